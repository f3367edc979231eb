//! The conventions of Blender for numbers and names.

use crate::formats::shared::images::{self, Form, Use};
use crate::ir::{Encoding, Texture};

/// What Blender does with an image: it decodes codes of sRGB after it interpolated between them (4.5: a black and a white pixel give
/// 0.21 between them instead of 0.5), so that it gets decoded ones.
pub fn images(texture: &Texture, purpose: Use) -> Form {
    match (purpose, texture.encoding) {
        (Use::Surface, Encoding::Srgb) => images::on_surface(texture, Form::Decoded),
        (Use::Surface, Encoding::Linear) => images::on_surface(texture, Form::Shared),
        (Use::Sky(_), _) => Form::Shared,
    }
}

/// Clipping distances that a file gets where the scene gives none and nothing lies outside of them.
pub const DEFAULT_CLIPPING: (f64, f64) = (1e-3, 1e6);

/// Text as a literal of Python.
pub fn literal(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            ' '..='~' => quoted.push(character),
            other => quoted.push_str(&format!("\\U{:08x}", u32::from(other))),
        }
    }
    quoted.push('"');
    quoted
}

/// `filter_width` of a Gaussian. Blender hands three times its number to Cycles, which draws exp(-2 (6 x / width)^2) (`film.cpp`); edges
/// of lamps are as wide as that with 4.5.15.
pub fn gaussian_width(stddev: f64) -> f64 {
    4.0 * stddev
}

/// Blender's least and largest `filter_width`.
pub const FILTER_WIDTHS: (f64, f64) = (0.01, 10.0);

/// The standard deviation of the Gaussian that a `filter_width` asks for: where 2 (6 x / (3 width))^2 is 1/2.
pub fn stddev(width: f64) -> f64 {
    3.0 * width / 12.0
}

/// How much of a spot's cone fades in Blender, from 0 to 1, for the half angles in degrees at which the light ends and
/// begins to fade. Blender compares cosines: it fades from `cos angle + blend (1 - cos angle)` down to `cos angle`.
pub fn spot_blend(angle: f64, inner: f64) -> f64 {
    // Cycles: spotsmooth = (1 - cos a) * blend, fading between cos a and cos a + spotsmooth (`light.cpp`).
    let (outer, inner) = (libm::cos(angle.to_radians()), libm::cos(inner.to_radians()));
    if outer < 1.0 { ((inner - outer) / (1.0 - outer)).clamp(0.0, 1.0) } else { 0.0 }
}

/// The half angle at which a spot begins to fade, of its `angle` and its `blend`: the inverse of [`spot_blend`].
pub fn spot_inner(angle: f64, blend: f64) -> f64 {
    let outer = libm::cos(angle.to_radians());
    libm::acos((outer + blend * (1.0 - outer)).clamp(-1.0, 1.0)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_quotes() {
        assert_eq!(literal("a\"b\\c\n\u{e9}"), "\"a\\\"b\\\\c\\U0000000a\\U000000e9\"");
    }

    #[test]
    fn a_gaussian_is_drawn_as_wide_as_it_is_asked_for() {
        for wanted in [0.3, 0.5, 1.0, 2.0] {
            let at = |x: f64| 6.0 * x / (3.0 * gaussian_width(wanted));
            let drawn = |x: f64| libm::exp(-2.0 * at(x) * at(x));
            assert!((drawn(wanted) - libm::exp(-0.5)).abs() < 1e-12, "{wanted}");
            assert!((stddev(gaussian_width(wanted)) - wanted).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sharp_spot_fades_nowhere_and_a_soft_one_everywhere() {
        assert_eq!(spot_blend(30.0, 30.0), 0.0);
        assert_eq!(spot_blend(30.0, 0.0), 1.0);
        assert_eq!(spot_blend(0.0, 0.0), 0.0);
        for inner in [0.0, 10.0, 29.0] {
            assert!((spot_inner(30.0, spot_blend(30.0, inner)) - inner).abs() < 1e-5);
        }
    }
}
