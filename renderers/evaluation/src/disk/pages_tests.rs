//! Pages among files of a person: what is ours is known, what is not stays, and a run that fails on its way is gone on with.

use std::fs;

use super::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Pages of these texts, as one command writes them.
fn pages(folder: &Path, by: &'static str, texts: &[(&str, &str)]) -> Pages {
    let mut pages = Pages::new(folder, by);
    texts.iter().for_each(|(path, text)| pages.put(*path, *text));
    pages
}

/// Names below a folder that were written and removed.
fn finish(folder: &Path, pages: Pages, force: bool) -> Result<(Vec<String>, Vec<String>), String> {
    let done = pages.finish(false, force).map_err(|failure| failure.message)?;
    let names = |paths: &[PathBuf]| {
        let inside = |path: &PathBuf| path.strip_prefix(folder).expect("inside").to_string_lossy().into_owned();
        paths.iter().map(inside).collect::<Vec<_>>()
    };
    Ok((names(&done.written), names(&done.removed)))
}

fn write(folder: &Path, by: &'static str, texts: &[(&str, &str)]) -> Result<(Vec<String>, Vec<String>), String> {
    finish(folder, pages(folder, by, texts), false)
}

fn done(written: &[&str], removed: &[&str]) -> Result<(Vec<String>, Vec<String>), String> {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    Ok((owned(written), owned(removed)))
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn pages_are_written_once_and_then_only_where_they_change() {
    let folder = folder();
    let folder = folder.path();
    let check = pages(folder, "doc", &[("a", "1"), ("b/c", "2")]).finish(true, false).expect("to do");
    assert_eq!((check.count(), names(folder)), (2, Vec::new()), "nothing is written where it is only asked");
    assert_eq!(write(folder, "doc", &[("a", "1"), ("b/c", "2")]), done(&["a", "b/c"], &[]));
    assert_eq!((read(folder.join("a")), read(folder.join("b/c"))), ("1".to_owned(), "2".to_owned()));
    let record = read(folder.join(RECORD));
    assert!(record.contains("\"generator\": \"ltsc\"") && record.ends_with("}\n") && !record.contains("becomes"));
    // Without anything to do, not even the record is written.
    fs::write(folder.join(RECORD), format!("{record} ")).expect("written");
    assert_eq!(write(folder, "doc", &[("a", "1"), ("b/c", "2")]), done(&[], &[]));
    assert_eq!(read(folder.join(RECORD)), format!("{record} "));
    assert_eq!(write(folder, "doc", &[("a", "1"), ("b/c", "3")]), done(&["b/c"], &[]));
    assert_eq!(
        (read(folder.join("b/c")), names(folder)),
        ("3".to_owned(), vec![RECORD.to_owned(), "a".to_owned(), "b".to_owned()])
    );
    // A page that is gone is written anew.
    fs::remove_file(folder.join("a")).expect("removed");
    assert_eq!(write(folder, "doc", &[("a", "1"), ("b/c", "3")]), done(&["a"], &[]));
}

#[test]
fn what_a_person_wrote_or_changed_is_refused_as_a_whole() {
    let folder = folder();
    let folder = folder.path();
    assert!(write(folder, "doc", &[("ours", "1"), ("changed", "1")]).is_ok());
    fs::write(folder.join("changed"), "edited").expect("written");
    fs::write(folder.join("foreign"), "mine").expect("written");
    fs::create_dir(folder.join("folder")).expect("a folder");
    for wrong in ["changed", "foreign", "folder"] {
        let all = [("first", "2"), ("ours", "2"), (wrong, "2")];
        let refused = write(folder, "doc", &all).expect_err("refused");
        assert!(refused.contains(wrong) && refused.contains("nothing was written"), "{refused}");
        assert!(!folder.join("first").exists() && read(folder.join("ours")) == "1", "{wrong}");
        // It is told before long work as well, and listed as what would be written.
        let asked = Pages::new(folder, "doc");
        assert!(asked.refuse(wrong, false).is_err() && asked.refuse(wrong, true).is_ok(), "{wrong}");
        assert_eq!(pages(folder, "doc", &all).finish(true, false).expect("to do").written.len(), 3);
    }
    let asked = Pages::new(folder, "doc");
    assert!(asked.refuse("ours", false).is_ok() && asked.refuse("none", false).is_ok());
    assert!(asked.refuse("ours/below", false).is_ok(), "what cannot be there is refused when it is written");
    // By force a file is written over, and ours from then on.
    let forced = finish(folder, pages(folder, "doc", &[("ours", "1"), ("changed", "2"), ("foreign", "2")]), true);
    assert_eq!(forced, done(&["changed", "foreign"], &[]));
    assert_eq!(
        write(folder, "doc", &[("ours", "1"), ("changed", "3"), ("foreign", "3")]),
        done(&["changed", "foreign"], &[])
    );
}

#[test]
fn what_is_as_it_would_be_written_is_ours_whatever_its_line_ends() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("a"), "one\r\ntwo\r\n").expect("written");
    assert_eq!(write(folder, "doc", &[("a", "one\ntwo\n")]), done(&[], &[]));
    assert_eq!(read(folder.join("a")), "one\r\ntwo\r\n", "and stays as it is");
    // From then on it is in the record, and so may be written over.
    assert_eq!(write(folder, "doc", &[("a", "three\n")]), done(&["a"], &[]));
    for (one, other) in
        [("a\nb", "a\nb\n"), ("a\nb", "ab"), ("a\rb", "ab"), ("a\n\nb", "a\nb"), ("a\r\r\n", "a\n"), ("", "\n")]
    {
        assert_ne!(hash(one.as_bytes()), hash(other.as_bytes()), "{one:?} and {other:?}");
    }
    // Records that were committed hold this hash.
    assert_eq!(hash(b"one\r\ntwo\n"), blake3::hash(b"one\ntwo\n").to_hex().to_string());
    for (one, other) in [("a\nb", "a\r\nb"), ("a\r", "a"), ("\r\n", "\n")] {
        assert_eq!(hash(one.as_bytes()), hash(other.as_bytes()), "{one:?} and {other:?}");
    }
}

