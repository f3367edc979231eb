//! Conventions of coats.

use ltsc_core::capability::Feature;

use super::super::formula::coat;
use super::super::kinds::{By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[convention!(
    "smooth_coat",
    &[
        View {
            name: "0 degrees",
            set: &[("turn", "0deg")],
            ..View::plain(&[albedo(
                Expected::Formula(|| coat(0.0, 0.5, 1.5)),
                &[stated("pbrt-v3", "0.97, 0.80, 0.90 of Mitsuba's albedo", Within::Ratio(0.96, 0.98))],
            )])
        },
        View {
            name: "60 degrees",
            set: &[("turn", "60deg")],
            ..View::plain(&[albedo(
                Expected::Formula(|| coat(60.0, 0.5, 1.5)),
                &[
                    stated("pbrt-v3", "0.97, 0.80, 0.90 of Mitsuba's albedo", Within::Ratio(0.79, 0.81)),
                    stated("luxcore", "1.00, 0.98, 1.21 of Mitsuba 3.9.1", Within::Ratio(0.97, 0.99)),
                ],
            )])
        },
        View {
            name: "80 degrees",
            set: &[("turn", "80deg")],
            ..View::plain(&[albedo(
                Expected::Formula(|| coat(80.0, 0.5, 1.5)),
                &[
                    stated("pbrt-v3", "0.97, 0.80, 0.90 of Mitsuba's albedo", Within::Ratio(0.89, 0.91)),
                    stated("luxcore", "1.00, 0.98, 1.21 of Mitsuba 3.9.1", Within::Ratio(1.19, 1.22)),
                ],
            )])
        },
    ]
)];

const fn stated(target: &'static str, words: &'static str, within: Within) -> Known {
    Known { target: Some(target), by: By::Feature(Feature::Plastic, words), within }
}

/// In all of the image.
const fn albedo(expected: Expected, known: &'static [Known]) -> Check {
    Check {
        known,
        rests_on: &[Feature::Plastic],
        ..check("albedo", Measure::Mean(Region::ALL, Channel::All), expected, Tolerance::Share(6e-3))
    }
}
