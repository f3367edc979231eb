//! Conventions of mirrors and metals.

use ltsc_core::capability::Feature;

use super::super::formula::Metal;
use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "mirror",
        &[Feature::Mirror, Feature::DimMirror],
        &[View::plain(&[
            check("perfect", Measure::Mean(PERFECT, Channel::All), Expected::Number(2.0), EXACT),
            dim("colored, red", Channel::Red, 1.8),
            dim("colored, green", Channel::Green, 1.0),
            dim("colored, blue", Channel::Blue, 0.4),
            check(
                "towards the dark",
                Measure::Mean(area(0.71, 0.86, 0.34, 0.66), Channel::All),
                Expected::Number(0.0),
                Tolerance::Plain(1e-4),
            ),
        ])]
    ),
    convention!(
        "conductor_fresnel",
        &[Feature::SmoothConductor, Feature::ColoredConductor],
        &[View::plain(&[
            reflects("0 degrees, red", 0, Channel::Red),
            reflects("30 degrees, green", 1, Channel::Green),
            reflects("45 degrees, red", 2, Channel::Red),
            reflects("45 degrees, blue", 2, Channel::Blue),
            reflects("60 degrees, green", 3, Channel::Green),
            reflects("75 degrees, red", 4, Channel::Red),
            reflects("75 degrees, blue", 4, Channel::Blue),
            reflects("82 degrees, green", 5, Channel::Green),
        ])]
    ),
    convention!(
        "conductor_alpha",
        &[Feature::RoughConductor],
        &[View::plain(&[
            lobe("0 degrees", 0),
            lobe("10 degrees", 1),
            lobe("20 degrees", 2),
            lobe("30 degrees", 3),
            lobe("45 degrees", 4),
        ])]
    ),
    convention!(
        "conductor_masking",
        &[Feature::RoughConductor, Feature::WideConductor],
        &[
            View {
                name: "alpha 0.5, 0 degrees",
                set: &[("alpha", "0.5"), ("turn", "0deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(0.5, 0.0)))])
            },
            View {
                name: "alpha 0.5, 60 degrees",
                set: &[("alpha", "0.5"), ("turn", "60deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(0.5, 60.0)))])
            },
            View {
                name: "alpha 0.5, 78.5 degrees",
                set: &[("alpha", "0.5"), ("turn", "78.5deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(0.5, 78.5)))])
            },
            View {
                name: "alpha 1, 0 degrees",
                set: &[("alpha", "1"), ("turn", "0deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(1.0, 0.0)))])
            },
            View {
                name: "alpha 1, 60 degrees",
                set: &[("alpha", "1"), ("turn", "60deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(1.0, 60.0)))])
            },
            View {
                name: "alpha 1, 78.5 degrees",
                set: &[("alpha", "1"), ("turn", "78.5deg")],
                ..View::plain(&[albedo(Expected::Formula(|| masked(1.0, 78.5)))])
            },
        ]
    ),
    convention!(
        "conductor_sharp",
        &[Feature::SharpConductor],
        &[View::plain(&[
            sharp("0 degrees", 0),
            sharp("0.15 degrees", 1),
            sharp("0.3 degrees", 2),
            sharp("0.5 degrees", 3),
        ])]
    ),
];

const EXACT: Tolerance = Tolerance::Share(1e-3);

const PERFECT: Region = area(0.13, 0.31, 0.34, 0.66);

const fn dim(name: &'static str, channel: Channel, expected: f64) -> Check {
    Check {
        known: &[Known {
            target: Some("pbrt-v4"),
            by: By::Feature(
                Feature::DimMirror,
                "at 45, 60, 75 and 85 degrees 0.896, 0.884, 0.854, 0.874 for a reflectance of 0.9",
            ),
            within: Within::Distance(0.1),
        }],
        ..check(name, Measure::Mean(area(0.41, 0.59, 0.34, 0.66), channel), Expected::Number(expected), EXACT)
    }
}

/// The middle of a plate: two of the eight columns, two of 32 rows, the plates four rows apart.
const fn plate(at: usize) -> Region {
    let top = 5.0 + 4.0 * at as f64;
    area(0.375, 0.625, top / 32.0, (top + 2.0) / 32.0)
}

const fn reflects(name: &'static str, at: usize, channel: Channel) -> Check {
    Check {
        rests_on: &[Feature::SmoothConductor],
        known: &[
            Known {
                target: Some("pbrt-v3"),
                by: By::Feature(Feature::SmoothConductor, "in even light by 1.3 to 3.7 %"),
                within: Within::Ratio(0.95, 1.0),
            },
            Known {
                target: Some("pbrt-v4"),
                by: By::Feature(Feature::ColoredConductor, "0.982 0.624 0.513 instead of 0.952 0.620 0.511"),
                within: Within::Distance(0.04),
            },
        ],
        ..check(name, Measure::Mean(plate(at), channel), Expected::Ideal, Tolerance::Share(3e-3))
    }
}

const fn lobe(name: &'static str, at: usize) -> Check {
    Check {
        rests_on: &[Feature::RoughConductor],
        ..check(name, Measure::Mean(plate(at), Channel::All), Expected::Ideal, Tolerance::Share(0.01))
    }
}

const fn sharp(name: &'static str, at: usize) -> Check {
    Check {
        rests_on: &[Feature::RoughConductor, Feature::SharpConductor],
        ..check(name, Measure::Mean(plate(at), Channel::All), Expected::Ideal, Tolerance::Share(0.02))
    }
}

/// The metal of `conductor_masking`, seen at an angle.
fn masked(alpha: f64, degrees: f64) -> f64 {
    Metal { eta: 0.2, k: 3.9, alpha }.albedo(degrees.to_radians().cos())
}

/// In all of the image.
const fn albedo(expected: Expected) -> Check {
    Check {
        rests_on: &[Feature::WideConductor],
        ..check("albedo", Measure::Mean(Region::ALL, Channel::All), expected, Tolerance::Share(0.01))
    }
}
