//! Two images of equal size, as metrics see them.

use serde::{Deserialize, Serialize};

use super::CompareError;
use ltsc_render::image::{Image, finite};

/// A value over all channels and in each. Nothing stands where the definition divides by zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// Over all three channels.
    pub overall: Option<f64>,
    /// In R, G and B.
    pub channels: [Option<f64>; 3],
}

/// A reference and an image of the same size.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// The reference.
    pub a: &'a Image,
    /// The image that is judged.
    pub b: &'a Image,
}

impl<'a> Pair<'a> {
    /// Joins two images.
    ///
    /// # Errors
    /// Refuses different sizes and images without pixels.
    pub fn new(a: &'a Image, b: &'a Image) -> Result<Self, CompareError> {
        if (a.width, a.height) != (b.width, b.height) {
            return Err(CompareError::Size { a: (a.width, a.height), b: (b.width, b.height) });
        }
        if a.pixels.is_empty() || b.pixels.is_empty() {
            return Err(CompareError::Empty);
        }
        Ok(Self { a, b })
    }

    /// All pixels that are finite in both images.
    pub fn pixels(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3])> + use<'a> {
        self.a
            .pixels
            .iter()
            .zip(&self.b.pixels)
            .filter(|(a, b)| finite(a) && finite(b))
            .map(|(a, b)| (a.map(f64::from), b.map(f64::from)))
    }

    /// The mean of `term(a, b, channel)` over all finite pixels, in each channel; nothing without
    /// pixels.
    pub fn mean(&self, term: impl Fn(f64, f64, usize) -> f64) -> Option<[f64; 3]> {
        let mut sums = [0.0; 3];
        let mut count = 0_usize;
        for (a, b) in self.pixels() {
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum += term(a[channel], b[channel], channel);
            }
            count += 1;
        }
        (count > 0).then(|| sums.map(|sum| sum / count as f64))
    }
}

impl Value {
    /// Nothing anywhere.
    pub(super) const NONE: Self = Self { overall: None, channels: [None; 3] };

    /// Three means, and their mean.
    pub(super) fn of_means(means: Option<[f64; 3]>) -> Self {
        means.map_or(Self::NONE, |means| Self {
            overall: Some(means.iter().sum::<f64>() / 3.0),
            channels: means.map(Some),
        })
    }

    /// Ratios of two triples, and that of their sums.
    pub(super) fn of_ratio(a: [f64; 3], b: [f64; 3]) -> Self {
        let ratio = |a: f64, b: f64| (a != 0.0).then(|| b / a).filter(|ratio| ratio.is_finite());
        Self {
            overall: ratio(a.iter().sum(), b.iter().sum()),
            channels: std::array::from_fn(|channel| ratio(a[channel], b[channel])),
        }
    }
}
