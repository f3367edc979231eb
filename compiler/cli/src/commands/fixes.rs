//! `ltsc lint --fix` and `--diff`: rounds of fixes over the files asked for, until none is left.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use ltsc_core::diag::{Edit, FileId, Finding, Fix, Severity, Sources};
use ltsc_core::eval::Overrides;
use ltsc_core::files::VPath;
use ltsc_core::fix::apply;
use ltsc_core::formats::Target;
use ltsc_render::regular;
use serde_json::Value;
use similar::TextDiff;

use crate::args;
use crate::output::{Exit, Failure};
use crate::project::Project;
use ltsc_evaluation::disk::{Changed, rewrite};

use super::shared::{CheckedFile, check_changed, disk_of};

/// More rounds than any text needs: each fix takes its finding away.
const ROUNDS: usize = 1000;

/// What fixes made of files.
pub struct Fixed {
    /// The files as they are then.
    pub checked: Vec<CheckedFile>,
    /// Those that changed: their paths, and the texts before and after.
    pub changed: Vec<(VPath, String, String)>,
    /// The fixes that were made, as programs read them; their places are those in the text that each was made in.
    pub fixes: Vec<Value>,
    /// How many were left out, since an error would follow from them.
    pub refused: usize,
}

/// Fixes files of a project in memory, and checks `users`, too. Files that were not asked for stay as they are.
pub fn fixed(
    project: &Project,
    files: &[PathBuf],
    users: &[PathBuf],
    findings: &args::Findings,
    targets: &[&'static Target],
) -> Result<Fixed, Failure> {
    let disk = disk_of(project, findings)?;
    let all = [files, users].concat();
    let check = |texts: &BTreeMap<VPath, String>| {
        check_changed(project, &all, findings, Overrides::default(), targets, &Changed { disk: &disk, texts })
    };
    let mut texts: BTreeMap<VPath, String> = BTreeMap::new();
    let mut originals: BTreeMap<VPath, String> = BTreeMap::new();
    let mut checked = check(&texts)?;
    let mut refused: BTreeSet<(String, Vec<Edit>)> = BTreeSet::new();
    let mut fixes = Vec::new();
    // All at once, and one by one from where that would lead to an error.
    let mut careful = false;
    for _ in 0..ROUNDS {
        // What was asked for stands first.
        let mut asked = fixes_of(&checked, files.len(), &refused);
        if careful {
            asked.truncate(1);
        }
        if asked.is_empty() {
            break;
        }
        let (next, made) = applied(&checked, &texts, &asked);
        let after = check(&next)?;
        if errors(&after) > errors(&checked) {
            if careful || asked.len() == 1 {
                refused.extend(asked.into_iter().map(|one| (one.path, one.fix.edits)));
            }
            careful = true;
            continue;
        }
        for path in next.keys().filter(|path| !originals.contains_key(*path)).cloned().collect::<Vec<_>>() {
            if let Some(text) = text_of(&checked, path.as_str()) {
                originals.insert(path, text.to_owned());
            }
        }
        fixes.extend(made);
        (texts, checked) = (next, after);
    }
    let changed = texts.into_iter().filter_map(|(path, after)| {
        let before = originals.remove(&path)?;
        (before != after).then_some((path, before, after))
    });
    Ok(Fixed { changed: changed.collect(), checked, fixes, refused: refused.len() })
}

/// A fix of a file.
struct Asked {
    path: String,
    fix: Fix,
    /// What is fixed, as programs read it.
    told: Value,
}

/// The fixes within the files asked for, the first so many, each once. Their edits all have the first file's number: one file has
/// others where other scenes use it.
fn fixes_of(checked: &[CheckedFile], count: usize, refused: &BTreeSet<(String, Vec<Edit>)>) -> Vec<Asked> {
    let asked: BTreeSet<&str> = checked.iter().take(count).map(|file| file.path.as_str()).collect();
    let (_, number) = scratch();
    let mut found = Vec::new();
    let mut seen = refused.clone();
    for file in checked {
        for finding in &file.checked.findings {
            let Some(fix) = &finding.fix else { continue };
            let Some(first) = fix.edits.first().map(|edit| edit.span.file) else { continue };
            let path = &file.sources.get(first).path;
            if !asked.contains(path.as_str()) || fix.edits.iter().any(|edit| edit.span.file != first) {
                continue;
            }
            let mut fix = fix.clone();
            fix.edits.iter_mut().for_each(|edit| edit.span.file = number);
            if seen.insert((path.clone(), fix.edits.clone())) {
                let told = file.located(finding.clone()).fixed_json(&fix.title);
                found.push(Asked { path: path.clone(), fix, told });
            }
        }
    }
    found
}

/// A file's number that stands for every file.
fn scratch() -> (Sources, FileId) {
    let mut sources = Sources::default();
    let number = sources.add("", "");
    (sources, number)
}

/// The text of the file at `path` as it was checked.
fn text_of<'c>(checked: &'c [CheckedFile], path: &str) -> Option<&'c str> {
    checked.iter().flat_map(|file| file.sources.iter()).find(|file| file.path == path).map(|file| &*file.text)
}

/// The texts with fixes, and which were made, as programs read them.
fn applied(
    checked: &[CheckedFile],
    texts: &BTreeMap<VPath, String>,
    fixes: &[Asked],
) -> (BTreeMap<VPath, String>, Vec<Value>) {
    let (_, number) = scratch();
    let mut next = texts.clone();
    let mut made = Vec::new();
    for file in checked {
        let path = file.path.as_str();
        let own: Vec<&Asked> = fixes.iter().filter(|asked| asked.path == path).collect();
        let Some(text) = text_of(checked, path) else { continue };
        let done = apply(text, number, own.iter().map(|asked| &asked.fix));
        if !done.made.is_empty() {
            next.insert(file.path.clone(), done.text);
            made.extend(done.made.iter().map(|at| own[*at].told.clone()));
        }
    }
    (next, made)
}

fn errors(checked: &[CheckedFile]) -> usize {
    let of = |finding: &&Finding| finding.severity == Severity::Error;
    checked.iter().flat_map(|file| &file.checked.findings).filter(of).count()
}

/// Writes the files that changed.
pub fn write(project: &Project, findings: &args::Findings, fixed: &Fixed) -> Result<(), Failure> {
    let disk = disk_of(project, findings)?;
    for (path, before, after) in &fixed.changed {
        let failed =
            |error: std::io::Error| Failure::new(Exit::Environment, format!("{path} cannot be written: {error}"));
        let real = disk.real(path).map_err(failed)?;
        if regular::read(&real, u64::MAX - 1).map_err(failed)? != before.as_bytes() {
            return Err(Failure::new(Exit::Environment, format!("{path} changed while it was fixed"))
                .help("run the command again"));
        }
        rewrite(&real, &project.root, after.as_bytes()).map_err(failed)?;
    }
    Ok(())
}

/// What would change, as a unified diff.
pub fn difference(fixed: &Fixed) -> String {
    let one = |(path, before, after): &(VPath, String, String)| {
        let header = (path.to_string(), format!("{path}, fixed"));
        TextDiff::from_lines(before, after).unified_diff().context_radius(3).header(&header.0, &header.1).to_string()
    };
    fixed.changed.iter().map(one).collect()
}
