//! Scenes in glTF, as ltsc writes them and reads them again.

use std::fs;
use std::path::Path;

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::files::VPath;
use ltsc_core::import::{self, Options};
use ltsc_core::ir::{Mesh, Scene};
use ltsc_core::pipeline;
use serde_json::Value;

use super::{Disk, ltsc, prepared, root, run, scenes};

/// Triangles of a scene at their places, and the box around them.
fn extent(scene: &Scene) -> (usize, [[f64; 3]; 2]) {
    let (mut count, mut around) = (0, [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);
    let mut meet = |mesh: &Mesh, place: &dyn Fn([f64; 3]) -> [f64; 3]| {
        count += mesh.triangles.len();
        for corner in mesh.triangles.iter().flat_map(|triangle| mesh.corners(*triangle)).map(place) {
            (0..3).for_each(|axis| {
                around[0][axis] = around[0][axis].min(corner[axis]);
                around[1][axis] = around[1][axis].max(corner[axis]);
            });
        }
    };
    for shape in scene.shapes.values() {
        meet(&scene.meshes[shape.mesh], &|corner| shape.transform.point(corner));
    }
    for instance in scene.instances.values() {
        for place in instance.places.maps() {
            for shape in scene.groups[instance.group].shapes.values() {
                meet(&scene.meshes[shape.mesh], &|corner| place.point(shape.transform.point(corner)));
            }
        }
    }
    (count, around)
}

fn near(a: &[f64], b: &[f64], bound: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= bound * (1.0 + a.abs()))
}

/// Radiance of all that emits, sorted.
fn emitted(scene: &Scene) -> Vec<String> {
    let shown =
        scene.shapes.values().filter_map(|shape| Some(format!("{:.6?}", shape.emission.as_ref()?.radiance.rgb())));
    let mut all: Vec<String> = shown.collect();
    all.sort();
    all
}

/// The document that `ltsc emit` writes of a scene in the folder `name` of `out`.
fn emit(scene: &Path, name: &str, out: &Path, more: &[&str]) -> Value {
    let folder = out.join(name);
    let ran = run(ltsc().arg("emit").arg(scene).args(["--target", "gltf", "-o"]).arg(&folder).args(more));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let file = folder.join(scene.file_stem().expect("a name")).with_extension("gltf");
    serde_json::from_slice(&fs::read(file).expect("a file")).expect("JSON")
}

/// Whether two documents say the same, numbers to a millionth.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => near(&[a.as_f64().unwrap_or(0.0)], &[b.as_f64().unwrap_or(0.0)], 1e-6),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        (a, b) => a == b,
    }
}

/// Boxes, every material and light, instances.
const SOME: [&str; 3] = ["cbox_classic", "surfaces", "cboxm_glossy_lvar"];

#[test]
fn what_is_written_as_gltf_is_read_back() {
    read_back(&SOME);
}

#[test]
#[ignore = "long: all scenes twice"]
fn all_that_is_written_as_gltf_is_read_back() {
    let all = scenes();
    read_back(&all.iter().map(String::as_str).collect::<Vec<_>>());
}

fn read_back(names: &[&str]) {
    let out = tempfile::tempdir().expect("a folder");
    for name in names {
        let source = root().join(format!("scenes-src/{name}.lts"));
        let first = emit(&source, "first", out.path(), &[]);
        let file = format!("first/{name}.gltf");
        let path = VPath::resolve("", &file).expect("a path");
        let (mut sources, disk) = (Sources::default(), Disk(out.path().to_path_buf()));
        let importer = import::find(&path).expect("an importer");
        let found = import::import(importer, &disk, &mut sources, &path, &Options::default());
        let bad = |finding: &&ltsc_core::diag::Finding| {
            finding.id == "loss-dropped" && finding.severity >= Severity::Warn || finding.severity > Severity::Warn
        };
        assert_eq!(found.findings.iter().find(bad).map(|finding| &finding.message), None, "{name}");
        let ours = prepared(&Disk(root().to_path_buf()), &format!("scenes-src/{name}.lts"));
        let (theirs, _) = pipeline::prepare(found.scene.expect("a scene")).expect("a valid scene");
        assert_eq!((&theirs.film, &theirs.integrator, &theirs.sampler), (&ours.film, &ours.integrator, &ours.sampler));
        let (a, b) = (ours.cameras.values().next().expect("one"), theirs.cameras.values().next().expect("one"));
        let (one, other) = (a.axes().expect("axes"), b.axes().expect("axes"));
        assert!(near(&a.eye, &b.eye, 1e-9) && near(&[a.fov_x], &[b.fov_x], 1e-9), "{name}: {a:?} {b:?}");
        assert!(near(&one.forward, &other.forward, 1e-9) && near(&one.up, &other.up, 1e-9), "{name}");
        let ((count, [low, high]), (again, [low_again, high_again])) = (extent(&ours), extent(&theirs));
        assert!(
            count == again && near(&low, &low_again, 1e-5) && near(&high, &high_again, 1e-5),
            "{name}: {count} {again}"
        );
        assert_eq!(emitted(&ours), emitted(&theirs), "{name}");
        let lights = |scene: &Scene| scene.lights.values().map(|light| light.kind.word()).collect::<Vec<_>>();
        assert_eq!(lights(&ours), lights(&theirs), "{name}");
        // And written once more it is the same document, but for bytes in another order.
        let second = emit(&out.path().join(&file), "second", out.path(), &[]);
        for key in ["materials", "cameras", "extensions", "scenes"] {
            assert!(same(&first[key], &second[key]), "{name}: {key}\n{:#}\n{:#}", first[key], second[key]);
        }
        assert_eq!(first["nodes"].as_array().map(Vec::len), second["nodes"].as_array().map(Vec::len), "{name}");
    }
}
