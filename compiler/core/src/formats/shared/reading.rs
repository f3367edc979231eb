//! What the files of a target say, read from their text: the first part of an importer, in the Scene's units.
//!
//! A reading is nearer to the file than a Scene: a material is what the file's parameters mean, not what the author may have
//! asked for, meshes are named and not read, and nothing is filled in that the file leaves open.

use crate::diag::Finding;
use crate::files::VPath;
use crate::ir::{Affine, Filter, ImageFile, Vec3};
use crate::mesh::Geometry;

/// Linear red, green and blue.
pub type Rgb = [f64; 3];

/// What the files of one folder say. Whatever was not understood is among the findings.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Width and height in pixels.
    pub film: Option<[u32; 2]>,
    /// The reconstruction filter as the parameters mean it; none where the format has no word for it.
    pub filter: Option<Filter>,
    /// Segments of a path, the camera's and the light's included.
    pub max_depth: Option<u32>,
    /// The largest count that the format can say, of segments and of samples; none where it can say all.
    pub most: Option<u32>,
    /// Samples and seed.
    pub sampling: Sampling,
    /// The algorithm, by the word of the language; none where the format has no choice.
    pub algorithm: Option<&'static str>,
    /// The algorithm as the target calls it; none where it has no choice, or does not say.
    pub native: Option<String>,
    /// What of the settings was given by statements of a test case.
    pub replaced: Replaced,
    /// The largest value that a sample may have; none where there is no limit, and no number where it is not understood.
    pub clamped: Option<f64>,
    /// Which part of the image is rendered.
    pub part: Part,
    /// Photon mapping: the first radius, and the photons of a pass.
    pub photons: (Option<f64>, Option<i64>),
    /// Algorithm and filter of a format that notes them only: they are the scene's own, whatever the target can do.
    pub noted: Option<Filter>,
    /// Clipping distances; none of a format that has none.
    pub clip: Option<Clip>,
    /// The file in which camera and film stand; none for the main file.
    pub settings: Option<VPath>,
    /// The file in which the surfaces stand; none for the main file.
    pub description: Option<VPath>,
    /// The camera.
    pub view: Option<View>,
    /// Materials, in the order of the file. Which surface has which says [`Use`].
    pub materials: Vec<Surface>,
    /// Meshes, each once.
    pub meshes: Vec<MeshSource>,
    /// What instances place: shapes in coordinates of their own.
    pub groups: Vec<Vec<Use>>,
    /// Shapes and instances in the order of the file.
    pub items: Vec<Item>,
    /// Whether uses of one mesh stand together, with places in single precision, and in another order than they were made in; their
    /// names say which is which.
    pub gathered: bool,
    /// Whether the format holds colors of surfaces to 0..1, so that a brighter one is written as 1.
    pub capped: bool,
    /// Lights without a surface in the order of the file.
    pub lights: Vec<Light>,
    /// What was not understood, with its place.
    pub findings: Vec<Finding>,
}

/// Settings that were given by statements of a test case, and are not those of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Replaced {
    /// Algorithm and path depth.
    pub integrator: bool,
    /// Samples and seed.
    pub sampler: bool,
    /// The reconstruction filter.
    pub filter: bool,
    /// Where the camera is and what it sees.
    pub camera: bool,
}

/// The part of an image that is rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// A rectangle.
    Rectangle {
        /// Its left and upper edge, its width and height in pixels.
        area: [u32; 4],
        /// Whether the image that is written has only these pixels; else the rest is black.
        cut: bool,
    },
    /// What the files say was not understood.
    Unknown,
}

/// What a format makes of a seed.
pub type OfSeed = fn(u32) -> i64;

/// How a format's files sample.
#[derive(Clone, Debug, Default)]
pub struct Sampling {
    /// Samples of a pixel, wherever they are said; none where it is not.
    pub samples: Vec<i64>,
    /// Mutations or passes that a given algorithm counts beside the sampler's samples.
    pub passes: Option<i64>,
    /// The seed with what the format makes of the Scene's; none where it has none.
    pub seed: Option<(i64, OfSeed)>,
    /// Whether points are those of a Sobol sequence; none where there is no choice.
    pub sobol: Option<bool>,
}

/// Clipping distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Of the front.
    pub near: Option<f64>,
    /// Of the back.
    pub far: Option<f64>,
    /// What the program takes where they are left out; none where the front must be said, and what is left out of the back is infinity.
    pub default: Option<(f64, f64)>,
}

/// A pinhole camera as the image shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position.
    pub eye: Vec3,
    /// To the right of the image, a unit vector.
    pub right: Vec3,
    /// To the top of the image, a unit vector.
    pub up: Vec3,
    /// Along the optical axis, a unit vector.
    pub forward: Vec3,
    /// Full angle along the image's width in degrees.
    pub fov_x: f64,
    /// Full angle along the image's height in degrees.
    pub fov_y: f64,
    /// How far the optical axis meets the image from its middle, to the right and up, in pixels.
    pub shift: [f64; 2],
}

