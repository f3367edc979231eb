//! Rule `camera-inside-mesh`: a camera stands outside of solid things.
#![doc = include_str!("camera_inside_mesh.md")]

use super::{Level, Report, Rule, Subject, also, called};
use crate::ir::Bsdf;
use crate::survey::{whole, winding};

pub(super) const RULE: Rule = Rule {
    id: "camera-inside-mesh",
    level: Level::Warn,
    summary: "A camera stands inside a closed surface that looks outwards.",
    doc: include_str!("camera_inside_mesh.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let survey = subject.survey();
    for (origin, camera) in scene.cameras.entries() {
        for placed in survey.placed.iter().filter(|placed| placed.bounds.contains(camera.eye)) {
            let material = placed.shape.material;
            let clear = material.index() < scene.materials.len()
                && matches!(scene.materials[material].bsdf, Bsdf::Dielectric { interior: _, exterior: _, alpha: _ });
            if clear || whole(winding(survey.triangles(placed), camera.eye)).is_none_or(|times| times <= 0) {
                continue;
            }
            let finding = report.add(
                origin,
                format!("{} stands inside `{}`", called(camera), placed.name()),
                "this camera",
                "it sees the backs of a closed surface, which no light from outside reaches: the image is dark, and says nothing \
                 about the scene",
                "move `eye` out of it; a room is made of walls that look inwards, for example `box(...) |> flip()`".to_owned(),
            );
            also(finding, placed.origin, "closed, and around the camera");
        }
    }
}
