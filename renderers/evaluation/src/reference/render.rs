//! A reference that ltsc renders: settings, checks before long work, and what is kept.

use std::path::{Path, PathBuf};

use ltsc_core::eval::Overrides;
use ltsc_core::ir::{Bsdf, Integrator, Scene};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::image::{Image, Provenance, attributes};
use ltsc_render::run::{DRIVERS, Driver, Seeds};

use super::about::{About, Origin, Settings, convergence};
use super::rounds::{Goal, Left, Made, Reached, chunk_samples, reach};
use super::{path, store};
use crate::chunk::Store;
use crate::disk::{Pages, probe};
use crate::failure::{Exit, Failure};
use crate::job::{Job, lacks, target_of};
use crate::watch::Watch;

/// What the record of the folder says of who wrote a file.
pub(super) const BY: &str = "reference";

/// What is to be rendered.
pub struct Wanted<'a> {
    /// The folder of references.
    pub references: &'a Path,
    /// When it is good enough.
    pub goal: Goal,
    /// Whether to write over another one.
    pub force: bool,
}

/// What became of it.
pub struct Kept {
    /// The file.
    pub file: PathBuf,
    /// What is known of it; none where nothing could be written yet.
    pub about: Option<About>,
    /// Chunks that there are, and samples per pixel of each.
    pub chunks: (u32, u32),
    /// Whether the file was written now.
    pub written: bool,
    /// What stood in its place and shows something else: a stale one, or one by another version.
    pub replaced: Option<String>,
    /// What remains; none where the goal is reached.
    pub left: Option<Left>,
    /// What ended it before its time.
    pub failed: Option<Failure>,
}

/// A scene with the settings of its reference: the longer side, another algorithm or depth, and the samples of one chunk.
///
/// # Errors
/// If the scene cannot be rendered so.
pub fn prepared(
    scene: Valid,
    size: Option<u32>,
    integrator: Option<&'static str>,
    max_depth: Option<u32>,
) -> Result<Valid, Failure> {
    let name = scene.name.clone();
    let longer = f64::from(scene.film.width.max(scene.film.height));
    let side = |of: u32| size.map(|size| ((f64::from(of) * f64::from(size) / longer).round() as u32).max(1));
    let (width, height) = (side(scene.film.width), side(scene.film.height));
    let overrides = Overrides { width, height, integrator, max_depth, ..Overrides::default() };
    let mut scene = pipeline::override_settings(scene, &overrides).map_err(|wrong| {
        let first = wrong.first().map(|finding| finding.message.clone()).unwrap_or_default();
        Failure::new(Exit::Input, format!("the scene `{name}` cannot be rendered so: {first}"))
    })?;
    // What is written tells the chunks apart by nothing but what the driver sets.
    let samples = chunk_samples((scene.film.width as usize, scene.film.height as usize));
    scene.set_sampling(samples, 0);
    Ok(scene)
}

/// Refuses a renderer that lacks the algorithm, or whose images are not independent of each other.
///
/// # Errors
/// Usage, with those that would do.
pub fn check(driver: &Driver, scene: &Scene) -> Result<(), Failure> {
    let seeded =
        |driver: &Driver| driver.seeds == Seeds::Free || driver.seeds == Seeds::Some && scene.sampler.word() == "sobol";
    let others = || {
        let fit = DRIVERS.iter().filter(|other| !lacks(other, scene) && seeded(other));
        let names: Vec<String> = fit.map(|other| format!("`{}`", other.name)).collect();
        if names.is_empty() {
            "no renderer that ltsc runs has both".to_owned()
        } else {
            format!("render with {}", names.join(" or "))
        }
    };
    let word = scene.integrator.word();
    if lacks(driver, scene) {
        let message = format!("{} has no `{word}`", driver.name);
        return Err(Failure::new(Exit::Usage, message)
            .help(format!("name another algorithm by `--integrator`, or {}", others())));
    }
    if !seeded(driver) {
        let message = format!("{} has no seeds that cost nothing: the error of its images cannot be told", driver.name);
        return Err(Failure::new(Exit::Usage, message).help(others()));
    }
    Ok(())
}

/// What an image by light tracing lacks.
const BLIND: &str = "light tracing shows nothing of what ideally smooth surfaces show to the camera: it is black there";

/// Whether a scene has surfaces of which light tracing shows nothing.
fn is_blind(scene: &Scene) -> bool {
    let smooth = |bsdf: &Bsdf| match bsdf {
        Bsdf::Dielectric { alpha, .. } | Bsdf::Conductor { alpha, .. } | Bsdf::Plastic { alpha, .. } => *alpha == 0.0,
        Bsdf::Mirror { .. } => true,
        Bsdf::Diffuse { .. } | Bsdf::Principled { .. } => false,
    };
    let traced = matches!(scene.integrator, Integrator::LightTracing { .. });
    traced && scene.materials.values().any(|material| smooth(&material.bsdf))
}