impl View {
    /// The camera that the rows of a map from scene to camera coordinates say: x to the right, y up, z along the axis.
    pub fn of_rows(map: &Affine, fov_x: f64, fov_y: f64) -> Option<Self> {
        let rows = map.rows.map(|row| [row[0], row[1], row[2]]);
        // A map that stretches one axis would show another image.
        let sizes = rows.map(crate::ir::length);
        if sizes.iter().any(|size| (size - sizes[2]).abs() > 1e-9 * sizes[2]) {
            return None;
        }
        let [right, up, forward] = rows.map(crate::ir::normalized);
        let eye = inverse(map)?.point([0.0; 3]);
        Some(Self { eye, right: right?, up: up?, forward: forward?, fov_x, fov_y, shift: [0.0; 2] })
    }
}

/// The inverse of a map; none where it has none.
pub fn inverse(map: &Affine) -> Option<Affine> {
    if !map.is_invertible() {
        return None;
    }
    // The inverse is the transpose of the cofactors over the determinant.
    let (cofactors, size) = (map.cofactors(), map.determinant());
    let linear = [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactors[column][row] / size));
    let offset = map.rows.map(|row| row[3]);
    let rows = linear.map(|row| [row[0], row[1], row[2], -crate::ir::dot(row, offset)]);
    Some(Affine { rows })
}

/// How an image of the environment is turned that a format places by `map`, when `still` is what it writes for one that is not turned.
pub fn turned(still: &Affine, map: &Affine) -> Affine {
    inverse(still).unwrap_or(Affine::IDENTITY).then(map)
}

/// A material.
#[derive(Clone, Debug)]
pub struct Surface {
    /// As the file calls it.
    pub name: String,
    /// How it scatters.
    pub model: Model,
    /// Whether it scatters on both sides alike; a dielectric has two different ones.
    pub two_sided: bool,
}

/// How a surface scatters, by what the parameters of the format mean.
#[derive(Clone, Debug)]
pub enum Model {
    /// Lambertian reflection.
    Diffuse {
        /// Share of light reflected.
        reflectance: Paint,
    },
    /// GGX microfacets, or a mirror where alpha is 0.
    Conductor {
        /// How the reflectance depends on the angle.
        fresnel: Fresnel,
        /// A factor of it.
        tint: Paint,
        /// GGX width.
        alpha: f64,
    },
    /// Reflects and refracts.
    Dielectric {
        /// Index of refraction behind the normals, relative to that in front.
        eta: f64,
        /// GGX width.
        alpha: f64,
    },
    /// A Lambertian base under a clear coat.
    Coated {
        /// The base, or what is seen of it.
        base: Paint,
        /// Which of the two.
        inside: Inside,
        /// Index of refraction of the coat against vacuum.
        ior: f64,
        /// GGX width of the coat.
        alpha: f64,
    },
    /// A blend of a coated base and a metal.
    Principled {
        /// What is seen of the base, and of the metal head-on.
        base: Paint,
        /// Share of the metal.
        metallic: f64,
        /// GGX width.
        alpha: f64,
        /// Reflectance of the coat head-on.
        specular: f64,
        /// The largest that the format can say of it.
        ceiling: f64,
    },
    /// One of two, by chance.
    Mix {
        /// Share of the second, 0..1.
        share: f64,
        /// The two.
        parts: Box<[Model; 2]>,
    },
}

impl Model {
    /// How many models it is made of, itself included.
    pub fn size(&self) -> usize {
        match self {
            Self::Diffuse { reflectance: _ }
            | Self::Conductor { fresnel: _, tint: _, alpha: _ }
            | Self::Dielectric { eta: _, alpha: _ }
            | Self::Coated { base: _, inside: _, ior: _, alpha: _ }
            | Self::Principled { base: _, metallic: _, alpha: _, specular: _, ceiling: _ } => 1,
            Self::Mix { share: _, parts } => parts.iter().map(Self::size).sum::<usize>() + 1,
        }
    }
}

/// The most models that a mix may be made of: readers refuse more.
pub const MIX_LIMIT: usize = 32;

/// What the base of a coat means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// The base itself: light that the coat throws back meets it again.
    Base,
    /// What is seen of it.
    Seen,
}

/// How the reflectance of a metal depends on the angle.
#[derive(Clone, Copy, Debug)]
pub enum Fresnel {
    /// The exact term of a complex index of refraction.
    Exact {
        /// Real part.
        eta: Rgb,
        /// Imaginary part.
        k: Rgb,
    },
    /// A term of the program's own, with numbers that were fitted to the exact one.
    Fitted {
        /// Index of refraction.
        n: Rgb,
        /// Extinction.
        k: Rgb,
        /// What the program computes for `n`, `k` and the cosine of the angle of incidence.
        term: fn(f64, f64, f64) -> f64,
        /// How far the best fit is from the exact term of this real and imaginary part at most, up to 85 degrees.
        most: fn(f64, f64) -> f64,
    },
    /// The tint head-on, and towards grazing what the program makes of it.
    HeadOn,
    /// None: the tint at every angle.
    Constant,
}

