//! The Scene in the middle: front ends make it, back ends read it, lint judges it. It knows no file format.
//!
//! One meaning of every number:
//!
//! | quantity | meaning |
//! |---|---|
//! | coordinates | right-handed, z up, lengths in scene units; positions `f32`, everything else `f64` |
//! | angles | degrees, because every text target spells degrees |
//! | colors | linear, sRGB (Rec. 709) primaries, D65 white; or values at wavelengths in nanometers |
//! | radiance | W/(m2 sr), leaving the surface on the side of its normals |
//! | intensity | W/sr, of a point light |
//! | irradiance | W/m2, of directional light on a surface across its direction |
//! | `alpha` | the width of the GGX distribution (not its root, not its square) |
//! | index of refraction | relative to vacuum; inside is behind the normals |
//! | field of view | full angle along the image's width |
//! | `max_depth` | segments of a path, the camera's and the light's included; 1 is emission seen directly |
//! | triangles | indices from 0; counter-clockwise seen from the side of the normal |
//! | images | row 0 on top |
//! | texture coordinates | (0, 0) is the lower left corner of the image, (1, 1) the upper right one |
//!
//! What is no longer in it: defaults, expressions, includes, relative paths, names of formats, units, several spellings
//! of one thing. Handles point backwards in [`Arena`]s, so that emitters need one pass.

mod affine;
mod arena;
mod camera;
mod cie;
mod color;
mod degrees;
mod doc;
mod group;
mod light;
mod light_paths;
mod material;
mod mesh;
mod settings;
mod shape;
mod spectrum;
mod suite;
mod texture;

pub use affine::{Affine, Vec3, cross, dot, length, normalized, sub};
pub use arena::{Arena, Handle};
pub use camera::{Axes, Camera};
pub use color::Color;
pub(crate) use degrees::{cosines_degrees, sin_cos_degrees, sines_degrees};
pub use doc::{Documentation, ParameterValue, Similar};
pub use group::{GROUP_DEPTH, Group, INSTANCE_LIMIT, Instance, Places};
pub use light::{LightKind, LightSource};
pub use light_paths::{LightExtent, LightPathError, LightPaths};
pub use material::{Bsdf, Material, Sides};
pub use mesh::Mesh;
pub use settings::{Film, Filter, Integrator, Sampler};
pub use shape::{Emission, Shape};
pub use spectrum::{Meaning, Spectrum};
pub use suite::Scenes;
pub use texture::{ColorOrTexture, Encoding, ImageFile, ImageFormat, ImageInfo, Texture};

use crate::diag::Origin;

/// A whole scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// A word (`[A-Za-z_][A-Za-z0-9_]*`) or what an importer found.
    pub name: String,
    /// Where the scene is declared.
    pub origin: Origin,
    /// What it is for.
    pub documentation: Documentation,
    /// Triangle meshes.
    pub meshes: Arena<Mesh>,
    /// Image files that color surfaces.
    pub textures: Arena<Texture>,
    /// Materials.
    pub materials: Arena<Material>,
    /// Surfaces and emitters: a mesh, where it lies, what it is made of.
    pub shapes: Arena<Shape>,
    /// Lights without a surface; those of groups are here too, once for each place.
    pub lights: Arena<LightSource>,
    /// Shapes to be placed by instances; a group stands behind those that it holds.
    pub groups: Arena<Group>,
    /// Groups at their places, each at one or at many.
    pub instances: Arena<Instance>,
    /// At least one after validation; the first is the default.
    pub cameras: Arena<Camera>,
    /// Resolution and reconstruction filter.
    pub film: Film,
    /// Default light transport algorithm.
    pub integrator: Integrator,
    /// Default sampling.
    pub sampler: Sampler,
}

impl Scene {
    /// All shapes and emitters with their origins: those of the scene, then those of each group once.
    pub fn surfaces(&self) -> impl Iterator<Item = (&Origin, &Shape)> {
        let groups = self.groups.values().flat_map(|group| group.shapes.entries());
        self.shapes.entries().chain(groups)
    }

    /// The same, to be changed.
    pub fn surfaces_mut(&mut self) -> impl Iterator<Item = &mut Shape> {
        let groups = self.groups.iter_mut().flat_map(|(_, group)| group.shapes.iter_mut());
        self.shapes.iter_mut().chain(groups).map(|(_, shape)| shape)
    }
}
