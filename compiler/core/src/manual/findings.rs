//! The page of findings: rules and codes.

use crate::diag::CODES;
use crate::lint::RULES;

use super::{MADE, anchor, cell};

pub(super) fn page() -> String {
    let mut text = format!(
        "# Findings\n\n{MADE}\n\
         Everything that ltsc says has a code. **Rules** judge scenes that mean something: their levels are `allow`, `warn` and \
         `deny`, set in\n`ltsc.toml`, on the command line (`--deny smooth-emitter`), or at the place by `allow smooth-emitter \
         \"reason\"`. All **other findings**\nare about what the text says; their errors cannot be switched off. \
         `ltsc explain CODE` prints a page; [diagnostics.md](diagnostics.md)\nshows them as they look.\n\n\
         ## Rules\n\n| rule | level | what a scene should keep |\n|---|---|---|\n"
    );
    for rule in RULES {
        let link = anchor(rule.id);
        text.push_str(&format!("| [`{}`](#{link}) | {} | {} |\n", rule.id, rule.level.word(), cell(rule.summary)));
    }
    text.push_str("\n## Other findings\n\n| code | meaning |\n|---|---|\n");
    for code in CODES {
        let first = code.doc.lines().next().unwrap_or_default();
        text.push_str(&format!("| [`{}`](#{}) | {} |\n", code.id, anchor(code.id), cell(first)));
    }
    text.push_str("\n## Pages of the rules\n");
    for rule in RULES {
        text.push_str(&format!("\n### `{}`\n\nLevel: {}. {}\n\n", rule.id, rule.level.word(), rule.summary));
        text.push_str(rule.doc.trim());
        text.push('\n');
        if !rule.targets.is_empty() {
            let names: Vec<String> = rule.targets.iter().map(|name| format!("`{name}`")).collect();
            text.push_str(&format!("\nLeft out unless one of these targets is asked for: {}.\n", names.join(", ")));
        }
    }
    text.push_str("\n## Pages of the other findings\n");
    for code in CODES {
        text.push_str(&format!("\n### `{}`\n\n{}\n", code.id, code.doc));
    }
    text
}
