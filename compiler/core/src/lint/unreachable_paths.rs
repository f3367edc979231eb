//! Rule `unreachable-paths`: the light paths of a scene can be found.
#![doc = include_str!("unreachable_paths.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{LightExtent, LightKind, LightPaths, LightSource};

pub(super) const RULE: Rule = Rule {
    id: "unreachable-paths",
    level: Level::Warn,
    summary: "No algorithm of local sampling finds the light paths that a scene tests.",
    doc: include_str!("unreachable_paths.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    // A scene with one light that has an extent is judged by it: its paths do not say which light they mean.
    let wide = |light: &LightSource| matches!(light.kind, LightKind::Environment { radiance: _, tint: _, turn: _ });
    let extended = scene.surfaces().any(|(_, shape)| shape.emission.is_some()) || scene.lights.values().any(wide);
    let extent = if extended || scene.lights.is_empty() { LightExtent::Area } else { LightExtent::Point };
    for text in &scene.documentation.paths {
        let Ok(class) = LightPaths::parse(text) else { continue };
        if !class.is_whole() || class.is_found_by_local_sampling(extent) {
            continue;
        }
        report.add(
            &scene.origin,
            format!("paths of the class `{text}` are found by no local sampling"),
            "this scene",
            "in full form some of them have no two neighboring `D`: path tracing, light tracing and bidirectional path tracing \
             leave them black, photon mapping blurs them (Veach 1997, section 8.3.4)",
            "give the light an extent, or leave the class out of `paths`".to_owned(),
        );
    }
}
