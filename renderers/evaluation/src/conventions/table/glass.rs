//! Conventions of glass.

use ltsc_core::capability::Feature;

use super::super::formula::{dielectric, slab, slab_once};
use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "camera_in_glass",
        &[Feature::SmoothDielectric],
        &[View::plain(&[Check {
            rests_on: &[Feature::SmoothDielectric],
            ..check(
                "through the surface",
                Measure::Mean(Region::ALL, Channel::All),
                Expected::Formula(|| 1.8 * 1.8 * (1.0 - dielectric(1.0, 1.8))),
                // 260 000 samples: a standard error of 0.06 %.
                Tolerance::Share(3e-3),
            )
        }])]
    ),
    convention!(
        "glass_slab",
        &[Feature::SmoothDielectric],
        &[
            View {
                name: "all reflections",
                ..View::plain(&[
                    pane("1.5, straight", 0, Expected::Formula(|| slab(0.0, 1.5))),
                    pane("1.5, 60 degrees", 1, Expected::Formula(|| slab(60.0, 1.5))),
                    pane("1.8, straight", 2, Expected::Formula(|| slab(0.0, 1.8))),
                    pane("1.8, 60 degrees", 3, Expected::Formula(|| slab(60.0, 1.8))),
                ])
            },
            View {
                name: "depth 4",
                depth: Some(4),
                ..View::plain(&[
                    pane("1.5, straight", 0, Expected::Formula(|| slab_once(0.0, 1.5))),
                    pane("1.5, 60 degrees", 1, Expected::Formula(|| slab_once(60.0, 1.5))),
                    pane("1.8, straight", 2, Expected::Formula(|| slab_once(0.0, 1.8))),
                    pane("1.8, 60 degrees", 3, Expected::Formula(|| slab_once(60.0, 1.8))),
                ])
            },
        ]
    ),
    convention!(
        "air_slab",
        &[Feature::ThinnerInside],
        &[View::plain(&[
            air("straight", 0, Expected::Formula(|| slab(0.0, 1.0 / 1.5))),
            air("30 degrees", 1, Expected::Formula(|| slab(30.0, 1.0 / 1.5))),
            air("60 degrees", 2, Expected::Number(0.0)),
        ])]
    ),
    convention!(
        "glass_box",
        &[Feature::SmoothDielectric],
        &[
            View { name: "lifted by 0.05", set: &[("lift", "0.05")], ..View::plain(&[room(LIFTED, &[])]) },
            View { name: "sunk by 0.05", set: &[("lift", "-0.05")], ..View::plain(&[room(SUNK, &[])]) },
            View {
                name: "on the floor",
                set: &[("lift", "0")],
                ..View::plain(&[room(
                    LIFTED,
                    &[Known { target: None, by: By::Rule("dielectric-contact"), within: Within::Ratio(0.7, 1.4) }]
                )])
            },
        ]
    ),
    convention!(
        "rough_glass_furnace",
        &[Feature::RoughDielectric],
        &[
            View {
                name: "alpha 0.1",
                set: &[("alpha", "0.1")],
                ..View::plain(&[specks("middle", MIDDLE, 0.9837), specks("whole image", Region::ALL, 0.9551),])
            },
            View {
                name: "alpha 0.3",
                set: &[("alpha", "0.3")],
                ..View::plain(&[ball("middle", MIDDLE, 0.8601), ball("whole image", Region::ALL, 0.8019),])
            },
            View {
                name: "alpha 0.5",
                set: &[("alpha", "0.5")],
                ..View::plain(&[ball("middle", MIDDLE, 0.6853), ball("whole image", Region::ALL, 0.6755),])
            },
            View {
                name: "alpha 0.8",
                set: &[("alpha", "0.8")],
                ..View::plain(&[ball("middle", MIDDLE, 0.4657), ball("whole image", Region::ALL, 0.5510),])
            },
            View {
                name: "alpha 1",
                set: &[("alpha", "1")],
                ..View::plain(&[ball("middle", MIDDLE, 0.3642), ball("whole image", Region::ALL, 0.4967),])
            },
        ]
    ),
];

/// The middle of a slab: four of eight columns, four of 32 rows, the slabs eight rows apart. 130 000 samples: a standard error of
/// 0.0007 to 0.0012.
const fn pane(name: &'static str, at: usize, expected: Expected) -> Check {
    let top = 2.0 + 8.0 * at as f64;
    let region = area(0.25, 0.75, top / 32.0, (top + 4.0) / 32.0);
    check(name, Measure::Mean(region, Channel::All), expected, Tolerance::Plain(4e-3))
}

const fn air(name: &'static str, at: usize, expected: Expected) -> Check {
    Check { rests_on: &[Feature::ThinnerInside], ..pane(name, at, expected) }
}

/// Seed 3; Cycles with 8192 samples has 0.2456 for the first, LuxCore with 4096 0.2437. Light that glass gathers is noisy: the 1024
/// samples of a run have a standard error of 2 %.
const BY: &str = "Mitsuba 3.9.1, 8192 samples";
const LIFTED: Expected = Expected::Reference { value: 0.2467, by: BY };
const SUNK: Expected = Expected::Reference { value: 0.3438, by: BY };

const fn room(expected: Expected, known: &'static [Known]) -> Check {
    Check {
        known,
        ..check(
            "foot of the box",
            Measure::Mean(area(0.3, 0.8, 0.7, 0.87), Channel::All),
            expected,
            Tolerance::Share(0.08),
        )
    }
}

/// Of 32 pixels eight by eight: 16 000 samples.
const MIDDLE: Region = area(0.375, 0.625, 0.375, 0.625);

/// rs_pbrt 0.9.12 has 0.91 to 1.02 of the answers.
const CORRELATED_3: Known = correlated("pbrt-v3");
const CORRELATED_4: Known = correlated("pbrt-v4");

const fn correlated(target: &'static str) -> Known {
    Known {
        target: Some(target),
        by: By::Feature(Feature::RoughDielectric, "PBRT's masking and shadowing are height-correlated"),
        within: Within::Ratio(0.9, 1.31),
    }
}

const fn ball(name: &'static str, region: Region, value: f64) -> Check {
    Check {
        rests_on: &[Feature::RoughDielectric],
        known: &[CORRELATED_3, CORRELATED_4],
        ..check(
            name,
            Measure::Mean(region, Channel::All),
            Expected::Reference { value, by: "Mitsuba 3.9.1, 1024 samples" },
            Tolerance::Share(0.012),
        )
    }
}

/// Where LuxCore's samples have heavy tails.
const fn specks(name: &'static str, region: Region, value: f64) -> Check {
    Check {
        known: &[
            Known {
                target: Some("luxcore"),
                by: By::Feature(Feature::RoughDielectric, "specks that made single tiles 2.4 times as bright"),
                within: Within::Ratio(0.95, 2.43),
            },
            CORRELATED_3,
            CORRELATED_4,
        ],
        ..ball(name, region, value)
    }
}
