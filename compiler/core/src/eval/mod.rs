//! Tree to Scene: names, types, units, constructors. Every error is a finding; evaluation goes on behind it.
//!
//! Reading order: `value`, `ops`, [`table`] (constructors), `expr` (expressions and calls), `function`, `numeric` (functions of numbers, translated), `module` (statements
//! and `use`), `items` (shapes, instances, settings), `flow` (loops, conditions, parameters), `limits` (how large a scene may become), `work` (what evaluation may spend), `overrides` (settings that replace the scene's), `synonyms` (words of other renderers), `unused` (names), `assemble` (the Scene).

#![expect(clippy::wildcard_enum_match_arm, reason = "a value of any other type is the same mistake, and is reported")]

mod assemble;
mod expr;
mod flow;
mod function;
mod items;
mod limits;
mod module;
mod numeric;
mod ops;
mod overrides;
mod synonyms;
mod table;
mod unused;
mod value;
mod work;

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use crate::diag::{Finding, Severity, Sources, Span};
use crate::files::{Files, VPath};
use crate::ir::{Affine, Arena, Documentation, Scene, Texture};

pub use limits::{Limit, Limits, parse_amount};
pub use overrides::Overrides;
pub use synonyms::any as synonym;
pub use table::{Constructor, Family, Parameter, table};
pub use value::Ty;

/// A parameter that a scene declares, with its value.
pub use crate::ir::ParameterValue as SceneParameter;

/// A suppression written in a scene: findings of `id` that start in `range` are allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allow {
    /// The code.
    pub id: String,
    /// Where the code stands.
    pub span: Span,
    /// The reason given.
    pub reason: String,
    /// What it covers; none for the whole file.
    pub range: Option<Span>,
}

/// A name that a file declares and never uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unused {
    /// The word of its declaration: `let`, `material`, `use`.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// Where it is declared.
    pub span: Span,
}

/// What a file means.
#[derive(Debug)]
pub struct Evaluated {
    /// The scene, if nothing was malformed and the file is one.
    pub scene: Option<Scene>,
    /// What was found.
    pub findings: Vec<Finding>,
    /// Suppressions in the file.
    pub allows: Vec<Allow>,
    /// Every file that was read, with the bytes that came from it, sorted by path: the inputs of the scene.
    pub inputs: BTreeMap<VPath, crate::files::Bytes>,
    /// Whether the file has no `scene` and is a library.
    pub library: bool,
    /// The parameters that the scene declares.
    pub parameters: Vec<SceneParameter>,
    /// Names that the file, or a library that it uses, declares in vain.
    pub unused: Vec<Unused>,
    /// Where mesh files with normals of another length than 1 are read, and what was done about it.
    pub lengthened: Vec<(Span, String)>,
}

/// Reads and evaluates the file at `path`. Texts that were read are added to `sources`.
pub fn evaluate(files: &dyn Files, sources: &mut Sources, path: &VPath, overrides: &Overrides) -> Evaluated {
    let mut interpreter = Interpreter::new(files, sources, &overrides.set, overrides.limits);
    let loaded = interpreter.main(path);
    if loaded.is_some() {
        interpreter.unknown_settings(path);
    }
    let library = loaded.as_ref().is_some_and(|module| module.header.is_none());
    let malformed = |found: &[Finding]| found.iter().any(|finding| finding.severity == Severity::Error);
    let mut scene = None;
    if let Some(module) = loaded {
        scene = interpreter.assemble(module, path, overrides).filter(|_| !malformed(&interpreter.findings));
    }
    let Interpreter { mut findings, allows, inputs, scene_parameters: parameters, unused, lengthened, .. } =
        interpreter;
    findings.sort_by_key(|finding| finding.origin.span());
    Evaluated { scene, findings, allows, inputs, library, parameters, unused, lengthened }
}

/// The name and documentation of the scene in the file at `path`; none for a library and for what cannot be read. Nothing but
/// the header is looked at.
pub fn header(files: &dyn Files, path: &VPath, limits: Limits) -> Option<(String, Documentation)> {
    let bytes = files.read(path, limits.text).ok()?;
    let text = std::str::from_utf8(&bytes).ok()?;
    let mut sources = Sources::default();
    let file = sources.add(path.as_str(), text);
    let tree = crate::syntax::header(file, text)?;
    Interpreter::new(files, &mut sources, &[], limits).header_alone(&tree)
}

/// The files that the file at `path` uses, those that are not there included; none of what cannot be read.
pub fn uses(files: &dyn Files, path: &VPath, limits: Limits) -> Vec<VPath> {
    let Ok(bytes) = files.read(path, limits.text) else { return Vec::new() };
    let Ok(text) = std::str::from_utf8(&bytes) else { return Vec::new() };
    let file = Sources::default().add(path.as_str(), "");
    let statements = crate::syntax::uses(file, text).statements;
    let named = statements.iter().filter_map(|statement| match &statement.kind {
        crate::syntax::StatementKind::Use { names: _, path } => Some(path),
        _ => None,
    });
    named.filter_map(|used| VPath::resolve(path.folder(), &used.text).ok()).collect()
}

/// How many steps of the way that led to an error are shown: calls, iterations, uses of files.
const TRAIL: usize = 8;

/// What has been reported and has no value.
struct Reported;

/// Evaluates one scene file and the libraries it uses.
struct Interpreter<'f> {
    files: &'f dyn Files,
    sources: &'f mut Sources,
    findings: Vec<Finding>,
    allows: Vec<Allow>,
    /// Libraries that have been evaluated; none for those that could not be read.
    modules: BTreeMap<VPath, Option<Rc<module::Names>>>,
    /// Files whose evaluation has not ended, outermost first.
    loading: Vec<VPath>,
    inputs: BTreeMap<VPath, crate::files::Bytes>,
    /// Meshes, groups, tables and textures read from files, by what makes two of them the same.
    read: BTreeMap<expr::FileKey, value::Value>,
    /// Textures so far, used or not.
    textures: Arena<Texture>,
    /// Places read from files.
    scattered: BTreeMap<VPath, Arc<[Affine]>>,
    /// Calls and iterations up to now.
    steps: u64,
    /// Work and memory up to now.
    work: work::Work,
    /// Triangles that generators and stages made up to now.
    triangles: u64,
    limits: Limits,
    /// Calls of functions around the place that is evaluated.
    call_depth: usize,
    /// Values of parameters from outside.
    set: &'f [(String, String)],
    /// Parameters met.
    scene_parameters: Vec<SceneParameter>,
    unused: Vec<Unused>,
    lengthened: Vec<(Span, String)>,
}

impl<'f> Interpreter<'f> {
    fn new(files: &'f dyn Files, sources: &'f mut Sources, set: &'f [(String, String)], limits: Limits) -> Self {
        Self {
            files,
            sources,
            findings: Vec::new(),
            allows: Vec::new(),
            modules: BTreeMap::new(),
            loading: Vec::new(),
            inputs: BTreeMap::new(),
            read: BTreeMap::new(),
            textures: Arena::default(),
            scattered: BTreeMap::new(),
            steps: 0,
            work: work::Work::default(),
            triangles: 0,
            limits,
            call_depth: 0,
            set,
            scene_parameters: Vec::new(),
            unused: Vec::new(),
            lengthened: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
