//! What several images of one renderer tell of their mean and of its error: per pixel, and per cell of a grid.

use ltsc_render::image::Image;

/// Red, green, blue, and the mean of the three, by which the correlation of pixels is judged.
const PARTS: usize = 4;

/// A pixel over all images of a side.
#[derive(Clone, Copy, Default)]
struct Pixel {
    mean: [f64; PARTS],
    /// Variance of one image.
    variance: [f64; PARTS],
    /// The sum of the cubes of the deviations from the mean.
    cubes: [f64; 3],
    /// The largest value above the mean.
    event: [f64; 3],
}

/// All images of one renderer.
pub(super) struct Side {
    pixels: Vec<Pixel>,
    /// The mean of red, green and blue in each pixel of each image.
    grey: Vec<Vec<f32>>,
    /// How many images there are.
    pub count: f64,
    /// Samples per pixel of each.
    pub samples: f64,
}

/// A cell of a side in one channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    /// The mean over all images.
    pub mean: f64,
    /// The variance of that mean.
    pub variance: f64,
    /// Degrees of freedom of that variance.
    pub freedom: f64,
    /// The third central moment of that mean.
    pub third: f64,
    /// The largest event, as the energy of one sample.
    pub event: f64,
}

/// How a side's errors hang together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// By how much the variance of tiles is larger than that of independent pixels, at least 1.
    tiles: f64,
    /// The same of larger cells.
    cells: f64,
    /// Whether whole images go up and down together.
    pub together: bool,
}

impl Side {
    /// Takes the statistics of images of one size; `samples` are those of one image.
    pub fn of(images: &[Image], samples: f64) -> Self {
        let count = images.len() as f64;
        let size = images.first().map_or(0, |image| image.pixels.len());
        let part = |image: &Image, at: usize| {
            let [r, g, b] = image.pixels[at].map(f64::from);
            [r, g, b, (r + g + b) / 3.0]
        };
        let pixel = |at: usize| {
            let mut pixel = Pixel::default();
            for image in images {
                let value = part(image, at);
                (0..PARTS).for_each(|c| pixel.mean[c] += value[c] / count);
            }
            for image in images {
                let value = part(image, at);
                for (c, value) in value.into_iter().enumerate() {
                    let off = value - pixel.mean[c];
                    pixel.variance[c] += off * off / (count - 1.0).max(1.0);
                    if c < 3 {
                        pixel.cubes[c] += off * off * off;
                        pixel.event[c] = pixel.event[c].max(off);
                    }
                }
            }
            pixel
        };
        let grey = images.iter().map(|image| (0..size).map(|at| part(image, at)[3] as f32).collect());
        Self { pixels: (0..size).map(pixel).collect(), grey: grey.collect(), count, samples }
    }

    /// Whether there is one image only, which is taken to be free of noise.
    pub fn is_exact(&self) -> bool {
        self.count < 2.0
    }

    /// The variance of a cell's mean, as independent pixels have it (`part` 3 is grey).
    fn by_pixels(&self, cell: &[usize], part: usize) -> f64 {
        let sum: f64 = cell.iter().map(|at| self.pixels[*at].variance[part]).sum();
        sum / (self.count * (cell.len() as f64).powi(2))
    }

    /// The variance of a cell's grey mean, as the means of the images have it.
    fn by_images(&self, cell: &[usize]) -> f64 {
        let size = cell.len() as f64;
        let means = self.grey.iter().map(|grey| cell.iter().map(|at| f64::from(grey[*at])).sum::<f64>() / size);
        let means: Vec<f64> = means.collect();
        let mean = means.iter().sum::<f64>() / self.count;
        means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / ((self.count - 1.0).max(1.0) * self.count)
    }

    /// The same of one channel of this side's images.
    fn by_images_of(&self, images: &[Image], cell: &[usize], channel: usize) -> f64 {
        let size = cell.len() as f64;
        let of = |image: &Image| cell.iter().map(|at| f64::from(image.pixels[*at][channel])).sum::<f64>() / size;
        let means: Vec<f64> = images.iter().map(of).collect();
        let mean = means.iter().sum::<f64>() / self.count;
        means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / ((self.count - 1.0).max(1.0) * self.count)
    }

