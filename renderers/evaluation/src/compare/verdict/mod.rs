//! Whether renderers agree on a scene: a verdict on two lists of noisy images with three outcomes.
//!
//! **agree** is proved: in every tile and in the whole image, in each channel, the difference lies within the tolerance at a level
//! of 5 % (two one-sided tests). **differ** is proved too: in some cell the difference is larger than the tolerance and larger than
//! chance allows at a level of 0.5 % over all tests. Everything else is **undecided**, and says how many samples would decide. More
//! noise never makes more agreement: a wider error takes away from both proofs.
//!
//! Cells are those of a grid of 8 by 8 tiles and of the same image cut 4, 2 and 1 times along each side. The error of a cell comes
//! from the scatter of its pixels over the images, widened by the correlation between pixels (reconstruction filters, reuse of paths). No
//! sample is clipped or left out as an outlier; instead each renderer is taken to have missed one event as large as the largest that
//! either has seen nearby. Skewness is corrected as Hall (1992) does. How often it is wrong, docs/calibration.md says.

mod kept;
mod normal;
mod side;
mod stated;
mod words;

use serde::{Deserialize, Serialize};

use rayon::prelude::*;

use super::moments::Moments;
use super::{CompareError, Images};
pub use kept::{Kept, MeanError, error_of, judge_kept, mean_error};
pub use stated::{Stated, judge_stated};
pub use words::Told;

use side::{Estimate, Noise, Place, Side};

/// Tiles along each side, and the coarser cuts. Any of them may be the finest one of a verdict; noise is always estimated on all.
pub const GRIDS: [usize; 4] = [8, 4, 2, 1];

const _: () = assert!(GRIDS[0] == super::moments::FINE, "sums are kept of the finest tiles");

/// The chance that two equal renderers are told apart, over all tests of a comparison.
const FALSE_ALARM: f64 = 0.005;

/// The deviate of the one-sided tests of agreement, 5 % each; since all must pass, nothing is corrected for their number.
const ONE_SIDED: f64 = 1.644_854;

/// Where a tile is darker than this share of the image, its tolerance is that of such a tile.
pub(crate) const DARK: f64 = 0.1;

/// A channel whose mean is below this share of the image's has its tolerance from the image's mean.
const FAINT: f64 = 0.01;

/// Pixels of the reference brighter than this many times its mean are left out: a light seen directly in a few pixels would
/// otherwise make the mean (the pools of the lteval suite: six pixels change it by 41 %). So are the eight pixels around each of them: the
/// edge of such a light covers a part of them, and that part is all noise. On veach_mis at 64 x 64 pixels the tile of the smallest light has
/// an error of 12.7 % with 4096 samples of each side where only the pixels that are bright enough are left out, 5.1 % with all pixels, and
/// 0.7 % without the edge.
const GLARE: f64 = 100.0;

/// The largest deviate that is told; without noise every difference has it.
const CERTAIN: f64 = 1e3;

/// The largest factor on the samples that a prediction names.
const FARTHEST: f64 = 1e4;

/// Images of one renderer, rendered independently of each other.
#[derive(Clone, Copy)]
pub struct Rendered<'i> {
    /// The images; a single one is taken to be free of noise.
    pub images: Images<'i>,
    /// Samples per pixel of each.
    pub samples: f64,
}

/// Shares by which two renderers may differ and still agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// In each tile, and in cells of several tiles.
    pub tiles: f64,
    /// In the whole image.
    pub whole: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { tiles: 0.05, whole: 0.01 }
    }
}

/// What is proved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// They agree within the tolerance.
    Agree,
    /// They differ by more than the tolerance.
    Differ,
    /// Neither is proved.
    Undecided,
}

impl Verdict {
    /// Tiles along each side.
    #[must_use]
    pub fn side(&self) -> usize {
        self.tiles.len().isqrt()
    }
}

impl Outcome {
    /// The word that people read.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Differ => "differ",
            Self::Undecided => "undecided",
        }
    }
}

