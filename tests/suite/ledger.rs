//! The bounds of the ledger against renderings: what is measured lies under them, and near them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::image::{Image, read};
use ltsc_render::install::{Status, status};
use ltsc_render::run::driver;

use super::{ltsc, run, skip};

/// Balls of gold and rough copper under even light, which each pixel shows at its own angle: one reflection, no noise but that of
/// the roughness. The gold is that of the scene `ring`.
const BALL: &str = "lts 1\n/// A ball of metal under even light.\nscene NAME { paths: [\"LSE\"] }\n\
    camera = perspective(eye: (0, -100, 0), target: (0, 0, 0), fov_x: 1.2deg)\nfilm = image(32, 32)\n\
    integrator = path(max_depth: 2)\nsampler = independent(samples: 256)\n\
    shape ball = sphere(radius: 1, segments: 256, rings: 128) with METAL\n\
    emitter sky = environment(radiance: 1)\n";

const GOLD: &str = "conductor(eta: rgb(0.143119, 0.374957, 1.44248), k: rgb(3.98316, 2.38572, 1.60322), alpha: 0.01)";
const WIDE: &str = "conductor(eta: 0.2, k: 3.9, alpha: 0.5)";

/// A Python that has the renderer's module.
fn python(renderer: &str) -> Option<PathBuf> {
    let env = Env::of_process();
    match status(driver(renderer).expect("a driver"), CachePaths::find(&env).as_ref(), &env) {
        Status::Installed { path, .. } => Some(path),
        Status::External { .. } | Status::Partial { .. } | Status::NotInstalled => None,
    }
}

fn scene(folder: &Path, name: &str, metal: &str) -> PathBuf {
    let path = folder.join(format!("{name}.lts"));
    fs::write(&path, BALL.replace("NAME", name).replace("METAL", metal)).expect("a scene");
    path
}

fn rendered(scene: &Path, renderer: &str) -> Image {
    let out = scene.with_extension(format!("{renderer}.exr"));
    let ran = run(ltsc()
        .arg("render")
        .arg(scene)
        .args(["--renderer", renderer, "--allow", "all", "--force", "-o"])
        .arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    read(&out).expect("an image").0
}

fn emitted(scene: &Path, target: &str) -> PathBuf {
    let out = scene.with_extension(target);
    let ran = run(ltsc().arg("emit").arg(scene).args(["--target", target, "--allow", "all", "-o"]).arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    out
}

/// The bound that the ledger of a folder states for something.
fn bound(folder: &Path, what: &str) -> f64 {
    let text = fs::read_to_string(folder.join("ledger.json")).expect("a ledger");
    let ledger: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let all = ledger["approximated"].as_array().expect("a list");
    let one = all.iter().find(|one| one["what"] == what).unwrap_or_else(|| panic!("no `{what}` in {text}"));
    one["here"]["at_most"].as_f64().unwrap_or_else(|| panic!("no bound for `{what}` in {text}"))
}

/// The largest share by which B lies from A, over the channels of pixels within nine tenths of the ball's radius, means of 2 x 2
/// pixels for the noise.
fn farthest(a: &Image, b: &Image) -> f64 {
    let mut most = 0.0_f64;
    for y in (0..32).step_by(2) {
        for x in (0..32).step_by(2) {
            // The ball fills 1.146 of 1.2 degrees.
            let (dx, dy) = (x as f64 + 1.0 - 16.0, y as f64 + 1.0 - 16.0);
            if (dx * dx + dy * dy).sqrt() > 0.9 * 16.0 * 1.146 / 1.2 {
                continue;
            }
            let mean = |image: &Image, channel: usize| {
                let near = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
                near.iter().map(|(x, y)| f64::from(image.at(*x, *y)[channel])).sum::<f64>() / 4.0
            };
            for channel in 0..3 {
                most = most.max((mean(b, channel) / mean(a, channel) - 1.0).abs());
            }
        }
    }
    most
}

/// What two exact renderers differ by here: noise, and the facets of the ball.
const NOISE: f64 = 0.004;

fn judge(what: &str, measured: f64, bound: f64) {
    assert!(measured <= bound + NOISE, "{what}: {measured:.4} measured, at most {bound:.4} stated");
    assert!(measured >= bound / 10.0, "{what}: {measured:.4} measured, and {bound:.4} stated, which says nothing");
}

#[test]
fn luxcores_metals_are_as_far_off_as_the_ledger_says() {
    if python("mitsuba-3").is_none() || python("luxcore").is_none() {
        return skip("bounds of LuxCore", "`ltsc renderers install mitsuba-3 luxcore`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    for (name, metal) in [("gold", GOLD), ("wide", WIDE)] {
        let scene = scene(folder.path(), name, metal);
        let stated = bound(&emitted(&scene, "luxcore"), "a rough conductor");
        judge(name, farthest(&rendered(&scene, "mitsuba-3"), &rendered(&scene, "luxcore")), stated);
    }
}

/// Takes the settings and the sky of the scene as it is written for Cycles, and the ball from the glTF file.
const IMPORT: &str = "
import runpy, sys
import bpy
described, model, out = sys.argv[1:4]
runpy.run_path(described, run_name='scene')
scene = bpy.context.scene
camera = scene.camera
for it in list(bpy.data.objects):
    if it.type == 'MESH':
        bpy.data.objects.remove(it)
bpy.ops.import_scene.gltf(filepath=model)
scene.camera = camera
assert [it for it in bpy.data.objects if it.type == 'MESH'], 'nothing was imported'
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
";

#[test]
fn gltfs_metals_are_as_far_off_as_the_ledger_says() {
    let (Some(_), Some(python)) = (python("mitsuba-3"), python("cycles")) else {
        return skip("bounds of glTF", "`ltsc renderers install mitsuba-3 cycles`");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene(folder.path(), "gold", GOLD);
    let gltf = emitted(&scene, "gltf");
    let described = emitted(&scene, "cycles").join("scene.py");
    let out = folder.path().join("gltf.exr");
    let ran =
        Command::new(python).args(["-I", "-c", IMPORT]).arg(described).arg(gltf.join("gold.gltf")).arg(&out).output();
    let ran = ran.expect("Python starts");
    assert!(ran.status.success(), "{}{}", String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    let (image, _) = read(&out).expect("an image");
    judge("gold", farthest(&rendered(&scene, "mitsuba-3"), &image), bound(&gltf, "a rough conductor"));
}
