//! Every limit that lint knows, broken in the scenes of the project: the rule that is for it must find it, and no other rule may speak
//! that has no reason to. All rules look at each broken scene. A plain run breaks each limit in two scenes; the long one in all of
//! them, and holds the table in `docs/lint.md` against what it finds.

mod defects;
mod mutant;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::sync::OnceLock;

use ltsc_core::lint::{Level, Levels, RULES};

use self::defects::{Broken, DEFECTS, Defect};
use self::mutant::{Found, Mutant};
use super::random::in_parallel;
use super::{QUICK, bless, root, scenes};

/// The page with the table, and the lines around it.
const PAGE: &str = "docs/lint.md";
const BEGIN: &str = "<!-- mutations: made by the test of this name -->\n";
const END: &str = "<!-- end of mutations -->\n";

/// What became of one defect in one scene.
struct Outcome {
    /// Whether the scene has what the defect needs.
    possible: bool,
    caught: bool,
    /// Findings of other codes that the clean scene does not have, and that the defect does not explain.
    wrong: Vec<String>,
}

/// All rules, also those that are allowed unless asked for.
fn every_rule() -> Levels {
    let mut levels = Levels::default();
    for rule in RULES {
        levels.set(rule.id, rule.level.max(Level::Warn)).expect("a rule");
    }
    levels
}

/// The scenes, and what is found in them as they are.
struct Bench {
    scenes: Vec<Mutant>,
    before: Vec<OnceLock<Vec<Found>>>,
}

impl Bench {
    fn new(scenes: &[String]) -> Self {
        let scenes = Mutant::of(scenes);
        Self { before: vec![OnceLock::new(); scenes.len()], scenes }
    }

    fn name(&self, scene: usize) -> &str {
        &self.scenes[scene].scene.name
    }

    /// What becomes of a defect in a scene.
    fn outcome(&self, defect: &Defect, scene: usize) -> Outcome {
        let mut mutant = self.scenes[scene].clone();
        let after = match (defect.inject)(&mut mutant) {
            Broken::Impossible => return Outcome { possible: false, caught: false, wrong: Vec::new() },
            Broken::Scene => {
                let mut found = mutant.findings(&every_rule());
                // Validation has a look where it is to find something: it takes longer than all rules.
                if defect.codes.iter().any(|code| code.starts_with("invalid-")) {
                    found.extend(mutant.refused());
                }
                found
            }
            Broken::Refused(codes) => codes,
        };
        let before = self.before[scene].get_or_init(|| self.scenes[scene].findings(&every_rule()));
        let known: BTreeSet<&Found> = before.iter().collect();
        let caught = after.iter().any(|found| defect.codes.contains(&found.0.as_str()) && !known.contains(found));
        let count = |list: &[Found], id: &str| list.iter().filter(|found| found.0 == id).count();
        let explained = |id: &str| defect.codes.contains(&id) || defect.also.contains(&id);
        let wrong = after.iter().filter(|found| !explained(&found.0) && !known.contains(found));
        let wrong = wrong.filter(|(id, _)| count(&after, id) > count(before, id));
        let wrong = wrong.map(|(id, message)| format!("{id}: {message}")).collect();
        Outcome { possible: true, caught, wrong }
    }
}

/// What is wrong with the outcomes of a defect in scenes of these names.
fn problems(defect: &Defect, of: &[(&str, &Outcome)]) -> Vec<String> {
    let names = |which: &dyn Fn(&Outcome) -> bool| {
        of.iter().filter(|(_, outcome)| which(outcome)).map(|(name, _)| *name).collect::<Vec<_>>()
    };
    let mut problems = Vec::new();
    let missed = names(&|outcome| outcome.possible && !outcome.caught);
    if !missed.is_empty() {
        problems.push(format!("`{}` is missed in {}", defect.what, missed.join(", ")));
    }
    let wrong: BTreeSet<&String> = of.iter().flat_map(|(_, outcome)| &outcome.wrong).collect();
    for found in wrong.iter().take(5) {
        let where_ = names(&|outcome| outcome.wrong.contains(*found));
        problems.push(format!("`{}` gives {found} in {}", defect.what, where_.join(", ")));
    }
    if names(&|outcome| outcome.possible).is_empty() {
        problems.push(format!("no scene has what `{}` needs", defect.what));
    }
    problems
}

