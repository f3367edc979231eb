//! Long renderings in chunks: what was rendered once is not rendered again, by a run that goes on after it was killed, by one that asks for
//! more samples, and by two at once. The renderer is a stand-in that counts its calls.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use ltsc_render::image::{Image, Provenance, attributes, write_exr};

use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::executor::{Executor, Local, Order, Outcome, Resources, Task};
use ltsc_evaluation::job::{Job, Runner};

use super::cli::MINIMAL;
use super::{ltsc, run};

struct Stage {
    folder: tempfile::TempDir,
}

impl Stage {
    fn new() -> Self {
        let stage = Self { folder: tempfile::tempdir().expect("a folder") };
        fs::create_dir(stage.path("scenes")).expect("a folder");
        fs::write(stage.path("scenes/one.lts"), MINIMAL.replace("NAME", "one")).expect("a scene");
        write_exr(&stage.path("image.exr"), &Image::filled(8, 8, [0.5, 0.25, 1.0]), &Provenance::default())
            .expect("an image");
        let here = stage.folder.path().display().to_string();
        fs::write(stage.path("version"), "pbrt-r4 4.5.2\n").expect("a version");
        let body = format!(
            "#!/bin/sh\ncat {here}/version\nif [ \"$1\" = --version ]; then exit 0; fi\n\
             echo call >> {here}/calls\nsleep 0.1\nwhile [ \"$1\" != --outfile ]; do shift; done\n\
             if [ -f {here}/fails ]; then echo 'it fails'; exit 1; fi\ncp {here}/image.exr \"$2\"\n"
        );
        fs::write(stage.path("pbrt-r4"), body).expect("a program");
        fs::set_permissions(stage.path("pbrt-r4"), fs::Permissions::from_mode(0o755)).expect("rights");
        stage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn ltsc(&self, words: &[&str]) -> Command {
        let mut command = ltsc();
        command.current_dir(self.folder.path()).env("LTSC_CACHE", self.path("cache")).args(words);
        command
    }

    fn render(&self, samples: u32, image: &str) -> Command {
        let mut command =
            self.ltsc(&["render", "scenes/one.lts", "--renderer", "pbrt-r4", "--width", "8", "--height", "8"]);
        command.args(["--samples", &samples.to_string(), "-o", image, "--executable"]).arg(self.path("pbrt-r4"));
        command
    }

    /// How often the renderer was called.
    fn calls(&self) -> usize {
        fs::read_to_string(self.path("calls")).unwrap_or_default().lines().count()
    }

    fn chunks(&self) -> u64 {
        let ran = run(&mut self.ltsc(&["cache", "--format", "json"]));
        let document: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
        let rows = document["chunks"].as_array().expect("rows");
        rows.iter().map(|row| row["chunks"].as_u64().expect("a number")).sum()
    }
}

#[test]
fn a_rendering_that_is_killed_goes_on_and_more_samples_need_only_the_rest() {
    let stage = Stage::new();
    let mut child = stage.render(16_384, "a.exr").stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("ltsc");
    let start = Instant::now();
    while stage.calls() < 4 {
        assert!(start.elapsed() < Duration::from_secs(60), "it does not start");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    let (before, called) = (stage.chunks(), stage.calls() as u64);
    assert!((3..16).contains(&before), "{before} chunks");
    let ran = run(&mut stage.render(16_384, "a.exr"));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains(&format!("{before} of 16 chunks of 1024 samples were there from before")), "{}", ran.err);
    assert_eq!((stage.chunks(), stage.calls() as u64), (16, called + 16 - before), "a chunk was rendered twice");
    let header = attributes(&stage.path("a.exr")).expect("a header");
    let has = |name: &str, value: &str| header.iter().any(|(known, found)| known == name && found == value);
    assert!(has("ltsc:samples", "16384") && has("ltsc:chunks", "16 of 1024 samples"), "{header:?}");
    // The same again renders nothing; more samples need the rest.
    let calls = stage.calls();
    assert_eq!(run(&mut stage.render(16_384, "b.exr")).code, Some(0));
    assert_eq!(stage.calls(), calls);
    assert_eq!(run(&mut stage.render(18_000, "c.exr")).code, Some(0));
    assert_eq!(stage.calls(), calls + 2);
    // Few samples are no chunks.
    assert_eq!(run(&mut stage.render(16, "d.exr")).code, Some(0));
    assert_eq!((stage.chunks(), stage.calls()), (18, calls + 3));
    let ran = run(&mut stage.ltsc(&["cache", "prune", "--days", "0"]));
    assert!(ran.code == Some(0) && ran.err.contains("18 chunks removed"), "{}", ran.err);
    assert_eq!(stage.chunks(), 0);
}

#[test]
fn two_at_once_share_the_work() {
    let stage = Stage::new();
    let begin =
        |image: &str| stage.render(8192, image).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("ltsc");
    let children = [begin("a.exr"), begin("b.exr")];
    for child in children {
        let out = child.wait_with_output().expect("ended");
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }
    assert_eq!((stage.chunks(), stage.calls()), (8, 8));
}

#[test]
fn a_renderer_that_fails_leaves_what_was_rendered_and_its_log() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(8192, "a.exr")).code, Some(0));
    fs::write(stage.path("fails"), "").expect("written");
    let ran = run(&mut stage.render(10_000, "b.exr"));
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    assert!(ran.err.contains("it fails"), "{}", ran.err);
    let shown = run(&mut stage.ltsc(&["cache"]));
    assert!(shown.out.contains("one") && shown.out.contains("8 chunks"), "{}", shown.out);
    let nowhere = run(&mut stage.ltsc(&["cache", "--shared", "nowhere \" '"]));
    assert!(nowhere.code == Some(2) && nowhere.err.contains("is no folder"), "{}", nowhere.err);
    assert_eq!(stage.chunks(), 8);
    assert!(!stage.path("b.exr").exists());
    fs::remove_file(stage.path("fails")).expect("removed");
    let ran = run(&mut stage.render(10_000, "b.exr"));
    assert_eq!((ran.code, stage.chunks()), (Some(0), 10), "{}", ran.err);
}

