//! Colors: a gray, linear red, green and blue, or a spectrum.

use super::{Meaning, Spectrum};

/// A reflectance, a radiance, or a spectral quantity such as an index of refraction.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// The same at every wavelength.
    Grey(f64),
    /// Linear red, green and blue with sRGB primaries.
    Rgb([f64; 3]),
    /// Values at wavelengths.
    Spectrum(Spectrum),
}

impl Color {
    /// Black.
    pub const BLACK: Self = Self::Grey(0.0);

    /// Linear red, green and blue.
    pub fn rgb(&self) -> [f64; 3] {
        match self {
            Self::Grey(value) => [*value; 3],
            Self::Rgb(rgb) => *rgb,
            Self::Spectrum(spectrum) => spectrum.rgb(),
        }
    }

    /// The largest channel, or value at a wavelength.
    pub fn max(&self) -> f64 {
        self.values().into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The smallest channel, or value at a wavelength.
    pub fn min(&self) -> f64 {
        self.values().into_iter().fold(f64::INFINITY, f64::min)
    }

    fn values(&self) -> Vec<f64> {
        match self {
            Self::Grey(value) => vec![*value],
            Self::Rgb(rgb) => rgb.to_vec(),
            Self::Spectrum(spectrum) => spectrum.points().iter().map(|(_, value)| *value).collect(),
        }
    }

    /// The same for what it stands for: a spectrum becomes RGB in one way where it is light, and in another where it is not.
    #[must_use]
    pub fn meant(self, meaning: Meaning) -> Self {
        match self {
            Self::Spectrum(spectrum) => Self::Spectrum(Spectrum::new(spectrum.points(), meaning)),
            other @ (Self::Grey(_) | Self::Rgb(_)) => other,
        }
    }

    /// Light by a factor brighter.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Grey(value) => Self::Grey(value * factor),
            Self::Rgb(rgb) => Self::Rgb(rgb.map(|value| value * factor)),
            Self::Spectrum(spectrum) => {
                let points: Vec<_> = spectrum.points().iter().map(|(at, value)| (*at, value * factor)).collect();
                Self::Spectrum(Spectrum::new(&points, Meaning::Light))
            }
        }
    }

    /// Its spectrum, if it is one.
    pub fn spectrum(&self) -> Option<&Spectrum> {
        match self {
            Self::Spectrum(spectrum) => Some(spectrum),
            Self::Grey(_) | Self::Rgb(_) => None,
        }
    }

    /// Whether every channel is 0, or the value at every wavelength.
    pub fn is_black(&self) -> bool {
        self.values().iter().all(|value| *value == 0.0)
    }

    /// Whether all channels are equal.
    pub fn is_grey(&self) -> bool {
        let [r, g, b] = self.rgb();
        r == g && g == b
    }
}
