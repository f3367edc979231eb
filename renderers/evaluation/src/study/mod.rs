//! An evaluation carried out: everything is looked at before anything is rendered, rendered in chunks, compared, and written into one
//! folder.
//!
//! Reading order: `runners` (programs of its renderers), `prepare` (scenes written for them, with plans of chunks), `work` (chunks rendered
//! by an executor), `judge` (images compared in pairs), `results` and `timing` (what is known afterwards: what another machine would
//! find too, and what it would not), `tables` (the same for people), `names` and `folder` (where it goes), `estimate` (what would be
//! done), `clean` (results of earlier runs, removed).

mod clean;
mod estimate;
mod folder;
mod judge;
mod manual;
mod names;
mod prepare;
pub mod results;
mod runners;
mod tables;
pub mod timing;
mod work;

use std::path::Path;

use crate::chunk::Store;
use crate::executor::Executor;
use crate::failure::Failure;
use crate::file::Evaluation;
use crate::file::model::Run;
use crate::watch::Watch;

pub use clean::{Removed, clean};
pub use estimate::Estimate;
pub use folder::{Clean, Folder, is_results};
pub use manual::Manual;
pub use prepare::{Loaded, Prepared, prepare};
pub use runners::{Runners, runners};
pub use work::{Fate, Options};

use results::Results;
use timing::Timing;

/// What an evaluation has given.
pub struct Done {
    /// What another machine would find too.
    pub results: Results,
    /// What it would not.
    pub timing: Timing,
}

/// Everything that is asked of an evaluation beyond its file.
pub struct Study<'a> {
    /// The evaluation.
    pub evaluation: &'a Evaluation,
    /// Its scenes, in the order of [`Evaluation::conditions`].
    pub conditions: &'a [Loaded],
    /// The text of its file.
    pub text: &'a str,
    /// The folder of its file, from which paths in it are seen.
    pub base: &'a Path,
    /// Where chunks are kept.
    pub store: &'a Store,
    /// Who renders them.
    pub executor: &'a dyn Executor,
    /// How.
    pub options: Options,
}

impl Study<'_> {
    /// Renders what is not there yet, compares, and writes the folder of the results. A case that fails is told in the results.
    ///
    /// # Errors
    /// Where nothing can be rendered at all, or the folder cannot be written.
    pub fn carry_out(
        &self,
        prepared: &Prepared<'_>,
        folder: &Folder,
        watch: &mut (dyn Watch + Send),
    ) -> Result<Done, Failure> {
        for ready in &prepared.runs {
            if let Some(manual) = &ready.manual {
                manual.write(&prepared.jobs[ready.job], folder.force)?;
            }
        }
        let fates = work::render(self, prepared, watch)?;
        let done = judge::judge(self, prepared, &fates, folder, watch)?;
        Ok(done)
    }

    /// The label of a run with its condition, for messages.
    fn label(&self, run: Run) -> String {
        format!("{}: {}", self.evaluation.conditions[run.condition].name, self.evaluation.label(run))
    }
}
