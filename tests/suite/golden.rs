//! What is made and committed. `generated/`: what every scene becomes for every target, as files that other programs open; a
//! change of an emitter shows there as a reviewable difference, binary files show in the manifest by their hash. `docs/`: the
//! pages that ltsc writes.

use std::fs;

use super::{QUICK, bless, files_below, ltsc, root, run, scenes};

#[test]
fn generated_is_what_the_scenes_become() {
    if bless() {
        let built = run(ltsc().args(["build", "scenes-src"]));
        assert_eq!(built.code, Some(0), "{}", built.err);
    }
    let ran = run(ltsc().args(["build", "--check"]));
    assert_eq!(ran.code, Some(0), "run `cargo run -- build` and look at the difference\n{}{}", ran.out, ran.err);
}

/// Builds these scenes twice, and compares the files with each other and with what is committed.
fn built_twice(scenes: &[String]) {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |name: &str| {
        let path = folder.path().join(name);
        let files = scenes.iter().map(|scene| format!("scenes-src/{scene}.lts"));
        let ran = run(ltsc().arg("build").args(files).arg("-o").arg(&path));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        path
    };
    let (first, second) = (of("first"), of("second"));
    let files = files_below(&first);
    assert_eq!(files, files_below(&second));
    assert!(files.len() > 15 * scenes.len(), "{files:?}");
    for file in files {
        assert!(fs::read(first.join(&file)).ok() == fs::read(second.join(&file)).ok(), "{file} differs");
        let committed = fs::read(root().join("generated").join(&file));
        assert!(fs::read(first.join(&file)).ok() == committed.ok(), "{file} is not what is committed");
    }
}

#[test]
fn two_builds_of_small_scenes_are_equal_to_the_byte() {
    built_twice(&QUICK.map(str::to_owned));
}

#[test]
#[ignore = "long: builds all scenes twice"]
fn two_builds_are_equal_to_the_byte() {
    built_twice(&scenes());
}

#[test]
fn manifests_name_every_generated_file() {
    let generated = root().join("generated");
    let files = files_below(&generated);
    for scene in scenes() {
        let text = fs::read_to_string(generated.join(&scene).join("manifest.json")).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let named: Vec<String> =
            manifest["files"].as_object().expect("files").keys().map(|path| format!("{scene}/{path}")).collect();
        let there: Vec<&String> = files
            .iter()
            .filter(|path| path.starts_with(&format!("{scene}/")) && !path.ends_with("manifest.json"))
            .collect();
        assert_eq!(named.iter().collect::<Vec<_>>(), there);
    }
    let strays: Vec<&String> = files.iter().filter(|path| !path.contains('/')).collect();
    assert!(strays.is_empty(), "files of nobody: {strays:?}");
}

#[test]
fn the_manual_is_what_ltsc_says() {
    let ran = run(ltsc().args(if bless() {
        &["manual", "-o", "docs", "--force"][..]
    } else {
        &["manual", "-o", "docs", "--check"]
    }));
    assert_eq!(ran.code, Some(0), "run `cargo run -- manual -o docs`\n{}{}", ran.out, ran.err);
}
