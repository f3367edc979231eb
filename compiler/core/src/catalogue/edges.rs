//! The edges of a mesh that a line drawing shows.

use std::collections::BTreeMap;

use crate::ir::{Affine, Mesh, Vec3, cross, dot, normalized, sub};

/// Meshes with more triangles are drawn as their boxes.
pub(super) const LIMIT: usize = 400_000;

/// Faces that meet at a smaller angle are one surface: the cosine of 25 degrees.
const CREASE: f64 = 0.906_307_787_036_65;

/// An edge with the normals of its faces; one face is a border.
pub(super) struct Edge {
    ends: [Vec3; 2],
    faces: (Vec3, Option<Vec3>),
}

/// The edges of a mesh, those between faces of one plane left out. Vertices at one place are one.
pub(super) fn edges(mesh: &Mesh) -> Vec<Edge> {
    let key = |index: u32| mesh.positions.get(index as usize).map(|place| place.map(|x| (x + 0.0).to_bits()));
    let mut found: BTreeMap<[[u32; 3]; 2], Edge> = BTreeMap::new();
    let mut many: Vec<[[u32; 3]; 2]> = Vec::new();
    for triangle in mesh.triangles.iter() {
        let [Some(a), Some(b), Some(c)] = triangle.map(key) else { continue };
        let corners = mesh.corners(*triangle);
        let normal = normalized(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])));
        let Some(normal) = normal else { continue };
        for (from, to, ends) in [(a, b, [0, 1]), (b, c, [1, 2]), (c, a, [2, 0])] {
            let key = if from < to { [from, to] } else { [to, from] };
            match found.get_mut(&key) {
                None => {
                    found.insert(key, Edge { ends: ends.map(|at: usize| corners[at]), faces: (normal, None) });
                }
                Some(edge) if edge.faces.1.is_none() => edge.faces.1 = Some(normal),
                Some(_) => many.push(key),
            }
        }
    }
    // Where three faces meet, the edge shows in any case.
    for key in many {
        if let Some(edge) = found.get_mut(&key) {
            edge.faces.1 = None;
        }
    }
    let flat = |edge: &Edge| edge.faces.1.is_some_and(|other| dot(edge.faces.0, other) > 1.0 - 1e-9);
    found.into_values().filter(|edge| !flat(edge)).collect()
}

impl Edge {
    /// The edge in the scene, if a drawing seen along `direction` shows it: a border, a crease, or an outline.
    pub(super) fn seen(&self, map: &Affine, normals: &[[f64; 3]; 3], direction: Vec3) -> Option<[Vec3; 2]> {
        let turned = |n: Vec3| [0, 1, 2].map(|row: usize| dot(normals[row], n));
        let shown = match self.faces {
            (_, None) => true,
            (first, Some(second)) => {
                let (a, b) = (turned(first), turned(second));
                let outline = dot(a, direction) * dot(b, direction) < 0.0;
                outline || normalized(a).zip(normalized(b)).is_none_or(|(a, b)| dot(a, b) < CREASE)
            }
        };
        shown.then(|| self.ends.map(|end| map.point(end)))
    }
}
