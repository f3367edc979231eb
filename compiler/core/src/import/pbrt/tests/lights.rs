//! Lights with and without a surface.

use std::f64::consts::PI;

use super::*;
use crate::import::pbrt::light::square;
use crate::ir::{Color, LightKind};

const V4: &str = "Option \"integer seed\" 1";

fn light(read: &Read) -> &LightKind {
    &read.scene().lights.values().next().expect("a light").kind
}

fn radiance(read: &Read) -> [f64; 3] {
    read.shape(0).emission.as_ref().expect("an emission").radiance.rgb()
}

#[test]
fn surfaces_emit_on_the_side_of_their_normals() {
    let up = [0.0, 0.0, 1.0];
    let down = [0.0, 0.0, -1.0];
    let normals = |z: i32| {
        format!(
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \"normal N\" [0 0 {z} 0 0 {z} 0 0 {z}]"
        )
    };
    let cases = [
        (String::new(), TRIANGLE.to_owned(), up),
        ("ReverseOrientation".to_owned(), TRIANGLE.to_owned(), down),
        // The surface is mirrored, its front stays: PBRT takes the corners and turns them over for the transform.
        ("Scale -1 1 1".to_owned(), TRIANGLE.to_owned(), up),
        ("Scale 1 1 -1".to_owned(), TRIANGLE.to_owned(), down),
        ("Scale -1 1 1 ReverseOrientation".to_owned(), TRIANGLE.to_owned(), down),
        // Normals decide, whatever the corners say.
        (String::new(), normals(1), up),
        (String::new(), normals(-1), down),
        ("Scale -1 1 1".to_owned(), normals(1), up),
        ("ReverseOrientation".to_owned(), normals(1), down),
    ];
    for (before, shape, front) in cases {
        let read = super::read(&format!("{HEAD}AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] {before} {shape}"));
        assert!(close(&read.front(0), &front), "{before} {shape}: {:?}", read.front(0));
        assert_eq!(radiance(&read), [1.0, 2.0, 3.0]);
    }
}

#[test]
fn strengths_of_surfaces() {
    assert_eq!(
        radiance(&world("AreaLightSource \"area\" \"color L\" [1 2 3] \"integer nsamples\" 4")),
        [1.0, 2.0, 3.0]
    );
    assert_eq!(
        radiance(&world("AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"rgb scale\" [2 2 1]")),
        [2.0, 4.0, 3.0]
    );
    assert_eq!(radiance(&world("AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2")), [2.0, 4.0, 6.0]);
    let read = world("AreaLightSource \"diffuse\" \"bool twosided\" \"true\"");
    assert!(read.says(3, "loss-dropped", "both sides"));
    // A triangle of the area 1/2: 10 / (pi / 2).
    let read = super::read(&format!("{V4} {HEAD}AreaLightSource \"diffuse\" \"float power\" 10{TRIANGLE}"));
    assert!(close(&radiance(&read), &[20.0 / PI; 3]));
    // v4 divides by the luminance: a spectrum of 7 everywhere is one of 1.
    let emission = |mark: &str, text: &str| {
        let read = super::read(&format!("{mark} {HEAD}AreaLightSource \"diffuse\" {text}{TRIANGLE}"));
        let color = read.shape(0).emission.clone().expect("an emission").radiance;
        color.spectrum().expect("a spectrum").luminance()
    };
    assert!((emission(V4, "\"spectrum L\" [300 7 900 7]") - 1.0).abs() < 1e-9);
    assert!((emission("", "\"spectrum L\" [300 7 900 7]") - 7.0).abs() < 1e-9);
    assert!((emission(V4, "\"blackbody L\" 3000 \"float scale\" 4") - 4.0).abs() < 1e-9);
}

