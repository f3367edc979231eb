//! The ledger of a scene and a target: what became of everything that the scene asks for.
//!
//! Made from what the target answers ([`Target::supports`]), the formulas by which numbers were converted
//! ([`Target::conversions`]), the bounds that hold for this very scene ([`Target::bound`]), and what lowering baked. Written beside
//! the files of the target as `ledger.json`, and said as findings.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::capability::{Bound, Support, features};
use crate::diag::{Finding, Origin, Severity};
use crate::formats::Target;
use crate::ir::Scene;

/// The name of its file in the folder of a target.
pub const FILE: &str = "ledger.json";

/// What a target says of a scene, and how.
#[derive(Clone, Debug, Serialize)]
pub struct Ledger {
    /// The scene's name.
    pub scene: String,
    /// The target's name.
    pub target: &'static str,
    /// The scene's parameters with their values.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, String>,
    /// What it says with the same meaning and the same numbers.
    pub exact: Vec<&'static str>,
    /// What it says exactly with other numbers, and the formula.
    pub converted: Vec<Converted>,
    /// What it has no exact equivalent for.
    pub approximated: Vec<Approximated>,
    /// What was computed beforehand and stands no longer as the scene says it.
    pub baked: Vec<String>,
    /// What it does not support.
    pub dropped: Vec<Dropped>,
    /// What was lost before any target was asked: what files of meshes and materials say that is not in the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reading: Vec<Unread>,
}

/// Something said exactly with other numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Converted {
    /// What it is.
    pub what: &'static str,
    /// How the numbers come about.
    pub formula: &'static str,
}

/// Something that was approximated.
#[derive(Clone, Debug, Serialize)]
pub struct Approximated {
    /// What it is.
    pub what: &'static str,
    /// What differs.
    pub why: &'static str,
    /// By how much in general, and how that was found.
    pub how_much: &'static str,
    /// How the numbers come about, where they are others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub formula: Option<&'static str>,
    /// By how much at most in this scene, where that can be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub here: Option<Here>,
    #[serde(skip)]
    origin: Origin,
}

/// A bound for one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Here {
    /// The largest share by which it is off, to four digits; 0.02 is 2 %.
    pub at_most: f64,
    /// What it is a share of.
    pub of: String,
}

/// Something in a file that is not in the scene, or only nearly.
#[derive(Clone, Debug, Serialize)]
pub struct Unread {
    /// The code of the finding that says it.
    pub loss: &'static str,
    /// The file, the place in it, and what was lost.
    pub what: String,
}

/// Something that a target does not support.
#[derive(Clone, Debug, Serialize)]
pub struct Dropped {
    /// What it is.
    pub what: &'static str,
    /// What is missing.
    pub why: &'static str,
    #[serde(skip)]
    origin: Origin,
}

impl Ledger {
    /// The ledger of a lowered scene; `before` are the findings of what came before: of reading the scene's files, and of lowering.
    pub fn of(scene: &Scene, target: &Target, before: &[Finding]) -> Self {
        let messages = |id: &'static str| before.iter().filter(move |one| one.id == id).map(|one| one.message.clone());
        let unread = |loss: &'static str| messages(loss).map(move |what| Unread { loss, what });
        let mut ledger = Self {
            scene: scene.name.clone(),
            target: target.name,
            parameters: scene
                .documentation
                .parameters
                .iter()
                .map(|one| (one.name.clone(), one.value.clone()))
                .collect(),
            exact: Vec::new(),
            converted: Vec::new(),
            approximated: Vec::new(),
            baked: messages("loss-baked").collect(),
            dropped: Vec::new(),
            reading: unread("loss-dropped").chain(unread("loss-approximated")).collect(),
        };
        for (feature, origin) in features(scene) {
            let what = feature.name();
            let formula = target.conversion(feature);
            match ((target.supports)(feature), formula) {
                (Support::Exact, None) => ledger.exact.push(what),
                (Support::Exact, Some(formula)) => ledger.converted.push(Converted { what, formula }),
                (Support::Approximate { why, bound: how_much }, formula) => {
                    let here = (target.bound)(feature, scene).map(|Bound { size, what: of }| {
                        let at_most = format!("{size:.3e}").parse().unwrap_or(size);
                        Here { at_most, of }
                    });
                    ledger.approximated.push(Approximated { what, why, how_much, formula, here, origin });
                }
                (Support::Unsupported { why }, _) => ledger.dropped.push(Dropped { what, why, origin }),
            }
        }
        ledger
    }

