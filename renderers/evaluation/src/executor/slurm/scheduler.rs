//! What Slurm is told and asked: `sbatch`, `squeue`, `scancel`, and `sacct` where it answers.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_render::client::{Answer, ask};
use ltsc_render::env::Env;

use crate::failure::{Exit, Failure, why};

/// How long one of its programs may take to answer; they have shorter limits of their own.
const PATIENCE: Duration = Duration::from_secs(120);

/// Its programs.
#[derive(Clone, Debug)]
pub struct Scheduler {
    sbatch: PathBuf,
    squeue: PathBuf,
    scancel: PathBuf,
    sacct: Option<PathBuf>,
}

/// What Slurm says of an element of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It will run, or would but for the reason.
    Waiting(String),
    /// It runs.
    Running,
    /// It ended well.
    Done,
    /// It ended otherwise, of its own accord or for want of what it was given.
    Failed(String),
    /// It was ended from outside.
    Ended(String),
}

impl State {
    /// Whether it will still do something.
    pub fn is_active(&self) -> bool {
        matches!(self, Self::Waiting(_) | Self::Running)
    }

    fn of(word: &str, reason: &str) -> Self {
        match word {
            "PENDING" | "REQUEUED" | "REQUEUE_HOLD" | "REQUEUE_FED" | "SPECIAL_EXIT" | "RESV_DEL_HOLD" => {
                Self::Waiting(reason.to_owned())
            }
            "RUNNING" | "CONFIGURING" | "COMPLETING" | "STAGE_OUT" | "SIGNALING" | "SUSPENDED" | "STOPPED"
            | "RESIZING" => Self::Running,
            "COMPLETED" => Self::Done,
            "FAILED" | "TIMEOUT" | "DEADLINE" | "OUT_OF_MEMORY" | "BOOT_FAIL" | "LAUNCH_FAILED" => {
                Self::Failed(word.to_owned())
            }
            // CANCELLED, NODE_FAIL, PREEMPTED, REVOKED, and what newer versions may say.
            _ => Self::Ended(word.to_owned()),
        }
    }
}

/// An element of an array, as it is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// The number of the array, for people and for [`Scheduler::cancel_elements`].
    pub array: String,
    /// What it does.
    pub state: State,
}

/// All that is known of some arrays, by name and index.
pub type Elements = BTreeMap<(String, usize), Element>;

/// An array to submit.
pub struct Array<'a> {
    /// Its name, which no other one has.
    pub name: &'a str,
    /// Elements.
    pub count: usize,
    /// Of them at once.
    pub at_once: usize,
    /// Processors of each; Slurm's default if none.
    pub cpus: Option<usize>,
    /// Where it runs and its output goes.
    pub folder: &'a Path,
    /// Its script.
    pub script: &'a Path,
    /// What the user says to `sbatch`.
    pub options: &'a [String],
}

impl Scheduler {
    /// That of this machine.
    pub fn find(env: &Env) -> Result<Self, Failure> {
        let program = |name: &str| env.on_path(name).into_iter().next();
        let needed = |name: &str| {
            program(name).ok_or_else(|| {
                Failure::new(Exit::Environment, format!("Slurm is not here: there is no `{name}` on the path"))
                    .help("run ltsc on a machine from which jobs are submitted, or render on this one")
            })
        };
        Ok(Self {
            sbatch: needed("sbatch")?,
            squeue: needed("squeue")?,
            scancel: needed("scancel")?,
            sacct: program("sacct"),
        })
    }

