//! `ltsc conventions`: what is listed, what is kept, and a few conventions through the renderers that are there.

use std::fs;
use std::process::Command;

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::install::{Status, status};
use ltsc_render::run::driver;

use super::{bless, ltsc, root, run, skip};

#[test]
fn the_page_is_what_the_stored_numbers_say() {
    let mut command: Command = ltsc();
    command.args(["conventions", "-o", "docs", "--stored"]);
    let ran = run(command.arg(if bless() { "--force" } else { "--check" }));
    assert_eq!(ran.code, Some(0), "run `cargo run -- conventions -o docs --stored`\n{}{}", ran.out, ran.err);
}

/// The README shows how many answers of targets were not measured.
#[test]
fn the_readme_says_what_was_not_measured() {
    let path = root().join("README.md");
    let text = fs::read_to_string(&path).expect("README.md").replace("\r\n", "\n");
    let (start, end) = ("<!-- coverage -->\n", "<!-- end of coverage -->");
    let (before, rest) = text.split_once(start).expect("the number");
    let (number, after) = rest.split_once(end).expect("its end");
    let ran = run(ltsc().args(["conventions", "--coverage"]));
    let last = ran.out.lines().last().expect("a sum");
    assert_eq!(ran.code, Some(i32::from(!last.ends_with(" 0 not measured"))), "{}", ran.out);
    if bless() {
        fs::write(&path, format!("{before}{start}{last}\n{end}{after}")).expect("a writable README");
        return;
    }
    assert_eq!(number.trim(), last, "run the tests with INSTA_UPDATE=always");
}

#[test]
fn scenes_have_their_canonical_form() {
    let ran = run(ltsc().args(["fmt", "--check", "renderers/evaluation/conventions"]));
    assert_eq!(ran.code, Some(0), "run `cargo run -- fmt renderers/evaluation/conventions`\n{}{}", ran.out, ran.err);
}

#[test]
fn conventions_are_listed() {
    let ran = run(ltsc().args(["conventions", "--list"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.lines().count() >= 25 && ran.out.contains("\npath_depth "), "{}", ran.out);
    let ran = run(ltsc().args(["conventions", "--list", "--only", "mirror", "--format", "json"]));
    let document: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(document["conventions"].as_array().expect("a list").len(), 1);
    assert_eq!(document["conventions"][0]["checks"], 5);
}

#[test]
fn wrong_usage_is_told_with_a_hint() {
    let cases: [(&[&str], i32, &str); 6] = [
        (&[], 2, "--renderer NAME"),
        (&["--renderer", "mitsuba-4"], 2, "did you mean `mitsuba-3`?"),
        (&["--renderer", "mitsuba-3", "--only", "path_dept"], 2, "did you mean `path_depth`?"),
        (&["--renderer", "mitsuba-3,luxcore", "--executable", "x"], 2, "name one renderer"),
        (&["--stored"], 2, "--output"),
        (&["--renderer", "mitsuba-3", "--executable", "no/such/python"], 4, "no such program"),
    ];
    for (arguments, code, hint) in cases {
        let ran = run(ltsc().arg("conventions").args(arguments));
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(hint), "{arguments:?}: {}", ran.err);
    }
}

/// The rows that a renderer gives for some conventions; none where it is missing.
fn rows(renderer: &str, only: &str) -> Option<Vec<serde_json::Value>> {
    let env = Env::of_process();
    let driver = driver(renderer).expect("a driver");
    let found = status(driver, CachePaths::find(&env).as_ref(), &env);
    if !matches!(found, Status::Installed { .. } | Status::External { .. }) {
        skip("conventions", &format!("`ltsc renderers install {renderer}`"));
        return None;
    }
    let ran = run(ltsc().args(["conventions", "--renderer", renderer, "--only", only, "--format", "json"]));
    assert_eq!(ran.code, Some(0), "{renderer}: {}{}", ran.out, ran.err);
    let document: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    Some(document["renderers"][0]["rows"].as_array().expect("rows").clone())
}

/// Renderers, and whether they hold the convention of depths.
const RENDERERS: [(&str, bool); 5] =
    [("mitsuba-3", true), ("luxcore", false), ("cycles", false), ("pbrt-r4", true), ("pbrt-r3", true)];

/// Cycles and LuxCore start slowly, and pbrt-r3 answers as pbrt-r4 does.
const LATE: [&str; 3] = ["cycles", "luxcore", "pbrt-r3"];

/// Quick ones, in the renderers that start quickly.
#[test]
fn renderers_hold_what_they_are_said_to_hold() {
    for (renderer, holds) in RENDERERS.into_iter().filter(|(renderer, _)| !LATE.contains(renderer)) {
        quick(renderer, holds);
    }
}

fn quick(renderer: &str, holds: bool) {
    let Some(rows) = rows(renderer, "emitter_side,path_depth") else { return };
    assert_eq!(rows.len(), 6, "{renderer}");
    let depth = rows.iter().find(|row| row["view"] == "depth 1").expect("a row");
    assert_eq!(depth["verdict"], if holds { "holds" } else { "unsupported" }, "{renderer}");
}

/// Those with more images.
#[test]
#[ignore = "long: four images by each renderer"]
fn renderers_hold_more_of_what_they_are_said_to_hold() {
    for (renderer, holds) in RENDERERS.into_iter().filter(|(renderer, _)| LATE.contains(renderer)) {
        quick(renderer, holds);
    }
    for (renderer, _) in RENDERERS {
        let Some(rows) = rows(renderer, "image_quarters,conductor_alpha") else { continue };
        assert_eq!(rows.len(), 23, "{renderer}");
        let quarters = rows.iter().filter(|row| row["convention"] == "image_quarters");
        assert!(quarters.clone().count() == 18 && quarters.clone().all(|row| row["verdict"] == "holds"), "{renderer}");
    }
}

/// Images on surfaces and of the environment: where each renderer's way of reading and interpolating them shows.
#[test]
#[ignore = "long: some thirty images by each renderer"]
fn images_mean_the_same_in_every_renderer() {
    for renderer in ["mitsuba-3", "luxcore", "cycles"] {
        let Some(rows) = rows(renderer, "texture_interpolation,environment_image") else { continue };
        // Two renderers mix the rows at the poles, which is stated.
        let good = |row: &&serde_json::Value| row["verdict"] == "holds" || row["verdict"] == "approximate";
        let broken: Vec<_> = rows.iter().filter(|row| !good(row)).collect();
        assert!(rows.len() == 9 * 3 + 9 * 8 && broken.is_empty(), "{renderer}: {broken:?}");
    }
}
