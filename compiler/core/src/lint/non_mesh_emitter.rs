//! Rule `non-mesh-emitter`: light comes from surfaces.
#![doc = include_str!("non_mesh_emitter.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "non-mesh-emitter",
    level: Level::Warn,
    summary: "Light comes from a point, a direction or the environment instead of a surface.",
    doc: include_str!("non_mesh_emitter.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    for (origin, light) in subject.scene.lights.entries() {
        report.add(
            origin,
            format!("the emitter `{}` is no surface but a light of kind `{}`", light.name, light.kind.word()),
            "this light",
            "glTF has no environment and gives other lights in lumens; algorithms find such lights in one way only, so that \
             nothing checks their strength; images of them differ where renderers meet them by chance",
            "write an area light: `emitter name = rectangle(...) with radiance(...)`".to_owned(),
        );
    }
}
