//! An evaluation as it is written: what the file says and no more, before names are looked up.

use std::time::Duration;

use ltsc_core::diag::Span;

use super::model::{At, Budget, Parameter, Reference, Settings, Source};

/// The most runs that an evaluation may have.
pub const MOST_RUNS: usize = 100_000;

/// The most values of a sweep.
pub const MOST_VALUES: usize = 10_000;

/// A file as it is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// `name`.
    pub name: Option<At<String>>,
    /// `description`.
    pub description: Option<At<String>>,
    /// `output`.
    pub output: WrittenOutput,
    /// `scenes`.
    pub scenes: Option<At<Vec<WrittenScene>>>,
    /// `[[sweep]]`.
    pub sweeps: Vec<WrittenSweep>,
    /// `settings`, `budget` and `chunks` for all cases.
    pub all: Overriding,
    /// `[renderers.NAME]`.
    pub renderers: Vec<WrittenRenderer>,
    /// `[parameters.NAME]`.
    pub sets: Vec<(At<String>, Parameters)>,
    /// `[[case]]`.
    pub cases: Vec<WrittenCase>,
    /// `[[exclude]]`.
    pub excludes: Vec<Exclude>,
    /// `reference`.
    pub reference: Option<At<Reference>>,
    /// `[compare]`.
    pub compare: WrittenCompare,
}

/// `output`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrittenOutput {
    /// `folder`.
    pub folder: Option<At<String>>,
    /// `dated`.
    pub dated: Option<bool>,
    /// `page`.
    pub page: Option<bool>,
    /// `display`.
    pub display: Option<bool>,
}

/// An entry of `scenes`.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenScene {
    /// `scene`.
    pub source: At<Source>,
    /// `name`.
    pub name: Option<At<String>>,
    /// `set`.
    pub set: Vec<(At<String>, String)>,
    /// `camera`.
    pub camera: Option<At<String>>,
    /// `reference`.
    pub reference: Option<At<Reference>>,
}

/// `[[sweep]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenSweep {
    /// `parameter`.
    pub parameter: At<String>,
    /// `scenes`; none for all.
    pub scenes: Option<Vec<At<String>>>,
    /// `values`, or what `from`, `to`, `step`, `count` and `scale` say; as texts of expressions.
    pub values: Vec<String>,
    /// Where it stands.
    pub span: Span,
}

/// `[renderers.NAME]`.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenRenderer {
    /// The name.
    pub name: At<String>,
    /// `target`.
    pub target: Option<At<String>>,
    /// `path`.
    pub path: Option<At<String>>,
    /// `options`.
    pub options: Vec<String>,
    /// `command`.
    pub command: Option<At<Vec<String>>>,
    /// `threads`.
    pub threads: Option<At<u32>>,
    /// `timeout`.
    pub timeout: Option<At<Duration>>,
    /// `manual`.
    pub manual: bool,
}

/// Native parameters: `base` and statements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters {
    /// `base`.
    pub base: Vec<At<String>>,
    /// The statements, as they are written.
    pub statements: Vec<(At<String>, Vec<Parameter>)>,
}

/// What a case says of all its renderers, or of one, and a file of all cases.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overriding {
    /// `parameters`; none at the top of a file, where that key has the sets.
    pub parameters: Parameters,
    /// `settings`.
    pub settings: Settings,
    /// `budget`.
    pub budget: Budget,
    /// `chunks`.
    pub chunks: Option<At<u32>>,
}

/// `[[case]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenCase {
    /// `name`.
    pub name: At<String>,
    /// `description`.
    pub description: Option<At<String>>,
    /// `renderer` or `renderers`.
    pub renderers: Vec<At<String>>,
    /// `scenes`; none for all.
    pub scenes: Option<Vec<At<String>>>,
    /// For all its renderers.
    pub all: Overriding,
    /// `for`: for one of them.
    pub one: Vec<(At<String>, Overriding)>,
    /// `reference`.
    pub reference: Option<At<Reference>>,
    /// Where it stands.
    pub span: Span,
}

/// `[[exclude]]`; none for all.
#[derive(Clone, Debug, PartialEq)]
pub struct Exclude {
    /// `scenes`.
    pub scenes: Option<Vec<At<String>>>,
    /// `cases`.
    pub cases: Option<Vec<At<String>>>,
    /// `renderers`.
    pub renderers: Option<Vec<At<String>>>,
    /// Where it stands.
    pub span: Span,
}

/// `[compare]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrittenCompare {
    /// `against`.
    pub against: Option<At<Against>>,
    /// `pairs`.
    pub pairs: Vec<At<(String, String)>>,
    /// `tolerance`.
    pub tolerance: Option<At<f64>>,
    /// `mean_tolerance`.
    pub mean_tolerance: Option<At<f64>>,
    /// `tiles`.
    pub tiles: Option<At<u32>>,
}

/// What the images of a condition are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The reference alone.
    Reference,
    /// The first image.
    First,
    /// Every other image.
    All,
    /// Nothing.
    Nothing,
}

impl Against {
    /// All of them, by their words.
    pub const WORDS: [(&'static str, Self); 4] =
        [("reference", Self::Reference), ("first", Self::First), ("all", Self::All), ("nothing", Self::Nothing)];
}

/// The name under which references of a pair are asked for.
pub const REFERENCE: &str = "reference";

/// Spans of sweeps, cases and excludes do not count in comparisons.
#[cfg(test)]
pub(super) fn without_places(mut written: Written, nowhere: Span) -> Written {
    written.sweeps.iter_mut().for_each(|sweep| sweep.span = nowhere);
    written.cases.iter_mut().for_each(|case| case.span = nowhere);
    written.excludes.iter_mut().for_each(|exclude| exclude.span = nowhere);
    written
}
