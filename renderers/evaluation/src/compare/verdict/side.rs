//! What several images of one renderer tell of their mean and of its error, per cell of a grid.
//!
//! All that a cell needs is a sum over its pixels, or a largest value, so the tiles of the finest grid are gathered once, and coarser
//! cells are put together from them.

use std::ops::Range;

use ltsc_render::image::Image;
use rayon::prelude::*;

use super::super::moments::{FINE, Moments, PARTS, TileSums, starts, tile_of};
use super::super::{CompareError, Images};
use super::GRIDS;

/// Sums over the pixels of a cell, of the channels or with grey at the end.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: f64,
    mean: [f64; 3],
    /// Variance of one image.
    variance: [f64; PARTS],
    /// The squares of the variances.
    squares: [f64; 3],
    cubes: [f64; 3],
    /// The largest value above the mean of its pixel.
    event: [f64; 3],
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        for c in 0..3 {
            self.mean[c] += other.mean[c];
            self.squares[c] += other.squares[c];
            self.cubes[c] += other.cubes[c];
            self.event[c] = self.event[c].max(other.event[c]);
        }
        (0..PARTS).for_each(|c| self.variance[c] += other.variance[c]);
    }
}

/// A cell of a grid: one of `grid` times `grid`, counted row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub grid: usize,
    pub index: usize,
}

impl Place {
    /// The tiles of the finest grid that it consists of.
    fn tiles(self) -> impl Iterator<Item = usize> {
        let side = FINE / self.grid;
        let (column, row) = (self.index % self.grid * side, self.index / self.grid * side);
        (row..row + side).flat_map(move |y| (column..column + side).map(move |x| y * FINE + x))
    }
}

/// All images of one renderer.
pub(super) struct Side {
    tiles: Vec<Sums>,
    /// Of each image the sums over the tiles.
    images: Vec<TileSums>,
    /// How the errors hang together, where that is known and the images are not.
    known: Option<Noise>,
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
    pub tiles: f64,
    /// The same of larger cells.
    pub cells: f64,
    /// Whether whole images go up and down together.
    pub together: bool,
}

/// Gives each tile the pixels that lie in it, row by row, the rows of tiles side by side.
fn by_tiles<T: Send>((width, height): (usize, usize), of: impl Fn(Range<usize>, &mut T) + Sync, tiles: &mut [T]) {
    let rows = tile_of(height);
    tiles.par_chunks_mut(FINE).enumerate().for_each(|(row, tiles)| {
        for y in (0..height).filter(|y| rows[*y] == row) {
            for (column, tile) in tiles.iter_mut().enumerate() {
                let from = y * width;
                of(from + starts(width, column)..from + starts(width, column + 1), tile);
            }
        }
    });
}

/// The sums of each tile.
fn sums_of(moments: &Moments, mask: &[bool]) -> Vec<Sums> {
    let mut tiles = vec![Sums::default(); FINE * FINE];
    let row = |pixels: Range<usize>, tile: &mut Sums| {
        for at in pixels.filter(|at| !mask[*at]) {
            let variance = moments.variance(at);
            let (cubes, event) = moments.extremes(at);
            let squares = [0, 1, 2].map(|c: usize| variance[c] * variance[c]);
            tile.add(&Sums { pixels: 1.0, mean: moments.mean(at), variance, squares, cubes, event });
        }
    };
    by_tiles((moments.width, moments.height), row, &mut tiles);
    tiles
}

/// Of an image the sums over the tiles, without what is left out.
fn tiles_without(image: &Image, mask: &[bool]) -> TileSums {
    let mut tiles = [[0.0; PARTS]; FINE * FINE];
    let row = |pixels: Range<usize>, tile: &mut [f64; PARTS]| {
        for at in pixels.filter(|at| !mask[*at]) {
            let [r, g, b] = image.pixels[at].map(f64::from);
            [r, g, b, (r + g + b) / 3.0].into_iter().zip(&mut *tile).for_each(|(value, sum)| *sum += value);
        }
    };
    by_tiles((image.width, image.height), row, &mut tiles);
    tiles
}

impl Side {
    /// Takes the statistics of images of one size; `samples` are those of one image, and pixels in the `mask` are left out.
    pub fn of(moments: &Moments, images: Images<'_>, mask: &[bool], samples: f64) -> Result<Self, CompareError> {
        let tiles = sums_of(moments, mask);
        let count = images.count();
        let mut sums = Vec::new();
        // One image tells nothing of its noise.
        if count > 1 && !mask.contains(&true) {
            sums = moments.tiles().to_vec();
        } else if count > 1 {
            for at in 0..count {
                sums.push(tiles_without(images.get(at)?.as_ref(), mask));
            }
        }
        Ok(Self { tiles, images: sums, known: None, count: count as f64, samples })
    }

    /// The same of images that are no longer there, of which it is known how their errors hang together.
    pub fn of_moments(moments: &Moments, mask: &[bool], samples: f64, noise: Noise) -> Self {
        let count = moments.count() as f64;
        Self { tiles: sums_of(moments, mask), images: Vec::new(), known: Some(noise), count, samples }
    }

