//! All stages in their order: read, evaluate, lint, lower, validate, emit. The only file that knows them all.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use crate::audit::{self, Asked, Audited, Meshes};
use crate::diag::{FileId, Finding, Origin, Severity, Sources, Suppression};
use crate::eval::{self, Allow, Evaluated, Overrides, SceneParameter};
use crate::files::{Bytes, Files, Sink, VPath};
use crate::fix;
use crate::formats::statements::{self, Statements};
use crate::formats::{self, Choices, Emission, Target};
use crate::import::{self, Imported, Importer};
use crate::ir::{Camera, Handle, Scene, Scenes};
use crate::ledger::{self, Ledger};
use crate::lint::{self, Around, Levels, UnusedName};
use crate::lower;
use crate::valid::{self, Valid};

/// How a file is looked at.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Settings that replace the scene's own.
    pub overrides: Overrides,
    /// Levels of rules that differ from the built-in ones.
    pub levels: Levels,
    /// Ignores the `allow` statements of scenes.
    pub no_allow: bool,
    /// Leaves out rules that exist for none of these targets; none are all.
    pub targets: Vec<&'static str>,
    /// The documentation of the project's scenes, for rules that compare scenes.
    pub scenes: Scenes,
}

/// A file that was read, evaluated and linted.
#[derive(Debug, Default)]
pub struct Checked {
    /// The scene, unless something is malformed or the file is a library.
    pub scene: Option<Scene>,
    /// Everything found, in the order of the text. Findings of severity [`Severity::Allow`] are among them.
    pub findings: Vec<Finding>,
    /// Whether the file is a library, which has nothing to emit.
    pub library: bool,
    /// Every file that was read, by path.
    pub inputs: BTreeMap<VPath, Bytes>,
    /// Files that a scene of another program names and that are not there.
    pub missing: BTreeSet<VPath>,
    /// The parameters that the scene declares.
    pub parameters: Vec<SceneParameter>,
}

impl Checked {
    /// The gravest finding's severity.
    pub fn worst(&self) -> Severity {
        self.findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Allow)
    }

    /// What files hold that is not in the scene, or not as they say it.
    pub fn losses(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.id.starts_with("loss-"))
    }
}

/// Formats of scenes and meshes that are not ltsc's own: how their files' names end, and what they hold.
const FOREIGN: &[(&str, &str)] = &[
    ("scn", "a scene of LuxCore"),
    ("cfg", "a configuration of LuxCore"),
    ("blend", "a scene of Blender"),
    ("usd", "a scene in USD"),
    ("usda", "a scene in USD"),
    ("usdc", "a scene in USD"),
    ("obj", MESH),
    ("ply", MESH),
    ("stl", MESH),
    ("py", "a program in Python"),
    ("rs", "a program"),
    ("c", "a program"),
    ("cpp", "a program"),
    ("sh", "a program"),
    ("json", "JSON"),
    ("toml", "TOML"),
    ("yaml", "YAML"),
    ("yml", "YAML"),
    ("md", "Markdown"),
    ("html", "HTML"),
    ("npy", "an array of NumPy"),
    ("exr", "an image"),
    ("png", "an image"),
    ("jpg", "an image"),
    ("hdr", "an image"),
];

const MESH: &str = "a mesh";

/// What is to be said of a file in a format that is not ltsc's own.
fn foreign(path: &VPath) -> Option<Finding> {
    let ending = path.as_str().rsplit_once('.')?.1.to_ascii_lowercase();
    let (_, what) = FOREIGN.iter().find(|(known, _)| *known == ending)?;
    let origin = Origin::File { path: path.as_str().to_owned(), place: String::new() };
    let finding = Finding::error("foreign-file", origin, format!("the file is {what}, not one of ltsc"));
    Some(if *what == MESH {
        finding.help(format!("name it in a scene: `shape a = file(\"{path}\") with diffuse(0.5)`"))
    } else {
        if what.starts_with("a scene") || what.starts_with("a configuration") {
            finding.note("scenes of other formats are not imported yet").help("name a `.lts` file")
        } else {
            finding.help("name a `.lts` file")
        }
    })
}

/// The code of a finding that ltsc itself failed.
pub const FAULT: &str = "internal-fault";

/// That ltsc failed on the file at `path`, where a panic said `problem`.
pub fn fault(path: &VPath, problem: &str) -> Checked {
    let origin = Origin::File { path: path.as_str().to_owned(), place: String::new() };
    let finding = Finding::error(FAULT, origin, format!("an internal error (a bug in ltsc): {problem}"))
        .help("please report it with the file");
    Checked { findings: vec![finding], ..Checked::default() }
}

