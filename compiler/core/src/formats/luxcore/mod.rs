//! LuxCore.

mod conversions;
mod emit;
pub mod fresnel;
pub mod import;
pub mod names;
mod properties;
mod scatter;
mod statements;

use super::Target;
use super::shared::images;
use super::statements::Native;
use crate::capability::{Feature, Support};

/// LuxCore.
pub const LUXCORE: Target = Target {
    name: "luxcore",
    aliases: &[],
    summary: "LuxCore (checked with 2.11.2)",
    main_file: "scene.cfg",
    shares_meshes: true,
    supports,
    conversions: conversions::CONVERSIONS,
    images: images::shared_or_scaled,
    bound: conversions::bound,
    choices: &[],
    emit: emit::emit,
    import: Some(import::import),
    statements: Some(Native { check: statements::check, size: statements::size }),
};

fn supports(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::ColoredDiffuse
        | Feature::SmoothDiffuse
        | Feature::SmoothDielectric
        | Feature::ThinnerInside
        | Feature::Mirror
        | Feature::DimMirror
        | Feature::OneSided
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::ColoredEmitter
        | Feature::Environment
        | Feature::PointLight
        | Feature::DirectionalLight
        | Feature::Texture
        | Feature::ColoredTexture
        | Feature::SrgbTexture
        | Feature::TurnedEnvironment
        | Feature::TintedEnvironment
        | Feature::LinearTexture
        | Feature::DeepTexture
        | Feature::ScaledTexture
        | Feature::JpegTexture
        | Feature::LinearJpegTexture
        | Feature::ExrTexture
        | Feature::PfmTexture
        | Feature::HdrTexture
        | Feature::ColoredConductor
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
        | Feature::BoxFilter
        | Feature::CutGaussianFilter
        | Feature::Path
        | Feature::IndirectLight
        | Feature::IndependentSampler
        | Feature::SobolSampler
        | Feature::SobolForLightPaths
        | Feature::Seed => Exact,
        Feature::SmoothConductor => Support::approximate(
            "LuxCore's metal has no smooth form (its roughness is at least 1e-9) and its Fresnel term is an approximation",
            "`n` and `k` are fitted to the exact term: for gold and copper within 0.04 of the reflectance at every angle; a \
             Cornell box with a copper block 1.002 in its mean (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::RoughConductor => Support::approximate(
            "LuxCore's Fresnel term and its masking and shadowing are approximations",
            "`n` and `k` are fitted to the exact term: for gold and copper within 0.04 of the reflectance at every angle; image \
             means 1.000 (a gold ring, standard error 0.3 %), 1.002 (a copper block of `alpha` 0.0625 in a Cornell box); \
             masking below 1 % for `alpha` up to 0.125 (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::WideConductor => Support::approximate(
            "LuxCore's masking and shadowing are Schlick's approximation, and its samples of the lobe state a density that lacks the \
             cosine to the facet",
            "tiles 6 % too dark at `alpha` 0.5, 13 to 21 % at 1 (2.11.2 against Mitsuba 3.9.1); in even light, seen at 0, 60 and \
             78.5 degrees, 8, 18 and 21 % too dark at 0.5, 21, 48 and 62 % at 1, of which the masking is 4, 11, 13 and 19, 39, 51",
        ),
        Feature::RoughDielectric => Support::approximate(
            "LuxCore's masking and shadowing are Schlick's approximation, and its samples of light through the surface have heavy tails",
            "a ball of index 1.5 under even light, in rings from its middle to 0.95 of its radius: 1.01 to 1.05 of Mitsuba 3 at `alpha` 0.1, \
             with specks that made single tiles 2.4 times as bright at 1024 samples per pixel, 0.93 to 0.98 at 0.3, 0.84 to 0.75 at 0.5, 0.73 to 0.45 \
             at 0.8, 0.63 to 0.32 at 1; a Cornell box with a block of it 1.03 in its mean at 0.1, 1.01 at 0.3 (2.11.2 against Mitsuba 3.9.1)",
        ),
        Feature::Plastic => Support::approximate(
            "LuxCore's `glossy2` has Schlick's Fresnel term and does not darken its base: what is seen of the base is written instead",
            "a base of 0.5 in even light, seen at 0, 60 and 80 degrees: 1.00, 0.98, 1.21 of Mitsuba 3.9.1 for `alpha` 0, 1.01, 1.00, 1.23 \
             for 0.1, 1.09, 1.10, 1.21 for 0.3 (2.11.2)",
        ),
        Feature::TexturedPlastic => Support::approximate(
            "LuxCore's `glossy2` does not darken its base: the texture is darkened by the factor of a grey of 0.5",
            "for an index of 1.5 seen 0.115 instead of 0.092 for a base of 0.2, 0.46 instead of 0.62 for 0.8 (computed)",
        ),
        Feature::Principled | Feature::TexturedPrincipled => Support::approximate(
            "LuxCore's `disney` weighs its parts otherwise, and reaches a reflectance of 0.08 head-on at most",
            "a base of 0.5 in even light, seen at 0, 60 and 80 degrees: 0.84, 0.83, 0.84 of Mitsuba 3.9.1 without metal, 0.97, 0.98, 0.97 \
             with nothing else, both for `roughness` 0.316; 0.89, 0.87, 0.83 half of each at 0.5 (2.11.2)",
        ),
        Feature::Spectrum => super::RGB_ONLY,
        Feature::EnvironmentImage => Support::approximate(
            "LuxCore mixes the rows of an environment's image at its two edges with each other",
            "half a row of pixels at each pole (2.11.2); exact elsewhere",
        ),
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::GaussianFilter => Support::approximate(
            "LuxCore draws positions from a table of the filter with 64 cells across",
            "at a straight edge less than 0.002 of the step, which is the noise, for `stddev` 0.3 to 2 cut at 1 to 8 of them (2.11.2); \
             more only where the cut is at more than 20 of them: 0.008 at 20, 0.029 at 40 (computed)",
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
