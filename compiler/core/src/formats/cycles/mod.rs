//! Cycles: a Python file that builds the scene in Blender, beside a file of functions that is the same for all scenes.

mod conversions;
mod emit;
pub mod import;
mod media;
pub mod names;
mod python;
mod statements;

use super::Target;
use super::statements::Native;
use crate::capability::{Feature, Support};

/// Cycles in Blender.
pub const CYCLES: Target = Target {
    name: "cycles",
    aliases: &["blender"],
    summary: "Cycles in Blender (checked with 4.5)",
    main_file: "scene.py",
    shares_meshes: true,
    supports,
    conversions: conversions::CONVERSIONS,
    images: names::images,
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
        | Feature::SharpConductor
        | Feature::ColoredConductor
        | Feature::Mirror
        | Feature::DimMirror
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::ColoredEmitter
        | Feature::Environment
        | Feature::TurnedEnvironment
        | Feature::TintedEnvironment
        | Feature::PointLight
        | Feature::SpotLight
        | Feature::DirectionalLight
        | Feature::Texture
        | Feature::ColoredTexture
        | Feature::LinearTexture
        | Feature::DeepTexture
        | Feature::ScaledTexture
        | Feature::JpegTexture
        | Feature::LinearJpegTexture
        | Feature::ExrTexture
        | Feature::PfmTexture
        | Feature::HdrTexture
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
        | Feature::SobolSampler
        | Feature::SobolForLightPaths
        | Feature::OneSided
        | Feature::Seed => Exact,
        Feature::EnvironmentImage => Support::approximate(
            "Cycles mixes the rows of an environment's image at its two edges with each other",
            "half a row of pixels at each pole (4.5); exact elsewhere",
        ),
        Feature::SrgbTexture => Support::approximate(
            "Cycles interpolates between sRGB codes and decodes then: its images are written decoded, as half floats in OpenEXR",
            "each pixel within 0.05 % of its value (2^-11), from the first code of 8 bits on; of JPEG within a code of what libjpeg decodes, two \
             at edges of halved chroma",
        ),
        Feature::SmoothDiffuse => Support::approximate(
            "Cycles also lights what turns its interpolated normal away from the camera; others leave it dark",
            "a coarse sphere of 12 by 6 faces, lit from the side, 2.7 % too bright in its mean, all of it on its lit edge, \
             where up to 0.06 of radiance stands for 0; 0.3 % where it is lit from above (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::SmoothConductor | Feature::RoughConductor => Support::approximate(
            "Cycles' Fresnel term of metals is the approximation for large `k`",
            "for gold and copper at most 0.007 of the light too bright, in their dark channels at 60 to 85 degrees (computed; \
             equal to four digits in what 4.5.15 renders)",
        ),
        Feature::WideConductor => Support::approximate(
            "Cycles' masking and shadowing are height-correlated, Mitsuba's are not",
            "as in PBRT: tiles up to 1 % at `alpha` 0.5, up to 3 % at 1; in even light, seen at 60 and 78.5 degrees, 2 and 7 % too \
             bright at 0.5, 10 and 26 % at 1 (4.5 against Mitsuba 3.9.1 and the integral)",
        ),
        Feature::RoughDielectric => Support::approximate(
            "Cycles does not scale radiance that enters another medium, and its masking and shadowing are height-correlated",
            "a ball of index 1.5 under even light, in rings from its middle to 0.95 of its radius: 1.00 of Mitsuba 3 at `alpha` 0.1, 1.00 to 1.01 \
             at 0.3, 1.00 to 1.05 at 0.5, 1.01 to 1.17 at 0.8, 1.01 to 1.31 at 1, where the camera and the lights lie in the same medium; else 1 / ior^2 \
             of that (4.5.15 against Mitsuba 3.9.1)",
        ),
        Feature::SmoothDielectric | Feature::ThinnerInside => Support::approximate(
            "Cycles does not scale radiance that enters another medium",
            "exact where the camera and the lights lie in the same medium, else 1 / ior^2: 0.309 of the radiance at 1.8 \
             (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::SoftSpotLight => Support::approximate(
            "between the two cones Cycles' spot rises as a smooth step of the cosine, not linearly with the angle",
            "exact outside of that ring; in it, as pbrt-v4's, up to 0.11 of the intensity more where it is narrow, up to 0.34 where \
             `inner` is 0 (computed; 10.6 % more at 26 degrees between 22 and 30 in 4.5.15)",
        ),
        Feature::Plastic => Support::approximate(
            "Blender's principled material does not darken its base: what is seen of the base is written instead",
            "albedo in even light of a base of 0.5 and an index of 1.5, seen at 0 to 80 degrees: within 0.4 % for a smooth coat, up to \
             3 % brighter at `alpha` 0.1 (6 % for a base of 0.8), up to 18 % at 0.3 (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::TexturedPlastic => Support::approximate(
            "Blender's principled material does not darken its base, and the texture is written as it is",
            "for an index of 1.5 seen 0.2 instead of 0.09 for a base of 0.2, 0.5 instead of 0.29, 0.8 instead of 0.62 (computed)",
        ),
        Feature::Principled | Feature::TexturedPrincipled => Support::approximate(
            "the base of Blender's principled material is Lambertian, and its coat is weighed by its albedo",
            "albedo in even light of a base of 0.5 and an index of 1.5, seen at 0, 60 and 80 degrees: 3, 7 and 15 % darker at \
             `roughness` 0.316, 3, 4 and 8 % with half metal at 0.5, within 0.4 % for a metal (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::Spectrum => super::RGB_ONLY,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::BoxFilter => {
            Support::unsupported("Cycles' box filter is the pixel itself, whatever its width in Blender (4.5.15)")
        }
        Feature::GaussianFilter => Support::approximate(
            "Cycles cuts its Gaussian at six standard deviations, draws it from a table, and has none wider than `stddev` 2.5",
            "at a straight edge off by at most 0.0012 of the step for `stddev` 0.1 to 2.5, 0.043 for 3 (4.5.15)",
        ),
        Feature::CutGaussianFilter => Support::approximate(
            "Cycles cuts its Gaussian at six standard deviations",
            "the mean stays; at a straight edge off by up to 0.007 of the step where it was to be cut at 3 standard deviations, 0.048 \
             at 2, 0.19 at 1 (4.5.15)",
        ),
        Feature::IndependentSampler => Support::approximate(
            "Cycles has no independent samples: a shuffled Sobol sequence stands for them",
            "less noise, the same expected image",
        ),
        Feature::Bidirectional | Feature::LightTracing | Feature::Metropolis | Feature::PhotonMap => {
            Support::unsupported("Cycles has path tracing only, which stands for it with the same depth")
        }
        Feature::EmissionOnly => {
            Support::unsupported("Cycles renders direct light too: a path depth of 1 gives the image of 2 (4.5)")
        }
    }
}
