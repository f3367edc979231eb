//! Relative mean square error: squared differences weigh less where the reference is bright.

use super::{Metric, Pair, Value, relative};

pub(super) const ROW: Metric = Metric {
    name: "relative-mse",
    summary: "mean square error relative to the reference",
    formula: "mean((B - A)^2 / (A^2 + e^2)), e = 1 % of the channel's mean |A|; no value in a \
              channel that is black in A, and such channels do not count overall",
    measure,
};

fn measure(pair: &Pair) -> Value {
    relative(pair, |a, b, guard| (b - a).powi(2) / (a * a + guard * guard))
}
