//! Builds that are killed, several at once, on a full disk: a scene's folder is the old one or the new one, and the next run goes on.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{files_below, ltsc, root, run, skip};

/// Scenes that are quick to build.
const SCENES: [&str; 2] = ["cbox_classic", "cbox_empty"];

/// What each file of the folder of generated scenes holds, by its path.
type Contents = BTreeMap<String, Vec<u8>>;

/// A project of a few scenes in a folder of its own, for three targets; `stale` has other numbers in its scenes.
fn project(folder: &Path, stale: bool) {
    let scenes = folder.join("scenes-src");
    fs::create_dir_all(scenes.join("lib")).expect("a folder");
    let targets = "targets = [\"mitsuba-3\", \"pbrt-v4\", \"luxcore\"]\n";
    fs::write(folder.join("ltsc.toml"), format!("scenes = \"scenes-src\"\n{targets}")).expect("written");
    for file in files_below(&root().join("scenes-src/lib")) {
        fs::copy(root().join("scenes-src/lib").join(&file), scenes.join("lib").join(&file)).expect("copied");
    }
    for scene in SCENES {
        let text = fs::read_to_string(root().join(format!("scenes-src/{scene}.lts"))).expect("a scene");
        let text = if stale { text.replace("radiance(30)", "radiance(31)") } else { text };
        fs::write(scenes.join(format!("{scene}.lts")), text).expect("written");
    }
}

fn build(folder: &Path) -> Command {
    let mut command = ltsc();
    command.current_dir(folder).args(["build", "--allow", "all"]).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// All files of each generated scene; none where its folder is missing.
fn contents(folder: &Path) -> BTreeMap<&'static str, Contents> {
    let of = |scene: &'static str| {
        let top = folder.join("generated").join(scene);
        let read = |path: String| (path.clone(), fs::read(top.join(&path)).expect("a file"));
        let files = if top.is_dir() { files_below(&top) } else { Vec::new() };
        (scene, files.into_iter().map(read).collect())
    };
    SCENES.into_iter().map(of).collect()
}

/// What is beside the scenes' folders.
fn others(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder.join("generated")).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| !SCENES.contains(&name.as_str())).collect()
}

/// The state in which a build begins.
#[derive(Clone, Copy, Debug)]
enum State {
    /// Nothing is generated yet.
    Fresh,
    /// The scenes have changed.
    Stale,
    /// Some files were changed, one is missing.
    Damaged,
}

fn copy(from: &Path, to: &Path) {
    for file in files_below(from) {
        let place = to.join(&file);
        fs::create_dir_all(place.parent().expect("a folder")).expect("a folder");
        fs::copy(from.join(&file), place).expect("copied");
    }
}

fn prepare(state: State, folder: &Path, old: &Path) {
    let generated = folder.join("generated");
    let _gone = fs::remove_dir_all(&generated);
    match state {
        State::Fresh => {}
        State::Stale => copy(&old.join("generated"), &generated),
        State::Damaged => {
            copy(&old.join("generated"), &generated);
            fs::write(generated.join("cbox_empty/pbrt-v4/scene.pbrt"), "damaged").expect("written");
            fs::remove_file(generated.join("cbox_empty/luxcore/scene.cfg")).expect("removed");
        }
    }
}

/// At a few random moments, in each state of the folder.
#[test]
fn a_killed_build_leaves_the_old_or_the_new_and_the_next_one_goes_on() {
    kill_builds(6, 0x2545_f491_4f6c_dd1d);
}

/// At more of them; at 1000 with `LTSC_THOROUGH`.
#[test]
#[ignore = "long: dozens of builds"]
fn many_killed_builds_leave_the_old_or_the_new_and_the_next_one_goes_on() {
    kill_builds(if std::env::var_os("LTSC_THOROUGH").is_some() { 1000 } else { 48 }, 0x9e37_79b9_7f4a_7c15);
}

