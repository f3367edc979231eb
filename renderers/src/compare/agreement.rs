//! Whether several noisy images of one scene by one renderer agree with those by another.
//!
//! Each side is a list of images with different seeds. Their scatter tells the noise of each tile, and a tile's difference is
//! counted in units of that noise, with a little that two right renderers may differ by.

use serde::{Deserialize, Serialize};

use super::CompareError;
use crate::image::{Image, finite};

/// Tiles along each side.
const TILES: usize = 8;

/// What two right renderings of a tile may differ by: this share of the tile ...
const OF_TILE: f64 = 0.002;
/// ... and this share of the image's mean, which counts in dark tiles only.
const OF_IMAGE: f64 = 0.0025;

/// Pixels of the reference brighter than this many times its mean are left out: a light seen directly in a few pixels would
/// otherwise make the mean (the pools of the lteval suite: six pixels change it by 41 %).
const GLARE: f64 = 100.0;

/// The bounds within which renderers agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Share by which means may differ, or four standard errors where that is more.
    pub mean: f64,
    /// Root mean square of the tiles' z.
    pub rms: f64,
    /// The largest z of a tile.
    pub worst: f64,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { mean: 0.005, rms: 1.6, worst: 6.0 }
    }
}

/// How two renderers agree on a scene. Ratios are B/A.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Images of A and of B.
    pub images: (usize, usize),
    /// Ratio of the means in red, green and blue; none where A is black.
    pub channels: [Option<f64>; 3],
    /// Ratio of the mean luminances.
    pub ratio: f64,
    /// Standard error of that ratio, from the scatter of the images.
    pub error: f64,
    /// Root mean square of the tiles' z.
    pub rms: f64,
    /// The largest z of a tile, without its sign.
    pub worst: f64,
    /// Column and row of that tile, from the upper left, beginning with 0.
    pub worst_tile: (usize, usize),
    /// The farthest any tile's luminance lies from A's, as a share of it, where the tile holds at least a twentieth of the image's
    /// mean: with the noise that is in it.
    pub farthest: f64,
    /// Pixels left out for their brightness or for not being finite.
    pub masked: usize,
}

impl Agreement {
    /// Compares images of B with those of the reference A. A may be a single image that is taken to be free of noise.
    ///
    /// # Errors
    /// Refuses images of different sizes, sides without images, and a B with a single image, which tells no noise.
    pub fn of(a: &[Image], b: &[Image]) -> Result<Self, CompareError> {
        let first = a.first().ok_or(CompareError::Empty)?;
        if b.len() < 2 || first.pixels.is_empty() {
            return Err(CompareError::Empty);
        }
        let size = (first.width, first.height);
        for other in a.iter().chain(b) {
            if (other.width, other.height) != size {
                return Err(CompareError::Size { a: size, b: (other.width, other.height) });
            }
        }
        let mask = mask(a, b);
        let masked = mask.iter().filter(|out| **out).count();
        if masked == mask.len() {
            return Err(CompareError::Empty);
        }
        let (tiles_a, tiles_b) = (tiles(a, &mask), tiles(b, &mask));
        let (means_a, means_b) = (means(a, &mask), means(b, &mask));
        let light = |means: &[[f64; 3]]| Sample::of(means.iter().map(luminance));
        let (whole_a, whole_b) = (light(&means_a), light(&means_b));
        if whole_a.mean <= 0.0 {
            return Err(CompareError::Empty);
        }
        let channels = [0, 1, 2].map(|channel| {
            let of = |means: &[[f64; 3]]| Sample::of(means.iter().map(|mean| mean[channel])).mean;
            (of(&means_a) > 0.0).then(|| of(&means_b) / of(&means_a))
        });
        let (mut sum, mut worst, mut worst_tile, mut farthest) = (0.0, 0.0_f64, (0, 0), 0.0_f64);
        let mut count = 0;
        for (at, (one, other)) in tiles_a.iter().zip(&tiles_b).enumerate() {
            let (Some(one), Some(other)) = (one, other) else { continue };
            let allowed = (OF_TILE * one.mean).powi(2) + (OF_IMAGE * whole_a.mean).powi(2);
            let z = ((other.mean - one.mean) / (one.error2 + other.error2 + allowed).sqrt()).abs();
            sum += z * z;
            count += 1;
            if z > worst {
                (worst, worst_tile) = (z, (at % TILES, at / TILES));
            }
            if one.mean >= 0.05 * whole_a.mean {
                farthest = farthest.max((other.mean / one.mean - 1.0).abs());
            }
        }
        let ratio = whole_b.mean / whole_a.mean;
        let error = (whole_a.error2 * ratio * ratio + whole_b.error2).sqrt() / whole_a.mean;
        let rms = (sum / f64::from(count.max(1))).sqrt();
        Ok(Self { images: (a.len(), b.len()), channels, ratio, error, rms, worst, worst_tile, farthest, masked })
    }

