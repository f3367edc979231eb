//! Private installations of renderers: a Python environment each, in the user's cache.
//!
//! `<cache>/renderers/<name>-<version>/` holds `venv/`, `install.log`, `install.lock`, the downloads
//! in `wheels/` and `pip-cache/` while they are needed, and, once everything has been proved to
//! work, `installed.json`. Nothing outside that folder is touched, and without the last file the
//! environment counts for nothing: it is made again, from what has already been downloaded.

mod error;
mod python;
mod verify;

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::cache::{CachePaths, replace_file};
use crate::env::{Env, executable};
use crate::run::process::{End, Lines, Patience, run, tail};
use crate::run::{Driver, find_on_path};

pub use error::InstallError;

/// The file whose lock an installation holds. The system frees it when the process ends, however
/// it ends, so that it cannot be left over.
pub(crate) const LOCK: &str = "install.lock";
const MARKER: &str = "installed.json";
const LOG: &str = "install.log";

/// What to install, and with what.
#[derive(Clone)]
pub struct InstallRequest {
    /// The renderer.
    pub driver: &'static Driver,
    /// Into which cache.
    pub cache: CachePaths,
    /// The environment in which to look for a Python.
    pub env: Env,
    /// The Python to use; one on the path if nothing is said.
    pub python: Option<PathBuf>,
    /// Becomes true when the caller no longer wants the installation.
    pub cancel: Option<Arc<AtomicBool>>,
}

/// A private installation that works.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Installed {
    /// The Python that has the renderer, to be used as the executable of a request.
    pub path: PathBuf,
    /// The version of the renderer.
    pub version: String,
    /// The folder that holds all of it.
    pub folder: PathBuf,
    /// Whether it was there before.
    pub already: bool,
}

/// What there is of a renderer on this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    /// Nothing.
    NotInstalled,
    /// A private installation that was begun and is not complete.
    Partial {
        /// Its folder.
        folder: PathBuf,
    },
    /// A private installation.
    Installed {
        /// The Python that has it.
        path: PathBuf,
        /// Its version.
        version: String,
    },
    /// One that the user has installed, on the path.
    External {
        /// The program, or the Python that has it.
        path: PathBuf,
        /// Its version.
        version: String,
    },
}

/// The steps of an installation, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Looking for a Python.
    Python,
    /// Making its environment.
    Environment,
    /// Downloading and unpacking packages.
    Packages,
    /// Rendering a scene whose image is known.
    Verification,
}

/// News from an installation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InstallProgress {
    /// A step begins.
    Step(Step),
    /// A line of output, to be shown below the step.
    Line(String),
}

/// What is in the marker. It says nothing of time, so equal installations have equal markers.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Marker {
    driver: String,
    version: String,
    python: String,
    requirements: Vec<String>,
}

