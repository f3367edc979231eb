//! Chunks of all runs, rendered by an executor; those of budgets follow in rounds.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::chunk::{Chunks, Plan};
use crate::executor::{News, Order, Outcome, Task};
use crate::failure::{Exit, Failure};
use crate::file::model::Run;
use crate::watch::Watch;

use super::Study;
use super::prepare::{Prepared, Ready};

/// How an evaluation is rendered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Goes on with the other cases where one fails.
    pub keep_going: bool,
}

/// What became of a run.
pub enum Fate {
    /// All of its chunks are there.
    Done(Chunks),
    /// It failed: what went wrong, once for all its chunks.
    Failed(Failure),
    /// It was not rendered, because another one had failed.
    Skipped,
    /// It is made by hand, and is not there yet.
    Awaited,
}

/// How many chunks of each run are to be rendered at first.
pub(super) fn wanted(prepared: &Prepared<'_>) -> Vec<u32> {
    prepared.runs.iter().map(|run| if run.manual.is_some() { 0 } else { run.plan.count }).collect()
}

/// Renders what is not there. The fates are in the order of the runs.
pub fn render(
    study: &Study<'_>,
    prepared: &Prepared<'_>,
    watch: &mut (dyn Watch + Send),
) -> Result<Vec<Fate>, Failure> {
    let mut wanted = wanted(prepared);
    let mut failed: BTreeMap<usize, Failure> = BTreeMap::new();
    loop {
        let tasks = tasks(prepared, &wanted);
        round(study, prepared, &tasks, &mut failed, watch)?;
        let stop = !failed.is_empty() && !study.options.keep_going;
        let mut more = false;
        for (at, count) in wanted.iter_mut().enumerate().filter(|_| !stop) {
            let new = with_budget(study, prepared, at, *count, &failed)?;
            more |= new > *count;
            *count = new;
        }
        if !more {
            break;
        }
    }
    let mut fates = Vec::new();
    for (at, (ready, count)) in prepared.runs.iter().zip(&wanted).enumerate() {
        if let Some(manual) = &ready.manual {
            fates.push(manual.chunks(ready.plan.samples).map_or(Fate::Awaited, Fate::Done));
            continue;
        }
        let plan = Plan { count: *count, ..ready.plan };
        fates.push(match failed.get(&at) {
            Some(Failure { exit, message, help }) => {
                Fate::Failed(Failure { exit: *exit, message: message.clone(), help: help.clone() })
            }
            None if there(study, prepared, ready, plan) => {
                Fate::Done(Chunks::of(study.store, &prepared.jobs[ready.job], plan, ready.first_seed)?)
            }
            None => Fate::Skipped,
        });
    }
    Ok(fates)
}

/// Whether all chunks of a plan are in the store.
fn there(study: &Study<'_>, prepared: &Prepared<'_>, ready: &Ready, plan: Plan) -> bool {
    let identity = prepared.jobs[ready.job].identity();
    (0..plan.count).all(|at| study.store.has(&identity, plan.samples, ready.first_seed.saturating_add(at)))
}

/// The chunks of all runs, each once, in the order of the runs.
pub(super) fn tasks(prepared: &Prepared<'_>, wanted: &[u32]) -> Vec<(Task, Vec<usize>)> {
    let mut tasks: Vec<(Task, Vec<usize>)> = Vec::new();
    let mut known: BTreeMap<(usize, u32, u32), usize> = BTreeMap::new();
    for (at, (ready, count)) in prepared.runs.iter().zip(wanted).enumerate() {
        for chunk in 0..*count {
            let task =
                Task { job: ready.job, samples: ready.plan.samples, seed: ready.first_seed.saturating_add(chunk) };
            let place = *known.entry((task.job, task.samples, task.seed)).or_insert_with(|| {
                tasks.push((task, Vec::new()));
                tasks.len() - 1
            });
            tasks[place].1.push(at);
        }
    }
    tasks
}

