//! `results.json`: what an evaluation has found and another machine with the same renderers would find too. Nothing here depends on
//! when, where and how fast it was rendered; that is in `timing.json`.

use std::collections::BTreeMap;

use ltsc_core::formats::effective::Effective;
use ltsc_core::ir::Filter;
use serde::{Deserialize, Serialize};

use crate::compare::blame::{Blame, Group};
use crate::compare::verdict::{Outcome, Stated, Verdict};
use crate::compare::{Measure, Shift};

/// The number of this form; it grows where a field goes or means something else.
pub const FORM: u32 = 1;

/// All results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// See [`FORM`].
    pub form: u32,
    /// `ltsc` and its version.
    pub generator: String,
    /// The evaluation's name.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// The copy of its file, beside this.
    pub file: String,
    /// Scenes with values of their parameters, in the order of the file.
    pub conditions: Vec<Condition>,
}

/// A scene with values of its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Its name.
    pub name: String,
    /// The scene's name.
    pub scene: String,
    /// Values of parameters, those of sweeps last.
    pub parameters: BTreeMap<String, String>,
    /// The parameters that are swept.
    pub swept: Vec<String>,
    /// Which pixels see what, of the sizes of images on whose differences something is to blame.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<Groups>,
    /// What the scene's file says of it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub documentation: String,
    /// Its images.
    pub runs: Vec<Run>,
    /// Its comparisons.
    pub pairs: Vec<Pair>,
}

/// Which pixels of images of a size see what.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Groups {
    /// A grey PNG, beside this file, whose values are numbers of groups.
    pub file: String,
    /// Its width, and that of the images.
    pub width: usize,
    /// Its height.
    pub height: usize,
    /// The groups.
    pub names: Vec<Group>,
}

/// How far an image has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It is there.
    Done,
    /// The renderer failed.
    Failed,
    /// It was not rendered, because another one had failed.
    Skipped,
    /// It is made by hand, and is not there yet.
    Awaited,
}

/// An image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The case, with its renderer where the case has several.
    pub label: String,
    /// The case.
    pub case: String,
    /// The renderer, as the file names it.
    pub renderer: String,
    /// The driver.
    pub driver: String,
    /// The target of its files.
    pub target: String,
    /// The renderer's version, as it says.
    pub version: String,
    /// How far it has come.
    pub status: Status,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// The image with its variance, beside this file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<String>,
    /// Where the files for the renderer are kept, of a case that failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub files: Option<String>,
    /// The image that somebody is to make, as it is seen from the evaluation's file; its files lie in the folder of the same name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Samples per pixel of all chunks.
    pub samples: u64,
    /// Chunks.
    pub chunks: u32,
    /// The seed of the first one.
    pub first_seed: u32,
    /// A hash of all that decides how the image looks but for samples and seed.
    pub identity: String,
    /// What the files for the renderer mean; none where they are not read back.
    pub settings: Option<Settings>,
    /// The standard error of a pixel of the image, over its mean: root of the mean variance of all pixels and channels.
    pub noise: Option<f64>,
    /// Pixels that are infinite or not a number in some chunk.
    pub non_finite: usize,
    /// What the target states of the scene.
    pub stated: Vec<Stated>,
    /// What the renderer is known to render otherwise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub defects: Vec<String>,
}

/// Settings with which an image was rendered, in units of scenes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The algorithm, as the renderer names it.
    pub algorithm: Option<String>,
    /// What it is, by the word of the language where that has one.
    pub family: Option<String>,
    /// `unbiased`, `consistent` or `biased`.
    pub convergence: Option<String>,
    /// Segments of a path; none where it is not known, or not bounded.
    pub max_depth: Option<u32>,
    /// Whether paths are not bounded.
    pub unbounded: bool,
    /// The reconstruction filter.
    pub filter: Option<String>,
    /// The largest value of a sample, where samples are clamped.
    pub clamped: Option<f64>,
    /// Statements and parameters that are not understood and passed through.
    pub passed: Vec<String>,
}

impl Settings {
    /// In words and numbers.
    #[must_use]
    pub fn of(effective: &Effective) -> Self {
        let filter = |filter: &Filter| match filter {
            Filter::Box { radius } => format!("box, radius {radius}"),
            Filter::Gaussian { stddev, radius } => format!("gaussian, standard deviation {stddev}, radius {radius}"),
        };
        Self {
            algorithm: effective.algorithm.map(|one| one.native.to_owned()),
            family: effective.algorithm.map(|one| one.family.to_owned()),
            convergence: effective.algorithm.map(|one| one.convergence.word().to_owned()),
            max_depth: effective.max_depth.filter(|depth| *depth < u32::MAX),
            unbounded: effective.max_depth == Some(u32::MAX),
            filter: effective.filter.as_ref().map(filter),
            clamped: effective.clamped.filter(|limit| limit.is_finite()),
            passed: effective.passed.clone(),
        }
    }
}

/// A comparison of two images of a condition; A is the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The label of A, or the file of the reference.
    pub a: String,
    /// Whether A is a file.
    pub reference: bool,
    /// The label of B.
    pub b: String,
    /// Samples per pixel of A, and of B; none of a file.
    pub samples: (Option<u64>, u64),
    /// Why the two are not the same image: settings that differ.
    pub not_comparable: Vec<String>,
    /// Settings of which nothing is known, so that they may differ.
    pub unknown: Vec<String>,
    /// What both targets state of the scene; the tolerance is wider by it.
    pub stated: Vec<Stated>,
    /// Whether the images differ by more than the tolerance, and by no more than is stated.
    pub excused: bool,
    /// What is proved.
    pub verdict: Option<Verdict>,
    /// Why there is no verdict.
    pub refused: Option<String>,
    /// On what the difference lies, the largest part first; empty where noise may have made it, or nothing differs.
    #[serde(default)]
    pub blame: Vec<Blame>,
    /// One entry for each metric.
    pub metrics: Vec<Measure>,
    /// The shift that moves B onto A.
    pub shift: Option<Shift>,
}

impl Results {
    /// How many comparisons have each outcome: agree, differ, undecided, and none.
    #[must_use]
    pub fn outcomes(&self) -> [usize; 4] {
        let mut counts = [0; 4];
        for pair in self.conditions.iter().flat_map(|condition| &condition.pairs) {
            let at = match pair.verdict.as_ref().map(|verdict| verdict.outcome) {
                Some(Outcome::Agree) => 0,
                Some(Outcome::Differ) => 1,
                Some(Outcome::Undecided) => 2,
                None => 3,
            };
            counts[at] += 1;
        }
        counts
    }

    /// All images.
    pub fn runs(&self) -> impl Iterator<Item = (&Condition, &Run)> {
        self.conditions.iter().flat_map(|condition| condition.runs.iter().map(move |run| (condition, run)))
    }
}
