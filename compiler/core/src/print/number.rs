//! Numbers, vectors, angles and strings as the language writes them: the shortest text that reads back as the same value.

use std::fmt::{Display, LowerExp};

/// A number. 0 and -0 are one.
///
/// Numbers of usual sizes are plain, others have the shorter of the two notations; what is not finite, which the language cannot say,
/// is 0.
pub(super) fn number<T: Display + LowerExp + Into<f64> + Copy>(value: T) -> String {
    let double: f64 = value.into();
    if double == 0.0 || !double.is_finite() {
        return "0".to_owned();
    }
    let plain = format!("{value}");
    if (1e-4..1e9).contains(&double.abs()) {
        return plain;
    }
    let exponent = format!("{value:e}");
    if exponent.len() < plain.len() { exponent } else { plain }
}

/// A number of single precision as it is written, and the number that the language reads there.
pub(super) fn single(value: f32) -> (String, f64) {
    let text = number(value);
    let read = text.parse().unwrap_or_default();
    (text, read)
}

/// An angle in degrees.
pub(super) fn angle(degrees: f64) -> String {
    number(degrees) + "deg"
}

/// `(1, 2, 3)`
pub(super) fn vector(parts: &[f64]) -> String {
    let parts: Vec<String> = parts.iter().map(|part| number(*part)).collect();
    format!("({})", parts.join(", "))
}

/// A vector, by its axis where it is one of the six unit vectors along the axes.
pub(super) fn direction(parts: [f64; 3]) -> String {
    let mut along = (0..3).filter(|at| parts[*at] != 0.0);
    match (along.next(), along.next()) {
        (Some(at), None) if parts[at] == 1.0 => ["X", "Y", "Z"][at].to_owned(),
        (Some(at), None) if parts[at] == -1.0 => ["-X", "-Y", "-Z"][at].to_owned(),
        _ => vector(&parts),
    }
}

/// A string in its quotes.
pub(super) fn string(text: &str) -> String {
    let mut made = String::with_capacity(text.len() + 2);
    made.push('"');
    for letter in text.chars() {
        match letter {
            '"' | '\\' => made.extend(['\\', letter]),
            '\n' => made.push_str("\\n"),
            control if control.is_control() => made.push_str(&format!("\\u{{{:x}}}", u32::from(control))),
            other => made.push(other),
        }
    }
    made.push('"');
    made
}

/// Numbers near `value`, those with the fewest digits first, and at last the number itself.
pub(super) fn rounder(value: f64) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::with_capacity(5);
    for digits in [3, 6, 9, 13] {
        let near: f64 = format!("{value:.digits$e}").parse().unwrap_or(value);
        if !found.contains(&near) {
            found.push(near);
        }
    }
    if !found.contains(&value) {
        found.push(value);
    }
    found
}
