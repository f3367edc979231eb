//! Triangle meshes.

use std::sync::Arc;

/// A triangle mesh. Cheap to clone: the arrays are shared.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// As the author wrote it; need not be a word, need not be unique.
    pub name: String,
    /// Vertex positions in scene units, finite.
    pub positions: Arc<Vec<[f32; 3]>>,
    /// A unit normal for each position; none where a file had none. Both the shading normal and the side on which an
    /// emitter emits.
    pub normals: Option<Arc<Vec<[f32; 3]>>>,
    /// Texture coordinates for each position, if any; v grows upwards in the image.
    pub uvs: Option<Arc<Vec<[f32; 2]>>>,
    /// Indices into `positions`, counter-clockwise seen from the side of the normal.
    pub triangles: Arc<Vec<[u32; 3]>>,
}

impl Mesh {
    /// The corners of a triangle in double precision.
    pub fn corners(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|index| self.positions[index as usize].map(f64::from))
    }
}
