//! Images of all directions: by longitude and latitude as the Scene has them, and on an equal-area octahedron (Clarberg 2008, "Fast
//! Equal-Area Mapping of the (Hemi)Sphere using SIMD"), as pbrt-v4 wants them.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use rayon::prelude::*;

use super::Pixels;
use crate::ir::Vec3;

/// The shortest side of an octahedral image: small images are interpolated between their pixels, and these are not.
const LEAST_SIDE: usize = 128;
/// The longest.
const MOST_SIDE: usize = 16_384;
/// How many pixels of an octahedral image are looked at to know how far it is off.
const LOOKED_AT: usize = 1 << 16;

/// The side of the octahedral image that stands for one by longitude and latitude: even, and twice as many pixels or more, so that
/// its pixels are smaller than the others are at the horizon.
pub fn side(of: [u32; 2]) -> usize {
    let pixels = 2.0 * f64::from(of[0]) * f64::from(of[1]);
    (libm::ceil(pixels.sqrt() / 2.0) as usize * 2).clamp(LEAST_SIDE, MOST_SIDE)
}

/// The direction at a place of the square, both coordinates 0..1. The middle is +z and the corners are -z; x grows with the first
/// coordinate and y with the second.
pub fn direction(place: [f64; 2]) -> Vec3 {
    let [u, v] = place.map(|x| 2.0 * x - 1.0);
    // The square's diamond is the upper half; beyond its edge the distance to the corner counts.
    let inside = 1.0 - (u.abs() + v.abs());
    let radius = 1.0 - inside.abs();
    let turn = if radius == 0.0 { 1.0 } else { (v.abs() - u.abs()) / radius + 1.0 };
    let angle = turn * FRAC_PI_4;
    let z = (1.0 - radius * radius).copysign(inside);
    let across = radius * (2.0 - radius * radius).sqrt();
    [libm::cos(angle).copysign(u) * across, libm::sin(angle).copysign(v) * across, z]
}

/// What an image by longitude and latitude has in a direction, interpolated between its pixels: its middle is +y, a quarter of the
/// width to the right of it is +x, its upper edge +z.
pub fn seen(image: &Pixels, [x, y, z]: Vec3) -> [f64; 3] {
    let (width, height) = (image.width as f64, image.height as f64);
    let u = (0.5 + libm::atan2(x, y) / TAU) * width - 0.5;
    let v = (libm::atan2((x * x + y * y).sqrt(), z) / PI * height - 0.5).clamp(0.0, height - 1.0);
    let (left, top) = (libm::floor(u), libm::floor(v));
    let column = |at: f64| (at as i64).rem_euclid(image.width as i64) as usize;
    let rows = [top as usize, (top as usize + 1).min(image.height - 1)];
    let (across, down) = (u - left, v - top);
    let corner = |x: f64, row: usize| image.at(column(x), row).map(f64::from);
    let [a, b] = rows.map(|row| mix(corner(left, row), corner(left + 1.0, row), across));
    mix(a, b, down)
}

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|at| a[at] + (b[at] - a[at]) * share)
}

/// The light of all directions together, each channel by itself: the integral of what [`seen`] gives.
fn power(image: &Pixels) -> [f64; 3] {
    let step = PI / image.height as f64;
    let mut sum = [0.0; 3];
    for row in 0..image.height {
        let middle = (row as f64 + 0.5) * step;
        // A hat over a row on each side; the first row and the last one reach their pole.
        let half = |sign: f64| {
            let end = middle + sign * step;
            sign * libm::cos(middle) - (libm::sin(end) - libm::sin(middle)) / step
        };
        let cap = 1.0 - libm::cos(step / 2.0);
        let above = if row == 0 { cap } else { half(-1.0) };
        let below = if row + 1 == image.height { cap } else { half(1.0) };
        let mut total = [0.0; 3];
        for column in 0..image.width {
            let color = image.at(column, row);
            [0, 1, 2].into_iter().for_each(|at| total[at] += f64::from(color[at]));
        }
        [0, 1, 2].into_iter().for_each(|at| sum[at] += total[at] * (above + below) * TAU / image.width as f64);
    }
    sum
}

