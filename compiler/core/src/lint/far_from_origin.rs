//! Rule `far-from-origin`: details are large against their coordinates.
#![doc = include_str!("far_from_origin.md")]

use super::{Level, Report, Rule, Subject, short};
use crate::ir::length;
use crate::survey::Placed;

pub(super) const RULE: Rule = Rule {
    id: "far-from-origin",
    level: Level::Warn,
    summary: "A body is thinner than a ten thousandth of its coordinates: Mitsuba's rays step over it.",
    doc: include_str!("far_from_origin.md"),
    targets: &["mitsuba-0.5", "mitsuba-0.6", "mitsuba-3"],
    check,
};

/// The largest coordinate over the smallest detail. Measured: Mitsuba 0.x passes over hits nearer than 1e-4 of the largest coordinate,
/// Mitsuba 3 starts rays 8.94e-5 (1 + largest coordinate) off the surface.
const RATIO: f64 = 1e4;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    for placed in &survey.placed {
        let Some(detail) = thickness(subject, placed) else { continue };
        let reach = placed.bounds.reach();
        if reach <= RATIO * detail {
            continue;
        }
        report.add(
            placed.origin,
            format!("`{}` is {} thin, and its coordinates reach {}", placed.name(), short(detail), short(reach)),
            "this shape",
            "Mitsuba starts a ray about 1e-4 of its largest coordinate off the surface: it steps over what is thinner, and light leaks \
             along corners by that width",
            "move the scene to the origin, or make the detail larger".to_owned(),
        );
    }
}

/// The smallest extent of a use along the axes of its mesh, in units of the scene; flat sides do not count.
fn thickness(subject: &Subject<'_>, placed: &Placed<'_>) -> Option<f64> {
    let own = subject.survey().meshes.get(placed.shape.mesh.index()).copied().flatten()?;
    // Below four units in the last place a side is flat.
    let flat = own.reach() / f64::from(1 << 21);
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| length(placed.transform.vector(axis)));
    let sides =
        own.size().into_iter().zip(columns).filter(|(side, _)| *side > flat).map(|(side, factor)| side * factor);
    sides.min_by(f64::total_cmp)
}
