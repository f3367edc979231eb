//! Folders appear as a whole, keep what is not ours, and what a killed run has left is put in order by the next.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use ltsc_core::files::{Files, Sink, VPath};

use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Writes files of these contents.
fn write(folder: &Path, files: &[(&str, &str)]) -> Changes {
    let mut sink = DiskSink::new(folder, "scene", false, false).expect("a sink");
    for (path, text) in files {
        sink.file(path, &mut |out| out.write_all(text.as_bytes())).expect("a file");
    }
    sink.finish().expect("a folder")
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).expect("a file")
}

#[test]
fn a_sink_that_is_dropped_leaves_what_was_there() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("outer/scene");
    let path = VPath::resolve("", "target/a.txt").expect("a path");
    let write = |sink: &mut DiskSink, text: &'static [u8]| {
        sink.file("target/a.txt", &mut |out| out.write_all(text)).expect("a file");
        sink.read(&path, 100).map(|bytes| bytes.to_vec())
    };
    let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
    assert_eq!(write(&mut sink, b"first"), Ok(b"first".to_vec()), "what was written is read before it has its name");
    drop(sink);
    assert_eq!(names(root.path()), Vec::<String>::new(), "folders made on the way are gone too");
    let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
    assert_eq!(write(&mut sink, b"first"), Ok(b"first".to_vec()));
    sink.finish().expect("a folder");
    let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
    assert_eq!(write(&mut sink, b"second"), Ok(b"second".to_vec()));
    drop(sink);
    assert_eq!(read(folder.join("target/a.txt")), "first");
    assert_eq!(names(&folder), [MANIFEST, "target"]);
    assert_eq!(names(&root.path().join("outer")), ["scene"]);
    let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
    assert_eq!(write(&mut sink, b"first"), Ok(b"first".to_vec()), "what is the same is read where it is");
    assert!(sink.finish().expect("a folder").is_empty());
}

#[test]
fn what_is_not_ours_stays_and_what_a_person_changed_is_not_removed() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("scene");
    write(&folder, &[("a/one", "1"), ("a/two", "2"), ("b/three", "3")]);
    fs::write(folder.join("a/notes.txt"), "mine").expect("written");
    fs::write(folder.join("b/three"), "edited").expect("written");
    #[cfg(unix)]
    std::os::unix::fs::symlink("/nowhere", folder.join("link")).expect("a link");
    let changes = write(&folder, &[("a/one", "new")]);
    assert_eq!((changes.removed, changes.kept), (vec!["a/two".to_owned()], vec!["b/three".to_owned()]));
    assert_eq!((read(folder.join("a/one")), read(folder.join("a/notes.txt"))), ("new".to_owned(), "mine".to_owned()));
    assert_eq!(read(folder.join("b/three")), "edited");
    #[cfg(unix)]
    assert_eq!(fs::read_link(folder.join("link")).expect("a link"), Path::new("/nowhere"));
    // Once it is not ours any more, it is as any other file.
    assert!(write(&folder, &[("a/one", "new")]).is_empty());
    assert_eq!(names(root.path()), ["scene"]);
}

#[cfg(unix)]
#[test]
fn links_and_foreign_folders_are_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let elsewhere = root.path().join("elsewhere");
    write(&elsewhere, &[("thesis.tex", "mine")]);
    let link = root.path().join("scene");
    std::os::unix::fs::symlink(&elsewhere, &link).expect("a link");
    assert!(DiskSink::new(&link, "scene", false, true).is_err());
    assert_eq!(read(elsewhere.join("thesis.tex")), "mine");
    let foreign = root.path().join("foreign");
    fs::create_dir(&foreign).expect("a folder");
    fs::write(foreign.join("thesis.tex"), "mine").expect("written");
    assert!(DiskSink::new(&foreign, "scene", false, false).is_err());
    assert!(DiskSink::new(&foreign, "scene", false, true).is_ok(), "unless it is asked for");
}

#[cfg(unix)]
#[test]
fn rights_of_a_folder_stay() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("scene");
    write(&folder, &[("a", "1")]);
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o750)).expect("rights");
    write(&folder, &[("a", "2")]);
    assert_eq!(fs::metadata(&folder).expect("a folder").permissions().mode() & 0o777, 0o750);
}

/// A run may be killed in any of these states.
#[test]
fn what_a_killed_run_has_left_is_put_in_order() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("scene");
    let staging = root.path().join(STAGING);
    write(&folder, &[("a", "old")]);
    // In the middle of writing.
    fs::create_dir_all(staging.join("0/target")).expect("a folder");
    fs::write(staging.join("0/target/half"), "ha").expect("written");
    fs::write(staging.join("lock"), "").expect("written");
    assert!(left_over(root.path()));
    assert!(write(&folder, &[("a", "old")]).is_empty());
    assert_eq!(names(root.path()), ["scene"]);
    // Between the two renames of a system without exchange: the old folder comes back.
    fs::create_dir(&staging).expect("a folder");
    fs::rename(&folder, staging.join("old-scene")).expect("moved");
    assert!(write(&folder, &[("a", "old")]).is_empty());
    assert_eq!((names(root.path()), read(folder.join("a"))), (vec!["scene".to_owned()], "old".to_owned()));
    // After them: the new one stays.
    fs::create_dir_all(staging.join("old-scene")).expect("a folder");
    fs::write(staging.join("old-scene/a"), "older").expect("written");
    assert!(write(&folder, &[("a", "old")]).is_empty());
    assert_eq!((names(root.path()), read(folder.join("a"))), (vec!["scene".to_owned()], "old".to_owned()));
}

