//! What is said of findings where they are not the answer of a command: each thing once, the rest counted, with the command that
//! shows it.

use std::collections::BTreeMap;
use std::path::Path;

use ltsc_core::diag::{Finding, Severity};
use ltsc_core::ledger::{Ledger, percent};
use serde_json::Value;

use crate::output::Located;
use crate::terminal;

/// Different warnings that are shown.
const WARNINGS: usize = 8;

/// Losses that are shown of one target, unless all are asked for.
const LOSSES: usize = 4;

/// `1 warning`, `2 warnings`.
pub fn plural(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A path as it is seen from the current folder.
pub fn from_here(path: &Path) -> std::path::Display<'_> {
    let here = std::env::current_dir().ok();
    here.and_then(|here| path.strip_prefix(here).ok())
        .filter(|path| !path.as_os_str().is_empty())
        .unwrap_or(path)
        .display()
}

/// A line for each different warning, with how many more there are of its kind.
pub fn warnings(all: &[&Located<'_>]) -> Vec<String> {
    let mut kinds: Vec<(&str, String, usize)> = Vec::new();
    for located in all {
        match kinds.iter_mut().find(|(id, _, _)| *id == located.finding.id) {
            Some((_, _, more)) => *more += 1,
            None => kinds.push((located.finding.id, located.short(), 0)),
        }
    }
    let rest: usize = kinds.iter().skip(WARNINGS).map(|(_, _, more)| more + 1).sum();
    let line = |(_, text, more): &(&str, String, usize)| match more {
        0 => text.clone(),
        more => format!("{text} (and {more} more like it)"),
    };
    let mut lines: Vec<String> = kinds.iter().take(WARNINGS).map(line).collect();
    if rest > 0 {
        lines.push(format!("... and {} of other kinds", plural(rest, "warning")));
    }
    lines
}

/// What a target does not say exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    what: String,
    dropped: bool,
    /// The largest difference, where it can be computed.
    most: Option<f64>,
}

/// The losses of a ledger.
pub fn losses_of(ledger: &Ledger) -> Vec<Loss> {
    let approximated = ledger.approximated.iter().map(|one| {
        let most = one.here.as_ref().map(|here| here.at_most);
        Loss { what: one.what.to_owned(), dropped: false, most }
    });
    let dropped = ledger.dropped.iter().map(|one| Loss { what: one.what.to_owned(), dropped: true, most: None });
    approximated.chain(dropped).collect()
}

/// The losses of a ledger that was written before; none where there is none.
pub fn losses_written(text: &[u8]) -> Vec<Loss> {
    let Ok(ledger) = serde_json::from_slice::<Value>(text) else { return Vec::new() };
    let list = |key: &str| ledger[key].as_array().cloned().unwrap_or_default();
    let loss = |one: Value, dropped: bool| {
        let what = one["what"].as_str()?.to_owned();
        Some(Loss { what, dropped, most: one["here"]["at_most"].as_f64() })
    };
    let approximated = list("approximated").into_iter().filter_map(|one| loss(one, false));
    approximated.chain(list("dropped").into_iter().filter_map(|one| loss(one, true))).collect()
}

