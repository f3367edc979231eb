//! Requests to programs that only look like renderers.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::super::{Progress, RenderError, RenderRequest, Rendered, Search, Source, driver, find, render};
use crate::cache::CachePaths;
use crate::env::Env;
use crate::image::{Image, Provenance, write_exr, write_pfm};

/// A folder with an emitted scene and a program that pretends to be a Python with a renderer.
struct Stage {
    folder: tempfile::TempDir,
    request: RenderRequest,
}

/// The scratch folder, from the job that is the last argument.
const SCRATCH: &str = r#"for job; do :; done; scratch=$(printf %s "$job" | sed 's/.*"scratch":"\([^"]*\)".*/\1/')"#;

impl Stage {
    fn new(driver_name: &str, program: &str, body: &str) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let driver = driver(driver_name).expect("a driver");
        fs::write(folder.path().join(driver.main_file), "<default name=\"samples\" <default name=\"seed\"")
            .expect("scene");
        let path = script(folder.path(), program, body);
        let log = folder.path().join("log");
        let mut request = RenderRequest::new(driver, folder.path().to_owned(), (2, 1), log);
        request.executable = Some(path);
        request.timeout = Some(Duration::from_secs(60));
        Self { folder, request }
    }

    fn python(body: &str) -> Self {
        Self::new("luxcore", "python3", body)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn render(&self) -> Result<Rendered, RenderError> {
        render(&self.request, &mut |_| {})
    }

    fn fails(&self) -> RenderError {
        self.render().map(|rendered| rendered.samples_done).expect_err("a failure")
    }
}

fn script(folder: &Path, name: &str, body: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, format!("#!/bin/sh\n{SCRATCH}\n{body}\n")).expect("write the script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("make it executable");
    path
}

