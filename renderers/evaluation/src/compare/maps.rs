//! The table of maps: a number for each pixel that says how two images differ there.

use rayon::prelude::*;

use super::flip::{self, Colors, Exposures};
use super::metrics::guards;
use super::{Pair, pair_exposure, ssim_map};
use ltsc_render::image::finite;

/// A number for each pixel.
pub struct Map {
    /// Name on pages.
    pub name: &'static str,
    /// What it says, in a few words.
    pub summary: &'static str,
    /// Its definition for a pixel, with the guard against division by zero: `A` and `B` are the pixel's values in a channel, `D` is
    /// `B - A`, and a mean is over channels. A map that has the name of a metric has its definition, so that its mean over pixels is that
    /// metric.
    pub formula: &'static str,
    /// The least and the largest value that it can have, perhaps infinite.
    pub range: (f32, f32),
    /// Its values row by row, not a number where a pixel is not finite in A or B; nothing where the definition gives none.
    pub measure: fn(&Pair) -> Option<Vec<f32>>,
}

/// All maps, in the order of pages.
///
/// Those called `-fixed` have guards in units of radiance, as pages of other programs show them: they mean something else in a scene that
/// is ten times brighter. The others are the same in any unit.
pub const MAPS: &[Map] = &[
    Map {
        name: "signed",
        summary: "difference, above 0 where B is brighter, in units of radiance",
        formula: "sqrt(sum(D^2)), negative where sum(D) is not above 0",
        range: (f32::NEG_INFINITY, f32::INFINITY),
        measure: |pair| each(pair, |a, b| signed(differences(a, b))),
    },
    Map {
        name: "absolute",
        summary: "size of the difference, in units of radiance",
        formula: "sqrt(sum(D^2))",
        range: (0.0, f32::INFINITY),
        measure: |pair| each(pair, |a, b| length(differences(a, b))),
    },
    Map {
        name: "relative",
        summary: "difference as a share of A, above 0 where B is brighter",
        formula: "sqrt(sum((D / |A|)^2)), negative where sum(D / |A|) is not above 0; |A| = 0 counts as 1",
        range: (f32::NEG_INFINITY, f32::INFINITY),
        measure: |pair| each(pair, |a, b| signed(share_of(a, differences(a, b)))),
    },
    Map {
        name: "squared",
        summary: "square error; the root of its mean over pixels is `rmse`",
        formula: "mean(D^2)",
        range: (0.0, f32::INFINITY),
        measure: |pair| each(pair, |a, b| mean(differences(a, b).map(|d| d * d))),
    },
    Map {
        name: "relative-squared",
        summary: "square error relative to A; its mean over pixels is `relative-mse`",
        formula: "mean(D^2 / (A^2 + e^2)), e = 1 % of the channel's mean |A| over the image; channels that are black in A do \
                  not count, and there is no value where all are",
        range: (0.0, f32::INFINITY),
        measure: |pair| guarded(pair, |a, b, guard| (b - a).powi(2) / (a * a + guard * guard)),
    },
    Map {
        name: "mape",
        summary: "absolute error relative to A",
        formula: "mean(|D| / (|A| + e)), e = 1 % of the channel's mean |A| over the image; channels that are black in A do \
                  not count, and there is no value where all are",
        range: (0.0, f32::INFINITY),
        measure: |pair| guarded(pair, |a, b, guard| (b - a).abs() / (a.abs() + guard)),
    },
    Map {
        name: "smape",
        summary: "absolute error relative to the mean of A and B, 0 to 2",
        formula: "mean(2 |D| / (|A| + |B|)), 0 where both are 0",
        range: (0.0, 2.0),
        measure: |pair| each(pair, |a, b| mean(term(a, b, |a, b| over(2.0 * (b - a).abs(), a.abs() + b.abs())))),
    },
    Map {
        name: "relative-squared-fixed",
        summary: "square error relative to A, with a guard in units of radiance",
        formula: "mean(D^2 / (A^2 + 0.0001))",
        range: (0.0, f32::INFINITY),
        measure: |pair| each(pair, |a, b| mean(term(a, b, |a, b| (b - a).powi(2) / (a * a + 1e-4)))),
    },
    Map {
        name: "mape-fixed",
        summary: "absolute error relative to A, with a guard in units of radiance",
        formula: "mean(|D| / (|A| + 0.01))",
        range: (0.0, f32::INFINITY),
        measure: |pair| each(pair, |a, b| mean(term(a, b, |a, b| (b - a).abs() / (a.abs() + 0.01)))),
    },
    Map {
        name: "smape-fixed",
        summary: "absolute error relative to the mean of A and B, with a guard in units of radiance, 0 to 2",
        formula: "mean(2 |D| / (|A| + |B| + 0.02))",
        range: (0.0, 2.0),
        measure: |pair| each(pair, |a, b| mean(term(a, b, |a, b| 2.0 * (b - a).abs() / (a.abs() + b.abs() + 0.02)))),
    },
    Map {
        name: "ssim",
        summary: "structural similarity as shown, 1 where equal",
        formula: "(2 a b + 1e-4) (2 cov + 9e-4) / ((a^2 + b^2 + 1e-4) (var_a + var_b + 9e-4)) over the 5 x 5 pixels around, of \
                  equal weight, cut at the border; a, b: mean luminance of both images as shown, in sRGB",
        range: (-1.0, 1.0),
        measure: |pair| Some(ssim_map(pair, pair_exposure(pair))),
    },
    Map {
        name: "flip",
        summary: "difference seen when flipping between the images as shown, 0 to 1",
        formula: "LDR-FLIP of both images as shown, Andersson et al. 2020, 67 pixels per degree",
        range: (0.0, 1.0),
        measure: |pair| Some(flip_map(pair, pair_exposure(pair))),
    },
    Map {
        name: "hdr-flip",
        summary: "largest difference seen at any exposure, 0 to 1",
        formula: "max(LDR-FLIP at exposure c, tone-mapped by ACES) over c, Andersson et al. 2021, 67 pixels per degree; \
                  exposures as of the metric of this name",
        range: (0.0, 1.0),
        measure: hdr_flip_map,
    },
];