/// Reads, evaluates and lints the file at `path`; texts that were read are added to `sources`.
pub fn check(files: &dyn Files, sources: &mut Sources, path: &VPath, options: &Options) -> Checked {
    if let Some(importer) = import::find(path) {
        return imported(importer, files, sources, path, options);
    }
    if let Some(finding) = foreign(path) {
        return Checked { findings: vec![finding], ..Checked::default() };
    }
    let Evaluated { scene, mut findings, allows, inputs, library, parameters, unused, lengthened } =
        eval::evaluate(files, sources, path, &options.overrides);
    let unused = unused.into_iter().map(|eval::Unused { kind, name, span }| UnusedName { kind, name, span }).collect();
    let around = Around { scenes: options.scenes.clone(), unused, lengthened };
    let lint = |scene| lint::lint(scene, &around, &options.levels, &options.targets);
    let mut linted = scene.as_ref().map(lint).unwrap_or_default();
    if !options.no_allow {
        let main = scene.as_ref().and_then(|_| sources.find(path.as_str()));
        findings.extend(suppress(&mut linted, &allows, main, options));
    }
    options.levels.judge(&mut findings);
    findings.append(&mut linted);
    findings.sort_by_key(|finding| finding.origin.span());
    fix::propose(&mut findings, sources);
    Checked { scene, findings, library, inputs, missing: BTreeSet::new(), parameters }
}

/// Reads and lints a scene of another program. `--set` gives its parameters values.
fn imported(importer: &Importer, files: &dyn Files, sources: &mut Sources, path: &VPath, options: &Options) -> Checked {
    let defines = options.overrides.set.iter().cloned().collect();
    let reading = import::Options { defines, limits: options.overrides.limits };
    let Imported { scene, mut findings, inputs, missing } = import::import(importer, files, sources, path, &reading);
    let scene = scene.map(|mut scene| {
        options.overrides.apply(&mut scene);
        scene
    });
    let around = Around { scenes: options.scenes.clone(), unused: Vec::new(), lengthened: Vec::new() };
    let linted = scene.as_ref().map(|scene| lint::lint(scene, &around, &options.levels, &options.targets));
    options.levels.judge(&mut findings);
    // Nobody has written it for several renderers: what stands in the way of that is told, and refuses nothing unless it is asked to.
    findings.extend(linted.unwrap_or_default().into_iter().filter_map(|mut finding| {
        if finding.severity == Severity::Deny && !options.levels.names(finding.id) {
            finding.severity = Severity::Warn;
        }
        (finding.id != "undocumented-scene" || options.levels.names(finding.id)).then_some(finding)
    }));
    findings.sort_by_key(|finding| finding.origin.span());
    Checked { scene, findings, inputs, missing, ..Checked::default() }
}

/// Gives findings that an `allow` covers the severity [`Severity::Allow`]; says which suppressions are unknown or unused.
fn suppress(linted: &mut [Finding], allows: &[Allow], main: Option<FileId>, options: &Options) -> Vec<Finding> {
    let mut findings = Vec::new();
    for allow in allows {
        let Some(rule) = lint::find(&allow.id) else {
            let similar = crate::diag::nearest(&allow.id, lint::RULES.iter().map(|rule| rule.id));
            let message = format!("there is no rule `{}`", allow.id);
            let finding = Finding::warn("unknown-rule", allow.span, message);
            findings.push(match similar {
                Some(id) => finding.help(format!("did you mean `{id}`?")),
                None => finding.help("`ltsc explain` lists the rules"),
            });
            continue;
        };
        let mut used = false;
        for finding in linted.iter_mut().filter(|finding| finding.id == allow.id) {
            let covered = match (allow.range, finding.origin.span()) {
                (None, Some(span)) => span.file == allow.span.file,
                (Some(range), Some(span)) => {
                    range.file == span.file && range.start <= span.start && span.start < range.end
                }
                (_, None) => false,
            };
            if covered {
                finding.severity = Severity::Allow;
                finding.suppression = Some(Suppression { span: allow.span, reason: allow.reason.clone() });
                used = true;
            }
        }
        // A rule that was not asked finds nothing to suppress, and what a library allows may be found in another scene.
        if !used && main == Some(allow.span.file) && options.levels.ask(rule, &options.targets) {
            findings.push(
                Finding::warn("unused-allow", allow.span, format!("`allow {}` suppresses nothing", allow.id))
                    .help("remove it"),
            );
        }
    }
    findings
}

/// Lowers and validates a scene. What was changed on the way comes back beside it.
///
/// # Errors
/// What makes the scene invalid.
pub fn prepare(scene: Scene) -> Result<(Valid, Vec<Finding>), Vec<Finding>> {
    let (lowered, mut findings) = lower::lower(scene);
    match valid::validate(lowered) {
        Ok(valid) => Ok((valid, findings)),
        Err(invalid) => {
            findings.extend(invalid);
            Err(findings)
        }
    }
}

/// The scene with other settings.
///
/// # Errors
/// What makes it invalid.
pub fn override_settings(scene: Valid, overrides: &Overrides) -> Result<Valid, Vec<Finding>> {
    let mut scene = scene.into_inner();
    overrides.apply(&mut scene);
    valid::validate(scene)
}