/// Installs a renderer, or finds that it is there.
///
/// # Errors
/// Gives an error if another process is at it, no Python fits, a step fails, or the installed
/// renderer gives a wrong image. What was downloaded is kept for the next attempt.
pub fn install(request: &InstallRequest, progress: &mut dyn FnMut(InstallProgress)) -> Result<Installed, InstallError> {
    let driver = request.driver;
    let cache =
        CachePaths { root: std::path::absolute(&request.cache.root).map_err(InstallError::io(&request.cache.root))? };
    let folder = cache.renderer(driver.name, driver.version);
    fs::create_dir_all(&folder).map_err(InstallError::io(&folder))?;
    let lock = lock(&folder)?;
    if let Status::Installed { path, version } = status_in_cache(driver, &cache) {
        return Ok(Installed { path, version, folder, already: true });
    }
    progress(InstallProgress::Step(Step::Python));
    let base = python::choose(driver, request.python.as_deref(), &request.env)?;
    progress(InstallProgress::Line(format!("{} ({})", base.path.display(), base.version)));
    let site = Site { request, folder: &folder };

    progress(InstallProgress::Step(Step::Environment));
    // What an interrupted pip left behind may look complete to the next one, so only its
    // downloads are kept.
    let place = folder.join("venv");
    let arguments = ["--clear".into(), place.clone().into_os_string()];
    site.module(Step::Environment, &base.path, "venv", &arguments, progress)?;
    let python = venv_python(&place);

    progress(InstallProgress::Step(Step::Packages));
    // In two steps, because pip's own cache keeps only what the package index lets it keep.
    let (wheels, downloads) = (folder.join("wheels"), folder.join("pip-cache"));
    let pip = |command: &str, options: &[&OsStr], progress: &mut dyn FnMut(InstallProgress)| {
        // Renderers are not built here: without a wheel that would fail after a long time.
        let common = ["--disable-pip-version-check", "--no-input", "--progress-bar=off", "--only-binary=:all:"];
        let arguments: Vec<OsString> = std::iter::once(command)
            .chain(common)
            .map(OsStr::new)
            .chain(options.iter().copied())
            .chain(driver.requirements.iter().map(OsStr::new))
            .map(OsStr::to_owned)
            .collect();
        site.module(Step::Packages, &python, "pip", &arguments, progress)
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

    progress(InstallProgress::Step(Step::Verification));
    let version = verify::verify(driver, &python, &folder, request.cancel.clone())?;
    let marker = Marker {
        driver: driver.name.to_owned(),
        version: version.clone(),
        python: base.version,
        requirements: driver.requirements.iter().map(|&line| line.to_owned()).collect(),
    };
    let path = folder.join(MARKER);
    let json = serde_json::to_vec_pretty(&marker).map_err(|error| InstallError::io(&path)(error.into()))?;
    replace_file(&path, |file| file.write_all(&json)).map_err(InstallError::io(&path))?;
    // Now they are of no further use; it is no fault if they stay.
    for place in [wheels, downloads] {
        let _ = fs::remove_dir_all(place);
    }
    drop(lock);
    Ok(Installed { path: python, version, folder, already: false })
}

/// Deletes a private installation with its downloads; it is no error if there is none.
///
/// # Errors
/// Gives an error if it is being installed just now or cannot be deleted.
pub fn uninstall(driver: &Driver, cache: &CachePaths) -> Result<(), InstallError> {
    let folder = cache.renderer(driver.name, driver.version);
    if !folder.exists() {
        return Ok(());
    }
    let lock = lock(&folder)?;
    // The marker goes first, so that half a deletion is not taken for an installation.
    let marker = folder.join(MARKER);
    if marker.exists() {
        fs::remove_file(&marker).map_err(InstallError::io(&marker))?;
    }
    // Windows does not delete what is open.
    drop(lock);
    fs::remove_dir_all(&folder).map_err(InstallError::io(&folder))
}

/// What there is of a renderer: a complete private installation, else one on the path, else a
/// begun private one. Asking programs on the path takes about a second for each.
#[must_use]
pub fn status(driver: &Driver, cache: Option<&CachePaths>, env: &Env) -> Status {
    let own = cache.map_or(Status::NotInstalled, |cache| status_in_cache(driver, cache));
    if matches!(own, Status::Installed { .. }) {
        return own;
    }
    find_on_path(driver, env, &mut Vec::new()).map_or(own, |(path, version)| Status::External { path, version })
}

/// What there is in the cache. This reads one small file and starts nothing.
#[must_use]
pub fn status_in_cache(driver: &Driver, cache: &CachePaths) -> Status {
    let folder = cache.renderer(driver.name, driver.version);
    if !folder.is_dir() {
        return Status::NotInstalled;
    }
    let marker = fs::read(folder.join(MARKER)).ok();
    let marker = marker.and_then(|bytes| serde_json::from_slice::<Marker>(&bytes).ok());
    let path = venv_python(&folder.join("venv"));
    match marker {
        // The Python below an environment may have been removed since.
        Some(marker) if marker.requirements == driver.requirements && executable(&path) => {
            Status::Installed { path, version: marker.version }
        }
        _ => Status::Partial { folder },
    }
}

fn venv_python(venv: &Path) -> PathBuf {
    if cfg!(windows) { venv.join("Scripts").join("python.exe") } else { venv.join("bin").join("python") }
}

/// Takes the lock of an installation folder, and notes who has it.
fn lock(folder: &Path) -> Result<File, InstallError> {
    let path = folder.join(LOCK);
    let io = InstallError::io(&path);
    let opened = File::options().read(true).write(true).create(true).truncate(false).open(&path);
    let mut file = opened.map_err(&io)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let mut process = String::new();
            // Only for the message.
            let _ = file.read_to_string(&mut process);
            return Err(InstallError::Busy { folder: folder.to_owned(), process: process.trim().to_owned() });
        }
        Err(TryLockError::Error(error)) => return Err(io(error)),
    }
    file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id())).map_err(&io)?;
    Ok(file)
}

/// Where the steps run.
struct Site<'a> {
    request: &'a InstallRequest,
    folder: &'a Path,
}

impl Site<'_> {
    /// Runs a Python module as `python -m` does, seeing nothing of the user's packages, and ending
    /// with this process.
    fn module(
        &self,
        step: Step,
        python: &Path,
        module: &str,
        arguments: &[OsString],
        progress: &mut dyn FnMut(InstallProgress),
    ) -> Result<(), InstallError> {
        let scratch = self.folder.join("tmp");
        fs::create_dir_all(&scratch).map_err(InstallError::io(&scratch))?;
        let mut command = python::isolated(python);
        command.arg("-c").arg(python::SUPERVISED).arg(module).args(arguments);
        command.current_dir(self.folder);
        for variable in ["TMPDIR", "TEMP", "TMP"] {
            command.env(variable, &scratch);
        }
        // What would lead pip elsewhere; where packages come from stays the user's choice.
        for variable in ["PIP_TARGET", "PIP_PREFIX", "PIP_ROOT", "PIP_NO_CACHE_DIR", "PIP_DRY_RUN"] {
            command.env_remove(variable);
        }
        command.env("PIP_USER", "0");
        let log = self.folder.join(LOG);
        let patience = Patience { timeout: None, cancel: self.request.cancel.as_deref() };
        let end = run(command, &log, Lines::All, patience, &mut |line| {
            progress(InstallProgress::Line(line.to_owned()));
        });
        // Anything that stays is deleted with the folder.
        let _ = fs::remove_dir_all(&scratch);
        match end.map_err(InstallError::io(python))? {
            End::Exited(status) if status.success() => Ok(()),
            End::Exited(status) => Err(InstallError::Step {
                driver: self.request.driver,
                step,
                code: status.code(),
                tail: tail(&log, 20),
                log,
            }),
            End::Cancelled | End::TimedOut => Err(InstallError::Cancelled),
        }
    }
}

#[cfg(test)]
mod tests;
