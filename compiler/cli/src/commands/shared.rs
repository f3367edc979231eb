//! What several commands do: checking files of a project, and settings from the command line.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ltsc_core::capability::{Feature, Support, features};
use ltsc_core::diag::{Finding, Severity, Sources, nearest};
use ltsc_core::eval::{self, Limits, Overrides};
use ltsc_core::files::VPath;
use ltsc_core::formats::Target;
use ltsc_core::ir::{Camera, Documentation, Handle, Scene};
use ltsc_core::pipeline::{self, Checked, Options};
use ltsc_core::valid::Valid;
use rayon::prelude::*;

use crate::args::{self, Format};
use crate::disk::DiskFiles;
use crate::output::{self, Exit, Failure, Located};
use crate::project::{self, Project};
use crate::terminal;

/// Findings shown to people before the rest is only counted.
const SHOWN: usize = 100;

/// A file that was checked, with the texts that its findings lie in.
pub struct CheckedFile {
    /// Below the project's root.
    pub path: VPath,
    pub checked: Checked,
    pub sources: Sources,
}

/// The files that a command with paths works on: those of the project where there are none.
pub fn files_of(paths: &[PathBuf]) -> Result<Vec<(Project, Vec<PathBuf>)>, Failure> {
    if paths.is_empty() {
        let project = Project::here()?;
        let files = project::scene_files(&project.scenes)?;
        return Ok(vec![(project, files)]);
    }
    paths.iter().map(|path| Ok((Project::of(path)?, project::scene_files(path)?))).collect()
}

/// Checks files of a project, in parallel; the result is in the order of the files.
pub fn check(
    project: &Project,
    files: &[PathBuf],
    findings: &args::Findings,
    overrides: Overrides,
    targets: &[&'static Target],
) -> Result<Vec<CheckedFile>, Failure> {
    let root = findings.root.as_deref().unwrap_or(&project.root);
    let disk = DiskFiles::new(root)
        .map_err(|error| Failure::new(Exit::Usage, format!("{} cannot be read: {error}", root.display())))?;
    let limits = project::limits_with(project.limits, &findings.limits)?;
    let options = Options {
        overrides: Overrides { limits, ..overrides },
        levels: project.levels_with(findings)?,
        no_allow: findings.no_allow,
        targets: targets.iter().map(|target| target.name).collect(),
        scenes: headers(project, files, &disk, limits),
    };
    let one = |file: &PathBuf| {
        let path = disk.path_of(file).ok_or_else(|| {
            Failure::new(Exit::Usage, format!("{} does not lie below {}", file.display(), root.display()))
                .help("widen the root with `--root`, or move the scene")
        })?;
        let mut sources = Sources::default();
        let checked = pipeline::check(&disk, &mut sources, &path, &options);
        Ok(CheckedFile { path, checked, sources })
    };
    // One file is not worth starting threads for.
    if files.len() == 1 { files.iter().map(one).collect() } else { files.par_iter().map(one).collect() }
}

/// The documentation of the project's scenes by name, of a folder without `ltsc.toml` only that of the files asked for. What
/// cannot be read is passed over: it is reported where it is checked.
fn headers(project: &Project, files: &[PathBuf], disk: &DiskFiles, limits: Limits) -> BTreeMap<String, Documentation> {
    let all = if project.declared { project::scene_files(&project.scenes).unwrap_or_default() } else { Vec::new() };
    let files = if all.is_empty() { files } else { &all };
    let headers = files.iter().filter_map(|file| eval::header(disk, &disk.path_of(file)?, limits));
    headers.collect()
}

/// Prints what was found in files, each thing once, and gives the exit code that it leads to. Where `quiet`, people do not see
/// mere remarks.
pub fn report(
    files: &[CheckedFile],
    more: Vec<Located<'_>>,
    format: Format,
    to_stdout: bool,
    quiet: bool,
) -> (Exit, output::Counts) {
    let mut seen = BTreeSet::new();
    let mut all: Vec<Located<'_>> = Vec::new();
    for file in files {
        for finding in &file.checked.findings {
            let located = Located { finding: finding.clone(), sources: &file.sources };
            if seen.insert(located.key()) {
                all.push(located);
            }
        }
    }
    all.extend(more);
    let counts = output::Counts::of(all.iter().map(|located| &located.finding));
    let worst = all.iter().map(|located| located.finding.severity).max().unwrap_or(Severity::Allow);
    if format == Format::Human && all.len() > SHOWN {
        let rest = all.len() - SHOWN;
        all.truncate(SHOWN);
        output::findings(&all, format, to_stdout, quiet);
        terminal::say(&format!("... and {rest} more findings; `--format short` shows all"));
    } else {
        output::findings(&all, format, to_stdout, quiet);
    }
    (Exit::of(worst), counts)
}

/// Prints findings that belong to no text of their own.
pub fn report_loose(findings: Vec<Finding>, sources: &Sources, format: Format) -> Exit {
    let worst = findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Allow);
    let all: Vec<Located<'_>> = findings.into_iter().map(|finding| Located { finding, sources }).collect();
    output::findings(&all, format, false, true);
    Exit::of(worst)
}

