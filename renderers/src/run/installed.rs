//! What there is of a private installation in the user's cache: where its program lies, and whether it is complete.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Crate, Driver, Installation};
use crate::cache::CachePaths;
use crate::env::executable;
use crate::regular;

/// The file whose lock an installation holds. The system frees it when the process ends, however
/// it ends, so that it cannot be left over.
pub(crate) const LOCK: &str = "install.lock";
/// What is there once everything has been proved to work.
pub(crate) const MARKER: &str = "installed.json";

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
        /// The program, or the Python that has it.
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

/// What is in the marker. It says nothing of time, so equal installations have equal markers.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Marker {
    pub driver: String,
    pub version: String,
    /// The version of Python or of cargo.
    #[serde(alias = "python")]
    pub tool: String,
    pub requirements: Vec<String>,
}

/// What the marker of an installation of this version says, so that another choice of packages is installed anew.
pub(crate) fn requirements(driver: &Driver) -> Vec<String> {
    match &driver.installation {
        Installation::Python(packages) => packages.requirements.iter().map(|&line| line.to_owned()).collect(),
        Installation::Cargo(source) => vec![format!("{}={}", source.name, driver.version)],
        Installation::User { .. } => Vec::new(),
    }
}

/// Where the executable of an installation lies.
fn place(driver: &Driver, folder: &Path) -> Option<PathBuf> {
    match &driver.installation {
        Installation::Python(_) => Some(python(folder)),
        Installation::Cargo(source) => Some(program(source, folder)),
        Installation::User { .. } => None,
    }
}

/// What there is in the cache. This reads one small file and starts nothing.
#[must_use]
pub fn status_in_cache(driver: &Driver, cache: &CachePaths) -> Status {
    let folder = cache.renderer(driver.name, driver.version);
    if !folder.is_dir() {
        return Status::NotInstalled;
    }
    let marker = regular::read(&folder.join(MARKER), regular::TEXT).ok();
    let marker = marker.and_then(|bytes| serde_json::from_slice::<Marker>(&bytes).ok());
    match (marker, place(driver, &folder)) {
        // The Python below an environment may have been removed since.
        (Some(marker), Some(path)) if marker.requirements == requirements(driver) && executable(&path) => {
            Status::Installed { path, version: marker.version }
        }
        _ => Status::Partial { folder },
    }
}

/// The Python of the environment.
pub(crate) fn python(folder: &Path) -> PathBuf {
    let venv = venv(folder);
    if cfg!(windows) { venv.join("Scripts").join("python.exe") } else { venv.join("bin").join("python") }
}

/// The environment of an installation for Python.
pub(crate) fn venv(folder: &Path) -> PathBuf {
    folder.join("venv")
}

/// The program that is built.
pub(crate) fn program(source: &Crate, folder: &Path) -> PathBuf {
    root(folder).join("bin").join(format!("{}{}", source.program, std::env::consts::EXE_SUFFIX))
}

/// Where cargo installs to.
pub(crate) fn root(folder: &Path) -> PathBuf {
    folder.join("root")
}
