//! Windows: a program in a job object with all that it starts, so that the system itself ends all of them.
//!
//! The system keeps what a program in a job starts in the same job, whatever becomes of its parent, and ends all of it with the last
//! handle to the job. That handle is this process's alone, and no program inherits it, so that however this process goes its programs go
//! with it. What a program starts in the moment between its own start and [`Whole::of`] is in no job.

use std::os::windows::io::AsRawHandle;
use std::process::Child;

use win32job::{ExtendedLimitInfo, Job, JobError};

/// A program with all that descends from it. Dropping this ends them; so does the end of this process.
pub(crate) struct Whole {
    _job: Job,
}

impl Whole {
    /// Of a program that was just started, and has started nothing yet.
    pub(crate) fn of(child: &Child) -> Result<Self, JobError> {
        let mut limits = ExtendedLimitInfo::new();
        limits.limit_kill_on_job_close();
        let job = Job::create_with_limit_info(&limits)?;
        job.assign_process(child.as_raw_handle() as isize)?;
        Ok(Self { _job: job })
    }
}
