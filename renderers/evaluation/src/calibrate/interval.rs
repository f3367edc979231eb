//! A rate that was counted, with its interval.

use serde::{Deserialize, Serialize};

/// The deviate of a two-sided interval of 95 %.
const Z: f64 = 1.959_964;

/// So many of so many trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rate {
    /// Trials of which it is true.
    pub hits: u64,
    /// All trials.
    pub trials: u64,
}

impl Rate {
    /// The share; none without trials.
    #[must_use]
    pub fn share(self) -> Option<f64> {
        (self.trials > 0).then(|| self.hits as f64 / self.trials as f64)
    }

    /// The interval of 95 % of Wilson (1927), for independent trials: from 0 to 1 without any.
    #[must_use]
    pub fn interval(self) -> (f64, f64) {
        let Some(share) = self.share() else { return (0.0, 1.0) };
        let n = self.trials as f64;
        let scale = 1.0 + Z * Z / n;
        let middle = (share + Z * Z / (2.0 * n)) / scale;
        let half = Z / scale * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
        // At its ends the interval ends there too, but for rounding.
        let low = if self.hits == 0 { 0.0 } else { (middle - half).max(0.0) };
        let high = if self.hits == self.trials { 1.0 } else { (middle + half).min(1.0) };
        (low, high)
    }
}

impl std::ops::Add for Rate {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { hits: self.hits + other.hits, trials: self.trials + other.trials }
    }
}

impl std::iter::Sum for Rate {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, one| sum + one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(hits: u64, trials: u64) -> (f64, f64) {
        Rate { hits, trials }.interval()
    }

    /// Newcombe 1998 (Statistics in Medicine 17, 857-872), table I, method 3; from memory, and by hand from the formula.
    #[test]
    fn intervals_are_those_of_the_tables() {
        for (hits, trials, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let (l, h) = interval(hits, trials);
            assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{hits} of {trials}: {l} to {h}");
        }
    }

    #[test]
    fn ends_are_ends() {
        assert_eq!((interval(0, 1000).0, interval(7, 7).1), (0.0, 1.0));
        assert!((interval(0, 1000).1 - 0.003_827).abs() < 1e-6);
        assert_eq!((interval(0, 0), Rate::default().share()), ((0.0, 1.0), None));
        let sum: Rate = [Rate { hits: 1, trials: 10 }, Rate { hits: 2, trials: 30 }].into_iter().sum();
        assert_eq!(sum, Rate { hits: 3, trials: 40 });
    }
}
