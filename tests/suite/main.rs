//! Tests of the whole: the house itself, the binary as people use it, and real renderers.

mod agree;
mod audit;
mod blender;
mod browser;
mod calibrate;
mod cases;
mod chunks;
mod cli;
mod conventions;
mod edits;
mod endless;
mod equiv;
mod eval;
mod evaluation_file;
mod files;
mod firefox;
mod fixes;
mod format;
mod gallery;
mod geometry;
mod gltf;
mod golden;
mod import;
mod import_gltf;
mod interrupted;
mod ledger;
mod losses;
mod metrics;
mod micro;
mod mitsuba;
mod mutations;
mod outputs;
mod page;
mod page_cases;
mod pages;
mod places;
mod ports;
mod pre_commit;
mod random;
mod reference;
mod render;
mod said;
mod scale;
mod seeds;
mod serve;
mod signals;
mod similar;
mod slurm;
mod statements;
mod thesis;
mod tidy;
mod user;
mod viewer;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ltsc_core::diag::Sources;
use ltsc_core::files::{Bytes, Files, ReadError, VPath};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::install::{Status, status};
use ltsc_render::run::driver;

/// The folder of the project.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The binary under test, without colors, with a fixed width and no settings of the user's.
fn ltsc() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ltsc"));
    command.env("NO_COLOR", "1").env("COLUMNS", "100").env("LC_ALL", "C.UTF-8");
    for name in ["LTSC_FORMAT", "LTSC_ROOT", "LTSC_ALLOW", "LTSC_WARN", "LTSC_DENY", "LTSC_TRUST"] {
        command.env_remove(name);
    }
    command.current_dir(root());
    command
}

/// What a run of the binary gave.
struct Ran {
    code: Option<i32>,
    out: String,
    err: String,
}

fn run(command: &mut Command) -> Ran {
    let Output { status, stdout, stderr } = command.output().expect("the binary starts");
    let text = |bytes| String::from_utf8(bytes).expect("output is UTF-8");
    Ran { code: status.code(), out: text(stdout), err: text(stderr) }
}

/// Says that a test was skipped, and fails where nothing may be.
fn skip(test: &str, lacks: &str) {
    // The print macros are captured by the harness.
    let _written = writeln!(std::io::stderr(), "skipped: {test} (needs {lacks})");
    assert!(std::env::var_os("LTSC_REQUIRE_ALL").is_none_or(|value| value != "1"), "{test} needs {lacks}");
}

/// The Python of a private installation of a renderer.
fn python(renderer: &str) -> Option<PathBuf> {
    let env = Env::of_process();
    let driver = driver(renderer).expect("a driver");
    match status(driver, CachePaths::find(&env).as_ref(), &env) {
        Status::Installed { path, .. } => Some(path),
        Status::External { .. } | Status::Partial { .. } | Status::NotInstalled => None,
    }
}

/// The thesis's own scenes, where they are beside the checkout.
fn corpus() -> Option<PathBuf> {
    let folder = root().parent()?.join("shared/corpus/lteval");
    folder.is_dir().then_some(folder)
}

/// The names of the project's scenes.
fn scenes() -> Vec<String> {
    let files =
        std::fs::read_dir(root().join("scenes-src")).expect("scenes").map(|entry| entry.expect("an entry").path());
    let scenes = files.filter(|path| path.extension().is_some_and(|ending| ending == "lts"));
    let mut names: Vec<String> =
        scenes.filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    assert!(names.len() >= 5, "{names:?}");
    names
}

/// Scenes that are quick to build and have every kind of loss: a plain run builds them, the long one all.
const QUICK: [&str; 4] = ["cbox_classic", "cbox_indirect", "ring", "surfaces"];

/// Files below a folder.
struct Disk(PathBuf);

impl Files for Disk {
    fn read(&self, path: &VPath, _: u64) -> Result<Bytes, ReadError> {
        let bytes = std::fs::read(self.0.join(path.as_str()));
        bytes.map(Bytes::new).map_err(|error| ReadError::Other(error.to_string()))
    }
}

/// The scene of a file, ready to be written.
fn prepared(files: &dyn Files, file: &str) -> Valid {
    let path = VPath::resolve("", file).expect("a path");
    let checked = pipeline::check(files, &mut Sources::default(), &path, &Default::default());
    let scene = checked.scene.unwrap_or_else(|| panic!("{file}: {:?}", checked.findings));
    pipeline::prepare(scene).unwrap_or_else(|findings| panic!("{file}: {findings:?}")).0
}

/// Whether expectations are to be rewritten, by the same switch as snapshots.
fn bless() -> bool {
    std::env::var("INSTA_UPDATE").is_ok_and(|value| value == "always" || value == "force")
}

/// All files below a folder, sorted, as paths relative to it with `/`.
fn files_below(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).expect("a readable folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let below = path.strip_prefix(folder).expect("a path below");
                found.push(below.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}
