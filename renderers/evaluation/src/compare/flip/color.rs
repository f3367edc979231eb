//! Colors as FLIP sees them: opponent axes that filters work on, and differences of colors as they are perceived.

/// Linear sRGB to XYZ over that of white, so that each row adds up to 1: primaries and white (D65, 0.3127, 0.3290) of IEC 61966-2-1.
const TO_XYZ: [[f32; 3]; 3] = [
    [0.433_887_3, 0.376_224, 0.189_888_6],
    [0.212_639, 0.715_168_7, 0.072_192_3],
    [0.017_750_0, 0.109_447_6, 0.872_802_3],
];

/// The way back.
const TO_RGB: [[f32; 3]; 3] = [
    [3.080_399, -1.537_383_2, -0.543_015_9],
    [-0.921_223_4, 1.875_967_5, 0.045_255_9],
    [0.052_873_9, -0.203_977, 1.151_103],
];

/// The exponent of color differences, and the share of the largest one that is perceived as 0.95 of it (Andersson et al. 2020:
/// q_c, p_c and p_t).
const COLOR_EXPONENT: f32 = 0.7;
const BREAK: f32 = 0.4;
const BREAK_VALUE: f32 = 0.95;

// No closures here and below: a build without optimization calls each of them for each pixel and exposure.
#[inline]
fn times([a, b, c]: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z]
}

/// The luminance of a color, that of white being 1.
pub(super) fn luminance([r, g, b]: [f32; 3]) -> f32 {
    TO_XYZ[1][0] * r + TO_XYZ[1][1] * g + TO_XYZ[1][2] * b
}

/// Luminance, red against green, and blue against yellow: YCxCz without its factors and offset, which filters of sum 1 keep.
#[inline]
pub(super) fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = times(&TO_XYZ, rgb);
    [y, x - y, y - z]
}

/// CIELAB of an opponent color that is brought back into the cube of colors, a and b adjusted as Hunt found: less of them is seen
/// where it is dark (Andersson et al. 2020).
#[inline]
pub(super) fn perceived([y, red, blue]: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = times(&TO_RGB, [y + red, y, y - blue]);
    let [x, y, z] = times(&TO_XYZ, [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0)]);
    let (x, y, z) = (lightness(x), lightness(y), lightness(z));
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * (500.0 * (x - y)), 0.01 * l * (200.0 * (y - z))]
}

/// The function of CIELAB (CIE 15): a cube root above (6/29)^3, a line below.
#[inline]
fn lightness(t: f32) -> f32 {
    const LIMIT: f32 = 6.0 / 29.0;
    let line = t / (3.0 * LIMIT * LIMIT) + 4.0 / 29.0;
    let root = cube_root(t.max(LIMIT * LIMIT * LIMIT));
    if t > LIMIT * LIMIT * LIMIT { root } else { line }
}

/// The cube root of a normal positive number: a guess from its exponent, and two of Halley's steps, which leave the rounding of
/// single precision. Without a branch, so that it works on several numbers at once.
#[inline]
fn cube_root(x: f32) -> f32 {
    // A third of the exponent, and a constant that halves the largest error of the guess, 3 %.
    let mut root = f32::from_bits(x.to_bits() / 3 + 0x2a51_0800);
    let cube = root * root * root;
    root *= (cube + 2.0 * x) / (2.0 * cube + x);
    let cube = root * root * root;
    root * (cube + 2.0 * x) / (2.0 * cube + x)
}

/// The distance of two perceived colors (HyAB, Abasi et al. 2020) as far as it is not in the exponent.
#[inline]
pub(super) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2])).sqrt()
}

/// Differences of perceived colors between 0 and 1.
pub(super) struct Scale {
    /// The difference that ends the range, that of green and blue, and the one where its slope changes.
    most: f32,
    middle: f32,
}

impl Scale {
    pub(super) fn new() -> Self {
        let of = |rgb| perceived(opponent(rgb));
        let most = distance(of([0.0, 1.0, 0.0]), of([0.0, 0.0, 1.0])).powf(COLOR_EXPONENT);
        Self { most, middle: BREAK * most }
    }

    /// The difference of two colors at this distance.
    #[inline]
    pub(super) fn difference(&self, distance: f32) -> f32 {
        let raised = distance.powf(COLOR_EXPONENT);
        if raised < self.middle {
            raised * (BREAK_VALUE / self.middle)
        } else {
            (BREAK_VALUE + (raised - self.middle) / (self.most - self.middle) * (1.0 - BREAK_VALUE)).min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_undo_each_other_and_keep_white() {
        for (axis, color) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
            let back = times(&TO_RGB, times(&TO_XYZ, color));
            for channel in 0..3 {
                let wanted = if channel == axis { 1.0 } else { 0.0 };
                assert!((back[channel] - wanted).abs() < 1e-5, "{axis}: {back:?}");
            }
        }
        let white = perceived(opponent([1.0; 3]));
        assert!((white[0] - 100.0).abs() < 1e-3 && white[1].abs() < 1e-2 && white[2].abs() < 1e-2, "{white:?}");
        assert!(perceived(opponent([0.0; 3])).iter().all(|value| value.abs() < 1e-4));
    }

    #[test]
    fn cube_roots_are_exact_to_single_precision() {
        for step in 0..10_000 {
            let x = 0.008_f32 * 1.0005_f32.powi(step);
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 3e-7, "{x}: {} for {}", cube_root(x), x.cbrt());
        }
    }

    #[test]
    fn the_scale_ends_at_its_ends_and_is_continuous() {
        let scale = Scale::new();
        let of = |rgb| perceived(opponent(rgb));
        let (green, blue) = (of([0.0, 1.0, 0.0]), of([0.0, 0.0, 1.0]));
        assert_eq!(scale.difference(0.0), 0.0);
        assert!((scale.difference(distance(green, blue)) - 1.0).abs() < 1e-6);
        let at = |raised: f32| scale.difference(raised.powf(1.0 / COLOR_EXPONENT));
        assert!((at(scale.middle * 0.9999) - BREAK_VALUE).abs() < 1e-3);
        assert!((at(scale.middle * 1.0001) - BREAK_VALUE).abs() < 1e-3);
    }
}
