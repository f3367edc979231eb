//! The page of targets: what each answers to every feature.

use crate::capability::{Feature, Support};
use crate::formats::{Choice, TARGETS, Target};

use super::{MADE, Measured, Proof, anchor, capital, cell};

pub(super) fn page(measured: &Measured) -> String {
    let mut text = format!(
        "# Targets\n\n{MADE}\n\
         For each thing that a scene can ask for, each target answers: **exact** (it means the same), *approximated* (there is no \
         exact equivalent; what differs and by how much is said)\nor **no** (not supported: it is left out, with the finding `loss-dropped`). A build says which of these concern its \
         scenes; `ltsc explain --target NAME`\nprints one target. [conventions.md](conventions.md) has the mappings and the \
         measurements, [renderers.md](renderers.md) the conventions: scenes with known answers that renderers were given.\n\n| target | aliases | what it is | file to open |\n|---|---|---|---|\n"
    );
    for target in TARGETS {
        let aliases: Vec<String> = target.aliases.iter().map(|name| format!("`{name}`")).collect();
        text.push_str(&format!(
            "| [`{}`](#{}) | {} | {} | `{}` |\n",
            target.name,
            anchor(target.name),
            aliases.join(", "),
            cell(target.summary),
            target.main_file
        ));
    }
    text.push_str("\n## What each target supports\n\n| | ");
    text.push_str(&TARGETS.iter().map(|target| format!("`{}`", target.name)).collect::<Vec<_>>().join(" | "));
    text.push_str(&format!(" |\n|---{}|\n", "|---".repeat(TARGETS.len())));
    for feature in Feature::ALL {
        let answers: Vec<&str> = TARGETS
            .iter()
            .map(|target| match (target.supports)(*feature) {
                Support::Exact => "exact",
                Support::Approximate { why: _, bound: _ } => "*approximated*",
                Support::Unsupported { why: _ } => "**no**",
            })
            .collect();
        text.push_str(&format!("| {} | {} |\n", cell(&capital(feature.name())), answers.join(" | ")));
    }
    for target in TARGETS {
        text.push_str(&section(target, measured));
    }
    text
}

/// What one target answers, and by what that was measured.
fn section(target: &Target, measured: &Measured) -> String {
    let mut converted = String::new();
    let mut nearly = String::new();
    let mut dropped = String::new();
    let mut exact = 0;
    for feature in Feature::ALL {
        let formula = target.conversion(*feature);
        match (target.supports)(*feature) {
            Support::Exact => {
                exact += 1;
                if let Some(formula) = formula {
                    converted.push_str(&format!("- *{}.* {}.\n", capital(feature.name()), capital(formula)));
                }
            }
            Support::Approximate { why, bound } => {
                let formula = formula.map(|formula| format!(" Written: {formula}.")).unwrap_or_default();
                nearly.push_str(&format!(
                    "- *{}.* {}. How much: {}.{formula}\n",
                    capital(feature.name()),
                    capital(why).trim_end_matches('.'),
                    bound.trim_end_matches('.')
                ));
            }
            Support::Unsupported { why } => {
                dropped.push_str(&format!("- *{}.* {}.\n", capital(feature.name()), capital(why).trim_end_matches('.')))
            }
        }
    }
    let mut text = format!("\n## `{}`\n\n{}. {exact} of {} exact.\n", target.name, target.summary, Feature::ALL.len());
    for (title, list) in
        [("Converted: exact, with other numbers", converted), ("Approximated", nearly), ("Not supported", dropped)]
    {
        if !list.is_empty() {
            text.push_str(&format!("\n**{title}**\n\n{list}"));
        }
    }
    text.push_str(&proofs(target, measured));
    if !target.choices.is_empty() {
        text.push_str("\n**Only where it is asked for**, by `--option` or in `options` of `ltsc.toml`\n\n");
        for Choice { name, summary } in target.choices {
            text.push_str(&format!("- `{}.{name}`: {summary}.\n", target.name));
        }
    }
    text
}

/// By what each answer was measured.
fn proofs(target: &Target, measured: &Measured) -> String {
    let mut text = String::from("\n**Measured by**\n\n| answer | | by |\n|---|---|---|\n");
    for feature in Feature::ALL {
        let word = match (target.supports)(*feature) {
            Support::Exact => "exact",
            Support::Approximate { why: _, bound: _ } => "*approximated*",
            Support::Unsupported { why: _ } => continue,
        };
        let proofs: Vec<String> = measured.of(target.name, *feature).iter().map(Proof::markdown).collect();
        let by = if proofs.is_empty() { "**not measured**".to_owned() } else { proofs.join(", ") };
        text.push_str(&format!("| {} | {word} | {} |\n", cell(&capital(feature.name())), cell(&by)));
    }
    text
}
