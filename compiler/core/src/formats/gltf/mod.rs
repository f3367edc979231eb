//! glTF 2.0: approximate by nature, but the form that every viewer and modeller reads.

mod buffer;
mod container;
mod conversions;
mod document;
mod emit;
pub mod import;
mod instancing;
pub mod names;
mod nodes;
mod surface;

use super::shared::images;
use super::{Choice, Target};
use crate::capability::{Feature, Support};

/// glTF 2.0 with a binary file beside it.
pub const GLTF: Target = Target {
    name: "gltf",
    aliases: &[],
    summary: "glTF 2.0, for viewers and modellers",
    main_file: "SCENE.gltf",
    shares_meshes: false,
    supports,
    conversions: conversions::CONVERSIONS,
    images: images::all_shared,
    bound: conversions::bound,
    choices: &[Choice {
        name: emit::INSTANCING,
        summary: "meshes and groups that are used more than once become instances of EXT_mesh_gpu_instancing, which readers \
                  must know; sheared uses stay nodes",
    }],
    emit: emit::separate,
    import: Some(import::import),
    statements: None,
};

/// glTF 2.0 in one binary file, images inside.
pub const GLB: Target = Target {
    name: "glb",
    aliases: &["gltf-binary"],
    summary: "glTF 2.0 in one binary file, images inside",
    main_file: "SCENE.glb",
    emit: emit::container,
    ..GLTF
};

const EXTRAS: Support =
    Support::unsupported("glTF has no word for it; it stands in the scene's `extras`, which renderers ignore");

const EMITTER: Support = Support::approximate(
    "glTF counts emission in candela per square meter, and surfaces that emit on one side are not drawn from behind",
    "the numbers are those of the radiance in W/(m2 sr); the back of an emitter is clear instead of black",
);

const SCHLICK: Support = Support::approximate(
    "glTF's metals have Schlick's Fresnel term with the reflectance at normal incidence",
    "exact at normal and grazing incidence; gold and copper differ by up to 0.03 between (computed from the Fresnel \
     equations)",
);

fn supports(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::ColoredDiffuse
        | Feature::SmoothDiffuse
        | Feature::Texture
        | Feature::ColoredTexture
        | Feature::SrgbTexture
        | Feature::DeepTexture
        | Feature::ScaledTexture
        | Feature::JpegTexture
        | Feature::VertexNormals
        | Feature::NoNormals
        | Feature::TextureCoordinates
        | Feature::TransformedShape
        | Feature::SharedMesh
        | Feature::Instances
        | Feature::Camera
        | Feature::ClippingPlanes => Exact,
        Feature::SmoothConductor | Feature::RoughConductor | Feature::SharpConductor | Feature::ColoredConductor => {
            SCHLICK
        }
        Feature::Mirror => Exact,
        Feature::DimMirror => Support::approximate(
            "a glTF metal of that base color stands for it, whose Fresnel term is Schlick's",
            "at 60, 75 and 85 degrees 0.52, 0.61, 0.82 for a reflectance of 0.5 (computed)",
        ),
        Feature::WideConductor => Support::approximate(
            "glTF's masking and shadowing are height-correlated, Mitsuba's are not, and viewers vary",
            "as in PBRT: up to 1 % at `alpha` 0.5, up to 3 % at 1",
        ),
        Feature::SmoothDielectric | Feature::RoughDielectric => Support::approximate(
            "glTF's transmission and volume are hints that rasterisers follow roughly",
            "a path tracer refracts; a rasteriser bends one lookup by the mesh's thickness",
        ),
        Feature::ThinnerInside => {
            Support::unsupported("glTF's index of refraction is at least 1, inside relative to outside")
        }
        Feature::BlackEmitter | Feature::ScatteringEmitter | Feature::ColoredEmitter => EMITTER,
        Feature::Environment | Feature::EnvironmentImage | Feature::TurnedEnvironment | Feature::TintedEnvironment => {
            Support::unsupported(
                "glTF has no environment: EXT_lights_image_based takes prefiltered images, and few programs read it",
            )
        }
        Feature::SoftSpotLight => Support::approximate(
            "KHR_lights_punctual leaves the fall-off between the two cones to the program that draws",
            "with the curve that it recommends up to 0.25 of the intensity less in that ring, with 0.7 to 1 of its light (computed)",
        ),
        Feature::PointLight | Feature::SpotLight | Feature::DirectionalLight => Support::approximate(
            "KHR_lights_punctual counts the intensity of a point in candela and that of a direction in lux",
            "the numbers are those of W/sr and W/m2, as those of emitters are those of W/(m2 sr): lights and emitters of a \
             scene keep their ratios",
        ),
        Feature::LinearTexture | Feature::LinearJpegTexture => Support::unsupported(
            "the base color of glTF is decoded by the sRGB curve in any case; a grey stands for the texture",
        ),
        Feature::ExrTexture | Feature::PfmTexture | Feature::HdrTexture => {
            Support::unsupported("glTF holds PNG and JPEG only; a grey stands for the texture")
        }
        Feature::Plastic | Feature::TexturedPlastic => Support::approximate(
            "glTF's coat does not darken its base: what is seen of the base is written, of a texture by the factor of a grey of 0.5",
            "for a texture and an index of 1.5 seen 0.115 instead of 0.092 for a base of 0.2, 0.46 instead of 0.62 for 0.8 (computed)",
        ),
        Feature::OneSided => Support::approximate(
            "glTF leaves out the back of a material without `doubleSided`, so that what lies behind it is seen (glTF 2.0, 3.9.5)",
            "none where no path meets the back of the surface",
        ),
        Feature::Principled | Feature::TexturedPrincipled => Support::approximate(
            "the base of glTF's metallic-roughness material is Lambertian (glTF 2.0, appendix B)",
            "Burley's base is up to 2 roughness / 3 brighter or darker at grazing angles; viewers vary",
        ),
        Feature::Spectrum => super::RGB_ONLY,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::Resolution => Support::approximate(
            "a glTF camera holds the ratio of width to height",
            "the ratio is exact; the resolution stands in the scene's `extras`",
        ),
        Feature::PixelFilter
        | Feature::BoxFilter
        | Feature::GaussianFilter
        | Feature::CutGaussianFilter
        | Feature::Path
        | Feature::Bidirectional
        | Feature::LightTracing
        | Feature::Metropolis
        | Feature::PhotonMap
        | Feature::EmissionOnly
        | Feature::IndirectLight
        | Feature::IndependentSampler
        | Feature::SobolSampler
        | Feature::SobolForLightPaths
        | Feature::Seed => EXTRAS,
    }
}

#[cfg(test)]
mod ranges_tests;
#[cfg(test)]
mod tests;
