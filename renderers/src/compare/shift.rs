//! The best whole-pixel shift: tells a wrong camera from a wrong light.

use serde::{Deserialize, Serialize};

use super::Pair;
use crate::image::finite;

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
/// difference; of equal ones the shortest. Only those pixels of A are used that every shift covers,
/// and nothing is given if there are none.
pub(super) fn best(pair: &Pair, reach: usize) -> Option<Shift> {
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
    Some(best)
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
    use crate::image::Image;

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
            let found = best(&Pair::new(&a, &b).expect("a pair"), 2).expect("large enough");
            // B lies to the right, so it must be moved to the left.
            assert_eq!((found.dx, found.dy), (-dx, -dy));
            assert_eq!(found.error, 0.0);
            assert_eq!(found.error_unshifted == 0.0, (dx, dy) == (0, 0));
        }
    }

    #[test]
    fn small_and_flat_images_show_no_shift() {
        let flat = Image::filled(9, 9, [1.0; 3]);
        let found = best(&Pair::new(&flat, &flat).expect("a pair"), 2).expect("large enough");
        assert_eq!((found.dx, found.dy), (0, 0));
        let small = Image::filled(4, 9, [1.0; 3]);
        assert_eq!(best(&Pair::new(&small, &small).expect("a pair"), 2), None);
    }
}
