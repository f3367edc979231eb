//! Operators on values.

use std::rc::Rc;

use crate::ir::{Color, Meaning, Spectrum};
use crate::syntax::{Binary, Unary};

use super::value::Value;

/// Why an operator gives no value: the message, and what to write instead.
pub(super) struct Wrong {
    pub message: String,
    pub help: Option<String>,
}

fn wrong<T>(message: impl Into<String>) -> Result<T, Wrong> {
    Err(Wrong { message: message.into(), help: None })
}

fn wrong_help<T>(message: impl Into<String>, help: impl Into<String>) -> Result<T, Wrong> {
    Err(Wrong { message: message.into(), help: Some(help.into()) })
}

/// `value` if it is finite.
pub(super) fn finite(value: f64, what: &str) -> Result<f64, Wrong> {
    if value.is_finite() {
        return Ok(value);
    }
    wrong(format!("the result of {what} is not a finite number"))
}

/// The parts of a spectrum, which operators look at each, with what its color takes; 0 for what is small.
pub(super) fn parts(value: &Value) -> u64 {
    match value {
        Value::Color(color) => color.spectrum().map_or(0, |spectrum| spectrum.points().len() as u64 + 500),
        _ => 0,
    }
}

/// A sign before a value.
pub(super) fn unary(operator: Unary, value: &Value) -> Result<Value, Wrong> {
    match (operator, value) {
        (Unary::Minus, Value::Number(n)) => Ok(Value::Number(-n)),
        (Unary::Minus, Value::Angle(a)) => Ok(Value::Angle(-a)),
        (Unary::Minus, Value::Vector(parts)) => Ok(Value::Vector(parts.iter().map(|part| 0.0 - part).collect())),
        (Unary::Not, Value::Bool(b)) => Ok(Value::Bool(!b)),
        (Unary::Minus, other) => wrong(format!("`-` does not apply to {}", other.kind())),
        (Unary::Not, other) => wrong(format!("`not` does not apply to {}", other.kind())),
    }
}

/// An operator between two values. `and` and `or` evaluate both sides: nothing has side effects. A comparison takes as many
/// units off `left_over` as the values have parts.
pub(super) fn binary(operator: Binary, left: &Value, right: &Value, left_over: &mut u64) -> Result<Value, Wrong> {
    match operator {
        Binary::Range => range(left, right),
        Binary::Or | Binary::And => logic(operator, left, right),
        Binary::Equal | Binary::NotEqual => equality(operator, left, right, left_over),
        Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual => order(operator, left, right),
        Binary::Add | Binary::Subtract => sum(operator, left, right),
        Binary::Multiply => product(left, right),
        Binary::Divide => quotient(left, right),
    }
}

fn mismatch<T>(operator: Binary, left: &Value, right: &Value) -> Result<T, Wrong> {
    let message = format!("`{}` does not apply to {} and {}", operator.sign(), left.kind(), right.kind());
    match (operator, left, right) {
        (_, Value::Angle(_), Value::Number(n)) | (_, Value::Number(n), Value::Angle(_)) => {
            wrong_help(message, format!("give both sides a unit: {}", super::expr::unit_help(*n)))
        }
        (Binary::Add, Value::String(_), Value::String(_)) => {
            wrong_help(message, "texts are not joined; list them: `for file in [\"a.ply\", \"b.ply\"] { ... }`")
        }
        (Binary::Add, Value::List(_), Value::List(_)) => wrong_help(message, "write `concat(a, b)`"),
        (Binary::Multiply, Value::Mesh(_), _) | (Binary::Add, Value::Mesh(_), _) => {
            wrong_help(message, "meshes are moved and changed by stages: `... |> scale(2) |> translate(z: 1)`")
        }
        _ => wrong(message),
    }
}

fn range(left: &Value, right: &Value) -> Result<Value, Wrong> {
    match (left, right) {
        (Value::Number(lo), Value::Number(hi)) => Ok(Value::Range(*lo, *hi)),
        (Value::Angle(_), Value::Angle(_)) => wrong_help(
            "a range has numbers at its ends, not angles",
            "count in numbers and multiply: `[for i in 0..9: i * 10deg]`",
        ),
        _ => mismatch(Binary::Range, left, right),
    }
}

