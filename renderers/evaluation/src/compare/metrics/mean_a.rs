//! The mean of the reference.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric =
    Metric { name: "mean-a", summary: "mean radiance of the reference", formula: "mean(A)", measure };

fn measure(pair: &Pair) -> Value {
    Value::of_means(pair.mean(|a, _, _| a))
}
