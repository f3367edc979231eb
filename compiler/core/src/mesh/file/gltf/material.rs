//! Materials of glTF 2.0, with the extensions for transmission, index of refraction, specular reflection and emissive
//! strength.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

use super::super::model::{Picture, Scatter, Surface};
use super::accessor::Buffers;
use super::decoded;
use crate::ir::Vec3;

/// The materials in their order.
pub(super) fn surfaces(buffers: &Buffers<'_>) -> Vec<Surface> {
    // Materials may share an image: its bytes are there once.
    let mut images = BTreeMap::new();
    let mut image = |info: &json::texture::Info| {
        let texture = buffers.root.textures.get(info.index.value()).filter(|_| info.tex_coord == 0)?;
        let source = texture.source.value();
        images.entry(source).or_insert_with(|| picture(buffers, source)).clone()
    };
    buffers.root.materials.iter().map(|material| surface(material, &mut image)).collect()
}

/// The image number `source`; none where it cannot be had.
fn picture(buffers: &Buffers<'_>, source: usize) -> Option<Picture> {
    let root = buffers.root;
    let image = root.images.get(source)?;
    let ending = |kind: &str| match kind {
        "image/png" => Some("png"),
        "image/jpeg" => Some("jpg"),
        _ => None,
    };
    if let Some(view) = image.buffer_view {
        let ending = ending(&image.mime_type.as_ref()?.0)?;
        let size = root.buffer_views.get(view.value())?.byte_length.0;
        return Some(Picture::Inside { image: source, ending, bytes: buffers.range(view.value(), 0, size)?.into() });
    }
    let uri = image.uri.as_deref()?;
    match uri.strip_prefix("data:") {
        Some(data) => {
            let (kind, text) = data.split_once(";base64,")?;
            Some(Picture::Inside { image: source, ending: ending(kind)?, bytes: STANDARD.decode(text).ok()?.into() })
        }
        None => decoded(uri).map(Picture::Beside),
    }
}

/// What glTF 2.0 and the extensions say where a file is silent.
const IOR: f64 = 1.5;

fn surface(material: &json::Material, image: &mut dyn FnMut(&json::texture::Info) -> Option<Picture>) -> Surface {
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
    let picture = pbr.base_color_texture.as_ref().and_then(image);
    lose(
        pbr.base_color_texture.is_some() && picture.is_none(),
        "textures of the base colour in a form that is not known",
    );
    lose(picture.is_some() && base != [1.0; 3], "the factor on a texture of the base colour");
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
    Surface { name, scatter, emission: shines.then_some(emission), picture, lost }
}

/// A number held to 0..1; 0 for what is none.
fn unit(x: f32) -> f64 {
    if x.is_finite() { f64::from(x).clamp(0.0, 1.0) } else { 0.0 }
}
