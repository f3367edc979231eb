//! Functions and groups: declarations with parameters. A function sees what its file declares above it; there is no recursion.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::diag::{Finding, Severity, Span, nearest};
use crate::ir::{Affine, Places};
use crate::syntax::{Call, Clause, Expr, ExprKind, Kind, Name, Param, Statement, StatementKind, Type};

use super::items::GroupBody;
use super::module::{Module, Scope};
use super::numeric::Program;
use super::table::{self, Family};
use super::value::{GroupValue, MaterialValue, Ty, Value};
use super::work::HOLD_DEPTH;
use super::{Interpreter, Reported, TRAIL};

/// How deep calls of functions may nest.
const CALL_DEPTH: usize = 128;

/// A function with everything that its body names.
#[derive(Debug)]
pub(super) struct Function {
    pub name: String,
    kind: Kind,
    params: Vec<Parameter>,
    body: Body,
    /// Values of the names that the body may use and that are no parameters.
    captured: BTreeMap<String, Value>,
    span: Span,
    /// Groups that calls have made, by their arguments: equal calls are one group.
    made: RefCell<BTreeMap<u128, Value>>,
    /// How deep functions and lists lie within each other in what the body names.
    depth: usize,
    /// The translated body, made at the first call; none where it does more than compute with numbers.
    program: OnceCell<Option<Program>>,
}

/// What a function is made of.
#[derive(Debug)]
enum Body {
    Value(Expr),
    Group(Vec<Statement>),
}

#[derive(Debug)]
struct Parameter {
    name: Name,
    ty: Typed,
    default: Option<Value>,
}

/// A type as a parameter declares it.
#[derive(Clone, Debug)]
pub(super) struct Typed {
    of: Element,
    lists: usize,
}

#[derive(Clone, Copy, Debug)]
enum Element {
    Table(Ty),
    Vec2,
    Range,
}

/// Why a value is not of a type.
enum Unfit {
    /// It is of another one.
    Type,
    /// It is too large to be looked at, which has been reported.
    Reported,
}

/// The words for types.
const TYPES: [&str; 10] = ["number", "angle", "bool", "string", "color", "vec2", "vec3", "range", "material", "mesh"];

impl Typed {
    /// The type that is written.
    pub(super) fn new(interpreter: &mut Interpreter<'_>, ty: &Type) -> Result<Self, Reported> {
        let of = match ty.name.text.as_str() {
            "number" => Element::Table(Ty::Number),
            "angle" => Element::Table(Ty::Angle),
            "bool" => Element::Table(Ty::Bool),
            "string" => Element::Table(Ty::String),
            "color" => Element::Table(Ty::Color),
            "vec2" => Element::Vec2,
            "vec3" => Element::Table(Ty::Vec3),
            "range" => Element::Range,
            "material" => Element::Table(Ty::Material),
            "mesh" => Element::Table(Ty::Mesh),
            other => {
                let similar = nearest(other, TYPES).map(|name| format!("did you mean `{name}`?"));
                return interpreter.report(
                    Finding::error("unknown-type", ty.name.span, format!("there is no type `{other}`"))
                        .note(format!("known: {}, and lists of them in brackets", TYPES.join(", ")))
                        .maybe_help(similar),
                );
            }
        };
        Ok(Self { of, lists: ty.lists })
    }

    /// The type in words.
    pub(super) fn words(&self) -> String {
        let element = match self.of {
            Element::Table(ty) => ty.words(),
            Element::Vec2 => "a vector of 2",
            Element::Range => "a range",
        };
        if self.lists == 0 {
            return element.to_owned();
        }
        let word = element.trim_start_matches("an ").trim_start_matches("a ");
        let (first, rest) =
            word.split_once(' ').map_or((word, String::new()), |(first, rest)| (first, format!(" {rest}")));
        format!("{}a list of {first}s{rest}", "a list of lists: ".repeat(self.lists - 1))
    }

