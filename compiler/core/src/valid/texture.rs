//! Textures: images with pixels, encodings that their formats have, and surfaces that can carry them.

use crate::diag::Finding;
use crate::ir::{Encoding, ImageInfo, Scene, Shape, Texture};

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    for (origin, texture) in scene.textures.entries() {
        let Texture { name, file, image, encoding, peak, factor } = texture;
        let ImageInfo { format, width, height, channels, bits } = *image;
        let mut fault = |message: &str| {
            let message = format!("texture `{}`: {message}", name.escape_debug());
            findings.push(Finding::error("invalid-texture", origin.clone(), message));
        };
        if width == 0 || height == 0 || file.is_empty() {
            fault("its image has no pixels");
        }
        if !(1..=4).contains(&channels) || ![8, 16, 32].contains(&bits) {
            fault("its image has no 1 to 4 channels of 8, 16 or 32 bits");
        }
        if !(peak.is_finite() && *peak >= 0.0) {
            fault("its largest number is not finite, or negative");
        }
        if !factor.iter().all(|part| (0.0..=1.0).contains(part)) {
            fault("its factor is not between 0 and 1");
        }
        if format.is_float() && *encoding == Encoding::Srgb {
            fault("its image holds floats, which are linear in every renderer");
        }
    }
    for (handle, material) in scene.materials.iter() {
        if material.bsdf.texture().is_some_and(|texture| texture.index() >= scene.textures.len()) {
            let message = format!("material `{}`: its texture is not in the scene", material.name.escape_debug());
            findings.push(Finding::error("invalid-material", scene.materials.origin(handle).clone(), message));
        }
    }
    for (origin, shape) in scene.surfaces() {
        let Shape { name, mesh, transform: _, material, emission: _ } = shape;
        let Some((_, material)) = scene.materials.iter().nth(material.index()) else { continue };
        let bare = scene.meshes.values().nth(mesh.index()).is_some_and(|mesh| mesh.uvs.is_none());
        if bare && material.bsdf.texture().is_some() {
            let message = format!(
                "shape `{}`: its mesh has no texture coordinates, and its material has a texture",
                name.escape_debug()
            );
            findings.push(Finding::error("missing-uvs", origin.clone(), message));
        }
    }
}
