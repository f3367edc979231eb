//! Rule `non-basic-material`: materials that all renderers have.
#![doc = include_str!("non_basic_material.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::Bsdf;

pub(super) const RULE: Rule = Rule {
    id: "non-basic-material",
    level: Level::Warn,
    summary: "A material is none of the four that renderers share.",
    doc: include_str!("non_basic_material.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, material) in scene.materials.iter() {
        let word = match &material.bsdf {
            Bsdf::Plastic { reflectance: _, ior: _, alpha: _ } => "plastic",
            Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => "principled",
            Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
            | Bsdf::Mirror { reflectance: _ } => continue,
        };
        report.add(
            scene.materials.origin(handle),
            format!("the material `{}` is `{word}`, which every renderer has in a way of its own", material.name),
            "no basic material",
            "images of different renderers cannot be compared where it is seen; `ltsc explain --target NAME` says what stands for it",
            "use `diffuse`, `conductor`, `dielectric` or `mirror`".to_owned(),
        );
    }
}
