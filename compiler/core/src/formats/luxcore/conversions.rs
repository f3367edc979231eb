//! Formulas by which the Scene's numbers become LuxCore's, and how far off it is for one scene.

use super::fresnel::{self, Fit};
use crate::capability::{Bound, Feature};
use crate::formats::shared::bounds;
use crate::formats::shared::filter::{self, Kernel};
use crate::formats::shared::microfacet::Masking;
use crate::ir::Scene;

const FITTED: &str = "n, k = those with which LuxCore's Fresnel term is nearest to the exact one of eta and k, by least squares over \
                      the cosine-weighted hemisphere";

/// See [`crate::formats::Target::conversions`].
pub const CONVERSIONS: &[(Feature, &str)] = &[
    (Feature::SmoothConductor, FITTED),
    (Feature::RoughConductor, FITTED),
    (
        Feature::Plastic,
        "kd = rho (1 - Fi) / (1 - rho Fi) with Fi the share of diffuse light that the coat throws back from inside",
    ),
    (Feature::Principled, "specular = ((ior - 1) / (ior + 1))^2 / 0.08, at most 1"),
    (Feature::PointLight, "gain = 4 pi: LuxCore spreads it over the sphere of directions"),
    (Feature::Texture, "v of texture coordinates becomes 1 - v; sRGB is decoded by a curve in `srgb.ocio`"),
    (Feature::EnvironmentImage, "turned so that its middle, LuxCore's -x, is +y"),
    (Feature::Camera, "screenwindow moved down by 2 / width, one row of pixels: LuxCore draws one row too low"),
    (Feature::GaussianFilter, "alpha = 1 / (2 stddev^2)"),
    (Feature::Path, "pathdepth.total, .diffuse, .glossy, .specular = max_depth, at least 2"),
    (Feature::Seed, "seed + 1: LuxCore's 0 and 1 are the same"),
];

/// Rough glass: 2.11.2 against Mitsuba 3.9.1, 1024 samples per pixel; see [`bounds::of_glass`].
const GLASS: &[bounds::Glass] =
    &[(0.01, 0.009), (0.05, 0.013), (0.1, 0.045), (0.3, 0.067), (0.5, 0.252), (0.8, 0.555), (1.0, 0.682)];

/// Cells on each side in the table of a filter (`filterdistribution.cpp`), each with the value in its middle.
const TABLE: u32 = 32;

/// Gaussians, by a table; metals: the Fresnel term with the numbers that are written, Schlick's masking, and what samples of the lobe lose.
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    if feature == Feature::RoughDielectric {
        return bounds::of_glass(scene, GLASS);
    }
    if feature == Feature::GaussianFilter {
        return filter::bound(scene, 0.0, |stddev, radius| Kernel::lowered(stddev, radius).stepped(TABLE, 0.5));
    }
    let metals = || bounds::metals(scene, feature);
    let masking = || {
        let of = |masking| bounds::of_masking(metals(), masking);
        bounds::larger(of(Masking::Schlick), of(Masking::SchlickSampled))
    };
    if feature == Feature::WideConductor {
        return masking();
    }
    if feature != Feature::SmoothConductor && feature != Feature::RoughConductor {
        return None;
    }
    let fresnel = bounds::of_fresnel(metals(), |eta, k| {
        let Fit { n, k, rms: _, most: _ } = fresnel::fit(eta, k);
        move |cosine| fresnel::approximate(n, k, cosine)
    });
    bounds::both(fresnel, masking())
}
