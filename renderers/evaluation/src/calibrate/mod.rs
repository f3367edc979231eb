//! How often the verdict is wrong: pairs of images are drawn from pools of chunks of real renderings, with something planted in one of
//! them or not, and its answers are counted.
//!
//! Pairs of one pool share chunks with each other, though not within a pair, so that small rates rest on the number of chunks, and the
//! intervals, which take pairs to be independent, are too narrow where a pair takes most of its pool. All numbers follow from the chunks
//! and a seed.

mod before;
mod draw;
mod interval;
mod page;
mod plant;
mod pool;
mod record;
pub mod suite;
mod trials;

use std::path::Path;

use ltsc_core::diag::nearest;
use ltsc_render::image::Image;
use ltsc_render::regular;

use crate::chunk::Store;
use crate::disk::{Done, Pages};
use crate::failure::{Exit, Failure, why};
use crate::job::{Job, Runner};
use crate::watch::Watch;

pub use page::{FILE, PAGE, summary};
pub use pool::Place;
pub use record::Record;

use plant::Truth;
use pool::Seeds;
use record::Pool;
use suite::Variant;

/// What the record of pages says of who wrote them.
const BY: &str = "calibrate";

/// What is asked for.
pub struct Wanted<'a> {
    /// Where the scenes are.
    pub place: Place<'a>,
    /// The scenes.
    pub scenes: &'a [&'static suite::Scene],
    /// The renderer.
    pub runner: &'a Runner,
    /// Where chunks are kept.
    pub store: &'a Store,
    /// Chunks of a scene.
    pub chunks: u32,
    /// Chunks of each of its variants.
    pub variant_chunks: u32,
    /// Renderers at once; none renders nothing, and takes what is there.
    pub at_once: Option<usize>,
    /// Pairs of one renderer for a scene; other kinds are shares of it.
    pub pairs: usize,
    /// What the draws begin with.
    pub seed: u64,
}

/// The scenes called so; all of them if nothing is named.
///
/// # Errors
/// Usage, for a name that is not in the table.
pub fn chosen(only: &[String]) -> Result<Vec<&'static suite::Scene>, Failure> {
    for name in only {
        if suite::SCENES.iter().any(|scene| scene.name == name) {
            continue;
        }
        let known: Vec<&str> = suite::SCENES.iter().map(|scene| scene.name).collect();
        let failure = Failure::new(Exit::Usage, format!("calibration has no scene `{name}`"));
        return Err(match nearest(name, known.iter().copied()) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help(format!("known: {}", known.join(", "))),
        });
    }
    let wanted = |scene: &&suite::Scene| only.is_empty() || only.iter().any(|name| name == scene.name);
    Ok(suite::SCENES.iter().filter(wanted).collect())
}

