//! Pairs of what lies at one place, by a grid of cells: each item looks into the cells that its partner may lie in.

use std::collections::HashMap;

use crate::ir::{Vec3, length, sub};

/// Partners at one place that are tried before the best of them is taken.
const TRIES: usize = 64;

/// A place, and how far that of the partner may be.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Where.
    pub at: Vec3,
    /// How far, >= 0.
    pub reach: f64,
}

/// Pairs of `a` and `b`, each item in one pair at most. `fit` says how good a pair is, 0 being the best; none where the two do not belong
/// together. The order is that of `a`.
pub fn pairs(a: &[Spot], b: &[Spot], mut fit: impl FnMut(usize, usize) -> Option<u32>) -> Vec<(usize, usize)> {
    let widest = a.iter().fold(0.0_f64, |most, spot| most.max(spot.reach));
    let side = (2.0 * widest).max(f64::MIN_POSITIVE);
    let cell = |at: Vec3| at.map(|x| (x / side).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    // From the last on, so that the first is taken first.
    for (index, spot) in b.iter().enumerate().rev() {
        cells.entry(cell(spot.at)).or_default().push(index as u32);
    }
    let mut found = Vec::new();
    for (index, spot) in a.iter().enumerate() {
        let low = cell(spot.at.map(|x| x - spot.reach));
        let high = cell(spot.at.map(|x| x + spot.reach));
        let mut best: Option<(u32, [i64; 3], usize)> = None;
        let mut tried = 0;
        'all: for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let Some(there) = cells.get(&[x, y, z]) else { continue };
                    for (slot, other) in there.iter().enumerate().rev() {
                        if length(sub(b[*other as usize].at, spot.at)) > spot.reach {
                            continue;
                        }
                        tried += 1;
                        if let Some(grade) = fit(index, *other as usize)
                            && best.is_none_or(|(known, _, _)| grade < known)
                        {
                            best = Some((grade, [x, y, z], slot));
                        }
                        if tried >= TRIES || best.is_some_and(|(grade, _, _)| grade == 0) {
                            break 'all;
                        }
                    }
                }
            }
        }
        if let Some((_, key, slot)) = best
            && let Some(there) = cells.get_mut(&key)
        {
            found.push((index, there.remove(slot) as usize));
        }
    }
    found
}