/// The mean of a channel over the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// B / A; none where A is black.
    pub ratio: Option<f64>,
    /// Standard error of that ratio.
    pub error: f64,
}

/// A place in a grid, and what it shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Cells along each side of its grid: 8, 4, 2 or 1.
    pub grid: usize,
    /// Column and row from the upper left, beginning with 0.
    pub at: (usize, usize),
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// B / A there; none where A is black.
    pub ratio: Option<f64>,
    /// The difference in standard errors, as a normal deviate.
    pub z: f64,
}

/// How many samples per pixel would prove agreement if the two are equal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Needed {
    /// In one of two cases; none beyond ten thousand times those of B.
    pub half: Option<f64>,
    /// In nine of ten.
    pub most: Option<f64>,
    /// Column and row of the tile that needs them most; none for the whole image.
    pub tile: Option<(usize, usize)>,
}

/// The verdict on two renderers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// What is proved of the whole.
    pub outcome: Outcome,
    /// Within what.
    pub tolerance: Tolerance,
    /// Images of A and of B.
    pub images: (usize, usize),
    /// Red, green and blue over the whole image.
    pub channels: [Channel; 3],
    /// Of the tiles of the finest grid, row by row; as many along each side as the square root of their number.
    pub tiles: Vec<Outcome>,
    /// Of all cells and channels the one that differs the most for its noise.
    pub worst: Cell,
    /// Cells and channels that differ by more than the tolerance and more than chance allows.
    pub differing: usize,
    /// Samples that would decide; none where it is decided.
    pub needed: Option<Needed>,
    /// Tiles that agree while their neighbors have rare bright samples that they have not met.
    pub rare: usize,
    /// Whether all of an image of A, of B goes up and down together.
    pub together: (bool, bool),
    /// Pixels left out for their brightness or for not being finite.
    pub masked: usize,
}

/// A cell with both sides' estimates in one channel.
struct Test {
    cell: Cell,
    a: Estimate,
    b: Estimate,
    /// What the tolerance is a share of.
    scale: f64,
    tolerance: f64,
    /// Variance for proving agreement, and for proving a difference.
    spread: (f64, f64),
}

impl Test {
    fn difference(&self) -> f64 {
        self.b.mean - self.a.mean
    }

    fn freedom(&self) -> f64 {
        let (a, b) = (self.a.variance, self.b.variance);
        if a + b <= 0.0 {
            return f64::INFINITY;
        }
        (a + b).powi(2) / (a * a / self.a.freedom + b * b / self.b.freedom)
    }

    fn allowed(&self) -> f64 {
        self.tolerance * self.scale
    }

    fn agrees(&self) -> bool {
        let room = self.allowed() - self.difference().abs();
        let spread = self.spread.0.sqrt();
        if spread <= 0.0 { room >= 0.0 } else { normal::of_t(room / spread, self.freedom()) > ONE_SIDED }
    }

    /// The difference in standard errors, its skewness corrected, as a normal deviate.
    fn deviate(&self) -> f64 {
        let spread = self.spread.1.sqrt();
        let t = self.difference() / spread.max(f64::MIN_POSITIVE);
        if self.difference() == 0.0 || t.abs() > CERTAIN {
            return t.clamp(-CERTAIN, CERTAIN);
        }
        let skew = ((self.b.third - self.a.third) / spread.powi(3)).clamp(-3.0, 3.0);
        normal::of_t(t + skew * t * t / 3.0 + skew * skew * t.powi(3) / 27.0 + skew / 6.0, self.freedom())
            .clamp(-CERTAIN, CERTAIN)
    }

    fn differs(&self, bound: f64) -> bool {
        self.cell.z.abs() > bound && self.difference().abs() > self.allowed()
    }

    /// The chance that agreement is proved with `factor` times the samples, if the two are equal.
    fn chance(&self, factor: f64) -> f64 {
        let spread = self.spread.0.sqrt();
        if spread <= 0.0 {
            return 1.0;
        }
        (2.0 * normal::below(factor.sqrt() * self.allowed() / spread - ONE_SIDED) - 1.0).max(0.0)
    }
}

