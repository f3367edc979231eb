//! The cone and the truncated cone.

use super::rectangle::range;
use super::revolve::{Revolution, Row, not_negative};
use super::{Axis, Geometry, MeshError};

/// A cone about the z axis, from `radius` at the lower end of `z` to `top` at the upper one, of `segments` segments.
/// One of both radii may be 0 and makes a tip, whose vertices have the normals of the middles of their segments.
///
/// The side has analytic smooth normals; texture coordinates: `u` is the longitude over 360 degrees,
/// counter-clockwise seen from above, `v` goes from 0 below to 1 above. With `caps` flat disks close each end that is
/// no tip, with vertices and normals of their own; their texture is as that of [`super::disk`].
///
/// # Errors
/// A radius that is negative or not finite, both 0, a range that is empty, reversed or vanishes in single precision,
/// fewer than 3 segments, more than [`super::MAX_TRIANGLES`], a cone so small that triangles vanish.
pub fn cone(radius: f64, top: f64, z: (f64, f64), segments: u64, caps: bool) -> Result<Geometry, MeshError> {
    not_negative("radius", radius)?;
    not_negative("top", top)?;
    if radius == 0.0 && top == 0.0 {
        return Err(MeshError::new("radius", "`radius` and `top` are both 0, the cone would be a line")
            .help("write a `radius` greater than 0"));
    }
    frustum("a cone", radius, top, z, segments, caps)
}

/// A cone whose radii are not negative and not both 0.
pub(super) fn frustum(
    what: &'static str,
    radius: f64,
    top: f64,
    z: (f64, f64),
    segments: u64,
    caps: bool,
) -> Result<Geometry, MeshError> {
    let (lo, hi) = range(Axis::Z, z.0, z.1)?;
    let ends = u64::from(radius > 0.0) + u64::from(top > 0.0);
    let mut cone = Revolution::new(what, "radius", segments, if caps { 2 * ends } else { ends })?;
    let slant = libm::hypot(hi - lo, radius - top);
    let normal = [(hi - lo) / slant, (radius - top) / slant];
    if caps && radius > 0.0 {
        cone.disk(radius, 0.0, lo, false)?;
    }
    cone.strip(&[Row { r: radius, z: lo, normal, v: 0.0 }, Row { r: top, z: hi, normal, v: 1.0 }])?;
    if caps && top > 0.0 {
        cone.disk(top, 0.0, hi, true)?;
    }
    cone.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::revolve::tests::sound;
    use crate::mesh::{bounds, largest_normal_deviation};

    #[test]
    fn cones_have_the_measures_of_pyramids() {
        for segments in [3, 4, 9, 64] {
            for (radius, top) in [(2.0, 0.0), (0.0, 2.0), (2.0, 1.0), (0.5, 3.0)] {
                let side = [[radius, -1.0], [top, 2.0]];
                let open = cone(radius, top, (-1.0, 2.0), segments, false).expect("a good cone");
                sound(&open, &[side], segments, false);
                let closed = cone(radius, top, (-1.0, 2.0), segments, true).expect("a good cone");
                let ends = [[0.0, -1.0], [radius, -1.0], [top, 2.0], [0.0, 2.0]];
                sound(&closed, &[[ends[0], ends[1]], side, [ends[2], ends[3]]], segments, true);
                let widest = if radius > top { radius } else { top };
                let [lo, hi] = bounds((&closed).into()).expect("it has triangles");
                assert_eq!((hi[0], lo[2], hi[2]), (widest, -1.0, 2.0));
            }
        }
        assert_eq!(cone(2.0, 0.0, (0.0, 1.0), 64, true).map(|g| g.triangles.len()), Ok(128));
        assert_eq!(cone(2.0, 1.0, (0.0, 1.0), 64, true).map(|g| g.triangles.len()), Ok(256));
    }

    #[test]
    fn normals_are_perpendicular_to_the_slope() {
        let g = cone(3.0, 0.0, (0.0, 4.0), 64, false).expect("a good cone");
        // The slope is (-3, 4), so the normal is (4, 3) over 5.
        assert!(g.normals.iter().flatten().all(|n| (n[2] - 0.6).abs() < 1e-6));
        // The face lies half a segment from its corners; the tip has its very normal.
        let deviation = largest_normal_deviation((&g).into()).expect("it has normals");
        assert!(deviation < 180.0 / 64.0, "{deviation}");
    }

    #[test]
    fn bad_arguments_are_named() {
        let at = |radius, top, z, segments| {
            cone(radius, top, z, segments, true).map(|_| ()).expect_err("a bad cone").argument
        };
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(at(bad, 0.0, (0.0, 1.0), 64), "radius");
            assert_eq!(at(1.0, bad, (0.0, 1.0), 64), "top");
        }
        for radius in [0.0, 1e300, 1e-300] {
            assert_eq!(at(radius, 0.0, (0.0, 1.0), 64), "radius", "{radius}");
        }
        for z in [(1.0, 0.0), (1.0, 1.0), (1e9, 1e9 + 1.0), (0.0, f64::NAN)] {
            assert_eq!(at(1.0, 0.0, z, 64), "z", "{z:?}");
        }
        for segments in [0, 2, (1 << 28) + 1, u64::MAX] {
            assert_eq!(at(1.0, 1.0, (0.0, 1.0), segments), "segments", "{segments}");
        }
    }
}
