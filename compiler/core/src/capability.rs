//! What scenes ask for and what targets answer.
//!
//! [`features`] reads a scene; each target answers [`Support`] for every [`Feature`] without a wildcard arm, so that a
//! new feature fails to compile in every target until someone decides. Losses, the table of targets and the tests that
//! read emitted files back are all made from these answers.

use std::collections::BTreeMap;

use crate::diag::Origin;
use crate::ir::{
    Affine, Bsdf, Camera, Color, ColorOrTexture, Emission, Encoding, Film, Filter, ImageFormat, ImageInfo, Integrator,
    LightKind, LightSource, Material, Mesh, Sampler, Scene, Shape, Texture, Vec3, cross, dot, normalized, sub,
};

/// The GGX width up to which all targets agree to about one percent; wider lobes show the different masking terms.
pub const WIDE_ALPHA: f64 = 0.3;

/// The GGX width below which targets begin to treat a surface as smooth or to clamp the width.
pub const SHARP_ALPHA: f64 = 0.01;

/// The cosine of 5 degrees: how far a vertex normal leans from its face before PBRT v3 visibly lights faces that look
/// away from the emitter.
const LEANING_COSINE: f64 = 0.996_194_698_091_745_5;

/// One thing that a scene can ask for. Closed: a new one fails to compile in every target until someone decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// A diffuse material.
    Diffuse,
    /// A diffuse material that is not grey.
    ColoredDiffuse,
    /// A diffuse surface whose vertex normals lean more than 5 degrees from the normals of its faces.
    SmoothDiffuse,
    /// A conductor with alpha 0.
    SmoothConductor,
    /// A conductor with alpha above 0.
    RoughConductor,
    /// A conductor with alpha above 0 and below [`SHARP_ALPHA`].
    SharpConductor,
    /// A conductor with alpha above [`WIDE_ALPHA`].
    WideConductor,
    /// A conductor whose `eta` or `k` is not grey.
    ColoredConductor,
    /// A dielectric with alpha 0.
    SmoothDielectric,
    /// A dielectric with alpha above 0.
    RoughDielectric,
    /// A dielectric that is optically thinner inside than outside.
    ThinnerInside,
    /// A mirror.
    Mirror,
    /// A mirror that reflects less than all light, or is not grey.
    DimMirror,
    /// A base under a clear coat.
    Plastic,
    /// The same with a texture.
    TexturedPlastic,
    /// A principled material.
    Principled,
    /// The same with a texture.
    TexturedPrincipled,
    /// A surface that is black from behind.
    OneSided,
    /// An emitter on a black diffuse surface.
    BlackEmitter,
    /// An emitter on a surface that also scatters light.
    ScatteringEmitter,
    /// An emitter whose radiance is not grey, or another light that is not.
    ColoredEmitter,
    /// A constant environment.
    Environment,
    /// An environment by an image.
    EnvironmentImage,
    /// An image of the environment that is turned.
    TurnedEnvironment,
    /// An image of the environment with a tint that is not grey.
    TintedEnvironment,
    /// A point light.
    PointLight,
    /// A spot light.
    SpotLight,
    /// A spot light without a sharp edge.
    SoftSpotLight,
    /// A directional light.
    DirectionalLight,
    /// A color as a spectrum.
    Spectrum,
    /// A texture.
    Texture,
    /// A texture whose image has colors.
    ColoredTexture,
    /// A PNG or JPEG file whose numbers are decoded by the sRGB curve.
    SrgbTexture,
    /// A PNG file whose numbers are linear.
    LinearTexture,
    /// A PNG file of 16 bits per channel.
    DeepTexture,
    /// A texture whose numbers are multiplied by a factor.
    ScaledTexture,
    /// A JPEG file.
    JpegTexture,
    /// A JPEG file whose numbers are linear.
    LinearJpegTexture,
    /// An OpenEXR file.
    ExrTexture,
    /// A PFM file.
    PfmTexture,
    /// A Radiance HDR file.
    HdrTexture,
    /// A mesh with a normal at each vertex.
    VertexNormals,
    /// A mesh without normals: flat faces.
    NoNormals,
    /// A mesh with texture coordinates.
    TextureCoordinates,
    /// A shape that keeps a transform.
    TransformedShape,
    /// A mesh used by several shapes.
    SharedMesh,
    /// A group placed by instances.
    Instances,
    /// A pinhole camera.
    Camera,
    /// A near or far clipping distance.
    ClippingPlanes,
    /// More cameras than one.
    SeveralCameras,
    /// Width and height of the image.
    Resolution,
    /// The box filter of radius 0.5: the pixel itself.
    PixelFilter,
    /// A box filter of another radius.
    BoxFilter,
    /// A Gaussian cut at four standard deviations.
    GaussianFilter,
    /// A Gaussian cut elsewhere.
    CutGaussianFilter,
    /// Path tracing.
    Path,
    /// Bidirectional path tracing.
    Bidirectional,
    /// Light tracing.
    LightTracing,
    /// Metropolis light transport.
    Metropolis,
    /// Progressive photon mapping.
    PhotonMap,
    /// Paths of one segment: emission seen directly and nothing else.
    EmissionOnly,
    /// Paths of three segments or more.
    IndirectLight,
    /// Independent random samples.
    IndependentSampler,
    /// A Sobol sequence with an algorithm whose paths begin at the camera.
    SobolSampler,
    /// A Sobol sequence with light tracing, Metropolis light transport or photon mapping.
    SobolForLightPaths,
    /// A seed other than 0.
    Seed,
}

