//! Whether the camera and the lights of a scene lie in the same medium.
//!
//! Radiance that enters a medium of index n grows by n^2 (Veach 1997, section 5.2), and Cycles leaves the factor out. It cancels
//! where light leaves the medium again before the camera. So what counts is how often a path from a light over a surface to the
//! camera enters dielectrics more often than it leaves them; straight lines tell that as well as bent ones.

use crate::capability::Bound;
use crate::ir::{Bsdf, Emission, LightKind, Material, Scene, Shape, Vec3, cross, dot, sub};
use crate::survey::{Bounds, Survey};

/// Points on surfaces that are looked at, and lights.
const POINTS: usize = 48;
const LIGHTS: usize = 8;

/// Triangles that share a box.
const CHUNK: usize = 64;

/// How near to the edge of a triangle a line may pass, as a share of its sides; nearer ones are not counted on.
const EDGE: f64 = 1e-7;

/// Some triangles of the border between two media.
struct Border {
    bounds: Bounds,
    triangles: Vec<[Vec3; 3]>,
    /// The logarithm of the index of refraction behind the normals, relative to that in front.
    change: f64,
}

/// The largest share by which Cycles is off for `scene`, over points of its surfaces, its cameras and its lights.
pub fn bound(scene: &Scene) -> Option<Bound> {
    let survey = Survey::of(scene);
    let (mut borders, mut solid) = (Vec::new(), Vec::new());
    let mut lights = Vec::new();
    for placed in &survey.placed {
        let Shape { name: _, mesh: _, transform: _, material, emission } = placed.shape;
        if let Some(Emission { radiance: _ }) = emission {
            lights.extend(survey.triangles(placed).next().map(middle));
        }
        let Material { name: _, bsdf } = &scene.materials[*material];
        match bsdf {
            Bsdf::Dielectric { interior, exterior, alpha: _ } => {
                let change = libm::log(interior / exterior);
                let all: Vec<[Vec3; 3]> = survey.triangles(placed).collect();
                borders.extend(all.chunks(CHUNK).map(|triangles| {
                    Border {
                        bounds: triangles
                            .iter()
                            .map(|one| Bounds::of_triangle(*one))
                            .reduce(Bounds::union)
                            .unwrap_or(placed.bounds),
                        triangles: triangles.to_vec(),
                        change,
                    }
                }));
            }
            Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Mirror { reflectance: _ }
            | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => solid.push(placed),
        }
    }
    let eyes: Vec<Vec3> = scene.cameras.values().map(|camera| camera.eye).collect();
    let far = survey.bounds.map_or(1.0, Bounds::diagonal);
    let stride = solid.len().div_ceil(POINTS).max(1);
    let each = (POINTS / solid.len().max(1)).max(1);
    let surfaces = solid.len();
    let points_of = surfaces.div_ceil(stride);
    let chosen = solid.into_iter().step_by(stride);
    let points: Vec<Vec3> = chosen
        .flat_map(|placed| {
            let count = scene.meshes[placed.shape.mesh].triangles.len();
            survey.triangles(placed).step_by(count.div_ceil(each).max(1)).map(middle)
        })
        .collect();
    let looked_at = format!(
        "looked at for {points_of} of {surfaces} surfaces that scatter, at {} points in all, and at most {LIGHTS} lights",
        points.len()
    );
    let mut worst: Option<(f64, f64)> = None;
    for (eye, point) in eyes.iter().flat_map(|eye| points.iter().map(move |point| (*eye, point))) {
        let Some(camera) = entered(&borders, eye, *point) else { continue };
        let distant = scene.lights.values().map(|light| match &light.kind {
            LightKind::Environment { radiance: _, tint: _, turn: _ } => along(*point, [0.0, 0.0, 1.0], far),
            LightKind::Point { position, intensity: _ }
            | LightKind::Spot { position, target: _, intensity: _, angle: _, inner: _ } => *position,
            LightKind::Directional { direction, irradiance: _ } => along(*point, *direction, -far),
        });
        for light in distant.chain(lights.iter().copied()).take(LIGHTS) {
            let Some(lit) = entered(&borders, light, *point) else { continue };
            // Cycles gives this share of the radiance.
            let share = libm::exp(2.0 * (camera - lit));
            let size = (share - 1.0).abs();
            if size > 1e-9 && worst.is_none_or(|(known, _)| size > known) {
                worst = Some((size, share));
            }
        }
    }
    Some(match worst {
        Some((size, share)) => Bound {
            size,
            what: format!(
                "of the light that comes to the camera from another medium: Cycles gives {share:.4} of it ({looked_at})"
            ),
        },
        None => {
            Bound { size: 0.0, what: format!("of the light: camera and lights lie in the same medium ({looked_at})") }
        }
    })
}

