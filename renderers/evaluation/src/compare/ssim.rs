//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity",
//! 2004) of luminance as a screen shows it, in windows of 5 x 5 pixels of equal weight.

use std::ops::{Add, Range};

use rayon::prelude::*;

use super::Pair;
use super::shown::luminances;

/// Pixels from a window's middle to its sides.
const REACH: usize = 2;

/// What keeps quotients of small numbers steady: `(0.01 L)^2` and `(0.03 L)^2` (Wang et al. 2004, from memory), the range `L` being 1.
const STEADY: [f64; 2] = [1e-4, 9e-4];

/// Sums over pixels: how many, of both images, of their squares, of their products.
#[derive(Clone, Copy, Default)]
struct Sums([f64; 6]);

impl Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|at| self.0[at] + other.0[at]))
    }
}

impl Sums {
    fn of(pixel: Option<[f64; 2]>) -> Self {
        pixel.map_or(Self::default(), |[a, b]| Self([1.0, a, b, a * a, b * b, a * b]))
    }

    /// Structural similarity, -1 to 1.
    fn similarity(self) -> f64 {
        let [count, a, b, aa, bb, ab] = self.0;
        let [a, b, aa, bb, ab] = [a, b, aa, bb, ab].map(|sum| sum / count);
        // Rounding must not make a variance negative, or a covariance larger than both variances.
        let (of_a, of_b) = ((aa - a * a).max(0.0), (bb - b * b).max(0.0));
        let both = (ab - a * b).clamp(-(of_a * of_b).sqrt(), (of_a * of_b).sqrt());
        let means = (2.0 * a * b + STEADY[0]) / (a * a + b * b + STEADY[0]);
        means * (2.0 * both + STEADY[1]) / (of_a + of_b + STEADY[1])
    }
}

/// The structural similarity of each pixel at an exposure in stops, -1 to 1; not a number where a pixel is not finite in A or B. Windows
/// end at the border of the image, and leave out such pixels.
#[must_use]
pub fn ssim_map(pair: &Pair, exposure: f64) -> Vec<f32> {
    let width = pair.a.width;
    let pixels = luminances(pair, exposure);
    let height = pixels.len() / width.max(1);
    let around = |at: usize, size: usize| -> Range<usize> { at.saturating_sub(REACH)..(at + REACH + 1).min(size) };
    let row = |y: usize| -> Vec<f32> {
        let columns: Vec<Sums> = (0..width)
            .map(|x| around(y, height).map(|y| Sums::of(pixels[y * width + x])).fold(Sums::default(), Add::add))
            .collect();
        let value = |x: usize| {
            let sums = columns[around(x, width)].iter().copied().fold(Sums::default(), Add::add);
            pixels[y * width + x].map_or(f32::NAN, |_| sums.similarity() as f32)
        };
        (0..width).map(value).collect()
    };
    (0..height).into_par_iter().flat_map_iter(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltsc_render::image::Image;

    /// The formula, read off the paper, for one window.
    fn plainly(values: &[(f64, f64)]) -> f64 {
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| values.iter().map(of).sum::<f64>() / values.len() as f64;
        let (a, b) = (mean(&|v| v.0), mean(&|v| v.1));
        let (aa, bb) = (mean(&|v| (v.0 - a).powi(2)), mean(&|v| (v.1 - b).powi(2)));
        let ab = mean(&|v| (v.0 - a) * (v.1 - b));
        (2.0 * a * b + 1e-4) * (2.0 * ab + 9e-4) / ((a * a + b * b + 1e-4) * (aa + bb + 9e-4))
    }

    #[test]
    fn windows_are_those_of_the_formula() {
        let mut seed = 1_u32;
        let mut dice = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [(seed >> 8) as f32 / (1 << 24) as f32; 3]
        };
        let mut image = || Image { width: 9, height: 7, pixels: (0..63).map(|_| dice()).collect() };
        let (a, mut b) = (image(), image());
        b.pixels[3 * 9 + 4][1] = f32::NAN;
        let map = ssim_map(&Pair::new(&a, &b).expect("a pair"), 0.0);
        let shown = |image: &Image, x: usize, y: usize| crate::compare::shown::srgb(f64::from(image.at(x, y)[0]));
        for (x, y) in [(0, 0), (4, 4), (8, 6), (1, 5)] {
            let mut window = Vec::new();
            for v in y.max(2) - 2..(y + 3).min(7) {
                for u in x.max(2) - 2..(x + 3).min(9) {
                    if (u, v) != (4, 3) {
                        window.push((shown(&a, u, v), shown(&b, u, v)));
                    }
                }
            }
            let (found, wanted) = (f64::from(map[y * 9 + x]), plainly(&window));
            assert!((found - wanted).abs() < 1e-6, "({x}, {y}): {found}, not {wanted}");
        }
        assert!(map[3 * 9 + 4].is_nan());
        assert_eq!(map.iter().filter(|value| value.is_nan()).count(), 1);
    }
}
