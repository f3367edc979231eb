//! Mean absolute percentage error, as a share and not in percent.

use super::{Metric, Pair, Value, relative};

pub(super) const ROW: Metric = Metric {
    name: "mape",
    summary: "mean absolute error relative to the reference",
    formula: "mean(|B - A| / (|A| + e)), e = 1 % of the channel's mean |A|; no value in a channel \
              that is black in A, and such channels do not count overall",
    measure,
};

fn measure(pair: &Pair) -> Value {
    relative(pair, |a, b, guard| (b - a).abs() / (a.abs() + guard))
}
