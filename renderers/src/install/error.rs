//! Why a renderer could not be installed.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::Step;
use crate::run::{Driver, Packages, RenderError};

/// Why a renderer could not be installed.
pub enum InstallError {
    /// Another process installs it.
    Busy {
        /// The folder.
        folder: PathBuf,
        /// The number of that process, if it is known.
        process: String,
    },
    /// Only the user can install it.
    ByUser {
        /// The renderer.
        driver: &'static Driver,
    },
    /// No cargo can be used.
    Cargo {
        /// The renderer.
        driver: &'static Driver,
        /// The oldest that can be used, 1.x.
        oldest: u32,
        /// Which were looked at, and what is wrong with each.
        looked: Vec<String>,
    },
    /// No Python can be used.
    Python {
        /// The renderer.
        driver: &'static Driver,
        /// The oldest and the newest that can be used, 3.x.
        pythons: (u32, u32),
        /// Which were looked at, and what is wrong with each.
        looked: Vec<String>,
    },
    /// A step failed.
    Step {
        /// The renderer.
        driver: &'static Driver,
        /// The step.
        step: Step,
        /// The exit code; nothing if a signal ended it.
        code: Option<i32>,
        /// The end of the log.
        tail: Vec<String>,
        /// The whole log.
        log: PathBuf,
    },
    /// The installed renderer does not render.
    Render(Box<RenderError>),
    /// The installed renderer renders something else than it should.
    Wrong {
        /// The renderer.
        driver: &'static Driver,
        /// What is wrong.
        message: String,
    },
    /// A file or program cannot be used.
    Io {
        /// Which.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The caller took the request back.
    Cancelled,
}

impl InstallError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Busy { .. } => "wait until it is done, or stop that process".to_owned(),
            Self::ByUser { driver } => driver.advice(),
            Self::Cargo { oldest, .. } => {
                format!("install Rust 1.{oldest} or newer with cargo (https://rustup.rs), or name an executable")
            }
            Self::Python { pythons: (oldest, newest), .. } => format!(
                "install Python 3.{oldest} to 3.{newest} with its `venv` and `pip` (on Debian and Ubuntu: \
                 `apt install python3-venv`), or name such a Python"
            ),
            Self::Step { tail, driver, log, .. } => step_hint(tail, driver, log),
            Self::Render(error) => error.hint(),
            Self::Wrong { .. } => "this machine renders wrong; please report it with the log".to_owned(),
            Self::Io { .. } => "check permissions and free space, or name another folder in LTSC_CACHE".to_owned(),
            Self::Cancelled => "start it again; what was downloaded is kept".to_owned(),
        }
    }

    /// Further lines: the end of a log, or what was looked at.
    #[must_use]
    pub fn tail(&self) -> &[String] {
        match self {
            Self::Python { looked, .. } | Self::Cargo { looked, .. } => looked,
            Self::Step { tail, .. } => tail,
            Self::Render(error) => error.tail(),
            Self::ByUser { .. } | Self::Busy { .. } | Self::Wrong { .. } | Self::Io { .. } | Self::Cancelled => &[],
        }
    }

    pub(super) fn io(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { path: path.clone(), source }
    }
}

/// What the last lines of pip, venv and cargo tell.
fn step_hint(tail: &[String], driver: &Driver, log: &Path) -> String {
    let said = |text: &str| tail.iter().any(|line| line.contains(text));
    if said("No space left") {
        "make room, or name a folder on another disk in LTSC_CACHE".to_owned()
    } else if let Some(Packages { pythons: (oldest, newest), .. }) =
        driver.packages().filter(|_| said("No matching distribution"))
    {
        format!(
            "there is no package for this Python and system (it takes Python 3.{oldest} to 3.{newest}, and on Linux one \
             with glibc), or the package index cannot be reached"
        )
    } else if said("linker `") {
        "cargo needs a C compiler to link programs; on Debian and Ubuntu: `apt install gcc libc6-dev`".to_owned()
    } else if said("ensurepip") {
        "this Python lacks parts; on Debian and Ubuntu: `apt install python3-venv`".to_owned()
    } else if ["Connection", "connection", "timed out", "SSL", "resolution", "resolve host"].iter().any(|t| said(t)) {
        "check the network and the proxy, and start it again; what was downloaded is kept".to_owned()
    } else {
        format!("read the log `{}`", log.display())
    }
}

impl fmt::Display for InstallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy { folder, process } => {
                write!(f, "another process is installing into `{}`", folder.display())?;
                if process.is_empty() { Ok(()) } else { write!(f, " (number {process})") }
            }
            Self::ByUser { driver } => write!(f, "`{}` is not installed by ltsc", driver.name),
            Self::Cargo { driver, .. } => {
                write!(f, "no cargo was found that `{}` can be built with", driver.name)
            }
            Self::Python { driver, .. } => {
                write!(f, "no Python was found that `{}` can be installed with", driver.name)
            }
            Self::Step { driver, step, code, .. } => {
                let what = match step {
                    Step::Python => "looking for a Python",
                    Step::Environment => "making a Python environment",
                    Step::Packages => "installing the packages",
                    Step::Cargo => "looking for a cargo",
                    Step::Build => "building the sources",
                    Step::Verification => "rendering a first image",
                };
                write!(f, "{what} for `{}` failed", driver.name)?;
                match code {
                    Some(code) => write!(f, " with exit code {code}"),
                    None => Ok(()),
                }
            }
            Self::Render(error) => write!(f, "it is installed, but does not work: {error}"),
            Self::Wrong { driver, message } => {
                write!(f, "`{}` is installed, but renders wrong: {message}", driver.name)
            }
            Self::Io { path, source } => write!(f, "cannot use `{}`: {source}", path.display()),
            Self::Cancelled => write!(f, "the installation was cancelled"),
        }
    }
}

impl fmt::Debug for InstallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}\n{}\nhint: {}", self.tail().join("\n"), self.hint())
    }
}

impl std::error::Error for InstallError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Render(error) => Some(error.as_ref()),
            Self::Io { source, .. } => Some(source),
            Self::ByUser { .. }
            | Self::Cargo { .. }
            | Self::Busy { .. }
            | Self::Python { .. }
            | Self::Step { .. }
            | Self::Wrong { .. }
            | Self::Cancelled => None,
        }
    }
}
