//! What a mesh measures: area, volume, bounds, whether it is closed, how far its normals lean from its faces.

use super::Geometry;
use super::smooth::position_ids;
use crate::ir::{Mesh, Vec3, cross, dot, length, normalized, sub};

/// A mesh or a geometry, borrowed. Triangles that use a vertex that is not there are passed over.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Normals, one for each position.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Indices into `positions`.
    pub triangles: &'a [[u32; 3]],
}

impl<'a> From<&'a Geometry> for View<'a> {
    fn from(geometry: &'a Geometry) -> Self {
        let Geometry { positions, normals, uvs: _, triangles } = geometry;
        Self { positions, normals: normals.as_deref(), triangles }
    }
}

impl<'a> From<&'a Mesh> for View<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        let Mesh { name: _, positions, normals, uvs: _, triangles } = mesh;
        Self { positions, normals: normals.as_ref().map(|normals| normals.as_slice()), triangles }
    }
}

impl View<'_> {
    fn corners(&self) -> impl Iterator<Item = ([u32; 3], [Vec3; 3])> {
        self.triangles.iter().filter_map(|triangle| {
            let [a, b, c] = triangle.map(|index| self.positions.get(index as usize));
            Some((*triangle, [*a?, *b?, *c?].map(|point| point.map(f64::from))))
        })
    }
}

/// The unit normal of a triangle on the side from which its corners run counter-clockwise; none where it has no area.
pub fn face_normal([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    normalized(cross(sub(b, a), sub(c, a)))
}

/// The sum of the areas of the triangles, in scene units squared.
pub fn area(view: View<'_>) -> f64 {
    view.corners().map(|(_, [a, b, c])| 0.5 * length(cross(sub(b, a), sub(c, a)))).sum()
}

/// The enclosed volume of a closed mesh in scene units cubed, negative where its faces look inwards. For an open mesh
/// the value depends on the place of the mesh and means nothing.
pub fn signed_volume(view: View<'_>) -> f64 {
    // Against a vertex of the mesh instead of the origin: far from the origin the terms would cancel badly.
    let Some(pole) = view.positions.first().map(|point| point.map(f64::from)) else { return 0.0 };
    view.corners()
        .map(|(_, corners)| corners.map(|corner| sub(corner, pole)))
        .map(|[a, b, c]| dot(a, cross(b, c)))
        .sum::<f64>()
        / 6.0
}

/// The smallest and largest coordinates over the vertices that a triangle uses; none for a mesh without triangles.
pub fn bounds(view: View<'_>) -> Option<[Vec3; 2]> {
    let mut found: Option<[Vec3; 2]> = None;
    for (_, corners) in view.corners() {
        let [lo, hi] = found.get_or_insert([corners[0]; 2]);
        for corner in corners {
            for axis in 0..3 {
                lo[axis] = lo[axis].min(corner[axis]);
                hi[axis] = hi[axis].max(corner[axis]);
            }
        }
    }
    found
}

/// How many triangles have no area, in exact arithmetic or below the resolution of double precision.
pub fn degenerate_triangles(view: View<'_>) -> usize {
    view.corners().filter(|(_, corners)| face_normal(*corners).is_none()).count()
}

/// Whether the surface is closed: every edge, by the positions of its ends, is run along as often in one direction as
/// in the other. Triangles with two corners at one place do not count; a mesh without others is not closed.
pub fn is_closed(view: View<'_>) -> bool {
    let ids = position_ids(view.positions);
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(view.triangles.len() * 3);
    for (triangle, _) in view.corners() {
        let [a, b, c] = triangle.map(|index| ids[index as usize]);
        if a != b && b != c && c != a {
            edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)));
        }
    }
    edges.sort_unstable();
    !edges.is_empty()
        && edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)).all(|same| {
            let forwards = same.iter().filter(|edge| edge.2).count();
            2 * forwards == same.len()
        })
}