/// What a pixel of an octahedral image of `side` gets: the mean over its directions, and how far they are from it in the mean.
fn texel(image: &Pixels, side: usize, at: [usize; 2]) -> ([f64; 3], f64) {
    // Each pixel has the same solid angle, and so has each part of it.
    let parts = if side <= 512 { 4 } else { 2 };
    let scale = 1.0 / (side * parts) as f64;
    let part = |axis: usize, index: usize| ((at[axis] * parts + index) as f64 + 0.5) * scale;
    let mut colors = [[0.0; 3]; 16];
    let count = parts * parts;
    for (index, color) in colors[..count].iter_mut().enumerate() {
        *color = seen(image, direction([part(0, index % parts), part(1, index / parts)]));
    }
    let mean = [0, 1, 2].map(|channel| colors[..count].iter().map(|color| color[channel]).sum::<f64>() / count as f64);
    let far = |color: &[f64; 3]| [0, 1, 2].iter().map(|at| (color[*at] - mean[*at]).abs()).sum::<f64>();
    (mean, colors[..count].iter().map(far).sum::<f64>() / count as f64)
}

/// The same image with a row between each two rows and one at each pole, for a renderer that lays the first row and the last one on
/// the poles: interpolated between its rows it is what the other is with its rows half a row away from them.
pub fn between_rows(image: Pixels) -> Pixels {
    let Pixels { width, height, channels, values } = image;
    let row = |at: usize| &values[at * width * channels..(at + 1) * width * channels];
    let mut made = Vec::with_capacity(values.len() * 2 + width * channels);
    made.extend_from_slice(row(0));
    for at in 0..height {
        made.extend_from_slice(row(at));
        let next = row((at + 1).min(height - 1));
        made.extend(row(at).iter().zip(next).map(|(a, b)| ((f64::from(*a) + f64::from(*b)) / 2.0) as f32));
    }
    Pixels { width, height: 2 * height + 1, channels, values: made }
}

/// A linear image by longitude and latitude as an octahedral one with the same light in each channel.
pub fn octahedral(image: &Pixels, side: usize) -> Pixels {
    let mut values = vec![0.0_f32; side * side * 3];
    let means: Vec<[f64; 3]> = values
        .par_chunks_exact_mut(side * 3)
        .enumerate()
        .map(|(row, line)| {
            let mut sum = [0.0; 3];
            for (column, pixel) in line.chunks_exact_mut(3).enumerate() {
                let (color, _) = texel(image, side, [column, row]);
                for ((value, part), sum) in pixel.iter_mut().zip(color).zip(&mut sum) {
                    *value = part as f32;
                    *sum += part;
                }
            }
            sum
        })
        .collect();
    // In the order of the rows, so that the sum is the same on every machine.
    let wanted = power(image);
    let solid = 4.0 * PI / (side * side) as f64;
    let scale = [0, 1, 2].map(|at| {
        let sum: f64 = means.iter().map(|row| row[at]).sum();
        if sum > 0.0 { wanted[at] / (sum * solid) } else { 1.0 }
    });
    for pixel in values.chunks_exact_mut(3) {
        pixel.iter_mut().zip(scale).for_each(|(value, scale)| *value = (f64::from(*value) * scale) as f32);
    }
    Pixels { width: side, height: side, channels: 3, values }
}

