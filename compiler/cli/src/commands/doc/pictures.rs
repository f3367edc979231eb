//! Pictures for the catalogue: each scene by its references or in two renderers, and how they differ.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::catalogue::Pictures;
use ltsc_core::ir::Scene;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::compare::{CompareOptions, compare, difference_rgb8, exposure, png, relative_rgb8, shown_rgb8};
use ltsc_evaluation::reference::{self, Picture};
use ltsc_render::regular;
use ltsc_render::run::driver;
use serde_json::json;

use crate::args::Doc;
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal::{self, Watcher};
use ltsc_evaluation::disk::{Done, Pages};

use super::super::shared::check;
use ltsc_evaluation::job::{Job, Runner, Writing, lacks};

/// The renderers that are compared, the reference first.
const PAIR: [&str; 2] = ["mitsuba-3", "luxcore"];

/// Stops by which differences are brightened, beside the exposure of the pictures.
const STOPS: f64 = 5.0;

/// Stops by which relative differences are brightened: at as many as the others the noise of few samples fills them.
const RELATIVE_STOPS: f64 = 2.0;

/// What is shown of a scene, and the pictures by their names.
type Made = (Pictures, Vec<(String, Vec<u8>)>);

type Scenes<'s> = BTreeMap<&'s str, (&'s Scene, &'s Project, &'s PathBuf)>;

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join("pictures").join(format!("{name}.json"))
}

/// What was rendered of a scene before.
pub fn load(folder: &Path, name: &str) -> Option<Pictures> {
    let text = regular::read_text(&file(folder, name), regular::TEXT).ok()?;
    let document: serde_json::Value = serde_json::from_str(&text).ok()?;
    let pairs = |key: &str| -> Option<Vec<(String, String)>> {
        let items = document.get(key)?.as_array()?.iter();
        items.map(|item| Some((item.get(0)?.as_str()?.to_owned(), item.get(1)?.as_str()?.to_owned()))).collect()
    };
    Some(Pictures { shown: pairs("shown")?, facts: pairs("facts")? })
}

/// Makes the pictures of all scenes: of their references, or with the renderers that are there.
pub fn render_all(command: &Doc, scenes: &Scenes<'_>, folder: &Path) -> Result<(), Failure> {
    let mut runners: Option<Vec<Runner>> = None;
    for name in scenes.keys() {
        Pages::new(folder, BY).refuse(&format!("pictures/{name}.json"), command.force)?;
    }
    for (name, (scene, project, path)) in scenes {
        let Some(scene) = prepared(command, scene, project, path)? else { continue };
        let sized = reference::prepared(scene.clone(), Some(command.size), None, None)?;
        let size = (sized.film.width as usize, sized.film.height as usize);
        let references = reference::folder(&project.root);
        let mut made = reference::pictures(&references, &scene, &project.choices, size, &mut Watcher::default())?;
        let kept = !made.is_empty();
        if kept {
            terminal::say(&format!("{name}: pictures of what is kept in {}", references.display()));
            made.truncate(PAIR.len());
        } else {
            let runners = match &mut runners {
                Some(there) => there,
                none => none.insert(there(command, project)?),
            };
            for runner in runners.iter() {
                made.extend(one(command, &sized, project, runner)?);
            }
        }
        let (mut pictures, files) = pictures_of(&scene.name, &made, folder)?;
        if pictures.shown.is_empty() {
            continue;
        }
        if kept {
            pictures.facts.insert(0, ("from".to_owned(), "references of the project".to_owned()));
        }
        // What is rendered is kept, also where a later scene fails.
        let text = format!("{:#}\n", json!({ "shown": pictures.shown, "facts": pictures.facts }));
        let mut pages = Pages::new(folder, BY);
        pages.put(format!("pictures/{name}.json"), text);
        for (name, bytes) in files {
            pages.put(format!("pictures/{name}"), bytes);
        }
        pages.keep(|path| !is_of(path, name));
        pages.finish(false, command.force)?;
    }
    Ok(())
}

/// The renderers of the pair that are there.
fn there(command: &Doc, project: &Project) -> Result<Vec<Runner>, Failure> {
    let mut runners = Vec::new();
    for name in PAIR {
        let Some(driver) = driver(name) else { continue };
        match Runner::find(driver, None, project.program(driver.name)?, Some(Duration::from_secs(command.timeout))) {
            Ok(runner) => runners.push(runner),
            Err(_) => {
                terminal::say(&format!(
                    "{name} is not there: its pictures are left out; `ltsc renderers install {name}`"
                ));
            }
        }
    }
    Ok(runners)
}

/// The scene as it is.
fn prepared(command: &Doc, scene: &Scene, project: &Project, path: &PathBuf) -> Result<Option<Valid>, Failure> {
    let overrides = ltsc_core::eval::Overrides::default();
    let checked = check(project, std::slice::from_ref(path), &command.findings(), overrides, &[])?;
    let Some(found) = checked.into_iter().next().and_then(|file| file.checked.scene) else { return Ok(None) };
    let cannot = |_| Failure::new(Exit::Input, format!("the scene `{}` cannot be rendered", scene.name));
    pipeline::prepare(found).map(|(scene, _)| Some(scene)).map_err(cannot)
}

