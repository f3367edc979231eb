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

/// How far in front of an emitter something must lie, as a share of the coordinates of both: more than their rounding. What else the
/// scene holds, and how large it is, plays no part.
const CLEAR: f64 = 1e-6;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    if survey.cut {
        return;
    }
    let note = "it emits on the side of its normals only: nothing receives its light, and no camera sees it shine";
    // Most emitters are black, and receive nothing.
    let receiving: Vec<bool> = scene.materials.values().map(|material| !material.bsdf.is_black()).collect();
    let receives = |placed: &&Placed<'_>| receiving.get(placed.shape.material.index()).copied().unwrap_or(false);
    let receivers: Vec<&Placed<'_>> = survey.placed.iter().filter(receives).collect();
    for placed in survey.placed.iter().filter(|placed| placed.shape.emission.is_some()) {
        if has_something(survey, placed, &receivers, 1.0) {
            continue;
        }
        let behind = has_something(survey, placed, &receivers, -1.0);
        let finding = report.add(
            placed.origin,
            format!("the emitter `{}` faces away from everything", placed.name()),
            "this emitter",
            note,
            if behind {
                "turn it over: another sign of `normal`, or `|> flip()` behind its mesh".to_owned()
            } else {
                "let something stand before it; nothing lies behind it either".to_owned()
            },
        );
        finding.fixable = behind;
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

/// Whether another surface that scatters light, or a camera, lies in front of a triangle of the emitter, or behind it for a `side` of -1.
fn has_something(survey: &Survey<'_>, emitter: &Placed<'_>, receivers: &[&Placed<'_>], side: f64) -> bool {
    survey.triangles(emitter).any(|triangle| {
        let Some(normal) = face_normal(triangle) else { return false };
        let front = Front { normal: normal.map(|x| side * x), point: triangle[0], size: size(triangle[0]) };
        let cameras = &survey.scene.cameras;
        let mut others = receivers.iter().filter(|other| !std::ptr::eq(**other, emitter));
        cameras.values().any(|camera| front.holds(camera.eye)) || others.any(|other| reaches(survey, other, &front))
    })
}

/// The space in front of a plane.
struct Front {
    normal: Vec3,
    /// A point of the plane.
    point: Vec3,
    /// Its largest coordinate.
    size: f64,
}

impl Front {
    /// Whether a point lies in it, beyond what rounding may do to its coordinates and the plane's.
    fn holds(&self, point: Vec3) -> bool {
        dot(self.normal, sub(point, self.point)) > CLEAR * self.size.max(size(point))
    }
}

fn size(point: Vec3) -> f64 {
    point.into_iter().fold(0.0, |most, x| x.abs().max(most))
}

/// Whether a part of a surface lies in front.
fn reaches(survey: &Survey<'_>, placed: &Placed<'_>, front: &Front) -> bool {
    let Bounds { low, high } = placed.bounds;
    let farthest = [0, 1, 2].map(|axis| if front.normal[axis] > 0.0 { high[axis] } else { low[axis] });
    dot(front.normal, sub(farthest, front.point)) > 0.0
        && survey.triangles(placed).any(|triangle| triangle.iter().any(|corner| front.holds(*corner)))
}

/// Whether a box lies behind the apex of a cone with half opening `angle` in degrees, or the ball around it outside of the cone;
/// false where it may lie inside.
fn outside_cone(bounds: Bounds, apex: Vec3, axis: Vec3, angle: f64) -> bool {
    let rounding = |corner: Vec3| CLEAR * size(apex).max(size(corner)) * length(axis);
    if bounds.corners().into_iter().all(|corner| dot(sub(corner, apex), axis) <= rounding(corner)) {
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
