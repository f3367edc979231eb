//! Pixels on their way into a browser: numbers as planes of bytes, deflated, and written as scripts, since a page that was opened from a
//! disk may load scripts beside it and nothing else.
//!
//! A number has 4 bytes, or 3 where a page would be large: the sign, the exponent and 15 bits of the mantissa of a single-precision
//! float, rounded to the nearest, so that the range is the same and the relative error at most 2^-16.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ltsc_render::image::{Image, finite};

use super::model::{Data, Preview};
use crate::compare::{exposure, shown_rgb8};

/// The longest side of an image that is loaded in one piece, and of a part of a larger one.
const TILE: usize = 768;

/// The longest side of what is shown of a larger image first.
const PREVIEW: usize = 512;

/// The longest side of a small picture on the index.
const THUMB: usize = 192;

/// How hard deflate tries, 0 to 10: noise does not get smaller by more.
const EFFORT: u8 = 6;

/// What an image is as data, but for its numbers.
pub(super) fn data(image: &Image, bytes: usize) -> Data {
    let (width, height) = (image.width, image.height);
    let longest = width.max(height);
    let preview = (longest > TILE).then(|| {
        let factor = longest.div_ceil(PREVIEW);
        Preview { factor, width: width.div_ceil(factor), height: height.div_ceil(factor) }
    });
    let starts = |size: usize| (0..size).step_by(TILE);
    let tile = |x: usize, y: usize| [x, y, TILE.min(width - x), TILE.min(height - y)];
    let tiles = starts(height).flat_map(|y| starts(width).map(move |x| (x, y))).map(|(x, y)| tile(x, y)).collect();
    let same = |[r, g, b]: &[f32; 3]| r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
    let finite_pixels = || image.pixels.iter().filter(|pixel| finite(pixel));
    let count = finite_pixels().count();
    let mean = std::array::from_fn(|channel| {
        let sum: f64 = finite_pixels().map(|pixel| f64::from(pixel[channel])).sum();
        (count > 0).then(|| sum / count as f64)
    });
    Data {
        width,
        height,
        grey: image.pixels.iter().all(same),
        bytes,
        preview,
        tiles,
        exposure: exposure(image),
        mean,
        non_finite: image.pixels.len() - count,
    }
}

/// The script that brings a part of an image, by the number of the image and of the part; the preview is the part `p`.
pub(super) fn script(image: &Image, data: &Data, number: usize, part: &str, [x, y, w, h]: [usize; 4]) -> Vec<u8> {
    let rows = (y..y + h).flat_map(|row| &image.pixels[row * image.width + x..][..w]);
    let pixels: Vec<[f32; 3]> = rows.copied().collect();
    let text = STANDARD.encode(miniz_oxide::deflate::compress_to_vec_zlib(&planes(&pixels, data), EFFORT));
    format!("ltsc.bring({number},\"{part}\",\"{text}\");\n").into_bytes()
}

/// The script that brings one byte for each pixel.
pub(super) fn group_script(name: &str, pixels: &[u8]) -> Vec<u8> {
    let text = STANDARD.encode(miniz_oxide::deflate::compress_to_vec_zlib(pixels, EFFORT));
    format!("ltsc.groups(\"{name}\",\"{text}\");\n").into_bytes()
}

/// The bytes of numbers, most significant first: all first bytes of the first channel, then all second ones, and so on.
fn planes(pixels: &[[f32; 3]], data: &Data) -> Vec<u8> {
    let channels = if data.grey { 1 } else { 3 };
    let mut all = Vec::with_capacity(pixels.len() * channels * data.bytes);
    for channel in 0..channels {
        let bits: Vec<u32> = pixels.iter().map(|pixel| rounded(pixel[channel], data.bytes)).collect();
        for byte in 0..data.bytes {
            all.extend(bits.iter().map(|bits| (bits >> (24 - 8 * byte)) as u8));
        }
    }
    all
}

/// The bits of a number of which only the first `bytes` are kept.
fn rounded(value: f32, bytes: usize) -> u32 {
    let bits = value.to_bits();
    if bytes >= 4 {
        return bits;
    }
    if value.is_nan() {
        return 0x7fc0_0000;
    }
    if value.is_infinite() {
        return bits;
    }
    // To the nearest, half up; the largest numbers stay finite.
    let up = bits.wrapping_add(0x80);
    if f32::from_bits(up).is_finite() { up & 0xffff_ff00 } else { bits & 0xffff_ff00 }
}

/// The image with each block of `factor` times `factor` pixels averaged; blocks at the border may be smaller. Pixels that are not finite
/// are left out, and a block of such pixels stays one.
pub(super) fn smaller(image: &Image, factor: usize) -> Image {
    let (width, height) = (image.width.div_ceil(factor), image.height.div_ceil(factor));
    let block = |x: usize, y: usize| {
        let (mut sum, mut count) = ([0.0_f64; 3], 0_u32);
        for row in y * factor..((y + 1) * factor).min(image.height) {
            for column in x * factor..((x + 1) * factor).min(image.width) {
                let pixel = image.at(column, row);
                if finite(&pixel) {
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += f64::from(value);
                    }
                    count += 1;
                }
            }
        }
        if count == 0 { image.at(x * factor, y * factor) } else { sum.map(|sum| (sum / f64::from(count)) as f32) }
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| block(x, y)).collect();
    Image { width, height, pixels }
}

