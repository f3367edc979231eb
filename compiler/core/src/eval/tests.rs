//! The table explains itself, and lights of groups are where they should be.

use crate::diag::Sources;
use crate::files::{MemoryFiles, VPath};
use crate::ir::{Bsdf, Color, LightKind, LightSource};

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
    files.insert("sky.exr", include_bytes!("../../../../renderers/evaluation/conventions/images/sky.exr"));
    files.insert("textures/oak.png", include_bytes!("../../../../tests/cases/textures/quads.png"));
    files.insert("meshes/table.glb", include_bytes!("../../../../tests/cases/meshes/table.glb"));
    files.insert(
        "meshes/board.obj",
        "mtllib board.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\no top\nusemtl oak\nf 1/1 2/2 3/3\nusemtl glass\n\
         f 3 2 1\no side\nusemtl oak\nf 1 2 3\no lamp\nusemtl lamp\nf 1 2 3\n",
    );
    files.insert(
        "meshes/board.mtl",
        "newmtl oak\nKd 0.5 0.25 0\nmap_Kd ../textures/oak.png\nnewmtl glass\nKd 1 1 1\nNi 1.33\nillum 7\nnewmtl lamp\n\
         Kd 0 0 0\nKe 3 3 3\n",
    );
    files.insert("forest.npy", npy("(2, 3)", &[1.0, 2.0, 3.0, -4.0, 5.0, 6.5]));
    files.insert(
        "turned.npy",
        npy("(2, 3, 4)", &[0.0, -1.0, 0.0, 7.0, 1.0, 0.0, 0.0, 8.0, 0.0, 0.0, 1.0, 9.0].repeat(2)),
    );
    files.insert("heights.npy", npy("(2, 3)", &[1.0, 2.0, 3.0, -4.0, 5.0, 6.5]));
    let path = VPath::resolve("", "a.lts").expect("a path");
    evaluate(&files, &mut Sources::default(), &path, &Overrides::default())
}

