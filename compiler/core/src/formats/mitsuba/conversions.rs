//! Formulas by which the Scene's numbers become Mitsuba's; most are the same numbers.

use crate::capability::{Bound, Feature};
use crate::formats::shared::filter::{self, Kernel};
use crate::ir::Scene;

/// Values of the table in which all versions look a filter up, each that of its step's inner end (`MTS_FILTER_RESOLUTION`, `rfilter.h`).
const TABLE: u32 = 31;

/// See [`crate::formats::Target::conversions`].
pub const CONVERSIONS: &[(Feature, &str)] = &[
    (Feature::Texture, "v of texture coordinates becomes 1 - v: Mitsuba's images begin at their top"),
    (Feature::EnvironmentImage, "turned from y up, +z in the middle, to z up, +y in the middle"),
];

/// Gaussians: Mitsuba's are cut at four standard deviations, and drawn by a table.
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    if ![Feature::GaussianFilter, Feature::CutGaussianFilter].contains(&feature) {
        return None;
    }
    filter::bound(scene, 0.0, |stddev, _| Kernel::lowered(stddev, 4.0 * stddev).stepped(TABLE, 0.0))
}
