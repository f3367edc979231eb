//! Pages that follow from the scenes: the catalogue, and the README's table.

use std::fs;

use super::{bless, ltsc, root, run};

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

#[test]
fn the_readme_says_what_scenes_become() {
    let path = root().join("README.md");
    let text = fs::read_to_string(&path).expect("README.md");
    let (start, end) = ("<!-- stats -->\n\n", "\n<!-- end of stats -->");
    let (before, rest) = text.split_once(start).expect("a table");
    let (table, after) = rest.split_once(end).expect("its end");
    let ran = run(ltsc().args(["build", "scenes-src", "--stats"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    // A time that was measured stays.
    let kept = |row: &str| {
        let known = table.lines().find(|known| timeless(known) == timeless(row));
        known.map_or_else(|| row.to_owned(), str::to_owned)
    };
    let made: String = ran.out.lines().map(|row| format!("{}\n", kept(row))).collect();
    if bless() {
        fs::write(&path, format!("{before}{start}{made}{end}{after}")).expect("a writable README");
        return;
    }
    assert!(made == table, "the table of README.md is stale: `ltsc build scenes-src --stats` says\n{}", ran.out);
}
