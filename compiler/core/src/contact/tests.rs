//! Contacts of small scenes, and of random ones against every pair of triangles.

use super::overlap::{Distances, Triangle, overlap};
use super::*;
use crate::diag::Sources;
use crate::eval::{Overrides, evaluate};
use crate::files::{MemoryFiles, VPath};
use crate::ir::Scene;
use proptest::prelude::*;

fn scene(items: &str) -> Scene {
    let mut files = MemoryFiles::default();
    let settings = "camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(64, 64)\n\
                    integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n";
    let floor = "shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)\n";
    files.insert(
        "page.lts",
        format!("lts 1\nscene page {{}}\n{settings}material glass = dielectric(ior: 1.5)\n{floor}{items}\n"),
    );
    let path = VPath::resolve("", "page.lts").expect("a path");
    let evaluated = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
    evaluated.scene.unwrap_or_else(|| panic!("{:?}", evaluated.findings))
}

/// The contacts of a scene by the names of both, with the areas within both distances, the same way and opposite.
fn contacts(items: &str) -> Vec<(String, [[f64; 2]; 2])> {
    let scene = scene(items);
    let survey = Survey::of(&scene);
    let name = |at: usize| survey.placed[at].name();
    let areas = |overlap: Overlap| [overlap.near, overlap.coplanar].map(|area| (area * 1e6).round() / 1e6);
    let one = |contact: &Contact| {
        let [a, b] = contact.uses.map(name);
        (format!("{a} {b}"), [areas(contact.same), areas(contact.opposite)])
    };
    Contacts::of(&survey).found.iter().map(one).collect()
}

const NONE: [f64; 2] = [0.0, 0.0];

#[test]
fn a_box_touches_the_floor_with_its_underside() {
    for material in ["glass", "diffuse(0.4)"] {
        let on = |z: &str| contacts(&format!("shape block = box(x: -1..1, y: -1..1, z: {z}) with {material}"));
        assert_eq!(on("0..2"), [("floor block".to_owned(), [NONE, [4.0, 4.0]])], "{material}");
        assert_eq!((on("-0.1..2"), on("0.1..2")), (vec![], vec![]), "sunk and lifted, {material}");
    }
    let glass = contacts("shape block = box(x: -1..1, y: -1..1, z: 0.0003..2) with glass");
    assert_eq!(glass, [("floor block".to_owned(), [NONE, [4.0, 0.0]])], "a little off");
    assert_eq!(contacts("shape block = box(x: -1..1, y: -1..1, z: 0.0003..2) with diffuse(0.4)"), []);
}

#[test]
fn lines_are_no_contacts() {
    let crossing = "shape wall = rectangle(x: -5..5, y: 5, z: 0..5, normal: -Y) with diffuse(0.4)
        shape plate = box(x: -1..1, y: 0..0.1, z: -1..1) with glass
        shape leaning = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) |> rotate(x: 10deg) with glass
        shape beside = rectangle(x: 5..6, y: -5..5, z: 0, normal: Z) with diffuse(0.4)
        emitter lamp = rectangle(x: -1..1, y: 4..5, z: 4, normal: -Z) with radiance(1)";
    assert_eq!(contacts(crossing), []);
}

#[test]
fn surfaces_of_one_material_are_contacts_too() {
    let pair = "material white = diffuse(0.5)
        shape one = box(x: 1..2, y: 1..2, z: 1..2) with white
        shape other = box(x: 1.5..2.5, y: 1..2, z: 1..2) with white
        shape third = box(x: -2..-1, y: 1..2, z: 1..2) with white
        emitter lamp = rectangle(x: -1.75..-1.25, y: 1.25..1.75, z: 2.0001, normal: Z) with radiance(1)";
    // Top, bottom, front and back of half a box each; its two ends lie apart.
    assert_eq!(
        contacts(pair),
        [("one other".to_owned(), [[2.0, 2.0], NONE]), ("third lamp".to_owned(), [[0.25, 0.0], NONE])]
    );
    let scene = scene(pair);
    let survey = Survey::of(&scene);
    let found = places(&survey, [1, 2]);
    assert!(
        found.iter().all(|(place, normal)| {
            let [x, y, z] = *place;
            let on = |at: f64, axis: usize| (at - 1.5).abs() == 0.5 && normal[axis] == 2.0 * (at - 1.5);
            (1.5..=2.0).contains(&x) && (on(y, 1) || on(z, 2))
        }),
        "{found:?}"
    );
}