impl Feature {
    /// All features, in the order in which they are shown.
    pub const ALL: &[Self] = &[
        Self::Diffuse,
        Self::ColoredDiffuse,
        Self::SmoothDiffuse,
        Self::SmoothConductor,
        Self::RoughConductor,
        Self::SharpConductor,
        Self::WideConductor,
        Self::ColoredConductor,
        Self::SmoothDielectric,
        Self::RoughDielectric,
        Self::ThinnerInside,
        Self::Mirror,
        Self::DimMirror,
        Self::Plastic,
        Self::TexturedPlastic,
        Self::Principled,
        Self::TexturedPrincipled,
        Self::OneSided,
        Self::BlackEmitter,
        Self::ScatteringEmitter,
        Self::ColoredEmitter,
        Self::Environment,
        Self::EnvironmentImage,
        Self::TurnedEnvironment,
        Self::TintedEnvironment,
        Self::PointLight,
        Self::SpotLight,
        Self::SoftSpotLight,
        Self::DirectionalLight,
        Self::Spectrum,
        Self::Texture,
        Self::ColoredTexture,
        Self::SrgbTexture,
        Self::LinearTexture,
        Self::DeepTexture,
        Self::ScaledTexture,
        Self::JpegTexture,
        Self::LinearJpegTexture,
        Self::ExrTexture,
        Self::PfmTexture,
        Self::HdrTexture,
        Self::VertexNormals,
        Self::NoNormals,
        Self::TextureCoordinates,
        Self::TransformedShape,
        Self::SharedMesh,
        Self::Instances,
        Self::Camera,
        Self::ClippingPlanes,
        Self::SeveralCameras,
        Self::Resolution,
        Self::PixelFilter,
        Self::BoxFilter,
        Self::GaussianFilter,
        Self::CutGaussianFilter,
        Self::Path,
        Self::Bidirectional,
        Self::LightTracing,
        Self::Metropolis,
        Self::PhotonMap,
        Self::EmissionOnly,
        Self::IndirectLight,
        Self::IndependentSampler,
        Self::SobolSampler,
        Self::SobolForLightPaths,
        Self::Seed,
    ];

