//! `ltsc explain`: pages of rules, findings, constructors and targets.

use ltsc_core::capability::{Feature, Support};
use ltsc_core::diag::{CODES, WORDS, nearest};
use ltsc_core::eval::{Constructor, Family, table};
use ltsc_core::lint;
use ltsc_core::manual::Proof;

use crate::args::Explain;
use crate::output::{Exit, Failure};
use crate::project;
use crate::terminal;

use super::conventions::measured_by;

/// The statements of the language, each by an example.
const STATEMENTS: &[(&str, &str)] = &[
    ("lts", "The version of the language, first in the file.\n\n    lts 1"),
    ("scene", "The header, which makes the file a scene.\n\n    scene ball { paths: [\"LSSDE\"] }"),
    ("use", "Names from a library.\n\n    use white, red as rot from \"lib/cornell.lts\""),
    ("let", "A value, or a function.\n\n    let size = 2\n    let half(x: number) = x / 2"),
    (
        "material",
        "A material, or a function that makes one.\n\n    material gold(alpha: number) = conductor(eta: 0.2, k: 3, alpha: alpha)",
    ),
    ("mesh", "A mesh; stages move and change it.\n\n    mesh ring = torus(major: 9, minor: 0.5) |> rotate(x: 90deg)"),
    ("texture", "An image on a surface.\n\n    texture oak = bitmap(\"oak.png\")"),
    (
        "group",
        "Shapes that lie together, placed by `instance`.\n\n    group lamp { shape foot = box(size: 1) with grey }",
    ),
    ("shape", "A mesh with a material.\n\n    shape ball = sphere(radius: 1) |> translate(z: 1) with diffuse(0.5)"),
    (
        "emitter",
        "A mesh that emits, or a light without a surface.\n\n    emitter lamp = rectangle(x: -1..1, y: -1..1, z: 6, normal: -Z) with radiance(20)",
    ),
    ("instance", "A group at a place.\n\n    instance lamp = lamp |> translate(x: 3)"),
    (
        "param",
        "A value that `--set` may change.\n\n    param alpha: number = 0.1 in 0.01..1\n    param turn: angle = 30deg in 0deg..90deg",
    ),
    (
        "for",
        "Statements for each element; both ends belong to a range.\n\n    for i in 0..8 { shape a = box(size: 1) |> translate(x: 2 * i) with grey }",
    ),
    (
        "if",
        "Statements, or a value, by a condition.\n\n    if i == 0 { shape a = ... } else { shape b = ... }\n    let x = if i == 0 then 5 else 4",
    ),
    (
        "with",
        "Gives a shape its material and an emitter its radiance; it comes after all stages.\n\n    shape a = box(size: 1) |> translate(z: 3) with grey",
    ),
    (
        "allow",
        "Accepts a finding of the next statement, with the reason.\n\n    allow smooth-emitter \"the bulb of the scan\"",
    ),
];

pub fn run(command: &Explain) -> Result<Exit, Failure> {
    match (&command.what, &command.target) {
        (Some(_), Some(_)) => Err(Failure::new(Exit::Usage, "a code and a target are both given")),
        (None, Some(target)) => explain_target(target),
        (Some(what), None) => explain(what),
        (None, None) => {
            terminal::print(&contents());
            Ok(Exit::Done)
        }
    }
}

fn explain(what: &str) -> Result<Exit, Failure> {
    let mut pages = Vec::new();
    if let Some(rule) = lint::find(what) {
        pages.push(format!("{} (level: {})\n{}\n\n{}", rule.id, rule.level.word(), rule.summary, rule.doc.trim_end()));
    }
    if let Some(code) = CODES.iter().find(|code| code.id == what) {
        pages.push(format!("{}\n{}", code.id, code.doc));
    }
    if ltsc_core::fix::codes().any(|id| id == what) {
        pages.push(
            "`ltsc lint --fix` mends it where there is one right answer; `--diff` shows what it would write."
                .to_owned(),
        );
    }
    pages.extend(table().filter(|row| row.name == what).map(page));
    pages.extend(
        STATEMENTS.iter().filter(|(word, _)| *word == what).map(|(word, text)| format!("{word} (a statement)\n{text}")),
    );
    pages.extend(
        WORDS.iter().filter(|(word, _)| *word == what).map(|(word, text)| format!("{word} (in output)\n{text}")),
    );
    if pages.is_empty()
        && let Some(ours) = ltsc_core::eval::synonym(what)
    {
        pages.push(format!("`{what}` is called `{ours}` here."));
        let name = ours.split('(').next().unwrap_or(ours);
        pages.extend(table().filter(|row| row.name == name).map(page));
    }
    if pages.is_empty() {
        let names = lint::RULES
            .iter()
            .map(|rule| rule.id)
            .chain(CODES.iter().map(|code| code.id))
            .chain(table().map(|row| row.name))
            .chain(STATEMENTS.iter().map(|(word, _)| *word));
        let failure = Failure::new(Exit::Usage, format!("there is nothing called `{what}`"));
        return Err(match nearest(what, names) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help("`ltsc explain` lists everything"),
        });
    }
    terminal::print(&format!("{}\n", pages.join("\n\n")));
    Ok(Exit::Done)
}

