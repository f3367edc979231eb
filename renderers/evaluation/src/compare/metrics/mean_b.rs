//! The mean of the image that is judged.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric =
    Metric { name: "mean-b", summary: "mean radiance of the image", formula: "mean(B)", measure };

fn measure(pair: &Pair) -> Value {
    Value::of_means(pair.mean(|_, b, _| b))
}
