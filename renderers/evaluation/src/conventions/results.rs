//! What was measured with a renderer, as it is kept: one JSON file for each renderer and version.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ltsc_core::formats::Target;
use ltsc_core::valid::Valid;
use ltsc_render::run::Driver;
use serde::{Deserialize, Serialize};

use super::judge::{Verdict, deviation, judge};
use super::kinds::{Check, Convention, Expected, Measure, View};
use super::{ideal, measure, noise, scene};
use ltsc_render::regular;

use crate::disk::Pages;
use crate::failure::{Exit, Failure};

/// What came of all conventions with one renderer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Results {
    /// The renderer's name.
    pub renderer: String,
    /// Its version, as it says.
    pub version: String,
    /// In the order of the table.
    pub rows: Vec<Row>,
}

impl Results {
    /// These, and what is kept of the same renderer and version for conventions other than `chosen`. The order is mended where the
    /// page is written.
    pub fn beside(&self, kept: &[Self], chosen: &[&'static Convention]) -> Self {
        let mut all = self.clone();
        let same = kept.iter().find(|kept| (&kept.renderer, &kept.version) == (&self.renderer, &self.version));
        let other = |row: &&Row| !chosen.iter().any(|convention| convention.name == row.convention);
        all.rows.extend(same.iter().flat_map(|kept| &kept.rows).filter(other).cloned());
        all
    }
}

/// What came of one check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The name of the scene.
    pub convention: String,
    /// The view; empty for the only one.
    pub view: String,
    /// The check.
    pub check: String,
    /// The answer.
    pub expected: f64,
    /// What was measured; none where the image has no finite number, or there is no image.
    pub measured: Option<f64>,
    /// Measured minus expected, as a share of it where `relative`.
    pub deviation: Option<f64>,
    /// How large the deviation may be.
    pub bound: f64,
    /// Whether deviation and bound are shares of the answer.
    pub relative: bool,
    /// What follows.
    pub verdict: Verdict,
    /// Where a deviation is stated, or why there is no number.
    pub because: Option<String>,
}

impl Row {
    /// The check with its view: `64 x 32, width`.
    pub fn what(&self) -> String {
        what(&self.view, &self.check)
    }
}

/// A check with its view, in words.
pub fn what(view: &str, check: &str) -> String {
    if view.is_empty() { check.to_owned() } else { format!("{view}, {check}") }
}

/// Six digits tell all there is to know, and keep files small.
pub fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10_f64.powi(5 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// A view with its scene and the answers of its checks, none of which depends on the renderer.
pub struct Asked {
    /// What it is about.
    pub convention: &'static Convention,
    /// How the scene is seen.
    pub view: &'static View,
    /// The scene, as it is rendered.
    pub scene: Valid,
    /// One for each check.
    pub expected: Vec<f64>,
}

/// Why there is no image to measure.
#[derive(Clone, Debug)]
pub struct Unmeasured {
    /// Whether the renderer failed, or its driver refuses what it is known to take for something else.
    pub verdict: Verdict,
    /// In words.
    pub reason: String,
}

impl Asked {
    /// Works the answers out.
    pub fn new(convention: &'static Convention, view: &'static View) -> Result<Self, Failure> {
        let scene = scene::prepared(convention, view)?;
        let of = |check: &Check| match (check.expected, check.measure) {
            (Expected::Number(value) | Expected::Reference { value, by: _ }, _) => value,
            (Expected::Formula(formula), _) => formula(),
            (Expected::Ideal, Measure::Mean(region, channel)) => {
                measure::of(ideal::Ideal::new(&scene).mean(&region), channel)
            }
            // A test refuses such rows.
            (Expected::Ideal, _) => f64::NAN,
        };
        let expected = view.checks.iter().map(of).map(rounded).collect();
        Ok(Self { convention, view, scene, expected })
    }

    /// The checks with their answers.
    pub fn checks(&self) -> impl Iterator<Item = (&'static Check, f64)> {
        self.view.checks.iter().zip(self.expected.iter().copied())
    }

    /// Whether a row is of this view.
    pub fn is_of(&self, row: &Row) -> bool {
        (self.convention.name, self.view.name) == (&row.convention, &row.view)
    }

    /// Whether a row is of this check.
    pub fn is(&self, check: &Check, row: &Row) -> bool {
        self.is_of(row) && check.name == row.check
    }

    /// The row of the check at `at` for what was measured with a renderer, or the reason why nothing was.
    pub fn row(
        &self,
        at: usize,
        (driver, target): (&Driver, &Target),
        measured: Result<Option<f64>, Unmeasured>,
    ) -> Row {
        let (check, expected) = (&self.view.checks[at], self.expected[at]);
        let (bound, relative) = check.tolerance.parts();
        let bound = rounded(bound + noise::left(driver, self, at));
        let (measured, (verdict, because)) = match measured {
            Ok(measured) => {
                let measured = measured.map(rounded);
                (measured, judge(check, target, &self.scene, expected, measured, bound))
            }
            Err(Unmeasured { verdict, reason }) => (None, (verdict, Some(reason))),
        };
        Row {
            convention: self.convention.name.to_owned(),
            view: self.view.name.to_owned(),
            check: check.name.to_owned(),
            expected,
            measured,
            deviation: measured.map(|measured| rounded(deviation(check.tolerance, expected, measured))),
            bound,
            relative,
            verdict,
            because,
        }
    }
}

/// The folder of stored results below that of the pages.
pub fn folder(pages: &Path) -> PathBuf {
    pages.join("renderers")
}

/// What the record of pages says of who wrote them.
pub const BY: &str = "conventions";

/// The file of a renderer and version, below the folder of pages.
pub fn name(renderer: &str, version: &str) -> String {
    let safe: String = version.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' }).collect();
    format!("renderers/{renderer}-{safe}.json")
}

/// All stored results, by renderer and version.
pub fn load(pages: &Path) -> Result<Vec<Results>, Failure> {
    let folder = folder(pages);
    let Ok(entries) = fs::read_dir(&folder) else { return Ok(Vec::new()) };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    let mut all = BTreeMap::new();
    for path in paths {
        let bad = |problem: String| {
            Failure::new(Exit::Input, format!("{}: {problem}", path.display()))
                .help("measure it again: `ltsc conventions --renderer NAME --output DIR`")
        };
        let text = regular::read_text(&path, regular::TEXT).map_err(|error| bad(error.to_string()))?;
        let results: Results = serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
        all.insert((results.renderer.clone(), results.version.clone()), results);
    }
    Ok(all.into_values().collect())
}

/// The text of a file of results.
pub fn text(results: &Results) -> String {
    serde_json::to_string_pretty(results).map_or_else(|_| String::new(), |text| text + "\n")
}

/// Writes results where they belong.
pub fn save(pages: &Path, results: &Results, force: bool) -> Result<PathBuf, Failure> {
    let name = name(&results.renderer, &results.version);
    let mut written = Pages::new(pages, BY);
    written.put(name.clone(), text(results));
    written.keep(|_| true);
    written.finish(false, force)?;
    Ok(pages.join(name))
}
