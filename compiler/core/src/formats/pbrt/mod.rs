//! PBRT v3 and v4: two targets, one emitter.

mod conversions;
mod emit;
pub mod import;
pub mod names;
mod scatter;
mod spectral;
mod statements;
mod text;
mod uplift;

use super::Target;
use super::shared::bounds;
use super::statements::Native;
use crate::capability::{Feature, Support};
use names::Version;

/// PBRT v4.
pub const PBRT_V4: Target = Target {
    name: "pbrt-v4",
    aliases: &["pbrt"],
    summary: "PBRT v4",
    main_file: "scene.pbrt",
    shares_meshes: true,
    supports: supports_v4,
    conversions: conversions::V4,
    images: names::images_v4,
    bound: |feature, scene| conversions::bound_v4(feature, scene).or_else(|| spectral::bound(feature, scene)),
    choices: &[],
    emit: |emission, sink| emit::emit(Version::V4, emission, sink),
    import: Some(|main, source| import::import(Version::V4, main, source)),
    statements: Some(Native { check: |given| statements::check(Version::V4, given), size: statements::size }),
};

/// PBRT v3.
pub const PBRT_V3: Target = Target {
    name: "pbrt-v3",
    aliases: &[],
    summary: "PBRT v3",
    main_file: "scene.pbrt",
    shares_meshes: true,
    supports: supports_v3,
    conversions: conversions::V3,
    images: names::images_v3,
    bound: bounds::of_correlation,
    choices: &[],
    emit: |emission, sink| emit::emit(Version::V3, emission, sink),
    import: Some(|main, source| import::import(Version::V3, main, source)),
    statements: Some(Native { check: |given| statements::check(Version::V3, given), size: statements::size }),
};

const NO_CLIPPING: Support =
    Support::approximate("PBRT has no clipping distances", "exact where every surface lies between them");

const CORRELATED: Support = Support::approximate(
    "PBRT's masking and shadowing are height-correlated, Mitsuba's are not",
    "up to 1 % per tile at `alpha` 0.5, up to 3 % brighter at 1 (rs_pbrt 0.9.12 against Mitsuba 3.9.1); in even light, seen at 60 and \
     78.5 degrees, 2 and 7 % too bright at 0.5, 10 and 26 % at 1 (the integral, and Cycles, which has the same term)",
);

const SOFT4: Support = Support::approximate(
    "between the two cones pbrt-v4's spot rises as a smooth step of the cosine, not linearly with the angle",
    "exact outside of that ring; in it up to 0.11 of the intensity more where it is narrow, with 1.03 of its light, up to 0.34 \
     and 1.5 where `inner` is 0 (computed from `lights.cpp`)",
);

const SOFT3: Support = Support::approximate(
    "between the two cones PBRT v3's spot rises with the fourth power of the cosine's share, not linearly with the angle",
    "exact outside of that ring; in it up to 0.47 of the intensity less, with 0.4 to 0.6 of its light (computed from \
     `spot.cpp`)",
);

const COATED: &str = "in even light a smooth coat over 0.5, seen at 0, 60 and 80 degrees, 0.3160, 0.3504, 0.5615 for 0.317, 0.352, 0.563; over 0.8 with `alpha` \
     0.1 at 0 and 60 degrees 0.5933, 0.6073 for 0.598, 0.614 (pbrt-v4 of 2026-06 against Mitsuba 3.9.1); by pbrt-r4 4.5.2 over 0.5 0.309, 0.340, 0.449 for 0.309, 0.341, 0.446 at `alpha` 0.1, 0.279, 0.287, 0.324 for 0.278, 0.286, 0.310 at 0.3";

const SCALED: &str =
    "for an index of 1.5 seen 0.115 instead of 0.092 for a base of 0.2, 0.46 instead of 0.62 for 0.8 (computed)";

const PHOTONS: Support = Support::approximate(
    "PBRT bounds a photon's path and the camera's path each by itself",
    "exact for diffuse surfaces and depths from 2 on; behind specular surfaces paths of up to twice the depth; as photon \
     mapping is, consistent and not unbiased: blurred over at first five pixels' share of the scene's radius, less with \
     each pass (`sppm.cpp`)",
);

const PHOTONS4: Support = Support::approximate(
    "pbrt-v4 bounds a photon's path and the camera's path each by itself, and chooses lights by `bvh`",
    "exact for diffuse surfaces and depths from 2 on; behind specular surfaces paths of up to twice the depth; of a spot with an \
     edge below 0.1 degrees the direct light is missing (`lights.cpp`; not measured); as photon mapping is, consistent and not unbiased: \
     blurred over at first five pixels' share of the scene's radius, less with each pass (`sppm.cpp`)",
);

