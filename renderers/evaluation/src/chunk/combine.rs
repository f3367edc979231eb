//! Chunks put together: the mean, its variance in each pixel, and what it cost.

use std::path::{Path, PathBuf};

use ltsc_render::image::{Image, Provenance, attributes, layered_bytes};
use ltsc_render::regular;
use serde::{Deserialize, Serialize};

use super::facts::Facts;
use super::{Plan, Store};
use crate::compare::Images;
use crate::disk::{unwritable, write_whole};
use crate::failure::{Exit, Failure};
use crate::job::Job;

/// The prefix of the channels that hold the variance of the mean.
pub const VARIANCE: &str = "variance.";

/// What all chunks of an image took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// The renderer's version, as it says.
    pub version: String,
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of rendering of all chunks together, without start and loading where the renderer tells them apart.
    pub seconds: f64,
    /// Seconds of processor time; none where it is not known of all chunks.
    pub cpu_seconds: Option<f64>,
    /// Bytes of memory of the largest process.
    pub peak_memory: Option<u64>,
    /// Threads of each renderer; none where chunks differ or had all processors.
    pub threads: Option<u32>,
    /// Renderers that ran at once, by this program's doing; none where chunks differ, or it is not known. Beside others times are longer.
    pub at_once: Option<u32>,
    /// The machines.
    pub machines: Vec<String>,
    /// The highest load of the machine at the beginning of a chunk; above its cores, times are too long.
    pub load: Option<f64>,
}

impl Cost {
    /// The sum over chunks.
    #[must_use]
    pub fn of(chunks: &[Facts]) -> Self {
        let mut machines: Vec<String> = chunks.iter().map(|facts| facts.machine.clone()).collect();
        machines.sort();
        machines.dedup();
        let first = chunks.first();
        let (threads, at_once) = first.map_or((None, None), |first| (first.threads, first.at_once));
        Self {
            version: first.map(|first| first.version.clone()).unwrap_or_default(),
            samples: chunks.iter().map(|facts| facts.samples).sum(),
            seconds: chunks.iter().map(|facts| facts.seconds).sum(),
            cpu_seconds: chunks.iter().map(|facts| facts.cpu_seconds).sum(),
            peak_memory: chunks.iter().filter_map(|facts| facts.peak_memory).max(),
            threads: threads.filter(|_| chunks.iter().all(|facts| facts.threads == threads)),
            at_once: at_once.filter(|_| chunks.iter().all(|facts| facts.at_once == at_once)),
            machines,
            load: chunks.iter().filter_map(|facts| facts.load).reduce(f64::max),
        }
    }
}

/// The chunks of an image.
pub struct Chunks {
    /// Their files, by seed.
    pub files: Vec<PathBuf>,
    /// Samples per pixel of each.
    pub samples: u32,
    /// What they took.
    pub cost: Cost,
    /// Seconds of rendering of each.
    pub seconds: Vec<f64>,
}

impl Chunks {
    /// Those of a plan, all of which are in the store.
    ///
    /// # Errors
    /// If one is missing or its header is damaged.
    pub fn of(store: &Store, job: &Job<'_>, plan: Plan, first_seed: u32) -> Result<Self, Failure> {
        let identity = job.identity();
        let seeds = first_seed..first_seed.saturating_add(plan.count);
        let files: Vec<PathBuf> = seeds.map(|seed| store.path(&identity, plan.samples, seed)).collect();
        let facts = files.iter().map(|file| facts(file)).collect::<Result<Vec<_>, _>>()?;
        let seconds = facts.iter().map(|facts| facts.seconds).collect();
        Ok(Self { files, samples: plan.samples, cost: Cost::of(&facts), seconds })
    }

    /// For statistics.
    #[must_use]
    pub fn images(&self) -> Images<'_> {
        Images::Files(&self.files)
    }

    /// The whole output of the renderer for each chunk, one after the other.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_logs(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        for file in &self.files {
            writeln!(out, "== {}", file.file_stem().unwrap_or_default().to_string_lossy())?;
            // A log that is gone is no loss of a chunk.
            let text = regular::read(&file.with_extension("log"), regular::TEXT).unwrap_or_default();
            out.write_all(&text)?;
        }
        Ok(())
    }

    /// The mean, and the variance of the mean where there are several chunks.
    ///
    /// # Errors
    /// If a chunk cannot be read.
    pub fn combined(&self) -> Result<(Image, Option<Image>), Failure> {
        let moments = self.images().moments().map_err(|error| {
            Failure::new(Exit::Environment, error.to_string()).help("remove that chunk: it is rendered again")
        })?;
        let variance = (self.files.len() > 1).then(|| moments.variance_image());
        Ok((moments.mean_image(), variance))
    }
}

fn facts(file: &Path) -> Result<Facts, Failure> {
    let found = attributes(file).map_err(|error| {
        Failure::new(Exit::Environment, error.to_string())
            .help(format!("remove {}: it is rendered again", file.display()))
    })?;
    Ok(Facts::read(&Provenance::from_attributes(&found)))
}

/// Writes a mean with its variance as layers of one OpenEXR file.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, image: &Image, variance: Option<&Image>, provenance: &Provenance) -> Result<(), Failure> {
    let layers: Vec<(&str, &Image)> =
        std::iter::once(("", image)).chain(variance.map(|variance| (VARIANCE, variance))).collect();
    let bytes = layered_bytes(path, &layers, provenance)
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
    write_whole(path, &mut |out| out.write_all(&bytes)).map_err(|error| unwritable(path, &error))
}