#[test]
fn what_is_no_longer_made_goes_as_it_was_written_and_by_its_own_command() {
    let folder = folder();
    let folder = folder.path();
    let all = [("gone/below/page", "1"), ("changed", "1"), ("kept", "1"), ("missing", "1"), ("stays", "1")];
    assert!(write(folder, "doc", &all).is_ok());
    assert!(write(folder, "manual", &[("other", "1")]).is_ok());
    fs::write(folder.join("changed"), "edited").expect("written");
    fs::remove_file(folder.join("missing")).expect("removed");
    let mut next = pages(folder, "doc", &[("stays", "1")]);
    assert_eq!(next.rest().collect::<Vec<_>>(), ["changed", "gone/below/page", "kept", "missing"]);
    next.keep(|path| path == "kept");
    assert_eq!(next.rest().collect::<Vec<_>>(), ["changed", "gone/below/page", "missing"]);
    assert_eq!(finish(folder, next, false), done(&[], &["gone/below/page"]));
    assert_eq!(names(folder), [RECORD, "changed", "kept", "other", "stays"], "folders that are empty are gone too");
    // What stays is not ours any more; what is kept is.
    assert_eq!(Pages::new(folder, "doc").rest().collect::<Vec<_>>(), ["kept", "stays"]);
    assert!(write(folder, "doc", &[("changed", "2")]).is_err());
    assert_eq!(Pages::new(folder, "manual").rest().collect::<Vec<_>>(), ["other"]);
    // Only asked, it stays.
    assert_eq!(pages(folder, "doc", &[]).finish(true, false).expect("to do").removed.len(), 2);
    assert!(folder.join("kept").exists());
    // A page that another command makes from now on is that command's.
    assert_eq!(write(folder, "manual", &[("other", "1"), ("kept", "2")]), done(&["kept"], &[]));
    assert_eq!(write(folder, "doc", &[]), done(&[], &["stays"]));
    assert_eq!(read(folder.join("kept")), "2");
}

