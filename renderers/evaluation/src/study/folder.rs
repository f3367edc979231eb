//! The folder of results: a copy of the evaluation's file, images with their variance, logs, tables. It appears as a whole at the end,
//! and a manifest says which of its files are ours.

use std::path::{Path, PathBuf};

use ltsc_core::files::Sink;

use crate::disk::{DiskSink, Manifest, not_ours, probe, unwritable};
use crate::failure::Failure;
use crate::file::Evaluation;
use crate::job::Job;

use super::names::Names;

/// What the manifest of results names as its scene begins with this.
const MARK: &str = "evaluation ";

/// When files that were written for renderers are kept in the results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clean {
    /// They are left out where a case succeeds.
    #[default]
    Success,
    /// They are always left out.
    Always,
    /// They are always kept.
    Never,
}

/// Where results go.
pub struct Folder {
    /// The folder itself.
    pub path: PathBuf,
    /// Whether files there that ltsc did not write are written over.
    pub force: bool,
    /// Which files for renderers are kept.
    pub clean: Clean,
}

impl Folder {
    /// Where the results of an evaluation go whose file lies in `base`: as it says, with `date` where it asks for one.
    #[must_use]
    pub fn of(evaluation: &Evaluation, base: &Path, date: &str) -> PathBuf {
        let mut name = Names::default().of(&evaluation.name);
        if evaluation.output.dated {
            name = format!("{name} {date}");
        }
        base.join(&evaluation.output.folder).join(name)
    }

    /// Now, by the clock of this place, as it stands in the names of folders.
    #[must_use]
    pub fn date() -> String {
        jiff::ZonedDateTime::now().strftime("%Y-%m-%d %H.%M.%S").to_string()
    }

    /// Refuses a place that cannot be written or holds what ltsc did not write, before long work is done for it.
    ///
    /// # Errors
    /// Why.
    pub fn check(&self) -> Result<(), Failure> {
        let around = self.path.parent().filter(|around| !around.as_os_str().is_empty()).unwrap_or(Path::new("."));
        probe(around)?;
        match std::fs::symlink_metadata(&self.path) {
            Err(_) => Ok(()),
            Ok(meta) if !meta.is_dir() => {
                let error = std::io::Error::new(std::io::ErrorKind::NotADirectory, "it is no folder");
                Err(unwritable(&self.path, &error))
            }
            Ok(_) => {
                let empty = std::fs::read_dir(&self.path).is_ok_and(|mut entries| entries.next().is_none());
                if self.force || empty || is_results(&self.path) {
                    Ok(())
                } else {
                    Err(not_ours(std::slice::from_ref(&self.path)))
                }
            }
        }
    }

    /// Begins to write it.
    pub(super) fn begin(&self, name: &str) -> Result<DiskSink, Failure> {
        let scene = format!("{MARK}{name}");
        DiskSink::new(&self.path, &scene, false, self.force).map_err(|error| unwritable(&self.path, &error))
    }

    /// Whether the files of a case are kept.
    pub(super) fn keeps(&self, failed: bool) -> bool {
        match self.clean {
            Clean::Success => failed,
            Clean::Always => false,
            Clean::Never => true,
        }
    }
}

/// Whether a folder holds results of an evaluation that ltsc wrote.
#[must_use]
pub fn is_results(folder: &Path) -> bool {
    Manifest::read(folder).is_some_and(|manifest| manifest.scene.starts_with(MARK))
}

/// Copies the files of a job into a folder of the results.
pub(super) fn copy(job: &Job<'_>, sink: &mut DiskSink, below: &str) -> std::io::Result<()> {
    let Some(manifest) = Manifest::read(job.folder()) else { return Ok(()) };
    for path in manifest.files.keys() {
        let from = job.folder().join(path);
        let name = if below.is_empty() { path.clone() } else { format!("{below}/{path}") };
        sink.file(&name, &mut |out| {
            let (mut file, _) = ltsc_render::regular::open(&from)?;
            std::io::copy(&mut file, out).map(|_| ())
        })?;
    }
    Ok(())
}
