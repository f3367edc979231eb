//! Statements of a test case in PBRT's text: directives with a type and parameters.
//!
//! A directive that stands among the settings is written in its place, every other one behind them, before the world begins. The
//! parameter `type` without a type is the directive's own, one without name and type a bare list of values, as `LookAt` takes them.

use std::io::{self, Write};

use super::names::Version;
use crate::diag::Finding;
use crate::formats::shared::number::Num;
use crate::formats::shared::text::Quoted;
use crate::formats::statements::{Kinds, Statement, Statements, Value, is_word, misspelled, other_case, side};

/// What PBRT calls the types of values.
const KINDS: Kinds = Kinds { bool: "bool", integer: "integer", float: "float", string: "string" };

/// Directives among the settings, in their order.
pub const PLACED: &[&str] = &["Scale", "LookAt", "Camera", "Film", "PixelFilter", "Sampler", "Integrator"];

/// Directives that are a list of numbers, and how many.
const COUNTS: &[(&str, usize)] = &[("Scale", 3), ("LookAt", 9)];

/// Directives that make a file, and those of the world.
const REFUSED: &[&str] = &["WorldBegin", "WorldEnd", "Include", "Import", "AttributeBegin", "AttributeEnd"];

/// The size of the film where a file gives none (`film.cpp` of both versions).
pub const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// What cannot be written.
pub fn check(version: Version, statements: &Statements) -> Vec<Finding> {
    let mut findings = statements.wrong();
    for statement in statements.iter() {
        let name = statement.name.as_str();
        if REFUSED.contains(&name) {
            findings.push(statement.invalid("has its place in the files that ltsc writes, and cannot be given"));
        } else if !is_word(name, "") {
            findings.push(statement.invalid("has a name that no directive can have"));
        }
        if let Some(meant) = other_case(name, PLACED) {
            findings.push(misspelled(statement, meant, version.target()));
        }
        let numbers = statement.parameters.iter().filter(|one| one.is_own() && one.name.is_empty());
        let numbers: usize =
            numbers.flat_map(|one| one.value.items()).filter_map(bare).map(|text| text.split(' ').count()).sum();
        if let Some((_, wanted)) = COUNTS.iter().find(|(known, wanted)| *known == name && *wanted != numbers) {
            findings.push(statement.invalid(format!("takes {wanted} numbers, and has {numbers}")));
        }
        for one in &statement.parameters {
            if one.is_own() {
                let bare = one.name.is_empty() && one.value.items().iter().all(|value| bare(value).is_some());
                let own = one.name == "type" && matches!(one.value, Value::String(_));
                if !(bare || own) {
                    let message = format!(
                        "has a parameter `{}` without a type that is neither a text called `type` nor a list without a name",
                        one.name
                    );
                    findings
                        .push(statement.invalid(message).help("PBRT has no attributes: say the type of the parameter"));
                }
                continue;
            }
            match one.kind(&KINDS) {
                Some(kind) if is_word(kind, "") && is_word(&one.name, ".-:") => {}
                Some(kind) => {
                    findings.push(
                        statement.invalid(format!("has a parameter `{kind} {}`, which PBRT cannot read", one.name)),
                    );
                }
                None => {
                    let finding = statement
                        .invalid(format!("has a list `{}` of different or no values without a type", one.name));
                    findings.push(finding.help(format!("say it: `[\"{}\", \"rgb\", [1, 2, 3]]`", one.name)));
                }
            }
        }
    }
    findings
}

/// The size of the image.
pub fn size(statements: &Statements, own: [u32; 2]) -> [u32; 2] {
    statements.find("Film").map_or(own, |film| {
        [side(film.value("xresolution"), DEFAULT_SIZE[0]), side(film.value("yresolution"), DEFAULT_SIZE[1])]
    })
}

/// Those without a place of their own.
pub fn others(statements: &Statements) -> impl Iterator<Item = &Statement> {
    statements.iter().filter(|statement| !PLACED.contains(&statement.name.as_str()))
}

/// Writes a directive.
pub fn write(version: Version, statement: &Statement, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{}", statement.name)?;
    if let Some(kind) = statement.own_type() {
        write!(out, " {}", Quoted(kind))?;
    }
    for one in statement.parameters.iter().filter(|one| one.is_own() && one.name.is_empty()) {
        for value in one.value.items() {
            write!(out, " {}", bare(value).unwrap_or_default())?;
        }
    }
    for one in statement.parameters.iter().filter(|one| !one.is_own()) {
        let kind = one.kind(&KINDS).unwrap_or_default();
        let values: Vec<String> = one.value.items().iter().map(|value| text(version, kind, value)).collect();
        write!(out, " \"{kind} {}\" [{}]", one.name, values.join(" "))?;
    }
    writeln!(out)
}

/// A value as it stands between brackets. Version 3 has its truth in quotes, version 4 refuses that.
fn text(version: Version, kind: &str, value: &Value) -> String {
    let truth = |value: &str| match version {
        Version::V3 => Quoted(value).to_string(),
        Version::V4 => value.to_owned(),
    };
    match value {
        Value::Bool(value) => truth(if *value { "true" } else { "false" }),
        Value::String(value) if kind == KINDS.bool && matches!(value.as_str(), "true" | "false") => truth(value),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => Num(*value).to_string(),
        Value::String(value) => Quoted(value).to_string(),
        Value::List(_) => String::new(),
    }
}

/// A value without quotes: numbers, also several in one text.
fn bare(value: &Value) -> Option<String> {
    match value {
        Value::Integer(value) => Some(value.to_string()),
        Value::Float(value) => Some(Num(*value).to_string()),
        Value::String(text) => {
            let numbers = crate::formats::shared::source::numbers(text, false)?;
            Some(numbers.into_iter().map(|value| Num(value).to_string()).collect::<Vec<_>>().join(" "))
        }
        Value::Bool(_) | Value::List(_) => None,
    }
}
