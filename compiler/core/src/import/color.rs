//! Colors as all importers need them: what they are for, what of them can be, and light of black bodies.

use super::reader::{Fate, Reader};
use crate::diag::Span;
use crate::ir::{Color, Meaning, Spectrum};

/// What a color is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// A share of light: from 0 to 1, what lies outside is cut with a finding.
    Share,
    /// Radiance, intensity, irradiance: not below 0.
    Light,
    /// An index of refraction or extinction: not below 0.
    Index,
}

impl Use {
    /// What a spectrum of this use says.
    pub fn meaning(self) -> Meaning {
        match self {
            Self::Share => Meaning::Share,
            Self::Light => Meaning::Light,
            Self::Index => Meaning::Index,
        }
    }
}

/// No color is brighter, so that its numbers stay finite in single precision.
pub(super) const BRIGHTEST: f64 = 1e28;

/// A color without what lies outside of what one of this use can be.
pub fn cut(color: Color, use_of: Use, at: Span, reader: &mut Reader<'_>) -> Color {
    let most = if use_of == Use::Share { 1.0 } else { BRIGHTEST };
    if color.min() >= 0.0 && color.max() <= most {
        return color;
    }
    let what = match use_of {
        Use::Share => "a share of light beyond 0 to 1 is cut",
        Use::Light | Use::Index if color.min() < 0.0 => "a color below 0 is cut",
        Use::Light | Use::Index => "a color beyond 1e28 is cut",
    };
    reader.lost(Fate::Approximated, at, what);
    let within = |value: f64| value.max(0.0).min(most);
    match color {
        Color::Grey(grey) => Color::Grey(within(grey)),
        Color::Rgb(rgb) => Color::Rgb(rgb.map(within)),
        Color::Spectrum(spectrum) => {
            let points: Vec<(f64, f64)> = spectrum.points().iter().map(|(at, value)| (*at, within(*value))).collect();
            Color::Spectrum(Spectrum::new(&points, use_of.meaning()))
        }
    }
}

/// Grey where all three are equal.
pub fn of_rgb(rgb: [f64; 3]) -> Color {
    if rgb[0] == rgb[1] && rgb[1] == rgb[2] { Color::Grey(rgb[0]) } else { Color::Rgb(rgb) }
}

/// The temperatures in kelvin that a black body may have.
pub const KELVIN: std::ops::RangeInclusive<f64> = 100.0..=1e6;

/// The radiance of a black body at a wavelength in nm, in W/(m2 sr nm): Planck's law with the constants of CODATA 2018.
pub fn planck(kelvin: f64, nanometers: f64) -> f64 {
    let length = nanometers * 1e-9;
    let squared = length * length;
    let exponent = 1.438_776_877e-2 / (length * kelvin);
    1e-9 * 1.191_042_972e-16 / (squared * squared * length * libm::expm1(exponent))
}

/// The light of a black body times a factor, each 10 nm from 360 to 830.
pub fn black_body(kelvin: f64, factor: f64) -> Spectrum {
    let points = (0..=47).map(|at| 360.0 + 10.0 * f64::from(at)).map(|at| (at, factor * planck(kelvin, at)));
    Spectrum::new(&points.collect::<Vec<(f64, f64)>>(), Meaning::Light)
}
