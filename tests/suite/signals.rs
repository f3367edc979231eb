//! What ltsc starts ends with it: by its end, a time-out, a signal that it can catch, and one that it cannot; and programs that a foreign
//! project names are not started at all.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::cli::MINIMAL;
use super::{ltsc, run, skip};

/// Signals by their names, numbers and whether ltsc can do something about them.
const SIGNALS: [(&str, i32, bool); 4] = [("INT", 2, true), ("TERM", 15, true), ("HUP", 1, true), ("KILL", 9, false)];

/// A scene and a place for temporary files.
struct Stage {
    folder: tempfile::TempDir,
}

impl Stage {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["tmp", "scenes", "cache"] {
            fs::create_dir(folder.path().join(name)).expect("a folder");
        }
        fs::write(folder.path().join("scenes/one.lts"), MINIMAL.replace("NAME", "one")).expect("a scene");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn program(&self, name: &str, body: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, format!("#!/bin/sh\ncd {}\n{body}\n", self.folder.path().display())).expect("a program");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("rights");
        path
    }

    fn ltsc(&self, words: &[&str]) -> Command {
        let mut command = ltsc();
        command.current_dir(self.folder.path()).env("TMPDIR", self.path("tmp")).env("LTSC_CACHE", self.path("cache"));
        command.args(words);
        command
    }

    fn render(&self, program: &Path) -> Command {
        let mut command =
            self.ltsc(&["render", "scenes/one.lts", "--renderer", "pbrt-r4", "-o", "a.exr", "--executable"]);
        command.arg(program).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// The processes that the program has written down, once there are so many.
    fn processes(&self, count: usize) -> Vec<i32> {
        let read = || -> Vec<i32> {
            let text = fs::read_to_string(self.path("pids")).unwrap_or_default();
            text.lines().filter_map(|line| line.parse().ok()).collect()
        };
        until(|| read().len() == count, "the program starts");
        read()
    }

    /// All processes end, and no temporary folder stays.
    fn is_empty(&self, what: &str, processes: &[i32]) {
        until(|| processes.iter().all(|pid| !runs(*pid)), &format!("{what}: all processes end"));
        let names = || {
            let entries = fs::read_dir(self.path("tmp")).expect("a folder").flatten();
            entries.map(|entry| entry.file_name()).collect::<Vec<_>>()
        };
        until(|| names().is_empty(), &format!("{what}: temporary folders go"));
    }
}

fn until(mut done: impl FnMut() -> bool, what: &str) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(20), "not so within 20 s: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Whether a process is there and has not ended.
fn runs(pid: i32) -> bool {
    let out = Command::new("ps").args(["-o", "stat=", "-p", &pid.to_string()]).output().expect("ps");
    let state = String::from_utf8_lossy(&out.stdout).trim().to_owned();
    !state.is_empty() && !state.starts_with('Z')
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status();
    assert!(sent.expect("kill").success());
}

/// Whether a signal is ignored here, and so by what is started here: under `nohup`, or in the background of a script.
fn ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Children of every kind: in the group, in a session of their own, left behind by a parent that has ended, deaf to signals.
/// `setsid` is on Linux only; there are four processes with it, and two without.
const BROOD: &str = "echo pbrt-r4 4.5.2\nif [ \"$1\" = --version ]; then exit 0; fi\ntrap '' INT TERM HUP\nsleep 600 & echo $! >> pids\n\
    if which setsid > /dev/null; then setsid sh -c 'echo $$ >> pids; exec sleep 600' &\n\
    setsid sh -c 'setsid sh -c \"echo \\$\\$ >> pids; exec sleep 600\" & sleep 0.2'; fi\necho $$ >> pids\n";

fn brood() -> usize {
    if cfg!(target_os = "linux") { 4 } else { 2 }
}

#[test]
fn a_signal_ends_all_that_was_started() {
    for (name, number, caught) in SIGNALS {
        if ignored(number) {
            skip("a signal", &format!("SIG{name}, which is ignored here"));
            continue;
        }
        let stage = Stage::new();
        let program = stage.program("pbrt-r4", &format!("{BROOD}while :; do sleep 1; done"));
        let mut child = stage.render(&program).spawn().expect("started");
        let processes = stage.processes(brood());
        assert!(processes.iter().all(|pid| runs(*pid)));
        send(&child, name);
        let status = child.wait().expect("ended");
        // Shells tell 130, 143, 129 and 137.
        assert_eq!(status.signal(), Some(number), "{name}");
        if caught {
            assert!(processes.iter().all(|pid| !runs(*pid)), "{name}: ltsc ends after all others");
            assert_eq!(fs::read_dir(stage.path("tmp")).expect("a folder").count(), 0, "{name}");
            let log = fs::read_to_string(stage.path("a.exr.log")).expect("a log");
            assert!(log.contains("the log ends here"), "{name}: {log}");
        }
        stage.is_empty(name, &processes);
        assert!(!stage.path("a.exr").exists());
    }
}

#[test]
fn the_end_of_a_renderer_and_a_time_out_end_all_that_was_started() {
    for (rest, more, code) in [("exit 1", &[][..], 4), ("while :; do sleep 1; done", &["--timeout", "2"], 4)] {
        let stage = Stage::new();
        let program = stage.program("pbrt-r4", &format!("{BROOD}{rest}"));
        let ran = run(stage.render(&program).args(more).stderr(Stdio::piped()));
        assert_eq!(ran.code, Some(code), "{rest}: {}", ran.err);
        stage.is_empty(rest, &stage.processes(brood()));
    }
}

