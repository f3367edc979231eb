//! `ltsc agree`: right renderers agree, a planted difference is found, and the page is what its record says.

use std::fs;
use std::path::PathBuf;

use super::{bless, ltsc, root, run, skip};

fn there(name: &str) -> bool {
    let ran = run(ltsc().args(["renderers", "list", "--format", "json"]));
    let list: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let all = list["renderers"].as_array().expect("a list");
    all.iter().any(|one| one["name"] == name && matches!(one["status"].as_str(), Some("installed" | "found")))
}

fn scene() -> PathBuf {
    root().join("scenes-src/cbox_classic.lts")
}

#[test]
fn one_renderer_agrees_with_itself_and_not_with_other_depths() {
    if !there("mitsuba-3") {
        return skip("agreement", "`ltsc renderers install mitsuba-3`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("agreement.json");
    let agree = |reference: &str, tolerance: &str, more: &[&str]| {
        run(ltsc()
            .arg("agree")
            .arg(scene())
            .args(["--renderer", "mitsuba-3", "--seeds", "4", "--samples", "32", "--size", "32"])
            .args(["--tolerance", tolerance, "--mean-tolerance", "0.05", "--reference"])
            .arg(folder.path().join(reference))
            .args(["--reference-name", "made for this test", "--keep"])
            .arg(folder.path().join("kept"))
            .args(more))
    };
    for (name, depth) in [("same", "10"), ("shallow", "3")] {
        for seed in ["100", "101", "102", "103"] {
            let image = folder.path().join(format!("{name}/cbox_classic-{}.exr", &seed[2..]));
            let ran = run(ltsc()
                .arg("render")
                .arg(scene())
                .args(["--renderer", "mitsuba-3", "--width", "32", "--height", "32", "--samples", "64"])
                .args(["--seed", seed, "--max-depth", depth, "-o"])
                .arg(&image));
            assert_eq!(ran.code, Some(0), "{}", ran.err);
        }
    }
    let same = agree("same", "40%", &["--record", record.to_str().expect("a name")]);
    assert_eq!(same.code, Some(0), "{}{}", same.out, same.err);
    assert!(same.out.contains("reference and mitsuba-3: agree: within 40.0 %"), "{}", same.out);
    assert!(folder.path().join("kept/page/index.html").is_file(), "{}", same.err);
    // The same images prove nothing narrower, and say how many samples would.
    let narrow = agree("same", "2%", &["--require-agree"]);
    assert_eq!(narrow.code, Some(1), "{}{}", narrow.out, narrow.err);
    assert!(
        narrow.out.contains("undecided") && narrow.out.contains("samples per pixel would show it"),
        "{}",
        narrow.out
    );
    // Taken from the folder of kept images: the same numbers.
    let shallow = agree("shallow", "40%", &["--format", "json"]);
    assert_eq!(shallow.code, Some(1), "{}{}", shallow.out, shallow.err);
    let answer: serde_json::Value = serde_json::from_str(&shallow.out).expect("JSON");
    let row = &answer["rows"][0];
    assert_eq!(row["verdict"]["outcome"], "differ", "{row}");
    for channel in 0..3 {
        assert!(row["verdict"]["channels"][channel]["ratio"].as_f64().expect("a ratio") > 1.02, "{row}");
    }
    let page = fs::read_to_string(record.with_extension("md")).expect("a page");
    assert!(page.contains("made for this test") && page.contains("**agree**"), "{page}");
}

#[test]
fn wrong_usage_is_told_apart() {
    let ran = |args: &[&str]| run(ltsc().arg("agree").args(args));
    let one = ran(&["scenes-src/ring.lts", "--seeds", "1"]);
    assert!(one.code == Some(2) && one.err.contains("4 seeds"), "{}", one.err);
    let share = ran(&["scenes-src/ring.lts", "--tolerance", "5"]);
    assert!(share.code == Some(2) && share.err.contains("`0.05` or `5%`"), "{}", share.err);
    let unknown = ran(&["scenes-src/ring.lts", "--renderer", "mitsuba-4"]);
    assert!(unknown.code == Some(2) && unknown.err.contains("mitsuba-3"), "{}", unknown.err);
    let alone = ran(&["scenes-src/ring.lts", "--renderer", "mitsuba-3"]);
    assert!(alone.code == Some(2) && alone.err.contains("--reference"), "{}", alone.err);
    let nowhere = ran(&["scenes-src/ring.lts", "--reference", "no-such-folder", "--renderer", "mitsuba-3"]);
    assert!(nowhere.code == Some(2) && nowhere.err.contains("no folder"), "{}", nowhere.err);
    assert_eq!(ran(&["--check"]).code, Some(2));
    let missing = ran(&["--check", "--record", "no-such-file.json"]);
    assert!(missing.code == Some(3) && missing.err.contains("missing"), "{}", missing.err);
}

#[test]
fn the_page_of_agreement_is_what_its_record_says() {
    let record = root().join("docs/agreement.json");
    let ran = run(ltsc().args(["agree", "--check", "--record"]).arg(&record));
    if ran.code == Some(1) && bless() {
        // A run without scenes renders nothing and writes the page.
        let empty = tempfile::tempdir().expect("a folder");
        let lib = empty.path().join("empty.lts");
        fs::write(&lib, "lts 1\n").expect("a library");
        let ran = run(ltsc().arg("agree").arg(&lib).arg("--force").arg("--record").arg(&record));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        return;
    }
    assert_eq!(ran.code, Some(0), "run the tests with INSTA_UPDATE=always\n{}{}", ran.out, ran.err);
}