    /// Submits an array, and gives its number.
    pub fn submit(&self, array: &Array<'_>) -> Result<String, Failure> {
        // What comes last counts, so the user's options change nothing that is relied on here.
        let mut words: Vec<OsString> = array.options.iter().map(OsString::from).collect();
        words.push("--parsable".into());
        words.push(format!("--job-name={}", array.name).into());
        words.push(format!("--array=0-{}%{}", array.count.saturating_sub(1), array.at_once.max(1)).into());
        words.extend(array.cpus.map(|cpus| OsString::from(format!("--cpus-per-task={cpus}"))));
        let mut folder = OsString::from("--chdir=");
        folder.push(array.folder);
        words.push(folder);
        // Below that folder: a `%` in its own path would mean something.
        words.push(format!("--output={}-%a.log", array.name).into());
        words.push(format!("--error={}-%a.log", array.name).into());
        words.push(array.script.into());
        let refused = |words: String| {
            // It may have been heard all the same.
            let _not_there = self.cancel(&[array.name.to_owned()]);
            Failure::new(Exit::Environment, format!("`sbatch` refuses the work: {words}"))
                .help("options such as `--partition=short` or `--account=NAME` are passed on to it")
        };
        let answer = ask(&self.sbatch, &words, PATIENCE).map_err(|error| refused(why(&error)))?;
        // With a name of the cluster behind it, where there are several.
        let id = answer.out.lines().last().and_then(|line| line.split(';').next()).unwrap_or_default().trim();
        let known = answer.ok && !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit());
        if known { Ok(id.to_owned()) } else { Err(refused(answer.words())) }
    }

    /// What is known of arrays of these names.
    pub fn elements(&self, names: &[String]) -> io::Result<Elements> {
        let names = format!("--name={}", names.join(","));
        let words = ["--noheader", "--array", "--states=all", &names, "--format=%j/%F/%K/%T/%r"];
        let answer = ask(&self.squeue, &words, PATIENCE)?;
        if answer.ok { Ok(elements(&answer.out)) } else { Err(io::Error::other(answer.words())) }
    }

    /// How an element ended of which `squeue` knows nothing any more.
    pub fn accounted(&self, array: &str, index: usize) -> Option<State> {
        let element = format!("--jobs={array}_{index}");
        let words = ["--noheader", "--parsable2", "--allocations", "--format=State", &element];
        let answer = ask(self.sacct.as_ref()?, &words, PATIENCE).ok().filter(|answer| answer.ok)?;
        // `CANCELLED by 1000`.
        let word = answer.out.lines().last()?.split_whitespace().next()?.to_owned();
        Some(State::of(&word, "")).filter(|state| !state.is_active())
    }

    /// Ends arrays by their names, also those that have just been submitted.
    pub fn cancel(&self, names: &[String]) -> io::Result<()> {
        names.iter().try_for_each(|name| heard(ask(&self.scancel, &[format!("--name={name}")], PATIENCE)?))
    }

    /// Ends some elements of arrays.
    pub fn cancel_elements(&self, elements: &[String]) -> io::Result<()> {
        if elements.is_empty() { Ok(()) } else { heard(ask(&self.scancel, elements, PATIENCE)?) }
    }
}

fn heard(answer: Answer) -> io::Result<()> {
    if answer.ok { Ok(()) } else { Err(io::Error::other(answer.words())) }
}

fn elements(text: &str) -> Elements {
    let element = |line: &str| {
        let mut parts = line.trim().splitn(5, '/');
        let (name, array, index) = (parts.next()?.to_owned(), parts.next()?.to_owned(), parts.next()?);
        let (state, reason) = (parts.next()?, parts.next().unwrap_or_default());
        // What is left of an array that was canceled has no index.
        Some(((name, index.parse().ok()?), Element { array, state: State::of(state, reason) }))
    };
    text.lines().filter_map(element).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As Slurm 22.05 writes it.
    #[test]
    fn states_of_elements_are_understood() {
        let text = "ltsc-x/5/N/A/CANCELLED/JobArrayTaskLimit\nltsc-x/5/2/COMPLETING/None\nltsc-x/5/0/CANCELLED/None\n\
                    ltsc-x/5/1/FAILED/JobLaunchFailure\nltsc-y/6/1/PENDING/launch failed requeued held\n\
                    ltsc-y/6/2/COMPLETED/None\nltsc-y/6/3/PREEMPTED/None\n";
        let found = elements(text);
        let state = |name: &str, index| found.get(&(name.to_owned(), index)).map(|element| element.state.clone());
        assert_eq!(found.len(), 6);
        assert_eq!(state("ltsc-x", 0), Some(State::Ended("CANCELLED".to_owned())));
        assert_eq!(state("ltsc-x", 1), Some(State::Failed("FAILED".to_owned())));
        assert_eq!(state("ltsc-x", 2), Some(State::Running));
        assert_eq!(state("ltsc-y", 1), Some(State::Waiting("launch failed requeued held".to_owned())));
        assert_eq!(state("ltsc-y", 2), Some(State::Done));
        assert_eq!(state("ltsc-y", 3), Some(State::Ended("PREEMPTED".to_owned())));
    }
}
