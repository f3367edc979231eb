//! The ratio of the means: too bright or too dark as a whole.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric = Metric {
    name: "ratio",
    summary: "how much brighter the image is as a whole",
    formula: "mean(B) / mean(A); no value where mean(A) = 0",
    measure,
};

fn measure(pair: &Pair) -> Value {
    match (pair.mean(|a, _, _| a), pair.mean(|_, b, _| b)) {
        (Some(a), Some(b)) => Value::of_ratio(a, b),
        _ => Value::NONE,
    }
}
