//! `ltsc build`: every scene of a project for every target.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ltsc_core::diag::{Finding, Severity};
use ltsc_core::eval::Overrides;
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ledger::Ledger;
use ltsc_core::lint::Levels;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use rayon::prelude::*;
use serde_json::json;

use crate::args::{Build, Format};
use crate::output::{self, Exit, Failure, Located};
use crate::project::{self, Project};
use crate::terminal::{self, Bar};
use ltsc_evaluation::disk::{Changes, DiskSink, MANIFEST, Manifest, STAGING, Staging, left_over, unwritable};

use super::shared::{CheckedFile, all_files_of, check, ledgers, losses, report, say_losses, set_for};

/// A scene that can be written.
struct Ready<'f> {
    scene: Valid,
    file: &'f CheckedFile,
    remarks: Vec<Finding>,
    /// By target.
    ledgers: Vec<Ledger>,
}

/// What became of one scene.
struct Built {
    name: String,
    targets: usize,
    changes: Changes,
}

/// What became of one scene, or why nothing did: the texts that were made say something else than the scene.
type Outcome = Result<Built, Vec<Finding>>;

pub fn run(command: &Build) -> Result<Exit, Failure> {
    let only: Vec<&'static Target> =
        command.target.iter().map(|name| project::target(name)).collect::<Result<_, _>>()?;
    if command.stats {
        return super::stats::run(command, &only);
    }
    let mut exit = Exit::Done;
    let mut said = false;
    let mut all = Vec::new();
    let groups = match gone(command)? {
        Some(project) => vec![(project, Vec::new())],
        None => all_files_of(&command.paths, &command.findings)?,
    };
    if groups.len() > 1 && command.findings.format.is_document() {
        return Err(Failure::new(Exit::Usage, "the scenes belong to several projects, and there is one document")
            .help("build them one by one, or choose `--format short`"));
    }
    let overrides = set_for(&command.set, &groups)?;
    for (project, files) in groups {
        let whole = is_whole(&project, &files);
        let (one, built) = build(command, &project, &files, &only, whole, &overrides)?;
        exit = exit.max(one);
        match built {
            Some(built) => all.extend(built),
            None => said = true,
        }
    }
    if command.findings.format == Format::Json && !said {
        let list: Vec<serde_json::Value> = all.iter().map(json_of).collect();
        terminal::print(&format!("{:#}\n", json!({ "scenes": list })));
    }
    Ok(exit)
}

/// Whether these are all scenes of the project, however they were named.
fn is_whole(project: &Project, files: &[PathBuf]) -> bool {
    let real = |files: &[PathBuf]| -> BTreeSet<PathBuf> {
        files.iter().map(|file| fs::canonicalize(file).unwrap_or_else(|_| file.clone())).collect()
    };
    project.declared
        && match project::scene_files(&project.scenes) {
            // A folder that cannot be read may hold the scene of what looks like an orphan.
            Ok(all) => all.problems.is_empty() && real(files).is_superset(&real(&all.files)),
            Err(_) => has_no_scene(project),
        }
}

/// The project, where all of it is to be built, the last scene is gone, and what was generated of it is not.
fn gone(command: &Build) -> Result<Option<Project>, Failure> {
    let project = match &command.paths[..] {
        [] => Project::here()?,
        [folder] => match Project::of(folder) {
            Ok(project)
                if project.declared && fs::canonicalize(folder).ok() == fs::canonicalize(&project.scenes).ok() =>
            {
                project
            }
            _ => return Ok(None),
        },
        _ => return Ok(None),
    };
    let left =
        command.output.is_none() && command.target.is_empty() && !orphans(&project.generated, &[], None)?.is_empty();
    Ok((left && has_no_scene(&project)).then_some(project))
}

/// Whether the project's folder of scenes is not there, or is read and holds none.
fn has_no_scene(project: &Project) -> bool {
    match fs::metadata(&project.scenes) {
        Err(error) => error.kind() == io::ErrorKind::NotFound,
        Ok(_) => project::scene_files(&project.scenes).is_err_and(|failure| failure.exit == Exit::Usage),
    }
}

