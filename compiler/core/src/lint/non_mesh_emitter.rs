//! Rule `non-mesh-emitter`: light comes from surfaces.
#![doc = include_str!("non_mesh_emitter.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::LightKind;

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
            match light.kind {
                LightKind::Environment { .. } => {
                    "glTF has no environment, and images of it differ where renderers sample it by chance"
                }
                LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Directional { .. } => {
                    "glTF gives such a light in lumens or lux, and no path hits it by chance: nothing checks its strength"
                }
            },
            "write an area light: `emitter name = rectangle(...) with radiance(...)`".to_owned(),
        );
    }
}
