//! Files of other people, and what is no file: no command writes over what ltsc did not write, none writes beside its output, and none
//! waits for a pipe or reads a device.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::cli::MINIMAL;
use super::{Ran, files_below, ltsc, run};

/// A project of one scene.
pub fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("scenes-src")).expect("a folder");
    fs::write(folder.path().join("ltsc.toml"), "").expect("written");
    fs::write(folder.path().join("scenes-src/one.lts"), MINIMAL.replace("NAME", "one")).expect("written");
    folder
}

fn at(folder: &Path, words: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).args(words))
}

/// What all files hold, and when they were changed.
fn state(folder: &Path) -> BTreeMap<String, (Vec<u8>, std::time::SystemTime)> {
    let of = |path: String| {
        let file = folder.join(&path);
        let time = fs::metadata(&file).and_then(|meta| meta.modified()).expect("a time");
        (path, (fs::read(&file).expect("a file"), time))
    };
    files_below(folder).into_iter().map(of).collect()
}

/// A program that passes for pbrt-r4 and gives an image of one gray.
#[cfg(unix)]
pub fn renderer(folder: &Path) -> String {
    use ltsc_render::image::{Image, Provenance, write_exr};
    use std::os::unix::fs::PermissionsExt;
    let (program, image) = (folder.join("pbrt-r4"), folder.join("gray.exr"));
    write_exr(&image, &Image::filled(16, 8, [0.5; 3]), &Provenance::default()).expect("an image");
    let text = format!(
        "#!/bin/sh\necho pbrt-r4 4.5.2\nif [ \"$1\" = --version ]; then exit 0; fi\nif [ -e {stop} ]; then exit 7; fi\n\
         while [ \"$1\" != --outfile ]; do shift; done\ncp {image} \"$2\"\n",
        stop = folder.join("stop").display(),
        image = image.display()
    );
    fs::write(&program, text).expect("written");
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("rights");
    program.to_str().expect("Unicode").to_owned()
}

/// A page of a person stays, is not half written over, and is named; so does one of ours that a person has changed.
#[test]
fn pages_of_a_person_stay() {
    for (command, own, other) in [("doc", "README.md", "one.md"), ("manual", "targets.md", "reference.md")] {
        let folder = project();
        let place = |name: &str| folder.path().join("out").join(name);
        let text = |name: &str| fs::read_to_string(place(name)).unwrap_or_default();
        fs::create_dir(folder.path().join("out")).expect("a folder");
        fs::write(place(own), "mine").expect("written");
        let command = |more: &[&str]| at(folder.path(), &[&[command, "-o", "out"], more].concat());
        let refused = command(&[]);
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        assert!(refused.err.contains(own) && refused.err.contains("--force"), "{}", refused.err);
        assert_eq!((text(own), files_below(&folder.path().join("out"))), ("mine".to_owned(), vec![own.to_owned()]));
        assert_eq!(command(&["--check"]).code, Some(1));
        assert_eq!(command(&["--force"]).code, Some(0));
        assert_ne!(text(own), "mine");
        // Changed since, and an ordinary change of what is written.
        let made = text(other);
        fs::write(place(other), made.clone() + "my remark\n").expect("written");
        assert_eq!((command(&[]).code, text(other)), (Some(2), made.clone() + "my remark\n"));
        fs::write(place(other), &made).expect("written");
        assert_eq!(command(&[]).code, Some(0));
        fs::remove_file(place(other)).expect("removed");
        assert_eq!((command(&[]).code, text(other)), (Some(0), made));
        // Without the record nothing is known to be ours, but what is as it would be written needs no word.
        fs::remove_file(place(".ltsc-pages.json")).expect("removed");
        assert_eq!(command(&[]).code, Some(0));
    }
}

