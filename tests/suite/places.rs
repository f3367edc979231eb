//! Places that cannot be written: each command that writes, each cause, one exit code and a hint for it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::files::{project, renderer};
use super::{Ran, ltsc, run, skip};

/// What keeps a place from being written, and the exit code that it leads to.
struct Cause {
    name: &'static str,
    /// The place, below which files are asked for.
    place: PathBuf,
    code: i32,
    /// What the message says.
    says: &'static str,
}

/// The command lines that write, with what they write in `place`.
fn commands(place: &Path, program: &str) -> Vec<Vec<String>> {
    let (folder, file) = (place.join("deep/out"), |name: &str| place.join(name).display().to_string());
    let folder = folder.display().to_string();
    let render = ["render", "scenes-src/one.lts", "--renderer", "pbrt-r4", "--executable", program, "--samples", "1"];
    let reference =
        ["reference", "scenes-src/one.lts", "--renderer", "pbrt-r4", "--executable", program, "--size", "16"];
    let agree = ["agree", "--renderer", "mitsuba-3,luxcore", "--samples", "1", "--size", "8"];
    let words = |first: &[&str], more: &[&str]| [first, more].concat().iter().map(|word| (*word).to_owned()).collect();
    vec![
        words(&["build", "-o"], &[&folder]),
        words(&["emit", "scenes-src/one.lts", "--target", "gltf", "-o"], &[&folder]),
        words(&["emit", "--target", "gltf", "-o"], &[&folder]),
        words(&["doc", "-o"], &[&folder]),
        words(&["doc", "--format", "html", "-o"], &[&folder]),
        words(&["manual", "-o"], &[&folder]),
        words(&["diff", "gray.exr", "gray.exr", "-o"], &[&folder]),
        words(&["init"], &[&folder]),
        words(&render, &["-o", &file("a.exr")]),
        words(&render, &["-o", "a.exr", "--log", &file("a.log")]),
        words(&reference, &["-o", &folder]),
        words(
            &["reference", "add", "gray.exr", "--scene", "scenes-src/one.lts", "--renderer", "a", "--by", "b", "-o"],
            &[&folder],
        ),
        words(&agree, &["--record", &file("a.json")]),
        words(&agree, &["--keep", &folder]),
        words(&["conventions", "--renderer", "pbrt-r4", "--executable", program, "--only", "mirror", "-o"], &[&folder]),
    ]
}

fn at(folder: &Path, words: &[String]) -> Ran {
    run(ltsc().current_dir(folder).args(words))
}

/// A small disk in memory, which is unmounted in the end.
#[cfg(target_os = "linux")]
struct Disk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl Disk {
    /// None where that is not allowed.
    fn new(options: &str) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder");
        let ran = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(folder.path()).output();
        ran.is_ok_and(|ran| ran.status.success()).then_some(Self(folder))
    }
}

#[cfg(target_os = "linux")]
impl Drop for Disk {
    fn drop(&mut self) {
        let _gone = Command::new("umount").arg("-l").arg(self.0.path()).output();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn one_cause_has_one_code_and_a_hint_in_every_command() {
    let folder = project();
    let program = renderer(folder.path());
    let mut causes = vec![
        Cause { name: "/proc", place: "/proc/nowhere".into(), code: 4, says: "the system makes no files in /proc" },
        Cause { name: "/proc itself", place: "/proc".into(), code: 4, says: "the system makes no files in /proc" },
        Cause { name: "a file", place: folder.path().join("ltsc.toml"), code: 2, says: "is a file, not a folder" },
        Cause {
            name: "below a file",
            place: folder.path().join("ltsc.toml/a"),
            code: 2,
            says: "is a file, not a folder",
        },
        Cause { name: "a long name", place: folder.path().join("n".repeat(300)), code: 2, says: "name is too long" },
    ];
    let full = Disk::new("size=16k");
    if let Some(Disk(full)) = &full {
        let _filled = fs::write(full.path().join("filler"), vec![1; 1 << 20]);
        causes.push(Cause { name: "full", place: full.path().join("a"), code: 4, says: "no space is left" });
    }
    let read_only = Disk::new("ro,size=16k");
    if let Some(Disk(folder)) = &read_only {
        causes.push(Cause { name: "read-only", place: folder.path().join("a"), code: 4, says: "read-only" });
    }
    let mut wrong = Vec::new();
    for Cause { name, place, code, says } in &causes {
        for words in commands(place, &program) {
            let ran = at(folder.path(), &words);
            if ran.code != Some(*code) || !ran.err.contains(says) || !ran.err.contains(" help: ") {
                wrong.push(format!("{name}: {}: {:?}: {}", words.join(" "), ran.code, ran.err));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong\n{}", wrong.len(), wrong.join("\n"));
    if full.is_none() || read_only.is_none() {
        skip("places on disks that are full or read-only", "the right to mount");
    }
}

/// Folders that are missing are made.
#[cfg(unix)]
#[test]
fn what_is_missing_of_a_place_is_made() {
    let folder = project();
    let program = renderer(folder.path());
    for words in commands(&folder.path().join("new/deeper"), &program) {
        // These need renderers, and one with noise.
        if words[0] == "agree" || words[..2] == ["reference", "scenes-src/one.lts"] {
            continue;
        }
        let ran = at(folder.path(), &words);
        // The image of the stand-in holds no convention.
        assert!(matches!(ran.code, Some(0 | 1)), "{words:?}: {:?} {}", ran.code, ran.err);
        assert!(folder.path().join("new/deeper").is_dir(), "{words:?}");
        fs::remove_dir_all(folder.path().join("new")).expect("a folder");
    }
}

/// A folder where a file is asked for.
#[cfg(unix)]
#[test]
fn a_folder_is_no_place_for_a_file() {
    let folder = project();
    let program = renderer(folder.path());
    fs::create_dir_all(folder.path().join("a.exr")).expect("a folder");
    fs::create_dir_all(folder.path().join("a.log")).expect("a folder");
    fs::create_dir_all(folder.path().join("a.json")).expect("a folder");
    for words in
        commands(folder.path(), &program).iter().filter(|words| !words.iter().any(|word| word.ends_with("out")))
    {
        let mut words = words.clone();
        if words.iter().any(|word| word.ends_with(".log")) {
            words.iter_mut().filter(|word| *word == "a.exr").for_each(|word| *word = "b.exr".to_owned());
        }
        let ran = at(folder.path(), &words);
        assert_eq!(ran.code, Some(2), "{words:?}: {}", ran.err);
        assert!(ran.err.contains("it is a folder") && ran.err.contains(" help: "), "{words:?}: {}", ran.err);
    }
}

/// A scene that may not be written stays, and its command says what to do.
#[cfg(unix)]
#[test]
fn a_scene_that_may_not_be_written_stays() {
    use std::os::unix::fs::PermissionsExt;
    let folder = project();
    let scene = folder.path().join("scenes-src/one.lts");
    let text = fs::read_to_string(&scene).expect("a scene") + "\n\n\n";
    fs::write(&scene, &text).expect("a scene");
    fs::set_permissions(&scene, fs::Permissions::from_mode(0o444)).expect("rights");
    let ran = at(folder.path(), &["fmt".to_owned()]);
    assert!(ran.code == Some(4) && ran.err.contains(" help: "), "{:?} {}", ran.code, ran.err);
    assert_eq!(fs::read_to_string(&scene).expect("a scene"), text);
}
