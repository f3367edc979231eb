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

/// The lines of the README around its table, and the table.
fn readme() -> [String; 3] {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    let (start, end) = ("<!-- stats -->\n\n", "\n<!-- end of stats -->");
    let (before, rest) = text.split_once(start).expect("a table");
    let (table, after) = rest.split_once(end).expect("its end");
    [format!("{before}{start}"), table.to_owned(), format!("{end}{after}")]
}

/// A row with the time of another one of the same scene.
fn at_the_time_of(row: &str, known: &str) -> String {
    let cells = |row: &str| row.split('|').map(str::to_owned).collect::<Vec<_>>();
    let (mut made, known) = (cells(row), cells(known));
    if let (Some(time), Some(of)) = (made.get_mut(2), known.get(2)) {
        time.clone_from(of);
    }
    made.join("|")
}

/// What `ltsc build --stats` says of these, with the times that `table` has of these scenes: it tells those of a release build, which
/// this one is not.
fn stats(files: &[String], table: &str) -> Vec<String> {
    let ran = run(ltsc().args(["build", "--stats"]).args(files));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let kept = |row: &str| {
        let scene = |row: &str| row.split('|').nth(1).map(|cell| cell.trim().to_owned());
        let known = table.lines().find(|known| scene(known) == scene(row));
        known.map_or_else(|| row.to_owned(), |known| at_the_time_of(row, known))
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
