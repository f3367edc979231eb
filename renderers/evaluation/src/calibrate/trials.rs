//! The trials: pairs are drawn, something is planted or not, and the verdict is asked.

use ltsc_render::image::Image;
use rayon::prelude::*;

use super::draw::{Design, Random, growing, pair};
use super::plant::{Distance, Plant, Truth};
use super::record::{CLEAR, Prediction, Row, SMALL, Test};
use super::suite::{SAMPLES, Scene, Variant};
use crate::compare::Images;
use crate::compare::verdict::{Needed, Outcome, Rendered, Tolerance, judge};
use crate::failure::{Exit, Failure};

/// Images of each side where nothing else is said.
const IMAGES: usize = 8;

/// Chunks of an image with which pairs grow: from 512 to 8192 samples per pixel in eight images.
const LEVELS: [usize; 7] = [4, 8, 16, 24, 32, 48, 64];

/// Something is planted from so many chunks on, where equals are likely to agree.
const PLANTED_FROM: usize = 32;

/// Pairs of one renderer, with their shares of all pairs that are asked for: few and many images, few and many samples, and sides that
/// are unlike.
const SAME: [(Design, Design, f64); 6] = [
    (design(4, 1), design(4, 1), 0.2),
    (design(8, 1), design(8, 1), 0.2),
    (design(16, 1), design(16, 1), 0.2),
    (design(8, 1), design(8, 16), 0.2),
    (design(4, 1), design(16, 16), 0.1),
    (design(8, 16), design(8, 16), 0.1),
];

/// The base against another estimator.
const ESTIMATOR: [(Design, Design, f64); 3] =
    [(design(8, 1), design(8, 1), 0.25), (design(8, 8), design(8, 8), 0.1), (design(16, 16), design(4, 1), 0.1)];

/// The base against another scene.
const REAL: [Design; 3] = [design(8, 1), design(8, 4), design(8, 16)];

/// Where planted differences are looked for at the small tolerance.
const POWER: [Design; 2] = [design(8, 1), design(8, 16)];

/// Shares of all pairs that are asked for.
const GROWING_SHARE: f64 = 0.15;
const OTHER_SHARE: f64 = 0.1;

const fn design(images: usize, chunks: usize) -> Design {
    Design { images, chunks }
}

/// What there is to draw from.
pub struct Pools<'p> {
    /// The scene.
    pub scene: &'p Scene,
    /// As it is.
    pub base: &'p [Image],
    /// Written otherwise; empty where it was not rendered.
    pub variants: &'p [(&'p Variant, Vec<Image>)],
    /// What the random numbers begin with.
    pub seed: u64,
    /// Pairs of one renderer; everything else is counted in shares of it.
    pub pairs: usize,
}

/// What was counted of a scene.
#[derive(Default)]
pub struct Counted {
    /// Rows.
    pub rows: Vec<Row>,
    /// Predictions.
    pub predictions: Vec<Prediction>,
    /// What could not be counted.
    pub missing: Vec<String>,
}

/// One kind of trial before it is counted.
struct Kind<'n> {
    test: Test,
    what: &'n str,
    designs: (Design, Design),
    tolerance: f64,
    distance: Option<Distance>,
}

impl Kind<'_> {
    fn row(&self, outcomes: &[Outcome]) -> Row {
        let count = |outcome| outcomes.iter().filter(|one| **one == outcome).count() as u64;
        Row {
            test: self.test,
            what: self.what.to_owned(),
            a: self.designs.0,
            b: self.designs.1,
            tolerance: self.tolerance,
            distance: self.distance,
            pairs: outcomes.len() as u64,
            agree: count(Outcome::Agree),
            differ: count(Outcome::Differ),
        }
    }
}

/// The verdict on two sides, of which each image has so many chunks.
fn verdict(
    (a, b): (&[Image], &[Image]),
    designs: (Design, Design),
    tolerance: f64,
) -> Result<(Outcome, Option<Needed>), Failure> {
    let side = |images, design: Design| Rendered {
        images: Images::Held(images),
        samples: f64::from(SAMPLES) * design.chunks as f64,
    };
    let within = Tolerance { tiles: tolerance, whole: tolerance };
    let verdict = judge(side(a, designs.0), side(b, designs.1), within)
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
    Ok((verdict.outcome, verdict.needed))
}

/// So much of all pairs, at least one.
fn part(pairs: usize, share: f64) -> u64 {
    ((pairs as f64 * share).round() as u64).max(1)
}

