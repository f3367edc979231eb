//! Rule `one-sided-similar`: similarity goes both ways.
#![doc = include_str!("one_sided_similar.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "one-sided-similar",
    level: Level::Warn,
    summary: "A scene calls another one similar, which does not say so of it.",
    doc: include_str!("one_sided_similar.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let name = &subject.scene.name;
    for similar in &subject.scene.documentation.similar {
        let Some(other) = subject.around.scenes.get(&similar.scene).filter(|_| similar.scene != *name) else {
            continue;
        };
        if other.similar.iter().any(|back| back.scene == *name) {
            continue;
        }
        report.add(
            &subject.scene.origin,
            format!("`{name}` calls `{}` similar, and is not called similar by it", similar.scene),
            "this scene",
            "a reader who starts at the other scene does not find this one",
            format!("write `similar: [(\"{name}\", \"...\")]` in `{}`, with the reason seen from there", similar.scene),
        );
    }
}
