//! The place beside what is written: who holds it, what is put in order, and what is left of it.

use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn a_place_is_made_held_and_given_back() {
    let root = tempfile::tempdir().expect("a folder");
    let around = root.path().join("outer/inner");
    let place = Staging::of(&around).expect("a place");
    assert_eq!(names(&around.join(STAGING)), [IGNORE, LOCK]);
    assert_eq!(read(around.join(STAGING).join(IGNORE)), "*\n", "nothing of it is committed");
    let (one, other) = (place.stage().expect("a folder"), place.stage().expect("a folder"));
    assert!(
        one != other && [&one, &other].iter().all(|stage| stage.is_dir() && stage.starts_with(around.join(STAGING)))
    );
    fs::write(one.join("half"), "ha").expect("written");
    drop(place);
    assert_eq!(names(root.path()), Vec::<String>::new(), "with folders that were made for it");
    // Where something was written they stay, and so does what was there before.
    fs::create_dir(root.path().join("outer")).expect("a folder");
    write_whole(&around.join("file"), &mut |out| out.write_all(b"text")).expect("a file");
    assert_eq!((names(&around), read(around.join("file"))), (vec!["file".to_owned()], "text".to_owned()));
    drop(Staging::of(&root.path().join("empty")).expect("a place"));
    fs::create_dir(root.path().join("empty")).expect("a folder");
    drop(Staging::of(&root.path().join("empty")).expect("a place"));
    assert_eq!(names(root.path()), ["empty", "outer"]);
}

#[test]
fn a_file_that_cannot_be_made_leaves_the_old_one() {
    let root = tempfile::tempdir().expect("a folder");
    let file = root.path().join("file");
    write_whole(&file, &mut |out| out.write_all(b"old")).expect("a file");
    let failed = write_whole(&file, &mut |out| {
        out.write_all(b"new")?;
        Err(io::Error::other("no more"))
    });
    assert_eq!(failed.expect_err("it fails").to_string(), "no more");
    assert_eq!((read(&file), names(root.path())), ("old".to_owned(), vec!["file".to_owned()]));
    let place = Staging::of(root.path()).expect("a place");
    place.put(&file, |new| fs::write(new, "new")).expect("a file");
    assert_eq!(
        (read(&file), names(&root.path().join(STAGING))),
        ("new".to_owned(), vec![IGNORE.to_owned(), LOCK.to_owned()])
    );
    let file = Path::new("file-of-a-test-of-staging");
    write_whole(file, &mut |out| out.write_all(b"here")).expect("a file where the process stands");
    let there = read(file);
    fs::remove_file(file).expect("removed");
    assert_eq!(there, "here");
}

#[test]
fn a_folder_takes_the_place_of_another() {
    let root = tempfile::tempdir().expect("a folder");
    let place = Staging::of(root.path()).expect("a place");
    let to = root.path().join("scene");
    for text in ["first", "second"] {
        let stage = place.stage().expect("a folder");
        fs::write(stage.join("a"), text).expect("written");
        place.replace(&stage, &to).expect("replaced");
        assert_eq!((read(to.join("a")), stage.exists()), (text.to_owned(), false));
    }
    drop(place);
    assert_eq!(names(root.path()), ["scene"]);
}

#[test]
fn what_is_in_the_way_of_a_place_is_refused() {
    let root = tempfile::tempdir().expect("a folder");
    let refused = |around: &Path| Staging::of(around).err().expect("refused");
    fs::write(root.path().join(STAGING), "mine").expect("written");
    let error = refused(root.path());
    assert!(error.kind() == io::ErrorKind::InvalidInput && error.to_string().ends_with("is no folder"), "{error}");
    assert_eq!(read(root.path().join(STAGING)), "mine");
    fs::write(root.path().join("file"), "mine").expect("written");
    refused(&root.path().join("file"));
    refused(&root.path().join("file/below"));
    assert_eq!(names(root.path()), [STAGING, "file"]);
    #[cfg(unix)]
    {
        let (other, around) = (root.path().join("other"), root.path().join("around"));
        fs::create_dir_all(&other).and_then(|()| fs::create_dir(&around)).expect("folders");
        fs::write(other.join("thesis"), "mine").expect("written");
        std::os::unix::fs::symlink(&other, around.join(STAGING)).expect("a link");
        assert!(refused(&around).to_string().ends_with("is no folder"));
        assert_eq!(names(&other), ["thesis"], "what a link leads to is not put in order");
    }
}

/// What does not change by waiting is told at once, and as it is.
#[test]
fn what_is_in_the_way_of_a_lock_is_told_as_it_is() {
    for name in [LOCK, IGNORE] {
        let root = tempfile::tempdir().expect("a folder");
        fs::create_dir_all(root.path().join(STAGING).join(name).join("mine")).expect("a folder");
        let error = Staging::of(root.path()).err().expect("refused");
        assert_ne!(error.kind(), io::ErrorKind::WouldBlock, "{error}");
        assert!(root.path().join(STAGING).join(name).join("mine").exists());
    }
    #[cfg(target_os = "linux")]
    assert_eq!(Staging::of(Path::new("/proc")).err().expect("refused").kind(), io::ErrorKind::NotFound);
}

