//! The command line: what people type, with examples.

mod calibrate;
mod docs;
mod eval;
mod reference;
mod translate;

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

pub use calibrate::Calibrate;
pub use docs::{Doc, DocFormat, Explain, Manual};
pub use eval::{Clean, CleanWhen, Eval, Reduce, Report, Serve, View};
pub use reference::{Reference, ReferenceAction, ReferenceAdd, ReferenceList};
pub use translate::{Emit, Equiv, Import};

const EXIT_CODES: &str = "\
Exit codes:
   0  done, or the answer is yes
   1  the answer is no: findings at `deny`, stale files, a difference beyond the tolerance
   2  wrong usage
   3  an input that cannot be read, or is malformed
   4  a renderer or the environment is missing or failed
  70  an internal error (a bug in ltsc)";

/// Compiler and translator for light-transport test scenes.
///
/// Scenes are written once, in `.lts`, checked against what renderers agree on, and generated for Mitsuba, PBRT, LuxCore,
/// Cycles and glTF; real renderers say where their images agree.
#[derive(Parser, Debug)]
#[command(name = "ltsc", version, after_help = EXIT_CODES, max_term_width = 110, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
    /// Colors: by default on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, value_enum, default_value_t = Choice::Auto, value_name = "WHEN", display_order = 1000)]
    pub color: Choice,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Choice {
    Auto,
    Always,
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// With excerpts of the scene.
    Human,
    /// One line a finding.
    Short,
    /// One JSON document.
    Json,
    /// A SARIF 2.1.0 log of the findings, for code scanning.
    Sarif,
    /// GitHub's workflow commands, which become annotations of a commit.
    Github,
}

/// The forms of commands whose answer is no list of findings. The others may stand in `LTSC_FORMAT`, and are taken for the one for people.
fn answer() -> impl TypedValueParser<Value = Format> {
    let shown = [("human", "For people"), ("short", "A line for each result"), ("json", "One JSON document")];
    let hidden = ["sarif", "github"].map(|name| PossibleValue::new(name).hide(true));
    let all = shown.into_iter().map(|(name, help)| PossibleValue::new(name).help(help)).chain(hidden);
    PossibleValuesParser::new(all.collect::<Vec<_>>()).try_map(|word| Format::from_str(&word, false))
}

/// The command line as clap knows it.
pub fn command() -> clap::Command {
    let form = |command: clap::Command| {
        command.mut_arg("format", |format| format.value_parser(answer()).help("How the result is printed"))
    };
    let mut command = Arguments::command();
    let names: Vec<String> = command.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    // One that is changed goes to the end, so that all of them go there in their order.
    for name in names {
        let own = matches!(name.as_str(), "agree" | "equiv" | "eval" | "reduce" | "reference" | "similar");
        command = command.mut_subcommand(name, |one| if own { form(one) } else { one });
    }
    command
}

/// Reads the command line; a form that a command does not have is refused.
///
/// # Errors
/// What clap says of it.
pub fn parse() -> Result<Arguments, clap::Error> {
    let mut command = command();
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
    if let Some(problem) = unfit(&matches) {
        return Err(command.error(ErrorKind::ArgumentConflict, problem));
    }
    Arguments::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Why the command does not have the form that the command line asks for. `LTSC_FORMAT` is for many commands, and leaves those that do
/// not have its form as they are.
fn unfit(matches: &ArgMatches) -> Option<String> {
    let (mut name, mut inner) = matches.subcommand()?;
    while let Some((below, deeper)) = inner.subcommand() {
        (name, inner) = (below, deeper);
    }
    let format = *inner.try_get_one::<Format>("format").ok()??;
    if inner.value_source("format") != Some(ValueSource::CommandLine) {
        return None;
    }
    let flag = |name: &str| inner.try_get_one::<bool>(name).ok().flatten().copied().unwrap_or(false);
    let findings = matches!(format, Format::Sarif | Format::Github);
    let answers = [
        "diff",
        "equiv",
        "agree",
        "eval",
        "clean",
        "reduce",
        "similar",
        "list",
        "add",
        "reference",
        "conventions",
        "calibrate",
    ];
    if answers.contains(&name) && findings {
        return Some(format!(
            "`{format}` is for findings, and `{name}` gives another answer: it has human, short and json"
        ));
    }
    let only = ["stats", "diff"].into_iter().find(|one| flag(one)).filter(|_| format != Format::Human)?;
    Some(format!("`--{only}` gives a text for people, not `{format}`"))
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Human => "human",
            Self::Short => "short",
            Self::Json => "json",
            Self::Sarif => "sarif",
            Self::Github => "github",
        })
    }
}