/// Judges images of B against those of the reference A.
///
/// # Errors
/// Refuses images of different sizes, an A without images or without light, and a B of fewer than 3 images, which tell too little of
/// their noise (4 and more are better, 8 recommended).
pub fn judge(a: Rendered<'_>, b: Rendered<'_>, tolerance: Tolerance) -> Result<Verdict, CompareError> {
    judge_in(a, b, tolerance, GRIDS[0])
}

/// The same with `fine` tiles along each side, one of [`GRIDS`]: larger tiles have less noise, and tell less of where images differ.
///
/// # Errors
/// As of [`judge`].
pub fn judge_in(a: Rendered<'_>, b: Rendered<'_>, tolerance: Tolerance, fine: usize) -> Result<Verdict, CompareError> {
    enough(a.images, b.images)?;
    let moments = [a.images.moments()?, b.images.moments()?];
    judge_moments((a, &moments[0]), (b, &moments[1]), tolerance, fine)
}

/// Refuses too few images. One image of A is a reference without noise.
fn enough(a: Images<'_>, b: Images<'_>) -> Result<(), CompareError> {
    let counts = [a.count(), b.count()];
    if counts[0] == 0 {
        return Err(CompareError::Empty);
    }
    let few = |(at, images): (usize, usize)| (images < 3 && !(images == 1 && at == 0)).then_some(images);
    match counts.into_iter().enumerate().find_map(few) {
        Some(images) => Err(CompareError::Few { images }),
        None => Ok(()),
    }
}

