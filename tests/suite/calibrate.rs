//! `ltsc calibrate`: its page, what it refuses, and a small count with a real renderer.

use std::fs;

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::install::{Status, status};
use ltsc_render::run::driver;

use super::{bless, ltsc, root, run, skip};

#[test]
fn the_page_is_what_the_record_says() {
    let mut command = ltsc();
    command.args(["calibrate", "-o", "docs", "--stored"]);
    let ran = run(command.arg(if bless() { "--force" } else { "--check" }));
    assert_eq!(ran.code, Some(0), "run `cargo run -- calibrate -o docs --stored`\n{}{}", ran.out, ran.err);
}

/// What was counted keeps the promises, on enough pairs of each scene.
#[test]
fn the_record_holds_enough_pairs_and_no_bar_is_missed() {
    let text = fs::read_to_string(root().join("docs/calibration.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let scenes = record["scenes"].as_array().expect("scenes");
    let names: Vec<&str> = scenes.iter().filter_map(|scene| scene["scene"].as_str()).collect();
    assert_eq!(names, ["cbox_classic", "ring", "pool_simple, lamp_side=40", "veach_mis"]);
    for scene in scenes {
        let rows = scene["rows"].as_array().expect("rows");
        let of = |test: &str, key: &str| -> u64 {
            rows.iter().filter(|row| row["test"] == test).filter_map(|row| row[key].as_u64()).sum()
        };
        let (pairs, wrong) = (of("same", "pairs"), of("same", "differ"));
        assert!(pairs >= 1000 && wrong * 100 <= pairs, "{}: {wrong} of {pairs}", scene["scene"]);
        let base = &scene["pools"][0];
        assert!(base["name"] == "base" && base["chunks"].as_u64().expect("a count") >= 1024, "{base}");
    }
    let page = fs::read_to_string(root().join("docs/calibration.md")).expect("a page");
    assert!(!page.contains("**missed**"), "a promise is not kept: see docs/calibration.md");
}

#[test]
fn wrong_usage_is_told_with_a_hint() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().to_str().expect("a name");
    let cases: [(&[&str], i32, &str); 5] = [
        (&["--only", "cbox_clasic"], 2, "did you mean `cbox_classic`?"),
        (&["--stored"], 2, "--output"),
        (&["--check"], 2, "--stored"),
        (&["--chunks", "1"], 2, "2..=8192"),
        (&["-o", place, "--stored"], 3, "`ltsc calibrate --output DIR` counts one"),
    ];
    for (words, code, hint) in cases {
        let ran = run(ltsc().arg("calibrate").args(words));
        assert!(ran.code == Some(code) && ran.err.contains(hint), "{words:?}: {:?} {}", ran.code, ran.err);
    }
    fs::write(folder.path().join("calibration.json"), "{\"scenes\": 1}").expect("written");
    let ran = run(ltsc().args(["calibrate", "-o", place, "--stored"]));
    assert!(ran.code == Some(3) && ran.err.contains("calibration.json"), "{}", ran.err);
    // A page of a person is found before anything is looked for or rendered.
    fs::write(folder.path().join("calibration.json"), "{\"scenes\": []}").expect("written");
    let ran = run(ltsc().args(["calibrate", "-o", place, "--kept"]));
    assert!(ran.code == Some(2) && ran.err.contains("--force"), "{}", ran.err);
}

#[test]
fn a_project_without_the_scenes_is_told() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("scenes")).expect("a folder");
    fs::write(folder.path().join("ltsc.toml"), "scenes = \"scenes\"\n").expect("written");
    let count = || run(ltsc().current_dir(folder.path()).args(["calibrate", "--only", "ring", "--kept"]));
    let ran = count();
    assert!(ran.code == Some(3) && ran.err.contains("checkout of ltsc"), "{}", ran.err);
    // A scene of that name in which there is nothing to change.
    fs::write(folder.path().join("scenes/ring.lts"), "lts 1\n").expect("written");
    let ran = count();
    assert!(ran.code == Some(3) && ran.err.contains("ring"), "{}", ran.err);
}

fn is_there() -> bool {
    let env = Env::of_process();
    let found = status(driver("mitsuba-3").expect("a driver"), CachePaths::find(&env).as_ref(), &env);
    let there = matches!(found, Status::Installed { .. } | Status::External { .. });
    if !there {
        skip("calibrate", "`ltsc renderers install mitsuba-3`");
    }
    there
}

/// A few chunks, twice: the second run renders none of them and says the same.
#[test]
fn chunks_are_rendered_once_and_counted_alike() {
    if !is_there() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let pages = folder.path().to_str().expect("a name");
    let words =
        ["calibrate", "--only", "ring", "--chunks", "16", "--variant-chunks", "4", "--pairs", "10", "-o", pages];
    let ran = run(ltsc().args(words));
    assert!(matches!(ran.code, Some(0 | 1)), "{}", ran.err);
    let page = fs::read_to_string(folder.path().join("calibration.md")).expect("a page");
    assert!(
        page.contains("- veach_mis: not counted") && page.contains("| `base` | the scene as it is | 16 |"),
        "{page}"
    );
    assert!(page.contains("- ring: equal, 16 x 1 chunks against 16 x 1: needs 32 chunks of the base"), "{page}");
    let json = fs::read_to_string(folder.path().join("calibration.json")).expect("a record");
    let again = run(ltsc().args(words).arg("--kept"));
    assert!(again.code == ran.code && again.out == ran.out, "{}\n{}", again.out, ran.out);
    assert_eq!(fs::read_to_string(folder.path().join("calibration.json")).expect("a record"), json);
    let check = run(ltsc().args(["calibrate", "-o", pages, "--stored", "--check"]));
    assert_eq!(check.code, Some(0), "{}{}", check.out, check.err);
    fs::write(folder.path().join("calibration.md"), "other").expect("written");
    let check = run(ltsc().args(["calibrate", "-o", pages, "--stored", "--check"]));
    assert!(check.code == Some(1) && check.out.contains("stale"), "{}{}", check.out, check.err);
}