fn logic(operator: Binary, left: &Value, right: &Value) -> Result<Value, Wrong> {
    match (left, right) {
        (Value::Bool(a), Value::Bool(b)) => Ok(Value::Bool(if operator == Binary::And { *a && *b } else { *a || *b })),
        _ => mismatch(operator, left, right),
    }
}

fn equality(operator: Binary, left: &Value, right: &Value, left_over: &mut u64) -> Result<Value, Wrong> {
    match compare(left, right, left_over) {
        _ if *left_over == 0 => wrong("the values have too many parts to be compared"),
        Some(equal) => Ok(Value::Bool(equal == (operator == Binary::Equal))),
        None => mismatch(operator, left, right),
    }
}

/// Whether two values of the same type are equal; none for types that cannot be compared. Meaningless where nothing is left
/// over: lists of lists share their parts, and can be larger than any memory.
pub(super) fn compare(left: &Value, right: &Value, left_over: &mut u64) -> Option<bool> {
    let parts = match left {
        Value::String(text) => 1 + text.len() as u64 / 16,
        Value::Color(color) => 1 + color.spectrum().map_or(0, |spectrum| spectrum.points().len() as u64),
        _ => 1,
    };
    *left_over = left_over.saturating_sub(parts);
    if *left_over == 0 {
        return Some(false);
    }
    match (left, right) {
        (Value::Number(a), Value::Number(b)) | (Value::Angle(a), Value::Angle(b)) => Some(a == b),
        (Value::Bool(a), Value::Bool(b)) => Some(a == b),
        (Value::String(a), Value::String(b)) => Some(a == b),
        (Value::Vector(a), Value::Vector(b)) => (a.len() == b.len()).then(|| a == b),
        (Value::Range(a, b), Value::Range(c, d)) => Some(a == c && b == d),
        (Value::Color(a), Value::Color(b)) => Some(match (a.spectrum(), b.spectrum()) {
            (Some(a), Some(b)) => a.points() == b.points(),
            (None, None) => a.rgb() == b.rgb(),
            (Some(_), None) | (None, Some(_)) => false,
        }),
        (Value::List(a), Value::List(b)) | (Value::Tuple(a), Value::Tuple(b)) => {
            if a.len() != b.len() {
                return Some(false);
            }
            for (x, y) in a.iter().zip(b.iter()) {
                match compare(x, y, left_over) {
                    Some(true) => {}
                    other => return other,
                }
            }
            Some(true)
        }
        _ => None,
    }
}

fn order(operator: Binary, left: &Value, right: &Value) -> Result<Value, Wrong> {
    let ((Value::Number(a), Value::Number(b)) | (Value::Angle(a), Value::Angle(b))) = (left, right) else {
        return mismatch(operator, left, right);
    };
    Ok(Value::Bool(match operator {
        Binary::Less => a < b,
        Binary::LessEqual => a <= b,
        Binary::Greater => a > b,
        _ => a >= b,
    }))
}

