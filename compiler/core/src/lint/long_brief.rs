//! Rule `long-brief`: one sentence says what a scene tests.
#![doc = include_str!("long_brief.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "long-brief",
    level: Level::Warn,
    summary: "The brief description is long: the scene may test two things.",
    doc: include_str!("long_brief.md"),
    targets: &[],
    check,
};

/// The most words of a brief description. The longest of the eleven scenes of the `lteval` test suite (Tázlar 2020) has 13.
const WORDS: usize = 20;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let brief = &subject.scene.documentation.brief;
    let words = brief.split_whitespace().count();
    let sentences = brief.matches(". ").count() + 1;
    if words <= WORDS && sentences == 1 {
        return;
    }
    let message = if sentences > 1 {
        format!("the brief description has {sentences} sentences")
    } else {
        format!("the brief description has {words} words")
    };
    report.add(
        &subject.scene.origin,
        message,
        "this scene",
        "what cannot be said in a short sentence is often two things, and a difference between renderers then has two causes",
        format!("say in at most {WORDS} words what the scene tests, and the rest in the paragraphs below"),
    );
}
