//! The file of a reference: the mean, and its standard error as a second layer, in half floats.
//!
//! Half floats have 11 significant bits between 6.1e-5 and 65504 and steps of 6e-8 below. The variance of a good reference of a usual
//! brightness lies under that, its root does not: so the standard error is what is stored. 32 bits are stored where a value is too
//! large, where the image is so dark that its
//! error would be lost, or where rounding would move a tile by more than a tenth of the reference's error. Values are never scaled: whoever
//! reads the file sees radiance.

use std::ops::Range;
use std::path::Path;

use ltsc_render::image::{Image, as_half, attributes, half_bytes, layered_bytes, read_layered};

use super::about::{About, Stored};
use crate::compare::verdict::{DARK, GRIDS, glare};
use crate::failure::{Exit, Failure};

/// The prefix of the channels that hold the standard error of the mean.
pub const ERROR: &str = "error.";

/// The largest half float.
const LARGEST: f32 = 65_504.0;

/// Images whose mean is below this are stored whole: a standard error of a hundredth of it would have 7 bits left.
const DIM: f64 = 1.0 / 1024.0;

/// Tiles along each side, as in the error.
const TILES: usize = GRIDS[0];

/// By how much of its error storing may move a tile.
const SHARE: f64 = 0.1;

/// Without an error this is what rounding may do to a tile.
const UNKNOWN: f64 = 1e-4;

/// The bytes of the file; `about` gets what storing has changed.
pub(super) fn encode(
    path: &Path,
    image: &Image,
    variance: Option<&Image>,
    about: &mut About,
) -> Result<Vec<u8>, Failure> {
    let half = each(image, &as_half);
    let change = change(image, &half);
    let error = about.error.map(|error| error.tiles);
    let fits = fits(image) && change <= error.map_or(UNKNOWN, |error| SHARE * error);
    about.stored = if fits { Stored { bits: 16, change } } else { Stored { bits: 32, change: 0.0 } };
    let root = variance.map(|variance| each(variance, &|value| value.max(0.0).sqrt()));
    let layers: Vec<(&str, &Image)> =
        std::iter::once(("", image)).chain(root.as_ref().map(|root| (ERROR, root))).collect();
    let write = if fits { half_bytes } else { layered_bytes };
    write(path, &layers, &about.provenance())
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))
}

/// What a file holds: mean and variance; none where ltsc did not write it as a reference.
pub(super) fn decode(path: &Path) -> Result<Option<(Image, Option<Image>, About)>, Failure> {
    let (image, root, attributes) =
        read_layered(path, ERROR).map_err(|error| Failure::new(Exit::Input, error.to_string()).help(error.hint()))?;
    let Some(about) = about_of(path, &attributes)? else { return Ok(None) };
    let variance = root.map(|root| each(&root, &|value| value * value));
    Ok(Some((image, variance, about)))
}

fn each(image: &Image, of: &dyn Fn(f32) -> f32) -> Image {
    Image { pixels: image.pixels.iter().map(|pixel| pixel.map(of)).collect(), ..*image }
}

/// What a file says of itself, without its pixels.
pub(super) fn describe(path: &Path) -> Result<Option<About>, Failure> {
    let found = attributes(path).map_err(|error| Failure::new(Exit::Input, error.to_string()).help(error.hint()))?;
    about_of(path, &found)
}

fn about_of(path: &Path, attributes: &[(String, String)]) -> Result<Option<About>, Failure> {
    About::read(attributes)
        .map_err(|failure| Failure { message: format!("{}: {}", path.display(), failure.message), ..failure })
}

fn grey(pixel: &[f32; 3]) -> Option<f64> {
    let mean = pixel.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0;
    mean.is_finite().then_some(mean)
}

