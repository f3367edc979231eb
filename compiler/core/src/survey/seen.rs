//! What each pixel of an image sees first: surfaces laid on the image, the nearest in front.

use crate::ir::{Camera, Film, Scene, Vec3};

use super::{Frustum, Survey};

/// No surface.
const NOTHING: u32 = u32::MAX;

/// What the pixels of an image see at their centers, what mirrors and glass show aside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// By pixel, row by row from the upper left: an index into [`Seen::things`]; `u32::MAX` where there is no surface.
    uses: Vec<u32>,
    /// What is seen somewhere.
    pub things: Vec<Thing>,
}

/// A use of a shape that is seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thing {
    /// The name of the shape, with that of its instance.
    pub name: String,
    /// The name of its material; may be empty.
    pub material: String,
    /// What the material is: `diffuse`, `conductor`.
    pub kind: &'static str,
    /// Whether it is a lamp.
    pub emits: bool,
}

impl Seen {
    /// Of a scene through one of its cameras, in an image of this size; none where the camera looks nowhere. Costs time linear in triangles
    /// and the pixels that they cover.
    pub fn of(scene: &Scene, camera: &Camera, (width, height): (usize, usize)) -> Option<Self> {
        let side = |pixels: usize| u32::try_from(pixels).ok();
        let film = Film { width: side(width)?, height: side(height)?, filter: scene.film.filter.clone() };
        let frustum = Frustum::of(camera, &film)?;
        let survey = Survey::of(scene);
        let mut depths = vec![f64::INFINITY; width * height];
        let mut uses = vec![NOTHING; width * height];
        for (at, placed) in survey.placed.iter().enumerate() {
            let Ok(at) = u32::try_from(at) else { break };
            if !frustum.may_see(placed.bounds) {
                continue;
            }
            for triangle in survey.triangles(placed) {
                let Some(polygon) = frustum.cut(triangle) else { continue };
                let corners: Vec<Vec3> =
                    polygon.iter().filter_map(|point| on_image(&frustum, *point, width, height)).collect();
                for fan in 1..corners.len().saturating_sub(1) {
                    fill([corners[0], corners[fan], corners[fan + 1]], width, height, |pixel, depth| {
                        if depth < depths[pixel] {
                            (depths[pixel], uses[pixel]) = (depth, at);
                        }
                    });
                }
            }
        }
        // Things are numbered as they are met, so that what is not seen has no entry.
        let mut number = vec![NOTHING; survey.placed.len()];
        let mut things = Vec::new();
        for seen in uses.iter_mut().filter(|seen| **seen != NOTHING) {
            let placed = &survey.placed[*seen as usize];
            let own = &mut number[*seen as usize];
            if *own == NOTHING {
                *own = things.len() as u32;
                let material = &scene.materials[placed.shape.material];
                things.push(Thing {
                    name: placed.name(),
                    material: material.name.clone(),
                    kind: material.bsdf.word(),
                    emits: placed.shape.emission.is_some(),
                });
            }
            *seen = *own;
        }
        Some(Self { width, height, uses, things })
    }

    /// What a pixel sees.
    pub fn thing(&self, pixel: usize) -> Option<&Thing> {
        self.things.get(*self.uses.get(pixel)? as usize)
    }

    /// Whether a pixel or one of its four neighbors sees something else: there edges lie, and what filters do differently.
    pub fn is_edge(&self, pixel: usize) -> bool {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let other = |x: usize, y: usize| self.uses[y * self.width + x] != self.uses[pixel];
        x > 0 && other(x - 1, y)
            || x + 1 < self.width && other(x + 1, y)
            || y > 0 && other(x, y - 1)
            || y + 1 < self.height && other(x, y + 1)
    }
}

/// Column and row of a point as the camera sees it, and one over its distance along the optical axis, which is linear over the image.
fn on_image(frustum: &Frustum, [x, y, z]: Vec3, width: usize, height: usize) -> Option<Vec3> {
    let [across, up] = frustum.tangents();
    let near = z > 1e-12;
    near.then(|| {
        let column = (x / (z * across) + 1.0) / 2.0 * width as f64;
        let row = (1.0 - y / (z * up)) / 2.0 * height as f64;
        [column, row, z.recip()]
    })
}

/// Gives each pixel whose center a triangle covers, with its distance along the optical axis.
fn fill(corners: [Vec3; 3], width: usize, height: usize, mut each: impl FnMut(usize, f64)) {
    let [a, b, c] = corners;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let reach = |axis: usize, most: usize| {
        let low = corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
        let from = (low - 0.5).ceil().clamp(0.0, most as f64) as usize;
        let to = ((high - 0.5).floor() + 1.0).clamp(0.0, most as f64) as usize;
        from..to
    };
    for row in reach(1, height) {
        let y = row as f64 + 0.5;
        for column in reach(0, width) {
            let x = column as f64 + 0.5;
            let share =
                |from: Vec3, to: Vec3| ((to[0] - from[0]) * (y - from[1]) - (x - from[0]) * (to[1] - from[1])) / area;
            let (of_c, of_a, of_b) = (share(a, b), share(b, c), share(c, a));
            if of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 {
                let near = of_a * a[2] + of_b * b[2] + of_c * c[2];
                if near > 0.0 {
                    each(row * width + column, near.recip());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;

    #[test]
    fn pixels_see_what_is_nearest() {
        let scene = sample::room();
        let camera = scene.cameras.values().next().expect("a camera");
        let seen = Seen::of(&scene, camera, (40, 30)).expect("an image");
        assert_eq!(seen.uses.len(), 1200);
        assert!(!seen.things.is_empty(), "something is seen");
        // The nearest surface along the ray through a pixel's center, found by brute force.
        let survey = Survey::of(&scene);
        let axes = camera.axes().expect("axes");
        let film = Film { width: 40, height: 30, filter: scene.film.filter.clone() };
        let [across, up] = Frustum::of(camera, &film).expect("a pyramid").tangents();
        let mut compared = 0;
        for pixel in (0..1200).step_by(37) {
            let x = ((pixel % 40) as f64 + 0.5) / 20.0 - 1.0;
            let y = 1.0 - ((pixel / 40) as f64 + 0.5) / 15.0;
            let ray = [0, 1, 2].map(|axis| axes.forward[axis] + x * across * axes.right[axis] + y * up * axes.up[axis]);
            let hits = survey.placed.iter().flat_map(|placed| {
                survey.triangles(placed).filter_map(|triangle| Some((hit(camera.eye, ray, triangle)?, placed.name())))
            });
            let nearest = hits.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, name)| name);
            // At a center just on an edge either is right.
            if !seen.is_edge(pixel) {
                assert_eq!(seen.thing(pixel).map(|thing| thing.name.clone()), nearest, "pixel {pixel}");
                compared += 1;
            }
        }
        assert!(compared > 10, "{compared}");
    }

    /// The distance along a ray to a triangle (Moller and Trumbore 1997).
    fn hit(eye: Vec3, ray: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f64> {
        use crate::ir::{cross, dot, sub};
        let (one, two) = (sub(b, a), sub(c, a));
        let p = cross(ray, two);
        let determinant = dot(one, p);
        if determinant.abs() < 1e-12 {
            return None;
        }
        let from = sub(eye, a);
        let u = dot(from, p) / determinant;
        let q = cross(from, one);
        let v = dot(ray, q) / determinant;
        let t = dot(two, q) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    }
}
