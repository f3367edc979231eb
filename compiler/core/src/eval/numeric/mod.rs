//! Functions of numbers as small programs: what `height_field` calls a million times.
//!
//! `lanes` runs them for many places at once.
//!
//! A function whose body only computes with numbers and angles is translated once, names resolved to slots, and then run
//! without values, scopes or allocations. A program gives the interpreter's result to the bit or none at all: whatever is an
//! error there (division by zero, a result that is not finite, too many steps) gives none, and the interpreter runs to
//! say why and where. A test holds both against each other on random expressions.

mod lanes;

pub(super) use lanes::LANES;

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::ir::sin_cos_degrees;
use crate::syntax::{Binary, Call, Clause, Expr, ExprKind, Unary};

use super::function::Function;
use super::value::Value;
use lanes::Kind;

/// How deep functions are written into each other; deeper ones are interpreted.
const INLINE_DEPTH: usize = 16;

/// Nodes that take as long as one part of an expression that is interpreted.
const NODES_PER_UNIT: u64 = 4;

/// The most nodes of a program, because functions are written out at each of their calls.
const MOST_NODES: usize = 10_000;

/// What a number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Number,
    /// In degrees.
    Angle,
}

/// A translated function.
#[derive(Debug)]
pub(super) struct Program {
    slots: usize,
    body: Node,
    unit: Unit,
    /// What a run costs at most, in units of work of the interpreter.
    units: u64,
}

#[derive(Debug)]
enum Node {
    Constant(f64),
    Slot(usize),
    Negative(Box<Node>),
    Arithmetic(Binary, Box<(Node, Node)>),
    One(Kind, fn(f64) -> f64, Box<Node>),
    Two(fn(f64, f64) -> f64, Box<(Node, Node)>),
    If(Box<(Test, Node, Node)>),
    /// A call: arguments go into slots from the given one on. Counts a step.
    Bind(usize, Vec<Node>, Box<Node>),
    /// The sum of the body over rows of numbers, which go into slots from the given one on. Counts a step for each.
    Sum(usize, Rc<Rows>, Box<Node>),
}

#[derive(Debug)]
enum Test {
    Order(Binary, Box<(Node, Node)>),
    Logic(Binary, Box<(Test, Test)>),
    Not(Box<Test>),
}

/// Rows of `width` numbers each.
#[derive(Debug)]
struct Rows {
    width: usize,
    numbers: Vec<f64>,
}

