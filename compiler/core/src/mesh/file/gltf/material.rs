//! Materials of glTF 2.0, with the extensions for transmission, index of refraction, specular reflection and emissive
//! strength.

use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

use super::super::model::{Scatter, Surface};
use crate::ir::Vec3;

/// The materials in their order.
pub(super) fn surfaces(root: &json::Root) -> Vec<Surface> {
    root.materials.iter().map(surface).collect()
}

/// What glTF 2.0 and the extensions say where a file is silent.
const IOR: f64 = 1.5;

fn surface(material: &json::Material) -> Surface {
    let mut lost = Vec::new();
    let pbr = &material.pbr_metallic_roughness;
    let color = pbr.base_color_factor.0.map(unit);
    let base = [color[0], color[1], color[2]];
    let extensions = material.extensions.as_ref();
    let ior = extensions.and_then(|all| all.ior.as_ref()).map_or(IOR, |ior| f64::from(ior.ior.0));
    let ior = if ior.is_finite() && ior >= 1.0 { ior } else { IOR };
    let specular = extensions.and_then(|all| all.specular.as_ref());
    let transmission = extensions.and_then(|all| all.transmission.as_ref());
    let transmitted = transmission.map_or(0.0, |it| unit(it.transmission_factor.0));
    let (metallic, roughness) = (unit(pbr.metallic_factor.0), unit(pbr.roughness_factor.0));
    let mut lose = |is: bool, what: &'static str| {
        if is {
            lost.push(what);
        }
    };
    lose(pbr.base_color_texture.is_some(), "textures of the base colour");
    lose(pbr.metallic_roughness_texture.is_some(), "textures of metallicity and roughness");
    lose(material.normal_texture.is_some(), "normal maps");
    lose(material.emissive_texture.is_some(), "textures of emission");
    lose(transmission.is_some_and(|it| it.transmission_texture.is_some()), "textures of transmission");
    let painted = specular.is_some_and(|it| it.specular_texture.is_some() || it.specular_color_texture.is_some());
    lose(painted, "textures of specular reflection");
    let cut = !matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque));
    lose(cut, "alpha, by which things are seen through a surface without being refracted");
    let strength = specular.map_or(1.0, |it| f64::from(it.specular_factor.0));
    let scatter = if transmitted > 0.0 {
        lose(transmitted < 1.0, "the part of light that glass does not transmit");
        lose(base != [1.0; 3], "the tint of transmitted light");
        Scatter::Glass { ior, alpha: roughness * roughness }
    } else if metallic == 0.0 && strength == 0.0 {
        Scatter::Diffuse(base)
    } else if metallic == 1.0 && roughness == 0.0 {
        Scatter::Mirror(base)
    } else {
        let tinted = specular.is_some_and(|it| it.specular_color_factor.0 != [1.0; 3]);
        lose(tinted || strength != 1.0, "strength and colour of specular reflection");
        Scatter::MetallicRoughness { base, metallic, roughness, ior }
    };
    let gain = extensions.and_then(|all| all.emissive_strength.as_ref());
    let gain = gain.map_or(1.0, |it| f64::from(it.emissive_strength.0));
    let emission: Vec3 = material.emissive_factor.0.map(|x| f64::from(x) * gain);
    let shines = emission.iter().all(|x| x.is_finite() && *x >= 0.0) && emission != [0.0; 3];
    let name = material.name.clone().unwrap_or_default();
    Surface { name, scatter, emission: shines.then_some(emission), lost }
}

/// A number held to 0..1; 0 for what is none.
fn unit(x: f32) -> f64 {
    if x.is_finite() { f64::from(x).clamp(0.0, 1.0) } else { 0.0 }
}
