//! Rule `smooth-emitter`: emitters are faceted.
#![doc = include_str!("smooth_emitter.md")]

use super::{Level, Report, Rule, Subject};

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
    for (origin, shape) in scene.surfaces().filter(|(_, shape)| shape.emission.is_some()) {
        let degrees = subject.faults(shape.mesh).lean;
        if degrees > TOLERANCE {
            let finding = report.add(
                origin,
                format!(
                    "the emitter `{}` has smooth normals: they lean up to {degrees:.1} degrees from the faces",
                    shape.name
                ),
                "this emitter",
                "Mitsuba and PBRT decide the emitting side by the shading normal or by the face, and not all alike",
                "write `|> faceted()` behind its mesh".to_owned(),
            );
            // What it scatters would look otherwise.
            finding.fixable =
                scene.materials.values().nth(shape.material.index()).is_some_and(|one| one.bsdf.is_black());
        }
    }
}