fn sum(operator: Binary, left: &Value, right: &Value) -> Result<Value, Wrong> {
    let apply = |a: f64, b: f64| finite(if operator == Binary::Add { a + b } else { a - b }, "this sum");
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Number(apply(*a, *b)?)),
        (Value::Angle(a), Value::Angle(b)) => Ok(Value::Angle(apply(*a, *b)?)),
        (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => {
            let parts: Result<Rc<[f64]>, Wrong> = a.iter().zip(b.iter()).map(|(a, b)| apply(*a, *b)).collect();
            Ok(Value::Vector(parts?))
        }
        (Value::Color(a), Value::Color(b)) if a.spectrum().is_some() || b.spectrum().is_some() => {
            let (Some(a), Some(b)) = (a.spectrum(), b.spectrum()) else {
                return wrong_help(
                    "a spectrum and an RGB color have no sum",
                    "write both as `spectrum(...)`, or both as `rgb(...)`",
                );
            };
            let mut wavelengths: Vec<f64> =
                a.points().iter().chain(b.points()).map(|(wavelength, _)| *wavelength).collect();
            wavelengths.sort_by(f64::total_cmp);
            wavelengths.dedup();
            let point = |wavelength: f64| Ok((wavelength, apply(a.value(wavelength), b.value(wavelength))?));
            let points: Result<Vec<(f64, f64)>, Wrong> = wavelengths.into_iter().map(point).collect();
            Ok(Value::Color(Color::Spectrum(Spectrum::new(&points?, Meaning::Share))))
        }
        (Value::Color(a), Value::Color(b)) => {
            let (a, b) = (a.rgb(), b.rgb());
            Ok(Value::Color(Color::Rgb([apply(a[0], b[0])?, apply(a[1], b[1])?, apply(a[2], b[2])?])))
        }
        _ => mismatch(operator, left, right),
    }
}

fn product(left: &Value, right: &Value) -> Result<Value, Wrong> {
    let apply = |a: f64, b: f64| finite(a * b, "this product");
    match (left, right) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Number(apply(*a, *b)?)),
        (Value::Number(a), Value::Angle(b)) | (Value::Angle(b), Value::Number(a)) => Ok(Value::Angle(apply(*a, *b)?)),
        (Value::Number(a), Value::Vector(b)) | (Value::Vector(b), Value::Number(a)) => {
            let parts: Result<Rc<[f64]>, Wrong> = b.iter().map(|part| apply(*a, *part)).collect();
            Ok(Value::Vector(parts?))
        }
        (Value::Number(a), Value::Color(b)) | (Value::Color(b), Value::Number(a)) => Ok(Value::Color(match b {
            Color::Grey(grey) => Color::Grey(apply(*a, *grey)?),
            Color::Rgb([r, g, b]) => Color::Rgb([apply(*a, *r)?, apply(*a, *g)?, apply(*a, *b)?]),
            Color::Spectrum(spectrum) => scaled(spectrum, |value| apply(*a, value))?,
        })),
        (Value::Vector(_), Value::Vector(_)) => wrong_help(
            "`*` does not apply to two vectors",
            "write `dot(a, b)`, `cross(a, b)`, or the product by component",
        ),
        _ => mismatch(Binary::Multiply, left, right),
    }
}

/// A spectrum whose values are changed.
fn scaled(spectrum: &Spectrum, change: impl Fn(f64) -> Result<f64, Wrong>) -> Result<Color, Wrong> {
    let point = |(wavelength, value): &(f64, f64)| Ok((*wavelength, change(*value)?));
    let points: Result<Vec<(f64, f64)>, Wrong> = spectrum.points().iter().map(point).collect();
    Ok(Color::Spectrum(Spectrum::new(&points?, Meaning::Share)))
}

fn quotient(left: &Value, right: &Value) -> Result<Value, Wrong> {
    let apply = |a: f64, b: f64| if b == 0.0 { wrong("division by zero") } else { finite(a / b, "this division") };
    match (left, right) {
        (Value::Number(a), Value::Number(b)) | (Value::Angle(a), Value::Angle(b)) => Ok(Value::Number(apply(*a, *b)?)),
        (Value::Angle(a), Value::Number(b)) => Ok(Value::Angle(apply(*a, *b)?)),
        (Value::Vector(a), Value::Number(b)) => {
            let parts: Result<Rc<[f64]>, Wrong> = a.iter().map(|part| apply(*part, *b)).collect();
            Ok(Value::Vector(parts?))
        }
        (Value::Color(a), Value::Number(b)) => Ok(Value::Color(match a {
            Color::Grey(grey) => Color::Grey(apply(*grey, *b)?),
            Color::Rgb([x, y, z]) => Color::Rgb([apply(*x, *b)?, apply(*y, *b)?, apply(*z, *b)?]),
            Color::Spectrum(spectrum) => scaled(spectrum, |value| apply(value, *b))?,
        })),
        _ => mismatch(Binary::Divide, left, right),
    }
}
