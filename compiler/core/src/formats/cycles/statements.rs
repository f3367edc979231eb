//! Statements of a test case as attributes of Blender's scene: `cycles` with `max_bounces` is `bpy.context.scene.cycles.max_bounces`.
//!
//! They are set behind the scene's own settings, each by itself: what a statement does not name stays. Types are not looked at.

use std::io::{self, Write};

use super::names::literal;
use crate::diag::Finding;
use crate::formats::shared::number::Num;
use crate::formats::statements::{Parameter, Statement, Statements, Value, is_word, side};

/// What attributes belong to, in the file.
pub const SCENE: &str = "bpy.context.scene.";

/// Words of Python, which cannot be names.
const WORDS: &[&str] = &[
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del",
    "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal",
    "not", "or", "pass", "raise", "return", "try", "while", "with", "yield",
];

/// The attribute of a parameter; the statement `scene` is the scene itself.
fn attribute(statement: &Statement, parameter: &Parameter) -> String {
    match statement.name.as_str() {
        "scene" => parameter.name.clone(),
        name => format!("{}.{}", name.strip_prefix("scene.").unwrap_or(name), parameter.name),
    }
}

/// What cannot be written.
pub fn check(statements: &Statements) -> Vec<Finding> {
    let mut findings = statements.wrong();
    for statement in statements.iter() {
        for one in &statement.parameters {
            let attribute = attribute(statement, one);
            // Names that begin with `_` are Python's own.
            let plain = |part: &str| is_word(part, "") && !part.starts_with('_') && !WORDS.contains(&part);
            if !attribute.split('.').all(plain) {
                let finding = statement.invalid(format!("makes the attribute `{attribute}`, which is none"));
                findings.push(finding.help(
                    "name attributes of the scene: `cycles` with `max_bounces`, `render` with `use_motion_blur`",
                ));
            }
            if attribute == "render.resolution_percentage" {
                let finding = statement.invalid("makes the image smaller than its size says");
                findings.push(finding.help("give `resolution_x` and `resolution_y` of `render` in pixels"));
            }
        }
    }
    findings
}

/// The size of the image.
pub fn size(statements: &Statements, own: [u32; 2]) -> [u32; 2] {
    let mut size = own;
    for (attribute, value) in all(statements) {
        match attribute.as_str() {
            "render.resolution_x" => size[0] = side(Some(value), size[0]),
            "render.resolution_y" => size[1] = side(Some(value), size[1]),
            _ => {}
        }
    }
    size
}

fn all(statements: &Statements) -> impl Iterator<Item = (String, &Value)> {
    statements
        .iter()
        .flat_map(|statement| statement.parameters.iter().map(|one| (attribute(statement, one), &one.value)))
}

/// Writes all.
pub fn write(statements: &Statements, out: &mut dyn Write) -> io::Result<()> {
    all(statements).try_for_each(|(attribute, value)| writeln!(out, "{SCENE}{attribute} = {}", text(value)))
}

fn text(value: &Value) -> String {
    let one = |value: &Value| match value {
        Value::Bool(value) => if *value { "True" } else { "False" }.to_owned(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => Num(*value).to_string(),
        Value::String(value) => literal(value),
        Value::List(_) => String::new(),
    };
    match value {
        Value::List(items) => match &items.iter().map(one).collect::<Vec<_>>()[..] {
            [single] => format!("({single},)"),
            several => format!("({})", several.join(", ")),
        },
        Value::Bool(_) | Value::Integer(_) | Value::Float(_) | Value::String(_) => one(value),
    }
}
