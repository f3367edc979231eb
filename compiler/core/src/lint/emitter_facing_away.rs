//! Rule `emitter-facing-away`: an emitter shines on something.
#![doc = include_str!("emitter_facing_away.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{LightKind, Vec3, dot, length, sub};
use crate::mesh::face_normal;
use crate::survey::{Bounds, Placed, Survey};

pub(super) const RULE: Rule = Rule {
    id: "emitter-facing-away",
    level: Level::Warn,
    summary: "An emitter has no surface and no camera in front of it.",
    doc: include_str!("emitter_facing_away.md"),
    targets: &[],
    check,
};

/// How far in front of an emitter something must lie, as a share of the scene's size: more than the rounding of coordinates.
const CLEAR: f64 = 1e-6;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    let (Some(bounds), false) = (survey.bounds, survey.cut) else { return };
    let clear = CLEAR * (1.0 + bounds.reach());
    let note = "it emits on the side of its normals only: nothing receives its light, and no camera sees it shine";
    // Most emitters are black, and receive nothing.
    let receiving: Vec<bool> = scene.materials.values().map(|material| !material.bsdf.is_black()).collect();
    let receives = |placed: &&Placed<'_>| receiving.get(placed.shape.material.index()).copied().unwrap_or(false);
    let receivers: Vec<&Placed<'_>> = survey.placed.iter().filter(receives).collect();
    for placed in survey.placed.iter().filter(|placed| placed.shape.emission.is_some()) {
        if has_something_in_front(survey, placed, &receivers, clear) {
            continue;
        }
        report.add(
            placed.origin,
            format!("the emitter `{}` faces away from everything", placed.name()),
            "this emitter",
            note,
            "turn it over: another sign of `normal`, or `|> flip()` behind its mesh".to_owned(),
        );
    }
    for (origin, light) in scene.lights.entries() {
        let LightKind::Spot { position, target, intensity: _, angle, inner: _ } = light.kind else { continue };
        let axis = sub(target, position);
        if !survey.placed.iter().all(|placed| outside_cone(placed.bounds, position, axis, angle)) {
            continue;
        }
        report.add(
            origin,
            format!("no surface lies in the cone of the spot `{}`", light.name),
            "this light",
            "nothing receives its light",
            "look at `target`, which is a point and no direction, and at `angle`".to_owned(),
        );
    }
}

/// Whether another surface that scatters light, or a camera, lies in front of a triangle of the emitter.
fn has_something_in_front(survey: &Survey<'_>, emitter: &Placed<'_>, receivers: &[&Placed<'_>], clear: f64) -> bool {
    survey.triangles(emitter).any(|triangle| {
        let Some(normal) = face_normal(triangle) else { return false };
        let level = dot(normal, triangle[0]) + clear;
        let cameras = &survey.scene.cameras;
        let mut others = receivers.iter().filter(|other| !std::ptr::eq(**other, emitter));
        cameras.values().any(|camera| dot(normal, camera.eye) > level)
            || others.any(|other| reaches(survey, other, normal, level))
    })
}

/// Whether a part of a surface lies beyond the plane `normal . x = level`.
fn reaches(survey: &Survey<'_>, placed: &Placed<'_>, normal: Vec3, level: f64) -> bool {
    let Bounds { low, high } = placed.bounds;
    let farthest = [0, 1, 2].map(|axis| if normal[axis] > 0.0 { high[axis] } else { low[axis] });
    dot(normal, farthest) > level
        && survey.triangles(placed).any(|triangle| triangle.iter().any(|corner| dot(normal, *corner) > level))
}

/// Whether a box lies behind the apex of a cone with half opening `angle` in degrees, or the ball around it outside of the cone;
/// false where it may lie inside.
fn outside_cone(bounds: Bounds, apex: Vec3, axis: Vec3, angle: f64) -> bool {
    if bounds.corners().iter().all(|corner| dot(sub(*corner, apex), axis) <= 0.0) {
        return true;
    }
    let to = sub(bounds.center(), apex);
    let (distance, radius) = (length(to), bounds.diagonal() / 2.0);
    if distance <= radius {
        return false;
    }
    let off = libm::acos((dot(to, axis) / (distance * length(axis))).clamp(-1.0, 1.0));
    off > angle.to_radians() + libm::asin(radius / distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_outside_a_cone_where_its_ball_is() {
        let cube = |center: Vec3| Bounds { low: center.map(|x| x - 0.5), high: center.map(|x| x + 0.5) };
        let out = |center, angle| outside_cone(cube(center), [0.0; 3], [0.0, 0.0, -2.0], angle);
        assert!(!out([0.0, 0.0, -5.0], 1.0) && out([0.0, 0.0, 5.0], 80.0));
        // At 45 degrees, with a ball that covers asin(0.866 / 7.07) = 7 degrees to each side.
        assert!(out([5.0, 0.0, -5.0], 37.0) && !out([5.0, 0.0, -5.0], 39.0));
        assert!(!out([0.0, 0.0, 0.3], 5.0), "it surrounds the apex");
        assert!(out([0.0, 0.0, 0.6], 90.0), "it lies behind the apex");
    }
}
