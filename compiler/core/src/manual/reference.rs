//! The page of the language: the chapter written by hand, and the table of constructors.

use crate::diag::WORDS;
use crate::eval::{Constructor, Family, Limit, Limits, Parameter, table};
use crate::ir::GROUP_DEPTH;
use crate::syntax::{NAME_LIMIT, NESTING_LIMIT, RESERVED, VERSION};

use super::{MADE, anchor, capital, cell};

/// Statements, values and operators.
pub(super) const LANGUAGE: &str = include_str!("language.md");

pub(super) fn page() -> String {
    let mut text = format!("# The language `.lts`, version {VERSION}\n\n{MADE}\n## Contents\n\n");
    let headings = LANGUAGE.lines().filter_map(|line| line.strip_prefix("## ")).map(str::to_owned);
    let families = Family::ALL.iter().map(|family| heading(*family));
    for heading in headings.chain(["Limits", "Reserved words", "Words of the output"].map(str::to_owned)) {
        text.push_str(&format!("- [{heading}](#{})\n", anchor(&heading)));
    }
    text.push_str("- Constructors and functions\n");
    for heading in families {
        text.push_str(&format!("  - [{heading}](#{})\n", anchor(&heading)));
    }
    text.push_str(&format!("\n{}\n", LANGUAGE.trim()));
    text.push_str(&limits());
    text.push_str("\n## Reserved words\n\nThey cannot be names, except in backticks (`` `mesh` ``): ");
    text.push_str(&RESERVED.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "));
    text.push_str(".\n\n## Words of the output\n\nWhat output says of scenes, targets and images, it says in these words.\n\n| word | meaning |\n|---|---|\n");
    for (word, meaning) in WORDS {
        text.push_str(&format!("| {word} | {} |\n", cell(meaning)));
    }
    for family in Family::ALL {
        text.push_str(&chapter(family));
    }
    text
}

fn limits() -> String {
    let mut text = "\n## Limits\n\nEach is an error with its number, so that no text can run without end. Those with a name are raised by \
                    `--limit NAME=VALUE` or\nin `[limits]` of `ltsc.toml`, up to their most.\n\n\
                    | name | bounds | built in | most |\n|---|---|---|---|\n"
        .to_owned();
    for limit in Limit::ALL {
        let (built_in, most) = (limit.of(&Limits::default()), limit.most);
        let (built_in, most) = if limit.what.starts_with("bytes") {
            (bytes(built_in), bytes(most))
        } else {
            (grouped(built_in), grouped(most))
        };
        text.push_str(&format!("| `{}` | {} | {built_in} | {most} |\n", limit.name, cell(limit.what)));
    }
    let fixed = [
        ("bytes of a name", NAME_LIMIT),
        ("brackets and signs in each other", NESTING_LIMIT),
        ("groups in each other", GROUP_DEPTH),
    ];
    fixed.iter().for_each(|(what, most)| text.push_str(&format!("| | {what} | {most} | {most} |\n")));
    text
}

/// A number of bytes, with a unit of `--limit` where it is a multiple of one.
fn bytes(value: u64) -> String {
    for (unit, shift) in [("GiB", 30), ("MiB", 20), ("KiB", 10)] {
        if value.is_multiple_of(1 << shift) {
            return format!("{} {unit}", grouped(value >> shift));
        }
    }
    grouped(value)
}

/// A number with `_` between groups of three digits, as the language writes it.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push('_');
        }
        text.push(digit);
    }
    text
}

/// The heading of a family.
fn heading(family: Family) -> String {
    match family {
        Family::Material => "Materials",
        Family::Emission => "Emission: what stands after `with` at an emitter",
        Family::Light => "Lights without a surface",
        Family::Mesh => "Meshes",
        Family::Stage => "Stages: what stands after `|>`",
        Family::Camera => "Cameras",
        Family::Film => "Film",
        Family::Filter => "Reconstruction filters",
        Family::Integrator => "Integrators",
        Family::Sampler => "Samplers",
        Family::Color => "Colors",
        Family::Group => "Groups",
        Family::Texture => "Textures",
        Family::Function => "Functions",
    }
    .to_owned()
}

fn chapter(family: Family) -> String {
    let mut text = format!("\n## {}\n", heading(family));
    let rows: Vec<&Constructor> = table().filter(|row| row.family == family).collect();
    if family == Family::Function {
        text.push_str("\n| function | gives | example |\n|---|---|---|\n");
        for row in rows {
            let example = row.example.strip_prefix("let a = ").unwrap_or(row.example);
            text.push_str(&format!("| `{}` | {} | `{example}` |\n", row.signature(), cell(row.summary)));
        }
        return text;
    }
    rows.iter().for_each(|row| text.push_str(&entry(row)));
    text
}

/// One constructor.
fn entry(row: &Constructor) -> String {
    let mut text = format!("\n### `{}`\n\n{}\n\n```text\n{}\n```\n", row.name, row.summary, row.signature());
    let params: Vec<&Parameter> = row.params.iter().skip(usize::from(row.family == Family::Stage)).collect();
    if !params.is_empty() {
        text.push_str("\n| parameter | type | default | meaning |\n|---|---|---|---|\n");
    }
    for (at, param) in params.iter().enumerate() {
        let default = match param.default {
            None => "required".to_owned(),
            Some("") => "none".to_owned(),
            Some(value) => format!("`{value}`"),
        };
        // What may be given without its label stands in bold.
        let name = if at < row.positional { format!("**`{}`**", param.name) } else { format!("`{}`", param.name) };
        text.push_str(&format!("| {name} | {} | {default} | {} |\n", param.ty.words(), cell(&capital_word(param.doc))));
    }
    text.push_str(&format!("\n```lts\n{}\n```\n", row.example));
    text
}

/// A capital at the start, unless that is code.
fn capital_word(text: &str) -> String {
    if text.starts_with('`') { text.to_owned() } else { capital(text) }
}