/// What targets cannot say exactly of scenes. People get a line for each target, programs a finding for each loss.
pub fn losses<'s>(scenes: &[(&Valid, &'s Sources)], targets: &[&'static Target], format: Format) -> Vec<Located<'s>> {
    if format != Format::Human {
        let all = scenes.iter().flat_map(|(scene, sources)| {
            let of = targets.iter().flat_map(|target| pipeline::losses(scene, target));
            of.map(|finding| Located { finding, sources })
        });
        return all.collect();
    }
    for target in targets {
        let (mut dropped, mut nearly) = (BTreeSet::new(), BTreeSet::new());
        for (feature, _) in scenes.iter().flat_map(|(scene, _)| features(scene)) {
            match (target.supports)(feature) {
                Support::Exact => {}
                Support::Approximate { .. } => {
                    nearly.insert(feature);
                }
                Support::Unsupported { .. } => {
                    dropped.insert(feature);
                }
            }
        }
        let list = |set: &BTreeSet<Feature>| set.iter().map(|feature| feature.name()).collect::<Vec<_>>().join(", ");
        if !dropped.is_empty() {
            terminal::say(&format!("{} cannot say: {}", target.name, list(&dropped)));
        }
        if !nearly.is_empty() {
            terminal::say(&format!("{} says nearly: {}", target.name, list(&nearly)));
        }
    }
    Vec::new()
}

/// The settings of the command line.
pub fn overrides(settings: &args::Settings) -> Result<Overrides, Failure> {
    let args::Settings { width, height, samples, max_depth, seed, set, camera: _ } = settings;
    let pair = |text: &String| match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().to_owned(), value.trim().to_owned())),
        _ => Err(Failure::new(Exit::Usage, format!("`--set {text}` has no value"))
            .help("write for example `--set alpha=0.2`")),
    };
    let set = set.iter().map(pair).collect::<Result<_, _>>()?;
    Ok(Overrides {
        width: *width,
        height: *height,
        samples: *samples,
        seed: *seed,
        max_depth: *max_depth,
        set,
        ..Overrides::default()
    })
}

/// The one scene of a file; findings are printed, and those that forbid to go on end the command.
pub struct One {
    pub project: Project,
    pub sources: Sources,
    pub scene: Valid,
    pub camera: Handle<Camera>,
    /// BLAKE3 of everything that the scene was read from, settings of the command line included.
    pub hash: String,
    /// What lowering changed.
    remarks: Vec<Finding>,
}

impl One {
    /// Prints what lowering changed and what the target cannot say exactly.
    pub fn report_losses(&self, target: &'static Target, format: Format) {
        let mut all: Vec<Located<'_>> =
            self.remarks.iter().map(|finding| Located { finding: finding.clone(), sources: &self.sources }).collect();
        all.extend(losses(&[(&self.scene, &self.sources)], &[target], format));
        if format == Format::Short {
            output::findings(&all, format, false, true);
        }
    }
}

/// Reads, checks and prepares the scene in `file`.
///
/// Programs get the findings as the one document of the command where they end it, and else only if `alone`.
pub fn one(
    file: &Path,
    findings: &args::Findings,
    settings: &args::Settings,
    alone: bool,
) -> Result<Result<One, Exit>, Failure> {
    let project = Project::of(file)?;
    if file.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{} is a folder", file.display())).help("name one scene"));
    }
    let overrides = overrides(settings)?;
    let files = check(&project, &[file.to_path_buf()], findings, overrides.clone(), &[])?;
    let json = findings.format == Format::Json;
    let worst = files.iter().map(|file| file.checked.worst()).max().unwrap_or(Severity::Allow);
    if !json || Exit::of(worst) != Exit::Done {
        let (exit, _) = report(&files, Vec::new(), findings.format, false, true);
        if exit != Exit::Done {
            return Ok(Err(exit));
        }
    }
    let Some(CheckedFile { path, checked, sources }) = files.into_iter().next() else { return Ok(Err(Exit::Fault)) };
    let Some(scene) = checked.scene else {
        let what = if checked.library { "is a library: it has no `scene`" } else { "gives no scene" };
        return Err(Failure::new(Exit::Input, format!("{path} {what}")).help("name a scene that uses it"));
    };
    let hash = hash(&checked.inputs, &overrides);
    let camera = camera(&scene, settings.camera.as_deref())?;
    match pipeline::prepare(scene) {
        Ok((scene, mut remarks)) => {
            remarks.splice(0..0, checked.findings.into_iter().filter(|_| json));
            if json && alone {
                report_loose(remarks.clone(), &sources, Format::Json);
            }
            Ok(Ok(One { project, sources, scene, camera, hash, remarks }))
        }
        Err(invalid) => Ok(Err(report_loose(invalid, &sources, findings.format))),
    }
}

fn camera(scene: &Scene, name: Option<&str>) -> Result<Handle<Camera>, Failure> {
    pipeline::camera(scene, name).ok_or_else(|| {
        let known: Vec<&str> = scene.cameras.values().filter_map(|camera| camera.name.as_deref()).collect();
        let name = name.unwrap_or_default();
        let failure = Failure::new(Exit::Usage, format!("the scene has no camera `{name}`"));
        if known.is_empty() {
            return failure.help("its only camera has no name: leave out `--camera`");
        }
        match nearest(name, known.iter().copied()) {
            Some(similar) => failure.help(format!("did you mean `{similar}`? it has {}", known.join(", "))),
            None => failure.help(format!("it has {}", known.join(", "))),
        }
    })
}

fn hash(inputs: &std::collections::BTreeMap<VPath, ltsc_core::files::Bytes>, overrides: &Overrides) -> String {
    let mut hasher = blake3::Hasher::new();
    for (path, bytes) in inputs {
        // Lengths keep two different lists of files from looking alike.
        hasher.update(&(path.as_str().len() as u64).to_le_bytes());
        hasher.update(path.as_str().as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    }
    hasher.update(format!("{overrides:?}").as_bytes());
    hasher.finalize().to_hex().to_string()
}
