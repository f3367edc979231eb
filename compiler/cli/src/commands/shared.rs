//! What several commands do: checking files of a project, and settings from the command line.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ltsc_core::diag::{Finding, Origin, Severity, Sources, nearest};
use ltsc_core::eval::{self, Limits, Overrides};
use ltsc_core::files::{Files, VPath};
use ltsc_core::formats::Target;
use ltsc_core::ir::{Camera, Documentation, Handle, Scene};
use ltsc_core::ledger::Ledger;
use ltsc_core::lint::Levels;
use ltsc_core::pipeline::{self, Checked, Options};
use ltsc_core::valid::Valid;
use rayon::prelude::*;
use serde_json::Value;

use crate::args::{self, Format};
use crate::output::{self, Exit, Failure, Located, why};
use crate::project::{self, Project};
use crate::terminal;
use ltsc_evaluation::disk::{Changed, DiskFiles};

use super::said;

/// Findings shown to people before the rest is only counted.
const SHOWN: usize = 100;

/// A file that was checked, with the texts that its findings lie in.
pub struct CheckedFile {
    /// Below the project's root.
    pub path: VPath,
    /// As it was found.
    pub file: PathBuf,
    pub checked: Checked,
    pub sources: Sources,
    /// Where the project lies in its repository.
    pub prefix: Arc<str>,
}

impl CheckedFile {
    /// `finding` with its place.
    pub fn located(&self, finding: Finding) -> Located<'_> {
        Located { finding, sources: &self.sources, prefix: &self.prefix }
    }
}

/// Files of a project, in the order in which they are answered for.
pub type Group = (Project, Vec<PathBuf>);

