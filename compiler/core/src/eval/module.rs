//! Statements of a file, its names, and `use`.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use crate::diag::{FileId, Finding, Label, Severity, Span, nearest};
use crate::files::{PathError, ReadError, VPath};
use crate::ir::{Documentation, Film, Handle, Integrator, Sampler, Texture};
use crate::syntax::{self, Cut, Expr, ExprKind, Kind, Name, Statement, StatementKind, Tree};

use super::items::{self, InstanceNames, Item, Lit, Placed};
use super::table::Family;
use super::unused::Looked;
use super::value::{CameraValue, MaterialValue, Value};
use super::{Allow, Interpreter, Reported};

/// Names and their values; a declared name has a place.
pub(super) type Names = BTreeMap<String, (Value, Span)>;

/// The names that can be seen at one place of a file.
#[derive(Default)]
pub(super) struct Scope {
    names: Names,
    /// Those of them that loops, groups and conditions declare, innermost last.
    inner: Vec<String>,
    /// The file, to say "declared below".
    ahead: Option<Ahead>,
}

/// A file that is being evaluated, statement by statement.
struct Ahead {
    file: FileId,
    text: Arc<str>,
    cut: Rc<Cut>,
    /// The names that the file declares, with their places and the ends of their statements; found when first asked for.
    names: OnceCell<BTreeMap<String, (Span, usize)>>,
}

impl Ahead {
    fn find(&self, name: &str) -> Option<(Span, usize)> {
        let names = self.names.get_or_init(|| {
            let mut names = BTreeMap::new();
            for (name, range, end) in self.cut.declared(&self.text) {
                names.entry(name.to_owned()).or_insert((Span::new(self.file, range.start, range.end), end));
            }
            names
        });
        names.get(name).copied()
    }
}

impl Scope {
    pub(super) fn get(&self, name: &str) -> Option<&Value> {
        self.entry(name).map(|(value, _)| value)
    }

    fn entry(&self, name: &str) -> Option<(&Value, Span)> {
        self.names.get(name).map(|(value, span)| (value, *span))
    }

    /// Where the file declares `name`, if it does so below `at` or in the same statement.
    pub(super) fn later(&self, name: &str, at: Span) -> Option<Span> {
        let (span, end) = self.ahead.as_ref()?.find(name)?;
        (span.file == at.file && end > at.start as usize).then_some(span)
    }

    /// Whether the file declares `name` above `at` in a statement that is broken: its value is not there, and no one wants to read
    /// that again.
    pub(super) fn broken(&self, name: &str, at: Span) -> bool {
        let found = self.ahead.as_ref().and_then(|ahead| ahead.find(name));
        found.is_some_and(|(span, end)| span.file == at.file && end <= at.start as usize)
    }

    /// Where `name` is declared.
    pub(super) fn place(&self, name: &str) -> Option<Span> {
        self.entry(name).map(|(_, span)| span)
    }

    /// Puts a name in, whatever was there.
    pub(super) fn insert(&mut self, name: &str, value: Value, span: Span) {
        self.names.insert(name.to_owned(), (value, span));
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.names.keys().map(String::as_str)
    }

    /// The names that can be called.
    pub(super) fn functions(&self) -> impl Iterator<Item = &str> + Clone {
        let functions = self.names.iter().filter(|(_, (value, _))| matches!(value, Value::Function(_)));
        functions.map(|(name, _)| name.as_str())
    }

    /// To be given to [`Scope::release`] when the names declared since go out of sight.
    pub(super) fn mark(&self) -> usize {
        self.inner.len()
    }

    pub(super) fn release(&mut self, mark: usize) {
        for name in self.inner.drain(mark..) {
            self.names.remove(&name);
        }
    }
}

/// The header of a scene file.
pub(super) struct Header {
    pub name: Name,
    pub doc: String,
    /// Names with their values and how these were written.
    pub fields: Vec<(Name, Value, Expr)>,
}

