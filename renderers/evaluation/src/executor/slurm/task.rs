//! What an array is to render, as a file in the shared folder, and one element of it on its node.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_render::regular;
use ltsc_render::run::without_driver;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::chunk::Store;
use crate::command::Command;
use crate::disk::{unwritable, write_whole};
use crate::executor::Task;
use crate::failure::{Exit, Failure, why};
use crate::job::{Job, Runner, driver_called};

/// More than the largest list.
const LARGEST: u64 = 1 << 28;

/// What the elements of an array render.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct List {
    /// The root of the store.
    pub store: PathBuf,
    /// Scenes as they were written for renderers.
    pub jobs: Vec<Listed>,
    /// A chunk for each element: samples and seed, and the index of its job.
    pub tasks: Vec<Task>,
}

/// A job in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Listed {
    /// See [`Job::identity`].
    pub identity: String,
    /// Where the files for the renderer are.
    pub folder: PathBuf,
    /// The scene's name.
    pub scene: String,
    /// Width and height of the image.
    pub size: (usize, usize),
    /// The renderer.
    pub driver: String,
    /// Its program.
    pub executable: PathBuf,
    /// Its version.
    pub version: String,
    /// As many as Slurm gives if none.
    pub threads: Option<usize>,
    /// Seconds for one chunk.
    pub timeout: Option<f64>,
    /// Further arguments of the program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub options: Vec<String>,
    /// The words of its command, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
}

impl Listed {
    /// A job whose files are in `folder`.
    pub fn of(job: &Job<'_>, folder: PathBuf) -> Self {
        let Runner { driver, found, threads, timeout, options, command, .. } = job.runner();
        Self {
            identity: job.identity(),
            folder,
            scene: job.scene().to_owned(),
            size: job.size(),
            driver: driver.name.to_owned(),
            executable: std::path::absolute(&found.path).unwrap_or_else(|_| found.path.clone()),
            version: found.version.clone(),
            threads: *threads,
            timeout: timeout.map(|timeout| timeout.as_secs_f64()),
            options: options.clone(),
            command: command.as_ref().map(Command::texts),
        }
    }
}

impl List {
    /// Reads one.
    pub fn read(path: &Path) -> io::Result<Self> {
        read(path)
    }

    /// Writes it.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        write(self, path)
    }

    /// What tells a chunk from all others.
    pub fn key(&self, index: usize) -> Option<(&str, u32, u32)> {
        let task = self.tasks.get(index)?;
        Some((&self.jobs.get(task.job)?.identity, task.samples, task.seed))
    }
}

/// How an element failed, beside its list.
#[derive(Debug, Serialize, Deserialize)]
struct Mark {
    exit: u8,
    message: String,
    help: Option<String>,
}

/// Where an element says that it has failed.
fn mark_of(list: &Path, index: usize) -> PathBuf {
    let stem = list.file_stem().unwrap_or_default().to_string_lossy();
    list.with_file_name(format!("{stem}-{index}.failed"))
}

/// What an element says of its failure; nothing if it ended otherwise.
pub fn failure_of(list: &Path, index: usize) -> Option<Failure> {
    let Mark { exit, message, help } = read(&mark_of(list, index)).ok()?;
    let known = [Exit::No, Exit::Usage, Exit::Input, Exit::Environment];
    let exit = known.into_iter().find(|known| known.code() == exit).unwrap_or(Exit::Fault);
    Some(Failure { exit, message, help })
}

/// Renders the chunk of one element, and says in a line what became of it. A failure is also written down beside the list.
///
/// # Errors
/// Where the list cannot be read, the files of the scene are not those that were written, or the renderer fails.
pub fn perform(path: &Path, index: usize) -> Result<String, Failure> {
    let list = List::read(path).map_err(|error| {
        Failure::new(Exit::Input, format!("{}: {}", path.display(), why(&error)))
            .help("a list is there as long as the ltsc that waits for it")
    })?;
    let done = element(&list, index);
    if let Err(Failure { exit, message, help }) = &done {
        let mark = Mark { exit: exit.code(), message: message.clone(), help: help.clone() };
        let place = mark_of(path, index);
        write(&mark, &place).map_err(|error| unwritable(&place, &error))?;
    }
    done
}

fn element(list: &List, index: usize) -> Result<String, Failure> {
    let found = list.tasks.get(index).and_then(|task| Some((task, list.jobs.get(task.job)?)));
    let (task, listed) = found.ok_or_else(|| Failure::new(Exit::Usage, format!("the list has no task {index}")))?;
    let runner = runner(listed)?;
    let job = Job::there(&listed.folder, listed.size, &runner)?;
    if job.identity() != listed.identity {
        let message = format!("{} holds another scene than the list says", listed.folder.display());
        return Err(Failure::new(Exit::Environment, message));
    }
    let made = Store::at(list.store.clone()).make(&job, (task.samples, task.seed), &mut |_| {})?;
    let what = match made {
        Some(facts) => format!("rendered in {:.1} s", facts.wall_seconds),
        None => "there already".to_owned(),
    };
    Ok(format!("{}, {}, {} samples, seed {}: {what}", listed.scene, listed.driver, task.samples, task.seed))
}

/// The renderer as it was found where the list was written, if it is that one here as well.
fn runner(listed: &Listed) -> Result<Runner, Failure> {
    let same = "the renderer must be the same one, in the same place, on all machines";
    let timeout = listed.timeout.map(Duration::try_from_secs_f64).and_then(Result::ok);
    let found = match &listed.command {
        None => Runner::find(driver_called(&listed.driver)?, Some(&listed.executable), None, timeout),
        Some(words) => {
            let command = Command::new(words).map_err(|(message, _)| Failure::new(Exit::Input, message))?;
            let driver = without_driver(&listed.driver).map_or_else(|| driver_called(&listed.driver), Ok)?;
            Runner::called(driver, command, Some(&listed.executable), timeout)
        }
    };
    let mut runner = found.map_err(|failure| failure.help(same))?;
    let driver = runner.driver;
    runner.options.clone_from(&listed.options);
    if runner.found.version != listed.version {
        let message = format!(
            "{} is {} {} here, not {}",
            listed.executable.display(),
            driver.name,
            runner.found.version,
            listed.version
        );
        return Err(Failure::new(Exit::Environment, message).help(same));
    }
    let given = runner.env.get("SLURM_CPUS_ON_NODE").and_then(|count| count.to_str()?.parse().ok());
    runner.threads = listed.threads.or(given);
    Ok(runner)
}

fn read<T: DeserializeOwned>(path: &Path) -> io::Result<T> {
    serde_json::from_slice(&regular::read(path, LARGEST)?).map_err(io::Error::from)
}

fn write<T: Serialize>(value: &T, path: &Path) -> io::Result<()> {
    let bytes = serde_json::to_vec_pretty(value).map_err(io::Error::from)?;
    write_whole(path, &mut |out| out.write_all(&bytes))
}