/// What the record of pages says of who wrote them.
const BY: &str = "doc --render";

/// Whether a picture or its numbers are of this scene: `pictures/ring-luxcore.png`, `pictures/ring.json`.
fn is_of(path: &str, scene: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or_default();
    name.split(['-', '.']).next() == Some(scene)
}

/// Removes the pictures of scenes that are gone.
pub fn remove_others(folder: &Path, scenes: &BTreeSet<&str>, command: &Doc) -> Result<Done, Failure> {
    let mut pages = Pages::new(folder, BY);
    pages.keep(|path| scenes.iter().any(|scene| is_of(path, scene)));
    pages.finish(command.check, command.force)
}

/// A picture by one renderer; none where it lacks the algorithm, or fails.
fn one(command: &Doc, scene: &Valid, project: &Project, runner: &Runner) -> Result<Option<Picture>, Failure> {
    let driver = runner.driver;
    if lacks(driver, scene) {
        terminal::say(&format!("{}: {} lacks `{}`", scene.name, driver.name, scene.integrator.word()));
        return Ok(None);
    }
    let Some(cache) = &runner.cache else {
        return Err(Failure::new(Exit::Environment, "the system names no cache folder, where chunks are kept")
            .help("set LTSC_CACHE to a folder"));
    };
    let writing = Writing { choices: project.choices.clone(), ..Writing::default() };
    let job = Job::written(scene, runner, &writing)?;
    let wanted = (command.noise, Duration::from_secs(command.timeout));
    let made = reference::picture(&Store::of(cache), &job, scene, wanted, &mut Watcher::default());
    match &made {
        Ok(Some(picture)) => {
            terminal::say(&format!("{}: {} {}: {}", scene.name, driver.name, picture.version, picture.facts()));
        }
        Ok(None) => terminal::say(&format!(
            "{}: {} left out: it takes longer than {} seconds; the next run goes on",
            scene.name, driver.name, command.timeout
        )),
        Err(failure) => terminal::say(&format!("{}: {} left out: {}", scene.name, driver.name, failure.message)),
    }
    Ok(made.unwrap_or_default())
}

/// The pictures, and what was measured.
fn pictures_of(scene: &str, made: &[Picture], folder: &Path) -> Result<Made, Failure> {
    let Some(first) = made.first() else { return Ok(Made::default()) };
    let stops = exposure(&first.image);
    let (mut pictures, mut files) = Made::default();
    let mut put = |title: String, kind: &str, width: usize, height: usize, pixels: &[u8]| {
        let name = format!("{scene}-{kind}.png");
        let bytes = png(&folder.join("pictures").join(&name), width, height, pixels)
            .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
        files.push((name.clone(), bytes));
        pictures.shown.push((title, name));
        Ok::<(), Failure>(())
    };
    let mut facts = Vec::new();
    for picture in made {
        let Picture { renderer, version, image, .. } = picture;
        put(
            format!("{renderer} {version}, {}", picture.algorithm),
            renderer,
            image.width,
            image.height,
            &shown_rgb8(image, stops),
        )?;
        facts.push((renderer.clone(), picture.facts()));
    }
    facts.push(("exposure of the pictures".to_owned(), format!("{stops:+.1} stops")));
    if let [one, other] = made {
        let (a, b) = (&one.image, &other.image);
        let different = |error: ltsc_evaluation::compare::CompareError| Failure::new(Exit::Fault, error.to_string());
        let signed = difference_rgb8(a, b, stops + STOPS).map_err(different)?;
        put(format!("difference, +{STOPS} stops"), "difference", a.width, a.height, &signed)?;
        let relative = relative_rgb8(a, b, RELATIVE_STOPS).map_err(different)?;
        put(format!("relative difference, +{RELATIVE_STOPS} stops"), "relative", a.width, a.height, &relative)?;
        facts.push((
            "differences".to_owned(),
            format!("green where {} is brighter, red where it is dimmer", other.renderer),
        ));
        let only = &["ratio", "relative-mse"];
        let options = CompareOptions { mask_non_finite: true, only, ..CompareOptions::default() };
        let comparison = compare(a, b, &options).map_err(different)?;
        for metric in only {
            let Some(value) = comparison.metric(metric) else { continue };
            let numbers: Vec<String> =
                value.channels.iter().map(|part| part.map_or("none".to_owned(), |part| format!("{part:.4}"))).collect();
            let what = if *metric == "ratio" {
                format!("mean of {} / mean of {} (red, green, blue)", other.renderer, one.renderer)
            } else {
                "relative mean squared error (red, green, blue)".to_owned()
            };
            facts.push((what, numbers.join(", ")));
        }
    }
    pictures.facts = facts;
    Ok((pictures, files))
}
