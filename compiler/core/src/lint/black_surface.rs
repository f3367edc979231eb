//! Rule `black-surface`: surfaces reflect something.
#![doc = include_str!("black_surface.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{Bsdf, Color};

pub(super) const RULE: Rule = Rule {
    id: "black-surface",
    level: Level::Warn,
    summary: "A surface reflects no light at all.",
    doc: include_str!("black_surface.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (origin, shape) in scene.surfaces().filter(|(_, shape)| shape.material.index() < scene.materials.len()) {
        let black = match &scene.materials[shape.material].bsdf {
            Bsdf::Diffuse { reflectance } => reflectance.color().is_some_and(Color::is_black),
            Bsdf::Mirror { reflectance } => reflectance.is_black(),
            Bsdf::Conductor { eta: _, k: _, alpha: _ } | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {
                false
            }
        };
        if !black || shape.emission.is_some() {
            continue;
        }
        report.add(
            origin,
            format!("the surface of `{}` is black", shape.name),
            "it reflects nothing",
            "a black surface tests that a renderer computes 0; relative differences are not defined on it",
            "give it a reflectance above 0, or remove it".to_owned(),
        );
    }
}
