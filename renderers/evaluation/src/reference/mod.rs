//! References: images that are kept for a scene, as `references/<scene>/<name>.exr` of a project, each with its error and its origin.
//!
//! A reference is known by what was written for its renderer: where the scene says something else now, it is stale, and whoever uses it is
//! told. [`find`] is for those who compare with it, [`list`] for those who look what is there; [`Wanted::render`] makes one, from
//! chunks that
//! are kept, so that a run of hours may be ended and goes on; [`add`] takes one from elsewhere.

mod about;
mod add;
mod list;
mod picture;
mod render;
mod rounds;
mod store;

use std::path::{Path, PathBuf};

use ltsc_core::eval::Overrides;
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ir::{Integrator, Sampler};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::image::{Image, ImageError, reduce};
use ltsc_render::run::{DRIVERS, driver};

pub use about::{About, Origin, Settings, Stored};
pub use add::{Declared, add};
pub use list::{Entry, State, list};
pub use picture::{Picture, picture, pictures};
pub use render::{Kept, Wanted, check, prepared};
pub use rounds::{Goal, Left, Made, Measure, Reached, chunk_samples, reach};
pub use store::ERROR;

use crate::compare::verdict;
use crate::failure::Failure;
use crate::job::{self, Writing};

/// The folder of a project's references.
#[must_use]
pub fn folder(project: &Path) -> PathBuf {
    project.join("references")
}

/// The file of a reference below that folder.
#[must_use]
pub fn path(references: &Path, scene: &str, name: &str) -> PathBuf {
    references.join(scene).join(format!("{name}.exr"))
}

/// A reference.
pub struct Found {
    /// Its file.
    pub file: PathBuf,
    /// The mean.
    pub image: Image,
    /// The variance of that mean in each pixel; none where it is not known.
    pub variance: Option<Image>,
    /// What is known of it.
    pub about: About,
    /// Why it is not of the scene as it is now; who uses it says so.
    pub stale: Option<Stale>,
}

/// Why a reference does not show a scene as it is now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stale {
    /// What is written for its renderer has changed.
    Changed,
    /// It has paths of other lengths.
    Depth {
        /// Segments of its longest paths.
        kept: u32,
        /// Those of the scene.
        scene: u32,
    },
    /// The scene can no longer be written for its target, or has other proportions.
    Unwritable(String),
}

impl std::fmt::Display for Stale {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Changed => f.write_str("the scene, or what is written for the target, has changed since"),
            Self::Depth { kept, scene } => {
                write!(f, "its paths have up to {kept} segments, those of the scene {scene}")
            }
            Self::Unwritable(why) => f.write_str(why),
        }
    }
}

impl Found {
    /// As a side of a verdict.
    #[must_use]
    pub fn side(&self) -> verdict::Kept<'_> {
        let samples = self.about.samples.unwrap_or(0) as f64 / f64::from(self.about.images.max(1));
        verdict::Kept {
            mean: &self.image,
            variance: self.variance.as_ref(),
            images: self.about.images as usize,
            samples: samples.max(1.0),
            correlation: self.about.error.map_or((1.0, 1.0), |error| error.correlation),
        }
    }

    /// The same with fewer pixels, each the mean of a block.
    ///
    /// # Errors
    /// If the sizes are not related by a whole number.
    pub fn reduced(self, width: usize, height: usize) -> Result<Self, ImageError> {
        if (self.image.width, self.image.height) == (width, height) {
            return Ok(self);
        }
        let block = ((self.image.width / width.max(1)).pow(2)).max(1) as f32;
        let variance = self.variance.as_ref().map(|variance| reduce(variance, width, height)).transpose()?;
        let variance = variance.map(|variance| Image {
            pixels: variance.pixels.iter().map(|pixel| pixel.map(|value| value / block)).collect(),
            ..variance
        });
        Ok(Self { image: reduce(&self.image, width, height)?, variance, ..self })
    }
}

/// The reference in a file, whatever it is of; none if the file is an image of another origin.
///
/// # Errors
/// If the file is damaged.
pub fn of_file(file: &Path) -> Result<Option<Found>, Failure> {
    let Some((image, variance, about)) = store::decode(file)? else { return Ok(None) };
    Ok(Some(Found { file: file.to_owned(), image, variance, about, stale: None }))
}

/// Why the reference in a file does not show a scene as it is now, by its header alone; none if it does, or is an image of another origin.
///
/// # Errors
/// If the header is damaged.
pub fn stale(file: &Path, scene: &Valid, choices: &Choices) -> Result<Option<Stale>, Failure> {
    store::describe(file)?.map_or(Ok(None), |about| staleness(&about, scene, choices))
}

/// The file of the reference of a scene for a renderer or a target, if there is one.
#[must_use]
pub fn file_of(references: &Path, scene: &str, name: &str) -> Option<PathBuf> {
    names(name).into_iter().map(|name| path(references, scene, &name)).find(|file| file.is_file())
}

