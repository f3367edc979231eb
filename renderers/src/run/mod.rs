//! Runs renderers: the table of drivers, and a request that becomes an image.
//!
//! A driver takes an emitted folder as it is and sets only seed, samples and threads, and what a renderer without them needs for that.

mod bar;
mod call;
mod cycles;
mod emitted;
mod error;
mod find;
pub(crate) mod installed;
mod luxcore;
mod mitsuba0;
mod mitsuba3;
mod pbrt;
mod pbrt3;
mod pbrt4;
mod pbrt_r3;
mod pbrt_r4;
pub(crate) mod process;
mod render;
pub(crate) mod script;
mod tiles;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use crate::cache::CachePaths;
use crate::env::Env;
use crate::image::Image;

pub use call::{Call, without_driver};
pub use error::{Failure, RenderError};
pub(crate) use find::on_path as find_on_path;
pub use find::{Found, Search, Source, find};
pub use installed::{Status, status_in_cache};
pub use process::{Usage, tail};
pub use render::{refuse, render};
pub use script::is_python;

/// A program that is asked for its version, and until when it may take to answer.
#[derive(Clone, Copy)]
pub(crate) struct Asked<'a> {
    pub program: &'a Path,
    pub until: Option<Instant>,
}

/// All drivers, in the order in which they are listed.
pub const DRIVERS: &[&Driver] = &[
    &mitsuba3::ROW,
    &luxcore::ROW,
    &cycles::ROW,
    &pbrt_r4::ROW,
    &pbrt_r3::ROW,
    &pbrt4::ROW,
    &pbrt3::ROW,
    &mitsuba0::ROW_06,
    &mitsuba0::ROW_05,
];

/// The driver of this name or alias.
#[must_use]
pub fn driver(name: &str) -> Option<&'static Driver> {
    DRIVERS.iter().copied().find(|driver| driver.name == name || driver.aliases.contains(&name))
}

/// What there is to know about one renderer.
pub struct Driver {
    /// Its name on the command line and in results.
    pub name: &'static str,
    /// Other names for it.
    pub aliases: &'static [&'static str],
    /// What it is, in a few words.
    pub summary: &'static str,
    /// The target whose files it reads.
    pub target: &'static str,
    /// The file in an emitted folder from which it starts.
    pub main_file: &'static str,
    /// The version that is installed and that everything was measured with.
    pub version: &'static str,
    /// How ltsc installs it.
    pub installation: Installation,
    /// Programs with this driver's own command line.
    pub programs: &'static [&'static str],
    /// Whether a named executable is asked for its version before it renders. For a program that takes no time and tells
    /// a wrong version before it has misread the scene; a Python with a renderer takes about a second to answer.
    pub asks_named: bool,
    /// The smallest scene that shows whether an installation works; see [`TEST_SCENE`]. Empty where nothing is installed.
    pub test_scene: &'static [(&'static str, &'static str)],
    /// Of a renderer that computes with wavelengths, drawn anew for each sample: the standard deviation that they alone give
    /// a sample of constant white, in red, green, blue and in the mean of the three, as a share.
    pub wavelengths: Option<[f64; 4]>,
    /// Whether it renders independent images of one scene.
    pub seeds: Seeds,
    /// The fewest samples per pixel with which images of different seeds have no error in common that counts; with fewer, their scatter
    /// does not tell it, and their mean keeps it.
    pub least_samples: u32,
    /// What it renders otherwise than its own path tracing, or than the renderer whose files it reads, by more than noise.
    pub defects: &'static [Defect],
    /// Texts of lines that tell that it has failed, for programs that end with code 0 all the same.
    pub failures: &'static [&'static str],
    /// Texts of the log that tell a known cause, each with what to do about it.
    pub hints: &'static [(&'static str, &'static str)],
    /// Asks an executable for its version; the reason if it has none.
    pub(crate) probe: fn(Asked<'_>) -> Result<String, String>,
    /// Turns a request into a command.
    pub(crate) plan: fn(&Job<'_>) -> Result<Plan, RenderError>,
}

impl Driver {
    /// What it is known to render otherwise of a scene with these features.
    pub fn defects_of<'f>(&self, features: &'f [String]) -> impl Iterator<Item = &'static str> + use<'f> {
        let concerns =
            move |defect: &&Defect| defect.features.iter().any(|name| features.iter().any(|own| own == name));
        self.defects.iter().filter(concerns).map(|defect| defect.what)
    }

    /// What ltsc has to install of it for Python, if it comes that way.
    #[must_use]
    pub fn packages(&self) -> Option<&Packages> {
        match &self.installation {
            Installation::Python(packages) => Some(packages),
            Installation::Cargo(_) | Installation::User { .. } => None,
        }
    }

    /// How to come by it, as a sentence.
    #[must_use]
    pub fn advice(&self) -> String {
        match &self.installation {
            Installation::Python(_) | Installation::Cargo(_) => {
                format!("`ltsc renderers install {}` makes a private copy; or name an executable", self.name)
            }
            Installation::User { source } => format!(
                "ltsc does not install it: build it from {source}, and name it by `--executable`, by `[renderers.\"{}\"]` in \
                 `ltsc.toml`, or put it on the path as {}",
                self.name,
                self.programs.iter().map(|program| format!("`{program}`")).collect::<Vec<_>>().join(" or ")
            ),
        }
    }
}