/// Whether the process with the number in the file is gone, within a few seconds.
fn gone(file: &Path) -> bool {
    let number = fs::read_to_string(file).expect("the number of a process");
    let number = rustix::process::Pid::from_raw(number.trim().parse().expect("a number"));
    let end = Instant::now() + Duration::from_secs(5);
    while Instant::now() < end {
        let state = fs::read_to_string(format!("/proc/{}/stat", number.expect("not 0").as_raw_nonzero()));
        let zombie = state.is_ok_and(|state| state.contains(") Z "));
        if zombie || rustix::process::test_kill_process(number.expect("not 0")).is_err() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

#[test]
fn passes_are_averaged_by_their_samples() {
    let stage = Stage::python(
        r#"echo noise; echo '@ltsc {"event":"version","version":"9.8"}'
        echo '@ltsc {"event":"loaded","seconds":0.5}'
        cp one.pfm $scratch/; cp two.pfm $scratch/
        echo '@ltsc {"event":"pass","samples":1,"done":1,"total":4,"file":"one.pfm","seconds":1}'
        echo '@ltsc {"event":"pass","samples":3,"done":4,"total":4,"file":"two.pfm","seconds":2}'
        echo '@ltsc {"event":"done","seconds":2.5}'; echo more noise >&2"#,
    );
    let one = Image { width: 2, height: 1, pixels: vec![[4.0, 0.0, 1.0], [0.0; 3]] };
    let two = Image { width: 2, height: 1, pixels: vec![[0.0, 4.0, 1.0], [f32::NAN, 8.0, 0.0]] };
    write_pfm(&stage.path("one.pfm"), &one).expect("write");
    write_pfm(&stage.path("two.pfm"), &two).expect("write");
    let mut news = Vec::new();
    let rendered = render(&stage.request, &mut |progress| news.push(progress)).expect("an image");
    assert_eq!(rendered.image.pixels[0], [1.0, 3.0, 1.0]);
    assert!(rendered.image.pixels[1][0].is_nan());
    assert_eq!(rendered.image.pixels[1][1..], [6.0, 0.0]);
    assert_eq!((rendered.samples_done, rendered.seconds), (4, 2.5));
    assert_eq!(rendered.renderer_version, "9.8");
    assert_eq!(news[0], Progress::Started { version: "9.8".to_owned() });
    assert_eq!(news[3], Progress::Samples { done: 4, total: 4, seconds: 2.0 });
    let log = fs::read_to_string(rendered.log_path).expect("the log");
    assert_eq!(log, "noise\nmore noise\n");
}

#[test]
fn the_job_says_what_was_asked_for() {
    let mut stage = Stage::python(r#"printf '%s' "$job" >&2; exit 1"#);
    stage.request.samples = 77;
    stage.request.seed = 5;
    stage.request.threads = Some(3);
    stage.fails();
    let log = fs::read_to_string(stage.path("log")).expect("the log");
    let job: serde_json::Value = serde_json::from_str(&log).expect("JSON");
    assert_eq!((&job["samples"], &job["seed"], &job["threads"]), (&77.into(), &5.into(), &3.into()));
    assert_eq!(job["main"], stage.path("scene.cfg").to_str().expect("Unicode"));
    // The folder of the run is deleted.
    assert!(!Path::new(job["scratch"].as_str().expect("text")).exists());
}

#[test]
fn an_exit_code_comes_with_the_end_of_the_log_and_a_hint() {
    let stage = Stage::python(
        r#"i=0; while [ $i -lt 50 ]; do echo "line $i"; i=$((i+1)); done
        printf 'bar 1\rbar 2\r\n\033[31mred\033[0m\n'
        echo '@ltsc {"event":"error","kind":"render","message":"no light"}'
        echo "ModuleNotFoundError: No module named 'pyluxcore'" >&2; exit 3"#,
    );
    let error = stage.fails();
    assert_eq!(error.to_string(), "`luxcore` failed with exit code 3: no light");
    assert!(error.hint().contains("renderers install"), "{}", error.hint());
    assert_eq!(error.tail().len(), 20);
    assert!(error.tail().iter().any(|line| line == "bar 2"));
    assert!(error.tail().iter().any(|line| line == "red"));
    assert!(error.tail().iter().all(|line| !line.contains("@ltsc")));
}

#[test]
fn a_crash_tells_its_signal() {
    let error = Stage::python("echo last words; kill -SEGV $$").fails();
    assert_eq!(error.to_string(), "`luxcore` was ended by signal 11");
    assert_eq!(error.tail(), ["last words"]);
    let error = Stage::python("kill -KILL $$").fails();
    assert!(error.hint().contains("memory"), "{}", error.hint());
}

#[test]
fn a_time_out_kills_grandchildren_too() {
    let mut stage = Stage::python(
        r"sh -c 'sleep 600 & echo $! > grandchild; wait' & echo $$ > child
        sleep 600",
    );
    stage.request.timeout = Some(Duration::from_millis(700));
    let start = Instant::now();
    let error = stage.fails();
    assert!(matches!(error, RenderError::TimedOut { .. }), "{error}");
    assert!(start.elapsed() < Duration::from_secs(20));
    assert!(gone(&stage.path("child")));
    assert!(gone(&stage.path("grandchild")));
}

#[test]
fn what_is_left_after_the_end_is_killed() {
    let stage = Stage::python("sleep 600 & echo $! > child; exit 1");
    let start = Instant::now();
    stage.fails();
    assert!(start.elapsed() < Duration::from_secs(20));
    assert!(gone(&stage.path("child")));
}

#[test]
fn a_cancelled_request_ends_at_once() {
    let mut stage = Stage::python("echo $$ > child; sleep 600");
    let cancel = Arc::new(AtomicBool::new(false));
    stage.request.cancel = Some(Arc::clone(&cancel));
    let (child, start) = (stage.path("child"), Instant::now());
    let waiter = std::thread::spawn(move || {
        while !child.exists() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(10));
        }
        std::thread::sleep(Duration::from_millis(50));
        cancel.store(true, Ordering::Relaxed);
    });
    let error = stage.fails();
    waiter.join().expect("the other thread");
    assert!(matches!(error, RenderError::Cancelled), "{error}");
    assert!(gone(&stage.path("child")));
}

#[test]
fn floods_neither_block_nor_pass_for_events() {
    // 40 MB on both streams, one of them without a line end, then a line that only contains an
    // event.
    let stage = Stage::python(
        r#"head -c 20000000 /dev/zero | tr '\0' x; echo ' @ltsc {"event":"done","seconds":1}'
        yes | head -c 20000000 >&2; exit 4"#,
    );
    let error = stage.fails();
    assert!(error.to_string().contains("exit code 4"), "{error}");
    let length = fs::metadata(stage.path("log")).expect("the log").len();
    assert!(length > 40_000_000, "{length}");
    assert!(error.tail().iter().all(|line| line.len() <= 400));
}

#[test]
fn a_good_end_without_an_image_is_an_error() {
    let pass = r#"echo '@ltsc {"event":"pass","samples":1,"done":1,"total":1,"file":"one.pfm","seconds":1}'"#;
    let done = r#"echo '@ltsc {"event":"done","seconds":2.5}'"#;
    let copy = "cp one.pfm $scratch/";
    let stage = |body: &str| {
        let stage = Stage::python(body);
        write_pfm(&stage.path("one.pfm"), &Image::filled(2, 2, [1.0; 3])).expect("write");
        stage.fails().to_string()
    };
    assert_eq!(stage("exit 0"), "`luxcore` left no image");
    assert_eq!(stage(done), "`luxcore` left no image");
    assert_eq!(stage(&format!("{copy}; {pass}")), "`luxcore` left no image");
    assert!(stage(&format!("{pass}; {done}")).contains("one.pfm"));
    assert!(stage(&format!("echo '@ltsc nonsense'; {copy}; {pass}; {done}")).contains("nonsense"));
    assert_eq!(stage(&format!("{copy}; {pass}; {done}")), "`luxcore` gave an image of 2x2 pixels instead of 2x1");
}

#[test]
fn mitsuba_may_be_run_by_its_own_command_line() {
    let stage = Stage::new(
        "mitsuba",
        "mitsuba",
        r#"if [ "$1" = --help ]; then echo 'Mitsuba version 3.7.0 (x)'; exit 0; fi
        echo "$@"; for a; do if [ "$last" = -o ]; then out=$a; fi; last=$a; done; cp "${0%/*}/image.exr" "$out""#,
    );
    let image = Image { width: 2, height: 1, pixels: vec![[1.0, 2.0, 3.0], [0.5; 3]] };
    write_exr(&stage.path("image.exr"), &image, &Provenance::default()).expect("write");
    let rendered = stage.render().expect("an image");
    assert_eq!(rendered.image, image);
    assert_eq!((rendered.samples_done, rendered.renderer_version.as_str()), (16, "3.7.0"));
    let log = fs::read_to_string(rendered.log_path).expect("the log");
    assert!(log.starts_with("-m scalar_rgb -Dsamples=16 -Dseed=0 -o "), "{log}");
    fs::write(stage.path("scene.xml"), "<default name=\"samples\"").expect("write");
    let error = stage.fails();
    assert!(error.to_string().contains("no parameter `seed`"), "{error}");
}

#[test]
fn what_is_named_comes_first_and_must_work() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let place = |name: &str, body: &str| {
        let place = folder.path().join(name);
        fs::create_dir(&place).expect("folder");
        script(&place, "python3", body)
    };
    let [good, other, bad] =
        [("good", "echo noise; echo '@ltsc 2.0'"), ("other", "echo '@ltsc 3.0'"), ("bad", "exit 77")]
            .map(|(name, body)| place(name, body));
    let path = [&bad, &good, &other].map(|file| file.parent().expect("a folder").to_str().expect("Unicode"));
    let env = Env::of(&[("PATH", &path.join(":"))]);
    let driver = driver("lux").expect("an alias");
    let cache = CachePaths { root: folder.path().join("cache") };
    let search = Search { env: &env, cache: Some(&cache), given: None, configured: None, until: None };
    let look = |search: Search<'_>| find(driver, &search).map(|found| (found.path, found.version, found.source));
    let found = look(search).expect("one on the path works");
    assert_eq!(found, (good.clone(), "2.0".to_owned(), Source::Path));
    let found = look(Search { configured: Some(&other), ..search }).expect("the configured one works");
    assert_eq!((found.0, found.2), (other.clone(), Source::Configured));
    let found = look(Search { configured: Some(&other), given: Some(&good), ..search }).expect("the given one works");
    assert_eq!((found.0, found.2), (good, Source::Given));
    let error = look(Search { given: Some(&bad), ..search }).expect_err("nothing else is tried");
    assert!(error.tail()[0].contains("has no module `pyluxcore`"), "{:?}", error.tail());
    let error = look(Search { given: Some(Path::new("/bin/ls")), ..search }).expect_err("no Python");
    assert!(error.tail()[0].contains("neither a Python"), "{:?}", error.tail());
}

#[test]
fn requests_that_make_no_sense_are_refused() {
    let mut stage = Stage::python("exit 0");
    stage.request.samples = 0;
    assert!(matches!(stage.fails(), RenderError::Request { .. }));
    stage.request.samples = 1;
    stage.request.main_file = "other.cfg".to_owned();
    assert!(stage.fails().hint().contains("emit"));
    stage.request.main_file = "scene.cfg".to_owned();
    stage.request.executable = Some(stage.path("missing"));
    assert!(matches!(stage.fails(), RenderError::Io { .. }));
    stage.request.executable = None;
    let error = stage.fails();
    assert!(matches!(error, RenderError::NotFound { .. }), "{error}");
    assert!(error.hint().contains("ltsc renderers install luxcore"));
}
