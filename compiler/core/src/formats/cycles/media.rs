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
        let Material { name: _, bsdf, sides: _ } = &scene.materials[*material];
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
    use crate::diag::Origin;
    use crate::formats::shared::sample;
    use crate::ir::{Color, LightSource};

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

    /// A triangle at z = 0 whose front looks up, and behind which the logarithm of the index is 0.5 more.
    fn border(a: Vec3, b: Vec3, c: Vec3) -> Border {
        Border { bounds: Bounds::of_triangle([a, b, c]), triangles: vec![[a, b, c]], change: 0.5 }
    }

    #[test]
    fn a_line_enters_where_it_meets_a_triangle_from_its_front() {
        let one = [border([0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])];
        let through = |x: f64, y: f64| entered(&one, [x, y, 2.0], [x, y, -3.0]);
        assert_eq!((through(1.0, 2.0), through(2.0, 1.0), through(0.5, 0.25)), (Some(0.5), Some(0.5), Some(0.5)));
        assert_eq!(entered(&one, [1.0, 2.0, -3.0], [1.0, 2.0, 2.0]), Some(-0.5), "out of it");
        // Beside each of the three sides, inside the box and outside of it.
        for (x, y) in [(3.0, 2.0), (2.0, 3.0), (-1.0, 1.0), (1.0, -1.0), (5.0, 1.0), (1.0, 5.0)] {
            assert_eq!(through(x, y), Some(0.0), "{x}, {y}");
        }
        // On an edge or too near to it there is no answer; a millionth of the side away there is.
        for (x, y) in
            [(2.0, 2.0), (2.0, 0.0), (0.0, 2.0), (1.0, 1e-8), (1e-8, 1.0), (2.0, 2.0 - 1e-7), (2.0, 2.0 + 1e-7)]
        {
            assert_eq!(through(x, y), None, "{x}, {y}");
        }
        assert_eq!((through(1.0, 4e-6), through(2.0, 2.0 - 4e-6)), (Some(0.5), Some(0.5)));
        // A slanted line goes by where it meets the plane: (1, 1), and (3, 3).
        assert_eq!(entered(&one, [0.0, -1.0, 2.0], [2.0, 3.0, -2.0]), Some(0.5));
        assert_eq!(entered(&one, [1.0, 1.0, 2.0], [5.0, 5.0, -2.0]), Some(0.0));
        // A line that ends before the plane, at it, or begins behind it meets nothing; one that begins at it does.
        for (from, to) in [(2.0, 0.1), (2.0, 0.0), (-0.1, -3.0)] {
            assert_eq!(entered(&one, [1.0, 1.0, from], [1.0, 1.0, to]), Some(0.0), "{from}, {to}");
        }
        assert_eq!(entered(&one, [1.0, 1.0, 0.0], [1.0, 1.0, -3.0]), Some(0.5));
        assert_eq!(entered(&one, [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]), Some(0.0), "along the plane");
    }

    /// In sums over several borders, whatever their places and sizes.
    #[test]
    fn what_is_entered_adds_up() {
        let at = |x: f64, z: f64| border([x, 0.0, z], [x + 4.0, 1.0, z], [x, 4.0, z]);
        let several = [at(0.0, 0.0), at(0.0, 1.0), at(100.0, 0.5), Border { change: 0.25, ..at(0.0, 1.5) }];
        assert_eq!(entered(&several, [1.0, 2.0, 9.0], [1.0, 2.0, -9.0]), Some(1.25));
        assert_eq!(entered(&several, [1.0, 2.0, 1.25], [1.0, 2.0, -9.0]), Some(1.0));
        assert_eq!(entered(&several, [101.0, 2.0, -9.0], [101.0, 2.0, 9.0]), Some(-0.5));
        // Other sides, and one a thousand times as large.
        for turn in 0..3 {
            let place = |[x, y, z]: Vec3| {
                let mut turned = [1000.0 * x + 7.0, 1000.0 * y - 3.0, 1000.0 * z + 1.0];
                turned.rotate_right(turn);
                turned
            };
            let [a, b, c] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(place);
            let one = [border(a, b, c)];
            let of = |from: Vec3, to: Vec3| entered(&one, place(from), place(to));
            assert_eq!(of([1.0, 2.0, 2.0], [0.5, 1.0, -3.0]), Some(0.5), "{turn}");
            assert_eq!(of([3.0, 2.0, 2.0], [3.0, 1.5, -3.0]), Some(0.0), "{turn}");
        }
    }

    #[test]
    fn places_on_the_way_are_where_they_should_be() {
        assert_eq!(along([1.0, 2.0, 3.0], [10.0, -20.0, 30.0], 0.5), [6.0, -8.0, 18.0]);
        let found = middle([[1.0, 0.0, 10.0], [0.0, 1.0, 20.0], [0.0, 0.0, 30.0]]);
        let wanted = [0.31, 0.36, 20.2];
        assert!(found.iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-12), "{found:?}");
    }

    /// The camera looks at a floor from the side, below a sheet between indices of 3 and 2: 1.5 behind its normals, which look up.
    fn under_a_sheet(lights: &[LightKind]) -> Bound {
        let mut scene = sample::empty("sheet");
        let white = sample::material(&mut scene, "white", sample::diffuse([1.0; 3]));
        let glass = Bsdf::Dielectric { interior: 3.0, exterior: 2.0, alpha: 0.0 };
        let glass = sample::material(&mut scene, "glass", glass);
        let flat = |half: f64, z: f64| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
        let floor = sample::quads(&mut scene, "floor", &[flat(10.0, 0.0)]);
        sample::shape(&mut scene, "floor", floor, white, None);
        let sheet = sample::quads(&mut scene, "sheet", &[flat(1000.0, 80.0)]);
        sample::shape(&mut scene, "sheet", sheet, glass, None);
        for kind in lights {
            scene.lights.push(LightSource { name: "light".to_owned(), kind: kind.clone() }, Origin::Made);
        }
        bound(&scene).expect("a camera")
    }

    #[test]
    fn each_kind_of_light_is_looked_for_where_it_is() {
        let grey = || Color::Grey(1.0);
        let point = |z: f64| LightKind::Point { position: [3.0, 0.0, z], intensity: grey() };
        let spot = |z: f64| LightKind::Spot {
            position: [3.0, 0.0, z],
            target: [0.0; 3],
            intensity: grey(),
            angle: 30.0,
            inner: 20.0,
        };
        let sun = |z: f64| LightKind::Directional { direction: [0.0, 0.0, z], irradiance: grey() };
        let sky = LightKind::environment(Color::Grey(1.0).into());
        // From above the sheet Cycles gives 1 / 2.25 of the light, from below all of it.
        for (kind, enters) in [
            (point(200.0), true),
            (point(20.0), false),
            (spot(200.0), true),
            (spot(20.0), false),
            (sun(-1.0), true),
            (sun(1.0), false),
            (sky, true),
        ] {
            let found = under_a_sheet(std::slice::from_ref(&kind));
            let wanted = if enters { 1.0 - 1.0 / 2.25 } else { 0.0 };
            assert!((found.size - wanted).abs() < 1e-9, "{kind:?}: {found:?}");
            assert_eq!(found.what.contains("Cycles gives 0.4444 of it"), enters, "{found:?}");
        }
        // Of several the worst counts, whatever their order; none tells nothing.
        for kinds in [[point(200.0), point(20.0)], [point(20.0), point(200.0)]] {
            assert!((under_a_sheet(&kinds).size - (1.0 - 1.0 / 2.25)).abs() < 1e-9);
        }
        assert_eq!(under_a_sheet(&[]).size, 0.0);
    }

    /// A light in a ball of glass: Cycles gives 1.8^2 of what comes to a camera outside of it, more than what the other light is off by.
    #[test]
    fn a_lamp_in_glass_is_too_bright_by_the_square_of_the_index() {
        let lamp = |z: f64| LightKind::Point { position: [0.0, 0.0, z], intensity: Color::Grey(1.0) };
        let mut scene = with_glass([2.0; 3], [0.0, 0.0, 90.0]);
        for z in [80.0, 90.0, 70.0] {
            scene.lights.push(LightSource { name: "lamp".to_owned(), kind: lamp(z) }, Origin::Made);
        }
        let found = bound(&scene).expect("a camera");
        assert!((found.size - 2.24).abs() < 1e-9 && found.what.contains("gives 3.2400 of it"), "{found:?}");
        // One in glass of an index of 1.2 beside it is off by less, before and behind the first in the list.
        for places in [[70.0, 90.0], [90.0, 70.0]] {
            let mut scene = with_glass([2.0; 3], [0.0, 0.0, 90.0]);
            let weak =
                sample::material(&mut scene, "weak", Bsdf::Dielectric { interior: 1.2, exterior: 1.0, alpha: 0.0 });
            let mesh = sample::block(&mut scene, "weak", [2.0; 3], [0.0, 0.0, 70.0], 7.0);
            sample::shape(&mut scene, "weak", mesh, weak, None);
            for z in places {
                scene.lights.push(LightSource { name: "lamp".to_owned(), kind: lamp(z) }, Origin::Made);
            }
            assert!((bound(&scene).expect("a camera").size - 2.24).abs() < 1e-9, "{places:?}");
        }
    }

    /// At most 48 points: of many surfaces some with one each, of few all with several.
    #[test]
    fn points_are_spread_over_surfaces() {
        let looked_at = |shapes: &[usize]| {
            let mut scene = sample::empty("many");
            let white = sample::material(&mut scene, "white", sample::diffuse([1.0; 3]));
            for quads in shapes {
                let quad = |at: usize| {
                    let z = at as f64;
                    [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]]
                };
                let quads: Vec<[Vec3; 4]> = (0..*quads).map(quad).collect();
                let mesh = sample::quads(&mut scene, "quads", &quads);
                sample::shape(&mut scene, "quads", mesh, white, None);
            }
            bound(&scene).expect("a camera").what
        };
        let says = |shapes: &[usize], text: &str| {
            let found = looked_at(shapes);
            assert!(found.contains(&format!("(looked at for {text} in all, and at most 8 lights)")), "{found}");
        };
        // One of 20 triangles; two; five, of which each has nine: every third of 20 triangles, and all of 2.
        says(&[10], "1 of 1 surfaces that scatter, at 20 points");
        says(&[30], "1 of 1 surfaces that scatter, at 30 points");
        says(&[10, 10], "2 of 2 surfaces that scatter, at 40 points");
        says(&[10, 1, 1, 1, 1], "5 of 5 surfaces that scatter, at 15 points");
        // Of 48 surfaces all, of 49 every second, of 100 every third.
        says(&[1; 48], "48 of 48 surfaces that scatter, at 48 points");
        says(&[1; 49], "25 of 49 surfaces that scatter, at 25 points");
        says(&[1; 100], "34 of 100 surfaces that scatter, at 34 points");
        says(&[], "0 of 0 surfaces that scatter, at 0 points");
    }
}
