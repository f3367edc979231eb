//! Rule `out-of-range-distance`: what a camera sees is neither very near nor very far.
#![doc = include_str!("out_of_range_distance.md")]

use super::{Level, Report, Rule, Subject, also, called};
use crate::survey::{Frustum, Placed, Span, Survey};

pub(super) const RULE: Rule = Rule {
    id: "out-of-range-distance",
    level: Level::Warn,
    summary: "A camera sees a surface nearer than 0.01 or farther than 1000 units.",
    doc: include_str!("out_of_range_distance.md"),
    targets: &[],
    check,
};

/// The range of distances along the optical axis, in scene units; the profile's methodology ("lteval", 2020).
const RANGE: Span = Span { near: 0.01, far: 1000.0 };

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    for (origin, camera) in scene.cameras.entries() {
        let Some(frustum) = Frustum::of(camera, &scene.film) else { continue };
        // What the camera's own clipping distances leave out is not seen.
        let clip = Span { near: camera.near.unwrap_or(0.0), far: camera.far.unwrap_or(f64::INFINITY) };
        let ends = Ends::of(survey, &frustum, clip);
        if let Some((near, placed)) = ends.near {
            let finding = report.add(
                origin,
                format!("{} sees `{}` {} units in front of it", called(camera), placed.name(), short(near)),
                "this camera",
                "Mitsuba cuts off what is nearer than 0.01 unless told otherwise, LuxCore what is nearer than 0.001, PBRT nothing; \
                 and the errors of single precision are as large as such distances",
                format!("keep {} units between the camera and what it sees, or scale the scene up", RANGE.near),
            );
            also(finding, placed.origin, "the nearest that it sees");
        }
        if let Some((far, placed)) = ends.far {
            let finding = report.add(
                origin,
                format!("{} sees `{}` {} units away", called(camera), placed.name(), short(far)),
                "this camera",
                "renderers clip at distances of their own (Mitsuba at 10000), and single precision has few digits left for details \
                 that are so far away",
                format!("keep what is seen within {} units, or scale the scene down", RANGE.far),
            );
            also(finding, placed.origin, "the farthest that it sees");
        }
    }
}

/// The nearest and the farthest visible surface that lie out of range.
#[derive(Default)]
struct Ends<'a, 's> {
    near: Option<(f64, &'a Placed<'s>)>,
    far: Option<(f64, &'a Placed<'s>)>,
}

impl<'a, 's> Ends<'a, 's> {
    fn of(survey: &'a Survey<'s>, frustum: &Frustum, clip: Span) -> Self {
        let mut ends = Self::default();
        let good = |span: Span| span.near >= RANGE.near && span.far <= RANGE.far;
        for placed in &survey.placed {
            if good(frustum.depths(placed.bounds)) || !frustum.may_see(placed.bounds) {
                continue;
            }
            for span in survey.triangles(placed).filter_map(|triangle| frustum.sees(triangle)) {
                if good(span) || span.far < clip.near || span.near > clip.far {
                    continue;
                }
                let (near, far) = (span.near.max(clip.near), span.far.min(clip.far));
                if near < RANGE.near && ends.near.is_none_or(|(least, _)| near < least) {
                    ends.near = Some((near, placed));
                }
                if far > RANGE.far && ends.far.is_none_or(|(most, _)| far > most) {
                    ends.far = Some((far, placed));
                }
            }
        }
        ends
    }
}

/// A distance for people: two digits of one that is out of range suffice to find it.
fn short(distance: f64) -> f64 {
    if distance >= 1.0 { distance.round() } else { (distance * 1e5).round() / 1e5 }
}
