//! Whether a point lies inside a surface, and what hides it from another.

use std::f64::consts::TAU;

use crate::ir::{Vec3, cross, dot, length, sub};

use super::{Bounds, Placed, Survey};

/// How far a winding number may lie from a whole one for a closed surface. Rounding adds some 1e-16 for each triangle; an open
/// surface comes this close to 0 only from afar.
const WHOLE: f64 = 1e-6;

/// How often the surface of these triangles winds around `point`, by the solid angles that it covers there (van Oosterom and
/// Strackee 1983). For a closed surface that looks outwards 1 inside and 0 outside; -1 inside one that looks inwards; other
/// values for an open one. A point on the surface is inside or outside.
pub fn winding(triangles: impl IntoIterator<Item = [Vec3; 3]>, point: Vec3) -> f64 {
    let solid_angle = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(|corner| sub(corner, point));
        let [la, lb, lc] = [a, b, c].map(length);
        let spread = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        2.0 * libm::atan2(dot(a, cross(b, c)), spread)
    };
    triangles.into_iter().map(solid_angle).sum::<f64>() / (2.0 * TAU)
}

/// The winding number of a closed surface; none where `winding` is that of an open one.
pub fn whole(winding: f64) -> Option<i64> {
    let nearest = winding.round();
    ((winding - nearest).abs() <= WHOLE).then_some(nearest as i64)
}

impl Survey<'_> {
    /// Whether something lies between two points, the ends left out by a millionth of the way.
    pub fn blocked(&self, from: Vec3, to: Vec3) -> bool {
        let way = sub(to, from);
        let boxed = Bounds { low: pick(from, to, f64::min), high: pick(from, to, f64::max) };
        let near = self.placed.iter().filter(|placed| placed.bounds.touches(boxed));
        let mut near: Vec<_> = near.filter(|placed| meets_box(placed.bounds, from, way)).collect();
        // Walls and panes first: they hide most, and are looked through at once.
        near.sort_by_key(|placed| self.scene.meshes[placed.shape.mesh].triangles.len());
        near.into_iter().any(|placed| self.triangles(placed).any(|triangle| meets(triangle, from, way)))
    }
}

/// Whether faces of a use that look against `normal` cross the line of this length on both sides of a point.
pub fn faces_against(survey: &Survey<'_>, placed: &Placed<'_>, point: Vec3, normal: Vec3, length: f64) -> bool {
    let at = |far: f64| [0, 1, 2].map(|axis| point[axis] + far * normal[axis]);
    let (from, to) = (at(length), at(-length));
    let against = |[a, b, c]: [Vec3; 3]| dot(cross(sub(b, a), sub(c, a)), normal) < 0.0;
    placed.bounds.grown(length).contains(point)
        && survey.triangles(placed).any(|triangle| against(triangle) && meets(triangle, from, sub(to, from)))
}

fn pick(a: Vec3, b: Vec3, choose: fn(f64, f64) -> f64) -> Vec3 {
    [0, 1, 2].map(|axis| choose(a[axis], b[axis]))
}

/// Whether the line `from + t way`, 0 <= t <= 1, meets the box.
fn meets_box(bounds: Bounds, from: Vec3, way: Vec3) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        if way[axis] == 0.0 {
            if !(bounds.low[axis]..=bounds.high[axis]).contains(&from[axis]) {
                return false;
            }
            continue;
        }
        let ends = [bounds.low[axis], bounds.high[axis]].map(|side| (side - from[axis]) / way[axis]);
        first = first.max(ends[0].min(ends[1]));
        last = last.min(ends[0].max(ends[1]));
    }
    // Flat boxes are met in a point, up to rounding.
    first <= last + 1e-9
}

/// Whether the line from `from` along `way` meets the triangle between its ends (Möller and Trumbore 1997).
fn meets([a, b, c]: [Vec3; 3], from: Vec3, way: Vec3) -> bool {
    const END: f64 = 1e-6;
    let (ab, ac) = (sub(b, a), sub(c, a));
    let p = cross(way, ac);
    let determinant = dot(ab, p);
    if determinant == 0.0 {
        return false;
    }
    let s = sub(from, a);
    let u = dot(s, p) / determinant;
    let q = cross(s, ab);
    let v = dot(way, q) / determinant;
    let t = dot(ac, q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (END..=1.0 - END).contains(&t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boxed, flip};

    #[test]
    fn a_closed_surface_winds_once_around_what_is_inside() {
        let around = |geometry: &crate::mesh::Geometry, point| {
            let corners = geometry.triangles.iter().map(|t| t.map(|i| geometry.positions[i as usize].map(f64::from)));
            winding(corners, point)
        };
        let mut full = boxed([10.0; 3], [11.0, 12.0, 13.0]).expect("a good box");
        let (inside, outside) = ([10.3, 11.1, 10.2], [12.0, 3.0, 10.2]);
        assert_eq!(whole(around(&full, inside)), Some(1));
        assert_eq!(whole(around(&full, outside)), Some(0));
        assert_eq!(whole(around(&flip(full.clone()), inside)), Some(-1));
        full.triangles.pop();
        assert_eq!(whole(around(&full, inside)), None);
    }

    #[test]
    fn a_line_meets_what_lies_between_its_ends() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let (above, below) = ([0.2, 0.3, 1.0], [0.2, 0.3, -1.0]);
        assert!(meets(triangle, above, sub(below, above)));
        assert!(!meets(triangle, above, [0.0, 0.0, -0.5]), "it ends before");
        assert!(!meets(triangle, above, [0.0, 0.0, -1.0]), "it ends there");
        assert!(!meets(triangle, [0.7, 0.7, 1.0], [0.0, 0.0, -2.0]), "it passes by");
        let flat = Bounds { low: [0.0; 3], high: [1.0, 1.0, 0.0] };
        assert!(meets_box(flat, above, sub(below, above)) && !meets_box(flat, above, [0.0, 0.0, -0.5]));
        assert!(!meets_box(flat, [2.0, 0.5, 1.0], [0.0, 0.0, -2.0]));
    }
}
