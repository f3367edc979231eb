//! Small scenes for one thing each: mirrors, groups within groups, emitters in groups, one mesh in many shapes.
//!
//! What every target's text says of where meshes lie and which of them shine is read back and compared with the scene, each reader
//! knowing no more than the format. Renderers (`render`) and Blender's importer (`blender`) look at the same scenes.

use std::collections::BTreeMap;

use ltsc_core::files::{MemoryFiles, MemorySink};
use ltsc_core::formats::{self, Choices};
use ltsc_core::ir::Affine;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::survey::Survey;
use ltsc_core::valid::Valid;

use super::mitsuba::{Element, parse};
use super::render::room_text;
use super::{files_below, prepared, root};

/// Things to put into a room of 10 x 10 x 10 above the origin.
pub const THINGS: &[(&str, &str)] = &[
    ("one_mirror", "shape m = box(size: 3) |> rotate(z: 20deg) |> translate(z: 2.5) with mirror()"),
    (
        "two_mirrors",
        "shape l = rectangle(x: -3, y: -2..4, z: 1..7, normal: X) with mirror(reflectance: 0.9)\n\
         shape r = rectangle(x: 3, y: -2..4, z: 1..7, normal: -X) with mirror(reflectance: rgb(0.9, 0.7, 0.5))\n\
         shape between = sphere(segments: 32, rings: 16) |> translate(0, 1, 3) with diffuse(rgb(0.8, 0.6, 0.2))",
    ),
    (
        "nested",
        "group ball {\n    shape one = box(size: 1) with diffuse(rgb(0.2, 0.6, 0.8))\n    \
         shape two = box(size: 0.5) |> rotate(z: 45deg) |> translate(z: 1) with mirror(reflectance: 0.8)\n}\n\
         group row {\n    instance a = ball |> translate(x: -1.5)\n    instance b = ball |> scale(1.5) |> translate(x: 1)\n    \
         shape own = box(size: (4, 0.5, 0.5)) |> translate(z: -1.2) with diffuse(0.5)\n}\n\
         instance x = row |> translate(0, -1, 3)\ninstance y = row |> rotate(z: 30deg) |> translate(0, 2, 6)",
    ),
    (
        "lamps",
        "group lantern {\n    shape case = box(size: 1) with diffuse(rgb(0.8, 0.6, 0.2))\n    \
         emitter lamp = box(size: 0.6) |> translate(z: 1.2) with radiance(rgb(6, 4, 2))\n}\n\
         for i in -1..1 { instance l = lantern |> rotate(z: 20deg * i) |> translate(3 * i, 0, 3) }\n\
         instance high = lantern |> rotate(x: 90deg) |> scale(1.5) |> translate(0, 1, 7)",
    ),
    (
        "one_mesh",
        "mesh block = box(size: 1)\nmaterial grey = diffuse(0.5)\n\
         for i in -1..1 { shape b = block |> rotate(z: 25deg * i) |> translate(3 * i, 0, 3) with grey }\n\
         shape metal = block |> scale(x: 1, y: 2, z: 3) |> translate(0, 3, 5) with mirror(reflectance: 0.9)\n\
         emitter glow = block |> scale(0.5) |> translate(0, -3, 6) with radiance(rgb(6, 4, 2))",
    ),
];

/// The scene of a thing in its room.
pub fn scene(name: &str, thing: &str) -> Valid {
    let mut files = MemoryFiles::default();
    let file = format!("{name}.lts");
    files.insert(file.clone(), room_text(name, 6, thing));
    prepared(&files, &file)
}

/// A use of a mesh: the stem of its file, whether it shines, and where it lies.
type Use = (String, bool, Affine);

/// Reads the uses of meshes in a target's text.
type Reader = fn(&str) -> Vec<Use>;

fn affine(numbers: &[f64], by_columns: bool) -> Affine {
    let width = if numbers.len() == 16 { 4 } else { 3 };
    let at = |row: usize, column: usize| {
        if by_columns { numbers[column * width + row] } else { numbers[row * 4 + column] }
    };
    Affine { rows: [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| at(row, column))) }
}

/// The numbers in a text, whatever stands between them.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    words.filter(|word| !word.is_empty()).map(|word| word.parse().unwrap_or_else(|_| panic!("{word}"))).collect()
}

