//! The page of the language: the chapter written by hand, and the table of constructors.

use crate::eval::{Constructor, Family, LIST_LIMIT, MESH_LIMIT, Parameter, STEP_LIMIT, TEXT_LIMIT, table};
use crate::ir::{GROUP_DEPTH, INSTANCE_LIMIT};
use crate::syntax::{NAME_LIMIT, NESTING_LIMIT, RESERVED, VERSION};

use super::{MADE, anchor, capital, cell};

/// Statements, values and operators.
pub(super) const LANGUAGE: &str = include_str!("language.md");

pub(super) fn page() -> String {
    let mut text = format!("# The language `.lts`, version {VERSION}\n\n{MADE}\n## Contents\n\n");
    let headings = LANGUAGE.lines().filter_map(|line| line.strip_prefix("## ")).map(str::to_owned);
    let families = Family::ALL.iter().map(|family| heading(*family));
    for heading in headings.chain(["Limits".to_owned(), "Reserved words".to_owned()]) {
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
    text.push_str(".\n");
    for family in Family::ALL {
        text.push_str(&chapter(family));
    }
    text
}

fn limits() -> String {
    let mut text = "\n## Limits\n\nEach is an error with its number, so that no text can run without end.\n\n\
                    | what | at most |\n|---|---|\n"
        .to_owned();
    let rows = [
        ("a scene file", format!("{} MiB", TEXT_LIMIT >> 20)),
        ("a mesh file", format!("{} GiB", MESH_LIMIT >> 30)),
        ("a name", format!("{NAME_LIMIT} bytes")),
        ("brackets in each other", NESTING_LIMIT.to_string()),
        ("elements of a list", LIST_LIMIT.to_string()),
        ("calls and iterations of a file", STEP_LIMIT.to_string()),
        ("groups in each other", GROUP_DEPTH.to_string()),
        ("shapes and instances, groups counted as often as they are placed", INSTANCE_LIMIT.to_string()),
    ];
    rows.iter().for_each(|(what, most)| text.push_str(&format!("| {what} | {most} |\n")));
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
        Family::Color => "Colours",
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