/// What a renderer does wrong.
pub struct Defect {
    /// Names of features of scenes that it concerns, as manifests have them.
    pub features: &'static [&'static str],
    /// What is wrong, as a sentence without a subject's name.
    pub what: &'static str,
}

/// Whether a renderer renders independent images of one scene, each with a seed of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seeds {
    /// Any seed costs as much as another.
    Free,
    /// Seed `k` costs `k` images more.
    Costly,
    /// With some samplers of the scene only; any seed but 0 is refused otherwise.
    Some,
}

/// How a renderer comes onto a machine.
pub enum Installation {
    /// As packages of Python, into a private environment.
    Python(Packages),
    /// As a crate that cargo builds, into a private folder.
    Cargo(Crate),
    /// By the user.
    User {
        /// Where its source is.
        source: &'static str,
    },
}

/// Packages of Python that hold a renderer.
pub struct Packages {
    /// What pip is to install.
    pub requirements: &'static [&'static str],
    /// The oldest and the newest minor version of Python 3 that the package index has wheels for.
    pub pythons: (u32, u32),
    /// The Python module.
    pub module: &'static str,
}

/// A crate that holds a renderer; its version is that of the driver.
pub struct Crate {
    /// Its name in the registry of crates.
    pub name: &'static str,
    /// The program that it builds.
    pub program: &'static str,
    /// The oldest cargo and compiler, 1.x, that can build it.
    pub oldest: u32,
    /// What else `cargo install` is given.
    pub flags: &'static [&'static str],
    /// Variables of the environment in which it is built.
    pub environment: &'static [(&'static str, &'static str)],
}

/// Width, height and samples of all test scenes, and what they show: a constant environment of
/// radiance 1 behind two squares. The upper left quarter is an emitter of radiance (1, 2, 4). The
/// lower right quarter is a diffuse surface of reflectance (0.5, 0.25, 0.125), and has just that
/// radiance, since it sees only the environment. The other two quarters are the environment.
pub(crate) const TEST_SCENE: (usize, usize, u32) = (8, 8, 64);

