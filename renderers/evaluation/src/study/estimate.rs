//! What an evaluation would do: chunks that are there, chunks to render, and how long that takes.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::chunk::{Chunks, Plan, Store};
use crate::file::Evaluation;

use super::prepare::Prepared;
use super::work::tasks;

/// What would be done.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// In the order of the evaluation.
    pub runs: Vec<Planned>,
    /// Different chunks in all.
    pub chunks: usize,
    /// Those that are there.
    pub kept: usize,
    /// Seconds of rendering for the rest, one after the other, as far as they are known.
    pub seconds: f64,
    /// Chunks of which nothing like them was rendered before, so that their time is not known.
    pub unknown: usize,
}

/// An image that would be rendered.
#[derive(Clone, Debug, Serialize)]
pub struct Planned {
    /// The condition.
    pub condition: String,
    /// The case, with its renderer where it has several.
    pub label: String,
    /// The renderer and its version.
    pub renderer: String,
    /// Width and height.
    pub size: (usize, usize),
    /// Samples per pixel of a chunk.
    pub samples: u32,
    /// Chunks.
    pub chunks: u32,
    /// Those that are there.
    pub kept: u32,
}

impl Estimate {
    /// Of an evaluation that is ready; nothing is rendered.
    #[must_use]
    pub fn of(evaluation: &Evaluation, prepared: &Prepared<'_>, store: &Store) -> Self {
        let wanted = super::work::wanted(prepared);
        let identities: Vec<String> = prepared.jobs.iter().map(crate::job::Job::identity).collect();
        let has = |job: usize, samples: u32, seed: u32| store.has(&identities[job], samples, seed);
        let tasks = tasks(prepared, &wanted);
        let open: Vec<_> = tasks.iter().filter(|(task, _)| !has(task.job, task.samples, task.seed)).collect();
        // Seconds for a pixel and a sample, by job, and by renderer where nothing of the job is there.
        let mut of_job: BTreeMap<usize, f64> = BTreeMap::new();
        let mut of_renderer: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        let runs = prepared.runs.iter().zip(&evaluation.runs).map(|(ready, run)| {
            let job = &prepared.jobs[ready.job];
            let seeds = (0..ready.plan.count).map(|at| ready.first_seed.saturating_add(at));
            let there: Vec<u32> = seeds.filter(|seed| has(ready.job, ready.plan.samples, *seed)).collect();
            if let Some(first) = there.first()
                && let Ok(chunk) = Chunks::of(store, job, Plan { samples: ready.plan.samples, count: 1 }, *first)
            {
                let work = job.size().0 as f64 * job.size().1 as f64 * f64::from(ready.plan.samples);
                of_job.insert(ready.job, chunk.cost.seconds / work);
                of_renderer.entry(job.runner().driver.name).or_default().push(chunk.cost.seconds / work);
            }
            Planned {
                condition: evaluation.conditions[run.condition].name.clone(),
                label: evaluation.label(*run),
                renderer: format!("{} {}", job.runner().driver.name, job.runner().found.version).trim().to_owned(),
                size: job.size(),
                samples: ready.plan.samples,
                chunks: ready.plan.count,
                kept: there.len() as u32,
            }
        });
        let runs: Vec<Planned> = runs.collect();
        let (mut seconds, mut unknown) = (0.0, 0);
        for (task, _) in &open {
            let job = &prepared.jobs[task.job];
            let work = job.size().0 as f64 * job.size().1 as f64 * f64::from(task.samples);
            let mean = |all: &Vec<f64>| all.iter().sum::<f64>() / all.len() as f64;
            let like = of_job.get(&task.job).copied().or_else(|| of_renderer.get(job.runner().driver.name).map(mean));
            match like {
                Some(each) => seconds += each * work,
                None => unknown += 1,
            }
        }
        Self { runs, chunks: tasks.len(), kept: tasks.len() - open.len(), seconds, unknown }
    }
}
