//! glTF as Blender's importer reads it: everything lies where the scene says, and the camera looks at it as the scene's does.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::Command;

use ltsc_core::formats::shared::camera::fov_y;
use ltsc_core::survey::Survey;
use ltsc_core::valid::Valid;
use serde_json::Value;

use super::micro::{self, THINGS};
use super::render::room_text;
use super::{Disk, QUICK, ltsc, prepared, python, root, run, scenes, skip};

/// Prints a line of JSON for each file: what Blender has after the import. Instances count one by one.
const SCRIPT: &str = "
import bpy, faulthandler, json, numpy, sys
faulthandler.dump_traceback_later(600, exit=True)
for path in sys.argv[1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    low, high, sums = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf), numpy.zeros(3)
    meshes = triangles = 0
    for one in bpy.context.evaluated_depsgraph_get().object_instances:
        if one.object.type != 'MESH':
            continue
        mesh = one.object.data
        points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
        mesh.vertices.foreach_get('co', points)
        corners = numpy.empty(len(mesh.loops), numpy.int32)
        mesh.loops.foreach_get('vertex_index', corners)
        matrix = numpy.array(one.matrix_world)
        points = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        low, high = numpy.minimum(low, points.min(0)), numpy.maximum(high, points.max(0))
        sums += points[corners].sum(0)
        meshes += 1
        triangles += len(mesh.polygons)
    cameras = [one for one in bpy.data.objects if one.type == 'CAMERA']
    lights = sorted(one.data.type for one in bpy.data.objects if one.type == 'LIGHT')
    matrix, lens = numpy.array(cameras[0].matrix_world), cameras[0].data
    upright = lens.sensor_fit == 'VERTICAL'
    print(json.dumps({
        'low': low.tolist(), 'high': high.tolist(), 'middle': (sums / (3 * triangles)).tolist(),
        'meshes': meshes, 'triangles': triangles, 'cameras': len(cameras), 'lights': lights,
        'eye': matrix[:3, 3].tolist(), 'forward': (-matrix[:3, 2]).tolist(), 'up': matrix[:3, 1].tolist(),
        'upright': upright, 'angle': lens.angle_y if upright else lens.angle_x, 'near': lens.clip_start,
    }))
";

/// Two blocks of one mesh and a group seen four times, once sheared; lights; a camera taller than wide.
const SMALL: &str = "lts 1
scene small {}
camera = perspective(eye: (3, -20, 5), target: (0, 1, 2), fov_x: 30deg, near: 0.5)
film = image(90, 160)
integrator = path(max_depth: 4)
sampler = independent(samples: 4)
group pair {
    shape left = box(size: (1, 2, 3)) with diffuse(0.5)
    shape right = box(size: 1) |> rotate(x: 30deg) |> translate(2, 0, 0) with diffuse(0.3)
}
instance near = pair |> rotate(z: 40deg) |> translate(-4, 0, 1)
instance far = pair |> scale(0.5) |> rotate(y: 100deg) |> translate(4, 3, 1)
instance tall = pair |> scale(z: 2) |> rotate(z: -20deg) |> translate(0, 6, 1)
instance skew = pair |> rotate(z: 30deg) |> scale(y: 3) |> translate(0, -4, 1)
emitter bulb = point(position: (0, 0, 9), intensity: 10)
emitter sun = directional(direction: (1, 2, -4), irradiance: 3)
emitter beam = spot(position: (0, -5, 6), target: (0, 1, 0), intensity: 9, angle: 30deg)
";

fn numbers(report: &Value, key: &str) -> [f64; 3] {
    let list = report[key].as_array().expect("a list");
    [0, 1, 2].map(|axis| list[axis].as_f64().expect("a number"))
}