/// A scene file as it was evaluated.
#[derive(Default)]
pub(super) struct Module {
    pub header: Option<Header>,
    pub items: Vec<Item>,
    pub lights: Vec<Lit>,
    pub instances: Vec<Placed>,
    /// Shapes and instances so far, those within groups as often as they are placed.
    pub size: u64,
    /// How many groups lie within each other so far.
    pub group_depth: usize,
    /// Names of shapes (false) and of emitters (true).
    pub item_names: BTreeMap<(bool, String), Span>,
    pub instance_names: InstanceNames,
    pub cameras: Vec<(Option<String>, Rc<CameraValue>, Span)>,
    pub film: Option<(Rc<Film>, Span)>,
    pub integrator: Option<(Rc<Integrator>, Span)>,
    pub sampler: Option<(Rc<Sampler>, Span)>,
    /// Settings whose value has been reported, so that they are not also called missing.
    pub broken: Vec<Kind>,
    pub names: Names,
    /// The iterations of the loops around the statement that is evaluated.
    pub path: Vec<String>,
    /// How many loops and conditions stand around it.
    pub depth: usize,
    /// Whether it is the body of a group.
    pub group: bool,
    /// The names that `use` brings.
    pub imported: BTreeSet<String>,
}

/// A file in the middle of its evaluation.
#[derive(Default)]
struct Reading {
    module: Module,
    scope: Scope,
    /// `allow` statements whose statement has not come yet.
    pending: Vec<Allow>,
    looked: Looked,
    /// The first statement.
    first: Option<Span>,
    /// Whether `scene` has come.
    scene: bool,
    /// Whether the first statement is `lts`.
    versioned: bool,
}

impl Module {
    /// The name of an item in the loops around it: `lamp[3,0,5]`.
    pub(super) fn item_name(&self, name: &Name) -> String {
        if self.path.is_empty() { name.text.clone() } else { format!("{}[{}]", name.text, self.path.join(",")) }
    }
}

