//! What formulas say of a micro-scene: the nearest surface along a ray, and its radiance where that has a closed form. It knows
//! the Scene and no renderer.
//!
//! Lamps have their radiance; diffuse surfaces and rough metal have that of point, spot and directional light (with
//! shadows), of polygons of light and of an even environment (both seen whole); an image of the environment
//! is seen as it is; smooth metal and mirrors show what they reflect.
//! Glass and light of several diffuse bounces have no closed form here, and give no number.

use ltsc_core::image::{self, Pixels, sphere};
use ltsc_core::ir::{
    Affine, Bsdf, Emission, Group, Instance, LightKind, Scene, Shape, Vec3, cross, dot, length, normalized, sub,
};
use ltsc_render::image::Image;
use std::f64::consts::PI;

use super::formula::{Metal, conductor, polygon};
use super::kinds::Region;

/// Rays to each pixel, on a lattice: each has a column and a row of its own.
const RAYS: usize = 32;

/// The step of the lattice from ray to ray, in rows.
const STEP: usize = 13;

/// How often reflections are followed.
const BOUNCES: usize = 8;

/// A ray starts this far from the surface that it leaves.
const START: f64 = 1e-7;

/// A triangle where it lies.
struct Triangle<'s> {
    corners: [Vec3; 3],
    /// Its own normal.
    flat: Vec3,
    /// Normals at its corners; the flat one where there are none.
    normals: [Vec3; 3],
    bsdf: &'s Bsdf,
    radiance: Option<[f64; 3]>,
}

/// Where a ray meets a surface.
struct Hit<'t, 's> {
    triangle: &'t Triangle<'s>,
    distance: f64,
    /// Of the corners.
    weights: [f64; 3],
}

/// A scene made ready for rays.
pub struct Ideal<'s> {
    scene: &'s Scene,
    triangles: Vec<Triangle<'s>>,
    environment: Option<[f64; 3]>,
    sky: Option<Sky>,
}

/// An image of the environment: its pixels, their factor, and from directions to those of the image.
struct Sky {
    pixels: Pixels,
    tint: [f64; 3],
    back: Affine,
}

impl Sky {
    /// The radiance that comes from a direction.
    fn seen(&self, to: Vec3) -> [f64; 3] {
        let color = sphere::seen(&self.pixels, self.back.point(to));
        [0, 1, 2].map(|channel| color[channel] * self.tint[channel])
    }
}

impl<'s> Ideal<'s> {
    /// Flattens the scene.
    pub fn new(scene: &'s Scene) -> Self {
        let mut triangles = Vec::new();
        for shape in scene.shapes.values() {
            add(scene, shape, &Affine::IDENTITY, &mut triangles);
        }
        for instance in scene.instances.values() {
            place(scene, instance, &Affine::IDENTITY, &mut triangles);
        }
        let environment = scene.lights.values().find_map(|light| match &light.kind {
            LightKind::Environment { radiance, tint: _, turn: _ } => radiance.color().map(ltsc_core::ir::Color::rgb),
            LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Directional { .. } => None,
        });
        let sky = scene.lights.values().find_map(|light| match &light.kind {
            LightKind::Environment { radiance, tint, turn } => {
                let texture = &scene.textures[radiance.texture()?];
                // A rotation's way back is its transpose.
                let back = Affine {
                    rows: [0, 1, 2].map(|row| [turn.rows[0][row], turn.rows[1][row], turn.rows[2][row], 0.0]),
                };
                Some(Sky { pixels: image::linear(texture).ok()?, tint: tint.rgb(), back })
            }
            LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Directional { .. } => None,
        });
        Self { scene, triangles, environment, sky }
    }

    /// The image of the first camera.
    pub fn image(&self) -> Image {
        let (width, height) = (self.scene.film.width as usize, self.scene.film.height as usize);
        let pixels = (0..width * height).map(|at| self.pixel(at % width, at / width).map(|value| value as f32));
        Image { width, height, pixels: pixels.collect() }
    }

    /// The mean over a region.
    pub fn mean(&self, region: &Region) -> [f64; 3] {
        let size = (self.scene.film.width as usize, self.scene.film.height as usize);
        let (columns, rows) = super::measure::pixels(region, size);
        let mut sum = [0.0; 3];
        for y in rows.clone() {
            for x in columns.clone() {
                let pixel = self.pixel(x, y);
                sum = [0, 1, 2].map(|channel| sum[channel] + pixel[channel]);
            }
        }
        let count = (columns.len() * rows.len()) as f64;
        sum.map(|value| value / count)
    }

