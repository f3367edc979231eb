//! Rule `rough-too-small`: a microfacet surface is rough enough to be sampled alike.
#![doc = include_str!("rough_too_small.md")]

use super::{Level, Report, Rule, Subject, short};
use crate::ir::Bsdf;

/// The smallest portable GGX width: the profile of the `lteval` test suite (Tázlar 2020).
const LEAST: f64 = 0.01;

pub(super) const RULE: Rule = Rule {
    id: "rough-too-small",
    level: Level::Deny,
    summary: "A GGX width below 0.01 is a mirror in one renderer and noise in another.",
    doc: include_str!("rough_too_small.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, material) in scene.materials.iter() {
        let (alpha, has, help) = match material.bsdf {
            Bsdf::Conductor { eta: _, k: _, alpha }
            | Bsdf::Dielectric { interior: _, exterior: _, alpha }
            | Bsdf::Plastic { reflectance: _, ior: _, alpha } => {
                let help = format!("write `alpha: {LEAST}`, `alpha: 0` for a smooth surface, or `mirror()`");
                (alpha, format!("alpha {alpha}"), help)
            }
            Bsdf::Principled { base: _, metallic: _, roughness, ior: _ } => {
                // Squared by all renderers; in f64, which 0.1 squared must not leave.
                let alpha = (roughness * roughness * 1e12).round() / 1e12;
                let help = format!("write `roughness: {}`, whose square is {LEAST}, or more", LEAST.sqrt());
                (alpha, format!("roughness {roughness}, alpha {}", short(alpha)), help)
            }
            Bsdf::Diffuse { reflectance: _ } | Bsdf::Mirror { reflectance: _ } => continue,
        };
        if alpha > 0.0 && alpha < LEAST {
            report.add(
                scene.materials.origin(handle),
                format!("the material `{}` has {has}, less than {LEAST}", material.name),
                "this material",
                "PBRT treats a width below 0.001 as smooth, LuxCore and Cycles clamp it, and single precision loses the peak",
                help,
            );
        }
    }
}
