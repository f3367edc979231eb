//! Rule `unknown-similar`: similar scenes are there.
#![doc = include_str!("unknown_similar.md")]

use super::{Level, Report, Rule, Subject};
use crate::diag::nearest;

pub(super) const RULE: Rule = Rule {
    id: "unknown-similar",
    level: Level::Warn,
    summary: "A scene names a similar one that the project does not have.",
    doc: include_str!("unknown_similar.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scenes = &subject.around.scenes;
    // A scene that is looked at alone has no neighbors to be checked against.
    if !scenes.contains_key(&subject.scene.name) {
        return;
    }
    for similar in &subject.scene.documentation.similar {
        let message = if similar.scene == subject.scene.name {
            format!("`{}` calls itself similar", similar.scene)
        } else if scenes.contains_key(&similar.scene) {
            continue;
        } else {
            format!("the project has no scene `{}`", similar.scene)
        };
        let others = scenes.keys().map(String::as_str).filter(|name| *name != subject.scene.name);
        let help = match nearest(&similar.scene, others) {
            Some(name) => format!("did you mean `{name}`?"),
            None => "remove it from `similar`".to_owned(),
        };
        let note = "readers follow these names to find the scene that fits their question";
        report.add(&subject.scene.origin, message, "this scene names it", note, help);
    }
}
