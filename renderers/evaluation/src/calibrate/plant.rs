//! Differences that are planted in images, and how large a difference is in tolerances.

use ltsc_render::image::Image;

use super::draw::mean;
use crate::compare::verdict::{DARK, GRIDS, glare};

/// Tiles along each side.
const FINE: usize = GRIDS[0];

/// What is done to the images of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plant {
    /// A tile of the finest grid, counted row by row, times a factor.
    Tile(usize, f64),
    /// A channel times a factor.
    Channel(usize, f64),
    /// Everything times a factor.
    Whole(f64),
    /// Everything moves one pixel to the right; the first column stays.
    Shift,
}

impl Plant {
    /// An image with it.
    #[must_use]
    pub fn on(self, image: &Image) -> Image {
        let mut new = image.clone();
        let scale = |values: &mut [f32], factor: f64| values.iter_mut().for_each(|value| *value *= factor as f32);
        match self {
            Self::Tile(tile, factor) => {
                let (columns, rows) = (bounds(tile % FINE, image.width), bounds(tile / FINE, image.height));
                for row in rows {
                    let pixels = &mut new.pixels[row * image.width..][columns.clone()];
                    pixels.iter_mut().for_each(|pixel| scale(pixel, factor));
                }
            }
            Self::Channel(channel, factor) => {
                new.pixels.iter_mut().for_each(|pixel| scale(&mut pixel[channel..=channel], factor));
            }
            Self::Whole(factor) => new.pixels.iter_mut().for_each(|pixel| scale(pixel, factor)),
            Self::Shift => {
                for row in new.pixels.chunks_mut(image.width.max(1)) {
                    let last = row.len().saturating_sub(1);
                    row.copy_within(..last, 1);
                }
            }
        }
        new
    }
}

/// The pixels of a tile along a side of `size` pixels, as the verdict cuts them.
fn bounds(tile: usize, size: usize) -> std::ops::Range<usize> {
    tile * size / FINE..(tile + 1) * size / FINE
}

/// What is known of a pool's truth: means of its cells with their standard errors.
pub struct Truth {
    /// The finest tiles and, at the end, the whole image.
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    mean: [f64; 3],
    /// Variance of that mean.
    variance: [f64; 3],
}

/// How far two truths are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Distance {
    /// The largest difference of a tile or of the whole image, as a share of what the tolerance is a share of.
    pub share: f64,
    /// What it is at least, three standard errors below: the largest of all cells.
    pub proved: f64,
}

impl Truth {
    /// Of a pool; none if it has fewer than two chunks.
    #[must_use]
    pub fn of(pool: &[Image]) -> Option<Self> {
        Self::with(pool, |image| image.clone())
    }

