//! The house: layers, tables, first lines, lengths, and ARCHITECTURE.md against the tree.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::{files_below, root};

/// The longest file in lines.
const LONGEST: usize = 1200;

/// Modules of the core and those that each may use; ARCHITECTURE.md has the same table.
const LAYERS: &[(&str, &[&str])] = &[
    ("diag", &[]),
    ("files", &["diag"]),
    ("ir", &["diag"]),
    ("npy", &[]),
    ("syntax", &["diag"]),
    ("format", &["syntax", "diag"]),
    ("fix", &["syntax", "diag"]),
    ("mesh", &["ir", "diag"]),
    ("image", &["ir", "diag"]),
    ("eval", &["syntax", "ir", "mesh", "image", "npy", "diag", "files"]),
    ("import", &["diag", "eval", "files", "formats", "image", "ir", "mesh"]),
    ("valid", &["ir", "mesh", "diag"]),
    ("lower", &["ir", "mesh", "diag"]),
    ("survey", &["ir", "diag"]),
    ("similar", &["ir"]),
    ("equiv", &["diag", "formats", "image", "ir", "survey"]),
    ("contact", &["ir", "survey"]),
    ("lint", &["ir", "mesh", "survey", "contact", "diag"]),
    ("capability", &["ir", "mesh", "diag"]),
    ("formats", &["ir", "mesh", "image", "survey", "valid", "capability", "diag", "files"]),
    ("print", &["diag", "files", "format", "formats", "ir", "mesh", "npy", "syntax"]),
    ("ledger", &["capability", "diag", "formats", "ir"]),
    ("audit", &["capability", "diag", "files", "formats", "image", "ir", "mesh"]),
    ("catalogue", &["ir", "survey"]),
    ("manual", &["capability", "diag", "eval", "formats", "ir", "lint", "syntax"]),
    (
        "pipeline",
        &[
            "audit",
            "capability",
            "diag",
            "eval",
            "files",
            "fix",
            "formats",
            "import",
            "ir",
            "ledger",
            "lint",
            "lower",
            "syntax",
            "valid",
        ],
    ),
];

fn rust_files(folder: &str) -> Vec<(String, String)> {
    let folder = root().join(folder);
    let files = files_below(&folder).into_iter().filter(|path| path.ends_with(".rs"));
    files.map(|path| (path.clone(), fs::read_to_string(folder.join(path)).expect("a source file"))).collect()
}

fn all_sources() -> Vec<(String, String)> {
    let folders = ["compiler/core/src", "compiler/cli/src", "renderers/src", "renderers/evaluation/src", "tests/suite"];
    let of = |folder: &&str| {
        let folder = (*folder).to_owned();
        rust_files(&folder).into_iter().map(move |(path, text)| (format!("{folder}/{path}"), text)).collect::<Vec<_>>()
    };
    folders.iter().flat_map(of).collect()
}

/// The text without what only tests have: each item under `#[cfg(test)]` or its like, and nothing behind it. Formatted code ends an item
/// where a line of its own indentation closes it.
fn without_tests(text: &str) -> String {
    let mut kept = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let start = line.trim_start();
        if !(start.starts_with("#[cfg(test)]") || start.starts_with("#[cfg(all(test,")) {
            kept.push(line);
            continue;
        }
        let indent = &line[..line.len() - start.len()];
        let more = |line: &&str| line.trim_start().starts_with("#[") || line.trim_start().starts_with("//");
        while lines.next_if(more).is_some() {}
        let Some(first) = lines.next() else { break };
        if !first.trim_end().ends_with([';', ',']) {
            let closes = |line: &str| line.strip_prefix(indent).is_some_and(|rest| rest.starts_with(['}', ']', ')']));
            for line in lines.by_ref() {
                if closes(line) {
                    break;
                }
            }
        }
    }
    kept.join("\n")
}