impl Format {
    /// Whether a command prints one document of this form, and not line by line.
    pub fn is_document(self) -> bool {
        matches!(self, Self::Json | Self::Sarif)
    }
}

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Make a new project: an `ltsc.toml` and a first scene.
    #[command(after_help = "Example:\n  ltsc init scenes\n  cd scenes\n  ltsc lint\n  ltsc build")]
    Init(Init),
    /// Generate every scene for every target.
    ///
    /// Without PATH the project that the current folder belongs to: the nearest folder upward with an `ltsc.toml`. Files
    /// that are already as they should be are not touched.
    #[command(
        after_help = "Examples:\n  ltsc build\n  ltsc build scenes-src\n  ltsc build scenes-src/ring.lts --target pbrt\n  ltsc build --check"
    )]
    Build(Build),
    /// Check scenes: errors, and what renderers do not agree on.
    #[command(
        after_help = "Examples:\n  ltsc lint\n  ltsc lint scenes-src/ring.lts --format short\n  ltsc lint --deny warnings --format github\n  ltsc lint --format sarif > ltsc.sarif\n  ltsc lint --target pbrt-v4 --deny loss-approximated\n  ltsc lint --fix            (--diff shows what it would change)\n  ltsc explain smooth-emitter"
    )]
    Lint(Lint),
    /// Format scenes and libraries.
    ///
    /// Comments stay, numbers stay as written, the meaning never changes. Without PATH the scenes of the project that the
    /// current folder belongs to; `-` reads standard input and writes standard output.
    #[command(
        after_help = "Examples:\n  ltsc fmt\n  ltsc fmt scenes-src/ring.lts\n  ltsc fmt --check          (exit 1 where something would change)\n  ltsc fmt --check --format github\n  ltsc fmt - < draft.lts > ring.lts"
    )]
    Fmt(Fmt),
    /// Find scenes of the project that test similar light paths.
    ///
    /// The score compares the classes of light paths (half of it), the materials (a quarter), and the words of the briefs (a
    /// quarter). From 0.5 on, or where the briefs alone reach 0.6, two scenes are near: the scene should say in `similar` why both
    /// are kept. From 0.9 on one of them may be enough. SCENE may be a draft anywhere below the project's root.
    #[command(
        after_help = "Examples:\n  ltsc similar scenes-src/cboxm_diffuse_lvar.lts\n  ltsc similar draft.lts --all\n  ltsc similar draft.lts --format json"
    )]
    Similar(Similar),
    /// Read a scene of another program, and write it as a scene of ltsc: a text to be edited, with its meshes and images.
    ///
    /// Everything that the file says and the text does not, or not in the same way, is told with its place. `lint`, `render`, `emit`
    /// (also called `convert`) and `similar` take such files as they are. `--set` gives values to parameters that the file declares.
    #[command(
        after_help = "Examples:\n  ltsc import scene.xml                       (writes NAME.lts, and a folder NAME beside it)\n  ltsc import kitchen/scene.xml -o scenes-src/kitchen.lts\n  ltsc import scene.xml --set spp=64 --deny loss-dropped\n  ltsc import --survey downloads              (what a folder of scenes holds, and what converts)\n  ltsc convert scene.xml --target pbrt-v4 -o out"
    )]
    Import(Import),
    /// Compare two scenes in any formats: whether they mean the same. A is the reference.
    ///
    /// Cameras, film, integrator and sampler, lights, and surfaces by where they lie in the scene, with what they are made of and what
    /// they emit to which side. Names, order and groups mean nothing, nor how triangles are shared out among shapes. What a reader could
    /// not put into one scene is a difference where it is not said of the other. Exit code 1: they differ.
    #[command(
        after_help = "Examples:\n  ltsc equiv scene.xml scene.pbrt\n  ltsc equiv scenes-src/ring.lts old/ring.xml --tolerance 0.1%\n  ltsc equiv a.lts b.lts --format json"
    )]
    Equiv(Equiv),
    /// Write a scene for one target, as one self-contained folder.
    ///
    /// Without SCENE every scene of the project, as `build` does, for this target only.
    #[command(
        after_help = "Examples:\n  ltsc emit scenes-src/ring.lts --target pbrt\n  ltsc emit ring.lts --target glb -o /tmp/ring --width 128 --height 128\n  ltsc emit ring.lts --target glb --option glb.instancing\n  ltsc emit --target mitsuba-3\n  ltsc convert scene.xml --target pbrt-v4 -o out     (a scene of another program)"
    )]
    #[command(visible_alias = "convert")]
    Emit(Emit),
    /// Check generated files against the scene: light, materials, camera, depth, size.
    ///
    /// `build` and `emit` do this with what they write, and keep nothing that differs. `audit` is for files that exist: it reads them,
    /// prints what they say beside what the scene says, and exits with 1 where they differ. Without PATH the scenes
    /// of the project that the current folder belongs to.
    #[command(
        after_help = "Examples:\n  ltsc audit\n  ltsc audit scenes-src/ring.lts --target pbrt-v4,luxcore\n  ltsc audit scenes-src/ring.lts --format json\n  ltsc audit ring.lts --target gltf --folder ring-gltf    (a folder that `emit` wrote)"
    )]
    Audit(Audit),
    /// Render a scene with a real renderer to a linear 32-bit EXR.
    #[command(
        after_help = "Examples:\n  ltsc renderers install mitsuba-3\n  ltsc render scenes-src/cbox_classic.lts --renderer mitsuba-3 --samples 512 -o a.exr\n  ltsc render cbox_classic.lts --renderer luxcore --width 128 --height 128 -o b.exr\n  ltsc render cbox_classic.lts --renderer pbrt-v3 --executable ~/pbrt-v3/build/pbrt -o c.exr"
    )]
    Render(Render),
    /// Compare two images; A is the reference.
    ///
    /// Prints metrics of light (means, errors) and of what a person sees (PSNR, SSIM, FLIP, HDR-FLIP), in all and in red, green and
    /// blue where they have channels; ratios of means in a grid of tiles; and the shift that moves B onto A. Equal images have no
    /// PSNR, since it is infinite; `-` and null stand for what has no value. `--format short` measures and prints ratios only.
    #[command(after_help = crate::commands::diff::help(false), after_long_help = crate::commands::diff::help(true))]
    Diff(Diff),
    /// Test whether renderers agree on scenes, beyond the noise of their images.
    ///
    /// Renders each scene in each renderer with several seeds, and compares them in pairs: the means, and the tiles of an 8 x 8 grid
    /// against the noise that the seeds show. With `--record` the results are kept, and a page is made of them.
    #[command(
        after_help = "Examples:\n  ltsc agree scenes-src/ring.lts\n  ltsc agree scenes-src/ring.lts --renderer mitsuba-3,cycles --seeds 8 --samples 128\n  ltsc agree --keep images --record docs/agreement.json\n  ltsc agree --check --record docs/agreement.json    (exit 1 if the page is stale)"
    )]
    Agree(Agree),
    /// Carry out an evaluation: render test cases, compare their images, and write what follows.
    ///
    /// Everything that the file says is checked before anything is rendered. Images are rendered in chunks, which the cache keeps: a run
    /// that is ended goes on where it was, and what was rendered once is not rendered again. The results are a folder with images,
    /// tables (summary.md, images.csv, comparisons.csv), results.json and timing.json.
    #[command(
        after_help = "Examples:\n  ltsc eval scenes-src/eval/minimal.toml\n  ltsc eval basic.toml --dry-run              (what would be rendered, and how long it takes)\n  ltsc eval sweep.toml --set lamp_side=5,20,80\n  ltsc eval all.toml --keep-going --jobs 2\n  ltsc eval all.toml --executor slurm --shared /mnt/shared --option=--partition=short\n  ltsc eval --from-lteval cfg.py > cfg.toml   (a configuration of the thesis's tool)"
    )]
    Eval(Box<Eval>),
    /// Make a page for a browser of a folder of results: all images in full range, comparisons, verdicts, plots.
    ///
    /// The folder is one that `ltsc eval` wrote, perhaps with images that were put there by hand, or any folder with OpenEXR and PFM
    /// images: `scenes/SCENE/CASE.exr`, `references/SCENE/NAME.exr`, or folders of any other name, each of which is a scene. The page is
    /// written into `DIR/page`; it opens from the disk, and needs no server and no network.
    #[command(
        after_help = "Examples:\n  ltsc report results/basic\n  ltsc report images --open\n  ltsc report results/basic --format json"
    )]
    Report(Report),
    /// Make a page for a browser of loose images; the first is what the others are compared with.
    #[command(
        after_help = "Examples:\n  ltsc view a.exr b.exr\n  ltsc view reference.exr 16.exr 64.exr 256.exr -o compared --open"
    )]
    View(View),
    /// Show a page that was made to browsers of this machine, from an address instead of the disk.
    ///
    /// A page needs no server; this is for browsers that may not read the disk, and for machines that are reached through a tunnel. Only
    /// this machine is answered, files below the folder are all that it can read, and it ends with Ctrl-C.
    #[command(
        after_help = "Examples:\n  ltsc serve results/basic --open\n  ltsc serve results/basic --port 8000\n  ssh -L 8000:127.0.0.1:8000 host ltsc serve results/basic --port 8000"
    )]
    Serve(Serve),
    /// Remove results of earlier evaluations.
    ///
    /// Nothing but files that ltsc wrote and nobody has changed since is removed, and of each evaluation the newest results stay.
    #[command(
        after_help = "Examples:\n  ltsc clean results --dry-run\n  ltsc clean results\n  ltsc clean results --keep 3\n  ltsc clean results --files    (only the files of failed cases)"
    )]
    Clean(Clean),
    /// Keep an image of a scene with its error, as what others are compared with.
    ///
    /// Renders the scene with one renderer until the median standard error of the 8 x 8 tiles is at most `--error` of their means (of a
    /// tenth of the image's mean in tiles darker than that), and keeps the mean and its standard error as `references/SCENE/RENDERER.exr` of the project. What was rendered stays
    /// in the cache in chunks: a run that is ended, by `--budget` or by you, goes on where it was. Exit code 1: not yet good enough.
    #[command(
        after_help = "Examples:\n  ltsc reference scenes-src/cbox_classic.lts --renderer mitsuba-3\n  ltsc reference scenes-src/ring.lts --renderer mitsuba-3 --integrator light_tracing --error 1% --budget 10m\n  ltsc reference list --check                    (exit 1 if one is stale)\n  ltsc reference add ring.exr --scene scenes-src/ring.lts --renderer mitsuba-0.5 --by \"the thesis, 2020\""
    )]
    Reference(Reference),
    /// Make a scene as small as it can be while two renderers still differ on it.
    ///
    /// Takes out surfaces, instances and lights, makes materials plainer and paths shorter, and renders what is left after each step. The
    /// result is a folder to attach to a report of the fault: the scene for both renderers, images, verdict, versions. Exit code 1: they do not differ.
    #[command(
        after_help = "Examples:\n  ltsc reduce scenes-src/surfaces.lts --renderer mitsuba-3,cycles\n  ltsc reduce scene.lts --renderer mitsuba-3,luxcore --samples 4096 --size 32 -o report"
    )]
    Reduce(Box<Reduce>),
    /// List and install renderers.
    Renderers(Renderers),
    /// Show what the user's cache holds, and remove what is old: renderings in chunks, and installations.
    ///
    /// Images that `eval` and `reference`, and `render` with many samples, take apart into chunks are kept there by what was rendered, so that nothing is
    /// rendered twice. All of it can be made again. The folder is $LTSC_CACHE, else the cache folder of the user.
    #[command(
        after_help = "Examples:\n  ltsc cache\n  ltsc cache prune --days 30\n  ltsc cache prune --days 0   (all chunks)"
    )]
    Cache(Cache),
    /// Test a renderer's conventions with micro-scenes of known answers.
    ///
    /// Each tests one convention: the axis of the field of view, the side that a lamp shines from, how the depth of paths is counted,
    /// Fresnel terms, and so on. The answer is a formula, a quadrature, or a measurement. A row `holds`, is `approximate` (off by no
    /// more than `ltsc explain --target NAME` says), `unsupported` (the target does not have it), or `fails`; if one fails, the exit
    /// code is 1.
    #[command(
        after_help = "Examples:\n  ltsc conventions --list\n  ltsc conventions --renderer mitsuba-3\n  ltsc conventions --renderer luxcore --only path_depth,conductor_alpha\n  ltsc conventions --renderer cycles --executable blender --format json\n  ltsc conventions --renderer mitsuba-3,luxcore,cycles -o docs   (keeps the numbers, writes docs/renderers.md)\n  ltsc conventions -o docs --stored --check   (exit 1 if the page is stale)"
    )]
    Conventions(Conventions),
    /// Count how often the verdict of `agree` and `eval` is wrong, for people who change its statistics.
    ///
    /// Pairs of images are drawn from pools of chunks of real renderings (Mitsuba 3, 64 x 64 pixels, 16 samples), with something planted in
    /// one of them or not, and the verdicts are counted. It needs ltsc's own scenes. Chunks are kept in the cache, so that a run that is
    /// ended goes on; the first one renders for half an hour and more on two cores. Counting takes four minutes of one core for a
    /// scene in a build without optimization, half a minute with it.
    #[command(
        after_help = "Examples:\n  ltsc calibrate -o docs   (counts, writes docs/calibration.json and docs/calibration.md)\n  ltsc calibrate --only ring -o docs\n  ltsc calibrate --only cbox_classic --kept --pairs 200   (a quick look, with what was rendered before)\n  ltsc calibrate -o docs --stored --check   (exit 1 if the page is stale)"
    )]
    Calibrate(Calibrate),
    /// Explain a finding, a word of the language, or a target.
    #[command(
        after_help = "Examples:\n  ltsc explain smooth-emitter\n  ltsc explain diffuse\n  ltsc explain --target luxcore\n  ltsc explain            (lists what can be explained)"
    )]
    Explain(Explain),
    /// Generate the scene catalog: a page for each scene, and a table of the light paths that they test.
    ///
    /// A page has the scene's documentation, a line drawing, its numbers, lights and materials, and pictures where they were made:
    /// of its references (`ltsc reference`), or by Mitsuba 3 and LuxCore. Without PATH the scenes of the project that the current folder belongs to.
    #[command(
        after_help = "Examples:\n  ltsc doc\n  ltsc doc --format html -o site\n  ltsc doc --render            (pictures again, by the renderers that are there)\n  ltsc doc --check             (exit 1 if a page is stale)"
    )]
    Doc(Doc),
    /// Print the reference manual in Markdown, or write it.
    ///
    /// Made from the tables that the compiler itself runs on: the language with every constructor, the findings, the targets.
    #[command(
        after_help = "Examples:\n  ltsc manual                  (lists the pages)\n  ltsc manual reference | less\n  ltsc manual -o docs\n  ltsc manual -o docs --check  (exit 1 if a file is stale)"
    )]
    Manual(Manual),
    /// Render one chunk of a list, as a task of a cluster.
    #[command(hide = true)]
    Task(Task),
    /// Print the completions of a shell.
    #[command(after_help = "Example:\n  ltsc completions bash > ~/.local/share/bash-completion/completions/ltsc")]
    Completions {
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
}

