//! `ltsc lint`.

use ltsc_core::diag::{Finding, Origin, Severity, Sources};
use ltsc_core::eval::Overrides;
use ltsc_core::formats::Target;
use ltsc_core::pipeline;

use crate::args::{Format, Lint};
use crate::output::{Counts, Exit, Failure, Located};
use crate::{project, terminal};

use super::shared::{CheckedFile, check, files_of, report};

pub fn run(command: &Lint) -> Result<Exit, Failure> {
    let targets = command.target.iter().map(|name| project::target(name)).collect::<Result<Vec<_>, _>>()?;
    let (groups, mut problems) = files_of(&command.paths)?;
    if groups.is_empty() && !problems.is_empty() {
        return Err(problems.swap_remove(0));
    }
    let mut files = Vec::new();
    for (project, paths) in groups {
        let levels = project.levels_with(&command.findings)?;
        let mut checked = check(&project, &paths, &command.findings, Overrides::default(), &targets)?;
        for file in &mut checked {
            let mut lost = losses(file, &targets);
            levels.judge(&mut lost);
            file.checked.findings.extend(lost);
        }
        files.extend(checked);
    }
    let nothing = Sources::default();
    let more = problems.into_iter().map(|problem| Located {
        finding: Finding { help: problem.help, ..Finding::error("unreadable-file", Origin::Made, problem.message) },
        sources: &nothing,
        prefix: "",
    });
    let (exit, counts) = report(&files, more.collect(), command.findings.format, true, targets.is_empty());
    if matches!(command.findings.format, Format::Human | Format::Github) {
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
