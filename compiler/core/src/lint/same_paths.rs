//! Rule `same-paths`: scenes that test the same say why both are kept.
#![doc = include_str!("same_paths.md")]

use super::{Level, Report, Rule, Subject};

/// How many of the other scenes are named.
const NAMED: usize = 3;

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
    let own = &scene.documentation;
    // Where one of two scenes says why it stands beside the other, what the other lacks is a finding of `one-sided-similar`.
    let (near, count) = subject.around.scenes.with_same_paths(&scene.name, own, NAMED);
    if count == 0 {
        return;
    }
    let names: Vec<String> = near.iter().map(|name| format!("`{name}`")).collect();
    let more = if count > near.len() { format!(" and {} more scenes", count - near.len()) } else { String::new() };
    let pairs: Vec<String> = near.iter().map(|name| format!("(\"{name}\", \"...\")")).collect();
    let (all, other, which) =
        if count == 1 { ("both", "the other has not", "one") } else { ("all of them", "the others have not", "some") };
    report.add(
        &scene.origin,
        format!("`{}` tests the same light paths as {}{more}", scene.name, names.join(", ")),
        "this scene",
        &format!("{all} test {}; a suite has few scenes, each for a purpose of its own", own.paths.join(", ")),
        format!("write what `{}` has that {other}: `similar: [{}]`, or remove {which}", scene.name, pairs.join(", ")),
    );
}
