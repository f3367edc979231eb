//! The page `renderers.md`: which renderer holds which convention, per version.

use super::judge::Verdict;
use super::kinds::{Convention, Expected};
use super::report::{changes, counts, deviation, number, size};
use super::results::{Asked, Results, Row, what};
use super::{scene, table};
use crate::failure::Failure;

const HEAD: &str = "\
# Which renderer holds which convention

*Written by `ltsc conventions --output docs`; a test holds it against the stored numbers. Do not edit.*

Each convention is a micro-scene (`renderers/evaluation/conventions`), written for every renderer by ltsc, and has an answer that no
renderer gave: a formula, a quadrature, or where there is neither a measurement that says of what. `ltsc conventions --renderer
NAME` renders and measures them in one or two minutes.

- **holds**: the number is the answer, within a bound that covers the noise of its samples.
- **approximate**: it is off, by no more than what `ltsc explain --target NAME` says of that target.
- **unsupported**: the target is said not to have it; the number is what it does instead.
- **fails**: it is off, and nothing says so.

Renderers that compute with wavelengths (pbrt-v4 and its port pbrt-r4) take the samples that the
bounds need; where those would be too many the bound is wider by the noise that is left.
";

/// The whole page.
pub fn page(all: &[Results], asked: &[Asked]) -> Result<String, Failure> {
    let mut text = HEAD.to_owned();
    text.push_str(&summary(all)?);
    text.push_str(&deviations(all));
    text.push_str(&history(all));
    text.push_str("\n## All numbers\n");
    for convention in table::all() {
        text.push_str(&details(convention, all, asked)?);
    }
    Ok(text)
}

/// Text that keeps its meaning in a cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").split_whitespace().collect::<Vec<_>>().join(" ")
}

fn heading(results: &Results) -> String {
    format!("{} {}", results.renderer, results.version)
}

fn rule(columns: usize) -> String {
    format!("|{}\n", "---|".repeat(columns))
}

/// A row for each convention, a column for each renderer and version.
fn summary(all: &[Results]) -> Result<String, Failure> {
    let mut text = String::from("\n| convention | what holds |");
    for results in all {
        text.push_str(&format!(" {} |", heading(results)));
    }
    text.push('\n');
    text.push_str(&rule(2 + all.len()));
    for convention in table::all() {
        let brief = scene::documentation(convention)?.brief;
        text.push_str(&format!("| [`{}`](#{}) | {} |", convention.name, convention.name, cell(&brief)));
        for results in all {
            let worst = rows_of(results, convention).map(|row| row.verdict).max();
            text.push_str(&format!(" {} |", worst.map_or("not measured", Verdict::word)));
        }
        text.push('\n');
    }
    text.push_str("| all checks | |");
    for results in all {
        text.push_str(&format!(" {} |", counts(&results.rows)));
    }
    text.push('\n');
    Ok(text)
}

fn rows_of<'r>(results: &'r Results, convention: &'r Convention) -> impl Iterator<Item = &'r Row> {
    results.rows.iter().filter(|row| row.convention == convention.name)
}

/// Everything that does not hold, with where it is stated.
fn deviations(all: &[Results]) -> String {
    let mut text = String::from("\n## What does not hold\n");
    for results in all {
        let off: Vec<&Row> = results.rows.iter().filter(|row| row.verdict != Verdict::Holds).collect();
        text.push_str(&format!("\n### {}\n\n", heading(results)));
        if off.is_empty() {
            text.push_str("Everything holds.\n");
            continue;
        }
        text.push_str("| convention | check | expected | measured | off by | verdict | because |\n");
        text.push_str(&rule(7));
        for row in off {
            text.push_str(&format!(
                "| `{}` | {} | {} | {} | {} | {} | {} |\n",
                row.convention,
                cell(&row.what()),
                number(row.expected),
                row.measured.map_or_else(|| "none".to_owned(), number),
                deviation(row),
                row.verdict.word(),
                cell(row.because.as_deref().unwrap_or("nothing says so")),
            ));
        }
    }
    text
}

/// What moved from one version of a renderer to the next.
fn history(all: &[Results]) -> String {
    let mut text = String::new();
    for pair in all.windows(2) {
        let [old, new] = pair else { continue };
        if old.renderer != new.renderer {
            continue;
        }
        text.push_str(&format!("\n### From {} to {}\n\n", heading(old), new.version));
        let lines = changes(old, new);
        if lines.is_empty() {
            text.push_str("Nothing moved.\n");
        }
        for line in lines {
            text.push_str(&format!("- {line}\n"));
        }
    }
    if text.is_empty() { text } else { format!("\n## What moved between versions\n{text}") }
}

/// A convention with its words and all its numbers.
fn details(convention: &Convention, all: &[Results], asked: &[Asked]) -> Result<String, Failure> {
    let documentation = scene::documentation(convention)?;
    let mut text = format!("\n### {}\n\n{} {}\n\n", convention.name, documentation.brief, documentation.full);
    text.push_str("| check | expected | bound |");
    for results in all {
        text.push_str(&format!(" {} |", heading(results)));
    }
    text.push('\n');
    text.push_str(&rule(3 + all.len()));
    for one in asked.iter().filter(|one| one.convention.name == convention.name) {
        for (check, expected) in one.checks() {
            let source = match check.expected {
                Expected::Reference { value: _, by } => format!(" ({by})"),
                Expected::Number(_) | Expected::Formula(_) | Expected::Ideal => String::new(),
            };
            let (bound, relative) = check.tolerance.parts();
            text.push_str(&format!(
                "| {} | {}{source} | {} |",
                cell(&what(one.view.name, check.name)),
                number(expected),
                size(bound, relative)
            ));
            for results in all {
                let row = results.rows.iter().find(|row| one.is(check, row));
                let row = row.map(|row| row.measured.map_or_else(|| "none".to_owned(), number));
                text.push_str(&format!(" {} |", row.unwrap_or_else(|| "not measured".to_owned())));
            }
            text.push('\n');
        }
    }
    Ok(text)
}