#[test]
fn walls_of_glass_can_be_too_thin() {
    let pane = |y: &str| contacts(&format!("shape pane = box(x: -1..1, y: {y}, z: 1..2) with glass"));
    assert_eq!(pane("0..0.0002"), [("pane pane".to_owned(), [NONE, [2.0, 0.0]])]);
    assert_eq!(pane("0..0.01"), []);
    // Smooth and curved, but nowhere thin.
    assert_eq!(contacts("shape ball = sphere(center: (0, 0, 2), segments: 64, rings: 32) with glass"), []);
}

#[test]
fn a_ball_hardly_touches_the_floor() {
    let found = contacts("shape ball = sphere(center: (0, 0, 1), segments: 200, rings: 100) with glass");
    let [(_, [_, [near, _]])] = found[..] else { panic!("{found:?}") };
    // The part of a sphere below the height h is 2 pi r h, h being 1.2e-3 at most.
    assert!(near < 0.001 * 12.6, "{near}");
}

#[test]
fn instances_are_what_copies_are() {
    let cells = "for i in 0..4, j in 0..4, k in 0..4 {";
    let group = format!(
        "group cell {{ shape cube = box(x: 0..1, y: 0..1, z: 1..2) with glass }}\n{cells} instance cell = cell |> translate(i, j, k) }}"
    );
    let copies = format!("{cells} shape cube = box(x: i..i + 1, y: j..j + 1, z: k + 1..k + 2) with glass }}");
    let (found, expected) = (contacts(&group), contacts(&copies));
    let areas = |found: &[(String, [[f64; 2]; 2])]| found.iter().map(|(_, areas)| *areas).collect::<Vec<_>>();
    // Three directions, four pairs along each line of five, 25 lines.
    assert_eq!(expected.len(), 3 * 4 * 25);
    assert_eq!(areas(&found), areas(&expected));
    assert!(found.iter().all(|(_, areas)| *areas == [NONE, [1.0, 1.0]]));
}

#[test]
fn work_is_limited() {
    let scene = scene("for i in 0..9 { shape cube = box(x: i..i + 1, y: 0..1, z: 1..2) with glass }");
    let survey = Survey::of(&scene);
    let whole = Contacts::of(&survey);
    assert_eq!((whole.found.len(), whole.left_out), (9, 0));
    let cut = search::Search::of(&survey).with_budget(40).run();
    assert!(cut.left_out > 0 && cut.found.len() < 9, "{cut:?}");
}

#[test]
fn what_is_kept_of_many_in_one_place_is_limited() {
    let scene = scene("for i in 0..59 { shape card = rectangle(x: 0..1, y: 0..1, z: 1, normal: Z) with glass }");
    let survey = Survey::of(&scene);
    let all = 60 * 59 / 2;
    let kept = |pairs, counted, contacts| {
        let found = search::Search::of(&survey).with_most(search::Most { pairs, counted, contacts }).run();
        (found.found.len(), found.left_out, found.uncounted)
    };
    assert_eq!(kept(all + 60, all, all + 60), (all, 0, false));
    // 60 of the pairs that are kept are those of each card with itself, which are looked at and touch nothing.
    assert_eq!(kept(160, all, all), (100, all - 100, false));
    assert_eq!(kept(all + 60, all, 20).0, 20);
    let (found, left_out, uncounted) = kept(160, 200, all);
    assert!(found == 100 && uncounted && (200..all - 100).contains(&left_out), "{found}, {left_out}");
}

