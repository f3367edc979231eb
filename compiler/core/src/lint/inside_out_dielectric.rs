//! Rule `inside-out-dielectric`: the normals of glass look outwards.
#![doc = include_str!("inside_out_dielectric.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Bsdf;

pub(super) const RULE: Rule = Rule {
    id: "inside-out-dielectric",
    level: Level::Deny,
    summary: "A closed dielectric has its normals inside: the solid is outside of it.",
    doc: include_str!("inside_out_dielectric.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (origin, shape) in scene.surfaces().filter(|(_, shape)| shape.material.index() < scene.materials.len()) {
        let Bsdf::Dielectric { interior, exterior, alpha: _ } = &scene.materials[shape.material].bsdf else { continue };
        if !subject.is_inside_out(shape.mesh) {
            continue;
        }
        report.add(
            origin,
            format!("the normals of the dielectric `{}` look into it", shape.name),
            "this surface",
            &format!(
                "the index {interior} holds behind the normals, that is in all space around it, and {exterior} inside: light bends the \
                 wrong way, and Cycles, which does not scale radiance by the index, is off by its square"
            ),
            format!("write `|> flip()` behind its mesh; for a bubble write `dielectric(ior: {exterior}, outside: {interior})` instead"),
        );
    }
}
