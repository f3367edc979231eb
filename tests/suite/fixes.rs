//! `ltsc lint --fix` and `--diff`: what is written, what is left, and what says so.

use std::fs;
use std::path::Path;

use super::outputs::{CLEAN, project};
use super::{Ran, ltsc, run};

const SMOOTH: &str = "emitter bulb = sphere(segments: 8, rings: 4) |> translate(z: 3) with radiance(1)  // bright\n";
const FACETED: &str =
    "emitter bulb = sphere(segments: 8, rings: 4) |> translate(z: 3) |> faceted() with radiance(1)  // bright\n";

fn lint(folder: &Path, args: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).arg("lint").args(args))
}

fn scene(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(format!("scenes/{name}.lts"))).expect("a scene")
}

#[test]
fn a_scene_is_fixed_and_the_rest_of_it_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let needless = "allow rough-too-small \"nothing is rough\"\n";
    project(folder, &[("bulb", &format!("\n   // odd   form\n{needless}{SMOOTH}")), ("nothing", "")]);
    let before = scene(folder, "bulb");
    let untouched = fs::metadata(folder.join("scenes/nothing.lts")).and_then(|meta| meta.modified()).expect("a time");
    assert!(
        lint(folder, &[]).err.contains("`ltsc lint --fix` mends 1"),
        "a comment before the needless `allow` keeps it"
    );

    let shown = lint(folder, &["--diff"]);
    assert_eq!(shown.code, Some(1), "{}", shown.err);
    let lines: Vec<&str> = shown.out.lines().filter(|line| line.starts_with(['+', '-'])).collect();
    let expected = ["--- scenes/bulb.lts", "+++ scenes/bulb.lts, fixed"];
    assert_eq!(lines[..2], expected);
    assert_eq!(lines[2..], [format!("-{}", SMOOTH.trim_end()), format!("+{}", FACETED.trim_end())]);
    assert!(shown.err.contains("1 finding would be fixed in 1 file; then 0 errors, 1 warning"), "{}", shown.err);
    assert_eq!(scene(folder, "bulb"), before, "`--diff` writes nothing");

    let fixed = lint(folder, &["--fix"]);
    assert_eq!(fixed.code, Some(0), "{}{}", fixed.out, fixed.err);
    assert!(fixed.err.contains("1 finding fixed in 1 file"), "{}", fixed.err);
    assert_eq!(scene(folder, "bulb"), before.replace(SMOOTH, FACETED));
    let again = lint(folder, &["--fix", "--format", "short"]);
    assert!(again.err.contains("0 findings fixed in 0 files") && again.code == Some(0), "{}", again.err);
    let after = fs::metadata(folder.join("scenes/nothing.lts")).and_then(|meta| meta.modified()).expect("a time");
    assert_eq!(untouched, after, "a file without fixes is not written");
    assert_eq!(lint(folder, &["--diff"]).out, "");
}

#[test]
fn programs_get_the_fixes_without_their_being_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(folder, &[("bulb", SMOOTH)]);
    let json: serde_json::Value = serde_json::from_str(&lint(folder, &["--format", "json"]).out).expect("JSON");
    let fix = &json["findings"][0]["fix"];
    let column = SMOOTH.find(" with").expect("a place") + 1;
    assert_eq!(
        (fix["edits"][0]["place"]["column"].as_u64(), &fix["edits"][0]["text"]),
        (Some(column as u64), &" |> faceted()".into())
    );
    let sarif: serde_json::Value = serde_json::from_str(&lint(folder, &["--format", "sarif"]).out).expect("JSON");
    let change = &sarif["runs"][0]["results"][0]["fixes"][0]["artifactChanges"][0];
    assert_eq!(change["artifactLocation"]["uri"], "scenes/bulb.lts");
    let region = &change["replacements"][0]["deletedRegion"];
    assert_eq!(
        (region["startColumn"].as_u64(), region["endColumn"].as_u64()),
        (Some(column as u64), Some(column as u64))
    );
}

