//! What people type for `ltsc eval`, and for what shows and removes its results or looks for the cause of what they say.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::{Answer, Findings, Settings, share};

#[derive(Args, Debug)]
pub struct Eval {
    /// The evaluation file.
    #[arg(value_name = "FILE.toml", required_unless_present = "from_lteval")]
    pub file: Option<PathBuf>,
    /// Print a configuration of the thesis's tool as an evaluation file; it is read, and not run.
    #[arg(long, value_name = "CFG.py", conflicts_with_all = ["file", "dry_run", "output", "set", "keep_going"])]
    pub from_lteval: Option<PathBuf>,
    /// The folder of the results [default: what the file says, `results/NAME DATE` beside it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// Say what would be rendered and how long it takes, and render nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Make the page of the results for a browser, whatever the file says.
    #[arg(long)]
    pub page: bool,
    /// Go on with the other cases where one fails.
    #[arg(long)]
    pub keep_going: bool,
    /// When files written for renderers are left out of the results: where a case succeeds, always, or never.
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = CleanWhen::Success)]
    pub clean: CleanWhen,
    /// Values of a parameter of the scenes, each of which makes a condition; may be given several times.
    #[arg(long, value_name = "NAME=VALUE,...")]
    pub set: Vec<String>,
    /// Renderers at once; they share the processors.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: u32,
    /// Memory for all renderers at once, in gigabytes [default: what the machine has].
    #[arg(long, value_name = "GB", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub memory: Option<u64>,
    /// For times that can be compared: renderers run one at a time, and what was rendered beside others is rendered again.
    #[arg(long, conflicts_with_all = ["jobs", "executor"])]
    pub timing: bool,
    /// Who renders: `local` (this machine) or `slurm` (a cluster).
    #[arg(long, value_name = "NAME", default_value = "local")]
    pub executor: String,
    /// The folder that all machines of a cluster share.
    #[arg(long, value_name = "DIR")]
    pub shared: Option<PathBuf>,
    /// A word for the executor, such as `--option=--partition=short` for Slurm; may be given several times.
    #[arg(long, value_name = "WORD", allow_hyphen_values = true)]
    pub option: Vec<String>,
    /// Allow the programs that the file names to run, now and later.
    #[arg(long)]
    pub trust: bool,
    /// Exit with 1 also where agreement is undecided.
    #[arg(long)]
    pub require_agree: bool,
    #[command(flatten)]
    pub findings: Findings,
}

/// When files written for renderers are left out of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CleanWhen {
    /// Where a case succeeds.
    Success,
    /// Always.
    Always,
    /// Never.
    Never,
}

#[derive(Args, Debug)]
pub struct Report {
    /// The folder of the results, or of images.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Start a browser with the page.
    #[arg(long)]
    pub open: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub answer: Answer,
}

#[derive(Args, Debug)]
pub struct View {
    /// OpenEXR or PFM files.
    #[arg(value_name = "IMAGE", required = true)]
    pub files: Vec<PathBuf>,
    /// The folder of the page.
    #[arg(short, long, value_name = "DIR", default_value = "view")]
    pub output: PathBuf,
    /// Start a browser with the page.
    #[arg(long)]
    pub open: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub answer: Answer,
}

#[derive(Args, Debug)]
pub struct Serve {
    /// The folder of the results, or of a page.
    #[arg(value_name = "DIR", default_value = ".")]
    pub folder: PathBuf,
    /// The port [default: one that is free].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Start a browser with the page.
    #[arg(long)]
    pub open: bool,
    #[command(flatten)]
    pub answer: Answer,
}

#[derive(Args, Debug)]
pub struct Clean {
    /// Folders of results, or folders with such folders [default: `results` in this folder].
    #[arg(value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Keep so many of the newest results of each evaluation.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub keep: usize,
    /// Remove the files of failed cases only; results stay.
    #[arg(long)]
    pub files: bool,
    /// Say what would be removed, and remove nothing.
    #[arg(long)]
    pub dry_run: bool,
    #[command(flatten)]
    pub answer: Answer,
}

#[derive(Args, Debug)]
pub struct Reduce {
    /// The scene file.
    pub scene: PathBuf,
    /// The two renderers, the reference first.
    #[arg(long, value_name = "A,B", value_delimiter = ',', required = true)]
    pub renderer: Vec<String>,
    /// The folder to write [default: `./<scene>-reduced`].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// Width and height of the images in pixels, where `--width` and `--height` say nothing.
    #[arg(long, value_name = "PIXELS", default_value_t = 64, value_parser = clap::value_parser!(u32).range(8..=4096))]
    pub size: u32,
    /// How much a tile may differ in each channel (0.05 is 5 %), plus the bounds that targets state for the scene.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share)]
    pub tolerance: f64,
    /// How much the whole image may differ in each channel, plus the same bounds.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub mean_tolerance: f64,
    /// Tiles along each side of the image.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = PossibleValuesParser::new(["1", "2", "4", "8"]).try_map(|text| text.parse::<u32>()))]
    pub tiles: u32,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub findings: Findings,
}
