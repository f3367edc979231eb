//! Expressions and calls.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use crate::diag::{Finding, Span, nearest};
use crate::files::{Bytes, ReadError, VPath};
use crate::ir::{Affine, Handle, LightKind, Texture};
use crate::syntax::{Call, Expr, ExprKind};

use super::function::Function;
use super::module::Scope;
use super::ops;
use super::synonyms;
use super::table::{self, Args, Constructor, Family, Site};
use super::value::{MeshValue, Refusal, Ty, Value};
use super::{Interpreter, Limit, Reported};

impl Interpreter<'_> {
    /// Whether names that may be meant are still looked for: not behind a thousand findings, each of which would compare with
    /// every name of a long text.
    pub(super) fn suggests(&self) -> bool {
        self.findings.len() < 1000
    }

    pub(super) fn report<T>(&mut self, finding: Finding) -> Result<T, Reported> {
        self.findings.push(finding);
        Err(Reported)
    }

    /// The value of `expr`; `wanted` is what its place asks for and tells constructors of the same name apart.
    pub(super) fn eval(&mut self, scope: &mut Scope, expr: &Expr, wanted: Option<Family>) -> Result<Value, Reported> {
        let wrong = |wrong: ops::Wrong, span: Span| {
            Finding::error("invalid-operation", span, wrong.message).maybe_help(wrong.help)
        };
        self.spend(1, expr.span)?;
        match &expr.kind {
            ExprKind::Number(n) => Ok(Value::Number(*n)),
            ExprKind::Unit(n, unit) => match unit.as_str() {
                "deg" => Ok(Value::Angle(*n)),
                "rad" => Ok(Value::Angle(n.to_degrees())),
                _ => self.report(
                    Finding::error("unknown-unit", expr.span, format!("there is no unit `{unit}`"))
                        .note("angles have units, lengths are scene units, radiance is W/(m2 sr)")
                        .help("write `deg` or `rad` for an angle, and no unit elsewhere"),
                ),
            },
            ExprKind::String(text) => {
                self.spend(text.len() as u64, expr.span)?;
                Ok(Value::String(Rc::from(text.as_str())))
            }
            ExprKind::Bool(value) => Ok(Value::Bool(*value)),
            ExprKind::Name(name) => self.name(scope, name, expr.span),
            ExprKind::Row(numbers) => self.numbers_value(numbers, expr.span),
            ExprKind::Tuple(parts) => {
                let values = self.all(scope, parts)?;
                self.tuple_value(values, expr.span)
            }
            ExprKind::List(parts) => {
                let values = self.all(scope, parts)?;
                self.list(values, expr.span)
            }
            ExprKind::Comprehension(clauses, body) => {
                let mut values = Vec::new();
                let span = expr.span;
                self.each(scope, clauses, &mut Vec::new(), &mut |this, scope, _| {
                    values.push(this.eval(scope, body, None)?);
                    if values.len() > this.limits.list {
                        return this.too_long(values.len(), span);
                    }
                    Ok(())
                })?;
                Ok(Value::List(self.elements(values, span)?))
            }
            ExprKind::Call(call) => self.call(scope, call, wanted),
            ExprKind::Unary(operator, operand) => {
                let value = self.eval(scope, operand, None)?;
                ops::unary(*operator, &value).or_else(|problem| self.report(wrong(problem, expr.span)))
            }
            ExprKind::Binary(operator, sign, operands) => {
                // Both sides are looked at even if the first is wrong: their errors come in one run.
                let left = self.eval(scope, &operands.0, None);
                let right = self.eval(scope, &operands.1, None);
                let (left, right) = (left?, right?);
                let mut over = self.left();
                let before = over;
                let made = ops::binary(*operator, &left, &right, &mut over);
                let parts = ops::parts(&left) + ops::parts(&right);
                // Where nothing is left, the values are too large to be compared.
                self.spend(if over == 0 { u64::MAX } else { before - over + parts }, *sign)?;
                if parts > 0 {
                    self.hold(parts * size_of::<[f64; 2]>() as u64, *sign)?;
                }
                made.or_else(|problem| {
                    let finding =
                        wrong(problem, *sign).also(operands.0.span, left.kind()).also(operands.1.span, right.kind());
                    self.report(finding)
                })
            }
            ExprKind::Index(both) => self.index(scope, &both.0, &both.1),
            ExprKind::Member(of, member) => {
                let value = self.eval(scope, of, None)?;
                let at = ["x", "y", "z"].iter().position(|name| *name == member.text);
                match (&value, at) {
                    (Value::Vector(parts), Some(at)) if at < parts.len() => Ok(Value::Number(parts[at])),
                    _ => self.report(
                        Finding::error(
                            "unknown-member",
                            member.span,
                            format!("{} has no member `{}`", value.kind(), member.text),
                        )
                        .note("vectors have `.x`, `.y` and, from three parts on, `.z`"),
                    ),
                }
            }
            ExprKind::If(parts) => match self.eval(scope, &parts.0, None)? {
                Value::Bool(true) => self.eval(scope, &parts.1, wanted),
                Value::Bool(false) => self.eval(scope, &parts.2, wanted),
                other => self.report(
                    Finding::error(
                        "type-mismatch",
                        parts.0.span,
                        format!("a condition is true or false, not {}", other.kind()),
                    )
                    .label(other.kind()),
                ),
            },
        }
    }

    fn all(&mut self, scope: &mut Scope, parts: &[Expr]) -> Result<Vec<Value>, Reported> {
        let values: Vec<Result<Value, Reported>> = parts.iter().map(|part| self.eval(scope, part, None)).collect();
        values.into_iter().collect()
    }

    fn list(&mut self, values: Vec<Value>, span: Span) -> Result<Value, Reported> {
        if values.len() > self.limits.list {
            self.too_long(values.len(), span)?;
        }
        Ok(Value::List(self.elements(values, span)?))
    }

    fn numbers_value(&mut self, numbers: &[f64], span: Span) -> Result<Value, Reported> {
        if (2..=4).contains(&numbers.len()) {
            return Ok(Value::Vector(numbers.into()));
        }
        let values = numbers.iter().map(|number| Value::Number(*number)).collect();
        Ok(Value::Tuple(self.elements(values, span)?))
    }

    fn tuple_value(&mut self, values: Vec<Value>, span: Span) -> Result<Value, Reported> {
        let numbers: Option<Vec<f64>> =
            values.iter().map(|value| if let Value::Number(n) = value { Some(*n) } else { None }).collect();
        match numbers {
            Some(numbers) if (2..=4).contains(&numbers.len()) => Ok(Value::Vector(numbers.into())),
            _ => Ok(Value::Tuple(self.elements(values, span)?)),
        }
    }

    fn too_long(&mut self, count: usize, span: Span) -> Result<(), Reported> {
        self.report(
            Finding::error("list-limit", span, format!("a list has {count} elements or more"))
                .note(format!("at most {} are allowed", self.limits.list))
                .help(Limit::help("list")),
        )
    }

    fn index(&mut self, scope: &mut Scope, of: &Expr, at: &Expr) -> Result<Value, Reported> {
        let (list, index) = (self.eval(scope, of, None), self.eval(scope, at, None));
        match (list?, index?) {
            (Value::List(items), Value::Number(n)) => {
                let found = (n.fract() == 0.0 && n >= 0.0).then_some(n as usize).and_then(|n| items.get(n));
                match found {
                    Some(item) => Ok(item.clone()),
                    None => self.report(
                        Finding::error("index-out-of-range", at.span, format!("the list has no element {n}"))
                            .label(format!("elements are 0..{}", items.len() as i64 - 1)),
                    ),
                }
            }
            (Value::List(items), Value::Range(lo, hi)) => {
                let good = lo.fract() == 0.0 && hi.fract() == 0.0 && lo >= 0.0 && hi >= lo && hi < items.len() as f64;
                if good {
                    return Ok(Value::List(items.slice(lo as usize..=hi as usize)));
                }
                self.report(
                    Finding::error("index-out-of-range", at.span, format!("the list has no elements {lo}..{hi}"))
                        .label(format!("elements are 0..{}", items.len() as i64 - 1)),
                )
            }
            (list, index) => {
                let message = format!("{} cannot be indexed by {}", list.kind(), index.kind());
                self.report(Finding::error("type-mismatch", of.span.to(at.span), message))
            }
        }
    }

    pub(super) fn name(&mut self, scope: &Scope, name: &str, span: Span) -> Result<Value, Reported> {
        match scope.get(name) {
            Some(Value::Poison) => return Err(Reported),
            Some(value) => return Ok(value.clone()),
            None => {}
        }
        let unit = |axis: usize| {
            let mut parts = [0.0; 3];
            parts[axis] = 1.0;
            Ok(Value::Vector(Rc::new(parts)))
        };
        match name {
            "X" => return unit(0),
            "Y" => return unit(1),
            "Z" => return unit(2),
            "PI" => return Ok(Value::Number(std::f64::consts::PI)),
            _ => {}
        }
        // What a broken statement above declares has been reported there.
        if scope.broken(name, span) {
            return Err(Reported);
        }
        let finding =
            Finding::error("unknown-name", span, format!("there is no value named `{name}`")).label("unknown here");
        let ours = match name {
            "True" | "TRUE" => Some("true"),
            "False" | "FALSE" => Some("false"),
            _ => None,
        };
        if let Some(ours) = ours {
            return self.report(finding.help(format!("write `{ours}`")));
        }
        if let Some(later) = scope.later(name, span) {
            let line = self.sources.position(later.file, later.start).line;
            return self.report(
                finding
                    .also(later, format!("declared below, line {line}"))
                    .help("move the declaration above its first use"),
            );
        }
        if table::find(name, None).is_some() {
            return self.report(finding.help(format!("`{name}` is a constructor: write `{name}(...)`")));
        }
        let similar = self.suggests().then(|| nearest(name, scope.names().chain(["X", "Y", "Z", "PI"]))).flatten();
        self.report(finding.maybe_help(similar.map(|name| format!("did you mean `{name}`?"))))
    }

    /// Calls the constructor or function that `call` names.
    fn call(&mut self, scope: &mut Scope, call: &Call, wanted: Option<Family>) -> Result<Value, Reported> {
        match scope.get(&call.name.text) {
            Some(Value::Function(function)) => {
                let function = Rc::clone(function);
                return self.call_function(scope, call, &function);
            }
            Some(Value::Poison) => {
                self.arguments_only(scope, call);
                return Err(Reported);
            }
            _ => {}
        }
        let before = wanted;
        let wanted = if call.piped.is_some() { Some(Family::Stage) } else { wanted };
        let Some(row) = table::find(&call.name.text, wanted) else {
            self.unknown_call(scope, &call.name.text, call.name.span, wanted);
            // The arguments are looked at all the same, for their own errors.
            self.arguments_only(scope, call);
            return Err(Reported);
        };
        let args = self.bind(scope, call, row, before)?;
        // Functions see nothing of the place where they are called, and are called most; `table` reads a file.
        let blind = row.family == Family::Function && row.name != "table";
        let file = if blind { None } else { Some(self.sources.get(call.span.file).path.clone()) };
        let folder = file.as_deref().and_then(|file| file.rsplit_once('/')).map_or("", |(folder, _)| folder);
        // Files are read once; a mesh of a file is one mesh however often it is named, an image one texture.
        let key = file_key(row, &args, folder);
        if let Some(value) = key.as_ref().and_then(|key| self.read.get(key)) {
            return match value {
                Value::Poison => Err(Reported),
                value => Ok(value.clone()),
            };
        }
        let mut site = Site {
            span: call.span,
            folder,
            triangles: self.limits.triangles.saturating_sub(self.triangles),
            limits: self.limits,
            host: self,
            lengthened: Vec::new(),
            findings: Vec::new(),
        };
        let built = (row.build)(&args, &mut site);
        let others = built.as_ref().err().map(|problem| further(row, &args, problem, &mut site)).unwrap_or_default();
        let Site { lengthened, findings, .. } = site;
        // Parts of one file share what is said of all of it.
        let new = |finding: &Finding, known: &[Finding]| {
            key.is_none() || !known.iter().any(|other| other.id == finding.id && other.message == finding.message)
        };
        for finding in findings {
            if new(&finding, &self.findings) {
                self.findings.push(finding);
            }
        }
        self.lengthened.extend(lengthened.into_iter().map(|message| (call.span, message)));
        let file = key.is_some();
        if let Some(key) = key {
            self.read.insert(key, built.as_ref().map_or(Value::Poison, Clone::clone));
        }
        if let (false, Ok(Value::Mesh(made))) = (file, &built) {
            self.count_triangles(made, &args, call.span)?;
        }
        built.map_err(|problem| {
            let problem = *problem.0;
            if problem.id == table::REPORTED {
                return Reported;
            }
            let spans = self.argument_spans(call, row);
            for table::Detail { at, message, label, note, help, id } in std::iter::once(problem).chain(others) {
                let at = at.and_then(|name| spans.iter().find(|(param, _)| *param == name));
                let mut finding = Finding::error(id, at.map_or(call.span, |(_, span)| *span), message);
                finding.notes.extend(note);
                finding.help = help;
                finding.label = label;
                self.findings.push(finding);
            }
            Reported
        })
    }

    /// Adds the triangles of a mesh that a generator or stage made to those of the scene. A stage that only moves a mesh makes
    /// none.
    fn count_triangles(&mut self, made: &MeshValue, args: &Args, span: Span) -> Result<(), Reported> {
        let of_before = |value: &&Value| matches!(value, Value::Mesh(before) if Rc::ptr_eq(&before.mesh, &made.mesh));
        if args.values.iter().flatten().any(|value| of_before(&value)) {
            return Ok(());
        }
        let most = self.limits.triangles;
        // Vertices that no triangle has also take room.
        let vertices = made.mesh.positions.len() as u64;
        self.triangles = self.triangles.saturating_add((made.mesh.triangles.len() as u64).max(vertices / 3));
        if self.triangles <= most {
            return Ok(());
        }
        let message = format!("the meshes of the scene have more than {most} triangles");
        self.report(Finding::error("triangle-limit", span, message).label("up to here").help(Limit::help("triangles")))
    }

    /// Reports a call of something that is no constructor and no function.
    pub(super) fn unknown_call(&mut self, scope: &Scope, name: &str, span: Span, wanted: Option<Family>) {
        if scope.broken(name, span) {
            return;
        }
        if name == "range" {
            self.findings.push(
                Finding::error("unknown-constructor", span, "there is no `range`")
                    .help("a range is written `0..9`; both ends belong to it"),
            );
            return;
        }
        let fits = table::table().filter(|row| wanted.is_none_or(|family| row.family == family));
        let known: Vec<&str> = fits.map(|row| row.name).collect();
        let functions = || scope.functions();
        let all = || table::table().map(|row| row.name).chain(scope.names());
        let suggests = self.suggests();
        let similar = synonyms::constructor(name, wanted)
            .or_else(|| if suggests { nearest(name, functions().chain(known.iter().copied())) } else { None })
            .or_else(|| if suggests { nearest(name, all()) } else { None });
        let what = wanted.map_or("a constructor or function", Family::words);
        let mut finding = Finding::error("unknown-constructor", span, format!("there is no `{name}`"))
            .label(format!("expected {what}"));
        if scope.get(name).is_some() {
            finding = finding.note(format!("`{name}` is a value and takes no arguments"));
        } else if let Some(later) = scope.later(name, span) {
            let line = self.sources.position(later.file, later.start).line;
            finding = finding.also(later, format!("declared below, line {line}"));
        } else if wanted.is_some() {
            finding = finding.note(format!("known: {}", known.join(", ")));
        }
        let finding = finding.maybe_help(similar.map(|name| format!("did you mean `{name}`?")));
        self.findings.push(finding);
    }

    /// How a list of numbers, such as a row of `table`, becomes a vector.
    fn row_help(&self, ty: Ty, items: &[Value], span: Span) -> Option<String> {
        let size = match ty {
            Ty::Vec3 | Ty::NumberOrVec3 => 3,
            Ty::Vec2 => 2,
            Ty::Row => 4,
            _ => return None,
        };
        let name = self.excerpt(span)?;
        let parts: Vec<String> = (0..size).map(|at| format!("{name}[{at}]")).collect();
        (items.len() == size).then(|| format!("a list is no vector: write `({})`", parts.join(", ")))
    }

    /// The text of a place, if it is short enough to be repeated in a help.
    fn excerpt(&self, span: Span) -> Option<&str> {
        let text = self.sources.get(span.file).text.get(span.start as usize..span.end as usize)?;
        (text.len() <= 40 && !text.contains('\n')).then_some(text)
    }

    fn arguments_only(&mut self, scope: &mut Scope, call: &Call) {
        for value in call.piped.iter().chain(call.args.iter().map(|arg| &arg.value)) {
            let _reported = self.eval(scope, value, None);
        }
    }

    /// The places of the arguments by parameter, as [`Interpreter::bind`] matches them.
    fn argument_spans(&self, call: &Call, row: &'static Constructor) -> Vec<(&'static str, Span)> {
        let mut spans = Vec::new();
        let mut next = 0;
        if let Some(piped) = &call.piped {
            spans.extend(row.params.first().map(|param| (param.name, piped.span)));
            next = 1;
        }
        for arg in &call.args {
            let param = match &arg.label {
                Some(label) => row.params.iter().find(|param| param.name == label.text),
                None => {
                    next += 1;
                    row.params.get(next - 1)
                }
            };
            spans.extend(param.map(|param| (param.name, arg.value.span)));
        }
        spans
    }

    /// Matches arguments with parameters and checks their types; reports all that is wrong with a call.
    /// `wanted` is what the place of the call asks for: what a stage moves is the same.
    fn bind(
        &mut self,
        scope: &mut Scope,
        call: &Call,
        row: &'static Constructor,
        wanted: Option<Family>,
    ) -> Result<Args, Reported> {
        let mut values: Vec<Option<Value>> = row.params.iter().map(|_| None).collect();
        let mut given: Vec<Option<Span>> = vec![None; row.params.len()];
        let mut good = true;
        let piped = usize::from(call.piped.is_some());
        let mut next = 0;
        let unlabeled = call.piped.iter().map(|value| (None, value));
        let labeled = call.args.iter().map(|arg| (arg.label.as_ref(), &arg.value));
        let mut seen_label = false;
        // Parameters that misspelt labels stand for: they are not missing.
        let mut meant: Vec<&str> = Vec::new();
        for (label, value) in unlabeled.chain(labeled) {
            let at = match label {
                Some(label) => {
                    seen_label = true;
                    row.params.iter().position(|param| param.name == label.text)
                }
                None => {
                    next += 1;
                    Some(next - 1)
                }
            };
            let (Some(at), Some(param)) = (at, at.and_then(|at| row.params.get(at))) else {
                meant.extend(self.unknown_argument(row, label.map(|label| (&*label.text, label.span)), value.span));
                let _reported = self.eval(scope, value, None);
                good = false;
                continue;
            };
            if label.is_none() && (seen_label || at >= row.positional + piped) {
                let written = self.excerpt(value.span).unwrap_or("...").to_owned();
                let free: Vec<&str> = row.params.iter().skip(at).map(|other| other.name).take(3).collect();
                let help = if free.len() > 1 && row.positional == 0 && param.default == Some("") {
                    format!(
                        "write its label, for example `{}: {written}` (others are {})",
                        param.name,
                        free[1..].join(", ")
                    )
                } else {
                    format!("write `{}: {written}`", param.name)
                };
                let finding = if seen_label {
                    Finding::error(
                        "unknown-argument",
                        value.span,
                        "an argument without label stands behind one with a label",
                    )
                } else {
                    Finding::error(
                        "unknown-argument",
                        value.span,
                        format!("`{}` takes `{}` with its label only", row.name, param.name),
                    )
                };
                self.findings.push(finding.help(help).note(format!("it is `{}`", row.signature())));
                let _reported = self.eval(scope, value, None);
                good = false;
                continue;
            }
            if let Some(first) = given[at] {
                self.findings.push(
                    Finding::error("unknown-argument", value.span, format!("`{}` is given twice", param.name))
                        .label("again")
                        .also(first, "first here"),
                );
                good = false;
                continue;
            }
            given[at] = Some(value.span);
            match self.typed(scope, value, param.ty, param.name, wanted) {
                Ok(value) => values[at] = Some(value),
                Err(Reported) => {
                    good = false;
                    let vector = row.params.iter().find(|other| other.ty == Ty::Vec3);
                    if let (None, Ty::Number, Some(vector), ExprKind::Row(_)) = (label, param.ty, vector, &value.kind) {
                        let written = self.excerpt(value.span).unwrap_or("...").to_owned();
                        let help = format!(
                            "write `{}({}: {written})`, or the numbers without brackets",
                            row.name, vector.name
                        );
                        if let Some(finding) = self.findings.last_mut() {
                            finding.help = Some(help);
                        }
                    }
                }
            }
        }
        for (at, param) in row.params.iter().enumerate() {
            if given[at].is_none() && param.default.is_none() && !meant.contains(&param.name) {
                let message = format!("`{}` needs `{}`", row.name, param.name);
                self.findings.push(
                    Finding::error("missing-argument", call.name.span, message)
                        .label(format!("`{}` is missing: {}", param.name, param.doc))
                        .help(format!("it is `{}`", row.signature())),
                );
                good = false;
            }
        }
        if good { Ok(Args { params: row.params, values }) } else { Err(Reported) }
    }

    /// Reports it, and gives the parameters that may be meant.
    fn unknown_argument(
        &mut self,
        row: &'static Constructor,
        label: Option<(&str, Span)>,
        value: Span,
    ) -> Vec<&'static str> {
        let params = row.params.iter().skip(usize::from(row.family == Family::Stage));
        let mut meant = Vec::new();
        let finding = match label {
            Some((label, span)) => {
                meant = synonyms::meant(label, params.map(|param| param.name));
                Finding::error("unknown-argument", span, format!("`{}` has no argument `{label}`", row.name))
                    .label("unknown argument")
                    .maybe_help(synonyms::question(&meant))
            }
            None => Finding::error("unknown-argument", value, format!("`{}` takes fewer arguments", row.name))
                .label("one too many"),
        };
        self.findings.push(finding.note(format!("it is `{}`", row.signature())));
        meant
    }

    /// The value of `expr` as the type of the parameter `name`.
    fn typed(
        &mut self,
        scope: &mut Scope,
        expr: &Expr,
        ty: Ty,
        name: &str,
        wanted: Option<Family>,
    ) -> Result<Value, Reported> {
        let family = match ty {
            Ty::Turnable => wanted.filter(|family| matches!(family, Family::Group | Family::Light)),
            Ty::Placeable => wanted.filter(|family| *family == Family::Group),
            Ty::Mesh => Some(Family::Mesh),
            Ty::Material => Some(Family::Material),
            Ty::Filter => Some(Family::Filter),
            _ => None,
        };
        let value = self.eval(scope, expr, family)?;
        if let (Ty::Points | Ty::Points2 | Ty::Faces | Ty::Numbers, Value::List(items)) = (ty, &value) {
            // They are checked and then read.
            self.spend(2 * items.len() as u64, expr.span)?;
        }
        let kind = value.kind();
        let light = matches!(value, Value::Light(_));
        let found = value.clone();
        let refusal = match ty.accept(value) {
            Ok(value) => return Ok(value),
            Err(refusal) => refusal,
        };
        let mismatch = Finding::error("type-mismatch", expr.span, format!("`{name}` takes {}, not {kind}", ty.words()))
            .label(kind);
        // Nobody writes `of`: it is what stands before `|>`.
        if name == "of" && matches!(refusal, Refusal::Type) && matches!(found, Value::Material(_)) {
            let written = self.excerpt(expr.span).unwrap_or("...").to_owned();
            return self.report(
                Finding::error(
                    "type-mismatch",
                    expr.span,
                    "stages stand before `with`: they change the mesh, not its material",
                )
                .label(kind)
                .help(format!("write `... |> stage(...) with {written}`")),
            );
        }
        let mismatch = if name == "of" {
            Finding::error("type-mismatch", expr.span, format!("before `|>` stands {}, not {kind}", ty.words()))
                .label(kind)
        } else {
            mismatch
        };
        self.report(match refusal {
            Refusal::Silent => return Err(Reported),
            Refusal::Type if light && matches!(ty, Ty::Mesh | Ty::Placeable | Ty::Turnable) => Finding::error(
                "type-mismatch",
                expr.span,
                "stages move meshes and groups, not lights; an environment can be turned by `rotate`",
            )
            .label(kind)
            .help(match &found {
                Value::Light(light) if matches!(**light, LightKind::Environment { .. }) => {
                    "an environment is infinitely far away: leave the stage out"
                }
                _ => "give the light the position or direction that it is to have, or put a point light into a group",
            }),
            Refusal::Type => mismatch.maybe_help(match (&found, &expr.kind) {
                (Value::List(_), ExprKind::List(_)) => type_help(ty, &found),
                (Value::List(items), _) => self.row_help(ty, items, expr.span).or_else(|| type_help(ty, &found)),
                _ => type_help(ty, &found),
            }),
            Refusal::Unit(n) => Finding::error(
                "missing-unit",
                expr.span,
                format!("`{name}` takes an angle, and this number has no unit"),
            )
            .label("no unit")
            .help(unit_help(n)),
            Refusal::Whole(n) => Finding::error(
                "type-mismatch",
                expr.span,
                format!("`{name}` takes a whole number that is not negative, not {n}"),
            ),
            Refusal::Reversed(lo, hi) => {
                let help = if lo == hi {
                    format!("write `{lo}` for a flat extent, if this axis may be flat")
                } else {
                    format!("write `{hi}..{lo}`")
                };
                let what = if lo == hi { "is empty" } else { "runs backwards" };
                Finding::error("reversed-range", expr.span, format!("the interval `{lo}..{hi}` {what}")).help(help)
            }
            Refusal::ColorFromVector => {
                let row = self.excerpt(expr.span).filter(|text| text.starts_with('(')).unwrap_or("(r, g, b)");
                mismatch.help(format!("write `rgb{row}` for linear values, or `srgb(\"#rrggbb\")`"))
            }
            Refusal::Signature => mismatch
                .label("a function with other parameters")
                .help(format!("declare it as `let {name}(x: number, y: number) = ...`")),
            Refusal::Element(at) => mismatch.note(format!("element {at} is of another type")),
        })
    }
}