/// How an answer that is no list of findings is printed.
#[derive(Args, Clone, Copy, Debug)]
pub struct Answer {
    /// How the result is printed.
    #[arg(long, value_parser = answer(), default_value_t = Format::Human, env = "LTSC_FORMAT")]
    pub format: Format,
}

/// How findings are judged and shown.
#[derive(Args, Clone, Debug)]
pub struct Findings {
    /// How findings are printed; `sarif` and `github` are for systems that show them in code.
    #[arg(long, value_enum, default_value_t = Format::Human, env = "LTSC_FORMAT")]
    pub format: Format,
    /// Accept findings: a code, `all` for every rule, or `warnings`. Also LTSC_ALLOW.
    #[arg(long, value_name = "CODE", value_delimiter = ',')]
    pub allow: Vec<String>,
    /// Report findings as warnings. Also LTSC_WARN.
    #[arg(long, value_name = "CODE", value_delimiter = ',')]
    pub warn: Vec<String>,
    /// Report findings and fail. Also LTSC_DENY. The command line overrides the variables, and these override ltsc.toml.
    #[arg(long, value_name = "CODE", value_delimiter = ',')]
    pub deny: Vec<String>,
    /// Ignore the `allow` statements of scenes.
    #[arg(long)]
    pub no_allow: bool,
    #[command(flatten)]
    pub limits: Limits,
    /// Files are read below this folder only [default: the project's root].
    #[arg(long, value_name = "DIR", env = "LTSC_ROOT")]
    pub root: Option<PathBuf>,
}

