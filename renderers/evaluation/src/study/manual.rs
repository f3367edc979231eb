//! Renderers that nobody starts here: the evaluation writes the files, says which image it expects, waits for nothing, and takes the image
//! when it is there.

use std::path::{Path, PathBuf};

use ltsc_render::image::attributes;

use crate::chunk::{Chunks, Cost};
use crate::disk::{DiskSink, unwritable};
use crate::failure::Failure;
use crate::file::Evaluation;
use crate::job::Job;

use super::folder::copy;
use super::names::{Names, Places};

/// Where a run lies whose image is made by hand: below the folder of results, the same whatever their date.
pub struct Manual {
    /// The folder of its files.
    pub files: PathBuf,
    /// The image that is expected; further ones of other seeds have `-1`, `-2` and so on before the ending.
    pub image: PathBuf,
}

impl Manual {
    /// Of a run, by its number; `base` is the folder of the evaluation's file.
    pub(super) fn of(evaluation: &Evaluation, run: usize, places: &Places, base: &Path) -> Self {
        let condition = &places.conditions[evaluation.runs[run].condition];
        let label = &places.runs[run];
        let study = Names::default().of(&evaluation.name);
        let folder = base.join(&evaluation.output.folder).join("manual").join(study).join(condition);
        Self { files: folder.join(label), image: folder.join(format!("{label}.exr")) }
    }

    /// Writes the files where they are not as they should be.
    pub(super) fn write(&self, job: &Job<'_>, force: bool) -> Result<(), Failure> {
        let failed = |error: std::io::Error| unwritable(&self.files, &error);
        let mut sink = DiskSink::new(&self.files, job.scene(), false, force).map_err(failed)?;
        copy(job, &mut sink, "").map_err(failed)?;
        sink.finish().map(|_| ()).map_err(failed)
    }

    /// The images that are there: the expected one, and those of other seeds.
    fn images(&self) -> Vec<PathBuf> {
        let stem = self.image.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let numbered = (1..).map(|at| self.image.with_file_name(format!("{stem}-{at}.exr")));
        std::iter::once(self.image.clone()).chain(numbered).take_while(|file| file.is_file()).collect()
    }

    /// The images as chunks of `samples` each; none where none is there.
    pub(super) fn chunks(&self, samples: u32) -> Option<Chunks> {
        let files = self.images();
        let first = files.first()?;
        let told = |name: &str| {
            let known = attributes(first).unwrap_or_default();
            known.into_iter().find(|(key, _)| key == name).map(|(_, value)| value)
        };
        let version = told("software").or_else(|| told("Software")).unwrap_or_default();
        let cost = Cost { version, samples: u64::from(samples) * files.len() as u64, ..Cost::default() };
        Some(Chunks { seconds: vec![0.0; files.len()], samples, cost, files })
    }
}