    /// What does not hold, in words; empty where the two agree.
    #[must_use]
    pub fn failures(&self, bounds: Bounds) -> Vec<String> {
        let mut found = Vec::new();
        let allowed = bounds.mean.max(4.0 * self.error);
        if (self.ratio - 1.0).abs() > allowed {
            found.push(format!(
                "the means differ by {:+.2} %, {:.2} % allowed",
                100.0 * (self.ratio - 1.0),
                100.0 * allowed
            ));
        }
        if self.rms >= bounds.rms {
            found.push(format!("the tiles' z has a root mean square of {:.2}, {} allowed", self.rms, bounds.rms));
        }
        if self.worst > bounds.worst {
            let (column, row) = self.worst_tile;
            found.push(format!("tile {column}, {row} has a z of {:.1}, {} allowed", self.worst, bounds.worst));
        }
        found
    }
}

/// Mean of a list of values, and the square of the standard error of that mean.
#[derive(Clone, Copy, Debug)]
struct Sample {
    mean: f64,
    error2: f64,
}

impl Sample {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let scatter: f64 = values.map(|value| (value - mean) * (value - mean)).sum();
        // A single image is taken to be free of noise.
        let error2 = if count > 1.0 { scatter / (count - 1.0) / count } else { 0.0 };
        Self { mean, error2 }
    }
}