impl Findings {
    /// The same where only errors matter: no rule is asked.
    pub fn unlinted(&self) -> Self {
        let allow = vec!["all".to_owned(), "warnings".to_owned()];
        Self { allow, warn: Vec::new(), deny: Vec::new(), ..self.clone() }
    }

    /// For people, with the project's levels.
    fn plain(limits: Limits, root: Option<PathBuf>) -> Self {
        let (allow, warn, deny) = (Vec::new(), Vec::new(), Vec::new());
        Self { format: Format::Human, allow, warn, deny, no_allow: false, limits, root }
    }
}

/// How large scenes may become.
#[derive(Args, Clone, Debug)]
pub struct Limits {
    /// Raise or lower a limit: text, file, memory (bytes, also as 64MiB), list, pixels, steps, triangles, instances; may be given
    /// several times.
    #[arg(long, value_name = "NAME=N")]
    pub limit: Vec<String>,
}

/// Settings that replace the scene's own.
#[derive(Args, Debug)]
pub struct Settings {
    /// Width of the image in pixels.
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub width: Option<u32>,
    /// Height of the image in pixels.
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub height: Option<u32>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: Option<u32>,
    /// Segments of a path, the camera's and the light's included.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_depth: Option<u32>,
    /// Start of the random numbers.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u32>,
    /// The value of a parameter that the scene declares by `param`; may be given several times.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// The camera to look through [default: the first].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
}

