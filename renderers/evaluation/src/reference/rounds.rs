//! Chunks until their mean is good enough: rounds that grow as the scatter asks for, within a time.

use std::time::{Duration, Instant};

use ltsc_render::image::Image;
use ltsc_render::run::Progress;

use crate::chunk::{Chunks, LEAST, Plan, Store};
use crate::compare::CompareError;
use crate::compare::verdict::{MeanError, mean_error};
use crate::failure::{Exit, Failure};
use crate::job::Job;
use crate::watch::Watch;

/// Samples of all pixels of a chunk: some seconds of a renderer on two cores (128 x 128 pixels of a Cornell box with 256 samples took
/// Mitsuba 3 in its scalar variant 8 s, Cycles 12 s, LuxCore 14 s).
const WORK: usize = 1 << 22;

/// The fewest and the most samples per pixel of a chunk. Mitsuba has 1024 seeds at 512 x 512 pixels, so that 65,536 samples are the
/// most there.
const SIZES: (usize, usize) = (64, 256);

/// The fewest chunks whose mean is kept; fewer tell too little of their error.
const FEWEST: u32 = 4;

/// What is rendered at once beyond what the scatter asks for, as a share: half of all runs would end just short of the goal.
const MORE: f64 = 0.02;

/// Samples per pixel of each chunk of a reference of this size: a power of two that nothing else decides, so that chunks stay what
/// they are.
#[must_use]
pub fn chunk_samples((width, height): (usize, usize)) -> u32 {
    let wanted = (WORK / (width * height).max(1)).max(1);
    let power = 1_usize << wanted.ilog2();
    u32::try_from(power.clamp(SIZES.0, SIZES.1)).unwrap_or(u32::MAX)
}

/// Which error is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// [`MeanError::tiles`].
    Tiles,
    /// [`MeanError::pixels`].
    Pixels,
}

/// When a mean is good enough.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Which error is meant.
    pub measure: Measure,
    /// How large it may be.
    pub error: f64,
    /// After this time no chunk is begun.
    pub budget: Option<Duration>,
}

impl Goal {
    fn of(&self, error: &MeanError) -> f64 {
        match self.measure {
            Measure::Tiles => error.tiles,
            Measure::Pixels => error.pixels,
        }
    }

    /// How many chunks the goal takes, if the scatter of `count` of them is what it seems.
    fn needed(&self, count: u32, error: &MeanError) -> u64 {
        let share = self.of(error) / self.error;
        (f64::from(count) * share * share).ceil() as u64
    }
}

/// What a goal still takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Chunks.
    pub chunks: u64,
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds on this machine; none before a chunk was rendered.
    pub seconds: Option<f64>,
}

/// The mean of what there is.
pub struct Made {
    /// Its chunks.
    pub chunks: Chunks,
    /// The mean.
    pub image: Image,
    /// The variance of that mean.
    pub variance: Image,
    /// Its error.
    pub error: MeanError,
}

/// How far it went.
pub struct Reached {
    /// Chunks that there are.
    pub count: u32,
    /// Samples per pixel of each.
    pub samples: u32,
    /// Their mean; none where there are too few.
    pub made: Option<Made>,
    /// What remains; none where the goal is reached.
    pub left: Option<Left>,
    /// What ended it before its time.
    pub failed: Option<Failure>,
}

