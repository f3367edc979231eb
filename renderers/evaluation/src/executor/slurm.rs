//! Renders on a cluster with Slurm: one array of tasks, each of which renders a chunk into the store. The store and all that tasks need
//! lie in a folder that all machines share, and nothing else connects them.
//!
//! A chunk that is in the store is done, whatever Slurm says. A task that is lost is submitted again, a few times. Where ltsc ends, the
//! array ends with it; where it was killed, the next run in that folder takes over what is still wanted of its array, and cancels
//! the rest.

mod scheduler;
mod session;
mod shared;
mod task;

use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_render::env::Env;

use super::{Executor, Kind, News, Order, Outcome, Resources};
use crate::failure::{Exit, Failure, why};
use scheduler::Scheduler;
use session::Session;
use shared::Shared;

pub use task::perform;

/// The row of the table.
pub const KIND: Kind = Kind {
    name: "slurm",
    summary: "a cluster with Slurm",
    make: |resources| {
        let program = std::env::current_exe()
            .map_err(|error| Failure::new(Exit::Environment, format!("ltsc does not find itself: {}", why(&error))))?;
        Ok(Box::new(Slurm::new(resources, &Env::of_process(), program)?))
    },
};

/// How often Slurm is asked: at first, and after a while.
const PAUSES: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(10));

/// How long the chunk of a task that ended well may take to be seen here: systems of files over a network remember for up to a minute
/// what was not there.
const GRACE: Duration = Duration::from_secs(90);

/// How long Slurm may give no answer.
const SILENCE: Duration = Duration::from_secs(600);

/// A cluster.
pub struct Slurm {
    shared: Shared,
    scheduler: Scheduler,
    /// The ltsc that tasks run.
    program: PathBuf,
    /// Tasks at once.
    at_once: usize,
    options: Vec<String>,
    pauses: (Duration, Duration),
    grace: Duration,
}

impl Slurm {
    /// The cluster of this machine, whose tasks run the ltsc at `program`.
    ///
    /// # Errors
    /// Where Slurm's programs are not on the path, or there is no folder that machines share.
    pub fn new(resources: &Resources, env: &Env, program: PathBuf) -> Result<Self, Failure> {
        let scheduler = Scheduler::find(env)?;
        let shared = resources.shared.as_deref().ok_or_else(|| {
            Failure::new(Exit::Usage, "the executor `slurm` needs a folder that all machines share".to_owned())
                .help("name one by `--shared DIR`")
        })?;
        if let Some(option) = resources.options.iter().find(|option| !option.starts_with('-')) {
            return Err(Failure::new(Exit::Usage, format!("`{option}` is no option of `sbatch`"))
                .help("write each as one word, such as `--partition=short`"));
        }
        Ok(Self {
            shared: Shared::at(shared)?,
            scheduler,
            program,
            at_once: resources.jobs.max(1),
            options: resources.options.clone(),
            pauses: PAUSES,
            grace: GRACE,
        })
    }

    /// Asks Slurm this often, and waits so long for chunks to be seen: for tests.
    #[must_use]
    pub fn hasty(self, pause: Duration, grace: Duration) -> Self {
        Self { pauses: (pause, pause), grace, ..self }
    }
}

impl Executor for Slurm {
    fn run(&self, order: &Order<'_>, news: &(dyn Fn(News<'_>) + Sync)) -> Result<Vec<Outcome>, Failure> {
        if !std::path::absolute(order.store.root()).is_ok_and(|root| root.starts_with(self.shared.root())) {
            let (store, shared) = (order.store.root().display(), self.shared.root().display());
            return Err(Failure::new(Exit::Usage, format!("the chunks in {store} are not seen by other machines"))
                .help(format!("keep them below {shared}")));
        }
        Session::new(self, order, news)?.run()
    }
}

/// Cancels what runs that were killed have left in a shared folder, and removes it; gives how many there were.
///
/// # Errors
/// If something cannot be removed.
pub fn clean(shared: &Path, env: &Env) -> Result<usize, Failure> {
    let shared = Shared::at(shared)?;
    let failed = |error: std::io::Error| crate::disk::unwritable(shared.root(), &error);
    let left = shared.left_over().map_err(failed)?;
    for run in &left {
        // Without their list tasks end by themselves, so that it can be removed from any machine.
        if let Ok(scheduler) = Scheduler::find(env) {
            let _ended_later = scheduler.cancel(&run.arrays().map_err(failed)?);
        }
        shared.end(&run.folder).map_err(failed)?;
    }
    Ok(left.len())
}
