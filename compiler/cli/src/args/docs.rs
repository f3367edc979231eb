//! What people type for what is to be read: `ltsc explain`, `manual` and `doc`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Findings, Limits, share};

#[derive(Args, Debug)]
pub struct Explain {
    /// The code of a finding, or the name of a constructor, a statement or a function.
    pub what: Option<String>,
    /// What a target supports, and how exactly.
    #[arg(long, value_name = "TARGET")]
    pub target: Option<String>,
}

#[derive(Args, Debug)]
pub struct Manual {
    /// The page: `reference`, `findings`, `targets`.
    #[arg(conflicts_with = "output")]
    pub page: Option<String>,
    /// Write all pages into this folder, each as `<page>.md`.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write nothing; list files that are stale, and exit with 1 if there are any.
    #[arg(long, requires = "output")]
    pub check: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
}

/// How the pages of scenes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DocFormat {
    /// Markdown, as forges show it.
    Markdown,
    /// HTML that needs no network.
    Html,
}

#[derive(Args, Debug)]
pub struct Doc {
    /// Folders with scenes; or scene files, for their pages alone, without the table of all [default: the scenes of the project].
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// The folder to write [default: `docs/scenes` of the project].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// How pages are written.
    #[arg(long, value_enum, default_value_t = DocFormat::Markdown)]
    pub format: DocFormat,
    /// Write nothing; list files that are stale, and exit with 1 if there are any.
    #[arg(long, conflicts_with = "render")]
    pub check: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// Make pictures: of the references of a scene that are large enough, or else by Mitsuba 3 and LuxCore, as far as they are there.
    #[arg(long)]
    pub render: bool,
    /// The longer side of pictures in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub size: u32,
    /// Render pictures until the median noise of a pixel is at most this share (0.05, or 5%).
    #[arg(long, value_name = "SHARE", default_value = "5%", value_parser = share)]
    pub noise: f64,
    /// Spend about this many seconds on each picture; what is rendered stays in the cache, and the next run goes on.
    #[arg(long, value_name = "SECONDS", default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
    #[command(flatten)]
    pub limits: Limits,
    /// Files are read below this folder only [default: the project's root].
    #[arg(long, value_name = "DIR", env = "LTSC_ROOT")]
    pub root: Option<PathBuf>,
}

impl Doc {
    /// How findings are shown: to people, with the project's levels.
    pub fn findings(&self) -> Findings {
        Findings::plain(self.limits.clone(), self.root.clone())
    }
}
