//! What an evaluation is, once everything in its file is resolved: what is rendered, how, and what is compared with what.

use std::fmt;
use std::time::Duration;

use ltsc_core::diag::Span;
use ltsc_core::eval::Overrides;
use ltsc_core::formats::Target;
pub use ltsc_core::formats::statements::Value;
use ltsc_core::ir::Filter;
use ltsc_render::run::Driver;

use crate::command::Command;
use crate::compare::verdict::Tolerance;

/// A value and its place. Places do not count when values are compared.
#[derive(Clone, Copy, Debug)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Where it is written.
    pub span: Span,
}

impl<T> At<T> {
    /// A value at a place.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

impl<T: PartialEq> PartialEq for At<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

/// An evaluation, resolved: parameter sets with their bases, sweeps as conditions, cases by renderers as runs.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Its name; the stem of the file's name if it gives none.
    pub name: String,
    /// What it is about; may be empty.
    pub description: String,
    /// Where results go, and what is made of them.
    pub output: Output,
    /// The scenes, in the order of the file.
    pub scenes: Vec<SceneRef>,
    /// Scenes with the parameters of sweeps; a scene without a sweep is one condition.
    pub conditions: Vec<Condition>,
    /// The renderers that cases name, in the order of the file.
    pub renderers: Vec<Renderer>,
    /// The parameter sets with all that they inherit.
    pub parameters: Vec<ParameterSet>,
    /// The test cases, in the order of the file.
    pub cases: Vec<Case>,
    /// What is rendered: condition by condition, case by case, renderer by renderer, without what is excluded.
    pub runs: Vec<Run>,
    /// What is compared, in the order of the runs.
    pub pairs: Vec<Pair>,
    /// Shares by which images may differ.
    pub tolerance: Tolerance,
    /// Tiles along each side of an image.
    pub tiles: u32,
}

/// Where results go, and what is made of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The folder in which the folder of the results is made, as it is written: relative to the evaluation file.
    pub folder: String,
    /// Whether date and time are part of the folder's name.
    pub dated: bool,
    /// Whether the page is written.
    pub page: bool,
    /// Whether the page is opened.
    pub display: bool,
}

/// Where a scene is.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Source {
    /// A scene of the project, by its name.
    Name(String),
    /// A file, as it is written: relative to the evaluation file.
    File(String),
}

/// A scene of an evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRef {
    /// Its name in results; no other has it.
    pub name: String,
    /// Where it is.
    pub source: Source,
    /// Values of its parameters, as texts of expressions.
    pub set: Vec<(String, String)>,
    /// The camera, where it is not the first.
    pub camera: Option<String>,
    /// Its own reference.
    pub reference: Option<At<Reference>>,
    /// Where it is named.
    pub span: Span,
}

/// A scene with the values of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Its name in results: that of the scene, and `parameter = value` for each sweep.
    pub name: String,
    /// The scene, of [`Evaluation::scenes`].
    pub scene: usize,
    /// Values of its parameters, those of sweeps last, as texts of expressions.
    pub set: Vec<(String, String)>,
    /// Those of sweeps, in the order of the sweeps.
    pub swept: Vec<(String, String)>,
}

/// A renderer of an evaluation.
#[derive(Clone)]
pub struct Renderer {
    /// Its name in the file.
    pub name: String,
    /// The target whose files it reads.
    pub target: &'static Target,
    /// The driver; none only where there is a command.
    pub driver: Option<&'static Driver>,
    /// The executable as it is written: relative to the evaluation file, or a name on the path.
    pub path: Option<At<String>>,
    /// Further arguments, word by word.
    pub options: Vec<String>,
    /// How the program is called, where that is not the driver's affair.
    pub command: Option<At<Command>>,
    /// The most threads; all processors if nothing is said.
    pub threads: Option<u32>,
    /// The longest time for one image.
    pub timeout: Option<Duration>,
    /// Whether nothing is run: its files are written, and its images are made by hand.
    pub manual: bool,
    /// Where it is declared, or named first.
    pub span: Span,
}

impl fmt::Debug for Renderer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, target, driver, path, options, command, threads, timeout, manual, span } = self;
        f.debug_struct("Renderer")
            .field("name", name)
            .field("target", &target.name)
            .field("driver", &driver.map(|driver| driver.name))
            .field("path", path)
            .field("options", options)
            .field("command", command)
            .field("threads", threads)
            .field("timeout", timeout)
            .field("manual", manual)
            .field("span", span)
            .finish()
    }
}

/// A parameter set with all that it inherits.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSet {
    /// Its name.
    pub name: String,
    /// Its statements.
    pub statements: Vec<Statement>,
    /// Where it is declared.
    pub span: Span,
}

/// A native statement, which replaces the scene's own of this name whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its name in the target's files: `integrator`, `Sampler`, `film`.
    pub name: At<String>,
    /// Its parameters; at most one of each name and type.
    pub parameters: Vec<Parameter>,
}

/// A native parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name; may be empty.
    pub name: String,
    /// Its type as the target spells it; empty for what is the statement's own (`type`); none where it follows from the value.
    pub kind: Option<String>,
    /// Its value.
    pub value: Value,
    /// Where it is written.
    pub span: Span,
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, &self.kind, &self.value) == (&other.name, &other.kind, &other.value)
    }
}

