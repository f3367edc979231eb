//! Film, integrator, sampler.

use crate::diag::Finding;
use crate::ir::{Film, Filter, Scene};

/// The longest side of an image. A square of this side has 48 GiB of RGB floats: more is a slip of the keyboard.
const MAX_SIDE: u32 = 65_536;

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    let mut add = |id, message: String, help: &str| {
        findings.push(Finding::error(id, scene.origin.clone(), message).help(help));
    };
    let Film { width, height, filter } = &scene.film;
    for (name, side) in [("width", *width), ("height", *height)] {
        if !(1..=MAX_SIDE).contains(&side) {
            let message = format!("the {name} of the film is {side} pixels");
            add("invalid-film", message, &format!("write a number from 1 to {MAX_SIDE}"));
        }
    }
    // Wider or narrower filters leave the tables and the single precision of renderers.
    let positive = |x: f64| (1e-3..=1e3).contains(&x);
    match *filter {
        Filter::Box { radius } => {
            if !positive(radius) {
                add(
                    "invalid-film",
                    format!("the radius of the box filter is {radius}"),
                    "write a number of pixels from 0.001 to 1000",
                );
            }
        }
        Filter::Gaussian { stddev, radius } => {
            if !positive(stddev) || !positive(radius) {
                let message = format!("the Gaussian filter has standard deviation {stddev} and radius {radius}");
                add("invalid-film", message, "write numbers of pixels from 0.001 to 1000");
            }
        }
    }
    if scene.integrator.max_depth() == 0 {
        let message = "`max_depth` is 0, no path has 0 segments".to_owned();
        add("invalid-integrator", message, "write at least 1, which shows emitters seen directly");
    }
    if scene.sampler.samples() == 0 {
        add("invalid-sampler", "the sampler takes 0 samples".to_owned(), "write at least 1");
    }
}