fn supports_v4(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::SmoothDiffuse
        | Feature::SmoothConductor
        | Feature::RoughConductor
        | Feature::SmoothDielectric
        | Feature::ThinnerInside
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::Environment
        | Feature::PointLight
        | Feature::SpotLight
        | Feature::DirectionalLight
        | Feature::TurnedEnvironment
        | Feature::SrgbTexture
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
        | Feature::Resolution
        | Feature::PixelFilter
        | Feature::BoxFilter
        | Feature::GaussianFilter
        | Feature::CutGaussianFilter
        | Feature::Path
        | Feature::Bidirectional
        | Feature::Metropolis
        | Feature::EmissionOnly
        | Feature::IndependentSampler
        | Feature::SobolSampler => Exact,
        Feature::Texture => Support::approximate(
            "pbrt-v4 takes a coarser copy of an image where a pixel of the film sees several of its pixels",
            "edges within an image blurred by about a pixel of the film (`MIPMap::Filter`); exact where the image is magnified",
        ),
        Feature::ColoredTexture => Support::approximate(
            "pbrt-v4 is always spectral: the colors of an image become smooth spectra",
            "as those of colored materials: in white light one bounce to 0.2 % of the brightest channel, saturated colors differ \
             from the second on, in colored light from the first",
        ),
        Feature::Plastic => Support::approximate(
            "pbrt-v4's `coateddiffuse` follows light between coat and base by chance, through a rough coat facet by facet",
            COATED,
        ),
        Feature::TexturedPlastic => Support::approximate(
            "pbrt-v4's `coateddiffuse` follows light between coat and base by chance, through a rough coat facet by facet",
            "as for a color (see plastic); a smooth coat over a texture of 0.8 in even light, seen straight on, 0.618 for 0.633 (pbrt-r4 4.5.2 \
             against the formula)",
        ),
        Feature::Principled => Support::approximate(
            "pbrt-v4 has no principled material: a mix of `coateddiffuse`, of whose base the color is seen, and of `conductor` \
             stands for it",
            "a base of 0.5 and roughness 0.316 in even light, seen at 0 and 60 degrees: without metal 0.4977, 0.5174 for 0.538, 0.582 \
             (pbrt-v4 of 2026-06 against Mitsuba 3.9.1); by pbrt-r4 4.5.2 0.585 for 0.724 at 80, metal 0.494, 0.513, 0.575 for 0.495, 0.501, 0.564; without the sheen at grazing angles that Burley's diffuse part has",
        ),
        Feature::OneSided => Support::approximate(
            "PBRT's materials scatter on both sides",
            "none where no path meets the back of the surface; else all that its back reflects",
        ),
        Feature::TexturedPrincipled => Support::approximate(
            "pbrt-v4's coat darkens its base, and the texture is lightened by the factor of a grey of 0.5 to make up for it",
            "for an index of 1.5 seen 0.135 where 0.2 is asked for, 1 where 0.8 is asked for (computed)",
        ),
        Feature::Spectrum => Support::approximate(
            "pbrt-v4 passes a light's spectrum through, and normalizes it: its luminance is written as `scale`",
            "exact but for the steps of both integrals, 1e-4; plastic and principled materials get RGB",
        ),
        Feature::EnvironmentImage => Support::approximate(
            "pbrt-v4 takes a square image of an equal-area octahedron and does not interpolate it: the image is written anew so, with \
             at least twice as many pixels",
            "the light of each channel is kept to 1e-6, directions to a pixel; within the image as much as it varies over a pixel of \
             the new one (computed for each scene)",
        ),
        Feature::TintedEnvironment => super::TINTED,
        Feature::SoftSpotLight => SOFT4,
        Feature::LightTracing => Support::approximate(
            "pbrt-v4's `lightpath` does not show an environment seen directly",
            "exact where no environment is in view (`LightPathIntegrator::EvaluatePixelSample`); the port pbrt-r4 4.5.2 has 17 % less in a \
             closed cube whose faces shine and reflect",
        ),
        Feature::PhotonMap => PHOTONS4,
        Feature::SobolForLightPaths => Support::approximate(
            "pbrt-v4's `mlt` and the photons of its `sppm` take random numbers of their own",
            "other noise, the same expected image; exact for `lightpath`",
        ),
        Feature::ColoredDiffuse => Support::approximate(
            "pbrt-v4 is always spectral: an RGB reflectance becomes a smooth spectrum",
            "in white light one bounce to 0.2 % of the brightest channel, further ones differ: Cornell boxes with saturated walls 1.008, \
             0.995, 1.000 and 1.057, 0.979, 0.997 (cbox_indirect) in their mean R, G, B, dark channels beside the walls by up to a factor of 3 \
             (pbrt-v4 of 2026-06); grey is exact, and what a scene gives as spectra",
        ),
        Feature::ColoredConductor => Support::approximate(
            "pbrt-v4 is always spectral: RGB `eta` and `k` become smooth spectra",
            "reflectance at normal incidence 0.982 0.624 0.513 instead of 0.952 0.620 0.511 for a copper-like metal \
             (pbrt-v4 of 2026-06; computed likewise for each scene); grey is exact",
        ),
        Feature::ColoredEmitter => Support::approximate(
            "pbrt-v4 is always spectral: an RGB radiance becomes a smooth spectrum",
            "seen and on grey surfaces 0.1 %, of a saturated one 1 % in its dark channels; on colored surfaces a floor of (0.8, 0.4, 0.2) has \
             -8.5 and -79 % of red and blue under a point of (100, 50, 10), -18 % of blue in directional light of (3, 2, 1), +7.3 and \
             -29 % of red and blue under an environment of (1, 2, 0.5) (pbrt-v4 of 2026-06 and pbrt-r4 4.5.2; the spectra of Jakob and Hanika give the same)",
        ),
        Feature::IndirectLight => Support::approximate(
            "rays of pbrt-v4 that start next to a concave edge miss the other face",
            "within 0.005 units of an edge of a cube of 100 units 2.1 % too dark (pbrt-v4 of 2026-06; pbrt-r4 4.5.2 1.9 %), nothing \
             that shows where a pixel sees more",
        ),
        Feature::SharpConductor => Support::approximate(
            "pbrt-v4 takes `alpha` below 0.001 as smooth",
            "exact from 0.001 on; below it highlights lose their width of about 0.1 degrees (`materials.h`)",
        ),
        Feature::WideConductor => CORRELATED,
        Feature::RoughDielectric => Support::approximate(
            "PBRT's masking and shadowing are height-correlated, Mitsuba's are not",
            "not measured for dielectrics; for conductors up to 1 % per tile at `alpha` 0.5, up to 3 % at 1",
        ),
        Feature::Mirror => Support::approximate(
            "pbrt-v4 has no mirror; a smooth conductor of that reflectance stands for it, at most 0.9999",
            "0.01 % per reflection for a perfect mirror",
        ),
        Feature::DimMirror => Support::approximate(
            "pbrt-v4 has no mirror; a smooth conductor of that reflectance at normal incidence stands for it",
            "at 45, 60, 75 and 85 degrees 0.896, 0.884, 0.854, 0.874 for a reflectance of 0.9, and 0.507, 0.529, 0.624, \
             0.820 for 0.5 (computed from the Fresnel equations)",
        ),
        Feature::ClippingPlanes => NO_CLIPPING,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::Seed => Support::approximate(
            "a seed in the file would override the command line's, so that it stands in a comment only",
            "other noise, the same expected image; `--seed` gives it",
        ),
    }
}