#[derive(Args, Debug)]
pub struct Task {
    /// The list, which the ltsc that waits has written.
    pub list: PathBuf,
    /// Which of its tasks.
    pub index: usize,
}

#[derive(Args, Debug)]
pub struct Init {
    /// The folder of the project [default: the current folder]; it is made if it is not there.
    pub folder: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub struct Build {
    /// Scene files, or folders with scenes [default: those of the project].
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Write nothing; list files that are stale, and exit with 1 if there are any.
    #[arg(long)]
    pub check: bool,
    /// Only these targets [default: those of ltsc.toml, else all].
    #[arg(long, value_name = "TARGET", value_delimiter = ',')]
    pub target: Vec<String>,
    /// An option of a target, such as `gltf.instancing`; `ltsc explain --target NAME` lists them.
    #[arg(long, value_name = "TARGET.OPTION", value_delimiter = ',')]
    pub option: Vec<String>,
    /// Write below this folder [default: that of ltsc.toml, else `generated` beside the scenes].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// The value of a parameter that the scene declares by `param`, for one scene; may be given several times.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Write nothing; print how long each scene takes and how many bytes it becomes, as a table in Markdown.
    #[arg(long, conflicts_with_all = ["check", "output", "force"])]
    pub stats: bool,
    /// Show all warnings and losses, also those that an earlier build has shown.
    #[arg(short, long)]
    pub verbose: bool,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Lint {
    /// Scene files, or folders with scenes [default: those of the project].
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Fix findings that have one right answer; nothing else in the scenes changes.
    #[arg(long)]
    pub fix: bool,
    /// Write nothing; show what `--fix` would change, and exit with 1 if it would.
    #[arg(long)]
    pub diff: bool,
    /// Check for these targets only, and report what they approximate or do not support.
    #[arg(long, value_name = "TARGET", value_delimiter = ',')]
    pub target: Vec<String>,
    /// The value of a parameter that the scene declares by `param`, for one scene; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", conflicts_with_all = ["fix", "diff"])]
    pub set: Vec<String>,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Fmt {
    /// Files, or folders with `.lts` files; `-` for standard input [default: the scenes of the project].
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Write nothing; exit with 1 and name the files that would change.
    #[arg(long)]
    pub check: bool,
    /// Write nothing; show what would change, and exit with 1 if something would.
    #[arg(long)]
    pub diff: bool,
    /// How errors are printed, and with `--check` the files that would change.
    #[arg(long, value_enum, default_value_t = Format::Human, env = "LTSC_FORMAT")]
    pub format: Format,
    #[command(flatten)]
    pub limits: Limits,
}

#[derive(Args, Debug)]
pub struct Similar {
    /// The scene file.
    pub scene: PathBuf,
    /// Show the scenes that are not near, too.
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Audit {
    /// Scene files, or folders with scenes [default: those of the project].
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Only these targets [default: those of ltsc.toml, else all, as far as they were generated].
    #[arg(long, value_name = "TARGET", value_delimiter = ',')]
    pub target: Vec<String>,
    /// Where scenes were generated [default: that of ltsc.toml, else `generated` beside the scenes].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// A folder that `emit` wrote, for one scene and one target.
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    pub folder: Option<PathBuf>,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Render {
    /// The scene file.
    pub scene: PathBuf,
    /// The renderer, as `ltsc renderers list` names it: `mitsuba-3`, `luxcore`, `cycles`, `pbrt-r4`, `pbrt-r3`, `pbrt-v4`, `pbrt-v3`,
    /// `mitsuba-0.6`, `mitsuba-0.5`.
    #[arg(long, value_name = "NAME")]
    pub renderer: String,
    /// The image to write.
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: PathBuf,
    /// Write over an image or a log that is there.
    #[arg(long)]
    pub force: bool,
    /// The renderer's executable, or a Python that has its module: a path, or a name on the path.
    #[arg(long, value_name = "FILE")]
    pub executable: Option<PathBuf>,
    /// Threads [default: all].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Stop the renderer after this many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: Option<u64>,
    /// Where the renderer's log is kept [default: beside the image, `.log` appended].
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub findings: Findings,
}

#[derive(Args, Debug)]
pub struct Diff {
    /// The reference.
    pub a: PathBuf,
    /// The image compared with it.
    pub b: PathBuf,
    /// Write the signed difference (green: B brighter, red: B dimmer) as difference.png, and diff.json, into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// Tiles along each side.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub tiles: u32,
    /// Brightness of the difference picture in stops.
    #[arg(long, value_name = "STOPS", default_value_t = 5.0, allow_hyphen_values = true)]
    pub exposure: f32,
    /// Reduce the larger image to the size of the smaller one by averaging whole blocks of pixels.
    #[arg(long)]
    pub reduce: bool,
    /// Leave out pixels that are not finite in either image, instead of refusing them.
    #[arg(long)]
    pub mask_nonfinite: bool,
    /// Exit with 1 if a channel's mean or a tile differs by more than this share (0.02 is 2 %).
    #[arg(long, value_name = "SHARE")]
    pub tolerance: Option<f64>,
    #[command(flatten)]
    pub answer: Answer,
}

#[derive(Args, Debug)]
pub struct Agree {
    /// Scene files, or folders with scenes [default: those of the project].
    #[arg(value_name = "PATH")]
    pub scenes: Vec<PathBuf>,
    /// The renderers [default: those of mitsuba-3, luxcore and cycles that are there].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub renderer: Vec<String>,
    /// Images of each renderer.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub seeds: u32,
    /// The first seed.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub first_seed: u32,
    /// How much a tile may differ in each channel (0.05 is 5 %), plus the bounds that targets state for the scene.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = share)]
    pub tolerance: f64,
    /// How much the whole image may differ in each channel, plus the same bounds.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub mean_tolerance: f64,
    /// Exit with 1 also where agreement is undecided.
    #[arg(long)]
    pub require_agree: bool,
    /// Samples per pixel of each image.
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
    /// Width and height of the images in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 128, value_parser = clap::value_parser!(u32).range(8..=4096))]
    pub size: u32,
    /// The value of a parameter that the scene declares by `param`; may be given several times.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// A folder with images to compare with: SCENE.exr, or SCENE-0.exr, SCENE-1.exr ... with several seeds.
    #[arg(long, value_name = "DIR")]
    pub reference: Option<PathBuf>,
    /// What the reference is, for the page.
    #[arg(long, value_name = "TEXT", requires = "reference")]
    pub reference_name: Option<String>,
    /// Keep the images in this folder, and take from it what was rendered before.
    #[arg(long, value_name = "DIR")]
    pub keep: Option<PathBuf>,
    /// Put the results into this record, and write its page beside it.
    #[arg(long, value_name = "FILE.json")]
    pub record: Option<PathBuf>,
    /// Render nothing; exit with 1 where the page of the record is not what it would become.
    #[arg(long, requires = "record")]
    pub check: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// Stop a renderer after this many seconds for one image.
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
    #[command(flatten)]
    pub findings: Findings,
}

impl Agree {
    /// What replaces the scene's own settings.
    pub fn settings(&self) -> Settings {
        Settings {
            width: None,
            height: None,
            samples: None,
            max_depth: None,
            seed: None,
            set: self.set.clone(),
            camera: None,
        }
    }
}

#[derive(Args, Debug)]
pub struct Renderers {
    #[command(subcommand)]
    pub action: RenderersAction,
}

#[derive(Subcommand, Debug)]
pub enum RenderersAction {
    /// Show which renderers are known and which are there.
    List {
        #[command(flatten)]
        answer: Answer,
    },
    /// Allow ltsc to run the programs that the project's `ltsc.toml` names; nothing is run now.
    Trust,
    /// Install pinned versions into a private folder of your cache; nothing else is touched.
    #[command(
        after_help = "Example:\n  ltsc renderers install mitsuba-3 luxcore\n\nmitsuba-3, luxcore and cycles are packages of Python, pbrt-r4 and pbrt-r3 are built by cargo (about ten minutes each). The folder is $LTSC_CACHE, else the cache folder of the user; an interrupted installation is continued."
    )]
    Install {
        /// The renderers.
        #[arg(required = true)]
        names: Vec<String>,
        /// Install again, even where the pinned version is there.
        #[arg(long)]
        force: bool,
    },
}

#[derive(Args, Debug)]
pub struct Cache {
    #[command(subcommand)]
    pub action: Option<CacheAction>,
    /// The folder that a cluster shares, instead of the user's cache; `prune` also ends there what killed runs have left.
    #[arg(long, value_name = "DIR", global = true)]
    pub shared: Option<PathBuf>,
    /// How it is printed; `sarif` and `github`, which are for findings, give the form for people.
    #[arg(long, value_enum, default_value_t = Format::Human, env = "LTSC_FORMAT", global = true)]
    pub format: Format,
}

#[derive(Subcommand, Debug)]
pub enum CacheAction {
    /// Remove the chunks of images of which none was rendered for some days; installations stay.
    Prune {
        /// How many days.
        #[arg(long, value_name = "N", default_value_t = 30)]
        days: u64,
    },
}

#[derive(Args, Debug)]
pub struct Conventions {
    /// The renderers, as `ltsc renderers list` names them: `mitsuba-3`, `luxcore`, `cycles`, `pbrt-r4`, ...
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub renderer: Vec<String>,
    /// Only these conventions.
    #[arg(long, value_name = "CONVENTION", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Render nothing; list the conventions.
    #[arg(long)]
    pub list: bool,
    /// Keep the numbers in `renderers/NAME-VERSION.json` below this folder, and write the page `renderers.md` there. With `--only`
    /// the numbers of other conventions stay.
    #[arg(short, long, value_name = "DIR", conflicts_with = "list")]
    pub output: Option<PathBuf>,
    /// Render nothing; judge the numbers that are kept again, and write the page.
    #[arg(long, requires = "output", conflicts_with = "renderer")]
    pub stored: bool,
    /// Render nothing; print which answers of targets the kept numbers show, and which were not measured (exit code 1). The
    /// numbers are those below `--output`, by default `docs`.
    #[arg(long, conflicts_with_all = ["renderer", "only", "list", "stored"])]
    pub coverage: bool,
    /// Write nothing; list files that are stale, and exit with 1 if there are any.
    #[arg(long, requires = "stored")]
    pub check: bool,
    /// Write also over files that ltsc did not write, or that were changed since.
    #[arg(long)]
    pub force: bool,
    /// The renderer's executable, or a Python that has its module.
    #[arg(long, value_name = "FILE")]
    pub executable: Option<PathBuf>,
    /// Threads; images are so small that one is enough, and LuxCore's disturb each other.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: u32,
    /// Stop the renderer after this many seconds for one image.
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    pub timeout: u64,
    #[command(flatten)]
    pub answer: Answer,
}

/// A share above 0: `0.05`, or `5%`.
fn share(text: &str) -> Result<f64, String> {
    let (number, part) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value / part < 1.0 => Ok(value / part),
        _ => Err("a share lies between 0 and 1, such as `0.05` or `5%`".to_owned()),
    }
}
