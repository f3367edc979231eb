//! `ltsc conventions --coverage`: by what each answer of a target was measured, and which answers were not measured.

use std::collections::BTreeMap;

use ltsc_core::capability::{Feature, Support, features};
use ltsc_core::formats::{TARGETS, Target};
use ltsc_core::manual::{Measured, Proof};
use ltsc_render::run::{DRIVERS, Driver, Installation};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::judge::Verdict;
use super::records::RECORDS;
use super::results::{Asked, Results};
use crate::failure::{Exit, Failure};

/// One answer of a target, other than "unsupported", as a renderer shows it.
pub struct Claim {
    /// What the target answers to.
    pub feature: Feature,
    /// Whether it answers "exact".
    pub exact: bool,
    /// What shows it, conventions first.
    pub proofs: Vec<Proof>,
    /// Conventions that show the opposite.
    pub against: Vec<String>,
}

impl Claim {
    fn is_measured(&self) -> bool {
        !self.proofs.is_empty() && self.against.is_empty()
    }
}

/// The answers of a renderer's target.
pub struct Coverage {
    /// The renderer.
    pub driver: &'static Driver,
    /// All but what it answers "unsupported" to.
    pub claims: Vec<Claim>,
}

impl Coverage {
    /// How many answers were not measured, or were shown to be wrong.
    pub fn open(&self) -> usize {
        self.claims.iter().filter(|claim| !claim.is_measured()).count()
    }
}

/// Whether ltsc installs the renderer, so that anyone can repeat what was measured with it.
fn installs(driver: &Driver) -> bool {
    !matches!(driver.installation, Installation::User { .. })
}

/// The answers of every renderer that ltsc installs.
pub fn of_renderers(kept: &[Results], asked: &[Asked]) -> Vec<Coverage> {
    let of = |driver: &'static Driver| {
        let target = TARGETS.iter().find(|target| target.name == driver.target)?;
        let results = kept.iter().filter(|results| results.renderer == driver.name);
        Some(Coverage { driver, claims: claims(target, &results.collect::<Vec<_>>(), asked) })
    };
    DRIVERS.iter().copied().filter(|driver| installs(driver)).filter_map(of).collect()
}

/// The answers of a target, with what these results and the records show of them.
fn claims(target: &Target, results: &[&Results], asked: &[Asked]) -> Vec<Claim> {
    let asks: Vec<Vec<Feature>> =
        asked.iter().map(|one| features(&one.scene).into_iter().map(|(feature, _)| feature).collect()).collect();
    let mut all = Vec::new();
    for feature in Feature::ALL.iter().copied() {
        let exact = match (target.supports)(feature) {
            Support::Exact => true,
            Support::Approximate { why: _, bound: _ } => false,
            Support::Unsupported { why: _ } => continue,
        };
        let mut claim = Claim { feature, exact, proofs: Vec::new(), against: Vec::new() };
        for results in results {
            let with = format!("{} {}", results.renderer, results.version);
            for (one, asks) in asked.iter().zip(&asks) {
                if !one.convention.proves.contains(&feature) || !asks.contains(&feature) {
                    continue;
                }
                let rows = results.rows.iter().filter(|row| one.is_of(row));
                let name = one.convention.name;
                match rows.map(|row| row.verdict).filter(|verdict| *verdict != Verdict::Unsupported).max() {
                    Some(Verdict::Fails) => claim.against.push(format!("{name} ({with})")),
                    Some(Verdict::Holds | Verdict::Approximate) => {
                        let link = format!("renderers.md#{name}");
                        let proof = Proof { name: format!("`{name}`"), link, with: with.clone() };
                        if !claim.proofs.contains(&proof) {
                            claim.proofs.push(proof);
                        }
                    }
                    Some(Verdict::Unsupported) | None => {}
                }
            }
        }
        let records = RECORDS.iter().filter(|record| {
            record.features.contains(&feature) && (record.targets.is_empty() || record.targets.contains(&target.name))
        });
        claim.proofs.extend(records.map(|record| record.at.proof()));
        all.push(claim);
    }
    all
}