    /// Whether there is one image only, which is taken to be free of noise.
    pub fn is_exact(&self) -> bool {
        self.count < 2.0
    }

    fn sums(&self, cell: Place) -> Sums {
        let mut sums = Sums::default();
        cell.tiles().for_each(|tile| sums.add(&self.tiles[tile]));
        sums
    }

    /// How many pixels a cell has, without those that are left out.
    pub fn size(&self, cell: Place) -> f64 {
        cell.tiles().map(|tile| self.tiles[tile].pixels).sum()
    }

    /// The variance of a cell's mean, as independent pixels have it (`part` 3 is grey).
    pub fn by_pixels(&self, cell: Place, part: usize) -> f64 {
        let sums = self.sums(cell);
        sums.variance[part] / (self.count * sums.pixels * sums.pixels)
    }

    /// The same as the means of the images have it.
    pub fn by_images(&self, cell: Place, part: usize) -> f64 {
        let size = self.size(cell);
        let of = |image: &TileSums| cell.tiles().map(|tile| image[tile][part]).sum::<f64>() / size;
        let means: Vec<f64> = self.images.iter().map(of).collect();
        let mean = means.iter().sum::<f64>() / self.count;
        means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / ((self.count - 1.0).max(1.0) * self.count)
    }

    /// How the errors hang together, from the tiles, the larger cells, and the whole image.
    pub fn noise(&self) -> Noise {
        let factor = |grid: usize| {
            let cells = (0..grid * grid).map(|index| Place { grid, index }).filter(|cell| self.size(*cell) > 0.0);
            let ratios = cells.filter_map(|cell| {
                let independent = self.by_pixels(cell, 3);
                (independent > 0.0).then(|| self.by_images(cell, 3) / independent)
            });
            let ratios: Vec<f64> = ratios.collect();
            if ratios.is_empty() { 1.0 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
        };
        if let Some(known) = self.known {
            return known;
        }
        if self.is_exact() {
            return Noise { tiles: 1.0, cells: 1.0, together: false };
        }
        let whole = Place { grid: 1, index: 0 };
        let small = factor(FINE).max(1.0);
        let large = factor(GRIDS[1]).max(small);
        let limit = 1.3 * quantile95(self.count - 1.0) * small * self.by_pixels(whole, 3);
        Noise { tiles: small, cells: large, together: self.by_images(whole, 3) > limit }
    }

    /// A cell in one channel.
    pub fn estimate(&self, cell: Place, channel: usize, noise: Noise) -> Estimate {
        let sums = self.sums(cell);
        let size = sums.pixels;
        let mean = sums.mean[channel] / size;
        if self.is_exact() {
            return Estimate { mean, freedom: f64::INFINITY, ..Estimate::default() };
        }
        let (variance, squares) = (sums.variance[channel], sums.squares[channel]);
        let phi = if cell.grid == FINE { noise.tiles } else { noise.cells };
        let k = self.count;
        let effective = if squares > 0.0 { (k - 1.0) * variance * variance / squares / phi } else { f64::INFINITY };
        let mut of = Estimate {
            mean,
            variance: phi * variance / (k * size * size),
            freedom: effective.max(k - 1.0),
            third: sums.cubes[channel] * k / ((k - 1.0) * (k - 2.0).max(1.0)) / (size.powi(3) * k * k),
            event: self.samples * sums.event[channel],
        };
        if noise.together {
            of.variance = of.variance.max(self.by_images(cell, channel));
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
        let mut moments = Moments::new(2, 1);
        images.iter().for_each(|image| moments.add(image).expect("one size"));
        let side = Side::of(&moments, Images::Held(&images), &[false; 2], 4.0).expect("images");
        let noise = Noise { tiles: 1.0, cells: 1.0, together: false };
        let of = side.estimate(Place { grid: 1, index: 0 }, 0, noise);
        assert_eq!(of.mean, 3.0);
        // The first has a variance of 7; that of the mean of two pixels over three images is 7 / (3 * 4).
        assert!((of.variance - 7.0 / 12.0).abs() < 1e-6);
        // One pixel carries all: two degrees of freedom.
        assert!((of.freedom - 2.0).abs() < 1e-9);
        assert_eq!(of.event, 12.0);
        // Cubes -8, -1, 27 give 18; 18 * 3 / (2 * 1) / (8 * 9).
        assert!((of.third - 0.375).abs() < 1e-6, "{}", of.third);
    }

    #[test]
    fn cells_are_made_of_all_tiles_once() {
        for grid in GRIDS {
            let mut seen: Vec<usize> = (0..grid * grid).flat_map(|index| Place { grid, index }.tiles()).collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..FINE * FINE).collect::<Vec<_>>());
        }
        assert_eq!(Place { grid: 4, index: 5 }.tiles().collect::<Vec<_>>(), [18, 19, 26, 27]);
        // Images with fewer pixels than tiles have empty ones.
        assert_eq!(tile_of(2), [3, 7]);
        assert_eq!(tile_of(16).len(), 16);
    }
}
