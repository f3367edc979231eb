//! Colors given as values at wavelengths.

use std::sync::Arc;

use super::cie;

/// What a spectrum says, which decides how it becomes RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A share of light, as a reflectance: its color in D65, so that a constant is a grey.
    Share,
    /// Light itself: its own color; 1 at every wavelength has the luminance of (1, 1, 1).
    Light,
    /// An index of refraction or of extinction: as a share, but never beyond its own values.
    Index,
}

/// Values at wavelengths, linear between them and constant beyond. Cheap to clone.
///
/// Spelling: PBRT v4 `spectrum`; every other target has RGB, and gets [`Spectrum::rgb`].
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    points: Arc<[(f64, f64)]>,
    /// Before it is cut to what can be written.
    exact: [f64; 3],
    rgb: [f64; 3],
}

impl Spectrum {
    /// Of `points` (wavelength in nm, value), of which there are some and whose wavelengths grow.
    pub fn new(points: &[(f64, f64)], meaning: Meaning) -> Self {
        let value = |wavelength: f64| value_at(points, wavelength);
        let exact = match meaning {
            Meaning::Share | Meaning::Index => cie::reflected(value),
            Meaning::Light => cie::emitted(value),
        };
        let values = || points.iter().map(|(_, value)| *value);
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let rgb = exact.map(|channel| match meaning {
            Meaning::Share if high <= 1.0 => channel.clamp(0.0, 1.0),
            Meaning::Share | Meaning::Light => channel.max(0.0),
            Meaning::Index => channel.max(low).min(high),
        });
        Self { points: points.into(), exact, rgb }
    }

    /// Wavelengths in nm with their values.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// The value at a wavelength in nm.
    pub fn value(&self, wavelength: f64) -> f64 {
        value_at(&self.points, wavelength)
    }

    /// Linear sRGB, cut to what can be written: no negative channel, and none of a reflectance above 1.
    pub fn rgb(&self) -> [f64; 3] {
        self.rgb
    }

    /// Linear sRGB before it is cut.
    pub fn exact_rgb(&self) -> [f64; 3] {
        self.exact
    }

    /// The luminance as light, that of 1 at every wavelength being 1.
    pub fn luminance(&self) -> f64 {
        cie::luminance(|wavelength| value_at(&self.points, wavelength))
    }
}

/// Linear between the points, constant beyond.
fn value_at(points: &[(f64, f64)], wavelength: f64) -> f64 {
    let above = points.partition_point(|(known, _)| *known <= wavelength);
    match (above.checked_sub(1).and_then(|below| points.get(below)), points.get(above)) {
        (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * (wavelength - x0) / (x1 - x0),
        (Some((_, only)), None) | (None, Some((_, only))) => *only,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_on_lines() {
        let points = [(400.0, 0.1), (500.0, 0.3), (700.0, 0.1)];
        for (wavelength, value) in [(100.0, 0.1), (400.0, 0.1), (450.0, 0.2), (500.0, 0.3), (600.0, 0.2), (900.0, 0.1)]
        {
            assert!((value_at(&points, wavelength) - value).abs() < 1e-12, "{wavelength}");
        }
    }

    #[test]
    fn meanings_differ() {
        let flat = [(400.0, 0.5), (700.0, 0.5)];
        let share = Spectrum::new(&flat, Meaning::Share);
        assert!(share.rgb().iter().all(|channel| (channel - 0.5).abs() < 1e-12));
        let [r, g, b] = Spectrum::new(&flat, Meaning::Light).rgb();
        assert!(r > 0.59 && g < 0.48 && b < 0.46);
        assert!((share.luminance() - 0.5).abs() < 1e-12);
        // A narrow line of green lies outside of sRGB, with red and blue below 0.
        let green = [(510.0, 0.0), (520.0, 1.0), (530.0, 0.0)];
        let spectrum = Spectrum::new(&green, Meaning::Share);
        assert!(spectrum.exact_rgb()[0] < 0.0 && spectrum.rgb()[0] == 0.0 && spectrum.rgb()[1] > 0.0);
        let index = Spectrum::new(&[(510.0, 1.0), (520.0, 2.0), (530.0, 1.0)], Meaning::Index);
        assert!(index.rgb().iter().all(|channel| (1.0..=2.0).contains(channel)));
    }
}