fn json_of(built: &Built) -> serde_json::Value {
    let Built { name, targets, changes: Changes { written, same, removed, kept, restored } } = built;
    json!({
        "scene": name, "targets": targets, "written": written, "unchanged": same, "removed": removed, "kept": kept,
        "restored": restored,
    })
}

fn build(
    command: &Build,
    project: &Project,
    files: &[PathBuf],
    only: &[&'static Target],
    whole: bool,
    overrides: &Overrides,
) -> Result<(Exit, Option<Vec<Built>>), Failure> {
    let targets: &[&'static Target] = if only.is_empty() { &project.targets } else { only };
    let output = command.output.as_deref().unwrap_or(&project.generated);
    let checked = check(project, files, &command.findings, overrides.clone(), &[])?;
    let levels = project.levels_with(&command.findings)?;
    let choices = project.choices_with(&command.option, targets)?;
    let (ready, mut more) = prepare(&checked, targets, &levels);
    for ready in &ready {
        more.extend(ready.remarks.iter().map(|finding| ready.file.located(finding.clone())));
    }
    let scenes: Vec<(&[Ledger], &CheckedFile)> = ready.iter().map(|ready| (&ready.ledgers[..], ready.file)).collect();
    let denied = |located: &Located<'_>| located.finding.severity >= Severity::Deny;
    let lost = losses(&scenes, &levels);
    let format = command.findings.format;
    let json = format == Format::Json;
    let failing =
        checked.iter().any(|file| file.checked.worst() >= Severity::Deny) || more.iter().chain(&lost).any(denied);
    // Programs get one document: the findings where they forbid to write, else what was written.
    let shown = if json && !failing { Format::Short } else { format };
    // People get a line for each target below, and what forbids to write.
    let each = shown != Format::Human && !command.check;
    more.extend(lost.into_iter().filter(|located| each || denied(located)));
    let (exit, _) = report(&checked, more, shown, false, true);
    if exit != Exit::Done {
        terminal::error("nothing was written");
        return Ok((exit, None));
    }
    if let Some((name, first, second)) = twins(&ready) {
        return Err(Failure::new(Exit::Input, format!("two scenes are named `{name}`: {first} and {second}"))
            .help("rename one of them"));
    }
    if shown == Format::Human && !command.check {
        say_losses(&scenes.iter().map(|(ledgers, _)| *ledgers).collect::<Vec<_>>());
    }
    let failed = |error: io::Error| unwritable(output, &error);
    let staging = if command.check { None } else { Some(Arc::new(Staging::of(output).map_err(failed)?)) };
    let bar = std::sync::Mutex::new((Bar::new(ready.len() as u64, "building"), 0));
    let outcomes: Vec<Result<Outcome, Failure>> = ready
        .par_iter()
        .map(|ready| {
            let result = write(ready, targets, &choices, (output, staging.as_ref()), command);
            if let Ok(mut bar) = bar.lock() {
                bar.1 += 1;
                let done = bar.1;
                bar.0.set(done);
            }
            result
        })
        .collect();
    if let Ok(bar) = bar.lock() {
        bar.0.finish();
    }
    let (mut built, mut wrong) = (Vec::new(), Vec::new());
    for (ready, outcome) in ready.iter().zip(outcomes) {
        match outcome? {
            Ok(one) => built.push(one),
            Err(findings) => wrong.extend(findings.into_iter().map(|finding| ready.file.located(finding))),
        }
    }
    if !wrong.is_empty() {
        output::findings(&wrong, None, format, false, true);
        terminal::error("ltsc wrote something else than the scenes say; nothing of these scenes was kept");
        terminal::help("this is an internal error (a bug in ltsc): please report it with the scenes");
        return Ok((Exit::Fault, None));
    }
    // Another folder may be shared with other projects.
    if whole && only.is_empty() && command.output.is_none() {
        built.extend(orphans(output, &ready, staging.as_ref())?);
    }
    if command.check && left_over(output) {
        let changes = Changes { removed: vec![STAGING.to_owned()], ..Changes::default() };
        built.push(Built { name: String::new(), targets: 0, changes });
    }
    let stale = built.iter().any(|scene| !scene.changes.is_empty());
    if !json {
        summary(&built, output, command.check);
    }
    if format == Format::Human && !command.check {
        where_to_look(&ready, targets, output);
    }
    Ok((if command.check && stale { Exit::No } else { Exit::Done }, Some(built)))
}

/// Lowers and validates what can be written; the rest comes back as findings.
fn prepare<'f>(
    checked: &'f [CheckedFile],
    targets: &[&'static Target],
    levels: &Levels,
) -> (Vec<Ready<'f>>, Vec<Located<'f>>) {
    let scenes = checked.par_iter().filter_map(|file| {
        let scene = file.checked.scene.clone().filter(|_| file.checked.worst() < Severity::Deny)?;
        let prepared = pipeline::prepare(scene).map(|(scene, remarks)| {
            let ledgers = ledgers(&scene, targets, &file.checked, &remarks);
            (scene, remarks, ledgers)
        });
        Some((file, prepared))
    });
    let (mut ready, mut invalid) = (Vec::new(), Vec::new());
    for (file, prepared) in scenes.collect::<Vec<_>>() {
        match prepared {
            Ok((scene, mut remarks, ledgers)) => {
                levels.judge(&mut remarks);
                ready.push(Ready { scene, file, remarks, ledgers });
            }
            Err(findings) => invalid.extend(findings.into_iter().map(|finding| file.located(finding))),
        }
    }
    (ready, invalid)
}

/// Two scenes that would be written into one folder, also where the system does not tell case.
fn twins(ready: &[Ready<'_>]) -> Option<(String, String, String)> {
    let mut seen: BTreeMap<String, &Ready<'_>> = BTreeMap::new();
    let path = |ready: &Ready<'_>| ready.file.path.to_string();
    for one in ready {
        if let Some(first) = seen.insert(one.scene.name.to_lowercase(), one) {
            return Some((one.scene.name.clone(), path(first), path(one)));
        }
    }
    None
}

fn write(
    ready: &Ready<'_>,
    targets: &[&'static Target],
    choices: &Choices,
    (output, staging): (&Path, Option<&Arc<Staging>>),
    command: &Build,
) -> Result<Outcome, Failure> {
    let scene = &ready.scene;
    let folder = output.join(&scene.name);
    let failed = |error: io::Error| unwritable(&folder, &error);
    let camera = pipeline::camera(scene, None)
        .ok_or_else(|| Failure::new(Exit::Fault, format!("the scene `{}` lost its camera", scene.name)))?;
    let mut sink = DiskSink::among(staging, &folder, &scene.name, command.force).map_err(failed)?;
    let shares = targets.iter().any(|target| target.shares_meshes);
    if !command.target.is_empty() {
        // The other targets of the folder stay as they are.
        let ours = |path: &str| targets.iter().any(|target| path.starts_with(&format!("{}/", target.name)));
        let common = |path: &str| path.starts_with("meshes/") || path.starts_with("textures/");
        sink.keep(|path| !ours(path) && (!common(path) || !shares));
    }
    if shares {
        formats::write_meshes(scene, "meshes/", &mut sink).map_err(failed)?;
        // What one target reads as it is stays there for the others, whichever are written now.
        let all: Vec<&Target> = formats::TARGETS.iter().collect();
        formats::write_textures(scene, &all, "textures/", &mut sink).map_err(failed)?;
    }
    for (target, ledger) in targets.iter().zip(&ready.ledgers) {
        let mut inner = sink.below(target.name);
        pipeline::emit_shared(scene, camera, target, ledger, choices, &mut inner).map_err(failed)?;
    }
    // Where nothing is to be written, what is stale is said, and only what is not stale can be read.
    if !command.check || sink.changes().is_empty() {
        let audited = pipeline::audit(scene, camera, targets, &sink, |target| target.name.to_owned());
        let wrong: Vec<Finding> = audited.findings().cloned().collect();
        if !wrong.is_empty() {
            return Ok(Err(wrong));
        }
    }
    let changes = sink.finish().map_err(failed)?;
    Ok(Ok(Built { name: scene.name.clone(), targets: targets.len(), changes }))
}

/// Folders of scenes that are gone.
fn orphans(output: &Path, ready: &[Ready<'_>], staging: Option<&Arc<Staging>>) -> Result<Vec<Built>, Failure> {
    let names: BTreeSet<&str> = ready.iter().map(|ready| ready.scene.name.as_str()).collect();
    let Ok(entries) = fs::read_dir(output) else { return Ok(Vec::new()) };
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.sort();
    let mut gone = Vec::new();
    for folder in folders {
        let Some(name) = folder.file_name().and_then(|name| name.to_str()).filter(|name| !names.contains(name)) else {
            continue;
        };
        // What a link points to is not ours.
        if fs::symlink_metadata(&folder).is_ok_and(|meta| meta.file_type().is_symlink()) {
            continue;
        }
        let Some(manifest) = Manifest::read(&folder).filter(|manifest| manifest.scene == name) else { continue };
        let failed = |error: io::Error| Failure::new(Exit::Environment, format!("{}: {error}", folder.display()));
        let mut changes = Changes { removed: manifest.files.keys().cloned().collect(), ..Changes::default() };
        if staging.is_some() {
            changes = DiskSink::among(staging, &folder, name, false).and_then(DiskSink::finish).map_err(failed)?;
            changes.written.clear();
            fs::remove_file(folder.join(MANIFEST)).map_err(failed)?;
            // Files of someone else's stay, and the folder with them.
            let _kept = fs::remove_dir(&folder);
        }
        changes.removed.push(MANIFEST.to_owned());
        gone.push(Built { name: name.to_owned(), targets: 0, changes });
    }
    Ok(gone)
}

/// The files to open, for the first scene.
fn where_to_look(ready: &[Ready<'_>], targets: &[&'static Target], output: &Path) {
    let Some(first) = ready.first() else { return };
    let name = &first.scene.name;
    let mut text = String::new();
    for target in targets {
        let file = output.join(name).join(target.name).join(target.main_file_of(name));
        text.push_str(&format!("  {:<12} {}\n", target.name, file.display()));
    }
    match ready.len() - 1 {
        0 => {}
        1 => text.push_str("  and the same for 1 more scene\n"),
        more => text.push_str(&format!("  and the same for {more} more scenes\n")),
    }
    terminal::say(text.trim_end());
}

fn summary(built: &[Built], output: &Path, check: bool) {
    let mut lines = String::new();
    for Built { name, targets: _, changes } in built {
        if check {
            let words = changes
                .written
                .iter()
                .map(|path| (path, "stale"))
                .chain(changes.removed.iter().map(|path| (path, "left over")));
            for (path, word) in words {
                lines.push_str(&format!("{word}: {}\n", output.join(name).join(path).display()));
            }
        } else if !changes.is_empty() {
            let removed =
                if changes.removed.is_empty() { String::new() } else { format!(", {} removed", changes.removed.len()) };
            lines.push_str(&format!(
                "{name}: {} files written, {} unchanged{removed}\n",
                changes.written.len(),
                changes.same
            ));
        }
    }
    terminal::print(&lines);
    for (name, path) in built.iter().flat_map(|scene| scene.changes.kept.iter().map(|path| (&scene.name, path))) {
        let path = output.join(name).join(path);
        terminal::say(&format!("{} is no longer made, and was changed since: it stays", path.display()));
    }
    for (name, path) in built.iter().flat_map(|scene| scene.changes.restored.iter().map(|path| (&scene.name, path))) {
        let path = output.join(name).join(path);
        let what = if check { "was changed by hand" } else { "was changed by hand, and is written anew" };
        terminal::say(&format!("{} {what}", path.display()));
    }
    let stale = built.iter().any(|scene| !scene.changes.is_empty());
    let targets = built.iter().map(|scene| scene.targets).max().unwrap_or(0);
    let scenes = built.iter().filter(|scene| scene.targets > 0).count();
    let what = format!(
        "{scenes} scene{} for {targets} target{}",
        if scenes == 1 { "" } else { "s" },
        if targets == 1 { "" } else { "s" }
    );
    let place = output.display();
    terminal::say(&match (check, stale) {
        (true, true) => format!("{place} is stale; `ltsc build` brings it up to date"),
        (false, true) => format!("{what} in {place}"),
        (_, false) => format!("{what} in {place}: nothing to do, all files are up to date"),
    });
}