#[test]
fn what_is_left_over_is_what_nobody_holds() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join(STAGING);
    assert!(!left_over(root.path()));
    fs::create_dir(&folder).expect("a folder");
    assert!(left_over(root.path()), "without a lock");
    fs::write(folder.join(LOCK), "").expect("written");
    assert!(left_over(root.path()), "with one that nobody has");
    let place = Staging::of(root.path()).expect("a place");
    assert!(!left_over(root.path()), "somebody writes here");
    drop(place);
    assert!(!left_over(root.path()) && !folder.exists());
}

#[test]
fn each_thing_that_a_killed_run_left_is_put_in_order() {
    let root = tempfile::tempdir().expect("a folder");
    let around = root.path();
    let folder = around.join(STAGING);
    for inner in ["7/half", "old-back", "old-there", "ready/inner"] {
        fs::create_dir_all(folder.join(inner)).expect("a folder");
    }
    fs::write(folder.join("old-back/a"), "old").expect("written");
    fs::write(folder.join("old-there/a"), "older").expect("written");
    fs::write(folder.join("file"), "half").expect("written");
    // Files that are ready without a manifest have been moved already, all but what no longer counts.
    fs::write(folder.join("ready/inner/a"), "new").expect("written");
    fs::create_dir(around.join("there")).expect("a folder");
    fs::write(around.join("there/a"), "new").expect("written");
    let place = Staging::of(around).expect("a place");
    assert_eq!(names(&folder), [IGNORE, LOCK]);
    drop(place);
    assert_eq!(names(around), ["back", "there"]);
    assert_eq!((read(around.join("back/a")), read(around.join("there/a"))), ("old".to_owned(), "new".to_owned()));
}

/// Files are moved into the folder itself: of its old ones those go that are as they were written.
#[test]
fn files_are_poured_into_a_folder_that_stays() {
    let root = tempfile::tempdir().expect("a folder");
    let around = root.path();
    let hash = |text: &str| blake3::hash(text.as_bytes()).to_hex().to_string();
    let manifest = |files: &[(&str, &str)]| {
        let mut manifest = Manifest { generator: "ltsc".to_owned(), scene: "scene".to_owned(), ..Manifest::default() };
        manifest.files.extend(files.iter().map(|(path, text)| ((*path).to_owned(), hash(text))));
        manifest.bytes()
    };
    for (path, text) in [("stays", "1"), ("gone/below/a", "1"), ("edited", "2"), ("foreign", "mine")] {
        let file = around.join(path);
        fs::create_dir_all(file.parent().expect("a folder")).and_then(|()| fs::write(file, text)).expect("written");
    }
    let old = [("stays", "1"), ("gone/below/a", "1"), ("edited", "1"), ("missing", "1")];
    fs::write(around.join(MANIFEST), manifest(&old)).expect("written");
    let place = Staging::of(around).expect("a place");
    let stage = place.stage().expect("a folder");
    fs::create_dir_all(stage.join("inner")).expect("a folder");
    fs::write(stage.join("inner/new"), "3").expect("written");
    let new = manifest(&[("stays", "1"), ("inner/new", "3")]);
    fs::write(stage.join(MANIFEST), &new).expect("written");
    place.pour(&stage).expect("poured");
    assert_eq!(names(&around.join(STAGING)), [IGNORE, LOCK]);
    drop(place);
    assert_eq!(names(around), ["edited", "foreign", "inner", MANIFEST, "stays"]);
    assert_eq!(read(around.join("inner/new")), "3");
    assert_eq!(fs::read(around.join(MANIFEST)).expect("a manifest"), new);
}

#[test]
fn an_open_file_is_there_as_long_as_its_name_is_its_own() {
    let root = tempfile::tempdir().expect("a folder");
    let path = root.path().join("lock");
    let file = File::create(&path).expect("a file");
    assert!(is_there(&file, &path));
    #[cfg(unix)]
    {
        fs::remove_file(&path).expect("removed");
        assert!(!is_there(&file, &path));
        fs::write(&path, "").expect("written");
        assert!(!is_there(&file, &path), "another of the same name");
    }
}

#[test]
fn folders_are_searched_and_cleared_up_to_their_top() {
    let root = tempfile::tempdir().expect("a folder");
    let top = root.path().join("top");
    fs::create_dir_all(top.join("a/b/c")).expect("folders");
    fs::create_dir_all(top.join("a/empty")).expect("folders");
    for path in ["z", "a/one", "a/b/c/two"] {
        fs::write(top.join(path), "1").expect("written");
    }
    let found = files_below(&top).expect("files");
    assert_eq!(found, ["a/b/c/two", "a/one", "z"].map(PathBuf::from));
    fs::remove_file(top.join("a/b/c/two")).expect("removed");
    remove_empty(&top, &top.join("a/b/c/two"));
    assert_eq!(names(&top.join("a")), ["empty", "one"], "up to what is not empty");
    remove_empty(&top, &top.join("a/empty/none"));
    fs::remove_file(top.join("a/one")).and_then(|()| fs::remove_file(top.join("z"))).expect("removed");
    remove_empty(&top, &top.join("a/one"));
    assert_eq!(
        (names(&top), names(root.path())),
        (Vec::<String>::new(), vec!["top".to_owned()]),
        "and not the top itself"
    );
    remove_empty(&top, &root.path().join("elsewhere/file"));
    assert!(top.exists());
}