fn stem(path: &str) -> String {
    path.rsplit('/').next().unwrap_or_default().trim_end_matches(".ply").to_owned()
}

/// What stands between the first and the second `"` of a text, and the rest.
fn quoted(text: &str) -> (&str, &str) {
    text.split_once('"').and_then(|(_, rest)| rest.split_once('"')).unwrap_or_else(|| panic!("no quotes in {text}"))
}

fn of_mitsuba(text: &str) -> Vec<Use> {
    let place = |element: &Element| {
        let transform = element.inner.iter().find(|inner| inner.tag == "transform");
        transform.map_or(Affine::IDENTITY, |transform| {
            let first = &transform.inner[0];
            match first.tag.as_str() {
                "translate" => {
                    Affine::translation(["x", "y", "z"].map(|name| numbers(first.get(name).expect("a part"))[0]))
                }
                "matrix" => affine(&numbers(first.get("value").expect("a matrix")), false),
                other => panic!("a transform of {other}"),
            }
        })
    };
    let own = |element: &Element| {
        let file = element.inner.iter().find(|inner| inner.get("name") == Some("filename")).expect("a file");
        let shines = element.inner.iter().any(|inner| inner.tag == "emitter");
        (stem(file.get("value").expect("a path")), shines, place(element))
    };
    let root = parse(text);
    let mut groups: BTreeMap<&str, Vec<Use>> = BTreeMap::new();
    let mut uses = Vec::new();
    for element in root.inner.iter().filter(|element| element.tag == "shape") {
        match element.get("type").expect("a type") {
            "ply" => uses.push(own(element)),
            "shapegroup" => {
                let inner = element.inner.iter().filter(|inner| inner.tag == "shape");
                let inner: Vec<Use> = inner
                    .map(|inner| {
                        assert_eq!(inner.get("type"), Some("ply"), "Mitsuba takes no instances in a group");
                        own(inner)
                    })
                    .collect();
                assert!(inner.iter().all(|(_, shines, _)| !shines), "Mitsuba takes no emitters in a group");
                groups.insert(element.get("id").expect("an id"), inner);
            }
            "instance" => {
                let group = element.inner.iter().find(|inner| inner.tag == "ref").and_then(|inner| inner.get("id"));
                let outer = place(element);
                let inner = &groups[group.expect("a group")];
                uses.extend(inner.iter().map(|(mesh, shines, own)| (mesh.clone(), *shines, own.then(&outer))));
            }
            other => panic!("a shape {other}"),
        }
    }
    uses
}

fn of_pbrt(text: &str) -> Vec<Use> {
    let mut groups: BTreeMap<String, Vec<Use>> = BTreeMap::new();
    let mut uses = Vec::new();
    let mut open: Option<(String, Vec<Use>)> = None;
    let mut stack = Vec::new();
    let (mut place, mut shines) = (Affine::IDENTITY, false);
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "AttributeBegin" => stack.push((place, shines)),
            "AttributeEnd" => (place, shines) = stack.pop().expect("a begin"),
            "Translate" => {
                let by = numbers(rest);
                place = Affine::translation([by[0], by[1], by[2]]).then(&place);
            }
            "ConcatTransform" => place = affine(&numbers(rest), true).then(&place),
            "AreaLightSource" => shines = true,
            "ObjectBegin" => {
                assert!(open.is_none(), "PBRT takes no object in an object");
                open = Some((quoted(rest).0.to_owned(), Vec::new()));
            }
            "ObjectEnd" => {
                let (name, inner) = open.take().expect("a begin");
                groups.insert(name, inner);
            }
            "ObjectInstance" => {
                assert!(open.is_none(), "PBRT takes no instance in an object");
                let inner = &groups[quoted(rest).0];
                uses.extend(inner.iter().map(|(mesh, shines, own)| (mesh.clone(), *shines, own.then(&place))));
            }
            "Shape" => {
                let file = rest.split_once("filename\"").map(|(_, rest)| quoted(rest).0).expect("a file");
                let made = (stem(file), shines, place);
                match &mut open {
                    Some((_, inner)) => {
                        assert!(!shines, "PBRT takes no area lights in an object");
                        inner.push(made);
                    }
                    None => uses.push(made),
                }
            }
            "WorldBegin" | "WorldEnd" | "MakeNamedMaterial" | "NamedMaterial" => {}
            other => panic!("a statement {other}"),
        }
    }
    uses
}