fn judge(scene: &Valid, file: &Path, report: &Value) {
    let what = file.display();
    let count = |key: &str| report[key].as_u64().expect("a count") as usize;
    // A node for each shape and each place of an instance.
    let places: usize = scene.instances.values().map(|instance| instance.places.maps().len()).sum();
    assert_eq!((count("cameras"), count("meshes")), (1, scene.shapes.len() + places), "{what}");
    let lights: Vec<&str> = report["lights"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert_eq!(lights.len(), scene.lights.len(), "{what}: {lights:?}");

    let survey = Survey::of(scene);
    let (mut low, mut high, mut sum) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], [0.0; 3]);
    let mut triangles = 0;
    for corners in survey.placed.iter().flat_map(|placed| survey.triangles(placed)) {
        triangles += 1;
        for (corner, axis) in corners.iter().flat_map(|corner| [0, 1, 2].map(|axis| (corner, axis))) {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
            sum[axis] += corner[axis];
        }
    }
    assert_eq!(count("triangles"), triangles, "{what}");
    // Blender turns y up to z up and keeps matrices in single precision: a part in a million of the largest coordinate.
    let (_, camera) = scene.cameras.iter().next().expect("a camera");
    let all = low.iter().chain(&high).chain(&camera.eye);
    let size = all.fold(0.0_f64, |most, x| most.max(x.abs()));
    let near = |name: &str, expected: [f64; 3], within: f64| {
        let there = numbers(report, name);
        let far = there.iter().zip(expected).any(|(a, b)| (a - b).abs() > within);
        assert!(!far, "{what}: {name} is {there:?}, not {expected:?}");
    };
    near("low", low, 1e-6 * size);
    near("high", high, 1e-6 * size);
    near("middle", sum.map(|x| x / (3 * triangles) as f64), 1e-6 * size);
    let axes = camera.axes().expect("a camera");
    near("eye", camera.eye, 1e-6 * size);
    near("forward", axes.forward, 1e-6);
    near("up", axes.up, 1e-6);
    let expected = if report["upright"] == true { fov_y(camera.fov_x, &scene.film) } else { camera.fov_x };
    let angle = report["angle"].as_f64().expect("an angle") * 180.0 / PI;
    assert!((angle - expected).abs() < 1e-4, "{what}: the angle of view is {angle}, not {expected}");
    if let Some(distance) = camera.near {
        let there = report["near"].as_f64().expect("a distance");
        assert!((there - distance).abs() < 1e-6, "{what}: clipped at {there}, not {distance}");
    }
}

/// Imports these scenes of ours, for each target, and others that are given with their files.
fn imported(names: &[String], others: impl FnOnce(&Path) -> Vec<(Valid, Vec<PathBuf>)>) {
    let Some(python) = python("cycles") else {
        return skip("glTF in Blender", "`ltsc renderers install cycles`");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let mut cases: Vec<(Valid, Vec<PathBuf>)> = Vec::new();
    for scene in names {
        let generated = root().join("generated").join(scene);
        let files = ["gltf", "glb"].map(|form| generated.join(form).join(format!("{scene}.{form}")));
        cases.push((prepared(&Disk(root().to_path_buf()), &format!("scenes-src/{scene}.lts")), files.to_vec()));
    }
    cases.extend(others(folder.path()));
    let files: Vec<&PathBuf> = cases.iter().flat_map(|(_, files)| files).collect();
    let output = Command::new(python).args(["-I", "-c", SCRIPT]).args(&files).output().expect("Python starts");
    let log = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{log}\n{}", String::from_utf8_lossy(&output.stderr));
    let reports: Vec<Value> = log
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(reports.len(), files.len(), "{log}");
    let mut reports = reports.iter();
    for (scene, files) in &cases {
        for file in files {
            judge(scene, file, reports.next().expect("a report"));
        }
    }
}

/// A scene in each form that glTF has.
fn forms(folder: &Path, scene: Valid, file: &Path) -> (Valid, Vec<PathBuf>) {
    let mut files = Vec::new();
    for (form, options) in
        [("gltf", &[][..]), ("gltf", &["--option", "gltf.instancing"]), ("glb", &["--option", "glb.instancing"])]
    {
        let out = folder.join(format!("{}-{form}{}", scene.name, options.len()));
        let emit = run(ltsc().arg("emit").arg(file).args(["--target", form, "-o"]).arg(&out).args(options));
        assert_eq!(emit.code, Some(0), "{}", emit.err);
        files.push(out.join(format!("{}.{form}", scene.name)));
    }
    (scene, files)
}

fn small(folder: &Path) -> (Valid, Vec<PathBuf>) {
    let file = folder.join("small.lts");
    std::fs::write(&file, SMALL).expect("a write");
    forms(folder, prepared(&Disk(folder.to_path_buf()), "small.lts"), &file)
}

fn thing(folder: &Path, name: &str, thing: &str) -> (Valid, Vec<PathBuf>) {
    let file = folder.join(format!("{name}.lts"));
    std::fs::write(&file, room_text(name, 6, thing)).expect("a write");
    let out = folder.join(name);
    let option = ["--target", "glb", "--option", "glb.instancing", "-o"];
    let emit = run(ltsc().arg("emit").arg(&file).args(option).arg(&out));
    assert_eq!(emit.code, Some(0), "{}", emit.err);
    (micro::scene(name, thing), vec![out.join(format!("{name}.glb"))])
}

#[test]
fn small_scenes_are_imported_as_they_are() {
    imported(&QUICK.map(str::to_owned), |folder| {
        let things = THINGS.iter().map(|(name, text)| thing(folder, name, text));
        [small(folder)].into_iter().chain(things).collect()
    });
}

#[test]
#[ignore = "long: scenes of hundreds of instances and of water"]
fn every_scene_is_imported_as_it_is() {
    imported(&scenes(), |folder| {
        let many = "scenes-src/cboxm_diffuse_lvar.lts";
        vec![forms(folder, prepared(&Disk(root().to_path_buf()), many), &root().join(many))]
    });
}