    /// Whether it is a string.
    pub(super) fn is_string(&self) -> bool {
        self.lists == 0 && matches!(self.of, Element::Table(Ty::String))
    }

    fn family(&self) -> Option<Family> {
        match (self.of, self.lists) {
            (Element::Table(Ty::Material), 0) => Some(Family::Material),
            (Element::Table(Ty::Mesh), 0) => Some(Family::Mesh),
            _ => None,
        }
    }

    fn check(&self, interpreter: &mut Interpreter<'_>, value: Value, lists: usize, span: Span) -> Result<Value, Unfit> {
        if lists > 0 {
            let Value::List(items) = &value else { return Err(Unfit::Type) };
            interpreter.spend(items.len() as u64, span).map_err(|Reported| Unfit::Reported)?;
            // What stays as it is stays shared: only numbers that become colors make a new list.
            if lists == 1 && self.keeps(items) {
                return Ok(value);
            }
            let checked: Result<Vec<Value>, Unfit> =
                items.iter().map(|item| self.check(interpreter, item.clone(), lists - 1, span)).collect();
            let checked = checked?;
            if lists > 1 && !matches!(self.of, Element::Table(Ty::Color)) {
                return Ok(value);
            }
            return interpreter.elements(checked, span).map(Value::List).map_err(|Reported| Unfit::Reported);
        }
        match (self.of, value) {
            (Element::Table(ty), value) => ty.accept(value).map_err(|_| Unfit::Type),
            (Element::Vec2, Value::Vector(parts)) if parts.len() == 2 => Ok(Value::Vector(parts)),
            (Element::Range, Value::Range(lo, hi)) => Ok(Value::Range(lo, hi)),
            (Element::Vec2 | Element::Range, _) => Err(Unfit::Type),
        }
    }

    /// Whether all of `items` are of the type of an element and remain as they are.
    fn keeps(&self, items: &[Value]) -> bool {
        items.iter().all(|item| match (self.of, item) {
            (Element::Table(Ty::Number), Value::Number(_))
            | (Element::Table(Ty::Angle), Value::Angle(_))
            | (Element::Table(Ty::Bool), Value::Bool(_))
            | (Element::Table(Ty::String), Value::String(_))
            | (Element::Table(Ty::Color), Value::Color(_))
            | (Element::Table(Ty::Material), Value::Material(_))
            | (Element::Table(Ty::Mesh), Value::Mesh(_))
            | (Element::Range, Value::Range(..)) => true,
            (Element::Table(Ty::Vec3), Value::Vector(parts)) => parts.len() == 3,
            (Element::Vec2, Value::Vector(parts)) => parts.len() == 2,
            _ => false,
        })
    }
}

impl Function {
    /// How deep functions and lists lie within each other, this one included.
    pub(super) fn depth(&self) -> usize {
        self.depth
    }

    /// Whether calls of it are groups.
    pub(super) fn makes_groups(&self) -> bool {
        self.kind == Kind::Group
    }

    /// Its body, the names of its parameters and what else the body names, if it is a function of numbers.
    pub(super) fn numeric(&self) -> Option<(&Expr, Vec<&str>, &BTreeMap<String, Value>)> {
        let Body::Value(body) = &self.body else { return None };
        let names = self.params.iter().map(|param| param.name.text.as_str()).collect();
        self.takes_numbers(self.params.len()).then_some((body, names, &self.captured))
    }

    /// Whether it can be called with as many numbers as `count`.
    pub(super) fn takes_numbers(&self, count: usize) -> bool {
        let number = |param: &Parameter| param.ty.lists == 0 && matches!(param.ty.of, Element::Table(Ty::Number));
        self.kind == Kind::Let && self.params.len() == count && self.params.iter().all(number)
    }
}

