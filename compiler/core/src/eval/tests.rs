//! The table explains itself, and lights of groups are where they should be.

use crate::diag::Sources;
use crate::files::{MemoryFiles, VPath};
use crate::ir::{Color, LightKind, LightSource};

use super::*;

/// Settings of a scene, by the word that begins them.
const SETTINGS: [(&str, &str); 4] = [
    ("camera", "camera = perspective(eye: (0, -9, 2), target: (0, 0, 2), fov_x: 45deg)"),
    ("film", "film = image(8, 8)"),
    ("integrator", "integrator = path(max_depth: 3)"),
    ("sampler", "sampler = independent(samples: 4)"),
];

/// What the scene of these statements is; settings that are not among them are added.
fn evaluated(statements: &str) -> Evaluated {
    let mut text = "lts 1\nscene a {}\n".to_owned();
    for (word, setting) in SETTINGS {
        if !statements.starts_with(&format!("{word} ")) {
            text.push_str(&format!("{setting}\n"));
        }
    }
    let mut files = MemoryFiles::default();
    files.insert("a.lts", format!("{text}{statements}\n"));
    // What examples read.
    files.insert(
        "meshes/bunny.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    files.insert("textures/oak.png", include_bytes!("../../../../tests/cases/textures/quads.png"));
    let path = VPath::resolve("", "a.lts").expect("a path");
    evaluate(&files, &mut Sources::default(), &path, &Overrides::default())
}

#[test]
fn every_example_of_the_table_is_a_scene() {
    for row in table() {
        let Evaluated { scene, findings, .. } = evaluated(row.example);
        let bad: Vec<_> = findings.iter().filter(|finding| finding.severity >= Severity::Warn).collect();
        assert!(scene.is_some() && bad.is_empty(), "{}: {bad:#?}", row.name);
        assert!(row.example.contains(&format!("{}(", row.name)), "the example of {} does not show it", row.name);
    }
}

#[test]
fn every_row_of_the_table_says_what_it_is() {
    for row in table() {
        assert!(row.summary.ends_with('.'), "{}: {}", row.name, row.summary);
        assert!(row.positional <= row.params.len(), "{}", row.name);
        for param in row.params {
            assert!(!param.doc.is_empty() && !param.doc.ends_with('.'), "{}: {}", row.name, param.name);
        }
    }
}

fn lights(statements: &str) -> Vec<LightSource> {
    let Evaluated { scene, findings, .. } = evaluated(statements);
    scene.unwrap_or_else(|| panic!("{findings:#?}")).lights.values().cloned().collect()
}

#[test]
fn lights_of_groups_are_placed_by_each_instance() {
    let found = lights(
        "group lamp {\n    emitter bulb = point(position: (1, 0, 2), intensity: 7)\n}\n\
         group pair {\n    instance lamp = lamp |> rotate(z: 90deg)\n    shape foot = box(size: 1) with diffuse(0.5)\n}\n\
         for i in 0..1 {\n    instance pair = pair |> scale(2) |> translate(10 * i, 0, 0)\n}\n\
         emitter sun = directional(direction: (0, 0, -5), irradiance: rgb(1, 2, 3))\n",
    );
    let names: Vec<&str> = found.iter().map(|light| light.name.as_str()).collect();
    assert_eq!(names, ["sun", "pair[0]/lamp/bulb", "pair[1]/lamp/bulb"]);
    let sun = LightKind::Directional { direction: [0.0, 0.0, -1.0], irradiance: Color::Rgb([1.0, 2.0, 3.0]) };
    assert_eq!(found[0].kind, sun);
    for (light, x) in found[1..].iter().zip([0.0, 10.0]) {
        // (1, 0, 2) turns to (0, 1, 2), grows to (0, 2, 4), and moves; its intensity stays.
        let LightKind::Point { position, intensity } = &light.kind else { panic!("{light:?}") };
        let there = [x, 2.0, 4.0];
        assert!(position.iter().zip(there).all(|(a, b)| (a - b).abs() < 1e-12), "{position:?}");
        assert_eq!(*intensity, Color::Grey(7.0));
    }
}

#[test]
fn a_light_may_be_a_value() {
    let found = lights(
        "let bulb(x: number) = point(position: (x, 0, 0), intensity: 1)\nfor i in 1..2 {\n    emitter a = bulb(i)\n}\n",
    );
    let names: Vec<&str> = found.iter().map(|light| light.name.as_str()).collect();
    assert_eq!(names, ["a[1]", "a[2]"]);
}

#[test]
fn a_spot_turns_with_its_group() {
    let found = lights(
        "group stand {\n    emitter a = spot(position: (1, 0, 0), target: (2, 0, 0), intensity: 1, angle: 20deg)\n}\n\
         instance stand = stand |> rotate(z: 90deg) |> translate(z: 5)\n\
         emitter b = spot(position: (0, 0, 0), target: (2, 0, 0), intensity: 1, angle: 0.5rad, inner: 10deg)\n",
    );
    let near = |a: &[f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    let LightKind::Spot { angle, inner, .. } = &found[0].kind else { panic!("{found:?}") };
    assert!((angle - 0.5_f64.to_degrees()).abs() < 1e-12 && *inner == 10.0);
    let LightKind::Spot { position, target, angle, inner, .. } = &found[1].kind else { panic!("{found:?}") };
    assert!(near(position, [0.0, 1.0, 5.0]) && near(target, [0.0, 2.0, 5.0]), "{found:?}");
    // Left out, the inner cone is the whole: a sharp edge.
    assert_eq!((*angle, *inner), (20.0, 20.0));
}
