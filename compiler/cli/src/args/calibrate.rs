//! What people type for `ltsc calibrate`.

use std::path::PathBuf;

use clap::Args;

use super::Answer;

#[derive(Args, Debug)]
pub struct Calibrate {
    /// Only these scenes: cbox_classic, ring, pool_simple, veach_mis.
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Write `calibration.json` and the page `calibration.md` into this folder; with `--only` the other scenes stay.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Render and count nothing; write the page of what is kept.
    #[arg(long, requires = "output", conflicts_with_all = ["only", "kept"])]
    pub stored: bool,
    /// Write nothing; say whether the page is stale, and exit with 1 if it is.
    #[arg(long, requires = "stored")]
    pub check: bool,
    /// Render nothing; count with the chunks that are there, and say what is missing.
    #[arg(long)]
    pub kept: bool,
    /// Chunks of each scene.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(2..=8192))]
    pub chunks: u32,
    /// Chunks of each variant of a scene.
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(2..=8192))]
    pub variant_chunks: u32,
    /// Pairs of one renderer for each scene; other kinds of trials are shares of it.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub pairs: u32,
    /// What the random numbers of the draws begin with.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Renderers at once, of one thread each [default: the processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub jobs: Option<u32>,
    /// Mitsuba 3's executable, or a Python that has its module: a path, or a name on the path.
    #[arg(long, value_name = "FILE")]
    pub executable: Option<PathBuf>,
    /// Stop the renderer after this many seconds for one chunk.
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub answer: Answer,
}
