//! The error of a mean, and a mean with its error as a side of a verdict: the images themselves need not be there any more.

use serde::{Deserialize, Serialize};

use super::side::{Noise, Place, Side};
use super::{DARK, GRIDS, Rendered, Tolerance, Verdict, decided, mask};
use crate::compare::moments::Moments;
use crate::compare::{CompareError, Images};
use ltsc_render::image::Image;

/// How far the mean of several images is from what they tend to, as their scatter tells.
///
/// All errors are standard errors as shares of what they belong to: a tile's mean, or a pixel's, of red, green and blue together; where
/// that is darker than a tenth of the image's mean, of that tenth. Pixels brighter than 100 times the image's mean, those around them, and those that are not
/// finite, are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeanError {
    /// The median of the 8 by 8 tiles.
    pub tiles: f64,
    /// The largest of the tiles.
    pub worst: f64,
    /// Column and row of that tile from the upper left, beginning with 0.
    pub worst_at: (usize, usize),
    /// The median of the pixels.
    pub pixels: f64,
    /// Of the mean of the whole image.
    pub whole: f64,
    /// By how much the variance of tiles and of larger cells is larger than that of independent pixels, at least 1.
    pub correlation: (f64, f64),
    /// Whether whole images go up and down together.
    pub together: bool,
    /// Pixels that were left out.
    pub masked: usize,
}

/// The median of chi-square over its degrees of freedom (Wilson and Hilferty 1931; within 1 % from 3 on): a variance of few images is
/// smaller than the true one more often than larger.
fn median_of_variances(freedom: f64) -> f64 {
    (1.0 - 2.0 / (9.0 * freedom.max(1.0))).powi(3)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// The moments of images of one renderer, and the error of their mean.
///
/// # Errors
/// If there are fewer than 3, one cannot be read, sizes differ, or the image is black.
pub fn mean_error(images: Images<'_>) -> Result<(Moments, MeanError), CompareError> {
    if images.count() < 3 {
        return Err(CompareError::Few { images: images.count() });
    }
    let moments = images.moments()?;
    let mask = mask(&moments, &moments);
    let side = Side::of(&moments, images, &mask, 1.0)?;
    let unbias = median_of_variances(side.count - 1.0);
    let error = told(&side, &moments, &mask, side.noise(), &|cell| side.by_images(cell, 3), unbias)?;
    Ok((moments, error))
}

/// The error of a side; `of` is the variance of the mean of a cell, which is `unbias` times too small in the median.
fn told(
    side: &Side,
    moments: &Moments,
    mask: &[bool],
    noise: Noise,
    of: &dyn Fn(Place) -> f64,
    unbias: f64,
) -> Result<MeanError, CompareError> {
    let whole = Place { grid: 1, index: 0 };
    let mean_of = |place: Place| (0..3).map(|channel| side.estimate(place, channel, noise).mean).sum::<f64>() / 3.0;
    let masked = mask.iter().filter(|out| **out).count();
    if masked == mask.len() {
        return Err(CompareError::Empty);
    }
    let light = mean_of(whole);
    if light.is_nan() || light <= 0.0 {
        return Err(CompareError::Empty);
    }
    let share = |variance: f64, mean: f64| (variance / unbias).sqrt() / mean.max(DARK * light);
    let fine = GRIDS[0];
    let cells = (0..fine * fine).map(|index| Place { grid: fine, index }).filter(|cell| side.size(*cell) > 0.0);
    let tiles: Vec<(f64, usize)> = cells.map(|cell| (share(of(cell), mean_of(cell)), cell.index)).collect();
    let worst = tiles.iter().copied().max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or_default();
    let mut all: Vec<f64> = tiles.iter().map(|(error, _)| *error).collect();
    let grey = |at: usize| moments.mean(at).iter().sum::<f64>() / 3.0;
    let pixel = |at: usize| share(moments.variance(at)[3] / side.count, grey(at));
    let mut pixels: Vec<f64> = (0..mask.len()).filter(|at| !mask[*at]).map(pixel).collect();
    // Where the images are gone, what they share is in no pixel's variance: cells get it as if it were correlation.
    let shared = if noise.together { of(whole) / side.by_pixels(whole, 3) } else { 1.0 };
    Ok(MeanError {
        tiles: median(&mut all),
        worst: worst.0,
        worst_at: (worst.1 % fine, worst.1 / fine),
        pixels: median(&mut pixels),
        whole: of(whole).sqrt() / light,
        correlation: (noise.tiles, noise.cells.max(shared)),
        together: noise.together,
        masked,
    })
}

/// The error of a mean of which the variance in each pixel is all that is known: pixels are taken to be independent of each other, and
/// channels to vary together, which is the worst that they can do.
///
/// # Errors
/// If sizes differ, or the image is black.
pub fn error_of(mean: &Image, variance: &Image, images: usize) -> Result<MeanError, CompareError> {
    let moments = Moments::of_mean(mean, variance, images.max(2))?;
    let mask = mask(&moments, &moments);
    let none = Noise { tiles: 1.0, cells: 1.0, together: false };
    let side = Side::of_moments(&moments, &mask, 1.0, none);
    told(&side, &moments, &mask, none, &|cell| side.by_pixels(cell, 3), 1.0)
}

/// A mean that is kept, as a side of a verdict.
#[derive(Clone, Copy)]
pub struct Kept<'i> {
    /// The mean.
    pub mean: &'i Image,
    /// The variance of that mean; without it, it is taken to be free of noise.
    pub variance: Option<&'i Image>,
    /// Of how many images it is.
    pub images: usize,
    /// Samples per pixel of each.
    pub samples: f64,
    /// How their errors hang together: [`MeanError::correlation`].
    pub correlation: (f64, f64),
}

