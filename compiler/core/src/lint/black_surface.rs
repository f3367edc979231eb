//! Rule `black-surface`: surfaces reflect something.
#![doc = include_str!("black_surface.md")]

use super::{Level, Report, Rule, Subject};

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
        let black = scene.materials[shape.material].bsdf.is_black();
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