    /// The same of a pool to which something is done.
    #[must_use]
    pub fn with(pool: &[Image], change: impl Fn(&Image) -> Image) -> Option<Self> {
        if pool.len() < 2 {
            return None;
        }
        let mean = change(&mean(pool.iter()));
        let light = |pixel: &[f32; 3]| Some(pixel.iter().map(|value| f64::from(*value)).sum::<f64>());
        // The pixels that the verdict leaves out.
        let out = glare(&mean.pixels.iter().map(light).collect::<Vec<_>>(), mean.width);
        let all: Vec<Vec<[f64; 3]>> = pool.iter().map(|image| cells(&change(image), &out)).collect();
        let n = pool.len() as f64;
        let cell = |at: usize| {
            let mut cell = Cell::default();
            for channel in 0..3 {
                let values = || all.iter().map(|cells| cells[at][channel]);
                let mean = values().sum::<f64>() / n;
                cell.mean[channel] = mean;
                cell.variance[channel] = values().map(|value| (value - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
            }
            cell
        };
        Some(Self { cells: (0..=FINE * FINE).map(cell).collect() })
    }

    /// Tiles whose tolerance is a share of their own mean in all channels, because they are not dark.
    #[must_use]
    pub fn bright(&self) -> Vec<usize> {
        let whole = self.cells[FINE * FINE].mean;
        let is_bright = |tile: &usize| (0..3).all(|c| self.cells[*tile].mean[c] > 1.5 * DARK * whole[c]);
        (0..FINE * FINE).filter(is_bright).collect()
    }

    /// B / A of the whole image in each channel.
    #[must_use]
    pub fn ratio(&self, b: &Self) -> [f64; 3] {
        let (a, b) = (&self.cells[FINE * FINE].mean, &b.cells[FINE * FINE].mean);
        [0, 1, 2].map(|c: usize| if a[c] > 0.0 { b[c] / a[c] } else { 1.0 })
    }

    /// How far another truth is from this one, in what tolerances are shares of.
    #[must_use]
    pub fn distance(&self, b: &Self) -> Distance {
        let whole = |truth: &Self| truth.cells[FINE * FINE].mean;
        let (whole_a, whole_b) = (whole(self), whole(b));
        let mut of = Distance::default();
        for (one, other) in self.cells.iter().zip(&b.cells) {
            for c in 0..3 {
                let scale = one.mean[c].min(other.mean[c]).max(DARK * whole_a[c].min(whole_b[c]));
                let off = (other.mean[c] - one.mean[c]).abs();
                if scale <= 0.0 || off.is_nan() {
                    continue;
                }
                let error = (one.variance[c] + other.variance[c]).sqrt();
                of.share = of.share.max(off / scale);
                of.proved = of.proved.max((off - 3.0 * error) / scale);
            }
        }
        of
    }
}

/// Means of the finest tiles and of the whole; not a number where all of one is left out.
fn cells(image: &Image, out: &[bool]) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); FINE * FINE + 1];
    for tile in 0..FINE * FINE {
        for row in bounds(tile / FINE, image.height) {
            for column in bounds(tile % FINE, image.width) {
                let at = row * image.width + column;
                if out[at] {
                    continue;
                }
                for cell in [tile, FINE * FINE] {
                    (0..3).for_each(|c| sums[cell].0[c] += f64::from(image.pixels[at][c]));
                    sums[cell].1 += 1.0;
                }
            }
        }
    }
    sums.into_iter().map(|(sum, count): ([f64; 3], f64)| sum.map(|value| value / count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Image {
        let pixels = (0..32 * 16).map(|at| [(at % 32) as f32, 1.0, 0.0]).collect();
        Image { width: 32, height: 16, pixels }
    }

    #[test]
    fn what_is_planted_is_where_it_should_be() {
        let image = ramp();
        let tile = Plant::Tile(9, 3.0).on(&image);
        let changed: Vec<usize> = (0..512).filter(|at| tile.pixels[*at] != image.pixels[*at]).collect();
        assert_eq!(changed, [68, 69, 70, 71, 100, 101, 102, 103], "rows 2 and 3, columns 4 to 7");
        assert_eq!(tile.pixels[69], [15.0, 3.0, 0.0]);
        assert_eq!(Plant::Channel(1, 0.5).on(&image).pixels[40], [8.0, 0.5, 0.0]);
        assert_eq!(Plant::Whole(2.0).on(&image).pixels[40], [16.0, 2.0, 0.0]);
        let shifted = Plant::Shift.on(&image);
        assert_eq!([0, 1, 2, 31, 32].map(|at: usize| shifted.pixels[at][0]), [0.0, 0.0, 1.0, 30.0, 0.0]);
    }

    #[test]
    fn a_distance_is_that_of_the_worst_cell_in_what_tolerances_are_shares_of() {
        let chunk = |grain: f32| Image::filled(32, 32, [1.0 + grain, 0.5 + grain, 0.2 + grain]);
        let pool: Vec<Image> = (0..64).map(|at| chunk(if at % 2 == 0 { 1e-3 } else { -1e-3 })).collect();
        let truth = Truth::of(&pool).expect("chunks");
        let of = |plant: Plant| truth.distance(&Truth::with(&pool, |image| plant.on(image)).expect("chunks"));
        let tile = of(Plant::Tile(7, 1.3));
        assert!((tile.share - 0.3).abs() < 1e-6, "{tile:?}");
        // The error of a chunk is 1e-3, of 64 of them 1/8 of it on both sides; the dimmest channel has it as 0.2.
        let error = 1e-3 / 63_f64.sqrt();
        let expected = 0.3 - 3.0 * (error * error * (1.0 + 1.69)).sqrt();
        assert!((tile.proved - expected).abs() < 2e-4, "{tile:?} {expected}");
        assert!((of(Plant::Whole(0.8)).share - 0.25).abs() < 1e-6, "a share of the smaller one");
        assert!(of(Plant::Shift).share < 1e-6);
        assert_eq!(truth.bright().len(), 64);
        // A dark tile is bright for nobody, and its difference is told by the image.
        let dark: Vec<Image> = pool.iter().map(|image| Plant::Tile(3, 0.01).on(image)).collect();
        let truth = Truth::of(&dark).expect("chunks");
        assert!(!truth.bright().contains(&3) && truth.bright().len() == 63);
        let twice: Vec<Image> = dark.iter().map(|image| Plant::Tile(3, 2.0).on(image)).collect();
        let off = truth.distance(&Truth::of(&twice).expect("chunks")).share;
        assert!((off - 0.1).abs() < 0.01, "{off}");
    }

    #[test]
    fn a_light_seen_directly_is_left_out() {
        let mut images = vec![Image::filled(16, 16, [1.0; 3]); 4];
        let truth = Truth::of(&images).expect("chunks");
        images.iter_mut().for_each(|image| image.pixels[5] = [1e5; 3]);
        assert!(truth.distance(&Truth::of(&images).expect("chunks")).share < 1e-9);
        assert!(Truth::of(&images[..1]).is_none());
    }
}
