//! Materials: what of a surface glTF can say, with its Khronos extensions.

use super::buffer::bounds;
use super::document as doc;
use super::names::{self, textures};
use crate::formats;
use crate::formats::shared::coat::Coat;
use crate::ir::{Affine, Bsdf, Color, ColorOrTexture, Emission as Light, Material, Mesh, Scene};

/// The grey by which it is said how a coat changes an image.
const GREY: f64 = 0.5;

/// A color that glTF can hold: from 0 to 1.
fn held(color: &Color) -> [f64; 3] {
    color.rgb().map(|x| x.clamp(0.0, 1.0))
}

/// The factor and the texture of a base color.
fn paint(scene: &Scene, value: &ColorOrTexture) -> ([f64; 3], Option<doc::TextureIndex>) {
    match value {
        ColorOrTexture::Color(color) => (held(color), None),
        ColorOrTexture::Texture(handle) => {
            let own = &scene.textures[*handle];
            let known = textures(scene).find(|((texture, _), _)| std::ptr::eq(*texture, own));
            match known {
                Some((_, index)) => (held(&Color::Rgb(own.factor)), Some(doc::TextureIndex { index })),
                None => (own.factor.map(|part| part * formats::STAND_IN), None),
            }
        }
    }
}

/// What stands for `material` on a surface that emits `emission`, on a mesh of `thickness`.
pub fn material(scene: &Scene, material: &Material, emission: Option<&Light>, thickness: f64) -> doc::Material {
    let Material { name, bsdf, sides: _ } = material;
    let mut extensions = doc::Extensions::default();
    let opaque = |[r, g, b]: [f64; 3], metallic_factor, roughness_factor| doc::Metallic {
        base_color_factor: [r, g, b, 1.0],
        base_color_texture: None,
        metallic_factor,
        roughness_factor,
    };
    let (pbr_metallic_roughness, two_sided) = match bsdf {
        Bsdf::Diffuse { reflectance } => {
            // Without the specular layer that every glTF dielectric has, what remains is Lambert's reflection.
            extensions.specular = Some(doc::Specular { specular_factor: 0.0 });
            let (factor, base_color_texture) = paint(scene, reflectance);
            (doc::Metallic { base_color_texture, ..opaque(factor, 0.0, 1.0) }, true)
        }
        Bsdf::Conductor { eta, k, alpha } => (opaque(names::base_color(eta, k), 1.0, names::roughness(*alpha)), true),
        Bsdf::Dielectric { interior, exterior, alpha } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*interior, *exterior) });
            extensions.transmission = Some(doc::Transmission { transmission_factor: 1.0 });
            // A thickness above 0 says that the surface bounds a volume, hence refracts; rasterisers use its size.
            extensions.volume = Some(doc::Volume { thickness_factor: thickness });
            (opaque([1.0; 3], 0.0, names::roughness(*alpha)), false)
        }
        Bsdf::Mirror { reflectance } => (opaque(held(reflectance), 1.0, 0.0), true),
        Bsdf::Plastic { reflectance, ior, alpha } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*ior, 1.0) });
            // glTF's coat does not darken its base: what is seen of the base is written.
            let seen = |share: f64| Coat::new(*ior).seen(share.min(1.0));
            let (factor, base_color_texture) = match reflectance {
                ColorOrTexture::Color(color) => (held(&Color::Rgb(color.rgb().map(seen))), None),
                ColorOrTexture::Texture(texture) => {
                    let factor = scene.textures[*texture].factor.map(|part| seen(GREY * part) / GREY);
                    match paint(scene, reflectance) {
                        (_, Some(texture)) => (factor, Some(texture)),
                        (_, None) => (factor.map(|part| part * formats::STAND_IN), None),
                    }
                }
            };
            (doc::Metallic { base_color_texture, ..opaque(factor, 0.0, names::roughness(*alpha)) }, true)
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*ior, 1.0) });
            let (factor, base_color_texture) = paint(scene, base);
            (doc::Metallic { base_color_texture, ..opaque(factor, *metallic, *roughness) }, true)
        }
    };
    let mut emissive_factor = None;
    if let Some(Light { radiance }) = emission {
        let (factor, strength) = names::emission(radiance);
        emissive_factor = Some(factor);
        if strength != 1.0 && strength > 0.0 {
            let emissive_strength = doc::EmissiveStrength { emissive_strength: strength };
            extensions.emissive_strength = Some(emissive_strength);
        }
    }
    doc::Material {
        name: name.clone(),
        pbr_metallic_roughness,
        emissive_factor,
        // A double-sided emitter would emit on both sides.
        double_sided: two_sided && !material.is_one_sided() && emission.is_none(),
        extensions,
    }
}

/// The smallest extent of a mesh, as its vertices are written, that is not flat along it; 1 for a point. Of what is not clear 0.
pub fn thickness(bsdf: &Bsdf, mesh: &Mesh, map: &Affine) -> f64 {
    match bsdf {
        Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {}
        Bsdf::Diffuse { reflectance: _ }
        | Bsdf::Conductor { eta: _, k: _, alpha: _ }
        | Bsdf::Mirror { reflectance: _ }
        | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
        | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => return 0.0,
    }
    let (low, high) = bounds(&mesh.positions, (*map != Affine::IDENTITY).then_some(map));
    let extents = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let smallest = extents.into_iter().filter(|extent| *extent > 0.0).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 1.0 }
}