/// A small picture in 8-bit sRGB at the exposure of the image: width, height, values.
pub(super) fn thumb(image: &Image, exposure: f64) -> (usize, usize, Vec<u8>) {
    let factor = image.width.max(image.height).div_ceil(THUMB).max(1);
    let small = smaller(image, factor);
    let shown = shown_rgb8(&small, exposure);
    (small.width, small.height, shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of a script, read as the page does it.
    fn read_back(script: &[u8], data: &Data, count: usize) -> Vec<[f32; 3]> {
        let text = String::from_utf8(script.to_vec()).expect("text");
        let packed = text.split('"').nth(3).expect("the numbers");
        let bytes = STANDARD.decode(packed).expect("base64");
        let bytes = miniz_oxide::inflate::decompress_to_vec_zlib(&bytes).expect("zlib");
        let channels = if data.grey { 1 } else { 3 };
        assert_eq!(bytes.len(), count * channels * data.bytes);
        let number = |at: usize, channel: usize| {
            let plane = |byte: usize| u32::from(bytes[(channel * data.bytes + byte) * count + at]);
            f32::from_bits((0..data.bytes).fold(0, |bits, byte| bits | plane(byte) << (24 - 8 * byte)))
        };
        (0..count).map(|at| std::array::from_fn(|channel| number(at, channel.min(channels - 1)))).collect()
    }

    fn strange() -> Image {
        let values = [0.0, -0.0, 1.0, -2.5, 1e-30, 3.4e38, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, 0.1];
        let mut pixels: Vec<[f32; 3]> = values.iter().map(|value| [*value, 0.3, -value]).collect();
        pixels.push([f32::NAN, 1.0, 2.0]);
        Image { width: 4, height: 3, pixels }
    }

    #[test]
    fn numbers_of_four_bytes_are_exact_and_of_three_nearly() {
        let image = strange();
        let whole = [0, 0, 4, 3];
        let exact = data(&image, 4);
        let found = read_back(&script(&image, &exact, 0, "0", whole), &exact, 12);
        let bits = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&image.pixels));
        let short = data(&image, 3);
        let found = read_back(&script(&image, &short, 0, "0", whole), &short, 12);
        for (found, wanted) in found.iter().flatten().zip(image.pixels.iter().flatten()) {
            let close = (f64::from(*found) - f64::from(*wanted)).abs() <= f64::from(wanted.abs()) / 65536.0;
            let same = wanted.is_nan() && found.is_nan() || found == wanted;
            assert!(same || close && found.is_finite(), "{found}, not {wanted}");
        }
    }

    #[test]
    fn parts_cover_an_image_once_and_a_grey_one_is_stored_once() {
        let image = Image::filled(1600, 900, [0.25; 3]);
        let data = data(&image, 4);
        assert!(data.grey);
        let covered: usize = data.tiles.iter().map(|[_, _, w, h]| w * h).sum();
        assert_eq!((covered, data.tiles.len()), (1600 * 900, 6));
        let preview = data.preview.expect("it is large");
        assert_eq!((preview.factor, preview.width, preview.height), (4, 400, 225));
        let [x, y, w, h] = data.tiles[5];
        let found = read_back(&script(&image, &data, 7, "5", [x, y, w, h]), &data, w * h);
        assert!(found.iter().all(|pixel| *pixel == [0.25; 3]));
    }

    #[test]
    fn smaller_images_are_averages_without_what_is_not_finite() {
        let mut image = Image::filled(5, 3, [1.0, 2.0, 0.0]);
        image.pixels[0] = [f32::NAN, 0.0, 0.0];
        image.pixels[1] = [4.0, 2.0, 0.0];
        image.pixels[14] = [f32::INFINITY; 3];
        let small = smaller(&image, 2);
        assert_eq!((small.width, small.height), (3, 2));
        assert_eq!(small.at(0, 0), [2.0, 2.0, 0.0]);
        assert_eq!(small.at(2, 1), [f32::INFINITY; 3]);
    }

    #[test]
    fn eleven_scenes_in_three_renderers_are_under_a_hundred_megabytes() {
        // The worst case: noise all over.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let pixels = (0..128 * 128).map(|_| std::array::from_fn(|_| random() + random() * random())).collect();
        let image = Image { width: 128, height: 128, pixels };
        let short = data(&image, 3);
        let bytes = script(&image, &short, 0, "0", [0, 0, 128, 128]).len();
        let all = 33 * bytes * (512 * 512) / (128 * 128);
        assert!(all < 95_000_000, "{all} bytes of 33 images of 512 x 512 pixels");
    }
}
