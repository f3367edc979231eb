//! Every limit that lint knows, broken once in each scene: the rule that is for it must find it, and no other rule may speak that
//! has no reason to. The result is a table in `docs/lint.md`. A plain run asks only the rules that are for a defect; a run that
//! rewrites expectations, or that requires all, asks every rule about every broken scene, which takes minutes.

mod defects;
mod mutant;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use ltsc_core::lint::{Level, Levels, RULES};

use self::defects::{Broken, DEFECTS, Defect};
use self::mutant::Mutant;
use super::{bless, root};

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

/// The rules that are for a defect.
fn only(codes: &[&str]) -> Levels {
    let mut levels = Levels::default();
    levels.set("all", Level::Allow).expect("a group");
    for code in codes.iter().filter(|code| RULES.iter().any(|rule| rule.id == **code)) {
        levels.set(code, Level::Warn).expect("a rule");
    }
    levels
}

/// Whether all rules look at each broken scene, so that those that are wrong are seen; it takes minutes. Otherwise only those do
/// that are for the defect.
fn thorough() -> bool {
    bless() || std::env::var_os("LTSC_REQUIRE_ALL").is_some_and(|value| value == "1")
}

fn outcome(defect: &Defect, clean: &Mutant, before: &[(String, String)]) -> Outcome {
    let mut mutant = clean.clone();
    let after = match (defect.inject)(&mut mutant) {
        Broken::Impossible => return Outcome { possible: false, caught: false, wrong: Vec::new() },
        Broken::Scene => {
            let mut found = mutant.findings(&if thorough() { every_rule() } else { only(defect.codes) });
            // Validation has a look where it is to find something: it takes longer than all rules.
            if defect.codes.iter().any(|code| code.starts_with("invalid-")) {
                found.extend(mutant.refused());
            }
            found
        }
        Broken::Refused(codes) => codes,
    };
    let known: BTreeSet<&(String, String)> = before.iter().collect();
    let caught = after.iter().any(|found| defect.codes.contains(&found.0.as_str()) && !known.contains(found));
    let count = |list: &[(String, String)], id: &str| list.iter().filter(|found| found.0 == id).count();
    let explained = |id: &str| defect.codes.contains(&id) || defect.also.contains(&id);
    let wrong = after.iter().filter(|found| !explained(&found.0) && !known.contains(found));
    let wrong = wrong.filter(|(id, _)| count(&after, id) > count(before, id));
    let wrong = wrong.map(|(id, message)| format!("{id}: {message}")).collect();
    Outcome { possible: true, caught, wrong }
}

#[test]
fn every_defect_is_caught_in_every_scene() {
    let scenes = Mutant::all();
    assert!(scenes.len() >= 11, "{} scenes", scenes.len());
    // One thread for each scene; results in the order of the scenes.
    let results: Vec<Vec<Outcome>> = std::thread::scope(|scope| {
        let of = |clean: &Mutant| {
            let before = clean.findings(&every_rule());
            DEFECTS.iter().map(|defect| outcome(defect, clean, &before)).collect()
        };
        let threads: Vec<_> = scenes.iter().map(|clean| scope.spawn(move || of(clean))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a scene that is linted")).collect()
    });
    let mut problems = Vec::new();
    let mut rows = String::new();
    for (at, defect) in DEFECTS.iter().enumerate() {
        let of: Vec<(&str, &Outcome)> =
            scenes.iter().zip(&results).map(|(scene, outcomes)| (scene.scene.name.as_str(), &outcomes[at])).collect();
        let names = |which: &dyn Fn(&Outcome) -> bool| {
            of.iter().filter(|(_, outcome)| which(outcome)).map(|(name, _)| *name).collect::<Vec<_>>()
        };
        let missed = names(&|outcome| outcome.possible && !outcome.caught);
        if !missed.is_empty() {
            problems.push(format!("`{}` is missed in {}", defect.what, missed.join(", ")));
        }
        let wrong: BTreeSet<&String> = of.iter().flat_map(|(_, outcome)| &outcome.wrong).collect();
        for found in wrong.iter().take(5) {
            let where_ = names(&|outcome| outcome.wrong.contains(*found));
            problems.push(format!("`{}` gives {found} in {}", defect.what, where_.join(", ")));
        }
        let possible = names(&|outcome| outcome.possible).len();
        let caught = names(&|outcome| outcome.caught).len();
        let wrong: usize = of.iter().map(|(_, outcome)| outcome.wrong.len()).sum();
        if possible == 0 {
            problems.push(format!("no scene has what `{}` needs", defect.what));
        }
        rows.push_str(&format!(
            "| {} | {} | {caught}/{possible} | {} | {wrong} |\n",
            defect.what,
            list(defect.codes),
            list(defect.also)
        ));
    }
    assert!(problems.is_empty(), "{} problems:\n{}", problems.len(), problems.join("\n"));
    keep_current(&table(&rows, scenes.len()));
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
        assert_eq!(old, table, "{PAGE} is old: run with INSTA_UPDATE=always");
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
