//! The torus.

use super::revolve::{Revolution, Row, positive};
use super::{Geometry, MeshError};
use crate::ir::sin_cos_degrees;

/// A torus about the z axis round the origin: the circle in its middle has radius `major`, the tube radius `minor`. It
/// has `2 * segments * rings` triangles, `segments` around the axis and `rings` around the tube, with analytic normals.
///
/// Texture coordinates: `u` is the longitude over 360 degrees, `v` the angle round the tube, from the outer equator
/// over the top; both have a seam.
///
/// # Errors
/// A radius that is not positive and finite, a tube that reaches the axis, fewer than 3 segments or rings, more than
/// [`super::MAX_TRIANGLES`], a tube so thin that triangles vanish in single precision.
pub fn torus(major: f64, minor: f64, segments: u64, rings: u64) -> Result<Geometry, MeshError> {
    positive("major", major)?;
    positive("minor", minor)?;
    if minor >= major {
        return Err(MeshError::new("minor", format!("the tube of radius {minor} reaches the axis {major} away"))
            .help("write a `minor` radius below the `major` one"));
    }
    if (major + minor) as f32 == major as f32 || (major - minor) as f32 == major as f32 {
        let message = format!("a tube of radius {minor} vanishes in single precision {major} from the axis");
        return Err(MeshError::new("minor", message).help("make the tube thicker"));
    }
    if rings < 3 {
        return Err(MeshError::new("rings", format!("a tube of {rings} rings is flat")).help("write at least 3 rings"));
    }
    let mut torus = Revolution::new("a torus", "minor", segments, rings.saturating_mul(2))?;
    let rows: Vec<Row> = (0..=rings)
        .map(|ring| {
            let v = ring as f64 / rings as f64;
            // The sine and cosine of 360 degrees are those of 0, so the tube closes to the bit.
            let (sine, cosine) = sin_cos_degrees(360.0 * v);
            Row { r: major + minor * cosine, z: minor * sine, normal: [cosine, sine], v }
        })
        .collect();
    torus.strip(&rows)?;
    torus.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::revolve::tests::sound;
    use crate::mesh::{area, bounds, largest_normal_deviation, signed_volume};
    use std::f64::consts::PI;

    #[test]
    fn measures_are_those_of_the_polyhedron() {
        for (segments, rings) in [(3_u64, 3_u64), (4, 5), (16, 8), (64, 32)] {
            let g = torus(3.0, 1.0, segments, rings).expect("a good torus");
            assert_eq!(g.triangles.len() as u64, 2 * segments * rings);
            let point = |ring: u64| {
                let (sine, cosine) = libm::sincos(2.0 * PI * ring as f64 / rings as f64);
                [3.0 + cosine, sine]
            };
            let stretches: Vec<_> = (0..rings).map(|ring| [point(ring), point(ring + 1)]).collect();
            sound(&g, &stretches, segments, true);
        }
    }

    #[test]
    fn fine_ones_have_the_measures_of_the_curved_one() {
        let g = torus(3.0, 1.0, 512, 256).expect("a good torus");
        assert!((area((&g).into()) / (4.0 * PI * PI * 3.0) - 1.0).abs() < 2e-4);
        assert!((signed_volume((&g).into()) / (2.0 * PI * PI * 3.0) - 1.0).abs() < 2e-4);
        assert_eq!(bounds((&g).into()), Some([[-4.0, -4.0, -1.0], [4.0, 4.0, 1.0]]));
        assert!(largest_normal_deviation((&g).into()).expect("it has normals") < 1.5);
    }

    #[test]
    fn bad_arguments_are_named() {
        let at = |major, minor, segments, rings| {
            torus(major, minor, segments, rings).map(|_| ()).expect_err("a bad torus").argument
        };
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(at(bad, 1.0, 64, 32), "major", "{bad}");
            assert_eq!(at(1.0, bad, 64, 32), "minor", "{bad}");
        }
        assert_eq!(at(1.0, 1.0, 64, 32), "minor");
        assert_eq!(at(1e300, 1.0, 64, 32), "minor");
        assert_eq!(at(1.0, 1e-9, 64, 32), "minor");
        assert_eq!(at(2.0, 1.0, 2, 32), "segments");
        assert_eq!(at(2.0, 1.0, 64, 2), "rings");
        assert_eq!(at(2.0, 1.0, u64::MAX, u64::MAX), "segments");
        assert_eq!(at(2.0, 1.0, 3, (1 << 30) / 6 + 1), "segments");
    }
}