impl Wanted<'_> {
    /// Renders a reference of a scene that [`prepared`] gave, as far as the goal's time reaches, and keeps it where it is no worse than
    /// what is there.
    ///
    /// # Errors
    /// Where another one stands in its place, or files cannot be read or written. A renderer that fails is no error of this: what was
    /// rendered before is kept, and its failure comes back.
    pub fn render(&self, store: &Store, job: &Job<'_>, scene: &Valid, watch: &mut dyn Watch) -> Result<Kept, Failure> {
        let driver = job.runner().driver;
        check(driver, scene)?;
        let file = path(self.references, job.scene(), driver.name);
        let (there, replaced) = self.there(&file, job, scene)?;
        probe(self.references)?;
        let place = format!("{}/{}.exr", job.scene(), driver.name);
        Pages::new(self.references, BY).refuse(&place, self.force)?;
        if is_blind(scene) && !self.force {
            let help = "choose another algorithm by `--integrator`, or add `--force` to keep it with these words";
            return Err(Failure::new(Exit::Usage, format!("{}: {BLIND}", job.scene())).help(help));
        }
        let Reached { count, samples, made, left, failed } = reach(store, job, &self.goal, watch)?;
        let mut kept = Kept { file, about: None, chunks: (count, samples), written: false, replaced, left, failed };
        let Some(made) = made else { return Ok(kept) };
        let mut about = about(job, scene, &made)?;
        // Chunks may have been removed since: what is there may be the better one.
        if let Some(there) = there.filter(|there| there.samples.unwrap_or(0) >= about.samples.unwrap_or(0)) {
            kept.about = Some(there);
            return Ok(kept);
        }
        write(self.references, &kept.file, (&made.image, Some(&made.variance)), &mut about, self.force)?;
        (kept.about, kept.written) = (Some(about), true);
        Ok(kept)
    }

    /// The same image in the place of this one, or what stands there else; what is neither stale nor an earlier version of this
    /// one is not to
    /// be written over but by force.
    fn there(&self, file: &Path, job: &Job<'_>, scene: &Valid) -> Result<(Option<About>, Option<String>), Failure> {
        if std::fs::symlink_metadata(file).is_err() {
            return Ok((None, None));
        }
        let about = match store::describe(file) {
            Ok(Some(about)) => about,
            _ if self.force => return Ok((None, Some("a file that is no reference".to_owned()))),
            Ok(None) => return Err(super::foreign(file)),
            Err(failure) => return Err(failure.help("move it away, or add `--force` to write over it")),
        };
        if identity(&about) == Some(&job.identity()) {
            return Ok((Some(about), None));
        }
        let Settings { width, height, integrator, max_depth, .. } = &about.settings;
        let (now, path) = (settings_of(scene), file.display());
        let other = if !about.is_rendered() {
            Some(format!("{path} is of other origin ({})", about.maker()))
        } else if about.settings != now {
            let Settings { width: w, height: h, integrator: word, max_depth: depth, .. } = &now;
            Some(format!(
                "{path} is {width}x{height} by {integrator} with {max_depth} segments, and {w}x{h} by {word} with {depth} is asked for"
            ))
        } else {
            None
        };
        match other.filter(|_| !self.force) {
            Some(other) => Err(Failure::new(Exit::Usage, other)
                .help("choose another folder by `-o`, or add `--force` to write over it")),
            None => Ok((None, Some(about.maker()))),
        }
    }
}

fn identity(about: &About) -> Option<&String> {
    match &about.origin {
        Origin::Rendered { identity, .. } => Some(identity),
        Origin::Declared { .. } => None,
    }
}

fn about(job: &Job<'_>, scene: &Valid, made: &Made) -> Result<About, Failure> {
    let driver = job.runner().driver;
    let target = target_of(driver);
    let word = scene.integrator.word();
    let known = made.chunks.files.first().and_then(|file| attributes(file).ok());
    let facts = known.map(|header| Provenance::from_attributes(&header).extra).unwrap_or_default();
    let said = facts.into_iter().find(|(name, _)| name == "defects").map(|(_, what)| what);
    let blind = is_blind(scene).then(|| BLIND.to_owned());
    let defects: Vec<String> = said.into_iter().chain(blind).collect();
    let cost = &made.chunks.cost;
    let origin = Origin::Rendered {
        renderer: driver.name.to_owned(),
        version: cost.version.clone(),
        convergence: convergence(target.name, word).map(|known| known.word().to_owned()),
        defects: (!defects.is_empty()).then(|| defects.join("; ")),
        identity: job.identity(),
        seconds: cost.seconds,
        cpu_seconds: cost.cpu_seconds,
        machines: cost.machines.clone(),
    };
    let mut about = About::new(job.scene(), driver.name, origin, target.name, job.content(), settings_of(scene));
    about.error = Some(made.error);
    about.images = u32::try_from(made.chunks.files.len()).unwrap_or(u32::MAX);
    about.samples = Some(cost.samples);
    Ok(about)
}

/// How a scene is written as it is.
pub(super) fn settings_of(scene: &Scene) -> Settings {
    Settings {
        width: scene.film.width,
        height: scene.film.height,
        integrator: scene.integrator.word().to_owned(),
        max_depth: scene.integrator.max_depth(),
        sampler: scene.sampler.word().to_owned(),
        samples: scene.sampler.samples(),
    }
}

/// Writes a reference into its folder.
pub(super) fn write(
    references: &Path,
    file: &Path,
    (image, variance): (&Image, Option<&Image>),
    about: &mut About,
    force: bool,
) -> Result<(), Failure> {
    let bytes = store::encode(file, image, variance, about)?;
    let mut pages = Pages::new(references, BY);
    pages.put(format!("{}/{}.exr", about.scene, about.name), bytes);
    pages.keep(|_| true);
    pages.finish(false, force).map(|_| ())
}