/// Renders those that are not there; what fails is put to its runs.
fn round(
    study: &Study<'_>,
    prepared: &Prepared<'_>,
    tasks: &[(Task, Vec<usize>)],
    failed: &mut BTreeMap<usize, Failure>,
    watch: &mut (dyn Watch + Send),
) -> Result<(), Failure> {
    let identities: Vec<String> = prepared.jobs.iter().map(crate::job::Job::identity).collect();
    let open: Vec<&(Task, Vec<usize>)> = tasks
        .iter()
        .filter(|(task, runs)| {
            // A run that has failed has no further chunks.
            runs.iter().any(|run| !failed.contains_key(run))
                && !study.store.has(&identities[task.job], task.samples, task.seed)
        })
        .collect();
    if open.is_empty() {
        return Ok(());
    }
    let kept = tasks.len() - open.len();
    if kept > 0 {
        watch.note(&format!("{kept} of {} chunks are there from before", tasks.len()));
    }
    let list: Vec<Task> = open.iter().map(|(task, _)| *task).collect();
    let order = Order { jobs: &prepared.jobs, tasks: &list, store: study.store, keep_going: study.options.keep_going };
    watch.begin(list.len() as u64, "rendering");
    let shown = Mutex::new((watch, 0_u64));
    let news = |news: News<'_>| {
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let run = |at: usize| open[at].1.first().map(|run| study.evaluation.runs[*run]);
        match news {
            News::Begun(at) => {
                let label = run(at).map(|run: Run| study.label(run)).unwrap_or_default();
                shown.0.doing(&label);
            }
            News::Ended(..) => {
                shown.1 += 1;
                let done = shown.1;
                shown.0.set(done);
            }
            News::Note(text) => shown.0.note(&text),
        }
    };
    let outcomes = study.executor.run(&order, &news);
    let (watch, _) = shown.into_inner().unwrap_or_else(PoisonError::into_inner);
    watch.end();
    for (outcome, (_, runs)) in outcomes?.into_iter().zip(open) {
        let Outcome::Failed(Failure { exit, message, help }) = outcome else { continue };
        for run in runs {
            let one = Failure { exit, message: message.clone(), help: help.clone() };
            failed.entry(*run).or_insert(one);
        }
    }
    Ok(())
}

/// How many chunks a run is to have, which has `count` now: more where its budget is not used up.
fn with_budget(
    study: &Study<'_>,
    prepared: &Prepared<'_>,
    at: usize,
    count: u32,
    failed: &BTreeMap<usize, Failure>,
) -> Result<u32, Failure> {
    let ready = &prepared.runs[at];
    let budget = &study.evaluation.variant(study.evaluation.runs[at]).budget;
    if failed.contains_key(&at) || !ready.seeded || (budget.time.is_none() && budget.samples.is_none()) {
        return Ok(count);
    }
    let plan = Plan { count, ..ready.plan };
    if !there(study, prepared, ready, plan) {
        return Ok(count);
    }
    let most = budget.samples.map_or(u32::MAX, |samples| samples.value / plan.samples.max(1));
    let job = &prepared.jobs[ready.job];
    let renders = |count: u32| {
        let last = ready.first_seed.checked_add(count - 1);
        last.is_some_and(|seed| job.refuse(plan.samples, seed).is_ok())
    };
    let Some(time) = budget.time else { return Ok(up_to(count, most, renders)) };
    let chunks = Chunks::of(study.store, job, plan, ready.first_seed)?;
    let more = further(time.value, chunks.cost.seconds, count).ok_or_else(|| {
        Failure::new(Exit::Environment, "a renderer does not tell how long its chunks took".to_owned())
            .help("give a budget of samples")
    })?;
    Ok(up_to(count, count.saturating_add(more).min(most), renders))
}

/// The most chunks that a renderer has seeds for, of `least`, which it has, to `most`.
fn up_to(least: u32, most: u32, renders: impl Fn(u32) -> bool) -> u32 {
    if most <= least || renders(most) {
        return most.max(least);
    }
    let (mut good, mut bad) = (least, most);
    while bad - good > 1 {
        let middle = good + (bad - good) / 2;
        *(if renders(middle) { &mut good } else { &mut bad }) = middle;
    }
    good
}

/// How many chunks more fit into a time, where `count` of them took `seconds`.
fn further(time: Duration, seconds: f64, count: u32) -> Option<u32> {
    let each = seconds / f64::from(count.max(1));
    if each <= 0.0 || !each.is_finite() {
        return None;
    }
    let left = (time.as_secs_f64() - seconds) / each;
    Some(left.clamp(0.0, 4096.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_end_where_seeds_end() {
        let of = |least, most, seeds| up_to(least, most, |count| count <= seeds);
        assert_eq!(of(8, 100, 1000), 100);
        assert_eq!(of(8, 8, 8), 8);
        assert_eq!(of(8, 4, 1000), 8, "those that are there stay");
        for seeds in [8, 9, 50, 99] {
            assert_eq!(of(8, 100, seeds), seeds);
        }
    }

    #[test]
    fn a_budget_of_time_has_room_for_so_many_chunks_more() {
        let of = |time, seconds, count| further(Duration::from_secs(time), seconds, count);
        assert_eq!(of(60, 8.0, 8), Some(52));
        assert_eq!(of(60, 60.0, 8), Some(0));
        assert_eq!(of(60, 80.0, 8), Some(0));
        assert_eq!(of(1_000_000, 8e-3, 8), Some(4096));
        assert_eq!(of(60, 0.0, 8), None);
    }
}
