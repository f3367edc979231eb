//! Geometric rules judge shapes, and neither the units of a scene nor what lies far from everything else.

use std::collections::BTreeSet;
use std::sync::Arc;

use ltsc_core::diag::Sources;
use ltsc_core::eval::{Overrides, evaluate};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::ir::{Affine, LightKind, Places, Scene};
use ltsc_core::lint::{Around, Level, Levels, RULES, lint};

/// Rules about distances and sizes as such, in the units that renderers see, and about nothing that has a place.
const OF_SIZE: &[&str] = &["large-extent", "out-of-range-distance"];

/// Those within the epsilon of Mitsuba 3, 8.94e-5 (1 + coordinate): in scenes of a thousandth its absolute part is all of it.
const OF_UNITS: &[&str] = &["dielectric-contact", "emitter-in-wall"];

const SETTINGS: &str = "camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(64, 64)\n\
                        integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n";

/// Scenes with a finding of each geometric rule, and next to each the right form.
const SCENES: &[(&str, &str)] = &[
    (
        "emitter-facing-away",
        "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         emitter up = rectangle(x: 0..1, y: 0..1, z: 4, normal: Z) with radiance(1)
         emitter down = rectangle(x: 2..3, y: 0..1, z: 4, normal: -Z) with radiance(1)
         emitter spot = spot(position: (0, 0, 4), target: (0, 0, 5), intensity: 1, angle: 2deg)",
    ),
    (
        "overlapping-faces",
        "material grey = diffuse(0.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with grey
         shape carpet = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with diffuse(0.3)
         shape rug = rectangle(x: 2..3, y: -1..1, z: 0.001, normal: Z) with diffuse(0.3)
         shape chest = box(x: -3..-2, y: 0..1, z: 0..1) with grey
         shape wall = box(x: -5..5, y: 3..3.1, z: 0..5) with grey
         shape shelf = box(x: -1..1, y: 2..3.1, z: 2..2.1) with grey
         shape board = box(x: -1..1, y: 2..3.09, z: 3..3.1) with grey
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 5, normal: -Z) with radiance(1)",
    ),
    (
        "dielectric-contact",
        "material glass = dielectric(ior: 1.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape stands = box(x: -1..0, y: 0..1, z: 0..1) with glass
         shape floats = box(x: 1..2, y: 0..1, z: 0.5..1) with glass
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 5, normal: -Z) with radiance(1)",
    ),
    (
        "emitter-in-wall",
        "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape ceiling = rectangle(x: -5..5, y: -5..5, z: 5, normal: -Z) with diffuse(0.5)
         emitter flush = rectangle(x: 0..1, y: 0..1, z: 5, normal: -Z) with radiance(1)
         emitter hangs = rectangle(x: 2..3, y: 0..1, z: 4.5, normal: -Z) with radiance(1)",
    ),
    (
        "inside-out-mesh",
        "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape turned = box(size: 1) |> flip() |> translate(z: 3) with diffuse(0.5)
         shape right = box(size: 1) |> translate(x: 2, z: 3) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 5, normal: -Z) with radiance(1)",
    ),
    (
        "inside-out-dielectric",
        "material glass = dielectric(ior: 1.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape turned = sphere(segments: 16, rings: 8) |> flip() |> translate(z: 3) with glass
         shape right = sphere(segments: 16, rings: 8) |> translate(x: 3, z: 3) with glass
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "open-dielectric",
        "material glass = dielectric(ior: 1.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape pane = rectangle(x: 0..1, y: 2, z: 1..2, normal: -Y) with glass
         shape closed = box(x: 2..3, y: 2..2.5, z: 1..2) with glass
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "camera-in-dielectric",
        "material glass = dielectric(ior: 1.5)
         shape around = box(x: -1..1, y: -11..-9, z: 1..3) with glass
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "camera-inside-mesh",
        "shape around = box(x: -1..1, y: -11..-9, z: 1..3) with diffuse(0.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "nothing-in-view",
        "shape floor = rectangle(x: -5..5, y: -50..-40, z: 0, normal: Z) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: -45..-44, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "smooth-emitter",
        "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         emitter ball = sphere(segments: 16, rings: 8) |> translate(z: 3) with radiance(1)
         emitter flat = sphere(segments: 16, rings: 8) |> faceted() |> translate(x: 3, z: 3) with radiance(1)",
    ),
    (
        "far-from-origin",
        "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         shape sheet = box(x: 90..91, y: 90..91, z: 1..1.005) with diffuse(0.5)
         shape block = box(x: 90..91, y: 93..94, z: 1..1.5) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
    (
        "degenerate-triangles",
        "let corners = [(0, 0, 1), (1, 0, 1), (0, 1, 1), (2, 0, 1)]
         let up = [for p in corners: (0, 0, 1)]
         shape line = triangles(positions: corners, faces: [(0, 1, 2), (0, 1, 3)], normals: up) with diffuse(0.5)
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)
         emitter lamp = rectangle(x: 0..1, y: 0..1, z: 6, normal: -Z) with radiance(1)",
    ),
];

