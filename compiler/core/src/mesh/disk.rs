//! The disk and the annulus.

use super::revolve::{Revolution, not_negative, positive};
use super::{Geometry, MeshError};

/// A flat disk of `radius` about the z axis at z = 0, facing up: a regular polygon of `segments` corners, its first on
/// the x axis. With `inner` above 0 a ring, from that radius outwards.
///
/// The texture coordinates are those of the square round the disk: (0.5, 0.5) in the middle, `u` along x, `v` along y.
///
/// # Errors
/// A radius that is not positive and finite, an inner one that is negative or not below it, fewer than 3 segments, more
/// than [`super::MAX_TRIANGLES`], a disk so small that triangles vanish in single precision.
pub fn disk(radius: f64, inner: f64, segments: u64) -> Result<Geometry, MeshError> {
    positive("radius", radius)?;
    not_negative("inner", inner)?;
    if inner >= radius {
        return Err(MeshError::new("inner", format!("`inner` is {inner}, not below `radius`, which is {radius}"))
            .help("write an inner radius below the outer one, or none for a disk without a hole"));
    }
    let mut disk = Revolution::new("a disk", "radius", segments, if inner == 0.0 { 1 } else { 2 })?;
    disk.disk(radius, inner, 0.0, true)?;
    disk.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::revolve::tests::sound;
    use crate::mesh::{bounds, largest_normal_deviation};

    #[test]
    fn disks_and_rings_are_flat_polygons() {
        for segments in [3, 4, 7, 64] {
            let g = disk(2.0, 0.0, segments).expect("a good disk");
            assert_eq!((g.positions.len() as u64, g.triangles.len() as u64), (segments + 1, segments));
            sound(&g, &[[[2.0, 0.0], [0.0, 0.0]]], segments, false);
            let g = disk(2.0, 0.5, segments).expect("a good ring");
            assert_eq!((g.positions.len() as u64, g.triangles.len() as u64), (2 * segments, 2 * segments));
            sound(&g, &[[[2.0, 0.0], [0.5, 0.0]]], segments, false);
            assert!(g.normals.iter().flatten().all(|normal| *normal == [0.0, 0.0, 1.0]));
            assert_eq!(largest_normal_deviation((&g).into()), Some(0.0));
        }
        let g = disk(2.0, 0.0, 8).expect("a good disk");
        assert_eq!(bounds((&g).into()), Some([[-2.0, -2.0, 0.0], [2.0, 2.0, 0.0]]));
        let uvs = g.uvs.as_ref().expect("it has texture coordinates");
        for (position, uv) in g.positions.iter().zip(uvs) {
            assert!((0..2).all(|axis| (uv[axis] - (0.5 + position[axis] / 4.0)).abs() < 1e-6));
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        let fault = |radius, inner, segments| disk(radius, inner, segments).map(|_| ()).expect_err("bad").argument;
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
            assert_eq!(fault(radius, 0.0, 64), "radius", "{radius}");
        }
        for inner in [1.0, 2.0, -0.5, f64::NAN] {
            assert_eq!(fault(1.0, inner, 64), "inner", "{inner}");
        }
        // Both circles are the same in single precision.
        assert_eq!(fault(1.0, 1.0 - 1e-12, 64), "radius");
        for segments in [0, 2, (1 << 30) + 1, u64::MAX] {
            assert_eq!(fault(1.0, 0.0, segments), "segments", "{segments}");
        }
    }
}
