//! The best whole-pixel shift: tells a wrong camera from a wrong light.

use serde::{Deserialize, Serialize};

use super::Pair;
use ltsc_render::image::finite;

/// How many standard errors a shift must make the images more equal by. Noise alone reaches 4 in one of 30 000 shifts, and 25 are
/// tried.
const SIGNIFICANT: f64 = 4.0;

/// The same for single pixels, whose gains are not independent: a pixel of B is in two of them.
const IN_PIXELS: f64 = 6.0;

/// Parts of each side of the image whose improvements are compared to tell a shift from noise.
const PARTS: usize = 8;

/// A shift that moves B onto A.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shift {
    /// Pixels to the right.
    pub dx: i64,
    /// Pixels downwards.
    pub dy: i64,
    /// Mean absolute difference after the shift.
    pub error: f64,
    /// Mean absolute difference without a shift, over the same pixels of A.
    pub error_unshifted: f64,
}

/// Tries all shifts up to `reach` in each direction and takes the one with the least mean absolute
/// difference; of equal ones the shortest; none where noise may have made the difference as well, unless `any` is asked for. Only
/// those pixels of A are used that every shift covers, and nothing is given if there are none.
pub(super) fn best(pair: &Pair, reach: usize, any: bool) -> Option<Shift> {
    let bound = i64::try_from(reach).ok()?;
    let mut shifts: Vec<(i64, i64)> =
        (-bound..=bound).flat_map(|dy| (-bound..=bound).map(move |dx| (dx, dy))).collect();
    shifts.sort_by_key(|&(dx, dy)| (dx.abs() + dy.abs(), dy, dx));
    let unshifted = error(pair, reach, (0, 0))?;
    let mut best = Shift { dx: 0, dy: 0, error: unshifted, error_unshifted: unshifted };
    for (dx, dy) in shifts {
        if let Some(error) = error(pair, reach, (dx, dy))
            && error < best.error
        {
            best = Shift { dx, dy, error, ..best };
        }
    }
    // Noise is never gone after a shift.
    let clear = any || (best.dx, best.dy) == (0, 0) || best.error <= 1e-6 * unshifted;
    let found = clear || is_significant(pair, reach, (best.dx, best.dy));
    Some(if found { best } else { Shift { dx: 0, dy: 0, error: unshifted, error_unshifted: unshifted } })
}

/// Whether the shift makes the image more equal in most of its parts, or in so many pixels, as at a few edges, that it is no chance.
/// One firefly that comes to lie on another is neither.
fn is_significant(pair: &Pair, reach: usize, (dx, dy): (i64, i64)) -> bool {
    let inner = |size: usize| size.saturating_sub(2 * reach);
    let (width, height) = (inner(pair.a.width), inner(pair.a.height));
    let (columns, rows) = (PARTS.min(width).max(1), PARTS.min(height).max(1));
    let mut parts = vec![(0.0, 0_usize); columns * rows];
    let (mut gained, mut squares) = (0.0, 0.0);
    let difference = |x: usize, y: usize, (dx, dy): (i64, i64)| {
        let (a, b) =
            (pair.a.at(x, y), pair.b.at(x.wrapping_add_signed(-dx as isize), y.wrapping_add_signed(-dy as isize)));
        (finite(&a) && finite(&b)).then(|| (0..3).map(|c| (f64::from(b[c]) - f64::from(a[c])).abs()).sum::<f64>())
    };
    for y in 0..height {
        for x in 0..width {
            let at = (x + reach, y + reach);
            if let (Some(before), Some(after)) = (difference(at.0, at.1, (0, 0)), difference(at.0, at.1, (dx, dy))) {
                let part = &mut parts[(y * rows / height) * columns + x * columns / width];
                *part = (part.0 + before - after, part.1 + 1);
                gained += before - after;
                squares += (before - after) * (before - after);
            }
        }
    }
    let gains: Vec<f64> =
        parts.iter().filter(|(_, count)| *count > 0).map(|(sum, count)| sum / *count as f64).collect();
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let spread = gains.iter().map(|gain| (gain - mean) * (gain - mean)).sum::<f64>() / (count - 1.0);
    let everywhere = count > 1.0 && mean > SIGNIFICANT * (spread / count).sqrt();
    everywhere || gained > IN_PIXELS * squares.sqrt()
}

