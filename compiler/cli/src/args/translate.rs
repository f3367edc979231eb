//! Arguments of the commands that turn one scene into another form.

use std::path::PathBuf;

use clap::Args;

use super::{Findings, Settings, share};

#[derive(Args, Debug)]
pub struct Import {
    /// The scene of another program.
    #[arg(required_unless_present = "survey")]
    pub scene: Option<PathBuf>,
    /// Write nothing; read all scenes of other programs below a folder, and print what they hold, how many convert with no
    /// `loss-dropped`, and what stands in the way. Files are read below this folder only, or below `--root`.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scene", "output", "set", "force"])]
    pub survey: Option<PathBuf>,
    /// The text, or the folder for it; meshes and images go into a folder of its name beside it [default: the scene's name here].
    #[arg(short, long, value_name = "FILE.lts|DIR")]
    pub output: Option<PathBuf>,
    /// The value of a parameter that the file declares (`<default>` of Mitsuba); may be given several times.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Write also over a text that is there, and over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Equiv {
    /// The reference.
    pub a: PathBuf,
    /// The scene compared with it.
    pub b: PathBuf,
    /// What counts as equal: a share of numbers and colors, and for places of the size of the scene, or of the surface's largest
    /// coordinate where that is smaller; ten times as much for normals.
    #[arg(long, value_name = "SHARE", default_value_t = ltsc_core::equiv::TOLERANCE, value_parser = share)]
    pub tolerance: f64,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Emit {
    /// The scene file.
    pub scene: Option<PathBuf>,
    /// The target: mitsuba-3, mitsuba-0.6, mitsuba-0.5, pbrt-v4, pbrt-v3, luxcore, cycles, gltf or glb.
    #[arg(long, value_name = "TARGET", default_value = "", hide_default_value = true)]
    pub target: String,
    /// An option of a target, such as `gltf.instancing`; `ltsc explain --target NAME` lists them.
    #[arg(long, value_name = "TARGET.OPTION", value_delimiter = ',')]
    pub option: Vec<String>,
    /// The folder to write [default: `./<scene>-<target>`].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub findings: Findings,
}