fn mean(pixels: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = pixels.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Whether all values lie in the range of half floats.
fn fits(image: &Image) -> bool {
    let values = image.pixels.as_flattened().iter().filter(|value| value.is_finite());
    let largest = values.fold(0.0_f32, |most, value| most.max(value.abs()));
    largest <= LARGEST && mean(image.pixels.iter().filter_map(grey)).abs() >= DIM
}

/// The largest change of the mean of a tile, without the pixels that count in no error either.
fn change(image: &Image, other: &Image) -> f64 {
    let glare = glare(&image.pixels.iter().map(grey).collect::<Vec<_>>(), image.width);
    let counts = |x: usize, y: usize| !glare[y * image.width + x];
    let of = |image: &Image, columns: Range<usize>, rows: Range<usize>| {
        let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        mean(places.filter(|(x, y)| counts(*x, *y)).filter_map(|(x, y)| grey(&image.at(x, y))))
    };
    let light = of(image, 0..image.width, 0..image.height).abs();
    let mut worst = 0.0_f64;
    for tile in 0..TILES * TILES {
        let part = |at: usize, size: usize| at * size / TILES..(at + 1) * size / TILES;
        let (columns, rows) = (part(tile % TILES, image.width), part(tile / TILES, image.height));
        let (a, b) = (of(image, columns.clone(), rows.clone()), of(other, columns, rows));
        let scale = a.abs().max(DARK * light);
        if scale > 0.0 {
            worst = worst.max((b - a).abs() / scale);
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::super::about::{Origin, Settings};
    use super::*;
    use crate::compare::verdict::MeanError;

    fn about(error: f64) -> About {
        let origin = Origin::Declared { by: "nobody".to_owned(), file: "a.exr".to_owned(), algorithm: None };
        let settings = Settings {
            width: 32,
            height: 32,
            integrator: "path".to_owned(),
            max_depth: 8,
            sampler: "independent".to_owned(),
            samples: 256,
        };
        let mut about = About::new("one", "luxcore", origin, "luxcore", "00ff".to_owned(), settings);
        about.error = Some(MeanError { tiles: error, ..MeanError::default() });
        about
    }

    /// Radiance over four decades, times a level, with an error of one percent.
    fn picture(level: f32) -> (Image, Image) {
        let value = |at: usize| level * 10_f32.powf((at * 37 % 1024) as f32 / 256.0 - 3.0);
        let pixels: Vec<[f32; 3]> = (0..1024).map(|at| [value(at), 0.5 * value(at), 0.1 * value(at)]).collect();
        let image = Image { width: 32, height: 32, pixels };
        let variance = image.pixels.iter().map(|pixel| pixel.map(|value| (0.01 * value).powi(2))).collect();
        (image.clone(), Image { pixels: variance, ..image })
    }

    fn kept(level: f32, error: f64) -> (Image, Image, Image, Image, Stored, usize) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let (image, variance) = picture(level);
        let mut about = about(error);
        let bytes = encode(&path, &image, Some(&variance), &mut about).expect("encoded");
        let size = bytes.len();
        crate::disk::write_whole(&path, &mut |out| out.write_all(&bytes)).expect("written");
        let (mean, spread, mut found) = decode(&path).expect("read").expect("ours");
        assert_eq!(describe(&path).expect("read").as_ref(), Some(&found));
        // Decimal numbers may lose the last bit.
        assert!((found.stored.change - about.stored.change).abs() < 1e-12);
        found.stored.change = about.stored.change;
        assert_eq!(found, about);
        (image, variance, mean, spread.expect("a variance"), about.stored, size)
    }

    #[test]
    fn half_floats_lose_less_than_a_tenth_of_the_error() {
        for level in [1e-2, 1.0, 300.0] {
            let (image, variance, mean, spread, stored, _) = kept(level, 5e-3);
            assert_eq!(stored.bits, 16, "{level}");
            // A tile of 16 pixels may be that of one; half an ulp of it is 2^-11.
            assert!(stored.change > 0.0 && stored.change < 5e-4, "{level}: {stored:?}");
            let brightest = image.pixels.as_flattened().iter().fold(0.0_f32, |most, value| most.max(*value));
            for (a, b) in image.pixels.as_flattened().iter().zip(mean.pixels.as_flattened()) {
                // Half an ulp of 11 bits; below the smallest normal number half a step of 6e-8.
                let within = (5e-4 * a).max(3e-8);
                assert!((a - b).abs() <= within, "{level}: {a} {b}");
            }
            for (at, (a, b)) in variance.pixels.as_flattened().iter().zip(spread.pixels.as_flattened()).enumerate() {
                if image.pixels.as_flattened()[at] > 1e-2 * brightest {
                    assert!((b / a - 1.0).abs() < 1e-2, "{level}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn what_rounding_would_spoil_is_stored_whole() {
        let (image, variance, mean, spread, stored, large) = kept(1.0, 1e-5);
        assert_eq!((stored.bits, stored.change, &mean), (32, 0.0, &image));
        let same = |(a, b): (&f32, &f32)| (b / a - 1.0).abs() < 1e-6;
        assert!(variance.pixels.as_flattened().iter().zip(spread.pixels.as_flattened()).all(same));
        // Too dark for their error, and too bright for themselves.
        for level in [1e-7, 1e-3, 1e5] {
            let (image, _, mean, _, stored, _) = kept(level, 5e-3);
            assert_eq!((stored.bits, &mean), (32, &image), "{level}");
        }
        let (.., small) = kept(1.0, 5e-3);
        assert!(small < large * 3 / 4, "{small} bytes, {large} in full");
    }

    #[test]
    fn a_range_that_half_floats_lack_is_stored_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        // A light of 1e12 in a picture of brightness 1.
        let (mut image, variance) = picture(1.0);
        image.pixels[7] = [1e12; 3];
        let mut about = about(5e-3);
        let bytes = encode(&path, &image, Some(&variance), &mut about).expect("encoded");
        crate::disk::write_whole(&path, &mut |out| out.write_all(&bytes)).expect("written");
        let (mean, ..) = decode(&path).expect("read").expect("ours");
        assert!(about.stored.bits == 32 && mean == image, "{:?}", about.stored);
    }
}
