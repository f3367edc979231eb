//! Generated files against their scenes: all of ours agree, and what is edited in a copy is named.

use std::fs;
use std::path::Path;

use ltsc_core::formats::TARGETS;

use super::{QUICK, files_below, ltsc, root, run, scenes};

/// Audits these scenes for every target.
fn agree(names: &[String]) {
    let files = names.iter().map(|scene| format!("scenes-src/{scene}.lts"));
    let ran = run(ltsc().arg("audit").args(files).args(["--format", "json"]));
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    let document: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let all = document["scenes"].as_array().expect("scenes");
    let audited: Vec<&str> = all.iter().filter_map(|scene| scene["scene"].as_str()).collect();
    assert_eq!(audited, names);
    for scene in all {
        let asked = &scene["asked"];
        let targets = scene["targets"].as_array().expect("targets");
        assert_eq!(targets.len(), TARGETS.len());
        for target in targets {
            let name = format!("{} {}", scene["scene"], target["target"]);
            assert_eq!(target["agrees"], true, "{name}");
            assert_eq!(target["said"]["surfaces"], asked["surfaces"], "{name}");
            assert_eq!(
                target["emitters"].as_array().map(Vec::len),
                scene["emitters"].as_array().map(Vec::len),
                "{name}"
            );
            let number = |value: &serde_json::Value| value.as_f64().expect("a number");
            for channel in 0..3 {
                let (a, b) = (number(&asked["power"][channel]), number(&target["said"]["power"][channel]));
                assert!(a > 0.0 && (a - b).abs() <= 1e-9 * a, "{name}: {a} {b}");
            }
        }
    }
}

#[test]
fn small_scenes_agree_with_their_files_for_every_target() {
    agree(&QUICK.map(str::to_owned));
}

#[test]
#[ignore = "long: reads the files of all scenes for all targets"]
fn every_scene_agrees_with_its_files_for_every_target() {
    agree(&scenes());
}

/// A copy of what was generated of a scene, with one text of it edited.
fn edited(scene: &str, file: &str, from: &str, to: &str) -> tempfile::TempDir {
    let copy = tempfile::tempdir().expect("a folder");
    let generated = root().join("generated");
    for path in files_below(&generated.join(scene)) {
        let place = copy.path().join(scene).join(&path);
        fs::create_dir_all(place.parent().expect("a folder")).expect("a folder");
        fs::copy(generated.join(scene).join(&path), place).expect("a file");
    }
    let place = copy.path().join(scene).join(file);
    let text = fs::read_to_string(&place).expect("text");
    assert!(text.contains(from), "{file} has no {from}");
    fs::write(&place, text.replacen(from, to, 1)).expect("a file");
    copy
}

fn audit(scene: &str, generated: &Path) -> super::Ran {
    let file = format!("scenes-src/{scene}.lts");
    run(ltsc().args(["audit", &file, "--format", "short", "-o"]).arg(generated))
}

/// A scene, a file, its text, an edit of it, the exit code, and what is said.
type Edit = (&'static str, &'static str, &'static str, &'static str, i32, &'static str);

const EDITS: &[Edit] = &[
    ("ring", "pbrt-v3/description.pbrt", "[30 30 30]", "[60 60 60]", 1, "`lamp` emits"),
    (
        "ring",
        "mitsuba-3/description.xml",
        "value=\"0.01\"",
        "value=\"0.0001\"",
        1,
        "`gold` has the width `alpha` 0.0001 instead of 0.01",
    ),
    (
        "ring",
        "luxcore/scene.cfg",
        "path.pathdepth.total = 10",
        "path.pathdepth.total = 9",
        1,
        "paths have 9 segments instead of 10",
    ),
    (
        "ring",
        "luxcore/scene.cfg",
        "roulette.cap = 1",
        "roulette.cap = 0.5",
        3,
        "`path.russianroulette.cap` other than 1",
    ),
    (
        "surfaces",
        "pbrt-v4/description.pbrt",
        "filename\" [\"../textures/tiles.png\"]",
        "filename\" [\"../textures/other.png\"]",
        1,
        "shows the image `other.png` instead of `tiles.png`",
    ),
];

/// Those in scenes that take longer.
const MORE_EDITS: &[Edit] = &[
    (
        "cboxm_glossy_lvar",
        "cycles/scene.py",
        "radiance=(19, 19, 19)",
        "radiance=(18, 19, 19)",
        1,
        "`lamp[0,0,1]` emits",
    ),
    (
        "cboxm_glossy_lvar",
        "luxcore/scene.scn",
        "transformation = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 30 1",
        "transformation = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 31 1",
        1,
        "the center",
    ),
    ("pool_simple", "gltf/pool_simple.gltf", "\"ior\": 1.", "\"ior\": 2.", 1, "index of refraction"),
    (
        "veach_mis",
        "mitsuba-0.6/description.xml",
        "<bsdf type=\"twosided\"",
        "<bsdf type=\"onesided\"",
        3,
        "there is no material `onesided`",
    ),
];

fn named(edits: &[Edit]) {
    for &(scene, file, from, to, code, words) in edits {
        let copy = edited(scene, file, from, to);
        let ran = audit(scene, copy.path());
        assert_eq!(ran.code, Some(code), "{file}: {}{}", ran.out, ran.err);
        assert!(ran.out.contains(words), "{file}: {}{}", ran.out, ran.err);
        assert!(ran.out.contains(file.split('/').next().expect("a target")), "{file}: {}", ran.out);
    }
}

#[test]
fn an_edit_of_a_generated_file_is_named_and_the_answer_is_no() {
    named(EDITS);
}

#[test]
#[ignore = "long: audits scenes of hundreds of instances and of water"]
fn an_edit_of_a_file_of_a_large_scene_is_named_and_the_answer_is_no() {
    named(MORE_EDITS);
}

#[test]
fn a_folder_that_emit_wrote_is_audited_with_its_settings() {
    let folder = tempfile::tempdir().expect("a folder");
    let ring = folder.path().join("ring");
    let emit = ["emit", "scenes-src/ring.lts", "--target", "pbrt", "--width", "64", "--height", "32", "-o"];
    assert_eq!(run(ltsc().args(emit).arg(&ring)).code, Some(0));
    let audit = ["audit", "scenes-src/ring.lts", "--target", "pbrt", "--folder"];
    let ran = run(ltsc().args(audit).arg(&ring).args(["--width", "64", "--height", "32"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.contains("agrees") && ran.out.contains("64 x 32"), "{}", ran.out);
    let ran = run(ltsc().args(audit).arg(&ring));
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert!(ran.err.contains("64 x 32 pixels instead of 512 x 512"), "{}", ran.err);
    let ran = run(ltsc().args(["audit", "--folder"]).arg(&ring));
    assert_eq!(ran.code, Some(2), "{}", ran.err);
}

#[test]
fn what_was_not_generated_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = audit("ring", folder.path());
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("nothing was generated of `ring`"), "{}", ran.err);
}