/// The items of a list in braces, which begins behind the first one; lists in it stay whole.
fn items(list: &str) -> Vec<&str> {
    let (mut depth, mut from) = (0, 0);
    let mut found = Vec::new();
    for (at, letter) in list.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => {
                found.push(&list[from..at]);
                return found;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(&list[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    found
}

#[test]
fn code_is_told_from_tests() {
    let text = "use crate::a;\n#[cfg(test)]\nmod early;\nfn b() {\n    x();\n}\n#[cfg(test)]\n#[path = \"c.rs\"]\nmod c {\n    fn d() {}\n}\nuse \
                crate::{e::{f, g}, h};\n#[cfg(all(test, unix))]\nmod last {\n}\nfn end() {}\n";
    let code = without_tests(text);
    assert_eq!(code, "use crate::a;\nfn b() {\n    x();\n}\nuse crate::{e::{f, g}, h};\nfn end() {}");
    assert_eq!(used(&code).into_iter().collect::<Vec<_>>(), ["a", "e", "h"]);
}

/// The names that follow `crate::` in code.
fn used(text: &str) -> BTreeSet<String> {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(list) = rest.strip_prefix('{') {
            let names =
                items(list).into_iter().map(|item| item.trim().split("::").next().unwrap_or_default().to_owned());
            found.extend(names.filter(|name| !name.is_empty()));
        } else {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            found.insert(rest[..end].to_owned());
        }
    }
    found
}

#[test]
fn modules_of_the_core_use_only_what_lies_below_them() {
    let layers: BTreeMap<&str, &[&str]> = LAYERS.iter().copied().collect();
    for (path, text) in rust_files("compiler/core/src") {
        let module = path.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        let allowed = layers.get(module).unwrap_or_else(|| panic!("`{module}` is missing in LAYERS"));
        // Tests of a module may reach further.
        if path.ends_with("tests.rs") || path.contains("_tests") || path.contains("/tests/") {
            continue;
        }
        for name in
            used(&without_tests(&text)).into_iter().filter(|name| layers.contains_key(name.as_str()) && name != module)
        {
            assert!(allowed.contains(&name.as_str()), "{path} uses `{name}`, which `{module}` may not know");
        }
    }
}

#[test]
fn a_format_knows_no_other_format() {
    let formats = ["mitsuba", "pbrt", "luxcore", "cycles", "gltf", "toy"];
    for (path, text) in rust_files("compiler/core/src/formats") {
        let Some((own, _)) = path.split_once('/') else { continue };
        for other in formats.into_iter().filter(|other| *other != own) {
            let reaches = [format!("super::super::{other}"), format!("formats::{other}")];
            assert!(!reaches.iter().any(|name| text.contains(name)), "{path} uses the format {other}");
        }
    }
}

/// What a new target costs: its folder, `mod` and a row for each of its targets in the table. `formats/toy` is such a folder, which
/// only tests of the core have.
#[test]
fn a_target_is_a_folder_and_two_lines() {
    let folders = fs::read_dir(root().join("compiler/core/src/formats")).expect("the formats");
    let folders = folders.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir());
    let names: BTreeSet<String> =
        folders.map(|path| path.file_name().expect("a name").to_string_lossy().into_owned()).collect();
    let table = fs::read_to_string(root().join("compiler/core/src/formats/mod.rs")).expect("the table");
    let rows = table.split("pub static TARGETS").nth(1).and_then(|rest| rest.split("];").next()).expect("the table");
    for name in names.iter().filter(|name| *name != "shared") {
        let mut lines = Vec::new();
        for (path, text) in rust_files("compiler/core/src")
            .into_iter()
            .filter(|(path, _)| !path.starts_with(&format!("formats/{name}/")) && !path.ends_with("tests.rs"))
        {
            // The toy is in the table for tests only.
            let code = if name == "toy" { text.clone() } else { without_tests(&text) };
            let names = |line: &str| {
                let line = line.split("//").next().unwrap_or_default();
                line.contains(&format!("mod {name};"))
                    || line.contains(&format!("{name}::")) && !line.contains("file::")
            };
            // Meshes are read from files of glTF as well, by a module of that name which has nothing to do with the target.
            // Nor is a reader of scenes of that format, which has a folder of its own.
            let of_meshes = path.starts_with("mesh/") || path.starts_with("import/");
            let found = code.lines().filter(|line| !of_meshes && names(line));
            lines.extend(found.map(|line| format!("{path}: {}", line.trim())));
        }
        let targets = rows.matches(&format!("{name}::")).count();
        assert!(targets > 0, "{name} has no target");
        assert_eq!(lines.len(), 1 + targets, "what knows the format {name}: {lines:#?}");
    }
    let above = |path: &str| path.starts_with("compiler/cli/") || path.starts_with("renderers/evaluation/");
    for (path, text) in all_sources().into_iter().filter(|(path, _)| above(path)) {
        let known = names.iter().find(|name| text.contains(&format!("formats::{name}")));
        assert!(known.is_none(), "{path} knows the format {known:?}");
    }
}

#[test]
fn core_and_renderers_do_not_know_each_other() {
    for (path, text) in rust_files("renderers/src") {
        assert!(!text.contains("ltsc_core"), "{path} knows the core");
        assert!(!text.contains("ltsc_evaluation"), "{path} knows what stands on it");
    }
    for (path, text) in rust_files("compiler/core/src") {
        let known = ["ltsc_render", "ltsc_evaluation"].into_iter().find(|name| text.contains(name));
        assert!(known.is_none(), "{path} knows {known:?}");
    }
}

/// What is rendered and what images say is decided in one package; commands ask it.
#[test]
fn commands_render_nothing_and_hold_no_statistics() {
    for (path, text) in all_sources().into_iter().filter(|(path, _)| path.starts_with("compiler/cli/src/")) {
        let code = without_tests(&text);
        for word in ["RenderRequest", "run::render", ".pixels", ".sqrt()", "emit_alone"] {
            let found = code.contains(word) && !(word == "emit_alone" && path.ends_with("commands/emit.rs"));
            assert!(!found, "{path} has `{word}`: ask `ltsc_evaluation`");
        }
    }
}

/// Modules that stand on each other in one direction only.
#[test]
fn there_are_no_circles_of_two() {
    let above = [
        ("renderers/src/run", "crate::install"),
        ("compiler/cli/src/terminal.rs", "crate::output"),
        ("compiler/core/src/formats/gltf/surface.rs", "super::emit"),
        ("compiler/core/src/formats/gltf/names.rs", "super::emit"),
        ("renderers/evaluation/src/compare", "crate::job"),
        ("renderers/evaluation/src/disk", "crate::job"),
        ("renderers/evaluation/src/job.rs", "crate::chunk"),
        ("renderers/evaluation/src/chunk", "crate::executor"),
    ];
    for (place, other) in above {
        let files = all_sources().into_iter().filter(|(path, _)| path.starts_with(place)).collect::<Vec<_>>();
        assert!(!files.is_empty(), "{place} is gone");
        for (path, text) in files {
            assert!(!without_tests(&text).contains(other), "{path} knows {other}, which stands on it");
        }
    }
}

#[test]
fn every_file_of_a_family_is_in_its_table() {
    let families = [
        ("compiler/core/src/lint", "RULES", "RULE"),
        ("compiler/core/src/eval/table", "parts", "ROWS"),
        ("renderers/evaluation/src/compare/metrics", "METRICS", "ROW"),
        ("compiler/core/src/lower", "PASSES", "PASS"),
        ("renderers/src/run", "DRIVERS", "ROW"),
        ("renderers/evaluation/src/executor", "EXECUTORS", "KIND"),
    ];
    // An importer is a folder and two lines.
    let importers = fs::read_to_string(root().join("compiler/core/src/import/mod.rs")).expect("a table");
    let files = rust_files("compiler/core/src/import");
    let folders: BTreeSet<&str> = files.iter().filter_map(|(path, _)| Some(path.split_once('/')?.0)).collect();
    assert!(folders.len() >= 2, "{folders:?}");
    for name in folders {
        let named =
            files.iter().filter(|(path, _)| !path.starts_with(&format!("{name}/")) && !path.ends_with("tests.rs"));
        let lines = named
            .flat_map(|(_, text)| text.lines())
            .filter(|line| line.contains(&format!("mod {name};")) || line.contains(&format!("{name}::")));
        assert_eq!(lines.count(), 2, "what knows the importer {name}");
        assert!(importers.contains(&format!("{name}::IMPORTER")), "{name} is not in IMPORTERS");
    }
    for (folder, list, row) in families {
        let table = fs::read_to_string(root().join(folder).join("mod.rs")).expect("a table");
        // In the folder of drivers lies also what they share.
        let shares = folder == "renderers/src/run";
        for (path, text) in rust_files(folder).into_iter().filter(|(path, _)| path != "mod.rs") {
            let name = path.trim_end_matches(".rs");
            // What one needs for itself lies in a folder of its name.
            if name.ends_with("tests")
                || name.contains('/') && folder.ends_with("executor")
                || shares && !text.contains(": Driver = Driver {")
            {
                continue;
            }
            assert!(table.contains(&format!("mod {name};")), "{folder}/{path} is no module");
            assert!(table.contains(&format!("{name}::{row}")), "{folder}/{path} is not in {list}");
        }
    }
}

#[test]
fn every_code_has_a_page_and_every_page_a_code() {
    let mut known: BTreeSet<&str> = ltsc_core::diag::CODES.iter().map(|code| code.id).collect();
    known.extend(ltsc_core::lint::RULES.iter().map(|rule| rule.id));
    let mut named = BTreeSet::new();
    let evaluations = ["file", "study"].map(|folder| rust_files(&format!("renderers/evaluation/src/{folder}")));
    for (path, text) in rust_files("compiler/core/src").into_iter().chain(evaluations.into_iter().flatten()) {
        if path == "diag/codes.rs" {
            continue;
        }
        // Codes are the strings of small letters and hyphens that stand where a code is due.
        let pieces = text.split('"').skip(1).step_by(2);
        named.extend(pieces.filter(|piece| known.contains(*piece)).map(str::to_owned));
        let invalid =
            text.split('"').skip(1).step_by(2).filter(|piece| piece.starts_with("invalid-") && !piece.contains(' '));
        for id in invalid {
            assert!(known.contains(id), "{path}: `{id}` has no page in diag/codes.rs");
        }
        for marker in ["Finding::error(\"", "Finding::warn(\"", "Finding::new(\"", ".id(\""] {
            for (at, _) in text.match_indices(marker) {
                let id = text[at + marker.len()..].split('"').next().unwrap_or_default();
                assert!(known.contains(id) || path.contains("tests"), "{path}: `{id}` has no page in diag/codes.rs");
            }
        }
    }
    let unused: Vec<&&str> = known.iter().filter(|id| !named.contains(**id)).collect();
    assert!(unused.is_empty(), "pages of codes that nothing says: {unused:?}");
}

#[test]
fn files_say_what_they_are_and_stay_readable() {
    for (path, text) in all_sources() {
        assert!(text.starts_with("//!"), "{path} does not say its purpose in the first line");
        let lines = text.lines().count();
        assert!(lines <= LONGEST, "{path} has {lines} lines");
    }
}

#[test]
fn nothing_speaks_of_one_machine() {
    // Written in pieces, so that this file does not find itself.
    let words = [["/ro", "ot/"].concat(), ["/wo", "rk/"].concat(), ["/ho", "me/"].concat()];
    for (path, text) in all_sources().into_iter().filter(|(path, _)| !path.ends_with("cache.rs")) {
        for word in &words {
            assert!(!text.contains(word.as_str()), "{path} contains {word}");
        }
    }
}

/// Files are read in one place, which refuses pipes and devices, and commands write through `disk` alone, which knows what is ours.
#[test]
fn files_are_read_in_one_place_and_written_in_another() {
    let reads = ["fs::read(", "fs::read_to_string(", "File::open("];
    let writes = ["fs::write(", "File::create", "fs::rename(", "fs::copy(", "tempfile::", "replace_file("];
    // What the system says of processes is no file.
    let apart = ["renderers/src/regular.rs", "renderers/src/tree.rs", "compiler/cli/src/signals.rs"];
    let own = |path: &&(String, String)| path.0.starts_with("compiler/cli/src/") || path.0.starts_with("renderers/");
    let all = all_sources();
    for (path, text) in all.iter().filter(own).filter(|(path, _)| !path.ends_with("tests.rs")) {
        let code = without_tests(text);
        let read = reads.iter().find(|word| code.contains(**word) && !apart.contains(&path.as_str()));
        assert!(read.is_none(), "{path} has {read:?}: read by `ltsc_render::regular`");
        let writes = writes.iter().filter(|_| !path.starts_with("renderers/src/") && !path.contains("/disk/"));
        let written = writes.into_iter().find(|word| code.contains(**word));
        assert!(written.is_none(), "{path} has {written:?}: write by `disk`");
    }
}

#[test]
fn architecture_is_true() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    assert!(text.lines().count() <= 300, "ARCHITECTURE.md is longer than 300 lines");
    let tree =
        text.split("## The tree").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("a section on the tree");
    let mut top = String::new();
    let mut named = BTreeSet::new();
    for line in tree.lines().filter(|line| line.starts_with("    ") && !line.trim().is_empty()) {
        let inner = line.starts_with("      ");
        let first = line.split_whitespace().next().unwrap_or_default();
        if inner && !first.ends_with('/') && !first.ends_with(".rs") {
            continue;
        }
        let path = if inner { format!("{top}{first}") } else { first.to_owned() };
        if !inner {
            top = first.to_owned();
        }
        assert!(root().join(&path).exists(), "ARCHITECTURE.md names {path}, which is not there");
        named.insert(path.trim_end_matches('/').to_owned());
    }
    for entry in fs::read_dir(root().join("compiler/core/src")).expect("the core") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        assert!(named.contains(&format!("compiler/core/src/{name}")), "ARCHITECTURE.md does not name {name}");
    }
    for (module, may) in LAYERS.iter().filter(|(module, _)| *module != "pipeline") {
        let row = text.lines().find(|line| {
            line.starts_with("| `") && line.split('|').nth(1).is_some_and(|cell| cell.contains(&format!("`{module}`")))
        });
        let row = row.unwrap_or_else(|| panic!("ARCHITECTURE.md has no row for `{module}`"));
        let cell = row.split('|').nth(2).unwrap_or_default();
        for name in *may {
            assert!(cell.contains(&format!("`{name}`")), "ARCHITECTURE.md: `{module}` may use `{name}`");
        }
        assert_eq!(cell.matches('`').count() / 2, may.len(), "ARCHITECTURE.md: what `{module}` may use");
    }
}

#[test]
fn no_merge_is_left_half_done() {
    let mut found = Vec::new();
    for folder in ["compiler", "docs", "fuzz/fuzz_targets", "grammar", "renderers", "scenes-src", "tests"] {
        for path in files_below(&root().join(folder)) {
            let Ok(text) = fs::read_to_string(root().join(folder).join(&path)) else { continue };
            let marks = ["<".repeat(7), ">".repeat(7)];
            if text.lines().any(|line| marks.iter().any(|mark| line.starts_with(&format!("{mark} ")))) {
                found.push(format!("{folder}/{path}"));
            }
        }
    }
    assert!(found.is_empty(), "marks of a conflict between versions in {found:?}");
}
