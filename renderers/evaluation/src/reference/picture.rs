//! Pictures for people: a scene by a renderer, from what is kept or rendered until it is clean enough.

use std::path::Path;
use std::time::Duration;

use ltsc_core::formats::Choices;
use ltsc_core::valid::Valid;
use ltsc_render::image::Image;
use ltsc_render::run::DRIVERS;

use super::about::Origin;
use super::rounds::{Goal, Measure, reach};
use super::{Found, find, path};
use crate::chunk::Store;
use crate::compare::verdict::error_of;
use crate::failure::Failure;
use crate::job::Job;
use crate::watch::Watch;

/// A picture of a scene.
pub struct Picture {
    /// The renderer.
    pub renderer: String,
    /// Its version.
    pub version: String,
    /// The algorithm, by its word in scenes.
    pub algorithm: String,
    /// The image.
    pub image: Image,
    /// Samples for each pixel of the image.
    pub samples: u64,
    /// The median standard error of its pixels, as a share; none where that is not known.
    pub noise: Option<f64>,
    /// What is known of it beside.
    pub remark: Option<String>,
}

impl Picture {
    /// How it was made, in a line.
    #[must_use]
    pub fn facts(&self) -> String {
        let mut words = vec![self.algorithm.clone(), format!("{} samples per pixel", self.samples)];
        words.extend(self.noise.map(|noise| format!("median noise of a pixel {:.1} %", 100.0 * noise)));
        words.extend(self.remark.clone());
        words.join(", ")
    }
}

/// The references of a scene that ltsc has rendered, that are not stale, and that have a whole number of times as many pixels along
/// each side, in the order in which
/// renderers are listed.
///
/// # Errors
/// If a file is damaged.
pub fn pictures(
    references: &Path,
    scene: &Valid,
    choices: &Choices,
    (width, height): (usize, usize),
    watch: &mut dyn Watch,
) -> Result<Vec<Picture>, Failure> {
    let mut all = Vec::new();
    for driver in DRIVERS.iter().filter(|driver| path(references, &scene.name, driver.name).is_file()) {
        let Some(found) = find(references, scene, choices, driver.name)? else { continue };
        if let Some(stale) = &found.stale {
            watch.note(&format!("{}: the reference by {} is stale and not shown: {stale}", scene.name, driver.name));
            continue;
        }
        let block = (found.image.width / width.max(1)).max(1);
        let Ok(found) = found.reduced(width, height) else { continue };
        let Origin::Rendered { renderer, version, .. } = &found.about.origin else { continue };
        let (renderer, version, remark) = (renderer.clone(), version.clone(), found.about.caution());
        let Found { image, variance, about, .. } = found;
        let images = about.images as usize;
        let error = variance.and_then(|variance| error_of(&image, &variance, images).ok());
        all.push(Picture {
            renderer,
            version,
            algorithm: about.settings.integrator,
            noise: error.map(|error| error.pixels),
            samples: about.samples.unwrap_or_default() * (block * block) as u64,
            image,
            remark,
        });
    }
    Ok(all)
}

/// Renders a picture of a scene that [`super::prepared`] gave, in chunks that are kept, until the median noise of a pixel is at most
/// `noise` or the time is over.
///
/// # Errors
/// What the renderer says, where there is too little to show.
pub fn picture(
    store: &Store,
    job: &Job<'_>,
    scene: &Valid,
    (noise, budget): (f64, Duration),
    watch: &mut dyn Watch,
) -> Result<Option<Picture>, Failure> {
    let goal = Goal { measure: Measure::Pixels, error: noise, budget: Some(budget) };
    let reached = reach(store, job, &goal, watch)?;
    match (reached.made, reached.failed) {
        (Some(made), _) => Ok(Some(Picture {
            renderer: job.runner().driver.name.to_owned(),
            version: made.chunks.cost.version,
            algorithm: scene.integrator.word().to_owned(),
            image: made.image,
            samples: made.chunks.cost.samples,
            noise: Some(made.error.pixels),
            remark: None,
        })),
        (None, Some(failure)) => Err(failure),
        (None, None) => Ok(None),
    }
}