/// The files that a command with paths works on, by project: those of the project where there are no paths. The order is that of
/// the paths, and a file that is named twice stands there once.
///
/// What cannot be read comes beside them: one bad path does not hide what is wrong with the others.
pub fn files_of(paths: &[PathBuf]) -> Result<(Vec<Group>, Vec<Failure>), Failure> {
    if paths.is_empty() {
        let project = Project::here()?;
        let project::Found { files, problems } = project::scene_files(&project.scenes)?;
        return Ok((vec![(project, files)], problems));
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut problems = Vec::new();
    let mut seen = BTreeSet::new();
    for path in paths {
        let found = Project::of(path).and_then(|project| Ok((project, project::scene_files(path)?)));
        let (project, files) = match found {
            Ok((project, found)) => {
                problems.extend(found.problems);
                (project, found.files)
            }
            Err(problem) if problem.exit == Exit::Usage => return Err(problem),
            Err(problem) => {
                problems.push(problem);
                continue;
            }
        };
        let files = files.into_iter().filter(|file| seen.insert(std::fs::canonicalize(file).unwrap_or(file.clone())));
        let same = |(other, _): &&mut Group| {
            (&other.root, other.declared, &other.scenes) == (&project.root, project.declared, &project.scenes)
        };
        match groups.iter_mut().find(same) {
            Some((_, known)) => known.extend(files),
            None => groups.push((project, files.collect())),
        }
    }
    Ok((groups, problems))
}

/// The files of [`files_of`], where one that cannot be read ends the command; what is wrong with the others is said before.
pub fn all_files_of(paths: &[PathBuf], findings: &args::Findings) -> Result<Vec<Group>, Failure> {
    let (groups, mut problems) = files_of(paths)?;
    let Some(last) = problems.pop() else { return Ok(groups) };
    let mut checked = Vec::new();
    for (project, files) in &groups {
        checked.extend(check(project, files, findings, Overrides::default(), &[])?);
    }
    let nothing = Sources::default();
    let more =
        problems.into_iter().map(|problem| Located { finding: problem.into_finding(), sources: &nothing, prefix: "" });
    report(&checked, more.collect(), findings.format, false, true);
    Err(last)
}

/// Checks files of a project, in parallel; the result is in the order of the files.
pub fn check(
    project: &Project,
    files: &[PathBuf],
    findings: &args::Findings,
    overrides: Overrides,
    targets: &[&'static Target],
) -> Result<Vec<CheckedFile>, Failure> {
    let disk = disk_of(project, findings)?;
    check_changed(project, files, findings, overrides, targets, &Changed { disk: &disk, texts: &BTreeMap::new() })
}

/// What a project reads from.
pub fn disk_of(project: &Project, findings: &args::Findings) -> Result<DiskFiles, Failure> {
    let root = findings.root.as_deref().unwrap_or(&project.root);
    DiskFiles::new(root)
        .map_err(|error| Failure::new(Exit::Usage, format!("{} cannot be read: {}", root.display(), why(&error))))
}

/// [`check`] of files of which some are not as they are on the disk.
pub fn check_changed(
    project: &Project,
    files: &[PathBuf],
    findings: &args::Findings,
    overrides: Overrides,
    targets: &[&'static Target],
    from: &Changed<'_>,
) -> Result<Vec<CheckedFile>, Failure> {
    check_each(project, files, findings, overrides, targets, from, |file| file)
}

/// What `keep` takes of each file; the rest of a file is let go before the next one is read.
pub fn check_each<T: Send>(
    project: &Project,
    files: &[PathBuf],
    findings: &args::Findings,
    overrides: Overrides,
    targets: &[&'static Target],
    from: &Changed<'_>,
    keep: impl Fn(CheckedFile) -> T + Sync,
) -> Result<Vec<T>, Failure> {
    let root = findings.root.as_deref().unwrap_or(&project.root);
    let limits = project::limits_with(project.limits, &findings.limits)?;
    let options = Options {
        overrides: Overrides { limits, ..overrides },
        levels: project.levels_with(findings)?,
        no_allow: findings.no_allow,
        targets: targets.iter().map(|target| target.name).collect(),
        scenes: headers(project, files, from, limits).into(),
    };
    let prefix: Arc<str> = project::prefix(root).into();
    let one = |file: &PathBuf| {
        let Some(path) = from.disk.path_of(file) else {
            let (path, finding) = nameless(file, root);
            let checked = Checked { findings: vec![finding], ..Checked::default() };
            let sources = Sources::default();
            return Ok(keep(CheckedFile { path, file: file.clone(), checked, sources, prefix: Arc::clone(&prefix) }));
        };
        let (checked, sources) = guarded(&path, || {
            let mut sources = Sources::default();
            let checked = pipeline::check(from, &mut sources, &path, &options);
            (checked, sources)
        });
        Ok(keep(CheckedFile { path, file: file.clone(), checked, sources, prefix: Arc::clone(&prefix) }))
    };
    // One file is not worth starting threads for.
    if files.len() == 1 { files.iter().map(one).collect() } else { files.par_iter().map(one).collect() }
}

/// A file that has no path below the root: how it is called in output, and why it is not read. The other files are.
fn nameless(file: &Path, root: &Path) -> (VPath, Finding) {
    let name = file.file_name().unwrap_or(file.as_os_str());
    let shown: String =
        name.to_string_lossy().chars().map(|c| if c.is_control() || c == '\\' { '?' } else { c }).collect();
    let whole = || VPath::resolve("", &shown).or_else(|_| VPath::resolve("", "file.lts"));
    let path = whole().unwrap_or_else(|_| unreachable!("a plain name is a path"));
    let real = std::fs::canonicalize(file).ok();
    let above = std::fs::canonicalize(root).ok();
    let outside = real.as_ref().zip(above.as_ref()).is_some_and(|(real, root)| !real.starts_with(root));
    let link = std::fs::symlink_metadata(file).is_ok_and(|meta| meta.is_symlink());
    let (id, why, help) = if outside && link {
        let why = format!("is a link that leads out of the project's root, {}", root.display());
        ("unreadable-file", why, "copy the file into the project, or widen the root with `--root`")
    } else if outside {
        let why = format!("does not lie below the root, {}", root.display());
        ("unreadable-file", why, "widen the root with `--root`, or move the scene")
    } else if file.to_str().is_none() {
        ("bad-path", "has a name that is not UTF-8".to_owned(), "rename the file or its folder")
    } else if file.to_string_lossy().contains('\\') {
        (
            "bad-path",
            "has a backslash in its path".to_owned(),
            "rename it: on other systems a backslash stands between folders",
        )
    } else if file.to_string_lossy().chars().any(char::is_control) {
        (
            "bad-path",
            "has a line break or another control character in its path".to_owned(),
            "rename the file or its folder",
        )
    } else {
        ("unreadable-file", "cannot be read".to_owned(), "is it a link that leads nowhere?")
    };
    let origin = Origin::File { path: path.to_string(), place: String::new() };
    (path, Finding::error(id, origin, format!("{shown:?} {why}")).help(help))
}

/// What `check` gives; where it panics, a finding that says so, since one file must not hide the others.
fn guarded(path: &VPath, check: impl FnOnce() -> (Checked, Sources)) -> (Checked, Sources) {
    // Nothing that a panic leaves half done is looked at afterwards.
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(check));
    done.unwrap_or_else(|payload| (pipeline::fault(path, &terminal::panic_text(payload.as_ref())), Sources::default()))
}

/// The documentation of the project's scenes by name, of a folder without `ltsc.toml` only that of the files asked for. What
/// cannot be read is passed over: it is reported where it is checked.
fn headers(
    project: &Project,
    files: &[PathBuf],
    from: &Changed<'_>,
    limits: Limits,
) -> BTreeMap<String, Documentation> {
    let all =
        if project.declared { project::scene_files(&project.scenes).unwrap_or_default().files } else { Vec::new() };
    let files = if all.is_empty() { files } else { &all };
    let headers = files.iter().filter_map(|file| eval::header(from, &from.disk.path_of(file)?, limits));
    headers.collect()
}

/// What was found in files, each thing once.
fn gathered<'f>(files: &'f [CheckedFile], more: Vec<Located<'f>>) -> Vec<Located<'f>> {
    let mut seen = BTreeSet::new();
    let mut all: Vec<Located<'f>> = Vec::new();
    for file in files {
        for finding in &file.checked.findings {
            let located = file.located(finding.clone());
            if seen.insert(located.key()) {
                all.push(located);
            }
        }
    }
    all.extend(more);
    all
}

/// The exit code that findings lead to, and how many there are.
fn tallied(all: &[Located<'_>]) -> (Exit, output::Counts) {
    let exit = all.iter().map(|located| Exit::of_finding(&located.finding)).max().unwrap_or(Exit::Done);
    (exit, output::Counts::of(all.iter().map(|located| &located.finding)))
}

/// The exit code of [`report`], and how many findings there are, without printing them.
pub fn counted(files: &[CheckedFile], more: Vec<Located<'_>>) -> (Exit, output::Counts) {
    tallied(&gathered(files, more))
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
    report_as(files, more, None, format, to_stdout, if quiet { Shown::Warnings } else { Shown::All })
}

/// What people see of findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// What refuses; warnings are the business of another line.
    Refusals,
    /// Warnings too.
    Warnings,
    /// Remarks too.
    All,
}

/// [`report`] with what was fixed, which JSON shows, and with more or less for people.
pub fn report_as(
    files: &[CheckedFile],
    more: Vec<Located<'_>>,
    fixed: Option<&[Value]>,
    format: Format,
    to_stdout: bool,
    shown: Shown,
) -> (Exit, output::Counts) {
    let mut all = gathered(files, more);
    let (exit, counts) = tallied(&all);
    let quiet = shown != Shown::All;
    if format == Format::Human && shown == Shown::Refusals {
        all.retain(|located| located.finding.severity >= Severity::Deny);
    }
    if format == Format::Human && all.len() > SHOWN {
        let rest = all.len() - SHOWN;
        all.truncate(SHOWN);
        output::findings(&all, fixed, format, to_stdout, quiet);
        terminal::say(&format!("... and {rest} more findings; `--format short` shows all"));
    } else {
        output::findings(&all, fixed, format, to_stdout, quiet);
    }
    (exit, counts)
}

/// The ledger of a scene for each target; `checked` is the file that it stands in, `lowered` what lowering found.
pub fn ledgers(scene: &Valid, targets: &[&'static Target], checked: &Checked, lowered: &[Finding]) -> Vec<Ledger> {
    let before: Vec<Finding> = checked.losses().chain(lowered).cloned().collect();
    targets.iter().map(|target| Ledger::of(scene, target, &before)).collect()
}

/// What targets cannot say exactly of scenes, with the levels chosen for it.
pub fn losses<'s>(scenes: &[(&[Ledger], &'s CheckedFile)], levels: &Levels) -> Vec<Located<'s>> {
    let all = scenes.iter().flat_map(|(ledgers, file)| {
        let mut of: Vec<Finding> = ledgers.iter().flat_map(Ledger::findings).collect();
        levels.judge(&mut of);
        of.into_iter().map(|finding| file.located(finding))
    });
    all.collect()
}