impl Interpreter<'_> {
    /// `value` as the type of the parameter `name`.
    pub(super) fn accept(&mut self, ty: &Typed, value: Value, span: Span, name: &str) -> Result<Value, Reported> {
        let kind = value.kind();
        if matches!(value, Value::Poison) {
            return Err(Reported);
        }
        let number = if let Value::Number(n) = &value { Some(*n) } else { None };
        match ty.check(self, value, ty.lists, span) {
            Ok(value) => return Ok(value),
            Err(Unfit::Reported) => return Err(Reported),
            Err(Unfit::Type) => {}
        }
        match (ty.of, number) {
            (Element::Table(Ty::Angle), Some(n)) if ty.lists == 0 => self.report(
                Finding::error("missing-unit", span, format!("`{name}` takes an angle, and this number has no unit"))
                    .label("no unit")
                    .help(super::expr::unit_help(n)),
            ),
            _ => self.report(
                Finding::error("type-mismatch", span, format!("`{name}` takes {}, not {kind}", ty.words())).label(kind),
            ),
        }
    }

    /// The function of `kind name(params) = body`.
    pub(super) fn function(
        &mut self,
        scope: &mut Scope,
        kind: Kind,
        name: &Name,
        params: &[Param],
        body: &Expr,
    ) -> Result<Value, Reported> {
        self.shadows_builtin(name);
        let (made, good) = self.parameters(scope, params);
        let mut names = Free::of(params);
        names.expr(body);
        self.spend(names.parts, name.span)?;
        let (captured, known) = self.capture(scope, name, names);
        let good = good && known;
        if !good {
            return Err(Reported);
        }
        let depth = self.nested(&captured, name.span)?;
        Ok(Value::Function(Rc::new(Function {
            name: name.text.clone(),
            kind,
            params: made,
            body: Body::Value(body.clone()),
            captured,
            span: name.span,
            made: RefCell::default(),
            depth,
            program: OnceCell::new(),
        })))
    }

    /// How deep functions and lists lie within each other in a function that names these values.
    fn nested(&mut self, captured: &BTreeMap<String, Value>, span: Span) -> Result<usize, Reported> {
        let depth = 1 + captured.values().map(Value::depth).max().unwrap_or(0);
        if depth > HOLD_DEPTH {
            let message = format!("functions name each other more than {HOLD_DEPTH} levels deep");
            return self.report(Finding::error("nesting-limit", span, message));
        }
        Ok(depth)
    }

    /// The values of the names that a body uses, and whether all of them are known; those that are not are reported.
    fn capture(&mut self, scope: &Scope, name: &Name, names: Free) -> (BTreeMap<String, Value>, bool) {
        let mut captured = BTreeMap::new();
        let mut good = true;
        for inner in &names.declared {
            if let Some(first) = scope.place(&inner.text) {
                self.duplicate(inner, first);
                good = false;
            }
        }
        for (text, span, called) in names.found {
            if let Some(value) = scope.get(&text) {
                captured.entry(text).or_insert_with(|| value.clone());
            } else if called && table::find(&text, None).is_some()
                || !called && matches!(text.as_str(), "X" | "Y" | "Z" | "PI")
            {
            } else if called && text == name.text {
                self.findings.push(
                    Finding::error("unknown-name", span, format!("the function `{text}` calls itself"))
                        .label("not declared yet")
                        .note("functions see what stands above them, so that every scene ends")
                        .help("write a loop, or a list: `[for i in 0..3: ...]`"),
                );
                good = false;
            } else if called {
                self.unknown_call(scope, &text, span, None);
                good = false;
            } else {
                good &= self.name(scope, &text, span).is_ok();
                let own = names.bound.iter().chain(names.declared.iter().map(|name| &name.text));
                let meant = if self.suggests() { nearest(&text, own.map(String::as_str)) } else { None };
                if let (Some(finding), Some(meant)) = (self.findings.last_mut(), meant)
                    && finding.help.is_none()
                {
                    finding.help = Some(format!("did you mean `{meant}`?"));
                }
            }
        }
        (captured, good)
    }

    /// Says that a function takes the place of a constructor or function of the language, which it may.
    fn shadows_builtin(&mut self, name: &Name) {
        let Some(row) = table::find(&name.text, None) else { return };
        let message = format!("the function `{}` hides the `{}` of the language", name.text, row.name);
        self.findings.push(
            Finding::warn("shadows-builtin", name.span, message)
                .label("calls below mean this one")
                .note("it is allowed, so that later versions of the language can add names")
                .help("choose another name if that is not meant"),
        );
    }

    /// The parameters of a function, and whether all of them are good.
    fn parameters(&mut self, scope: &mut Scope, params: &[Param]) -> (Vec<Parameter>, bool) {
        let mut made = Vec::new();
        let mut seen = BTreeMap::new();
        let mut good = true;
        for param in params {
            let twin = seen.insert(param.name.text.as_str(), param.name.span);
            if let Some(first) = twin.or_else(|| scope.place(&param.name.text)) {
                self.duplicate(&param.name, first);
                good = false;
                continue;
            }
            let ty = Typed::new(self, &param.ty);
            let default = param
                .default
                .as_ref()
                .map(|default| self.eval(scope, default, None).map(|value| (value, default.span)));
            let Ok(ty) = ty else {
                good = false;
                continue;
            };
            let default = match default {
                None => None,
                Some(Ok((value, span))) => self.accept(&ty, value, span, &param.name.text).ok(),
                Some(Err(Reported)) => None,
            };
            good &= default.is_some() == param.default.is_some();
            made.push(Parameter { name: param.name.clone(), ty, default });
        }
        (made, good)
    }

    /// The value of `group name(params) { statements }`: a group, or with parameters a function that makes groups.
    pub(super) fn group(
        &mut self,
        scope: &mut Scope,
        name: &Name,
        params: &[Param],
        body: &[Statement],
    ) -> Result<Value, Reported> {
        self.shadows_builtin(name);
        let (made, mut good) = self.parameters(scope, params);
        let mut captured = BTreeMap::new();
        let mut names = Free::of(params);
        names.statements(body);
        self.spend(names.parts, name.span)?;
        // A group without parameters is evaluated here and now, where its names can be seen.
        if !params.is_empty() {
            let known;
            (captured, known) = self.capture(scope, name, names);
            good &= known;
        }
        if !good {
            return Err(Reported);
        }
        let depth = self.nested(&captured, name.span)?;
        let function = Function {
            name: name.text.clone(),
            kind: Kind::Group,
            params: made,
            body: Body::Group(body.to_vec()),
            captured,
            span: name.span,
            made: RefCell::default(),
            depth,
            program: OnceCell::new(),
        };
        if params.is_empty() { self.group_items(scope, &function) } else { Ok(Value::Function(Rc::new(function))) }
    }

    /// Evaluates the statements of a group, whose names `scope` has.
    fn group_items(&mut self, scope: &mut Scope, function: &Function) -> Result<Value, Reported> {
        let Body::Group(body) = &function.body else { return Err(Reported) };
        let mut module = Module { depth: 1, group: true, ..Module::default() };
        let before = self.findings.len();
        self.block(&mut module, scope, body);
        if self.findings[before..].iter().any(|finding| finding.severity == Severity::Error) {
            return Err(Reported);
        }
        let Module { items, lights, instances, size, group_depth, .. } = module;
        let lit = !lights.is_empty() || instances.iter().any(|placed| placed.group.body.lit);
        let (name, span) = (function.name.clone(), function.span);
        let body = GroupBody { name, span, items, lights, instances, size, depth: group_depth.max(1), lit };
        Ok(Value::Group(GroupValue { body: Rc::new(body), places: Places::One(Affine::IDENTITY) }))
    }

    /// The names that the body of a function sees.
    fn inner_scope(function: &Function, values: &[Value]) -> Scope {
        let mut inner = Scope::default();
        for (name, value) in &function.captured {
            inner.insert(name, value.clone(), function.span);
        }
        for (param, value) in function.params.iter().zip(values) {
            inner.insert(&param.name.text, value.clone(), param.name.span);
        }
        inner
    }

    /// Calls a user's function; errors in its body point back to the call.
    pub(super) fn call_function(
        &mut self,
        scope: &mut Scope,
        call: &Call,
        function: &Rc<Function>,
    ) -> Result<Value, Reported> {
        self.step(call.span)?;
        let values = self.bind_function(scope, call, function)?;
        self.invoke(function, &values, call.span)
    }

    /// The numbers that a function has at many places, each of them a call that counts a step; none where it is to be called for
    /// one after the other, which says what is wrong and where.
    pub(super) fn invoke_many<const N: usize>(
        &mut self,
        function: &Rc<Function>,
        places: &[[f64; N]],
    ) -> Option<Vec<f64>> {
        if self.call_depth >= CALL_DEPTH || function.params.len() != N {
            return None;
        }
        let mut steps = self.steps + places.len() as u64;
        let program = self.program(function, places.len())?;
        let results = program.run_many(places, &mut steps)?;
        (steps <= self.limits.steps).then(|| {
            self.steps = steps;
            results
        })
    }

    /// The translated body of a function, to be run `times`, if that can be afforded; it counts as work here.
    fn program<'a>(&mut self, function: &'a Function, times: usize) -> Option<&'a Program> {
        let program = function.program.get_or_init(|| Program::of(function)).as_ref()?;
        let units = program.units().saturating_mul(times as u64);
        if !self.affords(units) {
            return None;
        }
        self.spend(units, function.span).ok()?;
        Some(program)
    }

    /// The value of a function's body for the parameters' values; `call` is where it is called.
    pub(super) fn invoke(&mut self, function: &Rc<Function>, values: &[Value], call: Span) -> Result<Value, Reported> {
        if self.call_depth >= CALL_DEPTH {
            return self.report(Finding::error(
                "nesting-limit",
                call,
                format!("functions call each other more than {CALL_DEPTH} levels deep"),
            ));
        }
        if let Some(program) = self.program(function, 1) {
            let mut steps = self.steps;
            let result = program.run(values, &mut steps);
            if let Some(result) = result.filter(|_| steps <= self.limits.steps) {
                self.steps = steps;
                return Ok(result);
            }
        }
        let family = match function.kind {
            Kind::Material => Some(Family::Material),
            Kind::Mesh => Some(Family::Mesh),
            Kind::Texture => Some(Family::Texture),
            _ => None,
        };
        self.spend(function.captured.len() as u64, call)?;
        let key = if matches!(function.body, Body::Group(_)) { self.fingerprint(values, call)? } else { 0 };
        let before = self.findings.len();
        self.call_depth += 1;
        let made = match &function.body {
            Body::Value(body) => {
                let mut inner = Self::inner_scope(function, values);
                self.eval(&mut inner, body, family).map(|value| (value, body.span))
            }
            Body::Group(_) => {
                let known = function.made.borrow().get(&key).cloned();
                let group =
                    known.map_or_else(|| self.group_items(&mut Self::inner_scope(function, values), function), Ok);
                if let Ok(group) = &group {
                    function.made.borrow_mut().insert(key, group.clone());
                }
                group.map(|value| (value, function.span))
            }
        };
        self.call_depth -= 1;
        let made = made.and_then(|(value, span)| match (function.kind, value) {
            (Kind::Material, Value::Material(material)) => {
                // Equal calls make one material: it is known by the function's name.
                let name = Some(function.name.clone());
                Ok(Value::Material(Rc::new(MaterialValue { name, span: call, ..(*material).clone() })))
            }
            (Kind::Material | Kind::Mesh | Kind::Texture, value)
                if !matches!(
                    (function.kind, &value),
                    (Kind::Mesh, Value::Mesh(_)) | (Kind::Texture, Value::Texture(_))
                ) =>
            {
                self.wrong_kind(function.kind, span, &value)
            }
            (_, value) => Ok(value),
        });
        for finding in self.findings[before..].iter_mut().filter(|finding| finding.severity == Severity::Error) {
            if finding.labels.len() < TRAIL {
                let text = format!("in this call of `{}`", function.name);
                finding.labels.push(crate::diag::Label { span: call, text });
            }
        }
        made
    }

    fn bind_function(&mut self, scope: &mut Scope, call: &Call, function: &Function) -> Result<Vec<Value>, Reported> {
        let mut given: Vec<Option<(Value, Span)>> = function.params.iter().map(|_| None).collect();
        let mut good = true;
        let mut next = 0;
        let piped = call.piped.iter().map(|value| (None, value));
        for (label, value) in piped.chain(call.args.iter().map(|arg| (arg.label.as_ref(), &arg.value))) {
            let at = match label {
                Some(label) => {
                    self.spend(function.params.len() as u64, label.span)?;
                    function.params.iter().position(|param| param.name.text == label.text)
                }
                None => {
                    next += 1;
                    Some(next - 1).filter(|at| *at < function.params.len())
                }
            };
            let Some(at) = at else {
                let names: Vec<&str> = function.params.iter().map(|param| param.name.text.as_str()).collect();
                let finding = match label {
                    Some(label) => {
                        let similar = nearest(&label.text, names.iter().copied());
                        Finding::error(
                            "unknown-argument",
                            label.span,
                            format!("`{}` has no argument `{}`", function.name, label.text),
                        )
                        .maybe_help(similar.map(|name| format!("did you mean `{name}`?")))
                    }
                    None => Finding::error(
                        "unknown-argument",
                        value.span,
                        format!("`{}` takes fewer arguments", function.name),
                    )
                    .label("one too many"),
                };
                self.findings.push(
                    finding
                        .note(format!("it is `{}({})`", function.name, names.join(", ")))
                        .also(function.span, "declared here"),
                );
                good = false;
                continue;
            };
            if let Some((_, first)) = &given[at] {
                let message = format!("`{}` is given twice", function.params[at].name.text);
                self.findings.push(
                    Finding::error("unknown-argument", value.span, message).label("again").also(*first, "first here"),
                );
                good = false;
                continue;
            }
            let param = &function.params[at];
            let made = self.eval(scope, value, param.ty.family());
            let accepted = made.and_then(|found| {
                self.accept(&param.ty, found, value.span, &param.name.text).inspect_err(|Reported| {
                    let labels = self.findings.last_mut().map(|finding| &mut finding.labels);
                    if let Some(labels) = labels.filter(|labels| labels.is_empty()) {
                        let text = format!("the parameter is declared here: {}", param.ty.words());
                        labels.push(crate::diag::Label { span: param.name.span, text });
                    }
                })
            });
            match accepted {
                Ok(found) => given[at] = Some((found, value.span)),
                Err(Reported) => good = false,
            }
        }
        let mut values = Vec::new();
        for (param, given) in function.params.iter().zip(given) {
            match given.map(|(value, _)| value).or_else(|| param.default.clone()) {
                Some(value) => values.push(value),
                None if good => {
                    let message = format!("`{}` needs `{}`", function.name, param.name.text);
                    self.findings.push(
                        Finding::error("missing-argument", call.name.span, message)
                            .label(format!("`{}` is missing: {}", param.name.text, param.ty.words()))
                            .also(param.name.span, "declared here"),
                    );
                    good = false;
                }
                None => {}
            }
        }
        if good { Ok(values) } else { Err(Reported) }
    }
}