#[test]
fn a_time_out_bounds_the_question_for_the_version() {
    let stage = Stage::new();
    let program = stage.program("pbrt-r4", &format!("set --\n{BROOD}while :; do sleep 1; done"));
    let start = Instant::now();
    let ran = run(stage.render(&program).args(["--timeout", "2"]).stderr(Stdio::piped()));
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    assert!(ran.err.contains("took more than 2 s"), "{}", ran.err);
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
    stage.is_empty("a question", &stage.processes(brood()));
}

/// How a renderer ended is told through its supervisor.
#[test]
fn a_crash_and_a_program_that_cannot_start_are_told() {
    let stage = Stage::new();
    let answer = "echo pbrt-r4 4.5.2\nif [ \"$1\" = --version ]; then exit 0; fi\n";
    for (body, word) in [("kill -SEGV $$", "signal 11"), ("kill -KILL $$", "signal 9"), ("exit 9", "exit code 9")] {
        let program = stage.program("pbrt-r4", &format!("{answer}{body}"));
        let ran = run(stage.render(&program).stderr(Stdio::piped()));
        assert!(ran.code == Some(4) && ran.err.contains(word), "{body}: {}", ran.err);
    }
    fs::write(stage.path("pbrt-r4"), "\x7fELF, but not really").expect("written");
    let ran = run(stage.render(&stage.path("pbrt-r4")).stderr(Stdio::piped()));
    assert!(ran.code == Some(4) && ran.err.contains("does not start"), "{}", ran.err);
}

/// A build that a signal ends leaves nothing behind, not even for the next one to clean up: twice for each signal, at other moments,
/// twenty times with `LTSC_THOROUGH`.
#[test]
fn a_signal_leaves_nothing_of_a_build() {
    let rounds = if std::env::var_os("LTSC_THOROUGH").is_some() { 20 } else { 2 };
    let signals = SIGNALS.into_iter().filter(|(_, number, caught)| *caught && !ignored(*number));
    let mut ended = 0;
    for (name, number, round) in
        signals.flat_map(|(name, number, _)| (0..rounds).map(move |round| (name, number, round)))
    {
        let stage = Stage::new();
        fs::write(stage.path("ltsc.toml"), "scenes = \"scenes\"\n").expect("written");
        for at in 0..60 {
            let scene = MINIMAL.replace("NAME", &format!("s{at}"));
            fs::write(stage.path(&format!("scenes/s{at}.lts")), scene).expect("a scene");
        }
        let mut build = stage.ltsc(&["build", "--allow", "all"]);
        let mut child = build.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started");
        until(|| stage.path("generated/.ltsc").exists(), "the build begins to write");
        std::thread::sleep(Duration::from_millis(300 * round / rounds));
        send(&child, name);
        let status = child.wait().expect("ended");
        ended += usize::from(status.signal() == Some(number));
        assert!(status.success() || status.signal() == Some(number), "{name}: {status}");
        assert!(!stage.path("generated/.ltsc").exists(), "{name}");
        for entry in fs::read_dir(stage.path("generated")).into_iter().flatten().flatten() {
            assert!(entry.path().join("manifest.json").is_file(), "{name}: {:?}", entry.path());
        }
    }
    println!("{ended} builds ended by a signal");
    assert!(ended > 0);
}

/// A program that the project names is run only once the user has said yes.
#[test]
fn a_foreign_project_starts_nothing() {
    let stage = Stage::new();
    let program = stage.program("python3", "echo yes > ran; echo '@ltsc 2.11.2'");
    let toml = "scenes = \"scenes\"\n[renderers.luxcore]\nexecutable = \"./python3\"\n";
    fs::write(stage.path("ltsc.toml"), toml).expect("written");
    let ran = |words: &[&str]| {
        let ran = run(&mut stage.ltsc(words));
        (ran, fs::remove_file(stage.path("ran")).is_ok())
    };
    let (list, started) = ran(&["renderers", "list"]);
    assert!(list.code == Some(0) && !started, "{}", list.err);
    assert!(list.out.contains("not trusted") && list.out.contains("ltsc renderers trust"), "{}", list.out);
    for words in [
        &["render", "scenes/one.lts", "--renderer", "luxcore", "-o", "a.exr"][..],
        &["agree", "scenes/one.lts", "--renderer", "luxcore,mitsuba-3"],
        &["agree", "scenes/one.lts"],
        &["conventions", "--renderer", "luxcore"],
        &["doc", "--render"],
    ] {
        let (refused, started) = ran(words);
        assert!(!started, "{words:?}");
        assert_eq!(refused.code, Some(4), "{words:?}: {}", refused.err);
        assert!(refused.err.contains("ltsc renderers trust") && refused.err.contains("python3"), "{}", refused.err);
    }
    // By a variable, and for good; what is named on the command line needs neither.
    let trusted = run(stage.ltsc(&["renderers", "list"]).env("LTSC_TRUST", stage.folder.path()));
    assert!(trusted.out.contains("configured") && fs::remove_file(stage.path("ran")).is_ok(), "{}", trusted.out);
    let other = run(stage.ltsc(&["renderers", "list"]).env("LTSC_TRUST", stage.path("scenes")));
    assert!(other.out.contains("not trusted") && !stage.path("ran").exists());
    let (trust, started) = ran(&["renderers", "trust"]);
    assert!(trust.code == Some(0) && !started && trust.err.contains("python3"), "{}", trust.err);
    let (list, started) = ran(&["renderers", "list"]);
    assert!(started && list.out.contains("configured"), "{}", list.out);
    // Another program of the same project is another question.
    fs::rename(&program, stage.path("python3.9")).expect("renamed");
    fs::write(stage.path("ltsc.toml"), toml.replace("./python3", "./python3.9")).expect("written");
    let (list, started) = ran(&["renderers", "list"]);
    assert!(!started && list.out.contains("not trusted"), "{}", list.out);
}
