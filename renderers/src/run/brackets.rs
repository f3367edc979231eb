//! One image of full range from several of 8 bits: exposures that differ by their scale only.
//!
//! A renderer that repeats its image bit by bit gives, at each scale, the code of one and the same radiance: each code
//! bounds it from below and from above. The bounds of all exposures together are what is known of a channel of a pixel,
//! and their middle is taken. Two exposures whose bounds exclude each other show that the renderer does not repeat
//! itself, which is refused.

use crate::image::Image;

/// Between neighbouring exposures. A channel that is just clamped in one has code 99 in the next, where half a step is
/// 1.06 % of it.
const STEP: f64 = 8.0;
/// The most exposures before the range is covered: 8^9 is a range of 10^8.
const MOST: usize = 10;
/// The most exposures from a neighbour to the next where an image that costs little is refined. Over values from 0.1 to 30
/// the largest error is 1.05 % with 1, 0.69 % with 2, 0.54 % with 4, 0.43 % with 8, and its root mean square 0.68, 0.41,
/// 0.26, 0.15 % (computed).
const FINEST: usize = 4;
/// Camera samples, over all exposures, up to which an image counts as one that costs little: rs_pbrt needs 3 s for them.
const CHEAP: u64 = 1 << 20;
/// How well a channel should be known, as a share of it, and below which share of the image's mean it need not be known.
const GOAL: (f64, f64) = (0.015, 0.01);
/// The brightest exposure: what is still black in it, below 10^-11, is taken for black.
const BRIGHTEST: f64 = 16_777_216.0;
/// The rounding of the renderer's arithmetic in single precision, which may move a value across the edge of a code.
const ROUNDING: f64 = 1e-6;

/// Exposures up to now.
pub(super) struct Brackets {
    size: (usize, usize),
    /// Samples of one exposure.
    cost: u64,
    /// Scales that have been taken in.
    scales: Vec<f32>,
    /// Scales that are to come.
    planned: Vec<f32>,
    /// What is known of each channel.
    low: Vec<f64>,
    high: Vec<f64>,
    refined: bool,
}

impl Brackets {
    /// Of images of this size, with so many samples per pixel.
    pub(super) fn new(width: usize, height: usize, samples: u32) -> Self {
        let channels = width * height * 3;
        Self {
            size: (width, height),
            cost: (width as u64 * height as u64).saturating_mul(u64::from(samples)).max(1),
            scales: Vec::new(),
            planned: vec![1.0],
            low: vec![0.0; channels],
            high: vec![f64::INFINITY; channels],
            refined: false,
        }
    }

    /// The scale of the exposure to take now; nothing when enough is known.
    pub(super) fn wanted(&self) -> Option<f32> {
        self.planned.last().copied()
    }

    /// How many exposures there will be, as far as is known.
    pub(super) fn expected(&self) -> usize {
        // One to know the range, and two more for what most scenes need.
        (self.scales.len() + self.planned.len()).max(3)
    }

    /// Takes the codes of the wanted exposure in.
    pub(super) fn add(&mut self, codes: &[u8]) -> Result<(), String> {
        let Some(scale) = self.planned.pop() else { return Ok(()) };
        if codes.len() != self.low.len() {
            return Err("gave exposures of different sizes".to_owned());
        }
        let mut strangers = 0_usize;
        for ((low, high), code) in self.low.iter_mut().zip(&mut self.high).zip(codes) {
            let (least, most) = bounds(*code);
            *low = low.max(least / f64::from(scale) * (1.0 - ROUNDING));
            *high = high.min(most / f64::from(scale) * (1.0 + ROUNDING));
            strangers += usize::from(*low > *high);
        }
        if strangers > 0 {
            return Err(format!(
                "does not repeat itself: {strangers} values of an exposure contradict the exposures before it, so that \
                 they cannot be put together"
            ));
        }
        self.scales.push(scale);
        if self.planned.is_empty() {
            self.plan();
        }
        Ok(())
    }

    /// Decides what is wanted next.
    fn plan(&mut self) {
        if self.refined {
            return;
        }
        if self.scales.len() < MOST {
            let least = self.scales.iter().copied().fold(f32::INFINITY, f32::min);
            if self.high.contains(&f64::INFINITY) {
                return self.planned.push(least / STEP as f32);
            }
            if let Some(scale) = self.brighter() {
                return self.planned.push(scale);
            }
        }
        self.refine();
    }

