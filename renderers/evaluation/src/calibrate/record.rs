//! What was counted, as it is kept.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use super::draw::Design;
use super::interval::Rate;
use super::plant::Distance;

/// The largest rate of wrong answers that is allowed.
pub const BAR: f64 = 0.01;

/// The tolerance at which false differences and what is found are counted: small, so that it hides nothing.
pub const SMALL: f64 = 0.01;

/// From so many tolerances on, a difference must not be called agreement.
pub const CLEAR: f64 = 1.5;

/// How far the median prediction may be off.
pub const FACTOR: f64 = 2.0;

/// All that is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// By scene.
    pub scenes: Vec<Scene>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The scene with its parameters.
    pub scene: String,
    /// The renderer and its version.
    pub renderer: String,
    /// Pixels along each side.
    pub size: u32,
    /// Samples per pixel of a chunk.
    pub samples: u32,
    /// What the random numbers of the draws begin with.
    pub seed: u64,
    /// What is drawn from.
    pub pools: Vec<Pool>,
    /// What was counted.
    pub rows: Vec<Row>,
    /// What was predicted.
    pub predictions: Vec<Prediction>,
    /// Trials that could not be made, and why.
    pub missing: Vec<String>,
}

/// A pool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pool {
    /// `base`, or the name of a variant.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Chunks that are there.
    pub chunks: u32,
    /// Chunks that were asked for.
    pub wanted: u32,
    /// The seed of the first one.
    pub first_seed: u32,
    /// Its mean over that of the base, in red, green and blue.
    pub ratio: [f64; 3],
    /// How far it is from the base.
    pub distance: Distance,
}

/// What a trial is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Both sides are of one pool: `differ` is wrong.
    Same,
    /// Both sides tend to the same image by different estimators: `differ` is wrong.
    Estimator,
    /// Both sides are of one pool, and grow until they agree.
    Growing,
    /// Something is planted: `agree` is wrong.
    Planted,
    /// A scene that is another one in truth.
    Real,
    /// Something is planted, at a small tolerance: whether it is found.
    Power,
}

/// So many trials of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The kind.
    pub test: Test,
    /// What stands against what.
    pub what: String,
    /// Side A.
    pub a: Design,
    /// Side B.
    pub b: Design,
    /// The tolerance in tiles and in the whole, as a share.
    pub tolerance: f64,
    /// The difference in truth, as a share; none where there is none.
    pub distance: Option<Distance>,
    /// Pairs.
    pub pairs: u64,
    /// Of these, `agree`.
    pub agree: u64,
    /// Of these, `differ`.
    pub differ: u64,
}

impl Row {
    /// Pairs that agree.
    #[must_use]
    pub fn agreed(&self) -> Rate {
        Rate { hits: self.agree, trials: self.pairs }
    }

    /// Pairs that differ.
    #[must_use]
    pub fn differed(&self) -> Rate {
        Rate { hits: self.differ, trials: self.pairs }
    }

    /// Whether `differ` is wrong here.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.distance.is_none()
    }

    /// Whether `agree` is wrong here beyond doubt: the difference is at least one and a half tolerances.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        // What is planted as 1.5 tolerances has rounding in it.
        self.distance.is_some_and(|distance| distance.proved >= CLEAR * self.tolerance * (1.0 - 1e-6))
    }
}

/// Samples that were predicted to show agreement of equals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// The tolerance.
    pub tolerance: f64,
    /// What was seen of each side.
    pub from: Design,
    /// Pairs.
    pub pairs: u64,
    /// Samples per pixel and side at which half of all pairs agree: the 10th, 50th and 90th of a hundred predictions; none where it
    /// was too many to be told.
    pub half: [Option<f64>; 3],
    /// The median of those at which nine of ten agree.
    pub most: Option<f64>,
}

impl Record {
    /// Whether no bar is missed.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.scenes.iter().all(|scene| scene.bars().iter().all(|bar| bar.met != Some(false)))
    }
}

/// A promise, and what was counted of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What is promised.
    pub what: String,
    /// What was counted; none for one that is no rate.
    pub rate: Option<Rate>,
    /// What was found where it is no rate; of a rate the worst row.
    pub found: String,
    /// Whether it is met; none where too little was counted.
    pub met: Option<bool>,
}

impl Scene {
    /// The promises.
    #[must_use]
    pub fn bars(&self) -> Vec<Bar> {
        let bar = |what: &str, rates: Vec<Rate>| {
            let rate: Rate = rates.iter().copied().sum();
            let worst = rates
                .into_iter()
                .max_by(|one, other| one.share().partial_cmp(&other.share()).unwrap_or(Ordering::Equal));
            let found = worst.map_or_else(String::new, |worst| format!("{} of {}", worst.hits, worst.trials));
            Bar { what: what.to_owned(), rate: Some(rate), found, met: rate.share().map(|share| share <= BAR) }
        };
        let differ = |test: Test| self.of(test).map(Row::differed).collect::<Vec<_>>();
        // Equals do not agree at the small tolerance either, so that it says nothing.
        let counts = |row: &&Row| row.is_clear() && row.tolerance > SMALL;
        let clear = |test: Test| self.of(test).filter(counts).map(Row::agreed).collect::<Vec<_>>();
        let mut bars = vec![
            bar("`differ` of equals, one renderer, tolerance 1 %", differ(Test::Same)),
            bar("`differ` of equals, two estimators, tolerance 1 %", differ(Test::Estimator)),
            bar("`differ` of equals with more and more samples", differ(Test::Growing)),
            bar("`agree` of what is planted, 1.5 tolerances and more", clear(Test::Planted)),
            bar("`agree` of other scenes, 1.5 tolerances and more", clear(Test::Real)),
        ];
        for prediction in self.predictions.iter().filter(|one| one.from.images == 8) {
            bars.push(self.predicted(prediction));
            bars.push(self.falls(prediction.tolerance));
        }
        bars
    }

