//! The signed difference as a picture: green where B is brighter, red where it is dimmer.

use std::path::Path;

use image::ImageEncoder;

use super::shown::srgb;
use super::{CompareError, Pair};
use ltsc_render::image::{Image, ImageError, finite};

/// What pixels that are not finite look like, a color that no difference has.
const NON_FINITE: [u8; 3] = [0, 0, 255];

/// The difference `mean(B) - mean(A)` of each pixel's channels, times `2^exposure`, in 8-bit sRGB:
/// green above zero, red below, black at zero, and blue where a pixel is not finite.
///
/// # Errors
/// Refuses images of different sizes or without pixels.
pub fn difference_rgb8(a: &Image, b: &Image, exposure: f64) -> Result<Vec<u8>, CompareError> {
    signed(a, b, exposure, |a, b| b - a)
}

/// As [`difference_rgb8`], of the difference as a share of A; where A is black and B is not, it is beyond all bounds.
///
/// # Errors
/// Refuses images of different sizes or without pixels.
pub fn relative_rgb8(a: &Image, b: &Image, exposure: f64) -> Result<Vec<u8>, CompareError> {
    signed(a, b, exposure, |a, b| if a == b { 0.0 } else { (b - a) / a.max(f64::MIN_POSITIVE) })
}

/// The stops that bring the 95th percentile of an image's brightness to 0.8, or that of its pixels above 0 where it is 0 over all; 0 for
/// a black image.
#[must_use]
pub fn exposure(image: &Image) -> f64 {
    let mut values: Vec<f32> =
        image.pixels.iter().map(|pixel| pixel.iter().sum::<f32>() / 3.0).filter(|value| value.is_finite()).collect();
    let of_all = bright(&mut values).filter(|value| *value > 0.0);
    let found = of_all.or_else(|| {
        values.retain(|value| *value > 0.0);
        bright(&mut values)
    });
    found.map_or(0.0, |bright| (0.8 / f64::from(bright)).log2())
}

/// The 95th percentile.
fn bright(values: &mut [f32]) -> Option<f32> {
    let at = values.len() * 95 / 100;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(at, f32::total_cmp).1)
}

/// An image in 8-bit sRGB, its values times `2^exposure`; blue where a pixel is not finite.
pub fn shown_rgb8(image: &Image, exposure: f64) -> Vec<u8> {
    let gain = exposure.exp2();
    let shown = |pixel: &[f32; 3]| {
        if finite(pixel) { pixel.map(|value| encode(f64::from(value) * gain)) } else { NON_FINITE }
    };
    image.pixels.iter().flat_map(shown).collect()
}

/// A difference of the means of channels, green above zero and red below.
fn signed(a: &Image, b: &Image, exposure: f64, of: fn(f64, f64) -> f64) -> Result<Vec<u8>, CompareError> {
    Pair::new(a, b)?;
    let gain = exposure.exp2();
    let mean = |pixel: &[f32; 3]| pixel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
    let color = |(a, b): (&[f32; 3], &[f32; 3])| {
        if !finite(a) || !finite(b) {
            return NON_FINITE;
        }
        let difference = of(mean(a), mean(b));
        let value = encode(difference.abs() * gain);
        if difference > 0.0 { [0, value, 0] } else { [value, 0, 0] }
    };
    Ok(a.pixels.iter().zip(&b.pixels).flat_map(color).collect())
}

/// [`difference_rgb8`] as a PNG file; `path` is for the error.
///
/// # Errors
/// Gives an error if the sizes differ.
pub fn difference_png(path: &Path, a: &Image, b: &Image, exposure: f64) -> Result<Vec<u8>, ImageError> {
    let unwritable = |message: String| ImageError::Unwritable { path: path.to_owned(), message };
    let pixels = difference_rgb8(a, b, exposure).map_err(|error| unwritable(error.to_string()))?;
    png(path, a.width, a.height, &pixels)
}

/// 8-bit sRGB values, row by row, as a PNG file; `path` is for the error.
///
/// # Errors
/// Gives an error if the values are not `3 * width * height`.
pub fn png(path: &Path, width: usize, height: usize, pixels: &[u8]) -> Result<Vec<u8>, ImageError> {
    encoded(path, (width, height), pixels, image::ExtendedColorType::Rgb8)
}

/// One value of 8 bits for each pixel, row by row, as a PNG file; `path` is for the error.
///
/// # Errors
/// Gives an error if the values are not `width * height`.
pub fn grey_png(path: &Path, width: usize, height: usize, pixels: &[u8]) -> Result<Vec<u8>, ImageError> {
    encoded(path, (width, height), pixels, image::ExtendedColorType::L8)
}

