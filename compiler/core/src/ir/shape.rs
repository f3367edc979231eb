//! Shapes: a mesh at its place, with a material and perhaps an emission.

use super::{Affine, Color, Handle, Material, Mesh};

/// A surface of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// As the author wrote it; need not be a word. Unique among the shapes, and among the emitters, of what holds it.
    pub name: String,
    /// The mesh, in its own coordinates.
    pub mesh: Handle<Mesh>,
    /// From the mesh's coordinates to the scene's, or the group's; invertible and not mirroring (a mirroring one is baked into the
    /// mesh with its winding turned).
    pub transform: Affine,
    /// How it scatters light.
    pub material: Handle<Material>,
    /// What it emits; none for a surface that is no emitter.
    pub emission: Option<Emission>,
}

/// Diffuse emission, the same over the whole surface, on the side of the normals only.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    /// Radiance in W/(m2 sr), >= 0 per channel.
    pub radiance: Color,
}