fn supports_v3(feature: Feature) -> Support {
    use Support::Exact;
    match feature {
        Feature::Diffuse
        | Feature::ColoredDiffuse
        | Feature::RoughConductor
        | Feature::ColoredConductor
        | Feature::SmoothDielectric
        | Feature::ThinnerInside
        | Feature::Mirror
        | Feature::DimMirror
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::ColoredEmitter
        | Feature::Environment
        | Feature::PointLight
        | Feature::SpotLight
        | Feature::DirectionalLight
        | Feature::ColoredTexture
        | Feature::TurnedEnvironment
        | Feature::TintedEnvironment
        | Feature::SrgbTexture
        | Feature::LinearTexture
        | Feature::JpegTexture
        | Feature::DeepTexture
        | Feature::ScaledTexture
        | Feature::LinearJpegTexture
        | Feature::HdrTexture
        | Feature::ExrTexture
        | Feature::PfmTexture
        | Feature::VertexNormals
        | Feature::NoNormals
        | Feature::TextureCoordinates
        | Feature::TransformedShape
        | Feature::SharedMesh
        | Feature::Instances
        | Feature::Camera
        | Feature::Resolution
        | Feature::PixelFilter
        | Feature::BoxFilter
        | Feature::Path
        | Feature::Bidirectional
        | Feature::Metropolis
        | Feature::EmissionOnly
        | Feature::IndirectLight
        | Feature::IndependentSampler => Exact,
        Feature::GaussianFilter | Feature::CutGaussianFilter => Support::approximate(
            "PBRT v3 takes its Gaussian from a table of 16 values (`Film`)",
            "at a straight edge 0.0012 of the step (computed); the port pbrt-r3 3.2.0 0.055 for a `stddev` of 0.3, 0.017 for 1 and 2",
        ),
        Feature::SmoothDiffuse => Support::approximate(
            "PBRT v3 lights faces whose interpolated normal looks away from the emitter",
            "as brightly as if it looked towards it with the same cosine (`LambertianReflection::f` knows no hemisphere): a \
             coarse sphere of 12 by 6 faces 2.3 % too bright, 3.5 % lit from the side, 27 % in the band between light and shadow (pbrt-v3 \
             against pbrt-v4, Mitsuba 3.9.1 and LuxCore 2.11.2); less with finer meshes",
        ),
        Feature::EnvironmentImage => Support::approximate(
            "PBRT v3 mixes the rows of an environment's image at its two edges with each other",
            "half a row of pixels at each pole (`InfiniteAreaLight::Le`: its `MIPMap` repeats); exact elsewhere",
        ),
        Feature::Texture => Support::approximate(
            "PBRT v3 takes a coarser copy of an image where a pixel of the film sees several of its pixels",
            "edges within an image blurred by about a pixel of the film (`MIPMap::Lookup`); exact where the image is magnified",
        ),
        Feature::Plastic => Support::approximate(
            "PBRT v3's `substrate` does not darken its base: what is seen of the base is written instead",
            "a base of 0.5 seen at 0, 60 and 80 degrees has 0.97, 0.80, 0.90 of Mitsuba's albedo at `alpha` 0, 0.99, 0.79, 0.74 at \
             0.1, and 1.07, 0.89, 0.74 at 0.3 (pbrt-v3 against Mitsuba 3.9.1)",
        ),
        Feature::TexturedPlastic => Support::approximate(
            "PBRT v3's `substrate` does not darken its base: the texture is darkened by the factor of a grey of 0.5",
            SCALED,
        ),
        Feature::OneSided => Support::approximate(
            "PBRT's materials scatter on both sides",
            "none where no path meets the back of the surface; else all that its back reflects",
        ),
        Feature::Principled | Feature::TexturedPrincipled => Support::approximate(
            "PBRT v3's `disney` is the model of 2015, which adds light that a rough base throws back",
            "against Mitsuba 3.9.1 within 0.3 % with `metallic` 0, within 1.2 % with 1, darker by 15 to 21 % with 0.5 (base \
             0.5, seen at 0, 60 and 80 degrees; pbrt-v3); the port pbrt-r3 3.2.0 differs: with 0 0.538, 0.532, 0.502 for pbrt-v3's 0.539, \
             0.581, 0.723, with 1 0.740, 0.732, 0.679 for 0.489, 0.501, 0.564, with 0.5 0.623, 0.605, 0.596 for 0.393, 0.409, 0.475",
        ),
        Feature::SmoothConductor => Support::approximate(
            "PBRT v3's metal has an `alpha` of at least 0.001, near the limit of its single precision",
            "reflections blurred by about 0.1 degrees (`microfacet.h`), and darker by 1.9 % head-on and 0.8 % at 60 degrees, in \
             even light by 1.3 to 3.7 % (measured, pbrt-v3 and rs_pbrt 0.9.12)",
        ),
        Feature::SharpConductor => Support::approximate(
            "PBRT v3 raises `alpha` to at least 0.001, and is not exact in single precision near it",
            "below 0.001 highlights blurred by about 0.1 degrees (`microfacet.h`); head-on darker by 1.9 % at 0.001, 0.7 % \
             at 0.0015, 0.2 % at 0.002, brighter by up to 0.2 % from 0.0025 to 0.01 (measured, pbrt-v3)",
        ),
        Feature::WideConductor => CORRELATED,
        Feature::RoughDielectric => Support::approximate(
            "PBRT's masking and shadowing are height-correlated, Mitsuba's are not",
            "a Cornell box with a block of rough glass 0.9998 in its mean at `alpha` 0.1, 1.0012 at 0.3 (pbrt-v3 against \
             Mitsuba 3.9.1)",
        ),
        Feature::SoftSpotLight => SOFT3,
        Feature::LightTracing => {
            Support::unsupported("PBRT v3 has no light tracing; path tracing of the same depth stands for it")
        }
        Feature::PhotonMap => PHOTONS,
        Feature::SobolSampler => Support::approximate(
            "PBRT v3 raises the number of samples to the next power of 2",
            "exact for powers of 2; less noise for others (`sobol.h`)",
        ),
        Feature::SobolForLightPaths => Support::unsupported(
            "PBRT v3's `mlt` takes independent random numbers and its `sppm` a Halton sequence: the same expected image",
        ),
        Feature::ClippingPlanes => NO_CLIPPING,
        Feature::Spectrum => super::RGB_ONLY,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::Seed => Support::approximate(
            "PBRT v3 has no seed in the file; `ltsc render --seed` makes one for path tracing by rows of tiles above the image",
            "other noise, the same expected image",
        ),
    }
}
