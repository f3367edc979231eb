//! Formulas by which the Scene's numbers become PBRT's, and how far off it is for one scene.

use crate::capability::{Bound, Feature};
use crate::formats::shared::{bounds, images};
use crate::image::{self, sphere};
use crate::ir::Scene;

const CAMERA: (Feature, &str) = (
    Feature::Camera,
    "fov = fov_x, where the image is wider than high 2 atan(tan(fov_x / 2) height / width): along the shorter axis; x is \
     mirrored, the camera being left-handed",
);
const DEPTH: &str = "maxdepth = max_depth - 1";
const PHOTON_DEPTH: (Feature, &str) = (Feature::PhotonMap, "maxdepth = max(max_depth - 1, 1)");
const SPOT: (Feature, &str) = (Feature::SpotLight, "coneangle = angle, conedeltaangle = angle - inner");
const CODES: &str = "its codes are written as PNG: v3 reads no JPEG";
const RELATIVE: &str = "eta = interior / exterior";

/// See [`crate::formats::Target::conversions`].
pub const V3: &[(Feature, &str)] = &[
    (Feature::SmoothDielectric, RELATIVE),
    (Feature::RoughDielectric, RELATIVE),
    (
        Feature::Plastic,
        "Kd = rho (1 - Fi) / (1 - rho Fi) with Fi the share of diffuse light that the coat throws back from inside, Ks = \
         ((ior - 1) / (ior + 1))^2",
    ),
    (Feature::JpegTexture, CODES),
    (Feature::LinearJpegTexture, CODES),
    (Feature::DeepTexture, "written decoded, as floats in OpenEXR: v3 reads PNG with 8 bits"),
    (Feature::HdrTexture, "written as PFM: v3 reads no Radiance HDR"),
    (Feature::TintedEnvironment, "L = the tint"),
    SPOT,
    CAMERA,
    (Feature::GaussianFilter, "alpha = 1 / (2 stddev^2)"),
    (Feature::Path, DEPTH),
    (Feature::Bidirectional, DEPTH),
    (Feature::Metropolis, DEPTH),
    PHOTON_DEPTH,
];

/// Likewise for v4.
pub const V4: &[(Feature, &str)] = &[
    (Feature::SmoothDielectric, RELATIVE),
    (Feature::RoughDielectric, RELATIVE),
    (Feature::LinearJpegTexture, "its codes are written as PNG: v4 takes every JPEG for sRGB"),
    (Feature::DeepTexture, "written decoded, as floats in OpenEXR: pbrt-r4 reads no PNG of 16 bits"),
    (Feature::HdrTexture, "written as PFM: pbrt-r4 takes Radiance HDR for codes of sRGB"),
    (
        Feature::EnvironmentImage,
        "(u, v) of the octahedron, its middle +z and its corners -z (Clarberg 2008); scale = the largest channel of the tint",
    ),
    (
        Feature::SpotLight,
        "coneangle = angle, conedeltaangle = angle - inner; an edge below 0.1 degrees makes `lightsampler` \
         `power`",
    ),
    (Feature::Spectrum, "scale of a light = its luminance, which v4 divides by"),
    CAMERA,
    (Feature::Path, DEPTH),
    (Feature::Bidirectional, DEPTH),
    (Feature::LightTracing, DEPTH),
    (Feature::Metropolis, DEPTH),
    PHOTON_DEPTH,
];

/// How far v4 is off for one scene.
pub fn bound_v4(feature: Feature, scene: &Scene) -> Option<Bound> {
    if feature != Feature::EnvironmentImage {
        return bounds::of_correlation(feature, scene);
    }
    let (texture, _) = images::sky(scene)?;
    let texture = &scene.textures[texture];
    let pixels = image::linear(texture).ok()?;
    let side = sphere::side([texture.image.width, texture.image.height]);
    let what = format!("of the mean radiance, in the mean over directions, in an image of {side} x {side} pixels");
    Some(Bound { size: sphere::off(&pixels, side), what })
}
