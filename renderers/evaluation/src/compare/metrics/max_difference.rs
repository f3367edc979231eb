//! The largest difference of any pixel.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric = Metric {
    name: "max-difference",
    summary: "largest absolute difference of a pixel, in units of radiance",
    formula: "max(|B - A|)",
    measure,
};

fn measure(pair: &Pair) -> Value {
    let largest = pair.pixels().fold(None, |largest: Option<[f64; 3]>, (a, b)| {
        let largest = largest.unwrap_or([0.0; 3]);
        Some(std::array::from_fn(|channel| largest[channel].max((b[channel] - a[channel]).abs())))
    });
    largest.map_or(Value::NONE, |largest| Value {
        overall: Some(largest.into_iter().fold(0.0, f64::max)),
        channels: largest.map(Some),
    })
}