/// FLIP (Andersson et al. 2020) at an exposure in stops, 0 to 1 in each pixel. A pixel that is not finite in one image looks to its
/// neighbors as it does in the other, black where it is finite in neither, and is itself not a number.
#[must_use]
pub fn flip_map(pair: &Pair, exposure: f64) -> Vec<f32> {
    let gain = exposure.exp2();
    let shown = |color: &[f32; 3]| color.map(|value| (f64::from(value) * gain).clamp(0.0, 1.0) as f32);
    let [a, b] = pair.colors().map(|image| image.par_iter().map(shown).collect::<Vec<_>>());
    pair.only_finite(flip::ldr(Colors { a: &a, b: &b, width: pair.a.width }))
}

/// HDR-FLIP (Andersson et al. 2021) at the exposures of [`flip_exposures`], 0 to 1 in each pixel; pixels that are not finite are treated
/// as by [`flip_map`], and negative radiance is black. Nothing where A is black and B is not: no exposure shows A.
#[must_use]
pub fn hdr_flip_map(pair: &Pair) -> Option<Vec<f32>> {
    let [a, b] = pair.colors();
    let colors = Colors { a: &a, b: &b, width: pair.a.width };
    let map = match flip_exposures(pair) {
        Some(exposures) => flip::hdr(colors, &exposures),
        None if b.iter().flatten().all(|value| *value <= 0.0) => vec![0.0; a.len()],
        None => return None,
    };
    Some(pair.only_finite(map))
}

/// The exposures of HDR-FLIP, from the pixels that are finite in A and B; nothing where A is black in them.
#[must_use]
pub fn flip_exposures(pair: &Pair) -> Option<Exposures> {
    let pixels = pair.a.pixels.iter().zip(&pair.b.pixels);
    Exposures::of(pixels.filter(|(a, b)| finite(a) && finite(b)).map(|(a, _)| *a))
}

/// The mean of the numbers of a map; nothing where it holds none.
#[must_use]
pub fn mean_of_map(map: &[f32]) -> Option<f64> {
    let numbers = map.iter().filter(|value| !value.is_nan());
    let (sum, count) = numbers.fold((0.0, 0_usize), |(sum, count), value| (sum + f64::from(*value), count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// A map whose values depend on their pixel alone.
fn each(pair: &Pair, of: impl Fn([f64; 3], [f64; 3]) -> f64 + Sync) -> Option<Vec<f32>> {
    let value = |(a, b): (&[f32; 3], &[f32; 3])| {
        if !finite(a) || !finite(b) {
            return f32::NAN;
        }
        // What single precision cannot hold is its largest number.
        let most = f64::from(f32::MAX);
        of(a.map(f64::from), b.map(f64::from)).clamp(-most, most) as f32
    };
    Some(pair.a.pixels.par_iter().zip(&pair.b.pixels).map(value).collect())
}

/// The mean of a term over the channels that are not black in A.
fn guarded(pair: &Pair, term: impl Fn(f64, f64, f64) -> f64 + Sync) -> Option<Vec<f32>> {
    let guards = guards(pair);
    let count = guards.iter().flatten().count();
    let sum = |a: [f64; 3], b: [f64; 3]| {
        (0..3).filter_map(|channel| Some(term(a[channel], b[channel], guards[channel]?))).sum::<f64>()
    };
    if count == 0 { None } else { each(pair, |a, b| sum(a, b) / count as f64) }
}

fn term(a: [f64; 3], b: [f64; 3], of: impl Fn(f64, f64) -> f64) -> [f64; 3] {
    std::array::from_fn(|channel| of(a[channel], b[channel]))
}

fn differences(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    term(a, b, |a, b| b - a)
}

fn share_of(a: [f64; 3], differences: [f64; 3]) -> [f64; 3] {
    term(a, differences, |a, difference| if a == 0.0 { difference } else { difference / a.abs() })
}

fn over(value: f64, divisor: f64) -> f64 {
    if divisor > 0.0 { value / divisor } else { 0.0 }
}

fn mean(values: [f64; 3]) -> f64 {
    values.iter().sum::<f64>() / 3.0
}

fn length(values: [f64; 3]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn signed(differences: [f64; 3]) -> f64 {
    let length = length(differences);
    if length == 0.0 || differences.iter().sum::<f64>() > 0.0 { length } else { -length }
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
