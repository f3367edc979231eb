//! Colours: a type that can grow; nothing outside it assumes three channels.

/// A reflectance, a radiance, or a spectral quantity such as an index of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    /// The same at every wavelength.
    Grey(f64),
    /// Linear red, green and blue with sRGB primaries.
    Rgb([f64; 3]),
}

impl Color {
    /// Black.
    pub const BLACK: Self = Self::Grey(0.0);

    /// Linear red, green and blue.
    pub fn rgb(&self) -> [f64; 3] {
        match *self {
            Self::Grey(value) => [value; 3],
            Self::Rgb(rgb) => rgb,
        }
    }

    /// The largest channel.
    pub fn max(&self) -> f64 {
        let [r, g, b] = self.rgb();
        r.max(g).max(b)
    }

    /// The smallest channel.
    pub fn min(&self) -> f64 {
        let [r, g, b] = self.rgb();
        r.min(g).min(b)
    }

    /// Whether every channel is 0.
    pub fn is_black(&self) -> bool {
        self.rgb() == [0.0; 3]
    }

    /// Whether all channels are equal.
    pub fn is_grey(&self) -> bool {
        let [r, g, b] = self.rgb();
        r == g && g == b
    }
}