/// A file as `numpy.save` writes it.
fn npy(shape: &str, numbers: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    bytes
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
fn images_of_one_file_keep_their_factors_apart() {
    let made = evaluated(
        "let oak = \"textures/oak.png\"\nmesh card = rectangle(x: 0..1, y: 0..1, z: 0, normal: Z)\n\
         shape a = card with diffuse(bitmap(oak))\nshape b = card with diffuse(bitmap(oak, scale: rgb(0.5, 0.25, 1)))\n\
         shape c = card with diffuse(bitmap(oak, scale: 0.5))\nshape d = card with diffuse(bitmap(oak, scale: 0.5))\n\
         group board = file(\"meshes/board.obj\")\ninstance one = board",
    );
    let scene = made.scene.unwrap_or_else(|| panic!("{:#?}", made.findings));
    let mut factors: Vec<[f64; 3]> = scene.textures.values().map(|texture| texture.factor).collect();
    factors.sort_by(|one, other| one.partial_cmp(other).expect("numbers"));
    // The last one is what `Kd` of the mesh file says.
    assert_eq!(factors, [[0.5, 0.25, 0.0], [0.5, 0.25, 1.0], [0.5; 3], [1.0; 3]]);
}

#[test]
fn an_environment_takes_no_image_with_a_factor() {
    let made = evaluated("emitter sky = environment(radiance: bitmap(\"sky.exr\", scale: 0.5))");
    let said: Vec<&str> = made.findings.iter().map(|finding| finding.message.as_str()).collect();
    assert!(said.contains(&"the image of an environment has no scale of its own"), "{said:?}");
    for (scale, id) in [
        ("2", "invalid-texture"),
        ("-0.1", "invalid-texture"),
        ("spectrum([(400, 0.1), (700, 0.2)])", "invalid-texture"),
    ] {
        let made = evaluated(&format!("material m = diffuse(bitmap(\"textures/oak.png\", scale: {scale}))"));
        assert!(made.findings.iter().any(|finding| finding.id == id), "{scale}: {:?}", made.findings);
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

const LAMP: &str = "group lamp {\n    shape foot = box(size: 1) with diffuse(0.5)\n    \
     emitter top = rectangle(x: -1..1, y: -1..1, z: 2, normal: Z) with radiance(1)\n    \
     emitter bulb = point(position: (1, 0, 2), intensity: 7)\n}\n";

#[test]
fn a_group_is_scattered_by_the_rows_of_an_array() {
    let Evaluated { scene, findings, .. } = evaluated(&format!(
        "{LAMP}group row {{\n    instance lamp = lamp |> scatter(\"forest.npy\")\n}}\n\
         instance far = lamp |> scale(2) |> scatter(\"turned.npy\") |> translate(0, 0, 100)\n\
         instance row = row |> translate(10, 0, 0)\n"
    ));
    let scene = scene.unwrap_or_else(|| panic!("{findings:#?}"));
    let names: Vec<&str> = scene.instances.values().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["far", "row"]);
    let far = scene.instances.values().next().expect("an instance");
    let rows = [[0.0, -2.0, 0.0, 7.0], [2.0, 0.0, 0.0, 8.0], [0.0, 0.0, 2.0, 109.0]];
    assert_eq!(far.places.maps(), [Affine { rows }; 2], "scaled, then placed by a row, then all of them moved");
    let lights: Vec<(&str, crate::ir::Vec3)> = scene
        .lights
        .values()
        .map(|light| match light.kind {
            LightKind::Point { position, .. } => (light.name.as_str(), position),
            ref other => panic!("{other:?}"),
        })
        .collect();
    let expected = [
        ("far[0]/bulb", [7.0, 10.0, 113.0]),
        ("far[1]/bulb", [7.0, 10.0, 113.0]),
        ("row/lamp[0]/bulb", [12.0, 2.0, 5.0]),
        ("row/lamp[1]/bulb", [7.0, 5.0, 8.5]),
    ];
    assert_eq!(lights, expected);
    // Emitters leave the groups, each at its own place.
    let (valid, _) = crate::pipeline::prepare(scene).expect("a valid scene");
    let emitters: Vec<&str> =
        valid.shapes.values().filter(|shape| shape.emission.is_some()).map(|shape| shape.name.as_str()).collect();
    assert_eq!(emitters, ["far[0]/top", "far[1]/top", "row/lamp[0]/top", "row/lamp[1]/top"]);
    let places: usize = valid.instances.values().map(|instance| instance.places.maps().len()).sum();
    assert_eq!((valid.groups.len(), valid.instances.len(), places), (1, 2, 4));
}

#[test]
fn tables_are_lists_of_lists() {
    let found = lights(
        "for row in table(\"heights.npy\") {\n    \
         emitter a = point(position: (row[0], row[1], row[2]), intensity: len(row))\n}\n",
    );
    let positions: Vec<_> = found
        .iter()
        .map(|light| match &light.kind {
            LightKind::Point { position, intensity } => (*position, intensity.clone()),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(positions, [([1.0, 2.0, 3.0], Color::Grey(3.0)), ([-4.0, 5.0, 6.5], Color::Grey(3.0))]);
}

#[test]
fn names_of_scattered_places_are_taken() {
    let id = |statements: &str| {
        let Evaluated { findings, .. } = evaluated(&format!("{LAMP}{statements}"));
        findings.iter().map(|finding| format!("{}: {}", finding.id, finding.message)).collect::<Vec<_>>()
    };
    let taken = ["duplicate-name: two instances are named `a[1]`"];
    assert_eq!(id("instance a = lamp |> scatter(\"forest.npy\")\nfor i in 1..2 {\n    instance a = lamp\n}\n"), taken);
    assert_eq!(id("for i in 1..2 {\n    instance a = lamp\n}\ninstance a = lamp |> scatter(\"forest.npy\")\n"), taken);
    let free = "for i in 2..3 {\n    instance a = lamp\n}\ninstance a = lamp |> scatter(\"forest.npy\")\n";
    assert_eq!(id(free), Vec::<String>::new());
}

#[test]
fn a_large_text_means_what_a_small_one_does() {
    let statements = |many: usize| {
        let filler: String = (0..many)
            .map(|at| format!("shape far{at} = box(size: 1) |> translate({at}, 2.5, 0.125) with diffuse(0.25)\n"))
            .collect();
        format!(
            "shape a = box(size: 1) with later\nlet first = 1\nlet vain = 1\nlet own = own + 1\n{filler}\
             shape b = box(size: sizes) with diffuse(first)\nlet x = = 1\nshape b = box(size: 1) with diffuse(0.5)\nshape b = box(size: 1) with diffuse(0.5)\n\
             {filler}material later = diffuse(0.5)\nshape c = box(size: size) with later\n"
        )
    };
    let told = |many: usize| -> Vec<(&'static str, String, usize)> {
        let Evaluated { findings, unused, .. } = evaluated(&statements(many));
        assert_eq!(unused.iter().map(|unused| unused.name.as_str()).collect::<Vec<_>>(), ["vain"]);
        findings.into_iter().map(|finding| (finding.id, finding.message, finding.labels.len())).collect()
    };
    // 2500 are 190 kB, twice: two batches.
    let (small, large) = (told(0), told(2500));
    assert!(large.len() > 2500, "the second filler repeats the names of the first");
    let large: Vec<_> = large.into_iter().filter(|(_, message, _)| !message.contains("`far")).collect();
    assert_eq!(small, large);
    let ids: Vec<&str> = small.iter().map(|(id, _, _)| *id).collect();
    assert_eq!(
        ids,
        ["unknown-name", "unknown-name", "unknown-name", "syntax-error", "duplicate-name", "unknown-name"],
        "{small:?}"
    );
    assert_eq!((small[0].2, small[1].2, small[2].2), (1, 1, 0), "declared below, in the same statement, nowhere");
}

#[test]
fn groups_of_files_have_their_materials() {
    let Evaluated { scene, findings, .. } = evaluated(
        "group board = file(\"meshes/board.obj\") |> scale(2)\ninstance board = board |> translate(1, 0, 0)\n\
         instance table = file(\"meshes/table.glb\")\n",
    );
    let scene = scene.unwrap_or_else(|| panic!("{findings:#?}"));
    let group = |name: &str| scene.groups.values().find(|group| group.name == name).expect("a group");
    let parts = |name: &str| -> Vec<(String, String, &Bsdf)> {
        let material = |shape: &crate::ir::Shape| &scene.materials[shape.material];
        let told = |shape: &crate::ir::Shape| (shape.name.clone(), material(shape).name.clone(), &material(shape).bsdf);
        group(name).shapes.values().map(told).collect()
    };
    let board = parts("board");
    let names: Vec<(&str, &str)> = board.iter().map(|(part, material, _)| (part.as_str(), material.as_str())).collect();
    assert_eq!(names, [("top oak", "oak"), ("top glass", "glass"), ("side", "oak"), ("lamp", "lamp")]);
    assert!(board[0].2.texture().is_some(), "{:?}", board[0].2);
    let plain = Bsdf::Diffuse { reflectance: Color::Rgb([0.5, 0.25, 0.0]).into() };
    assert_eq!(*board[2].2, plain, "without texture coordinates there is nothing to lay the image over");
    assert_eq!(*board[1].2, Bsdf::Dielectric { interior: 1.33, exterior: 1.0, alpha: 0.0 });
    let lamp = group("board").shapes.values().last().expect("a lamp");
    assert_eq!(lamp.emission.as_ref().map(|emission| emission.radiance.clone()), Some(Color::Grey(3.0)));
    let table = parts("table");
    let names: Vec<&str> = table.iter().map(|(part, _, _)| part.as_str()).collect();
    assert_eq!(names, ["crate", "window", "lamp", "knob"]);
    assert!(matches!(table[0].2, Bsdf::Principled { metallic: 0.0, roughness: 1.0, ior: 1.5, .. }), "{:?}", table[0].2);
    assert!(matches!(table[1].2, Bsdf::Dielectric { .. }) && matches!(table[3].2, Bsdf::Principled { .. }));
    assert!(scene.meshes.values().all(|mesh| mesh.normals.is_some()), "flat where the file has none");
    let codes: Vec<(&str, Severity)> = findings.iter().map(|finding| (finding.id, finding.severity)).collect();
    assert!(
        codes.contains(&("loss-dropped", Severity::Warn)) && codes.contains(&("loss-approximated", Severity::Info))
    );
    assert!(crate::pipeline::prepare(scene.clone()).is_ok());
}
