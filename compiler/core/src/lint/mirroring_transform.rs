//! Rule `mirroring-transform`: nothing is moved by a transform that turns left into right.
#![doc = include_str!("mirroring_transform.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Affine;

pub(super) const RULE: Rule = Rule {
    id: "mirroring-transform",
    level: Level::Warn,
    summary: "A transform mirrors: it turns a left hand into a right one.",
    doc: include_str!("mirroring_transform.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (origin, shape) in scene.surfaces().filter(|(_, shape)| shape.transform.determinant() < 0.0) {
        report.add(
            origin,
            format!("the transform of `{}` mirrors its mesh", shape.name),
            "mirrored",
            "renderers disagree on the front of a mirrored mesh, so a mirrored copy with its winding turned is written; texts and \
             coordinate systems of other programs are mirrored by mistake",
            "turn the mesh instead (`rotate`), or write `allow mirroring-transform` with the reason before it".to_owned(),
        );
    }
    let inner = scene.groups.values().flat_map(|group| group.instances.entries());
    for (origin, instance) in scene.instances.entries().chain(inner) {
        let mirrored = |map: &Affine| map.determinant() < 0.0;
        let Some(first) = instance.places.maps().iter().position(mirrored) else { continue };
        report.add(
            origin,
            format!(
                "the transform of the instance `{}` mirrors its group",
                instance.places.name_of(&instance.name, first)
            ),
            "mirrored",
            "renderers disagree on the front of a mirrored instance, so a mirrored copy of the whole group is written",
            "turn the group instead (`rotate`), or write `allow mirroring-transform` with the reason before it"
                .to_owned(),
        );
    }
}