/// One image to render.
#[derive(Clone)]
pub struct RenderRequest {
    /// With which renderer.
    pub driver: &'static Driver,
    /// The executable, if it is known; otherwise [`find`] looks for one.
    pub executable: Option<PathBuf>,
    /// The environment in which to look for one.
    pub env: Env,
    /// The cache in which to look for one.
    pub cache: Option<CachePaths>,
    /// The emitted folder; nothing is written there.
    pub folder: PathBuf,
    /// The file in it to start from, such as [`Driver::main_file`].
    pub main_file: String,
    /// Width that the scene asks for, in pixels; another image is refused.
    pub width: usize,
    /// Height that the scene asks for, in pixels; another image is refused.
    pub height: usize,
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Seed. Count from 0: different seeds give images without common random numbers, and those so
    /// large that this could not be kept are refused (Mitsuba has 16384 seeds at 128 by 128 pixels,
    /// 1024 at 512 by 512). Equal seeds give the same image where the renderer can do that. Mitsuba 0.x refuses any but 0, unless the
    /// sampler is `sobol`; pbrt-v3 and pbrt-r3 have seeds for path tracing, and pbrt-r3 renders `seed` images more for it.
    pub seed: u32,
    /// Threads; all processors if nothing is said.
    pub threads: Option<usize>,
    /// The longest time that it may take, with all that is asked of programs before, start and loading included.
    pub timeout: Option<Duration>,
    /// Where the whole output of the renderer goes; begun anew, its folder must exist.
    pub log: PathBuf,
    /// The renderer's variant, where it has several; its plainest if nothing is said.
    pub variant: Option<String>,
    /// Names of the features that the scene uses, for what the renderer is known to do wrong with them.
    pub features: Vec<String>,
    /// Further arguments of the program; renderers that run as a script of Python have none but `-m VARIANT`.
    pub options: Vec<String>,
    /// How the program is called, where that is not the driver's affair. It is then not asked for its version.
    pub call: Option<Call>,
    /// Becomes true when the caller no longer wants the image.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl RenderRequest {
    /// A request with the driver's main file and nothing optional, logged into `log`.
    #[must_use]
    pub fn new(driver: &'static Driver, folder: PathBuf, size: (usize, usize), log: PathBuf) -> Self {
        Self {
            driver,
            executable: None,
            env: Env::default(),
            cache: None,
            folder,
            main_file: driver.main_file.to_owned(),
            width: size.0,
            height: size.1,
            samples: 16,
            seed: 0,
            threads: None,
            timeout: None,
            log,
            variant: None,
            features: Vec::new(),
            options: Vec::new(),
            call: None,
            cancel: None,
        }
    }
}

/// News from a running renderer.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// It has started.
    Started {
        /// Its version, as it says.
        version: String,
    },
    /// The scene is loaded.
    Loaded {
        /// How long that took.
        seconds: f64,
    },
    /// Samples were taken.
    Samples {
        /// Samples per pixel up to now.
        done: u64,
        /// Samples per pixel at the end.
        total: u64,
        /// Rendering time up to now.
        seconds: f64,
    },
}

/// A rendered image.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Linear radiance.
    pub image: Image,
    /// Rendering time, without start and loading where the renderer tells them apart.
    pub seconds: f64,
    /// Time from start to end.
    pub wall_seconds: f64,
    /// The version, as the renderer says.
    pub renderer_version: String,
    /// Samples per pixel that were really taken; some samplers round up.
    pub samples_done: u64,
    /// The executable that was used.
    pub executable: PathBuf,
    /// The whole output of the renderer.
    pub log_path: PathBuf,
    /// What the renderer took.
    pub usage: Usage,
    /// What else there is to know of the image, by name; it goes into the provenance.
    pub facts: Vec<(String, String)>,
}

/// A request whose executable and folders are known.
pub(crate) struct Job<'a> {
    pub request: &'a RenderRequest,
    pub executable: &'a Path,
    /// The emitted folder, absolute.
    pub folder: &'a Path,
    /// The main file, absolute.
    pub main: &'a Path,
    /// An empty folder that is deleted afterwards.
    pub scratch: &'a Path,
}

/// What to run, and where the image will be.
pub(crate) struct Plan {
    pub command: Command,
    pub delivery: Delivery,
    /// Rows that the program's image has above those of the request; they are cut off.
    pub above: usize,
    /// What is known of the image before it is there; see [`Rendered::facts`].
    pub facts: Vec<(String, String)>,
}

/// How a renderer hands its image over.
pub(crate) enum Delivery {
    /// By events that name image files in the scratch folder, to be averaged by their samples.
    Events,
    /// As one image file, whose samples are those of the request; the function understands lines of its output.
    File(PathBuf, Listener),
}

/// Understands a line of a renderer's output.
pub(crate) type Listener = fn(&str) -> Option<Said>;

/// What a line of a renderer's output says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Said {
    /// The share of the image that is done, from 0 to 1; the first such line tells that the scene is loaded.
    Part(f64),
    /// How long the rendering took, in seconds.
    Took(f64),
}
