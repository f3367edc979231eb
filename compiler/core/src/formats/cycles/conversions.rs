//! Formulas by which the Scene's numbers become Blender's, and how far off it is for one scene.

use super::media;
use crate::capability::{Bound, Feature};
use crate::formats::shared::bounds;
use crate::ir::Scene;

const ROUGHNESS: &str = "Roughness = sqrt(alpha)";
const RELATIVE: &str = "IOR = interior / exterior, Roughness = sqrt(alpha)";
const EMISSION: &str = "Color = L / max(L), Strength = max(L), on the front of the surface only";
const POWER: &str = "color = I / max(I), energy = 4 pi max(I)";

/// See [`crate::formats::Target::conversions`].
pub const CONVERSIONS: &[(Feature, &str)] = &[
    (Feature::RoughConductor, ROUGHNESS),
    (Feature::SmoothDielectric, RELATIVE),
    (Feature::RoughDielectric, RELATIVE),
    (
        Feature::Plastic,
        "base color = rho (1 - Fi) / (1 - rho Fi) with Fi the share of diffuse light that the coat throws back from inside",
    ),
    (Feature::BlackEmitter, EMISSION),
    (Feature::ScatteringEmitter, EMISSION),
    (Feature::Environment, "Color = L / max(L), Strength = max(L)"),
    (Feature::PointLight, POWER),
    (
        Feature::SpotLight,
        "color = I / max(I), energy = 4 pi max(I), spot_size = 2 angle, spot_blend = (cos inner - cos angle) / (1 - cos angle)",
    ),
    (Feature::DirectionalLight, "color = E / max(E), energy = max(E)"),
    (Feature::BoxFilter, "filter_width = 2 radius"),
    (Feature::GaussianFilter, "filter_width = 12 stddev"),
    (Feature::Path, "max_bounces, diffuse_, glossy_, transmission_bounces = max_depth - 2"),
];

/// Wide metals, whose masking is correlated by height, and light that enters another medium, which Cycles does not scale.
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    let refracts = [Feature::SmoothDielectric, Feature::RoughDielectric, Feature::ThinnerInside].contains(&feature);
    if refracts { media::bound(scene) } else { bounds::of_correlation(feature, scene) }
}