    /// What is not said exactly: `loss-approximated` and `loss-dropped`.
    pub fn findings(&self) -> Vec<Finding> {
        let name = self.target;
        let nearly = self.approximated.iter().map(|one| {
            let message = format!("{name} approximates {}: {}", one.what, one.why);
            let finding = Finding::new("loss-approximated", Severity::Info, one.origin.clone(), message);
            let finding = finding.note(one.how_much);
            match &one.here {
                Some(here) => finding.note(format!("in this scene at most {} {}", percent(here.at_most), here.of)),
                None => finding,
            }
        });
        let dropped = self.dropped.iter().map(|one| {
            let message = format!("{name} does not support {}: {}", one.what, one.why);
            Finding::new("loss-dropped", Severity::Warn, one.origin.clone(), message)
        });
        nearly.chain(dropped).collect()
    }

    /// The text of `ledger.json`.
    pub fn json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}"));
        text.push('\n');
        text
    }
}

/// A share in percent, to three digits.
pub fn percent(share: f64) -> String {
    let percent = share * 100.0;
    let digits = if percent >= 100.0 {
        0
    } else if percent >= 10.0 {
        1
    } else {
        2
    };
    format!("{percent:.digits$} %")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{TARGETS, find, shared::sample};
    use crate::ir::{Bsdf, Color};

    fn gold(alpha: f64) -> Scene {
        let mut scene = sample::room();
        let (eta, k) = (Color::Rgb([0.143_119, 0.374_957, 1.442_48]), Color::Rgb([3.983_16, 2.385_72, 1.603_22]));
        let gold = sample::material(&mut scene, "gold", Bsdf::Conductor { eta, k, alpha });
        let block = sample::block(&mut scene, "bar", [5.0; 3], [0.0, 0.0, 30.0], 0.0);
        sample::shape(&mut scene, "bar", block, gold, None);
        scene
    }

    #[test]
    fn everything_that_is_asked_for_is_booked_once() {
        let scene = gold(0.4);
        for target in TARGETS {
            let Ledger { exact, converted, approximated, dropped, .. } = Ledger::of(&scene, target, &[]);
            let booked = exact.len() + converted.len() + approximated.len() + dropped.len();
            assert_eq!(booked, features(&scene).len(), "{}", target.name);
        }
    }

    #[test]
    fn bounds_are_those_of_the_scene() {
        let here = |alpha: f64, target: &str, what: &str| {
            let ledger = Ledger::of(&gold(alpha), find(target).expect("a target"), &[]);
            let one = ledger.approximated.into_iter().find(|one| one.what == what)?;
            one.here.map(|here| here.at_most)
        };
        for (target, low, high) in [("gltf", 0.02, 0.2), ("luxcore", 0.01, 0.2)] {
            let found = here(0.1, target, "a rough conductor").expect("a bound");
            assert!((low..high).contains(&found), "{target}: {found}");
        }
        let wide = |alpha| here(alpha, "luxcore", "a conductor with `alpha` above 0.3").expect("a bound");
        // Schlick's masking and the cosine that samples of the lobe lose, at 78.5 degrees.
        for (alpha, bound) in [(0.5, 0.36), (1.0, 0.69)] {
            assert!((wide(alpha) - bound).abs() < 0.01, "{alpha}: {}", wide(alpha));
        }
        assert_eq!(here(0.1, "mitsuba-3", "a rough conductor"), None);
    }

    #[test]
    fn findings_and_file_say_the_same() {
        let ledger = Ledger::of(&gold(0.4), find("luxcore").expect("a target"), &[]);
        let findings = ledger.findings();
        assert_eq!(findings.len(), ledger.approximated.len() + ledger.dropped.len());
        assert!(findings.iter().any(|finding| finding.notes.iter().any(|note| note.contains("in this scene at most"))));
        let read: serde_json::Value = serde_json::from_str(&ledger.json()).expect("JSON");
        assert_eq!(read["target"], "luxcore");
        assert_eq!(read["approximated"].as_array().expect("a list").len(), ledger.approximated.len());
    }
}