impl Interpreter<'_> {
    /// Evaluates the file that the user named.
    pub(super) fn main(&mut self, path: &VPath) -> Option<Module> {
        let file = match self.load(path) {
            Ok(file) => file,
            Err(problem) => {
                let origin = crate::diag::Origin::File { path: path.to_string(), place: String::new() };
                self.findings.push(Finding { origin, ..*problem });
                return None;
            }
        };
        self.loading.push(path.clone());
        let module = self.file(file);
        self.loading.pop();
        Some(module)
    }

    /// Name and documentation of a tree that is nothing but a `scene` statement.
    pub(super) fn header_alone(&mut self, tree: &Tree) -> Option<(String, Documentation)> {
        let mut reading = Reading::default();
        tree.statements.iter().for_each(|statement| self.next(&mut reading, statement));
        let header = reading.module.header?;
        Some((header.name.text.clone(), self.documentation(&header)))
    }

    /// Reads a file. The finding of an error has no place yet.
    fn load(&mut self, path: &VPath) -> Result<FileId, Box<Finding>> {
        let place = crate::diag::Origin::Made;
        let bytes = self.files.read(path, self.limits.text).map_err(|error| Box::new(read_problem(path, &error)))?;
        self.inputs.insert(path.clone(), bytes.clone());
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() + 1;
            let finding = Finding::error("not-text", place.clone(), format!("`{path}` is not a text in UTF-8"))
                .note(format!("the first bad byte is at {} (line {line})", error.valid_up_to()));
            Box::new(finding.help("scene files are text; save it as UTF-8"))
        })?;
        if text.contains('\0') {
            let at = text.find('\0').unwrap_or(0);
            let finding = Finding::error("not-text", place, format!("`{path}` contains a zero byte"))
                .note(format!("the first one is at byte {at}"));
            return Err(Box::new(finding.help("scene files are text; is this a binary file?")));
        }
        if let Some(what) = foreign_text(text) {
            return Err(Box::new(
                Finding::error("foreign-file", place, format!("`{path}` is {what}, not a scene of ltsc"))
                    .help("a scene is written in the language `.lts`; `ltsc init` makes one to start from"),
            ));
        }
        Ok(self.sources.add(path.as_str(), text))
    }

    /// Parses and evaluates a file, statement by statement: names are declared before they are used, so that nothing has to be
    /// kept of a statement once it has been evaluated.
    fn file(&mut self, file: FileId) -> Module {
        let text = Arc::clone(&self.sources.get(file).text);
        let cut = Rc::new(Cut::new(&text));
        let ahead = Ahead { file, text: Arc::clone(&text), cut: Rc::clone(&cut), names: OnceCell::new() };
        let mut reading = Reading { scope: Scope { ahead: Some(ahead), ..Scope::default() }, ..Reading::default() };
        let findings = cut.read(file, &text, &mut |statements| {
            statements.iter().for_each(|statement| self.next(&mut reading, statement));
        });
        let silent = findings.is_empty();
        self.findings.extend(findings);
        let Reading { mut module, scope, pending, looked, first, scene, versioned } = reading;
        if !versioned && (first.is_some() || silent) {
            let newest = syntax::VERSION;
            self.findings.push(
                Finding::warn(
                    "missing-version",
                    first.unwrap_or(Span::new(file, 0, 0)),
                    "the file does not say its version of the language",
                )
                .note(format!("the newest one, {newest}, is assumed"))
                .help(format!("write `lts {newest}` first")),
            );
        }
        for (kind, name) in looked.unused(scene) {
            self.unused.push(super::Unused { kind, name: name.text, span: name.span });
        }
        for allow in pending {
            self.findings.push(
                Finding::warn("unused-allow", allow.span, format!("`allow {}` stands before nothing", allow.id))
                    .help("move it before the statement it is about"),
            );
        }
        module.names = scope.names;
        module
    }

    /// Evaluates the next statement of a file.
    fn next(&mut self, reading: &mut Reading, statement: &Statement) {
        let Reading { module, scope, pending, looked, first, scene, versioned } = reading;
        let is_first = first.is_none();
        first.get_or_insert(statement.span);
        looked.statement(statement);
        match &statement.kind {
            StatementKind::Allow { id, reason } => {
                let allow = Allow { id: id.text.clone(), span: id.span, reason: reason.text.clone(), range: None };
                if reason.text.trim().is_empty() {
                    self.findings.push(
                        Finding::error("missing-reason", reason.span, format!("`allow {}` gives no reason", id.text))
                            .help("say why the finding is right and yet wanted"),
                    );
                }
                pending.push(allow);
                return;
            }
            StatementKind::Version(number) => {
                *versioned |= is_first;
                self.version(number, statement.span, is_first);
                return;
            }
            StatementKind::Scene { .. } => {
                *scene = true;
                self.allows.append(pending);
            }
            StatementKind::Use { names, .. } => {
                let local = names.iter().map(|(name, alias)| alias.as_ref().unwrap_or(name).text.clone());
                module.imported.extend(local);
            }
            StatementKind::Declaration { .. }
            | StatementKind::Group { .. }
            | StatementKind::Parameter { .. }
            | StatementKind::For { .. }
            | StatementKind::If { .. } => {}
        }
        self.allows.extend(pending.drain(..).map(|allow| Allow { range: Some(statement.span), ..allow }));
        self.statement(module, scope, statement);
    }

    /// `lts 1`
    fn version(&mut self, number: &Expr, span: Span, first: bool) {
        if !first {
            self.findings.push(
                Finding::error("misplaced-statement", span, "`lts` must be the first statement, and stand once")
                    .help("remove it, or move it to the start of the file"),
            );
            return;
        }
        match number.kind {
            ExprKind::Number(version) if version == f64::from(syntax::VERSION) => {}
            _ => {
                let newest = syntax::VERSION;
                self.findings.push(
                    Finding::error("unknown-version", number.span, "this version of the language is not known")
                        .note(format!("this compiler knows version {newest}"))
                        .help("use a newer ltsc, or write `lts 1`"),
                );
            }
        }
    }

    pub(super) fn statement(&mut self, module: &mut Module, scope: &mut Scope, statement: &Statement) {
        match &statement.kind {
            // `next` has looked at them.
            StatementKind::Version(_) => {}
            StatementKind::Scene { name, fields } => self.header(module, scope, name, fields, &statement.doc),
            StatementKind::Use { names, path } => self.use_names(scope, names, path),
            StatementKind::Declaration { kind, name, params, value, with } => {
                if let Some(params) = params {
                    self.function_declaration(
                        module,
                        scope,
                        (*kind, statement.span),
                        name.as_ref(),
                        params,
                        value,
                        with.as_ref(),
                    );
                    return;
                }
                self.declaration(module, scope, *kind, name.as_ref(), value, with.as_ref(), statement.span);
            }
            StatementKind::Group { name, params, body } => {
                let made = self.group(scope, name, params, body).unwrap_or(Value::Poison);
                if module.depth > 0 { self.declare_inner(scope, name, made) } else { self.declare(scope, name, made) }
            }
            StatementKind::Parameter { name, ty, default, range } => {
                self.parameter(scope, name, ty, default, range.as_ref());
                if self.loading.len() > 1 {
                    self.findings.push(
                        Finding::error("misplaced-statement", statement.span, "a library has no parameters")
                            .help("give its functions parameters, and declare `param` in the scene"),
                    );
                }
            }
            StatementKind::For { clauses, body } => self.for_statement(module, scope, clauses, body),
            StatementKind::If { branches, otherwise } => self.if_statement(module, scope, branches, otherwise),
            StatementKind::Allow { .. } => {}
        }
    }

    fn poison(&mut self, scope: &mut Scope, name: Option<&Name>) {
        if let Some(name) = name {
            self.declare(scope, name, Value::Poison);
        }
    }

    /// Declares a name of the file, once, without shadowing.
    pub(super) fn declare(&mut self, scope: &mut Scope, name: &Name, value: Value) {
        if self.is_free(scope, name) {
            scope.names.insert(name.text.clone(), (value, name.span));
        }
    }

    /// Declares a loop variable, to be released with its [`Scope::mark`].
    pub(super) fn declare_inner(&mut self, scope: &mut Scope, name: &Name, value: Value) {
        if self.is_free(scope, name) {
            scope.names.insert(name.text.clone(), (value, name.span));
            scope.inner.push(name.text.clone());
        }
    }

    fn is_free(&mut self, scope: &Scope, name: &Name) -> bool {
        let Some((_, first)) = scope.entry(&name.text) else { return true };
        self.duplicate(name, first);
        false
    }

    pub(super) fn duplicate(&mut self, name: &Name, first: Span) {
        self.findings.push(
            Finding::error("duplicate-name", name.span, format!("`{}` is declared twice", name.text))
                .label("again")
                .also(first, "first here")
                .note("values have one space of names, and no name hides another")
                .help("choose another name"),
        );
    }

    /// `kind name(params) = value`
    #[expect(clippy::too_many_arguments, reason = "the parts of one statement")]
    fn function_declaration(
        &mut self,
        module: &Module,
        scope: &mut Scope,
        (kind, span): (Kind, Span),
        name: Option<&Name>,
        params: &[syntax::Param],
        value: &Expr,
        with: Option<&Expr>,
    ) {
        let good = matches!(kind, Kind::Let | Kind::Material | Kind::Mesh | Kind::Texture) && with.is_none();
        let Some(name) = name.filter(|_| good) else {
            self.findings.push(
                Finding::error("misplaced-parameters", span, format!("a {} takes no parameters", kind.word()))
                    .note("`let`, `material`, `mesh` and `texture` can be functions"),
            );
            self.poison(scope, name);
            return;
        };
        let made = self.function(scope, kind, name, params, value).unwrap_or(Value::Poison);
        if module.depth > 0 { self.declare_inner(scope, name, made) } else { self.declare(scope, name, made) }
    }

    fn header(&mut self, module: &mut Module, scope: &mut Scope, name: &Name, fields: &[syntax::Field], doc: &str) {
        if let Some(first) = &module.header {
            self.findings.push(
                Finding::error("misplaced-statement", name.span, "a file has one scene")
                    .label("again")
                    .also(first.name.span, "first here"),
            );
            return;
        }
        let mut values = Vec::new();
        for field in fields {
            if let Ok(value) = self.eval(scope, &field.value, None) {
                values.push((field.name.clone(), value, field.value.clone()));
            }
        }
        module.header = Some(Header { name: name.clone(), doc: doc.to_owned(), fields: values });
    }

    fn use_names(&mut self, scope: &mut Scope, names: &[(Name, Option<Name>)], path: &Name) {
        let library = self.library(path);
        for (name, alias) in names {
            let local = alias.as_ref().unwrap_or(name);
            let found = match &library {
                None => Some(Value::Poison),
                Some(library) => library.get(&name.text).map(|(value, _)| value.clone()),
            };
            if found.is_none() {
                let known = library.iter().flat_map(|names| names.keys().map(String::as_str));
                let similar = if self.suggests() { nearest(&name.text, known) } else { None };
                let similar = similar.map(|name| format!("did you mean `{name}`?"));
                self.findings.push(
                    Finding::error("unknown-name", name.span, format!("`{}` declares no `{}`", path.text, name.text))
                        .label("not in that file")
                        .maybe_help(similar),
                );
            }
            self.declare(scope, local, found.unwrap_or(Value::Poison));
        }
    }

    /// The names of the library at `path`; none if that has been reported.
    fn library(&mut self, path: &Name) -> Option<Rc<Names>> {
        let from = self.loading.last().map_or(String::new(), |from| from.folder().to_owned());
        let resolved = match VPath::resolve(&from, &path.text) {
            Ok(resolved) => resolved,
            Err(error) => {
                self.findings.push(path_problem(path.span, &error));
                return None;
            }
        };
        if let Some(known) = self.modules.get(&resolved) {
            return known.clone();
        }
        if let Some(at) = self.loading.iter().position(|loading| *loading == resolved) {
            let mut way: Vec<String> = self.loading[at..].iter().map(|path| format!("`{path}`")).collect();
            way.push(format!("`{resolved}`"));
            self.findings.push(
                Finding::error("use-cycle", path.span, "files use each other in a circle")
                    .label("leads back to a file that is being read")
                    .note(way.join(" uses "))
                    .help("move what both need to a third file"),
            );
            return None;
        }
        let file = match self.load(&resolved) {
            Ok(file) => file,
            Err(problem) => {
                self.findings.push(Finding { origin: path.span.into(), ..*problem });
                self.modules.insert(resolved, None);
                return None;
            }
        };
        let before = self.findings.len();
        self.loading.push(resolved.clone());
        let module = self.file(file);
        self.loading.pop();
        for finding in self.findings[before..].iter_mut().filter(|found| found.severity == Severity::Error) {
            finding.labels.push(Label { span: path.span, text: "used here".to_owned() });
        }
        if let Some(header) = &module.header {
            self.findings.push(
                Finding::error(
                    "misplaced-statement",
                    path.span,
                    format!("`{resolved}` is a scene, and only libraries can be used"),
                )
                .also(header.name.span, "this makes it a scene")
                .help("move what both need to a file without `scene`"),
            );
        } else {
            self.library_only(&module);
        }
        let Module { names, imported, .. } = module;
        let own = names.into_iter().filter(|(name, _)| !imported.contains(name)).collect();
        let names = Rc::new(own);
        self.modules.insert(resolved, Some(Rc::clone(&names)));
        Some(names)
    }

    /// Libraries hold values only.
    fn library_only(&mut self, module: &Module) {
        let items = module.items.iter().map(|item| (item.span, "shapes and emitters"));
        let lights = module.lights.iter().map(|light| (light.span, "shapes and emitters"));
        let instances = module.instances.iter().map(|instance| (instance.span, "instances"));
        let cameras = module.cameras.iter().map(|(_, _, span)| (*span, "cameras"));
        let film = module.film.iter().map(|(_, span)| (*span, "films"));
        let integrator = module.integrator.iter().map(|(_, span)| (*span, "integrators"));
        let sampler = module.sampler.iter().map(|(_, span)| (*span, "samplers"));
        let all: Vec<(Span, &str)> =
            items.chain(lights).chain(instances).chain(cameras).chain(film).chain(integrator).chain(sampler).collect();
        for (span, what) in all {
            self.findings.push(
                Finding::error("misplaced-statement", span, format!("a library has no {what}"))
                    .help("move it to the scene, or give the library a `scene` header"),
            );
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one statement")]
    fn declaration(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        kind: Kind,
        name: Option<&Name>,
        value: &Expr,
        with: Option<&Expr>,
        span: Span,
    ) {
        let named = match kind {
            Kind::Film | Kind::Integrator | Kind::Sampler => {
                if let Some(name) = name {
                    self.findings.push(
                        Finding::error("misplaced-name", name.span, format!("a {} has no name", kind.word()))
                            .help(format!("write `{} = ...`", kind.word())),
                    );
                }
                false
            }
            Kind::Camera => false,
            Kind::Let
            | Kind::Material
            | Kind::Mesh
            | Kind::Texture
            | Kind::Group
            | Kind::Shape
            | Kind::Emitter
            | Kind::Instance => true,
        };
        if named && name.is_none() {
            let word = kind.word();
            self.findings.push(
                Finding::error(
                    "missing-name",
                    Span { end: span.start + word.len() as u32, ..span },
                    format!("a {word} needs a name"),
                )
                .help(format!("write `{word} name = ...`")),
            );
        }
        if let Some(with) = with
            && !matches!(kind, Kind::Shape | Kind::Emitter)
        {
            self.findings.push(
                Finding::error("misplaced-with", with.span, format!("`{}` takes no `with`", kind.word()))
                    .note("`with` gives a shape its material, and an emitter its radiance"),
            );
            return;
        }
        match kind {
            Kind::Let | Kind::Material | Kind::Mesh | Kind::Texture | Kind::Group => {
                self.value_declaration(module, scope, kind, name, value)
            }
            Kind::Shape | Kind::Emitter => self.item(module, scope, kind, name, value, with, span),
            Kind::Camera | Kind::Film | Kind::Integrator | Kind::Sampler => {
                self.setting(module, scope, kind, name, value, span)
            }
            Kind::Instance => self.instance(module, scope, name, value, span),
        }
    }

    fn value_declaration(&mut self, module: &Module, scope: &mut Scope, kind: Kind, name: Option<&Name>, value: &Expr) {
        let family = match kind {
            Kind::Material => Some(Family::Material),
            Kind::Mesh => Some(Family::Mesh),
            Kind::Group => Some(Family::Group),
            Kind::Texture => Some(Family::Texture),
            _ => None,
        };
        let evaluated = self.eval(scope, value, family).and_then(|found| match (kind, found) {
            (Kind::Material, Value::Material(material)) => {
                let own = name.map(|name| name.text.clone());
                Ok(Value::Material(Rc::new(MaterialValue { name: own, span: value.span, ..(*material).clone() })))
            }
            (Kind::Mesh, Value::Mesh(mesh)) => Ok(Value::Mesh(items::rename(mesh, name))),
            (Kind::Group, Value::Group(group)) => Ok(Value::Group(group)),
            (Kind::Texture, Value::Texture(texture)) => Ok(Value::Texture(self.renamed(texture, name, value.span))),
            (Kind::Let, found) => Ok(found),
            (_, found) => self.wrong_kind(kind, value.span, &found),
        });
        if let Some(name) = name {
            let made = evaluated.unwrap_or(Value::Poison);
            // What a loop declares is gone behind its iteration.
            if module.depth > 0 { self.declare_inner(scope, name, made) } else { self.declare(scope, name, made) }
        }
    }

    /// A texture takes the name of its declaration; the image stays one.
    pub(super) fn renamed(&mut self, texture: Handle<Texture>, name: Option<&Name>, span: Span) -> Handle<Texture> {
        let Some(name) = name else { return texture };
        let renamed = Texture { name: name.text.clone(), ..self.textures[texture].clone() };
        self.textures.push(renamed, span)
    }

    pub(super) fn wrong_kind<T>(&mut self, kind: Kind, span: Span, found: &Value) -> Result<T, Reported> {
        let article = if kind.word().starts_with(['a', 'e', 'i']) { "an" } else { "a" };
        self.report(
            Finding::error(
                "type-mismatch",
                span,
                format!("`{}` declares {article} {}, not {}", kind.word(), kind.word(), found.kind()),
            )
            .label(found.kind()),
        )
    }
}

/// What a text is that was pasted into a scene file from another format; none for what may be a scene.
fn foreign_text(text: &str) -> Option<&'static str> {
    let start = text.trim_start_matches('\u{feff}').trim_start();
    let python = |line: &str| {
        line.starts_with("import ") && !line.contains('"') || line.starts_with("from ") && line.contains(" import ")
    };
    match start.as_bytes().first()? {
        b'<' => Some("XML"),
        b'{' => Some("JSON"),
        b'#' if start.starts_with("#!") => Some("a program"),
        _ if start.lines().next().is_some_and(python) => Some("a program in Python"),
        _ => None,
    }
}

