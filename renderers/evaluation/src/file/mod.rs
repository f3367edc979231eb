//! The evaluation file: which scenes are rendered by which renderers with which settings, and what is compared with what.
//!
//! Reading order: `model` (what an evaluation is), `written` (what a file says), `read` with `reader`, `parts`, `statement` and `sweep`
//! (text to what it says), `resolve` with `renderer`, `translate` and `compare` (names looked up, everything multiplied out),
//! `print` (text again), `lteval` with `python` (configurations of the thesis's tool).
//! Nothing is read or rendered here: what else must be known is asked of [`Surroundings`].

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
#[cfg(test)]
mod wrong_tests;

use ltsc_core::diag::{FileId, Finding, Severity, Span};

pub use model::Evaluation;
pub use parts::duration;
pub use print::print;
pub use read::read;
pub use resolve::{LEAST_CHUNKS, resolve};
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
    load_swept(file, text, stem, &[], surroundings)
}

/// The same with sweeps that are not in the file: each a parameter of all scenes with its values, as texts of expressions. They take the
/// place of the file's own sweeps over that parameter.
#[must_use]
pub fn load_swept(
    file: FileId,
    text: &str,
    stem: &str,
    sweeps: &[(String, Vec<String>)],
    surroundings: &dyn Surroundings,
) -> (Option<Evaluation>, Vec<Finding>) {
    let (mut written, mut findings) = read(file, text);
    // What is no TOML has lost some of its keys: nothing is said of those that seem to be missing.
    let syntax = |finding: &Finding| finding.id == "evaluation-syntax";
    if findings.iter().any(syntax) {
        findings.retain(syntax);
        findings.sort_by_key(|finding| finding.origin.span());
        return (None, findings);
    }
    let start = Span::new(file, 0, 0);
    for (parameter, values) in sweeps {
        written.sweeps.retain(|sweep| sweep.parameter.value != *parameter);
        let parameter = model::At::new(parameter.clone(), start);
        written.sweeps.push(written::WrittenSweep { parameter, scenes: None, values: values.clone(), span: start });
    }
    let whole = findings.iter().all(|finding| finding.severity != Severity::Error);
    let (evaluation, more) = resolve(&written, file, stem, surroundings, whole);
    findings.extend(more);
    findings.sort_by_key(|finding| finding.origin.span());
    let fine = findings.iter().all(|finding| finding.severity != Severity::Error);
    (evaluation.filter(|_| fine), findings)
}
