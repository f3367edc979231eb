//! The vocabulary of PBRT's scene files and its conventions for numbers, per version.
//!
//! Where a spelling has no other source it was read in the sources of pbrt-v3 (`src/core/api.cpp` and the `Create`
//! functions) and pbrt-v4 (`src/pbrt/parser.cpp` and the `Create` functions), and in the file format documentation of
//! pbrt-v4.

use crate::formats::shared::camera;
use crate::formats::shared::images::{self, Form, Forms, Use};
use crate::ir::{Affine, Encoding, Film, ImageFormat, LightKind, Scene, Texture};

/// A version of the file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// PBRT v3, and its translation rs_pbrt 0.9.
    V3,
    /// PBRT v4.
    V4,
}

impl Version {
    /// The target's name.
    pub fn target(self) -> &'static str {
        match self {
            Self::V3 => "pbrt-v3",
            Self::V4 => "pbrt-v4",
        }
    }

    /// What it does with images.
    pub fn images(self) -> Forms {
        match self {
            Self::V3 => images_v3,
            Self::V4 => images_v4,
        }
    }

    /// The vocabulary.
    pub fn names(self) -> &'static Names {
        match self {
            Self::V3 => &V3,
            Self::V4 => &V4,
        }
    }
}

/// Names of directives' types and parameters.
#[derive(Debug)]
pub struct Names {
    /// `Film`: the type, the ending of the image's name, and further parameters. Both images hold float32: v3 writes
    /// half-float EXR, so a PFM is asked for; v4 writes half-float EXR unless told otherwise.
    pub film: (&'static str, &'static str, &'static str),
    /// `PixelFilter`: half the side along x and y.
    pub filter_radius: (&'static str, &'static str),
    /// `Sampler`: independent random numbers.
    pub sampler: &'static str,
    /// `Integrator "bdpt"`: parameters beside the depth. v3's light choice is written out, v4 takes no such parameter there
    /// and refuses what it does not take.
    pub bidirectional: &'static str,
    /// `Integrator "mlt"`: parameters beside depth and samples.
    pub metropolis: &'static str,
    /// Light tracing: v4's `lightpath`; v3 has none.
    pub light_tracing: Option<&'static str>,
    /// `Integrator "sppm"`: the number of passes; none where they are the sampler's samples (v4, `SPPMIntegrator::Render`).
    pub passes: Option<&'static str>,
    /// The type of points.
    pub point: &'static str,
    /// Whether a file ends with `WorldEnd`: v3 needs it, v4 refuses it.
    pub world_end: bool,
    /// Diffuse material: type, parameter, further parameters.
    pub diffuse: (&'static str, &'static str, &'static str),
    /// Conductor.
    pub conductor: &'static str,
    /// Dielectric: type and further parameters.
    pub dielectric: (&'static str, &'static str),
    /// Mirror: type, parameter, further parameters. v4 has none; a conductor of given reflectance comes near.
    pub mirror: (&'static str, &'static str, &'static str),
    /// Switches off the reading of `roughness` as a number that is mapped to alpha first.
    pub plain_roughness: &'static str,
}

static V3: Names = Names {
    film: ("image", "pfm", ""),
    filter_radius: ("xwidth", "ywidth"),
    sampler: "random",
    bidirectional: " \"string lightsamplestrategy\" [\"power\"]",
    metropolis: "",
    light_tracing: None,
    passes: Some("iterations"),
    point: "point",
    world_end: true,
    diffuse: ("matte", "Kd", " \"float sigma\" [0]"),
    conductor: "metal",
    dielectric: ("glass", " \"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1]"),
    mirror: ("mirror", "Kr", ""),
    plain_roughness: "\"bool remaproughness\" [\"false\"]",
};

static V4: Names = Names {
    film: ("rgb", "exr", " \"bool savefp16\" [false]"),
    filter_radius: ("xradius", "yradius"),
    sampler: "independent",
    bidirectional: " \"bool regularize\" [false]",
    metropolis: " \"bool regularize\" [false]",
    light_tracing: Some("lightpath"),
    passes: None,
    point: "point3",
    world_end: false,
    diffuse: ("diffuse", "reflectance", ""),
    conductor: "conductor",
    dielectric: ("dielectric", ""),
    mirror: ("conductor", "reflectance", " \"float roughness\" [0]"),
    plain_roughness: "\"bool remaproughness\" [false]",
};

/// `thickness` of v4's coats. The layer between coat and base, 0.01 by default, absorbs exp(-thickness / cosine) of the light even
/// where there is no medium in it: a base of 0.5 has 0.3045 head-on, with 0 it has 0.3160 (measured). pbrt-v4 takes 0 for the
/// least positive number (`LayeredBxDF`); its port pbrt-r4 does not, and gives 0.2592.
pub const THICKNESS: f64 = 1e-6;

/// The edge of a spot in degrees below which v4's light samplers `bvh` and `exhaustive` take it for black, by its bound
/// `cosTheta_e` (`SpotLight::Bounds`, whose cosine has 15 bits): measured with 0 and 0.02 degrees; from 0.1 on it has room.
const SHARPEST: f64 = 0.1;

/// `Integrator "path"`: parameters beside the depth, among them how it chooses a light.
///
/// v3's default, "spatial", does not end with a hundred thousand emitting triangles (measured with rs_pbrt 0.9.12 and
/// pbrt-v3). v4's default is written out, but where a spot is sharp: `power` lights that as it should (measured), and knows all
/// lights, environments among them, at the price of noise where many lights are far away. It weighs them at four wavelengths,
/// where a spectrum may be 0; `uniform` looks at nothing.
pub fn path(version: Version, scene: &Scene) -> String {
    let sampler = match version {
        Version::V3 => return " \"float rrthreshold\" [1] \"string lightsamplestrategy\" [\"power\"]".to_owned(),
        Version::V4 if !scene.lights.values().any(|light| sharp(&light.kind)) => "bvh",
        Version::V4 if spectra(scene) => "uniform",
        Version::V4 => "power",
    };
    format!(" \"string lightsampler\" [\"{sampler}\"] \"bool regularize\" [false]")
}

fn sharp(kind: &LightKind) -> bool {
    matches!(kind, LightKind::Spot { position: _, target: _, intensity: _, angle, inner } if angle - inner < SHARPEST)
}

/// Whether any light has a spectrum of its own.
fn spectra(scene: &Scene) -> bool {
    let shapes = scene.shapes.values().chain(scene.groups.values().flat_map(|group| group.shapes.values()));
    let surfaces = shapes.filter_map(|shape| shape.emission.as_ref()).map(|emission| &emission.radiance);
    let others = scene.lights.values().map(|light| light.kind.color());
    surfaces.chain(others).any(|color| color.spectrum().is_some())
}

/// What a version does with an image: v3 reads PNG, OpenEXR and PFM (`ReadImage` of `imageio.cpp`; TGA beside them); v4 all formats,
/// takes JPEG as sRGB whatever the file says (`Image::Read` of `image.cpp`), and an environment as an octahedron.
pub fn images(version: Version, texture: &Texture, purpose: Use) -> Form {
    match (version, purpose, texture.image.format) {
        (Version::V4, Use::Sky(tint), _) => Form::Octahedral(images::split(tint).1),
        // Both have a word for a factor, a number or a color by the version; in the image it is the same for all.
        (_, Use::Surface, _) if texture.is_scaled() => Form::Tinted(texture.factor),
        // pbrt-v4 reads these two, v3 the first with 8 bits. The ports pbrt-r4 and pbrt-r3 refuse PNG of 16 bits, and r4 takes Radiance
        // HDR for codes of sRGB (4.5.2, 3.2.0).
        (_, _, ImageFormat::Png) if texture.image.bits > 8 => Form::Tinted([1.0; 3]),
        (_, _, ImageFormat::Hdr) => Form::Pfm,
        (_, _, ImageFormat::Png | ImageFormat::Exr | ImageFormat::Pfm) => Form::Shared,
        (Version::V4, _, ImageFormat::Jpeg) if texture.encoding == Encoding::Srgb => Form::Shared,
        (_, _, ImageFormat::Jpeg) => Form::Png,
    }
}

/// The same for v3.
pub fn images_v3(texture: &Texture, purpose: Use) -> Form {
    images(Version::V3, texture, purpose)
}

/// The same for v4.
pub fn images_v4(texture: &Texture, purpose: Use) -> Form {
    images(Version::V4, texture, purpose)
}

/// `Texture "imagemap"`: how pixels are decoded, and looked up between their middles. v3's default averages over an
/// ellipse of at least a pixel of the image, which is no line between two pixels (0.061 where 0.125 is due, pbrt-r3 3.2.0 and rs_pbrt
/// 0.9.12); its pyramid is one where the image is magnified. v4's default is written out.
pub fn lookup(version: Version, texture: &Texture) -> &'static str {
    match (version, images(version, texture, Use::Surface).encoding(texture)) {
        (Version::V3, Encoding::Srgb) => "\"bool gamma\" [\"true\"] \"bool trilinear\" [\"true\"]",
        (Version::V3, Encoding::Linear) => "\"bool gamma\" [\"false\"] \"bool trilinear\" [\"true\"]",
        (Version::V4, Encoding::Srgb) => "\"string encoding\" [\"sRGB\"] \"string filter\" [\"bilinear\"]",
        (Version::V4, Encoding::Linear) => "\"string encoding\" [\"linear\"] \"string filter\" [\"bilinear\"]",
    }
}

/// The samples of a v4 spectrum: beyond the first and the last it is 0 (`PiecewiseLinearSpectrum`), so that constant ends are
/// written out. It looks at 360 to 830 nm.
pub fn samples(points: &[(f64, f64)]) -> Vec<[f64; 2]> {
    let ends = |place: f64| move |point: &(f64, f64)| [place, point.1];
    let first = points.first().filter(|point| point.0 > 360.0).map(ends(360.0));
    let last = points.last().filter(|point| point.0 < 830.0).map(ends(830.0));
    first.into_iter().chain(points.iter().map(|(wavelength, value)| [*wavelength, *value])).chain(last).collect()
}

/// From v3's directions of an environment to the Scene's: its z is up, its -x lies in the middle of the image, and its -y a quarter to
/// the right of that (`InfiniteAreaLight::Le`; LuxCore has the same formula, and was measured).
pub const ENVIRONMENT: Affine = Affine { rows: [[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

/// The angle that both versions call `fov`: the full angle along the image's shorter axis (pbrt-v3 and pbrt-v4,
/// `PerspectiveCamera`: the shorter axis of the default screen window spans -1..1).
pub fn fov(fov_x: f64, film: &Film) -> f64 {
    let Film { width, height, filter: _ } = film;
    if width > height { camera::fov_y(fov_x, film) } else { fov_x }
}

/// `maxdepth` counts bounces: one less than the Scene's segments. So do all integrators: `bdpt` and `mlt` join subpaths of s
/// and t vertices, s + t - 1 segments, with a depth of s + t - 2 (`bdpt.cpp`, `mlt.cpp`; `integrators.cpp` of v4); v4's
/// `lightpath` connects `maxdepth` surfaces to the camera. `sppm` bounds the path from the camera and the photon's path
/// each by itself; with a diffuse surface in front of the camera the sum is that of the others.
pub fn max_depth(segments: u32) -> u32 {
    segments.saturating_sub(1)
}

/// The depth of `sppm`: with 0 it renders nothing, with 1 emission and direct light (`sppm.cpp`).
pub fn photon_depth(segments: u32) -> u32 {
    max_depth(segments).max(1)
}

/// v3's Gaussian is `exp(-alpha x^2) - exp(-alpha r^2)`, alpha = 1 / (2 stddev^2); v4 takes the standard deviation.
pub fn gaussian_alpha(stddev: f64) -> f64 {
    1.0 / (2.0 * stddev * stddev)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Filter;

    #[test]
    fn the_angle_is_along_the_shorter_axis() {
        let film = |width, height| Film { width, height, filter: Filter::Box { radius: 0.5 } };
        // 2:1: 2 atan(tan(45) / 2); at 1:1 and 1:2 the width is the shorter axis, or as long.
        assert!((fov(90.0, &film(200, 100)) - 53.130_102_354).abs() < 1e-8);
        assert_eq!(fov(90.0, &film(100, 100)), 90.0);
        assert_eq!(fov(90.0, &film(100, 200)), 90.0);
    }

    #[test]
    fn depth_and_gaussian() {
        assert_eq!((max_depth(10), max_depth(1), max_depth(0)), (9, 0, 0));
        assert_eq!(gaussian_alpha(0.5), 2.0);
    }
}
