//! Chunks drawn from pools, never the same twice for one pair, and put together to images of more samples.

use ltsc_render::image::Image;

/// Random numbers that are the same on every machine (SplitMix64; Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    /// The numbers of one trial: other names and other trials have others.
    #[must_use]
    pub fn of(seed: u64, name: &str, trial: u64) -> Self {
        let hash = blake3::hash(format!("{seed} {trial} {name}").as_bytes());
        let first = hash.as_bytes().iter().take(8).fold(0, |sum, byte| sum << 8 | u64::from(*byte));
        Self(first)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// One of the numbers below `count`, 0 if there is none.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next()) * count as u128) >> 64) as usize
    }

    /// So many different ones of the numbers below `of`; none if there are not so many.
    pub fn pick(&mut self, count: usize, of: usize) -> Option<Vec<usize>> {
        if count > of {
            return None;
        }
        let mut all: Vec<usize> = (0..of).collect();
        for at in 0..count {
            let other = at + self.below(of - at);
            all.swap(at, other);
        }
        all.truncate(count);
        Some(all)
    }
}

/// How one side of a pair is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct Design {
    /// Images.
    pub images: usize,
    /// Chunks that each is the mean of.
    pub chunks: usize,
}

impl Design {
    /// Chunks in all.
    #[must_use]
    pub fn total(self) -> usize {
        self.images * self.chunks
    }
}

/// The sum of chunks, to which more can be added.
struct Sum {
    pixels: Vec<[f32; 3]>,
    count: usize,
}

impl Sum {
    fn add(&mut self, chunk: &Image) {
        self.count += 1;
        for (sum, value) in self.pixels.iter_mut().zip(&chunk.pixels) {
            sum[0] += value[0];
            sum[1] += value[1];
            sum[2] += value[2];
        }
    }

    fn mean(&self, size: (usize, usize)) -> Image {
        let share = 1.0 / self.count.max(1) as f32;
        let pixels = self.pixels.iter().map(|sum| [sum[0] * share, sum[1] * share, sum[2] * share]).collect();
        Image { width: size.0, height: size.1, pixels }
    }
}

/// Images of two sides.
pub type Pair = (Vec<Image>, Vec<Image>);

/// Draws a pair from two pools, or without a second one both sides from the first, no chunk twice; none if there are too few chunks.
pub fn pair(random: &mut Random, a: &[Image], b: Option<&[Image]>, designs: (Design, Design)) -> Option<Pair> {
    let (picks_a, picks_b) = match b {
        Some(b) => (random.pick(designs.0.total(), a.len())?, random.pick(designs.1.total(), b.len())?),
        None => {
            let mut all = random.pick(designs.0.total() + designs.1.total(), a.len())?;
            let rest = all.split_off(designs.0.total());
            (all, rest)
        }
    };
    Some((images(a, &picks_a, designs.0), images(b.unwrap_or(a), &picks_b, designs.1)))
}

fn images(pool: &[Image], picks: &[usize], design: Design) -> Vec<Image> {
    picks.chunks(design.chunks.max(1)).map(|picks| mean(picks.iter().filter_map(|at| pool.get(*at)))).collect()
}

/// The mean of images of one size; an empty image of none.
pub fn mean<'i>(images: impl Iterator<Item = &'i Image>) -> Image {
    let mut images = images.peekable();
    let size = images.peek().map_or((0, 0), |first| (first.width, first.height));
    let mut sum = Sum { pixels: vec![[0.0; 3]; size.0 * size.1], count: 0 };
    images.for_each(|image| sum.add(image));
    sum.mean(size)
}

/// Sees a pair at a level, which is told by its place.
pub type Each<'e> = dyn FnMut(usize, &[Image], &[Image]) + 'e;

