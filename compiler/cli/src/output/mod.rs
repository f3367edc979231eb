//! Exit codes, and findings as people and programs read them.

mod github;
mod located;
mod sarif;

use std::io::{self, Write};
use std::process::ExitCode;

use ltsc_core::diag::{Finding, Origin, Severity};
use serde_json::{Value, json};

use crate::args::Format;
use crate::terminal;

pub use located::Located;

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
    pub fn of(severity: Severity) -> Self {
        match severity {
            Severity::Allow | Severity::Info | Severity::Warn => Self::Done,
            Severity::Deny => Self::No,
            Severity::Error => Self::Input,
        }
    }

    /// The exit code that a finding leads to.
    pub fn of_finding(finding: &Finding) -> Self {
        if finding.id == ltsc_core::pipeline::FAULT { Self::Fault } else { Self::of(finding.severity) }
    }
}

/// What the system says, without its number.
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
    pub exit: Exit,
    pub message: String,
    pub help: Option<String>,
}

impl Failure {
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into(), help: None }
    }

    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// The same as a finding among others.
    pub fn into_finding(self) -> Finding {
        let id = if self.exit == Exit::Fault { ltsc_core::pipeline::FAULT } else { "unreadable-file" };
        Finding { help: self.help, ..Finding::error(id, Origin::Made, self.message) }
    }

    /// What programs read in place of the answer; nothing for forms that people read.
    pub fn print(&self, format: Format) {
        match format {
            Format::Json => {
                let document = json!({ "error": { "message": self.message, "help": self.help } });
                terminal::print(&format!("{document:#}\n"));
            }
            Format::Sarif => terminal::print(&format!("{:#}\n", sarif::failure(self))),
            Format::Github => terminal::print(&github::failure(self)),
            Format::Human | Format::Short => {}
        }
    }

    /// Says what went wrong and gives the exit code.
    pub fn show(&self) -> Exit {
        terminal::error(&self.message);
        if let Some(help) = &self.help {
            terminal::help(help);
        }
        self.exit
    }
}

/// "error" for what ends with an exit code of its own, "warning" and "info" for the rest.
pub fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error | Severity::Deny => "error",
        Severity::Warn => "warning",
        Severity::Info => "info",
        Severity::Allow => "allowed",
    }
}

/// How many findings of each kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    pub errors: usize,
    pub warnings: usize,
    pub allowed: usize,
}

impl Counts {
    pub fn of<'f>(findings: impl Iterator<Item = &'f Finding>) -> Self {
        let mut counts = Self::default();
        for finding in findings {
            match finding.severity {
                Severity::Error | Severity::Deny => counts.errors += 1,
                Severity::Warn => counts.warnings += 1,
                Severity::Allow => counts.allowed += 1,
                Severity::Info => {}
            }
        }
        counts
    }

    /// "2 errors, 1 warning", with what was allowed.
    pub fn words(&self) -> String {
        let one = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        let mut text = format!("{}, {}", one(self.errors, "error"), one(self.warnings, "warning"));
        if self.allowed > 0 {
            text.push_str(&format!(", {} allowed", self.allowed));
        }
        text
    }
}

/// Prints findings. People's forms go to standard error for commands whose output is something else, programs' to
/// standard output. Findings that are allowed, and remarks where `quiet`, are not shown to people. `fixed` is what became of a
/// command that mends ([`Located::fixed_json`]).
pub fn findings(all: &[Located<'_>], fixed: Option<&[Value]>, format: Format, to_stdout: bool, quiet: bool) {
    let least = if quiet { Severity::Warn } else { Severity::Info };
    let shown = all.iter().filter(|located| located.finding.severity >= least);
    match format {
        Format::Json => {
            let counts = Counts::of(all.iter().map(|located| &located.finding));
            let list: Vec<Value> = all.iter().map(Located::json).collect();
            let mut document = json!({
                "findings": list,
                "counts": { "errors": counts.errors, "warnings": counts.warnings, "allowed": counts.allowed },
            });
            if let Some(fixed) = fixed {
                document["fixed"] = fixed.into();
            }
            terminal::print(&format!("{document:#}\n"));
        }
        Format::Sarif => terminal::print(&format!("{:#}\n", sarif::document(all))),
        Format::Github => terminal::print(&shown.map(github::line).collect::<String>()),
        Format::Short => people(&shown.map(|located| located.short() + "\n").collect::<String>(), to_stdout),
        Format::Human => {
            let graphical = |located: &Located<'_>| terminal::graphical(&located.finding, located.sources, to_stdout);
            people(&shown.map(graphical).collect::<String>(), to_stdout);
        }
    }
}

fn people(text: &str, to_stdout: bool) {
    if to_stdout {
        terminal::print(text);
    } else {
        let _written = std::io::stderr().write_all(text.as_bytes());
    }
}
