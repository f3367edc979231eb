//! Generators and mesh arithmetic, and mesh files.

use std::sync::Arc;

use crate::ir::Mesh;

/// A triangle mesh in the making; the arrays mean what they mean in [`Mesh`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Vertex positions in scene units.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one for each position.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates, one for each position.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Indices into `positions`, counter-clockwise seen from the side of the normal.
    pub triangles: Vec<[u32; 3]>,
}

impl Geometry {
    /// The finished mesh.
    pub fn into_mesh(self, name: impl Into<String>) -> Mesh {
        Mesh {
            name: name.into(),
            positions: Arc::new(self.positions),
            normals: self.normals.map(Arc::new),
            uvs: self.uvs.map(Arc::new),
            triangles: Arc::new(self.triangles),
        }
    }
}
