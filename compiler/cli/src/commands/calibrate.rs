//! `ltsc calibrate`: how often the verdict is wrong, counted on real renderings.

use std::path::Path;
use std::time::Duration;

use ltsc_evaluation::calibrate::{self, Place, Wanted, chosen};
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::disk::probe;
use ltsc_evaluation::job::{Runner, driver_called};

use crate::args::{Calibrate, Format};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal::{self, Watcher};

/// The renderer of the pools: fast to start, with seeds that cost nothing and independent samples.
const RENDERER: &str = "mitsuba-3";

pub fn run(command: &Calibrate) -> Result<Exit, Failure> {
    if let (true, Some(pages)) = (command.stored, &command.output) {
        return stored(pages, command);
    }
    let scenes = chosen(&command.only)?;
    if let Some(pages) = &command.output {
        probe(pages)?;
        calibrate::refuse(pages, command.force)?;
        calibrate::load(pages)?;
    }
    let project = Project::here()?;
    let driver = driver_called(RENDERER)?;
    let given = command.executable.as_deref();
    let configured = if given.is_none() { project.program(driver.name)? } else { None };
    let found = Runner::find(driver, given, configured, Some(Duration::from_secs(command.timeout)))?;
    let runner = Runner { threads: Some(1), ..found };
    let Some(cache) = &runner.cache else {
        return Err(Failure::new(Exit::Environment, "the system names no cache folder, where chunks are kept")
            .help("set LTSC_CACHE to a folder"));
    };
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = command.jobs.map_or(processors, |jobs| jobs as usize);
    let store = Store::of(cache).at_once(at_once);
    let wanted = Wanted {
        place: Place { root: &project.root, scenes: &project.scenes },
        scenes: &scenes,
        runner: &runner,
        store: &store,
        chunks: command.chunks,
        variant_chunks: command.variant_chunks,
        at_once: (!command.kept).then_some(at_once),
        pairs: command.pairs as usize,
        seed: command.seed,
    };
    let record = wanted.counted(&mut Watcher::default())?;
    if command.answer.format == Format::Json {
        let text = serde_json::to_string_pretty(&record).unwrap_or_default();
        terminal::print(&format!("{text}\n"));
    } else {
        terminal::print(&calibrate::summary(&record));
    }
    let met = record.is_met();
    if let Some(pages) = &command.output {
        let done = calibrate::save(pages, record, command.force)?;
        terminal::say(done.lines(false).trim_end());
    }
    Ok(if met { Exit::Done } else { Exit::No })
}

/// Writes the page of what is kept; with `--check` only says whether it is stale.
fn stored(pages: &Path, command: &Calibrate) -> Result<Exit, Failure> {
    let done = calibrate::stored(pages, command.check, command.force)?;
    terminal::print(&done.lines(command.check));
    let (place, fresh) = (pages.display(), done.count() == 0);
    match (fresh, command.check) {
        (true, _) => terminal::say(&format!("{place}: nothing to do, the page is up to date")),
        (false, true) => {
            terminal::say(&format!(
                "{place} is stale; `ltsc calibrate --output {place} --stored` brings it up to date"
            ));
        }
        (false, false) => {}
    }
    Ok(if command.check && !fresh { Exit::No } else { Exit::Done })
}