/// How far an octahedral image of `side` is from the image that it stands for, in the mean over directions and as a share of the mean.
pub fn off(image: &Pixels, side: usize) -> f64 {
    let every = (side * side).div_ceil(LOOKED_AT).max(1);
    let (mut far, mut sum) = (0.0, 0.0);
    for index in (0..side * side).step_by(every) {
        let (mean, off) = texel(image, side, [index % side, index / side]);
        far += off;
        sum += mean.iter().sum::<f64>();
    }
    if sum > 0.0 { far / sum } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(width: usize, height: usize, color: impl Fn(usize, usize) -> [f32; 3]) -> Pixels {
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| color(x, y)).collect();
        Pixels { width, height, channels: 3, values }
    }

    #[test]
    fn places_of_the_square_are_the_directions_of_the_octahedron() {
        let close = |place, wanted: Vec3| {
            let found = direction(place);
            assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{place:?} is {found:?}");
        };
        close([0.5, 0.5], [0.0, 0.0, 1.0]);
        close([1.0, 0.5], [1.0, 0.0, 0.0]);
        close([0.0, 0.5], [-1.0, 0.0, 0.0]);
        close([0.5, 1.0], [0.0, 1.0, 0.0]);
        close([0.5, 0.0], [0.0, -1.0, 0.0]);
        close([0.0, 0.0], [0.0, 0.0, -1.0]);
        // A corner's neighbor is below the horizon, on its own side.
        let [x, y, z] = direction([0.9, 0.8]);
        assert!(x > 0.0 && y > 0.0 && z < 0.0);
    }

    #[test]
    fn all_pixels_have_the_same_solid_angle() {
        // The share of directions with z above a bound is half of what lies above it (Archimedes).
        let side = 200;
        for bound in [-0.5, 0.0, 0.3, 0.9] {
            let above = (0..side * side).filter(|at| {
                let place = [at % side, at / side].map(|x| (x as f64 + 0.5) / side as f64);
                direction(place)[2] > bound
            });
            let share = above.count() as f64 / (side * side) as f64;
            assert!((share - (1.0 - bound) / 2.0).abs() < 0.01, "{bound}: {share}");
        }
    }

    #[test]
    fn light_is_kept_and_stays_in_its_direction() {
        // Six colors round the axes: the brightest pixel of each channel lies where it did.
        let image = sky(64, 32, |x, y| {
            let grows = |a: usize, b: usize| 1.0 / (1.0 + a.abs_diff(b) as f32);
            [grows(x, 47), grows(y, 0), grows(x, 31) * grows(y, 16)]
        });
        let made = octahedral(&image, side([64, 32]));
        let solid = 4.0 * PI / (made.width * made.width) as f64;
        let wanted = power(&image);
        for (channel, wanted) in wanted.into_iter().enumerate() {
            let sum: f64 = made.values.iter().skip(channel).step_by(3).map(|x| f64::from(*x)).sum::<f64>() * solid;
            assert!((sum / wanted - 1.0).abs() < 1e-6, "{channel}: {sum} for {wanted}");
        }
        let brightest = |channel: usize| {
            let at = (0..made.width * made.width)
                .max_by(|a, b| made.values[a * 3 + channel].total_cmp(&made.values[b * 3 + channel]))
                .expect("a pixel");
            direction([at % made.width, at / made.width].map(|x| (x as f64 + 0.5) / made.width as f64))
        };
        // A quarter of the width to the right of the middle is +x; the upper edge is +z; the middle is +y.
        assert!(brightest(0)[0] > 0.0 && brightest(0)[1].abs() < 0.2, "{:?}", brightest(0));
        assert!(brightest(1)[2] > 0.98 && brightest(2)[1] > 0.98, "{:?}, {:?}", brightest(1), brightest(2));
    }

    #[test]
    fn rows_in_between_are_at_the_poles_and_half_way() {
        let image = Pixels { width: 1, height: 2, channels: 1, values: vec![1.0, 3.0] };
        let made = between_rows(image);
        assert_eq!((made.height, made.values), (5, vec![1.0, 1.0, 2.0, 3.0, 3.0]));
    }

    #[test]
    fn the_light_of_an_image_is_its_integral() {
        let grey = sky(6, 3, |_, _| [0.5; 3]);
        assert!(power(&grey).iter().all(|x| (x - 2.0 * PI).abs() < 1e-12), "{:?}", power(&grey));
        let one = sky(1, 1, |_, _| [1.0, 2.0, 4.0]);
        assert!((power(&one)[2] - 16.0 * PI).abs() < 1e-12);
        // Against a fine sum over directions.
        let image = sky(8, 4, |x, y| [x as f32, y as f32, ((x + y) % 3) as f32]);
        let fine = 400;
        let mut sum = [0.0; 3];
        for at in 0..fine * fine {
            let color = seen(&image, direction([at % fine, at / fine].map(|x| (x as f64 + 0.5) / fine as f64)));
            [0, 1, 2].into_iter().for_each(|at| sum[at] += color[at] * 4.0 * PI / (fine * fine) as f64);
        }
        assert!(sum.iter().zip(power(&image)).all(|(a, b)| (a / b - 1.0).abs() < 1e-3), "{sum:?}, {:?}", power(&image));
    }

    #[test]
    fn a_smooth_sky_is_hardly_off_and_a_checked_one_is() {
        let smooth = sky(64, 32, |x, _| [1.0 + libm::cos(x as f64 * TAU / 64.0) as f32 * 0.5; 3]);
        let checked = sky(64, 32, |x, y| [((x + y) % 2) as f32; 3]);
        let (smooth, checked) = (off(&smooth, side([64, 32])), off(&checked, side([64, 32])));
        assert!(smooth < 0.01 && checked > 0.05 && checked < 0.5, "{smooth}, {checked}");
        assert_eq!(side([64, 32]), 128);
        assert_eq!(side([2048, 1024]), 2048);
    }
}
