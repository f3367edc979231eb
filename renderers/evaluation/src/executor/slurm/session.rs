//! One order on a cluster: what is submitted, seen to be done, lost, submitted again, and given up.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use ltsc_render::guard::{self, Held};
use ltsc_render::run::tail;

use super::scheduler::{Array, Element, Elements, Scheduler, State};
use super::shared::{Run, Shared, log_of};
use super::task::{List, Listed, failure_of};
use super::{SILENCE, Slurm};
use crate::disk::unwritable;
use crate::executor::{News, Order, Outcome, Task};
use crate::failure::{Exit, Failure, why};

/// How often a chunk is submitted.
const TRIES: usize = 3;

/// The most elements of an array: what Slurm takes unless it is told otherwise (`MaxArraySize`).
const MOST: usize = 1000;

/// Lines of a log that are shown.
const LINES: usize = 20;

/// Why tasks wait where all is well.
const USUAL: &[&str] = &["", "None", "Priority", "Resources", "JobArrayTaskLimit", "BeginTime", "Cleaning", "Prolog"];

/// What is to be undone where a signal ends the process.
#[derive(Default)]
struct Undo {
    arrays: Vec<String>,
    runs: Vec<PathBuf>,
    /// Nothing is submitted from here on.
    ended: bool,
}

/// Where a chunk is.
enum Phase {
    /// It is to be submitted.
    Waiting,
    /// It is an element of an array.
    Submitted {
        array: usize,
        index: usize,
        begun: bool,
        /// Since when Slurm says that it is done, though it is not in the store.
        done: Option<Instant>,
    },
    Ended(Outcome),
}

struct Chunk {
    phase: Phase,
    tries: usize,
}

/// An array.
struct Submitted {
    name: String,
    /// As Slurm counts it.
    number: String,
    list: PathBuf,
}

pub struct Session<'a> {
    slurm: &'a Slurm,
    order: &'a Order<'a>,
    news: &'a (dyn Fn(News<'_>) + Sync),
    identities: Vec<String>,
    chunks: Vec<Chunk>,
    arrays: Vec<Submitted>,
    /// The first one is of this session.
    own: Option<Run>,
    taken: Vec<Run>,
    /// Chunks of each job that were rendered, and tasks of it that failed of their own accord.
    made: Vec<usize>,
    failed: Vec<usize>,
    /// Whether something may still run that nobody waits for.
    unwanted: bool,
    said: BTreeSet<String>,
    /// Since when no more is taken, after something was.
    refused: Option<Instant>,
    undo: Arc<Mutex<Undo>>,
    _held: Held,
}

