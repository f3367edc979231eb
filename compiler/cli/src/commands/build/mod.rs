//! `ltsc build`: every scene of a project for every target.

mod summary;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ltsc_core::diag::{Finding, Severity};
use ltsc_core::eval::Overrides;
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ledger::{self, Ledger};
use ltsc_core::lint::Levels;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::regular;
use rayon::prelude::*;
use serde_json::json;

use crate::args::{Build, Format};
use crate::output::{self, Exit, Failure, Located};
use crate::project::{self, Project};
use crate::terminal::{self, Bar};
use ltsc_evaluation::disk::{Changes, DiskSink, MANIFEST, Manifest, STAGING, Staging, left_over, unwritable};

use super::said::{Loss, losses_of, losses_written};
use super::shared::{CheckedFile, Shown, all_files_of, check, ledgers, losses, report_as, set_for};

/// A scene that can be written.
struct Ready<'f> {
    scene: Valid,
    file: &'f CheckedFile,
    remarks: Vec<Finding>,
    /// By target.
    ledgers: Vec<Ledger>,
}

/// What became of one scene.
#[derive(Default)]
struct Built {
    name: String,
    targets: usize,
    changes: Changes,
    /// Whether nothing was generated of it before.
    first: bool,
    /// By target, the losses that its ledger did not have before, and how many it had.
    news: Vec<(&'static str, Vec<Loss>)>,
    known: Vec<(&'static str, usize)>,
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
    let Built { name, targets, changes: Changes { written, same, removed, kept, restored }, .. } = built;
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
    // People get what forbids to write here, and the rest below.
    let each = shown != Format::Human && !command.check;
    more.extend(lost.into_iter().filter(|located| each || denied(located)));
    let worth = if command.verbose { Shown::Warnings } else { Shown::Refusals };
    let warnings: Vec<Located<'_>> = if worth == Shown::Refusals { warnings(&checked, &more) } else { Vec::new() };
    let (exit, counts) = report_as(&checked, more, None, shown, false, worth);
    if exit != Exit::Done {
        if shown == Format::Human && worth == Shown::Refusals && counts.warnings > 0 {
            terminal::say(&summary::lint(&command.paths, counts.warnings));
        }
        terminal::error("nothing was written");
        return Ok((exit, None));
    }
    if let Some((name, first, second)) = twins(&ready) {
        return Err(Failure::new(Exit::Input, format!("two scenes are named `{name}`: {first} and {second}"))
            .help("rename one of them"));
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
        built.push(Built { changes, ..Built::default() });
    }
    let stale = built.iter().any(|scene| !scene.changes.is_empty());
    if !json {
        let told = summary::Told { command, output, ready: &ready, targets, built: &built, warnings: &warnings };
        told.say(format == Format::Human);
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
    let first = Manifest::read(&folder).is_none();
    let (news, known) = told_before(&folder, targets, &ready.ledgers);
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
    Ok(Ok(Built { name: scene.name.clone(), targets: targets.len(), changes, first, news, known }))
}

/// By target, the losses that the ledger in the folder does not have yet, and how many it has.
type Told = (Vec<(&'static str, Vec<Loss>)>, Vec<(&'static str, usize)>);

fn told_before(folder: &Path, targets: &[&'static Target], ledgers: &[Ledger]) -> Told {
    let one = |(target, ledger): (&&'static Target, &Ledger)| {
        let file = folder.join(target.name).join(ledger::FILE);
        let before = regular::read(&file, regular::TEXT).map(|text| losses_written(&text)).unwrap_or_default();
        let (known, news): (Vec<Loss>, _) = losses_of(ledger).into_iter().partition(|loss| before.contains(loss));
        ((target.name, news), (target.name, known.len()))
    };
    targets.iter().zip(ledgers).map(one).unzip()
}

/// The warnings of files, each once, and those among `more`.
fn warnings<'f>(checked: &'f [CheckedFile], more: &[Located<'f>]) -> Vec<Located<'f>> {
    let mut seen = BTreeSet::new();
    let own = checked.iter().flat_map(|file| file.checked.findings.iter().map(|finding| file.located(finding.clone())));
    let more = more.iter().map(|one| Located { finding: one.finding.clone(), ..*one });
    let all = own.chain(more).filter(|one| one.finding.severity == Severity::Warn);
    all.filter(|one| seen.insert(one.key())).collect()
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
        let failed = |error: io::Error| unwritable(&folder, &error);
        let mut changes = Changes { removed: manifest.files.keys().cloned().collect(), ..Changes::default() };
        if staging.is_some() {
            changes = DiskSink::among(staging, &folder, name, false).and_then(DiskSink::finish).map_err(failed)?;
            changes.written.clear();
            fs::remove_file(folder.join(MANIFEST)).map_err(failed)?;
            // Files of someone else's stay, and the folder with them.
            let _kept = fs::remove_dir(&folder);
        }
        changes.removed.push(MANIFEST.to_owned());
        gone.push(Built { name: name.to_owned(), changes, ..Built::default() });
    }
    Ok(gone)
}
