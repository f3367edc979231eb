//! Verdicts: a number against its answer, and a deviation against what is stated of the target.

use ltsc_core::capability::{Bound, Feature, Support};
use ltsc_core::formats::Target;
use ltsc_core::ir::Scene;
use serde::{Deserialize, Serialize};

use super::kinds::{By, Check, Known, Tolerance, Within};

/// What becomes of a check; the later, the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The number is the answer, within the tolerance.
    Holds,
    /// It is off by what the target is stated to be off by.
    Approximate,
    /// The target is stated not to have it.
    Unsupported,
    /// It is off, and nothing says so.
    Fails,
}

impl Verdict {
    /// The word that people read.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Approximate => "approximate",
            Self::Unsupported => "unsupported",
            Self::Fails => "fails",
        }
    }
}

/// How far off a number is: as a share of the answer, or plainly.
pub fn deviation(tolerance: Tolerance, expected: f64, measured: f64) -> f64 {
    match tolerance {
        Tolerance::Share(_) => (measured - expected) / expected,
        Tolerance::Plain(_) => measured - expected,
    }
}

/// The verdict, and where a deviation is stated: by the bound that the target computes for this very scene, or in words.
pub fn judge(
    check: &Check,
    target: &Target,
    scene: &Scene,
    expected: f64,
    measured: Option<f64>,
    bound: f64,
) -> (Verdict, Option<String>) {
    let Some(measured) = measured else {
        return (Verdict::Fails, Some("the image has no finite number there".to_owned()));
    };
    if deviation(check.tolerance, expected, measured).abs() <= bound {
        return (Verdict::Holds, None);
    }
    if let Some((feature, why)) = lacking(check, target) {
        return (Verdict::Unsupported, Some(format!("{}: {why}", feature.name())));
    }
    if let Some(reason) = bounded(check, target, scene, measured / expected - 1.0, bound) {
        return (Verdict::Approximate, Some(reason));
    }
    let stated = |known: &&Known| {
        known.target.is_none_or(|name| name == target.name) && within(known.within, expected, measured)
    };
    match check.known.iter().find(stated) {
        Some(Known { by: By::Feature(feature, words), .. }) => {
            (Verdict::Approximate, Some(format!("{}: {words}", feature.name())))
        }
        Some(Known { by: By::Rule(rule), .. }) => {
            (Verdict::Unsupported, Some(format!("the rule `{rule}` refuses such scenes")))
        }
        None => (Verdict::Fails, None),
    }
}

/// The first feature whose bound for the scene covers a deviation, the tolerance beside it.
fn bounded(check: &Check, target: &Target, scene: &Scene, share: f64, tolerance: f64) -> Option<String> {
    let nearly = |feature: &&Feature| matches!((target.supports)(**feature), Support::Approximate { .. });
    check.rests_on.iter().filter(nearly).find_map(|feature| {
        let Bound { size, what } = (target.bound)(*feature, scene)?;
        let covers = share.abs() <= size + tolerance;
        covers.then(|| format!("{}: off by at most {:.1} % {what}", feature.name(), 100.0 * size))
    })
}

/// The first feature that the check rests on and the target lacks.
fn lacking(check: &Check, target: &Target) -> Option<(Feature, &'static str)> {
    check.rests_on.iter().find_map(|feature| match (target.supports)(*feature) {
        Support::Unsupported { why } => Some((*feature, why)),
        Support::Exact | Support::Approximate { .. } => None,
    })
}

fn within(within: Within, expected: f64, measured: f64) -> bool {
    match within {
        Within::Ratio(least, most) => (least..=most).contains(&(measured / expected)),
        Within::Distance(most) => (measured - expected).abs() <= most,
    }
}
