//! Loops, conditions and parameters of a scene.

use crate::diag::{Finding, Label, Severity, Span};
use crate::files::VPath;
use crate::syntax::{self, Binary, Clause, Expr, ExprKind, Name, Statement, StatementKind, Type};

use super::function::Typed;
use super::module::{Module, Scope};
use super::value::Value;
use super::{Interpreter, Limit, Reported, SceneParameter, TRAIL};

/// What a parameter may be.
enum Allowed {
    Value(Value),
    /// In degrees, both ends included.
    Angles(f64, f64),
}

impl Allowed {
    /// As it would be written.
    fn words(&self) -> String {
        match self {
            Self::Value(Value::List(items)) if items.len() <= 20 => {
                items.iter().map(Value::written).collect::<Vec<_>>().join(", ")
            }
            Self::Value(value) => value.written(),
            Self::Angles(lo, hi) => format!("{lo}deg..{hi}deg"),
        }
    }
}

/// Names of the iterations of the loops around a place: values of range variables, indices of list elements.
pub(super) type Path = Vec<String>;

impl Interpreter<'_> {
    /// Runs `body` once for each combination of the clauses' elements, with their names declared. Stops at the first
    /// iteration in which something is wrong, and says which one it was.
    pub(super) fn each(
        &mut self,
        scope: &mut Scope,
        clauses: &[Clause],
        path: &mut Path,
        body: &mut dyn FnMut(&mut Self, &mut Scope, &Path) -> Result<(), Reported>,
    ) -> Result<(), Reported> {
        let Some((clause, rest)) = clauses.split_first() else { return body(self, scope, path) };
        let over = self.eval(scope, &clause.over, None)?;
        let span = clause.over.span;
        let (items, count, first) = match over {
            Value::List(items) => (Some(items.clone()), items.len(), None),
            Value::Range(lo, hi) => (None, self.whole_numbers(lo, hi, span)?, Some(lo)),
            other => {
                let message = format!("a loop runs over a list or a range, not {}", other.kind());
                return self.report(Finding::error("type-mismatch", span, message).label(other.kind()));
            }
        };
        for at in 0..count {
            self.step(span)?;
            let number = Value::Number(first.unwrap_or(0.0) + at as f64);
            let item = items.as_ref().and_then(|items| items.get(at)).unwrap_or(&number);
            let values = self.destructure(clause, item)?;
            let mark = scope.mark();
            for (name, value) in clause.names.iter().zip(values) {
                self.declare_inner(scope, name, value);
            }
            path.push(first.map_or_else(|| at.to_string(), |lo| format!("{}", lo + at as f64)));
            let before = self.findings.len();
            let done = self.each(scope, rest, path, body);
            let broken = done.is_err() || self.findings[before..].iter().any(|found| found.severity == Severity::Error);
            if broken {
                let place = path.last().cloned().unwrap_or_default();
                self.iteration(before, clause, first.is_some(), &place);
            }
            path.pop();
            scope.release(mark);
            if broken {
                return Err(Reported);
            }
        }
        Ok(())
    }

    /// Says in which iteration of `clause` the errors since `before` arose, from the innermost loop outward.
    fn iteration(&mut self, before: usize, clause: &Clause, numbers: bool, place: &str) {
        let names: Vec<&str> = clause.names.iter().map(|name| name.text.as_str()).collect();
        let span = clause.names.iter().map(|name| name.span).reduce(Span::to).unwrap_or(clause.over.span);
        let names = if clause.tuple { format!("({})", names.join(", ")) } else { names.join(", ") };
        let text = if numbers {
            format!("in iteration {names} = {place}")
        } else {
            format!("in iteration {names} = element {place}")
        };
        for finding in self.findings[before..].iter_mut().filter(|found| found.severity == Severity::Error) {
            if finding.labels.len() < TRAIL {
                finding.labels.push(Label { span, text: text.clone() });
            }
        }
    }

    /// The parts of an element that a clause names.
    fn destructure(&mut self, clause: &Clause, item: &Value) -> Result<Vec<Value>, Reported> {
        let values: Vec<Value> = match (clause.tuple, item) {
            (true, Value::Tuple(parts)) => {
                self.spend(parts.len() as u64, clause.over.span)?;
                parts.to_vec()
            }
            (true, Value::Vector(parts)) => parts.iter().map(|part| Value::Number(*part)).collect(),
            (_, item) => vec![item.clone()],
        };
        if values.len() == clause.names.len() {
            return Ok(values);
        }
        let span = clause.names.first().map_or(clause.over.span, |name| name.span);
        self.report(
            Finding::error("type-mismatch", span, format!("{} names stand for {}", clause.names.len(), item.kind()))
                .help("give as many names as the tuple has parts"),
        )
    }

    /// How many whole numbers a range has, both ends included; `a..a-1` is empty.
    fn whole_numbers(&mut self, lo: f64, hi: f64, span: Span) -> Result<usize, Reported> {
        if lo.fract() != 0.0 || hi.fract() != 0.0 {
            return self
                .report(Finding::error("type-mismatch", span, "a loop's range has whole ends").help(
                    "count in whole numbers and compute the rest: `for i in 0..4 { let x = 0.5 + 0.5 * i ... }`",
                ));
        }
        let count = hi - lo + 1.0;
        if count < 0.0 {
            return self.report(
                Finding::error("reversed-range", span, format!("the range `{lo}..{hi}` runs backwards"))
                    .help(format!("write `{hi}..{lo}`, or `reverse(...)` of a list")),
            );
        }
        if count > self.limits.list as f64 {
            return self.report(
                Finding::error("list-limit", span, format!("the range has {count} numbers"))
                    .note(format!("at most {} are allowed", self.limits.list))
                    .help(Limit::help("list")),
            );
        }
        Ok(count as usize)
    }

    /// `for ... { statements }`
    pub(super) fn for_statement(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        clauses: &[Clause],
        body: &[Statement],
    ) {
        let mut path = std::mem::take(&mut module.path);
        let _reported = self.each(scope, clauses, &mut path, &mut |this, scope, path| {
            module.path.clone_from(path);
            this.block(module, scope, body);
            Ok(())
        });
        module.path = path;
    }

    /// `if ... { statements } else { statements }`
    pub(super) fn if_statement(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        branches: &[(Expr, Vec<Statement>)],
        otherwise: &[Statement],
    ) {
        for (condition, body) in branches {
            match self.eval(scope, condition, None) {
                Ok(Value::Bool(true)) => return self.block(module, scope, body),
                Ok(Value::Bool(false)) => {}
                Ok(other) => {
                    let message = format!("a condition is true or false, not {}", other.kind());
                    self.findings.push(Finding::error("type-mismatch", condition.span, message).label(other.kind()));
                    return;
                }
                Err(Reported) => return,
            }
        }
        self.block(module, scope, otherwise);
    }

    /// The statements of a group, a loop or a condition, whose names go out of sight behind it.
    pub(super) fn block(&mut self, module: &mut Module, scope: &mut Scope, body: &[Statement]) {
        let mark = scope.mark();
        module.depth += 1;
        for statement in body {
            let misplaced = match &statement.kind {
                StatementKind::Version(_) => Some("`lts`"),
                StatementKind::Scene { .. } => Some("`scene`"),
                StatementKind::Use { .. } => Some("`use`"),
                StatementKind::Parameter { .. } => Some("`param`"),
                StatementKind::Declaration {
                    kind: syntax::Kind::Camera | syntax::Kind::Film | syntax::Kind::Integrator | syntax::Kind::Sampler,
                    ..
                } => Some("a setting"),
                _ => None,
            };
            match misplaced {
                Some(what) => {
                    let message = format!("{what} stands inside braces");
                    self.findings.push(
                        Finding::error("misplaced-statement", statement.span, message).help("move it to the top level"),
                    );
                }
                None => self.statement(module, scope, statement),
            }
        }
        module.depth -= 1;
        scope.release(mark);
    }

    /// `param NAME: type = default in range`
    pub(super) fn parameter(
        &mut self,
        scope: &mut Scope,
        name: &Name,
        ty: &Type,
        default: &Expr,
        range: Option<&Expr>,
    ) {
        let value = self.parameter_value(scope, name, ty, default, range);
        self.declare(scope, name, value.unwrap_or(Value::Poison));
    }

    fn parameter_value(
        &mut self,
        scope: &mut Scope,
        name: &Name,
        ty: &Type,
        default: &Expr,
        range: Option<&Expr>,
    ) -> Result<Value, Reported> {
        let typed = Typed::new(self, ty);
        let written = self.eval(scope, default, None);
        let allowed = range.map(|range| self.allowed(scope, range)).transpose();
        let (typed, written, allowed) = (typed?, written?, allowed?);
        let mut value = self.accept(&typed, written, default.span, &name.text)?;
        self.in_range(&value, allowed.as_ref(), default.span, name)?;
        let at = self.scene_parameters.len();
        self.scene_parameters.push(SceneParameter {
            name: name.text.clone(),
            ty: typed.words(),
            value: value.written(),
            allowed: allowed.as_ref().map_or(String::new(), Allowed::words),
        });
        let given = self.set.iter().rev().find(|(given, _)| *given == name.text).map(|(_, text)| text.clone());
        if let Some(text) = given {
            let (set, span) = self.parse_setting(scope, name, &typed, &text)?;
            value = self.accept(&typed, set, span, &name.text)?;
            self.in_range(&value, allowed.as_ref(), span, name)?;
            if let Some(known) = self.scene_parameters.get_mut(at) {
                known.value = value.written();
            }
        }
        Ok(value)
    }

    /// The value of a parameter that was given from outside, as the text of an expression.
    fn parse_setting(
        &mut self,
        scope: &mut Scope,
        name: &Name,
        typed: &Typed,
        text: &str,
    ) -> Result<(Value, Span), Reported> {
        // A shell takes quotes away: a bare word is the string itself.
        if typed.is_string() && !text.starts_with('\u{22}') {
            let file = self.sources.add(format!("--set {}={text}", name.text), text);
            return Ok((Value::String(text.into()), Span::new(file, 0, text.len())));
        }
        let source = format!("let value = {text}");
        let file = self.sources.add(format!("--set {}={text}", name.text), source.as_str());
        let (tree, findings) = syntax::parse(file, &source);
        let bad = !findings.is_empty();
        self.findings.extend(findings);
        let mut statements = tree.statements.into_iter();
        match (statements.next().map(|statement| statement.kind), statements.next(), bad) {
            (Some(StatementKind::Declaration { value, params: None, with: None, .. }), None, false) => {
                let made = self.eval(scope, &value, None)?;
                Ok((made, value.span))
            }
            (_, _, true) => Err(Reported),
            (_, _, false) => {
                let span = Span::new(file, 12, source.len());
                self.report(Finding::error("syntax-error", span, "a parameter is set to one value"))
            }
        }
    }

    /// What a parameter may be: `0..1`, `2deg..90deg`, or a list.
    fn allowed(&mut self, scope: &mut Scope, range: &Expr) -> Result<Allowed, Reported> {
        if let ExprKind::Binary(Binary::Range, _, ends) = &range.kind {
            let (lo, hi) = (self.eval(scope, &ends.0, None), self.eval(scope, &ends.1, None));
            match (lo?, hi?) {
                (Value::Angle(lo), Value::Angle(hi)) => return Ok(Allowed::Angles(lo, hi)),
                (Value::Number(lo), Value::Number(hi)) => return Ok(Allowed::Value(Value::Range(lo, hi))),
                _ => {}
            }
        }
        self.eval(scope, range, None).map(Allowed::Value)
    }

    fn in_range(&mut self, value: &Value, allowed: Option<&Allowed>, span: Span, name: &Name) -> Result<(), Reported> {
        let Some(allowed) = allowed else { return Ok(()) };
        let inside = match (value, allowed) {
            (Value::Number(n), Allowed::Value(Value::Range(lo, hi))) | (Value::Angle(n), Allowed::Angles(lo, hi)) => {
                (*lo..=*hi).contains(n)
            }
            (value, Allowed::Value(Value::List(items))) => {
                let mut left = self.left();
                let before = left;
                let found = items.iter().any(|item| super::ops::compare(value, item, &mut left) == Some(true));
                self.spend(before - left, span)?;
                found
            }
            _ => {
                return self.report(
                    Finding::error(
                        "type-mismatch",
                        name.span,
                        format!("`in` takes a range or a list that fits {}, not {}", value.kind(), allowed.words()),
                    )
                    .help("write for example `in 0.01..1`, `in 2deg..90deg`, or `in [\"a\", \"b\"]`"),
                );
            }
        };
        if inside {
            return Ok(());
        }
        let allowed = allowed.words();
        self.report(
            Finding::error(
                "parameter-range",
                span,
                format!("`{}` is {}, and allowed is {allowed}", name.text, value.written()),
            )
            .label("not allowed")
            .also(name.span, "declared here"),
        )
    }

    /// Parameters that were given from outside and that the scene does not have.
    pub(super) fn unknown_settings(&mut self, path: &VPath) {
        let known: Vec<&str> = self.scene_parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        let mut findings = Vec::new();
        for (name, _) in self.set {
            if known.contains(&name.as_str()) {
                continue;
            }
            let origin = crate::diag::Origin::File { path: path.to_string(), place: String::new() };
            let similar =
                crate::diag::nearest(name, known.iter().copied()).map(|name| format!("did you mean `{name}`?"));
            let list = if known.is_empty() {
                "the scene has none".to_owned()
            } else {
                format!("the scene has {}", known.join(", "))
            };
            let finding = Finding::error("unknown-parameter", origin, format!("the scene has no parameter `{name}`"));
            findings.push(finding.note(list).maybe_help(similar));
        }
        self.findings.extend(findings);
    }
}
