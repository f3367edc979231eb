//! Conventions of the camera and the film.

use ltsc_core::capability::Feature;
use ltsc_core::ir::Camera;

use super::super::formula::{box_edge, gaussian_edge, projected};
use super::super::kinds::{
    Axis, By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
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
    convention!(
        "gaussian_filter",
        &[Feature::GaussianFilter],
        &[
            View { name: "stddev 0.3", set: &[("stddev", "0.3")], ..View::plain(gaussian!(0.3)) },
            View { name: "stddev 0.5", set: &[("stddev", "0.5")], ..View::plain(gaussian!(0.5)) },
            View { name: "stddev 1", set: &[("stddev", "1")], ..View::plain(gaussian!(1.0)) },
            View { name: "stddev 2", set: &[("stddev", "2")], ..View::plain(gaussian!(2.0)) },
            // Fewer rows: pbrt-r4 adds each sample to 625 pixels, ten minutes for all of them.
            View { name: "stddev 3", set: &[("stddev", "3")], size: Some((32, 8)), ..View::plain(gaussian!(3.0)) },
        ]
    ),
    convention!(
        "cut_gaussian_filter",
        &[Feature::CutGaussianFilter],
        &[
            View { name: "at 1", set: &[("radius", "1")], ..View::plain(cut!(1.0)) },
            View { name: "at 2", set: &[("radius", "2")], ..View::plain(cut!(2.0)) },
            View { name: "at 3", set: &[("radius", "3")], ..View::plain(cut!(3.0)) },
        ]
    ),
    convention!(
        "box_filter",
        &[Feature::BoxFilter],
        &[
            View { name: "radius 1", set: &[("radius", "1")], ..View::plain(boxed!(1.0)) },
            View { name: "radius 1.5", set: &[("radius", "1.5")], ..View::plain(boxed!(1.5)) },
            View { name: "radius 3", set: &[("radius", "3")], ..View::plain(boxed!(3.0)) },
        ]
    ),
];

/// Columns round the edge of a lamp, which lies a quarter of a pixel into the column 16 of 32.
macro_rules! edge {
    ($shown:path $(, $number:expr)*; $feature:expr, $known:expr) => {
        &[
            Check {
                known: $known,
                rests_on: $feature,
                ..check("two columns before the edge", lane(14), Expected::Formula(|| $shown($($number,)* 1.75)), STEP)
            },
            Check {
                known: $known,
                rests_on: $feature,
                ..check("column before the edge", lane(15), Expected::Formula(|| $shown($($number,)* 0.75)), STEP)
            },
            Check {
                known: $known,
                rests_on: $feature,
                ..check("column of the edge", lane(16), Expected::Formula(|| $shown($($number,)* -0.25)), STEP)
            },
            Check {
                known: $known,
                rests_on: $feature,
                ..check("column behind the edge", lane(17), Expected::Formula(|| $shown($($number,)* -1.25)), STEP)
            },
        ]
    };
}
use edge;

macro_rules! gaussian {
    ($stddev:literal) => {
        edge!(gaussian_edge, $stddev, 4.0 * $stddev; &[Feature::GaussianFilter], WIDEST)
    };
}
use gaussian;

macro_rules! cut {
    ($radius:literal) => {
        edge!(gaussian_edge, 1.0, $radius; &[Feature::GaussianFilter, Feature::CutGaussianFilter], UNCUT)
    };
}
use cut;

macro_rules! boxed {
    ($radius:literal) => {
        edge!(box_edge, $radius; &[Feature::BoxFilter], &[])
    };
}
use boxed;

/// The table of Mitsuba, 0.0082, and four standard errors of 65 000 samples.
const STEP: Tolerance = Tolerance::Plain(0.016);

const WIDEST: &[Known] = &[
    Known {
        target: Some("cycles"),
        by: By::Feature(Feature::GaussianFilter, "0.043 for 3"),
        within: Within::Distance(0.047),
    },
    PORT,
];

/// PBRT's port of version 3 with its own table.
const PORT: Known = Known {
    target: Some("pbrt-v3"),
    by: By::Feature(Feature::GaussianFilter, "the port pbrt-r3 3.2.0 0.055 for a `stddev` of 0.3"),
    within: Within::Distance(0.058),
};

const UNCUT: &[Known] = &[
    Known {
        target: Some("cycles"),
        by: By::Feature(Feature::CutGaussianFilter, "0.19 at 1"),
        within: Within::Distance(0.2),
    },
    Known {
        target: Some("mitsuba-3"),
        by: By::Feature(Feature::CutGaussianFilter, "0.20 at 1"),
        within: Within::Distance(0.21),
    },
    Known {
        target: Some("mitsuba-0.6"),
        by: By::Feature(Feature::CutGaussianFilter, "0.20 at 1"),
        within: Within::Distance(0.21),
    },
    Known {
        target: Some("mitsuba-0.5"),
        by: By::Feature(Feature::CutGaussianFilter, "0.20 at 1"),
        within: Within::Distance(0.21),
    },
];

/// One of 32 columns.
const fn lane(at: usize) -> Measure {
    let Region { x: _, y } = Region::ALL;
    Measure::Mean(Region { x: (at as f64 / 32.0, (at as f64 + 1.0) / 32.0), y }, Channel::All)
}

const EXACT: Tolerance = Tolerance::Plain(1e-3);

/// What lies before the planes is seen instead, of radiance 7.
const fn unclipped(target: &'static str) -> Known {
    let by = By::Feature(Feature::ClippingPlanes, "exact where every surface lies between them");
    Known { target: Some(target), by, within: Within::Distance(7.01) }
}

const UNCLIPPED: &[Known] = &[unclipped("pbrt-v4"), unclipped("pbrt-v3")];

const fn clipped(name: &'static str, region: Region, radiance: f64) -> Check {
    Check {
        rests_on: &[Feature::ClippingPlanes],
        known: UNCLIPPED,
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