#[test]
fn a_black_body_of_v3_has_the_peak_1() {
    // 6000 K has its peak at 483 nm.
    let read = world("AreaLightSource \"diffuse\" \"blackbody L\" [6000 2.5]");
    let color = read.shape(0).emission.clone().expect("an emission").radiance;
    let spectrum = color.spectrum().expect("a spectrum").clone();
    assert!((spectrum.value(483.0) - 2.5).abs() < 1e-3);
    // exp(hc / kT) for 700 nm against 483 nm.
    let planck = |nm: f64| 1.0 / (libm::pow(nm, 5.0) * libm::expm1(1.438_776_877e7 / (nm * 6000.0)));
    assert!((spectrum.value(700.0) / 2.5 - planck(700.0) / planck(482.96)).abs() < 1e-3);
}

#[test]
fn points_and_spots() {
    let read = world(
        "Translate 0 0 7 LightSource \"point\" \"point from\" [1 2 3] \"rgb I\" [1 2 3] \"rgb scale\" [2 2 2] Identity",
    );
    assert_eq!(light(&read), &LightKind::Point { position: [1.0, 2.0, 10.0], intensity: Color::Rgb([2.0, 4.0, 6.0]) });
    let read = super::read(&format!("{V4} {HEAD}LightSource \"point\" \"float power\" 100{TRIANGLE}"));
    let LightKind::Point { position: _, intensity } = light(&read) else { panic!("no point") };
    assert!(close(&intensity.rgb(), &[100.0 / (4.0 * PI); 3]));
    let read = world(
        "LightSource \"spot\" \"point from\" [0 0 3] \"point to\" [1 0 3] \"float coneangle\" 40 \"float conedeltaangle\" 10 \"rgb I\" [5 5 5]",
    );
    assert!(read.says(3, "loss-approximated", "falls off linearly"));
    let known = LightKind::Spot {
        position: [0.0, 0.0, 3.0],
        target: [1.0, 0.0, 3.0],
        intensity: Color::Grey(5.0),
        angle: 40.0,
        inner: 30.0,
    };
    assert_eq!(light(&read), &known);
}

#[test]
fn parallel_light_goes_from_one_point_to_another() {
    let read = world("LightSource \"distant\" \"point from\" [0 0 4] \"point to\" [0 3 4] \"rgb L\" [1 2 3]");
    assert_eq!(
        light(&read),
        &LightKind::Directional { direction: [0.0, 1.0, 0.0], irradiance: Color::Rgb([1.0, 2.0, 3.0]) }
    );
    assert!(world("LightSource \"distant\" \"point to\" [0 0 0]").says(3, "loss-dropped", "without a direction"));
    let read = super::read(&format!("{V4} {HEAD}LightSource \"distant\" \"float illuminance\" 3{TRIANGLE}"));
    let LightKind::Directional { direction: _, irradiance } = light(&read) else { panic!("none") };
    assert_eq!(irradiance, &Color::Grey(3.0));
}

#[test]
fn environments_of_one_color() {
    let read = world("LightSource \"infinite\" \"rgb L\" [1 2 3]\nLightSource \"infinite\"");
    assert_eq!(light(&read), &LightKind::environment(Color::Rgb([1.0, 2.0, 3.0]).into()));
    assert!(read.says(4, "loss-dropped", "a second environment"));
    let read = super::read(&format!("{V4} {HEAD}LightSource \"infinite\" \"float illuminance\" 3{TRIANGLE}"));
    assert_eq!(light(&read), &LightKind::environment(Color::Grey(3.0 / PI).into()));
}

/// An image whose pixels say where they are: u, v, 1.
fn map(width: usize, height: usize) -> Vec<u8> {
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32, 1.0]
    };
    write::pfm(&Pixels { width, height, channels: 3, values: (0..width * height).flat_map(pixel).collect() })
}

/// What the Scene's environment has in a direction.
fn seen(read: &Read, direction: [f64; 3]) -> [f64; 3] {
    let LightKind::Environment { radiance, tint: _, turn } = light(read) else { panic!("no environment") };
    let texture = &read.scene().textures[radiance.texture().expect("an image")];
    assert!(turn.is_rotation(), "{turn:?}");
    let pixels = crate::image::linear(texture).expect("pixels");
    // The way back of a rotation is its transpose.
    let back =
        [0, 1, 2].map(|column: usize| crate::ir::dot([0, 1, 2].map(|row: usize| turn.rows[row][column]), direction));
    crate::image::sphere::seen(&pixels, back)
}

