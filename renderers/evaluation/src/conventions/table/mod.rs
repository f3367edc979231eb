//! The table of conventions, by what they are about. Each has one scene in `renderers/evaluation/conventions`; a test compares.

mod camera;
mod coats;
mod conductors;
mod emission;
mod glass;
mod groups;
mod images;
mod lights;
mod shading;

use super::kinds::{Check, Convention, Expected, Measure, Tolerance};

/// A convention with the text of its scene, and what it proves.
macro_rules! convention {
    ($name:literal, $proves:expr, $views:expr) => {
        Convention {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/conventions/", $name, ".lts")),
            proves: $proves,
            views: $views,
        }
    };
}
use convention;

/// All conventions by family, in the order in which they are shown.
const FAMILIES: &[&[Convention]] = &[
    camera::ROWS,
    emission::ROWS,
    lights::ROWS,
    conductors::ROWS,
    glass::ROWS,
    coats::ROWS,
    shading::ROWS,
    images::ROWS,
    groups::ROWS,
];

/// All conventions.
pub fn all() -> impl Iterator<Item = &'static Convention> {
    FAMILIES.iter().copied().flatten()
}

/// A check with nothing stated about it.
const fn check(name: &'static str, measure: Measure, expected: Expected, tolerance: Tolerance) -> Check {
    Check { name, measure, expected, tolerance, rests_on: &[], known: &[] }
}
