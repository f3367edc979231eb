//! The cylinder.

use super::cone::frustum;
use super::revolve::positive;
use super::{Geometry, MeshError};

/// A cylinder of `radius` about the z axis over the range `z`: analytic smooth normals outward on `segments` segments,
/// and with `caps` a flat disk at each end. Vertices and texture coordinates are as on [`super::cone`].
///
/// # Errors
/// A radius that is not positive and finite, a range that is empty, reversed or vanishes in single precision, fewer
/// than 3 segments, more than [`super::MAX_TRIANGLES`], a cylinder so small that triangles vanish.
pub fn cylinder(radius: f64, z: (f64, f64), segments: u64, caps: bool) -> Result<Geometry, MeshError> {
    positive("radius", radius)?;
    frustum("a cylinder", radius, radius, z, segments, caps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::revolve::tests::sound;
    use crate::mesh::{area, bounds, signed_volume};
    use std::f64::consts::PI;

    #[test]
    fn measures_are_those_of_a_prism() {
        for segments in [3, 5, 32] {
            let side = [[1.5, 1.0], [1.5, 5.0]];
            let open = cylinder(1.5, (1.0, 5.0), segments, false).expect("a good cylinder");
            assert_eq!(open.triangles.len() as u64, 2 * segments);
            sound(&open, &[side], segments, false);
            let closed = cylinder(1.5, (1.0, 5.0), segments, true).expect("a good cylinder");
            assert_eq!(closed.triangles.len() as u64, 4 * segments);
            sound(&closed, &[[[0.0, 1.0], side[0]], side, [side[1], [0.0, 5.0]]], segments, true);
        }
    }

    #[test]
    fn fine_cylinders_have_the_measures_of_the_curved_one() {
        let g = cylinder(2.0, (0.0, 3.0), 512, true).expect("a good cylinder");
        assert!((area((&g).into()) / (2.0 * PI * 2.0 * (2.0 + 3.0)) - 1.0).abs() < 1e-4);
        assert!((signed_volume((&g).into()) / (PI * 4.0 * 3.0) - 1.0).abs() < 1e-4);
        assert_eq!(bounds((&g).into()), Some([[-2.0, -2.0, 0.0], [2.0, 2.0, 3.0]]));
    }

    #[test]
    fn sides_are_radial_and_caps_flat() {
        let g = cylinder(2.0, (0.0, 3.0), 16, true).expect("a good cylinder");
        let normals = g.normals.as_ref().expect("it has normals");
        let (mut flat, mut round) = (0, 0);
        for (position, normal) in g.positions.iter().zip(normals) {
            if normal[2] == 0.0 {
                assert!((0..2).all(|axis| (position[axis] / 2.0 - normal[axis]).abs() < 1e-6));
                round += 1;
            } else {
                assert_eq!(normal[2], if position[2] == 0.0 { -1.0 } else { 1.0 });
                flat += 1;
            }
        }
        assert_eq!((flat, round), (2 * 17, 2 * 17));
    }

    #[test]
    fn bad_arguments_are_named() {
        let at = |radius, z, segments| cylinder(radius, z, segments, true).map(|_| ()).expect_err("bad").argument;
        for radius in [0.0, -1.0, f64::NAN, 1e300, 1e-300] {
            assert_eq!(at(radius, (0.0, 1.0), 64), "radius", "{radius}");
        }
        assert_eq!(at(1.0, (1.0, 0.0), 64), "z");
        assert_eq!(at(1.0, (0.0, f64::INFINITY), 64), "z");
        assert_eq!(at(1.0, (0.0, 1.0), 2), "segments");
        assert_eq!(at(1.0, (0.0, 1.0), u64::MAX), "segments");
    }
}
