//! `ltsc conventions`: micro-scenes with known answers through real renderers, and a page of what holds where.

mod coverage;
mod formula;
mod ideal;
mod judge;
mod kinds;
mod measure;
mod noise;
mod page;
mod records;
mod report;
mod results;
mod scene;
mod table;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::time::Duration;

use ltsc_core::diag::nearest;
use ltsc_core::formats::Target;
use ltsc_render::regular;
use ltsc_render::run::{Driver, RenderError};

use crate::args::{Conventions, Format};
use crate::disk::{Pages, probe};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};
use crate::terminal::{self, Bar};

use super::job::{Job, Runner};
use super::render::find_driver;
pub use coverage::built_in as measured_by;
use judge::Verdict;
use kinds::Convention;
use results::{Asked, Results, Row, Unmeasured};

/// The page, below the folder of pages.
const PAGE: &str = "renderers.md";

pub fn run(command: &Conventions) -> Result<Exit, Failure> {
    let chosen = chosen(&command.only)?;
    if command.list {
        terminal::print(&report::list(&chosen, command.format == Format::Json)?);
        return Ok(Exit::Done);
    }
    if command.coverage {
        return covered(command.output.as_deref().unwrap_or(Path::new("docs")), command.format);
    }
    let drivers = command.renderer.iter().map(|name| find_driver(name)).collect::<Result<Vec<_>, _>>()?;
    if let (true, Some(pages)) = (command.stored, &command.output) {
        return stored(pages, command);
    }
    if drivers.is_empty() {
        let known: Vec<&str> = ltsc_render::run::DRIVERS.iter().map(|driver| driver.name).collect();
        return Err(Failure::new(Exit::Usage, "no renderer is named")
            .help(format!("add `--renderer NAME`: {}; or `--list`", known.join(", "))));
    }
    if drivers.len() > 1 && command.executable.is_some() {
        return Err(Failure::new(Exit::Usage, "one executable cannot be several renderers").help("name one renderer"));
    }
    // All of them are looked for before the first one starts.
    let runners = drivers.iter().map(|driver| runner(command, driver)).collect::<Result<Vec<_>, _>>()?;
    if let Some(folder) = &command.output {
        probe(folder)?;
        let pages = Pages::new(folder, results::BY);
        let files = runners.iter().filter_map(|runner| {
            let version = runner.found.version.as_str();
            Some(results::name(runner.driver.name, Some(version).filter(|version| !version.is_empty())?))
        });
        for name in files.chain([PAGE.to_owned(), coverage::FILE.to_owned()]) {
            pages.refuse(&name, command.force)?;
        }
    }
    let asked = asked(&chosen)?;
    let mut all = Vec::new();
    for runner in &runners {
        let results = measured(runner, &asked)?;
        if command.format != Format::Json {
            terminal::print(&report::table(&results));
        }
        all.push(results);
    }
    if command.format == Format::Json {
        terminal::print(&report::json(&all));
    }
    if let Some(pages) = &command.output {
        for results in &all {
            let kept = results::load(pages)?;
            for line in report::moved(&kept, results) {
                terminal::say(&line);
            }
            let path = results::save(pages, &results.beside(&kept, &chosen), command.force)?;
            terminal::say(&format!("{} written", path.display()));
        }
        stored(pages, command)?;
    }
    let worst = all.iter().flat_map(|results| &results.rows).map(|row| row.verdict).max();
    Ok(if worst == Some(Verdict::Fails) { Exit::No } else { Exit::Done })
}

/// The conventions called so, in the order of the table; all of them if nothing is named.
fn chosen(only: &[String]) -> Result<Vec<&'static Convention>, Failure> {
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

fn runner(command: &Conventions, driver: &'static Driver) -> Result<Runner, Failure> {
    let project = Project::here().ok();
    let timeout = Some(Duration::from_secs(command.timeout));
    let found = Runner::find(driver, command.executable.as_deref(), project.as_ref(), timeout)?;
    Ok(Runner { threads: Some(command.threads as usize), ..found })
}

/// All views with their answers; what is wrong with a scene shows before the first one is rendered.
fn asked(chosen: &[&'static Convention]) -> Result<Vec<Asked>, Failure> {
    let views = chosen.iter().flat_map(|convention| convention.views.iter().map(|view| (*convention, view)));
    views.map(|(convention, view)| Asked::new(convention, view)).collect()
}

/// Renders all views and measures them.
fn measured(runner: &Runner, asked: &[Asked]) -> Result<Results, Failure> {
    let target = project::target(runner.driver.target)?;
    let mut bar = Bar::new(asked.len() as u64, runner.driver.name);
    let mut version = runner.found.version.clone();
    let mut rows = Vec::new();
    for (done, one) in (0..).zip(asked) {
        bar.set(done);
        bar.say(&format!("{} ({})", one.convention.name, runner.driver.name));
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
    bar.finish();
    Ok(Results { renderer: runner.driver.name.to_owned(), version, rows })
}

/// Prints which answers of targets were measured; the answer is no where one was not.
fn covered(pages: &Path, format: Format) -> Result<Exit, Failure> {
    let kept = results::load(pages)?;
    if kept.is_empty() {
        let place = results::folder(pages);
        return Err(Failure::new(Exit::Input, format!("{} holds no results", place.display())).help(
            "name the folder of pages by `--output DIR`; `ltsc conventions --renderer NAME --output DIR` fills it",
        ));
    }
    let all = coverage::of_renderers(&kept, &asked(&table::all().collect::<Vec<_>>())?);
    terminal::print(&if format == Format::Json { coverage::json(&all) } else { coverage::human(&all) });
    Ok(if all.iter().all(|coverage| coverage.open() == 0) { Exit::Done } else { Exit::No })
}

/// Judges what is kept again, and writes the page; with `check` only says what would change.
fn stored(pages: &Path, command: &Conventions) -> Result<Exit, Failure> {
    let check = command.check;
    let all: Vec<&'static Convention> = table::all().collect();
    let asked = asked(&all)?;
    let mut kept = results::load(pages)?;
    let mut written = Pages::new(pages, results::BY);
    for results in &mut kept {
        let driver = find_driver(&results.renderer)?;
        let target = project::target(driver.target)?;
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
    let done = written.finish(check, command.force)?;
    terminal::print(&done.lines(check));
    let (place, fresh) = (pages.display(), done.count() == 0);
    match (fresh, check) {
        (true, _) => terminal::say(&format!("{place}: nothing to do, all results and the page are up to date")),
        (false, true) => {
            terminal::say(&format!(
                "{place} is stale; `ltsc conventions --output {place} --stored` brings it up to date"
            ));
        }
        (false, false) => {}
    }
    Ok(if check && !fresh { Exit::No } else { Exit::Done })
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
