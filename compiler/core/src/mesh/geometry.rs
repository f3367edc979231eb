//! A triangle mesh in the making.

use std::sync::Arc;

use super::{MeshError, is_unit};
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

    /// A copy of the mesh, to be changed.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
        Self {
            positions: positions.to_vec(),
            normals: normals.as_ref().map(|normals| normals.to_vec()),
            uvs: uvs.as_ref().map(|uvs| uvs.to_vec()),
            triangles: triangles.to_vec(),
        }
    }

    /// Whether the arrays belong together: indices in range, arrays of one length, positions and uvs finite, normals of
    /// unit length. Everything that makes a geometry gives one that passes.
    ///
    /// # Errors
    /// The first fault found, with its place in the array.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_indices()?;
        if let Some(at) = self.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(MeshError::new("", format!("position {at} is not finite")));
        }
        if let Some(at) = self.uvs.iter().flatten().position(|uv| !uv.iter().all(|x| x.is_finite())) {
            return Err(MeshError::new("", format!("texture coordinate {at} is not finite")));
        }
        if let Some(at) = self.normals.iter().flatten().position(|normal| !is_unit(*normal)) {
            return Err(MeshError::new("", format!("normal {at} is not of unit length")));
        }
        Ok(())
    }

    /// The part of [`Geometry::check`] that keeps later stages from reading outside an array.
    pub(crate) fn check_indices(&self) -> Result<(), MeshError> {
        let count = self.positions.len();
        let lengths = [self.normals.as_ref().map(Vec::len), self.uvs.as_ref().map(Vec::len)];
        for (name, length) in ["normals", "texture coordinates"].into_iter().zip(lengths) {
            if let Some(length) = length.filter(|length| *length != count) {
                return Err(MeshError::new("", format!("the mesh has {count} positions but {length} {name}")));
            }
        }
        let outside = |triangle: &[u32; 3]| triangle.iter().any(|index| *index as usize >= count);
        if let Some(at) = self.triangles.iter().position(outside) {
            let [a, b, c] = self.triangles[at];
            let message = format!("triangle {at} uses the vertices {a}, {b}, {c}, but the mesh has {count} vertices");
            return Err(MeshError::new("", message));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_names_the_first_fault() {
        let good = Geometry {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 3]),
            uvs: None,
            triangles: vec![[0, 1, 2]],
        };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(Geometry::from_mesh(&good.clone().into_mesh("m")), good);
        let fault = |change: &dyn Fn(&mut Geometry)| {
            let mut bad = good.clone();
            change(&mut bad);
            bad.check().map_err(|error| error.message).expect_err("the geometry is broken")
        };
        assert!(fault(&|g| g.triangles.push([0, 1, 3])).starts_with("triangle 1 uses"));
        assert!(fault(&|g| g.normals = Some(vec![])).contains("3 positions but 0 normals"));
        assert!(fault(&|g| g.uvs = Some(vec![[f32::NAN, 0.0]; 3])).contains("texture coordinate 0"));
        assert!(fault(&|g| g.positions[2][1] = f32::INFINITY).contains("position 2"));
        assert!(fault(&|g| g.normals = Some(vec![[0.0, 0.0, 0.99]; 3])).contains("normal 0"));
    }
}
