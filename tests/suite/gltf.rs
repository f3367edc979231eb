//! glTF as Khronos's own validator judges it.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::{ltsc, root, run, scenes, skip};

/// The folder `node_modules` with the package `gltf-validator`.
fn modules() -> Option<PathBuf> {
    let named = std::env::var_os("LTSC_NODE_MODULES").map(PathBuf::from);
    let folder = named.unwrap_or_else(|| root().join("target/validators/node_modules"));
    folder.join("gltf-validator").is_dir().then_some(folder)
}

/// Prints a line of JSON for each file: its report.
const SCRIPT: &str = "
const fs = require('fs'), path = require('path');
const validator = require(path.join(process.argv[1], 'gltf-validator'));
(async () => {
    for (const file of process.argv.slice(2)) {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
            uri: path.basename(file),
            maxIssues: 0,
            externalResourceFunction: async (uri) => new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
        });
        console.log(JSON.stringify(report));
    }
})().catch((error) => { console.error(error); process.exit(1); });
";

/// What the validator says of each file; none where it is missing.
fn reports(test: &str, files: &[PathBuf]) -> Option<Vec<Value>> {
    let Some(modules) = modules() else {
        skip(test, "the npm package gltf-validator in target/validators");
        return None;
    };
    let output = Command::new("node").args(["-e", SCRIPT]).arg(&modules).args(files).output().expect("node starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    let reports: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("a report")).collect();
    assert_eq!(reports.len(), files.len());
    Some(reports)
}

fn has_no_issue(file: &Path, report: &Value) {
    let issues = &report["issues"];
    let counts = (&issues["numErrors"], &issues["numWarnings"]);
    assert_eq!(counts, (&0.into(), &0.into()), "{}: {issues:#}", file.display());
}

#[test]
fn generated_gltf_and_glb_have_no_error_and_no_warning() {
    let name = |scene: &str, form: &str| root().join(format!("generated/{scene}/{form}/{scene}.{form}"));
    let files: Vec<PathBuf> = scenes().iter().flat_map(|scene| ["gltf", "glb"].map(|form| name(scene, form))).collect();
    let Some(reports) = reports("gltf", &files) else { return };
    for (pair, files) in reports.chunks(2).zip(files.chunks(2)) {
        for (report, file) in pair.iter().zip(files) {
            has_no_issue(file, report);
        }
        // Both forms hold the same things.
        let what = |report: &Value| {
            let mut info = report["info"].clone();
            info["resources"] = Value::Null;
            info
        };
        assert_eq!(what(&pair[0]), what(&pair[1]), "{}", files[0].display());
        assert!(pair[0]["info"]["totalTriangleCount"].as_u64().expect("a count") > 0);
    }
}

/// The validator does not know EXT_mesh_gpu_instancing, which it says as a remark, and sees what else there is.
#[test]
fn instances_in_the_buffer_have_no_error_and_no_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "cboxm_diffuse_lvar";
    let files = ["gltf", "glb"].map(|form| {
        let out = folder.path().join(form);
        let ran = run(ltsc()
            .args(["emit", &format!("scenes-src/{scene}.lts"), "--target", form])
            .args(["--option", &format!("{form}.instancing"), "-o"])
            .arg(&out));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        out.join(format!("{scene}.{form}"))
    });
    let text = std::fs::read(&files[0]).expect("a file");
    let document: Value = serde_json::from_slice(&text).expect("JSON");
    let nodes = document["nodes"].as_array().expect("nodes");
    let names = |node: &Value| node["extras"]["names"].as_array().map_or(1, Vec::len);
    let uses: usize = nodes.iter().filter(|node| node["mesh"].is_u64()).map(names).sum();
    let plain = root().join(format!("generated/{scene}/gltf/{scene}.gltf"));
    let plain: Value = serde_json::from_slice(&std::fs::read(plain).expect("a file")).expect("JSON");
    let before = plain["nodes"].as_array().expect("nodes").iter().filter(|node| node["mesh"].is_u64()).count();
    assert_eq!(uses, before);
    assert!(nodes.len() * 20 < before, "{} nodes stand for {before}", nodes.len());
    let Some(reports) = reports("gltf with instances", &files) else { return };
    for (report, file) in reports.iter().zip(&files) {
        has_no_issue(file, report);
        let used = report["info"]["extensionsUsed"].as_array().expect("extensions");
        assert!(used.contains(&"EXT_mesh_gpu_instancing".into()), "{used:?}");
    }
}