/// The files of all chunks, sorted.
fn files(stage: &Stage) -> Vec<PathBuf> {
    let all = super::files_below(&stage.path("cache")).into_iter().filter(|path| path.ends_with(".exr"));
    all.map(|path| stage.path("cache").join(path)).collect()
}

#[test]
fn a_chunk_that_is_damaged_is_rendered_again_or_named() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(8192, "a.exr")).code, Some(0));
    let chunks = files(&stage);
    assert_eq!(chunks.len(), 8);
    // Without its header a file is no chunk.
    fs::write(&chunks[0], "").expect("written");
    fs::write(&chunks[1], "garbage \" '").expect("written");
    let ran = run(&mut stage.render(8192, "b.exr"));
    assert_eq!((ran.code, stage.calls()), (Some(0), 10), "{}", ran.err);
    // Where the pixels alone are lost, the file is named.
    let whole = fs::read(&chunks[2]).expect("a chunk");
    fs::write(&chunks[2], &whole[..whole.len() - 40]).expect("written");
    let ran = run(&mut stage.render(8192, "c.exr"));
    let name = chunks[2].file_name().expect("a name").to_string_lossy().into_owned();
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    assert!(ran.err.contains(&name) && ran.err.contains("it is rendered again"), "{}", ran.err);
    assert!(!stage.path("c.exr").exists());
    fs::remove_file(&chunks[2]).expect("removed");
    assert_eq!(run(&mut stage.render(8192, "c.exr")).code, Some(0));
}

#[test]
fn another_version_of_a_renderer_renders_anew() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(8192, "a.exr")).code, Some(0));
    fs::write(stage.path("version"), "pbrt-r4 4.5.3\n").expect("written");
    assert_eq!(run(&mut stage.render(8192, "b.exr")).code, Some(0));
    assert_eq!((stage.calls(), stage.chunks()), (16, 16));
}

/// Only Linux tells them.
#[test]
#[cfg(target_os = "linux")]
fn a_chunk_says_what_it_took() {
    let stage = Stage::new();
    let text = fs::read_to_string(stage.path("pbrt-r4")).expect("a program");
    let busy = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done\nsleep 0.1\n";
    fs::write(stage.path("pbrt-r4"), text.replacen("sleep 0.1\n", busy, 1)).expect("written");
    assert_eq!(run(&mut stage.render(8192, "a.exr")).code, Some(0));
    let header = attributes(&files(&stage)[0]).expect("a header");
    let number = |name: &str| -> f64 {
        let found = header.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}: {header:?}"));
        found.1.parse().expect("a number")
    };
    let (cpu, wall, memory) = (number("ltsc:cpu-seconds"), number("ltsc:wall-seconds"), number("ltsc:peak-memory"));
    assert!(cpu > 0.05 && cpu < wall, "{cpu} s of {wall} s");
    assert!((1e5..1e8).contains(&memory), "{memory} bytes for a shell");
    assert!(header.iter().any(|(name, value)| name == "ltsc:machine" && value.contains("cores")), "{header:?}");
}

#[test]
fn what_fails_stops_the_rest_unless_it_is_to_go_on() {
    let stage = Stage::new();
    fs::write(stage.path("fails"), "").expect("written");
    let scene = super::prepared(&super::Disk(stage.folder.path().to_path_buf()), "scenes/one.lts");
    let driver = ltsc_render::run::driver("pbrt-r4").expect("a driver");
    let runner = Runner::find(driver, Some(&stage.path("pbrt-r4")), None, None).expect("a program");
    let job = Job::new(&scene, &runner).expect("files");
    let tasks = [0, 1, 2, 3].map(|seed| Task { job: 0, samples: 1, seed });
    let store = Store::at(stage.path("cache/chunks"));
    let local = Local::new(Resources { jobs: 1, memory: None, shared: None, options: Vec::new() });
    let outcomes = |keep_going| {
        let order = Order { jobs: std::slice::from_ref(&job), tasks: &tasks, store: &store, keep_going };
        local.run(&order, &|_| {}).expect("outcomes")
    };
    let stopped = outcomes(false);
    assert!(matches!(stopped[..], [Outcome::Failed(_), Outcome::Skipped, Outcome::Skipped, Outcome::Skipped]));
    assert_eq!(stage.calls(), 1);
    assert!(outcomes(true).iter().all(|outcome| matches!(outcome, Outcome::Failed(_))));
    assert_eq!(stage.calls(), 5);
}