    /// How the errors hang together, from the tiles, the larger cells, and the whole image.
    pub fn noise(&self, tiles: &[Vec<usize>], cells: &[Vec<usize>], whole: &[usize]) -> Noise {
        let factor = |cells: &[Vec<usize>]| {
            let ratios = cells.iter().filter(|cell| !cell.is_empty()).filter_map(|cell| {
                let independent = self.by_pixels(cell, 3);
                (independent > 0.0).then(|| self.by_images(cell) / independent)
            });
            let ratios: Vec<f64> = ratios.collect();
            if ratios.is_empty() { 1.0 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
        };
        if self.is_exact() {
            return Noise { tiles: 1.0, cells: 1.0, together: false };
        }
        let small = factor(tiles).max(1.0);
        let large = factor(cells).max(small);
        let limit = 1.3 * quantile95(self.count - 1.0) * small * self.by_pixels(whole, 3);
        Noise { tiles: small, cells: large, together: self.by_images(whole) > limit }
    }

    /// A cell in one channel; `tile` where it belongs to the finest grid.
    pub fn estimate(&self, images: &[Image], cell: &[usize], channel: usize, noise: Noise, tile: bool) -> Estimate {
        let size = cell.len() as f64;
        let (mut mean, mut variance, mut squares, mut cubes, mut event) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
        for pixel in cell.iter().map(|at| &self.pixels[*at]) {
            mean += pixel.mean[channel] / size;
            variance += pixel.variance[channel];
            squares += pixel.variance[channel].powi(2);
            cubes += pixel.cubes[channel];
            event = event.max(pixel.event[channel]);
        }
        if self.is_exact() {
            return Estimate { mean, freedom: f64::INFINITY, ..Estimate::default() };
        }
        let phi = if tile { noise.tiles } else { noise.cells };
        let k = self.count;
        let effective = if squares > 0.0 { (k - 1.0) * variance * variance / squares / phi } else { f64::INFINITY };
        let mut of = Estimate {
            mean,
            variance: phi * variance / (k * size * size),
            freedom: effective.max(k - 1.0),
            third: cubes * k / ((k - 1.0) * (k - 2.0).max(1.0)) / (size.powi(3) * k * k),
            event: self.samples * event,
        };
        if noise.together {
            of.variance = of.variance.max(self.by_images_of(images, cell, channel));
            of.freedom = k - 1.0;
        }
        of
    }
}

/// The 95 % point of chi-square over its degrees of freedom (Wilson and Hilferty 1931; within 0.6 % from 3 on).
fn quantile95(freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom.max(1.0));
    (1.0 - spread + 1.644_854 * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, known) in [(3.0, 2.605), (7.0, 2.010), (15.0, 1.666)] {
            assert!((quantile95(freedom) / known - 1.0).abs() < 0.006, "{freedom}: {}", quantile95(freedom));
        }
    }

    #[test]
    fn a_cell_has_the_moments_of_its_pixels() {
        // Two pixels over three images: 1, 2, 6 and 3, 3, 3.
        let image = |value: f32| Image { width: 2, height: 1, pixels: vec![[value; 3], [3.0; 3]] };
        let images = [image(1.0), image(2.0), image(6.0)];
        let side = Side::of(&images, 4.0);
        let cell = vec![0, 1];
        let noise = Noise { tiles: 1.0, cells: 1.0, together: false };
        let of = side.estimate(&images, &cell, 0, noise, true);
        assert_eq!(of.mean, 3.0);
        // The first has a variance of 7; that of the mean of two pixels over three images is 7 / (3 * 4).
        assert!((of.variance - 7.0 / 12.0).abs() < 1e-12);
        // One pixel carries all: two degrees of freedom.
        assert_eq!(of.freedom, 2.0);
        assert_eq!(of.event, 12.0);
        // Cubes -8, -1, 27 give 18; 18 * 3 / (2 * 1) / (8 * 9).
        assert!((of.third - 0.375).abs() < 1e-12, "{}", of.third);
    }
}
