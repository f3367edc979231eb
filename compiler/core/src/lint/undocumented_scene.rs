//! Rule `undocumented-scene`: a test scene says what it tests.
#![doc = include_str!("undocumented_scene.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "undocumented-scene",
    level: Level::Warn,
    summary: "A scene does not say what it tests.",
    doc: include_str!("undocumented_scene.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let documentation = &scene.documentation;
    let mut missing = Vec::new();
    if documentation.brief.is_empty() {
        missing.push("a brief description");
    }
    if documentation.full.is_empty() {
        missing.push("a full description");
    }
    if documentation.paths.is_empty() {
        missing.push("the light paths that it tests");
    }
    if missing.is_empty() {
        return;
    }
    let (last, before) = (missing[missing.len() - 1], &missing[..missing.len() - 1]);
    let list = if before.is_empty() { last.to_owned() } else { format!("{} and {last}", before.join(", ")) };
    report.add(
        &scene.origin,
        format!("the scene `{}` lacks {list}", scene.name),
        "this scene",
        "who compares renderers must know which effect a difference belongs to, and which scene to take",
        "write `/// Brief.` and `///`, `/// Full text.` before `scene`, and `paths: [\"LDE\"]` in it".to_owned(),
    );
}
