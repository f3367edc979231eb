//! Numbers taken from an image.

use std::ops::Range;

use crate::compare::{CompareOptions, compare};
use ltsc_render::image::Image;

use super::kinds::{Axis, Channel, Measure, Region};

/// The whole pixels that a region covers; at least one each way.
pub fn pixels(region: &Region, (width, height): (usize, usize)) -> (Range<usize>, Range<usize>) {
    let range = |(from, to): (f64, f64), size: usize| {
        let first = ((from * size as f64).round() as usize).min(size - 1);
        let end = ((to * size as f64).round() as usize).clamp(first + 1, size);
        first..end
    };
    (range(region.x, width), range(region.y, height))
}

/// The number, or none where the image has none: a value that is not finite, or no light to find a middle of. `ideal` is the true
/// image, for shifts.
pub fn measure(measure: &Measure, image: &Image, ideal: &dyn Fn() -> Image) -> Option<f64> {
    let size = (image.width, image.height);
    let found = match measure {
        Measure::Mean(region, channel) => {
            let (columns, rows) = pixels(region, size);
            let count = (columns.len() * rows.len()) as f64;
            let sum: f64 = rows.map(|y| columns.clone().map(|x| value(image, x, y, *channel)).sum::<f64>()).sum();
            sum / count
        }
        Measure::Covered(region, axis) => {
            let (columns, rows) = pixels(region, size);
            let across = match axis {
                Axis::X => rows.len(),
                Axis::Y => columns.len(),
            };
            let sum: f64 = rows.map(|y| columns.clone().map(|x| value(image, x, y, Channel::All)).sum::<f64>()).sum();
            sum / across as f64
        }
        Measure::Middle(channel, axis) => {
            let (mut sum, mut weighed) = (0.0, 0.0);
            for y in 0..image.height {
                for x in 0..image.width {
                    let light = value(image, x, y, *channel);
                    let place = match axis {
                        Axis::X => x,
                        Axis::Y => y,
                    };
                    sum += light;
                    weighed += light * (place as f64 + 0.5);
                }
            }
            weighed / sum
        }
        Measure::Shift(axis) => {
            let options = CompareOptions { any_shift: true, only: &["ratio"], ..CompareOptions::default() };
            let shift = compare(&ideal(), image, &options).ok()?.shift?;
            // What moves the image onto the true one; the image itself lies the other way.
            -(match axis {
                Axis::X => shift.dx,
                Axis::Y => shift.dy,
            } as f64)
        }
    };
    found.is_finite().then_some(found + 0.0)
}

fn value(image: &Image, x: usize, y: usize, channel: Channel) -> f64 {
    let [red, green, blue] = image.at(x, y).map(f64::from);
    match channel {
        Channel::Red => red,
        Channel::Green => green,
        Channel::Blue => blue,
        Channel::All => (red + green + blue) / 3.0,
    }
}

/// One of three channels.
pub fn of(channels: [f64; 3], channel: Channel) -> f64 {
    match channel {
        Channel::Red => channels[0],
        Channel::Green => channels[1],
        Channel::Blue => channels[2],
        Channel::All => channels.iter().sum::<f64>() / 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::kinds::area;
    use super::*;

    /// A white square from column and row 2 to before 6 in 8 x 8 pixels.
    fn square() -> Image {
        let mut image = Image::filled(8, 8, [0.0; 3]);
        for y in 2..6 {
            for x in 2..6 {
                image.pixels[y * 8 + x] = [1.0, 0.5, 0.0];
            }
        }
        image
    }

    fn found(kind: Measure, image: &Image) -> Option<f64> {
        measure(&kind, image, &square)
    }

    #[test]
    fn regions_are_whole_pixels() {
        assert_eq!(pixels(&Region::ALL, (48, 16)), (0..48, 0..16));
        assert_eq!(pixels(&area(0.25, 0.5, 0.5, 1.0), (8, 4)), (2..4, 2..4));
        assert_eq!(pixels(&area(0.99, 1.0, 0.5, 0.51), (8, 4)), (7..8, 2..3));
    }

    #[test]
    fn means_and_extents() {
        let image = square();
        assert_eq!(found(Measure::Mean(area(0.25, 0.75, 0.25, 0.75), Channel::Red), &image), Some(1.0));
        assert_eq!(found(Measure::Mean(Region::ALL, Channel::Green), &image), Some(0.125));
        assert_eq!(found(Measure::Mean(Region::ALL, Channel::All), &image), Some(0.125));
        assert_eq!(found(Measure::Covered(area(0.0, 1.0, 0.375, 0.625), Axis::X), &image), Some(2.0));
        assert_eq!(found(Measure::Covered(area(0.375, 0.5, 0.0, 1.0), Axis::Y), &image), Some(2.0));
    }

    #[test]
    fn middles_and_shifts() {
        let image = square();
        assert_eq!(found(Measure::Middle(Channel::Red, Axis::X), &image), Some(4.0));
        assert_eq!(found(Measure::Middle(Channel::Blue, Axis::X), &image), None, "no light has no middle");
        assert_eq!(found(Measure::Shift(Axis::Y), &image), Some(0.0));
        let mut down = image.clone();
        down.pixels.rotate_right(8);
        assert_eq!(found(Measure::Shift(Axis::Y), &down), Some(1.0), "one row down is plus one");
        assert_eq!(found(Measure::Shift(Axis::X), &down), Some(0.0));
        assert_eq!(found(Measure::Middle(Channel::Red, Axis::Y), &down), Some(5.0));
    }

    #[test]
    fn what_is_not_finite_is_no_number() {
        let mut image = square();
        image.pixels[20] = [f32::NAN, 0.0, 0.0];
        assert_eq!(found(Measure::Mean(Region::ALL, Channel::Red), &image), None);
        image.pixels[20] = [f32::INFINITY, 0.0, 0.0];
        assert_eq!(found(Measure::Mean(Region::ALL, Channel::Red), &image), None);
    }
}
