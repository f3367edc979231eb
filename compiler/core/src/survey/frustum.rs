//! What a camera can see, walls aside: the pyramid of its image.

use crate::ir::{Axes, Camera, Film, Vec3, dot, sub};

use super::Bounds;

/// The pyramid that a camera sees, from the eye on; its clipping distances are left out.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    eye: Vec3,
    axes: Axes,
    /// Tangents of half the angles of view, across and up.
    tangents: [f64; 2],
}

/// The nearest and the farthest distance along the optical axis at which something is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The nearest.
    pub near: f64,
    /// The farthest.
    pub far: f64,
}

impl Frustum {
    /// The pyramid of `camera` with an image of `film`'s shape; none where the camera looks nowhere.
    pub fn of(camera: &Camera, film: &Film) -> Option<Self> {
        let across = libm::tan(camera.fov_x.to_radians() / 2.0);
        let up = across * f64::from(film.height) / f64::from(film.width.max(1));
        let good = across.is_finite() && across > 0.0 && up > 0.0;
        good.then_some(())?;
        Some(Self { eye: camera.eye, axes: camera.axes()?, tangents: [across, up] })
    }

    /// Tangents of half the angles of view, across and up.
    pub(super) fn tangents(&self) -> [f64; 2] {
        self.tangents
    }

    /// A point as the camera sees it: to the right, up, and along the optical axis.
    fn local(&self, point: Vec3) -> Vec3 {
        let from = sub(point, self.eye);
        [dot(from, self.axes.right), dot(from, self.axes.up), dot(from, self.axes.forward)]
    }

    /// How far a local point lies inside each of the five planes: left, right, bottom, top, and that through the eye.
    fn inside(&self, [x, y, z]: Vec3) -> [f64; 5] {
        let [across, up] = self.tangents;
        [x + z * across, z * across - x, y + z * up, z * up - y, z]
    }

    /// Whether the box may be seen; false only where it lies outside one of the planes.
    pub fn may_see(&self, bounds: Bounds) -> bool {
        let corners = bounds.corners().map(|corner| self.inside(self.local(corner)));
        (0..5).all(|plane| corners.iter().any(|corner| corner[plane] >= 0.0))
    }

    /// The distances at which a triangle is seen, what hides it aside; none where it lies outside.
    pub fn sees(&self, triangle: [Vec3; 3]) -> Option<Span> {
        let polygon = self.cut(triangle)?;
        let depths = polygon.iter().map(|point| point[2]);
        let near = depths.clone().fold(f64::INFINITY, f64::min);
        Some(Span { near, far: depths.fold(0.0, f64::max) })
    }

    /// A point in the middle of what is seen of a triangle, in the scene; none where it lies outside.
    pub fn seen_point(&self, triangle: [Vec3; 3]) -> Option<Vec3> {
        let mean = |points: &[Vec3]| {
            let share = 1.0 / points.len() as f64;
            points.iter().fold([0.0; 3], |sum, point| [0, 1, 2].map(|axis| sum[axis] + share * point[axis]))
        };
        let middle = mean(&triangle);
        if self.inside(self.local(middle)).iter().all(|side| *side >= 0.0) {
            return Some(middle);
        }
        let [x, y, z] = mean(&self.cut(triangle)?);
        let Axes { right, up, forward } = self.axes;
        Some([0, 1, 2].map(|axis| self.eye[axis] + x * right[axis] + y * up[axis] + z * forward[axis]))
    }

    /// How near and how far the corners of a box lie along the optical axis; below 0 behind the eye.
    pub fn depths(&self, bounds: Bounds) -> Span {
        let depths = bounds.corners().map(|corner| self.local(corner)[2]);
        let near = depths.into_iter().fold(f64::INFINITY, f64::min);
        Span { near, far: depths.into_iter().fold(f64::NEG_INFINITY, f64::max) }
    }

    /// What is seen of a triangle, as a polygon with local corners (Sutherland and Hodgman 1974); none where it lies outside.
    pub(super) fn cut(&self, triangle: [Vec3; 3]) -> Option<Vec<Vec3>> {
        let corners = triangle.map(|corner| self.local(corner));
        let sides = corners.map(|corner| self.inside(corner));
        if (0..5).any(|plane| sides.iter().all(|side| side[plane] < 0.0)) {
            return None;
        }
        let mut polygon = corners.to_vec();
        for plane in 0..5 {
            let mut cut = Vec::with_capacity(polygon.len() + 1);
            for at in 0..polygon.len() {
                let (from, to) = (polygon[at], polygon[(at + 1) % polygon.len()]);
                let (a, b) = (self.inside(from)[plane], self.inside(to)[plane]);
                if a >= 0.0 {
                    cut.push(from);
                }
                if (a >= 0.0) != (b >= 0.0) {
                    let share = a / (a - b);
                    cut.push([0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis])));
                }
            }
            polygon = cut;
            if polygon.is_empty() {
                return None;
            }
        }
        Some(polygon)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Filter;

    fn frustum() -> Frustum {
        let camera = Camera {
            name: None,
            eye: [0.0, -10.0, 0.0],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_x: 90.0,
            near: None,
            far: None,
        };
        let film = Film { width: 200, height: 100, filter: Filter::Box { radius: 0.5 } };
        Frustum::of(&camera, &film).expect("a regular camera")
    }

    #[test]
    fn triangles_are_cut_at_the_edges_of_the_image() {
        let frustum = frustum();
        let at = |x: f64, z: f64| [[x, 0.0, z], [x + 1.0, 0.0, z], [x, 0.0, z + 1.0]];
        assert_eq!(frustum.sees(at(0.0, 0.0)), Some(Span { near: 10.0, far: 10.0 }));
        // The image is 20 wide and 10 high at the distance of the origin.
        assert!(frustum.sees(at(9.5, 0.0)).is_some() && frustum.sees(at(10.5, 0.0)).is_none());
        assert!(frustum.sees(at(0.0, 4.5)).is_some() && frustum.sees(at(0.0, 5.5)).is_none());
        assert!(frustum.sees(at(0.0, 0.0).map(|point| [point[0], -11.0, point[2]])).is_none(), "behind the eye");
        // A floor that runs under the eye is seen from where the image begins.
        let floor = [[-100.0, -100.0, -1.0], [100.0, -100.0, -1.0], [0.0, 100.0, -1.0]];
        let seen = frustum.sees(floor).expect("it is seen");
        assert!((seen.near - 2.0).abs() < 1e-9 && (seen.far - 110.0).abs() < 1e-9, "{seen:?}");
        let point = frustum.seen_point(floor).expect("it is seen");
        assert!(frustum.inside(frustum.local(point)).iter().all(|side| *side >= 0.0) && (point[2] + 1.0).abs() < 1e-9);
        assert_eq!(frustum.depths(Bounds::of_triangle(floor)), Span { near: -90.0, far: 110.0 });
    }

    #[test]
    fn boxes_outside_one_plane_are_not_seen() {
        let frustum = frustum();
        let cube = |center: Vec3| Bounds { low: center.map(|x| x - 0.5), high: center.map(|x| x + 0.5) };
        assert!(frustum.may_see(cube([0.0; 3])) && frustum.may_see(cube([10.0, 0.0, 0.0])));
        assert!(!frustum.may_see(cube([12.0, 0.0, 0.0])) && !frustum.may_see(cube([0.0, -12.0, 0.0])));
    }
}
