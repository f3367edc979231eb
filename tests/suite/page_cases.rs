//! The pages of the rules: what they call bad gives the rule's finding, and what they call good does not.

use std::collections::BTreeMap;

use ltsc_core::diag::{Finding, Severity, Sources};
use ltsc_core::eval::{self, Limits};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::lint::{Level, Levels, RULES};
use ltsc_core::pipeline::{Options, check};

/// Settings that a fragment may leave out, by the word that begins them.
const SETTINGS: [(&str, &str); 4] = [
    ("camera", "camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)"),
    ("film", "film = image(64, 64)"),
    ("integrator", "integrator = path(max_depth: 3)"),
    ("sampler", "sampler = independent(samples: 4)"),
];

/// A mesh without normals, which examples read.
const BUNNY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
    3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// A mesh with normals of length 2, which examples read.
const BUST: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 0 0 2\n1 0 0 0 0 2\n0 1 0 0 0 2\n3 0 1 2\n";

/// The blocks of a page between two of its headings.
fn blocks<'p>(page: &'p str, from: &str, to: &str) -> Vec<&'p str> {
    let Some((_, rest)) = page.split_once(from) else { return Vec::new() };
    let section = rest.split(to).next().unwrap_or_default();
    section.split("```lts\n").skip(1).filter_map(|block| block.split("```").next()).collect()
}

/// The files of a block: `// name.lts` on a line of its own begins one; a block without such lines is one file.
fn parts(block: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    for line in block.lines() {
        let begins = line.strip_prefix("// ").is_some_and(|rest| rest.ends_with(".lts") && !rest.contains(' '));
        if begins && !parts.last().is_some_and(String::is_empty) {
            parts.push(String::new());
        }
        if let (false, Some(last)) = (begins, parts.last_mut()) {
            last.push_str(line);
            last.push('\n');
        }
    }
    parts
}

/// A whole scene file around a fragment, with its name.
fn whole(fragment: &str) -> (String, String) {
    let word = |word: &str| fragment.lines().find(|line| line.split([' ', '(']).next() == Some(word));
    let name = word("scene").and_then(|line| line.split(' ').nth(1)).unwrap_or("page").to_owned();
    let mut text = "lts 1\n".to_owned();
    if word("scene").is_none() {
        text.push_str("scene page {}\n");
    }
    text.push_str(fragment);
    for (_, setting) in SETTINGS.iter().filter(|(kind, _)| word(kind).is_none()) {
        text.push_str(setting);
        text.push('\n');
    }
    (name, text)
}

/// What is found in the files of a block, which are the scenes of one project, where `rule` is switched on.
fn findings(rule: &str, block: &str) -> Vec<Finding> {
    let mut files = MemoryFiles::default();
    files.insert("meshes/bunny.ply", BUNNY);
    files.insert("meshes/bust.ply", BUST);
    let mut paths = Vec::new();
    for (name, text) in parts(block).iter().map(|part| whole(part)) {
        files.insert(format!("{name}.lts"), text);
        paths.push(VPath::resolve("", &format!("{name}.lts")).expect("a path"));
    }
    let scenes: BTreeMap<_, _> =
        paths.iter().filter_map(|path| eval::header(&files, path, Limits::default())).collect();
    assert_eq!(scenes.len(), paths.len(), "scenes of one block have names of their own:\n{block}");
    let mut levels = Levels::default();
    levels.set(rule, Level::Warn).expect("a rule");
    let options = Options { scenes: scenes.into(), levels, ..Options::default() };
    let of = |path| check(&files, &mut Sources::default(), path, &options).findings;
    paths.iter().flat_map(of).collect()
}

#[test]
fn examples_of_rules_are_bad_and_good() {
    let mut wrong = Vec::new();
    for rule in RULES {
        let bad = blocks(rule.doc, "**Bad**", "**Good**");
        let good = blocks(rule.doc, "**Good**", "**Targets.**");
        assert!(!bad.is_empty() && !good.is_empty(), "the page of `{}` lacks an example", rule.id);
        for (blocks, word, expected) in [(bad, "bad", true), (good, "good", false)] {
            for block in blocks {
                let found = findings(rule.id, block);
                let malformed = found.iter().any(|finding| finding.severity == Severity::Error);
                if malformed || found.iter().any(|finding| finding.id == rule.id) != expected {
                    let list: Vec<String> =
                        found.iter().map(|finding| format!("    {}: {}", finding.id, finding.message)).collect();
                    wrong.push(format!("`{}`, said to be {word}:\n{block}{}", rule.id, list.join("\n")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "examples of pages:\n{}", wrong.join("\n\n"));
}

#[test]
fn pages_of_rules_have_the_parts_that_readers_look_for() {
    for rule in RULES {
        for part in ["**Why.**", "**Bad**", "**Good**", "**Targets.**"] {
            assert_eq!(rule.doc.matches(part).count(), 1, "the page of `{}`: {part}", rule.id);
        }
        assert!(rule.summary.ends_with('.') && !rule.summary.contains('\n'), "the summary of `{}`", rule.id);
        for target in rule.targets {
            let known = ltsc_core::formats::TARGETS.iter().any(|known| known.name == *target);
            assert!(known, "`{}` is for `{target}`, which is no target", rule.id);
        }
    }
}
