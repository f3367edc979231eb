//! Moments of each pixel over several images, gathered one image at a time, so that memory does not grow with their number.

use rayon::prelude::*;

use ltsc_render::image::{Image, finite};

use super::CompareError;

/// Red, green, blue, and the mean of the three.
pub(super) const PARTS: usize = 4;

/// Pixels that one thread works on at a time; whole rows.
const PIECE: usize = 1 << 14;

/// Tiles along each side whose sums are kept of each image.
pub(super) const FINE: usize = 8;

/// Sums of an image over the pixels of each tile, in each part.
pub(super) type TileSums = [[f64; PARTS]; FINE * FINE];

/// The tile of the finest grid that each column, or row, lies in.
pub(super) fn tile_of(size: usize) -> Vec<usize> {
    (0..FINE).flat_map(|at| std::iter::repeat_n(at, (at + 1) * size / FINE - at * size / FINE)).collect()
}

/// A pixel over the images that were added.
#[derive(Clone, Copy)]
struct Pixel {
    mean: [f64; 3],
    /// Sums of the squares of the deviations from the mean; the last is that of the mean of red, green and blue.
    squares: [f32; PARTS],
    /// Sums of their cubes.
    cubes: [f32; 3],
    /// The largest value.
    largest: [f32; 3],
    /// Whether some image is not finite here.
    bad: bool,
}

/// The moments of all pixels; 64 bytes for each, whatever the number of images.
pub struct Moments {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    count: usize,
    pixels: Vec<Pixel>,
    /// Of each image, over the pixels that are finite in it.
    tiles: Vec<TileSums>,
    columns: Vec<usize>,
    rows: Vec<usize>,
}

