//! Installations of Python packages, each in an environment of its own.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::Path;

use super::{InstallError, InstallProgress, Made, Site, Step, python};
use crate::run::Packages;
use crate::run::installed::{python, venv};

/// Makes the environment and unpacks the packages.
pub(super) fn make(
    site: &Site<'_>,
    packages: &Packages,
    progress: &mut dyn FnMut(InstallProgress),
) -> Result<Made, InstallError> {
    let request = site.request;
    progress(InstallProgress::Step(Step::Python));
    let base = python::choose(request.driver, packages, request.python.as_deref(), &request.env)?;
    progress(InstallProgress::Line(format!("{} ({})", base.path.display(), base.version)));

    progress(InstallProgress::Step(Step::Environment));
    // What an interrupted pip left behind may look complete to the next one, so only its
    // downloads are kept.
    let arguments = ["--clear".into(), venv(site.folder).into_os_string()];
    module(site, Step::Environment, &base.path, "venv", &arguments, progress)?;
    let python = python(site.folder);

    progress(InstallProgress::Step(Step::Packages));
    // In two steps, because pip's own cache keeps only what the package index lets it keep.
    let (wheels, downloads) = (site.folder.join("wheels"), site.folder.join("pip-cache"));
    let pip = |command: &str, options: &[&OsStr], progress: &mut dyn FnMut(InstallProgress)| {
        // Renderers are not built here: without a wheel that would fail after a long time.
        let common = ["--disable-pip-version-check", "--no-input", "--progress-bar=off", "--only-binary=:all:"];
        let arguments: Vec<OsString> = std::iter::once(command)
            .chain(common)
            .map(OsStr::new)
            .chain(options.iter().copied())
            .chain(packages.requirements.iter().map(OsStr::new))
            .map(OsStr::to_owned)
            .collect();
        module(site, Step::Packages, &python, "pip", &arguments, progress)
    };
    pip("download", &["--cache-dir".as_ref(), downloads.as_os_str(), "--dest".as_ref(), wheels.as_os_str()], progress)?;
    let options = ["--no-index", "--no-cache-dir", "--no-warn-script-location", "--find-links"].map(OsStr::new);
    let unpacked = pip("install", &[&options[..], &[wheels.as_os_str()]].concat(), progress);
    if unpacked.is_err() {
        // A download that was cut off may be the cause, and without a checksum from the index pip
        // would keep it.
        let _ = fs::remove_dir_all(&wheels);
    }
    unpacked?;
    Ok(Made { executable: python, tool: base.version, leftovers: vec![wheels, downloads] })
}

/// Runs a Python module as `python -m` does, seeing nothing of the user's packages, and ending
/// with this process.
fn module(
    site: &Site<'_>,
    step: Step,
    python: &Path,
    module: &str,
    arguments: &[OsString],
    progress: &mut dyn FnMut(InstallProgress),
) -> Result<(), InstallError> {
    let mut command = python::isolated(python);
    command.arg("-c").arg(python::SUPERVISED).arg(module).args(arguments);
    // What would lead pip elsewhere; where packages come from stays the user's choice.
    for variable in ["PIP_TARGET", "PIP_PREFIX", "PIP_ROOT", "PIP_NO_CACHE_DIR", "PIP_DRY_RUN"] {
        command.env_remove(variable);
    }
    command.env("PIP_USER", "0");
    site.run(step, command, progress)
}