impl<'a> Session<'a> {
    pub fn new(slurm: &'a Slurm, order: &'a Order<'a>, news: &'a (dyn Fn(News<'_>) + Sync)) -> Result<Self, Failure> {
        let undo = Arc::new(Mutex::new(Undo::default()));
        let (scheduler, shared, state) = (slurm.scheduler.clone(), slurm.shared.clone(), Arc::clone(&undo));
        let ((), held) = guard::hold(|| Ok(()), |()| move || put_back(&scheduler, &shared, &state))
            .map_err(|error| unwritable(slurm.shared.root(), &error))?;
        Ok(Self {
            slurm,
            order,
            news,
            identities: order.jobs.iter().map(crate::job::Job::identity).collect(),
            chunks: order.tasks.iter().map(|_| Chunk { phase: Phase::Waiting, tries: 0 }).collect(),
            arrays: Vec::new(),
            own: None,
            taken: Vec::new(),
            made: vec![0; order.jobs.len()],
            failed: vec![0; order.jobs.len()],
            unwanted: false,
            said: BTreeSet::new(),
            refused: None,
            undo,
            _held: held,
        })
    }

    /// Renders all that is not there.
    pub fn run(mut self) -> Result<Vec<Outcome>, Failure> {
        for at in 0..self.chunks.len() {
            if self.is_there(at) {
                self.begin(at);
                self.end(at, Outcome::Kept);
            }
        }
        self.take_over()?;
        let start = Instant::now();
        let (first, last) = self.slurm.pauses;
        loop {
            guard::stop_if_ending();
            match self.submit() {
                Ok(()) => self.refused = None,
                Err(failure) if self.arrays.is_empty() => return Err(failure),
                // What was taken before may be taken later.
                Err(failure) => {
                    if self.refused.is_none() {
                        self.note(format!("{}: tried again", failure.message));
                    }
                    if self.refused.get_or_insert_with(Instant::now).elapsed() > SILENCE {
                        return Err(failure);
                    }
                }
            }
            if self.chunks.iter().all(|chunk| matches!(chunk.phase, Phase::Ended(_))) {
                break;
            }
            std::thread::sleep((start.elapsed() / 20).clamp(first, last));
            self.look()?;
        }
        let chunks = std::mem::take(&mut self.chunks);
        Ok(chunks
            .into_iter()
            .map(|chunk| if let Phase::Ended(outcome) = chunk.phase { outcome } else { Outcome::Skipped })
            .collect())
    }

    fn task(&self, at: usize) -> Task {
        self.order.tasks[at]
    }

    fn is_there(&self, at: usize) -> bool {
        let Task { job, samples, seed } = self.task(at);
        self.order.store.has(&self.identities[job], samples, seed)
    }

    fn note(&self, text: String) {
        (self.news)(News::Note(text));
    }

    fn unwritable(&self, error: &io::Error) -> Failure {
        unwritable(self.slurm.shared.root(), error)
    }

    fn begin(&mut self, at: usize) {
        if let Phase::Submitted { begun, .. } = &mut self.chunks[at].phase {
            if *begun {
                return;
            }
            *begun = true;
        }
        (self.news)(News::Begun(at));
    }

    fn end(&mut self, at: usize, outcome: Outcome) {
        (self.news)(News::Ended(at, &outcome));
        self.chunks[at].phase = Phase::Ended(outcome);
    }

    /// Submits what waits for it.
    fn submit(&mut self) -> Result<(), Failure> {
        let waits = |at: &usize| matches!(self.chunks[*at].phase, Phase::Waiting);
        let mut ready: Vec<usize> = (0..self.chunks.len()).filter(waits).collect();
        let active = self.chunks.iter().filter(|chunk| matches!(chunk.phase, Phase::Submitted { .. })).count();
        let Some((count, at_once)) = size(ready.len(), active, self.slurm.at_once) else { return Ok(()) };
        ready.truncate(count);
        if self.own.is_none() {
            let run = self.slurm.shared.begin(&self.slurm.program).map_err(|error| self.unwritable(&error))?;
            lock(&self.undo).runs.push(run.folder.clone());
            self.own = Some(run);
        }
        let Some(run) = &self.own else { return Ok(()) };
        let used: BTreeSet<usize> = ready.iter().map(|at| self.task(*at).job).collect();
        let jobs: Vec<_> = used.iter().map(|job| &self.order.jobs[*job]).collect();
        let place = |job: usize| used.iter().take_while(|used| **used < job).count();
        let list = List {
            store: self.store(),
            jobs: jobs.iter().map(|job| Listed::of(job, self.slurm.shared.job(&job.identity()))).collect(),
            tasks: ready.iter().map(|at| self.task(*at)).map(|task| Task { job: place(task.job), ..task }).collect(),
        };
        let name = format!("{}-{}", run.name, self.arrays.len());
        let path = run.list(&name);
        self.slurm.shared.put(&list, &path, &jobs)?;
        let array = Array {
            name: &name,
            count: ready.len(),
            at_once,
            cpus: jobs.iter().filter_map(|job| job.runner().threads).max(),
            folder: &run.folder,
            script: &run.script(),
            options: &self.slurm.options,
        };
        let number = {
            // A signal waits for the answer, so that it cancels what was accepted.
            let mut undo = lock(&self.undo);
            if undo.ended {
                drop(undo);
                guard::stop_if_ending();
                return Ok(());
            }
            undo.arrays.push(name.clone());
            self.slurm.scheduler.submit(&array)?
        };
        self.note(format!("Slurm has array {number}: chunks {}, at most {at_once} at once", ready.len()));
        for (index, at) in ready.into_iter().enumerate() {
            self.chunks[at].tries += 1;
            self.chunks[at].phase = Phase::Submitted { array: self.arrays.len(), index, begun: false, done: None };
        }
        self.arrays.push(Submitted { name, number, list: path });
        Ok(())
    }

    fn store(&self) -> PathBuf {
        let root = self.order.store.root();
        std::path::absolute(root).unwrap_or_else(|_| root.to_owned())
    }

    /// What Slurm knows of arrays; it may be silent for a while.
    fn elements(&self, names: &[String]) -> Result<Elements, Failure> {
        let start = Instant::now();
        let mut said = false;
        loop {
            guard::stop_if_ending();
            match self.slurm.scheduler.elements(names) {
                Ok(elements) => return Ok(elements),
                Err(error) if start.elapsed() > SILENCE => {
                    let message = format!("Slurm gives no answer: {}", why(&error));
                    return Err(Failure::new(Exit::Environment, message)
                        .help("start again later: chunks that are rendered by then are kept"));
                }
                Err(error) if !said => self.note(format!("Slurm gives no answer, and is asked again: {}", why(&error))),
                Err(_) => {}
            }
            said = true;
            std::thread::sleep(self.slurm.pauses.1);
        }
    }

    /// Sees what has become of all chunks.
    fn look(&mut self) -> Result<(), Failure> {
        let names: Vec<String> = self.arrays.iter().map(|array| array.name.clone()).collect();
        // Before the store: what is done by now has put its chunk there.
        let elements = self.elements(&names)?;
        for at in 0..self.chunks.len() {
            if matches!(self.chunks[at].phase, Phase::Ended(_)) {
                continue;
            }
            if self.is_there(at) {
                self.begin(at);
                let job = self.task(at).job;
                self.made[job] += 1;
                self.end(at, Outcome::Made);
                continue;
            }
            let Phase::Submitted { array, index, done, .. } = &mut self.chunks[at].phase else { continue };
            let (array, index) = (*array, *index);
            let element = elements.get(&(self.arrays[array].name.clone(), index));
            match element.map(|element| element.state.clone()) {
                Some(State::Waiting(reason)) => self.explain(&reason),
                Some(State::Running) => self.begin(at),
                Some(State::Done) if done.get_or_insert_with(Instant::now).elapsed() < self.slurm.grace => {}
                state => self.lose(at, (array, index), state),
            }
        }
        Ok(())
    }

    /// Says once why tasks wait, where it is not the usual reason.
    fn explain(&mut self, reason: &str) {
        if !USUAL.contains(&reason) && self.said.insert(reason.to_owned()) {
            self.note(format!("Slurm lets tasks wait: {reason}"));
        }
    }

    /// A task ended, and its chunk is not there.
    fn lose(&mut self, at: usize, (array, index): (usize, usize), state: Option<State>) {
        let Submitted { number, list, .. } = &self.arrays[array];
        let state = state.or_else(|| self.slurm.scheduler.accounted(number, index));
        let list = list.clone();
        let said = failure_of(&list, index);
        let own = said.is_some() || matches!(state, Some(State::Failed(_) | State::Done));
        let what = match &state {
            Some(State::Failed(word) | State::Ended(word)) => format!("Slurm says {word}"),
            Some(_) => "it ended without a chunk".to_owned(),
            None => "Slurm does not know it any more".to_owned(),
        };
        let Task { job, seed, .. } = self.task(at);
        let name =
            format!("{} by {}, seed {seed}", self.order.jobs[job].scene(), self.order.jobs[job].runner().driver.name);
        let failure = said.unwrap_or_else(|| {
            let mut message = format!("the task of {name} was lost: {what}");
            let lines = tail(&log_of(&list, index), LINES);
            if !lines.is_empty() {
                message.push_str("\nthe end of its log:");
            }
            lines.iter().for_each(|line| message.push_str(&format!("\n    {line}")));
            let failure = Failure::new(Exit::Environment, message);
            match state {
                Some(State::Failed(word)) if word == "TIMEOUT" => {
                    failure.help("give it more time, as by `--time=2:00:00`")
                }
                Some(State::Failed(word)) if word == "OUT_OF_MEMORY" => {
                    failure.help("give it more memory, as by `--mem=8G`")
                }
                _ if lines.is_empty() => failure.help(format!(
                    "it has no log: is {} the same folder on all machines?",
                    self.slurm.shared.root().display()
                )),
                _ => failure,
            }
        });
        self.failed[job] += usize::from(own);
        // A renderer that gives nothing but failures is not asked for each chunk.
        let hopeless = self.failed[job] >= TRIES && self.made[job] == 0;
        if self.chunks[at].tries < TRIES && !hopeless {
            self.note(format!("a chunk is submitted again: {name} ({what})"));
            self.chunks[at].phase = Phase::Waiting;
            return;
        }
        self.end(at, Outcome::Failed(failure));
        if !self.order.keep_going {
            self.give_up(|_| true);
        } else if hopeless {
            self.give_up(|other| other.job == job);
        }
    }

    /// Skips what is not there.
    fn give_up(&mut self, which: impl Fn(Task) -> bool) {
        let mut elements = Vec::new();
        for at in (0..self.chunks.len()).filter(|at| which(self.order.tasks[*at])) {
            match self.chunks[at].phase {
                Phase::Ended(_) => continue,
                Phase::Submitted { array, index, .. } => elements.push((array, index)),
                Phase::Waiting => {}
            }
            self.chunks[at].phase = Phase::Ended(Outcome::Skipped);
        }
        self.unwanted |= !elements.is_empty();
        let number = |(array, index): &(usize, usize)| format!("{}_{index}", self.arrays[*array].number);
        let numbers: Vec<String> = elements.iter().map(number).collect();
        self.cancelled(self.slurm.scheduler.cancel_elements(&numbers));
    }

    fn cancelled(&self, done: io::Result<()>) {
        if let Err(error) = done {
            self.note(format!("`scancel` fails: {}", why(&error)));
        }
    }

    /// Waits for what killed runs have submitted as far as it is wanted here, and cancels the rest of it.
    fn take_over(&mut self) -> Result<(), Failure> {
        let wanted: BTreeMap<(String, u32, u32), usize> = (0..self.chunks.len())
            .filter(|at| matches!(self.chunks[*at].phase, Phase::Waiting))
            .map(|at| (self.task(at), at))
            .map(|(Task { job, samples, seed }, at)| ((self.identities[job].clone(), samples, seed), at))
            .collect();
        for run in self.slurm.shared.left_over().map_err(|error| self.unwritable(&error))? {
            let names = run.arrays().map_err(|error| self.unwritable(&error))?;
            let elements = if names.is_empty() { Elements::new() } else { self.elements(&names)? };
            let (mut taken, mut others) = (0, Vec::new());
            for name in &names {
                let list = List::read(&run.list(name)).ok().filter(|list| list.store == self.store());
                let active = elements.iter().filter(|((other, _), element)| other == name && element.state.is_active());
                let mut number = None;
                for ((_, index), Element { array, .. }) in active {
                    number = Some(array.clone());
                    let key = list.as_ref().and_then(|list| list.key(*index));
                    let at =
                        key.and_then(|(identity, samples, seed)| wanted.get(&(identity.to_owned(), samples, seed)));
                    match at.filter(|at| matches!(self.chunks[**at].phase, Phase::Waiting)) {
                        Some(at) => {
                            let (array, index) = (self.arrays.len(), *index);
                            self.chunks[*at] =
                                Chunk { phase: Phase::Submitted { array, index, begun: false, done: None }, tries: 1 };
                            taken += 1;
                        }
                        None => others.push(format!("{array}_{index}")),
                    }
                }
                let list = run.list(name);
                self.arrays.extend(number.map(|number| Submitted { name: name.clone(), number, list }));
            }
            if taken == 0 {
                self.cancelled(self.slurm.scheduler.cancel(&names));
                self.slurm.shared.end(&run.folder).map_err(|error| self.unwritable(&error))?;
                continue;
            }
            self.note(format!(
                "Slurm still has tasks of a run that was killed: taken over {taken}, canceled {}",
                others.len()
            ));
            self.cancelled(self.slurm.scheduler.cancel_elements(&others));
            let mut undo = lock(&self.undo);
            undo.arrays.extend(names);
            undo.runs.push(run.folder.clone());
            drop(undo);
            self.taken.push(run);
        }
        Ok(())
    }
}

impl Drop for Session<'_> {
    /// Leaves nothing that runs, and nothing in the shared folder but chunks.
    fn drop(&mut self) {
        let waits = self.chunks.iter().any(|chunk| matches!(chunk.phase, Phase::Submitted { .. }));
        if waits || self.unwanted {
            let names: Vec<String> = self.arrays.iter().map(|array| array.name.clone()).collect();
            self.cancelled(self.slurm.scheduler.cancel(&names));
        }
        for run in self.taken.iter().chain(&self.own) {
            if let Err(error) = self.slurm.shared.end(&run.folder) {
                self.note(format!("{} stays: {}", run.folder.display(), why(&error)));
            }
        }
    }
}

/// How many elements the next array has, and how many of them may run at once: all that is ready where nothing else is there, and later
/// what fills the places that have become free.
fn size(ready: usize, active: usize, at_once: usize) -> Option<(usize, usize)> {
    let free = at_once.saturating_sub(active);
    let count = ready.min(if active == 0 { MOST } else { free });
    (count > 0).then_some((count, free))
}

fn lock(undo: &Mutex<Undo>) -> MutexGuard<'_, Undo> {
    undo.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a session does when it is dropped, where a signal ends the process first.
fn put_back(scheduler: &Scheduler, shared: &Shared, undo: &Mutex<Undo>) {
    let mut undo = lock(undo);
    undo.ended = true;
    let _the_next_run_does_it = scheduler.cancel(&undo.arrays);
    for run in &undo.runs {
        let _the_next_run_does_it = shared.remove(run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_run_at_once_than_may() {
        assert_eq!(size(3, 0, 8), Some((3, 8)));
        assert_eq!(size(1500, 0, 8), Some((1000, 8)));
        // An array that may run one at a time gets one element, since that stays so when other places become free.
        assert_eq!(size(500, 7, 8), Some((1, 1)));
        assert_eq!(size(2, 3, 8), Some((2, 5)));
        assert_eq!(size(500, 9, 8), None);
        assert_eq!(size(0, 0, 8), None);
    }
}
