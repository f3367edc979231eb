//! `ltsc lint`.

use crate::args::{Format, Lint};
use crate::output::{Counts, Exit, Failure};
use crate::terminal;

use super::shared::{check, files_of, report};

pub fn run(command: &Lint) -> Result<Exit, Failure> {
    let mut files = Vec::new();
    for (project, paths) in files_of(&command.paths)? {
        files.extend(check(&project, &paths, &command.findings, ltsc_core::eval::Overrides::default())?);
    }
    let (exit, counts) = report(&files, Vec::new(), command.findings.format, true);
    if command.findings.format == Format::Human {
        terminal::say(&summary(files.len(), &counts));
    }
    Ok(exit)
}

fn summary(files: usize, counts: &Counts) -> String {
    let plural = if files == 1 { "" } else { "s" };
    format!("{files} file{plural} checked: {}", counts.words())
}
