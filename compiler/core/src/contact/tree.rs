//! A tree of boxes: which of many boxes may touch one.

use rayon::prelude::*;

use crate::survey::Bounds;

/// Children of a node, and items of a leaf.
const WIDTH: usize = 8;

/// The most nodes that wait to be looked at: of 2^32 items there are 11 levels, each of which takes one away and brings
/// [`WIDTH`]; and one place behind them.
const MOST_OPEN: usize = 11 * (WIDTH - 1) + 2;

/// Below so many items threads cost more than they save.
const WORTH_THREADS: usize = 1 << 14;

/// Items in the order of a space-filling curve, packed into a tree without pointers. It takes 4 bytes an item and a box for each
/// eight of them; the boxes of the items themselves are not kept.
#[derive(Debug)]
pub struct Tree {
    /// The items, in groups of [`WIDTH`].
    order: Vec<u32>,
    /// Boxes by level: first those around the groups of items, then those around [`WIDTH`] boxes of the level below.
    levels: Vec<Vec<Bounds>>,
}

impl Tree {
    /// The tree of `count` items whose boxes `bounds` gives. Time is that of sorting them.
    ///
    /// # Panics
    /// At more than `u32::MAX` items.
    pub fn of(count: usize, bounds: impl Fn(usize) -> Bounds + Sync) -> Self {
        let count = u32::try_from(count).expect("fewer than 2^32 items");
        if count == 0 {
            return Self { order: Vec::new(), levels: Vec::new() };
        }
        let many = count as usize >= WORTH_THREADS;
        let all = |a: Bounds, b: Bounds| a.union(b);
        let whole = if many {
            (0..count).into_par_iter().map(|at| bounds(at as usize)).reduce_with(all)
        } else {
            (0..count).map(|at| bounds(at as usize)).reduce(all)
        };
        let Some(whole) = whole else { return Self { order: Vec::new(), levels: Vec::new() } };
        let key = |at: u32| (morton(bounds(at as usize).center(), whole), at);
        let mut keys: Vec<(u64, u32)>;
        if many {
            keys = (0..count).into_par_iter().map(key).collect();
            keys.par_sort_unstable();
        } else {
            keys = (0..count).map(key).collect();
            keys.sort_unstable();
        }
        let order: Vec<u32> = keys.into_iter().map(|(_, at)| at).collect();
        let around = |items: &[u32]| items.iter().map(|at| bounds(*at as usize)).reduce(all);
        let mut levels: Vec<Vec<Bounds>> = vec![if many {
            order.par_chunks(WIDTH).filter_map(around).collect()
        } else {
            order.chunks(WIDTH).filter_map(around).collect()
        }];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            levels.push(last.chunks(WIDTH).filter_map(|boxes| boxes.iter().copied().reduce(all)).collect());
        }
        Self { order, levels }
    }

    /// Calls `found` with groups of items, at least all those whose boxes touch `near`; gives the number of boxes looked at.
    pub fn each(&self, near: Bounds, mut found: impl FnMut(&[u32])) -> u64 {
        self.leaves(near, 0, |leaf| found(self.items(leaf)))
    }

    /// Calls `found` with every two items whose boxes, `bounds`, touch, the lower first and each pair once; gives the number of
    /// boxes looked at. The items of a leaf are neighbors, and look for theirs together. Where `found` says no, the next leaves are not
    /// looked at.
    pub fn each_pair(&self, bounds: impl Fn(usize) -> Bounds, mut found: impl FnMut(usize, usize) -> bool) -> u64 {
        let mut looked = 0;
        let mut more = true;
        let Some(leaves) = self.levels.first() else { return 0 };
        let mut own: Vec<(usize, Bounds)> = Vec::with_capacity(WIDTH);
        for (leaf, around) in leaves.iter().enumerate() {
            if !more {
                break;
            }
            own.clear();
            own.extend(self.items(leaf).iter().map(|item| (*item as usize, bounds(*item as usize))));
            looked += self.leaves(*around, leaf, |other| {
                for (place, item) in self.items(other).iter().map(|item| *item as usize).enumerate() {
                    let second = bounds(item);
                    // Within the leaf itself only what comes later.
                    let firsts = if other == leaf { &own[..place] } else { &own[..] };
                    if !second.touches(*around) {
                        continue;
                    }
                    for (first, _) in firsts.iter().filter(|(_, first)| first.touches(second)) {
                        more &= found((*first).min(item), (*first).max(item));
                    }
                }
            });
        }
        looked
    }

    /// The items of a leaf.
    fn items(&self, leaf: usize) -> &[u32] {
        &self.order[leaf * WIDTH..self.order.len().min((leaf + 1) * WIDTH)]
    }

    /// Calls `found` with the leaves from `first` on whose boxes touch `near`; gives the number of boxes looked at.
    fn leaves(&self, near: Bounds, first: usize, mut found: impl FnMut(usize)) -> u64 {
        let Some(top) = self.levels.len().checked_sub(1) else { return 0 };
        let mut looked = 1;
        if !self.levels[top][0].touches(near) {
            return looked;
        }
        let mut open = [(0_usize, 0_usize); MOST_OPEN];
        open[0] = (top, 0);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (level, at) = open[count];
            if level == 0 {
                found(at);
                continue;
            }
            let below = &self.levels[level - 1];
            // Before this child all leaves lie before the first.
            let start = (first / WIDTH.pow(level as u32 - 1)).max(at * WIDTH);
            let children =
                &below[start.min(below.len())..below.len().min((at + 1) * WIDTH).max(start.min(below.len()))];
            looked += children.len() as u64;
            // The first is looked at first.
            for (child, bounds) in children.iter().enumerate().rev() {
                open[count] = (level - 1, start + child);
                count += usize::from(bounds.touches(near));
            }
        }
        looked
    }
}

