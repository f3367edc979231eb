//! What needs the pixels of two images: ratios of tiles with their intervals, and metrics of images that no evaluation has compared.

use ltsc_render::image::{Image, finite};

use super::model::{Pair, Tiles};
use crate::compare::verdict::{GRIDS, Verdict};
use crate::compare::{CompareOptions, compare};

/// The deviate of an interval of 95 %, both sides.
const NINETY_FIVE: f64 = 1.959_964;

/// Metrics of light, and all but the slowest one of those of what is seen.
const LIGHT: &[&str] = &["mean-a", "mean-b", "ratio", "rmse", "relative-mse", "mape", "smape", "max-difference"];
const SEEN: &[&str] =
    &["mean-a", "mean-b", "ratio", "rmse", "relative-mse", "mape", "smape", "max-difference", "psnr", "ssim", "flip"];

/// The most pixels of which metrics of what is seen are measured: the viewer shows their maps at any size.
const QUICK: usize = 1 << 20;

/// An image with the variance of each pixel, where that is known.
pub(super) struct Side<'s> {
    pub image: &'s Image,
    pub variance: Option<&'s Image>,
}

/// The grid of a verdict, without its numbers.
pub(super) fn judged(verdict: &Verdict) -> Tiles {
    let side = verdict.side();
    Tiles {
        columns: side,
        rows: side,
        words: verdict.tiles.iter().map(|outcome| outcome.word()).collect(),
        tolerance: Some(verdict.tolerance.tiles),
        ..Tiles::default()
    }
}

/// Fills in what the pixels say: ratios of tiles, and metrics where there are none.
pub(super) fn measure(pair: &mut Pair, a: &Side, b: &Side, open: bool) {
    if (a.image.width, a.image.height) != (b.image.width, b.image.height) {
        let size = |image: &Image| format!("{} x {}", image.width, image.height);
        pair.refused.get_or_insert(format!("the images differ in size: {} and {}", size(a.image), size(b.image)));
        return;
    }
    if open {
        let only = if a.image.pixels.len() > QUICK { LIGHT } else { SEEN };
        let options = CompareOptions { mask_non_finite: true, only, ..CompareOptions::default() };
        match compare(a.image, b.image, &options) {
            Ok(found) => {
                pair.metrics = found.metrics.into_iter().map(|one| (one.name, one.value.overall)).collect();
                if let Some(shift) = found.shift.filter(|shift| (shift.dx, shift.dy) != (0, 0)) {
                    pair.notes.push(format!("B lies {}, {} pixels off A", shift.dx, shift.dy));
                }
            }
            Err(error) => {
                pair.refused = Some(error.to_string());
                return;
            }
        }
        pair.refused
            .get_or_insert("no evaluation has judged these images: there are metrics, and no verdict".to_owned());
    }
    let tiles = pair.tiles.get_or_insert_with(|| {
        let fit = |size: usize| GRIDS[0].min(size);
        Tiles { columns: fit(a.image.width), rows: fit(a.image.height), ..Tiles::default() }
    });
    let (columns, rows) = (tiles.columns.max(1), tiles.rows.max(1));
    for row in 0..rows {
        for column in 0..columns {
            let part = |at: usize, of: usize, size: usize| at * size / of..(at + 1) * size / of;
            let place = (part(column, columns, a.image.width), part(row, rows, a.image.height));
            let (ratio, half) = tile(a, b, &place);
            tiles.ratios.push(ratio);
            tiles.half.push(half);
        }
    }
}

type Place = (std::ops::Range<usize>, std::ops::Range<usize>);

/// B / A of the means over a tile and all channels, and half of its interval of 95 %: by the variances of the pixels, which are taken to
/// be independent of each other, the error of a quotient to first order.
fn tile(a: &Side, b: &Side, (columns, rows): &Place) -> (Option<f64>, Option<f64>) {
    let (mut sums, mut spreads) = ([0.0_f64; 2], [0.0_f64; 2]);
    for y in rows.clone() {
        for x in columns.clone() {
            let pixels = [a.image.at(x, y), b.image.at(x, y)];
            if !pixels.iter().all(finite) {
                continue;
            }
            for (side, of) in [a, b].into_iter().enumerate() {
                sums[side] += pixels[side].iter().map(|value| f64::from(*value)).sum::<f64>();
                let spread = of.variance.map(|variance| variance.at(x, y)).filter(finite);
                // Channels of a pixel go up and down together: their standard errors add up.
                let root =
                    spread.map_or(0.0, |spread| spread.iter().map(|v| f64::from(v.max(0.0)).sqrt()).sum::<f64>());
                spreads[side] += root * root;
            }
        }
    }
    if sums[0] <= 0.0 {
        return (None, None);
    }
    let ratio = sums[1] / sums[0];
    let known = b.variance.is_some();
    let share = (spreads[0] / (sums[0] * sums[0]) * ratio * ratio + spreads[1] / (sums[0] * sums[0])).sqrt();
    (Some(ratio), known.then_some(NINETY_FIVE * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_have_ratios_and_intervals() {
        let (a, mut b) = (Image::filled(16, 16, [1.0; 3]), Image::filled(16, 16, [1.1; 3]));
        b.pixels[0] = [f32::NAN; 3];
        let variance = Image::filled(16, 16, [0.04; 3]);
        let mut pair = Pair::default();
        let side = |image, variance| Side { image, variance };
        measure(&mut pair, &side(&a, None), &side(&b, Some(&variance)), true);
        let tiles = pair.tiles.expect("a grid");
        assert_eq!((tiles.columns, tiles.ratios.len()), (8, 64));
        assert!(tiles.ratios.iter().flatten().all(|ratio| (ratio - 1.1).abs() < 1e-6), "{tiles:?}");
        // Four pixels of standard error 0.2: 0.1 of their mean.
        assert!((tiles.half[63].expect("known") - 0.1 * NINETY_FIVE).abs() < 1e-6, "{:?}", tiles.half[63]);
        assert!(pair.metrics.iter().any(|(name, value)| name == "flip" && value.is_some()) && pair.refused.is_some());
    }

    #[test]
    fn what_cannot_be_compared_says_why() {
        let (a, b) = (Image::filled(4, 4, [1.0; 3]), Image::filled(5, 4, [1.0; 3]));
        let side = |image| Side { image, variance: None };
        let mut pair = Pair::default();
        measure(&mut pair, &side(&a), &side(&b), true);
        assert!(pair.refused.is_some_and(|why| why.contains("4 x 4 and 5 x 4")) && pair.tiles.is_none());
        let mut pair = Pair::default();
        let nan = Image::filled(4, 4, [f32::NAN; 3]);
        measure(&mut pair, &side(&a), &side(&nan), true);
        assert!(pair.refused.is_some() && pair.metrics.is_empty());
    }
}