/// What no scene of ours has: emitters and lights that are spectra, glass of two thicknesses, a reflectance above 1, a sheared mesh.
const ODD: &str = "lts 1
scene odd {}
camera = perspective(eye: (0, -20, 5), target: (0, 0, 2), fov_x: 30deg, near: 0.5, far: 90)
film = image(90, 160)
integrator = path(max_depth: 4)
sampler = independent(samples: 4)
let flat = spectrum([(400, 2), (700, 2)])
let line = spectrum([(500, 0), (510, 9), (520, 0)])
material glass = dielectric(ior: 1.5)
shape thin = box(size: 1) with glass
shape thick = box(size: 3) |> translate(x: 4) with glass
shape bent = box(size: 1) |> rotate(z: 30deg) |> scale(x: 3) |> translate(x: -4) with glass
shape bright = box(size: 1) |> translate(y: 3) with diffuse(rgb(1.2, 0.5, 0))
shape leaf = box(size: 1) |> translate(y: 5) with diffuse(spectrum([(510, 0), (520, 1), (530, 0)]))
shape coat = box(size: 1) |> translate(y: 7) with plastic(rgb(1.1, 0.9, 0.2), alpha: 0.2)
emitter lamp = rectangle(x: -1..1, y: -1..1, z: 9, normal: -Z) with radiance(flat)
emitter laser = rectangle(x: 3..4, y: -1..1, z: 9, normal: -Z) with radiance(line)
emitter bulb = point(position: (0, 0, 9), intensity: flat)
emitter sun = directional(direction: (1, 2, -4), irradiance: line)
emitter beam = spot(position: (0, -5, 6), target: (0, 1, 0), intensity: flat, angle: 90deg)
emitter sky = environment(radiance: 0.5)
";

#[test]
fn spectra_and_glass_of_two_thicknesses_have_no_error_and_no_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("odd.lts");
    std::fs::write(&scene, ODD).expect("a write");
    let files = ["gltf", "glb"].map(|form| {
        let out = folder.path().join(form);
        let ran = run(ltsc().arg("emit").arg(&scene).args(["--target", form, "--allow", "all", "-o"]).arg(&out));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        let ran = run(ltsc().arg("audit").arg(&scene).args(["--target", form, "--allow", "all", "--folder"]).arg(&out));
        assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
        for lost in ["agrees, but for", "a constant environment", "a reflectance above 1"] {
            assert!(ran.out.contains(lost), "{lost}: {}", ran.out);
        }
        out.join(format!("odd.{form}"))
    });
    let Some(reports) = reports("gltf of odd scenes", &files) else { return };
    for (report, file) in reports.iter().zip(&files) {
        has_no_issue(file, report);
    }
}

#[test]
fn options_of_targets_are_asked_for_by_name() {
    let out = tempfile::tempdir().expect("a folder");
    let emit = |target: &str, option: &str| {
        let mut command = ltsc();
        command.args(["emit", "scenes-src/ring.lts", "--target", target, "--option", option, "-o"]);
        run(command.arg(out.path().join(target)))
    };
    let wrong = emit("gltf", "gltf.instances");
    assert_eq!(wrong.code, Some(2), "{}", wrong.err);
    assert!(wrong.err.contains("did you mean `gltf.instancing`?"), "{}", wrong.err);
    let other = emit("gltf", "glb.instancing");
    assert_eq!(other.code, Some(2), "{}", other.err);
    assert!(other.err.contains("one of `glb`, which is not written"), "{}", other.err);

    let project = out.path().join("ltsc.toml");
    let lint = || run(ltsc().arg("lint").current_dir(out.path()));
    std::fs::create_dir(out.path().join("scenes-src")).expect("a folder");
    let text = "lts 1\nscene a {}\ncamera = perspective(eye: (0, -9, 2), target: (0, 0, 0), fov_x: 45deg)\n\
                film = image(16, 16)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
                shape a = box(size: 1) with diffuse(0.5)\n\
                emitter lamp = rectangle(x: -1..1, y: -1..1, z: 3, normal: -Z) with radiance(3)\n";
    std::fs::write(out.path().join("scenes-src/a.lts"), text).expect("a write");
    std::fs::write(&project, "options = [\"glb.instance\"]\n").expect("a write");
    let ran = lint();
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("`options`: there is no option `glb.instance`"), "{}", ran.err);
    std::fs::write(&project, "options = [\"glb.instancing\"]\n").expect("a write");
    let ran = lint();
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
}
