//! Rule `nothing-in-view`: a camera sees the scene.
#![doc = include_str!("nothing_in_view.md")]

use super::{Level, Report, Rule, Subject, called};
use crate::ir::{Camera, LightKind};
use crate::survey::{Frustum, Survey};

pub(super) const RULE: Rule = Rule {
    id: "nothing-in-view",
    level: Level::Deny,
    summary: "A camera sees no surface.",
    doc: include_str!("nothing_in_view.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    for (origin, camera) in scene.cameras.entries() {
        let Some(frustum) = Frustum::of(camera, &scene.film) else { continue };
        if survey.cut || sees_something(survey, camera, &frustum) {
            continue;
        }
        let around = scene
            .lights
            .values()
            .any(|light| matches!(light.kind, LightKind::Environment { radiance: _, tint: _, turn: _ }));
        report.add(
            origin,
            format!("{} sees no surface", called(camera)),
            "this camera",
            if around {
                "the image shows the environment and nothing else"
            } else {
                "the image is black in every renderer: that they agree on it says nothing"
            },
            "look at `eye`, `target`, `fov_x`, `near` and `far`; for example let `target` be a point of the scene"
                .to_owned(),
        );
    }
}

/// Whether a triangle lies in the image, and between the clipping distances; what hides it is another surface.
fn sees_something(survey: &Survey<'_>, camera: &Camera, frustum: &Frustum) -> bool {
    let near = camera.near.unwrap_or(0.0);
    let far = camera.far.unwrap_or(f64::INFINITY);
    survey.placed.iter().filter(|placed| frustum.may_see(placed.bounds)).any(|placed| {
        let spans = survey.triangles(placed).filter_map(|triangle| frustum.sees(triangle));
        spans.into_iter().any(|span| span.far >= near && span.near <= far)
    })
}
