//! Rule `smooth-emitter`: emitters are faceted.
#![doc = include_str!("smooth_emitter.md")]

use super::{Level, Report, Rule, Subject};
use crate::mesh::{View, largest_normal_deviation};

/// How far a normal may lean from its face, in degrees: files round their normals.
const TOLERANCE: f64 = 1.0;

pub(super) const RULE: Rule = Rule {
    id: "smooth-emitter",
    level: Level::Deny,
    summary: "An emitter has smooth normals, and renderers disagree on which side and how much it emits.",
    doc: include_str!("smooth_emitter.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    // A mesh is measured once, however many emitters share it.
    let mut known: Vec<Option<Option<f64>>> = vec![None; scene.meshes.len()];
    for (origin, shape) in scene.surfaces() {
        if shape.emission.is_none() {
            continue;
        }
        let mesh = &scene.meshes[shape.mesh];
        let slot = &mut known[shape.mesh.index()];
        let deviation = *slot.get_or_insert_with(|| largest_normal_deviation(View::from(mesh)));
        if let Some(degrees) = deviation.filter(|degrees| *degrees > TOLERANCE) {
            report.add(
                origin,
                format!(
                    "the emitter `{}` has smooth normals: they lean up to {degrees:.1} degrees from the faces",
                    shape.name
                ),
                "this emitter",
                "Mitsuba and PBRT decide the emitting side by the shading normal or by the face, and not all alike",
                "write `|> faceted()` behind its mesh".to_owned(),
            );
        }
    }
}
