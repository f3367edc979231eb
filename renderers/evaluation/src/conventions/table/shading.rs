//! Conventions of normals, and of surfaces near each other.

use ltsc_core::capability::Feature;

use super::super::formula::furnace;
use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "normal_interpolation",
        &[Feature::VertexNormals, Feature::SmoothDiffuse],
        &[View::plain(&[
            interpolated("left edge", area(0.0, 0.125, 0.0, 1.0)),
            interpolated("between", area(0.25, 0.375, 0.0, 1.0)),
            interpolated("middle", area(0.4375, 0.5625, 0.0, 1.0)),
            interpolated("right edge", area(0.875, 1.0, 0.0, 1.0)),
        ])]
    ),
    convention!(
        "flat_faces",
        &[Feature::VertexNormals, Feature::Diffuse],
        &[View::plain(&[
            interpolated("left face", area(0.0, 0.4, 0.0, 1.0)),
            interpolated("right face", area(0.6, 1.0, 0.0, 1.0)),
            interpolated("left of the ridge", area(0.40625, 0.46875, 0.0, 1.0)),
            interpolated("right of the ridge", area(0.53125, 0.59375, 0.0, 1.0)),
        ])]
    ),
    convention!(
        "turned_normals",
        &[Feature::VertexNormals, Feature::SmoothDiffuse],
        &[View::plain(&[Check {
            known: &[Known {
                target: Some("pbrt-v3"),
                by: By::Feature(Feature::SmoothDiffuse, "with the same cosine"),
                // 0.8 / pi of 0.342.
                within: Within::Distance(0.0875),
            }],
            ..check(
                "turned away",
                Measure::Mean(Region::ALL, Channel::All),
                Expected::Number(0.0),
                Tolerance::Plain(1e-4),
            )
        }])]
    ),
    convention!(
        "one_sided",
        &[Feature::OneSided, Feature::Diffuse],
        &[View::plain(&[
            front("a diffuse front", area(0.15, 0.38, 0.15, 0.38), 0.8),
            front("a mirror's front", area(0.62, 0.85, 0.15, 0.38), 0.7),
            back("a diffuse back", area(0.15, 0.38, 0.62, 0.85)),
            back("a mirror's back", area(0.62, 0.85, 0.62, 0.85)),
        ])]
    ),
    convention!(
        "coarse_sphere",
        &[Feature::VertexNormals, Feature::SmoothDiffuse],
        &[View::plain(&[
            sphere(
                "whole image",
                Region::ALL,
                5e-3,
                &[
                    smooth("cycles", "2.7 % too bright in its mean", Within::Ratio(1.0, 1.03)),
                    smooth("pbrt-v3", "3.5 % lit from the side", Within::Ratio(1.0, 1.04)),
                ]
            ),
            // A column and a half of what faces the camera, while its normals do not.
            sphere(
                "lit edge",
                area(0.093, 0.157, 0.35, 0.65),
                0.02,
                &[
                    smooth("cycles", "up to 0.06 of radiance stands for 0", Within::Distance(0.06)),
                    smooth("pbrt-v3", "knows no hemisphere", Within::Distance(0.06)),
                ]
            ),
            sphere(
                "between light and shadow",
                area(0.47, 0.66, 0.3, 0.7),
                8e-3,
                &[smooth("pbrt-v3", "27 % in the band between light and shadow", Within::Ratio(1.0, 1.3))]
            ),
        ])]
    ),
    convention!(
        "far_camera",
        &[Feature::Diffuse, Feature::Camera],
        &[View::plain(&[
            turned("0 degrees", 0),
            turned("1.5 degrees", 1),
            turned("3 degrees", 2),
            turned("5 degrees", 3)
        ])]
    ),
    convention!(
        "corner_leak",
        &[Feature::IndirectLight],
        &[
            View { name: "at the origin", set: &[("away", "0"), ("window", "0.06")], ..View::plain(CORNER) },
            View { name: "1000 away", set: &[("away", "1000"), ("window", "0.6")], ..View::plain(CORNER) },
            View { name: "10000 away", set: &[("away", "10000"), ("window", "6")], ..View::plain(CORNER) },
        ]
    ),
    convention!(
        "coplanar_squares",
        &[Feature::Diffuse],
        &[
            View {
                name: "in one plane",
                set: &[("gap", "0")],
                ..View::plain(&[Check {
                    known: &[Known {
                        target: Some("cycles"),
                        by: By::Rule("overlapping-faces"),
                        within: Within::Ratio(0.0, 0.1),
                    }],
                    ..SQUARE
                }])
            },
            View { name: "a little apart", set: &[("gap", "0.0001")], ..View::plain(&[SQUARE]) },
        ]
    ),
];

