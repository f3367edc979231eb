//! A hash for keys of a few numbers that are looked up thousands of times: the standard one, made to withstand chosen keys, takes
//! longer than what is looked up. Whoever writes a scene of equal hashes makes its lint slow, which a large scene does as well.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A map that is never iterated over.
pub(super) type QuickMap<K, V> = HashMap<K, V, BuildHasherDefault<Quick>>;

/// An odd number without a pattern: the fraction of the golden ratio in 64 bits.
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

/// Multiplies what was seen by a constant to twice its length, and folds both halves.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quick(u64);

impl Hasher for Quick {
    fn write(&mut self, bytes: &[u8]) {
        let mut words = bytes.chunks_exact(8);
        for word in words.by_ref() {
            self.write_u64(word.first_chunk().map_or(0, |word| u64::from_ne_bytes(*word)));
        }
        for byte in words.remainder() {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, word: u64) {
        // A counter within, so that zeros are told apart by their number.
        let product = u128::from(self.0.wrapping_add(FACTOR) ^ word) * u128::from(FACTOR);
        self.0 = product as u64 ^ (product >> 64) as u64;
    }

    fn write_u8(&mut self, word: u8) {
        self.write_u64(u64::from(word));
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(u64::from(word));
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::hash::{BuildHasher, BuildHasherDefault};

    use super::Quick;

    #[test]
    fn keys_that_are_near_each_other_spread() {
        let hash = |key: ([usize; 2], [i64; 3])| BuildHasherDefault::<Quick>::default().hash_one(key);
        let mut low: BTreeMap<u64, u32> = BTreeMap::new();
        let mut high: BTreeMap<u64, u32> = BTreeMap::new();
        for x in -16..16 {
            for y in -16..16 {
                for z in -16..16 {
                    let hash = hash(([1, 2], [x, 1000 * y, z << 40]));
                    *low.entry(hash & 0xfff).or_default() += 1;
                    *high.entry(hash >> 57).or_default() += 1;
                }
            }
        }
        // 32 768 keys: 8 in each of 4096 places on average, 256 in each of 128; a fair die has no more than some 25 and 340.
        assert!(low.values().all(|count| *count < 32) && low.len() > 4000, "{:?}", low.values().max());
        assert!(high.values().all(|count| (160..352).contains(count)), "{:?}", high.values().max());
    }
}
