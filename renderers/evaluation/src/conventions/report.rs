//! Results as people and programs read them.

use serde_json::json;

use super::judge::Verdict;
use super::kinds::Convention;
use super::results::{Results, Row};
use super::scene;
use crate::failure::Failure;

/// The conventions with what each says in a sentence.
pub fn list(chosen: &[&'static Convention], as_json: bool) -> Result<String, Failure> {
    let mut text = String::new();
    let mut list = Vec::new();
    for convention in chosen {
        let brief = scene::documentation(convention)?.brief;
        let checks: usize = convention.views.iter().map(|view| view.checks.len()).sum();
        text.push_str(&format!("{:<22} {brief}\n", convention.name));
        list.push(json!({
            "name": convention.name, "brief": brief, "images": convention.views.len(), "checks": checks,
        }));
    }
    Ok(if as_json { format!("{:#}\n", json!({ "conventions": list })) } else { text })
}

/// A number in as few digits as tell it.
pub fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.1e}") } else { format!("{value:.4}") }
}

/// A deviation or a bound, with its unit.
pub fn size(value: f64, relative: bool) -> String {
    if relative { format!("{:.2} %", 100.0 * value) } else { number(value) }
}

/// The same with its sign.
fn signed(value: f64, relative: bool) -> String {
    if value > 0.0 { format!("+{}", size(value, relative)) } else { size(value, relative) }
}

/// The deviation of a row in words.
pub fn deviation(row: &Row) -> String {
    row.deviation.map_or_else(|| "none".to_owned(), |value| signed(value, row.relative))
}

/// How many rows have each verdict.
pub fn counts(rows: &[Row]) -> String {
    let of = |verdict: Verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let all = [Verdict::Holds, Verdict::Approximate, Verdict::Unsupported, Verdict::Fails];
    let parts: Vec<String> = all
        .into_iter()
        .filter(|verdict| of(*verdict) > 0)
        .map(|verdict| format!("{} {}", of(verdict), verdict.word()))
        .collect();
    if parts.is_empty() { "nothing measured".to_owned() } else { parts.join(", ") }
}

/// The table of a renderer, a line for each check.
pub fn table(results: &Results) -> String {
    let rows = &results.rows;
    let width = rows.iter().map(|row| row.what().chars().count()).max().unwrap_or(0);
    let mut text = format!("{} {}: {}\n", results.renderer, results.version, counts(rows));
    let mut last = "";
    for row in rows {
        if row.convention != last {
            text.push_str(&format!("\n{}\n", row.convention));
            last = &row.convention;
        }
        let what = row.what();
        let measured = row.measured.map_or_else(|| "none".to_owned(), number);
        text.push_str(&format!(
            "  {what:<width$}  expected {:>9}  measured {measured:>9}  off by {:>9} of {:>7}  {}\n",
            number(row.expected),
            deviation(row),
            size(row.bound, row.relative),
            row.verdict.word(),
        ));
        if let Some(because) = &row.because {
            text.push_str(&format!("  {:<width$}  {because}\n", ""));
        }
    }
    text
}

/// All results as one document.
pub fn json(all: &[Results]) -> String {
    format!("{:#}\n", json!({ "renderers": all }))
}

/// What moved against the stored results of the same renderer: verdicts that changed, and numbers that moved by more than
/// their bound. Of several versions the last one that is not this one is compared, else this one's own.
pub fn moved(stored: &[Results], new: &Results) -> Vec<String> {
    let mut same = stored.iter().filter(|old| old.renderer == new.renderer);
    let other = stored.iter().rfind(|old| old.renderer == new.renderer && old.version != new.version);
    let Some(old) = other.or_else(|| same.next()) else { return Vec::new() };
    changes(old, new)
}

/// What moved from one set of results to another, in sentences.
pub fn changes(old: &Results, new: &Results) -> Vec<String> {
    let mut lines = Vec::new();
    for row in &new.rows {
        let before = old.rows.iter().find(|before| {
            (&before.convention, &before.view, &before.check) == (&row.convention, &row.view, &row.check)
        });
        let Some(before) = before else { continue };
        let (Some(was), Some(is)) = (before.measured, row.measured) else { continue };
        let off = if row.relative { (is - was) / row.expected } else { is - was };
        if before.verdict == row.verdict && off.abs() <= row.bound {
            continue;
        }
        lines.push(format!(
            "{} ({}): {} in {} {}, {} in {}: {} is now {}",
            row.convention,
            row.what(),
            number(was),
            old.renderer,
            old.version,
            number(is),
            new.version,
            before.verdict.word(),
            row.verdict.word(),
        ));
    }
    lines
}