/// All proofs, by target and feature, as they are kept for the manual.
type Kept = BTreeMap<String, BTreeMap<String, Vec<KeptProof>>>;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptProof {
    name: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    link: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    with: String,
}

/// The file that keeps the proofs for the manual and `ltsc explain`, which have it built in.
pub const FILE: &str = "coverage.json";

/// Its text for what was measured.
pub fn text(kept: &[Results], asked: &[Asked]) -> String {
    let mut all = Kept::new();
    for target in TARGETS {
        let by = |results: &&Results| {
            DRIVERS.iter().any(|driver| driver.name == results.renderer && driver.target == target.name)
        };
        let results: Vec<&Results> = kept.iter().filter(by).collect();
        let claims = claims(target, &results, asked).into_iter().filter(|claim| !claim.proofs.is_empty());
        let keep = |Proof { name, link, with }: Proof| KeptProof { name, link, with };
        let claims = claims
            .map(|claim| (claim.feature.name().to_owned(), claim.proofs.into_iter().map(keep).collect()))
            .collect();
        all.insert(target.name.to_owned(), claims);
    }
    serde_json::to_string_pretty(&all).map_or_else(|_| String::new(), |text| text + "\n")
}

/// What a file of coverage says.
pub fn of_text(text: &str) -> Result<Measured, Failure> {
    let kept: Kept = serde_json::from_str(text)
        .map_err(|error| Failure::new(Exit::Fault, format!("docs/coverage.json was malformed: {error}")))?;
    let mut measured = Measured::default();
    for (target, answers) in kept {
        for (name, proofs) in answers {
            // A feature that is gone has no proofs.
            let Some(feature) = Feature::ALL.iter().find(|feature| feature.name() == name) else { continue };
            for KeptProof { name, link, with } in proofs {
                measured.add(&target, *feature, Proof { name, link, with });
            }
        }
    }
    Ok(measured)
}

/// In one sentence, as the README has it.
pub fn summary(all: &[Coverage]) -> String {
    let answers: usize = all.iter().map(|coverage| coverage.claims.len()).sum();
    let open: usize = all.iter().map(Coverage::open).sum();
    format!("{} renderers, {answers} answers, {open} not measured", all.len())
}

/// For people: what is open, renderer by renderer, and the sum.
pub fn human(all: &[Coverage]) -> String {
    let mut text = String::new();
    for coverage in all {
        let by_convention =
            |claim: &&Claim| claim.is_measured() && claim.proofs.iter().any(|proof| !proof.with.is_empty());
        let conventions = coverage.claims.iter().filter(by_convention).count();
        let records = coverage.claims.len() - conventions - coverage.open();
        text.push_str(&format!(
            "{:<10} ({}): {} answers, {conventions} measured by conventions, {records} by tests or records, {} not measured\n",
            coverage.driver.name,
            coverage.driver.target,
            coverage.claims.len(),
            coverage.open(),
        ));
        for claim in coverage.claims.iter().filter(|claim| !claim.is_measured()) {
            let says = if claim.exact { "exact" } else { "approximated" };
            let name = claim.feature.name();
            match claim.against.as_slice() {
                [] => text.push_str(&format!("    {says}, not measured: {name}\n")),
                against => text.push_str(&format!("    {says}, but fails: {name}: {}\n", against.join(", "))),
            }
        }
    }
    format!("{text}{}\n", summary(all))
}

/// For programs.
pub fn json(all: &[Coverage]) -> String {
    let claim = |claim: &Claim| {
        json!({
            "feature": claim.feature.name(),
            "answer": if claim.exact { "exact" } else { "approximate" },
            "measured": claim.is_measured(),
            "by": claim.proofs.iter().map(Proof::text).collect::<Vec<_>>(),
            "against": claim.against,
        })
    };
    let renderers = all.iter().map(|coverage| {
        json!({
            "renderer": coverage.driver.name,
            "target": coverage.driver.target,
            "not_measured": coverage.open(),
            "answers": coverage.claims.iter().map(claim).collect::<Vec<_>>(),
        })
    });
    format!("{:#}\n", json!({ "renderers": renderers.collect::<Vec<_>>() }))
}