    /// The scale at which the brightest channel that is not known well is as bright as it can be without being clamped.
    fn brighter(&self) -> Option<f32> {
        let floor = GOAL.1 * self.mean();
        let vague = |low: f64, high: f64| high - low > 2.0 * GOAL.0 * f64::max(f64::midpoint(low, high), floor);
        let brightest = self
            .low
            .iter()
            .zip(&self.high)
            .filter(|(low, high)| vague(**low, **high))
            .map(|(_, high)| *high)
            .fold(0.0, f64::max);
        let power = (brightest.recip().ln() / STEP.ln()).floor();
        let scale = STEP.powf(power) as f32;
        let most = self.scales.iter().copied().fold(0.0, f32::max);
        (brightest > 0.0 && f64::from(scale) <= BRIGHTEST && scale > most).then_some(scale)
    }

    /// Adds exposures between the others if they cost little: an image without noise is known no better than its codes.
    fn refine(&mut self) {
        self.refined = true;
        if self.high.contains(&f64::INFINITY) || self.mean() == 0.0 {
            return;
        }
        let least = self.scales.iter().copied().fold(f32::INFINITY, f32::min);
        // One more, which knows dark channels as well as bright ones.
        let most = self.scales.iter().copied().fold(0.0, f32::max) * STEP as f32;
        let steps = (f64::from(most / least).ln() / STEP.ln()).round().max(1.0) as usize;
        let affordable = usize::try_from(CHEAP / self.cost).unwrap_or(usize::MAX).saturating_sub(self.scales.len());
        let between = (affordable / steps).min(FINEST - 1);
        if between == 0 {
            return;
        }
        for step in (0..=steps * (between + 1)).rev() {
            let scale = (f64::from(least) * STEP.powf(step as f64 / (between + 1) as f64)) as f32;
            if !self.scales.contains(&scale) {
                self.planned.push(scale);
            }
        }
    }

    /// Over all channels that are not clamped.
    fn mean(&self) -> f64 {
        let finite = self.low.iter().zip(&self.high).filter(|(_, high)| high.is_finite());
        let (sum, count) =
            finite.fold((0.0, 0.0), |(sum, count), (low, high)| (sum + middle(*low, *high), count + 1.0));
        sum / f64::max(count, 1.0)
    }

    /// The largest error of a channel of the image, as a share of it or of a hundredth of the mean, whichever is larger.
    pub(super) fn error(&self) -> f64 {
        let floor = GOAL.1 * self.mean();
        let known = self.low.iter().zip(&self.high).filter(|(_, high)| high.is_finite());
        known
            .map(|(low, high)| {
                let value = middle(*low, *high);
                (high - value).max(value - low) / value.max(floor)
            })
            .filter(|error| error.is_finite())
            .fold(0.0, f64::max)
    }

    /// Scales that were taken, in order.
    pub(super) fn scales(&self) -> &[f32] {
        &self.scales
    }

    /// The image. What was clamped in every exposure is infinite, and what had code 0 in every one is 0.
    pub(super) fn image(&self) -> Image {
        let value = |index: usize| middle(self.low[index], self.high[index]) as f32;
        let (width, height) = self.size;
        let pixels = (0..width * height).map(|pixel| [0, 1, 2].map(|channel| value(3 * pixel + channel))).collect();
        Image { width, height, pixels }
    }
}

fn middle(low: f64, high: f64) -> f64 {
    // Black stays black.
    if low > 0.0 { f64::midpoint(low, high) } else { 0.0 }
}

/// The least and the largest value with this code: PBRT rounds 255 times the sRGB curve of the value to the nearest
/// number, and clamps it (`WriteImage` in `imageio.cpp`, `Film::write_image` in rs_pbrt's `film.rs`).
fn bounds(code: u8) -> (f64, f64) {
    let at = |code: f64| decode(code / 255.0);
    let least = if code == 0 { 0.0 } else { at(f64::from(code) - 0.5) };
    let most = if code == 255 { f64::INFINITY } else { at(f64::from(code) + 0.5) };
    (least, most)
}

