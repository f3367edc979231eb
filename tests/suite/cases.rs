//! `tests/cases/`: inputs beside what is expected of them. Every case is linted by the binary; the expectation holds the
//! exit code and every finding as people see it. A line `// ltsc lint ARGUMENTS` in a case gives further arguments.

use std::collections::BTreeSet;
use std::fs;

use super::gallery;
use super::{bless, files_below, ltsc, root, run};

/// Codes that no scene text can lead to today, each with what would.
pub const BEYOND_TEXT: &[(&str, &str)] = &[
    ("foreign-file", "a file of another format: see `outputs`"),
    ("internal-fault", "a fault of ltsc: see the unit test of `guarded`"),
    ("print-renamed", "a scene that becomes a text: see `print` in compiler/core"),
    ("invalid-camera", "an importer: the constructor refuses first"),
    ("audit-mismatch", "files that were generated: see `audit`"),
    ("evaluation-chunks", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-cycle", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-duplicate", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-key", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-missing", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-name", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-parameter", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-render", "an evaluation file: see `study`"),
    ("evaluation-renderer", "an evaluation file: see `study`"),
    ("evaluation-seeds", "an evaluation file: see `study`"),
    ("not-comparable", "an evaluation file: see `study`"),
    ("stale-reference", "an evaluation file: see `study`"),
    ("evaluation-scene", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-setting", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-syntax", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-type", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-unused", "an evaluation file: see `file` in renderers/evaluation"),
    ("evaluation-value", "an evaluation file: see `file` in renderers/evaluation"),
    ("lteval-paths", "a configuration of lteval: see `file` in renderers/evaluation"),
    ("lteval-unread", "a configuration of lteval: see `file` in renderers/evaluation"),
    ("invalid-statement", "native statements and neutral settings of a test case: see `statements`"),
    ("misspelled-statement", "native statements and neutral settings of a test case: see `statements`"),
    ("no-statements", "native statements and neutral settings of a test case: see `statements`"),
    ("foreign-limit", "files that were generated: see `audit`"),
    ("foreign-reference", "files that were generated: see `audit`"),
    ("foreign-syntax", "files that were generated: see `audit`"),
    ("foreign-unknown", "files that were generated: see `audit`"),
    ("invalid-emission", "an importer: the constructor refuses first"),
    ("invalid-film", "an importer: the constructor refuses first"),
    ("invalid-group", "an importer: the evaluator counts and measures groups itself"),
    ("invalid-integrator", "an importer: the constructor refuses first"),
    ("invalid-light", "an importer: the constructor refuses first"),
    ("invalid-material", "an importer: the constructor refuses first"),
    ("invalid-name", "an importer: the grammar refuses first"),
    ("invalid-shape", "an importer: handles of the evaluator are right by construction"),
    ("invalid-sampler", "an importer: the constructor refuses first"),
    ("invalid-transform", "an importer: stages refuse first"),
    ("invalid-scene", "emit, not lint: see `cli`"),
    ("not-text", "binary input: see `cli`"),
    ("step-limit", "takes seconds: see `cli`"),
    ("unformatted", "fmt, not lint: see `format`"),
    ("unknown-parameter", "the command line: see `cli`"),
];

#[test]
fn cases_give_the_findings_that_are_expected() {
    let folder = root().join("tests/cases");
    let mut seen = BTreeSet::new();
    let mut expected = BTreeSet::new();
    let mut all = Vec::new();
    for path in files_below(&folder) {
        if path.ends_with(".snap") {
            expected.insert(path.trim_end_matches(".snap").to_owned());
        }
        if ["meshes/", "lib/", "format/"].iter().any(|other| path.starts_with(other)) || !path.ends_with(".lts") {
            continue;
        }
        let name = path.trim_end_matches(".lts").to_owned();
        let text = fs::read_to_string(folder.join(&path)).unwrap_or_default();
        let more = text.lines().find_map(|line| line.strip_prefix("// ltsc lint ")).unwrap_or_default();
        let args = ["lint", "--root", ".", path.as_str()].into_iter().chain(more.split_whitespace());
        let ran = run(ltsc().current_dir(&folder).args(args));
        assert!(matches!(ran.code, Some(0 | 1 | 3)), "{path}: {:?}\n{}", ran.code, ran.err);
        let shown = format!("exit code {}\n{}{}", ran.code.unwrap_or(-1), ran.out, ran.err);
        let (folder_of, stem) = path.trim_end_matches(".lts").rsplit_once('/').unwrap_or(("", &name));
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(folder.join(folder_of));
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        all.push((path.clone(), shown.clone()));
        settings.bind(|| insta::assert_snapshot!(stem.to_owned(), shown));
        seen.insert(name);
    }
    gallery::check(&all);
    let strays: Vec<&String> = expected.difference(&seen).collect();
    assert!(strays.is_empty(), "expectations without a case: {strays:?}");
    assert!(seen.len() >= 20, "only {} cases were found", seen.len());
}

#[test]
fn every_code_is_shown_by_a_case() {
    if bless() {
        // The snapshots are being rewritten at the same time.
        return;
    }
    let folder = root().join("tests/cases");
    let snapshots = files_below(&folder).into_iter().filter(|path| path.ends_with(".snap"));
    let text: String = snapshots.map(|path| fs::read_to_string(folder.join(path)).expect("a snapshot")).collect();
    let shown: BTreeSet<&str> = text.lines().map(str::trim).collect();
    let codes =
        ltsc_core::diag::CODES.iter().map(|code| code.id).chain(ltsc_core::lint::RULES.iter().map(|rule| rule.id));
    let missing: Vec<&str> =
        codes.filter(|id| !shown.contains(id) && !BEYOND_TEXT.iter().any(|(beyond, _)| beyond == id)).collect();
    assert!(missing.is_empty(), "codes that no case shows: {missing:?}");
}