impl Moments {
    /// Of no image yet.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        let none = Pixel { mean: [0.0; 3], squares: [0.0; PARTS], cubes: [0.0; 3], largest: [f32::MIN; 3], bad: false };
        let (columns, rows) = (tile_of(width), tile_of(height));
        Self { width, height, count: 0, pixels: vec![none; width * height], tiles: Vec::new(), columns, rows }
    }

    /// Those of `count` images of which only the mean and the variance of that mean are left. What else there is to know of them is
    /// taken to be nothing: no skewness, no value above the mean; the mean of the channels as noisy as channels that vary together.
    ///
    /// # Errors
    /// If the two differ in size.
    pub fn of_mean(mean: &Image, variance: &Image, count: usize) -> Result<Self, CompareError> {
        if (mean.width, mean.height) != (variance.width, variance.height) {
            let size = |image: &Image| (image.width, image.height);
            return Err(CompareError::Size { a: size(mean), b: size(variance) });
        }
        let freedom = count as f64 * count.saturating_sub(1) as f64;
        let of = |(value, variance): (&[f32; 3], &[f32; 3])| {
            let squares = variance.map(|part| f64::from(part) * freedom);
            let grey = (squares.iter().map(|part| part.max(0.0).sqrt()).sum::<f64>() / 3.0).powi(2);
            Pixel {
                mean: value.map(f64::from),
                squares: [squares[0] as f32, squares[1] as f32, squares[2] as f32, grey as f32],
                cubes: [0.0; 3],
                largest: *value,
                bad: !finite(value) || !finite(variance),
            }
        };
        let pixels = mean.pixels.iter().zip(&variance.pixels).map(of).collect();
        Ok(Self { count, pixels, ..Self::new(mean.width, mean.height) })
    }

    /// Adds an image.
    ///
    /// # Errors
    /// If its size is another one.
    pub fn add(&mut self, image: &Image) -> Result<(), CompareError> {
        self.add_all(&[image])
    }

    /// Adds images, several at once, which takes less of memory's time than one after the other, and gives the same.
    ///
    /// # Errors
    /// If one has another size; none is added then.
    pub fn add_all(&mut self, images: &[&Image]) -> Result<(), CompareError> {
        let (a, other) =
            ((self.width, self.height), |image: &&&Image| (image.width, image.height) != (self.width, self.height));
        if let Some(image) = images.iter().find(other) {
            return Err(CompareError::Size { a, b: (image.width, image.height) });
        }
        let first = self.count;
        self.count += images.len();
        if self.width == 0 {
            return Ok(());
        }
        let lines = (PIECE / self.width).max(1);
        let (width, columns, rows) = (self.width, &self.columns, &self.rows);
        // One row lies in one row of tiles; sums are put together in their order, so that they do not depend on the machine. What is known of a
        // piece of the image is looked at for all images before the next piece.
        let of_piece = |(piece, pixels): (usize, &mut [Pixel])| -> Vec<Vec<(usize, RowSums)>> {
            let from = piece * lines * width;
            let mut all = Vec::with_capacity(images.len());
            for (at, image) in images.iter().enumerate() {
                let n = (first + at + 1) as f64;
                let values = image.pixels[from..from + pixels.len()].chunks_exact(width);
                let of_lines = pixels.chunks_exact_mut(width).zip(values).enumerate();
                all.push(
                    of_lines
                        .map(|(line, (pixels, values))| (rows[piece * lines + line], row(pixels, values, columns, n)))
                        .collect(),
                );
            }
            all
        };
        let pieces: Vec<Vec<Vec<(usize, RowSums)>>> =
            self.pixels.par_chunks_mut(lines * width).enumerate().map(of_piece).collect();
        for at in 0..images.len() {
            let mut tiles = [[0.0; PARTS]; FINE * FINE];
            for (row, sums) in pieces.iter().flat_map(|piece| &piece[at]) {
                for (column, sums) in sums.iter().enumerate() {
                    let tile = &mut tiles[row * FINE + column];
                    (0..PARTS).for_each(|part| tile[part] += sums[part]);
                }
            }
            self.tiles.push(tiles);
        }
        Ok(())
    }

    /// How many images were added.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Of each image the sums over each tile; where pixels are left out, they are those of all that are finite all the same.
    pub(super) fn tiles(&self) -> &[TileSums] {
        &self.tiles
    }

    /// Whether some image is infinite or not a number in a pixel.
    pub(super) fn is_bad(&self, at: usize) -> bool {
        self.pixels[at].bad
    }

    pub(super) fn mean(&self, at: usize) -> [f64; 3] {
        self.pixels[at].mean
    }

    /// The variance of one image in a pixel.
    pub(super) fn variance(&self, at: usize) -> [f64; PARTS] {
        let freedom = (self.count as f64 - 1.0).max(1.0);
        self.pixels[at].squares.map(|sum| f64::from(sum) / freedom)
    }

    /// The sums of the cubes of deviations, and the largest value above the mean.
    pub(super) fn extremes(&self, at: usize) -> ([f64; 3], [f64; 3]) {
        let pixel = &self.pixels[at];
        let above = [0, 1, 2].map(|c: usize| (f64::from(pixel.largest[c]) - pixel.mean[c]).max(0.0));
        (pixel.cubes.map(f64::from), above)
    }

    /// The mean of all images; not a number where one of them is not finite.
    #[must_use]
    pub fn mean_image(&self) -> Image {
        self.image(|pixel| pixel.mean.map(|value| value as f32))
    }

    /// The variance of that mean.
    #[must_use]
    pub fn variance_image(&self) -> Image {
        let share = 1.0 / ((self.count as f64 - 1.0).max(1.0) * self.count.max(1) as f64);
        self.image(|pixel| [0, 1, 2].map(|c: usize| (f64::from(pixel.squares[c]) * share) as f32))
    }

    fn image(&self, value: impl Fn(&Pixel) -> [f32; 3] + Sync) -> Image {
        let of = |pixel: &Pixel| if pixel.bad { [f32::NAN; 3] } else { value(pixel) };
        Image { width: self.width, height: self.height, pixels: self.pixels.par_iter().map(of).collect() }
    }
}

