//! A reference from elsewhere, with the origin that somebody declares for it.

use std::path::{Path, PathBuf};

use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::valid::Valid;
use ltsc_render::image::{Image, ImageError, Window, read, read_layered, read_placed};
use ltsc_render::run::driver;

use super::about::{About, Origin};
use super::render::{prepared, settings_of, write};
use super::{ERROR, content_of, path, store};
use crate::chunk::{LEAST, VARIANCE};
use crate::compare::verdict::error_of;
use crate::failure::{Exit, Failure};

/// An image with what is said of it.
pub struct Declared<'a> {
    /// The image, in OpenEXR or PFM.
    pub file: &'a Path,
    /// The variance of its mean, in another file of the same size.
    pub variance: Option<&'a Path>,
    /// The name under which it is kept.
    pub name: &'a str,
    /// Who or what it is from.
    pub by: &'a str,
    /// The algorithm, as they call it.
    pub algorithm: Option<&'a str>,
    /// Samples per pixel.
    pub samples: Option<u64>,
    /// Segments of its longest paths, where they are not those of the scene.
    pub max_depth: Option<u32>,
}

/// The target whose files tell whether a scene has changed, where a name belongs to none.
const TARGET: &str = "mitsuba-3";

/// Takes an image in as the reference of a scene, which has its own settings.
///
/// # Errors
/// If it cannot be read, does not have the proportions of the scene's image, or another one stands in its place.
pub fn add(
    references: &Path,
    scene: Valid,
    choices: &Choices,
    declared: &Declared<'_>,
    force: bool,
) -> Result<(PathBuf, About), Failure> {
    let name = kept_name(declared.name)?;
    let by = declared.by.trim();
    if by.is_empty() {
        return Err(Failure::new(Exit::Usage, "`--by` is empty").help("say who or what the image is from"));
    }
    let (image, variance) = images(declared)?;
    let film = (u64::from(scene.film.width), u64::from(scene.film.height));
    let size = (image.width as u64, image.height as u64);
    if size.0 * film.1 != size.1 * film.0 {
        let message = format!(
            "{} has {}x{} pixels, and the image of {} {}x{}",
            declared.file.display(),
            size.0,
            size.1,
            scene.name,
            film.0,
            film.1
        );
        return Err(Failure::new(Exit::Input, message).help("a reference has the proportions of the scene's image"));
    }
    let file = path(references, &scene.name, &name);
    if std::fs::symlink_metadata(&file).is_ok() && !force {
        let there = store::describe(&file).ok().flatten().map_or("something else".to_owned(), |about| about.maker());
        return Err(Failure::new(Exit::Usage, format!("{} is there: {there}", file.display()))
            .help("choose another name, or add `--force` to write over it"));
    }
    let longer = u32::try_from(size.0.max(size.1)).ok();
    let scene = prepared(scene, longer, None, declared.max_depth)?;
    let settings = settings_of(&scene);
    let target = target_of(&name);
    let content = content_of(&scene, target, choices, &settings)?.map_err(|why| Failure::new(Exit::Input, why))?;
    let origin = Origin::Declared {
        by: by.to_owned(),
        file: declared.file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        algorithm: declared.algorithm.map(str::to_owned),
    };
    let mut about = About::new(&scene.name, &name, origin, target.name, content, settings);
    about.samples = declared.samples;
    if let Some(variance) = &variance {
        // How well a variance is known that somebody else has measured nobody says.
        about.images = LEAST as u32;
        let error = error_of(&image, variance, about.images as usize);
        about.error = Some(error.map_err(|error| Failure::new(Exit::Input, error.to_string()).help(error.hint()))?);
    }
    write(references, &file, (&image, variance.as_ref()), &mut about, force)?;
    Ok((file, about))
}

/// The name of a renderer or target as the tables have it, or one of small letters, digits, hyphens, dots and underscores.
fn kept_name(name: &str) -> Result<String, Failure> {
    if let Some(known) = driver(name).map(|driver| driver.name).or(formats::find(name).map(|target| target.name)) {
        return Ok(known.to_owned());
    }
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '_' | '.');
    if !name.is_empty()
        && name.len() <= 64
        && name.chars().all(plain)
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
    {
        return Ok(name.to_owned());
    }
    Err(Failure::new(Exit::Usage, format!("`{name}` cannot be the name of a reference"))
        .help("write a renderer, a target, or a word of small letters, digits, `-`, `_` and `.`"))
}

fn target_of(name: &str) -> &'static Target {
    let known = driver(name).and_then(|driver| formats::find(driver.target)).or_else(|| formats::find(name));
    // A test of the tables of targets knows it.
    known.or_else(|| formats::find(TARGET)).unwrap_or_else(|| unreachable!("there is no target {TARGET}"))
}

/// The image and the variance of its mean: from a file of its own, or from layers `variance` or `error` of the image.
fn images(declared: &Declared<'_>) -> Result<(Image, Option<Image>), Failure> {
    let wrong = |error: ImageError| Failure::new(Exit::Input, error.to_string()).help(error.hint());
    let (image, window, _) = read_placed(declared.file).map_err(wrong)?;
    let whole = Window { at: window.shown_at, shown: (image.width, image.height), ..window };
    if whole != window {
        return Err(Failure::new(Exit::Input, format!("{} is not shown whole", declared.file.display()))
            .help("write it with equal data and display windows"));
    }
    if image.non_finite() == image.pixels.len() {
        return Err(Failure::new(Exit::Input, format!("{} has no finite pixel", declared.file.display())));
    }
    let variance = match declared.variance {
        Some(file) => Some(read(file).map_err(wrong)?.0),
        None => {
            let (_, variance, _) = read_layered(declared.file, VARIANCE).map_err(wrong)?;
            let (_, error, _) = read_layered(declared.file, ERROR).map_err(wrong)?;
            let squared = error.map(|error| Image {
                pixels: error.pixels.iter().map(|pixel| pixel.map(|value| value * value)).collect(),
                ..error
            });
            variance.or(squared)
        }
    };
    if let Some(variance) = &variance {
        if (variance.width, variance.height) != (image.width, image.height) {
            return Err(Failure::new(Exit::Input, "the variance has another size than the image"));
        }
        if variance.pixels.as_flattened().iter().any(|value| *value < 0.0) {
            return Err(Failure::new(Exit::Input, "the variance is negative in some pixels")
                .help("give the variance of the mean, not a difference"));
        }
    }
    Ok((image, variance))
}
