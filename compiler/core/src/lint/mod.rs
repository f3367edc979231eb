//! Portability rules: what renderers agree on, and where a scene leaves that ground. Lint only judges a Scene.
//!
//! A rule is a file with its page (`DOC`), and a line in [`RULES`].

mod missing_normals;
mod rough_too_small;
mod smooth_emitter;
mod undocumented_scene;

use std::collections::BTreeMap;

use crate::diag::{Finding, Origin, Severity};
use crate::ir::Scene;

/// What happens to the findings of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// They are dropped.
    Allow,
    /// They are shown.
    Warn,
    /// They are shown and make the answer no.
    Deny,
}

impl Level {
    /// The level called `word`.
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "allow" => Some(Self::Allow),
            "warn" => Some(Self::Warn),
            "deny" => Some(Self::Deny),
            _ => None,
        }
    }

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Self::Allow => "allow",
            Self::Warn => "warn",
            Self::Deny => "deny",
        }
    }

    fn severity(self) -> Severity {
        match self {
            Self::Allow => Severity::Allow,
            Self::Warn => Severity::Warn,
            Self::Deny => Severity::Deny,
        }
    }
}

/// A rule.
pub struct Rule {
    /// Its code, which reads well after "allow".
    pub id: &'static str,
    /// Its level unless the project or the command line says otherwise.
    pub level: Level,
    /// One sentence.
    pub summary: &'static str,
    /// Its page in Markdown: what, why with the renderer and source, bad, good, targets.
    pub doc: &'static str,
    /// Looks at a scene.
    check: fn(&Scene, &mut Report),
}

/// All rules, by name.
pub static RULES: &[Rule] =
    &[missing_normals::RULE, rough_too_small::RULE, smooth_emitter::RULE, undocumented_scene::RULE];

/// Levels that differ from the built-in ones, by code.
pub type Levels = BTreeMap<String, Level>;

/// Where a rule puts what it finds.
struct Report {
    id: &'static str,
    severity: Severity,
    findings: Vec<Finding>,
}

impl Report {
    /// Adds a finding of the rule at `origin`, and gives it back for label, notes and help.
    fn add(&mut self, origin: &Origin, message: String, label: &str, note: &str, help: String) {
        let finding = Finding::new(self.id, self.severity, origin.clone(), message).label(label).note(note).help(help);
        self.findings.push(finding);
    }
}

/// The rule called `id`.
pub fn find(id: &str) -> Option<&'static Rule> {
    RULES.iter().find(|rule| rule.id == id)
}

/// What the rules find in `scene`, in the order of its text.
pub fn lint(scene: &Scene, levels: &Levels) -> Vec<Finding> {
    let mut findings = Vec::new();
    for rule in RULES {
        let level = levels.get(rule.id).copied().unwrap_or(rule.level);
        if level == Level::Allow {
            continue;
        }
        let mut report = Report { id: rule.id, severity: level.severity(), findings: Vec::new() };
        (rule.check)(scene, &mut report);
        findings.extend(report.findings);
    }
    findings.sort_by_key(|finding| finding.origin.span());
    findings
}
