//! Exit codes, and findings as people and programs read them.

mod github;
mod located;
mod sarif;

use std::io::Write;

use ltsc_core::diag::{Finding, Severity};
pub use ltsc_evaluation::failure::{Exit, Failure, why};
use serde_json::{Value, json};

use crate::args::Format;
use crate::terminal;

pub use located::Located;

/// What programs read in place of the answer; nothing for forms that people read.
pub fn print_failure(failure: &Failure, format: Format) {
    match format {
        Format::Json => {
            let document = json!({ "error": { "message": failure.message, "help": failure.help } });
            terminal::print(&format!("{document:#}\n"));
        }
        Format::Sarif => terminal::print(&format!("{:#}\n", sarif::failure(failure))),
        Format::Github => terminal::print(&github::failure(failure)),
        Format::Human | Format::Short => {}
    }
}

/// Says what went wrong and gives the exit code.
pub fn show(failure: &Failure) -> Exit {
    terminal::error(&failure.message);
    if let Some(help) = &failure.help {
        terminal::help(help);
    }
    failure.exit
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