/// The triangles at the rim of the surface, in their order: those with an edge that is not run along as often in one direction as
/// in the other. Triangles with two corners at one place do not count.
pub fn rim(view: View<'_>) -> Vec<usize> {
    let ids = position_ids(view.positions);
    let mut edges: Vec<(u32, u32, bool, usize)> = Vec::with_capacity(view.triangles.len() * 3);
    for (at, triangle) in view.triangles.iter().enumerate() {
        let [Some(a), Some(b), Some(c)] = triangle.map(|index| ids.get(index as usize).copied()) else { continue };
        if a != b && b != c && c != a {
            edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to, at)));
        }
    }
    edges.sort_unstable();
    let mut found = Vec::new();
    for same in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        if 2 * same.iter().filter(|edge| edge.2).count() != same.len() {
            found.extend(same.iter().map(|edge| edge.3));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The largest angle in degrees between the normal of a face and the normal of one of its vertices; none for a mesh
/// without normals or without a triangle that has an area. 0 for a faceted mesh up to the rounding of its normals,
/// which is below 0.0001 degrees.
pub fn largest_normal_deviation(view: View<'_>) -> Option<f64> {
    let normals = view.normals?;
    let mut largest: Option<f64> = None;
    for (triangle, corners) in view.corners() {
        let Some(face) = face_normal(corners) else { continue };
        for index in triangle {
            let Some(normal) = normals.get(index as usize) else { continue };
            let normal = normal.map(f64::from);
            // Exact near 0 and near 180 degrees, unlike the arc cosine.
            let angle = libm::atan2(length(cross(face, normal)), dot(face, normal)).to_degrees();
            largest = Some(largest.map_or(angle, |most| most.max(angle)));
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boxed, flip};

    #[test]
    fn an_open_box_is_open_and_a_turned_one_has_negative_volume() {
        let full = boxed([10.0; 3], [11.0, 12.0, 13.0]).expect("a good box");
        let mut open = full.clone();
        open.triangles.pop();
        assert!(is_closed((&full).into()) && !is_closed((&open).into()));
        // Three triangles share an edge with the one that is missing.
        assert!(rim((&full).into()).is_empty() && rim((&open).into()).len() == 3);
        assert!((signed_volume((&flip(full)).into()) + 6.0).abs() < 1e-12);
    }

    #[test]
    fn one_triangle_turned_over_is_seen() {
        let mut g = boxed([0.0; 3], [1.0; 3]).expect("a good box");
        g.triangles[5].swap(0, 1);
        assert!(!is_closed((&g).into()));
        assert_eq!(largest_normal_deviation((&g).into()), Some(180.0));
    }

    #[test]
    fn deviation_is_in_degrees() {
        let mut g = boxed([0.0; 3], [1.0; 3]).expect("a good box");
        let normals = g.normals.as_mut().expect("it has normals");
        let (sine, cosine) = libm::sincos(2.0_f64.to_radians());
        normals[0] = [-cosine as f32, sine as f32, 0.0];
        assert!((largest_normal_deviation((&g).into()).expect("it has normals") - 2.0).abs() < 1e-4);
        g.normals = None;
        assert_eq!(largest_normal_deviation((&g).into()), None);
    }

    #[test]
    fn degenerate_triangles_and_wrong_indices_do_no_harm() {
        let g = Geometry {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [f32::NAN; 3]],
            triangles: vec![[0, 1, 2], [0, 0, 1], [0, 1, 9]],
            ..Geometry::default()
        };
        let view = (&g).into();
        assert_eq!((degenerate_triangles(view), area(view), is_closed(view)), (2, 0.0, false));
        assert_eq!(bounds(view), Some([[0.0; 3], [2.0, 0.0, 0.0]]));
        assert_eq!(bounds((&Geometry::default()).into()), None);
        assert!(!is_closed((&Geometry::default()).into()));
    }
}