/// The most triangles of a mesh that is made only to hear of more errors.
const MADE_FOR_FINDINGS: u64 = 1 << 16;

/// What is wrong with the arguments of a call beside `first`: it is made again without each argument that is wrong, which has its
/// default then. Calls that read files or call functions are not made again.
fn further(row: &Constructor, args: &Args, first: &table::Problem, site: &mut Site<'_>) -> Vec<table::Detail> {
    let mut found: Vec<table::Detail> = Vec::new();
    // Extents and axes depend on each other.
    let entangled =
        |ty| matches!(ty, Ty::String | Ty::Height | Ty::Extent | Ty::Range | Ty::Axis | Ty::Placeable | Ty::Turnable);
    if row.params.iter().any(|param| entangled(param.ty)) {
        return found;
    }
    let mut wrong: Vec<&str> = Vec::new();
    let mut rest = Args { params: args.params, values: args.values.clone() };
    let mut at = first.0.at;
    // Nothing is to be made but findings.
    let triangles = site.triangles;
    site.triangles = triangles.min(MADE_FOR_FINDINGS);
    // A problem without an argument, or with one that is left out already, has no other behind it that could be told apart.
    while let Some(name) = at.filter(|name| !wrong.contains(name)) {
        wrong.push(name);
        let Some(place) = row.params.iter().position(|param| param.name == name) else { break };
        rest.values[place] = None;
        let Err(table::Problem(next)) = (row.build)(&rest, site) else { break };
        if next.id == "triangle-limit" {
            break;
        }
        at = next.at;
        if next.id != table::REPORTED && next.at.is_some_and(|name| !wrong.contains(&name) && rest.get(name).is_some())
        {
            found.push(*next);
        }
    }
    site.triangles = triangles;
    found
}

