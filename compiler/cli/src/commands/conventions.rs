//! `ltsc conventions`: micro-scenes with known answers through real renderers, and a page of what holds where.

use std::path::Path;
use std::time::Duration;

use ltsc_evaluation::conventions::judge::Verdict;
use ltsc_evaluation::conventions::{PAGE, asked, chosen, coverage, measured, report, results, stored, table};
use ltsc_evaluation::disk::{Pages, probe};
use ltsc_evaluation::job::{Runner, driver_called};
use ltsc_render::run::Driver;

use crate::args::{Conventions, Format};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal::{self, Watcher};

/// What was measured when this program was built.
pub fn measured_by() -> Result<ltsc_core::manual::Measured, Failure> {
    coverage::of_text(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/coverage.json")))
}

pub fn run(command: &Conventions) -> Result<Exit, Failure> {
    let chosen = chosen(&command.only)?;
    if command.list {
        terminal::print(&report::list(&chosen, command.answer.format == Format::Json)?);
        return Ok(Exit::Done);
    }
    if command.coverage {
        return covered(command.output.as_deref().unwrap_or(Path::new("docs")), command.answer.format);
    }
    let drivers = command.renderer.iter().map(|name| driver_called(name)).collect::<Result<Vec<_>, _>>()?;
    if let (true, Some(pages)) = (command.stored, &command.output) {
        return write(pages, command);
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
        let results = measured(runner, &asked, &mut Watcher::default())?;
        if command.answer.format != Format::Json {
            terminal::print(&report::table(&results));
        }
        all.push(results);
    }
    if command.answer.format == Format::Json {
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
        write(pages, command)?;
    }
    let worst = all.iter().flat_map(|results| &results.rows).map(|row| row.verdict).max();
    Ok(if worst == Some(Verdict::Fails) { Exit::No } else { Exit::Done })
}

fn runner(command: &Conventions, driver: &'static Driver) -> Result<Runner, Failure> {
    let project = Project::here().ok();
    let timeout = Some(Duration::from_secs(command.timeout));
    let given = command.executable.as_deref();
    let configured = match project.as_ref().filter(|_| given.is_none()) {
        Some(project) => project.program(driver.name)?,
        None => None,
    };
    let found = Runner::find(driver, given, configured, timeout)?;
    Ok(Runner { threads: Some(command.threads as usize), ..found })
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

/// Judges what is kept again, and writes the page; with `--check` only says what would change.
fn write(pages: &Path, command: &Conventions) -> Result<Exit, Failure> {
    let check = command.check;
    let done = stored(pages, check, command.force)?;
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
