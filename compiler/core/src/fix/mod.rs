//! Fixes: what to write where a finding has one right answer, as edits of the text.
//!
//! [`propose`] gives findings their fixes, one function of `makers` for each code; [`apply`] writes those that do not get in each
//! other's way. A fix changes nothing but its own place: the rest of the file stays as it is to the byte. It changes what a scene means only
//! where the finding proves that the scene does not mean what it says; else the finding says that it is not fixable.

mod makers;
mod tree;

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use crate::diag::{Edit, FileId, Finding, Fix, Severity, Sources, Span};
use crate::syntax::{self, Tree};

/// What the maker of a fix sees.
struct Place<'a> {
    /// The finding's place.
    span: Span,
    /// The text of its file.
    text: &'a str,
    /// The file's statements, once they were asked for.
    parsed: &'a OnceCell<Tree>,
}

impl Place<'_> {
    /// The file's statements.
    fn tree(&self) -> &Tree {
        self.parsed.get_or_init(|| syntax::parse(self.span.file, self.text).0)
    }

    /// The text of a range.
    fn text_of(&self, span: Span) -> &str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// The range `start..end` of the file.
    fn range(&self, start: usize, end: usize) -> Span {
        Span::new(self.span.file, start, end)
    }
}

type Maker = fn(&Place<'_>) -> Option<Fix>;

/// The codes that have fixes, by name.
const MAKERS: &[(&str, Maker)] = &[
    ("emitter-facing-away", makers::turn_emitter),
    ("inside-out-mesh", makers::flip_mesh),
    ("misplaced-mesh", makers::center_mesh),
    ("missing-version", makers::add_version),
    ("reversed-range", makers::swap_interval),
    ("smooth-emitter", makers::facet_emitter),
    ("unused-allow", makers::remove_allow),
    ("unused-name", makers::remove_used_name),
];

/// The codes of findings that may have a fix.
pub fn codes() -> impl Iterator<Item = &'static str> {
    MAKERS.iter().map(|(id, _)| *id)
}

/// Gives findings in texts their fixes.
pub fn propose(findings: &mut [Finding], sources: &Sources) {
    let mut trees: BTreeMap<FileId, OnceCell<Tree>> = BTreeMap::new();
    for finding in findings.iter_mut().filter(|finding| finding.fixable && finding.severity > Severity::Allow) {
        let Some((_, maker)) = MAKERS.iter().find(|(id, _)| *id == finding.id) else { continue };
        let Some(span) = finding.origin.span() else { continue };
        let text: &str = &sources.get(span.file).text;
        let parsed = trees.entry(span.file).or_default();
        finding.fix = maker(&Place { span, text, parsed });
    }
}

/// What became of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Applied {
    /// The text with the edits.
    pub text: String,
    /// Which fixes are in it, counted from 0 in the order in which they were given.
    pub made: Vec<usize>,
}

/// Writes fixes into the text of `file`, in their order; one that touches what another changes waits for the next round, and one
/// that reaches into another file is left out. Two that are equal are one.
pub fn apply<'f>(text: &str, file: FileId, fixes: impl Iterator<Item = &'f Fix>) -> Applied {
    // By their starts; no two of them touch.
    let mut taken: BTreeMap<u32, &Edit> = BTreeMap::new();
    let mut made = Vec::new();
    let mut seen = BTreeSet::new();
    for (number, fix) in fixes.enumerate() {
        let here = fix.edits.iter().all(|edit| edit.span.file == file && edit.span.end as usize <= text.len());
        // What touches may need a separator that neither has.
        let clear = |edit: &Edit| {
            taken.range(..=edit.span.end).next_back().is_none_or(|(_, last)| last.span.end < edit.span.start)
        };
        if !here || fix.edits.is_empty() || !fix.edits.iter().all(clear) || !seen.insert(&fix.edits) {
            continue;
        }
        taken.extend(fix.edits.iter().map(|edit| (edit.span.start, edit)));
        made.push(number);
    }
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in taken.into_values() {
        out.push_str(text.get(at..edit.span.start as usize).unwrap_or_default());
        out.push_str(&edit.text);
        at = edit.span.end as usize;
    }
    out.push_str(text.get(at..).unwrap_or_default());
    Applied { text: out, made }
}

#[cfg(test)]
mod tests;
