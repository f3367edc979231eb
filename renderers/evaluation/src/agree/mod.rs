//! Scenes in several renderers with several seeds, and whether the images agree beyond their noise.

pub mod page;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::ir::Scene;
use ltsc_core::valid::Valid;
use ltsc_render::image::{Image, Provenance, exr_bytes, read, reduce};
use ltsc_render::run::{Driver, Progress};

use crate::chunk::Store;
use crate::compare::Images;
use crate::compare::verdict::{self, Stated, Tolerance, judge_stated};
use crate::disk::{not_ours, unwritable, write_whole};
use crate::failure::{Exit, Failure};
use crate::job::{Job, Runner, lacks, stated};
use crate::watch::Watch;
use page::{Row, Side};

/// What is rendered, and how it is judged.
pub struct Study<'a> {
    /// Parameters of the scenes that were set, `name=value`.
    pub settings: &'a [String],
    /// Width and height of the images in pixels.
    pub size: u32,
    /// Samples per pixel of each image.
    pub samples: u32,
    /// Images of each renderer.
    pub seeds: u32,
    /// The seed of the first one.
    pub first_seed: u32,
    /// Shares by which renderers may differ.
    pub tolerance: Tolerance,
    /// The longest time for one image.
    pub timeout: Duration,
    /// Where images are kept between runs.
    pub keep: Option<&'a Path>,
    /// Whether to write over images there that are not ours.
    pub force: bool,
    /// A folder of images to compare with, and what they are.
    pub reference: Option<(&'a Path, &'a str)>,
}

/// A renderer of a study.
pub struct Asked {
    /// The driver.
    pub driver: &'static Driver,
    /// The program that the project names for it.
    pub program: Option<PathBuf>,
    /// Whether its absence is an error.
    pub needed: bool,
}

/// What one renderer made of a scene.
struct Made {
    side: Side,
    images: Vec<Image>,
    /// What the target states of this scene: by how much it may be off, and in what.
    stated: Vec<Stated>,
}