/// Neutral settings, translated for each target; what is none is the scene's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// The algorithm: the name of its constructor in scenes, one of [`WORDS`](ltsc_core::ir::Integrator::WORDS).
    pub integrator: Option<At<&'static str>>,
    /// The largest number of segments of a path.
    pub max_depth: Option<At<u32>>,
    /// Samples per pixel of a whole image, all its chunks together.
    pub samples: Option<At<u32>>,
    /// The points that are sampled: the name of the sampler in scenes, one of [`WORDS`](ltsc_core::ir::Sampler::WORDS).
    pub sampler: Option<At<&'static str>>,
    /// The reconstruction filter.
    pub filter: Option<At<Filter>>,
    /// Width and height in pixels.
    pub size: Option<At<(u32, u32)>>,
    /// The seed of the first chunk.
    pub seed: Option<At<u32>>,
}

impl Settings {
    /// These settings where they say something, otherwise those of `below`.
    #[must_use]
    pub fn over(&self, below: &Self) -> Self {
        let Self { integrator, max_depth, samples, sampler, filter, size, seed } = self.clone();
        Self {
            integrator: integrator.or(below.integrator),
            max_depth: max_depth.or(below.max_depth),
            samples: samples.or(below.samples),
            sampler: sampler.or(below.sampler),
            filter: filter.or_else(|| below.filter.clone()),
            size: size.or(below.size),
            seed: seed.or(below.seed),
        }
    }

    /// Whether nothing is said.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What they put in the place of the scene's own.
    #[must_use]
    pub fn overrides(&self) -> Overrides {
        let Self { integrator, max_depth, samples, sampler, filter, size, seed } = self;
        Overrides {
            width: size.map(|size| size.value.0),
            height: size.map(|size| size.value.1),
            samples: samples.map(|samples| samples.value),
            seed: seed.map(|seed| seed.value),
            max_depth: max_depth.map(|depth| depth.value),
            integrator: integrator.map(|integrator| integrator.value),
            sampler: sampler.map(|sampler| sampler.value),
            filter: filter.as_ref().map(|filter| filter.value.clone()),
            ..Overrides::default()
        }
    }
}

/// How long an image is rendered beyond its samples: chunk after chunk, until the first of these is used up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Budget {
    /// Time of rendering, all chunks together.
    pub time: Option<At<Duration>>,
    /// Samples per pixel, all chunks together.
    pub samples: Option<At<u32>>,
}

impl Budget {
    /// This budget where it says something, otherwise that of `below`.
    #[must_use]
    pub fn over(&self, below: &Self) -> Self {
        Self { time: self.time.or(below.time), samples: self.samples.or(below.samples) }
    }
}

/// A test case.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name; no other has it.
    pub name: At<String>,
    /// What it is about; may be empty.
    pub description: String,
    /// How each of its renderers renders it.
    pub variants: Vec<Variant>,
    /// Its own reference.
    pub reference: Option<At<Reference>>,
    /// Where it is written.
    pub span: Span,
}

/// A test case for one of its renderers.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The renderer, of [`Evaluation::renderers`].
    pub renderer: usize,
    /// Native statements, all that is inherited included.
    pub statements: Vec<Statement>,
    /// Neutral settings; a native statement of the same meaning is stronger.
    pub settings: Settings,
    /// How long it is rendered beyond its samples.
    pub budget: Budget,
    /// How many independent images, each of another seed, make the image; if nothing is said, eight or more, of a size that depends on
    /// the samples alone.
    pub chunks: Option<u32>,
    /// Where the renderer is named for the case.
    pub span: Span,
}

/// One image to be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    /// Of [`Evaluation::conditions`].
    pub condition: usize,
    /// Of [`Evaluation::cases`].
    pub case: usize,
    /// Of [`Case::variants`].
    pub variant: usize,
}

/// An image that is known to be right.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// None.
    Nothing,
    /// The image that is kept for the scene and the target, where there is one.
    Convention,
    /// A file; `{scene}`, `{condition}`, `{case}`, `{renderer}` and `{target}` are filled in.
    File(String),
    /// Another case of the same condition.
    Case {
        /// Its name.
        case: String,
        /// Its renderer; none for the same renderer, or the only one that the case has.
        renderer: Option<String>,
    },
}

/// One side of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Side {
    /// What is rendered, of [`Evaluation::runs`].
    Run(usize),
    /// A reference image, relative to the evaluation file.
    File(String),
}

/// Two images of one condition that are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// The reference of the two.
    pub a: Side,
    /// What is held against it, of [`Evaluation::runs`].
    pub b: usize,
    /// Where the comparison is asked for; none where it is the default.
    pub span: Option<Span>,
}

impl Evaluation {
    /// The variant of a run.
    #[must_use]
    pub fn variant(&self, run: Run) -> &Variant {
        &self.cases[run.case].variants[run.variant]
    }

    /// The renderer of a run.
    #[must_use]
    pub fn renderer(&self, run: Run) -> &Renderer {
        &self.renderers[self.variant(run).renderer]
    }

    /// The name of a run among those of its condition: that of the case, with the renderer where the case has several.
    #[must_use]
    pub fn label(&self, run: Run) -> String {
        let case = &self.cases[run.case];
        if case.variants.len() == 1 {
            return case.name.value.clone();
        }
        format!("{}/{}", case.name.value, self.renderer(run).name)
    }
}
