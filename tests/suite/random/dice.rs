//! Choices by a seed: the same on every machine.

/// The generator SplitMix64 (Steele, Lea and Flood 2014).
pub struct Dice(u64);

impl Dice {
    /// Starts with a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xa076_1d64_78bd_642f) ^ 0x6c74_7363)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut state = self.0;
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^ (state >> 31)
    }

    /// From 0 to just below 1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of the whole numbers from `low` to `high`, both included.
    pub fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.next() % (u64::from(high - low) + 1)) as u32
    }

    /// A place in a list of `count`.
    pub fn at(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    /// One of a list.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.at(from.len())]
    }

    /// Yes in `share` of all cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    /// From `low` to `high` with as many digits as people write, or with all.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let exact = low + (high - low) * self.share();
        let rounded = match self.at(4) {
            0 => exact.round(),
            1 => (exact * 10.0).round() / 10.0,
            2 => (exact * 1e3).round() / 1e3,
            _ => exact,
        };
        if (low..=high).contains(&rounded) { rounded } else { exact }
    }

    /// A positive number of any size from 10 to the power `low` to 10 to the power `high`.
    pub fn size(&mut self, low: f64, high: f64) -> f64 {
        let power = self.between(low, high);
        let size = 10_f64.powf(power);
        if self.chance(0.5) { size } else { format!("{size:.0e}").parse().unwrap_or(size) }
    }
}
