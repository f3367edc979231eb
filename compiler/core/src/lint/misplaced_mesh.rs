//! Rule `misplaced-mesh`: a mesh that is used once lies where it is seen.
#![doc = include_str!("misplaced_mesh.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Affine;

pub(super) const RULE: Rule = Rule {
    id: "misplaced-mesh",
    level: Level::Allow,
    summary: "A mesh or group with one use is moved by a transform instead of lying in its place.",
    doc: include_str!("misplaced_mesh.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let mut uses = vec![0_usize; scene.meshes.len()];
    for (_, shape) in scene.surfaces() {
        if let Some(uses) = uses.get_mut(shape.mesh.index()) {
            *uses += 1;
        }
    }
    let note = "a transform is applied in double precision here and in single precision there; ltsc applies it once to the vertices \
                where it can";
    let once = scene.surfaces().filter(|(_, shape)| uses.get(shape.mesh.index()) == Some(&1));
    for (origin, shape) in once.filter(|(_, shape)| shape.transform != Affine::IDENTITY) {
        report.add(
            origin,
            format!("the mesh of `{}` has one use and does not lie in its place", shape.name),
            "moved by a transform",
            note,
            "give its generator the coordinates in the scene, or move the vertices in the file".to_owned(),
        );
    }
    let mut placed = vec![0_usize; scene.groups.len()];
    let inner = || scene.groups.values().flat_map(|group| group.instances.entries());
    for (_, instance) in scene.instances.entries().chain(inner()) {
        if let Some(placed) = placed.get_mut(instance.group.index()) {
            *placed += instance.places.maps().len();
        }
    }
    let once = scene.instances.entries().chain(inner()).filter(|(_, i)| placed.get(i.group.index()) == Some(&1));
    for (origin, instance) in once.filter(|(_, instance)| instance.places.maps() != [Affine::IDENTITY]) {
        report.add(
            origin,
            format!("the group of the instance `{}` is placed once and does not lie in its place", instance.name),
            "moved by a transform",
            note,
            "write its shapes where they lie in the scene".to_owned(),
        );
    }
}
