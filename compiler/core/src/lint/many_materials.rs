//! Rule `many-materials`: few kinds of scattering in one scene.
#![doc = include_str!("many_materials.md")]

use super::{Level, Report, Rule, Subject, also};

use std::collections::BTreeMap;

use crate::diag::Origin;

pub(super) const RULE: Rule = Rule {
    id: "many-materials",
    level: Level::Warn,
    summary: "A scene has more than four kinds of scattering, and isolates none.",
    doc: include_str!("many_materials.md"),
    targets: &[],
    check,
};

/// The most kinds of scattering in one scene.
const KINDS: usize = 4;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let mut kinds: BTreeMap<&str, &Origin> = BTreeMap::new();
    for (_, shape) in scene.surfaces().filter(|(_, shape)| shape.material.index() < scene.materials.len()) {
        let kind = scene.materials[shape.material].bsdf.kind();
        kinds.entry(kind).or_insert(scene.materials.origin(shape.material));
    }
    if kinds.len() <= KINDS {
        return;
    }
    let list: Vec<&str> = kinds.keys().copied().collect();
    let finding = report.add(
        &scene.origin,
        format!("the scene has {} kinds of scattering", kinds.len()),
        "this scene",
        &format!("they are {}; a difference between renderers cannot be told apart by them", list.join(", ")),
        format!("keep at most {KINDS}, or make two scenes"),
    );
    for (kind, origin) in kinds {
        also(finding, origin, kind);
    }
}