#[test]
fn large_meshes_wait_for_small_ones() {
    let text = "shape one = sphere(center: (0, 0, 3), radius: 1, segments: 100, rings: 50) with glass
        shape two = sphere(center: (0.5, 0, 3), radius: 1, segments: 100, rings: 50) with glass
        for i in 0..3 { shape cube = box(x: i..i + 1, y: 0..1, z: 5..6) with glass }";
    let scene = scene(text);
    let survey = Survey::of(&scene);
    let whole = Contacts::of(&survey);
    assert!(whole.found.is_sorted_by_key(|contact| contact.uses) && whole.left_out == 0, "{whole:?}");
    // Enough for the cubes, and for the first sphere that is looked at.
    let cut = search::Search::of(&survey).with_budget(1000).run();
    let cubes: Vec<_> = whole.found.iter().filter(|contact| contact.uses[0] > 2).copied().collect();
    assert_eq!(cubes.len(), 3);
    assert_eq!((cut.found, cut.left_out), (cubes, 2));
}

/// Every pair of triangles, without boxes, trees or known poses.
fn by_force(survey: &Survey<'_>) -> Vec<([usize; 2], [f64; 2])> {
    let triangles: Vec<Vec<Triangle>> =
        survey.placed.iter().map(|placed| survey.triangles(placed).filter_map(Triangle::of).collect()).collect();
    let mut found = Vec::new();
    for one in 0..triangles.len() {
        for other in one + 1..triangles.len() {
            let [a, b] = [one, other].map(|at| &survey.placed[at]);
            let opaque = [a, b].iter().all(|placed| role(survey, placed) == Role::Opaque);
            // Far between the gaps that occur, and those that do not.
            let within = if opaque {
                Distances { near: 1e-4, coplanar: 1e-4 }
            } else {
                Distances { near: 0.002, coplanar: 1e-4 }
            };
            let mut areas = [0.0; 2];
            for first in &triangles[one] {
                for second in &triangles[other] {
                    if let Some((same, overlap)) = overlap(first, second, within) {
                        areas[usize::from(!same)] += overlap.near;
                    }
                }
            }
            if areas != [0.0; 2] {
                found.push(([one, other], areas));
            }
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn nothing_is_missed(items in prop::collection::vec((0_u8..4, any::<[u8; 3]>(), 0_u8..4, any::<bool>()), 2..12)) {
        let mut text = String::from(
            "let wave(x: number, y: number) = 0.2 * x\nmesh slope = height_field(wave, x: 0..4, y: 0..4, vertices: (13, 13))\n\
             mesh plane = height_field(wave, x: 0..4, y: 0..4, vertices: (3, 3))\nmesh cube = box(size: 2)\n",
        );
        for (at, (kind, [x, y, z], material, turned)) in items.iter().enumerate() {
            let mesh = ["slope", "plane", "cube", "rectangle(x: 0..2, y: 0..2, z: 0, normal: -Z)"][usize::from(*kind)];
            let with = ["glass", "diffuse(0.1)", "diffuse(0.2)", "diffuse(0.3)"][usize::from(*material)];
            let turn = if *turned { "|> rotate(z: 90deg) " } else { "" };
            let place = [x, y, z].map(|c| c % 4);
            text.push_str(&format!("shape s{at} = {mesh} {turn}|> translate({}, {}, {}) with {with}\n", place[0], place[1], place[2]));
        }
        let scene = scene(&text);
        let survey = Survey::of(&scene);
        let found: Vec<_> = Contacts::of(&survey).found.into_iter().filter(|contact| contact.uses[0] != contact.uses[1]).collect();
        let expected = by_force(&survey);
        prop_assert_eq!(found.iter().map(|contact| contact.uses).collect::<Vec<_>>(), expected.iter().map(|pair| pair.0).collect::<Vec<_>>());
        for (contact, (_, areas)) in found.iter().zip(&expected) {
            for (overlap, area) in [contact.same, contact.opposite].into_iter().zip(areas) {
                prop_assert!((overlap.near - area).abs() <= 1e-3 * (1.0 + area), "{:?} {}", contact, area);
            }
        }
    }
}