/// The losses of several scenes for several targets; `of` has those of each scene, by target. Each is said once for all targets that
/// share the list, the largest difference first, and with the number of its scenes where `scenes` are several.
pub fn losses(of: &[Vec<(&'static str, Vec<Loss>)>], scenes: usize, all: bool) -> Vec<String> {
    let mut order: Vec<&'static str> = Vec::new();
    let mut by_target: BTreeMap<&'static str, Vec<(Loss, usize)>> = BTreeMap::new();
    for (target, lost) in of.iter().flatten() {
        if !order.contains(target) {
            order.push(target);
        }
        let known = by_target.entry(target).or_default();
        for loss in lost {
            match known.iter_mut().find(|(other, _)| (&other.what, other.dropped) == (&loss.what, loss.dropped)) {
                Some((other, count)) => {
                    other.most = other.most.into_iter().chain(loss.most).reduce(f64::max);
                    *count += 1;
                }
                None => known.push((loss.clone(), 1)),
            }
        }
    }
    let mut lines: Vec<(Vec<&str>, String)> = Vec::new();
    for dropped in [false, true] {
        for target in &order {
            let Some(known) = by_target.get(target) else { continue };
            let mut known: Vec<&(Loss, usize)> = known.iter().filter(|(loss, _)| loss.dropped == dropped).collect();
            known.sort_by(|(one, _), (other, _)| other.most.unwrap_or(0.0).total_cmp(&one.most.unwrap_or(0.0)));
            if known.is_empty() {
                continue;
            }
            let shown = if all { known.len() } else { LOSSES };
            let mut words: Vec<String> = known.iter().take(shown).map(|one| loss_words(one, scenes)).collect();
            if known.len() > shown {
                words.push(format!("{} more", known.len() - shown));
            }
            let text = format!("{}: {}", if dropped { "not supported" } else { "approximated" }, words.join(", "));
            match lines.iter_mut().find(|(_, known)| *known == text) {
                Some((targets, _)) => targets.push(target),
                None => lines.push((vec![target], text)),
            }
        }
    }
    lines.into_iter().map(|(targets, text)| format!("{}: {text}", targets.join(", "))).collect()
}

fn loss_words((loss, count): &(Loss, usize), scenes: usize) -> String {
    let most = loss.most.map(|most| format!("by up to {}", percent(most)));
    let count = (scenes > 1).then(|| if *count == scenes { "all scenes".to_owned() } else { plural(*count, "scene") });
    match most.into_iter().chain(count).collect::<Vec<_>>().join(", ").as_str() {
        "" => loss.what.clone(),
        more => format!("{} ({more})", loss.what),
    }
}

/// What the file of one scene was read without, and how many other warnings and losses there are, in a line. What a reader left out is no
/// matter of taste: the image is another one without it.
pub fn one_scene(findings: &[Finding], ledger: Option<&Ledger>, file: &Path) {
    let warnings = || findings.iter().filter(|finding| finding.severity == Severity::Warn);
    let unread = |finding: &&Finding| finding.id.starts_with("loss-");
    for finding in warnings().filter(unread) {
        terminal::say(&format!("warning: {}", finding.message));
    }
    let others = warnings().filter(|finding| !unread(finding)).count();
    let lost = ledger.map_or(0, |ledger| ledger.approximated.len() + ledger.dropped.len());
    let mut words = Vec::new();
    if others > 0 {
        words.push(plural(others, "warning"));
    }
    let mut target = String::new();
    if let Some(ledger) = ledger.filter(|_| lost > 0) {
        words.push(format!(
            "{} in {}",
            if lost == 1 { "1 loss".to_owned() } else { format!("{lost} losses") },
            ledger.target
        ));
        target = format!(" --target {}", ledger.target);
    }
    if !words.is_empty() {
        terminal::say(&format!("{}: `ltsc lint {}{target}` shows them", words.join(", "), from_here(file)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(what: &str, dropped: bool, most: Option<f64>) -> Loss {
        Loss { what: what.to_owned(), dropped, most }
    }

    #[test]
    fn losses_are_said_once_for_all_scenes_and_targets_that_share_them() {
        let first = vec![loss("plastic", false, None), loss("metal", false, Some(0.02)), loss("samples", true, None)];
        let second = vec![loss("metal", false, Some(0.5)), loss("samples", true, None)];
        let of = |lost: &[Loss]| vec![("a", lost.to_vec()), ("b", lost.to_vec()), ("c", Vec::new())];
        let lines = losses(&[of(&first), of(&second)], 2, false);
        assert_eq!(
            lines,
            [
                "a, b: approximated: metal (by up to 50.0 %, all scenes), plastic (1 scene)",
                "a, b: not supported: samples (all scenes)",
            ]
        );
        let one = losses(&[of(&first)], 1, false);
        assert_eq!(one[0], "a, b: approximated: metal (by up to 2.00 %), plastic");
    }

    #[test]
    fn a_long_list_ends_with_a_number_unless_all_is_asked_for() {
        let lost: Vec<Loss> = (0..7).map(|at| loss(&format!("w{at}"), false, None)).collect();
        let of = [vec![("a", lost)]];
        assert_eq!(losses(&of, 1, false), ["a: approximated: w0, w1, w2, w3, 3 more"]);
        assert_eq!(losses(&of, 1, true), ["a: approximated: w0, w1, w2, w3, w4, w5, w6"]);
    }

    #[test]
    fn a_ledger_that_was_written_is_read() {
        let text = br#"{ "approximated": [{ "what": "metal", "here": { "at_most": 0.5, "of": "light" } }, { "what": "plastic" }], "dropped": [{ "what": "samples" }] }"#;
        let known = [loss("metal", false, Some(0.5)), loss("plastic", false, None), loss("samples", true, None)];
        assert_eq!(losses_written(text), known);
        assert_eq!(losses_written(b"{"), []);
    }
}
