//! `ltsc completions`.

use clap_complete::{Shell, generate};

use crate::args;
use crate::output::{Exit, Failure};
use crate::terminal;

pub fn run(shell: Shell) -> Result<Exit, Failure> {
    let mut bytes = Vec::new();
    generate(shell, &mut args::command(), "ltsc", &mut bytes);
    terminal::print(&String::from_utf8_lossy(&bytes));
    Ok(Exit::Done)
}
