//! Affine maps applied to vertices.

use rayon::prelude::*;

use super::error::round;
use super::{Geometry, MeshError};
use crate::ir::{Affine, dot, normalized};

/// Below this many items a loop is not worth other threads.
const WORTH_THREADS: usize = 1 << 14;

/// The geometry where `map` takes it: positions in double precision, rounded once; normals by the cofactors of the map,
/// normalized; the winding turned where the map mirrors, so that the front stays the front.
///
/// # Errors
/// A map that cannot be inverted, or a vertex that leaves the range of single precision.
pub fn transform(mut geometry: Geometry, map: &Affine) -> Result<Geometry, MeshError> {
    if !map.is_invertible() {
        let message = "the transform flattens the mesh or is not finite: it has no inverse";
        return Err(MeshError::new("", message).help("scale by numbers that are not 0"));
    }
    geometry.positions = transform_positions(&geometry.positions, map)?;
    if let Some(normals) = &mut geometry.normals {
        *normals = transform_normals(normals, map);
    }
    if map.determinant() < 0.0 {
        for triangle in &mut geometry.triangles {
            triangle.swap(1, 2);
        }
    }
    Ok(geometry)
}

/// The points where `map` takes them.
///
/// # Errors
/// A point that leaves the range of single precision.
pub fn transform_positions(positions: &[[f32; 3]], map: &Affine) -> Result<Vec<[f32; 3]>, MeshError> {
    let moved = |point: &[f32; 3]| round("", map.point(point.map(f64::from)));
    if positions.len() >= WORTH_THREADS {
        // Which thread fails first depends on the weather; the sequential pass below always names the first point.
        if let Ok(moved) = positions.par_iter().map(moved).collect() {
            return Ok(moved);
        }
    }
    positions.iter().map(moved).collect()
}

/// The normals of a surface that `map`, which must be invertible, takes away, of unit length; on the front of the moved
/// surface also where the map mirrors.
pub fn transform_normals(normals: &[[f32; 3]], map: &Affine) -> Vec<[f32; 3]> {
    let sign = if map.determinant() < 0.0 { -1.0 } else { 1.0 };
    let rows = map.cofactors();
    let moved = |normal: &[f32; 3]| {
        let before = normal.map(f64::from);
        match normalized(rows.map(|row| sign * dot(row, before))) {
            // Adding 0 turns -0 to 0.
            Some(after) => after.map(|x| x as f32 + 0.0),
            None => *normal,
        }
    };
    if normals.len() < WORTH_THREADS {
        return normals.iter().map(moved).collect();
    }
    normals.par_iter().map(moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{bounds, boxed, is_closed, largest_normal_deviation, signed_volume, sphere};

    fn turned() -> Affine {
        Affine::scaling([2.0, 0.5, 3.0])
            .then(&Affine::rotation([0.6, 0.0, 0.8], 37.0))
            .then(&Affine::translation([5.0, -7.0, 11.0]))
    }

    #[test]
    fn volume_scales_by_the_determinant_and_normals_stay_on_the_faces() {
        let g = boxed([0.0; 3], [1.0, 2.0, 3.0]).expect("a good box");
        for mirror in [1.0, -1.0] {
            let map = Affine::scaling([mirror, 1.0, 1.0]).then(&turned());
            let moved = transform(g.clone(), &map).expect("it fits");
            assert!((signed_volume((&moved).into()) - 6.0 * 3.0).abs() < 1e-4, "mirror {mirror}");
            assert!(largest_normal_deviation((&moved).into()).expect("normals") < 1e-3, "mirror {mirror}");
            assert!(is_closed((&moved).into()));
            assert_eq!(moved.check(), Ok(()));
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let g = boxed([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).expect("a good box");
        let moved = transform(g, &Affine::rotation([0.0, 0.0, 1.0], 90.0)).expect("it fits");
        assert_eq!(bounds((&moved).into()), Some([[-5.0, 1.0, 3.0], [-2.0, 4.0, 6.0]]));
        assert!(moved.normals.iter().flatten().flatten().all(|x| [0.0, 1.0, -1.0].contains(x)));
    }

    #[test]
    fn threads_change_nothing() {
        let g = sphere(1.0, [0.0; 3], 256, 128).expect("a good sphere");
        assert!(g.positions.len() > WORTH_THREADS);
        let moved = transform(g.clone(), &turned()).expect("it fits");
        let one = |point: &[f32; 3]| turned().point(point.map(f64::from)).map(|x| x as f32);
        assert!(g.positions.iter().map(one).eq(moved.positions));
    }

    #[test]
    fn singular_maps_and_overflow_are_errors() {
        let g = boxed([0.0; 3], [1.0; 3]).expect("a good box");
        assert!(transform(g.clone(), &Affine::scaling([1.0, 0.0, 1.0])).is_err());
        assert!(transform(g.clone(), &Affine::scaling([f64::NAN, 1.0, 1.0])).is_err());
        assert!(transform(g, &Affine::translation([1e39, 0.0, 0.0])).is_err());
    }
}