/// The place of a point along the Z curve through a box (Morton 1966), 21 bits for each axis.
fn morton(point: [f64; 3], whole: Bounds) -> u64 {
    let size = whole.size();
    let mut key = 0;
    for axis in 0..3 {
        let share = if size[axis] > 0.0 { (point[axis] - whole.low[axis]) / size[axis] } else { 0.0 };
        // A cast is saturating; NaN becomes 0.
        key |= spread((share * f64::from(1 << 21)) as u64) << axis;
    }
    key
}

/// Every third bit of the result is one of the lowest 21 of `x`.
fn spread(x: u64) -> u64 {
    let mut x = x.min((1 << 21) - 1);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_near_is_missed(
            boxes in prop::collection::vec((any::<[i8; 3]>(), any::<[u8; 3]>()), 0..200),
            near in (any::<[i8; 3]>(), any::<[u8; 3]>()),
        ) {
            let bounds = |(low, size): ([i8; 3], [u8; 3])| {
                let low = low.map(f64::from);
                Bounds { low, high: [0, 1, 2].map(|axis| low[axis] + f64::from(size[axis] % 40)) }
            };
            let near = bounds(near);
            let tree = Tree::of(boxes.len(), |at| bounds(boxes[at]));
            let mut found = Vec::new();
            tree.each(near, |items| found.extend(items.iter().copied().filter(|at| bounds(boxes[*at as usize]).common(near).is_some())));
            found.sort_unstable();
            let expected: Vec<u32> =
                (0..boxes.len() as u32).filter(|at| bounds(boxes[*at as usize]).common(near).is_some()).collect();
            prop_assert_eq!(found, expected);
        }
    }

    proptest! {
        #[test]
        fn pairs_are_found_once(boxes in prop::collection::vec((any::<[i8; 3]>(), any::<[u8; 3]>()), 0..200)) {
            let bounds = |at: usize| {
                let (low, size) = boxes[at];
                let low = low.map(f64::from);
                Bounds { low, high: [0, 1, 2].map(|axis| low[axis] + f64::from(size[axis] % 40)) }
            };
            let mut found = Vec::new();
            Tree::of(boxes.len(), bounds).each_pair(bounds, |a, b| {
                found.push((a, b));
                true
            });
            found.sort_unstable();
            let all = (0..boxes.len()).flat_map(|a| (a + 1..boxes.len()).map(move |b| (a, b)));
            let expected: Vec<_> = all.filter(|(a, b)| bounds(*a).common(bounds(*b)).is_some()).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn few_boxes_are_looked_at() {
        let side = 100;
        let bounds = |at: usize| {
            let low = [(at % side) as f64, (at / side) as f64, 0.0];
            Bounds { low, high: low.map(|x| x + 1.0) }
        };
        let tree = Tree::of(side * side, bounds);
        let looked = tree.each(Bounds { low: [50.2; 3].map(|x| x), high: [50.3, 50.3, 60.0] }, |_| ());
        assert_eq!(looked, 1, "it lies above all");
        let looked = tree.each(Bounds { low: [50.2, 50.2, 0.5], high: [50.3, 50.3, 0.6] }, |_| ());
        assert!(looked < 100, "{looked}");
    }
}
