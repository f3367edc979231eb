//! Formulas by which the Scene's numbers become Blender's, and how far off it is for one scene.

use super::{media, names};
use crate::capability::{Bound, Feature};
use crate::formats::shared::bounds;
use crate::formats::shared::filter::{self, Kernel};
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
    (
        Feature::GaussianFilter,
        "filter_width = 4 stddev, which Blender makes three times as wide and Cycles takes for twelve",
    ),
    (Feature::Path, "max_bounces, diffuse_, glossy_, transmission_bounces = max_depth - 2"),
];

/// Rough glass: 4.5.15 against Mitsuba 3.9.1, 1024 samples per pixel; see [`bounds::of_glass`].
const GLASS: &[bounds::Glass] = &[(0.05, 0.002), (0.1, 0.004), (0.3, 0.014), (0.5, 0.048), (0.8, 0.172), (1.0, 0.307)];

/// What Cycles' own table of a filter does to a straight edge: with 4.5.15 up to 0.0012 of the step for standard deviations of 0.1 to 2.5.
const TABLE: f64 = 1.2e-3;

/// Gaussians, cut farther out; metals, whose Fresnel term is the one for large `k`; wide ones, whose masking is correlated by height; and light that enters
/// another medium, which Cycles does not scale.
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    if [Feature::GaussianFilter, Feature::CutGaussianFilter].contains(&feature) {
        return filter::bound(scene, TABLE, |stddev, _| {
            let (least, most) = names::FILTER_WIDTHS;
            let stddev = names::stddev(names::gaussian_width(stddev).clamp(least, most));
            Kernel::cut(stddev, 6.0 * stddev)
        });
    }
    if feature == Feature::RoughDielectric {
        return bounds::both(media::bound(scene), bounds::of_glass(scene, GLASS));
    }
    if [Feature::SmoothDielectric, Feature::ThinnerInside].contains(&feature) {
        return media::bound(scene);
    }
    if [Feature::SmoothConductor, Feature::RoughConductor].contains(&feature) {
        return bounds::of_fresnel(bounds::metals(scene, feature), |eta, k| move |cosine| large_k(eta, k, cosine));
    }
    bounds::of_correlation(feature, scene)
}

/// The reflectance of a metal as Cycles computes it: the approximation for large `k` (Pharr and Humphreys, "Physically Based
/// Rendering", first edition, section 9.2.1). Measured with 4.5.15 on copper: 0.5163 at 45 degrees in blue, 0.6314 at 60 in green,
/// 0.6204 at 75 in blue, 0.7793 at 82 in green; this gives 0.5163, 0.6314, 0.6202, 0.779, the exact term 0.5147, 0.6258, 0.6152,
/// 0.7746.
fn large_k(eta: f64, k: f64, cosine: f64) -> f64 {
    let (size, linear, square) = (eta * eta + k * k, 2.0 * eta * cosine, cosine * cosine);
    let along = (size * square - linear + 1.0) / (size * square + linear + 1.0);
    let across = (size - linear + square) / (size + linear + square);
    f64::midpoint(along, across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::fresnel;

    #[test]
    fn the_approximation_is_that_of_the_renderer() {
        let at = |eta: f64, k: f64, degrees: f64| large_k(eta, k, libm::cos(degrees.to_radians()));
        for (eta, k, degrees, rendered) in [
            (1.102_212, 2.142_188, 45.0, 0.5163),
            (0.924_033, 2.452_848, 60.0, 0.6314),
            (1.102_212, 2.142_188, 75.0, 0.6204),
            (0.924_033, 2.452_848, 82.0, 0.7793),
        ] {
            assert!((at(eta, k, degrees) - rendered).abs() < 5e-4, "{degrees}");
            assert!(
                (fresnel::conductor(eta, k, libm::cos(degrees.to_radians())) - rendered).abs() > 1.4e-3,
                "{degrees}"
            );
        }
        assert!((at(0.2, 3.9, 0.0) - fresnel::head_on(0.2, 3.9)).abs() < 1e-12);
    }
}