/// Finds the names of an expression that nothing in it binds.
#[derive(Default)]
struct Free {
    /// Name, place, and whether it is called.
    found: Vec<(String, Span, bool)>,
    bound: Vec<String>,
    /// How often each of them is bound.
    counts: BTreeMap<String, usize>,
    /// How many expressions and statements were looked at.
    parts: u64,
    /// The names that are bound within, parameters aside.
    declared: Vec<Name>,
}

impl Free {
    fn of(params: &[Param]) -> Self {
        let mut names = Self::default();
        params.iter().for_each(|param| names.bind_text(&param.name.text));
        names
    }

    /// The statements of a group: what they declare is bound behind its declaration.
    fn statements(&mut self, body: &[Statement]) {
        let before = self.bound.len();
        for statement in body {
            self.parts += 1;
            match &statement.kind {
                StatementKind::Declaration { kind, name, params, value, with } => {
                    let outside = self.bound.len();
                    for param in params.iter().flatten() {
                        param.default.iter().for_each(|default| self.expr(default));
                        self.bind_text(&param.name.text);
                    }
                    self.expr(value);
                    with.iter().for_each(|with| self.expr(with));
                    self.release(outside);
                    let values = [Kind::Let, Kind::Material, Kind::Mesh, Kind::Texture, Kind::Group];
                    name.iter().filter(|_| values.contains(kind)).for_each(|name| self.bind(name));
                }
                StatementKind::Group { name, params, body } => {
                    let outside = self.bound.len();
                    for param in params {
                        param.default.iter().for_each(|default| self.expr(default));
                        self.bind_text(&param.name.text);
                    }
                    self.statements(body);
                    self.release(outside);
                    self.bind(name);
                }
                StatementKind::For { clauses, body } => {
                    let outside = self.bound.len();
                    self.clauses(clauses);
                    self.statements(body);
                    self.release(outside);
                }
                StatementKind::If { branches, otherwise } => {
                    for (condition, body) in branches {
                        self.expr(condition);
                        self.statements(body);
                    }
                    self.statements(otherwise);
                }
                // They stand at the top of a file, and are reported where they do not.
                StatementKind::Version(_)
                | StatementKind::Scene { .. }
                | StatementKind::Use { .. }
                | StatementKind::Parameter { .. }
                | StatementKind::Allow { .. } => {}
            }
        }
        self.release(before);
    }

