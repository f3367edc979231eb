//! Pages that follow from the scenes: the catalogue, and the README's table.

use std::fs;

use super::{QUICK, bless, ltsc, root, run};

#[test]
fn the_catalogue_is_what_ltsc_says() {
    let ran = run(ltsc().args(if bless() { &["doc", "--force"][..] } else { &["doc", "--check"] }));
    assert_eq!(ran.code, Some(0), "run `cargo run -- doc`\n{}{}", ran.out, ran.err);
}

#[test]
fn one_scene_leaves_the_pages_of_others_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let doc = |scenes: &[&str]| {
        let ran = run(ltsc().arg("doc").args(scenes).arg("-o").arg(folder.path()));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
    };
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a page");
    doc(&["scenes-src/cbox_empty.lts", "scenes-src/ring.lts"]);
    let before = [text("README.md"), text("cbox_empty.md")];
    fs::remove_file(folder.path().join("ring.md")).expect("removed");
    doc(&["scenes-src/ring.lts"]);
    assert!(text("ring.md").contains("# ring"));
    assert_eq!([text("README.md"), text("cbox_empty.md")], before);
}

/// The cells of a row without the time, which differs between machines.
fn timeless(row: &str) -> Vec<&str> {
    row.split('|').enumerate().filter(|(at, _)| *at != 2).map(|(_, cell)| cell.trim()).collect()
}

/// The lines of the README around its table, and the table.
fn readme() -> [String; 3] {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    let (start, end) = ("<!-- stats -->\n\n", "\n<!-- end of stats -->");
    let (before, rest) = text.split_once(start).expect("a table");
    let (table, after) = rest.split_once(end).expect("its end");
    [format!("{before}{start}"), table.to_owned(), format!("{end}{after}")]
}

/// What `ltsc build --stats` says of these, with the times that `table` has: a time that was measured stays.
fn stats(files: &[String], table: &str) -> Vec<String> {
    let ran = run(ltsc().args(["build", "--stats"]).args(files));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let kept = |row: &str| {
        let known = table.lines().find(|known| timeless(known) == timeless(row));
        known.map_or_else(|| row.to_owned(), str::to_owned)
    };
    ran.out.lines().map(kept).collect()
}

/// How the table is made anew.
const STALE: &str =
    "the table of README.md is stale: run `INSTA_UPDATE=always cargo test --test suite -- --ignored readme`";

#[test]
fn the_readme_says_what_small_scenes_become() {
    let [_, table, _] = readme();
    let rows = stats(&QUICK.map(|scene| format!("scenes-src/{scene}.lts")), &table);
    assert_eq!(rows.len(), QUICK.len() + 2, "{rows:?}");
    for row in rows {
        assert!(bless() || table.lines().any(|known| known == row), "{STALE}\n{row}");
    }
}

#[test]
#[ignore = "long: builds all scenes"]
fn the_readme_says_what_scenes_become() {
    let [before, table, after] = readme();
    let made: String = stats(&["scenes-src".to_owned()], &table).into_iter().map(|row| format!("{row}\n")).collect();
    if bless() {
        fs::write(root().join("README.md"), format!("{before}{made}{after}")).expect("a writable README");
        return;
    }
    assert!(made == table, "{STALE}\n{made}");
}
