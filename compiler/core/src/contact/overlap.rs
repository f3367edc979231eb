//! How much of two triangles lies in or near one plane, one over the other.

use crate::ir::{Vec3, cross, dot, length, sub};
use crate::survey::Bounds;

/// The cosine of the largest angle between planes that count as parallel, 5.7 degrees. Planes at a larger angle cross: what is near
/// is a strip along a line, no wider than ten times the distance.
const PARALLEL: f64 = 0.995;

/// The least part of the smaller triangle that must be covered: less is the rounding of edges that touch.
const SLIVER: f64 = 1e-3;

/// A triangle in the scene's coordinates that has an area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    /// Of unit length.
    pub normal: Vec3,
    pub area: f64,
    pub bounds: Bounds,
}

impl Triangle {
    /// None for a triangle without area.
    pub fn of(corners: [Vec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let across = cross(sub(b, a), sub(c, a));
        let twice = length(across);
        let normal = across.map(|x| x / twice);
        let good = twice > 0.0 && normal.iter().all(|x| x.is_finite());
        good.then(|| Self { corners, normal, area: 0.5 * twice, bounds: Bounds::of_triangle(corners) })
    }
}

/// Faces that lie over each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The area within the larger distance, in units squared.
    pub near: f64,
    /// The area within the smaller distance.
    pub coplanar: f64,
    /// The smallest distance; infinite for no area.
    pub gap: f64,
}

impl Overlap {
    /// Nothing lies over anything.
    pub const NONE: Self = Self { near: 0.0, coplanar: 0.0, gap: f64::INFINITY };

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { near: self.near + other.near, coplanar: self.coplanar + other.coplanar, gap: self.gap.min(other.gap) }
    }
}

/// The larger and the smaller distance within which faces count as lying over each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distances {
    pub near: f64,
    pub coplanar: f64,
}

/// What of `other` lies over `one`, measured on the plane of `one`; with whether both look the same way. None where planes cross
/// or nothing does.
pub(super) fn overlap(one: &Triangle, other: &Triangle, within: Distances) -> Option<(bool, Overlap)> {
    common(one, other, within).map(|(same, found, _)| (same, found))
}

/// The middle of what of two triangles lies in one plane and looks the same way, with the direction.
pub(super) fn place(one: &Triangle, other: &Triangle, within: Distances) -> Option<(Vec3, Vec3)> {
    common(one, other, within).and_then(|(same, _, middle)| same.then_some((middle, one.normal)))
}

fn common(one: &Triangle, other: &Triangle, within: Distances) -> Option<(bool, Overlap, Vec3)> {
    if !one.bounds.grown(within.near).touches(other.bounds) {
        return None;
    }
    let cosine = dot(one.normal, other.normal);
    if cosine.abs() < PARALLEL {
        return None;
    }
    let start = one.corners[0];
    let height = other.corners.map(|corner| dot(one.normal, sub(corner, start)));
    if height.iter().all(|h| *h > within.near) || height.iter().all(|h| *h < -within.near) {
        return None;
    }
    // Flattened along the axis that the plane looks along the most; the third number is the height over the plane.
    let normal = one.normal.map(f64::abs);
    let drop = (0..3).fold(0, |most, axis| if normal[axis] > normal[most] { axis } else { most });
    let (u, v) = ((drop + 1) % 3, (drop + 2) % 3);
    let flat = |corner: Vec3| [corner[u] - start[u], corner[v] - start[v]];
    let mut polygon = Polygon::default();
    for (corner, height) in other.corners.iter().zip(height) {
        let [x, y] = flat(*corner);
        polygon.push([x, y, height]);
    }
    polygon.keep_within(within.near);
    let border = one.corners.map(flat);
    let turn = if one.normal[drop] > 0.0 { 1.0 } else { -1.0 };
    for side in 0..3 {
        let ([ax, ay], [bx, by]) = (border[side], border[(side + 1) % 3]);
        polygon.keep(|p| turn * ((bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax)));
    }
    let near = polygon.area() / normal[drop];
    if near <= SLIVER * one.area.min(other.area) {
        return None;
    }
    let gap = polygon.gap();
    let middle = polygon.middle();
    let mut found = Overlap { near, coplanar: 0.0, gap };
    if gap <= within.coplanar {
        polygon.keep_within(within.coplanar);
        found.coplanar = polygon.area() / normal[drop];
    }
    // From the flattened middle up to the plane of `one`.
    let mut at = start;
    (at[u], at[v]) = (start[u] + middle[0], start[v] + middle[1]);
    at[drop] -= (one.normal[u] * middle[0] + one.normal[v] * middle[1]) / one.normal[drop];
    Some((cosine > 0.0, found, at))
}

/// A convex polygon of few corners: a triangle that was cut seven times at most.
#[derive(Default)]
struct Polygon {
    corners: [Vec3; 12],
    count: usize,
}