fn of_luxcore(text: &str) -> Vec<Use> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let all: BTreeMap<&str, &str> = lines.filter_map(|line| line.split_once(" = ")).collect();
    let get = |key: String| all.get(key.as_str()).copied();
    let objects = all.keys().filter_map(|key| key.strip_prefix("scene.objects.")?.strip_suffix(".shape"));
    let made = objects.map(|name| {
        let word = |what: &str| {
            quoted(get(format!("scene.objects.{name}.{what}")).unwrap_or_else(|| panic!("{name}: no {what}"))).0
        };
        let file = get(format!("scene.shapes.{}.ply", word("shape"))).expect("a shape");
        let shines = get(format!("scene.materials.{}.emission", word("material"))).is_some();
        let place = get(format!("scene.objects.{name}.transformation"));
        let place = place.map_or(Affine::IDENTITY, |place| affine(&numbers(place), true));
        (stem(quoted(file).0), shines, place)
    });
    made.collect()
}

fn of_cycles(text: &str) -> Vec<Use> {
    let mut groups: BTreeMap<&str, Vec<Use>> = BTreeMap::new();
    let mut files: BTreeMap<&str, String> = BTreeMap::new();
    let mut uses = Vec::new();
    let mut open: Option<&str> = None;
    for line in text.lines() {
        let inside = line.starts_with("    ");
        let (word, rest) = line.trim().split_once('(').unwrap_or((line.trim(), ""));
        match word {
            "mesh" => {
                let (name, rest) = quoted(rest);
                files.insert(name, stem(quoted(rest).0));
            }
            "with group" => open = Some(quoted(rest).0),
            "shape" | "emitter" => {
                let (_, rest) = quoted(rest);
                let (mesh, rest) = quoted(rest);
                let place = rest.split_once("matrix=");
                let place = place.map_or(Affine::IDENTITY, |(_, place)| affine(&numbers(place), false));
                let made = (files[mesh].clone(), word == "emitter", place);
                match open.filter(|_| inside) {
                    Some(group) => groups.entry(group).or_default().push(made),
                    None => uses.push(made),
                }
            }
            "instance" => {
                let (_, rest) = quoted(rest);
                let (group, rest) = quoted(rest);
                let outer = affine(&numbers(rest), false);
                let inner = &groups[group];
                uses.extend(inner.iter().map(|(mesh, shines, own)| (mesh.clone(), *shines, own.then(&outer))));
            }
            _ => {}
        }
    }
    uses
}

/// Sorted by mesh and place, so that the order of a file does not count.
fn sorted(mut uses: Vec<Use>) -> Vec<Use> {
    let key = |(mesh, shines, place): &Use| {
        let rounded = place.rows.as_flattened().iter().map(|x| (x * 1e6).round() as i64).collect::<Vec<_>>();
        (mesh.clone(), *shines, rounded)
    };
    uses.sort_by_key(key);
    uses
}

#[test]
fn every_target_lays_every_mesh_where_the_scene_has_it() {
    let mut of: Vec<(&str, &str, Reader)> =
        vec![("luxcore", "scene.scn", of_luxcore), ("cycles", "scene.py", of_cycles)];
    of.extend(["mitsuba-3", "mitsuba-0.6", "mitsuba-0.5"].map(|target| (target, "description.xml", of_mitsuba as _)));
    of.extend(["pbrt-v4", "pbrt-v3"].map(|target| (target, "description.pbrt", of_pbrt as _)));
    for (name, thing) in THINGS {
        let scene = scene(name, thing);
        let files = formats::mesh_files(&scene);
        let survey = Survey::of(&scene);
        let expected = survey.placed.iter().map(|placed| {
            let shape = placed.shape;
            (stem(&files[shape.mesh.index()]), shape.emission.is_some(), placed.transform)
        });
        let expected = sorted(expected.collect());
        let lights = expected.iter().filter(|(_, shines, _)| *shines).count();
        let extra = match *name {
            "lamps" => 4,
            "one_mesh" => 1,
            _ => 0,
        };
        assert_eq!(lights, 1 + extra, "{name}");
        for (target, file, read) in &of {
            let mut sink = MemorySink::default();
            let target = formats::find(target).expect("a target");
            let camera = pipeline::camera(&scene, None).expect("a camera");
            let ledger = Ledger::of(&scene, target, &[]);
            pipeline::emit_shared(&scene, camera, target, &ledger, &Choices::default(), &mut sink)
                .expect("memory takes all");
            let text = std::str::from_utf8(&sink.files[*file]).expect("text");
            let found = sorted(read(text));
            let what = format!("{name} for {}", target.name);
            assert_eq!(found.len(), expected.len(), "{what}\n{text}");
            for ((mesh, shines, place), (own, shone, there)) in found.iter().zip(&expected) {
                assert_eq!((mesh, shines), (own, shone), "{what}");
                let off = place.rows.as_flattened().iter().zip(there.rows.as_flattened());
                assert!(off.into_iter().all(|(a, b)| (a - b).abs() < 1e-9), "{what}: {mesh} {place:?} {there:?}");
            }
        }
    }
}

