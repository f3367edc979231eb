//! Conventions of lights without a surface.

use ltsc_core::capability::Feature;

use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "point_light",
        &[Feature::PointLight, Feature::ColoredEmitter, Feature::Diffuse],
        &[View::plain(&[
            colored(near("red", NEAR_BULB, Channel::Red)),
            colored(near("green", NEAR_BULB, Channel::Green)),
            colored(near("blue", NEAR_BULB, Channel::Blue)),
            colored(near("far from it", area(0.65, 0.95, 0.7, 0.95), Channel::All)),
            check(
                "in the shadow",
                Measure::Mean(area(0.75, 0.81, 0.5, 0.56), Channel::All),
                Expected::Number(0.0),
                Tolerance::Plain(1e-4),
            ),
        ])]
    ),
    convention!(
        "spot_light",
        &[Feature::SpotLight, Feature::SoftSpotLight],
        &[View::plain(&[
            near("on the axis", columns(31.0, 33.0), Channel::All),
            Check { known: LUXCORE_CONE, ..near("10 degrees", columns(38.0, 40.0), Channel::All) },
            Check { known: LUXCORE_CONE, ..near("20 degrees", columns(46.0, 47.0), Channel::All) },
            Check { known: RING, ..near("between the cones", columns(51.0, 52.0), Channel::All) },
            check(
                "outside",
                Measure::Mean(columns(57.0, 64.0), Channel::All),
                Expected::Number(0.0),
                Tolerance::Plain(1e-4),
            ),
        ])]
    ),
    convention!(
        "directional_light",
        &[Feature::DirectionalLight, Feature::ColoredEmitter, Feature::ColoredDiffuse, Feature::Diffuse],
        &[View::plain(&[
            colored(near("red", FLOOR, Channel::Red)),
            colored(near("green", FLOOR, Channel::Green)),
            colored(near("blue", FLOOR, Channel::Blue)),
            check(
                "turned away",
                Measure::Mean(area(0.8125, 0.875, 0.44, 0.62), Channel::All),
                Expected::Number(0.0),
                Tolerance::Plain(1e-4),
            ),
        ])]
    ),
    convention!(
        "environment_light",
        &[Feature::Environment, Feature::ColoredEmitter, Feature::ColoredDiffuse],
        &[View::plain(&[
            colored(check(
                "seen, red",
                Measure::Mean(RIGHT, Channel::Red),
                Expected::Number(1.0),
                Tolerance::Share(1e-3)
            )),
            colored(check(
                "seen, green",
                Measure::Mean(RIGHT, Channel::Green),
                Expected::Number(2.0),
                Tolerance::Share(1e-3)
            )),
            colored(check(
                "seen, blue",
                Measure::Mean(RIGHT, Channel::Blue),
                Expected::Number(0.5),
                Tolerance::Share(1e-3)
            )),
            // 100 000 samples: a standard error of at most 0.15 %.
            colored(check(
                "lit, red",
                Measure::Mean(LEFT, Channel::Red),
                Expected::Number(0.8),
                Tolerance::Share(6e-3)
            )),
            colored(check(
                "lit, green",
                Measure::Mean(LEFT, Channel::Green),
                Expected::Number(0.8),
                Tolerance::Share(6e-3)
            )),
            colored(check(
                "lit, blue",
                Measure::Mean(LEFT, Channel::Blue),
                Expected::Number(0.1),
                Tolerance::Share(6e-3)
            )),
        ])]
    ),
];

const NEAR_BULB: Region = area(0.05, 0.35, 0.05, 0.35);
const FLOOR: Region = area(0.05, 0.5, 0.05, 0.95);
const LEFT: Region = area(0.05, 0.45, 0.05, 0.95);
const RIGHT: Region = area(0.55, 0.95, 0.05, 0.95);

/// A check of light that has a color, seen or on a surface that has one.
const fn colored(check: Check) -> Check {
    Check { rests_on: &[Feature::ColoredEmitter], ..check }
}

/// A mean that the ideal image has too; only where samples lie within pixels is left to chance.
const fn near(name: &'static str, region: Region, channel: Channel) -> Check {
    check(name, Measure::Mean(region, channel), Expected::Ideal, Tolerance::Share(5e-3))
}

/// Columns of 64, rows round the middle.
const fn columns(from: f64, to: f64) -> Region {
    area(from / 64.0, to / 64.0, 0.44, 0.56)
}

const LUXCORE_CONE: &[Known] = &[Known {
    target: Some("luxcore"),
    by: By::Feature(Feature::SpotLight, "1.5 % too bright at 10 degrees from it, 6 % at 20"),
    within: Within::Ratio(1.0, 1.07),
}];

/// 26 degrees from the axis, half of the way from the inner cone to the outer one: half of 0.74 (I rho cos^3 / (pi h^2)).
const RING: &[Known] = &[
    Known {
        target: Some("luxcore"),
        by: By::Feature(Feature::SoftSpotLight, "in that ring up to 0.47 of the intensity less"),
        within: Within::Distance(0.47 * 0.74),
    },
    Known {
        target: Some("cycles"),
        by: By::Feature(Feature::SoftSpotLight, "up to 0.11 of the intensity more where it is narrow"),
        within: Within::Distance(0.12 * 0.74),
    },
    Known {
        target: Some("pbrt-v4"),
        by: By::Feature(Feature::SoftSpotLight, "in it up to 0.11 of the intensity more where it is narrow"),
        within: Within::Distance(0.12 * 0.74),
    },
    Known {
        target: Some("pbrt-v3"),
        by: By::Feature(Feature::SoftSpotLight, "in it up to 0.47 of the intensity less"),
        within: Within::Distance(0.47 * 0.74),
    },
];