/// Rec. 709 luminance of linear RGB.
fn luminance(rgb: &[f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// Which pixels are left out: those that are not finite in some image, and glare of the reference.
fn mask(a: &[Image], b: &[Image]) -> Vec<bool> {
    let mut out: Vec<bool> =
        (0..a[0].pixels.len()).map(|at| a.iter().chain(b).any(|image| !finite(&image.pixels[at]))).collect();
    let light = |at: usize| {
        let sum: f64 = a.iter().map(|image| luminance(&image.pixels[at].map(f64::from))).sum();
        sum / a.len() as f64
    };
    let kept: Vec<(usize, f64)> = (0..out.len()).filter(|at| !out[*at]).map(|at| (at, light(at))).collect();
    let mean = kept.iter().map(|(_, light)| light).sum::<f64>() / kept.len().max(1) as f64;
    for (at, light) in kept {
        out[at] = light > GLARE * mean;
    }
    out
}

/// The mean of each image over the pixels that are kept.
fn means(images: &[Image], mask: &[bool]) -> Vec<[f64; 3]> {
    let count = mask.iter().filter(|out| !**out).count() as f64;
    let mean = |image: &Image| {
        let mut sum = [0.0; 3];
        for (pixel, _) in image.pixels.iter().zip(mask).filter(|(_, out)| !**out) {
            for (total, value) in sum.iter_mut().zip(pixel) {
                *total += f64::from(*value);
            }
        }
        sum.map(|total| total / count)
    };
    images.iter().map(mean).collect()
}

/// The luminance of each tile; none where all of its pixels are left out, or the image has fewer.
fn tiles(images: &[Image], mask: &[bool]) -> Vec<Option<Sample>> {
    let (width, height) = (images[0].width, images[0].height);
    let range = |at: usize, size: usize| at * size / TILES..(at + 1) * size / TILES;
    let tile = |column: usize, row: usize| {
        let inside: Vec<usize> = range(row, height)
            .flat_map(|y| range(column, width).map(move |x| y * width + x))
            .filter(|at| !mask[*at])
            .collect();
        let mean = |image: &Image| {
            inside.iter().map(|at| luminance(&image.pixels[*at].map(f64::from))).sum::<f64>() / inside.len() as f64
        };
        (!inside.is_empty()).then(|| Sample::of(images.iter().map(mean)))
    };
    (0..TILES * TILES).map(|at| tile(at % TILES, at / TILES)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Images of 32 x 32 pixels around `level`, with noise from a small generator.
    fn noisy(level: f32, noise: f32, count: usize, seed: u64) -> Vec<Image> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 40) as f32 / (1_u64 << 24) as f32 - 0.5
        };
        let image = |_| {
            let mut image = Image::filled(32, 32, [0.0; 3]);
            image.pixels.iter_mut().for_each(|pixel| *pixel = [level * (1.0 + noise * random()); 3]);
            image
        };
        (0..count).map(image).collect()
    }

    #[test]
    fn equal_truth_agrees_and_the_noise_is_seen() {
        let agreement = Agreement::of(&noisy(0.5, 1.0, 8, 1), &noisy(0.5, 1.0, 8, 2)).expect("comparable");
        assert_eq!(agreement.failures(Bounds::default()), Vec::<String>::new());
        // Uniform noise has a deviation of its width / sqrt(12); 16 images of 1024 pixels, both sides.
        let expected = (1.0 / 12.0_f64 / 1024.0 / 8.0 * 2.0).sqrt();
        assert!((agreement.error / expected - 1.0).abs() < 0.6, "{} for {expected}", agreement.error);
        assert!((0.3..1.6).contains(&agreement.rms), "{agreement:?}");
    }

    #[test]
    fn a_brighter_whole_and_a_brighter_tile_are_found() {
        let a = noisy(0.5, 0.2, 4, 3);
        let whole = Agreement::of(&a, &noisy(0.51, 0.2, 4, 4)).expect("comparable");
        assert!(
            whole.failures(Bounds::default()).iter().any(|failure| failure.contains("means differ by +")),
            "{whole:?}"
        );
        let mut b = noisy(0.5, 0.2, 4, 5);
        for image in &mut b {
            for y in 8..12 {
                for x in 20..24 {
                    image.pixels[y * 32 + x] = [0.6; 3];
                }
            }
        }
        let tile = Agreement::of(&a, &b).expect("comparable");
        assert_eq!(tile.worst_tile, (5, 2));
        assert!(tile.failures(Bounds::default()).iter().any(|failure| failure.contains("tile 5, 2")), "{tile:?}");
        assert!((tile.farthest - 0.2).abs() < 0.05);
    }

    #[test]
    fn glare_and_what_is_no_number_is_left_out() {
        let mut a = noisy(0.5, 0.1, 2, 6);
        let mut b = noisy(0.5, 0.1, 3, 7);
        a.iter_mut().for_each(|image| image.pixels[7] = [5000.0; 3]);
        b[1].pixels[9] = [f32::NAN; 3];
        let agreement = Agreement::of(&a, &b).expect("comparable");
        assert_eq!((agreement.masked, agreement.images), (2, (2, 3)));
        assert!((agreement.ratio - 1.0).abs() < 0.01);
    }

    #[test]
    fn what_tells_no_noise_is_refused() {
        let a = noisy(0.5, 0.1, 2, 8);
        assert_eq!(Agreement::of(&a, &a[..1]), Err(CompareError::Empty));
        assert_eq!(Agreement::of(&[], &a), Err(CompareError::Empty));
        let other = vec![Image::filled(8, 8, [1.0; 3]); 2];
        assert!(matches!(Agreement::of(&a, &other), Err(CompareError::Size { .. })));
        let black = vec![Image::filled(32, 32, [0.0; 3]); 2];
        assert_eq!(Agreement::of(&black, &a), Err(CompareError::Empty));
        // A reference of one image is taken to be exact.
        assert!(Agreement::of(&a[..1], &a).is_ok());
    }
}