fn kill_builds(rounds: usize, mut random: u64) {
    let (old, new) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    project(old.path(), true);
    project(new.path(), false);
    assert!(build(old.path()).status().expect("run").success());
    let start = Instant::now();
    assert!(build(new.path()).status().expect("run").success());
    let whole = start.elapsed();
    let wanted = contents(new.path());
    let mut cut_short = 0;
    for round in 0..rounds {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        let state = [State::Fresh, State::Stale, State::Damaged][round % 3];
        prepare(state, new.path(), old.path());
        let before = contents(new.path());
        let mut child = build(new.path()).spawn().expect("started");
        let share = (random >> 11) as f64 / (1_u64 << 53) as f64;
        std::thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * share));
        cut_short += usize::from(child.try_wait().expect("a state").is_none());
        let _ended = child.kill();
        let _status = child.wait();
        let after = contents(new.path());
        for scene in SCENES {
            assert!(
                after[scene] == before[scene] || after[scene] == wanted[scene],
                "round {round}, {state:?}: {scene} is neither the old nor the new: {:?}",
                after[scene].keys().collect::<Vec<_>>()
            );
        }
        let ran = run(ltsc().current_dir(new.path()).args(["build", "--allow", "all"]));
        assert_eq!(ran.code, Some(0), "round {round}, {state:?}: {}", ran.err);
        assert!(contents(new.path()) == wanted, "round {round}, {state:?}: the next build made something else");
        assert_eq!(others(new.path()), Vec::<String>::new(), "round {round}, {state:?}");
    }
    assert!(cut_short > rounds / 4, "{cut_short} of {rounds} were still running");
}

/// The system calls that change names.
const CALLS: [&str; 4] =
    ["rename,renameat,renameat2", "unlink,unlinkat,rmdir", "mkdir,mkdirat", "link,linkat,symlink,symlinkat"];

/// Runs a command that is killed at its `when`th system call of these, all of which are made by one thread. Whether it was.
fn killed(inner: &Command, calls: &str, when: usize) -> bool {
    let mut command = Command::new("strace");
    command.args(["-f", "-o", "/dev/null", "-e", &format!("inject={calls}:signal=KILL:when={when}")]);
    command.arg(inner.get_program()).args(inner.get_args()).env("RAYON_NUM_THREADS", "1");
    command.current_dir(inner.get_current_dir().expect("a folder")).stdout(Stdio::null()).stderr(Stdio::null());
    !command.status().expect("run").success()
}

fn traces() -> bool {
    Command::new("strace").arg("-V").output().is_ok_and(|out| out.status.success())
}

/// Kills builds for two targets at the system calls that change names: all of them, one after the other; with `LTSC_THOROUGH` only.
#[test]
fn a_build_that_is_killed_at_a_rename_leaves_the_old_or_the_new() {
    // Hundreds of builds under a tracer.
    if std::env::var_os("LTSC_THOROUGH").is_none() {
        return;
    }
    if !traces() {
        return skip("kills at each rename", "`strace`");
    }
    let (old, new) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    for (folder, stale) in [(&old, true), (&new, false)] {
        project(folder.path(), stale);
        let text = "scenes = \"scenes-src\"\ntargets = [\"pbrt-v4\", \"luxcore\"]\n";
        fs::write(folder.path().join("ltsc.toml"), text).expect("written");
        assert!(build(folder.path()).status().expect("run").success());
    }
    let wanted = contents(new.path());
    for calls in CALLS {
        let mut kills = 0;
        for state in [State::Fresh, State::Stale, State::Damaged] {
            for when in 1.. {
                prepare(state, new.path(), old.path());
                let before = contents(new.path());
                let was_killed = killed(&build(new.path()), calls, when);
                let after = contents(new.path());
                for scene in SCENES {
                    assert!(
                        after[scene] == before[scene] || after[scene] == wanted[scene],
                        "{calls} {when}, {state:?}: {scene}"
                    );
                }
                let ran = run(ltsc().current_dir(new.path()).args(["build", "--allow", "all"]));
                assert_eq!(ran.code, Some(0), "{calls} {when}, {state:?}: {}", ran.err);
                assert!(contents(new.path()) == wanted && others(new.path()).is_empty(), "{calls} {when}, {state:?}");
                if !was_killed {
                    break;
                }
                kills += 1;
            }
        }
        println!("{kills} kills at {calls}");
    }
}