/// The camera called `name`, or the first one.
pub fn camera(scene: &Scene, name: Option<&str>) -> Option<Handle<Camera>> {
    let mut cameras = scene.cameras.iter();
    let found = match name {
        None => cameras.next(),
        Some(name) => cameras.find(|(_, camera)| camera.name.as_deref() == Some(name)),
    };
    found.map(|(handle, _)| handle)
}

/// Writes one self-contained folder for one target, meshes and images inside.
///
/// # Errors
/// What the sink says.
pub fn emit_alone(
    scene: &Valid,
    camera: Handle<Camera>,
    target: &Target,
    ledger: &Ledger,
    choices: &Choices,
    sink: &mut dyn Sink,
) -> io::Result<()> {
    emit_given(scene, camera, target, ledger, choices, &statements::NONE, sink)
}

/// The same with statements of a test case, which [`take_statements`] has looked at, in the place of the target's own.
///
/// # Errors
/// What the sink says.
pub fn emit_given(
    scene: &Valid,
    camera: Handle<Camera>,
    target: &Target,
    ledger: &Ledger,
    choices: &Choices,
    statements: &Statements,
    sink: &mut dyn Sink,
) -> io::Result<()> {
    if target.shares_meshes {
        formats::write_meshes(scene, "meshes/", sink)?;
        formats::write_textures(scene, &[target], "textures/", sink)?;
    }
    book(ledger, sink)?;
    (target.emit)(&Emission { scene, camera, meshes: "meshes/", textures: "textures/", choices, statements }, sink)
}

/// A scene that statements of a test case are to replace settings of: its image has the size that they say, since conventions of
/// cameras depend on it. What is likely to be a mistake comes back beside it.
///
/// # Errors
/// What the target cannot write, or an image of such a size.
pub fn take_statements(
    scene: Valid,
    target: &Target,
    statements: &Statements,
) -> Result<(Valid, Vec<Finding>), Vec<Finding>> {
    if statements.is_empty() {
        return Ok((scene, Vec::new()));
    }
    let Some(native) = &target.statements else {
        let origin = statements.iter().next().map_or(Origin::Made, |first| first.origin.clone());
        let finding = Finding::error("no-statements", origin, format!("{} takes no statements", target.name));
        return Err(vec![
            finding
                .note("it has no words for integrator, sampler and film")
                .help("leave the parameters out, or name another target"),
        ]);
    };
    let findings = (native.check)(statements);
    if findings.iter().any(|finding| finding.severity == Severity::Error) {
        return Err(findings);
    }
    let own = [scene.film.width, scene.film.height];
    let size = (native.size)(statements, own);
    if size == own {
        return Ok((scene, findings));
    }
    let mut scene = scene.into_inner();
    [scene.film.width, scene.film.height] = size;
    valid::validate(scene).map(|scene| (scene, findings))
}

/// Writes the folder of one target beside the folders `meshes` and `textures` that targets share.
///
/// # Errors
/// What the sink says.
pub fn emit_shared(
    scene: &Valid,
    camera: Handle<Camera>,
    target: &Target,
    ledger: &Ledger,
    choices: &Choices,
    sink: &mut dyn Sink,
) -> io::Result<()> {
    book(ledger, sink)?;
    let (meshes, textures) = ("../meshes/", "../textures/");
    (target.emit)(&Emission { scene, camera, meshes, textures, choices, statements: &statements::NONE }, sink)
}

/// Reads what was written of a scene back from `files`, each target in the folder that `folder` says, and compares it with the scene.
/// Targets without a reader are passed over.
pub fn audit(
    scene: &Valid,
    camera: Handle<Camera>,
    targets: &[&'static Target],
    files: &dyn Files,
    folder: impl Fn(&Target) -> String,
) -> Audited {
    audit_given(scene, camera, targets, &statements::NONE, files, folder)
}

/// The same with statements of a test case in the place of the targets' own: they are not compared, all else is.
pub fn audit_given(
    scene: &Valid,
    camera: Handle<Camera>,
    targets: &[&'static Target],
    given: &Statements,
    files: &dyn Files,
    folder: impl Fn(&Target) -> String,
) -> Audited {
    let asked = Asked::new(scene, camera);
    let mut meshes = Meshes::new(files);
    let readable = targets.iter().filter(|target| target.import.is_some());
    let targets = readable.map(|target| audit::audit(&asked, target, &folder(target), given, &mut meshes)).collect();
    let Asked { sums, emitters, .. } = asked;
    Audited { asked: sums, emitters, targets }
}

fn book(ledger: &Ledger, sink: &mut dyn Sink) -> io::Result<()> {
    sink.file(ledger::FILE, &mut |out| out.write_all(ledger.json().as_bytes()))
}