/// A color, or an image.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// The same everywhere.
    Color(Rgb),
    /// By the surface's texture coordinates; (0, 0) is the lower left corner of the image.
    Image {
        /// The image.
        file: Picture,
        /// Whether its numbers are linear; else they are decoded by the sRGB curve.
        linear: bool,
        /// A factor of what is decoded.
        factor: Rgb,
    },
}

/// Where an image is.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// In a file of its own.
    File(VPath),
    /// In the file itself.
    Here(ImageFile),
}

impl From<VPath> for Picture {
    fn from(path: VPath) -> Self {
        Self::File(path)
    }
}

impl Paint {
    /// White.
    pub const WHITE: Self = Self::Color([1.0; 3]);
    /// Black.
    pub const BLACK: Self = Self::Color([0.0; 3]);

    /// The same times `by`.
    #[must_use]
    pub fn scaled(self, by: Rgb) -> Self {
        let times = |a: Rgb| [a[0] * by[0], a[1] * by[1], a[2] * by[2]];
        match self {
            Self::Color(color) => Self::Color(times(color)),
            Self::Image { file, linear, factor } => Self::Image { file, linear, factor: times(factor) },
        }
    }
}

/// Where a mesh is.
#[derive(Clone, Debug)]
pub struct MeshSource {
    /// Its place.
    pub place: MeshPlace,
    /// Which side of it is the front.
    pub front: Front,
    /// Whether faces stay flat whatever normals the mesh has; none where the mesh decides: by its normals, flat without them.
    pub flat: Option<bool>,
}

/// Where the numbers of a mesh are.
#[derive(Clone, Debug)]
pub enum MeshPlace {
    /// In a mesh file.
    File(VPath),
    /// In the file itself.
    Here(Geometry),
}

/// What decides on which side a triangle emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Front {
    /// The side from which the corners run counter-clockwise.
    Winding,
    /// The side of the normals at the corners, where the mesh has some; else the winding.
    Normals,
}

/// A mesh with a material at its place.
#[derive(Clone, Debug)]
pub struct Use {
    /// As the file calls it; may be empty.
    pub name: String,
    /// Index into [`Reading::meshes`].
    pub mesh: usize,
    /// Index into [`Reading::materials`].
    pub material: usize,
    /// From the mesh's coordinates to those of what holds it.
    pub transform: Affine,
    /// What it emits.
    pub emission: Option<Emitted>,
}

/// Diffuse emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitted {
    /// Radiance in W/(m2 sr).
    pub radiance: Rgb,
    /// On both sides; else on the front.
    pub both_sides: bool,
    /// Whether the front is turned over.
    pub reversed: bool,
}

/// Something that is placed.
#[derive(Clone, Debug)]
pub enum Item {
    /// A shape.
    Shape(Use),
    /// A group at its place.
    Instance {
        /// As the file calls it; may be empty.
        name: String,
        /// Index into [`Reading::groups`].
        group: usize,
        /// From the group's coordinates to the scene's.
        transform: Affine,
    },
}

/// A light without a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// From everywhere.
    Environment {
        /// Radiance.
        radiance: Paint,
        /// From the directions of an image as the Scene has them to those in which it is seen.
        turn: Affine,
    },
    /// From a point into all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Intensity in W/sr.
        intensity: Rgb,
    },
    /// From a point into a cone.
    Spot {
        /// Where it is.
        position: Vec3,
        /// The axis, a unit vector.
        direction: Vec3,
        /// Intensity in W/sr on the axis.
        intensity: Rgb,
        /// Half of the cone's opening in degrees.
        angle: f64,
        /// Half of the opening of full intensity in degrees.
        inner: f64,
    },
    /// From one direction.
    Directional {
        /// Where the light travels to, a unit vector.
        direction: Vec3,
        /// Irradiance across it.
        irradiance: Rgb,
    },
}

impl Light {
    /// The constructor of the language for such a light.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Environment { radiance: _, turn: _ } => "environment",
            Self::Point { position: _, intensity: _ } => "point",
            Self::Spot { position: _, direction: _, intensity: _, angle: _, inner: _ } => "spot",
            Self::Directional { direction: _, irradiance: _ } => "directional",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_inverted() {
        let map = Affine::scaling([1.0, 2.0, 3.0])
            .then(&Affine::rotation([0.0, 0.0, 1.0], 30.0))
            .then(&Affine::translation([4.0, 5.0, 6.0]));
        let back = inverse(&map).expect("a map that has an inverse");
        let there = back.point(map.point([1.0, -2.0, 7.0]));
        assert!(there.iter().zip([1.0, -2.0, 7.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{there:?}");
        assert!(inverse(&Affine::scaling([1.0, 0.0, 1.0])).is_none());
    }
}
