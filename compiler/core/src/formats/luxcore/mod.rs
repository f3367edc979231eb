//! LuxCore.

mod emit;
pub mod names;

use super::Target;
use crate::capability::{Feature, Support};

/// LuxCore.
pub const LUXCORE: Target = Target {
    name: "luxcore",
    aliases: &[],
    summary: "LuxCore (checked with 2.11.2)",
    main_file: "scene.cfg",
    shares_meshes: true,
    supports,
    emit: emit::emit,
};

fn supports(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::ColouredDiffuse
        | Feature::SmoothDiffuse
        | Feature::SmoothDielectric
        | Feature::ThinnerInside
        | Feature::Mirror
        | Feature::DimMirror
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::ColouredEmitter
        | Feature::Environment
        | Feature::PointLight
        | Feature::DirectionalLight
        | Feature::Texture
        | Feature::ColouredTexture
        | Feature::LinearTexture
        | Feature::DeepTexture
        | Feature::JpegTexture
        | Feature::LinearJpegTexture
        | Feature::ExrTexture
        | Feature::PfmTexture
        | Feature::HdrTexture
        | Feature::ColouredConductor
        | Feature::SharpConductor
        | Feature::VertexNormals
        | Feature::NoNormals
        | Feature::TextureCoordinates
        | Feature::TransformedShape
        | Feature::SharedMesh
        | Feature::Instances
        | Feature::Camera
        | Feature::ClippingPlanes
        | Feature::Resolution
        | Feature::PixelFilter
        | Feature::Path
        | Feature::IndirectLight
        | Feature::IndependentSampler
        | Feature::SobolSampler
        | Feature::SobolForLightPaths
        | Feature::Seed => Exact,
        Feature::SmoothConductor => Support::approximate(
            "LuxCore's metal has no smooth form (its roughness is at least 1e-9) and its Fresnel term is an approximation",
            "up to 21 % too bright at 75 degrees, exact at normal incidence; a Cornell box with a copper block 1.006 in its \
             mean, tiles up to 5 % (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::RoughConductor => Support::approximate(
            "LuxCore's Fresnel term and its masking and shadowing are approximations",
            "up to 21 % too bright at 75 degrees, exact at normal incidence; image means 1.033 (a gold ring), 1.007 (four \
             metal plates), 1.010 (a copper block of `alpha` 0.0625 in a Cornell box); masking below 1 % for `alpha` up \
             to 0.125 (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::WideConductor => Support::approximate(
            "LuxCore's masking and shadowing are Schlick's approximation",
            "tiles 6 % too dark at `alpha` 0.5, 13 to 21 % at 1 (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::RoughDielectric => Support::approximate(
            "LuxCore's masking and shadowing are Schlick's approximation",
            "a Cornell box with a block of rough glass 1.03 in its mean at `alpha` 0.1, 1.01 at 0.3, single tiles with \
             caustics up to 70 % at 256 samples per pixel (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::BoxFilter | Feature::GaussianFilter | Feature::CutGaussianFilter => Support::approximate(
            "LuxCore draws positions from a table of the filter",
            "no difference above the noise of 256 samples per pixel, 3 % of the step at an edge (2.11.2 against \
             Mitsuba 3.9.1)",
        ),
        Feature::SpotLight => Support::approximate(
            "the intensity of LuxCore's spot grows with 1 / cos of the angle from its axis",
            "exact on the axis, 1.5 % too bright at 10 degrees from it, 6 % at 20, 15 % at 30 (2.11.2)",
        ),
        Feature::SoftSpotLight => Support::approximate(
            "between the two cones LuxCore's spot rises with the fourth power of the cosine's share, not linearly with the angle",
            "in that ring up to 0.47 of the intensity less, with 0.4 to 0.6 of its light (computed from `spotlight.cpp`)",
        ),
        Feature::Bidirectional => Support::unsupported(
            "LuxCore's bidirectional path tracing bounds the two halves of a path and not the whole: a Cornell box of depth \
             10 is 3.8 % too bright, more than without any bound (2.11.2); path tracing of the same depth stands for it",
        ),
        Feature::LightTracing => Support::unsupported(
            "LuxCore's tracing from the lights was not measured; path tracing of the same depth stands for it",
        ),
        Feature::Metropolis => Support::unsupported(
            "LuxCore has Metropolis sampling of path tracing only; path tracing of the same depth stands for it",
        ),
        Feature::PhotonMap => Support::unsupported(
            "LuxCore has photon caches for parts of the light only; path tracing of the same depth stands for it",
        ),
        Feature::EmissionOnly => {
            Support::unsupported("LuxCore renders direct light too: a path depth of 1 gives the image of 2 (2.11.2)")
        }
    }
}