    /// What it is, as it reads within a sentence: "a diffuse material".
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "a diffuse material",
            Self::ColoredDiffuse => "a colored diffuse material",
            Self::SmoothDiffuse => "a diffuse surface with smooth normals",
            Self::SmoothConductor => "a smooth conductor",
            Self::RoughConductor => "a rough conductor",
            Self::SharpConductor => "a conductor with `alpha` below 0.01",
            Self::WideConductor => "a conductor with `alpha` above 0.3",
            Self::ColoredConductor => "a colored conductor",
            Self::SmoothDielectric => "a smooth dielectric",
            Self::RoughDielectric => "a rough dielectric",
            Self::ThinnerInside => "a dielectric optically thinner inside than outside",
            Self::Mirror => "a mirror",
            Self::DimMirror => "a mirror that absorbs light",
            Self::Plastic => "plastic",
            Self::TexturedPlastic => "plastic with a texture",
            Self::Principled => "a principled material",
            Self::TexturedPrincipled => "a principled material with a texture",
            Self::OneSided => "a surface that is black from behind",
            Self::BlackEmitter => "an emitter on a black surface",
            Self::ScatteringEmitter => "an emitter on a surface that scatters light",
            Self::ColoredEmitter => "a colored emitter",
            Self::Environment => "a constant environment",
            Self::EnvironmentImage => "an image of the environment",
            Self::TurnedEnvironment => "a turned image of the environment",
            Self::TintedEnvironment => "a tinted image of the environment",
            Self::PointLight => "a point light",
            Self::SpotLight => "a spot light",
            Self::SoftSpotLight => "a spot light with a soft edge",
            Self::DirectionalLight => "a directional light",
            Self::Spectrum => "a spectrum",
            Self::Texture => "a texture",
            Self::ColoredTexture => "a colored texture",
            Self::SrgbTexture => "a texture decoded by the sRGB curve",
            Self::LinearTexture => "a texture of linear numbers in PNG",
            Self::DeepTexture => "a texture of 16 bits in PNG",
            Self::ScaledTexture => "a texture with a factor",
            Self::JpegTexture => "a texture in JPEG",
            Self::LinearJpegTexture => "a texture of linear numbers in JPEG",
            Self::ExrTexture => "a texture in OpenEXR",
            Self::PfmTexture => "a texture in PFM",
            Self::HdrTexture => "a texture in Radiance HDR",
            Self::VertexNormals => "a mesh with normals",
            Self::NoNormals => "a mesh without normals",
            Self::TextureCoordinates => "texture coordinates",
            Self::TransformedShape => "a shape with a transform",
            Self::SharedMesh => "a mesh used several times",
            Self::Instances => "instances of a group",
            Self::Camera => "a pinhole camera",
            Self::ClippingPlanes => "clipping distances of the camera",
            Self::SeveralCameras => "several cameras",
            Self::Resolution => "the resolution of the image",
            Self::PixelFilter => "the box filter of one pixel",
            Self::BoxFilter => "a box filter of another radius than 0.5",
            Self::GaussianFilter => "a Gaussian filter",
            Self::CutGaussianFilter => "a Gaussian filter not cut at four standard deviations",
            Self::Path => "path tracing",
            Self::Bidirectional => "bidirectional path tracing",
            Self::LightTracing => "light tracing",
            Self::Metropolis => "Metropolis light transport",
            Self::PhotonMap => "photon mapping",
            Self::EmissionOnly => "paths of one segment",
            Self::IndirectLight => "indirect light",
            Self::IndependentSampler => "independent samples",
            Self::SobolSampler => "a Sobol sequence",
            Self::SobolForLightPaths => "a Sobol sequence for paths that begin at lights",
            Self::Seed => "a seed",
        }
    }
}

/// What a target answers.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// The target means the same.
    Exact,
    /// The target means nearly the same.
    Approximate {
        /// What differs.
        why: &'static str,
        /// By how much, and how that was found.
        bound: &'static str,
    },
    /// The target cannot say it.
    Unsupported {
        /// What is missing.
        why: &'static str,
    },
}

impl Support {
    /// [`Support::Approximate`].
    pub const fn approximate(why: &'static str, bound: &'static str) -> Self {
        Self::Approximate { why, bound }
    }