/// A record is a file like any other: it may name what lies elsewhere.
#[test]
fn a_record_leads_nowhere_else() {
    let root = folder();
    let folder = root.path().join("docs");
    let outside = root.path().join("outside");
    fs::create_dir_all(folder.join("inner")).expect("a folder");
    fs::create_dir(&outside).expect("a folder");
    for place in [root.path().join("thesis"), outside.join("thesis")] {
        fs::write(place, "mine").expect("written");
    }
    let mut record = Record { generator: "ltsc".to_owned(), ..Record::default() };
    let ours = Ours { by: "doc".to_owned(), hash: hash(b"mine"), becomes: None };
    record.files.insert("../thesis".to_owned(), ours.clone());
    record.files.insert(root.path().join("thesis").to_string_lossy().into_owned(), ours.clone());
    record.files.insert("link/thesis".to_owned(), ours);
    fs::write(folder.join(RECORD), serde_json::to_vec(&record).expect("a text")).expect("written");
    #[cfg(unix)]
    std::os::unix::fs::symlink(&outside, folder.join("link")).expect("a link");
    assert_eq!(write(&folder, "doc", &[("a", "1")]), done(&["a"], &[]));
    assert_eq!(
        (read(root.path().join("thesis")), read(outside.join("thesis"))),
        ("mine".to_owned(), "mine".to_owned())
    );
    #[cfg(unix)]
    {
        let refused = write(&folder, "doc", &[("link/new", "1")]).expect_err("a link leads out");
        assert!(refused.contains("link"), "{refused}");
        assert_eq!(names(&outside), ["thesis"]);
    }
    // What is not ltsc's is no record.
    record.generator = "other".to_owned();
    record.files.insert("a".to_owned(), Ours { by: "doc".to_owned(), hash: hash(b"2"), becomes: None });
    fs::write(folder.join(RECORD), serde_json::to_vec(&record).expect("a text")).expect("written");
    fs::write(folder.join("a"), "2").expect("written");
    assert!(Pages::new(&folder, "doc").refuse("a", false).is_err());
}

/// A link where a page was is a person's, wherever it leads; so is what cannot be looked at.
#[cfg(unix)]
#[test]
fn links_in_the_place_of_pages_are_not_written_over() {
    let root = folder();
    let folder = root.path().join("docs");
    assert!(write(&folder, "doc", &[("a", "1"), ("gone", "1")]).is_ok());
    let other = root.path().join("other");
    for name in ["a", "gone"] {
        fs::remove_file(folder.join(name)).expect("removed");
        fs::write(&other, "1").expect("written");
        std::os::unix::fs::symlink(&other, folder.join(name)).expect("a link");
    }
    assert!(Pages::new(&folder, "doc").refuse("a", false).is_err());
    assert!(write(&folder, "doc", &[("a", "2"), ("gone", "1")]).is_err());
    assert_eq!(write(&folder, "doc", &[]), done(&[], &[]));
    assert!(folder.join("gone").is_symlink() && read(&other) == "1");
    std::os::unix::fs::symlink("endless", folder.join("endless")).expect("a link");
    assert!(Pages::new(&folder, "doc").refuse("endless/page", false).is_err());
}

/// The run fails at its second page, where a file stands in the place of a folder; the first is written by then.
#[test]
fn a_run_that_fails_on_its_way_is_gone_on_with() {
    let folder = folder();
    let folder = folder.path();
    assert!(write(folder, "doc", &[("a", "1"), ("later", "1")]).is_ok());
    fs::write(folder.join("b"), "mine").expect("written");
    let all = [("a", "2"), ("aa", "2"), ("b/c", "2"), ("later", "2")];
    assert!(write(folder, "doc", &all).is_err());
    assert_eq!(["a", "aa", "later"].map(|name| read(folder.join(name))), ["2", "2", "1"]);
    // Whatever the next run makes of them, all of them are ours.
    assert_eq!(read(folder.join("b")), "mine");
    fs::remove_file(folder.join("b")).expect("removed");
    let all = [("a", "3"), ("aa", "3"), ("b/c", "3"), ("later", "3")];
    assert_eq!(write(folder, "doc", &all), done(&["a", "aa", "b/c", "later"], &[]));
    assert!(!read(folder.join(RECORD)).contains("becomes"));
}