/// A function of one number: name, argument, result.
type One = (&'static str, Unit, Unit, fn(f64) -> f64);

/// A function of two numbers that gives a number.
type Two = (&'static str, fn(f64, f64) -> f64);

/// Functions of one number. NaN for what the table of functions refuses.
const ONE: &[One] = &[
    ("sin", Unit::Angle, Unit::Number, |x| sin_cos_degrees(x).0),
    ("cos", Unit::Angle, Unit::Number, |x| sin_cos_degrees(x).1),
    ("asin", Unit::Number, Unit::Angle, |x| libm::asin(x).to_degrees()),
    ("acos", Unit::Number, Unit::Angle, |x| libm::acos(x).to_degrees()),
    ("atan", Unit::Number, Unit::Angle, |x| libm::atan(x).to_degrees()),
    ("sqrt", Unit::Number, Unit::Number, f64::sqrt),
    ("abs", Unit::Number, Unit::Number, f64::abs),
    ("floor", Unit::Number, Unit::Number, f64::floor),
    ("ceil", Unit::Number, Unit::Number, f64::ceil),
    ("round", Unit::Number, Unit::Number, f64::round),
    ("exp", Unit::Number, Unit::Number, libm::exp),
    ("log", Unit::Number, Unit::Number, libm::log),
];

/// Functions of two numbers.
const TWO: &[Two] = &[
    ("pow", libm::pow),
    ("mod", |a, b| if b == 0.0 { f64::NAN } else { a - b * (a / b).floor() }),
    ("min", f64::min),
    ("max", f64::max),
];

impl Program {
    /// The program of a function's body; none where it does more than compute with numbers.
    pub(super) fn of(function: &Function) -> Option<Self> {
        let mut writer = Writer { slots: 0, nodes: 0, depth: 0 };
        let (body, names, captured) = function.numeric()?;
        let mut scope = Scope { captured, slots: Vec::new() };
        for name in names {
            scope.slots.push((name, writer.slot(), Unit::Number));
        }
        let (body, unit) = writer.expr(&scope, body)?;
        let units = 1 + body.nodes() / NODES_PER_UNIT;
        Some(Self { slots: writer.slots, body, unit, units })
    }

    /// What a run costs at most, in units of work of the interpreter.
    pub(super) fn units(&self) -> u64 {
        self.units
    }

    /// The result for the parameters' values. Adds the steps that the interpreter would count.
    pub(super) fn run(&self, values: &[Value], steps: &mut u64) -> Option<Value> {
        let mut slots = vec![0.0; self.slots];
        for (slot, value) in slots.iter_mut().zip(values) {
            let Value::Number(number) = value else { return None };
            *slot = *number;
        }
        let result = self.body.run(&mut slots, steps)?;
        Some(match self.unit {
            Unit::Number => Value::Number(result),
            Unit::Angle => Value::Angle(result),
        })
    }
}

impl Node {
    /// How many nodes a run visits at most.
    fn nodes(&self) -> u64 {
        let inner = match self {
            Self::Constant(_) | Self::Slot(_) => 0,
            Self::Negative(of) | Self::One(_, _, of) => of.nodes(),
            Self::Arithmetic(_, both) | Self::Two(_, both) => both.0.nodes().saturating_add(both.1.nodes()),
            Self::If(parts) => parts.0.nodes().saturating_add(parts.1.nodes().max(parts.2.nodes())),
            Self::Bind(_, args, body) => args.iter().fold(body.nodes(), |sum, arg| sum.saturating_add(arg.nodes())),
            Self::Sum(_, rows, body) => {
                let count = rows.numbers.len() / rows.width.max(1);
                body.nodes().saturating_add(1).saturating_mul(count as u64)
            }
        };
        inner.saturating_add(1)
    }

    fn run(&self, slots: &mut [f64], steps: &mut u64) -> Option<f64> {
        let result = match self {
            Self::Constant(number) => return Some(*number),
            Self::Slot(slot) => return slots.get(*slot).copied(),
            Self::Negative(of) => -of.run(slots, steps)?,
            Self::Arithmetic(operator, both) => {
                let (a, b) = (both.0.run(slots, steps)?, both.1.run(slots, steps)?);
                match operator {
                    Binary::Add => a + b,
                    Binary::Subtract => a - b,
                    Binary::Multiply => a * b,
                    Binary::Divide if b != 0.0 => a / b,
                    _ => return None,
                }
            }
            Self::One(_, function, of) => function(of.run(slots, steps)?),
            Self::Two(function, both) => function(both.0.run(slots, steps)?, both.1.run(slots, steps)?),
            Self::If(parts) => {
                let chosen = if parts.0.run(slots, steps)? { &parts.1 } else { &parts.2 };
                return chosen.run(slots, steps);
            }
            Self::Bind(first, args, body) => {
                *steps += 1;
                for (at, arg) in args.iter().enumerate() {
                    let value = arg.run(slots, steps)?;
                    *slots.get_mut(first + at)? = value;
                }
                return body.run(slots, steps);
            }
            Self::Sum(first, rows, body) => {
                let mut sum: f64 = std::iter::empty::<f64>().sum();
                for row in rows.numbers.chunks_exact(rows.width) {
                    *steps += 1;
                    slots.get_mut(*first..first + rows.width)?.copy_from_slice(row);
                    sum += body.run(slots, steps)?;
                }
                sum
            }
        };
        result.is_finite().then_some(result)
    }
}

impl Test {
    fn nodes(&self) -> u64 {
        let inner = match self {
            Self::Order(_, both) => both.0.nodes().saturating_add(both.1.nodes()),
            Self::Logic(_, both) => both.0.nodes().saturating_add(both.1.nodes()),
            Self::Not(of) => of.nodes(),
        };
        inner.saturating_add(1)
    }

    fn run(&self, slots: &mut [f64], steps: &mut u64) -> Option<bool> {
        match self {
            Self::Order(operator, both) => {
                let (a, b) = (both.0.run(slots, steps)?, both.1.run(slots, steps)?);
                match operator {
                    Binary::Less => Some(a < b),
                    Binary::LessEqual => Some(a <= b),
                    Binary::Greater => Some(a > b),
                    Binary::GreaterEqual => Some(a >= b),
                    _ => None,
                }
            }
            // Both sides are computed, as the interpreter does: an error in either is one.
            Self::Logic(operator, both) => {
                let (a, b) = (both.0.run(slots, steps)?, both.1.run(slots, steps)?);
                Some(if *operator == Binary::And { a && b } else { a || b })
            }
            Self::Not(of) => of.run(slots, steps).map(|value| !value),
        }
    }
}

/// What names mean within a function.
struct Scope<'a> {
    captured: &'a BTreeMap<String, Value>,
    slots: Vec<(&'a str, usize, Unit)>,
}

/// Translates; none for everything that is not arithmetic.
struct Writer {
    slots: usize,
    nodes: usize,
    depth: usize,
}

impl Writer {
    fn slot(&mut self) -> usize {
        self.slots += 1;
        self.slots - 1
    }

    fn expr(&mut self, scope: &Scope<'_>, expr: &Expr) -> Option<(Node, Unit)> {
        self.nodes += 1;
        if self.nodes > MOST_NODES {
            return None;
        }
        match &expr.kind {
            ExprKind::Number(number) => Some((Node::Constant(*number), Unit::Number)),
            ExprKind::Unit(number, unit) => match unit.as_str() {
                "deg" => Some((Node::Constant(*number), Unit::Angle)),
                "rad" => Some((Node::Constant(number.to_degrees()), Unit::Angle)),
                _ => None,
            },
            ExprKind::Name(name) => Self::name(scope, name),
            ExprKind::Member(of, member) => {
                let ExprKind::Name(name) = &of.kind else { return None };
                let Some(Value::Vector(parts)) = scope.captured.get(name) else { return None };
                let at = ["x", "y", "z"].iter().position(|known| *known == member.text)?;
                Some((Node::Constant(*parts.get(at)?), Unit::Number))
            }
            ExprKind::Unary(Unary::Minus, of) => {
                let (of, unit) = self.expr(scope, of)?;
                Some((Node::Negative(Box::new(of)), unit))
            }
            ExprKind::Binary(operator, _, both) => {
                let (a, left) = self.expr(scope, &both.0)?;
                let (b, right) = self.expr(scope, &both.1)?;
                let unit = match (operator, left, right) {
                    (Binary::Add | Binary::Subtract, one, other) if one == other => one,
                    (Binary::Multiply, Unit::Number, unit)
                    | (Binary::Multiply | Binary::Divide, unit, Unit::Number) => unit,
                    (Binary::Divide, Unit::Angle, Unit::Angle) => Unit::Number,
                    _ => return None,
                };
                Some((Node::Arithmetic(*operator, Box::new((a, b))), unit))
            }
            ExprKind::If(parts) => {
                let test = self.test(scope, &parts.0)?;
                let ((a, unit), (b, other)) = (self.expr(scope, &parts.1)?, self.expr(scope, &parts.2)?);
                (unit == other).then(|| (Node::If(Box::new((test, a, b))), unit))
            }
            ExprKind::Call(call) => self.call(scope, call),
            _ => None,
        }
    }

    fn test(&mut self, scope: &Scope<'_>, expr: &Expr) -> Option<Test> {
        match &expr.kind {
            ExprKind::Unary(Unary::Not, of) => Some(Test::Not(Box::new(self.test(scope, of)?))),
            ExprKind::Binary(operator @ (Binary::And | Binary::Or), _, both) => {
                Some(Test::Logic(*operator, Box::new((self.test(scope, &both.0)?, self.test(scope, &both.1)?))))
            }
            ExprKind::Binary(operator, _, both) => {
                let order =
                    matches!(operator, Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual);
                let ((a, left), (b, right)) = (self.expr(scope, &both.0)?, self.expr(scope, &both.1)?);
                (order && left == right).then(|| Test::Order(*operator, Box::new((a, b))))
            }
            _ => None,
        }
    }

    fn name(scope: &Scope<'_>, name: &str) -> Option<(Node, Unit)> {
        if let Some((_, slot, unit)) = scope.slots.iter().rev().find(|(known, _, _)| *known == name) {
            return Some((Node::Slot(*slot), *unit));
        }
        match scope.captured.get(name) {
            Some(Value::Number(number)) => Some((Node::Constant(*number), Unit::Number)),
            Some(Value::Angle(angle)) => Some((Node::Constant(*angle), Unit::Angle)),
            None if name == "PI" => Some((Node::Constant(std::f64::consts::PI), Unit::Number)),
            _ => None,
        }
    }

    fn call(&mut self, scope: &Scope<'_>, call: &Call) -> Option<(Node, Unit)> {
        let Call { name, piped: None, args, span: _ } = call else { return None };
        if args.iter().any(|arg| arg.label.is_some()) {
            return None;
        }
        match scope.captured.get(&name.text) {
            Some(Value::Function(function)) => return self.inline(scope, call, function),
            Some(_) => return None,
            None => {}
        }
        if let ("sum", [list]) = (name.text.as_str(), args.as_slice()) {
            let ExprKind::Comprehension(clauses, body) = &list.value.kind else { return None };
            let [clause] = clauses.as_slice() else { return None };
            return self.sum(scope, clause, body);
        }
        match args.as_slice() {
            [of] => {
                let (_, takes, gives, function) = ONE.iter().find(|(known, ..)| *known == name.text)?;
                let (of, unit) = self.expr(scope, &of.value)?;
                let kind = match name.text.as_str() {
                    "sin" => Kind::Sine,
                    "cos" => Kind::Cosine,
                    _ => Kind::Other,
                };
                (unit == *takes).then(|| (Node::One(kind, *function, Box::new(of)), *gives))
            }
            [a, b] => {
                let (_, function) = TWO.iter().find(|(known, _)| *known == name.text)?;
                let ((a, left), (b, right)) = (self.expr(scope, &a.value)?, self.expr(scope, &b.value)?);
                let numbers = (left, right) == (Unit::Number, Unit::Number);
                numbers.then(|| (Node::Two(*function, Box::new((a, b))), Unit::Number))
            }
            _ => None,
        }
    }

    /// A user's function, written out in place.
    fn inline(&mut self, scope: &Scope<'_>, call: &Call, function: &Function) -> Option<(Node, Unit)> {
        let (body, names, captured) = function.numeric()?;
        if self.depth >= INLINE_DEPTH || names.len() != call.args.len() {
            return None;
        }
        let mut args = Vec::new();
        for arg in &call.args {
            let (arg, Unit::Number) = self.expr(scope, &arg.value)? else { return None };
            args.push(arg);
        }
        let first = self.slots;
        let slots = names.into_iter().map(|name| (name, self.slot(), Unit::Number)).collect();
        self.depth += 1;
        let made = self.expr(&Scope { captured, slots }, body);
        self.depth -= 1;
        let (body, unit) = made?;
        Some((Node::Bind(first, args, Box::new(body)), unit))
    }

    /// `sum([for pattern in list: body])` over a list that is known when the function is declared.
    fn sum(&mut self, scope: &Scope<'_>, clause: &Clause, body: &Expr) -> Option<(Node, Unit)> {
        let ExprKind::Name(list) = &clause.over.kind else { return None };
        if scope.slots.iter().any(|(known, _, _)| known == list) {
            return None;
        }
        let Some(Value::List(items)) = scope.captured.get(list) else { return None };
        let width = clause.names.len().max(1);
        let mut numbers = Vec::with_capacity(items.len() * width);
        for item in items.iter() {
            match item {
                Value::Number(number) if !clause.tuple => numbers.push(*number),
                Value::Vector(parts) if clause.tuple && parts.len() == width => numbers.extend_from_slice(parts),
                _ => return None,
            }
        }
        // A name that is declared already is an error, which the interpreter reports.
        let taken =
            |name: &str| scope.captured.contains_key(name) || scope.slots.iter().any(|(known, ..)| *known == name);
        if clause.names.iter().any(|name| taken(&name.text)) {
            return None;
        }
        let first = self.slots;
        let mut slots = scope.slots.clone();
        for name in &clause.names {
            slots.push((name.text.as_str(), self.slot(), Unit::Number));
        }
        let (body, Unit::Number) = self.expr(&Scope { captured: scope.captured, slots }, body)? else { return None };
        Some((Node::Sum(first, Rc::new(Rows { width, numbers }), Box::new(body)), Unit::Number))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use crate::diag::Sources;
    use crate::eval::{Overrides, evaluate};
    use crate::files::{MemoryFiles, VPath};

    /// The value of `body` at (x, y) with the function declared with or without a parameter that keeps it from being
    /// translated, and the messages of what was wrong.
    fn value(body: &str, translated: bool, (x, y): (f64, f64)) -> (Option<u64>, Vec<String>) {
        let (more, last) = if translated { ("", "") } else { (", more: bool", ", true") };
        let text = format!(
            "lts 1
scene test {{ }}
camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)
film = image(64, 64)
integrator = path(max_depth: 3)
sampler = independent(samples: 4)
let pairs = [(1, 2), (0.5, -3), (0, 1)]
let some = [2, 3, 0.25]
let c = 1.5
let turn = 30deg
let v = (4, 5, 6)
let half(a: number) = a / 2
let wave(a: number, b: number) = sin(a * turn) + sum([for (p, q) in pairs: p * b + q])
let f(x: number, y: number{more}) = {body}
shape s = box(size: 1) |> translate(x: f({x}, {y}{last})) with diffuse(0.5)
"
        );
        let mut files = MemoryFiles::default();
        files.insert("test.lts", text.as_bytes());
        let path = VPath::resolve("", "test.lts").expect("a path");
        let found = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
        let shape = found.scene.as_ref().and_then(|scene| scene.shapes.values().next());
        let x = shape.map(|shape| (shape.transform.rows[0][3] + 0.0).to_bits());
        (x, found.findings.into_iter().map(|finding| finding.message).collect())
    }

    fn number() -> impl Strategy<Value = String> {
        let leaf = prop_oneof![
            (-40..40_i32).prop_map(|n| format!("({})", f64::from(n) / 8.0)),
            prop::sample::select(vec!["x", "y", "c", "PI", "v.y", "0", "1e200"]).prop_map(str::to_owned),
            Just("sum([for w in some: w * x])".to_owned()),
            Just("sum([for (p, q) in pairs: p * x + q])".to_owned()),
        ];
        leaf.prop_recursive(4, 32, 3, |inner| {
            let one = prop::sample::select(vec![
                "-",
                "sqrt",
                "abs",
                "floor",
                "ceil",
                "round",
                "exp",
                "log",
                "half",
                "1deg / asin",
                "turn / acos",
                "atan",
            ]);
            let two = prop::sample::select(vec!["pow", "mod", "min", "max", "wave"]);
            prop_oneof![
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("({a} {o} {b})")),
                (one, inner.clone()).prop_map(|(f, a)| match f {
                    "atan" => format!("cos(atan({a}))"),
                    f => format!("({f}({a}))"),
                }),
                (two, inner.clone(), inner.clone()).prop_map(|(f, a, b)| format!("{f}({a}, {b})")),
                inner.clone().prop_map(|a| format!("sin({a} * 20deg - 0.1rad)")),
                (inner.clone(), inner.clone(), inner.clone())
                    .prop_map(|(a, b, c)| format!("(if {a} < {b} and not {c} >= 1 then {b} else {c})")),
            ]
        })
    }

    proptest! {
        #[test]
        fn programs_agree_with_the_interpreter(body in number(), x in -3..3_i32, y in -3..3_i32) {
            let at = (f64::from(x), f64::from(y) / 4.0);
            let (fast, slow) = (value(&body, true, at), value(&body, false, at));
            prop_assert_eq!(fast, slow, "{}", body);
        }
    }

    /// The heights of a field of 15 x 11 vertices, and the messages of what was wrong, with the function translated or not.
    fn heights(body: &str, translated: bool, steps: u64) -> (Vec<u32>, Vec<String>) {
        let (name, more) = if translated { ("f", "") } else { ("g", "let g(x: number, y: number) = [f(x, y), 0][0]") };
        let text = format!(
            "lts 1
scene test {{ }}
camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)
film = image(64, 64)
integrator = path(max_depth: 3)
sampler = independent(samples: 4)
let pairs = [(1, 2), (0.5, -3), (0, 1)]
let some = [2, 3, 0.25]
let c = 1.5
let turn = 30deg
let v = (4, 5, 6)
let half(a: number) = a / 2
let wave(a: number, b: number) = sin(a * turn) + sum([for (p, q) in pairs: p * b + q])
let f(x: number, y: number) = {body}
{more}
shape s = height_field({name}, x: -2..1.5, y: -3..2, vertices: (15, 11)) with diffuse(0.5)
"
        );
        let mut files = MemoryFiles::default();
        files.insert("test.lts", text.as_bytes());
        let path = VPath::resolve("", "test.lts").expect("a path");
        let mut overrides = Overrides::default();
        overrides.limits.steps = steps;
        let found = evaluate(&files, &mut Sources::default(), &path, &overrides);
        let mesh = found.scene.as_ref().and_then(|scene| scene.meshes.values().next());
        let z = mesh.map(|mesh| mesh.positions.iter().map(|position| position[2].to_bits()).collect());
        let errors = found.findings.into_iter().filter(|finding| finding.severity == crate::diag::Severity::Error);
        (z.unwrap_or_default(), errors.map(|finding| finding.message).collect())
    }

    proptest! {
        #[test]
        fn many_places_at_once_agree_with_one_after_the_other(body in number()) {
            // The second shows the last bits of a number, which heights round away.
            for body in [body.clone(), format!("mod(({body}) * 1073741824, 1)")] {
                let (fast, slow) = (heights(&body, true, 1 << 40), heights(&body, false, 1 << 40));
                // The field's own error names the place; the interpreter's is about the body in both.
                prop_assert_eq!(fast, slow, "{}", body);
            }
        }
    }

    #[test]
    fn steps_are_counted_for_many_places_as_for_one() {
        // 1 for each vertex, and 3 for its sum; a call of `wave` and the 3 of its sum more.
        for (body, each) in [("sum([for w in some: w * x])", 4), ("wave(x, y) + sum([for w in some: w * x])", 8)] {
            let steps = |steps| heights(body, true, steps).1.len();
            assert_eq!((steps(each * 165), steps(each * 165 - 1)), (0, 1), "{body}");
        }
        assert_eq!(heights("if x < 0 then 1 / x else x", true, 165).1, Vec::<String>::new(), "one place at a time");
    }

    #[test]
    fn bodies_of_numbers_are_translated() {
        use super::Program;
        use crate::eval::value::Value;
        let mut steps = 0;
        let node = |node| Program { slots: 1, body: node, unit: super::Unit::Number, units: 1 };
        let twice = super::Node::Arithmetic(
            crate::syntax::Binary::Multiply,
            Box::new((super::Node::Slot(0), super::Node::Constant(2.0))),
        );
        let result = node(twice).run(&[Value::Number(21.0)], &mut steps);
        assert!(matches!(result, Some(Value::Number(n)) if n == 42.0));
        let (value, findings) = value("wave(half(x), y) + sum([for w in some: w])", true, (2.0, 1.0));
        assert_eq!((value.map(f64::from_bits), findings), (Some(0.5 + 1.5 + 0.0 + 5.25), vec![]));
    }
}