#[test]
fn programs_get_what_was_fixed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let turned = "shape b = box(size: 1) |> flip() |> translate(z: 2) with diffuse(0.5)\n";
    project(folder, &[("bulb", &format!("{SMOOTH}{turned}")), ("nothing", "")]);
    let json = |args: &[&str]| -> serde_json::Value {
        serde_json::from_str(&lint(folder, &[&["--format", "json"], args].concat()).out).expect("JSON")
    };
    assert!(json(&[]).get("fixed").is_none(), "nobody asked for a change");
    let found = json(&[]);
    let fixed = json(&["--fix"]);
    let list = fixed["fixed"].as_array().expect("a list");
    assert_eq!(list.len(), 2, "{fixed:#}");
    for (one, before) in list.iter().zip(found["findings"].as_array().expect("a list")) {
        assert_eq!((&one["id"], &one["place"], &one["message"]), (&before["id"], &before["place"], &before["message"]));
        assert_eq!(one["fix"], before["fix"]["title"]);
    }
    assert_eq!(list[0]["place"]["path"], "scenes/bulb.lts");
    assert_eq!(fixed["findings"].as_array().map(Vec::len), Some(0), "{fixed:#}");
    assert_eq!(json(&["--fix"])["fixed"].as_array().map(Vec::len), Some(0));
}

#[test]
fn several_rounds_bring_what_stands_in_each_others_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    fs::create_dir(folder.join("lib")).expect("a folder");
    fs::write(folder.join("lib/numbers.lts"), "let p = 1\nlet q = 2\nlet r = 3\n").expect("a library");
    project(
        folder,
        &[
            ("one", "use p, q, r from \"../lib/numbers.lts\"\n"),
            ("three", "use p from \"../lib/numbers.lts\"\nlet n = p\n"),
        ],
    );
    let fixed = lint(folder, &["--fix", "--format", "short"]);
    assert!(fixed.err.contains("3 findings fixed in 1 file"), "{}{}", fixed.out, fixed.err);
    assert_eq!(scene(folder, "one"), CLEAN.replace("NAME", "one").replace("LDE", "LDDDDE"));
    // The library was not asked for, and keeps its finding.
    assert!(fixed.out.contains("lib/numbers.lts") && fixed.out.contains("missing-version"), "{}", fixed.out);
    assert!(fs::read_to_string(folder.join("lib/numbers.lts")).expect("a library").starts_with("let p"));
    // Two scenes use it, and it is fixed once where it is asked for.
    let both = lint(folder, &["--fix", "--format", "short", "scenes", "lib"]);
    assert!(both.err.contains("1 finding fixed in 1 file"), "{}{}", both.out, both.err);
    let text = fs::read_to_string(folder.join("lib/numbers.lts")).expect("a library");
    assert_eq!(text, "lts 1\n\nlet p = 1\nlet q = 2\nlet r = 3\n");
}

#[test]
fn a_fix_that_would_lead_to_an_error_is_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let own = "mesh faceted(m: mesh, size: number) = m\n";
    let turned = "shape b = box(size: 1) |> flip() |> translate(z: 2) with diffuse(0.5)\n";
    project(folder, &[("bulb", &format!("{own}{SMOOTH}{turned}"))]);
    let fixed = lint(folder, &["--fix", "--format", "short"]);
    assert!(fixed.code == Some(1) && fixed.out.contains("smooth-emitter"), "{}{}", fixed.out, fixed.err);
    assert!(fixed.err.contains("1 finding fixed in 1 file; 1 finding not fixed"), "{}", fixed.err);
    let text = scene(folder, "bulb");
    assert!(text.contains(SMOOTH) && text.contains("|> translate(z: 2) |> flip()"), "{text}");
}

#[test]
fn line_ends_of_windows_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(folder, &[("bulb", SMOOTH)]);
    let windows = scene(folder, "bulb").replace("lts 1\n\n", "").replace('\n', "\r\n");
    fs::write(folder.join("scenes/bulb.lts"), &windows).expect("a write");
    assert_eq!(lint(folder, &["--fix"]).code, Some(0));
    let smooth = SMOOTH.replace('\n', "\r\n");
    assert_eq!(
        scene(folder, "bulb"),
        format!("lts 1\r\n\r\n{}", windows.replace(&smooth, &FACETED.replace('\n', "\r\n")))
    );
}
