//! What of a scene is not written, or not as it is: findings.

use crate::diag::{Finding, Origin, Severity};

/// The findings so far.
#[derive(Debug, Default)]
pub(super) struct Notes {
    pub findings: Vec<Finding>,
}

impl Notes {
    /// Something is left out.
    pub fn dropped(&mut self, at: &Origin, message: impl Into<String>) {
        self.findings.push(Finding::new("loss-dropped", Severity::Warn, at.clone(), message));
    }

    /// Something is written as what is nearest.
    pub fn changed(&mut self, at: &Origin, message: impl Into<String>) {
        self.findings.push(Finding::new("loss-approximated", Severity::Warn, at.clone(), message));
    }

    /// Something keeps its meaning and not its form.
    pub fn baked(&mut self, at: &Origin, message: impl Into<String>) {
        self.findings.push(Finding::new("loss-baked", Severity::Info, at.clone(), message));
    }

    /// A name that is taken or cannot be written; says nothing of one that stays.
    pub fn named(&mut self, at: &Origin, what: &str, name: &str, written: &str) {
        if name != written {
            let message = format!("the {what} `{}` is called `{written}` in the text", name.escape_debug());
            self.findings.push(Finding::new("print-renamed", Severity::Info, at.clone(), message));
        }
    }

    /// `value` where the language has it, else the nearest number that it has.
    pub fn within(&mut self, at: &Origin, what: &str, value: f64, least: f64, most: f64) -> f64 {
        if (least..=most).contains(&value) {
            return value;
        }
        let near = if value > most { most } else { least };
        let range = match (least, most) {
            (f64::MIN, f64::MAX) => "finite numbers".to_owned(),
            (least, f64::MAX) => format!("{least:?} and more"),
            (least, most) => format!("{least:?} to {most:?}"),
        };
        let message = format!("{what} is {value:?}, and {near:?} is written: the language has {range} there");
        self.changed(at, message);
        near
    }

    /// The same for a vector, of whose numbers only those that are not finite are refused.
    pub fn finite<const N: usize>(&mut self, at: &Origin, what: &str, value: [f64; N]) -> [f64; N] {
        value.map(|part| self.within(at, what, part, f64::MIN, f64::MAX))
    }
}
