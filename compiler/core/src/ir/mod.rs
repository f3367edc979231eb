//! The Scene in the middle: front ends make it, back ends read it, lint judges it. It knows no file format.
//!
//! One meaning of every number:
//!
//! | quantity | meaning |
//! |---|---|
//! | coordinates | right-handed, z up, lengths in scene units; positions `f32`, everything else `f64` |
//! | angles | degrees, because every text target spells degrees |
//! | colours | linear, sRGB (Rec. 709) primaries, D65 white |
//! | radiance | W/(m2 sr), leaving the surface on the side of its normals |
//! | `alpha` | the width of the GGX distribution (not its root, not its square) |
//! | index of refraction | relative to vacuum; inside is behind the normals |
//! | field of view | full angle along the image's width |
//! | `max_depth` | segments of a path, the camera's and the light's included; 1 is emission seen directly |
//! | triangles | indices from 0; counter-clockwise seen from the side of the normal |
//! | images | row 0 on top |
//!
//! What is no longer in it: defaults, expressions, includes, relative paths, names of formats, units, several spellings
//! of one thing. Handles point backwards in [`Arena`]s, so that emitters need one pass.

mod affine;
mod arena;
mod camera;
mod color;
mod doc;
mod material;
mod mesh;
mod settings;
mod shape;

pub(crate) use affine::sin_cos_degrees;
pub use affine::{Affine, Vec3, cross, dot, length, normalized, sub};
pub use arena::{Arena, Handle};
pub use camera::Camera;
pub use color::Color;
pub use doc::{Documentation, Similar};
pub use material::{Bsdf, Material};
pub use mesh::Mesh;
pub use settings::{Film, Filter, Integrator, Sampler};
pub use shape::{Emission, Shape};

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
    /// Materials.
    pub materials: Arena<Material>,
    /// Surfaces and emitters: a mesh, where it lies, what it is made of.
    pub shapes: Arena<Shape>,
    /// At least one after validation; the first is the default.
    pub cameras: Arena<Camera>,
    /// Resolution and reconstruction filter.
    pub film: Film,
    /// Default light transport algorithm.
    pub integrator: Integrator,
    /// Default sampling.
    pub sampler: Sampler,
}
