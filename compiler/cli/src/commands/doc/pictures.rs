//! Renderings for the catalogue: each scene in two renderers, and how they differ.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::catalogue::Pictures;
use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;
use ltsc_core::pipeline;
use ltsc_evaluation::compare::{CompareOptions, compare, difference_rgb8, exposure, png, relative_rgb8, shown_rgb8};
use ltsc_render::regular;
use ltsc_render::run::{Driver, Rendered, driver};
use serde_json::json;

use crate::args::Doc;
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal::{self, Bar};
use ltsc_evaluation::disk::{Done, Pages};

use super::super::shared::check;
use ltsc_evaluation::job::{Job, Runner, lacks};

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

/// Renders all scenes with the renderers that are there.
pub fn render_all(command: &Doc, scenes: &Scenes<'_>, folder: &Path) -> Result<(), Failure> {
    let mut drivers: Vec<&'static Driver> = Vec::new();
    for name in PAIR {
        let Some(driver) = driver(name) else { continue };
        let timeout = Duration::from_secs(command.timeout);
        let there = match scenes.values().next() {
            Some((_, project, _)) => Runner::find(driver, None, project.program(driver.name)?, Some(timeout)).is_ok(),
            None => false,
        };
        if there {
            drivers.push(driver);
        } else {
            terminal::say(&format!("{name} is not there: its pictures are left out; `ltsc renderers install {name}`"));
        }
    }
    if drivers.is_empty() {
        return Ok(());
    }
    for name in scenes.keys() {
        Pages::new(folder, BY).refuse(&format!("pictures/{name}.json"), command.force)?;
    }
    for (name, (scene, project, path)) in scenes {
        let (pictures, files) = one(command, scene, project, path, &drivers, folder)?;
        if pictures.shown.is_empty() {
            continue;
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

/// The settings of a picture: the longer side is as asked for.
fn settings(command: &Doc, scene: &Scene) -> Overrides {
    let (width, height) = (scene.film.width, scene.film.height);
    let longer = f64::from(width.max(height));
    let side = |of: u32| Some(((f64::from(of) * f64::from(command.size) / longer).round() as u32).max(1));
    Overrides { width: side(width), height: side(height), samples: Some(command.samples), ..Overrides::default() }
}

fn one(
    command: &Doc,
    scene: &Scene,
    project: &Project,
    path: &PathBuf,
    drivers: &[&'static Driver],
    folder: &Path,
) -> Result<Made, Failure> {
    let checked = check(project, std::slice::from_ref(path), &command.findings(), settings(command, scene), &[])?;
    let Some(small) = checked.into_iter().next().and_then(|file| file.checked.scene) else {
        return Ok(Made::default());
    };
    let (small, _) = pipeline::prepare(small)
        .map_err(|_| Failure::new(Exit::Input, format!("the scene `{}` cannot be rendered", scene.name)))?;
    let mut all: Vec<(&'static Driver, Rendered)> = Vec::new();
    for driver in drivers {
        if lacks(driver, &small) {
            terminal::say(&format!("{}: {} lacks `{}`", scene.name, driver.name, small.integrator.word()));
            continue;
        }
        let what = format!("{} ({})", scene.name, driver.name);
        let mut bar = Bar::new(0, &what);
        let timeout = Some(Duration::from_secs(command.timeout));
        let runner = Runner::find(driver, None, project.program(driver.name)?, timeout)?;
        let job = Job::new(&small, &runner)?;
        let done = job.render(command.samples, small.sampler.seed(), &mut |_| bar.say(&what));
        bar.finish();
        match done {
            Ok(image) => {
                terminal::say(&format!("{}: {} in {:.1} s", scene.name, driver.name, image.seconds));
                all.push((driver, image));
            }
            Err(error) => terminal::say(&format!("{}: {} left out: {error}", scene.name, driver.name)),
        }
    }
    pictures_of(command, scene, &all, folder)
}

/// The pictures, and what was measured.
fn pictures_of(
    command: &Doc,
    scene: &Scene,
    rendered: &[(&'static Driver, Rendered)],
    folder: &Path,
) -> Result<Made, Failure> {
    let Some((_, first)) = rendered.first() else { return Ok(Made::default()) };
    let stops = exposure(&first.image);
    let (mut pictures, mut files) = Made::default();
    let mut put = |title: String, kind: &str, width: usize, height: usize, pixels: &[u8]| {
        let name = format!("{}-{kind}.png", scene.name);
        let bytes = png(&folder.join("pictures").join(&name), width, height, pixels)
            .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
        files.push((name.clone(), bytes));
        pictures.shown.push((title, name));
        Ok::<(), Failure>(())
    };
    for (driver, done) in rendered {
        let image = &done.image;
        let title = format!("{} {}", driver.name, done.renderer_version);
        put(title, driver.name, image.width, image.height, &shown_rgb8(image, stops))?;
    }
    let mut facts = vec![("samples per pixel".to_owned(), command.samples.to_string())];
    facts.push(("exposure of the pictures".to_owned(), format!("{stops:+.1} stops")));
    if let [(one, a), (other, b)] = rendered {
        let (a, b) = (&a.image, &b.image);
        let different = |error: ltsc_evaluation::compare::CompareError| Failure::new(Exit::Fault, error.to_string());
        let signed = difference_rgb8(a, b, stops + STOPS).map_err(different)?;
        put(format!("difference, +{STOPS} stops"), "difference", a.width, a.height, &signed)?;
        let relative = relative_rgb8(a, b, RELATIVE_STOPS).map_err(different)?;
        put(format!("relative difference, +{RELATIVE_STOPS} stops"), "relative", a.width, a.height, &relative)?;
        facts.push((
            "differences".to_owned(),
            format!("green where {} is brighter, red where it is dimmer", other.name),
        ));
        let only = &["ratio", "relative-mse"];
        let options = CompareOptions { mask_non_finite: true, only, ..CompareOptions::default() };
        let comparison = compare(a, b, &options).map_err(different)?;
        for metric in only {
            let Some(value) = comparison.metric(metric) else { continue };
            let numbers: Vec<String> =
                value.channels.iter().map(|part| part.map_or("none".to_owned(), |part| format!("{part:.4}"))).collect();
            let what = if *metric == "ratio" {
                format!("mean of {} / mean of {} (red, green, blue)", other.name, one.name)
            } else {
                "relative mean squared error (red, green, blue)".to_owned()
            };
            facts.push((what, numbers.join(", ")));
        }
    }
    pictures.facts = facts;
    Ok((pictures, files))
}
