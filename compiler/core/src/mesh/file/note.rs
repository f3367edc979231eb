//! What a reader has to say about a mesh file that it read: what was left out, what was changed.

use std::collections::BTreeMap;

use super::plural;
use crate::diag::Severity;

/// What became of what a note is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// Left out; the finding `loss-dropped`.
    Dropped,
    /// Read as something that is near it: `loss-approximated`.
    Approximated,
    /// Computed by the reader, with the same image: `loss-baked`.
    Baked,
    /// Read, although something is odd: `mesh-file`.
    Odd,
    /// Normals of another length than 1, which other programs may read otherwise: the rule `non-unit-normals`.
    Lengths,
}

impl Fate {
    /// The code of the finding.
    pub fn code(self) -> &'static str {
        match self {
            Self::Dropped => "loss-dropped",
            Self::Approximated => "loss-approximated",
            Self::Baked => "loss-baked",
            Self::Odd => "mesh-file",
            Self::Lengths => "non-unit-normals",
        }
    }
}

const MATERIALS: &str = "materials are not read";

/// Something to know about a mesh file that was read.
///
/// Each note becomes a finding. Notes that say the same of several places are one, with the first place and the sum of their
/// counts, so that a file gives one finding for each kind of thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// What became of it.
    pub fate: Fate,
    /// `Warn` where it may change the image, `Info` where it does not.
    pub severity: Severity,
    /// What happened; lower-case, one sentence.
    pub message: String,
    /// Where first: `line 7`, `byte 120`, `/meshes/0`; empty for the whole file.
    pub place: String,
    /// What to do about it.
    pub help: Option<String>,
    /// How many of what, and what stands behind that in the message.
    tally: Option<(u64, &'static str, String)>,
}

impl Note {
    fn new(fate: Fate, severity: Severity, place: impl Into<String>, message: impl Into<String>) -> Self {
        Self { fate, severity, message: message.into(), place: place.into(), help: None, tally: None }
    }

    /// Whether it says that materials of the file are not read.
    pub fn is_of_materials(&self) -> bool {
        self.fate == Fate::Dropped && self.message.starts_with(MATERIALS)
    }

    /// Materials of the file that are not read.
    pub(super) fn materials(place: impl Into<String>, why: &str) -> Self {
        Self::dropped(place, format!("{MATERIALS}: {why}"))
    }

    /// Something was left out that may be seen in an image; with [`Note::slight`] something that is not.
    pub(super) fn dropped(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Dropped, Severity::Warn, place, message)
    }

    /// Something was read as what is near it. The message has the bound.
    pub(super) fn approximated(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Approximated, Severity::Info, place, message)
    }

    /// Something was computed that the file leaves open, or says otherwise.
    pub(super) fn baked(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Baked, Severity::Info, place, message)
    }

    /// Something is odd and should be looked at.
    pub(super) fn warn(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Odd, Severity::Warn, place, message)
    }

    /// Something is odd and has no consequence.
    pub(super) fn info(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Odd, Severity::Info, place, message)
    }

    /// Normals were brought to unit length.
    pub(super) fn lengths(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::new(Fate::Lengths, Severity::Warn, place, message)
    }

    /// What no image shows: a remark, which people see where they ask for it.
    #[must_use]
    pub(super) fn slight(mut self) -> Self {
        self.severity = Severity::Info;
        self
    }

    /// What is seen in an image: a warning.
    #[must_use]
    pub(super) fn grave(mut self) -> Self {
        self.severity = Severity::Warn;
        self
    }

    /// Puts `3 faces` before the message. The counts of notes that are equal otherwise are added up.
    #[must_use]
    pub(super) fn counting(mut self, count: u64, what: &'static str) -> Self {
        let rest = std::mem::take(&mut self.message);
        self.message = format!("{} {rest}", plural(count, what));
        self.tally = Some((count, what, rest));
        self
    }

    #[must_use]
    pub(super) fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

/// The notes, those that say the same made one, in the order in which they come first.
pub(super) fn merged(notes: Vec<Note>) -> Vec<Note> {
    let mut all: Vec<Note> = Vec::new();
    let mut known: BTreeMap<(Fate, Severity, &'static str, String), usize> = BTreeMap::new();
    for note in notes {
        let (what, said) = match &note.tally {
            Some((_, what, rest)) => (*what, rest.clone()),
            None => ("", note.message.clone()),
        };
        let at = *known.entry((note.fate, note.severity, what, said)).or_insert(all.len());
        let Some(first) = all.get_mut(at) else {
            all.push(note);
            continue;
        };
        if let (Some((sum, what, rest)), Some((count, ..))) = (&mut first.tally, &note.tally) {
            *sum = sum.saturating_add(*count);
            first.message = format!("{} {rest}", plural(*sum, what));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_that_say_the_same_are_one() {
        let faces = |place: &str, count| Note::dropped(place, "left out").counting(count, "face");
        let colors = |place: &str| Note::dropped(place, "vertex colors are not read");
        let notes =
            vec![colors("line 1"), faces("line 2", 1), colors("line 3"), faces("line 4", 2), faces("", 5).slight()];
        let said: Vec<(String, String)> = merged(notes).into_iter().map(|note| (note.place, note.message)).collect();
        let expected =
            [("line 1", "vertex colors are not read"), ("line 2", "3 faces left out"), ("", "5 faces left out")];
        assert_eq!(said, expected.map(|(place, message)| (place.to_owned(), message.to_owned())));
    }
}