/// All trials of a scene that its pools are large enough for.
///
/// # Errors
/// Where images cannot be judged: black ones, or of different sizes.
pub fn count(pools: &Pools<'_>) -> Result<Counted, Failure> {
    let mut counted = Counted::default();
    let Some(truth) = Truth::of(pools.base) else {
        counted.missing.push("the base was not rendered".to_owned());
        return Ok(counted);
    };
    pools.same(&mut counted)?;
    pools.predictions(&mut counted)?;
    for tolerance in pools.scene.tolerances {
        pools.growing(*tolerance, &truth, &mut counted)?;
    }
    for (variant, pool) in pools.variants {
        match Truth::of(pool) {
            None => counted.missing.push(format!("`{}` was not rendered", variant.name)),
            Some(_) if variant.same => pools.estimator(variant, pool, &mut counted)?,
            Some(other) => pools.real(variant, pool, truth.distance(&other), &mut counted)?,
        }
    }
    pools.power(&truth, &mut counted)?;
    Ok(counted)
}

impl Pools<'_> {
    /// The numbers of a trial.
    fn random(&self, what: &str, trial: u64) -> Random {
        Random::of(self.seed, &format!("{} {what}", self.scene.label()), trial)
    }

    /// Draws and judges pairs; none where a pool is too small, which is then told.
    fn pairs(
        &self,
        other: Option<&[Image]>,
        kind: &Kind<'_>,
        trials: u64,
        missing: &mut Vec<String>,
    ) -> Result<Option<Row>, Failure> {
        let Kind { designs: (a, b), what, .. } = kind;
        let (of_base, of_other) = if other.is_some() { (a.total(), b.total()) } else { (a.total() + b.total(), 0) };
        if of_base > self.base.len() || other.is_some_and(|other| of_other > other.len()) {
            missing.push(format!(
                "{what}, {} x {} chunks against {} x {}: needs {of_base} chunks of the base{}",
                a.images,
                a.chunks,
                b.images,
                b.chunks,
                if of_other > 0 { format!(" and {of_other} of the other") } else { String::new() }
            ));
            return Ok(None);
        }
        let name = format!("{what} {}x{} {}x{}", a.images, a.chunks, b.images, b.chunks);
        let one = |trial: u64| {
            let drawn = pair(&mut self.random(&name, trial), self.base, other, kind.designs);
            let Some((a, b)) = drawn else { return Ok(Outcome::Undecided) };
            verdict((&a, &b), kind.designs, kind.tolerance).map(|(outcome, _)| outcome)
        };
        let outcomes = (0..trials).into_par_iter().map(one).collect::<Result<Vec<_>, Failure>>()?;
        Ok(Some(kind.row(&outcomes)))
    }

    fn same(&self, counted: &mut Counted) -> Result<(), Failure> {
        for (a, b, share) in SAME {
            let kind = Kind { test: Test::Same, what: "equal", designs: (a, b), tolerance: SMALL, distance: None };
            counted.rows.extend(self.pairs(None, &kind, part(self.pairs, share), &mut counted.missing)?);
        }
        Ok(())
    }

    fn estimator(&self, variant: &Variant, pool: &[Image], counted: &mut Counted) -> Result<(), Failure> {
        for (a, b, share) in ESTIMATOR {
            let (test, what) = (Test::Estimator, variant.name);
            let kind = Kind { test, what, designs: (a, b), tolerance: SMALL, distance: None };
            counted.rows.extend(self.pairs(Some(pool), &kind, part(self.pairs, share), &mut counted.missing)?);
        }
        Ok(())
    }

    fn real(
        &self,
        variant: &Variant,
        pool: &[Image],
        distance: Distance,
        counted: &mut Counted,
    ) -> Result<(), Failure> {
        let (last, trials) = (REAL[REAL.len() - 1], part(self.pairs, OTHER_SHARE));
        // The largest tolerance that it is still far beyond, down to a tenth of a percent.
        let widest = libm::floor(1000.0 * distance.proved / CLEAR) / 1000.0;
        let mut all: Vec<(Design, f64)> = REAL.iter().map(|design| (*design, SMALL)).collect();
        all.extend(self.scene.tolerances.iter().map(|tolerance| (last, *tolerance)));
        if widest > SMALL {
            all.push((last, widest));
            let equal =
                Kind { test: Test::Growing, what: "equal", designs: (last, last), tolerance: widest, distance: None };
            counted.rows.extend(self.pairs(None, &equal, trials, &mut counted.missing)?);
        }
        for (design, tolerance) in all {
            let (test, what) = (Test::Real, variant.name);
            let kind = Kind { test, what, designs: (design, design), tolerance, distance: Some(distance) };
            counted.rows.extend(self.pairs(Some(pool), &kind, trials, &mut counted.missing)?);
        }
        Ok(())
    }

    /// What few samples predict.
    fn predictions(&self, counted: &mut Counted) -> Result<(), Failure> {
        for (from, tolerance) in [4, 8, 16]
            .into_iter()
            .flat_map(|images| self.scene.tolerances.iter().map(move |one| (design(images, 1), one)))
        {
            if 2 * from.total() > self.base.len() {
                counted.missing.push(format!("predictions from {} x 1 chunks", from.images));
                continue;
            }
            let name = format!("prediction {}", from.images);
            let one = |trial: u64| {
                let drawn = pair(&mut self.random(&name, trial), self.base, None, (from, from));
                let Some((a, b)) = drawn else { return Ok((Outcome::Undecided, None)) };
                verdict((&a, &b), (from, from), *tolerance)
            };
            let trials = part(self.pairs, OTHER_SHARE);
            let all = (0..trials).into_par_iter().map(one).collect::<Result<Vec<_>, Failure>>()?;
            let outcomes: Vec<Outcome> = all.iter().map(|(outcome, _)| *outcome).collect();
            let (test, designs, tolerance) = (Test::Growing, (from, from), *tolerance);
            let equal = Kind { test, what: "equal", designs, tolerance, distance: None };
            counted.rows.push(equal.row(&outcomes));
            // Where it is decided already nothing is predicted.
            let needed: Vec<Needed> = all.into_iter().filter_map(|(_, needed)| needed).collect();
            let sorted = |of: fn(&Needed) -> Option<f64>| {
                let mut all: Vec<f64> = needed.iter().map(|one| of(one).unwrap_or(f64::INFINITY)).collect();
                all.sort_by(f64::total_cmp);
                all
            };
            let (half, most) = (sorted(|one| one.half), sorted(|one| one.most));
            let at = |all: &[f64], share: f64| {
                let place = (share * all.len().saturating_sub(1) as f64).round() as usize;
                all.get(place).copied().filter(|value| value.is_finite()).map(three_digits)
            };
            counted.predictions.push(Prediction {
                tolerance,
                from,
                pairs: needed.len() as u64,
                half: [0.1, 0.5, 0.9].map(|share| at(&half, share)),
                most: at(&most, 0.5),
            });
        }
        Ok(())
    }

    /// Equal pairs that grow; the largest ones also with something planted.
    fn growing(&self, tolerance: f64, truth: &Truth, counted: &mut Counted) -> Result<(), Failure> {
        let fits = |level: &&usize| 2 * IMAGES * **level <= self.base.len();
        let levels: Vec<usize> = LEVELS.iter().filter(fits).copied().collect();
        if let Some(first) = LEVELS.iter().find(|level| !levels.contains(level)) {
            let needs = 2 * IMAGES * first;
            counted
                .missing
                .push(format!("pairs of {IMAGES} x {first} chunks and more need {needs} chunks of the base"));
        }
        let (bright, shift) = (truth.bright(), Truth::with(self.base, |image| Plant::Shift.on(image)));
        let shift = shift.map_or(Distance::default(), |shifted| truth.distance(&shifted));
        let kinds = planted(tolerance, shift);
        let trials = part(self.pairs, GROWING_SHARE);
        // Of each level the outcome without anything planted, and those of all that is.
        let one = |trial: u64| {
            let mut random = self.random(&format!("growing {tolerance}"), trial);
            let tile = bright.get(random.below(bright.len())).copied().unwrap_or(0);
            let channel = random.below(3);
            let mut all: Vec<Vec<Outcome>> = Vec::new();
            let mut failed = None;
            growing(&mut random, self.base, IMAGES, &levels, &mut |at, a, b| {
                let designs = (design(IMAGES, levels[at]), design(IMAGES, levels[at]));
                let plants: &[Planted] = if levels[at] >= PLANTED_FROM { &kinds } else { &[] };
                let plants = plants.iter().map(|one| (one.plant)(one.factor, tile, channel));
                let outcomes = std::iter::once(None).chain(plants.map(Some)).map(|plant| {
                    let other: Option<Vec<Image>> = plant.map(|plant| b.iter().map(|image| plant.on(image)).collect());
                    Ok(verdict((a, other.as_deref().unwrap_or(b)), designs, tolerance)?.0)
                });
                match outcomes.collect::<Result<Vec<_>, Failure>>() {
                    Ok(outcomes) => all.push(outcomes),
                    Err(failure) => failed = Some(failure),
                }
            });
            failed.map_or(Ok(all), Err)
        };
        let all = (0..trials).into_par_iter().map(one).collect::<Result<Vec<_>, Failure>>()?;
        for (at, level) in levels.iter().enumerate() {
            let designs = (design(IMAGES, *level), design(IMAGES, *level));
            let of = |kind: usize| -> Vec<Outcome> {
                all.iter().filter_map(|levels| levels.get(at)?.get(kind).copied()).collect()
            };
            let equal = Kind { test: Test::Growing, what: "equal", designs, tolerance, distance: None };
            counted.rows.push(equal.row(&of(0)));
            for (kind, one) in kinds.iter().enumerate().filter(|_| *level >= PLANTED_FROM) {
                let Planted { what, distance, .. } = one;
                let row = Kind { test: Test::Planted, what, designs, tolerance, distance: Some(*distance) };
                counted.rows.push(row.row(&of(kind + 1)));
            }
        }
        Ok(())
    }

    fn power(&self, truth: &Truth, counted: &mut Counted) -> Result<(), Failure> {
        let bright = truth.bright();
        for one in POWER {
            if 2 * one.total() > self.base.len() {
                counted.missing.push(format!("power of {} x {} chunks", one.images, one.chunks));
                continue;
            }
            let all: Vec<Power> = [("whole image", WHOLE), ("green", GREEN), ("one tile", TILE)]
                .into_iter()
                .flat_map(|(what, plant)| {
                    let named = |share: f64| format!("{what} +{:.0} %", 100.0 * share);
                    [0.02, 0.05].map(|share| Power { what: named(share), share, plant })
                })
                .collect();
            let trial = |trial: u64| {
                let mut random = self.random(&format!("power {}x{}", one.images, one.chunks), trial);
                let tile = bright.get(random.below(bright.len())).copied().unwrap_or(0);
                let Some((a, b)) = pair(&mut random, self.base, None, (one, one)) else { return Ok(Vec::new()) };
                let of = |Power { what: _, share, plant }: &Power| {
                    let other: Vec<Image> = b.iter().map(|image| plant(1.0 + share, tile, 1).on(image)).collect();
                    verdict((&a, &other), (one, one), SMALL).map(|(outcome, _)| outcome)
                };
                all.iter().map(of).collect::<Result<Vec<_>, Failure>>()
            };
            let trials = part(self.pairs, OTHER_SHARE);
            let outcomes = (0..trials).into_par_iter().map(trial).collect::<Result<Vec<_>, Failure>>()?;
            for (at, Power { what, share, plant: _ }) in all.iter().enumerate() {
                let (test, distance) = (Test::Power, Some(Distance { share: *share, proved: *share }));
                let kind = Kind { test, what, designs: (one, one), tolerance: SMALL, distance };
                let of: Vec<Outcome> = outcomes.iter().filter_map(|all| all.get(at).copied()).collect();
                counted.rows.push(kind.row(&of));
            }
        }
        Ok(())
    }
}