impl Study<'_> {
    /// Renders a scene with all renderers and compares them in pairs, and with the reference where there is one; `each` sees a
    /// comparison as soon as it is there.
    ///
    /// # Errors
    /// Where a renderer that is needed is missing, or one fails.
    pub fn of(
        &self,
        scene: &Valid,
        renderers: &[Asked],
        watch: &mut dyn Watch,
        each: &mut dyn FnMut(&Row),
    ) -> Result<Vec<Row>, Failure> {
        let mut made: Vec<Made> = self.reference(scene, watch)?.into_iter().collect();
        for Asked { driver, program, needed } in renderers {
            let Ok(runner) = Runner::find(driver, None, program.as_deref(), Some(self.timeout)) else {
                let message = format!("{} is not there", driver.name);
                if *needed {
                    return Err(Failure::new(Exit::Environment, message).help(driver.advice()));
                }
                watch.note(&format!("{message}: left out"));
                continue;
            };
            if lacks(driver, scene) {
                let (name, word) = (driver.name, scene.integrator.word());
                watch.note(&format!("{}: {name} lacks `{word}`: left out", scene.name));
                continue;
            }
            if self.samples < driver.least_samples {
                let (name, least) = (driver.name, driver.least_samples);
                watch
                    .note(&format!("{name}: images of fewer than {least} samples have an error in common that counts"));
            }
            made.push(self.images(scene, &runner, watch)?);
        }
        let mut rows = Vec::new();
        for (at, a) in made.iter().enumerate() {
            for b in &made[at + 1..] {
                let row = self.compare(scene, a, b)?;
                each(&row);
                rows.push(row);
            }
        }
        Ok(rows)
    }

    fn compare(&self, scene: &Scene, a: &Made, b: &Made) -> Result<Row, Failure> {
        let mut stated: Vec<Stated> = a.stated.iter().chain(&b.stated).cloned().collect();
        stated.sort_by(|one, other| other.share.total_cmp(&one.share));
        let more: f64 = stated.iter().map(|one| one.share).sum();
        let of = |made: &'_ Made| made.images.len();
        let side = |images| verdict::Rendered { images: Images::Held(images), samples: f64::from(self.samples) };
        let (verdict, excused) =
            judge_stated(|within| verdict::judge(side(&a.images), side(&b.images), within), self.tolerance, more)
                .map_err(|error| {
                    let (one, other) = (&a.side.name, &b.side.name);
                    let counts = format!("{one} ({}) and {other} ({})", of(a), of(b));
                    Failure::new(Exit::Environment, format!("{}: {counts}: {error}", scene.name)).help(error.hint())
                })?;
        Ok(Row {
            scene: scene.name.clone(),
            settings: self.settings.to_vec(),
            size: self.size,
            samples: self.samples,
            a: a.side.clone(),
            b: b.side.clone(),
            stated,
            excused,
            verdict,
        })
    }

    /// The images of the reference: `SCENE.exr`, or `SCENE-0.exr`, `SCENE-1.exr` and so on, in the folder asked for.
    fn reference(&self, scene: &Scene, watch: &mut dyn Watch) -> Result<Option<Made>, Failure> {
        let Some((folder, origin)) = self.reference else { return Ok(None) };
        let mut files = vec![folder.join(format!("{}.exr", scene.name))];
        files.extend((0..).map(|at| folder.join(format!("{}-{at}.exr", scene.name))).take_while(|file| file.is_file()));
        let mut images = Vec::new();
        for file in files.iter().filter(|file| file.is_file()) {
            let unreadable = |error: ltsc_render::image::ImageError| {
                let help = error.hint().to_owned();
                Failure::new(Exit::Input, error.to_string()).help(help)
            };
            let (image, _) = read(file).map_err(unreadable)?;
            let size = self.size as usize;
            images.push(if image.width == size { image } else { reduce(&image, size, size).map_err(unreadable)? });
        }
        if images.is_empty() {
            watch.note(&format!("{}: no reference in {}", scene.name, folder.display()));
            return Ok(None);
        }
        let side = Side { name: "reference".to_owned(), version: origin.to_owned(), seconds: None };
        Ok(Some(Made { side, images, stated: Vec::new() }))
    }

    /// One image for each seed; those in the folder of kept images that are of the same files and settings are taken from there.
    fn images(&self, scene: &Valid, runner: &Runner, watch: &mut dyn Watch) -> Result<Made, Failure> {
        let driver = runner.driver;
        let what = format!("{} ({})", scene.name, driver.name);
        let mut side = Side { name: driver.name.to_owned(), version: String::new(), seconds: Some(0.0) };
        let mut images = Vec::new();
        watch.begin(u64::from(self.seeds), &what);
        let job = Job::new(scene, runner)?;
        for seed in 0..self.seeds {
            let seed = self.first_seed + seed;
            let key = job.key(self.samples, seed);
            let name = format!("{}-{seed}-{}.exr", driver.name, &key[..12]);
            let kept = self.keep.map(|folder| folder.join(&scene.name).join(name));
            let known = kept.as_deref().and_then(|file| known(file, &key));
            // The name has the key, so that what is there under it is no image of ours.
            if let Some(file) = kept.as_deref().filter(|file| known.is_none() && !self.force && is_there_at(file)) {
                return Err(not_ours(&[file.to_path_buf()]));
            }
            let (image, version, seconds) = match known {
                Some(known) => known,
                None => {
                    let done = self.rendered(&job, seed, &mut |_| watch.doing(&what))?;
                    if let Some(file) = &kept {
                        let (image, version, seconds) = &done;
                        let provenance = Provenance {
                            scene: scene.name.clone(),
                            scene_hash: key,
                            version: env!("CARGO_PKG_VERSION").to_owned(),
                            renderer: driver.name.to_owned(),
                            renderer_version: version.clone(),
                            samples: u64::from(self.samples),
                            seed: u64::from(seed),
                            seconds: *seconds,
                            extra: Vec::new(),
                        };
                        keep(file, image, &provenance)?;
                    }
                    done
                }
            };
            side.version = version;
            side.seconds = side.seconds.map(|sum| sum + seconds);
            images.push(image);
            watch.set(images.len() as u64);
        }
        watch.end();
        Ok(Made { side, images, stated: stated(scene, driver) })
    }

    /// An image with its renderer's version and time: a chunk of the cache, where there is one, so that what was rendered once is not
    /// rendered again.
    fn rendered(
        &self,
        job: &Job<'_>,
        seed: u32,
        news: &mut dyn FnMut(Progress),
    ) -> Result<(Image, String, f64), Failure> {
        let Some(cache) = &job.runner().cache else {
            let done = job.render(self.samples, seed, news).map_err(|error| Failure::of_renderer(&error))?;
            return Ok((done.image, done.renderer_version, done.seconds));
        };
        let store = Store::of(cache);
        store.make(job, (self.samples, seed), news)?;
        let file = store.path(&job.identity(), self.samples, seed);
        let (image, attributes) = read(&file).map_err(|error| {
            Failure::new(Exit::Environment, error.to_string())
                .help(format!("remove {}: it is rendered again", file.display()))
        })?;
        let about = Provenance::from_attributes(&attributes);
        Ok((image, about.renderer_version, about.seconds))
    }
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