    /// The mean over the rays to a pixel.
    fn pixel(&self, x: usize, y: usize) -> [f64; 3] {
        let Some(camera) = self.scene.cameras.values().next() else { return [f64::NAN; 3] };
        let Some(axes) = camera.axes() else { return [f64::NAN; 3] };
        let (width, height) = (f64::from(self.scene.film.width), f64::from(self.scene.film.height));
        let scale = 2.0 * (camera.fov_x / 2.0).to_radians().tan() / width;
        let mut sum = [0.0; 3];
        for ray in 0..RAYS {
            let within = |at: usize| (at as f64 + 0.5) / RAYS as f64;
            let across = (x as f64 + within(ray) - width / 2.0) * scale;
            let upward = (height / 2.0 - y as f64 - within(ray * STEP % RAYS)) * scale;
            let to = [0, 1, 2].map(|i| axes.forward[i] + across * axes.right[i] + upward * axes.up[i]);
            let Some(to) = normalized(to) else { continue };
            let light = self.radiance(camera.eye, to, BOUNCES);
            sum = [0, 1, 2].map(|channel| sum[channel] + light[channel]);
        }
        sum.map(|value| value / RAYS as f64)
    }

    /// The radiance that arrives at `from` from the direction `to`.
    fn radiance(&self, from: Vec3, to: Vec3, bounces: usize) -> [f64; 3] {
        let Some(hit) = self.trace(from, to) else {
            return self.sky.as_ref().map_or(self.environment.unwrap_or([0.0; 3]), |sky| sky.seen(to));
        };
        let triangle = hit.triangle;
        let mut light = match triangle.radiance {
            Some(radiance) if dot(triangle.flat, to) < 0.0 => radiance,
            Some(_) | None => [0.0; 3],
        };
        let point = along(from, to, hit.distance);
        let smooth = [0, 1, 2].map(|i| (0..3).map(|at| hit.weights[at] * triangle.normals[at][i]).sum());
        let smooth = normalized(smooth).unwrap_or(triangle.flat);
        // Surfaces scatter on both sides alike.
        let side = if dot(triangle.flat, to) > 0.0 { -1.0 } else { 1.0 };
        let (flat, smooth) = (triangle.flat.map(|x| side * x), smooth.map(|x| side * x));
        let back = to.map(|x| -x);
        let scattered = match triangle.bsdf {
            Bsdf::Diffuse { reflectance } => {
                let share = reflectance.color().map_or([f64::NAN; 3], ltsc_core::ir::Color::rgb);
                if share == [0.0; 3] {
                    return light;
                }
                let mut sum = self.lit_by_lights(point, flat, smooth, back, &|_, _| [1.0 / PI; 3]);
                for lamp in self.triangles.iter().filter(|lamp| dot(lamp.flat, sub(point, lamp.corners[0])) > START) {
                    let Some(radiance) = lamp.radiance else { continue };
                    let above = lamp.corners.map(|corner| dot(flat, sub(corner, point)) > 0.0);
                    if above == [false; 3] {
                        continue;
                    }
                    if above != [true; 3] {
                        // A polygon that the horizon cuts has another formula.
                        return [f64::NAN; 3];
                    }
                    let seen = polygon(&lamp.corners, point, smooth) / PI;
                    sum = [0, 1, 2].map(|channel| sum[channel] + seen * radiance[channel]);
                }
                let even = self.environment.unwrap_or([0.0; 3]);
                [0, 1, 2].map(|channel| share[channel] * (sum[channel] + even[channel]))
            }
            Bsdf::Conductor { eta, k, alpha } => {
                let (eta, k) = (eta.rgb(), k.rgb());
                let metals = [0, 1, 2].map(|i| Metal { eta: eta[i], k: k[i], alpha: *alpha });
                let cosine = dot(smooth, back);
                if *alpha == 0.0 {
                    let seen = self.reflected(point, to, smooth, bounces);
                    [0, 1, 2].map(|i| conductor(cosine, eta[i], k[i]) * seen[i])
                } else {
                    let scatter = |into: Vec3, n: Vec3| metals.map(|metal| metal.reflects(n, into, back));
                    let sum = self.lit_by_lights(point, flat, smooth, back, &scatter);
                    match self.environment {
                        Some(even) => [0, 1, 2].map(|i| sum[i] + even[i] * metals[i].albedo(cosine)),
                        None => sum,
                    }
                }
            }
            Bsdf::Mirror { reflectance } => {
                let (share, seen) = (reflectance.rgb(), self.reflected(point, to, smooth, bounces));
                [0, 1, 2].map(|i| share[i] * seen[i])
            }
            Bsdf::Dielectric { .. } | Bsdf::Plastic { .. } | Bsdf::Principled { .. } => [f64::NAN; 3],
        };
        light = [0, 1, 2].map(|channel| light[channel] + scattered[channel]);
        light
    }

    /// What is seen in a mirror.
    fn reflected(&self, point: Vec3, to: Vec3, normal: Vec3, bounces: usize) -> [f64; 3] {
        let twice = 2.0 * dot(to, normal);
        let away = [0, 1, 2].map(|i| to[i] - twice * normal[i]);
        if bounces == 0 { [f64::NAN; 3] } else { self.radiance(point, away, bounces - 1) }
    }