    /// [`Support::Unsupported`].
    pub const fn unsupported(why: &'static str) -> Self {
        Self::Unsupported { why }
    }
}

/// By how much a target is off for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// The largest share of a value by which it is off; 0.02 is 2 %.
    pub size: f64,
    /// What it is a share of, and where it is reached: "of the light that `gold` reflects once, in blue at 72 degrees".
    pub what: String,
}

/// What `scene` asks for, each feature once with the first place that asks for it, in the order of [`Feature::ALL`].
pub fn features(scene: &Scene) -> Vec<(Feature, Origin)> {
    let Scene {
        name: _,
        origin,
        documentation: _,
        meshes,
        textures,
        materials,
        shapes: _,
        lights,
        groups: _,
        instances,
        cameras,
        film,
        integrator,
        sampler,
    } = scene;
    let mut asked = Asked::default();
    for (handle, material) in materials.iter() {
        let Material { name: _, bsdf, sides: _ } = material;
        ask_bsdf(&mut asked, bsdf, materials.origin(handle));
        asked.add_if(material.is_one_sided(), Feature::OneSided, materials.origin(handle));
    }
    for (handle, mesh) in meshes.iter() {
        let Mesh { name: _, positions: _, normals, uvs, triangles: _ } = mesh;
        let place = meshes.origin(handle);
        let kind = if normals.is_some() { Feature::VertexNormals } else { Feature::NoNormals };
        asked.add(kind, place);
        asked.add_if(uvs.is_some(), Feature::TextureCoordinates, place);
    }
    for (place, texture) in textures.entries() {
        ask_texture(&mut asked, texture, place);
    }
    let mut uses = vec![0_u32; meshes.len()];
    for (place, shape) in scene.surfaces() {
        let Shape { name: _, mesh, transform, material, emission } = shape;
        uses[mesh.index()] += 1;
        asked.add_if(uses[mesh.index()] > 1, Feature::SharedMesh, place);
        asked.add_if(*transform != crate::ir::Affine::IDENTITY, Feature::TransformedShape, place);
        let scatters = scatters_diffusely(&materials[*material].bsdf);
        if scatters == Some(true) && !asked.has(Feature::SmoothDiffuse) {
            asked.add_if(leans(&meshes[*mesh]), Feature::SmoothDiffuse, place);
        }
        if let Some(Emission { radiance }) = emission {
            let black = scatters == Some(false);
            let kind = if black { Feature::BlackEmitter } else { Feature::ScatteringEmitter };
            asked.add(kind, place);
            asked.color(radiance, Feature::ColoredEmitter, place);
        }
    }
    for (place, light) in lights.entries() {
        let LightSource { name: _, kind } = light;
        let feature = match kind {
            LightKind::Environment { radiance: ColorOrTexture::Color(_), tint: _, turn: _ } => Feature::Environment,
            LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint, turn } => {
                asked.add_if(*turn != Affine::IDENTITY, Feature::TurnedEnvironment, place);
                asked.add_if(!tint.is_grey(), Feature::TintedEnvironment, place);
                Feature::EnvironmentImage
            }
            LightKind::Point { position: _, intensity: _ } => Feature::PointLight,
            LightKind::Spot { position: _, target: _, intensity: _, angle, inner } => {
                asked.add_if(inner < angle, Feature::SoftSpotLight, place);
                Feature::SpotLight
            }
            LightKind::Directional { direction: _, irradiance: _ } => Feature::DirectionalLight,
        };
        asked.add(feature, place);
        asked.color(kind.color(), Feature::ColoredEmitter, place);
    }
    for (place, _) in instances.entries().take(1) {
        asked.add(Feature::Instances, place);
    }
    for (at, (handle, camera)) in cameras.iter().enumerate() {
        let Camera { name: _, eye: _, target: _, up: _, fov_x: _, near, far } = camera;
        let place = cameras.origin(handle);
        asked.add(Feature::Camera, place);
        asked.add_if(near.is_some() || far.is_some(), Feature::ClippingPlanes, place);
        asked.add_if(at > 0, Feature::SeveralCameras, place);
    }
    ask_settings(&mut asked, film, integrator, sampler, origin);
    asked.0.into_iter().collect()
}

