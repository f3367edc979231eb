//! `ltsc manual`: the reference manual, printed or written.

use std::path::Path;

use ltsc_core::diag::nearest;
use ltsc_core::manual::{self, PAGES};

use crate::args::Manual;
use crate::output::{Exit, Failure};
use crate::terminal;
use ltsc_evaluation::disk::Pages;

use super::conventions::measured_by;

pub fn run(command: &Manual) -> Result<Exit, Failure> {
    match (&command.page, &command.output) {
        (_, Some(folder)) => write(folder, command),
        (Some(name), None) => {
            let page = manual::find(name).ok_or_else(|| unknown(name))?;
            terminal::print(&(page.text)(&measured_by()?));
            Ok(Exit::Done)
        }
        (None, None) => {
            let lines: Vec<String> = PAGES.iter().map(|page| format!("{:<12} {}\n", page.name, page.summary)).collect();
            terminal::print(&lines.concat());
            Ok(Exit::Done)
        }
    }
}

fn unknown(name: &str) -> Failure {
    let names = PAGES.iter().map(|page| page.name);
    let failure = Failure::new(Exit::Usage, format!("the manual has no page `{name}`"));
    match nearest(name, names.clone()) {
        Some(similar) => failure.help(format!("did you mean `{similar}`?")),
        None => failure.help(format!("it has {}", names.collect::<Vec<_>>().join(", "))),
    }
}

/// Writes the pages that are not yet what they should be, or only names them.
fn write(folder: &Path, command: &Manual) -> Result<Exit, Failure> {
    let (measured, check) = (measured_by()?, command.check);
    let mut pages = Pages::new(folder, "manual");
    for page in PAGES {
        pages.put(page.file(), (page.text)(&measured));
    }
    let done = pages.finish(check, command.force)?;
    terminal::print(&done.lines(check));
    let (stale, place) = (done.count(), folder.display());
    match (stale, check) {
        (0, _) => terminal::say(&format!("{place}: nothing to do, all pages are up to date")),
        (_, true) => terminal::say(&format!("{place} is stale; `ltsc manual -o {place}` brings it up to date")),
        (_, false) => {}
    }
    Ok(if check && stale > 0 { Exit::No } else { Exit::Done })
}
