//! `ltsc agree`: scenes in several renderers with several seeds, and whether the images agree beyond their noise.

mod page;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::compare::CompareError;
use ltsc_render::compare::verdict::{self, Outcome, Tolerance, Verdict};
use ltsc_render::image::{Image, Provenance, exr_bytes, read, reduce};
use ltsc_render::run::{Driver, Rendered};
use serde_json::json;

use crate::args::{Agree, Format};
use crate::disk::{not_ours, probe, unwritable, write_whole};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};
use crate::terminal::{self, Bar};

use super::job::{Job, Runner, is_there, lacks};
use super::render::{failure, find_driver};
use super::renderers::advice;
use super::said::one_scene;
use super::shared::{Shown, all_files_of, check, overrides, report_as};
use page::{Row, Side, Stated};

/// The renderers that are compared unless others are named.
const DEFAULT: [&str; 3] = ["mitsuba-3", "luxcore", "cycles"];

/// What one renderer made of a scene.
struct Made {
    side: Side,
    images: Vec<Image>,
    /// What the target states of this scene: by how much it may be off, and in what.
    stated: Vec<Stated>,
}

pub fn run(command: &Agree) -> Result<Exit, Failure> {
    if command.check {
        return check_page(command);
    }
    let drivers: Vec<&'static Driver> = if command.renderer.is_empty() {
        DEFAULT.iter().map(|name| find_driver(name)).collect::<Result<_, _>>()?
    } else {
        command.renderer.iter().map(|name| find_driver(name)).collect::<Result<_, _>>()?
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
    let (mut rows, mut exit, mut scenes) = (Vec::new(), Exit::Done, 0);
    for (project, files) in all_files_of(&command.scenes, &command.findings)? {
        for file in &files {
            match scene_of(command, &project, file)? {
                Ok(Some(scene)) => {
                    scenes += 1;
                    rows.extend(scene_rows(command, &project, &scene, &drivers)?);
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

/// Renders a scene with all renderers and compares them in pairs, and with the reference where there is one.
fn scene_rows(
    command: &Agree,
    project: &Project,
    scene: &Valid,
    drivers: &[&'static Driver],
) -> Result<Vec<Row>, Failure> {
    let mut made: Vec<Made> = reference(command, scene)?.into_iter().collect();
    for driver in drivers {
        let named = !command.renderer.is_empty();
        if !is_there(driver, project, Duration::from_secs(command.timeout))? {
            let message = format!("{} is not there", driver.name);
            if named {
                return Err(Failure::new(Exit::Environment, message).help(advice(driver)));
            }
            terminal::say(&format!("{message}: left out"));
            continue;
        }
        if lacks(driver, scene)? {
            terminal::say(&format!("{}: {} lacks `{}`: left out", scene.name, driver.name, scene.integrator.word()));
            continue;
        }
        made.push(images(command, project, scene, driver)?);
    }
    let mut rows = Vec::new();
    for (at, a) in made.iter().enumerate() {
        for b in &made[at + 1..] {
            let row = compare(command, scene, a, b)?;
            match command.findings.format {
                Format::Json => {}
                Format::Short => terminal::print(&row.short()),
                Format::Human | Format::Sarif | Format::Github => terminal::print(&row.text()),
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// By how much of what targets state the tolerance for agreement grows at most: images may differ by more without being called
/// different, and are not called equal.
const MOST_STATED: f64 = 0.1;

/// The verdict within a tolerance and what targets state beside it, `more`; and whether the images differ by more than would still be
/// called agreement, and by no more than is stated.
fn judged(
    a: verdict::Rendered<'_>,
    b: verdict::Rendered<'_>,
    tolerance: Tolerance,
    more: f64,
) -> Result<(Verdict, bool), CompareError> {
    let within = |more: f64| Tolerance { tiles: tolerance.tiles + more, whole: tolerance.whole + more };
    let verdict = verdict::judge(a, b, within(more.min(MOST_STATED)))?;
    if more <= MOST_STATED || verdict.outcome != Outcome::Differ {
        return Ok((verdict, false));
    }
    let wide = verdict::judge(a, b, within(more))?;
    if wide.outcome == Outcome::Differ {
        return Ok((wide, false));
    }
    Ok((Verdict { outcome: Outcome::Undecided, ..verdict }, true))
}

fn compare(command: &Agree, scene: &Scene, a: &Made, b: &Made) -> Result<Row, Failure> {
    let mut stated: Vec<Stated> = a.stated.iter().chain(&b.stated).cloned().collect();
    stated.sort_by(|one, other| other.share.total_cmp(&one.share));
    let more: f64 = stated.iter().map(|one| one.share).sum();
    let tolerance = Tolerance { tiles: command.tolerance, whole: command.mean_tolerance };
    let side = |made: &'_ Made| made.images.len();
    let samples = f64::from(command.samples);
    let of = |images| verdict::Rendered { images, samples };
    let (verdict, excused) = judged(of(&a.images), of(&b.images), tolerance, more).map_err(|error| {
        let (one, other) = (&a.side.name, &b.side.name);
        let counts = format!("{one} ({}) and {other} ({})", side(a), side(b));
        Failure::new(Exit::Environment, format!("{}: {counts}: {error}", scene.name)).help(error.hint())
    })?;
    Ok(Row {
        scene: scene.name.clone(),
        settings: command.set.clone(),
        size: command.size,
        samples: command.samples,
        a: a.side.clone(),
        b: b.side.clone(),
        stated,
        excused,
        verdict,
    })
}

/// The images of the reference: `SCENE.exr`, or `SCENE-0.exr`, `SCENE-1.exr` and so on, in the folder asked for.
fn reference(command: &Agree, scene: &Scene) -> Result<Option<Made>, Failure> {
    let Some(folder) = &command.reference else { return Ok(None) };
    let mut files = vec![folder.join(format!("{}.exr", scene.name))];
    files.extend((0..).map(|at| folder.join(format!("{}-{at}.exr", scene.name))).take_while(|file| file.is_file()));
    let mut images = Vec::new();
    for file in files.iter().filter(|file| file.is_file()) {
        let unreadable = |error: ltsc_render::image::ImageError| {
            let help = error.hint().to_owned();
            Failure::new(Exit::Input, error.to_string()).help(help)
        };
        let (image, _) = read(file).map_err(unreadable)?;
        let size = command.size as usize;
        images.push(if image.width == size { image } else { reduce(&image, size, size).map_err(unreadable)? });
    }
    if images.is_empty() {
        terminal::say(&format!("{}: no reference in {}", scene.name, folder.display()));
        return Ok(None);
    }
    let version = command.reference_name.clone().unwrap_or_default();
    Ok(Some(Made { side: Side { name: "reference".to_owned(), version, seconds: None }, images, stated: Vec::new() }))
}

/// One image for each seed; those in the folder of kept images that are of the same files and settings are taken from there.
fn images(command: &Agree, project: &Project, scene: &Valid, driver: &'static Driver) -> Result<Made, Failure> {
    let what = format!("{} ({})", scene.name, driver.name);
    let mut side = Side { name: driver.name.to_owned(), version: String::new(), seconds: Some(0.0) };
    let mut images = Vec::new();
    let mut bar = Bar::new(u64::from(command.seeds), &what);
    let timeout = Some(Duration::from_secs(command.timeout));
    let runner = Runner::find(driver, None, Some(project), timeout)?;
    let job = Job::new(scene, &runner)?;
    for seed in 0..command.seeds {
        let seed = command.first_seed + seed;
        let key = job.key(command.samples, seed);
        let kept = command
            .keep
            .as_ref()
            .map(|folder| folder.join(&scene.name).join(format!("{}-{seed}-{}.exr", driver.name, &key[..12])));
        let known = kept.as_deref().and_then(|file| known(file, &key));
        // The name has the key, so that what is there under it is no image of ours.
        if let Some(file) = kept.as_deref().filter(|file| known.is_none() && !command.force && is_there_at(file)) {
            return Err(not_ours(&[file.to_path_buf()]));
        }
        let (image, version, seconds) = match known {
            Some(known) => known,
            None => {
                let done = job.render(command.samples, seed, &mut |_| bar.say(&what));
                let Rendered { image, renderer_version, seconds, samples_done, .. } =
                    done.map_err(|error| failure(&error))?;
                if let Some(file) = &kept {
                    let provenance = Provenance {
                        scene: scene.name.clone(),
                        scene_hash: key,
                        version: env!("CARGO_PKG_VERSION").to_owned(),
                        renderer: driver.name.to_owned(),
                        renderer_version: renderer_version.clone(),
                        samples: samples_done,
                        seed: u64::from(seed),
                        seconds,
                        extra: Vec::new(),
                    };
                    keep(file, &image, &provenance)?;
                }
                (image, renderer_version, seconds)
            }
        };
        side.version = version;
        side.seconds = side.seconds.map(|sum| sum + seconds);
        images.push(image);
        bar.set(images.len() as u64);
    }
    bar.finish();
    Ok(Made { side, images, stated: stated(scene, driver)? })
}

/// What a renderer's target states of a scene with a number: by how much its light may be off.
fn stated(scene: &Scene, driver: &Driver) -> Result<Vec<Stated>, Failure> {
    let ledger = Ledger::of(scene, project::target(driver.target)?, &[]);
    let here = ledger.approximated.iter().filter_map(|one| {
        let share = one.here.as_ref()?.at_most;
        (share > 0.0).then(|| Stated { by: driver.name.to_owned(), what: one.what.to_owned(), share })
    });
    Ok(here.collect())
}

fn keep(file: &Path, image: &Image, provenance: &Provenance) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let bytes = exr_bytes(file, image, provenance)
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
    write_whole(file, &mut |out| out.write_all(&bytes)).map_err(|error| unwritable(folder, &error))
}

fn is_there_at(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok()
}

/// An image rendered before, with its renderer's version and time, if it has this key.
fn known(file: &Path, key: &str) -> Option<(Image, String, f64)> {
    let (image, attributes) = read(file).ok()?;
    let of = Provenance::from_attributes(&attributes);
    (of.scene_hash == key).then_some((image, of.renderer_version, of.seconds))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_widens_agreement_by_a_tenth_at_most() {
        let flat = |value: f32| vec![Image::filled(16, 16, [value; 3]); 4];
        let of = |ratio: f32, more: f64| {
            let (a, b) = (flat(1.0), flat(ratio));
            let side = |images| verdict::Rendered { images, samples: 16.0 };
            let (verdict, excused) =
                judged(side(&a), side(&b), Tolerance { tiles: 0.05, whole: 0.01 }, more).expect("a verdict");
            (verdict.outcome, excused)
        };
        assert_eq!(of(1.005, 0.0), (Outcome::Agree, false));
        assert_eq!(of(1.08, 0.0), (Outcome::Differ, false));
        assert_eq!(of(1.08, 0.09), (Outcome::Agree, false));
        assert_eq!(of(1.08, 2.7), (Outcome::Agree, false), "within what a tenth allows");
        assert_eq!(of(1.5, 2.7), (Outcome::Undecided, true), "stated, and no agreement");
        assert_eq!(of(1.5, 0.2), (Outcome::Differ, false), "more than is stated");
    }
}
