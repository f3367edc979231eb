//! Private installations of renderers in the user's cache: a Python environment, or what cargo has built.
//!
//! `<cache>/renderers/<name>-<version>/` holds `venv/` (Python) or `root/` (cargo), `install.log`, `install.lock`, what
//! is needed on the way (`wheels/` and `pip-cache/`, or `build/`), and, once everything has been proved to work,
//! `installed.json`. Nothing outside that folder is touched but cargo's own downloads, and without the last file what is
//! there counts for nothing: it is made again, from what has already been downloaded or built.

mod cargo;
mod error;
mod pip;
mod python;
mod verify;

use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cache::{CachePaths, replace_file};
use crate::env::Env;
use crate::run::installed::{LOCK, MARKER, Marker, requirements};
use crate::run::process::{End, Lines, Patience, begin, run, tail};
use crate::run::{Driver, Installation, find_on_path};

pub use error::InstallError;

pub use crate::run::{Status, status_in_cache};

const LOG: &str = "install.log";

/// What to install, and with what.
#[derive(Clone)]
pub struct InstallRequest {
    /// The renderer.
    pub driver: &'static Driver,
    /// Into which cache.
    pub cache: CachePaths,
    /// The environment in which to look for a Python or a cargo.
    pub env: Env,
    /// The Python to use, where it takes one; one on the path if nothing is said.
    pub python: Option<PathBuf>,
    /// Becomes true when the caller no longer wants the installation.
    pub cancel: Option<Arc<AtomicBool>>,
}

/// A private installation that works.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Installed {
    /// The program, or the Python that has the renderer, to be used as the executable of a request.
    pub path: PathBuf,
    /// The version of the renderer.
    pub version: String,
    /// The folder that holds all of it.
    pub folder: PathBuf,
    /// Whether it was there before.
    pub already: bool,
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
    /// Looking for a cargo.
    Cargo,
    /// Downloading sources and building them.
    Build,
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

/// Installs a renderer, or finds that it is there.
///
/// # Errors
/// Gives an error if ltsc does not install it, another process is at it, no Python or cargo fits, a step fails, or the
/// installed renderer gives a wrong image. What was downloaded and built is kept for the next attempt.
pub fn install(request: &InstallRequest, progress: &mut dyn FnMut(InstallProgress)) -> Result<Installed, InstallError> {
    let driver = request.driver;
    if matches!(driver.installation, Installation::User { .. }) {
        return Err(InstallError::ByUser { driver });
    }
    let cache =
        CachePaths { root: std::path::absolute(&request.cache.root).map_err(InstallError::io(&request.cache.root))? };
    let folder = cache.renderer(driver.name, driver.version);
    fs::create_dir_all(&folder).map_err(InstallError::io(&folder))?;
    let lock = lock(&folder)?;
    if let Status::Installed { path, version: _ } = status_in_cache(driver, &cache) {
        progress(InstallProgress::Step(Step::Verification));
        match verify::verify(driver, &path, &folder, request.cancel.clone()) {
            Ok(version) => return Ok(Installed { path, version, folder, already: true }),
            Err(error) if request.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed)) => {
                return Err(error);
            }
            // It was complete once and renders no longer: it is made again.
            Err(_) => clear(&folder).map_err(InstallError::io(&folder))?,
        }
    }
    let site = Site { request, folder: &folder };
    let Made { executable, tool, leftovers } = match &driver.installation {
        Installation::Python(packages) => pip::make(&site, packages, progress)?,
        Installation::Cargo(source) => cargo::make(&site, source, progress)?,
        Installation::User { .. } => return Err(InstallError::ByUser { driver }),
    };
    progress(InstallProgress::Step(Step::Verification));
    let version = verify::verify(driver, &executable, &folder, request.cancel.clone())?;
    let marker =
        Marker { driver: driver.name.to_owned(), version: version.clone(), tool, requirements: requirements(driver) };
    let path = folder.join(MARKER);
    let json = serde_json::to_vec_pretty(&marker).map_err(|error| InstallError::io(&path)(error.into()))?;
    replace_file(&path, |file| file.write_all(&json)).map_err(InstallError::io(&path))?;
    // Now they are of no further use; it is no fault if they stay.
    for place in leftovers {
        let _ = fs::remove_dir_all(place);
    }
    drop(lock);
    Ok(Installed { path: executable, version, folder, already: false })
}

/// Deletes what an installation has made, the marker first; downloads stay.
fn clear(folder: &Path) -> std::io::Result<()> {
    let marker = folder.join(MARKER);
    if marker.exists() {
        fs::remove_file(marker)?;
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if [LOCK, LOG, "wheels", "pip-cache", "build"].iter().any(|kept| entry.file_name() == *kept) {
            continue;
        }
        if entry.file_type()?.is_dir() { fs::remove_dir_all(entry.path())? } else { fs::remove_file(entry.path())? }
    }
    Ok(())
}

/// What an installation has made.
struct Made {
    /// What a request is to run.
    executable: PathBuf,
    /// The version of the tool that made it.
    tool: String,
    /// Folders that are of no use once it is known to work.
    leftovers: Vec<PathBuf>,
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
    find_on_path(driver, env, None, &mut Vec::new()).map_or(own, |(path, version)| Status::External { path, version })
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
    /// Runs a command of a step in the installation's folder, with a folder for temporary files there.
    fn run(
        &self,
        step: Step,
        mut command: Command,
        progress: &mut dyn FnMut(InstallProgress),
    ) -> Result<(), InstallError> {
        let scratch = self.folder.join("tmp");
        fs::create_dir_all(&scratch).map_err(InstallError::io(&scratch))?;
        command.current_dir(self.folder);
        for variable in ["TMPDIR", "TEMP", "TMP"] {
            command.env(variable, &scratch);
        }
        let program = PathBuf::from(command.get_program());
        let log = self.folder.join(LOG);
        begin(&log).map_err(InstallError::io(&log))?;
        let patience = Patience { until: None, cancel: self.request.cancel.as_deref() };
        let end = run(command, &log, Lines::All, patience, &mut |line| {
            progress(InstallProgress::Line(line.to_owned()));
        });
        // Anything that stays is deleted with the folder.
        let _ = fs::remove_dir_all(&scratch);
        match end.map_err(InstallError::io(&program))?.0 {
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
