//! Moments of each pixel over several images, gathered piece by piece of the picture over all images, so that memory does not grow with
//! their number, and what is known of a piece stays near the processor.

use rayon::prelude::*;

use ltsc_render::image::{Image, finite};

use super::CompareError;

/// Red, green, blue, and the mean of the three.
pub(super) const PARTS: usize = 4;

/// Pixels that are looked at in all images before the next ones; whole rows.
const PIECE: usize = 1 << 12;

/// Pieces of the picture that one thread takes at a time.
const BAND: usize = 32;

/// Tiles along each side whose sums are kept of each image.
pub(super) const FINE: usize = 8;

/// Sums of an image over the pixels of each tile, in each part.
pub(super) type TileSums = [[f64; PARTS]; FINE * FINE];

/// The tile of the finest grid that each column, or row, lies in.
pub(super) fn tile_of(size: usize) -> Vec<usize> {
    (0..FINE).flat_map(|at| std::iter::repeat_n(at, starts(size, at + 1) - starts(size, at))).collect()
}

/// Where a tile of the finest grid begins.
pub(super) fn starts(size: usize, tile: usize) -> usize {
    tile * size / FINE
}

/// Images whose rows are asked for, from the first to the last.
pub(super) trait Rows {
    /// The rows of the image `at` from row `from` on, as many as `pixels` holds; those that are in memory are given as they are, others
    /// are put there.
    fn rows<'p>(
        &'p mut self,
        at: usize,
        from: usize,
        pixels: &'p mut [[f32; 3]],
    ) -> Result<&'p [[f32; 3]], CompareError>;
}

/// The moments of all pixels; 61 bytes for each, whatever the number of images.
pub struct Moments {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    count: usize,
    pixels: Pixels<Vec<f64>, Vec<f32>, Vec<bool>>,
    /// Of each image, over the pixels that are finite in it.
    tiles: Vec<TileSums>,
    rows: Vec<usize>,
}

/// Pixels over the images that were added: three numbers for each, but where it says otherwise.
struct Pixels<D, S, B> {
    mean: D,
    /// Sums of the squares of the deviations from the mean.
    squares: S,
    /// The same of the mean of red, green and blue, one number for each.
    grey: S,
    /// Sums of their cubes.
    cubes: S,
    /// The largest value.
    largest: S,
    /// Whether some image is not finite here, one for each.
    bad: B,
}

/// Some of the rows.
type Part<'p> = Pixels<&'p mut [f64], &'p mut [f32], &'p mut [bool]>;

impl Pixels<Vec<f64>, Vec<f32>, Vec<bool>> {
    fn new(count: usize) -> Self {
        Self {
            mean: vec![0.0; 3 * count],
            squares: vec![0.0; 3 * count],
            grey: vec![0.0; count],
            cubes: vec![0.0; 3 * count],
            largest: vec![f32::MIN; 3 * count],
            bad: vec![false; count],
        }
    }

    fn whole(&mut self) -> Part<'_> {
        let Self { mean, squares, grey, cubes, largest, bad } = self;
        Pixels { mean, squares, grey, cubes, largest, bad }
    }
}

impl<'p> Part<'p> {
    /// The first `count` pixels, and the others.
    fn split(self, count: usize) -> (Self, Self) {
        let count = count.min(self.bad.len());
        let (mean, means) = self.mean.split_at_mut(3 * count);
        let (squares, more_squares) = self.squares.split_at_mut(3 * count);
        let (grey, greys) = self.grey.split_at_mut(count);
        let (cubes, more_cubes) = self.cubes.split_at_mut(3 * count);
        let (largest, more_largest) = self.largest.split_at_mut(3 * count);
        let (bad, more_bad) = self.bad.split_at_mut(count);
        let rest = Pixels {
            mean: means,
            squares: more_squares,
            grey: greys,
            cubes: more_cubes,
            largest: more_largest,
            bad: more_bad,
        };
        (Pixels { mean, squares, grey, cubes, largest, bad }, rest)
    }

    /// All of them, `count` at a time.
    fn pieces(self, count: usize) -> Vec<Self> {
        let (mut all, mut rest) = (Vec::new(), self);
        while !rest.bad.is_empty() {
            let (first, others) = rest.split(count);
            all.push(first);
            rest = others;
        }
        all
    }

