//! The exposures of HDR-FLIP, and the tone mapping of each.

use super::color::luminance;

/// Narkowicz's fit of ACES, `(a x^2 + b x) / (c x^2 + d x + e)`, with 0.6 times the exposure, which his fit leaves out (Narkowicz 2016;
/// Andersson et al. 2021).
const ACES: [f64; 5] = [2.51 * 0.36, 0.03 * 0.6, 2.43 * 0.36, 0.59 * 0.6, 0.14];

/// The tone-mapped value that the brightest pixel has at the first exposure, and the median at the last (Andersson et al. 2021).
const TARGET: f64 = 0.85;

/// The most exposures. They lie one stop or less apart up to that, farther beyond: a range of 63 stops holds no picture, and without a
/// bound a median near 0 would take hours.
const MOST: f64 = 64.0;

/// Exposures in stops, evenly spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The first, the darkest.
    pub start: f64,
    /// The last.
    pub stop: f64,
    /// How many, 2 or more.
    pub count: usize,
}

impl Exposures {
    /// Those of a reference with these luminances: from where the brightest pixel is mapped to 0.85 to where the median is, a stop or less
    /// apart, up to 64. Where the median is 0, that of the luminances above 0 counts. Nothing without a luminance above 0.
    #[must_use]
    pub(in super::super) fn of(colors: impl Iterator<Item = [f32; 3]>) -> Option<Self> {
        let mut values: Vec<f32> = colors.map(|rgb| luminance(rgb).clamp(0.0, f32::MAX)).collect();
        if median(&mut values)? <= 0.0 {
            values.retain(|value| *value > 0.0);
        }
        let middle = median(&mut values)?;
        let most = f64::from(values.iter().copied().fold(0.0, f32::max));
        let [a, b, c, d, e] = ACES;
        let (square, linear, constant) = (a - TARGET * c, b - TARGET * d, -TARGET * e);
        let mapped = (-linear + (linear * linear - 4.0 * square * constant).sqrt()) / (2.0 * square);
        let (start, stop) = ((mapped / most).log2(), (mapped / middle).log2());
        Some(Self { start, stop, count: (stop - start).ceil().clamp(2.0, MOST) as usize })
    }

    /// The factors of all exposures.
    pub(super) fn gains(&self) -> impl Iterator<Item = f32> {
        let step = (self.stop - self.start) / (self.count as f64 - 1.0);
        // A factor of single precision: 0 times it must stay 0.
        (0..self.count).map(move |at| (self.start + step * at as f64).exp2().min(f64::from(f32::MAX)) as f32)
    }
}

/// The middle value, the upper one of two.
fn median(values: &mut [f32]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1))
}

/// A value of radiance times an exposure's factor, tone-mapped, 0 to 1. Negative radiance counts as none.
#[inline]
pub(super) fn aces(value: f32, gain: f32) -> f32 {
    const F: [f32; 5] = [ACES[0] as f32, ACES[1] as f32, ACES[2] as f32, ACES[3] as f32, ACES[4] as f32];
    // The curve is above 1 there, and its square still a number.
    let x = (value * gain).clamp(0.0, 1e6);
    (x * (F[0] * x + F[1]) / (x * (F[2] * x + F[3]) + F[4])).min(1.0)
}