/// The values that `--set` gives to parameters, one for each.
pub fn set_of(set: &[String]) -> Result<Vec<(String, String)>, Failure> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for text in set {
        let Some((name, value)) = text.split_once('=').filter(|(name, _)| !name.trim().is_empty()) else {
            return Err(Failure::new(Exit::Usage, format!("`--set {text}` has no value"))
                .help("write for example `--set alpha=0.2`"));
        };
        let (name, value) = (name.trim(), value.trim());
        if let Some((_, first)) = pairs.iter().find(|(known, _)| known == name) {
            let message = format!("`--set` gives `{name}` two values, {first} and {value}");
            return Err(Failure::new(Exit::Usage, message).help("give each parameter one value"));
        }
        pairs.push((name.to_owned(), value.to_owned()));
    }
    Ok(pairs)
}

/// The values that `--set` gives in a command that works on several scenes: they belong to one.
pub fn set_for(set: &[String], groups: &[Group]) -> Result<Overrides, Failure> {
    let set = set_of(set)?;
    if !set.is_empty() && groups.iter().map(|(_, files)| files.len()).sum::<usize>() != 1 {
        return Err(Failure::new(Exit::Usage, "`--set` goes with one scene, whose parameters it sets")
            .help("name the scene file"));
    }
    Ok(Overrides { set, ..Overrides::default() })
}

