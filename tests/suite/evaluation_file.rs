//! Evaluation files that are shipped, and those of `docs/evaluation.md`: nothing is wrong with them, and the page has every key.

use std::collections::BTreeMap;
use std::fs;

use ltsc_core::diag::{Finding, Sources};
use ltsc_core::files::VPath;
use ltsc_core::formats::Target;
use ltsc_core::pipeline::{self, Options};
use ltsc_evaluation::file::model::Source;
use ltsc_evaluation::file::{Evaluation, Surroundings, load};

use super::{Disk, files_below, root, scenes};

/// The project's scenes with their parameters.
struct Project(BTreeMap<String, Vec<String>>);

impl Project {
    fn new() -> Self {
        let disk = Disk(root().to_path_buf());
        let parameters = |name: &String| {
            let path = VPath::resolve("scenes-src", &format!("{name}.lts")).expect("a path");
            // Meshes are not made for that: the parameters are known before.
            let checked = pipeline::check(&disk, &mut Sources::default(), &path, &Options::default());
            checked.parameters.into_iter().map(|parameter| parameter.name).collect()
        };
        // Only those whose parameters an evaluation here sets are looked into.
        let swept = |name: &String| name.starts_with("pool");
        let known = scenes().into_iter().map(|name| {
            let own = if swept(&name) { parameters(&name) } else { Vec::new() };
            (name, own)
        });
        Self(known.collect())
    }
}

fn name(scene: &Source) -> &str {
    let (Source::Name(name) | Source::File(name)) = scene;
    name
}

impl Surroundings for Project {
    fn scenes(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }

    fn missing(&self, scene: &Source) -> Option<String> {
        (!self.0.contains_key(name(scene))).then(|| format!("there is no scene `{}`", name(scene)))
    }

    fn lacks(&self, _scene: &Source, _target: &'static Target) -> Option<String> {
        None
    }

    fn parameters(&self, scene: &Source) -> Option<Vec<String>> {
        self.0.get(name(scene)).cloned()
    }

    fn has_file(&self, path: &str) -> bool {
        path.starts_with("references/")
    }

    fn reference(&self, _scene: &Source, _target: &'static Target) -> Option<String> {
        None
    }
}

fn read(text: &str, project: &Project) -> (Option<Evaluation>, Vec<Finding>) {
    load(Sources::default().add("evaluation.toml", text), text, "evaluation", project)
}

fn page() -> String {
    fs::read_to_string(root().join("docs/evaluation.md")).expect("the page")
}

#[test]
fn nothing_is_wrong_with_shipped_evaluations() {
    let project = Project::new();
    let folder = root().join("scenes-src/eval");
    let mut runs = Vec::new();
    for path in files_below(&folder) {
        assert!(path.ends_with(".toml"), "{path}");
        let text = fs::read_to_string(folder.join(&path)).expect("an evaluation");
        assert!(text.starts_with("# "), "{path} does not say what it shows");
        let (evaluation, findings) = read(&text, &project);
        assert!(findings.is_empty(), "{path}: {findings:#?}");
        let evaluation = evaluation.expect("an evaluation");
        runs.push((path, evaluation.runs.len(), evaluation.pairs.len()));
        if runs.last().is_some_and(|(path, _, _)| path == "all_scenes.toml") {
            let named: Vec<&str> = evaluation.scenes.iter().map(|scene| scene.name.as_str()).collect();
            assert_eq!(named, scenes(), "all scenes");
        }
    }
    let expected = [
        ("all_scenes.toml", 32, 20),
        ("basic.toml", 4, 2),
        ("minimal.toml", 1, 0),
        ("parameter_types.toml", 3, 2),
        ("sweep.toml", 10, 5),
        ("thesis.toml", 33, 22),
        ("together.toml", 10, 6),
        ("worked.toml", 13, 10),
    ];
    let runs: Vec<(&str, usize, usize)> =
        runs.iter().map(|(path, runs, pairs)| (path.as_str(), *runs, *pairs)).collect();
    assert_eq!(runs, expected);
}

#[test]
fn nothing_is_wrong_with_the_examples_of_the_page() {
    let project = Project::new();
    let page = page();
    let blocks: Vec<&str> =
        page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default()).collect();
    assert!(blocks.len() >= 6, "{} examples", blocks.len());
    for block in blocks {
        let (evaluation, findings) = read(block, &project);
        assert!(findings.is_empty(), "{block}\n{findings:#?}");
        assert!(evaluation.is_some_and(|evaluation| !evaluation.runs.is_empty()), "{block}");
    }
}

/// What is said of an unknown key names those that are known.
#[test]
fn the_page_has_every_key() {
    let page = page();
    let start = "scenes = [\"ring\"]\n[[case]]\nname = \"a\"\nrenderers = [\"luxcore\"]\n";
    let places = [
        ("qqqqqqqq = 1\n", ""),
        ("output = { qqqqqqqq = 1 }\n", ""),
        ("settings = { qqqqqqqq = 1 }\n", ""),
        ("settings = { filter = { type = \"box\", qqqqqqqq = 1 } }\n", ""),
        ("budget = { qqqqqqqq = 1 }\n", ""),
        ("compare = { qqqqqqqq = 1 }\n", ""),
        ("reference = { case = \"a\", qqqqqqqq = 1 }\n", ""),
        ("", "qqqqqqqq = 1\n"),
        ("", "for.luxcore = { qqqqqqqq = 1 }\n"),
        ("", "[[sweep]]\nparameter = \"x\"\nvalues = [1]\nqqqqqqqq = 1\n"),
        ("", "[[exclude]]\nscenes = [\"ring\"]\nqqqqqqqq = 1\n"),
        ("", "[renderers.luxcore]\nqqqqqqqq = 1\n"),
    ];
    let mut keys = 0;
    for (before, behind) in places {
        let text = format!("{before}{start}{behind}");
        let (_, findings) = read(&text, &Project(BTreeMap::new()));
        let unknown = findings.iter().find(|finding| finding.id == "evaluation-key");
        let help =
            unknown.and_then(|finding| finding.help.as_deref()).unwrap_or_else(|| panic!("{text}\n{findings:?}"));
        let known = help.strip_prefix("known: ").unwrap_or_else(|| panic!("{help}"));
        for key in known.split(", ") {
            let named = page.contains(&format!("| `{key}` |"))
                || page.contains(&format!("`{key}`"))
                || page.contains(&format!("`{key}.NAME`"));
            assert!(named, "docs/evaluation.md does not name the key `{key}`");
            keys += 1;
        }
    }
    assert!(keys > 50, "{keys} keys");
}