    /// Whether the median prediction is right within a factor.
    fn predicted(&self, prediction: &Prediction) -> Bar {
        let what =
            format!("median prediction within a factor of {FACTOR}, tolerance {:.0} %", 100.0 * prediction.tolerance);
        let bar = |found: String, met| Bar { what: what.clone(), rate: None, found, met };
        let Some(said) = prediction.half[1] else { return bar("nothing was predicted".to_owned(), None) };
        match self.measured(prediction.tolerance, 0.5) {
            Measured::At(found) => {
                let ratio = said / found;
                bar(format!("{said:.0} for {found:.0}"), Some((1.0 / FACTOR..=FACTOR).contains(&ratio)))
            }
            Measured::More(than) => {
                bar(format!("{said:.0} for more than {than:.0}"), (said * FACTOR < than).then_some(false))
            }
            Measured::Fewer(than) => {
                bar(format!("{said:.0} for {than:.0} or fewer"), (said > FACTOR * than).then_some(false))
            }
            Measured::Unknown => bar("nothing was measured".to_owned(), None),
        }
    }

    /// Whether the share of undecided pairs falls with samples: more samples never have more of them, but for chance.
    fn falls(&self, tolerance: f64) -> Bar {
        let open: Vec<Rate> = self
            .of(Test::Growing)
            .filter(|row| row.tolerance == tolerance && row.pairs > 0)
            .map(|row| Rate { hits: row.pairs - row.agree - row.differ, trials: row.pairs })
            .collect();
        let shown: Vec<String> =
            open.iter().map(|rate| format!("{:.0}", 100.0 * rate.share().unwrap_or(0.0))).collect();
        let fallen = |pair: &[Rate]| pair[1].interval().0 <= pair[0].interval().1;
        let less = open.first().zip(open.last()).is_some_and(|(first, last)| last.share() < first.share());
        Bar {
            what: format!("`undecided` falls with samples, tolerance {:.0} %", 100.0 * tolerance),
            rate: None,
            found: format!("{} %", shown.join(", ")),
            met: (open.len() > 1).then(|| less && open.windows(2).all(fallen)),
        }
    }

    /// Rows of a kind.
    pub fn of(&self, test: Test) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.test == test)
    }

    /// Samples per pixel of a side.
    #[must_use]
    pub fn samples_of(&self, design: Design) -> u64 {
        u64::from(self.samples) * design.total() as u64
    }

    /// Samples per pixel and side at which this share of equal pairs agrees, between the two levels that lie around it, in the
    /// logarithm; the first says more than so many, the second fewer, if all levels lie on one side.
    #[must_use]
    pub fn measured(&self, tolerance: f64, share: f64) -> Measured {
        let levels: Vec<(f64, f64)> = self
            .of(Test::Growing)
            .filter(|row| row.tolerance == tolerance)
            .filter_map(|row| Some((self.samples_of(row.a) as f64, row.agreed().share()?)))
            .collect();
        let (Some(first), Some(last)) = (levels.first(), levels.last()) else { return Measured::Unknown };
        if first.1 >= share {
            return Measured::Fewer(first.0);
        }
        let Some(pair) = levels.windows(2).find(|pair| pair[0].1 < share && pair[1].1 >= share) else {
            return Measured::More(last.0);
        };
        let at = (share - pair[0].1) / (pair[1].1 - pair[0].1);
        Measured::At(libm::exp(libm::log(pair[0].0) * (1.0 - at) + libm::log(pair[1].0) * at))
    }
}

/// Where a share of agreement is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// With so many samples.
    At(f64),
    /// With more than that.
    More(f64),
    /// With that or fewer.
    Fewer(f64),
    /// Nothing was counted.
    Unknown,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_found_between_levels() {
        let row = |chunks: usize, agree: u64| Row {
            test: Test::Growing,
            what: "equal".to_owned(),
            a: Design { images: 8, chunks },
            b: Design { images: 8, chunks },
            tolerance: 0.1,
            distance: None,
            pairs: 100,
            agree,
            differ: 0,
        };
        let mut scene = Scene {
            scene: "a".to_owned(),
            renderer: String::new(),
            size: 64,
            samples: 16,
            seed: 1,
            pools: Vec::new(),
            rows: vec![row(1, 0), row(4, 25), row(16, 75)],
            predictions: Vec::new(),
            missing: Vec::new(),
        };
        // Half way between 512 and 2048 in the logarithm.
        let Measured::At(half) = scene.measured(0.1, 0.5) else { panic!("between levels") };
        assert!((half - 1024.0).abs() < 1e-6, "{half}");
        assert_eq!(scene.measured(0.1, 0.9), Measured::More(2048.0));
        assert_eq!(scene.measured(0.2, 0.5), Measured::Unknown);
        scene.rows.remove(0);
        assert_eq!(scene.measured(0.1, 0.2), Measured::Fewer(512.0));
    }

    #[test]
    fn only_what_is_far_enough_is_clear() {
        let mut row = Row {
            test: Test::Real,
            what: String::new(),
            a: Design { images: 8, chunks: 1 },
            b: Design { images: 8, chunks: 1 },
            tolerance: 0.1,
            distance: Some(Distance { share: 0.3, proved: 0.14 }),
            pairs: 1,
            agree: 0,
            differ: 0,
        };
        assert!(!row.is_clear() && !row.is_equal());
        row.distance = Some(Distance { share: 0.3, proved: 0.15 });
        assert!(row.is_clear());
        row.distance = None;
        assert!(!row.is_clear() && row.is_equal());
    }
}
