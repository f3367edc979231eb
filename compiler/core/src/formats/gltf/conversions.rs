//! Formulas by which the Scene's numbers become glTF's, and how far off it is for one scene.

use crate::capability::{Bound, Feature};
use crate::formats::shared::{bounds, fresnel};
use crate::ir::Scene;

const RELATIVE: &str = "ior = interior / exterior, at least 1";
const METAL: &str = "base color = ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2), roughness = sqrt(alpha)";
const EMISSION: &str = "emissive factor = L / max(L), emissive strength = max(L)";

/// See [`crate::formats::Target::conversions`].
pub const CONVERSIONS: &[(Feature, &str)] = &[
    (Feature::SmoothConductor, METAL),
    (Feature::RoughConductor, METAL),
    (Feature::SmoothDielectric, RELATIVE),
    (Feature::RoughDielectric, RELATIVE),
    (Feature::BlackEmitter, EMISSION),
    (Feature::ScatteringEmitter, EMISSION),
    (Feature::Texture, "v of texture coordinates becomes 1 - v: glTF's images begin at their top"),
    (
        Feature::Camera,
        "yfov = 2 atan(tan(fov_x / 2) height / width), aspect ratio = width / height; z up becomes y up at the root",
    ),
];

const METALS: [Feature; 4] =
    [Feature::SmoothConductor, Feature::RoughConductor, Feature::SharpConductor, Feature::ColoredConductor];

/// Metals have Schlick's Fresnel term; wide ones a masking that is correlated by height.
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    let metals = bounds::metals(scene, feature);
    if METALS.contains(&feature) {
        return bounds::of_fresnel(metals, |eta, k| {
            let head_on = fresnel::head_on(eta, k);
            move |cosine| fresnel::schlick(head_on, cosine)
        });
    }
    bounds::of_correlation(feature, scene)
}
