//! Who renders chunks: this machine, or a cluster. All of them put chunks into a store, and nothing else; what is there already is not
//! rendered again.

mod local;
pub mod slurm;

use crate::chunk::Store;
use crate::failure::{Exit, Failure};
use crate::job::Job;

pub use local::Local;

/// A chunk to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Task {
    /// Which of the jobs.
    pub job: usize,
    /// Samples per pixel.
    pub samples: u32,
    /// The seed.
    pub seed: u32,
}

/// What is to be rendered.
pub struct Order<'a> {
    /// Scenes as they were written for renderers.
    pub jobs: &'a [Job<'a>],
    /// Their chunks, in the order in which they are wanted.
    pub tasks: &'a [Task],
    /// Where chunks are put.
    pub store: &'a Store,
    /// Whether to go on with the others where one has failed.
    pub keep_going: bool,
}

/// What became of a chunk.
#[derive(Debug)]
pub enum Outcome {
    /// It was rendered.
    Made,
    /// It was there.
    Kept,
    /// It could not be rendered.
    Failed(Failure),
    /// It was not begun, because another one had failed.
    Skipped,
}

impl Outcome {
    /// Whether the chunk is in the store now.
    #[must_use]
    pub fn is_there(&self) -> bool {
        matches!(self, Self::Made | Self::Kept)
    }
}

/// News of the work.
#[derive(Debug)]
pub enum News<'a> {
    /// A chunk is being rendered.
    Begun(usize),
    /// A chunk is done, or has failed.
    Ended(usize, &'a Outcome),
    /// Something that people should read.
    Note(String),
}

/// Renders chunks.
pub trait Executor: Sync {
    /// Renders all chunks that are not in the store, and gives one outcome for each task.
    ///
    /// # Errors
    /// Where nothing can be rendered at all; a renderer that fails is an outcome.
    fn run(&self, order: &Order<'_>, news: &(dyn Fn(News<'_>) + Sync)) -> Result<Vec<Outcome>, Failure>;
}

/// An executor by its name, for the command line.
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a few words.
    pub summary: &'static str,
    /// Makes one.
    pub make: fn(&Resources) -> Result<Box<dyn Executor>, Failure>,
}

/// What may be used.
#[derive(Clone, Debug)]
pub struct Resources {
    /// Renderers at once.
    pub jobs: usize,
    /// Bytes of memory for all of them together; none where it is not known.
    pub memory: Option<u64>,
    /// A folder that all machines share, for executors that use several.
    pub shared: Option<std::path::PathBuf>,
    /// What else an executor is told, such as `--partition=short`.
    pub options: Vec<String>,
}

/// All executors.
pub const EXECUTORS: &[&Kind] = &[&local::KIND, &slurm::KIND];

/// The executor called `name`.
///
/// # Errors
/// Usage, with those that are known.
pub fn find(name: &str) -> Result<&'static Kind, Failure> {
    EXECUTORS.iter().copied().find(|kind| kind.name == name).ok_or_else(|| {
        let known: Vec<&str> = EXECUTORS.iter().map(|kind| kind.name).collect();
        Failure::new(Exit::Usage, format!("there is no executor `{name}`")).help(format!("known: {}", known.join(", ")))
    })
}