/// What a texture asks for.
pub fn of_texture(texture: &Texture) -> Vec<Feature> {
    let mut asked = Asked::default();
    ask_texture(&mut asked, texture, &Origin::Made);
    asked.0.into_keys().collect()
}

#[derive(Default)]
struct Asked(BTreeMap<Feature, Origin>);

impl Asked {
    fn add(&mut self, feature: Feature, place: &Origin) {
        self.0.entry(feature).or_insert_with(|| place.clone());
    }

    fn add_if(&mut self, condition: bool, feature: Feature, place: &Origin) {
        if condition {
            self.add(feature, place);
        }
    }

    /// A color: a spectrum, or `colored` where it is not grey.
    fn color(&mut self, color: &Color, colored: Feature, place: &Origin) {
        match color {
            Color::Grey(_) => {}
            Color::Rgb(_) => self.add_if(!color.is_grey(), colored, place),
            Color::Spectrum(_) => self.add(Feature::Spectrum, place),
        }
    }

    fn has(&self, feature: Feature) -> bool {
        self.0.contains_key(&feature)
    }
}

fn ask_bsdf(asked: &mut Asked, bsdf: &Bsdf, place: &Origin) {
    match bsdf {
        Bsdf::Diffuse { reflectance } => {
            asked.add(Feature::Diffuse, place);
            match reflectance {
                ColorOrTexture::Color(color) => asked.color(color, Feature::ColoredDiffuse, place),
                // What the texture asks for stands with it.
                ColorOrTexture::Texture(_) => {}
            }
        }
        Bsdf::Conductor { eta, k, alpha } => {
            let smooth = *alpha == 0.0;
            let kind = if smooth { Feature::SmoothConductor } else { Feature::RoughConductor };
            asked.add(kind, place);
            asked.add_if(!smooth && *alpha < SHARP_ALPHA, Feature::SharpConductor, place);
            asked.add_if(*alpha > WIDE_ALPHA, Feature::WideConductor, place);
            asked.color(eta, Feature::ColoredConductor, place);
            asked.color(k, Feature::ColoredConductor, place);
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let smooth = *alpha == 0.0;
            let kind = if smooth { Feature::SmoothDielectric } else { Feature::RoughDielectric };
            asked.add(kind, place);
            asked.add_if(interior < exterior, Feature::ThinnerInside, place);
        }
        Bsdf::Mirror { reflectance } => {
            asked.add(Feature::Mirror, place);
            asked.add_if(reflectance.rgb() != [1.0; 3], Feature::DimMirror, place);
            asked.add_if(reflectance.spectrum().is_some(), Feature::Spectrum, place);
        }
        Bsdf::Plastic { reflectance, ior: _, alpha: _ } => {
            asked.add(Feature::Plastic, place);
            asked.add_if(reflectance.texture().is_some(), Feature::TexturedPlastic, place);
            asked.add_if(has_spectrum(reflectance), Feature::Spectrum, place);
        }
        Bsdf::Principled { base, metallic: _, roughness: _, ior: _ } => {
            asked.add(Feature::Principled, place);
            asked.add_if(base.texture().is_some(), Feature::TexturedPrincipled, place);
            asked.add_if(has_spectrum(base), Feature::Spectrum, place);
        }
    }
}

fn has_spectrum(paint: &ColorOrTexture) -> bool {
    paint.color().is_some_and(|color| color.spectrum().is_some())
}