/// Mean absolute difference between A and B moved by the shift, over the inner pixels of A.
fn error(pair: &Pair, reach: usize, (dx, dy): (i64, i64)) -> Option<f64> {
    let inner = |size: usize| reach..size.saturating_sub(reach);
    // Inner pixels are at least `reach` away from every side, so this stays inside.
    let source = |at: usize, by: i64| at.wrapping_add_signed(-by as isize);
    let (mut sum, mut count) = (0.0, 0_usize);
    for y in inner(pair.a.height) {
        for x in inner(pair.a.width) {
            let (a, b) = (pair.a.at(x, y), pair.b.at(source(x, dx), source(y, dy)));
            if finite(&a) && finite(&b) {
                sum += (0..3).map(|c| (f64::from(b[c]) - f64::from(a[c])).abs()).sum::<f64>();
                count += 3;
            }
        }
    }
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltsc_render::image::Image;

    /// An image without symmetry whose content lies `dx` to the right and `dy` down.
    fn pattern(dx: i64, dy: i64) -> Image {
        let value = |x: i64, y: i64| ((x * 7 + y * 13 + x * y * 3).rem_euclid(31)) as f32;
        let pixels = (0..12).flat_map(|y| (0..16).map(move |x| [value(x - dx, y - dy), 1.0, 0.0])).collect();
        Image { width: 16, height: 12, pixels }
    }

    #[test]
    fn every_shift_is_found_with_its_sign() {
        let a = pattern(0, 0);
        for (dx, dy) in [(0, 0), (1, 0), (0, -1), (2, 1), (-2, -2)] {
            let b = pattern(dx, dy);
            let found = best(&Pair::new(&a, &b).expect("a pair"), 2, false).expect("large enough");
            // B lies to the right, so it must be moved to the left.
            assert_eq!((found.dx, found.dy), (-dx, -dy));
            assert_eq!(found.error, 0.0);
            assert_eq!(found.error_unshifted == 0.0, (dx, dy) == (0, 0));
        }
    }

    #[test]
    fn noise_is_no_shift() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        for _ in 0..20 {
            let mut noisy =
                || Image { width: 24, height: 20, pixels: (0..480).map(|_| [next(), next(), next()]).collect() };
            let (mut a, b) = (noisy(), noisy());
            // A firefly in each, next to each other.
            a.pixels[210] = [1000.0; 3];
            let found = best(&Pair::new(&a, &b).expect("a pair"), 2, false).expect("large enough");
            assert_eq!((found.dx, found.dy), (0, 0), "{found:?}");
            // The same noise two pixels to the right is a shift.
            let mut moved = b.clone();
            moved.pixels.rotate_right(2);
            let found = best(&Pair::new(&b, &moved).expect("a pair"), 2, false).expect("large enough");
            assert_eq!((found.dx, found.dy), (-2, 0), "{found:?}");
            // And so is the same two pixels down.
            let mut moved = b.clone();
            moved.pixels.rotate_right(2 * 24);
            let pair = Pair::new(&b, &moved).expect("a pair");
            let found = best(&pair, 2, false).expect("large enough");
            assert_eq!((found.dx, found.dy), (0, -2), "{found:?}");
            assert!(is_significant(&pair, 2, (0, -2)) && !is_significant(&pair, 2, (0, 2)));
        }
    }

    #[test]
    fn edges_in_a_corner_show_a_shift_and_two_fireflies_do_not() {
        let square = |at: usize| {
            let mut image = Image::filled(64, 64, [0.5; 3]);
            let inside = |x: usize, y: usize| (at..at + 24).contains(&x) && (10..34).contains(&y);
            let mut noise = 1_u32;
            for (index, pixel) in image.pixels.iter_mut().enumerate() {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223 + at as u32);
                let value = if inside(index % 64, index / 64) { 1.0 } else { 0.0 } + (noise >> 8) as f32 / 1e9;
                *pixel = [value; 3];
            }
            image
        };
        let found = best(&Pair::new(&square(10), &square(11)).expect("a pair"), 2, false).expect("large enough");
        assert_eq!((found.dx, found.dy), (-1, 0), "{found:?}");
        let (mut a, mut b) = (Image::filled(64, 64, [0.5; 3]), Image::filled(64, 64, [0.5; 3]));
        a.pixels[64 * 20 + 20] = [900.0; 3];
        b.pixels[64 * 20 + 21] = [1000.0; 3];
        let pair = Pair::new(&a, &b).expect("a pair");
        let found = best(&pair, 2, false).expect("large enough");
        assert_eq!((found.dx, found.dy), (0, 0), "{found:?}");
        let found = best(&pair, 2, true).expect("large enough");
        assert_eq!((found.dx, found.dy), (-1, 0), "asked for, it is given");
    }

    #[test]
    fn small_and_flat_images_show_no_shift() {
        let flat = Image::filled(9, 9, [1.0; 3]);
        let found = best(&Pair::new(&flat, &flat).expect("a pair"), 2, false).expect("large enough");
        assert_eq!((found.dx, found.dy), (0, 0));
        let small = Image::filled(4, 9, [1.0; 3]);
        assert_eq!(best(&Pair::new(&small, &small).expect("a pair"), 2, false), None);
    }

    /// Two images in which each inner pixel grows more equal by 3 times its gain, between -1 and 1, where B moves one to the right, or one
    /// down: B is striped, 0 and 1, and A lies between both.
    fn gaining(width: usize, height: usize, down: bool, gain: impl Fn(usize, usize) -> f32) -> (Image, Image) {
        let stripe = |x: usize, y: usize| if down { y % 2 } else { x % 2 } as f32;
        let places = || (0..height + 2).flat_map(move |y| (0..width + 2).map(move |x| (x, y)));
        let near = |x: usize, y: usize| {
            let inside = (1..=width).contains(&x) && (1..=height).contains(&y);
            let gain = if inside { gain(x - 1, y - 1) } else { 0.0 };
            // |b - a| - |1 - b - a| is the gain.
            if stripe(x, y) == 0.0 { (1.0 + gain) / 2.0 } else { (1.0 - gain) / 2.0 }
        };
        let image = |pixels| Image { width: width + 2, height: height + 2, pixels };
        (
            image(places().map(|(x, y)| [near(x, y); 3]).collect()),
            image(places().map(|(x, y)| [stripe(x, y); 3]).collect()),
        )
    }

    fn significant(width: usize, height: usize, gain: impl Fn(usize, usize) -> f32) -> bool {
        let [right, below] = [false, true].map(|down| {
            let (a, b) = gaining(width, height, down, &gain);
            let by = if down { (0, 1) } else { (1, 0) };
            is_significant(&Pair::new(&a, &b).expect("a pair"), 1, by)
        });
        assert_eq!(right, below);
        right
    }

    /// 64 parts with a gain of `mean` or 0.1 more or less: a standard error of 0.1 / sqrt(63), so that four of them are 0.05040. In each
    /// part pixels gain and lose 0.5 beside that, so that no sum over pixels shows it.
    #[test]
    fn a_shift_is_one_from_four_standard_errors_of_the_parts_on() {
        // Parts of 2 by 2, of 4 by 2, of 2 by 6 pixels, and of 2 by 2 or 2 by 4 where sides are no multiples of eight.
        for (width, height) in [(16, 16), (32, 16), (16, 48)] {
            let of = |mean: f32| {
                move |x: usize, y: usize| {
                    let part = if (x * 8 / width + y * 8 / height).is_multiple_of(2) { 0.1 } else { -0.1 };
                    mean + part + if (x + y).is_multiple_of(2) { 0.5 } else { -0.5 }
                }
            };
            assert!(!significant(width, height, of(0.0500)) && significant(width, height, of(0.0508)), "{width}");
            assert!(!significant(width, height, of(-0.3)), "a loss is none");
        }
        // With fewer pixels than parts each pixel is one: 15 of them, one gains 0.2 more, so that the standard error is 0.2 / 15.
        let one = |mean: f32| move |x: usize, y: usize| mean + if (x, y) == (4, 2) { 0.2 } else { 0.0 };
        // The mean is 0.2 / 15 above the others' gain: 4 standard errors where they gain 3 of them.
        assert!(!significant(5, 3, one(0.0395)) && significant(5, 3, one(0.0405)));
        assert!(!significant(1, 1, |_, _| 0.9), "one part tells nothing");
    }

    /// Of 12 by 12 pixels parts have 1, 2 or 4, and count alike: those of four lose 0.3 in each pixel, the others gain 0.5. Their mean is 0.3, its
    /// standard error 0.35 / 8; the sums over pixels tell nothing: 20.8 of 5.1 as the root of the squares.
    #[test]
    fn parts_of_different_sizes_count_alike() {
        let wide = |at: usize| (0..12).filter(|other| other * 8 / 12 == at * 8 / 12).count() == 2;
        assert!(significant(12, 12, |x, y| if wide(x) && wide(y) { -0.3 } else { 0.5 }));
    }

    /// In one part of 7 by 7 pixels some gain alike: the sum is sqrt(n) times the root of the squares.
    #[test]
    fn a_shift_is_one_from_six_roots_of_the_squares_of_pixels_on() {
        let first =
            |count: usize| move |x: usize, y: usize| if x < 7 && y < 7 && y * 7 + x < count { 0.25 } else { 0.0 };
        assert!(!significant(56, 56, first(35)) && significant(56, 56, first(37)));
        // Pixels that lose the same take away from the sum and add to the squares: 40 gain and 2 lose, 38 / sqrt(42) = 5.86; 41 and 1, 6.17.
        let losing = |lost: usize| {
            move |x: usize, y: usize| match y * 7 + x {
                at if x >= 7 || y >= 7 || at >= 42 => 0.0,
                at if at < lost => -0.25,
                _ => 0.25,
            }
        };
        assert!(!significant(56, 56, losing(2)) && significant(56, 56, losing(1)));
    }

    #[test]
    fn what_is_not_finite_takes_no_part() {
        // 64 parts of a pixel that gain 0.25 more or less: eight standard errors, and 5.7 roots of the squares.
        let gain = |x: usize, _: usize| if x.is_multiple_of(2) { 0.0 } else { 0.5 };
        let (mut a, mut b) = gaining(8, 8, false, gain);
        let there = |a: &Image, b: &Image| is_significant(&Pair::new(a, b).expect("a pair"), 1, (1, 0));
        assert!(there(&a, &b));
        a.pixels[33] = [f32::NAN, 0.0, 0.0];
        b.pixels[47] = [0.0, f32::INFINITY, 0.0];
        assert!(there(&a, &b));
        // B is 2 brighter in red, 1 in green, in all 16 inner pixels of 4 by 4 but one in each image.
        let (mut a, mut b) = (Image::filled(6, 6, [1.0; 3]), Image::filled(6, 6, [3.0, 2.0, 1.0]));
        a.pixels[7] = [f32::NAN; 3];
        b.pixels[8] = [f32::INFINITY; 3];
        assert_eq!(error(&Pair::new(&a, &b).expect("a pair"), 1, (0, 0)), Some(1.0));
        // Four of them 4 brighter beside: (14 * 3 + 4 * 4) / (14 * 3).
        (1..5).for_each(|x| b.pixels[4 * 6 + x] = [5.0, 4.0, 1.0]);
        let found = error(&Pair::new(&a, &b).expect("a pair"), 1, (0, 0)).expect("pixels");
        assert!((found - (42.0 + 16.0) / 42.0).abs() < 1e-12, "{found}");
        let nothing = Image::filled(6, 6, [f32::NAN; 3]);
        assert_eq!(error(&Pair::new(&nothing, &b).expect("a pair"), 1, (0, 0)), None);
    }

    /// What remains after a shift is rounding, or noise, by its share of what was there before: whatever the unit of light.
    #[test]
    fn what_is_gone_after_a_shift_is_told_by_its_share() {
        let lit = |at: usize, value: f32, rest: f32| {
            let mut image = Image::filled(16, 16, [0.0; 3]);
            image.pixels[16 * 8 + at] = [value; 3];
            image.pixels[16 * 3 + 3] = [rest; 3];
            image
        };
        for unit in [1e-6, 1.0, 1e6] {
            let found = |rest: f32| {
                let (a, b) = (lit(8, unit, 0.0), lit(9, unit, rest * unit));
                best(&Pair::new(&a, &b).expect("a pair"), 2, false).expect("large enough")
            };
            // Two pixels of the light are wrong before, and of the rest one is, before and after: it is half of its share.
            assert_eq!((found(1.9e-6).dx, found(2.2e-6).dx), (-1, 0), "{unit}");
        }
    }

    #[test]
    fn of_equal_shifts_the_shortest_is_taken() {
        // Stripes of two pixels, moved by one: to the left, or three to the right.
        let stripes = |by: usize| Image {
            width: 16,
            height: 12,
            pixels: (0..16 * 12).map(|at| [if (at % 16 + by) % 4 < 2 { 1.0 } else { 0.0 }; 3]).collect(),
        };
        let found = best(&Pair::new(&stripes(0), &stripes(1)).expect("a pair"), 3, false).expect("large enough");
        assert_eq!((found.dx, found.dy), (1, 0));
        // Half of all pixels differ before.
        assert_eq!((found.error, found.error_unshifted), (0.0, 0.5));
    }
}
