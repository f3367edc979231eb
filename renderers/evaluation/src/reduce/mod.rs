//! A scene on which two renderers differ, made as small as it can be while they still do: for a report of the fault.
//!
//! Shapes, instances and lights are taken out in halves, then in smaller parts, down to one by one (delta debugging, Zeller and Hildebrandt
//! 2002); what is left is made of plainer materials, and of shorter paths. After each step both renderers render what is left, and
//! the verdict decides. Chunks are kept, so that a run that is ended goes on where it was.

mod scene;
mod write;

use ltsc_core::ir::Scene;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;

use crate::chunk::{self, Chunks, Plan, Store};
use crate::compare::verdict::{Outcome, Rendered, Stated, Tolerance, Verdict, judge_in, judge_stated};
use crate::failure::{Exit, Failure};
use crate::job::{Job, Runner, lacks, stated};
use crate::watch::{Unwatched, Watch};

pub use write::{check, write};

/// What is asked.
pub struct Question<'a> {
    /// The reference.
    pub a: &'a Runner,
    /// The renderer that is held against it.
    pub b: &'a Runner,
    /// Samples per pixel of an image.
    pub samples: u32,
    /// Within what the two are to agree.
    pub tolerance: Tolerance,
    /// Tiles along each side of an image.
    pub tiles: usize,
    /// Where chunks are kept.
    pub store: &'a Store,
}

/// A scene in both renderers.
pub struct Shown<'a> {
    /// The scene.
    pub scene: Valid,
    /// What it became for each renderer.
    pub jobs: [Job<'a>; 2],
    /// Its images.
    pub chunks: [Chunks; 2],
    /// What the targets state of it.
    pub stated: Vec<Stated>,
    /// What is proved.
    pub verdict: Verdict,
}

/// A scene that was made smaller.
pub struct Reduced<'a> {
    /// What is left.
    pub shown: Shown<'a>,
    /// What was done, in words.
    pub steps: Vec<String>,
    /// Surfaces, instances and lights before and after.
    pub things: (usize, usize),
    /// Scenes that were rendered.
    pub tried: usize,
}

impl<'a> Question<'a> {
    /// The verdict on a scene; none where it cannot be rendered, or has no light.
    fn ask(&self, scene: Scene, watch: &mut dyn Watch) -> Result<Option<Shown<'a>>, Failure> {
        let Ok((mut scene, _)) = pipeline::prepare(scene) else { return Ok(None) };
        let plans = [self.a, self.b].map(|runner| Plan::for_driver(runner.driver, u64::from(self.samples)));
        let mut made = Vec::new();
        for (runner, plan) in [self.a, self.b].into_iter().zip(plans) {
            if lacks(runner.driver, &scene) {
                let message = format!("{} has no `{}`", runner.driver.name, scene.integrator.word());
                return Err(
                    Failure::new(Exit::Usage, message).help("write another integrator, or name another renderer")
                );
            }
            scene.set_sampling(plan.samples, 0);
            let job = Job::new(&scene, runner)?;
            let chunks = chunk::render(self.store, &job, plan, 0, &mut Unwatched)?;
            watch.doing(&format!("{} ({})", scene.name, runner.driver.name));
            made.push((job, chunks));
        }
        let mut stated: Vec<Stated> = stated(&scene, self.a.driver);
        if self.a.driver.name != self.b.driver.name {
            stated.extend(crate::job::stated(&scene, self.b.driver));
        } else {
            stated.clear();
        }
        let more = stated.iter().map(|one| one.share).sum();
        let Ok([(job_a, a), (job_b, b)]) = <[_; 2]>::try_from(made) else { return Ok(None) };
        let side = |chunks: &Chunks| f64::from(chunks.samples);
        let judged = judge_stated(
            |within| {
                let one = Rendered { images: a.images(), samples: side(&a) };
                let other = Rendered { images: b.images(), samples: side(&b) };
                judge_in(one, other, within, self.tiles)
            },
            self.tolerance,
            more,
        );
        // Without light there is nothing to compare.
        let Ok((verdict, _)) = judged else { return Ok(None) };
        Ok(Some(Shown { scene, jobs: [job_a, job_b], chunks: [a, b], stated, verdict }))
    }

    /// Makes a scene smaller as long as its two images differ.
    ///
    /// # Errors
    /// If they do not differ, or a renderer fails.
    pub fn reduce(&self, scene: Scene, watch: &mut dyn Watch) -> Result<Reduced<'a>, Failure> {
        let before = scene::things(&scene).len();
        let mut tried = 1;
        let first = self.ask(scene.clone(), watch)?;
        let Some(mut shown) = first.filter(|shown| shown.verdict.outcome == Outcome::Differ) else {
            let message =
                format!("{} and {} do not differ on `{}`", self.a.driver.name, self.b.driver.name, scene.name);
            return Err(Failure::new(Exit::No, message)
                .help("more `--samples` may show a difference, and a smaller `--tolerance` finds a smaller one"));
        };
        let mut current = scene;
        let mut steps = Vec::new();
        self.remove(&mut current, &mut shown, &mut tried, watch)?;
        let after = scene::things(&current).len();
        if after < before {
            steps.push(format!("{} of {before} surfaces, instances and lights were taken out", before - after));
        }
        for plainer in scene::plainer(&current) {
            tried += 1;
            if let Some(next) = self.differs((plainer.make)(&current), watch)? {
                current = (plainer.make)(&current);
                shown = next;
                steps.push(plainer.what);
            }
        }
        for depth in 1..current.integrator.max_depth() {
            let mut shorter = current.clone();
            shorter.integrator = shorter.integrator.with_max_depth(depth);
            tried += 1;
            if let Some(next) = self.differs(shorter, watch)? {
                steps.push(format!("paths have {depth} segments instead of {}", current.integrator.max_depth()));
                shown = next;
                break;
            }
        }
        Ok(Reduced { shown, steps, things: (before, after), tried })
    }

    fn differs(&self, scene: Scene, watch: &mut dyn Watch) -> Result<Option<Shown<'a>>, Failure> {
        Ok(self.ask(scene, watch)?.filter(|shown| shown.verdict.outcome == Outcome::Differ))
    }

    /// Takes out what can be taken out, in ever smaller parts.
    fn remove(
        &self,
        current: &mut Scene,
        shown: &mut Shown<'a>,
        tried: &mut usize,
        watch: &mut dyn Watch,
    ) -> Result<(), Failure> {
        let mut part = scene::things(current).len().div_ceil(2);
        while part > 0 {
            let mut at = 0;
            let mut smaller = false;
            while at < scene::things(current).len() {
                let count = scene::things(current).len();
                let without = scene::without(current, at..(at + part).min(count));
                *tried += 1;
                match self.differs(without.clone(), watch)? {
                    Some(next) => {
                        (*current, *shown) = (without, next);
                        smaller = true;
                        watch.note(&format!("{} of {count} things are left", scene::things(current).len()));
                    }
                    None => at += part,
                }
            }
            part = if smaller { part.min(scene::things(current).len().div_ceil(2)) } else { part / 2 };
        }
        Ok(())
    }
}
