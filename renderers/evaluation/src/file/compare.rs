//! What is compared with what.

use std::collections::BTreeSet;

use ltsc_core::diag::Span;

use super::model::{At, Evaluation, Pair, Reference, Run, Side};
use super::resolve::{Findings, reference_of};
use super::surroundings::Surroundings;
use super::written::{Against, MOST_RUNS, REFERENCE, Written, WrittenCompare};
use crate::compare::verdict::Tolerance;

/// The tolerance, the default where nothing is said.
pub(super) fn tolerance(written: &WrittenCompare) -> Tolerance {
    let Tolerance { tiles, whole } = Tolerance::default();
    let value = |given: Option<At<f64>>, own: f64| given.map_or(own, |given| given.value);
    Tolerance { tiles: value(written.tolerance, tiles), whole: value(written.mean_tolerance, whole) }
}

/// A side of a pair by its name: a case, and a renderer where only one is meant.
type Named = (usize, Option<usize>);

/// Looks a side up: the name of a case, or `case/renderer`.
fn side(evaluation: &Evaluation, name: &str) -> Option<Named> {
    let case = |name: &str| evaluation.cases.iter().position(|case| case.name.value == name);
    if let Some(found) = case(name) {
        return Some((found, None));
    }
    let (first, renderer) = name.rsplit_once('/')?;
    let found = case(first)?;
    let renderer = evaluation.cases[found]
        .variants
        .iter()
        .position(|variant| evaluation.renderers[variant.renderer].name == renderer)?;
    Some((found, Some(renderer)))
}

fn labels(evaluation: &Evaluation) -> Vec<String> {
    let mut found = Vec::new();
    for case in &evaluation.cases {
        found.push(case.name.value.clone());
        if case.variants.len() > 1 {
            let name = |renderer: usize| evaluation.renderers[renderer].name.as_str();
            found.extend(case.variants.iter().map(|own| format!("{}/{}", case.name.value, name(own.renderer))));
        }
    }
    found
}

/// Says which names of cases and renderers are not known, and what is compared with itself.
pub(super) fn names(evaluation: &Evaluation, written: &Written, findings: &mut Findings) {
    let labels = labels(evaluation);
    for At { value: (a, b), span } in &written.compare.pairs {
        for name in [a, b] {
            let reference = name == REFERENCE && name == a;
            // A case that is wrong itself is not there, and not unknown.
            let there = |name: &str| written.cases.iter().any(|case| case.name.value == name);
            let wrong = evaluation.cases.len() < written.cases.len()
                && (there(name) || name.rsplit_once('/').is_some_and(|(case, _)| there(case)));
            if !reference && !wrong && side(evaluation, name).is_none() {
                let known = labels.iter().map(String::as_str).chain([REFERENCE]);
                findings.unknown("case", &At::new(name.clone(), *span), known);
            }
        }
        if a == b {
            findings.error("evaluation-value", *span, format!("`{a}` is compared with itself"));
        }
    }
    let own = evaluation.cases.iter().filter_map(|case| case.reference.as_ref());
    let of_scenes = evaluation.scenes.iter().filter_map(|scene| scene.reference.as_ref());
    for At { value, span } in own.chain(of_scenes).chain(&written.reference) {
        let Reference::Case { case, renderer } = value else { continue };
        let Some(found) = evaluation.cases.iter().find(|other| other.name.value == *case) else {
            if !written.cases.iter().any(|other| other.name.value == *case) {
                let known = written.cases.iter().map(|case| case.name.value.as_str());
                findings.unknown("case", &At::new(case.clone(), *span), known);
            }
            continue;
        };
        let own: Vec<&str> =
            found.variants.iter().map(|variant| evaluation.renderers[variant.renderer].name.as_str()).collect();
        if let Some(renderer) = renderer.as_ref().filter(|name| !own.contains(&name.as_str())) {
            let what = format!("renderer of the case `{case}` called");
            findings.unknown(&what, &At::new(renderer.clone(), *span), own);
        }
    }
}