fn ask_texture(asked: &mut Asked, texture: &Texture, place: &Origin) {
    let Texture { name: _, file: _, image, encoding, peak: _, factor: _ } = texture;
    let ImageInfo { format, width: _, height: _, channels, bits } = *image;
    asked.add(Feature::Texture, place);
    asked.add_if(channels >= 3, Feature::ColoredTexture, place);
    asked.add_if(*encoding == Encoding::Srgb, Feature::SrgbTexture, place);
    asked.add_if(texture.is_scaled(), Feature::ScaledTexture, place);
    let linear = *encoding == Encoding::Linear;
    match format {
        ImageFormat::Png => {
            asked.add_if(linear, Feature::LinearTexture, place);
            asked.add_if(bits > 8, Feature::DeepTexture, place);
        }
        ImageFormat::Jpeg => {
            asked.add(Feature::JpegTexture, place);
            asked.add_if(linear, Feature::LinearJpegTexture, place);
        }
        ImageFormat::Exr => asked.add(Feature::ExrTexture, place),
        ImageFormat::Pfm => asked.add(Feature::PfmTexture, place),
        ImageFormat::Hdr => asked.add(Feature::HdrTexture, place),
    }
}

fn ask_settings(asked: &mut Asked, film: &Film, integrator: &Integrator, sampler: &Sampler, place: &Origin) {
    let Film { width: _, height: _, filter } = film;
    asked.add(Feature::Resolution, place);
    match filter {
        Filter::Box { radius } => {
            let kind = if *radius == 0.5 { Feature::PixelFilter } else { Feature::BoxFilter };
            asked.add(kind, place);
        }
        Filter::Gaussian { stddev, radius } => {
            let whole = (radius - 4.0 * stddev).abs() <= 1e-9 * radius;
            asked.add(Feature::GaussianFilter, place);
            asked.add_if(!whole, Feature::CutGaussianFilter, place);
        }
    }
    let (algorithm, _) = algorithm(integrator);
    asked.add(algorithm, place);
    asked.add_if(integrator.max_depth() <= 1, Feature::EmissionOnly, place);
    asked.add_if(integrator.max_depth() >= 3, Feature::IndirectLight, place);
    asked.add(sampler_feature(sampler, integrator), place);
    asked.add_if(sampler.seed() != 0, Feature::Seed, place);
}

/// The feature that a sampler is for the paths of an integrator.
pub fn sampler_feature(sampler: &Sampler, integrator: &Integrator) -> Feature {
    let (_, from_lights) = algorithm(integrator);
    match sampler {
        Sampler::Independent { samples: _, seed: _ } => Feature::IndependentSampler,
        Sampler::Sobol { samples: _, seed: _ } if from_lights => Feature::SobolForLightPaths,
        Sampler::Sobol { samples: _, seed: _ } => Feature::SobolSampler,
    }
}

/// The feature that an integrator is, and whether its paths (those that the sampler is for) begin at the lights.
pub fn algorithm(integrator: &Integrator) -> (Feature, bool) {
    match integrator {
        Integrator::Path { max_depth: _ } => (Feature::Path, false),
        Integrator::Bidirectional { max_depth: _ } => (Feature::Bidirectional, false),
        Integrator::LightTracing { max_depth: _ } => (Feature::LightTracing, true),
        Integrator::Metropolis { max_depth: _ } => (Feature::Metropolis, true),
        Integrator::PhotonMap { max_depth: _ } => (Feature::PhotonMap, true),
    }
}

/// Whether a surface is a black (`Some(false)`) or another (`Some(true)`) diffuse one; none for other materials.
fn scatters_diffusely(bsdf: &Bsdf) -> Option<bool> {
    match bsdf {
        Bsdf::Diffuse { reflectance } => Some(!reflectance.color().is_some_and(Color::is_black)),
        // Their bases are diffuse.
        Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
        | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => Some(true),
        Bsdf::Conductor { eta: _, k: _, alpha: _ }
        | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
        | Bsdf::Mirror { reflectance: _ } => None,
    }
}

