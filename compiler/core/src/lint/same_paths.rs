//! Rule `same-paths`: scenes that test the same say why both are kept.
#![doc = include_str!("same_paths.md")]

use super::{Level, Report, Rule, Subject};

use std::collections::BTreeSet;

use crate::ir::{Documentation, LightPaths};

pub(super) const RULE: Rule = Rule {
    id: "same-paths",
    level: Level::Warn,
    summary: "Two scenes test the same classes of light paths, and nothing says why both are kept.",
    doc: include_str!("same_paths.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let own = classes(&scene.documentation);
    if own.is_empty() {
        return;
    }
    for (name, other) in subject.around.scenes.iter().filter(|(name, _)| **name != scene.name) {
        let argued = |from: &Documentation, to: &str| from.similar.iter().any(|similar| similar.scene == to);
        // Where one of them says it, what the other lacks is a finding of `one-sided-similar`.
        if classes(other) != own || argued(&scene.documentation, name) || argued(other, &scene.name) {
            continue;
        }
        let list: Vec<&str> = scene.documentation.paths.iter().map(String::as_str).collect();
        report.add(
            &scene.origin,
            format!("`{}` tests the same light paths as `{name}`", scene.name),
            "this scene",
            &format!("both test {}; a suite has few scenes, each for a purpose of its own", list.join(", ")),
            format!(
                "write what `{}` has that the other has not: `similar: [(\"{name}\", \"...\")]`, or remove one",
                scene.name
            ),
        );
    }
}

/// The classes of a scene, in one spelling and without order.
fn classes(documentation: &Documentation) -> BTreeSet<String> {
    documentation.paths.iter().map(|text| LightPaths::canonical(text)).collect()
}