/// Renders chunks, the first with seed 0, until the goal is reached or the time is over; those that are there are not rendered again. What
/// the renderer says when it fails comes back beside what was reached before.
///
/// # Errors
/// If chunks cannot be read, or the image is black.
pub fn reach(store: &Store, job: &Job<'_>, goal: &Goal, watch: &mut dyn Watch) -> Result<Reached, Failure> {
    let (begun, samples) = (Instant::now(), chunk_samples(job.size()));
    let identity = job.identity();
    let before = (0..).take_while(|seed| store.has(&identity, samples, *seed)).count();
    let before = u32::try_from(before).unwrap_or(u32::MAX);
    let what = format!("{} ({})", job.scene(), job.runner().driver.name);
    if before > 0 {
        watch.note(&format!("{what}: {before} chunks of {samples} samples are there from before"));
    }
    let over = || goal.budget.is_some_and(|budget| begun.elapsed() >= budget);
    let least = u32::try_from(LEAST).unwrap_or(u32::MAX);
    let (mut count, mut wanted) = (0, before.max(least));
    let (mut failed, mut seconds, mut rendered) = (None, 0.0, 0_u32);
    loop {
        watch.begin(u64::from(wanted) * u64::from(samples), &what);
        while count < wanted && (count < before || !over()) {
            let at = u64::from(count) * u64::from(samples);
            watch.set(at);
            let made = store.make(job, (samples, count), &mut |news| {
                if let Progress::Samples { done, .. } = news {
                    watch.set(at + done);
                }
            });
            match made {
                Ok(facts) => {
                    count += 1;
                    seconds += facts.as_ref().map_or(0.0, |facts| facts.wall_seconds);
                    rendered += u32::from(facts.is_some());
                }
                Err(failure) => {
                    failed = Some(failure);
                    break;
                }
            }
        }
        watch.end();
        let each = (rendered > 0).then(|| seconds / f64::from(rendered));
        let left = |chunks: u64| Left {
            chunks,
            samples: chunks * u64::from(samples),
            seconds: each.map(|each| each * chunks as f64),
        };
        if count < FEWEST {
            let left = left(u64::from(least - count));
            return Ok(Reached { count, samples, made: None, left: Some(left), failed });
        }
        let made = mean(store, job, Plan { samples, count })?;
        let needed = goal.needed(count, &made.error);
        let reached = goal.of(&made.error) <= goal.error;
        if reached || failed.is_some() || over() {
            // A goal that is just missed takes one more.
            let rest = needed.saturating_sub(u64::from(count)).max(1);
            let left = (!reached).then(|| left(rest));
            return Ok(Reached { count, samples, made: Some(made), left, failed });
        }
        let more = (needed as f64 * (1.0 + MORE)) as u64;
        let next = more.clamp(u64::from(count) + 1, 2 * u64::from(count));
        wanted = u32::try_from(next).unwrap_or(u32::MAX);
        watch.note(&format!("{what}: {}, {wanted} chunks next", told(goal, &made.error, count, samples)));
    }
}

fn told(goal: &Goal, error: &MeanError, count: u32, samples: u32) -> String {
    let of = match goal.measure {
        Measure::Tiles => "of a tile",
        Measure::Pixels => "of a pixel",
    };
    let samples = u64::from(count) * u64::from(samples);
    format!("error {of} {:.2} % after {samples} samples", 100.0 * goal.of(error))
}

fn mean(store: &Store, job: &Job<'_>, plan: Plan) -> Result<Made, Failure> {
    let chunks = Chunks::of(store, job, plan, 0)?;
    let (moments, error) = mean_error(chunks.images()).map_err(|error| match error {
        CompareError::Empty => Failure::new(Exit::Environment, format!("the image of {} is black", job.scene()))
            .help("no light is found: try another algorithm by `--integrator`"),
        error => Failure::new(Exit::Environment, error.to_string()).help("remove that chunk: it is rendered again"),
    })?;
    let variance = moments.variance_image();
    if variance.pixels.as_flattened().iter().all(|value| *value == 0.0) {
        let message = format!("{} chunks of {} are all the same image", plan.count, job.scene());
        return Err(Failure::new(Exit::Environment, message).help(
            "the renderer does not obey its seed, or the scene has no noise: the error of such a mean cannot be told",
        ));
    }
    Ok(Made { chunks, image: moments.mean_image(), variance, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chunk_is_a_power_of_two_that_depends_on_the_size_alone() {
        let sizes = [(8, 8), (128, 128), (128, 96), (256, 256), (256, 192), (512, 512), (4096, 4096), (1, 1)];
        assert_eq!(sizes.map(chunk_samples), [256, 256, 256, 64, 64, 64, 64, 256]);
    }

    #[test]
    fn what_is_needed_grows_with_the_square() {
        let error = |tiles| MeanError { tiles, pixels: 0.1, ..MeanError::default() };
        let goal = Goal { measure: Measure::Tiles, error: 0.005, budget: None };
        assert_eq!(goal.needed(8, &error(0.05)), 800);
        assert_eq!(goal.needed(8, &error(0.005)), 8);
        assert_eq!(Goal { measure: Measure::Pixels, error: 0.05, ..goal }.needed(8, &error(0.05)), 32);
    }
}