/// The pairs of all conditions.
pub(super) fn pairs(
    evaluation: &Evaluation,
    written: &Written,
    around: &dyn Surroundings,
    findings: &mut Findings,
) -> Vec<Pair> {
    let against = written.compare.against;
    let mut found: Vec<Pair> = Vec::new();
    let mut known: BTreeSet<(Option<usize>, Option<String>, usize)> = BTreeSet::new();
    let mut referenced = false;
    let mut start = 0;
    while let Some(first) = evaluation.runs.get(start) {
        let count = evaluation.runs[start..].iter().take_while(|run| run.condition == first.condition).count();
        let runs = start..start + count;
        start = runs.end;
        let mut add = |a: Side, b: usize, span: Option<Span>| {
            let key = match &a {
                Side::Run(run) => (Some(*run), None, b),
                Side::File(path) => (None, Some(path.clone()), b),
            };
            if a != Side::Run(b) && known.insert(key) {
                found.push(Pair { a, b, span });
            }
        };
        let references: Vec<Option<Side>> =
            runs.clone().map(|run| reference(evaluation, written, around, run, runs.clone(), findings)).collect();
        referenced |= references.iter().any(Option::is_some);
        match against.map(|against| against.value) {
            Some(Against::Nothing) => {}
            None if !written.compare.pairs.is_empty() => {}
            None => {
                for (run, reference) in runs.clone().zip(&references) {
                    add(reference.clone().unwrap_or(Side::Run(runs.start)), run, None);
                }
            }
            Some(Against::First) => {
                for run in runs.clone() {
                    add(Side::Run(runs.start), run, against.map(|against| against.span));
                }
            }
            Some(Against::Reference) => {
                for (run, reference) in runs.clone().zip(&references) {
                    if let Some(reference) = reference {
                        add(reference.clone(), run, against.map(|against| against.span));
                    }
                }
            }
            Some(Against::All) => {
                for a in runs.clone() {
                    for b in a + 1..runs.end {
                        add(Side::Run(a), b, against.map(|against| against.span));
                    }
                }
            }
        }
        for At { value: (a, b), span } in &written.compare.pairs {
            let of = |name: &str| -> Vec<usize> {
                let Some((case, variant)) = side(evaluation, name) else { return Vec::new() };
                let own = |run: &usize| {
                    let Run { case: other, variant: of, condition: _ } = evaluation.runs[*run];
                    other == case && variant.is_none_or(|variant| variant == of)
                };
                runs.clone().filter(own).collect()
            };
            for run in of(b) {
                if a == REFERENCE && side(evaluation, a).is_none() {
                    if let Some(Some(reference)) = references.get(run - runs.start) {
                        add(reference.clone(), run, Some(*span));
                    }
                    continue;
                }
                let all = of(a);
                let renderer = |run: usize| evaluation.variant(evaluation.runs[run]).renderer;
                let same: Vec<usize> = all.iter().copied().filter(|other| renderer(*other) == renderer(run)).collect();
                for other in if same.is_empty() { all } else { same } {
                    add(Side::Run(other), run, Some(*span));
                }
            }
        }
        if found.len() > MOST_RUNS {
            let place = against.map_or(evaluation.cases[first.case].span, |against| against.span);
            findings.error("evaluation-value", place, format!("there are more than {MOST_RUNS} comparisons"));
            return Vec::new();
        }
    }
    if let Some(against) = against.filter(|against| against.value == Against::Reference && !referenced) {
        findings.error("evaluation-missing", against.span, "nothing has a reference").help =
            Some("write `reference = \"FILE.exr\"`, `\"convention\"` or `{ case = \"NAME\" }`".to_owned());
    }
    found
}

/// The reference of a run among those of its condition.
fn reference(
    evaluation: &Evaluation,
    written: &Written,
    around: &dyn Surroundings,
    at: usize,
    runs: std::ops::Range<usize>,
    findings: &mut Findings,
) -> Option<Side> {
    let run = evaluation.runs[at];
    let At { value, span } = reference_of(evaluation, written, run)?;
    let condition = &evaluation.conditions[run.condition];
    let scene = &evaluation.scenes[condition.scene];
    let renderer = evaluation.renderer(run);
    match value {
        Reference::Nothing => None,
        Reference::Convention => around.reference(&scene.source, renderer.target).map(Side::File),
        Reference::File(pattern) => {
            let path = fill(pattern, |name| match name {
                "scene" => scene.name.clone(),
                "condition" => condition.name.clone(),
                "case" => evaluation.cases[run.case].name.value.clone(),
                "renderer" => renderer.name.clone(),
                _ => renderer.target.name.to_owned(),
            });
            if !around.has_file(&path) {
                let message = format!("there is no reference `{path}`");
                findings.error("unreadable-file", *span, message);
            }
            Some(Side::File(path))
        }
        Reference::Case { case, renderer: wanted } => {
            let of_case = |other: &usize| evaluation.cases[evaluation.runs[*other].case].name.value == *case;
            let all: Vec<usize> = runs.filter(of_case).collect();
            let name = |other: usize| evaluation.renderer(evaluation.runs[other]).name.as_str();
            let wanted = wanted.as_deref().unwrap_or(renderer.name.as_str());
            let same = all.iter().copied().find(|other| name(*other) == wanted);
            let only = || if let [only] = all.as_slice() { Some(*only) } else { None };
            same.or_else(only).filter(|other| *other != at).map(Side::Run)
        }
    }
}

/// The text with what takes the place of placeholders.
fn fill(pattern: &str, value: impl Fn(&str) -> String) -> String {
    let mut filled = String::new();
    let mut rest = pattern;
    while let Some((before, after)) = rest.split_once('{') {
        let (name, behind) = after.split_once('}').unwrap_or((after, ""));
        filled.push_str(before);
        filled.push_str(&value(name));
        rest = behind;
    }
    filled + rest
}
