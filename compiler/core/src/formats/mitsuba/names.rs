//! The vocabulary of Mitsuba's scene files and its conventions for numbers, per version.
//!
//! Where a spelling has no other source it was read in the source of Mitsuba 0.6 (`src/librender`, `src/bsdfs`,
//! `src/films`), the schema `data/schema/scene.xsd` that it comes with, and the plugin reference of Mitsuba 3.

use crate::formats::shared::images::{self, Form, Forms, Use};
use crate::ir::{Affine, ColorOrTexture, LightKind, Texture};

/// A version of the file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// Mitsuba 0.5.
    V05,
    /// Mitsuba 0.6: the same text but for the version, as 0.6 refuses a file that says 0.5.0 (`scenehandler.cpp`
    /// compares the first two numbers; seen with a build of 0.6).
    V06,
    /// Mitsuba 3: parameters in snake case, and every parameter that a plugin does not ask for is an error (3.9.1).
    V3,
}

impl Version {
    /// The `version` of the root element.
    pub fn number(self) -> &'static str {
        match self {
            Self::V05 => "0.5.0",
            Self::V06 => "0.6.0",
            Self::V3 => "3.0.0",
        }
    }

    /// The target's name.
    pub fn target(self) -> &'static str {
        match self {
            Self::V05 => "mitsuba-0.5",
            Self::V06 => "mitsuba-0.6",
            Self::V3 => "mitsuba-3",
        }
    }

    /// What it does with images.
    pub fn images(self) -> Forms {
        match self {
            Self::V05 | Self::V06 => images_0,
            Self::V3 => images_3,
        }
    }

    /// The names of parameters.
    pub fn names(self) -> &'static Names {
        match self {
            Self::V05 | Self::V06 => &CAMEL,
            Self::V3 => &SNAKE,
        }
    }
}

/// The plugin of a light.
pub fn emitter(kind: &LightKind) -> &'static str {
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Color(_), tint: _, turn: _ } => "constant",
        LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint: _, turn: _ } => "envmap",
        LightKind::Point { position: _, intensity: _ } => "point",
        LightKind::Spot { position: _, target: _, intensity: _, angle: _, inner: _ } => "spot",
        LightKind::Directional { direction: _, irradiance: _ } => "directional",
    }
}

/// From `envmap`'s directions to the Scene's: its y is up, its +z lies in the middle of the image and its -x a quarter to the right
/// of that (measured with 3.9.1; `envmap.cpp` of 0.6 has the same formula).
pub const ENVIRONMENT: Affine = Affine { rows: [[-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]] };

/// The most rows of an image of the environment that is written anew for Mitsuba 3.
const MOST_ROWS: u32 = 4096;

/// Images of Mitsuba 3: it lays the first row of an environment on one pole and the last one on the other (measured with 3.9.1), so
/// that images get rows there. A colored tint is multiplied into the image, the rest is `scale`.
pub fn images_3(texture: &Texture, purpose: Use) -> Form {
    match purpose {
        Use::Sky(tint) if texture.image.height <= MOST_ROWS => Form::Rows(images::split(tint).1),
        Use::Surface | Use::Sky(_) => images_0(texture, purpose),
    }
}

/// Images of Mitsuba 0.x.
pub fn images_0(texture: &Texture, purpose: Use) -> Form {
    match purpose {
        Use::Surface => images::on_surface(texture, Form::Shared),
        Use::Sky(tint) => match images::split(tint) {
            (_, [1.0, 1.0, 1.0]) => Form::Shared,
            (_, color) => Form::Tinted(color),
        },
    }
}