/// The inverse of PBRT's `GammaCorrect`: 12.92 x up to 0.0031308, 1.055 x^(1/2.4) - 0.055 above.
fn decode(x: f64) -> f64 {
    if x <= 12.92 * 0.003_130_8 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// Writes `<scale>.png` for every scale that may be asked for: 8^(k / n).
    pub(crate) fn write_exposures(folder: &Path, image: &Image) {
        fs::create_dir_all(folder).expect("a folder");
        let (width, height) = (image.width as u32, image.height as u32);
        for between in 1..=FINEST {
            for step in -3 * FINEST as i32..=5 * FINEST as i32 {
                let scale = STEP.powf(f64::from(step) / between as f64) as f32;
                let codes: Vec<u8> = image.pixels.iter().flatten().map(|value| encode(value * scale)).collect();
                let path = folder.join(format!("{scale}.png"));
                image::save_buffer(path, &codes, width, height, image::ColorType::Rgb8).expect("a PNG");
            }
        }
    }

    /// What the renderer writes for a value, in its single precision.
    fn encode(value: f32) -> u8 {
        let curved = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (255.0 * curved + 0.5).clamp(0.0, 255.0) as u8
    }

    fn expose(values: &[f32], samples: u32) -> Brackets {
        let mut brackets = Brackets::new(values.len() / 3, 1, samples);
        while let Some(scale) = brackets.wanted() {
            let codes: Vec<u8> = values.iter().map(|value| encode(value * scale)).collect();
            brackets.add(&codes).expect("exposures of one image");
        }
        brackets
    }

    fn found(brackets: &Brackets) -> Vec<f32> {
        brackets.image().pixels.into_iter().flatten().collect()
    }

    #[test]
    fn every_code_bounds_what_it_stands_for() {
        for step in 0..20_000 {
            let value = step as f32 / 19_000.0;
            let (least, most) = bounds(encode(value));
            let value = f64::from(value);
            assert!(least * (1.0 - ROUNDING) <= value && value <= most * (1.0 + ROUNDING), "{value}");
        }
    }

    #[test]
    fn a_wide_range_is_recovered_within_the_error_that_is_told() {
        // Lights, walls, shadows, with every digit of the codes.
        let values: Vec<f32> = (0..3000).map(|i| 1e-4 * 1.006_f32.powi(i)).collect();
        let (brightest, darkest) = (values[2999], values[0]);
        assert!(brightest / darkest > 1e7);
        let brackets = expose(&values, 10_000);
        assert!(brackets.scales().len() <= MOST, "{:?}", brackets.scales());
        let error = brackets.error();
        assert!(error <= GOAL.0, "{error}");
        let floor = (GOAL.1 * brackets.mean()) as f32;
        for (found, value) in found(&brackets).into_iter().zip(&values) {
            let off = f64::from((found - value).abs() / value.max(floor));
            assert!(off <= error + 1e-5, "{found} instead of {value}");
        }
    }

    #[test]
    fn small_images_are_refined() {
        let values: Vec<f32> = (0..300).map(|i| 0.01 * 1.03_f32.powi(i)).collect();
        let coarse = expose(&values, 1_000_000);
        let fine = expose(&values, 16);
        assert!(fine.error() < 0.6 * coarse.error(), "{} {}", fine.error(), coarse.error());
        for (found, value) in found(&fine).into_iter().zip(&values).filter(|(_, value)| **value > 0.1) {
            assert!((found / value - 1.0).abs() < 0.0055, "{found} instead of {value}");
        }
    }

    #[test]
    fn the_mean_is_not_moved() {
        let values: Vec<f32> = (0..30_000).map(|i| 0.05 + 0.9 * (i as f32 * 0.618_034).fract()).collect();
        let brackets = expose(&values, 1_000_000);
        let mean = |values: &[f32]| values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64;
        let ratio = mean(&found(&brackets)) / mean(&values);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }

    #[test]
    fn black_and_infinite_images_come_to_an_end() {
        let black = expose(&[0.0; 12], 1_000_000);
        assert_eq!(found(&black), [0.0; 12]);
        assert!(black.scales().len() <= 3, "{:?}", black.scales());
        let bright = expose(&[f32::INFINITY, 1.0, 0.0], 1_000_000);
        assert_eq!(found(&bright)[0], f32::INFINITY);
        assert_eq!(found(&bright)[2], 0.0);
        assert_eq!(bright.scales().len(), MOST);
        // The black channel is known within 1.5e-4, and the mean of the two is 0.5.
        assert!((0.02..0.04).contains(&bright.error()), "{}", bright.error());
        // A single dark value, and a single bright one.
        for value in [1e-5, 3e4] {
            let brackets = expose(&[value, value, value], 1_000_000);
            assert!((found(&brackets)[0] / value - 1.0).abs() < 0.015, "{value}: {:?}", found(&brackets));
        }
    }

    #[test]
    fn exposures_that_contradict_each_other_are_refused() {
        let mut brackets = Brackets::new(1, 1, 1);
        brackets.add(&[255, 10, 0]).expect("the first");
        assert_eq!(brackets.wanted(), Some(0.125));
        let error = brackets.add(&[200, 10, 0]).expect_err("10 again at an eighth of the light");
        assert!(error.contains("does not repeat itself: 1 values"), "{error}");
        assert!(Brackets::new(1, 1, 1).add(&[0; 6]).is_err());
    }
}