/// A finding about a path as it is written.
pub(super) fn path_problem(span: Span, error: &PathError) -> Finding {
    let finding = Finding::error("bad-path", span, error.to_string()).label("this path");
    match error {
        PathError::Backslash => finding.help("write `/` between folders: that works on every system"),
        PathError::Absolute => finding.help("write the path from the folder of this file"),
        PathError::Outside => finding
            .note("a scene reads only files below its project's root, so that it can be moved and shared")
            .help("move the file into the project, or put an `ltsc.toml` into a folder further up"),
        PathError::Empty => finding.help("name a file"),
        PathError::Control => finding,
    }
}

/// A finding about a file that cannot be read, without a place.
fn read_problem(path: &VPath, error: &ReadError) -> Finding {
    let finding =
        Finding::error("unreadable-file", crate::diag::Origin::Made, format!("`{path}` cannot be read: {error}"));
    finding.maybe_help(beside_help(path, error))
}

/// The name of a file in the same folder that may have been meant.
pub(super) fn beside_help(path: &VPath, error: &ReadError) -> Option<String> {
    match error {
        ReadError::Missing { beside } => {
            nearest(path.name(), beside.iter().map(String::as_str)).map(|name| format!("did you mean `{name}`?"))
        }
        ReadError::Outside | ReadError::TooLarge { .. } | ReadError::Other(_) => None,
    }
}