    /// The light of points, spots and directional light that `scatter` sends on: given the direction to the light and the normal, the
    /// reflectance distribution.
    fn lit_by_lights(
        &self,
        point: Vec3,
        flat: Vec3,
        smooth: Vec3,
        back: Vec3,
        scatter: &dyn Fn(Vec3, Vec3) -> [f64; 3],
    ) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for light in self.scene.lights.values() {
            let towards = |position: Vec3| {
                let way = sub(position, point);
                (normalized(way).unwrap_or(flat), length(way))
            };
            let (into, distance, across) = match &light.kind {
                LightKind::Environment { .. } => continue,
                LightKind::Point { position, intensity } => {
                    let (into, distance) = towards(*position);
                    (into, distance, intensity.rgb().map(|value| value / (distance * distance)))
                }
                LightKind::Spot { position, target, intensity, angle, inner } => {
                    let (into, distance) = towards(*position);
                    let axis = normalized(sub(*target, *position)).unwrap_or(flat);
                    let off = (-dot(axis, into)).clamp(-1.0, 1.0).acos().to_degrees();
                    let share = if off <= *inner {
                        1.0
                    } else if off >= *angle {
                        0.0
                    } else {
                        (angle - off) / (angle - inner)
                    };
                    (into, distance, intensity.rgb().map(|value| share * value / (distance * distance)))
                }
                LightKind::Directional { direction, irradiance } => {
                    let into = normalized(*direction).map_or(flat, |to| to.map(|x| -x));
                    (into, f64::INFINITY, irradiance.rgb())
                }
            };
            let cosine = dot(smooth, into);
            if cosine <= 0.0 || dot(flat, into) <= 0.0 || dot(smooth, back) <= 0.0 {
                continue;
            }
            if self.trace(point, into).is_some_and(|hit| hit.distance < distance) {
                continue;
            }
            let scattered = scatter(into, smooth);
            sum = [0, 1, 2].map(|channel| sum[channel] + scattered[channel] * across[channel] * cosine);
        }
        sum
    }

    /// The nearest triangle along a ray (Möller and Trumbore, 1997).
    fn trace(&self, from: Vec3, to: Vec3) -> Option<Hit<'_, 's>> {
        let mut nearest: Option<Hit<'_, 's>> = None;
        for triangle in &self.triangles {
            let [a, b, c] = triangle.corners;
            let (one, other) = (sub(b, a), sub(c, a));
            let p = cross(to, other);
            let volume = dot(one, p);
            if volume == 0.0 {
                continue;
            }
            let start = sub(from, a);
            let u = dot(start, p) / volume;
            let q = cross(start, one);
            let v = dot(to, q) / volume;
            let distance = dot(other, q) / volume;
            let beyond = nearest.as_ref().is_some_and(|hit| hit.distance <= distance);
            if u < 0.0 || v < 0.0 || u + v > 1.0 || distance <= START || beyond {
                continue;
            }
            nearest = Some(Hit { triangle, distance, weights: [1.0 - u - v, u, v] });
        }
        nearest
    }
}

fn along(from: Vec3, to: Vec3, distance: f64) -> Vec3 {
    [0, 1, 2].map(|i| from[i] + distance * to[i])
}

fn place<'s>(scene: &'s Scene, instance: &'s Instance, outer: &Affine, triangles: &mut Vec<Triangle<'s>>) {
    let Group { name: _, shapes, instances } = &scene.groups[instance.group];
    for map in instance.places.maps() {
        let map = map.then(outer);
        for shape in shapes.values() {
            add(scene, shape, &map, triangles);
        }
        for inner in instances.values() {
            place(scene, inner, &map, triangles);
        }
    }
}

fn add<'s>(scene: &'s Scene, shape: &'s Shape, outer: &Affine, triangles: &mut Vec<Triangle<'s>>) {
    let map = shape.transform.then(outer);
    let mesh = &scene.meshes[shape.mesh];
    let turn = map.cofactors();
    // The front stays the front where a map mirrors.
    let side = if map.determinant() < 0.0 { -1.0 } else { 1.0 };
    let normal = |n: Vec3| normalized([0, 1, 2].map(|i| side * dot(turn[i], n))).unwrap_or(n);
    for triangle in mesh.triangles.iter() {
        let corners = mesh.corners(*triangle).map(|corner| map.point(corner));
        let [a, b, c] = corners;
        let Some(flat) = normalized(cross(sub(b, a), sub(c, a)).map(|x| side * x)) else { continue };
        let normals = match &mesh.normals {
            Some(normals) => triangle.map(|at| normal(normals[at as usize].map(f64::from))),
            None => [flat; 3],
        };
        let radiance = shape.emission.as_ref().map(|Emission { radiance }| radiance.rgb());
        triangles.push(Triangle { corners, flat, normals, bsdf: &scene.materials[shape.material].bsdf, radiance });
    }
}
