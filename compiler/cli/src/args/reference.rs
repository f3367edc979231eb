//! What people type for `ltsc reference`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use ltsc_core::ir::Integrator;
use ltsc_evaluation::file::duration;

use super::{Answer, Findings, Limits, share};

#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Reference {
    #[command(subcommand)]
    pub action: Option<ReferenceAction>,
    /// The scene file.
    #[arg(required = true)]
    pub scene: Option<PathBuf>,
    /// The renderer, as `ltsc renderers list` names it: `mitsuba-3`, `luxcore`, `cycles`, `pbrt-r4`, ...
    #[arg(long, value_name = "NAME", required = true)]
    pub renderer: Option<String>,
    /// Render until the error is at most this share (0.005, or 0.5%).
    #[arg(long, value_name = "SHARE", default_value = "0.5%", value_parser = share)]
    pub error: f64,
    /// The algorithm [default: the scene's]: path, bidirectional, light_tracing, metropolis, photon_map.
    #[arg(long, value_name = "NAME", value_parser = integrator)]
    pub integrator: Option<&'static str>,
    /// The longer side of the image in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 128, value_parser = clap::value_parser!(u32).range(8..=4096))]
    pub size: u32,
    /// Segments of a path, the camera's and the light's included [default: the scene's].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_depth: Option<u32>,
    /// Begin no chunk after this time (10m, 90s, 2h); write what there is, and say what remains [default: none].
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub budget: Option<Duration>,
    /// The folder of references [default: `references` of the project].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over a reference of other size, algorithm or origin; keep also an image in which light tracing leaves smooth
    /// surfaces black.
    #[arg(long)]
    pub force: bool,
    /// The renderer's executable, or a Python that has its module: a path, or a name on the path.
    #[arg(long, value_name = "FILE")]
    pub executable: Option<PathBuf>,
    /// Threads [default: all].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Stop the renderer after this many seconds for one chunk.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: Option<u64>,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Subcommand, Debug)]
pub enum ReferenceAction {
    /// Show which references are there, how good they are, and which do not show their scene as it is now.
    #[command(
        after_help = "Examples:\n  ltsc reference list\n  ltsc reference list scenes-src/ring.lts --format json\n  ltsc reference list --renderer mitsuba-3,luxcore --check   (exit 1 if one is stale, damaged or missing)"
    )]
    List(ReferenceList),
    /// Keep an image from elsewhere as a reference, with the origin that you declare.
    ///
    /// The image is shown as declared wherever it is used; ltsc looks at its size only. The variance of its mean, if there is
    /// one, is taken from `--variance`, or
    /// from channels `variance.R`, `variance.G`, `variance.B` of the file, or `error.R` ... for the standard error.
    #[command(
        after_help = "Examples:\n  ltsc reference add ring.exr --scene scenes-src/ring.lts --renderer mitsuba-0.5 --by \"the thesis, 2020\"\n  ltsc reference add a.pfm --scene ring.lts --renderer measured --by \"J. Doe, camera 3\" --algorithm photograph"
    )]
    Add(ReferenceAdd),
}

#[derive(Args, Debug)]
pub struct ReferenceList {
    /// Scene files, or folders with scenes [default: those of the project].
    #[arg(value_name = "PATH")]
    pub scenes: Vec<PathBuf>,
    /// Only references of these renderers; those that are not there are listed as missing.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub renderer: Vec<String>,
    /// Exit with 1 where one is stale, damaged or without a scene, or one of a `--renderer` is missing.
    #[arg(long)]
    pub check: bool,
    /// The folder of references [default: `references` of the project].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub answer: Answer,
    #[command(flatten)]
    pub limits: Limits,
    /// Files are read below this folder only [default: the project's root].
    #[arg(long, value_name = "DIR", env = "LTSC_ROOT")]
    pub root: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct ReferenceAdd {
    /// The image: linear, OpenEXR or PFM, with the proportions of the scene's image.
    pub file: PathBuf,
    /// The scene file.
    #[arg(long, value_name = "FILE")]
    pub scene: PathBuf,
    /// The renderer or target that it stands for, or another word of small letters, digits, `-`, `_` and `.`.
    #[arg(long, value_name = "NAME")]
    pub renderer: String,
    /// Who or what it is from.
    #[arg(long, value_name = "TEXT")]
    pub by: String,
    /// The algorithm, as they call it.
    #[arg(long, value_name = "TEXT")]
    pub algorithm: Option<String>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub samples: Option<u64>,
    /// The variance of the mean in each pixel, in another file.
    #[arg(long, value_name = "FILE")]
    pub variance: Option<PathBuf>,
    /// Segments of its longest paths [default: the scene's].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_depth: Option<u32>,
    /// The folder of references [default: `references` of the project].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write over a reference that is there.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub answer: Answer,
    #[command(flatten)]
    pub limits: Limits,
    /// Files are read below this folder only [default: the project's root].
    #[arg(long, value_name = "DIR", env = "LTSC_ROOT")]
    pub root: Option<PathBuf>,
}

impl ReferenceList {
    /// How findings are shown: to people, with the project's levels.
    pub fn findings(&self) -> Findings {
        Findings::plain(self.limits.clone(), self.root.clone())
    }
}

impl ReferenceAdd {
    /// How findings are shown: to people, with the project's levels.
    pub fn findings(&self) -> Findings {
        Findings::plain(self.limits.clone(), self.root.clone())
    }
}

fn integrator(text: &str) -> Result<&'static str, String> {
    let known = Integrator::WORDS.into_iter().find(|word| *word == text);
    known.ok_or_else(|| match ltsc_core::diag::nearest(text, Integrator::WORDS) {
        Some(near) => format!("there is no algorithm of this name: did you mean `{near}`?"),
        None => format!("known: {}", Integrator::WORDS.join(", ")),
    })
}

fn time(text: &str) -> Result<Duration, String> {
    duration(text).ok_or_else(|| "write seconds, or a time such as `90s`, `10m` or `2h`".to_owned())
}