/// A folder that cannot be replaced gets its files one by one; a run that was killed on the way is continued.
#[test]
fn pouring_goes_on_where_it_was_killed() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().to_path_buf();
    let other = root.path().join("other");
    write(&other, &[("a", "new"), ("b/c", "new")]);
    fs::write(folder.join("a"), "old").expect("written");
    fs::write(folder.join("gone"), "old").expect("written");
    let hash = |text: &str| blake3::hash(text.as_bytes()).to_hex().to_string();
    let mut manifest = Manifest { generator: "ltsc".to_owned(), scene: "scene".to_owned(), ..Manifest::default() };
    manifest.files.insert("a".to_owned(), hash("old"));
    manifest.files.insert("gone".to_owned(), hash("old"));
    fs::write(folder.join(MANIFEST), manifest.bytes()).expect("written");
    fs::create_dir(folder.join(STAGING)).expect("a folder");
    fs::rename(&other, folder.join(STAGING).join("ready")).expect("moved");
    // As if killed after the first file.
    fs::rename(folder.join(STAGING).join("ready/a"), folder.join("a")).expect("moved");
    drop(Staging::of(&folder).expect("put in order"));
    assert_eq!(names(&folder), ["a", "b", MANIFEST]);
    assert_eq!((read(folder.join("a")), read(folder.join("b/c"))), ("new".to_owned(), "new".to_owned()));
    // As if killed after the manifest, before the empty folder was removed: everything stays.
    fs::create_dir_all(folder.join(STAGING).join("ready/b")).expect("a folder");
    drop(Staging::of(&folder).expect("put in order"));
    assert_eq!(names(&folder), ["a", "b", MANIFEST]);
    assert_eq!((read(folder.join("a")), read(folder.join("b/c"))), ("new".to_owned(), "new".to_owned()));
}

#[test]
fn one_process_or_thread_writes_at_a_time() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("scene");
    std::thread::scope(|scope| {
        for at in 0..8 {
            let folder = &folder;
            scope.spawn(move || {
                for round in 0..20 {
                    let text = format!("{at} {round}");
                    write(folder, &[("a", &text), ("b", &text)]);
                    assert!(folder.join("a").is_file());
                }
            });
        }
    });
    assert_eq!(read(folder.join("a")), read(folder.join("b")), "of one writer");
    assert_eq!(names(root.path()), ["scene"]);
}

#[test]
fn several_folders_share_a_place() {
    let root = tempfile::tempdir().expect("a folder");
    let staging = Arc::new(Staging::of(root.path()).expect("a place"));
    for scene in ["one", "two"] {
        let mut sink = DiskSink::among(Some(&staging), &root.path().join(scene), scene, false).expect("a sink");
        sink.file("a", &mut |out| out.write_all(b"1")).expect("a file");
        sink.finish().expect("a folder");
    }
    drop(staging);
    assert_eq!(names(root.path()), ["one", "two"]);
}

#[cfg(unix)]
#[test]
fn a_persons_file_keeps_its_rights_and_its_other_names() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let root = tempfile::tempdir().expect("a folder");
    let file = root.path().join("a.lts");
    fs::write(&file, "old, and longer").expect("written");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).expect("rights");
    rewrite(&file, root.path(), b"new").expect("written");
    assert_eq!((read(&file), fs::metadata(&file).expect("a file").mode() & 0o777), ("new".to_owned(), 0o600));
    let other = root.path().join("b.lts");
    fs::hard_link(&file, &other).expect("a link");
    rewrite(&file, root.path(), b"x").expect("written");
    assert_eq!((read(&other), fs::metadata(&other).expect("a file").nlink()), ("x".to_owned(), 2));
    fs::remove_file(&other).expect("removed");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).expect("rights");
    assert!(rewrite(&file, root.path(), b"new").is_err());
    let outside = tempfile::tempdir().expect("a folder");
    fs::write(outside.path().join("c.lts"), "c").expect("written");
    let link = root.path().join("c.lts");
    std::os::unix::fs::symlink(outside.path().join("c.lts"), &link).expect("a link");
    assert!(rewrite(&link, root.path(), b"new").is_err());
    assert_eq!(
        (read(outside.path().join("c.lts")), names(root.path())),
        ("c".to_owned(), vec!["a.lts".to_owned(), "c.lts".to_owned()])
    );
}
