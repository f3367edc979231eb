//! Rule `camera-in-dielectric`: a camera stands in air.
#![doc = include_str!("camera_in_dielectric.md")]

use super::{Level, Report, Rule, Subject, also, called};
use crate::ir::{Bsdf, Vec3, dot, sub};
use crate::mesh::face_normal;
use crate::survey::{Frustum, Placed, Survey, whole, winding};

pub(super) const RULE: Rule = Rule {
    id: "camera-in-dielectric",
    level: Level::Warn,
    summary: "A camera stands inside glass or water, where Cycles' radiance is of another scale.",
    doc: include_str!("camera_in_dielectric.md"),
    targets: &["cycles"],
    check,
};

/// How many points of an open surface are looked at.
const SAMPLES: usize = 16;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    let inside = |placed: &Placed<'_>| match scene.materials.values().nth(placed.shape.material.index())?.bsdf {
        Bsdf::Dielectric { interior, exterior: _, alpha: _ } if interior != 1.0 => Some(interior),
        Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
        | Bsdf::Diffuse { reflectance: _ }
        | Bsdf::Conductor { eta: _, k: _, alpha: _ }
        | Bsdf::Mirror { reflectance: _ }
        | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
        | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => None,
    };
    for (origin, camera) in scene.cameras.entries() {
        let Some(frustum) = Frustum::of(camera, &scene.film) else { continue };
        for placed in &survey.placed {
            let Some(interior) = inside(placed) else { continue };
            let surrounds = placed.bounds.contains(camera.eye);
            if !surrounds && !frustum.may_see(placed.bounds) || !stands_behind(survey, placed, &frustum, camera.eye) {
                continue;
            }
            let finding = report.add(
                origin,
                format!("{} stands behind the surface of `{}`", called(camera), placed.name()),
                &format!("in a medium of index {interior}"),
                &format!(
                    "a renderer that follows physics scales radiance with the square of the index where light is refracted, Cycles \
                     does not: where the light stands in air, its image is {:.3} times as bright as that of the others",
                    1.0 / (interior * interior)
                ),
                "move the camera into air, for example by a pane of the same material in front of it".to_owned(),
            );
            also(finding, placed.origin, "seen from behind");
        }
    }
}

/// Whether the eye is inside a closed surface, or sees an open one from behind.
fn stands_behind(survey: &Survey<'_>, placed: &Placed<'_>, frustum: &Frustum, eye: Vec3) -> bool {
    if let Some(times) = whole(winding(survey.triangles(placed), eye)) {
        // An open surface that covers next to nothing of the view cannot be told from a closed one, and matters as little.
        return times > 0;
    }
    let behind =
        |triangle: &[Vec3; 3]| face_normal(*triangle).is_some_and(|normal| dot(normal, sub(eye, triangle[0])) < 0.0);
    let seen: Vec<Vec3> =
        survey.triangles(placed).filter(behind).filter_map(|triangle| frustum.seen_point(triangle)).collect();
    let step = seen.len().div_ceil(SAMPLES).max(1);
    seen.iter().step_by(step).any(|point| !survey.blocked(eye, *point))
}