/// Names of parameters.
#[derive(Debug)]
pub struct Names {
    /// Integrator: largest number of path segments; the Scene's `max_depth` has this very meaning.
    pub max_depth: &'static str,
    /// Integrator: first segment that Russian roulette may end.
    pub rr_depth: &'static str,
    /// Sampler: samples per pixel.
    pub sample_count: &'static str,
    /// Sampler: seed; none where the plugin `independent` has none (0.x).
    pub seed: Option<&'static str>,
    /// Whether the version has the plugins `bdpt`, `pssmlt`, `sppm` and `sobol`: 3 has none of them (plugins of 3.9.1).
    pub light_paths: bool,
    /// Sensor and shape: the transform.
    pub to_world: &'static str,
    /// Sensor: the axis of `fov`.
    pub fov_axis: &'static str,
    /// Sensor: nearest distance along the axis.
    pub near_clip: &'static str,
    /// Sensor: farthest distance along the axis.
    pub far_clip: &'static str,
    /// Film: channels.
    pub pixel_format: &'static str,
    /// Film: the part that is rendered, by its left and upper edge, width and height.
    pub crop: [&'static str; 4],
    /// Film: numbers.
    pub component_format: &'static str,
    /// Film: whether a logo is drawn into the image; none where there is none to switch off (3).
    pub banner: Option<&'static str>,
    /// Filter: half the side; none where the box is the pixel (3.9.1 refuses `radius`).
    pub box_radius: Option<&'static str>,
    /// Dielectric: index of refraction inside.
    pub int_ior: &'static str,
    /// Dielectric: index of refraction outside.
    pub ext_ior: &'static str,
    /// Conductor: index of refraction of the surroundings; 0.x takes that of air, 1.000277, unless told otherwise, 3
    /// has no such parameter.
    pub ext_eta: Option<&'static str>,
    /// Plastic: the base.
    pub diffuse_reflectance: &'static str,
    /// Whether there is a plugin `principled` (3).
    pub principled: bool,
    /// Conductor: factor of the reflectance.
    pub specular_reflectance: &'static str,
    /// Spot: half of the cone's opening, and of the part of full intensity, in degrees (`m_cosCutoffAngle` and
    /// `m_cosBeamWidth` are cosines of the whole numbers in `spot.cpp` of 0.6 and 3.9.1).
    pub spot: (&'static str, &'static str),
    /// Bitmap: the parameter that says how pixels are looked up, and its value: linearly between their middles, in 0.x also over
    /// the footprint of a pixel of the film.
    pub filter_type: (&'static str, &'static str),
    /// Bitmap: what lies beyond its edges.
    pub wrap_mode: &'static str,
    /// Bitmap: whether texture coordinates are moved by `to_uv` and decoding is switched off by `raw` (3); else by `vscale` and
    /// `voffset`, and by `gamma` (0.x).
    pub to_uv: bool,
    /// Mesh: flat faces.
    pub face_normals: &'static str,
}

static CAMEL: Names = Names {
    max_depth: "maxDepth",
    rr_depth: "rrDepth",
    sample_count: "sampleCount",
    seed: None,
    light_paths: true,
    to_world: "toWorld",
    fov_axis: "fovAxis",
    near_clip: "nearClip",
    far_clip: "farClip",
    pixel_format: "pixelFormat",
    crop: ["cropOffsetX", "cropOffsetY", "cropWidth", "cropHeight"],
    component_format: "componentFormat",
    banner: Some("banner"),
    box_radius: Some("radius"),
    int_ior: "intIOR",
    ext_ior: "extIOR",
    ext_eta: Some("extEta"),
    diffuse_reflectance: "diffuseReflectance",
    principled: false,
    specular_reflectance: "specularReflectance",
    spot: ("cutoffAngle", "beamWidth"),
    filter_type: ("filterType", "ewa"),
    wrap_mode: "wrapMode",
    to_uv: false,
    face_normals: "faceNormals",
};

static SNAKE: Names = Names {
    max_depth: "max_depth",
    rr_depth: "rr_depth",
    sample_count: "sample_count",
    seed: Some("seed"),
    light_paths: false,
    to_world: "to_world",
    fov_axis: "fov_axis",
    near_clip: "near_clip",
    far_clip: "far_clip",
    pixel_format: "pixel_format",
    crop: ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"],
    component_format: "component_format",
    banner: None,
    box_radius: None,
    int_ior: "int_ior",
    ext_ior: "ext_ior",
    ext_eta: None,
    diffuse_reflectance: "diffuse_reflectance",
    principled: true,
    specular_reflectance: "specular_reflectance",
    spot: ("cutoff_angle", "beam_width"),
    filter_type: ("filter_type", "bilinear"),
    wrap_mode: "wrap_mode",
    to_uv: true,
    face_normals: "face_normals",
};

/// Segments that are followed before Russian roulette may end a path: the default of all versions, written out so
/// that a file says what is done.
pub const RR_DEPTH: u32 = 5;

/// `sppm` refuses a depth below 2 (`sppm.cpp` of 0.6). All plugins count segments as the Scene does: 1 is emission seen
/// directly, 2 direct light (the manual of 0.6, `maxDepth` of `bdpt`, `ptracer`, `pssmlt` and `sppm`; that of 3.9.1,
/// `max_depth` of `ptracer`).
pub fn photon_depth(segments: u32) -> u32 {
    segments.max(2)
}

/// The share of photons that `sppm` keeps from pass to pass; PBRT's is fixed to this, Mitsuba's default is 0.7.
pub const PHOTON_ALPHA: f64 = 2.0 / 3.0;

/// Clipping distances that are in force where a file gives none: `nearClip` and `farClip` of `sensor.cpp` in 0.6,
/// `near_clip` and `far_clip` of 3.9.1.
pub const DEFAULT_CLIPPING: (f64, f64) = (1e-2, 1e4);
