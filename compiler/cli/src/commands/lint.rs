//! `ltsc lint`.

use ltsc_core::diag::{Finding, Severity, Sources};
use ltsc_core::formats::Target;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use serde_json::Value;

use crate::args::{Format, Lint};
use crate::output::{Counts, Exit, Failure, Located};
use crate::{project, terminal};

use super::fixes::{self, Fixed};
use super::shared::{CheckedFile, Shown, check, counted, files_of, ledgers, report_as, set_for};
use super::users::users;

pub fn run(command: &Lint) -> Result<Exit, Failure> {
    let targets = command.target.iter().map(|name| project::target(name)).collect::<Result<Vec<_>, _>>()?;
    let (groups, mut problems) = files_of(&command.paths)?;
    if groups.is_empty() && !problems.is_empty() {
        return Err(problems.swap_remove(0));
    }
    let overrides = set_for(&command.set, &groups)?;
    let mut files = Vec::new();
    let mut tally = Tally::default();
    let mut using = 0;
    for (project, paths) in groups {
        let levels = project.levels_with(&command.findings)?;
        let users = users(&project, &paths, &command.findings)?;
        using += users.len();
        let mut checked = if command.fix || command.diff {
            let fixed = fixes::fixed(&project, &paths, &users, &command.findings, &targets)?;
            if command.diff {
                terminal::print(&fixes::difference(&fixed));
            } else {
                fixes::write(&project, &command.findings, &fixed)?;
            }
            tally.add(&fixed);
            fixed.checked
        } else {
            let all = [paths, users].concat();
            check(&project, &all, &command.findings, overrides.clone(), &targets)?
        };
        for file in &mut checked {
            let mut lost = losses(file, &targets);
            levels.judge(&mut lost);
            file.checked.findings.extend(lost);
        }
        files.extend(checked);
    }
    let nothing = Sources::default();
    let more =
        problems.into_iter().map(|problem| Located { finding: problem.into_finding(), sources: &nothing, prefix: "" });
    if command.diff {
        let (exit, counts) = counted(&files, more.collect());
        terminal::say(&format!("{}; then {}", tally.words("would be fixed"), counts.words()));
        return Ok(if !tally.fixes.is_empty() { exit.max(Exit::No) } else { exit });
    }
    let fixed = command.fix.then_some(tally.fixes.as_slice());
    let shown = if targets.is_empty() { Shown::Warnings } else { Shown::All };
    let (exit, counts) = report_as(&files, more.collect(), fixed, command.findings.format, true, shown);
    if command.fix {
        terminal::say(&tally.words("fixed"));
    }
    if matches!(command.findings.format, Format::Human | Format::Github) {
        terminal::say(&summary(&files, using, &counts));
    }
    Ok(exit)
}

/// What was fixed.
#[derive(Default)]
struct Tally {
    /// As programs read them.
    fixes: Vec<Value>,
    files: usize,
    refused: usize,
}

impl Tally {
    fn add(&mut self, fixed: &Fixed) {
        self.fixes.extend_from_slice(&fixed.fixes);
        self.files += fixed.changed.len();
        self.refused += fixed.refused;
    }

    fn words(&self, done: &str) -> String {
        let one = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        let refused = if self.refused == 0 {
            String::new()
        } else {
            format!("; {} not fixed, since an error would follow", one(self.refused, "finding"))
        };
        format!("{} {done} in {}{refused}", one(self.fixes.len(), "finding"), one(self.files, "file"))
    }
}

/// What the targets asked for cannot say exactly, which is a finding of the scene.
fn losses(file: &CheckedFile, targets: &[&'static Target]) -> Vec<Finding> {
    if targets.is_empty() || file.checked.worst() == Severity::Error {
        return Vec::new();
    }
    let Some(scene) = file.checked.scene.clone() else { return Vec::new() };
    match pipeline::prepare(scene) {
        Ok((scene, lowered)) => {
            ledgers(&scene, targets, &file.checked, &lowered).iter().flat_map(Ledger::findings).collect()
        }
        Err(invalid) => invalid,
    }
}

/// One line about all files, of which the last `using` were not asked for.
fn summary(files: &[CheckedFile], using: usize, counts: &Counts) -> String {
    let asked = files.len() - using;
    let plural = if asked == 1 { "" } else { "s" };
    let users = match using {
        0 => String::new(),
        1 => " with 1 scene that uses a library".to_owned(),
        _ => format!(" with {using} scenes that use a library"),
    };
    let open = files.iter().flat_map(|file| &file.checked.findings).filter(|finding| finding.fix.is_some()).count();
    let fixable = if open == 0 { String::new() } else { format!("; `ltsc lint --fix` mends {open}") };
    format!("{asked} file{plural} checked{users}: {}{fixable}", counts.words())
}
