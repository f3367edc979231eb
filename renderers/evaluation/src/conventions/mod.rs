//! Micro-scenes with known answers through real renderers, and a page of what holds where.

pub mod coverage;
mod formula;
mod ideal;
pub mod judge;
pub mod kinds;
mod measure;
mod noise;
pub mod page;
mod records;
pub mod report;
pub mod results;
pub mod scene;
pub mod table;
#[cfg(test)]
mod tests;

use std::path::Path;

use ltsc_core::diag::nearest;
use ltsc_core::formats::Target;
use ltsc_render::regular;
use ltsc_render::run::{Driver, RenderError};

use crate::disk::{Done, Pages};
use crate::failure::{Exit, Failure};
use crate::job::{Job, Runner, driver_called, target_of};
use crate::watch::Watch;
use judge::Verdict;
use kinds::Convention;
use results::{Asked, Results, Row, Unmeasured};

/// The page, below the folder of pages.
pub const PAGE: &str = "renderers.md";

/// The conventions called so, in the order of the table; all of them if nothing is named.
///
/// # Errors
/// Usage, for a name that is not in the table.
pub fn chosen(only: &[String]) -> Result<Vec<&'static Convention>, Failure> {
    for name in only {
        if table::all().any(|convention| convention.name == name) {
            continue;
        }
        let failure = Failure::new(Exit::Usage, format!("there is no convention `{name}`"));
        return Err(match nearest(name, table::all().map(|convention| convention.name)) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help("`ltsc conventions --list` shows them"),
        });
    }
    let wanted = |convention: &&Convention| only.is_empty() || only.iter().any(|name| name == convention.name);
    Ok(table::all().filter(wanted).collect())
}

/// All views with their answers; what is wrong with a scene shows before the first one is rendered.
///
/// # Errors
/// A fault of ltsc, where a scene is not valid.
pub fn asked(chosen: &[&'static Convention]) -> Result<Vec<Asked>, Failure> {
    let views = chosen.iter().flat_map(|convention| convention.views.iter().map(|view| (*convention, view)));
    views.map(|(convention, view)| Asked::new(convention, view)).collect()
}

/// Renders all views and measures them.
///
/// # Errors
/// Where a scene cannot be written. A renderer that fails is a result.
pub fn measured(runner: &Runner, asked: &[Asked], watch: &mut dyn Watch) -> Result<Results, Failure> {
    let target = target_of(runner.driver);
    watch.begin(asked.len() as u64, runner.driver.name);
    let mut version = runner.found.version.clone();
    let mut rows = Vec::new();
    for (done, one) in (0..).zip(asked) {
        watch.set(done);
        watch.doing(&format!("{} ({})", one.convention.name, runner.driver.name));
        let job = Job::new(&one.scene, runner)?;
        let image = match job.render(noise::samples(runner.driver, one), one.scene.sampler.seed(), &mut |_| {}) {
            Ok(rendered) => {
                version = Some(rendered.renderer_version).filter(|found| !found.is_empty()).unwrap_or(version);
                Ok(rendered.image)
            }
            Err(error) => {
                let refused = matches!(error, RenderError::Request { .. });
                let verdict = if refused { Verdict::Unsupported } else { Verdict::Fails };
                Err(Unmeasured { verdict, reason: error.to_string() })
            }
        };
        for (at, (check, _)) in one.checks().enumerate() {
            let ideal = || ideal::Ideal::new(&one.scene).image();
            let measured = image.as_ref().map(|image| measure::measure(&check.measure, image, &ideal));
            rows.push(one.row(at, (runner.driver, target), measured.map_err(Clone::clone)));
        }
    }
    watch.end();
    Ok(Results { renderer: runner.driver.name.to_owned(), version, rows })
}

/// Judges what is kept again, and writes the page; with `check` only says what would change.
///
/// # Errors
/// Where results cannot be read, or pages of others are there.
pub fn stored(pages: &Path, check: bool, force: bool) -> Result<Done, Failure> {
    let all: Vec<&'static Convention> = table::all().collect();
    let asked = asked(&all)?;
    let mut kept = results::load(pages)?;
    let mut written = Pages::new(pages, results::BY);
    for results in &mut kept {
        let driver = driver_called(&results.renderer)?;
        let target = target_of(driver);
        let before = results::text(results);
        results.rows = again(&results.rows, &asked, (driver, target));
        let (name, after) = (results::name(&results.renderer, &results.version), results::text(results));
        // Numbers that are judged as before stay as they are written.
        let there = (before == after).then(|| regular::read_text(&pages.join(&name), regular::TEXT).ok()).flatten();
        written.put_merged(name, there.unwrap_or(after));
    }
    written.put(PAGE, page::page(&kept, &asked)?);
    written.put(coverage::FILE, coverage::text(&kept, &asked));
    written.keep(|_| true);
    written.finish(check, force)
}

/// The rows of the checks that were measured, judged by the table of today.
fn again(rows: &[Row], asked: &[Asked], by: (&Driver, &Target)) -> Vec<Row> {
    let mut all = Vec::new();
    for one in asked {
        for (at, (check, _)) in one.checks().enumerate() {
            let Some(row) = rows.iter().find(|row| one.is(check, row)) else { continue };
            let measured = match (row.measured, &row.because) {
                (None, Some(reason)) => Err(Unmeasured { verdict: row.verdict, reason: reason.clone() }),
                (measured, _) => Ok(measured),
            };
            all.push(one.row(at, by, measured));
        }
    }
    all
}
