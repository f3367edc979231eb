//! FLIP of what a screen shows.

use super::{Metric, Pair, Value};
use crate::compare::{flip_map, mean_of_map, pair_exposure};

pub(super) const ROW: Metric = Metric {
    name: "flip",
    summary: "difference seen when flipping between the images as shown, 0 to 1; of colors, so without channels",
    formula: "mean(LDR-FLIP of both images as shown), Andersson et al. 2020, 67 pixels per degree",
    measure,
};

fn measure(pair: &Pair) -> Value {
    Value::whole(mean_of_map(&flip_map(pair, pair_exposure(pair))))
}
