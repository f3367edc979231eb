//! Rule `reflectance-over-one`: surfaces reflect at most what they receive.
#![doc = include_str!("reflectance_over_one.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{Bsdf, Color, Texture};

pub(super) const RULE: Rule = Rule {
    id: "reflectance-over-one",
    level: Level::Deny,
    summary: "A surface reflects more light than it receives.",
    doc: include_str!("reflectance_over_one.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, material) in scene.materials.iter() {
        let image = material.bsdf.texture().and_then(|texture| scene.textures.values().nth(texture.index()));
        let reflectance = match &material.bsdf {
            Bsdf::Diffuse { reflectance } | Bsdf::Plastic { reflectance, ior: _, alpha: _ } => reflectance.color(),
            Bsdf::Principled { base, metallic: _, roughness: _, ior: _ } => base.color(),
            Bsdf::Mirror { reflectance } => Some(reflectance),
            Bsdf::Conductor { eta: _, k: _, alpha: _ } | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {
                None
            }
        };
        let Some(most) = reflectance.map(Color::max).or(image.map(Texture::most)) else { continue };
        if most <= 1.0 {
            continue;
        }
        let what = match image {
            Some(texture) => format!("the largest number of its image `{}` is {most}", texture.name),
            None => format!("the largest channel is {most}"),
        };
        report.add(
            scene.materials.origin(handle),
            format!("the material `{}` reflects more light than it receives", material.name),
            &what,
            "light grows with every bounce, so the image depends on the depth limit; Mitsuba 0.x scales it down, PBRT v4 refuses the file",
            "reflectances lie between 0 and 1; scale the radiance of the emitters instead".to_owned(),
        );
    }
}
