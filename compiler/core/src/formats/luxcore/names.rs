//! The vocabulary of LuxCore's scene description language and its conventions for numbers.
//!
//! Measured with pyluxcore 2.11.2 where it says so, else read in LuxCore's source (`src/slg/scene/parse*.cpp`).

use crate::formats::shared::coat;
use crate::ir::{Affine, Camera, Encoding, Film};

/// The screen window that goes with a `fieldofview` along the image's width: `left right bottom top`.
///
/// The field of view spans the window's width of 2. The window is moved down by the height of one row of pixels,
/// because the image otherwise lies exactly one row too low (`perspective.cpp` takes `height - y - 1` of a continuous
/// y). Measured with 2.11.2 against Mitsuba 3.9.1: with this window the best shift of a Cornell box is (0, 0) at 1:1,
/// 2:1 and 1:2.
pub fn screen_window(film: &Film) -> [f64; 4] {
    let Film { width, height, filter: _ } = film;
    let half = f64::from(*height) / f64::from(*width);
    let row = 2.0 * half / f64::from(*height);
    [-1.0, 1.0, -half - row, half - row]
}

/// `path.pathdepth.total` counts segments as the Scene does (measured: 2, 3, 4 against Mitsuba's 2, 3, 4), but 1 gives
/// the same as 2: emission alone cannot be asked for.
pub fn depth(segments: u32) -> u32 {
    segments.max(2)
}

/// `renderengine.seed` is at least 1 (0 is raised to 1), so the Scene's seeds move up by one.
pub fn seed(seed: u32) -> u32 {
    seed.wrapping_add(1).max(1)
}

/// The Gaussian is `exp(-alpha x^2) - exp(-alpha r^2)` with alpha = 1 / (2 stddev^2).
pub fn gaussian_alpha(stddev: f64) -> f64 {
    1.0 / (2.0 * stddev * stddev)
}

/// Clipping distances in force where a file gives none: `cliphither` and `clipyon`.
pub const DEFAULT_CLIPPING: (f64, f64) = (1e-3, 1e30);

/// The least distance from a surface at which rays start and end, `scene.epsilon.min`; none where LuxCore's own 1e-5 will do.
///
/// LuxCore starts shadow rays 128 units in the last place of a point's largest coordinate away from it. A point near the origin that a
/// camera sees from far away is known less well than that: with 2.11.2 a diffuse plate within 3 units of the origin, seen from 100
/// units, shadows itself by 0.9 %, from 400 by 11 % straight on and 37 % tilted by 3 degrees; with four units in the last place of the
/// camera's largest coordinate (1e-4 for 400) it has the radiance of the formula.
pub fn least_distance(camera: &Camera) -> Option<f64> {
    let far = camera.eye.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
    let needed = far * 4.0 * f64::from(f32::EPSILON) / 2.0;
    (needed > DEFAULT_LEAST_DISTANCE).then_some(needed)
}

/// `scene.epsilon.min` where a file gives none.
const DEFAULT_LEAST_DISTANCE: f64 = 1e-5;

/// The gain of a point light: LuxCore spreads color times gain over the whole sphere of directions, 4 pi steradians
/// (`pointlight.cpp`; measured with 2.11.2), where the Scene counts what goes into each steradian.
pub const POINT_GAIN: f64 = 4.0 * std::f64::consts::PI;

/// Properties that decode an image. LuxCore's own way is a power, and 2.2 instead of the sRGB curve is 1.7 % too much for a code of
/// 128 and 31 % too little for 30 (measured with 2.11.2); [`SRGB_CONFIG`] is the curve itself.
pub fn decoding(encoding: Encoding) -> &'static [(&'static str, &'static str)] {
    match encoding {
        Encoding::Srgb => &[
            ("colorspace", "\"opencolorio\""),
            ("colorspace.config", "\"srgb.ocio\""),
            ("colorspace.name", "\"srgb\""),
        ],
        Encoding::Linear => &[("gamma", "1")],
    }
}

/// The file that says what sRGB is, for OpenColorIO within LuxCore; looked up in the folder where LuxCore is started.
pub const SRGB_FILE: &str = "srgb.ocio";

/// Its contents: the curve of IEC 61966-2-1, and the scene's own linear values.
pub const SRGB_CONFIG: &str = "\
ocio_profile_version: 2
roles:
  default: linear
  scene_linear: linear
displays:
  none:
    - !<View> {name: none, colorspace: linear}
colorspaces:
  - !<ColorSpace>
    name: linear
  - !<ColorSpace>
    name: srgb
    to_scene_reference: !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: forward}
";

/// `specular` of `disney`: the reflectance head-on is 0.08 times this, and it is at most 1 (`disney.cpp`).
pub fn specular(ior: f64) -> f64 {
    (coat::normal_reflectance(ior) / 0.08).min(1.0)
}

/// From the directions of `infinite` to the Scene's: the image's middle is its -x, and a quarter to the right of that its -y (measured
/// with 2.11.2).
pub const ENVIRONMENT: Affine = Affine { rows: [[0.0, -1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

/// Settings that every scene has, with the reason of each.
pub const FIXED: &[(&str, &str)] = &[
    ("renderengine.type", "\"PATHCPU\""),
    // Linear radiance reaches the output unchanged.
    ("film.imagepipelines.0.0.type", "\"NOP\""),
    // Russian roulette with a cap below 1 enters the multiple importance weights of direct light on one side only and
    // adds energy where many lights compete: 1.9 % on 729 lights with the default of 0.5 (measured; `pathtracer.cpp`).
    ("path.russianroulette.cap", "1"),
    ("path.clamping.variance.maxvalue", "0"),
    ("path.hybridbackforward.enable", "0"),
    // The choice of lights by power; LuxCore's default is a logarithm of it.
    ("lightstrategy.type", "\"POWER\""),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Filter;

    #[test]
    fn the_window_is_moved_by_one_row() {
        let window = |width, height| screen_window(&Film { width, height, filter: Filter::Box { radius: 0.5 } });
        // 2:1: half is 0.5, a row 1/100; 1:1: half is 1, a row 2/100; 1:2: half is 2, a row 4/200.
        let close = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(window(200, 100), [-1.0, 1.0, -0.51, 0.49]));
        assert!(close(window(100, 100), [-1.0, 1.0, -1.02, 0.98]));
        assert!(close(window(100, 200), [-1.0, 1.0, -2.02, 1.98]));
    }

    #[test]
    fn far_cameras_ask_for_a_distance() {
        let from = |eye| {
            let target = [0.0; 3];
            Camera { name: None, eye, target, up: [0.0, 0.0, 1.0], fov_x: 45.0, near: None, far: None }
        };
        assert_eq!(least_distance(&from([0.0, -40.0, 3.0])), None);
        let needed = least_distance(&from([1.0, -400.0, 3.0])).expect("a distance");
        assert!((needed - 400.0 * f64::from(f32::EPSILON) * 2.0).abs() < 1e-12, "{needed}");
    }

    #[test]
    fn a_gaussian_is_drawn_as_wide_as_it_is_asked_for() {
        for stddev in [0.3, 0.5, 1.0, 2.0_f64] {
            let drawn = |x: f64| libm::exp(-gaussian_alpha(stddev) * x * x);
            assert!((drawn(stddev) - libm::exp(-0.5)).abs() < 1e-12, "{stddev}");
        }
    }

    #[test]
    fn depth_and_seed() {
        assert_eq!((depth(10), depth(2), depth(1)), (10, 2, 2));
        assert_eq!((seed(0), seed(7), seed(u32::MAX)), (1, 8, 1));
    }
}
