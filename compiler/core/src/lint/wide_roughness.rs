//! Rule `wide-roughness`: rough glass, and metal so rough that renderers part.
#![doc = include_str!("wide_roughness.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Bsdf;

pub(super) const RULE: Rule = Rule {
    id: "wide-roughness",
    level: Level::Warn,
    summary: "Rough glass, and metal with an alpha above 0.3, is dimmer in one renderer than in another.",
    doc: include_str!("wide_roughness.md"),
    targets: &["luxcore", "cycles", "pbrt-v3", "pbrt-v4"],
    check,
};

/// The GGX width of metal up to which masking and shadowing matter by less than 1 %.
const METAL: f64 = 0.3;

/// The GGX width of glass up to which LuxCore is off by less than 2 % in its means.
const GLASS: f64 = 0.05;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, material) in scene.materials.iter() {
        let (alpha, what, note, help) = match material.bsdf {
            Bsdf::Dielectric { interior: _, exterior: _, alpha } if alpha > GLASS => (
                alpha,
                "rough glass",
                "LuxCore's and Mitsuba's masking differ, and Cycles' and PBRT's are correlated by height: a ball under even light, at its \
                 middle and towards its edge, shows in LuxCore 0.95 and 0.94 of what it shows in Mitsuba 3 for an alpha of 0.3, 0.84 and 0.75 \
                 for 0.5, 0.63 and 0.32 for 1; in Cycles 1.00 and 1.02, 1.00 and 1.05, 1.01 and 1.31; below 0.3 LuxCore has bright specks",
                "write `alpha: 0`, or leave `luxcore` out of the targets that are compared",
            ),
            Bsdf::Conductor { eta: _, k: _, alpha } if alpha > METAL => (
                alpha,
                "metal",
                "masking and shadowing differ: in even light, seen at 0, 60 and 78.5 degrees, LuxCore is 8, 18 and 21 % darker than Mitsuba 3 for an \
                 alpha of 0.5, 21, 48 and 62 % for 1; Cycles and PBRT are 2 and 7 % brighter at 60 and 78.5 degrees for 0.5, 10 and 26 % for 1",
                "write an `alpha` of at most 0.3",
            ),
            Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ }
            | Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Mirror { reflectance: _ } => continue,
        };
        report.add(
            scene.materials.origin(handle),
            format!(
                "the material `{}` is {what} of alpha {alpha}, which renderers show of different brightness",
                material.name
            ),
            "this material",
            note,
            help.to_owned(),
        );
    }
}
