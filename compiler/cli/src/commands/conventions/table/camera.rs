//! Conventions of the camera and the film.

use ltsc_core::capability::Feature;
use ltsc_core::ir::Camera;

use super::super::formula::projected;
use super::super::kinds::{Axis, Channel, Check, Convention, Expected, Measure, Region, Tolerance, View, area};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "field_of_view",
        &[Feature::Camera, Feature::Resolution, Feature::BlackEmitter],
        &[
            View { name: "64 x 64", ..View::plain(COVERED) },
            View { name: "64 x 32", size: Some((64, 32)), ..View::plain(COVERED) },
            View { name: "32 x 64", size: Some((32, 64)), ..View::plain(COVERED_NARROW) },
        ]
    ),
    convention!(
        "image_quarters",
        &[Feature::Camera, Feature::Resolution, Feature::PixelFilter, Feature::BlackEmitter],
        &[
            View { name: "32 x 32", ..View::plain(QUARTERS) },
            View { name: "48 x 32", size: Some((48, 32)), ..View::plain(QUARTERS) },
            View { name: "32 x 48", size: Some((32, 48)), ..View::plain(QUARTERS) },
        ]
    ),
    convention!(
        "handedness",
        &[Feature::Camera],
        &[View::plain(&[
            check("x axis, across", Measure::Middle(Channel::Red, Axis::X), Expected::Formula(|| seen(0).0), NEAR),
            check("x axis, down", Measure::Middle(Channel::Red, Axis::Y), Expected::Formula(|| seen(0).1), NEAR),
            check("y axis, across", Measure::Middle(Channel::Green, Axis::X), Expected::Formula(|| seen(1).0), NEAR),
            check("y axis, down", Measure::Middle(Channel::Green, Axis::Y), Expected::Formula(|| seen(1).1), NEAR),
            check("z axis, across", Measure::Middle(Channel::Blue, Axis::X), Expected::Formula(|| seen(2).0), NEAR),
            check("z axis, down", Measure::Middle(Channel::Blue, Axis::Y), Expected::Formula(|| seen(2).1), NEAR),
        ])]
    ),
    convention!(
        "pixel_filter",
        &[Feature::PixelFilter, Feature::Resolution],
        &[View::plain(&[
            check("column before the edge", column(9), Expected::Number(1.0), EXACT),
            // 16 000 samples: a standard error of 0.0034.
            check("column of the edge", column(10), Expected::Number(0.25), Tolerance::Plain(0.015)),
            check("column behind the edge", column(11), Expected::Number(0.0), EXACT),
        ])]
    ),
    convention!(
        "clipping",
        &[Feature::ClippingPlanes],
        &[View::plain(&[
            clipped("between the planes", area(0.0, 0.4375, 0.0, 1.0), 2.0),
            clipped("behind them", area(0.5625, 1.0, 0.0, 1.0), 0.0),
        ])]
    ),
    convention!(
        "two_cameras",
        &[Feature::SeveralCameras],
        &[View::plain(&[check("the first", Measure::Mean(Region::ALL, Channel::All), Expected::Number(2.0), TENTH)])]
    ),
];

const EXACT: Tolerance = Tolerance::Plain(1e-3);

const fn clipped(name: &'static str, region: Region, radiance: f64) -> Check {
    Check {
        rests_on: &[Feature::ClippingPlanes],
        ..check(name, Measure::Mean(region, Channel::All), Expected::Number(radiance), EXACT)
    }
}

/// A fifth of a pixel.
const NEAR: Tolerance = Tolerance::Plain(0.2);

/// Pixels to a unit at the distance 1, where the image is `width` wide.
fn scale(width: f64) -> f64 {
    width / 2.0 / 30_f64.to_radians().tan()
}

/// In an image 64 pixels wide. The bands lie round the middle, within the lamp; an edge has a standard error of 0.02 pixels.
const COVERED: &[Check] = &[
    check("width", Measure::Covered(area(0.0, 1.0, 0.46, 0.54), Axis::X), Expected::Formula(|| 0.5 * scale(64.0)), BY),
    check(
        "height",
        Measure::Covered(area(0.46, 0.54, 0.0, 1.0), Axis::Y),
        Expected::Formula(|| 0.25 * scale(64.0)),
        BY,
    ),
];

/// In one 32 pixels wide.
const COVERED_NARROW: &[Check] = &[
    check("width", Measure::Covered(area(0.0, 1.0, 0.46, 0.54), Axis::X), Expected::Formula(|| 0.5 * scale(32.0)), BY),
    check(
        "height",
        Measure::Covered(area(0.46, 0.54, 0.0, 1.0), Axis::Y),
        Expected::Formula(|| 0.25 * scale(32.0)),
        BY,
    ),
];

const BY: Tolerance = Tolerance::Plain(0.15);

const QUARTERS: &[Check] = &[
    check("upper left", Measure::Mean(area(0.0, 0.5, 0.0, 0.5), Channel::All), Expected::Number(1.0), TENTH),
    check("upper right", Measure::Mean(area(0.5, 1.0, 0.0, 0.5), Channel::All), Expected::Number(2.0), TENTH),
    check("lower left", Measure::Mean(area(0.0, 0.5, 0.5, 1.0), Channel::All), Expected::Number(4.0), TENTH),
    check("lower right", Measure::Mean(area(0.5, 1.0, 0.5, 1.0), Channel::All), Expected::Number(8.0), TENTH),
    check("shift across", Measure::Shift(Axis::X), Expected::Number(0.0), EXACT),
    check("shift down", Measure::Shift(Axis::Y), Expected::Number(0.0), EXACT),
];

/// A twentieth of a row moves the mean of 24 rows by that at least.
const TENTH: Tolerance = Tolerance::Share(1e-3);

/// The middle of the lamp on an axis, in the image of `handedness`.
fn seen(axis: usize) -> (f64, f64) {
    let camera = Camera {
        name: None,
        eye: [4.0, -3.0, 2.0],
        target: [0.0; 3],
        up: [0.0, 0.0, 1.0],
        fov_x: 40.0,
        near: None,
        far: None,
    };
    let mut point = [0.0; 3];
    point[axis] = 1.0;
    projected(&camera, (64, 64), point)
}

/// One of 16 columns.
const fn column(at: usize) -> Measure {
    let Region { x: _, y } = Region::ALL;
    Measure::Mean(Region { x: (at as f64 / 16.0, (at as f64 + 1.0) / 16.0), y }, Channel::All)
}