impl Wanted<'_> {
    /// Renders the pools that are not there, all of them before the first trial, and counts.
    ///
    /// # Errors
    /// Where a scene or a chunk cannot be read, or the renderer fails.
    pub fn counted(&self, watch: &mut (dyn Watch + Send)) -> Result<Record, Failure> {
        let mut jobs = Vec::new();
        let mut seeds = Vec::new();
        for scene in self.scenes {
            jobs.push(self.place.job(self.runner, scene, None)?);
            seeds.push(Seeds { first: 0, count: self.chunks });
            for variant in scene.variants {
                jobs.push(self.place.job(self.runner, scene, Some(variant.change))?);
                seeds.push(Seeds { first: variant.first_seed, count: self.variant_chunks });
            }
        }
        if let Some(at_once) = self.at_once {
            pool::render(&jobs, &seeds, self.store, at_once, watch)?;
        }
        let mut record = Record::default();
        let mut rest: Vec<(Job<'_>, Seeds)> = jobs.into_iter().zip(seeds).collect();
        watch.begin(self.scenes.len() as u64, "trials");
        for (done, scene) in (0..).zip(self.scenes) {
            watch.set(done);
            watch.doing(scene.name);
            let own: Vec<(Job<'_>, Seeds)> = rest.drain(..=scene.variants.len()).collect();
            record.scenes.push(self.scene(scene, &own)?);
        }
        watch.end();
        Ok(record)
    }

    /// The trials of a scene; its own pool comes first, and those of its variants after it.
    fn scene(&self, scene: &suite::Scene, own: &[(Job<'_>, Seeds)]) -> Result<record::Scene, Failure> {
        let load = |(job, seeds): &(Job<'_>, Seeds)| pool::load(job, *seeds, self.store);
        let all = own.iter().map(load).collect::<Result<Vec<Vec<Image>>, Failure>>()?;
        let mut all = all.into_iter();
        let base = all.next().unwrap_or_default();
        let variants: Vec<(&Variant, Vec<Image>)> = scene.variants.iter().zip(all).collect();
        let truth = Truth::of(&base);
        let about = |name: &str, what: &str, seeds: Seeds, images: &[Image]| {
            let both = truth.as_ref().zip(Truth::of(images));
            Pool {
                name: name.to_owned(),
                what: what.to_owned(),
                chunks: u32::try_from(images.len()).unwrap_or(u32::MAX),
                wanted: seeds.count,
                first_seed: seeds.first,
                ratio: both.as_ref().map_or([1.0; 3], |(one, other)| one.ratio(other)),
                distance: both.map(|(one, other)| one.distance(&other)).unwrap_or_default(),
            }
        };
        let mut pools: Vec<Pool> = Vec::new();
        pools.extend(own.first().map(|(_, seeds)| about("base", "the scene as it is", *seeds, &base)));
        for ((variant, images), (_, seeds)) in variants.iter().zip(&own[1..]) {
            pools.push(about(variant.name, variant.what, *seeds, images));
        }
        let drawn = trials::Pools { scene, base: &base, variants: &variants, seed: self.seed, pairs: self.pairs };
        let trials::Counted { rows, predictions, missing } = trials::count(&drawn)?;
        let renderer = format!("{} {}", self.runner.driver.name, self.runner.found.version);
        Ok(record::Scene {
            scene: scene.label(),
            renderer: renderer.trim().to_owned(),
            size: suite::SIZE,
            samples: suite::SAMPLES,
            seed: self.seed,
            pools,
            rows,
            predictions,
            missing,
        })
    }
}

/// What is kept in a folder of pages; nothing if there is none.
///
/// # Errors
/// Where it is no such record.
pub fn load(pages: &Path) -> Result<Record, Failure> {
    let path = pages.join(FILE);
    let bad = |problem: String| {
        Failure::new(Exit::Input, format!("{}: {problem}", path.display()))
            .help("remove it and count again: `ltsc calibrate --output DIR`")
    };
    match regular::read_text(&path, regular::TEXT) {
        Err(error) if matches!(error.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory) => {
            Ok(Record::default())
        }
        Err(error) => Err(bad(why(&error))),
        Ok(text) => serde_json::from_str(&text).map_err(|error| bad(error.to_string())),
    }
}

/// Refuses what [`save`] would refuse, before anything is rendered for it.
///
/// # Errors
/// Where files of others are there.
pub fn refuse(pages: &Path, force: bool) -> Result<(), Failure> {
    let of = Pages::new(pages, BY);
    [FILE, PAGE].into_iter().try_for_each(|name| of.refuse(name, force))
}

/// Writes the record and its page; scenes that were not counted now stay as they are kept.
///
/// # Errors
/// Where files of others are there, or the folder cannot be written.
pub fn save(pages: &Path, mut new: Record, force: bool) -> Result<Done, Failure> {
    let kept = load(pages)?;
    let old = kept.scenes.into_iter().filter(|old| new.scenes.iter().all(|scene| scene.scene != old.scene));
    let old: Vec<record::Scene> = old.collect();
    new.scenes.extend(old);
    let place = |scene: &record::Scene| suite::SCENES.iter().position(|known| known.label() == scene.scene);
    new.scenes.sort_by_key(|scene| (place(scene).unwrap_or(usize::MAX), scene.scene.clone()));
    let mut written = Pages::new(pages, BY);
    let text = serde_json::to_string_pretty(&new).map_err(|error| Failure::new(Exit::Fault, error.to_string()))?;
    written.put(FILE, text + "\n");
    written.put(PAGE, page::page(&new));
    written.finish(false, force)
}

/// Writes the page of what is kept anew; with `check` only says what would change.
///
/// # Errors
/// Where nothing is kept, or the folder cannot be written.
pub fn stored(pages: &Path, check: bool, force: bool) -> Result<Done, Failure> {
    let kept = load(pages)?;
    if kept.scenes.is_empty() {
        let message = format!("{} holds no calibration", pages.display());
        return Err(Failure::new(Exit::Input, message).help("`ltsc calibrate --output DIR` counts one"));
    }
    let mut written = Pages::new(pages, BY);
    written.put(PAGE, page::page(&kept));
    written.keep(|_| true);
    written.finish(check, force)
}
