//! The numbers against formulas, and the pages against each other.

use crate::diag::Sources;
use crate::eval::{Overrides, evaluate};
use crate::files::{MemoryFiles, VPath};
use crate::ir::Scene;

use super::*;

fn scene(statements: &str) -> Scene {
    let text = format!(
        "lts 1\n/// Brief.\n///\n/// Full.\nscene a {{ paths: [\"LS+DE\", \"SGS\"], similar: [(\"b\", \"the other | one\")] }}\n\
         camera = perspective(eye: (0, -9, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(8, 8)\n\
         integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n{statements}\n"
    );
    let mut files = MemoryFiles::default();
    files.insert("a.lts", text);
    let path = VPath::resolve("", "a.lts").expect("a path");
    let made = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
    made.scene.unwrap_or_else(|| panic!("{:#?}", made.findings))
}

const ROOM: &str = "group cell {\n    shape b = box(size: 1) with diffuse(0.5)\n    emitter lamp = rectangle(x: 0..1, y: 0..2, z: 3, normal: -Z) with radiance(10)\n}\n\
    for i in 0..2 {\n    instance cell = cell |> scale(2) |> translate(10 * i, 0, 0)\n}\n\
    emitter bulb = point(position: (0, 0, 1), intensity: rgb(1, 2, 3))\n\
    emitter spot = spot(position: (0, 0, 5), target: (0, 0, 0), intensity: 1, angle: 60deg, inner: 60deg)\n";

#[test]
fn things_are_counted_and_measured() {
    let numbers = Numbers::of(&scene(ROOM));
    assert_eq!((numbers.triangles, numbers.placed_triangles, numbers.instances, numbers.shapes), (14, 42, 3, 2));
    assert_eq!(numbers.lights(), 5);
    let [lamp, bulb, spot] = &numbers.emitters[..] else { panic!("{:?}", numbers.emitters) };
    let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * b.abs();
    // Three lamps of 2 square units, each four times as large in the scene.
    let pi = std::f64::consts::PI;
    assert!(near(lamp.area, 24.0) && near(lamp.power.expect("a power")[1], pi * 24.0 * 10.0), "{lamp:?}");
    assert!(near(bulb.power.expect("a power")[2], 4.0 * pi * 3.0), "{bulb:?}");
    assert!(near(spot.power.expect("a power")[0], 2.0 * pi * (1.0 - 0.5)), "{spot:?}");
    assert_eq!(numbers.materials.len(), 1);
    let nested = "group a {\n    shape b = box(size: 1) with diffuse(0.5)\n}\ngroup c {\n    instance x = a\n    instance y = a |> translate(2)\n}\n\
        instance p = c\ninstance q = c |> translate(0, 5)\n";
    assert_eq!(instances(&scene(nested)), 6);
    let bounds = numbers.bounds.expect("a box");
    assert_eq!((bounds.low, bounds.high), ([-1.0, -1.0, -1.0], [22.0, 4.0, 6.0]));
}

#[test]
fn a_soft_spot_has_the_integral_of_its_cone() {
    let strengths = |inner: f64| {
        let text = format!(
            "emitter s = spot(position: (0, 0, 5), target: (0, 0, 0), intensity: 1, angle: 40deg, inner: {inner}deg)\n"
        );
        Numbers::of(&scene(&(text + "shape b = box(size: 1) with diffuse(0.5)"))).emitters[0].power.expect("a power")[0]
    };
    // The midpoint rule over the angle.
    let steps = 200_000;
    let (a, b) = (10_f64.to_radians(), 40_f64.to_radians());
    let sum: f64 = (0..steps)
        .map(|step| {
            let t = b * (f64::from(step) + 0.5) / f64::from(steps);
            let share = if t < a { 1.0 } else { (b - t) / (b - a) };
            2.0 * std::f64::consts::PI * share * libm::sin(t) * b / f64::from(steps)
        })
        .sum();
    assert!((strengths(10.0) / sum - 1.0).abs() < 1e-6);
    assert!(strengths(10.0) < strengths(39.0) && strengths(39.0) < strengths(40.0));
}

#[test]
fn coverage_knows_what_a_class_holds() {
    let scene = scene(ROOM);
    let text = coverage(&[&scene]);
    for row in ["| `LSDE` | x |", "| `LSSSDE` | x |", "| `LSGSE` | x |", "| `LDSGSE` | x |"] {
        assert!(text.contains(row), "{row}\n{text}");
    }
    assert!(!text.contains("| `LDE` |") && text.contains("With 1 surface, 3 of 3: `LDE`, `LGE`, `LSE`"), "{text}");
}

#[test]
fn drawings_show_edges_and_not_the_diagonals_of_faces() {
    let lines = |statements: &str| {
        let svg = diagram(&scene(statements)).expect("a drawing");
        assert!(!svg.contains("NaN") && svg.ends_with("</svg>\n"));
        svg.split("d=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap_or_default().matches(['H', 'V', 'L']).count())
            .collect::<Vec<_>>()
    };
    // From above a box is a square: four lines, and four of the camera; the same from the front.
    assert_eq!(lines("shape b = box(size: 1) with diffuse(0.5)"), [4, 4, 4, 4]);
    // A sphere's outline is a polygon.
    let round = lines("shape b = sphere(segments: 32, rings: 16) with diffuse(0.5)");
    assert!(round[0] >= 28 && round[0] <= 36, "{round:?}");
}

#[test]
fn pages_are_regular() {
    let scene = scene(ROOM);
    let pictures = Pictures {
        shown: vec![("Mitsuba 3".to_owned(), "a-mitsuba-3.png".to_owned())],
        facts: vec![("samples".to_owned(), "64".to_owned())],
    };
    let entry = Entry { scene: &scene, pictures: Some(&pictures) };
    let text = page(&entry, &["a", "b"]);
    assert!(text.contains("[b](b.md): the other | one") && text.contains("(pictures/a-mitsuba-3.png)"), "{text}");
    assert!(text.contains("| `LS+DE` | `LDD S+D DSE`, `LSD S+D DSE` | yes |"), "{text}");
    assert!(page(&entry, &["a"]).contains("- `b`: the other"));
    for text in [text, index(&[entry])] {
        let mut columns = 0;
        for line in text.lines() {
            let here = if line.starts_with('|') { line.replace("\\|", "").matches('|').count() } else { 0 };
            assert!(columns == 0 || here == 0 || here == columns, "{line}");
            columns = here;
        }
    }
}
