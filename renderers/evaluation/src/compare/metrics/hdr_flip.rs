//! FLIP of radiance, over exposures.

use super::{Metric, Pair, Value};
use crate::compare::{hdr_flip_map, mean_of_map};

pub(super) const ROW: Metric = Metric {
    name: "hdr-flip",
    summary: "largest difference seen at any exposure, 0 to 1; of colors, so without channels",
    formula: "mean(max(LDR-FLIP of both images at exposure c, tone-mapped by ACES) over c), Andersson et al. 2021, 67 pixels \
              per degree; c from where the brightest pixel of A is mapped to 0.85 to where its median luminance is, at most a \
              stop apart up to 64 exposures; the median of pixels that are not black where that of all is 0; no value where A \
              is black and B is not",
    measure,
};

fn measure(pair: &Pair) -> Value {
    Value::whole(hdr_flip_map(pair).and_then(|map| mean_of_map(&map)))
}