/// Reflects its share of even light.
const fn front(name: &'static str, region: Region, share: f64) -> Check {
    check(name, Measure::Mean(region, Channel::All), Expected::Number(share), Tolerance::Share(0.01))
}

/// Reflects nothing; in PBRT it is as from the front.
const fn back(name: &'static str, region: Region) -> Check {
    const BOTH: [Known; 2] = [as_from_the_front("pbrt-v3"), as_from_the_front("pbrt-v4")];
    Check {
        known: &BOTH,
        ..check(name, Measure::Mean(region, Channel::All), Expected::Number(0.0), Tolerance::Plain(1e-4))
    }
}

const fn as_from_the_front(target: &'static str) -> Known {
    let by = By::Feature(Feature::OneSided, "all that its back reflects");
    Known { target: Some(target), by, within: Within::Distance(0.81) }
}

/// Two rows in the middle of a plate, the plates four rows apart.
const fn turned(name: &'static str, at: usize) -> Check {
    let top = 5.0 + 4.0 * at as f64;
    interpolated(name, area(0.375, 0.625, top / 32.0, (top + 2.0) / 32.0))
}
/// 65 000 samples: a standard error of 0.2 % at most.
const SQUARE: Check =
    check("albedo", Measure::Mean(Region::ALL, Channel::All), Expected::Number(0.8), Tolerance::Share(0.01));

const fn interpolated(name: &'static str, region: Region) -> Check {
    check(name, Measure::Mean(region, Channel::All), Expected::Ideal, Tolerance::Share(5e-3))
}

const fn sphere(name: &'static str, region: Region, share: f64, known: &'static [Known]) -> Check {
    Check { known, ..check(name, Measure::Mean(region, Channel::All), Expected::Ideal, Tolerance::Share(share)) }
}

const fn smooth(target: &'static str, words: &'static str, within: Within) -> Known {
    Known { target: Some(target), by: By::Feature(Feature::SmoothDiffuse, words), within }
}

/// A row on each side of the edge, 16 000 samples each: a standard error of 0.3 %.
const CORNER: &[Check] = &[
    Check { known: LEAKS, ..corner("above the edge", area(0.0, 1.0, 0.4375, 0.5)) },
    Check { known: LEAKS, ..corner("below the edge", area(0.0, 1.0, 0.5, 0.5625)) },
    corner("away from it", area(0.0, 1.0, 0.75, 1.0)),
];

const fn corner(name: &'static str, region: Region) -> Check {
    check(name, Measure::Mean(region, Channel::All), Expected::Formula(|| furnace(0.8, 3)), Tolerance::Share(0.02))
}

const LEAKS: &[Known] = &[
    Known { target: Some("mitsuba-0.6"), by: LEAK, within: Within::Ratio(0.5, 1.0) },
    Known { target: Some("mitsuba-0.5"), by: LEAK, within: Within::Ratio(0.5, 1.0) },
    Known {
        target: Some("pbrt-v4"),
        by: By::Feature(Feature::IndirectLight, "of a cube of 100 units 2.1 % too dark"),
        within: Within::Ratio(0.97, 1.0),
    },
];

const LEAK: By = By::Feature(Feature::IndirectLight, "a dark line as wide as 1e-4 times the largest coordinate");
