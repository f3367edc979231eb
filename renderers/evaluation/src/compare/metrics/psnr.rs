//! Peak signal-to-noise ratio of what a screen shows.

use super::{Metric, Pair, Value};
use crate::compare::pair_exposure;
use crate::compare::shown::shown;

pub(super) const ROW: Metric = Metric {
    name: "psnr",
    summary: "peak signal-to-noise ratio as shown, in dB; larger is more equal",
    formula: "-10 log10(mean((b - a)^2)); a, b: values of both images as shown, in sRGB; no value where they are equal, \
              since it is infinite",
    measure,
};

fn measure(pair: &Pair) -> Value {
    let [a, b] = shown(pair, pair_exposure(pair));
    // They are of one size and hold pixels, as the pair does.
    let Ok(shown) = Pair::new(&a, &b) else { return Value::NONE };
    let Value { overall, channels } = Value::of_means(shown.mean(|a, b, _| (b - a).powi(2)));
    let decibel = |error: Option<f64>| error.filter(|error| *error > 0.0).map(|error| -10.0 * error.log10());
    Value { overall: decibel(overall), channels: channels.map(decibel) }
}
