//! Two images of equal size, as metrics see them.

use serde::{Deserialize, Serialize};

use super::CompareError;
use ltsc_render::image::{Image, finite};

/// A value over all channels and in each. Nothing stands where the definition divides by zero, or knows no channels.
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

    /// The colors of both images, with numbers everywhere: a pixel that is not finite in one image has the color of the other, so that no
    /// difference is seen there, and is black where it is finite in neither.
    pub(super) fn colors(&self) -> [Vec<[f32; 3]>; 2] {
        [(self.a, self.b), (self.b, self.a)].map(|(own, other)| {
            let color = |(own, other): (&[f32; 3], &[f32; 3])| match (finite(own), finite(other)) {
                (true, _) => *own,
                (false, true) => *other,
                (false, false) => [0.0; 3],
            };
            own.pixels.iter().zip(&other.pixels).map(color).collect()
        })
    }

    /// A map of numbers without those of pixels that are not finite in A or B.
    pub(super) fn only_finite(&self, mut map: Vec<f32>) -> Vec<f32> {
        for ((value, a), b) in map.iter_mut().zip(&self.a.pixels).zip(&self.b.pixels) {
            if !finite(a) || !finite(b) {
                *value = f32::NAN;
            }
        }
        map
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

    /// A value that has no channels.
    pub(super) fn whole(overall: Option<f64>) -> Self {
        Self { overall, ..Self::NONE }
    }

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