/// Judges images of B against a mean that is kept of A, as [`super::judge`] does. Of A's rarest events nothing is known but what B has
/// met. `fine` are the tiles along each side, one of [`GRIDS`].
///
/// # Errors
/// As of [`super::judge`].
pub fn judge_kept(a: Kept<'_>, b: Rendered<'_>, tolerance: Tolerance, fine: usize) -> Result<Verdict, CompareError> {
    let Some(variance) = a.variance.filter(|_| a.images > 1) else {
        let images = Images::Held(std::slice::from_ref(a.mean));
        return super::judge_in(Rendered { images, samples: a.samples }, b, tolerance, fine);
    };
    if b.images.count() < 3 {
        return Err(CompareError::Few { images: b.images.count() });
    }
    let of_a = Moments::of_mean(a.mean, variance, a.images)?;
    let of_b = b.images.moments()?;
    if (of_a.width, of_a.height) != (of_b.width, of_b.height) {
        return Err(CompareError::Size { a: (of_a.width, of_a.height), b: (of_b.width, of_b.height) });
    }
    let mask = mask(&of_a, &of_b);
    let masked = mask.iter().filter(|out| **out).count();
    if masked == mask.len() {
        return Err(CompareError::Empty);
    }
    let (tiles, cells) = a.correlation;
    let noise = Noise { tiles: tiles.max(1.0), cells: cells.max(tiles).max(1.0), together: false };
    let kept = Side::of_moments(&of_a, &mask, a.samples, noise);
    let sides = [kept, Side::of(&of_b, b.images, &mask, b.samples)?];
    decided(&sides, (tolerance, fine), (a.images, b.images.count()), masked)
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::super::tests::{even, noisy};
    use super::*;

    #[test]
    fn the_error_of_a_mean_is_that_of_its_noise() {
        // Uniform noise of width 0.5 has a deviation of 0.5 / sqrt(12); a tile has 16 pixels.
        for count in [4, 8, 32] {
            let images = even(count, 0.5, 11);
            let (_, error) = mean_error(Images::Held(&images)).expect("images");
            let pixel = 0.5 / 12_f64.sqrt() / (count as f64).sqrt();
            // The median of 64 estimates of count - 1 degrees of freedom, and that of 1024.
            let within = 4.0 * 1.25 / (2.0 * (count as f64 - 1.0)).sqrt() / 8.0;
            assert!((error.tiles / (pixel / 4.0) - 1.0).abs() < within, "{count}: {error:?}, {pixel}");
            assert!((error.pixels / pixel - 1.0).abs() < within.max(0.03), "{count}: {error:?}, {pixel}");
            assert!(error.worst > error.tiles && error.whole < error.tiles, "{error:?}");
        }
    }

    #[test]
    fn dark_tiles_and_glare_do_not_lead_the_error() {
        // A black half with noise of its own: its error is told as a share of a tenth of the image's mean.
        let mut images = noisy(16, 0.4, 3, |at, _| if at % 32 < 16 { 1.0 } else { 1e-4 });
        let (_, error) = mean_error(Images::Held(&images)).expect("images");
        assert!(error.worst < 0.05 && error.masked == 0, "{error:?}");
        for (at, image) in images.iter_mut().enumerate() {
            image.pixels[40] = [1e4 * (1.0 + at as f32); 3];
        }
        let (_, with_glare) = mean_error(Images::Held(&images)).expect("images");
        assert_eq!(with_glare.masked, 9, "with the pixels around it");
        assert!((with_glare.tiles / error.tiles - 1.0).abs() < 0.1, "{with_glare:?} for {error:?}");
        let black = vec![Image::filled(8, 8, [0.0; 3]); 4];
        assert!(matches!(mean_error(Images::Held(&black)), Err(CompareError::Empty)));
        assert!(matches!(mean_error(Images::Held(&black[..2])), Err(CompareError::Few { images: 2 })));
    }

    #[test]
    fn a_kept_mean_is_judged_as_its_images_are() {
        let tolerance = Tolerance { tiles: 0.1, whole: 0.1 };
        for (seed, level, outcome) in
            [(1, 1.0, Outcome::Agree), (2, 1.2, Outcome::Differ), (3, 1.07, Outcome::Undecided)]
        {
            let (a, b) = (even(16, 0.3, seed), noisy(8, 0.3, seed + 70, |at, _| if at % 32 < 8 { level } else { 1.0 }));
            let side = |images| Rendered { images: Images::Held(images), samples: 16.0 };
            let known = super::super::judge(side(&a), side(&b), tolerance).expect("a verdict");
            let (moments, error) = mean_error(Images::Held(&a)).expect("images");
            let (mean, variance) = (moments.mean_image(), moments.variance_image());
            let kept = Kept {
                mean: &mean,
                variance: Some(&variance),
                images: a.len(),
                samples: 16.0,
                correlation: error.correlation,
            };
            let found = judge_kept(kept, side(&b), tolerance, 8).expect("a verdict");
            assert_eq!((found.outcome, known.outcome), (outcome, outcome), "{level}");
            for channel in 0..3 {
                let (one, other) = (found.channels[channel], known.channels[channel]);
                assert!((one.ratio.unwrap_or(0.0) - other.ratio.unwrap_or(0.0)).abs() < 1e-6);
                assert!((one.error / other.error - 1.0).abs() < 0.02, "{one:?} for {other:?}");
            }
            // An image without its error decides more easily than it should: it is what nothing better is known of.
            let exact = judge_kept(Kept { variance: None, ..kept }, side(&b), tolerance, 8).expect("a verdict");
            assert!(exact.channels[0].error < found.channels[0].error);
        }
    }

    fn near(found: f64, wanted: f64) {
        assert!((found - wanted).abs() <= 1e-5 * wanted.abs() + 1e-12, "{found} instead of {wanted}");
    }

    /// 8 by 8 pixels, one for each tile, whose values and variances are known.
    #[test]
    fn the_error_of_a_known_variance_is_that_by_hand() {
        let mut mean = Image::filled(8, 8, [1.0, 2.0, 3.0]);
        // Channels vary together: their deviations 0.1, 0.2, 0.3 make one of 0.2, and with a mean of 2 a share of 0.1.
        let mut variance = Image::filled(8, 8, [0.01, 0.04, 0.09]);
        let found = error_of(&mean, &variance, 4).expect("an error");
        near(found.tiles, 0.1);
        near(found.worst, 0.1);
        near(found.pixels, 0.1);
        near(found.whole, 0.1 / 8.0);
        assert_eq!((found.correlation, found.together, found.masked), ((1.0, 1.0), false, 0));
        // One pixel of a deviation of 0.6 is the worst, and the whole has a variance of 63 * 0.04 + 0.36.
        variance.pixels[3 * 8 + 5] = [0.36; 3];
        let found = error_of(&mean, &variance, 4).expect("an error");
        near(found.worst, 0.3);
        near(found.tiles, 0.1);
        near(found.whole, 2.88_f64.sqrt() / 64.0 / 2.0);
        assert_eq!(found.worst_at, (5, 3));
        // A pixel as dark as that is told as a share of a tenth of the image's mean, which it lowers.
        mean.pixels[3 * 8 + 5] = [0.01; 3];
        let found = error_of(&mean, &variance, 4).expect("an error");
        near(found.worst, 0.6 / (0.1 * (63.0 * 2.0 + 0.01) / 64.0));
        // What is not finite is left out, and the worst of the others is one of many.
        mean.pixels[3 * 8 + 5] = [f32::NAN; 3];
        let found = error_of(&mean, &variance, 4).expect("an error");
        near(found.worst, 0.1);
        near(found.whole, 0.1 / 63.0_f64.sqrt());
        assert_eq!(found.masked, 1);
        // Fewer pixels than tiles: those without any do not count.
        let (mean, few) = (Image::filled(4, 2, [2.0; 3]), Image::filled(4, 2, [0.04; 3]));
        let found = error_of(&mean, &few, 4).expect("an error");
        near(found.tiles, 0.1);
        near(found.worst, 0.1);
        let refused = |value: f32| error_of(&Image::filled(8, 8, [value; 3]), &variance, 4).expect_err("refused");
        assert!([f32::NAN, 0.0, -1.0].into_iter().all(|value| refused(value) == CompareError::Empty));
        assert!(matches!(error_of(&Image::filled(4, 8, [1.0; 3]), &variance, 4), Err(CompareError::Size { .. })));
    }

    /// Four images of 10, each pixel one more or less in turn, and the whole one more or less beside that: a pixel's mean has a variance of
    /// (4 + 4) / 3 / 4, the whole of 4 / 3 / 4, and independent pixels of 2 / 3 / 64.
    #[test]
    fn the_error_of_images_that_swing_is_that_by_hand() {
        let pixel = |image: usize, at: usize| {
            let sign = if (image + at).is_multiple_of(2) { 1.0 } else { -1.0 };
            [10.0 + sign + if image < 2 { 1.0 } else { -1.0 }; 3]
        };
        let of = |image: usize| Image { width: 8, height: 8, pixels: (0..64).map(|at| pixel(image, at)).collect() };
        let images: Vec<Image> = (0..4).map(of).collect();
        let (moments, found) = mean_error(Images::Held(&images)).expect("images");
        assert!(mean_error(Images::Held(&images[..3])).is_ok(), "three are enough");
        // A variance of three degrees is below the true one by (1 - 2 / 27)^3 in the median.
        let median = (25.0_f64 / 27.0).powi(3);
        near(found.tiles, (2.0 / 3.0 / median).sqrt() / 10.0);
        near(found.worst, (2.0 / 3.0 / median).sqrt() / 10.0);
        near(found.pixels, (2.0 / 3.0 / median).sqrt() / 10.0);
        near(found.whole, (1.0_f64 / 3.0).sqrt() / 10.0);
        // Kept, the swing is told as correlation of the whole: (1 / 3) / (2 / 3 / 64).
        assert!(found.together);
        near(found.correlation.0, 1.0);
        near(found.correlation.1, 32.0);
        let (mean, variance) = (moments.mean_image(), moments.variance_image());
        let flat = vec![Image::filled(8, 8, [10.0; 3]); 3];
        let kept =
            Kept { mean: &mean, variance: Some(&variance), images: 4, samples: 1.0, correlation: found.correlation };
        let side = Rendered { images: Images::Held(&flat), samples: 1.0 };
        let verdict = judge_kept(kept, side, Tolerance::default(), 8).expect("a verdict");
        near(verdict.channels[0].error, (1.0_f64 / 3.0).sqrt() / 10.0);
        // Factors below 1 are none, and larger cells have no smaller one than tiles.
        let error = |correlation: (f64, f64)| {
            judge_kept(Kept { correlation, ..kept }, side, Tolerance::default(), 8).expect("a verdict").channels[0]
                .error
        };
        let plain = (2.0_f64 / 3.0 / 64.0).sqrt() / 10.0;
        near(error((0.1, 0.1)), plain);
        near(error((4.0, 1.0)), 2.0 * plain);
        near(error((0.1, 9.0)), 3.0 * plain);
        // One image has no noise, whatever is said of it.
        let one = judge_kept(Kept { images: 1, ..kept }, side, Tolerance::default(), 8).expect("a verdict");
        assert_eq!((one.channels[0].error, one.images), (0.0, (1, 3)));
        assert_eq!((verdict.images, verdict.masked), ((4, 3), 0));
    }

    #[test]
    fn a_kept_mean_that_tells_nothing_is_refused() {
        let (mean, variance) = (Image::filled(8, 8, [1.0; 3]), Image::filled(8, 8, [0.01; 3]));
        let kept = Kept { mean: &mean, variance: Some(&variance), images: 4, samples: 1.0, correlation: (1.0, 1.0) };
        let of = |kept: Kept<'_>, images: &[Image]| {
            let side = Rendered { images: Images::Held(images), samples: 1.0 };
            judge_kept(kept, side, Tolerance::default(), 8)
        };
        let other = |width: usize, height: usize| vec![Image::filled(width, height, [1.0; 3]); 3];
        assert!(of(kept, &other(8, 8)).is_ok());
        assert_eq!(of(kept, &other(8, 8)[..2]), Err(CompareError::Few { images: 2 }));
        for (width, height) in [(4, 8), (8, 4)] {
            assert_eq!(of(kept, &other(width, height)), Err(CompareError::Size { a: (8, 8), b: (width, height) }));
        }
        let nothing = Image::filled(8, 8, [f32::NAN; 3]);
        assert_eq!(of(Kept { mean: &nothing, ..kept }, &other(8, 8)), Err(CompareError::Empty));
        let mut some = mean.clone();
        some.pixels[9] = [f32::NAN; 3];
        assert_eq!(of(Kept { mean: &some, ..kept }, &other(8, 8)).expect("a verdict").masked, 1);
    }

    #[test]
    fn medians_are_those_of_lists() {
        assert_eq!((median(&mut [3.0, 1.0, 2.0]), median(&mut [4.0, 1.0, 3.0, 2.0])), (2.0, 3.0));
        assert_eq!(median(&mut []), f64::INFINITY);
        // Medians of chi-square over its degrees of freedom from tables, and of one and less the formula's own.
        for (freedom, known) in [(3.0, 0.7887), (7.0, 0.9065), (30.0, 0.9779)] {
            assert!((median_of_variances(freedom) / known - 1.0).abs() < 0.01, "{freedom}");
        }
        near(median_of_variances(0.0), (7.0_f64 / 9.0).powi(3));
    }
}
