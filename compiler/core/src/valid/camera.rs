//! Cameras: at least one, each with a direction, an upward direction, an opening and a depth range.

use crate::diag::Finding;
use crate::ir::{Camera, Scene, cross, length, normalized, sub};

use super::{LARGEST, fits};

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    if scene.cameras.is_empty() {
        findings.push(
            Finding::error("invalid-scene", scene.origin.clone(), "the scene has no camera")
                .help("add `camera = perspective(eye: (...), target: (...), fov_x: 45deg)`"),
        );
    }
    for (handle, camera) in scene.cameras.iter() {
        faults(camera, |message, help| {
            let message = match &camera.name {
                Some(name) => format!("camera `{}`: {message}", name.escape_debug()),
                None => format!("the camera: {message}"),
            };
            findings.push(Finding::error("invalid-camera", scene.cameras.origin(handle).clone(), message).help(help));
        });
    }
}

fn faults(camera: &Camera, mut add: impl FnMut(&str, &str)) {
    let Camera { name: _, eye, target, up, fov_x, near, far } = camera;
    let finite = |vector: &[f64; 3]| vector.iter().all(|x| fits(*x));
    if !(finite(eye) && finite(target) && finite(up)) {
        add("`eye`, `target` or `up` is not finite, or beyond 1e30", "give smaller coordinates");
    } else {
        match (normalized(sub(*target, *eye)), normalized(*up)) {
            (None, _) => add("`eye` and `target` are the same point", "move the target along the viewing direction"),
            (_, None) => add("`up` has length 0", "write `up: Z`"),
            // A thousandth of a degree: below it the image's orientation is rounding error in single precision.
            (Some(forward), Some(up)) if length(cross(forward, up)) < 1.7e-5 => {
                add("`up` is parallel to the viewing direction", "choose another `up`, for example `up: Y`");
            }
            (Some(_), Some(_)) => {}
        }
    }
    if !(*fov_x > 0.0 && *fov_x < 180.0) {
        add(&format!("`fov_x` is {fov_x} degrees"), "the angle of view lies between 0 and 180 degrees");
    }
    for (name, plane) in [("near", near), ("far", far)] {
        if let Some(distance) = plane
            && !(*distance >= 1.0 / LARGEST && fits(*distance))
        {
            add(&format!("`{name}` is {distance}"), "clipping distances lie between 1e-30 and 1e30");
        }
    }
    if let (Some(near), Some(far)) = (near, far)
        && near >= far
    {
        add(&format!("`near` ({near}) is not below `far` ({far})"), "`near` must be the smaller distance");
    }
}
