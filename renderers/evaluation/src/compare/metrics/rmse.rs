//! Root mean square error.

use super::{Metric, Pair, Value};

pub(super) const ROW: Metric = Metric {
    name: "rmse",
    summary: "root mean square error, in units of radiance",
    formula: "sqrt(mean((B - A)^2))",
    measure,
};

fn measure(pair: &Pair) -> Value {
    let Value { overall, channels } = Value::of_means(pair.mean(|a, b, _| (b - a).powi(2)));
    Value { overall: overall.map(f64::sqrt), channels: channels.map(|mean| mean.map(f64::sqrt)) }
}
