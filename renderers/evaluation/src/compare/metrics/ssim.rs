//! Structural similarity of what a screen shows.

use super::{Metric, Pair, Value};
use crate::compare::{mean_of_map, pair_exposure, ssim_map};

pub(super) const ROW: Metric = Metric {
    name: "ssim",
    summary: "structural similarity as shown, -1 to 1; 1 is equal; of luminance, so without channels",
    formula: "mean((2 a b + 1e-4) (2 cov + 9e-4) / ((a^2 + b^2 + 1e-4) (var_a + var_b + 9e-4))) over windows of 5 x 5 \
              pixels of equal weight, cut at the border; a, b: luminance of both images as shown, in sRGB",
    measure,
};

fn measure(pair: &Pair) -> Value {
    Value::whole(mean_of_map(&ssim_map(pair, pair_exposure(pair))))
}
