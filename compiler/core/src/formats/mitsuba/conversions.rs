//! Formulas by which the Scene's numbers become Mitsuba's; most are the same numbers.

use crate::capability::Feature;

/// See [`crate::formats::Target::conversions`].
pub const CONVERSIONS: &[(Feature, &str)] = &[
    (Feature::Texture, "v of texture coordinates becomes 1 - v: Mitsuba's images begin at their top"),
    (Feature::EnvironmentImage, "turned from y up, +z in the middle, to z up, +y in the middle"),
];