fn encoded(
    path: &Path,
    (width, height): (usize, usize),
    pixels: &[u8],
    color: image::ExtendedColorType,
) -> Result<Vec<u8>, ImageError> {
    let unwritable = |message: String| ImageError::Unwritable { path: path.to_owned(), message };
    if pixels.len() != usize::from(color.channel_count()) * width * height {
        return Err(unwritable(format!("{} values for {width} x {height} pixels", pixels.len())));
    }
    let side = |size: usize| u32::try_from(size).map_err(|_| unwritable("too large".to_owned()));
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(pixels, side(width)?, side(height)?, color)
        .map_err(|error| unwritable(error.to_string()))?;
    Ok(png)
}

/// Reads a grey PNG of 8 bits back: width, height, and one value for each pixel; nothing of another file.
#[must_use]
pub fn read_grey_png(bytes: &[u8]) -> Option<(usize, usize, Vec<u8>)> {
    let picture = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).ok()?;
    let image::DynamicImage::ImageLuma8(picture) = picture else { return None };
    Some((picture.width() as usize, picture.height() as usize, picture.into_raw()))
}

/// A value in sRGB, rounded to 8 bits.
fn encode(linear: f64) -> u8 {
    (srgb(linear) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_brings_the_bright_part_to_the_same_brightness() {
        let image =
            |scale: f32| Image { width: 100, height: 1, pixels: (0..100).map(|at| [scale * at as f32; 3]).collect() };
        assert!((exposure(&image(1.0)) - (0.8_f64 / 95.0).log2()).abs() < 1e-6);
        assert!((exposure(&image(0.25)) - exposure(&image(1.0)) - 2.0).abs() < 1e-6);
        // All but one pixel are black.
        let mut spot = image(0.0);
        spot.pixels[7] = [0.4; 3];
        assert!((exposure(&spot) - 1.0).abs() < 1e-6);
        assert_eq!((exposure(&image(0.0)), exposure(&Image::filled(2, 1, [f32::NAN; 3]))), (0.0, 0.0));
    }

    #[test]
    fn colors_show_sign_and_exposure() {
        let a = Image::filled(4, 1, [1.0; 3]);
        let mut b = a.clone();
        b.pixels[0] = [1.5, 1.5, 1.5];
        b.pixels[1] = [0.25, 0.5, 0.75];
        b.pixels[3] = [1.0, f32::NAN, 1.0];
        let plain = difference_rgb8(&a, &b, 0.0).expect("equal sizes");
        // Half intensity is 188 in sRGB.
        assert_eq!(plain, [0, 188, 0, 188, 0, 0, 0, 0, 0, 0, 0, 255]);
        let bright = difference_rgb8(&a, &b, 1.0).expect("equal sizes");
        assert_eq!(bright[..6], [0, 255, 0, 255, 0, 0]);
        let dark = difference_rgb8(&a, &b, -10.0).expect("equal sizes");
        // 0.5 / 1024 lies in the linear part: 12.92 * 255 * 0.5 / 1024 = 1.6.
        assert_eq!(dark[..6], [0, 2, 0, 2, 0, 0]);
        assert!(difference_rgb8(&a, &Image::filled(1, 4, [1.0; 3]), 0.0).is_err());
    }

    #[test]
    fn relative_differences_are_shares_of_the_first() {
        let mut a = Image::filled(3, 1, [2.0; 3]);
        let mut b = Image::filled(3, 1, [3.0; 3]);
        (a.pixels[1], b.pixels[1]) = ([0.0; 3], [0.0; 3]);
        (a.pixels[2], b.pixels[2]) = ([0.0; 3], [1e-9; 3]);
        assert_eq!(relative_rgb8(&a, &b, 0.0).expect("equal sizes"), [0, 188, 0, 0, 0, 0, 0, 255, 0]);
        assert_eq!(shown_rgb8(&Image::filled(1, 1, [0.25, f32::NAN, 1.0]), 1.0), NON_FINITE);
        assert_eq!(shown_rgb8(&Image::filled(1, 1, [0.25, 0.0, 1.0]), 1.0), [188, 0, 255]);
    }

    #[test]
    fn the_file_is_a_png_of_the_same_size() {
        let a = Image::filled(5, 3, [1.0; 3]);
        let bytes = difference_png(Path::new("a.png"), &a, &Image::filled(5, 3, [2.0; 3]), 0.0).expect("a file");
        let png = image::load_from_memory(&bytes).expect("decode");
        assert_eq!((png.width(), png.height()), (5, 3));
        assert_eq!(png.to_rgb8().get_pixel(4, 2).0, [0, 255, 0]);
    }
}
