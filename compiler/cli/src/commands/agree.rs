//! `ltsc agree`: scenes in several renderers with several seeds, and whether the images agree beyond their noise.

use std::path::PathBuf;
use std::time::Duration;

use ltsc_core::eval::Overrides;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_evaluation::agree::page::{self, Row};
use ltsc_evaluation::agree::{Asked, Study};
use ltsc_evaluation::compare::verdict::{Outcome, Tolerance};
use ltsc_evaluation::disk::probe;
use ltsc_evaluation::job::driver_called;
use ltsc_render::run::Driver;
use serde_json::json;

use crate::args::{Agree, Format};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal::{self, Watcher};

use super::said::one_scene;
use super::shared::{Shown, all_files_of, check, overrides, report_as};

/// The renderers that are compared unless others are named.
const DEFAULT: [&str; 3] = ["mitsuba-3", "luxcore", "cycles"];

pub fn run(command: &Agree) -> Result<Exit, Failure> {
    if command.check {
        return check_page(command);
    }
    let drivers: Vec<&'static Driver> = if command.renderer.is_empty() {
        DEFAULT.iter().map(|name| driver_called(name)).collect::<Result<_, _>>()?
    } else {
        command.renderer.iter().map(|name| driver_called(name)).collect::<Result<_, _>>()?
    };
    if command.seeds < 3 {
        let images = if command.seeds == 1 { "one image tells nothing" } else { "two images tell too little" };
        return Err(Failure::new(Exit::Usage, format!("{images} of their noise")).help("ask for 4 seeds or more"));
    }
    if drivers.len() < 2 && command.reference.is_none() {
        return Err(Failure::new(Exit::Usage, "one renderer has nothing to agree with")
            .help("name a second one, or images by `--reference`"));
    }
    if let Some(folder) = command.reference.as_deref().filter(|folder| !folder.is_dir()) {
        return Err(Failure::new(Exit::Usage, format!("{} is no folder", folder.display()))
            .help("`--reference` names the folder of the images"));
    }
    if let Some(record) = &command.record {
        page::check(record, command.force)?;
    }
    if let Some(folder) = &command.keep {
        probe(folder)?;
    }
    let origin = command.reference_name.as_deref().unwrap_or_default();
    let study = Study {
        settings: &command.set,
        size: command.size,
        samples: command.samples,
        seeds: command.seeds,
        first_seed: command.first_seed,
        tolerance: Tolerance { tiles: command.tolerance, whole: command.mean_tolerance },
        timeout: Duration::from_secs(command.timeout),
        keep: command.keep.as_deref(),
        force: command.force,
        reference: command.reference.as_deref().map(|folder| (folder, origin)),
    };
    let mut each = |row: &Row| match command.findings.format {
        Format::Json => {}
        Format::Short => terminal::print(&row.short()),
        Format::Human | Format::Sarif | Format::Github => terminal::print(&row.text()),
    };
    let (mut rows, mut exit, mut scenes) = (Vec::new(), Exit::Done, 0);
    for (project, files) in all_files_of(&command.scenes, &command.findings)? {
        for file in &files {
            match scene_of(command, &project, file)? {
                Ok(Some(scene)) => {
                    scenes += 1;
                    rows.extend(study.of(
                        &scene,
                        &asked(command, &project, &drivers)?,
                        &mut Watcher::default(),
                        &mut each,
                    )?);
                }
                Ok(None) => {}
                Err(refused) => exit = exit.max(refused),
            }
        }
    }
    // A gate must not turn green because nothing was there to compare.
    if rows.is_empty() && scenes > 0 {
        return Err(Failure::new(Exit::Environment, "nothing was compared")
            .help("install a second renderer, or give images by `--reference`"));
    }
    if let Some(record) = &command.record {
        page::record(record, &rows, command.force)?;
    }
    if let Some(folder) = command.keep.as_deref().filter(|folder| folder.is_dir())
        && let Some(index) = super::page::beside(folder, command.force, false)
    {
        terminal::say(&format!("open {} in a browser", super::said::from_here(&index)));
    }
    if command.findings.format == Format::Json {
        let rows: Vec<serde_json::Value> = rows.iter().map(|row| json!(row)).collect();
        terminal::print(&format!("{:#}\n", json!({ "rows": rows })));
    }
    let count = |outcome| rows.iter().filter(|row| row.verdict.outcome == outcome).count();
    let [agree, differ, undecided] = [Outcome::Agree, Outcome::Differ, Outcome::Undecided].map(count);
    let plural = if rows.len() == 1 { "" } else { "s" };
    terminal::say(&format!("{} comparison{plural}: {agree} agree, {differ} differ, {undecided} undecided", rows.len()));
    let no = differ > 0 || command.require_agree && undecided > 0;
    Ok(exit.max(if no { Exit::No } else { Exit::Done }))
}

/// The renderers with the programs that the project names for them; one that the user does not trust is an error.
fn asked(command: &Agree, project: &Project, drivers: &[&'static Driver]) -> Result<Vec<Asked>, Failure> {
    let of = |driver: &&'static Driver| {
        let program = project.program(driver.name)?.map(PathBuf::from);
        Ok(Asked { driver, program, needed: !command.renderer.is_empty() })
    };
    drivers.iter().map(of).collect()
}

/// The scene in `file` at the size asked for; none for a library.
fn scene_of(command: &Agree, project: &Project, file: &PathBuf) -> Result<Result<Option<Valid>, Exit>, Failure> {
    let wanted = Overrides {
        width: Some(command.size),
        height: Some(command.size),
        samples: Some(command.samples),
        set: overrides(&command.settings())?.set,
        ..Overrides::default()
    };
    let files = check(project, std::slice::from_ref(file), &command.findings, wanted, &[])?;
    let format = if command.findings.format == Format::Short { Format::Short } else { Format::Human };
    let (exit, _) = report_as(&files, Vec::new(), None, format, false, Shown::Refusals);
    if exit != Exit::Done {
        return Ok(Err(exit));
    }
    if let (Format::Human, Some(only)) = (format, files.first()) {
        one_scene(&only.checked.findings, None, file);
    }
    let Some(scene) = files.into_iter().next().and_then(|file| file.checked.scene) else { return Ok(Ok(None)) };
    let name = scene.name.clone();
    let (scene, _) = pipeline::prepare(scene)
        .map_err(|_| Failure::new(Exit::Input, format!("the scene `{name}` cannot be rendered")))?;
    Ok(Ok(Some(scene)))
}

/// Whether the page is what the record says; nothing is rendered.
fn check_page(command: &Agree) -> Result<Exit, Failure> {
    let Some(record) = &command.record else {
        return Err(
            Failure::new(Exit::Usage, "`--check` compares a record with its page").help("add `--record FILE.json`")
        );
    };
    if page::is_fresh(record)? {
        terminal::say(&format!("{} is up to date", page::beside(record).display()));
        return Ok(Exit::Done);
    }
    terminal::print(&format!("stale: {}\n", page::beside(record).display()));
    Ok(Exit::No)
}
