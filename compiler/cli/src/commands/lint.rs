//! `ltsc lint`.

use ltsc_core::diag::{Finding, Severity};
use ltsc_core::eval::Overrides;
use ltsc_core::formats::Target;
use ltsc_core::pipeline;

use crate::args::{Format, Lint};
use crate::output::{Counts, Exit, Failure};
use crate::{project, terminal};

use super::shared::{CheckedFile, check, files_of, report};

pub fn run(command: &Lint) -> Result<Exit, Failure> {
    let targets = command.target.iter().map(|name| project::target(name)).collect::<Result<Vec<_>, _>>()?;
    let mut files = Vec::new();
    for (project, paths) in files_of(&command.paths)? {
        files.extend(check(&project, &paths, &command.findings, Overrides::default(), &targets)?);
    }
    for file in &mut files {
        file.checked.findings.extend(losses(file, &targets));
    }
    let (exit, counts) = report(&files, Vec::new(), command.findings.format, true, targets.is_empty());
    if command.findings.format == Format::Human {
        terminal::say(&summary(files.len(), &counts));
    }
    Ok(exit)
}

/// What the targets asked for cannot say exactly, which is a finding of the scene.
fn losses(file: &CheckedFile, targets: &[&'static Target]) -> Vec<Finding> {
    if targets.is_empty() || file.checked.worst() == Severity::Error {
        return Vec::new();
    }
    let Some(scene) = file.checked.scene.clone() else { return Vec::new() };
    match pipeline::prepare(scene) {
        Ok((scene, _)) => targets.iter().flat_map(|target| pipeline::losses(&scene, target)).collect(),
        Err(invalid) => invalid,
    }
}

fn summary(files: usize, counts: &Counts) -> String {
    let plural = if files == 1 { "" } else { "s" };
    format!("{files} file{plural} checked: {}", counts.words())
}
