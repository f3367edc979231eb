//! The programs of an evaluation's renderers; what is missing is found together.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ltsc_core::diag::Finding;
use ltsc_render::run::{Driver, without_driver};

use crate::failure::Failure;
use crate::file::Evaluation;
use crate::file::model::Renderer;
use crate::job::Runner;

/// The code of a finding that a renderer is not there.
pub const MISSING: &str = "evaluation-renderer";

/// A program for each renderer of an evaluation, in its order; none for those that render nothing.
pub struct Runners(Vec<Option<Runner>>);

impl Runners {
    /// That of a renderer by its number, if it renders anything.
    #[must_use]
    pub fn get(&self, renderer: usize) -> Option<&Runner> {
        self.0.get(renderer)?.as_ref()
    }
}

/// Finds the programs of all renderers that render something. `base` is the folder of the evaluation's file, `configured` gives what the
/// project names for a driver, `threads` how many those have that say nothing.
///
/// # Errors
/// A finding for each that is missing.
pub fn runners(
    evaluation: &Evaluation,
    base: &Path,
    configured: &dyn Fn(&'static Driver) -> Result<Option<PathBuf>, Failure>,
    threads: Option<usize>,
) -> Result<Runners, Vec<Finding>> {
    let used: BTreeSet<usize> = evaluation.runs.iter().map(|run| evaluation.variant(*run).renderer).collect();
    let mut found = Vec::new();
    let mut missing = Vec::new();
    for (at, renderer) in evaluation.renderers.iter().enumerate() {
        if !used.contains(&at) {
            found.push(None);
            continue;
        }
        match runner(renderer, base, configured, threads) {
            Ok(runner) => found.push(Some(runner)),
            Err(failure) => {
                let place = renderer.path.as_ref().map_or(renderer.span, |path| path.span);
                let message = format!("the renderer `{}` cannot be used: {}", renderer.name, failure.message);
                missing.push(Finding { help: failure.help, ..Finding::error(MISSING, place, message) });
            }
        }
    }
    if missing.is_empty() { Ok(Runners(found)) } else { Err(missing) }
}

fn runner(
    renderer: &Renderer,
    base: &Path,
    configured: &dyn Fn(&'static Driver) -> Result<Option<PathBuf>, Failure>,
    threads: Option<usize>,
) -> Result<Runner, Failure> {
    if renderer.manual {
        let driver = renderer.driver.or_else(|| without_driver(renderer.target.name));
        return driver.map(Runner::manual).ok_or_else(|| {
            let message = format!("nothing is known of files for `{}`", renderer.target.name);
            Failure::new(crate::failure::Exit::Fault, message)
        });
    }
    let given = renderer.path.as_ref().map(|path| program(&path.value, base));
    let mut runner = match (&renderer.command, renderer.driver) {
        (Some(command), driver) => {
            let driver = driver.or_else(|| without_driver(renderer.target.name)).ok_or_else(|| {
                let message = format!("nothing is known of files for `{}`", renderer.target.name);
                Failure::new(crate::failure::Exit::Fault, message)
            })?;
            Runner::called(driver, command.value.clone(), given.as_deref(), renderer.timeout)?
        }
        (None, Some(driver)) => {
            let named = if given.is_none() { configured(driver)? } else { None };
            Runner::find(driver, given.as_deref(), named.as_deref(), None)?
        }
        // The file's reader has refused it.
        (None, None) => {
            let message = format!("no renderer of ltsc reads `{}`", renderer.target.name);
            return Err(Failure::new(crate::failure::Exit::Usage, message));
        }
    };
    runner.threads = renderer.threads.map(|threads| threads as usize).or(threads);
    runner.timeout = renderer.timeout;
    runner.options.clone_from(&renderer.options);
    Ok(runner)
}

/// A program as the file names it: a bare name is looked up on the path unless it lies beside the file; all else starts there.
fn program(name: &str, base: &Path) -> PathBuf {
    let beside = base.join(name);
    let bare = Path::new(name).components().count() == 1;
    if bare && !beside.is_file() { PathBuf::from(name) } else { beside }
}
