//! The box along the axes. (`box` is a reserved word of Rust.)

use super::rectangle::{range, side};
use super::{Axis, Geometry, MeshError, SignedAxis};

/// The box from `lo` to `hi`: outward faceted normals, 24 vertices, 12 triangles, texture coordinates from 0 to 1 on
/// each side, laid as on [`super::rectangle`].
///
/// # Errors
/// A number that is not finite, or a side that is empty, reversed or vanishes in single precision.
pub fn boxed(lo: [f64; 3], hi: [f64; 3]) -> Result<Geometry, MeshError> {
    for axis in Axis::ALL {
        range(axis, lo[axis.index()], hi[axis.index()])?;
    }
    let mut geometry = Geometry { normals: Some(Vec::new()), uvs: Some(Vec::new()), ..Geometry::default() };
    for axis in Axis::ALL {
        for negative in [true, false] {
            side(&mut geometry, lo, hi, SignedAxis { axis, negative })?;
        }
    }
    Ok(geometry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{area, bounds, is_closed, largest_normal_deviation, signed_volume};

    #[test]
    fn measures_are_those_of_a_box() {
        let g = boxed([-1.0, 2.0, 0.5], [1.0, 5.0, 4.5]).expect("a good box");
        assert_eq!((g.positions.len(), g.triangles.len(), g.check()), (24, 12, Ok(())));
        let view = (&g).into();
        assert_eq!(area(view), 2.0 * (2.0 * 3.0 + 3.0 * 4.0 + 2.0 * 4.0));
        assert!((signed_volume(view) - 24.0).abs() < 1e-12);
        assert!(is_closed(view));
        assert_eq!(largest_normal_deviation(view), Some(0.0));
        assert_eq!(bounds(view), Some([[-1.0, 2.0, 0.5], [1.0, 5.0, 4.5]]));
    }

    #[test]
    fn bad_sides_are_named() {
        let fault = |lo, hi| boxed(lo, hi).expect_err("a bad box").argument;
        assert_eq!(fault([0.0; 3], [1.0, 0.0, 1.0]), "y");
        assert_eq!(fault([0.0; 3], [1.0, 1.0, f64::INFINITY]), "z");
        assert_eq!(fault([f64::NAN, 0.0, 0.0], [1.0; 3]), "x");
    }
}
