//! Rule `odd-field-of-view`: a camera has the view of a camera.
#![doc = include_str!("odd_field_of_view.md")]

use std::f64::consts::PI;

use super::{Level, Report, Rule, Subject, called};

pub(super) const RULE: Rule = Rule {
    id: "odd-field-of-view",
    level: Level::Warn,
    summary: "A camera's angle of view is below 3.2 or above 150 degrees.",
    doc: include_str!("odd_field_of_view.md"),
    targets: &[],
    check,
};

/// The smallest angle of view along the width in degrees: every angle that was meant in radians is smaller, and a lens of 600 mm
/// before a film 36 mm wide has 3.4.
const LEAST: f64 = 3.2;

/// The largest: at its edge a length is drawn 1 / cos^2(75 deg) = 15 times as long as in the middle.
const MOST: f64 = 150.0;

/// Below this an angle in degrees was hardly meant in radians: it would be less than 6 degrees.
const LEAST_RADIANS: f64 = 0.1;

fn check(subject: &Subject<'_>, report: &mut Report) {
    for (origin, camera) in subject.scene.cameras.entries() {
        let degrees = camera.fov_x;
        if (LEAST..=MOST).contains(&degrees) {
            continue;
        }
        let help = if (LEAST_RADIANS..PI).contains(&degrees) {
            format!(
                "if that was meant in radians, write `{}rad` ({} degrees)",
                short(degrees),
                short(degrees.to_degrees())
            )
        } else if degrees < LEAST {
            format!("write an angle of at least {LEAST} degrees, and move the camera nearer")
        } else {
            format!("write an angle of at most {MOST} degrees, and move the camera back")
        };
        report.add(
            origin,
            format!("{} sees {} degrees along the image's width", called(camera), short(degrees)),
            "this camera",
            "Mitsuba, PBRT and LuxCore take degrees, Blender and glTF radians: such an angle is most often one in the other unit",
            help,
        );
    }
}

/// Three digits behind the point.
fn short(degrees: f64) -> f64 {
    (degrees * 1e3).round() / 1e3
}