/// The same for images whose moments are known; the images are read only where pixels are left out.
///
/// # Errors
/// As of [`judge`].
pub fn judge_moments(
    (a, of_a): (Rendered<'_>, &Moments),
    (b, of_b): (Rendered<'_>, &Moments),
    tolerance: Tolerance,
    fine: usize,
) -> Result<Verdict, CompareError> {
    enough(a.images, b.images)?;
    let counts = (a.images.count(), b.images.count());
    if (of_a.width, of_a.height) != (of_b.width, of_b.height) {
        return Err(CompareError::Size { a: (of_a.width, of_a.height), b: (of_b.width, of_b.height) });
    }
    let mask = mask(of_a, of_b);
    let masked = mask.iter().filter(|out| **out).count();
    if masked == mask.len() {
        return Err(CompareError::Empty);
    }
    let sides = [Side::of(of_a, a.images, &mask, a.samples)?, Side::of(of_b, b.images, &mask, b.samples)?];
    decided(&sides, (tolerance, fine), counts, masked)
}

/// The verdict on two sides.
fn decided(
    sides: &[Side; 2],
    (tolerance, fine): (Tolerance, usize),
    counts: (usize, usize),
    masked: usize,
) -> Result<Verdict, CompareError> {
    let noise = [0, 1].map(|at: usize| sides[at].noise());
    let tests = tests(sides, noise, tolerance, fine)?;
    let count = tests.len() as f64;
    let bound = normal::exceeded((1.0 - (1.0 - FALSE_ALARM).powf(1.0 / count)) / 2.0);
    Ok(verdict(tests, bound, (tolerance, fine), counts, noise, masked, sides[1].samples * sides[1].count))
}

/// All cells in all channels, the finest grid first.
fn tests(sides: &[Side; 2], noise: [Noise; 2], tolerance: Tolerance, fine: usize) -> Result<Vec<Test>, CompareError> {
    let of = |cell: Place, channel: usize| {
        (sides[0].estimate(cell, channel, noise[0]), sides[1].estimate(cell, channel, noise[1]))
    };
    let whole = [0, 1, 2].map(|channel| of(Place { grid: 1, index: 0 }, channel));
    let least = whole.map(|(a, b)| a.mean.min(b.mean));
    let light = least.iter().sum::<f64>() / 3.0;
    if whole.iter().all(|(a, _)| a.mean <= 0.0) {
        return Err(CompareError::Empty);
    }
    // The energy of one sample, spread over all that a side has.
    let shares: f64 =
        sides.iter().map(|side| if side.is_exact() { 0.0 } else { (side.count * side.samples).powi(-2) }).sum();
    let mut all = Vec::new();
    for grid in GRIDS.into_iter().filter(|grid| *grid <= fine) {
        let tile = grid == fine;
        let sizes: Vec<f64> = (0..grid * grid).map(|index| sides[0].size(Place { grid, index })).collect();
        for (channel, least) in least.into_iter().enumerate() {
            let estimates: Vec<Option<(Estimate, Estimate)>> = (0..grid * grid)
                .map(|index| (sizes[index] > 0.0).then(|| of(Place { grid, index }, channel)))
                .collect();
            let event = |at: usize| estimates[at].map_or(0.0, |(a, b)| a.event.max(b.event));
            for (at, estimate) in estimates.iter().enumerate() {
                let Some((a, b)) = *estimate else { continue };
                let own = event(at);
                let around = if tile { own.max(fourth_around(at, grid, &event)) } else { own };
                let missed = |event: f64| (event / sizes[at]).powi(2) * shares;
                let base = if least < FAINT * light { light } else { least };
                let scale = a.mean.min(b.mean).max(DARK * base);
                let variance = a.variance + b.variance;
                let place = Cell {
                    grid,
                    at: (at % grid, at / grid),
                    channel,
                    ratio: (a.mean > 0.0).then(|| b.mean / a.mean),
                    z: 0.0,
                };
                let mut test = Test {
                    cell: place,
                    a,
                    b,
                    scale,
                    tolerance: if grid == 1 { tolerance.whole } else { tolerance.tiles },
                    spread: (variance + missed(own), variance + missed(around)),
                };
                test.cell.z = test.deviate();
                all.push(test);
            }
        }
    }
    Ok(all)
}

fn verdict(
    tests: Vec<Test>,
    bound: f64,
    (tolerance, fine): (Tolerance, usize),
    images: (usize, usize),
    noise: [Noise; 2],
    masked: usize,
    samples: f64,
) -> Verdict {
    let of_tile = |tile: usize| {
        tests.iter().filter(move |test| test.cell.grid == fine && test.cell.at == (tile % fine, tile / fine))
    };
    let tiles: Vec<Outcome> = (0..fine * fine)
        .map(|tile| {
            if of_tile(tile).all(Test::agrees) {
                Outcome::Agree
            } else if of_tile(tile).any(|test| test.differs(bound)) {
                Outcome::Differ
            } else {
                Outcome::Undecided
            }
        })
        .collect();
    let whole: Vec<&Test> = tests.iter().filter(|test| test.cell.grid == 1).collect();
    let differing = tests.iter().filter(|test| test.differs(bound)).count();
    let outcome = if tiles.iter().all(|tile| *tile == Outcome::Agree) && whole.iter().all(|test| test.agrees()) {
        Outcome::Agree
    } else if differing > 0 {
        Outcome::Differ
    } else {
        Outcome::Undecided
    };
    let rare = (0..fine * fine).filter(|tile| {
        tiles[*tile] == Outcome::Agree && of_tile(*tile).any(|test| ONE_SIDED * test.spread.1.sqrt() > test.allowed())
    });
    let rare = rare.count();
    // What is off by more than the tolerance comes before what is only sure to be off.
    let rank = |test: &&Test| (test.differs(bound), test.cell.z.abs());
    let worst =
        tests.iter().max_by(|one, other| rank(one).partial_cmp(&rank(other)).unwrap_or(std::cmp::Ordering::Equal));
    let channel = |channel: usize| {
        let test = whole.iter().find(|test| test.cell.channel == channel);
        test.map_or(Channel { ratio: None, error: 0.0 }, |test| {
            let ratio = test.cell.ratio;
            let share = ratio.unwrap_or(0.0);
            let error = (test.a.variance * share * share + test.b.variance).sqrt() / test.a.mean.max(f64::MIN_POSITIVE);
            Channel { ratio, error: if ratio.is_some() { error } else { 0.0 } }
        })
    };
    Verdict {
        outcome,
        tolerance,
        images,
        channels: [0, 1, 2].map(channel),
        worst: worst.map_or(Cell { grid: 1, at: (0, 0), channel: 0, ratio: None, z: 0.0 }, |test| test.cell),
        differing,
        needed: (outcome == Outcome::Undecided).then(|| needed(&tests, samples, fine)),
        rare,
        together: (noise[0].together, noise[1].together),
        tiles,
        masked,
    }
}

/// How many samples prove agreement if the two are equal; `samples` are those that B has in all.
fn needed(tests: &[Test], samples: f64, fine: usize) -> Needed {
    let must: Vec<&Test> = tests.iter().filter(|test| test.cell.grid == 1 || test.cell.grid == fine).collect();
    // Of each cell the channel that is the least sure decides.
    let chances = |factor: f64| {
        let mut all = std::collections::BTreeMap::new();
        for test in &must {
            let chance = test.chance(factor);
            let least: &mut f64 = all.entry((test.cell.grid, test.cell.at)).or_insert(1.0);
            *least = least.min(chance);
        }
        all
    };
    let together = |factor: f64| chances(factor).values().product::<f64>();
    let factor = |wanted: f64| {
        if together(FARTHEST) < wanted {
            return None;
        }
        let (mut low, mut high) = (1.0_f64.recip() / FARTHEST, FARTHEST);
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if together(middle) < wanted { low = middle } else { high = middle }
        }
        Some(high)
    };
    let (half, most) = (factor(0.5), factor(0.9));
    let least = chances(half.unwrap_or(FARTHEST)).into_iter().min_by(|one, other| one.1.total_cmp(&other.1));
    let tile = least.and_then(|((grid, at), _)| (grid == fine && fine > 1).then_some(at));
    Needed { half: half.map(|factor| factor * samples), most: most.map(|factor| factor * samples), tile }
}

/// The fourth largest value among a tile and its eight neighbors, those beyond the edge repeating the edge.
fn fourth_around(at: usize, grid: usize, value: &impl Fn(usize) -> f64) -> f64 {
    let (x, y) = ((at % grid) as isize, (at / grid) as isize);
    let inside = |place: isize| place.clamp(0, grid as isize - 1) as usize;
    let mut around: Vec<f64> = (-1..=1)
        .flat_map(|row| (-1..=1).map(move |column| (row, column)))
        .map(|(row, column)| value(inside(y + row) * grid + inside(x + column)))
        .collect();
    around.sort_by(|one, other| other.total_cmp(one));
    around[3]
}

/// Which pixels are left out: those that are not finite in some image, and glare of the reference.
fn mask(a: &Moments, b: &Moments) -> Vec<bool> {
    let bad = |at: usize| a.is_bad(at) || b.is_bad(at);
    let light = |at: usize| (!bad(at)).then(|| a.mean(at).iter().sum::<f64>());
    let all: Vec<Option<f64>> = (0..a.width * a.height).into_par_iter().map(light).collect();
    glare(&all, a.width).into_iter().enumerate().map(|(at, glare)| glare || bad(at)).collect()
}

/// Which pixels show a light directly, or its edge; of some it is not known how bright they are.
pub(crate) fn glare(light: &[Option<f64>], width: usize) -> Vec<bool> {
    let known = light.iter().flatten().count();
    let mean = light.iter().flatten().sum::<f64>() / known.max(1) as f64;
    let mut out = vec![false; light.len()];
    let (width, height) = (width.max(1), light.len() / width.max(1));
    for (at, light) in light.iter().enumerate() {
        if light.is_none_or(|light| light <= GLARE * mean) {
            continue;
        }
        let (x, y) = (at % width, at / width);
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            out[row * width + x.saturating_sub(1)..row * width + (x + 2).min(width)].fill(true);
        }
    }
    out
}

#[cfg(test)]
mod tests;

#[cfg(test)]
#[path = "exact_tests.rs"]
mod exact_tests;