#[test]
fn a_mirror_in_every_target() {
    let thing = "shape m = box(size: 3) |> translate(z: 2.5) with mirror(reflectance: rgb(0.9, 0.5, 0.2))";
    let scene = scene("mirror", thing);
    let written = |target: &str, file: &str| {
        let mut sink = MemorySink::default();
        let target = formats::find(target).expect("a target");
        let camera = pipeline::camera(&scene, None).expect("a camera");
        pipeline::emit_shared(&scene, camera, target, &Ledger::of(&scene, target, &[]), &Choices::default(), &mut sink)
            .expect("memory takes all");
        let text = String::from_utf8(sink.files[file].clone()).expect("text");
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (target, name) in [
        ("mitsuba-3", "specular_reflectance"),
        ("mitsuba-0.6", "specularReflectance"),
        ("mitsuba-0.5", "specularReflectance"),
    ] {
        let xml = written(target, "description.xml");
        let mirror = format!(
            "<bsdf type=\"conductor\"> <string name=\"material\" value=\"none\"/> <rgb name=\"{name}\" value=\"0.9, 0.5, 0.2\"/> \
             </bsdf>"
        );
        assert!(xml.contains(&mirror), "{target}: {xml}");
    }
    for (target, mirror) in [
        ("pbrt-v3", "\"string type\" [\"mirror\"] \"rgb Kr\" [0.9 0.5 0.2]"),
        ("pbrt-v4", "\"string type\" [\"conductor\"] \"rgb reflectance\" [0.9 0.5 0.2] \"float roughness\" [0]"),
    ] {
        let pbrt = written(target, "description.pbrt");
        assert!(pbrt.contains(mirror), "{target}: {pbrt}");
    }
    let scn = written("luxcore", "scene.scn");
    assert!(scn.contains(".type = \"mirror\" ") && scn.contains(".kr = 0.9 0.5 0.2 "), "{scn}");
    let python = written("cycles", "scene.py");
    assert!(python.contains("mirror((0.9, 0.5, 0.2))"), "{python}");
    let gltf = written("gltf", "mirror.gltf");
    assert!(
        gltf.contains("\"baseColorFactor\": [ 0.9, 0.5, 0.2, 1.0 ], \"metallicFactor\": 1.0, \"roughnessFactor\": 0.0"),
        "{gltf}"
    );
}

#[test]
fn meshes_of_scenes_with_many_instances_are_few() {
    for scene in super::scenes() {
        let folder = root().join("generated").join(&scene).join("meshes");
        let files: Vec<String> = files_below(&folder);
        if scene.starts_with("cboxm") {
            assert!((5..=20).contains(&files.len()), "{scene} has {} meshes: {files:?}", files.len());
        }
        if scene == "veach_mis" {
            // A sphere of 64 segments and more has a megabyte; plates, walls and floor are boxes.
            let size = |file: &&String| std::fs::metadata(folder.join(file)).expect("a file").len();
            let large: Vec<&String> = files.iter().filter(|file| size(file) > 100_000).collect();
            assert_eq!(large.len(), 1, "one sphere of {files:?}");
            let text = std::fs::read_to_string(root().join("generated/veach_mis/pbrt-v4/description.pbrt"));
            assert_eq!(text.expect("a file").matches(large[0].as_str()).count(), 4, "it is used four times");
        }
    }
}
