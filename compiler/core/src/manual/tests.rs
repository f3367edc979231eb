//! The manual is whole: examples compile, links lead somewhere, tables have the columns that they announce.

use std::collections::BTreeSet;

use crate::capability::Feature;
use crate::diag::{CODES, Severity, Sources};
use crate::eval::{Overrides, evaluate, table};
use crate::files::{MemoryFiles, VPath};
use crate::lint::RULES;

use super::*;

/// The blocks of `text` that are marked as the language.
fn blocks(text: &str) -> Vec<&str> {
    let after = text.split("```lts\n").skip(1);
    after.map(|rest| rest.split("```").next().unwrap_or_default()).collect()
}

#[test]
fn every_example_of_the_chapter_is_a_scene() {
    let blocks = blocks(reference::LANGUAGE);
    assert!(blocks.len() >= 5, "{}", blocks.len());
    for block in blocks {
        let whole = block.starts_with("lts 1");
        let head = "lts 1\nscene ball {}\ncamera = perspective(eye: (0, -9, 2), target: (0, 0, 2), fov_x: 45deg)\n\
                    film = image(8, 8)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n";
        let text = if whole { block.to_owned() } else { format!("{head}{block}") };
        let mut files = MemoryFiles::default();
        files.insert("ball.lts", text);
        let path = VPath::resolve("", "ball.lts").expect("a path");
        let made = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
        let bad: Vec<_> = made.findings.iter().filter(|finding| finding.severity >= Severity::Warn).collect();
        assert!(bad.is_empty() && made.scene.is_some(), "{block}\n{bad:#?}");
        let formatted =
            crate::format::format(&mut Sources::default(), "ball.lts", block).unwrap_or_else(|_| panic!("{block}"));
        assert_eq!(formatted, *block, "examples have the canonical form");
    }
}

#[test]
fn links_within_a_page_lead_to_its_headings() {
    for page in PAGES {
        let text = (page.text)(&Measured::default());
        let headings: BTreeSet<String> = text
            .lines()
            .filter(|line| line.starts_with('#'))
            .map(|line| anchor(line.trim_start_matches('#').trim_start()))
            .collect();
        for link in text.split("](#").skip(1).filter_map(|rest| rest.split(')').next()) {
            assert!(headings.contains(link), "{}: #{link}", page.name);
        }
    }
}

#[test]
fn tables_are_regular() {
    for page in PAGES {
        let text = (page.text)(&Measured::default());
        let mut columns = 0;
        for line in text.lines() {
            let here = if line.starts_with('|') { line.replace("\\|", "").matches('|').count() } else { 0 };
            assert!(columns == 0 || here == 0 || here == columns, "{}: {line}", page.name);
            columns = here;
        }
    }
}

#[test]
fn nothing_is_left_out() {
    let text: String = PAGES.iter().map(|page| (page.text)(&Measured::default())).collect();
    for row in table() {
        assert!(text.contains(&row.signature()), "{}", row.name);
    }
    for id in CODES.iter().map(|code| code.id).chain(RULES.iter().map(|rule| rule.id)) {
        assert!(text.contains(&format!("\n### `{id}`\n")), "{id}");
    }
    for feature in Feature::ALL {
        assert!(text.contains(&format!("\n| {} |", capital(feature.name()))), "{feature:?}");
    }
    // What the chapter says of statements and types is what the grammar has.
    let textures = table().any(|row| row.name == "bitmap");
    for word in crate::syntax::RESERVED.iter().filter(|word| textures || **word != "texture") {
        assert!(
            reference::LANGUAGE.contains(&format!("`{word}")) || reference::LANGUAGE.contains(&format!("{word} ")),
            "{word}"
        );
    }
}