/// Sums over the columns of tiles.
type RowSums = [[f64; PARTS]; FINE];

/// Adds a row of the `n`th image, and gives its sums.
fn row(pixels: &mut [Pixel], values: &[[f32; 3]], columns: &[usize], n: f64) -> RowSums {
    let mut sums = [[0.0; PARTS]; FINE];
    let share = n.recip();
    for ((pixel, value), column) in pixels.iter_mut().zip(values).zip(columns) {
        pixel.add(*value, n, share);
        if finite(value) {
            let [r, g, b] = value.map(f64::from);
            let sum = &mut sums[*column];
            [r, g, b, (r + g + b) / 3.0].into_iter().zip(sum).for_each(|(value, sum)| *sum += value);
        }
    }
    sums
}

impl Pixel {
    /// Adds the `n`th value, `share` being 1 / `n` (Terriberry's update of central moments).
    fn add(&mut self, value: [f32; 3], n: f64, share: f64) {
        if !finite(&value) || self.bad {
            self.bad = true;
            return;
        }
        let grey = |values: [f64; 3]| (values[0] + values[1] + values[2]) * (1.0 / 3.0);
        let off = grey(value.map(f64::from)) - grey(self.mean);
        self.squares[3] += (off * off * (n - 1.0) * share) as f32;
        for (c, value) in value.into_iter().enumerate() {
            let off = f64::from(value) - self.mean[c];
            let step = off * share;
            let square = off * step * (n - 1.0);
            let squares = f64::from(self.squares[c]);
            self.cubes[c] += (square * step * (n - 2.0) - 3.0 * step * squares) as f32;
            self.squares[c] = (squares + square) as f32;
            self.mean[c] += step;
            self.largest[c] = self.largest[c].max(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_plain_sums() {
        let values = [1.0_f32, 2.0, 6.0, 2.5, 0.25];
        let image = |value: f32| Image { width: 2, height: 1, pixels: vec![[value, 2.0 * value, 3.0], [0.5; 3]] };
        let mut moments = Moments::new(2, 1);
        values.iter().for_each(|value| moments.add(&image(*value)).expect("one size"));
        let n = values.len() as f64;
        let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / n;
        let power = |power: i32| values.iter().map(|value| (f64::from(*value) - mean).powi(power)).sum::<f64>();
        assert!((moments.mean(0)[0] - mean).abs() < 1e-12);
        assert!((moments.variance(0)[0] - power(2) / (n - 1.0)).abs() < 1e-5);
        assert!((moments.variance(0)[1] - 4.0 * power(2) / (n - 1.0)).abs() < 1e-4);
        // Grey is the value itself and a constant.
        assert!((moments.variance(0)[3] - power(2) / (n - 1.0)).abs() < 1e-5);
        let (cubes, above) = moments.extremes(0);
        assert!((cubes[0] - power(3)).abs() < 1e-4, "{} for {}", cubes[0], power(3));
        assert!((above[0] - (6.0 - mean)).abs() < 1e-6);
        assert_eq!((moments.variance(1)[0], moments.mean_image().pixels[1]), (0.0, [0.5; 3]));
        let of_mean = f64::from(moments.variance_image().pixels[0][0]);
        assert!((of_mean - power(2) / (n - 1.0) / n).abs() < 1e-5);
    }

    #[test]
    fn a_pixel_that_is_once_not_finite_has_no_mean() {
        let mut moments = Moments::new(1, 1);
        for value in [1.0, f32::INFINITY, 1.0] {
            moments.add(&Image::filled(1, 1, [1.0, value, 1.0])).expect("one size");
        }
        assert!(moments.is_bad(0) && moments.mean_image().non_finite() == 1);
        assert!(moments.add(&Image::filled(2, 1, [1.0; 3])).is_err());
    }
}
