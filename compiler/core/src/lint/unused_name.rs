//! Rule `unused-name`: what a scene declares, it uses.
#![doc = include_str!("unused_name.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "unused-name",
    level: Level::Warn,
    summary: "A value, material, mesh or group is declared and never used.",
    doc: include_str!("unused_name.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    for unused in &subject.around.unused {
        let super::UnusedName { kind, name, span } = unused;
        report.add(
            &(*span).into(),
            format!("`{name}` is declared and never used"),
            "nothing names it",
            "a reader looks for its purpose; a misspelt name elsewhere may have been meant for it",
            if *kind == "use" { format!("remove `{name}` from the list") } else { "use it, or remove it".to_owned() },
        );
    }
}
