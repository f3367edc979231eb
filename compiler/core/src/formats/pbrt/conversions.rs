//! Formulas by which the Scene's numbers become PBRT's, and how far off it is for one scene.

use crate::capability::Feature;

const CAMERA: (Feature, &str) = (
    Feature::Camera,
    "fov = fov_x, where the image is wider than high 2 atan(tan(fov_x / 2) height / width): along the shorter axis; x is \
     mirrored, the camera being left-handed",
);
const DEPTH: &str = "maxdepth = max_depth - 1";
const PHOTON_DEPTH: (Feature, &str) = (Feature::PhotonMap, "maxdepth = max(max_depth - 1, 1)");
const SPOT: (Feature, &str) = (Feature::SpotLight, "coneangle = angle, conedeltaangle = angle - inner");
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
