//! Rule `one-sided-surface`: backs that some targets show black and others do not.
#![doc = include_str!("one_sided_surface.md")]

use std::collections::BTreeMap;

use super::{Level, Report, Rule, Subject, also_once};

pub(super) const RULE: Rule = Rule {
    id: "one-sided-surface",
    level: Level::Warn,
    summary: "An open surface is black from behind, which PBRT and glTF cannot say.",
    doc: include_str!("one_sided_surface.md"),
    targets: &["pbrt-v3", "pbrt-v4", "gltf", "glb"],
    check,
};

/// Materials whose places are shown.
const SHOWN: usize = 3;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let mut open = BTreeMap::new();
    for (origin, shape) in scene.surfaces() {
        let known = shape.material.index() < scene.materials.len() && shape.mesh.index() < scene.meshes.len();
        if known && scene.materials[shape.material].is_one_sided() && !subject.is_closed(shape.mesh) {
            open.entry(shape.material).or_insert((origin, shape));
        }
    }
    let Some((material, (_, shape))) = open.iter().next() else { return };
    let name = &scene.materials[*material].name;
    let more = match open.len() {
        1 => String::new(),
        all => format!(" (the first of {all} such materials)"),
    };
    let finding = report.add(
        scene.materials.origin(*material),
        format!("the material `{name}` of `{}` is black from behind{more}", shape.name),
        "black from behind",
        "PBRT shows the back as the front, and glTF does not show it: images are the same only where no path meets it",
        "where no path meets it give the surface two sides, which every renderer has".to_owned(),
    );
    for (material, _) in open.iter().skip(1).take(SHOWN) {
        also_once(finding, scene.materials.origin(*material), "so is this one");
    }
}