/// The page of a constructor.
fn page(row: &Constructor) -> String {
    let mut text = format!("{} -> {}\n{}\n\n", row.signature(), row.family.words(), row.summary);
    for param in row.params.iter().skip(usize::from(row.family == Family::Stage)) {
        let default = match param.default {
            None => "required".to_owned(),
            Some("") => "optional".to_owned(),
            Some(value) => format!("= {value}"),
        };
        text.push_str(&format!("    {:<12} {:<28} {default:<12} {}\n", param.name, param.ty.words(), param.doc));
    }
    let example: Vec<String> = row.example.lines().map(|line| format!("    {line}")).collect();
    text.push_str(&format!("\nExample:\n{}", example.join("\n")));
    text
}

fn explain_target(name: &str) -> Result<Exit, Failure> {
    let target = project::target(name)?;
    let measured = measured_by()?;
    let mut exact = String::new();
    let mut rest = String::new();
    let mut converted = String::new();
    for feature in Feature::ALL {
        let (word, parts) = match (target.supports)(*feature) {
            Support::Exact => {
                let by = by(measured.of(target.name, *feature));
                match target.conversion(*feature) {
                    Some(formula) => {
                        converted.push_str(&format!("converted: {}\n{}", feature.name(), wrapped(formula, "    ")));
                        converted.push_str(&wrapped(&by, "    "));
                    }
                    None => exact.push_str(&format!("exact: {}\n{}", feature.name(), wrapped(&by, "    "))),
                }
                continue;
            }
            Support::Approximate { why, bound } => {
                ("approximated", [why, bound].into_iter().chain(target.conversion(*feature)).collect())
            }
            Support::Unsupported { why } => ("not supported", vec![why]),
        };
        rest.push_str(&format!("{word}: {}\n", feature.name()));
        for part in parts {
            rest.push_str(&wrapped(part, "    "));
        }
        if word == "approximated" {
            rest.push_str(&wrapped(&by(measured.of(target.name, *feature)), "    "));
        }
    }
    for choice in target.choices {
        rest.push_str(&format!("option: {}.{}\n{}", target.name, choice.name, wrapped(choice.summary, "    ")));
    }
    terminal::print(&format!("{}\n{}\n\n{exact}{converted}{rest}", target.name, target.summary));
    Ok(Exit::Done)
}

/// By what an answer was measured.
fn by(proofs: &[Proof]) -> String {
    if proofs.is_empty() {
        return "not measured".to_owned();
    }
    format!("measured by {}", proofs.iter().map(Proof::text).collect::<Vec<_>>().join(", "))
}

/// Lines of at most 100 characters, each behind `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let mut out = String::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && indent.len() + line.len() + 1 + word.len() > 100 {
            out.push_str(&format!("{indent}{line}\n"));
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    out.push_str(&format!("{indent}{line}\n"));
    out
}

fn contents() -> String {
    let mut text = "Rules:\n".to_owned();
    for rule in lint::RULES {
        text.push_str(&format!("    {:<22} {:<6} {}\n", rule.id, rule.level.word(), rule.summary));
    }
    text.push_str("\nOther findings:\n");
    for code in CODES {
        text.push_str(&format!("    {:<22} {}\n", code.id, code.doc.lines().next().unwrap_or_default()));
    }
    for family in Family::ALL {
        text.push_str(&format!("\n{} is made by:\n", capital(family.words())));
        for row in table().filter(|row| row.family == family) {
            text.push_str(&format!("    {:<22} {}\n", row.name, row.summary));
        }
    }
    text.push_str("\nStatements:\n");
    for (word, page) in STATEMENTS {
        text.push_str(&format!("    {word:<22} {}\n", page.lines().next().unwrap_or_default()));
    }
    text.push_str("\nTargets (`ltsc explain --target NAME`):\n");
    for target in ltsc_core::formats::TARGETS {
        text.push_str(&format!("    {:<22} {}\n", target.name, target.summary));
    }
    text
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}
