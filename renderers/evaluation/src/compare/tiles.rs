//! Ratios of means over a grid of tiles: where in the image a difference lies.

use serde::{Deserialize, Serialize};

use super::{Pair, Value};
use ltsc_render::image::finite;

/// The share of the image's mean in A that is added to a tile's, so that tiles which hold almost
/// no light do not look the worst for their noise alone (0.05 separated noise from error when
/// caustics of Mitsuba, LuxCore and Cycles were compared).
const DARK: f64 = 0.05;

/// Ratio B/A of the means over one tile; nothing where A is black or no pixel is finite.
pub type Tile = Value;

/// A grid of ratios.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tiles {
    /// Rows of tiles from the top, each from the left.
    pub rows: Vec<Vec<Tile>>,
    /// The tile whose ratio over all channels is farthest from 1; none where all are 1.
    pub worst: Option<WorstTile>,
    /// The tile with the largest guarded deviation (see [`WorstTile::deviation`]).
    pub worst_guarded: Option<WorstTile>,
}

/// A tile that stands out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorstTile {
    /// Column of the tile, from the left, beginning with 0.
    pub column: usize,
    /// Row of the tile, from the top, beginning with 0.
    pub row: usize,
    /// Ratio B/A over all channels; nothing where A is black.
    pub ratio: Option<f64>,
    /// `|b - a| / (a + 0.05 m)` over all channels, where a and b are the means of the tile and m
    /// is that of the whole A: a deviation that stays small in tiles that are almost black. No
    /// value if A is black as a whole.
    pub deviation: Option<f64>,
}

/// Divides the images into `wanted` by `wanted` tiles whose sides differ by at most one pixel.
pub(super) fn tiles(pair: &Pair, wanted: usize) -> Tiles {
    let columns = wanted.clamp(1, pair.a.width);
    let lines = wanted.clamp(1, pair.a.height);
    let image = pair.mean(|a, _, _| a).map_or(0.0, |means| means.iter().sum::<f64>() / 3.0);
    let mut found = Vec::with_capacity(lines);
    let mut all = Vec::with_capacity(lines * columns);
    for row in 0..lines {
        let mut tiles = Vec::with_capacity(columns);
        for column in 0..columns {
            let means = means(pair, (column, columns), (row, lines));
            let value = means.map_or(Value::NONE, |(a, b)| Value::of_ratio(a, b));
            if let Some((a, b)) = means {
                let (a, b) = (a.iter().sum::<f64>() / 3.0, b.iter().sum::<f64>() / 3.0);
                let divisor = a + DARK * image;
                let deviation = (divisor > 0.0).then(|| (b - a).abs() / divisor);
                all.push(WorstTile { column, row, ratio: value.overall, deviation });
            }
            tiles.push(value);
        }
        found.push(tiles);
    }
    let from_one = |tile: &WorstTile| tile.ratio.map(|ratio| (ratio - 1.0).abs());
    Tiles { rows: found, worst: largest(&all, from_one), worst_guarded: largest(&all, |tile| tile.deviation) }
}

/// The first tile with the largest value above 0.
fn largest(tiles: &[WorstTile], value: impl Fn(&WorstTile) -> Option<f64>) -> Option<WorstTile> {
    let mut best: Option<(f64, WorstTile)> = None;
    for tile in tiles {
        if let Some(value) = value(tile)
            && value > best.map_or(0.0, |(most, _)| most)
        {
            best = Some((value, *tile));
        }
    }
    best.map(|(_, tile)| tile)
}

/// Means of A and B over the finite pixels of part `column.0` of `column.1`, and the same in rows.
fn means(pair: &Pair, column: (usize, usize), row: (usize, usize)) -> Option<([f64; 3], [f64; 3])> {
    let range = |(index, count): (usize, usize), size: usize| index * size / count..(index + 1) * size / count;
    let (mut a, mut b, mut count) = ([0.0; 3], [0.0; 3], 0_usize);
    for y in range(row, pair.a.height) {
        for x in range(column, pair.a.width) {
            let (left, right) = (pair.a.at(x, y), pair.b.at(x, y));
            if finite(&left) && finite(&right) {
                for channel in 0..3 {
                    a[channel] += f64::from(left[channel]);
                    b[channel] += f64::from(right[channel]);
                }
                count += 1;
            }
        }
    }
    let share = |sums: [f64; 3]| sums.map(|sum| sum / count as f64);
    (count > 0).then(|| (share(a), share(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltsc_render::image::Image;

    #[test]
    fn a_changed_quarter_is_the_worst_tile() {
        let a = Image::filled(10, 6, [1.0, 2.0, 0.0]);
        let mut b = a.clone();
        for y in 0..3 {
            for x in 5..10 {
                b.pixels[y * 10 + x] = [1.5, 1.5, 0.0];
            }
        }
        // A brighter tile elsewhere is closer to 1.
        for y in 3..6 {
            for x in 0..5 {
                b.pixels[y * 10 + x] = [1.0, 2.2, 0.0];
            }
        }
        let b = Image { pixels: b.pixels, ..b };
        let found = tiles(&Pair::new(&a, &b).expect("a pair"), 2);
        assert_eq!(found.rows[0][0].overall, Some(1.0));
        assert_eq!(found.rows[0][1].channels, [Some(1.5), Some(0.75), None]);
        assert_eq!(found.rows[0][1].overall, Some(1.0));
        let worst = found.worst.expect("a worst tile");
        assert_eq!((worst.column, worst.row), (0, 1));
        assert!((worst.ratio.expect("a ratio") - 3.2 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn dark_tiles_do_not_lead_the_guarded_list() {
        let mut a = Image::filled(4, 1, [1.0; 3]);
        a.pixels[0] = [1e-6; 3];
        a.pixels[3] = [0.0; 3];
        let mut b = a.clone();
        b.pixels[0] = [5e-6; 3];
        b.pixels[1] = [1.25; 3];
        b.pixels[3] = [1e-6; 3];
        let found = tiles(&Pair::new(&a, &b).expect("a pair"), 8);
        assert_eq!(found.rows.len(), 1);
        assert_eq!(found.rows[0].len(), 4);
        assert_eq!(found.rows[0][3].overall, None);
        assert_eq!(found.worst.map(|tile| tile.column), Some(0));
        assert_eq!(found.worst_guarded.map(|tile| tile.column), Some(1));
    }

    #[test]
    fn equal_images_have_no_worst_tile() {
        let mut a = Image::filled(4, 1, [1.0; 3]);
        a.pixels[3] = [0.0; 3];
        let found = tiles(&Pair::new(&a, &a).expect("a pair"), 4);
        assert_eq!((found.worst, found.worst_guarded), (None, None));
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (size, count) in [(7, 3), (8, 8), (1, 1), (129, 8)] {
            let ends: Vec<usize> = (0..=count).map(|index| index * size / count).collect();
            assert_eq!((ends[0], ends[count]), (0, size));
            assert!(ends.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