    fn clauses(&mut self, clauses: &[Clause]) {
        for clause in clauses {
            self.expr(&clause.over);
            clause.names.iter().for_each(|name| self.bind(name));
        }
    }

    fn bind_text(&mut self, text: &str) {
        self.bound.push(text.to_owned());
        *self.counts.entry(text.to_owned()).or_default() += 1;
    }

    /// Forgets the names that were bound since there were `before`.
    fn release(&mut self, before: usize) {
        for name in self.bound.drain(before..) {
            if let Some(count) = self.counts.get_mut(&name) {
                *count -= 1;
                if *count == 0 {
                    self.counts.remove(&name);
                }
            }
        }
    }

    fn bind(&mut self, name: &Name) {
        self.bind_text(&name.text);
        self.declared.push(name.clone());
    }

    fn name(&mut self, text: &str, span: Span, called: bool) {
        if !self.counts.contains_key(text) {
            self.found.push((text.to_owned(), span, called));
        }
    }

    fn expr(&mut self, expr: &Expr) {
        self.parts += 1;
        match &expr.kind {
            ExprKind::Number(_) | ExprKind::Unit(..) | ExprKind::String(_) | ExprKind::Bool(_) | ExprKind::Row(_) => {}
            ExprKind::Name(text) => self.name(text, expr.span, false),
            ExprKind::Tuple(parts) | ExprKind::List(parts) => parts.iter().for_each(|part| self.expr(part)),
            ExprKind::Comprehension(clauses, body) => self.comprehension(clauses, body),
            ExprKind::Call(call) => {
                self.name(&call.name.text, call.name.span, true);
                call.piped.iter().chain(call.args.iter().map(|arg| &arg.value)).for_each(|part| self.expr(part));
            }
            ExprKind::Unary(_, of) | ExprKind::Member(of, _) => self.expr(of),
            ExprKind::Binary(_, _, both) | ExprKind::Index(both) => {
                self.expr(&both.0);
                self.expr(&both.1);
            }
            ExprKind::If(parts) => {
                self.expr(&parts.0);
                self.expr(&parts.1);
                self.expr(&parts.2);
            }
        }
    }

    fn comprehension(&mut self, clauses: &[Clause], body: &Expr) {
        let before = self.bound.len();
        self.clauses(clauses);
        self.expr(body);
        self.release(before);
    }
}
