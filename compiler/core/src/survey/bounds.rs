//! Boxes along the axes.

use crate::ir::{Affine, Vec3, length, sub};

/// A box with its sides along the axes; flat ones are allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub low: Vec3,
    /// The largest coordinates.
    pub high: Vec3,
}

impl Bounds {
    /// The smallest box around `points`; none without points.
    pub fn of_points(points: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        let (mut low, mut high) = (first, first);
        for point in points {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        Some(Self { low: low.map(f64::from), high: high.map(f64::from) })
    }

    /// The smallest box around a triangle.
    pub fn of_triangle([a, b, c]: [Vec3; 3]) -> Self {
        let pick = |choose: fn(f64, f64) -> f64| [0, 1, 2].map(|axis| choose(choose(a[axis], b[axis]), c[axis]));
        Self { low: pick(f64::min), high: pick(f64::max) }
    }

    /// The box around both.
    pub fn union(self, other: Self) -> Self {
        let pick = |choose: fn(f64, f64) -> f64, a: Vec3, b: Vec3| [0, 1, 2].map(|axis| choose(a[axis], b[axis]));
        Self { low: pick(f64::min, self.low, other.low), high: pick(f64::max, self.high, other.high) }
    }

    /// What both have in common; none where they are apart. Boxes that touch have a flat box in common.
    pub fn common(self, other: Self) -> Option<Self> {
        let low = [0, 1, 2].map(|axis| self.low[axis].max(other.low[axis]));
        let high = [0, 1, 2].map(|axis| self.high[axis].min(other.high[axis]));
        (0..3).all(|axis| low[axis] <= high[axis]).then_some(Self { low, high })
    }

    /// Whether both have something in common, a point at least.
    #[inline]
    pub fn touches(self, other: Self) -> bool {
        // Without branches: which of the six fails first cannot be foreseen.
        (0..3).fold(true, |so, axis| so & (self.low[axis] <= other.high[axis]) & (other.low[axis] <= self.high[axis]))
    }

    /// The box with `by` added on every side.
    pub fn grown(self, by: f64) -> Self {
        Self { low: self.low.map(|x| x - by), high: self.high.map(|x| x + by) }
    }

    /// Whether `point` lies in it or on its sides.
    pub fn contains(self, point: Vec3) -> bool {
        (0..3).all(|axis| (self.low[axis]..=self.high[axis]).contains(&point[axis]))
    }

    /// Its eight corners.
    pub fn corners(self) -> [Vec3; 8] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: usize| {
            [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] })
        })
    }

    /// The lengths of its sides.
    pub fn size(self) -> Vec3 {
        sub(self.high, self.low)
    }

    /// The length of its diagonal.
    pub fn diagonal(self) -> f64 {
        length(self.size())
    }

    /// Its middle.
    pub fn center(self) -> Vec3 {
        [0, 1, 2].map(|axis| 0.5 * (self.low[axis] + self.high[axis]))
    }

    /// The largest absolute coordinate.
    pub fn reach(self) -> f64 {
        self.low.iter().chain(&self.high).fold(0.0_f64, |most, x| most.max(x.abs()))
    }

    /// A box around the image of this one, by the center and half sides (Arvo 1990, "Transforming axis-aligned bounding
    /// boxes", Graphics Gems).
    pub fn transformed(self, map: &Affine) -> Self {
        let mut low = [0.0; 3];
        let mut high = [0.0; 3];
        for (axis, row) in map.rows.iter().enumerate() {
            (low[axis], high[axis]) = (row[3], row[3]);
            for ((factor, from_low), from_high) in row.iter().zip(self.low).zip(self.high) {
                let (a, b) = (factor * from_low, factor * from_high);
                low[axis] += a.min(b);
                high[axis] += a.max(b);
            }
        }
        Self { low, high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_box_holds_its_corners() {
        let own = Bounds { low: [-1.0, 0.0, 2.0], high: [3.0, 0.0, 5.0] };
        let map = Affine::rotation([0.0, 0.6, 0.8], 33.0).then(&Affine::translation([7.0, -2.0, 1.0]));
        let turned = own.transformed(&map);
        for corner in own.corners() {
            assert!(turned.grown(1e-12).contains(map.point(corner)));
        }
        assert_eq!(own.transformed(&Affine::IDENTITY), own);
        for (x, touches) in [(3.0, true), (3.1, false), (-9.0, true)] {
            let other = Bounds { low: [x, 0.0, 0.0], high: [4.0; 3] };
            assert_eq!(
                (own.common(other).is_some(), own.touches(other), other.touches(own)),
                (touches, touches, touches)
            );
        }
    }
}
