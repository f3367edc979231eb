//! `ltsc task`, which tasks of a cluster run: one chunk into the store. A failure is told here and written beside the list.

use ltsc_evaluation::executor::slurm;

use crate::args::Task;
use crate::output::{Exit, Failure};
use crate::terminal;

pub fn run(command: &Task) -> Result<Exit, Failure> {
    terminal::say(&slurm::perform(&command.list, command.index)?);
    Ok(Exit::Done)
}