/// A box at 1e7, in the middle of nowhere.
const FAR: &str = "shape nowhere = box(size: 100, center: (10000000, 10000000, -10000000)) with diffuse(0.5)";

fn scene(items: &str) -> Scene {
    let mut files = MemoryFiles::default();
    files.insert("page.lts", format!("lts 1\nscene page {{}}\n{SETTINGS}{items}\n"));
    let path = VPath::resolve("", "page.lts").expect("a path");
    let evaluated = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
    evaluated.scene.unwrap_or_else(|| panic!("{:?}", evaluated.findings))
}

/// The scene in other units.
fn scaled(mut scene: Scene, by: f64) -> Scene {
    let map = |map: &mut Affine| map.rows.iter_mut().for_each(|row| row[3] *= by);
    let point = |point: &mut [f64; 3]| point.iter_mut().for_each(|x| *x *= by);
    for (_, mesh) in scene.meshes.iter_mut() {
        Arc::make_mut(&mut mesh.positions).iter_mut().flatten().for_each(|x| *x = (f64::from(*x) * by) as f32);
    }
    for (_, shape) in scene.shapes.iter_mut() {
        map(&mut shape.transform);
    }
    for (_, camera) in scene.cameras.iter_mut() {
        point(&mut camera.eye);
        point(&mut camera.target);
    }
    for (_, light) in scene.lights.iter_mut() {
        if let LightKind::Spot { position, target, .. } = &mut light.kind {
            point(position);
            point(target);
        }
    }
    assert!(scene.instances.values().all(|instance| matches!(instance.places, Places::One(_))), "none is made here");
    scene
}

/// What is found, without numbers, which are of other sizes.
fn verdicts(scene: &Scene, left_out: &[&[&str]]) -> BTreeSet<String> {
    let mut levels = Levels::default();
    for rule in RULES.iter().filter(|rule| rule.level == Level::Allow) {
        levels.set(rule.id, Level::Warn).expect("a rule");
    }
    let found = lint(scene, &Around::default(), &levels, &[]);
    let known = |id: &str| left_out.iter().any(|ids| ids.contains(&id));
    let words = |message: &str| message.chars().filter(|c| !c.is_ascii_digit() && *c != '.').collect::<String>();
    found.iter().filter(|one| !known(one.id)).map(|one| format!("{} {}", one.id, words(&one.message))).collect()
}

#[test]
fn what_lies_nowhere_near_changes_nothing() {
    for (rule, items) in SCENES {
        let alone = verdicts(&scene(items), &[OF_SIZE]);
        assert!(alone.iter().any(|line| line.starts_with(rule)), "{rule}: {alone:#?}");
        let mut with = verdicts(&scene(&format!("{items}\n{FAR}")), &[OF_SIZE]);
        // A box of 100 at 1e7 is thin there, and that is all.
        with.retain(|line| !line.contains("`nowhere`"));
        assert_eq!(alone, with, "{rule}");
    }
}

#[test]
fn other_units_change_nothing_but_what_is_about_them() {
    for (rule, items) in SCENES {
        for by in [1e-3, 1.0 / 1024.0, 1e4] {
            let left_out: &[&[&str]] = if by < 1.0 { &[OF_SIZE, OF_UNITS] } else { &[OF_SIZE] };
            let one = verdicts(&scene(items), left_out);
            let other = verdicts(&scaled(scene(items), by), left_out);
            assert_eq!(one, other, "{rule} by {by}");
        }
    }
}
