//! Files of images: their bytes against those that the scene's images have in the target's form.

use std::collections::BTreeSet;

use super::{Asked, Found, look};
use crate::files::{Files, VPath};
use crate::formats::Target;
use crate::formats::shared::images::{self, Form, Use};
use crate::formats::shared::reading::{Light, Paint, Picture, Reading};

/// Pixels up to which an image is made anew to be compared: an octahedron takes a second for a million of them.
const MOST: u64 = 1 << 20;

pub(super) fn compare(asked: &Asked<'_>, target: &Target, reading: &Reading, files: &dyn Files, found: &mut Found) {
    // What is said of the sky, and what of surfaces.
    let mut said: BTreeSet<(bool, &VPath)> = BTreeSet::new();
    let file = |paint: &'_ Paint| match paint {
        Paint::Image { file: Picture::File(path), linear: _, factor: _ } => Some(path.clone()),
        Paint::Image { file: Picture::Here(_), linear: _, factor: _ } | Paint::Color(_) => None,
    };
    let surfaces: Vec<VPath> =
        reading.materials.iter().filter_map(|surface| look::image(&surface.model)).filter_map(file).collect();
    let skies: Vec<VPath> = reading
        .lights
        .iter()
        .filter_map(|light| match light {
            Light::Environment { radiance, turn: _ } => file(radiance),
            Light::Point { .. } | Light::Spot { .. } | Light::Directional { .. } => None,
        })
        .collect();
    said.extend(surfaces.iter().map(|path| (false, path)));
    said.extend(skies.iter().map(|path| (true, path)));
    for (handle, purpose) in images::uses(asked.scene) {
        let texture = &asked.scene.textures[handle];
        let Some(name) = images::file_name(asked.scene, handle, purpose, target.images) else { continue };
        let sky = match purpose {
            Use::Surface => false,
            Use::Sky(_) => true,
        };
        // Names that differ were said.
        let Some((_, path)) = said.iter().find(|(of, path)| *of == sky && path.name() == name) else { continue };
        let form = (target.images)(texture, purpose);
        let large = u64::from(texture.image.width) * u64::from(texture.image.height) > MOST;
        if large && form != Form::Shared {
            continue;
        }
        found.stands_in(Some(path));
        match (files.read(path, u64::MAX), form.write(texture)) {
            (Ok(there), Ok(wanted)) if *there == *wanted => {}
            (Ok(_), Ok(_)) => found.differs(format!("the image `{}` has other pixels", texture.name)),
            (Err(problem), _) => found.differs(format!("the image `{}` cannot be read: {problem}", texture.name)),
            (_, Err(problem)) => found.differs(format!("the image `{}` cannot be made: {problem}", texture.name)),
        }
    }
    found.stands_in(None);
}
