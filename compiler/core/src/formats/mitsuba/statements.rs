//! Statements of a test case in Mitsuba's XML: elements, whose parameters are elements with a name and a value.
//!
//! `integrator` stands in the scene, `sampler` and `film` in the sensor, `rfilter` in the film, and every other one at the end of the
//! scene. A parameter without a type is an attribute of the element. The film's own filter is a statement of its own, and stays.

use std::io::{self, Write};

use super::names::Version;
use crate::diag::Finding;
use crate::formats::shared::number::Num;
use crate::formats::shared::text::Xml;
use crate::formats::statements::{
    Kinds, Parameter, Statement, Statements, Value, is_word, misspelled, other_case, side,
};

/// What Mitsuba calls the types of values.
const KINDS: Kinds = Kinds { bool: "boolean", integer: "integer", float: "float", string: "string" };

/// Statements that have a place of their own.
const PLACED: &[&str] = &["integrator", "sampler", "film", "rfilter"];

/// Elements that make a file, and the camera: its place is no parameter.
const REFUSED: &[&str] = &["scene", "include", "default", "alias", "sensor", "path"];

/// The size of the film where a file gives none (`film.cpp` of all versions).
pub const DEFAULT_SIZE: [u32; 2] = [768, 576];

/// Samples of a pixel where a sampler gives none (the samplers of 0.6; `sampler.cpp` of 3.9.1).
pub const DEFAULT_SAMPLES: u32 = 4;

/// What cannot be written.
pub fn check(version: Version, statements: &Statements) -> Vec<Finding> {
    let mut findings = statements.wrong();
    for statement in statements.iter() {
        let name = statement.name.as_str();
        if REFUSED.contains(&name) {
            let finding = statement.invalid("has its place in the files that ltsc writes, and cannot be given");
            findings.push(
                finding
                    .help("give `integrator`, `sampler`, `film`, `rfilter`, or what belongs at the end of the scene"),
            );
        } else if !is_word(name, ".-") {
            findings.push(statement.invalid("has a name that no element can have"));
        }
        if let Some(meant) = other_case(name, PLACED) {
            findings.push(misspelled(statement, meant, version.target()));
        }
        for one in &statement.parameters {
            if one.is_own() {
                if !is_word(&one.name, ".-") {
                    findings
                        .push(statement.invalid(format!("has an attribute `{}`, which none can be called", one.name)));
                }
                continue;
            }
            match (&one.value, one.kind(&KINDS)) {
                (Value::List(_), _) if one.kind.is_none() => {
                    let finding = statement.invalid(format!("has a list `{}` without a type", one.name));
                    findings.push(finding.help(format!("say it: `[\"{}\", \"rgb\", [1, 2, 3]]`", one.name)));
                }
                (_, Some(kind)) if is_word(kind, ".-") => {}
                (_, kind) => {
                    let kind = kind.unwrap_or_default();
                    findings.push(statement.invalid(format!("has a parameter of the type `{kind}`, which is no word")));
                }
            }
        }
    }
    findings
}

/// The size of the image.
pub fn size(statements: &Statements, own: [u32; 2]) -> [u32; 2] {
    statements
        .find("film")
        .map_or(own, |film| [side(film.value("width"), DEFAULT_SIZE[0]), side(film.value("height"), DEFAULT_SIZE[1])])
}

/// Those without a place of their own.
pub fn others(statements: &Statements) -> impl Iterator<Item = &Statement> {
    statements.iter().filter(|statement| !PLACED.contains(&statement.name.as_str()))
}

/// The number of samples and the seed that a sampler says, with the name of the seed if it has one. Both are written as defaults,
/// which the command line replaces.
pub fn sampling(version: Version, sampler: &Statement) -> (i64, Option<(&'static str, i64)>) {
    let names = version.names();
    let samples = sampler.value(names.sample_count).and_then(Value::integer).unwrap_or(DEFAULT_SAMPLES.into());
    let seed = names.seed.or_else(|| (sampler.own_type() == Some("sobol")).then_some("scramble"));
    let seed = seed.map(|name| (name, sampler.value(name).and_then(Value::integer).unwrap_or(0)));
    (samples, seed)
}

/// Writes an element with what stands in it beside its parameters; values of `instead` are written for those of that name, and added
/// where the statement has none.
pub fn write(
    statement: &Statement,
    depth: usize,
    instead: &[(&str, &str)],
    out: &mut dyn Write,
    inner: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let tabs = "\t".repeat(depth);
    write!(out, "{tabs}<{}", statement.name)?;
    for one in statement.parameters.iter().filter(|one| one.is_own()) {
        write!(out, " {}=\"{}\"", one.name, Xml(&text(&one.value)))?;
    }
    let mut body = Vec::new();
    let parameters: Vec<&Parameter> = statement.parameters.iter().filter(|one| !one.is_own()).collect();
    let parameter = |kind: &str, name: &str, value: &str, body: &mut Vec<u8>| {
        writeln!(body, "{tabs}\t<{kind} name=\"{}\" value=\"{}\"/>", Xml(name), Xml(value))
    };
    for one in &parameters {
        let value = match instead.iter().find(|(name, _)| *name == one.name && one.value.integer().is_some()) {
            Some((_, value)) => (*value).to_owned(),
            None => text(&one.value),
        };
        parameter(one.kind(&KINDS).unwrap_or_default(), &one.name, &value, &mut body)?;
    }
    for (name, value) in instead.iter().filter(|(name, _)| parameters.iter().all(|one| one.name != *name)) {
        parameter(KINDS.integer, name, value, &mut body)?;
    }
    inner(&mut body)?;
    if body.is_empty() {
        return writeln!(out, "/>");
    }
    writeln!(out, ">")?;
    out.write_all(&body)?;
    writeln!(out, "{tabs}</{}>", statement.name)
}

/// A value as Mitsuba reads it; a list is `x, y, z`.
fn text(value: &Value) -> String {
    let one = |value: &Value| match value {
        Value::Bool(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => Num(*value).to_string(),
        Value::String(value) => value.clone(),
        Value::List(_) => String::new(),
    };
    value.items().iter().map(one).collect::<Vec<_>>().join(", ")
}
