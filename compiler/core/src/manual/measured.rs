//! By what the answers of targets were measured, as pages and `ltsc explain` say it. Who measures stands outside of the core; it
//! hands over the words.

use std::collections::BTreeMap;

use crate::capability::Feature;

/// One thing that shows whether an answer is true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proof {
    /// Its name: a convention, a section of a page, a test.
    pub name: String,
    /// Where it is shown, seen from the folder of the manual; empty where no page shows it.
    pub link: String,
    /// With what: `luxcore 2.11.2`; empty where the name says it all.
    pub with: String,
}

impl Proof {
    /// As text: `mirror (luxcore 2.11.2)`.
    #[must_use]
    pub fn text(&self) -> String {
        if self.with.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.with) }
    }

    /// As Markdown, with its link.
    #[must_use]
    pub fn markdown(&self) -> String {
        let name = if self.link.is_empty() { self.name.clone() } else { format!("[{}]({})", self.name, self.link) };
        if self.with.is_empty() { name } else { format!("{name} ({})", self.with) }
    }
}

/// What was measured of each target's answers.
#[derive(Clone, Debug, Default)]
pub struct Measured(BTreeMap<(String, Feature), Vec<Proof>>);

impl Measured {
    /// Notes a proof of what `target` answers to `feature`.
    pub fn add(&mut self, target: &str, feature: Feature, proof: Proof) {
        self.0.entry((target.to_owned(), feature)).or_default().push(proof);
    }

    /// What shows that the answer of `target` to `feature` is true; nothing where it was not measured.
    #[must_use]
    pub fn of(&self, target: &str, feature: Feature) -> &[Proof] {
        self.0.get(&(target.to_owned(), feature)).map_or(&[], Vec::as_slice)
    }
}