/// The logarithm of the index of refraction at `to`, relative to that at `from`; none where the line passes an edge.
fn entered(borders: &[Border], from: Vec3, to: Vec3) -> Option<f64> {
    let way = sub(to, from);
    let pick = |choose: fn(f64, f64) -> f64| [0, 1, 2].map(|axis| choose(from[axis], to[axis]));
    let line = Bounds { low: pick(f64::min), high: pick(f64::max) };
    let mut sum = 0.0;
    for border in borders.iter().filter(|border| border.bounds.common(line).is_some()) {
        for [a, b, c] in &border.triangles {
            let (ab, ac) = (sub(*b, *a), sub(*c, *a));
            let p = cross(way, ac);
            // Positive where the line comes from the front (Möller and Trumbore 1997).
            let determinant = dot(ab, p);
            if determinant == 0.0 {
                continue;
            }
            let s = sub(from, *a);
            let u = dot(s, p) / determinant;
            let q = cross(s, ab);
            let v = dot(way, q) / determinant;
            let t = dot(ac, q) / determinant;
            if !(0.0..1.0).contains(&t) {
                continue;
            }
            let inside = u.min(v).min(1.0 - u - v);
            if inside.abs() < EDGE {
                return None;
            }
            if inside > 0.0 {
                sum += if determinant > 0.0 { border.change } else { -border.change };
            }
        }
    }
    Some(sum)
}

fn along(from: Vec3, direction: Vec3, far: f64) -> Vec3 {
    [0, 1, 2].map(|axis| from[axis] + far * direction[axis])
}

fn middle([a, b, c]: [Vec3; 3]) -> Vec3 {
    // Not the middle itself, which lies on lines of symmetry and so on edges of other triangles.
    let weights = [0.31, 0.36, 0.33];
    [0, 1, 2].map(|axis| a[axis] * weights[0] + b[axis] * weights[1] + c[axis] * weights[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;

    /// The Cornell box with a block of glass.
    fn with_glass(size: Vec3, center: Vec3) -> Scene {
        let mut scene = sample::room();
        let glass = Bsdf::Dielectric { interior: 1.8, exterior: 1.0, alpha: 0.0 };
        let glass = sample::material(&mut scene, "glass", glass);
        let mesh = sample::block(&mut scene, "glass", size, center, 7.0);
        sample::shape(&mut scene, "glass", mesh, glass, None);
        scene
    }

    #[test]
    fn closed_glass_cancels() {
        let scene = with_glass([10.0, 20.0, 30.0], [0.0, 0.0, 15.5]);
        assert_eq!(bound(&scene).expect("a camera").size, 0.0);
    }

    #[test]
    fn a_camera_in_glass_sees_the_square_of_the_index_too_little() {
        // Everything lies inside, and so do the lights.
        let all = with_glass([2000.0; 3], [0.0; 3]);
        assert_eq!(bound(&all).expect("a camera").size, 0.0);
        let eye = all.cameras.values().next().expect("a camera").eye;
        let found = bound(&with_glass([0.5; 3], eye)).expect("a camera");
        // Light enters the glass, so that its radiance grows by 1.8^2, and Cycles gives 1 / 3.24 of it.
        assert!((found.size - (1.0 - 1.0 / 3.24)).abs() < 1e-9 && found.what.contains("0.3086"), "{found:?}");
    }
}
