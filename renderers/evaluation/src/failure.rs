//! How a command ends where it cannot go on, and with which exit code.

use std::io;
use std::process::ExitCode;

use ltsc_core::diag::{Finding, Origin, Severity};
use ltsc_render::run::RenderError;

/// What the process says when it ends; the numbers are part of the command line's contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Done, or the answer is yes.
    Done,
    /// The answer is no.
    No,
    /// Wrong usage.
    Usage,
    /// Input unreadable or malformed.
    Input,
    /// A renderer or the environment is missing or failed.
    Environment,
    /// A fault of ltsc.
    Fault,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

impl Exit {
    /// The number.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::No => 1,
            Self::Usage => 2,
            Self::Input => 3,
            Self::Environment => 4,
            Self::Fault => 70,
        }
    }

    /// The exit code that findings of this severity lead to.
    #[must_use]
    pub fn of(severity: Severity) -> Self {
        match severity {
            Severity::Allow | Severity::Info | Severity::Warn => Self::Done,
            Severity::Deny => Self::No,
            Severity::Error => Self::Input,
        }
    }

    /// The exit code that a finding leads to.
    #[must_use]
    pub fn of_finding(finding: &Finding) -> Self {
        if finding.id == ltsc_core::pipeline::FAULT { Self::Fault } else { Self::of(finding.severity) }
    }
}

/// What the system says, without its number.
#[must_use]
pub fn why(error: &io::Error) -> String {
    let text = error.to_string();
    let known = text.split_once(" (os error").filter(|_| error.raw_os_error().is_some());
    let plain = known.map_or(text.as_str(), |(plain, _)| plain);
    let mut chars = plain.chars();
    let first: String = chars.next().map(|first| first.to_lowercase().collect()).unwrap_or_default();
    if known.is_some() { first + chars.as_str() } else { plain.to_owned() }
}

/// A command cannot go on; the message has been written to no one yet.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What went wrong.
    pub message: String,
    /// What can be done.
    pub help: Option<String>,
}

impl Failure {
    /// A failure without advice.
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into(), help: None }
    }

    /// The same with advice.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// The same as a finding among others.
    #[must_use]
    pub fn into_finding(self) -> Finding {
        let id = if self.exit == Exit::Fault { ltsc_core::pipeline::FAULT } else { "unreadable-file" };
        Finding { help: self.help, ..Finding::error(id, Origin::Made, self.message) }
    }

    /// What becomes of a renderer that is missing or fails, with the places looked at or the end of its log.
    #[must_use]
    pub fn of_renderer(error: &RenderError) -> Self {
        let mut message = error.to_string();
        if !error.tail().is_empty() {
            let head = if matches!(error, RenderError::NotFound { .. }) { "looked at:" } else { "the end of its log:" };
            message.push('\n');
            message.push_str(head);
            for line in error.tail() {
                message.push_str("\n    ");
                message.push_str(line);
            }
        }
        Self {
            help: Some(error.hint().to_owned()).filter(|hint| !hint.is_empty()),
            ..Self::new(Exit::Environment, message)
        }
    }
}
