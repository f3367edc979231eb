//! Findings: everything ltsc has to say about an input, in one form for all stages and all outputs.
//!
//! A message is lower-case, one sentence, names in backticks, no full stop. A label says what is wrong at its place, a
//! note why (which renderer), the help what to write instead.

mod codes;
mod source;
mod words;

pub use codes::{CODES, Code};
pub use source::{FileId, Position, SourceFile, Sources};
pub use words::WORDS;

use serde::Serialize;

/// How grave a finding is, mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Switched off by the scene, the command line or the project; kept so that it can be counted.
    Allow,
    /// Worth knowing, nothing to do: for example that a transform was baked.
    Info,
    /// Should be looked at; the command goes on.
    Warn,
    /// The scene is well-formed, but the answer is no: exit code 1.
    Deny,
    /// The input is unreadable or malformed: exit code 3.
    Error,
}

/// A byte range in one text file of [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The file the range lies in.
    pub file: FileId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The range `start..end` of `file`.
    pub fn new(file: FileId, start: usize, end: usize) -> Self {
        let clamp = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        Self { file, start: clamp(start), end: clamp(end.max(start)) }
    }

    /// The smallest range that holds both; `self` where they lie in different files.
    pub fn to(self, other: Self) -> Self {
        if self.file != other.file {
            return self;
        }
        Self { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// Where a thing comes from.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Origin {
    /// A range of a text that is in [`Sources`].
    Text(Span),
    /// A place in a file that is not kept as text: a byte offset, a line, a JSON pointer.
    File {
        /// The file, as the user named it or relative to the project root.
        path: String,
        /// The place in it in words ("byte 120", "line 7", "/materials/0/name"); empty for the whole file.
        place: String,
    },
    /// Made by ltsc itself; no place in any input.
    Made,
}

impl Origin {
    /// The span, if this is one.
    pub fn span(&self) -> Option<Span> {
        match self {
            Self::Text(span) => Some(*span),
            Self::File { .. } | Self::Made => None,
        }
    }
}

impl From<Span> for Origin {
    fn from(span: Span) -> Self {
        Self::Text(span)
    }
}

/// A second place that explains a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is there.
    pub text: String,
}

/// One thing said about an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Stable code, words that read well after "allow": `smooth-emitter`.
    pub id: &'static str,
    /// How grave it is.
    pub severity: Severity,
    /// What is wrong.
    pub message: String,
    /// Where.
    pub origin: Origin,
    /// What is wrong at that place, in few words; empty for none.
    pub label: String,
    /// Further places.
    pub labels: Vec<Label>,
    /// Why it matters: which renderer does what.
    pub notes: Vec<String>,
    /// What to write instead.
    pub help: Option<String>,
    /// Why the scene wants it, where its severity is [`Severity::Allow`] by an `allow` of the scene.
    pub suppression: Option<Suppression>,
    /// Whether it proves what is to be changed, so that it may have a fix.
    pub fixable: bool,
    /// What to change, where there is one right answer.
    pub fix: Option<Fix>,
}

/// A change of texts after which a finding is gone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What it does, in the words of a help.
    pub title: String,
    /// The changes, which do not overlap.
    pub edits: Vec<Edit>,
}

/// A range of a text and what stands there afterwards.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edit {
    /// What is replaced; empty where something is put in.
    pub span: Span,
    /// What it is replaced by.
    pub text: String,
}

/// An `allow` of a scene that covers a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suppression {
    /// Where it stands.
    pub span: Span,
    /// The reason that it gives.
    pub reason: String,
}

impl Finding {
    /// A finding at `origin` without label, notes and help.
    pub fn new(id: &'static str, severity: Severity, origin: impl Into<Origin>, message: impl Into<String>) -> Self {
        Self {
            id,
            severity,
            message: message.into(),
            origin: origin.into(),
            label: String::new(),
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
            suppression: None,
            fixable: true,
            fix: None,
        }
    }

    /// A finding that the input is malformed.
    pub fn error(id: &'static str, origin: impl Into<Origin>, message: impl Into<String>) -> Self {
        Self::new(id, Severity::Error, origin, message)
    }

    /// A finding that should be looked at.
    pub fn warn(id: &'static str, origin: impl Into<Origin>, message: impl Into<String>) -> Self {
        Self::new(id, Severity::Warn, origin, message)
    }

    /// Says what is wrong at the place itself.
    #[must_use]
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.label = text.into();
        self
    }

    /// Adds a second place.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Says why.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// Says what to write instead.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// [`Finding::help`] where there is some.
    #[must_use]
    pub fn maybe_help(mut self, text: Option<String>) -> Self {
        if text.is_some() {
            self.help = text;
        }
        self
    }
}

/// The most names that a misspelt one is compared with.
const MOST_CANDIDATES: usize = 10_000;

/// The name among `known` that is nearest to `name`, if one is near enough to be meant.
///
/// Near means a Damerau-Levenshtein distance (neighboring letters swapped count one) of at most a third of the length,
/// at least 1 (a name of one letter has no typing error, only another case); ties go to the first.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().count();
    let limit = if length < 2 { 0 } else { (length / 3).max(1) };
    let lowered = |text: &str| -> String { text.chars().take(64).flat_map(char::to_lowercase).collect() };
    let lower = lowered(name);
    let mut best: Option<(usize, &'a str)> = None;
    for candidate in known.into_iter().take(MOST_CANDIDATES) {
        // The distance is at least the difference of the lengths: most candidates need no closer look.
        if candidate.chars().count().abs_diff(length) > limit {
            continue;
        }
        let away = strsim::osa_distance(&lower, &lowered(candidate));
        if away <= limit && best.is_none_or(|(least, _)| away < least) {
            best = Some((away, candidate));
        }
    }
    best.map(|(_, found)| found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_finds_typing_errors_only() {
        let known = ["diffuse", "conductor", "dielectric", "mirror"];
        assert_eq!(nearest("difuse", known), Some("diffuse"));
        assert_eq!(nearest("mirorr", known), Some("mirror"));
        assert_eq!(nearest("Mirror", known), Some("mirror"));
        assert_eq!(nearest("plastic", known), None);
        assert_eq!(nearest("", known), None);
        assert_eq!((nearest("a", ["X", "A"]), nearest("q", ["X", "A"])), (Some("A"), None));
    }

    #[test]
    fn severities_are_ordered() {
        assert!(
            Severity::Error > Severity::Deny && Severity::Deny > Severity::Warn && Severity::Info > Severity::Allow
        );
    }
}
