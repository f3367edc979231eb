//! Symmetric mean absolute percentage error, as a share between 0 and 2.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric = Metric {
    name: "smape",
    summary: "mean absolute error relative to the mean of both images, 0 to 2",
    formula: "mean(2 |B - A| / (|A| + |B|)), 0 where both are black",
    measure,
};

fn measure(pair: &Pair) -> Value {
    Value::of_means(pair.mean(|a, b, _| {
        let sum = a.abs() + b.abs();
        if sum > 0.0 { 2.0 * (b - a).abs() / sum } else { 0.0 }
    }))
}
