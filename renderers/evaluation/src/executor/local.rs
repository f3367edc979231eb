//! Renders on this machine, several chunks at once.

use std::sync::{Condvar, Mutex, PoisonError};

use super::{Executor, Kind, News, Order, Outcome, Resources};
use crate::failure::Failure;

/// The row of the table.
pub const KIND: Kind = Kind {
    name: "local",
    summary: "this machine",
    make: |resources| Ok(Box::new(Local { resources: resources.clone() })),
};

/// Several renderers at once on this machine, as far as its memory allows: the first ones show how much they take.
pub struct Local {
    resources: Resources,
}

/// What the threads share.
struct State {
    next: usize,
    running: usize,
    failed: bool,
    /// The most memory that a renderer has held.
    largest: u64,
    outcomes: Vec<Outcome>,
}

impl Local {
    /// With so much of the machine.
    #[must_use]
    pub fn new(resources: Resources) -> Self {
        Self { resources }
    }

    /// How many may run at once where one takes so much memory.
    fn at_once(&self, largest: u64) -> usize {
        let jobs = self.resources.jobs.max(1);
        match self.resources.memory {
            Some(memory) if largest > 0 => jobs.min(usize::try_from(memory / largest).unwrap_or(jobs)).max(1),
            _ => jobs,
        }
    }
}

impl Executor for Local {
    fn run(&self, order: &Order<'_>, news: &(dyn Fn(News<'_>) + Sync)) -> Result<Vec<Outcome>, Failure> {
        let outcomes = order.tasks.iter().map(|_| Outcome::Skipped).collect();
        let state = Mutex::new(State { next: 0, running: 0, failed: false, largest: 0, outcomes });
        let changed = Condvar::new();
        let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
        let work = || {
            loop {
                let at = {
                    let mut state = lock();
                    loop {
                        if state.next >= order.tasks.len() || state.failed && !order.keep_going {
                            return;
                        }
                        if state.running < self.at_once(state.largest) {
                            break;
                        }
                        state = changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                    }
                    let at = state.next;
                    state.next += 1;
                    state.running += 1;
                    at
                };
                let task = order.tasks[at];
                news(News::Begun(at));
                let made = order.store.make(&order.jobs[task.job], (task.samples, task.seed), &mut |_| {});
                let (outcome, memory) = match made {
                    Ok(Some(facts)) => (Outcome::Made, facts.peak_memory.unwrap_or(0)),
                    Ok(None) => (Outcome::Kept, 0),
                    Err(failure) => (Outcome::Failed(failure), 0),
                };
                news(News::Ended(at, &outcome));
                let mut state = lock();
                state.running -= 1;
                state.largest = state.largest.max(memory);
                state.failed |= matches!(outcome, Outcome::Failed(_));
                state.outcomes[at] = outcome;
                drop(state);
                changed.notify_all();
            }
        };
        std::thread::scope(|scope| {
            let threads = self.resources.jobs.clamp(1, order.tasks.len().max(1));
            for _ in 0..threads {
                scope.spawn(work);
            }
        });
        Ok(state.into_inner().unwrap_or_else(PoisonError::into_inner).outcomes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_bounds_what_runs_at_once() {
        let local = |jobs, memory| Local::new(Resources { jobs, memory, shared: None, options: Vec::new() });
        assert_eq!(local(4, None).at_once(1 << 40), 4);
        assert_eq!(local(4, Some(8 << 30)).at_once(0), 4);
        assert_eq!(local(4, Some(8 << 30)).at_once(3 << 30), 2);
        assert_eq!(local(4, Some(1 << 30)).at_once(3 << 30), 1);
        assert_eq!(local(0, None).at_once(1), 1);
    }
}