/// Draws a pair from one pool, as [`pair`] does, and lets it grow: `each` sees it with every number of chunks for an image in
/// `levels`, which rise, and more of the same chunks each time. Nothing happens if there are too few chunks for the last level.
pub fn growing(random: &mut Random, pool: &[Image], images: usize, levels: &[usize], each: &mut Each<'_>) {
    let most = levels.iter().copied().max().unwrap_or(0);
    let Some(first) = pool.first() else { return };
    let Some(picks) = random.pick(2 * images * most, pool.len()) else { return };
    let size = (first.width, first.height);
    let none = || Sum { pixels: vec![[0.0; 3]; size.0 * size.1], count: 0 };
    let mut sums: Vec<Sum> = (0..2 * images).map(|_| none()).collect();
    for (at, level) in levels.iter().enumerate() {
        for (sum, own) in sums.iter_mut().zip(picks.chunks(most.max(1))) {
            own.iter().take(*level).skip(sum.count).filter_map(|pick| pool.get(*pick)).for_each(|chunk| sum.add(chunk));
        }
        let all: Vec<Image> = sums.iter().map(|sum| sum.mean(size)).collect();
        let (a, b) = all.split_at(images);
        each(at, a, b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chunks of one pixel whose values are powers of two, so that a sum tells which are in it.
    fn marked(count: usize) -> Vec<Image> {
        (0..count).map(|at| Image::filled(1, 1, [(1_u32 << at) as f32; 3])).collect()
    }

    fn bits(images: &[Image], chunks: usize) -> Vec<u32> {
        images.iter().map(|image| (image.pixels[0][0] * chunks as f32).round() as u32).collect()
    }

    #[test]
    fn no_chunk_is_drawn_twice_for_a_pair() {
        let pool = marked(20);
        let (one, other) = (Design { images: 4, chunks: 2 }, Design { images: 3, chunks: 4 });
        for trial in 0..200 {
            let (a, b) = pair(&mut Random::of(1, "one", trial), &pool, None, (one, other)).expect("enough chunks");
            assert_eq!((a.len(), b.len()), (4, 3));
            let all: Vec<u32> = bits(&a, 2).into_iter().chain(bits(&b, 4)).collect();
            // All twenty are used once: sums of different powers of two are as large as all together only so.
            assert_eq!(all.iter().sum::<u32>(), (1 << 20) - 1, "{all:?}");
            assert_eq!(all.iter().map(|bits| bits.count_ones()).sum::<u32>(), 20);
        }
        assert!(pair(&mut Random::of(1, "one", 0), &pool[..19], None, (one, other)).is_none());
    }

    #[test]
    fn draws_are_even_and_the_same_each_time() {
        let of = |trial| Random::of(7, "even", trial).pick(3, 10).expect("numbers");
        assert_eq!(of(5), of(5));
        let mut counts = [0_u32; 10];
        (0..10_000).flat_map(of).for_each(|at| counts[at] += 1);
        // 3000 each, with a deviation of 46.
        assert!(counts.iter().all(|count| (2770..3230).contains(count)), "{counts:?}");
        assert_ne!(Random::of(7, "a", 0).next(), Random::of(7, "b", 0).next());
        assert_ne!(Random::of(7, "a", 0).next(), Random::of(8, "a", 0).next());
    }

    #[test]
    fn what_grows_keeps_its_chunks() {
        let pool = marked(16);
        let mut seen: Vec<Vec<u32>> = Vec::new();
        growing(&mut Random::of(3, "grow", 0), &pool, 2, &[1, 2, 4], &mut |at, a, b| {
            let chunks = [1, 2, 4][at];
            seen.push(bits(a, chunks).into_iter().chain(bits(b, chunks)).collect());
        });
        assert_eq!(seen.len(), 3);
        assert_eq!(seen[2].iter().sum::<u32>(), (1 << 16) - 1);
        for (fewer, more) in seen[0].iter().zip(&seen[2]) {
            assert!(fewer.count_ones() == 1 && more.count_ones() == 4 && fewer & more == *fewer);
        }
        growing(&mut Random::of(3, "grow", 0), &pool, 2, &[5], &mut |_, _, _| unreachable!("too few chunks"));
    }
}