#[test]
fn what_was_read_may_be_written_over() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("a"), "mine").expect("written");
    let mut merged = Pages::new(folder, "doc");
    merged.put_merged("a", "mine, and more");
    assert_eq!(finish(folder, merged, false), done(&["a"], &[]));
    assert_eq!(read(folder.join("a")), "mine, and more");
}

#[test]
fn commands_that_write_at_once_keep_each_others_records() {
    let folder = folder();
    let folder = folder.path();
    assert!(write(folder, "doc", &[("a", "1"), ("gone", "1")]).is_ok());
    let begun = pages(folder, "doc", &[("a", "2")]);
    assert!(write(folder, "manual", &[("b", "1")]).is_ok());
    assert_eq!(finish(folder, begun, false), done(&["a"], &["gone"]));
    let record = Record::read(folder);
    let by: Vec<(&str, &str)> = record.files.iter().map(|(path, ours)| (path.as_str(), ours.by.as_str())).collect();
    assert_eq!(by, [("a", "doc"), ("b", "manual")]);
    assert_eq!(record.files["a"], Ours { by: "doc".to_owned(), hash: hash(b"2"), becomes: None });
}

#[test]
fn what_a_killed_run_left_is_told_and_goes() {
    let folder = folder();
    let folder = folder.path();
    assert!(write(folder, "doc", &[("a", "1")]).is_ok());
    fs::create_dir_all(folder.join(STAGING).join("0")).expect("a folder");
    let asked = pages(folder, "doc", &[("a", "1")]).finish(true, false).expect("to do");
    assert_eq!((asked.count(), asked.removed), (1, vec![folder.join(STAGING)]));
    assert!(folder.join(STAGING).exists());
    assert_eq!(write(folder, "doc", &[("a", "1")]), done(&[], &[STAGING]));
    assert_eq!(names(folder), [RECORD, "a"]);
}

#[test]
fn what_was_done_has_a_line_for_each_file() {
    let done = Done { written: vec!["a".into(), "b".into()], removed: vec!["c".into()] };
    assert_eq!(done.count(), 3);
    assert_eq!(done.lines(false), "a written\nb written\nc removed\n");
    assert_eq!(done.lines(true), "stale: a\nstale: b\nleft over: c\n");
}

#[test]
fn eight_files_are_named_and_the_rest_counted() {
    let of = |count: usize| {
        let files: Vec<PathBuf> = (0..count).map(|at| at.to_string().into()).collect();
        not_ours(&files).message
    };
    assert!(of(1).starts_with("0 is there, and ltsc did not write it as it is; nothing was written"), "{}", of(1));
    assert!(of(2).starts_with("0, 1 are there, and ltsc did not write them as they are; nothing"), "{}", of(2));
    assert!(of(8).starts_with("0, 1, 2, 3, 4, 5, 6, 7 are there"), "{}", of(8));
    assert!(of(11).starts_with("0, 1, 2, 3, 4, 5, 6, 7 and 3 more are there"), "{}", of(11));
}

#[test]
fn what_cannot_be_there_is_absent() {
    for (kind, absent) in [
        (io::ErrorKind::NotFound, true),
        (io::ErrorKind::NotADirectory, true),
        (io::ErrorKind::InvalidFilename, true),
        (io::ErrorKind::PermissionDenied, false),
        (io::ErrorKind::Other, false),
    ] {
        assert_eq!(is_absent(&kind.into()), absent, "{kind}");
    }
}
