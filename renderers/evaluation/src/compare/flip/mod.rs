//! FLIP, the difference that a person sees who flips between two images: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström,
//! Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020; and for radiance its maximum over exposures, Andersson,
//! Nilsson, Shirley, Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images", 2021.
//!
//! Our own code. Its formulas and constants are those of the papers from memory; that they are the right ones is shown by NVIDIA's
//! `flip-evaluator` 1.7, whose numbers it has (docs/metrics.md, and tests below). Images are worked on in
//! tiles, each with the pixels around it that its filters reach; beyond its border an image goes on as it ends.

mod color;
mod exposure;
mod filter;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

pub use exposure::Exposures;

use color::{Scale, distance, opponent, perceived};
use filter::{Filters, HALO, LANES};

/// The longest side of a tile, whose planes then stay in a processor's cache.
const TILE: usize = 128;

/// Two images of as many pixels in rows of one width, all finite.
#[derive(Clone, Copy)]
pub(super) struct Colors<'c> {
    pub a: &'c [[f32; 3]],
    pub b: &'c [[f32; 3]],
    pub width: usize,
}

/// The FLIP of each pixel, 0 to 1, of images in linear sRGB whose values lie between 0 and 1; others are clamped.
pub(super) fn ldr(colors: Colors) -> Vec<f32> {
    map(colors, &[1.0], |value, _| value.clamp(0.0, 1.0))
}

/// The HDR-FLIP of each pixel at these exposures, 0 to 1.
pub(super) fn hdr(colors: Colors, exposures: &Exposures) -> Vec<f32> {
    map(colors, &exposures.gains().collect::<Vec<_>>(), exposure::aces)
}

/// The largest FLIP of each pixel over all factors, values being mapped by `tone`.
fn map(colors: Colors, gains: &[f32], tone: impl Fn(f32, f32) -> f32 + Sync) -> Vec<f32> {
    let width = colors.width;
    let height = colors.a.len().checked_div(width).unwrap_or_default();
    let starts = |size: usize| (0..size).step_by(TILE);
    let places: Vec<(usize, usize)> = starts(height).flat_map(|y| starts(width).map(move |x| (x, y))).collect();
    let (filters, scale) = (Filters::new(), Scale::new());
    let tiles: Vec<(usize, Vec<f32>)> = places
        .par_iter()
        .map_init(Work::default, |work, &(x, y)| {
            let inside = ((width - x).min(TILE), (height - y).min(TILE));
            work.load(colors, (x, y), inside);
            let mut found = vec![0.0; work.width * work.height];
            for gain in gains {
                work.raise(&mut found, &filters, &scale, |value| tone(value, *gain));
            }
            (work.width, found)
        })
        .collect();
    let mut all = vec![0.0; colors.a.len()];
    for (&(x, y), (pitch, tile)) in places.iter().zip(&tiles) {
        let count = (width - x).min(TILE);
        for (row, values) in tile.chunks_exact(*pitch).enumerate() {
            all[(y + row) * width + x..][..count].copy_from_slice(&values[..count]);
        }
    }
    all
}

/// A plane of numbers for each channel.
type Planes = [Vec<f32>; 3];

/// What a thread needs for a tile.
#[derive(Default)]
struct Work {
    /// Pixels in a row, some of them perhaps beyond the image, so that rows are multiples of [`LANES`].
    width: usize,
    height: usize,
    /// Both images with the pixels around the tile.
    images: [Planes; 2],
    opponent: Planes,
    /// Filtered along rows, with the rows above and below.
    across: Planes,
    seen: [Seen; 2],
}

/// An image as it is perceived.
#[derive(Default)]
struct Seen {
    /// Filtered opponent colors; blue and yellow is a sum of the last two.
    color: [Vec<f32>; 4],
    /// Edges and points, each along rows and columns.
    edges: [Vec<f32>; 2],
    points: [Vec<f32>; 2],
}

impl Work {
    /// Takes a tile and what lies around it.
    fn load(&mut self, colors: Colors, (left, top): (usize, usize), (width, height): (usize, usize)) {
        (self.width, self.height) = (width.next_multiple_of(LANES), height);
        let rows = colors.a.len() / colors.width;
        let columns: Vec<usize> =
            (left..left + self.width + 2 * HALO).map(|at| at.saturating_sub(HALO).min(colors.width - 1)).collect();
        for (planes, image) in self.images.iter_mut().zip([colors.a, colors.b]) {
            for (channel, plane) in planes.iter_mut().enumerate() {
                plane.clear();
                for row in top..top + height + 2 * HALO {
                    let row = row.saturating_sub(HALO).min(rows - 1);
                    let row = &image[row * colors.width..][..colors.width];
                    plane.extend(columns.iter().map(|column| row[*column][channel]));
                }
            }
        }
    }