impl Polygon {
    fn push(&mut self, corner: Vec3) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// Cuts away where `inside` is negative (Sutherland and Hodgman 1974).
    fn keep(&mut self, inside: impl Fn(Vec3) -> f64) {
        let mut cut = Self::default();
        for at in 0..self.count {
            let (from, to) = (self.corners[at], self.corners[(at + 1) % self.count]);
            let (a, b) = (inside(from), inside(to));
            if a >= 0.0 {
                cut.push(from);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let share = a / (a - b);
                cut.push([0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis])));
            }
        }
        *self = cut;
    }

    /// Cuts away what is farther from the plane.
    fn keep_within(&mut self, distance: f64) {
        if self.corners().iter().any(|corner| corner[2].abs() > distance) {
            self.keep(|p| distance - p[2]);
            self.keep(|p| distance + p[2]);
        }
    }

    /// The area, flattened.
    fn area(&self) -> f64 {
        let Some(start) = self.corners().first() else { return 0.0 };
        let fan = self.corners().windows(2).map(|pair| {
            let (a, b) = (sub(pair[0], *start), sub(pair[1], *start));
            a[0] * b[1] - a[1] * b[0]
        });
        0.5 * fan.sum::<f64>().abs()
    }

    /// A point within: the mean of the corners.
    fn middle(&self) -> Vec3 {
        let sum = self.corners().iter().fold([0.0; 3], |sum, corner| [0, 1, 2].map(|axis| sum[axis] + corner[axis]));
        sum.map(|x| x / self.count.max(1) as f64)
    }

    /// The smallest height.
    fn gap(&self) -> f64 {
        let heights = self.corners().iter().map(|corner| corner[2]);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
        if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Affine;

    const WITHIN: Distances = Distances { near: 0.01, coplanar: 1e-4 };

    fn triangle(corners: [Vec3; 3]) -> Triangle {
        Triangle::of(corners).expect("an area")
    }

    fn unit() -> Triangle {
        triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    fn over(corners: [Vec3; 3]) -> Option<(bool, Overlap)> {
        // The same in any position, and the other way round.
        let found = overlap(&unit(), &triangle(corners), WITHIN);
        let map = Affine::rotation([0.6, 0.0, 0.8], 37.0).then(&Affine::translation([5.0, -7.0, 11.0]));
        let moved = |triangle: [Vec3; 3]| self::triangle(triangle.map(|corner| map.point(corner)));
        for (one, other) in [(unit().corners, corners), (corners, unit().corners)] {
            let again = overlap(&moved(one), &moved(other), WITHIN);
            assert_eq!(found.is_some(), again.is_some(), "{corners:?}");
            if let (Some((same, a)), Some((also, b))) = (found, again) {
                assert!(same == also && (a.near - b.near).abs() < 0.01 * a.near, "{a:?} {b:?}");
            }
        }
        found
    }

    #[test]
    fn areas_of_parallel_triangles() {
        let (same, whole) = over([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).expect("itself");
        assert!(same && (whole.near - 0.5).abs() < 1e-12 && (whole.coplanar - 0.5).abs() < 1e-12 && whole.gap == 0.0);
        let (same, half) =
            over([[0.0, 0.0, 0.005], [0.0, 1.0, 0.005], [0.5, 0.0, 0.005]]).expect("above it, turned over");
        assert!(!same && (half.near - 0.25).abs() < 1e-12 && half.coplanar == 0.0 && (half.gap - 0.005).abs() < 1e-12);
        assert!(over([[0.0, 0.0, 0.02], [1.0, 0.0, 0.02], [0.0, 1.0, 0.02]]).is_none(), "too far away");
        // A hexagon: the two triangles of a star, whose corners are a third of their sides long.
        let star = triangle([[1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]]);
        assert!(overlap(&star, &star, WITHIN).is_some());
    }

    #[test]
    fn what_touches_along_a_line_does_not_overlap() {
        assert!(over([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).is_none(), "the other half of a square");
        assert!(over([[1.0, 1e-5, 0.0], [0.0, 1e-5, 0.0], [0.0, -1.0, 0.0]]).is_none(), "by rounding");
        assert!(over([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).is_none(), "a wall");
        assert!(over([[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]).is_none(), "beside it");
    }

    #[test]
    fn of_a_leaning_triangle_the_near_part_counts() {
        // It rises by 0.05 over a length of 1: the first fifth is near.
        let (same, part) = over([[0.0; 3], [1.0, 0.0, 0.05], [0.0, 1.0, 0.0]]).expect("a part");
        // 1/2 (1 - 0.8^2), the strip of the triangle with x below 0.2.
        assert!(same && (part.near - 0.18).abs() < 1e-3, "{part:?}");
        assert!((part.coplanar - 0.002).abs() < 1e-4, "{part:?}");
    }
}