/// Each in the smallest scene, and in one of those that are quick to build, which it takes by turns.
#[test]
fn every_defect_is_caught_in_two_scenes() {
    let bench = Bench::new(&["cbox_empty"].into_iter().chain(QUICK).map(str::to_owned).collect::<Vec<_>>());
    let small = 0;
    let found = in_parallel(0, DEFECTS.len() as u64, |at| {
        let (at, count) = (at as usize, bench.scenes.len());
        let turns = (0..count).map(|step| (at + step) % count).filter(|scene| *scene != small);
        let mut of = vec![(bench.name(small), bench.outcome(&DEFECTS[at], small))];
        // The first that has what the defect needs.
        let outcomes = turns.map(|scene| (bench.name(scene), bench.outcome(&DEFECTS[at], scene)));
        of.extend(outcomes.filter(|(_, outcome)| outcome.possible).take(1));
        problems(&DEFECTS[at], &of.iter().map(|(name, outcome)| (*name, outcome)).collect::<Vec<_>>())
    });
    let problems: Vec<String> = found.into_iter().flat_map(|(_, problems)| problems).collect();
    assert!(problems.is_empty(), "{} problems:\n{}", problems.len(), problems.join("\n"));
}

#[test]
#[ignore = "long: every rule looks at some 700 broken scenes"]
fn every_defect_is_caught_in_every_scene() {
    let bench = Bench::new(&scenes());
    let count = bench.scenes.len();
    let pairs = (count * DEFECTS.len()) as u64;
    let results = in_parallel(0, pairs, |pair| bench.outcome(&DEFECTS[pair as usize / count], pair as usize % count));
    let mut wrong_or_missed = Vec::new();
    let mut rows = String::new();
    for (defect, outcomes) in DEFECTS.iter().zip(results.chunks(count)) {
        let of: Vec<(&str, &Outcome)> =
            outcomes.iter().enumerate().map(|(scene, (_, outcome))| (bench.name(scene), outcome)).collect();
        wrong_or_missed.extend(problems(defect, &of));
        let possible = of.iter().filter(|(_, outcome)| outcome.possible).count();
        let caught = of.iter().filter(|(_, outcome)| outcome.caught).count();
        let wrong: usize = of.iter().map(|(_, outcome)| outcome.wrong.len()).sum();
        rows.push_str(&format!("{}{caught}/{possible} | {} | {wrong} |\n", begin(defect), list(defect.also)));
    }
    assert!(wrong_or_missed.is_empty(), "{} problems:\n{}", wrong_or_missed.len(), wrong_or_missed.join("\n"));
    keep_current(&table(&rows, count));
}

/// The first cells of a row of the table.
fn begin(defect: &Defect) -> String {
    format!("| {} | {} | ", defect.what, list(defect.codes))
}

/// A plain run sees a defect that is not in the table.
#[test]
fn every_defect_is_in_the_table() {
    let page = fs::read_to_string(root().join(PAGE)).expect("the page of lint");
    let missing: Vec<&str> =
        DEFECTS.iter().filter(|defect| !page.contains(&begin(defect))).map(|defect| defect.what).collect();
    let old = "run `INSTA_UPDATE=always cargo test --test suite -- --ignored mutations`";
    assert!(missing.is_empty(), "{PAGE} lacks {missing:?}: {old}");
}

/// Codes for the table.
fn list(codes: &[&str]) -> String {
    codes.iter().map(|code| format!("`{code}`")).collect::<Vec<_>>().join(", ")
}

fn table(rows: &str, scenes: usize) -> String {
    format!(
        "{} defects, each injected into each of the {scenes} scenes that has what it takes. *Caught* counts the scenes in which the \
         finding appears that the clean scene does not have, *also true* names findings that the defect may bring along, *wrong* counts all \
         others.\n\n\
         | defect | finding | caught | also true | wrong |\n|---|---|---|---|---|\n{rows}",
        DEFECTS.len()
    )
}

/// Compares the page with `table`, or rewrites it.
fn keep_current(table: &str) {
    let path = root().join(PAGE);
    let page = fs::read_to_string(&path).expect("the page of lint");
    let (before, rest) = page.split_once(BEGIN).expect("the place of the table");
    let (old, after) = rest.split_once(END).expect("the end of the table");
    if bless() {
        fs::write(&path, format!("{before}{BEGIN}{table}{END}{after}")).expect("the page is written");
    } else {
        assert_eq!(old, table, "{PAGE} is old: run it with INSTA_UPDATE=always");
    }
}

#[test]
fn every_rule_has_a_defect_that_it_catches() {
    let caught: BTreeSet<&str> = DEFECTS.iter().flat_map(|defect| defect.codes).copied().collect();
    let missing: Vec<&str> = RULES.iter().map(|rule| rule.id).filter(|id| !caught.contains(id)).collect();
    assert!(missing.is_empty(), "rules without a defect: {missing:?}");
    let codes: BTreeMap<&str, ()> = ltsc_core::diag::CODES.iter().map(|code| (code.id, ())).collect();
    let known = |id: &&str| RULES.iter().any(|rule| rule.id == *id) || codes.contains_key(id);
    let strange: Vec<&str> = DEFECTS
        .iter()
        .flat_map(|defect| defect.codes.iter().chain(defect.also))
        .copied()
        .filter(|id| !known(id))
        .collect();
    assert!(strange.is_empty(), "no such findings: {strange:?}");
}