/// Pages among files of a person: each is the old one or the new one, and the next run knows all of them for its own. Kills at random
/// moments; with `LTSC_THOROUGH` at each system call that changes names.
#[test]
fn pages_that_are_killed_halfway_are_written_by_the_next_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let pages = folder.path().join("docs/scenes");
    let doc = || {
        let mut command = ltsc();
        command.current_dir(folder.path()).arg("doc").stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let read = || -> Contents {
        let names = if pages.is_dir() { files_below(&pages) } else { Vec::new() };
        let names = names.into_iter().filter(|name| !name.starts_with('.'));
        names.map(|name| (name.clone(), fs::read(pages.join(&name)).expect("a page"))).collect()
    };
    let begin = |stale: bool| {
        project(folder.path(), stale);
        let _gone = fs::remove_dir_all(folder.path().join("docs"));
    };
    begin(false);
    let start = Instant::now();
    assert!(doc().status().expect("run").success());
    let whole = start.elapsed();
    let new = read();
    begin(true);
    assert!(doc().status().expect("run").success());
    let old = read();
    assert_ne!(old, new, "the scenes differ");
    let judge = |what: &str| {
        for (name, bytes) in read() {
            assert!(old.get(&name) == Some(&bytes) || new.get(&name) == Some(&bytes), "{what}: {name} is half a page");
        }
        let ran = run(ltsc().current_dir(folder.path()).arg("doc"));
        assert_eq!(ran.code, Some(0), "{what}: {}", ran.err);
        assert!(read() == new && !pages.join(".ltsc").exists(), "{what}");
    };
    let stale = || {
        begin(true);
        assert!(doc().status().expect("run").success());
        project(folder.path(), false);
    };
    for round in 1..8_u32 {
        stale();
        let mut child = doc().spawn().expect("started");
        std::thread::sleep(whole * round / 8);
        let _ended = child.kill();
        let _status = child.wait();
        judge(&format!("round {round}"));
    }
    if std::env::var_os("LTSC_THOROUGH").is_none() {
        return;
    }
    if !traces() {
        return skip("kills at each rename", "`strace`");
    }
    for calls in CALLS {
        let mut kills = 0;
        for when in 1.. {
            stale();
            let was_killed = killed(&doc(), calls, when);
            judge(&format!("{calls} {when}"));
            if !was_killed {
                break;
            }
            kills += 1;
        }
        println!("{kills} kills of pages at {calls}");
    }
}

#[test]
fn eight_first_builds_at_once_all_succeed() {
    for _ in 0..3 {
        let folder = tempfile::tempdir().expect("a folder");
        project(folder.path(), false);
        let mut all: Vec<_> = (0..8).map(|_| build(folder.path()).spawn().expect("started")).collect();
        for child in &mut all {
            assert!(child.wait().expect("ended").success());
        }
        let check = run(ltsc().current_dir(folder.path()).args(["build", "--allow", "all", "--check"]));
        assert_eq!((check.code, others(folder.path())), (Some(0), Vec::new()), "{}", check.err);
    }
}

/// On small file systems in memory, which only root may make.
#[test]
fn a_full_disk_leaves_the_old_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let small: PathBuf = folder.path().join("small");
    fs::create_dir(&small).expect("a folder");
    let mounted = |size: u32| {
        let mut command = Command::new("mount");
        command.args(["-t", "tmpfs", "-o", &format!("size={size}k"), "tmpfs"]).arg(&small);
        command.stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    let unmount = || assert!(Command::new("umount").arg(&small).status().expect("umount").success());
    if !cfg!(target_os = "linux") || !mounted(64) {
        return skip("full disks", "the right to mount");
    }
    unmount();
    let thorough = std::env::var_os("LTSC_THOROUGH").is_some();
    let sizes: Vec<u32> = if thorough { (64..=1600).step_by(16).collect() } else { vec![64, 96, 128, 160, 192, 1600] };
    for size in sizes {
        assert!(mounted(size));
        project(&small, false);
        let ran = run(ltsc().current_dir(&small).args(["build", "--allow", "all"]));
        let made = contents(&small);
        let whole = |files: &Contents| files.is_empty() || files.contains_key("manifest.json");
        let fine = made.values().all(whole) && others(&small).is_empty();
        let code = ran.code;
        unmount();
        assert!(
            fine,
            "{size} KiB: half a folder, or something left over: {:?}",
            made.values().map(Contents::len).collect::<Vec<_>>()
        );
        assert!(matches!(code, Some(0 | 4)), "{size} KiB: {code:?} {}", ran.err);
        if code == Some(4) {
            assert!(ran.err.contains("No space left") || ran.err.contains("space"), "{size} KiB: {}", ran.err);
        }
    }
}
