//! Turning a surface inside out.

use super::Geometry;

/// The geometry with its normals and its winding turned over.
pub fn flip(mut geometry: Geometry) -> Geometry {
    for triangle in &mut geometry.triangles {
        triangle.swap(1, 2);
    }
    for normal in geometry.normals.iter_mut().flatten() {
        // 0 - x instead of -x: no -0.
        *normal = normal.map(|x| 0.0 - x);
    }
    geometry
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boxed, largest_normal_deviation, signed_volume};

    #[test]
    fn twice_is_the_same_and_once_looks_inwards() {
        let g = boxed([0.0; 3], [1.0, 2.0, 3.0]).expect("a good box");
        let inside = flip(g.clone());
        assert!((signed_volume((&inside).into()) + 6.0).abs() < 1e-12);
        assert_eq!(largest_normal_deviation((&inside).into()), Some(0.0));
        assert_eq!(flip(inside), g);
    }
}