/// The settings of the command line.
pub fn overrides(settings: &args::Settings) -> Result<Overrides, Failure> {
    let args::Settings { width, height, samples, max_depth, seed, set, camera: _ } = settings;
    let set = set_of(set)?;
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

/// The one scene of a file, in which nothing forbids to go on.
pub struct One {
    pub project: Project,
    pub scene: Valid,
    pub camera: Handle<Camera>,
    /// BLAKE3 of everything that the scene was read from, settings of the command line included.
    pub hash: String,
    /// The file, what lowering changed among its findings.
    file: CheckedFile,
    /// What was lost before any target was asked.
    before: Vec<Finding>,
}

impl One {
    /// What becomes of the scene for a target.
    pub fn ledger(&self, target: &Target) -> Ledger {
        Ledger::of(&self.scene, target, &self.before)
    }

    /// Prints what was found and what the target cannot say exactly, and gives the exit code that it leads to. Where the answer of
    /// the command is a document of its own, `quiet`, programs get findings only where they forbid to go on.
    pub fn report(&self, target: &'static Target, findings: &args::Findings, quiet: bool) -> Result<Exit, Failure> {
        let format = findings.format;
        let ledgers = [self.ledger(target)];
        let lost = losses(&[(&ledgers, &self.file)], &self.project.levels_with(findings)?);
        let denied = |located: &Located<'_>| located.finding.severity >= Severity::Deny;
        let refused = self.file.checked.worst() >= Severity::Deny || lost.iter().any(denied);
        if quiet && format.is_document() && !refused {
            return Ok(Exit::Done);
        }
        // People get one line, and what forbids to go on.
        let all = lost.into_iter().filter(|located| format != Format::Human || denied(located)).collect();
        if format == Format::Human && !refused {
            // `lint` shows them: a sweep of renderings does not say the same again each time.
            said::one_scene(&self.file.checked.findings, Some(&ledgers[0]), &self.file.file);
            return Ok(Exit::Done);
        }
        let (exit, _) = report(std::slice::from_ref(&self.file), all, format, false, true);
        Ok(exit)
    }
}

impl One {
    /// Reads what was written of the scene for one target, below the root of `files`, and refuses it where it says something else
    /// than the scene.
    pub fn audited(&self, target: &'static Target, files: &dyn Files, format: Format) -> Option<Exit> {
        let audited = pipeline::audit(&self.scene, self.camera, &[target], files, |_| String::new());
        let wrong: Vec<Located<'_>> = audited.findings().map(|finding| self.file.located(finding.clone())).collect();
        if wrong.is_empty() {
            return None;
        }
        output::findings(&wrong, None, format, false, true);
        terminal::error("ltsc wrote something else than the scene says; nothing was kept");
        terminal::help("this is an internal error (a bug in ltsc): please report it with the scene");
        Some(Exit::Fault)
    }
}

/// Reads, checks and prepares the scene in `file`; where its findings forbid to go on, they are printed and the exit code comes
/// back.
pub fn one(file: &Path, findings: &args::Findings, settings: &args::Settings) -> Result<Result<One, Exit>, Failure> {
    let project = Project::of(file)?;
    if file.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{} is a folder", file.display())).help("name one scene"));
    }
    let overrides = overrides(settings)?;
    let files = check(&project, &[file.to_path_buf()], findings, overrides.clone(), &[])?;
    let refuse = |files: &[CheckedFile]| report(files, Vec::new(), findings.format, false, true).0;
    if files.iter().any(|file| file.checked.worst() >= Severity::Deny) {
        return Ok(Err(refuse(&files)));
    }
    let Some(mut file) = files.into_iter().next() else { return Ok(Err(Exit::Fault)) };
    let Some(scene) = file.checked.scene.take() else {
        let what = if file.checked.library { "is a library: it has no `scene`" } else { "gives no scene" };
        return Err(Failure::new(Exit::Input, format!("{} {what}", file.path)).help("name a scene that uses it"));
    };
    let hash = hash(&file.checked.inputs, &overrides);
    let camera = camera(&scene, settings.camera.as_deref())?;
    let prepared = pipeline::prepare(scene);
    let (scene, mut remarks) = match prepared {
        Ok((scene, remarks)) => (Some(scene), remarks),
        Err(invalid) => (None, invalid),
    };
    project.levels_with(findings)?.judge(&mut remarks);
    let before = file.checked.losses().chain(&remarks).cloned().collect();
    file.checked.findings.extend(remarks);
    match scene {
        Some(scene) => Ok(Ok(One { project, scene, camera, hash, file, before })),
        None => Ok(Err(refuse(&[file]))),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_finding_of_its_file() {
        let path = VPath::resolve("", "a.lts").expect("a path");
        let (checked, _) = guarded(&path, || panic!("no such handle"));
        let finding = &checked.findings[0];
        assert_eq!((finding.id, Exit::of_finding(finding)), ("internal-fault", Exit::Fault));
        assert!(finding.message.contains("no such handle"), "{}", finding.message);
    }

    #[test]
    fn everything_that_makes_another_scene_makes_another_hash() {
        let inputs = |files: &[(&str, &str)]| {
            let path = |path: &str| VPath::resolve("", path).expect("a path");
            let bytes = |text: &str| ltsc_core::files::Bytes::new(text.as_bytes().to_vec());
            files.iter().map(|(name, text)| (path(name), bytes(text))).collect()
        };
        let set = |values: &[(&str, &str)]| Overrides {
            set: values.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
            ..Overrides::default()
        };
        let one = &[("a.lts", "1")][..];
        let all = [
            hash(&inputs(one), &set(&[])),
            hash(&inputs(one), &set(&[("alpha", "0.1")])),
            hash(&inputs(one), &set(&[("alpha", "0.2")])),
            hash(&inputs(one), &set(&[("beta", "0.1")])),
            hash(&inputs(one), &Overrides { width: Some(1), ..Overrides::default() }),
            hash(&inputs(one), &Overrides { height: Some(1), ..Overrides::default() }),
            hash(&inputs(one), &Overrides { samples: Some(1), ..Overrides::default() }),
            hash(&inputs(one), &Overrides { seed: Some(1), ..Overrides::default() }),
            hash(&inputs(one), &Overrides { max_depth: Some(1), ..Overrides::default() }),
            hash(&inputs(&[("a.lts", "2")]), &set(&[])),
            hash(&inputs(&[("b.lts", "1")]), &set(&[])),
            hash(&inputs(&[("a.lts", "1"), ("b.lts", "")]), &set(&[])),
            hash(&inputs(&[("a.lts", "1b.lts")]), &set(&[])),
        ];
        let different: std::collections::BTreeSet<&String> = all.iter().collect();
        assert_eq!(different.len(), all.len());
        assert_eq!(hash(&inputs(one), &set(&[])), all[0]);
    }
}
