//! Chunks on a cluster: with programs that stand in for Slurm's, which fail as they are told, and with a Slurm of one node on this machine.
#![cfg(unix)]

mod real;
mod stand_in;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use ltsc_core::files::MemoryFiles;
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::executor::slurm::Slurm;
use ltsc_evaluation::executor::{Executor, News, Order, Outcome, Resources, Task};
use ltsc_evaluation::failure::Failure;
use ltsc_evaluation::job::{Job, Runner};
use ltsc_render::env::Env;
use ltsc_render::guard;
use ltsc_render::image::{Image, Provenance, exr_bytes};
use ltsc_render::run::driver;

use super::cli::MINIMAL;
use super::prepared;

/// What tells a process of its own where it works.
const PLACE: &str = "LTSC_TEST_SLURM";

/// A shared folder, a folder of Slurm's programs, and a renderer that gives an image at once, waits for the file `go` while there is
/// `hold`, and fails while there is `broken`.
struct Stage {
    path: PathBuf,
    _folder: Option<tempfile::TempDir>,
}

impl Stage {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let stage = Self { path: folder.path().to_owned(), _folder: Some(folder) };
        for name in ["bin", "shared", "renders", "tmp"] {
            fs::create_dir(stage.at(name)).expect("a folder");
        }
        let image = Image::filled(16, 8, [1.0, 2.0, 3.0]);
        let bytes = exr_bytes(&stage.at("image.exr"), &image, &Provenance::default()).expect("an image");
        fs::write(stage.at("image.exr"), bytes).expect("written");
        fs::write(stage.at("version"), "pbrt-r4 4.5.2\n").expect("written");
        let body = "if [ \"$1\" = --version ]; then exec cat version; fi\n\
            if [ -f broken ]; then echo 'there is no light'; exit 1; fi\n\
            while [ $# -gt 0 ]; do if [ \"$1\" = --outfile ]; then out=$2; fi; shift; done\n\
            mark=renders/${SLURM_JOB_NAME:-none}.$SLURM_ARRAY_TASK_ID\n\
            echo $$ > \"$mark.new\"; mv \"$mark.new\" \"$mark\"\n\
            if [ -f hold ]; then while [ ! -f go ]; do sleep 0.05; done; fi\ncp image.exr \"$out\"\n";
        stage.program("pbrt-r4", body);
        stage
    }

    fn at(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn program(&self, name: &str, body: &str) {
        let path = self.at(name);
        fs::write(&path, format!("#!/bin/sh\ncd '{}'\n{body}", self.path.display())).expect("a program");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("rights");
    }

    fn touch(&self, name: &str) {
        fs::write(self.at(name), "").expect("written");
    }

    fn resources(&self) -> Resources {
        let options = vec!["--partition=all".to_owned()];
        Resources { jobs: 2, memory: None, shared: Some(self.at("shared")), options }
    }

    fn env(&self) -> Env {
        Env::of(&[("PATH", self.at("bin").to_str().expect("a name"))])
    }

    fn slurm(&self) -> Slurm {
        let program = PathBuf::from(env!("CARGO_BIN_EXE_ltsc"));
        hasty(Slurm::new(&self.resources(), &self.env(), program).expect("a cluster"))
    }

    fn store(&self) -> Store {
        Store::at(self.at("shared/chunks"))
    }

    fn runner(&self) -> Runner {
        let found = Runner::find(driver("pbrt-r4").expect("a driver"), Some(&self.at("pbrt-r4")), None, None);
        Runner { threads: Some(1), ..found.expect("a renderer") }
    }

    /// Renders chunks of these seeds of a small scene, two samples each, and tells what was said.
    fn run(&self, slurm: &Slurm, seeds: &[u32], keep_going: bool) -> (Result<Vec<Outcome>, Failure>, Vec<String>) {
        self.run_with(slurm, seeds, keep_going, &|_| {})
    }

    fn run_with(
        &self,
        slurm: &Slurm,
        seeds: &[u32],
        keep_going: bool,
        heard: &(dyn Fn(&News<'_>) + Sync),
    ) -> (Result<Vec<Outcome>, Failure>, Vec<String>) {
        let mut files = MemoryFiles::default();
        files.insert("one.lts", MINIMAL.replace("NAME", "one"));
        let runner = self.runner();
        let job = Job::new(&prepared(&files, "one.lts"), &runner).expect("a job");
        run(slurm, &self.store(), &job, seeds, keep_going, heard)
    }

    /// The same in a process of its own.
    fn process(&self) -> Child {
        let suite = std::env::current_exe().expect("this program");
        let mut command = Command::new(suite);
        command.args(["--ignored", "--exact", "slurm::a_process_of_its_own"]).env(PLACE, &self.path);
        // Nobody removes the temporary folders of a test that is killed.
        command.env("TMPDIR", self.at("tmp"));
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started")
    }

    /// How many tasks have reached the renderer.
    fn renders(&self) -> usize {
        let marks = fs::read_dir(self.at("renders")).expect("a folder").flatten();
        marks.filter(|mark| mark.path().extension().is_some_and(|ending| ending != "new")).count()
    }

    /// Nothing stays in the shared folder but chunks.
    fn is_tidy(&self) {
        let entries = fs::read_dir(self.at("shared")).expect("a folder").flatten();
        let mut names: Vec<_> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| name != "chunks");
        assert!(names.is_empty(), "{names:?}");
    }
}

fn run(
    executor: &dyn Executor,
    store: &Store,
    job: &Job<'_>,
    seeds: &[u32],
    keep_going: bool,
    heard: &(dyn Fn(&News<'_>) + Sync),
) -> (Result<Vec<Outcome>, Failure>, Vec<String>) {
    let tasks: Vec<Task> = seeds.iter().map(|seed| Task { job: 0, samples: 2, seed: *seed }).collect();
    let order = Order { jobs: std::slice::from_ref(job), tasks: &tasks, store, keep_going };
    let said = Mutex::new(Vec::new());
    let done = executor.run(&order, &|news| {
        heard(&news);
        if let News::Note(text) = news {
            said.lock().expect("a list").push(text);
        }
    });
    (done, said.into_inner().expect("a list"))
}

/// A cluster that is asked ten times a second.
fn hasty(slurm: Slurm) -> Slurm {
    slurm.hasty(Duration::from_millis(100), Duration::from_secs(1))
}

/// One letter for each: made, kept, failed, skipped.
fn letters(outcomes: &[Outcome]) -> String {
    let letter = |outcome: &Outcome| match outcome {
        Outcome::Made => 'm',
        Outcome::Kept => 'k',
        Outcome::Failed(_) => 'f',
        Outcome::Skipped => 's',
    };
    outcomes.iter().map(letter).collect()
}

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(30), "not so within 30 s: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn kill(pid: &str) {
    assert!(Command::new("kill").args(["-KILL", pid]).status().expect("kill").success(), "{pid}");
}

/// What others start to end it: chunks of three seeds, until there is a file `signal`.
#[test]
#[ignore = "others start it"]
fn a_process_of_its_own() {
    let Some(path) = std::env::var_os(PLACE) else { return };
    let stage = Stage { path: PathBuf::from(path), _folder: None };
    let signal = stage.at("signal");
    std::thread::spawn(move || {
        while !signal.exists() {
            std::thread::sleep(Duration::from_millis(20));
        }
        // As the binary does.
        guard::put_back();
        std::process::exit(143);
    });
    let (done, said) = stage.run(&stage.slurm(), &[0, 1, 2], false);
    panic!("it ended by itself: {done:?} {said:?}");
}

/// A process is killed while so many of its three tasks run; the next run waits for two of them.
fn taken_over(stage: &Stage, running: usize) {
    stage.touch("hold");
    let mut child = stage.process();
    until("tasks run", || stage.renders() == running);
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert!(stage.at("shared/runs").is_dir(), "a killed run leaves what it has submitted");
    let before = stage.renders();
    // Seed 2 is not wanted any more, seed 7 is new.
    let go = |news: &News<'_>| {
        if matches!(news, News::Note(text) if text.contains("taken over 2, canceled 1")) {
            stage.touch("go");
        }
    };
    let (done, said) = stage.run_with(&stage.slurm(), &[0, 1, 7], false, &go);
    assert_eq!(letters(&done.expect("outcomes")), "mmm", "{said:?}");
    assert_eq!(said.iter().filter(|text| text.contains("has array")).count(), 1, "{said:?}");
    assert_eq!(stage.renders(), before + 1, "what ran was not begun again");
    stage.is_tidy();
}