/// A page of a scene that is gone goes; where a person has worked on it, it stays.
#[test]
fn a_page_that_is_no_longer_made_goes_only_as_it_was() {
    for changed in [false, true] {
        let folder = project();
        let (scene, page) = (folder.path().join("scenes-src/two.lts"), folder.path().join("docs/scenes/two.md"));
        fs::write(&scene, MINIMAL.replace("NAME", "two")).expect("written");
        assert_eq!(at(folder.path(), &["doc"]).code, Some(0));
        if changed {
            fs::write(&page, "mine").expect("written");
        }
        fs::remove_file(&scene).expect("removed");
        let ran = at(folder.path(), &["doc"]);
        assert_eq!((ran.code, page.exists()), (Some(0), changed), "{}", ran.err);
        assert_eq!(ran.err.contains("it stays"), changed, "{}", ran.err);
        assert_eq!(at(folder.path(), &["doc", "--check"]).code, Some(0));
    }
}

#[cfg(unix)]
#[test]
fn an_image_and_a_log_that_are_there_stay() {
    let folder = project();
    let program = renderer(folder.path());
    let place = |name: &str| folder.path().join(name);
    let render = |more: &[&str]| {
        let words =
            ["render", "scenes-src/one.lts", "--renderer", "pbrt-r4", "--executable", &program, "--samples", "1"];
        at(folder.path(), &[&words[..], more].concat())
    };
    // A scene as a log, with all that is allowed.
    let scene = fs::read(place("scenes-src/one.lts")).expect("the scene");
    for more in [&[][..], &["--force"]] {
        let ran = render(&[&["-o", "a.exr", "--log", "scenes-src/one.lts"], more].concat());
        assert_eq!(ran.code, Some(2), "{}", ran.err);
        assert_eq!(fs::read(place("scenes-src/one.lts")).expect("the scene"), scene);
    }
    // Notes of a person as a log; a failure leaves a log that the next run may begin anew.
    fs::write(place("a.exr.log"), "notes").expect("written");
    assert_eq!(render(&["-o", "a.exr"]).code, Some(2));
    assert_eq!(fs::read(place("a.exr.log")).expect("notes"), b"notes");
    fs::write(place("stop"), "").expect("written");
    assert_eq!(render(&["-o", "b.exr"]).code, Some(4));
    assert!(place("b.exr.log").exists() && !place("b.exr").exists());
    fs::remove_file(place("stop")).expect("removed");
    let ran = render(&["-o", "b.exr"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    // An image may have taken hours.
    let image = fs::read(place("b.exr")).expect("an image");
    let ran = render(&["-o", "b.exr", "--seed", "1"]);
    assert!(ran.code == Some(2) && ran.err.contains("--force"), "{}", ran.err);
    assert_eq!(fs::read(place("b.exr")).expect("an image"), image);
    assert_eq!(render(&["-o", "b.exr", "--force"]).code, Some(0));
    assert_eq!(render(&["-o", "a.exr", "--force"]).code, Some(0));
    assert_ne!(fs::read(place("a.exr.log")).expect("a log"), b"notes");
}

/// Someone's changes in a folder of `emit` stay; those in a folder that is only generated are written over, and told.
#[test]
fn changes_in_a_folder_that_was_emitted_stay() {
    let folder = project();
    let emit = |more: &[&str]| {
        at(folder.path(), &[&["emit", "scenes-src/one.lts", "--target", "luxcore", "-o", "out"], more].concat())
    };
    assert_eq!(emit(&[]).code, Some(0));
    let settings = folder.path().join("out/render.cfg");
    let file = if settings.exists() { settings } else { folder.path().join("out/scene.cfg") };
    let made = fs::read_to_string(&file).expect("settings");
    fs::write(&file, "mine").expect("written");
    let ran = emit(&[]);
    assert!(ran.code == Some(2) && ran.err.contains("was changed since"), "{}", ran.err);
    assert_eq!(fs::read_to_string(&file).expect("settings"), "mine");
    assert_eq!(emit(&["--force"]).code, Some(0));
    assert_eq!(fs::read_to_string(&file).expect("settings"), made);
    // A file that the next version writes, and a person has now.
    let manifest = folder.path().join("out/manifest.json");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    let name = file.file_name().expect("a name").to_str().expect("Unicode");
    let without: Vec<&str> = text.lines().filter(|line| !line.contains(&format!("\"{name}\""))).collect();
    fs::write(&manifest, without.join("\n")).expect("written");
    fs::write(&file, "mine").expect("written");
    let ran = emit(&[]);
    assert!(ran.code == Some(2) && ran.err.contains("did not write it"), "{}", ran.err);
    assert_eq!(fs::read_to_string(&file).expect("settings"), "mine");

    assert_eq!(at(folder.path(), &["build"]).code, Some(0));
    fs::write(folder.path().join("generated/one/luxcore/scene.cfg"), "mine").expect("written");
    let ran = at(folder.path(), &["build"]);
    assert!(ran.code == Some(0) && ran.err.contains("was changed by hand"), "{}", ran.err);
    // What was never ours is not written over there either.
    let manifest = folder.path().join("generated/one/manifest.json");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    let without: Vec<&str> = text.lines().filter(|line| !line.contains("luxcore/scene.cfg")).collect();
    fs::write(&manifest, without.join("\n")).expect("written");
    fs::write(folder.path().join("generated/one/luxcore/scene.cfg"), "mine").expect("written");
    assert_eq!(at(folder.path(), &["build"]).code, Some(2));
    assert_eq!(fs::read(folder.path().join("generated/one/luxcore/scene.cfg")).expect("a file"), b"mine");
}

#[test]
fn a_page_of_agreement_that_a_person_changed_stays() {
    let folder = project();
    fs::write(folder.path().join("record.md"), "mine").expect("written");
    // Told before anything is rendered.
    let ran = at(folder.path(), &["agree", "--renderer", "luxcore,cycles", "--record", "record.json"]);
    assert!(ran.code == Some(2) && ran.err.contains("record.md"), "{}", ran.err);
    assert_eq!(fs::read(folder.path().join("record.md")).expect("a page"), b"mine");
}

/// All commands that write, each with a folder of its own: nothing else of the project changes, and no temporary file stays.
#[cfg(unix)]
#[test]
fn nothing_outside_the_output_is_touched() {
    let folder = project();
    let program = renderer(folder.path());
    let temporary = folder.path().join("tmp");
    fs::create_dir(&temporary).expect("a folder");
    let image = ["--renderer", "pbrt-r4", "--executable", &program, "--samples", "1", "-o"];
    let commands: [(&[&str], &str); 9] = [
        (&["build"], "generated"),
        (&["build", "-o", "other"], "other"),
        (&["emit", "scenes-src/one.lts", "--target", "gltf", "-o", "emitted"], "emitted"),
        (&["doc"], "docs/scenes"),
        (&["doc", "-o", "pages", "--format", "html"], "pages"),
        (&["manual", "-o", "manual"], "manual"),
        (&[&["render", "scenes-src/one.lts"], &image[..], &["images/a.exr"]].concat(), "images"),
        (&[&["render", "scenes-src/one.lts"], &image[..], &["images/b.exr"]].concat(), "images"),
        (&["diff", "images/a.exr", "images/b.exr", "-o", "difference"], "difference"),
    ];
    for (words, output) in commands {
        let before = state(folder.path());
        let ran = run(ltsc().current_dir(folder.path()).env("TMPDIR", &temporary).args(words));
        assert_eq!(ran.code, Some(0), "{words:?}: {}", ran.err);
        let after = state(folder.path());
        let changed: Vec<&String> = after
            .iter()
            .filter(|(path, now)| before.get(*path) != Some(now))
            .map(|(path, _)| path)
            .chain(before.keys().filter(|path| !after.contains_key(*path)))
            .collect();
        assert!(!changed.is_empty(), "{words:?} wrote nothing");
        let outside: Vec<&&String> = changed.iter().filter(|path| !path.starts_with(&format!("{output}/"))).collect();
        assert!(outside.is_empty(), "{words:?}: {outside:?}");
        let left: Vec<&String> =
            after.keys().filter(|path| path.contains(".ltsc/") || path.starts_with("tmp/")).collect();
        assert!(left.is_empty(), "{words:?}: {left:?}");
        let empty = fs::read_dir(&temporary).expect("a folder").count();
        assert_eq!(empty, 0, "{words:?}");
    }
}

/// The output of a command that must end by itself, at once.
#[cfg(unix)]
fn ends(folder: &Path, words: &[&str]) -> Ran {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let mut command = ltsc();
    command.current_dir(folder).args(words).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Should it read a device, it ends soon.
    let mut child = command.spawn().expect("started");
    let start = Instant::now();
    while child.try_wait().expect("a state").is_none() {
        if start.elapsed() > Duration::from_secs(30) {
            let _ended = child.kill();
            let _status = child.wait();
            panic!("{words:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let out = child.wait_with_output().expect("output");
    let text = |bytes| String::from_utf8(bytes).expect("output is UTF-8");
    Ran { code: out.status.code(), out: text(out.stdout), err: text(out.stderr) }
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_at_once() {
    use std::os::unix::fs::symlink;
    type Make = fn(&Path);
    let pipe: Make = |path| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
    };
    let device: Make = |path| symlink("/dev/zero", path).expect("a link");
    let folder: Make = |path| fs::create_dir(path).expect("a folder");
    let socket: Make = |path| drop(std::os::unix::net::UnixListener::bind(path).expect("a socket"));
    for (kind, make) in [("pipe", pipe), ("device", device), ("folder", folder), ("socket", socket)] {
        // A scene: each command says what it is, and goes on to the others.
        let root = project();
        make(&root.path().join("scenes-src/two.lts"));
        for words in [
            &["build", "scenes-src/two.lts"][..],
            &["lint", "scenes-src/two.lts"],
            &["lint", "--fix", "scenes-src/two.lts"],
            &["fmt", "scenes-src/two.lts"],
            &["emit", "scenes-src/two.lts", "--target", "gltf"],
            &["render", "scenes-src/two.lts", "--renderer", "luxcore", "-o", "a.exr"],
            &["audit", "scenes-src/two.lts"],
            &["similar", "scenes-src/two.lts"],
            &["doc", "scenes-src/two.lts"],
            &["build"],
            &["fmt", "--check"],
        ] {
            let ran = ends(root.path(), words);
            // A folder may be named where scenes are meant, and holds none; the device lies outside of the project.
            let (fine, reason) = match kind {
                "folder" => (ran.code != Some(70), ""),
                "device" => (matches!(ran.code, Some(2 | 3)), ""),
                _ => (ran.code == Some(3), "no regular file"),
            };
            assert!(fine, "{kind} {words:?}: {:?} {}", ran.code, ran.err);
            assert!(format!("{}{}", ran.out, ran.err).contains(reason), "{kind} {words:?}: {}{}", ran.out, ran.err);
        }
        // What a scene imports.
        let root = project();
        let scene = root.path().join("scenes-src/one.lts");
        let text = fs::read_to_string(&scene).expect("a scene");
        for (name, more) in [
            ("a.ply", "shape a = file(\"a.ply\") with diffuse(0.5)"),
            ("a.obj", "group a = file(\"a.obj\")\ninstance b = a()"),
            ("a.png", "shape a = box(size: 1) with diffuse(bitmap(\"a.png\"))"),
            ("a.npy", "shape a = box(size: 1) |> scatter(\"a.npy\") with diffuse(0.5)"),
            ("a.lts", "use red from \"a.lts\"\nshape a = box(size: 1) with red"),
        ] {
            make(&root.path().join("scenes-src").join(name));
            fs::write(&scene, format!("{text}{more}\n")).expect("written");
            let ran = ends(root.path(), &["lint", "scenes-src/one.lts"]);
            assert_eq!(ran.code, Some(3), "{kind} {name}: {}{}", ran.out, ran.err);
        }
        // The project file.
        if kind != "folder" {
            let root = project();
            fs::remove_file(root.path().join("ltsc.toml")).expect("removed");
            make(&root.path().join("ltsc.toml"));
            for words in [&["renderers", "list"][..], &["build"], &["lint", "scenes-src"], &["doc"]] {
                let ran = ends(root.path(), words);
                assert_eq!(ran.code, Some(3), "{kind} {words:?}: {}", ran.err);
                assert!(ran.err.contains("ltsc.toml") && ran.err.contains("no regular file"), "{}", ran.err);
            }
        }
        // Images.
        let root = project();
        make(&root.path().join("a.exr"));
        assert_eq!(ends(root.path(), &["diff", "a.exr", "a.exr"]).code, Some(3), "{kind}");
        // What is to be written, and records of it.
        make(&root.path().join("a.log"));
        let log = ["render", "scenes-src/one.lts", "--renderer", "luxcore", "-o", "b.exr", "--log", "a.log"];
        assert_eq!(ends(root.path(), &log).code, Some(2), "{kind}");
        fs::create_dir(root.path().join("out")).expect("a folder");
        make(&root.path().join("out/targets.md"));
        make(&root.path().join("out/.ltsc-pages.json"));
        assert_eq!(ends(root.path(), &["manual", "-o", "out"]).code, Some(2), "{kind}");
        assert_eq!(ends(root.path(), &["build"]).code, Some(0), "{kind}");
        for name in ["manifest.json", "pbrt-v4/scene.pbrt"] {
            let place: PathBuf = root.path().join("generated/one").join(name);
            fs::remove_file(&place).expect("removed");
            make(&place);
            let ran = ends(root.path(), &["build"]);
            assert!(ran.code != Some(70) && ran.code.is_some(), "{kind} {name}: {}", ran.err);
            fs::remove_dir_all(root.path().join("generated")).expect("removed");
            assert_eq!(ends(root.path(), &["build"]).code, Some(0), "{kind}");
        }
    }
}

/// Without a project a scene is generated beside itself; what is no longer made is told by `--check`, and goes, also with the last scene.
#[test]
fn leftovers_are_told_and_go() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("a/b");
    fs::create_dir_all(&inner).expect("a folder");
    fs::write(inner.join("x.lts"), MINIMAL.replace("NAME", "x")).expect("written");
    assert_eq!(at(&inner, &["build", "x.lts"]).code, Some(0));
    assert!(inner.join("generated/x/manifest.json").is_file());
    assert_eq!(fs::read_dir(folder.path().join("a")).expect("a folder").count(), 1);

    let folder = project();
    let two = folder.path().join("scenes-src/two.lts");
    fs::write(&two, MINIMAL.replace("NAME", "two")).expect("written");
    let check = |words: &[&str]| at(folder.path(), &[&["build"], words, &["--check"]].concat()).code;
    assert_eq!(at(folder.path(), &["build"]).code, Some(0));
    fs::remove_file(&two).expect("removed");
    assert_eq!((check(&[]), check(&["scenes-src"])), (Some(1), Some(1)));
    assert_eq!(at(folder.path(), &["build", "scenes-src"]).code, Some(0));
    assert!(!folder.path().join("generated/two").exists());
    assert_eq!((check(&[]), check(&["scenes-src"])), (Some(0), Some(0)));
    for words in [&[][..], &["scenes-src"]] {
        fs::write(&two, MINIMAL.replace("NAME", "two")).expect("written");
        assert_eq!(at(folder.path(), &["build"]).code, Some(0));
        fs::remove_file(&two).expect("removed");
        let _gone = fs::remove_file(folder.path().join("scenes-src/one.lts"));
        assert_eq!(check(words), Some(1), "the last scene is gone");
        let ran = at(folder.path(), &[&["build"], words].concat());
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        assert_eq!(fs::read_dir(folder.path().join("generated")).map_or(0, Iterator::count), 0);
        // Then there is nothing to build.
        assert_eq!(at(folder.path(), &["build"]).code, Some(2));
    }
}
