//! Cycles: a Python file that builds the scene in Blender, beside a file of functions that is the same for all scenes.

mod conversions;
mod emit;
mod media;
pub mod names;

use super::Target;
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
    bound: conversions::bound,
    choices: &[],
    emit: emit::emit,
};

fn supports(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::ColouredDiffuse
        | Feature::SmoothConductor
        | Feature::RoughConductor
        | Feature::SharpConductor
        | Feature::ColouredConductor
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
        | Feature::Seed => Exact,
        Feature::SmoothDiffuse => Support::approximate(
            "Cycles shades surfaces with smooth normals a little brighter where they turn away from the light",
            "a coarse sphere of 12 by 6 faces 0.32 % too bright in its mean, 1.2 % in the band between light and shadow \
             (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::WideConductor => Support::approximate(
            "Cycles' masking and shadowing are height-correlated, Mitsuba's are not",
            "as in PBRT: tiles up to 1 % at `alpha` 0.5, up to 3 % at 1 (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::SmoothDielectric | Feature::RoughDielectric | Feature::ThinnerInside => Support::approximate(
            "Cycles does not scale radiance that enters another medium",
            "exact where the camera and the lights lie in the same medium, else 1 / ior^2: 0.309 of the radiance at 1.8 \
             (4.5 against Mitsuba 3.9.1)",
        ),
        Feature::SpotLight | Feature::SoftSpotLight => Support::approximate(
            "the edge of Cycles' spot is a smooth step of its own",
            "the same within the inner cone and outside of the outer one",
        ),
        Feature::Plastic => Support::approximate(
            "Blender's principled material does not darken its base: what is seen of the base is written instead",
            "not measured; exact for the coat's reflectance head-on and for the base in all directions but grazing ones",
        ),
        Feature::TexturedPlastic => Support::approximate(
            "Blender's principled material does not darken its base, and the texture is written as it is",
            "for an index of 1.5 seen 0.2 instead of 0.09 for a base of 0.2, 0.5 instead of 0.29, 0.8 instead of 0.62 (computed)",
        ),
        Feature::Principled | Feature::TexturedPrincipled => Support::approximate(
            "the base of Blender's principled material is Lambertian, and its coat is weighed by its albedo",
            "not measured; `roughness`, `metallic` and `ior` mean the same",
        ),
        Feature::EnvironmentImage => Support::unsupported(
            "which way round Cycles lays an image of the environment was not measured; a constant grey stands for it",
        ),
        Feature::Spectrum => super::RGB_ONLY,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::BoxFilter => Support::approximate(
            "Cycles' filters are at most 10 pixels wide",
            "exact up to a radius of 5, and 5 beyond it",
        ),
        Feature::GaussianFilter | Feature::CutGaussianFilter => Support::approximate(
            "Cycles cuts its Gaussian at six standard deviations, and at 5 pixels",
            "the weight beyond four standard deviations is 6e-5 of the whole (`film.cpp`)",
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
