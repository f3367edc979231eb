//! Statements of a test case in LuxCore's properties: the statement and the parameter's name joined are a key of `scene.cfg`.
//!
//! A statement replaces all settings whose keys begin with its name. Types are not said in LuxCore, and not looked at.

use std::io::{self, Write};

use crate::diag::Finding;
use crate::formats::shared::number::Num;
use crate::formats::statements::{Parameter, Statement, Statements, Value, is_word, side};

/// The size of the film where a file gives none (`film.cpp`).
pub const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// The setting that names the scene's file.
pub const SCENE_FILE: &str = "scene.file";

/// The key of a parameter.
fn key(statement: &Statement, parameter: &Parameter) -> String {
    if parameter.name.is_empty() { statement.name.clone() } else { format!("{}.{}", statement.name, parameter.name) }
}

/// What cannot be written.
pub fn check(statements: &Statements) -> Vec<Finding> {
    let mut findings = statements.wrong();
    for statement in statements.iter() {
        for one in &statement.parameters {
            let key = key(statement, one);
            if !key.split('.').all(|part| !part.is_empty() && is_word(&format!("_{part}"), "-")) {
                findings.push(statement.invalid(format!("makes the key `{key}`, which is none")));
            } else if key == SCENE_FILE {
                findings.push(statement.invalid("names the file of the scene, which is the one beside it"));
            }
            let quoted = |value: &Value| matches!(value, Value::String(text) if text.contains(['"', '\\', '\n', '\r']));
            if one.value.items().iter().any(quoted) {
                findings.push(
                    statement.invalid(format!("has a text `{}` with letters that LuxCore cannot read", one.name)),
                );
            }
        }
    }
    findings
}

/// The size of the image.
pub fn size(statements: &Statements, own: [u32; 2]) -> [u32; 2] {
    let mut size = [("film.width", 0), ("film.height", 1)]
        .map(|(key, at)| if replaced(statements, key) { DEFAULT_SIZE[at] } else { own[at] });
    for (key, value) in all(statements) {
        match key.as_str() {
            "film.width" => size[0] = side(Some(value), size[0]),
            "film.height" => size[1] = side(Some(value), size[1]),
            _ => {}
        }
    }
    size
}

fn all(statements: &Statements) -> impl Iterator<Item = (String, &Value)> {
    statements.iter().flat_map(|statement| statement.parameters.iter().map(|one| (key(statement, one), &one.value)))
}

/// Whether a setting of ltsc's is replaced by one of the statements.
pub fn replaced(statements: &Statements, key: &str) -> bool {
    key != SCENE_FILE && statements.iter().any(|statement| begins(key, &statement.name))
}

/// Whether a key is a name, or begins with it.
pub fn begins(key: &str, name: &str) -> bool {
    key.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Writes all.
pub fn write(statements: &Statements, out: &mut dyn Write) -> io::Result<()> {
    all(statements).try_for_each(|(key, value)| writeln!(out, "{key} = {}", text(value)))
}

fn text(value: &Value) -> String {
    let one = |value: &Value| match value {
        Value::Bool(value) => u8::from(*value).to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => Num(*value).to_string(),
        Value::String(value) => format!("\"{value}\""),
        Value::List(_) => String::new(),
    };
    value.items().iter().map(one).collect::<Vec<_>>().join(" ")
}