/// Directions, not on an axis, as the file's world has them.
const DIRECTIONS: [[f64; 3]; 4] = [[0.5, 0.6, 0.2], [-0.4, 0.3, -0.7], [0.2, -0.8, 0.3], [-0.9, -0.3, 0.1]];

fn unit(direction: [f64; 3]) -> [f64; 3] {
    crate::ir::normalized(direction).expect("a direction")
}

/// v3: phi of a direction is atan2(y, x), from 0 to 2 pi, and u = phi / 2 pi; v = theta / pi from +z (`InfiniteAreaLight::Le`).
#[test]
fn an_environment_of_v3_is_seen_where_v3_sees_it() {
    let file = map(64, 32);
    let cases = [(HEAD, ""), (HEAD, "Rotate 30 0 0 1 Rotate 50 1 0 0"), (HEAD, "Scale -1 1 1 Rotate 20 0 1 0")];
    for (head, transform) in cases {
        let text = format!(
            "{head}AttributeBegin {transform} LightSource \"infinite\" \"string mapname\" \"m.pfm\" \"rgb L\" [2 2 2] AttributeEnd\n{transform}{TRIANGLE}"
        );
        let read = read_with(&text, &[("a/m.pfm", &file)]);
        assert_eq!(read.said(), [], "{transform}");
        for local in DIRECTIONS.map(unit) {
            let phi = libm::atan2(local[1], local[0]).rem_euclid(2.0 * PI);
            let known = [phi / (2.0 * PI), libm::acos(local[2]) / PI];
            let found = seen(&read, read.shape(0).transform.vector(local));
            assert!(
                (found[0] - known[0]).abs() < 1e-3 && (found[1] - known[1]).abs() < 1e-3,
                "{transform} {local:?}: {found:?} {known:?}"
            );
        }
        let LightKind::Environment { radiance: _, tint, turn: _ } = light(&read) else { panic!("no environment") };
        assert_eq!(tint, &Color::Grey(2.0));
    }
    // The world is mirrored, and the environment with it.
    let left = format!(
        "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" WorldBegin LightSource \"infinite\" \"string mapname\" \"m.pfm\"{TRIANGLE}"
    );
    let read = read_with(&left, &[("a/m.pfm", &file)]);
    for local in DIRECTIONS.map(unit) {
        let phi = libm::atan2(local[1], local[0]).rem_euclid(2.0 * PI);
        let found = seen(&read, [-local[0], local[1], local[2]]);
        assert!((found[0] - phi / (2.0 * PI)).abs() < 1e-3, "{local:?} {found:?}");
    }
}

#[test]
fn an_environment_of_v4_is_seen_where_v4_sees_it() {
    let file = map(64, 64);
    for transform in ["", "Rotate 30 0 0 1 Rotate 50 1 0 0", "Scale -1 1 1 Rotate 20 0 1 0"] {
        let text = format!(
            "{V4} {HEAD}AttributeBegin {transform} LightSource \"infinite\" \"string filename\" \"m.pfm\" \"float scale\" 3 AttributeEnd\n{transform}{TRIANGLE}"
        );
        let read = read_with(&text, &[("a/m.pfm", &file)]);
        assert!(
            read.says(3, "loss-approximated", "on an octahedron becomes an image of 128 x 64"),
            "{:?}",
            read.said()
        );
        for local in DIRECTIONS.map(unit) {
            let known = square(local);
            let found = seen(&read, read.shape(0).transform.vector(local));
            // Where the square is folded its numbers jump; the directions are not there.
            assert!(
                (found[0] - known[0]).abs() < 0.02 && (found[1] - known[1]).abs() < 0.02,
                "{transform} {local:?}: {found:?} {known:?}"
            );
        }
    }
}

#[test]
fn the_square_and_the_sphere_are_one() {
    for at in 0..400 {
        let place = [(at % 20) as f64 / 20.0 + 0.025, (at / 20) as f64 / 20.0 + 0.025];
        assert!(close(&square(crate::image::sphere::direction(place)), &place), "{place:?}");
    }
}