    /// Adds the `n`th value of each (Terriberry's update of central moments), all of which are finite.
    fn add(&mut self, values: &[[f32; 3]], n: f64) {
        const THIRD: f64 = 1.0 / 3.0;
        let share = n.recip();
        let grey = values.iter().zip(self.mean.as_chunks::<3>().0).zip(&mut *self.grey);
        for ((value, mean), squares) in grey {
            let value = value.map(f64::from);
            let off = (value[0] + value[1] + value[2]) * THIRD - (mean[0] + mean[1] + mean[2]) * THIRD;
            *squares += (off * off * (n - 1.0) * share) as f32;
        }
        let sums = self.squares.iter_mut().zip(&mut *self.cubes).zip(&mut *self.largest);
        for ((value, mean), ((squares, cubes), largest)) in values.as_flattened().iter().zip(&mut *self.mean).zip(sums)
        {
            let off = f64::from(*value) - *mean;
            let step = off * share;
            let square = off * step * (n - 1.0);
            let before = f64::from(*squares);
            *cubes += (square * step * (n - 2.0) - 3.0 * step * before) as f32;
            *squares = (before + square) as f32;
            *mean += step;
            *largest = if *value > *largest { *value } else { *largest };
        }
    }

    /// The same where some may not be finite, or were not in images before.
    fn add_each(&mut self, values: &[[f32; 3]], n: f64) {
        for (at, value) in values.iter().enumerate() {
            self.bad[at] |= !finite(value);
            if !self.bad[at] {
                let three = 3 * at..3 * at + 3;
                let mut one = Pixels {
                    mean: &mut self.mean[three.clone()],
                    squares: &mut self.squares[three.clone()],
                    grey: &mut self.grey[at..=at],
                    cubes: &mut self.cubes[three.clone()],
                    largest: &mut self.largest[three],
                    bad: &mut self.bad[at..=at],
                };
                one.add(std::slice::from_ref(value), n);
            }
        }
    }
}

