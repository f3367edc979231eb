//! Pixels of an image in memory, as numbers, and how they become linear.

use std::sync::OnceLock;

use crate::ir::Encoding;

/// Pixels from the upper left corner on, row by row, as the file has them: before any decoding, 0..1 for whole numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 (grey) or 3 (red, green, blue).
    pub channels: usize,
    /// `width * height * channels` numbers.
    pub values: Vec<f32>,
}

impl Pixels {
    /// The pixel in a column of a row, both of which are in range.
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let start = (y * self.width + x) * self.channels;
        match self.values.get(start..start + self.channels) {
            Some([r, g, b]) => [*r, *g, *b],
            Some([grey]) => [*grey; 3],
            _ => [0.0; 3],
        }
    }

    /// The largest number, at least 0.
    pub fn peak(&self) -> f32 {
        self.values.iter().copied().fold(0.0, f32::max)
    }

    /// The same made linear.
    #[must_use]
    pub fn linear(mut self, encoding: Encoding) -> Self {
        if encoding == Encoding::Srgb {
            // Whole numbers of 8 or 16 bits.
            let curve = curve();
            self.values.iter_mut().for_each(|value| *value = curve[(*value * 65_535.0).round() as u16 as usize]);
        }
        self
    }

    /// The same with each channel times its part of `by`.
    #[must_use]
    pub fn times(self, by: [f64; 3]) -> Self {
        if by == [1.0; 3] {
            return self;
        }
        let mut colored = self.colored();
        for pixel in colored.values.chunks_exact_mut(3) {
            pixel.iter_mut().zip(by).for_each(|(value, by)| *value = (f64::from(*value) * by) as f32);
        }
        colored
    }

    /// The same with three channels.
    #[must_use]
    pub fn colored(self) -> Self {
        if self.channels == 3 {
            return self;
        }
        let values = self.values.iter().flat_map(|value| [*value; 3]).collect();
        Self { channels: 3, values, ..self }
    }
}

/// What the sRGB curve makes of each code of 16 bits. The codes of 8 bits are among them: 65535 is 257 times 255.
fn curve() -> &'static [f32] {
    static CURVE: OnceLock<Vec<f32>> = OnceLock::new();
    CURVE.get_or_init(|| (0..=u16::MAX).map(|code| decoded(f64::from(code) / 65_535.0) as f32).collect())
}

/// The linear value of one of the sRGB curve, both 0..1 (IEC 61966-2-1).
pub fn decoded(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_that_of_the_standard() {
        let codes = [0.0, 10.0, 128.0, 255.0].map(|code: f32| code / 255.0);
        let grey = Pixels { width: 4, height: 1, channels: 1, values: codes.to_vec() };
        let found = grey.clone().linear(Encoding::Srgb).values;
        // 10/255/12.92; ((128/255 + 0.055) / 1.055)^2.4.
        for (found, wanted) in found.iter().zip([0.0, 0.003_035_27, 0.215_860_5, 1.0]) {
            assert!((f64::from(*found) - wanted).abs() < 1e-7, "{found} for {wanted}");
        }
        assert_eq!(grey.clone().linear(Encoding::Linear), grey);
    }

    #[test]
    fn grey_becomes_colored_where_it_has_to() {
        let grey = Pixels { width: 1, height: 2, channels: 1, values: vec![0.5, 2.0] };
        assert_eq!(grey.clone().times([1.0; 3]), grey);
        assert_eq!(grey.clone().times([1.0, 2.0, 0.0]).values, [0.5, 1.0, 0.0, 2.0, 4.0, 0.0]);
        assert_eq!((grey.at(0, 1), grey.peak()), ([2.0; 3], 2.0));
    }
}