/// How to write a number without unit as an angle. Few turn by more than a whole turn in radians.
pub(super) fn unit_help(n: f64) -> String {
    if n.abs() > std::f64::consts::TAU { format!("write `{n}deg`") } else { format!("write `{n}deg` or `{n}rad`") }
}

/// What to write where `found` is of another type than `ty`.
fn type_help(ty: Ty, found: &Value) -> Option<String> {
    let text = match (ty, found) {
        (Ty::Axis, _) => "write `X`, `-X`, `Y`, `-Y`, `Z` or `-Z`",
        (Ty::Extent | Ty::Range, Value::Vector(parts)) if parts.len() == 2 => {
            return Some(format!("a range is written `{}..{}`", parts[0], parts[1]));
        }
        (Ty::Range, Value::Number(_)) => "a range is written `a..b`; both ends belong to it",
        (Ty::Number | Ty::Whole, Value::Angle(_)) => "write the number without its unit",
        (Ty::Number, Value::Vector(_)) => "give its parts one by one, or use a parameter that takes a vector",
        (Ty::Vec3 | Ty::NumberOrVec3, Value::List(_)) => "vectors stand in round brackets: `(x, y, z)`",
        (Ty::Vec3, Value::Vector(_)) => "write three numbers: `(x, y, z)`",
        (Ty::Color | Ty::ColorOrTexture, Value::String(text)) if text.starts_with('#') => {
            return Some(format!("write `srgb({text:?})`"));
        }
        (Ty::Color | Ty::ColorOrTexture, Value::String(_)) => {
            "write `srgb(\"#rrggbb\")`, or `bitmap(\"...\")` for an image"
        }
        (Ty::Mesh, Value::Group(_)) => "a group is placed by `instance name = ...`",
        (Ty::Mesh | Ty::Placeable | Ty::Turnable | Ty::Material, Value::Function(_)) => {
            "call it: write `(...)` with its arguments behind it"
        }
        (Ty::Filter, Value::String(_)) => "write for example `gaussian()`",
        _ => return None,
    };
    Some(text.to_owned())
}