/// The reference of a scene for a renderer or a target, if there is one; of a target that of the first renderer that reads its files, in
/// the order in which they are listed. `scene` is as it is now, with the depth of paths that is compared; size, algorithm and samples
/// do not
/// matter.
///
/// # Errors
/// If a file is damaged or of other origin.
pub fn find(references: &Path, scene: &Valid, choices: &Choices, name: &str) -> Result<Option<Found>, Failure> {
    let Some(file) = file_of(references, &scene.name, name) else { return Ok(None) };
    let Some((image, variance, about)) = store::decode(&file)? else { return Err(foreign(&file)) };
    let stale = staleness(&about, scene, choices)?;
    Ok(Some(Found { file, image, variance, about, stale }))
}

/// The names under which a reference for a renderer or target may be kept, the nearest first.
fn names(name: &str) -> Vec<String> {
    let mut all = vec![name.to_owned()];
    let target = formats::find(name);
    if let Some(driver) = driver(name).filter(|_| target.is_none() || target.is_some_and(|known| known.name != name)) {
        all.extend([driver.name, driver.target].map(str::to_owned));
    }
    if let Some(target) = target {
        all.push(target.name.to_owned());
        let readers = DRIVERS.iter().filter(|driver| driver.target == target.name);
        all.extend(readers.map(|driver| driver.name.to_owned()));
    }
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|name| seen.insert(name.clone()));
    all
}

fn foreign(file: &Path) -> Failure {
    Failure::new(crate::failure::Exit::Input, format!("{} is no reference that ltsc wrote", file.display()))
        .help("take it in by `ltsc reference add FILE --scene SCENE --renderer NAME --by WHO`, or move it away")
}

/// Why a reference does not show the scene as it is now; none if it does.
pub(crate) fn staleness(about: &About, scene: &Valid, choices: &Choices) -> Result<Option<Stale>, Failure> {
    let Some(target) = formats::find(&about.target) else {
        return Ok(Some(Stale::Unwritable(format!("there is no target `{}`", about.target))));
    };
    Ok(match content_of(scene, target, choices, &about.settings)? {
        Err(why) => Some(Stale::Unwritable(why)),
        Ok(now) if now != about.content => Some(Stale::Changed),
        Ok(_) if scene.integrator.max_depth() != about.settings.max_depth => {
            Some(Stale::Depth { kept: about.settings.max_depth, scene: scene.integrator.max_depth() })
        }
        Ok(_) => None,
    })
}

/// A hash of what is written of a scene with these settings; why not where it is impossible.
fn content_of(
    scene: &Valid,
    target: &'static Target,
    choices: &Choices,
    settings: &Settings,
) -> Result<Result<String, String>, Failure> {
    let known = |words: &[&'static str], word: &str| words.iter().find(|known| **known == word).copied();
    let integrator = known(&Integrator::WORDS, &settings.integrator);
    let sampler = known(&Sampler::WORDS, &settings.sampler);
    if integrator.is_none() || sampler.is_none() {
        return Ok(Err("its algorithm or sampler is not known".to_owned()));
    }
    let overrides = Overrides {
        width: Some(settings.width),
        height: Some(settings.height),
        samples: Some(settings.samples.max(1)),
        seed: Some(0),
        max_depth: Some(settings.max_depth),
        integrator,
        sampler,
        ..Overrides::default()
    };
    let scene = match pipeline::override_settings(scene.clone(), &overrides) {
        Ok(scene) => scene,
        Err(wrong) => {
            let first = wrong.first().map(|finding| finding.message.clone()).unwrap_or_default();
            return Ok(Err(format!("the scene cannot be rendered so: {first}")));
        }
    };
    let writing = Writing { choices: choices.clone(), ..Writing::default() };
    job::content(&scene, target, &writing).map(Ok)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_renderer_has_its_own_reference_or_that_of_its_target() {
        assert_eq!(names("pbrt-r4"), ["pbrt-r4", "pbrt-v4"]);
        assert_eq!(names("pbrt-v4"), ["pbrt-v4", "pbrt-r4"]);
        assert_eq!(names("mitsuba-3"), ["mitsuba-3"]);
        assert_eq!(names("mitsuba"), ["mitsuba", "mitsuba-3"]);
        assert_eq!(names("thesis"), ["thesis"]);
    }

    #[test]
    fn a_smaller_reference_has_the_variance_of_its_blocks() {
        let settings = Settings {
            width: 4,
            height: 2,
            integrator: "path".to_owned(),
            max_depth: 2,
            sampler: "independent".to_owned(),
            samples: 1,
        };
        let origin = Origin::Declared { by: "nobody".to_owned(), file: "a.exr".to_owned(), algorithm: None };
        let about = About::new("one", "a", origin, "luxcore", String::new(), settings);
        let found = Found {
            file: PathBuf::new(),
            image: Image::filled(4, 2, [1.0; 3]),
            variance: Some(Image::filled(4, 2, [0.5; 3])),
            about,
            stale: None,
        };
        let small = found.reduced(2, 1).expect("half");
        assert_eq!(small.variance.expect("a variance").pixels, [[0.125; 3]; 2]);
        assert_eq!(small.image.pixels, [[1.0; 3]; 2]);
    }
}
