//! Flat shading: every triangle gets its own normal.

use super::split::Splitter;
use super::{Geometry, MeshError, face_normal};

/// The geometry with the normal of each face at its corners, and how many triangles had no area and were dropped.
///
/// Vertices are split where faces of different normals meet; neighbors in one plane go on sharing theirs.
///
/// # Errors
/// Indices out of range, or arrays of different lengths.
pub fn faceted(geometry: Geometry) -> Result<(Geometry, usize), MeshError> {
    geometry.check_indices()?;
    let mut splitter = Splitter::new(&geometry);
    let mut dropped = 0;
    for triangle in &geometry.triangles {
        match face_normal(triangle.map(|index| geometry.positions[index as usize].map(f64::from))) {
            // Adding 0 turns -0 to 0, so that neighbors in a plane along an axis agree to the bit.
            Some(normal) => splitter.push(*triangle, [normal.map(|x| x as f32 + 0.0); 3]),
            None => dropped += 1,
        }
    }
    Ok((splitter.finish(), dropped))
}

#[cfg(test)]
pub(in crate::mesh) mod tests {
    use super::*;
    use crate::mesh::{is_closed, largest_normal_deviation, signed_volume, sphere};

    #[test]
    fn a_cube_of_8_vertices_gets_24() {
        let cube = cube();
        let (g, dropped) = faceted(cube.clone()).expect("a consistent cube");
        assert_eq!((g.positions.len(), g.triangles.len(), dropped, g.check()), (24, 12, 0, Ok(())));
        assert_eq!(largest_normal_deviation((&g).into()), Some(0.0));
        assert_eq!(signed_volume((&g).into()), signed_volume((&cube).into()));
        assert!(is_closed((&g).into()));
    }

    #[test]
    fn a_sphere_becomes_flat_and_stays_closed() {
        let smooth = sphere(1.0, [0.0; 3], 32, 16).expect("a good sphere");
        let (g, dropped) = faceted(smooth.clone()).expect("a consistent sphere");
        assert_eq!((g.triangles.len(), dropped), (smooth.triangles.len(), 0));
        assert!(largest_normal_deviation((&g).into()).expect("normals") < 1e-4);
        assert!(is_closed((&g).into()));
        assert_eq!(g.uvs.as_ref().map(Vec::len), Some(g.positions.len()));
    }

    #[test]
    fn triangles_without_area_are_dropped_and_counted() {
        let mut g = cube();
        g.triangles.push([0, 0, 1]);
        assert_eq!(faceted(g).map(|(g, dropped)| (g.triangles.len(), dropped)), Ok((12, 1)));
        let broken = Geometry { triangles: vec![[0, 1, 2]], ..Geometry::default() };
        assert!(faceted(broken).is_err());
    }

    pub(in crate::mesh) fn cube() -> Geometry {
        let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
        let quads: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Geometry { positions, normals: None, uvs: None, triangles }
    }
}
