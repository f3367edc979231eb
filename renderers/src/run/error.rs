//! Why a renderer gave no image.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::Duration;

use super::{Driver, process};
use crate::image::ImageError;

/// Lines of the log that an error carries.
pub(super) const TAIL: usize = 20;
/// Lines in which a known cause is looked for: it may stand before a long traceback, and lines of
/// standard output reach the log later than those of standard error.
pub(super) const CAUSES: usize = 500;

/// Why a renderer gave no image. Those that it caused itself carry the end of its log.
#[derive(Debug)]
pub enum RenderError {
    /// No executable was found.
    NotFound {
        /// Name of the driver.
        driver: &'static str,
        /// Where it was looked for, and what was wrong there.
        looked: Vec<String>,
    },
    /// The request cannot be carried out as it is.
    Request {
        /// What is wrong.
        message: String,
        /// What may help.
        hint: String,
    },
    /// The system could not start the program, or a file could not be written.
    Io {
        /// The program or file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The program ended with an error.
    Failed(Box<Failure>),
    /// The program took too long and was killed, with everything it had started.
    TimedOut {
        /// Name of the driver.
        driver: &'static str,
        /// The time that it had.
        after: Duration,
        /// The end of the log.
        tail: Vec<String>,
        /// The whole log.
        log: PathBuf,
    },
    /// The caller took the request back.
    Cancelled,
    /// The program ended well, but its image is missing or of another size than the scene says.
    NoImage {
        /// Name of the driver.
        driver: &'static str,
        /// What is wrong.
        message: String,
        /// The end of the log.
        tail: Vec<String>,
        /// The whole log.
        log: PathBuf,
    },
    /// The image of the renderer cannot be read.
    Image(ImageError),
}

/// How a program failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Name of the driver.
    pub driver: &'static str,
    /// Exit code; nothing if a signal ended it.
    pub code: Option<i32>,
    /// The signal that ended it (Unix).
    pub signal: Option<i32>,
    /// What the renderer says is wrong, if it says so.
    pub message: Option<String>,
    /// What may help.
    pub hint: String,
    /// The end of the log.
    pub tail: Vec<String>,
    /// The whole log.
    pub log: PathBuf,
}

impl RenderError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::NotFound { driver, .. } => super::driver(driver).map_or_else(String::new, Driver::advice),
            Self::Request { hint, .. } => hint.clone(),
            Self::Failed(failure) => failure.hint.clone(),
            Self::Io { .. } => "check the name, the permissions and the free space".to_owned(),
            Self::TimedOut { .. } => "allow more time, take fewer samples or a smaller image".to_owned(),
            Self::Cancelled => "start it again; finished parts are kept".to_owned(),
            Self::NoImage { log, .. } => format!("read the log `{}`", log.display()),
            Self::Image(error) => error.hint(),
        }
    }

    /// The end of the renderer's log, if it ran.
    #[must_use]
    pub fn tail(&self) -> &[String] {
        match self {
            Self::Failed(failure) => &failure.tail,
            Self::TimedOut { tail, .. } | Self::NoImage { tail, .. } => tail,
            Self::NotFound { looked, .. } => looked,
            Self::Request { .. } | Self::Io { .. } | Self::Cancelled | Self::Image(_) => &[],
        }
    }

    /// A failure, explained by the first of the driver's hints whose text the message or the log
    /// holds.
    pub(super) fn failed(
        driver: &'static str,
        hints: &[(&str, &str)],
        status: ExitStatus,
        message: Option<String>,
        log: &Path,
    ) -> Self {
        let tail = process::tail(log, TAIL);
        let signal = signal(status);
        let lines = process::tail(log, CAUSES);
        let said = |text: &str| message.iter().chain(&lines).any(|line| line.contains(text));
        let known = hints.iter().find(|(text, _)| said(text)).map(|&(_, hint)| hint.to_owned());
        let hint = known.unwrap_or_else(|| match signal {
            // What the Linux kernel sends to a program when memory is short.
            Some(9) => "it was killed, most likely for want of memory".to_owned(),
            _ => format!("read the log `{}`", log.display()),
        });
        let (code, log) = (status.code(), log.to_owned());
        Self::Failed(Box::new(Failure { driver, code, signal, message, hint, tail, log }))
    }
}

#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal(_: ExitStatus) -> Option<i32> {
    None
}

impl From<ImageError> for RenderError {
    fn from(error: ImageError) -> Self {
        Self::Image(error)
    }
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFound { driver, .. } => write!(f, "no working `{driver}` was found"),
            Self::Request { message, .. } => f.write_str(message),
            Self::Io { path, source } => write!(f, "cannot use `{}`: {source}", path.display()),
            Self::Failed(failure) => {
                let Failure { driver, code, signal, message, .. } = failure.as_ref();
                match (code, signal) {
                    (_, Some(signal)) => write!(f, "`{driver}` was ended by signal {signal}")?,
                    // It tells a failure in words only.
                    (Some(0), None) => write!(f, "`{driver}` failed")?,
                    (Some(code), None) => write!(f, "`{driver}` failed with exit code {code}")?,
                    (None, None) => write!(f, "`{driver}` failed")?,
                }
                match message {
                    Some(message) => write!(f, ": {}", message.trim()),
                    None => Ok(()),
                }
            }
            Self::TimedOut { driver, after, .. } => {
                write!(f, "`{driver}` took more than {} s and was stopped", after.as_secs_f64())
            }
            Self::Cancelled => write!(f, "the rendering was cancelled"),
            Self::NoImage { driver, message, .. } => write!(f, "`{driver}` {message}"),
            Self::Image(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RenderError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { source, .. } => Some(source),
            Self::Image(error) => Some(error),
            Self::NotFound { .. }
            | Self::Request { .. }
            | Self::Failed(_)
            | Self::TimedOut { .. }
            | Self::Cancelled
            | Self::NoImage { .. } => None,
        }
    }
}
