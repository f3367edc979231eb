//! Affine transforms in double precision, and the few vector operations that the Scene needs.

use super::degrees::sin_cos_degrees;

/// A point or a direction.
pub type Vec3 = [f64; 3];

/// `a - b`.
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The scalar product.
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The Euclidean length.
pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// `a` with length 1; none for a zero or non-finite vector.
pub fn normalized(a: Vec3) -> Option<Vec3> {
    // Scaling first keeps tiny and huge vectors from underflow and overflow.
    let largest = a.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let scaled = a.map(|x| x / largest);
    let size = length(scaled);
    // It is at least 1, or not a number where a part of the vector is none, which `max` overlooks.
    (size >= 1.0).then(|| scaled.map(|x| x / size))
}

/// A map of points `p -> M p + t`, written as the three rows of `(M | t)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Row `i` holds `M[i][0..3]` and `t[i]`.
    pub rows: [[f64; 4]; 3],
}

impl Affine {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// Moves by `by`.
    pub fn translation(by: Vec3) -> Self {
        let mut map = Self::IDENTITY;
        for (row, offset) in map.rows.iter_mut().zip(by) {
            row[3] = offset;
        }
        map
    }

    /// Scales along the axes.
    pub fn scaling(by: Vec3) -> Self {
        let mut map = Self::IDENTITY;
        for (axis, factor) in by.into_iter().enumerate() {
            map.rows[axis][axis] = factor;
        }
        map
    }

    /// Turns by `degrees` about the unit vector `axis` through the origin, counter-clockwise seen against it.
    ///
    /// Multiples of 90 degrees about a coordinate axis are exact.
    pub fn rotation(axis: Vec3, degrees: f64) -> Self {
        let (sine, cosine) = sin_cos_degrees(degrees);
        let [x, y, z] = axis;
        let k = 1.0 - cosine;
        Self {
            rows: [
                [cosine + x * x * k, x * y * k - z * sine, x * z * k + y * sine, 0.0],
                [y * x * k + z * sine, cosine + y * y * k, y * z * k - x * sine, 0.0],
                [z * x * k - y * sine, z * y * k + x * sine, cosine + z * z * k, 0.0],
            ],
        }
    }

    /// The map that applies `self` first and `after` second.
    #[must_use]
    pub fn then(&self, after: &Self) -> Self {
        let mut rows = [[0.0; 4]; 3];
        for (row, outer) in rows.iter_mut().zip(&after.rows) {
            for (column, entry) in row.iter_mut().enumerate() {
                *entry = (0..3).map(|k| outer[k] * self.rows[k][column]).sum::<f64>();
            }
            row[3] += outer[3];
        }
        Self { rows }
    }

    /// Where a point goes.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// Where a direction goes.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }

    /// The determinant of the linear part: volume scale, negative where the map mirrors.
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = self.linear();
        dot(a, cross(b, c))
    }

    /// The matrix that maps normals: the cofactors of the linear part, i.e. the inverse transpose times the
    /// determinant. Its results must be normalized; it turns them over where the map mirrors.
    pub fn cofactors(&self) -> [[f64; 3]; 3] {
        let [a, b, c] = self.linear();
        [cross(b, c), cross(c, a), cross(a, b)]
    }

    /// Whether all entries are finite and the linear part can be inverted.
    pub fn is_invertible(&self) -> bool {
        let finite = self.rows.iter().flatten().all(|x| x.is_finite());
        // Relative to the product of the row lengths, so that small scenes are not called singular.
        let scale: f64 = self.linear().map(length).iter().product();
        finite && scale > 0.0 && self.determinant().abs() > 1e-12 * scale
    }

    /// Whether this is a translation, rotation and uniform scale, to 1e-9 of the scale: the maps under which unit
    /// normals stay correct without the inverse transpose.
    pub fn is_similarity(&self) -> bool {
        let [a, b, c] = self.linear();
        let square = dot(a, a);
        let close = |x: f64| x.abs() <= 1e-9 * square;
        close(dot(a, b))
            && close(dot(b, c))
            && close(dot(a, c))
            && close(dot(b, b) - square)
            && close(dot(c, c) - square)
    }

    /// Whether this is a rotation about the origin and nothing else, to 1e-9.
    pub fn is_rotation(&self) -> bool {
        let [a, b, c] = self.linear();
        let still = self.rows.iter().all(|row| row[3] == 0.0);
        still && self.is_similarity() && (dot(a, a) - 1.0).abs() <= 1e-9 && dot(a, super::cross(b, c)) > 0.0
    }

    fn linear(&self) -> [Vec3; 3] {
        self.rows.map(|r| [r[0], r[1], r[2]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Vec3 = [1.0, 0.0, 0.0];
    const Z: Vec3 = [0.0, 0.0, 1.0];

    #[test]
    fn a_direction_has_length_1_or_is_none() {
        for at in 0..3 {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut vector = [1.0, -2.0, 3.0];
                vector[at] = bad;
                assert_eq!(normalized(vector), None, "{vector:?}");
            }
        }
        for size in [1e-320, 1e-150, 1.0, 1e150, 1e308] {
            let unit = normalized([size, -size, 0.0]).expect("a direction");
            assert!((length(unit) - 1.0).abs() < 1e-15, "{size}: {unit:?}");
        }
        assert_eq!(normalized([0.0; 3]), None);
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y_exactly() {
        for turns in [-7, -3, 1, 5] {
            assert_eq!(Affine::rotation(Z, 90.0 * f64::from(turns)).vector(X), [0.0, 1.0, 0.0]);
        }
        assert_eq!(Affine::rotation(Z, -90.0).vector(X), [0.0, -1.0, 0.0]);
    }

    #[test]
    fn then_applies_left_to_right() {
        let map = Affine::rotation(Z, 90.0).then(&Affine::translation([10.0, 0.0, 0.0]));
        assert_eq!(map.point(X), [10.0, 1.0, 0.0]);
    }

    #[test]
    fn cofactors_map_normals_of_a_stretched_plane() {
        // The plane x + z = 0 stretched by 2 along x has the normal (1, 0, 2).
        let map = Affine::scaling([2.0, 1.0, 1.0]);
        let n = map.cofactors().map(|r| dot(r, [1.0, 0.0, 1.0]));
        assert!(length(cross(n, [1.0, 0.0, 2.0])) < 1e-12 && dot(n, [1.0, 0.0, 2.0]) > 0.0);
        assert!(!map.is_similarity() && Affine::scaling([-3.0, 3.0, 3.0]).is_similarity());
    }

    #[test]
    fn singular_maps_are_seen() {
        assert!(!Affine::scaling([1.0, 0.0, 1.0]).is_invertible());
        assert!(!Affine::scaling([1.0, f64::NAN, 1.0]).is_invertible());
        assert!(Affine::scaling([1e-9, 1e-9, 1e-9]).is_invertible());
    }
}
