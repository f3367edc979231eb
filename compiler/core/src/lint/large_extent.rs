//! Rule `large-extent`: scenes of a moderate size.
#![doc = include_str!("large_extent.md")]

use super::{Level, Report, Rule, Subject, also};

pub(super) const RULE: Rule = Rule {
    id: "large-extent",
    level: Level::Warn,
    summary: "A scene extends over more than 500 units.",
    doc: include_str!("large_extent.md"),
    targets: &[],
    check,
};

/// The largest extent along an axis, in units of the scene; the limit of the profile's methodology.
const EXTENT: f64 = 500.0;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    let Some(bounds) = survey.bounds else { return };
    let size = bounds.size();
    let Some(axis) = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).filter(|axis| size[*axis] > EXTENT) else {
        return;
    };
    let letter = ["x", "y", "z"][axis];
    let far = |low: bool| {
        let ends =
            survey.placed.iter().map(|placed| if low { -placed.bounds.low[axis] } else { placed.bounds.high[axis] });
        ends.zip(&survey.placed).max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, placed)| placed)
    };
    let finding = report.add(
        &subject.scene.origin,
        format!("the scene extends over {} units along {letter}", rounded(size[axis])),
        "this scene",
        &format!(
            "from {} to {}; renderers lose single precision in ways of their own",
            bounds.low[axis], bounds.high[axis]
        ),
        format!("scale the scene to at most {EXTENT} units, and powers and distances with it"),
    );
    let ends: Vec<_> = [far(true), far(false)].into_iter().flatten().collect();
    for (end, placed) in ends.iter().enumerate() {
        if end == 0 || placed.origin != ends[0].origin {
            also(finding, placed.origin, if end == 0 { "reaches its low end" } else { "reaches its high end" });
        }
    }
}

/// A length for people: coordinates are single precision, and have some seven digits.
fn rounded(length: f64) -> f64 {
    (length * 1e3).round() / 1e3
}