/// What is planted, by a factor, in this tile or this channel.
type Made = fn(f64, usize, usize) -> Plant;

const TILE: Made = |factor, tile, _| Plant::Tile(tile, factor);
const CHANNEL: Made = |factor, _, channel| Plant::Channel(channel, factor);
const GREEN: Made = |factor, _, _| Plant::Channel(1, factor);
const WHOLE: Made = |factor, _, _| Plant::Whole(factor);

/// Something that is planted at the small tolerance, brighter by a share.
struct Power {
    what: String,
    share: f64,
    plant: Made,
}

/// Something that is planted where equals are likely to agree.
struct Planted {
    what: String,
    plant: Made,
    factor: f64,
    distance: Distance,
}

/// All of them, in tolerances; `shift` is how far a shift by one pixel is from the image.
fn planted(tolerance: f64, shift: Distance) -> Vec<Planted> {
    let of = |what: &str, plant, times: f64, up: bool| {
        let share = times * tolerance;
        // A tolerance is a share of the darker side.
        let factor = if up { 1.0 + share } else { 1.0 / (1.0 + share) };
        let (sign, distance) = (if up { '+' } else { '-' }, Distance { share, proved: share });
        Planted {
            what: format!("{what} {sign}{times} {}", if times > 1.0 { "tolerances" } else { "tolerance" }),
            plant,
            factor,
            distance,
        }
    };
    let moved =
        Planted { what: "shifted by a pixel".to_owned(), plant: |_, _, _| Plant::Shift, factor: 1.0, distance: shift };
    vec![
        of("one tile", TILE, CLEAR, true),
        of("one tile", TILE, CLEAR, false),
        // At the tolerance itself a tile may be called equal in 5 % of all cases.
        of("one tile", TILE, 1.0, true),
        of("one channel", CHANNEL, CLEAR, true),
        of("whole image", WHOLE, CLEAR, false),
        moved,
    ]
}

/// Rounded, so that a record does not change in its last digit.
fn three_digits(value: f64) -> f64 {
    let scale = 10_f64.powi(2 - libm::floor(libm::log10(value.max(f64::MIN_POSITIVE))) as i32);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests;