/// Whether a vertex normal leans more than 5 degrees from the normal of one of its faces.
fn leans(mesh: &Mesh) -> bool {
    let Mesh { name: _, positions: _, normals, uvs: _, triangles } = mesh;
    let Some(normals) = normals else { return false };
    triangles.iter().any(|triangle| {
        let [a, b, c]: [Vec3; 3] = mesh.corners(*triangle);
        let Some(face) = normalized(cross(sub(b, a), sub(c, a))) else { return false };
        triangle.iter().any(|index| {
            let normal = normals[*index as usize].map(f64::from);
            dot(face, normal) < LEANING_COSINE
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Sources;
    use crate::diag::Span;
    use crate::formats::shared::sample;
    use std::sync::Arc;

    fn asks(scene: &Scene) -> Vec<Feature> {
        features(scene).into_iter().map(|(feature, _)| feature).collect()
    }

    #[test]
    fn the_list_is_whole_and_in_order() {
        assert!(Feature::ALL.is_sorted());
        assert_eq!(Feature::ALL.len(), Feature::Seed as usize + 1);
        let names: std::collections::BTreeSet<_> = Feature::ALL.iter().map(|feature| feature.name()).collect();
        assert_eq!(names.len(), Feature::ALL.len());
    }

    #[test]
    fn a_cornell_box_asks_for_little() {
        use Feature as F;
        assert_eq!(
            asks(&sample::room()),
            [
                F::Diffuse,
                F::ColoredDiffuse,
                F::BlackEmitter,
                F::VertexNormals,
                F::Camera,
                F::Resolution,
                F::PixelFilter,
                F::Path,
                F::IndirectLight,
                F::IndependentSampler,
            ]
        );
    }

    #[test]
    fn materials_ask_by_their_numbers() {
        let metal = |eta: Color, alpha: f64| Bsdf::Conductor { eta, k: Color::Grey(2.0), alpha };
        let asks = |bsdf: Bsdf| {
            let mut scene = sample::empty("s");
            sample::material(&mut scene, "m", bsdf);
            let mut found = self::asks(&scene);
            found.retain(|feature| *feature < Feature::BlackEmitter);
            found
        };
        let grey = || Color::Grey(0.2);
        let colored = Color::Rgb([0.2, 0.3, 0.4]);
        assert_eq!(asks(metal(grey(), 0.0)), [Feature::SmoothConductor]);
        assert_eq!(asks(metal(grey(), 0.3)), [Feature::RoughConductor]);
        assert_eq!(asks(metal(grey(), 0.31)), [Feature::RoughConductor, Feature::WideConductor]);
        assert_eq!(asks(metal(grey(), 0.005)), [Feature::RoughConductor, Feature::SharpConductor]);
        assert_eq!(asks(metal(colored, 0.1)), [Feature::RoughConductor, Feature::ColoredConductor]);
        let bubble = Bsdf::Dielectric { interior: 1.0, exterior: 1.33, alpha: 0.0 };
        assert_eq!(asks(bubble), [Feature::SmoothDielectric, Feature::ThinnerInside]);
        let dim = Bsdf::Mirror { reflectance: Color::Grey(0.9) };
        assert_eq!(asks(dim), [Feature::Mirror, Feature::DimMirror]);
    }

    #[test]
    fn lights_and_algorithms_are_asked_for() {
        let mut scene = sample::empty("s");
        let kinds = [
            LightKind::environment(Color::Grey(1.0).into()),
            LightKind::Point { position: [0.0; 3], intensity: Color::Grey(1.0) },
            LightKind::Directional { direction: [0.0, 0.0, -1.0], irradiance: Color::Rgb([1.0, 2.0, 3.0]) },
            LightKind::Spot {
                position: [0.0; 3],
                target: [1.0; 3],
                intensity: Color::Grey(1.0),
                angle: 20.0,
                inner: 15.0,
            },
        ];
        for kind in kinds {
            scene.lights.push(LightSource { name: "l".to_owned(), kind }, crate::diag::Origin::Made);
        }
        scene.sampler = Sampler::Sobol { samples: 4, seed: 1 };
        let light = [
            Feature::ColoredEmitter,
            Feature::Environment,
            Feature::PointLight,
            Feature::SpotLight,
            Feature::SoftSpotLight,
            Feature::DirectionalLight,
        ];
        let rest = [Feature::Path, Feature::IndirectLight, Feature::SobolSampler, Feature::Seed];
        let of = |scene: &Scene| {
            let mut found = asks(scene);
            found.retain(|feature| light.contains(feature) || (*feature >= Feature::Path && *feature <= Feature::Seed));
            found
        };
        assert_eq!(of(&scene), [&light[..], &rest[..]].concat());
        let all = [
            (Integrator::Bidirectional { max_depth: 1 }, Feature::Bidirectional, Feature::SobolSampler),
            (Integrator::LightTracing { max_depth: 1 }, Feature::LightTracing, Feature::SobolForLightPaths),
            (Integrator::Metropolis { max_depth: 1 }, Feature::Metropolis, Feature::SobolForLightPaths),
            (Integrator::PhotonMap { max_depth: 1 }, Feature::PhotonMap, Feature::SobolForLightPaths),
        ];
        for (integrator, feature, sampler) in all {
            scene.integrator = integrator;
            assert_eq!(of(&scene)[light.len()..], [feature, Feature::EmissionOnly, sampler, Feature::Seed]);
        }
    }

    #[test]
    fn the_first_place_is_kept() {
        let mut sources = Sources::default();
        let file = sources.add("a.lts", "ab");
        let mut scene = sample::empty("s");
        for at in 0..2 {
            let material = Material::new("m", sample::diffuse([0.5; 3]));
            scene.materials.push(material, Span::new(file, at, at + 1));
        }
        let found = features(&scene);
        assert_eq!(found[0], (Feature::Diffuse, Span::new(file, 0, 1).into()));
    }

    #[test]
    fn shapes_ask_for_transforms_sharing_and_emission() {
        let mut scene = sample::room();
        let (_, lamp) = scene.shapes.iter().last().expect("a lamp");
        let mut second = lamp.clone();
        second.transform = Affine::translation([1.0, 0.0, 0.0]);
        second.emission = Some(Emission { radiance: Color::Rgb([1.0, 2.0, 3.0]) });
        let (white, _) = scene.materials.iter().next().expect("white");
        second.material = white;
        scene.shapes.push(second, Origin::Made);
        let found = asks(&scene);
        for feature in
            [Feature::SharedMesh, Feature::TransformedShape, Feature::ScatteringEmitter, Feature::ColoredEmitter]
        {
            assert!(found.contains(&feature), "{feature:?}");
        }
    }

    #[test]
    fn leaning_normals_are_seen_on_diffuse_surfaces_only() {
        let mut scene = sample::room();
        for (_, mesh) in scene.meshes.iter_mut() {
            let lean = |normal: &[f32; 3]| [normal[0] + 0.06, normal[1] + 0.06, normal[2] + 0.06];
            mesh.normals = mesh.normals.as_ref().map(|all| Arc::new(all.iter().map(lean).map(unit).collect()));
        }
        assert!(asks(&scene).contains(&Feature::SmoothDiffuse));
        for (_, material) in scene.materials.iter_mut() {
            material.bsdf = Bsdf::Mirror { reflectance: Color::Grey(1.0) };
        }
        assert!(!asks(&scene).contains(&Feature::SmoothDiffuse));
    }

    fn unit(v: [f32; 3]) -> [f32; 3] {
        normalized(v.map(f64::from)).expect("a direction").map(|x| x as f32)
    }

    #[test]
    fn settings_ask_by_their_numbers() {
        let mut scene = sample::empty("s");
        scene.film.filter = Filter::Gaussian { stddev: 0.5, radius: 1.5 };
        scene.integrator = Integrator::Path { max_depth: 1 };
        scene.sampler = Sampler::Independent { samples: 1, seed: 3 };
        let found = asks(&scene);
        assert!(found.contains(&Feature::CutGaussianFilter) && found.contains(&Feature::Seed));
        assert!(found.contains(&Feature::EmissionOnly) && !found.contains(&Feature::IndirectLight));
        scene.film.filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 };
        assert!(!asks(&scene).contains(&Feature::CutGaussianFilter));
    }
}
