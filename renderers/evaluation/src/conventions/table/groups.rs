//! Conventions of groups, instances and shared meshes.

use ltsc_core::capability::Feature;

use super::super::formula::slab_once;
use super::super::kinds::{
    Axis, By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "instance_transform",
        &[Feature::Camera, Feature::ColoredDiffuse],
        // Pixels from the left are 32 + 8 x, from the top 32 - 8 z.
        &[View::plain(&[
            // (1, 0) -> (2, 0) -> (0, -2) -> (1.5, -1.5) in x and z.
            middle("scaled, turned, moved: across", Channel::Red, Axis::X, 44.0),
            middle("scaled, turned, moved: down", Channel::Red, Axis::Y, 44.0),
            // (1, 0) -> (2, 2).
            middle("by a matrix: across", Channel::Green, Axis::X, 48.0),
            middle("by a matrix: down", Channel::Green, Axis::Y, 16.0),
            // (1, 0) -> (-2, 2).
            middle("about a point: across", Channel::Blue, Axis::X, 16.0),
            middle("about a point: down", Channel::Blue, Axis::Y, 16.0),
        ])]
    ),
    convention!(
        "repeated_group",
        &[Feature::Instances, Feature::ColoredDiffuse],
        // Pixels from the left are 32 + 8 x, from the top 32 - 8 z.
        &[View::plain(&[
            part("scaled, left", (8.0, 16.0, 8.0, 24.0), Channel::Red, 0.8),
            part("scaled, right", (16.0, 24.0, 8.0, 24.0), Channel::Green, 0.4),
            part("mirrored, left", (44.0, 48.0, 12.0, 20.0), Channel::Green, 0.4),
            part("mirrored, right", (48.0, 52.0, 12.0, 20.0), Channel::Red, 0.8),
            part("turned, top", (44.0, 52.0, 44.0, 48.0), Channel::Green, 0.4),
            part("turned, bottom", (44.0, 52.0, 48.0, 52.0), Channel::Red, 0.8),
            part("between them", (0.0, 40.0, 28.0, 64.0), Channel::All, 0.0),
        ])]
    ),
    convention!(
        "nested_groups",
        &[Feature::Camera, Feature::ColoredDiffuse],
        &[View::plain(&[
            // (1, 0) -> (2, 0) -> (0, -2) -> (0, -1).
            middle("moved, then turned: across", Channel::Red, Axis::X, 32.0),
            middle("moved, then turned: down", Channel::Red, Axis::Y, 40.0),
            // (1, 0) -> (0, -1) -> (-2, 0) -> (-3, 0).
            middle("turned, then moved: across", Channel::Green, Axis::X, 8.0),
            middle("turned, then moved: down", Channel::Green, Axis::Y, 32.0),
        ])]
    ),
    convention!(
        "mirrored_instance",
        &[Feature::VertexNormals, Feature::SmoothDielectric],
        &[View::plain(&[
            check(
                "slab of glass",
                Measure::Mean(area(0.25, 0.75, 0.125, 0.375), Channel::All),
                Expected::Formula(|| slab_once(60.0, 1.5)),
                Tolerance::Plain(5e-3),
            ),
            check(
                "leaning normals",
                Measure::Mean(area(0.25, 0.75, 0.625, 0.875), Channel::All),
                Expected::Ideal,
                // With two lights, of which samples choose one.
                Tolerance::Share(0.02),
            ),
        ])]
    ),
    convention!(
        "emitter_in_group",
        &[Feature::BlackEmitter],
        &[View::plain(&[
            check("scaled and turned", mean(6.0, 10.0, 6.0, 10.0, 32.0), Expected::Number(2.0), Tolerance::Share(0.02)),
            check("the back of a mirrored one", mean(22.0, 26.0, 12.0, 13.0, 32.0), Expected::Number(0.0), DARK),
            check("lit by a mirrored one", mean(19.0, 27.0, 22.0, 24.0, 32.0), Expected::Ideal, Tolerance::Share(0.03)),
        ])]
    ),
    convention!(
        "shared_mesh",
        &[Feature::SharedMesh, Feature::TransformedShape, Feature::ColoredDiffuse, Feature::Diffuse],
        &[View::plain(&[
            check("moved", mean(8.0, 16.0, 8.0, 16.0, 64.0), Expected::Number(0.8), Tolerance::Share(0.025)),
            Check {
                measure: Measure::Mean(area(40.0 / 64.0, 56.0 / 64.0, 40.0 / 64.0, 56.0 / 64.0), Channel::Blue),
                ..check("scaled and turned, blue", WHOLE, Expected::Number(0.6), Tolerance::Share(0.025))
            },
            check("mirrored", mean(8.0, 16.0, 48.0, 56.0, 64.0), Expected::Number(0.5), Tolerance::Share(0.025)),
            check("lamp", mean(48.0, 56.0, 8.0, 16.0, 64.0), Expected::Number(3.0), Tolerance::Share(0.025)),
        ])]
    ),
];

const DARK: Tolerance = Tolerance::Plain(1e-4);

const WHOLE: Measure = Measure::Mean(Region::ALL, Channel::All);

const fn middle(name: &'static str, channel: Channel, axis: Axis, expected: f64) -> Check {
    Check {
        // What little of another color's light is seen in a channel lies up to 40 pixels away.
        known: &[Known {
            target: Some("pbrt-v4"),
            by: By::Feature(Feature::ColoredDiffuse, "one bounce to 0.2 % of the brightest channel"),
            within: Within::Distance(0.5),
        }],
        ..check(name, Measure::Middle(channel, axis), Expected::Number(expected), Tolerance::Plain(0.1))
    }
}

/// Columns from and to, rows from and to, of an image of 64 pixels; what is meant is a quarter of a pixel away from its neighbors.
const fn part(
    name: &'static str,
    (left, right, top, bottom): (f64, f64, f64, f64),
    channel: Channel,
    expected: f64,
) -> Check {
    let region = area(left / 64.0, right / 64.0, top / 64.0, bottom / 64.0);
    let tolerance = if expected == 0.0 { DARK } else { Tolerance::Share(0.005) };
    check(name, Measure::Mean(region, channel), Expected::Number(expected), tolerance)
}

/// Columns and rows of an image of `size` by `size` pixels.
const fn mean(left: f64, right: f64, top: f64, bottom: f64, size: f64) -> Measure {
    Measure::Mean(area(left / size, right / size, top / size, bottom / size), Channel::All)
}
