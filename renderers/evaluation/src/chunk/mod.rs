//! Images in pieces: a rendering of many samples is the mean of several renderings of few, each with a seed of its own.
//!
//! A chunk is known by its content: the files that were written for the renderer, the renderer and its version, samples and seed. What
//! was rendered once is not rendered again, whoever asks: a killed run goes on where it stopped, and more samples need only what is not
//! there yet. Their scatter tells the error of the mean.

mod combine;
mod facts;
mod store;

pub use combine::{Chunks, Cost, VARIANCE, write};
pub use facts::{Facts, Machine};
pub use store::{Entry, Store, Summary};

use ltsc_render::run::{Driver, Progress, Seeds};

use crate::failure::Failure;
use crate::job::Job;
use crate::watch::Watch;

/// The fewest chunks of an image whose error is to be told.
pub const LEAST: u64 = 8;

/// How the samples of an image are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Samples per pixel of each chunk.
    pub samples: u32,
    /// How many there are.
    pub count: u32,
}

impl Plan {
    /// At least `samples` per pixel, in chunks whose size depends on nothing else, so that more samples later are some chunks more: 1024
    /// samples from 8192 on, 16 times as many for each factor of 16 from there on, 64 below, and fewer where there would be less than
    /// eight chunks.
    #[must_use]
    pub fn of(samples: u64) -> Self {
        let samples = samples.max(1);
        let mut size: u64 = 64;
        while samples >= size * 16 * LEAST {
            size *= 16;
        }
        while size > 1 && samples < size * LEAST {
            size /= 2;
        }
        Self::with(samples, u32::try_from(size).unwrap_or(u32::MAX))
    }

    /// [`Plan::of`] for a renderer: no chunk has fewer samples than those with which its images are independent.
    #[must_use]
    pub fn for_driver(driver: &Driver, samples: u64) -> Self {
        let plan = Self::of(samples);
        if plan.samples < driver.least_samples { Self::with(samples, driver.least_samples) } else { plan }
    }

    /// At least `samples` per pixel in chunks of `size`.
    #[must_use]
    pub fn with(samples: u64, size: u32) -> Self {
        let size = size.max(1);
        let count = samples.max(1).div_ceil(u64::from(size));
        Self { samples: size, count: u32::try_from(count).unwrap_or(u32::MAX) }
    }

    /// Samples per pixel in all.
    #[must_use]
    pub fn total(self) -> u64 {
        u64::from(self.samples) * u64::from(self.count)
    }

    /// One chunk of all samples, for renderers without seeds: their error cannot be told.
    #[must_use]
    pub fn whole(samples: u64) -> Self {
        Self { samples: u32::try_from(samples.max(1)).unwrap_or(u32::MAX), count: 1 }
    }
}

/// From so many samples on, an image is rendered in chunks, so that what was rendered is not lost where a run is ended.
const LONG: u64 = 8192;

/// How an image is rendered that nobody asks the error of: whole, but long ones by renderers whose seeds cost nothing.
#[must_use]
pub fn plan_of_one(driver: &Driver, samples: u64) -> Plan {
    if samples >= LONG && driver.seeds == Seeds::Free {
        Plan::for_driver(driver, samples)
    } else {
        Plan::whole(samples)
    }
}

/// Renders an image in chunks, one after the other, each with all threads of the job; those that are there are not rendered again.
///
/// # Errors
/// What the renderer says, or the disk.
pub fn render(
    store: &Store,
    job: &Job<'_>,
    plan: Plan,
    first_seed: u32,
    watch: &mut dyn Watch,
) -> Result<Chunks, Failure> {
    let driver = job.runner().driver.name;
    let what = format!("{} ({driver})", job.scene());
    watch.begin(plan.total(), &what);
    let mut kept = 0;
    for at in 0..plan.count {
        let before = u64::from(at) * u64::from(plan.samples);
        let chunk = (plan.samples, first_seed.saturating_add(at));
        let made = store.make(job, chunk, &mut |news| match news {
            Progress::Samples { done, total: _, seconds: _ } => watch.set(before + done),
            Progress::Started { .. } | Progress::Loaded { .. } => watch.set(before),
        });
        kept += u32::from(matches!(made, Ok(None)));
        if let Err(failure) = made {
            watch.end();
            return Err(failure);
        }
    }
    watch.end();
    if kept > 0 {
        let (chunks, samples) = (plan.count, plan.samples);
        watch.note(&format!("{kept} of {chunks} chunks of {samples} samples were there from before"));
    }
    Chunks::of(store, job, plan, first_seed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_have_enough_chunks_and_grow_by_chunks() {
        let of = |samples| (Plan::of(samples).samples, Plan::of(samples).count);
        assert_eq!(
            [1, 8, 16, 100, 512, 1024, 4096, 8192, 100_000, 131_072].map(of),
            [(1, 1), (1, 8), (2, 8), (8, 13), (64, 8), (64, 16), (64, 64), (1024, 8), (1024, 98), (16_384, 8)]
        );
    }

    #[test]
    fn a_plan_has_all_the_samples_and_eight_chunks_where_there_are_eight_samples() {
        for samples in (1..5000).chain((5000..10_000_000).step_by(4999)) {
            let plan = Plan::of(samples);
            assert!(plan.total() >= samples && plan.total() < samples + u64::from(plan.samples), "{samples}: {plan:?}");
            assert!(plan.count <= 129 && (samples < LEAST || u64::from(plan.count) >= LEAST), "{samples}: {plan:?}");
        }
    }
}
