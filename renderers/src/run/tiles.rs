//! Seeds for PBRT version 3, which has none: its random numbers belong to tiles of the film.
//!
//! `SamplerIntegrator::Render` gives each tile of 16 by 16 pixels a sampler of its own, numbered row by row. With rows of tiles added above
//! the image, each tile of the image gets another number. Seed `k` adds `k` times the rows that the image has, so that no two seeds
//! share a number at any place. The view of the image stays what it is: the screen window grows with the film.

use std::path::PathBuf;

use super::{Job, RenderError, emitted, pbrt};

/// The side of a tile (`core/integrator.cpp`).
const TILE: usize = 16;

/// The most rows of a film: positions on it are single precision, and with so many a pixel still has 256 of them.
const MOST_ROWS: usize = 1 << 15;

/// The most pixels of a film, of 32 bytes each.
const MOST_PIXELS: usize = 1 << 26;

/// Integrators whose random numbers belong to tiles.
const TILED: [&str; 2] = ["path", "bdpt"];

/// How pixels outside the image can be left out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outside {
    /// By the parameter `pixelbounds` of the path integrator.
    Skipped,
    /// Not at all: all rows are rendered.
    Rendered,
}

/// Changes the files of the emitted folder so that the image has the random numbers of the request's seed, and gives the rows that the
/// film has above the image. `changed` holds files that are changed already.
///
/// # Errors
/// If the integrator or the sampler takes its random numbers from elsewhere, the film gets too large, or the files are not as they
/// are emitted.
pub(super) fn seed(
    job: &Job<'_>,
    outside: Outside,
    changed: &mut Vec<(PathBuf, String)>,
) -> Result<usize, RenderError> {
    let seed = job.request.seed as usize;
    if seed == 0 {
        return Ok(0);
    }
    let files: Vec<(PathBuf, String)> = emitted::texts(job.folder, "pbrt")
        .map(|(path, text)| match changed.iter().find(|(known, _)| *known == path) {
            Some((_, text)) => (path, text.clone()),
            None => (path, text),
        })
        .collect();
    let (width, height) = (job.request.width, job.request.height);
    let name = job.request.driver.name;
    for (directive, known, what) in [("Integrator", &TILED[..], "integrator"), ("Sampler", &["random"][..], "sampler")]
    {
        let kind = files.iter().find_map(|(_, text)| kind_of(text, directive)).unwrap_or("none");
        if !known.contains(&kind) {
            return Err(RenderError::Request {
                message: format!("{name} has no seeds for the {what} `{kind}`"),
                hint: "leave the seed at 0, or let the scene say `integrator = path(...)` and `sampler = independent(...)`"
                    .to_owned(),
            });
        }
    }
    let radius = files.iter().find_map(|(_, text)| float(text, "PixelFilter", "ywidth")).unwrap_or(2.0).ceil() as usize;
    // Samples are taken where they reach into the image; one more row for what is rounded.
    let tiles = radius.saturating_mul(2).saturating_add(height + 2).div_ceil(TILE);
    let above = tiles.saturating_mul(TILE).saturating_mul(seed);
    let rows = above.saturating_add(height);
    let most_rows = MOST_ROWS.min(MOST_PIXELS / width.max(1));
    if rows > most_rows {
        let most = most_rows.saturating_sub(height) / tiles.saturating_mul(TILE);
        return Err(RenderError::Request {
            message: format!(
                "{name} has no seed {seed} for an image of {width}x{height} pixels: the largest is {most}"
            ),
            hint: "count seeds from 0, or make the image smaller".to_owned(),
        });
    }
    let (x, y) = if width > height { (width as f64 / height as f64, 1.0) } else { (1.0, height as f64 / width as f64) };
    let top = y + 2.0 * y * above as f64 / height as f64;
    let window = format!(" \"float screenwindow\" [{} {x} {} {top}]", -x, -y);
    let (from, to) = (above.saturating_sub(TILE), rows + TILE);
    let bounds = format!(" \"integer pixelbounds\" [{} {} {from} {to}]", -(TILE as i64), width + TILE);
    let (mut film, mut camera) = (false, false);
    for (path, text) in files {
        let mut new = text.clone();
        if let Some((start, end)) = pbrt::value_of(&new, "Film", "yresolution") {
            film |= new[start..end] == height.to_string();
            new.replace_range(start..end, &rows.to_string());
        }
        if !new.contains("\"float screenwindow\"") {
            new = pbrt::with_parameter(&new, "Camera", Some("perspective"), &window);
            camera |= new.contains("\"float screenwindow\"");
        }
        if outside == Outside::Skipped {
            // Light that `bdpt` carries to the film counts all samples of the film.
            new = pbrt::with_parameter(&new, "Integrator", Some("path"), &bounds);
        }
        if new != text {
            changed.retain(|(known, _)| *known != path);
            changed.push((path, new));
        }
    }
    if film && camera {
        return Ok(above);
    }
    Err(RenderError::Request {
        message: format!(
            "the files have no perspective camera or no film of {width}x{height} pixels, which seeds of {name} need"
        ),
        hint: format!("emit the scene for the target `{}` again, or leave the seed at 0", job.request.driver.target),
    })
}

/// The type of a directive: `path` of `Integrator "path"`.
fn kind_of<'a>(text: &'a str, directive: &str) -> Option<&'a str> {
    let (start, end) = pbrt::directive(text, directive)?;
    text[start..end].trim_end_matches('"').rsplit('"').next()
}

/// The value of a parameter of one number.
fn float(text: &str, directive: &str, name: &str) -> Option<f64> {
    let (start, _) = pbrt::directive(text, directive)?;
    let from = start + text[start..].find(&format!("\"float {name}\""))?;
    let rest = &text[from..];
    rest[rest.find('[')? + 1..rest.find(']')?].trim().parse().ok()
}
