//! Exit codes, and findings as people and programs read them.

use std::io::Write;
use std::process::ExitCode;

use ltsc_core::diag::{Finding, Origin, Severity, Sources, Span};
use serde_json::{Value, json};

use crate::args::Format;
use crate::terminal;

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
        Self::from(match exit {
            Exit::Done => 0,
            Exit::No => 1,
            Exit::Usage => 2,
            Exit::Input => 3,
            Exit::Environment => 4,
            Exit::Fault => 70,
        })
    }
}

impl Exit {
    /// The exit code that findings of this severity lead to.
    pub fn of(severity: Severity) -> Self {
        match severity {
            Severity::Allow | Severity::Info | Severity::Warn => Self::Done,
            Severity::Deny => Self::No,
            Severity::Error => Self::Input,
        }
    }
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

    /// One document for programs.
    pub fn json(&self) -> String {
        format!("{:#}\n", json!({ "error": { "message": self.message, "help": self.help } }))
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

/// A finding with the text that its spans lie in.
pub struct Located<'s> {
    pub finding: Finding,
    pub sources: &'s Sources,
}

impl Located<'_> {
    /// Path, line and column; zeros where there is no such thing.
    fn place(&self) -> (String, usize, usize) {
        match &self.finding.origin {
            Origin::Text(span) => {
                let at = self.sources.position(span.file, span.start);
                (self.sources.get(span.file).path.clone(), at.line, at.column)
            }
            Origin::File { path, .. } => (path.clone(), 0, 0),
            Origin::Made => (String::new(), 0, 0),
        }
    }

    /// What makes two findings the same: a library's is found once for each scene that uses it.
    pub fn key(&self) -> (String, usize, usize, &'static str, String) {
        let (path, line, column) = self.place();
        (path, line, column, self.finding.id, self.finding.message.clone())
    }

    fn short(&self) -> String {
        let (path, line, column) = self.place();
        let place = match (path.as_str(), line) {
            ("", _) => String::new(),
            (path, 0) => format!("{path}: "),
            (path, line) => format!("{path}:{line}:{column}: "),
        };
        let Finding { id, severity, message, .. } = &self.finding;
        let line = format!("{place}{}[{id}]: {message}", severity_word(*severity));
        terminal::harmless(&line).replace('\n', " ")
    }

    fn span_json(&self, span: Span) -> Value {
        let (from, to) = (self.sources.position(span.file, span.start), self.sources.position(span.file, span.end));
        json!({
            "path": self.sources.get(span.file).path,
            "line": from.line, "column": from.column, "end_line": to.line, "end_column": to.column,
        })
    }

    /// The stable JSON form.
    pub fn json(&self) -> Value {
        let Finding { id, severity, message, origin, label, labels, notes, help } = &self.finding;
        let place = match origin {
            Origin::Text(span) => self.span_json(*span),
            Origin::File { path, place } => json!({ "path": path, "place": place }),
            Origin::Made => Value::Null,
        };
        let labels: Vec<Value> =
            labels.iter().map(|label| json!({ "place": self.span_json(label.span), "text": label.text })).collect();
        json!({
            "id": id, "severity": severity, "message": message, "place": place, "label": label,
            "labels": labels, "notes": notes, "help": help,
        })
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
/// standard output. Findings that are allowed, and remarks where `quiet`, are not shown to people.
pub fn findings(all: &[Located<'_>], format: Format, to_stdout: bool, quiet: bool) {
    let least = if quiet { Severity::Warn } else { Severity::Info };
    match format {
        Format::Json => {
            let counts = Counts::of(all.iter().map(|located| &located.finding));
            let list: Vec<Value> = all.iter().map(Located::json).collect();
            let document = json!({
                "findings": list,
                "counts": { "errors": counts.errors, "warnings": counts.warnings, "allowed": counts.allowed },
            });
            terminal::print(&format!("{document:#}\n"));
        }
        Format::Short | Format::Human => {
            let mut text = String::new();
            for located in all.iter().filter(|located| located.finding.severity >= least) {
                if format == Format::Short {
                    text.push_str(&located.short());
                    text.push('\n');
                } else {
                    text.push_str(&terminal::graphical(&located.finding, located.sources, to_stdout));
                }
            }
            if to_stdout {
                terminal::print(&text);
            } else {
                let _written = std::io::stderr().write_all(text.as_bytes());
            }
        }
    }
}
