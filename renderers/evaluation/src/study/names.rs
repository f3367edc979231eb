//! Names of files for conditions and runs: readable, allowed on all systems, and never twice.

use std::collections::BTreeSet;

use crate::file::Evaluation;

/// Names of devices that no file of Windows may have.
const DEVICES: &[&str] = &["con", "prn", "aux", "nul"];

/// The longest part of a name that is kept, in bytes.
const LONGEST: usize = 100;

/// Gives each text a name of its own.
#[derive(Default)]
pub struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// A name like `text`. Two texts that differ in letters' case or in what no file name may have get a number at the end.
    pub fn of(&mut self, text: &str) -> String {
        let plain = allowed(text);
        let mut name = plain.clone();
        let mut number = 2;
        // Systems that take no notice of case must not see one file twice.
        while !self.taken.insert(name.to_lowercase()) {
            name = format!("{plain} {number}");
            number += 1;
        }
        name
    }
}

/// Names of all conditions and runs of an evaluation, given in the order of its file, so that results and what is made by hand have the
/// same.
pub(super) struct Places {
    /// In the order of [`Evaluation::conditions`].
    pub conditions: Vec<String>,
    /// In the order of [`Evaluation::runs`]; names differ within a condition.
    pub runs: Vec<String>,
}

impl Places {
    /// Of an evaluation.
    pub fn of(evaluation: &Evaluation) -> Self {
        let mut names = Names::default();
        let conditions: Vec<String> = evaluation.conditions.iter().map(|condition| names.of(&condition.name)).collect();
        let mut within: Vec<Names> = conditions.iter().map(|_| Names::default()).collect();
        let runs = evaluation.runs.iter().map(|run| within[run.condition].of(&evaluation.label(*run))).collect();
        Self { conditions, runs }
    }
}

/// The text with `-` for what a file name may not have.
fn allowed(text: &str) -> String {
    let keep = |c: char| !c.is_control() && !matches!(c, '/' | '\\' | '<' | '>' | ':' | '"' | '|' | '?' | '*');
    let mut name: String = text.chars().map(|c| if keep(c) { c } else { '-' }).collect();
    if name.len() > LONGEST {
        let end = (0..=LONGEST).rev().find(|end| name.is_char_boundary(*end)).unwrap_or(0);
        name.truncate(end);
    }
    let trimmed = name.trim().trim_start_matches('.').trim_end_matches(['.', ' ']).trim();
    let stem = trimmed.split('.').next().unwrap_or_default().to_lowercase();
    let device = DEVICES.contains(&stem.as_str())
        || ["com", "lpt"].iter().any(|port| {
            stem.strip_prefix(port)
                .is_some_and(|rest| rest.len() == 1 && rest.bytes().all(|byte| byte.is_ascii_digit()))
        });
    match trimmed {
        "" => "unnamed".to_owned(),
        _ if device => format!("-{trimmed}"),
        _ => trimmed.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_allowed_everywhere_and_never_twice() {
        let mut names = Names::default();
        let given = [
            "pool, lamp=4",
            "neutral/lux",
            "neutral-lux",
            "Neutral/Lux",
            "../x",
            ".",
            "con.exr",
            "a\u{7}b",
            "LPT1",
            "",
        ];
        let wanted = [
            "pool, lamp=4",
            "neutral-lux",
            "neutral-lux 2",
            "Neutral-Lux 3",
            "-x",
            "unnamed",
            "-con.exr",
            "a-b",
            "-LPT1",
            "unnamed 2",
        ];
        assert_eq!(given.map(|text| names.of(text)), wanted);
        let long = "ä".repeat(200);
        assert!(names.of(&long).len() <= LONGEST + 4);
    }
}