    /// Raises each pixel of `found` to its FLIP where that is more.
    fn raise(&mut self, found: &mut [f32], filters: &Filters, scale: &Scale, tone: impl Fn(f32) -> f32) {
        for image in 0..2 {
            self.see(image, filters, &tone);
        }
        let count = found.len();
        let [a, b] = &self.seen;
        let [a, b] = [a, b].map(|seen| {
            let [x, y, z, _] = &seen.color;
            [x, y, z, &seen.edges[0], &seen.edges[1], &seen.points[0], &seen.points[1]].map(|plane| &plane[..count])
        });
        let [distances, features, _] = &mut self.across;
        let (distances, features) = (&mut distances[..count], &mut features[..count]);
        // Apart from the powers, so that it works on several pixels at once.
        for at in 0..count {
            let length = |planes: &[&[f32]; 7], from: usize| {
                (planes[from][at] * planes[from][at] + planes[from + 1][at] * planes[from + 1][at]).sqrt()
            };
            let edge = (length(&a, 3) - length(&b, 3)).abs();
            let point = (length(&a, 5) - length(&b, 5)).abs();
            features[at] = (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).sqrt().min(1.0);
            distances[at] = distance([a[0][at], a[1][at], a[2][at]], [b[0][at], b[1][at], b[2][at]]);
        }
        for ((most, distance), feature) in found.iter_mut().zip(distances).zip(features) {
            // Most images of a scene are equal somewhere.
            if *distance > 0.0 {
                *most = most.max(scale.difference(*distance).powf(1.0 - *feature));
            }
        }
    }

    /// Filters an image.
    fn see(&mut self, image: usize, filters: &Filters, tone: impl Fn(f32) -> f32) {
        let (width, height) = (self.width, self.height);
        let (above, padded) = (height + 2 * HALO, (width + 2 * HALO) * (height + 2 * HALO));
        self.opponent.iter_mut().for_each(|plane| plane.resize(padded, 0.0));
        self.across.iter_mut().for_each(|plane| plane.resize(width * above, 0.0));
        let seen = &mut self.seen[image];
        let planes = seen.color.iter_mut().chain(&mut seen.edges).chain(&mut seen.points);
        planes.for_each(|plane| plane.resize(width * height, 0.0));
        // Slices of one length, so that the loops need no checks and work on several pixels at once.
        let [red, green, blue] = self.images[image].each_ref().map(|plane| &plane[..padded]);
        let [y, red_green, blue_yellow] = self.opponent.each_mut().map(|plane| &mut plane[..padded]);
        for at in 0..padded {
            [y[at], red_green[at], blue_yellow[at]] = opponent([tone(red[at]), tone(green[at]), tone(blue[at])]);
        }
        let [first, second, third] = &mut self.across;
        let [own_y, own_red, own_blue, other] = &mut seen.color;
        filters.luminance.rows(y, width, above, [first]);
        filters.luminance.columns(first, width, height, [own_y]);
        filters.red_green.rows(red_green, width, above, [first]);
        filters.red_green.columns(first, width, height, [own_red]);
        filters.blue_yellow.rows(blue_yellow, width, above, [first, second]);
        filters.blue_yellow_down[0].columns(first, width, height, [own_blue]);
        filters.blue_yellow_down[1].columns(second, width, height, [other]);
        let count = width * height;
        let (own_y, own_red) = (&mut own_y[..count], &mut own_red[..count]);
        let (own_blue, other) = (&mut own_blue[..count], &other[..count]);
        for at in 0..count {
            let found = perceived([own_y[at], own_red[at], own_blue[at] + other[at]]);
            [own_y[at], own_red[at], own_blue[at]] = found;
        }
        filters.features.rows(y, width, above, [first, second, third]);
        let ([edge, edge_down], [point, point_down]) = (&mut seen.edges, &mut seen.points);
        filters.features_smooth.columns(first, width, height, [edge]);
        filters.features_smooth.columns(second, width, height, [point]);
        filters.features_down.columns(third, width, height, [edge_down, point_down]);
    }
}