impl table::Host for Interpreter<'_> {
    fn read(&mut self, path: &VPath) -> Result<Bytes, ReadError> {
        let bytes = self.files.read(path, self.limits.file)?;
        self.inputs.insert(path.clone(), bytes.clone());
        Ok(bytes)
    }

    fn texture(&mut self, texture: Texture, span: Span) -> Handle<Texture> {
        self.textures.push(texture, span)
    }

    fn image(&self, texture: Handle<Texture>) -> &Texture {
        &self.textures[texture]
    }

    fn scattered(&mut self) -> &mut BTreeMap<VPath, Arc<[Affine]>> {
        &mut self.scattered
    }

    fn apply(&mut self, function: &Rc<Function>, values: Vec<Value>, span: Span) -> Result<Value, Reported> {
        self.step(span)?;
        self.invoke(function, &values, span)
    }

    fn apply_many(&mut self, function: &Rc<Function>, places: &[[f64; 2]]) -> Option<Vec<f64>> {
        self.invoke_many(function, places)
    }

    fn list(&mut self, items: Vec<Value>, span: Span) -> Result<Value, Reported> {
        Interpreter::list(self, items, span)
    }

    fn hold(&mut self, bytes: u64, span: Span) -> Result<(), Reported> {
        self.spend(bytes / 64, span)?;
        Interpreter::hold(self, bytes, span)
    }
}

/// Family, path, part or encoding, and the bits of a factor; see [`file_key`].
pub(super) type FileKey = (Family, VPath, Option<String>, [u64; 3]);

/// What makes two calls of `file` the same mesh or group, of `bitmap` the same texture, and of `table` the same list.
fn file_key(row: &Constructor, args: &Args, folder: &str) -> Option<FileKey> {
    let more = match (row.family, row.name) {
        (Family::Mesh | Family::Group, "file") | (Family::Function, "table") => "part",
        (Family::Texture, "bitmap") => "encoding",
        _ => return None,
    };
    let text = |name| match args.get(name) {
        Some(Value::String(text)) => Some(text.to_string()),
        _ => None,
    };
    let factor = args.color("scale").map_or([1.0; 3], |color| color.rgb()).map(f64::to_bits);
    Some((row.family, VPath::resolve(folder, &text("path")?).ok()?, text(more), factor))
}
