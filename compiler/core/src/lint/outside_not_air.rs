//! Rule `outside-not-air`: dielectrics border on air.
#![doc = include_str!("outside_not_air.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Bsdf;

pub(super) const RULE: Rule = Rule {
    id: "outside-not-air",
    level: Level::Warn,
    summary: "The outside of a dielectric is not air, and not every renderer can say that.",
    doc: include_str!("outside_not_air.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, material) in scene.materials.iter() {
        let Bsdf::Dielectric { interior, exterior, alpha: _ } = &material.bsdf else { continue };
        if *exterior == 1.0 {
            continue;
        }
        report.add(
            scene.materials.origin(handle),
            format!("the outside of the material `{}` has the index of refraction {exterior}", material.name),
            "not air",
            "PBRT and Cycles have the ratio of both only, glTF and LuxCore's volumes know air outside: the ratio is written there, \
             and anything that depends on the medium itself is lost",
            format!("write `dielectric(ior: {})`, if only the ratio matters", short(interior / exterior)),
        );
    }
}

/// Five digits are enough for an index of refraction.
fn short(value: f64) -> String {
    let rounded = (value * 1e5).round() / 1e5;
    format!("{rounded}")
}