impl Moments {
    /// Of no image yet.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        let rows = tile_of(height);
        Self { width, height, count: 0, pixels: Pixels::new(width * height), tiles: Vec::new(), rows }
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
        let mut all = Self { count, ..Self::new(mean.width, mean.height) };
        for (at, (value, variance)) in mean.pixels.iter().zip(&variance.pixels).enumerate() {
            let squares = variance.map(|part| f64::from(part) * freedom);
            let grey = (squares.iter().map(|part| part.max(0.0).sqrt()).sum::<f64>() / 3.0).powi(2);
            let three = 3 * at..3 * at + 3;
            all.pixels.mean[three.clone()].copy_from_slice(&value.map(f64::from));
            all.pixels.squares[three.clone()].copy_from_slice(&squares.map(|sum| sum as f32));
            all.pixels.grey[at] = grey as f32;
            all.pixels.largest[three].copy_from_slice(value);
            all.pixels.bad[at] = !finite(value) || !finite(variance);
        }
        Ok(all)
    }

    /// Adds an image.
    ///
    /// # Errors
    /// If its size is another one.
    pub fn add(&mut self, image: &Image) -> Result<(), CompareError> {
        self.add_all(&[image])
    }

    /// Adds images that are in memory.
    ///
    /// # Errors
    /// If one has another size; none is added then.
    pub fn add_all(&mut self, images: &[&Image]) -> Result<(), CompareError> {
        struct Held<'i>(&'i [&'i Image]);
        impl Rows for Held<'_> {
            fn rows<'p>(
                &'p mut self,
                at: usize,
                from: usize,
                pixels: &'p mut [[f32; 3]],
            ) -> Result<&'p [[f32; 3]], CompareError> {
                let image = self.0[at];
                let start = from * image.width;
                Ok(&image.pixels[start..start + pixels.len()])
            }
        }
        let size = (self.width, self.height);
        if let Some(image) = images.iter().find(|image| (image.width, image.height) != size) {
            return Err(CompareError::Size { a: size, b: (image.width, image.height) });
        }
        self.gather(images.len(), || Ok(Held(images)))
    }

    /// Adds `count` images of this size, the rows of which `open` gives; it is asked once for each band of the picture. Sums are put together
    /// in the order of rows, so that they do not depend on the machine.
    ///
    /// # Errors
    /// As of `open` and what it gives; this is of no use then.
    pub(super) fn gather<R: Rows>(
        &mut self,
        count: usize,
        open: impl Fn() -> Result<R, CompareError> + Sync,
    ) -> Result<(), CompareError> {
        let (first, width, rows) = (self.count, self.width, &self.rows);
        self.count += count;
        if self.width == 0 {
            return Ok(());
        }
        let lines = (PIECE / width).max(1);
        // Of each row the sums of each image.
        let of_band = |(band, pixels): (usize, Part<'_>)| -> Result<Vec<Vec<RowSums>>, CompareError> {
            let mut images = open()?;
            let mut buffer = vec![[0.0; 3]; lines * width];
            let mut all = Vec::new();
            for (piece, pixels) in pixels.pieces(lines * width).into_iter().enumerate() {
                let from = (band * BAND + piece) * lines;
                let mut of_lines: Vec<(Part<'_>, Vec<RowSums>)> =
                    pixels.pieces(width).into_iter().map(|line| (line, Vec::with_capacity(count))).collect();
                let buffer = &mut buffer[..of_lines.len() * width];
                for at in 0..count {
                    let values = images.rows(at, from, buffer)?;
                    for ((line, sums), values) in of_lines.iter_mut().zip(values.chunks_exact(width)) {
                        sums.push(row(line, values, (first + at + 1) as f64));
                    }
                }
                all.extend(of_lines.into_iter().map(|(_, sums)| sums));
            }
            Ok(all)
        };
        let bands = self.pixels.whole().pieces(BAND * lines * width);
        let bands: Vec<Vec<Vec<RowSums>>> =
            bands.into_par_iter().enumerate().map(of_band).collect::<Result<_, CompareError>>()?;
        let of_image = |at: usize| {
            let mut tiles = [[0.0; PARTS]; FINE * FINE];
            for (sums, row) in bands.iter().flatten().zip(rows) {
                for (column, sums) in sums[at].iter().enumerate() {
                    let tile = &mut tiles[row * FINE + column];
                    (0..PARTS).for_each(|part| tile[part] += sums[part]);
                }
            }
            tiles
        };
        self.tiles.extend((0..count).map(of_image));
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
        self.pixels.bad[at]
    }

    pub(super) fn mean(&self, at: usize) -> [f64; 3] {
        of(&self.pixels.mean, at)
    }

    /// The variance of one image in a pixel.
    pub(super) fn variance(&self, at: usize) -> [f64; PARTS] {
        let freedom = (self.count as f64 - 1.0).max(1.0);
        let [r, g, b] = of(&self.pixels.squares, at);
        [r, g, b, self.pixels.grey[at]].map(|sum| f64::from(sum) / freedom)
    }

    /// The sums of the cubes of deviations, and the largest value above the mean.
    pub(super) fn extremes(&self, at: usize) -> ([f64; 3], [f64; 3]) {
        let (mean, largest) = (self.mean(at), of(&self.pixels.largest, at));
        let above = [0, 1, 2].map(|c: usize| (f64::from(largest[c]) - mean[c]).max(0.0));
        (of(&self.pixels.cubes, at).map(f64::from), above)
    }

    /// The mean of all images; not a number where one of them is not finite.
    #[must_use]
    pub fn mean_image(&self) -> Image {
        self.image(|at| self.mean(at).map(|value| value as f32))
    }

    /// The variance of that mean.
    #[must_use]
    pub fn variance_image(&self) -> Image {
        let share = 1.0 / ((self.count as f64 - 1.0).max(1.0) * self.count.max(1) as f64);
        self.image(|at| of(&self.pixels.squares, at).map(|sum| (f64::from(sum) * share) as f32))
    }

    fn image(&self, value: impl Fn(usize) -> [f32; 3] + Sync) -> Image {
        let of = |at: usize| if self.is_bad(at) { [f32::NAN; 3] } else { value(at) };
        let pixels = (0..self.width * self.height).into_par_iter().map(of).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}

/// The three numbers of a pixel.
fn of<T: Copy>(numbers: &[T], at: usize) -> [T; 3] {
    [numbers[3 * at], numbers[3 * at + 1], numbers[3 * at + 2]]
}

/// Sums over the columns of tiles.
type RowSums = [[f64; PARTS]; FINE];

/// Adds a row of the `n`th image, and gives its sums.
fn row(pixels: &mut Part<'_>, values: &[[f32; 3]], n: f64) -> RowSums {
    let clean = values.as_flattened().iter().fold(true, |all, value| all & value.is_finite());
    if clean && !pixels.bad.contains(&true) {
        pixels.add(values, n);
    } else {
        pixels.add_each(values, n);
    }
    let mut sums = [[0.0; PARTS]; FINE];
    for (tile, sum) in sums.iter_mut().enumerate() {
        for value in &values[starts(values.len(), tile)..starts(values.len(), tile + 1)] {
            if clean || finite(value) {
                let [r, g, b] = value.map(f64::from);
                [r, g, b, (r + g + b) / 3.0].into_iter().zip(&mut *sum).for_each(|(value, sum)| *sum += value);
            }
        }
    }
    sums
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
