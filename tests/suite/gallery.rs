//! `docs/diagnostics.md`: every finding as it looks, from what the cases show.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;

use super::cases::BEYOND_TEXT;
use super::{bless, root};

/// Cases that are shown whole, each with its title and what it is about.
const CHAPTERS: &[(&str, &str, &str)] = &[
    (
        "names/trail.lts",
        "The way that led there",
        "An error within a library, a function or a loop shows how evaluation came there: calls, iterations, uses, innermost first.",
    ),
    (
        "types/hints.lts",
        "Words of other renderers, types and units",
        "What is called otherwise elsewhere is recognized, and a value of the wrong type is told apart from the right one.",
    ),
    ("syntax/other_languages.lts", "Slips of the pen", "All errors of a file come in one run, each at its own place."),
];

/// One finding of a case.
struct Block<'t> {
    id: &'t str,
    text: &'t str,
    case: &'t str,
}

/// The findings that a run printed.
fn blocks<'t>(case: &'t str, shown: &'t str) -> Vec<Block<'t>> {
    let known = |line: &str| {
        ltsc_core::diag::CODES.iter().any(|code| code.id == line)
            || ltsc_core::lint::RULES.iter().any(|rule| rule.id == line)
    };
    let mut starts = Vec::new();
    let mut at = 0;
    for line in shown.split_inclusive('\n') {
        if known(line.trim_end()) {
            starts.push(at);
        }
        at += line.len();
    }
    // The last line counts the findings.
    let end = shown.trim_end().rfind('\n').unwrap_or(shown.len());
    let ends = starts.iter().skip(1).copied().chain([end.max(starts.last().copied().unwrap_or(0))]);
    let of = |(start, end): (usize, usize)| {
        let text = shown[start..end].trim_end();
        Block { id: text.lines().next().unwrap_or_default().trim(), text, case }
    };
    starts.iter().copied().zip(ends).map(of).collect()
}

/// How well a block shows its code: with an excerpt and a help, and short.
fn rank(block: &Block<'_>) -> (bool, bool, usize, usize) {
    let lines = block.text.lines().count();
    (!block.text.contains("╭─"), !block.text.contains("help: "), lines.max(8), block.text.len())
}

fn page(cases: &[(String, String)]) -> String {
    let mut text = "# Diagnostics\n\n\
        *Written by the tests from what the cases in `tests/cases` print; do not edit.*\n\n\
        A finding has a code, one sentence, its places, and, where there is something to say, a note (why) and a help (what to write). \
        `ltsc explain CODE`\nprints more on a code; [findings.md](findings.md) has all pages.\n"
        .to_owned();
    for (case, title, about) in CHAPTERS {
        let (_, shown) = cases.iter().find(|(path, _)| path == case).unwrap_or_else(|| panic!("{case} is missing"));
        let source = fs::read_to_string(root().join("tests/cases").join(case)).expect("a case");
        let _written = write!(text, "\n## {title}\n\n{about}\n\n```lts\n{}\n```\n", source.trim_end());
        for block in blocks(case, shown) {
            let _written = write!(text, "\n```text\n{}\n```\n", block.text);
        }
    }
    let mut best: BTreeMap<&str, Block<'_>> = BTreeMap::new();
    for block in cases.iter().flat_map(|(path, shown)| blocks(path, shown)) {
        if best.get(block.id).is_none_or(|known| rank(&block) < rank(known)) {
            best.insert(block.id, block);
        }
    }
    text.push_str("\n## Every code\n");
    for (id, Block { id: _, text: shown, case }) in &best {
        let _written = write!(text, "\n### `{id}`\n\nFrom [{case}](../tests/cases/{case}):\n\n```text\n{shown}\n```\n");
    }
    text.push_str("\n## Not shown\n\nThese codes come from other inputs than the text of a scene.\n\n| code | comes from |\n|---|---|\n");
    for (id, from) in BEYOND_TEXT.iter().filter(|(id, _)| !best.contains_key(id)) {
        let _written = writeln!(text, "| `{id}` | {from} |");
    }
    text
}

/// Compares the page with what the cases show, or rewrites it.
pub fn check(cases: &[(String, String)]) {
    let path = root().join("docs/diagnostics.md");
    let made = page(cases);
    if bless() {
        fs::write(&path, made).expect("a writable page");
        return;
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    assert!(there == made, "docs/diagnostics.md is stale; run `INSTA_UPDATE=always cargo test --test suite cases`");
}
