//! The evaluation file: which scenes are rendered by which renderers with which settings, and what is compared with what.
//!
//! Reading order: `model` (what an evaluation is), `written` (what a file says), `read` with `reader`, `parts`, `statement` and `sweep`
//! (text to what it says), `resolve` with `renderer`, `translate` and `compare` (names looked up, everything multiplied out),
//! `command` (programs without a driver), `print` (text again), `lteval` with `python` (configurations of the thesis's tool).
//! Nothing is read or rendered here: what else must be known is asked of [`Surroundings`].

pub mod command;
mod compare;
pub mod lteval;
pub mod model;
mod parts;
mod print;
mod python;
mod read;
mod reader;
mod renderer;
mod resolve;
mod statement;
mod surroundings;
mod sweep;
mod translate;
pub mod written;

#[cfg(test)]
mod lteval_tests;
#[cfg(test)]
mod print_tests;
#[cfg(test)]
mod tests;

use ltsc_core::diag::{FileId, Finding, Severity};

pub use model::Evaluation;
pub use parts::duration;
pub use print::print;
pub use read::read;
pub use resolve::{CHUNKS, LEAST_CHUNKS, resolve};
pub use surroundings::{Surroundings, Unknown};

/// Reads and resolves the text of a file whose name has the stem `stem`. There is an evaluation only if nothing is wrong; all
/// findings come at once, in the order of the text.
#[must_use]
pub fn load(
    file: FileId,
    text: &str,
    stem: &str,
    surroundings: &dyn Surroundings,
) -> (Option<Evaluation>, Vec<Finding>) {
    let (written, mut findings) = read(file, text);
    // What is no TOML has lost some of its keys: nothing is said of those that seem to be missing.
    let syntax = |finding: &Finding| finding.id == "evaluation-syntax";
    if findings.iter().any(syntax) {
        findings.retain(syntax);
        findings.sort_by_key(|finding| finding.origin.span());
        return (None, findings);
    }
    let whole = findings.iter().all(|finding| finding.severity != Severity::Error);
    let (evaluation, more) = resolve(&written, file, stem, surroundings, whole);
    findings.extend(more);
    findings.sort_by_key(|finding| finding.origin.span());
    let fine = findings.iter().all(|finding| finding.severity != Severity::Error);
    (evaluation.filter(|_| fine), findings)
}
