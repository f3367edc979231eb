//! The door through which a reader opens files: below one folder, within bounds, with findings that name file and line.

use crate::diag::{Finding, Origin};
use crate::files::{Bytes, Files, VPath};
use crate::formats::statements::{NONE, Statements};

/// A reader was given something that is not written as its format asks for.
pub const SYNTAX: &str = "foreign-syntax";
/// A reader was given a statement or a parameter that it does not know.
pub const UNKNOWN: &str = "foreign-unknown";
/// A reader was given more than it takes.
pub const LIMIT: &str = "foreign-limit";
/// A file, or something in it, is named and is not there.
pub const REFERENCE: &str = "foreign-reference";

/// Findings of one reading before the rest is left out.
const MOST_FINDINGS: usize = 100;
/// Files of one reading: includes that include each other twice would else never end.
const MOST_FILES: usize = 1000;
/// How deep files may include each other.
pub const INCLUDE_DEPTH: usize = 16;
/// Bytes of all files of one reading together.
const MOST_BYTES: u64 = 4 << 30;
/// Bytes of one file that are parsed as text, so that offsets fit everywhere.
const MOST_TEXT: u64 = 2 << 30;

/// The files of one reading.
pub struct Source<'f> {
    files: &'f dyn Files,
    opened: usize,
    left: u64,
    findings: Vec<Finding>,
    more: bool,
    given: &'f Statements,
    hushed: bool,
    passed: Vec<Finding>,
}

/// A text with its path, for places.
#[derive(Clone, Copy)]
pub struct Text<'t> {
    /// The file.
    pub path: &'t VPath,
    /// What stands in it.
    pub text: &'t str,
}

impl Text<'_> {
    /// The line of a byte.
    pub fn origin(&self, at: usize) -> Origin {
        let before = self.text.as_bytes().get(..at).unwrap_or(self.text.as_bytes());
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        Origin::File { path: self.path.as_str().to_owned(), place: format!("line {line}") }
    }
}

/// The whole file.
pub fn whole(path: &VPath) -> Origin {
    Origin::File { path: path.as_str().to_owned(), place: String::new() }
}

impl<'f> Source<'f> {
    /// Reads from `files`.
    pub fn new(files: &'f dyn Files) -> Self {
        Self::with(files, &NONE)
    }

    /// Reads from `files` what was written with statements of a test case.
    pub fn with(files: &'f dyn Files, given: &'f Statements) -> Self {
        let (findings, passed) = (Vec::new(), Vec::new());
        Self { files, opened: 0, left: MOST_BYTES, findings, more: false, given, hushed: false, passed }
    }

    /// The statements of a test case.
    pub fn given(&self) -> &'f Statements {
        self.given
    }

    /// From here on, findings are about a statement of a test case: what is not understood in it passes through. Gives what was
    /// so far.
    pub fn hush(&mut self, hushed: bool) -> bool {
        std::mem::replace(&mut self.hushed, hushed)
    }

    /// The bytes of a file that is named at `origin`.
    pub fn bytes(&mut self, path: &VPath, origin: impl Fn() -> Origin) -> Option<Bytes> {
        self.opened += 1;
        if self.opened > MOST_FILES {
            self.say(LIMIT, origin(), format!("more than {MOST_FILES} files are named"));
            return None;
        }
        match self.files.read(path, self.left) {
            Ok(bytes) => {
                self.left -= bytes.len() as u64;
                Some(bytes)
            }
            Err(problem) => {
                self.say(REFERENCE, origin(), format!("`{path}` cannot be read: {problem}"));
                None
            }
        }
    }

    /// The path `relative` as written in the file `from`; a path that leaves the folder is a finding.
    pub fn path(&mut self, from: &VPath, relative: &str, origin: impl Fn() -> Origin) -> Option<VPath> {
        match VPath::resolve(from.folder(), relative) {
            Ok(path) => Some(path),
            Err(problem) => {
                self.say(REFERENCE, origin(), format!("the path `{}`: {problem}", shown(relative)));
                None
            }
        }
    }

    /// Adds a finding.
    pub fn say(&mut self, id: &'static str, origin: Origin, message: impl Into<String>) {
        self.add(Finding::error(id, origin, message));
    }

    /// Adds a finding with all that it has.
    pub fn add(&mut self, finding: Finding) {
        if self.hushed {
            if self.passed.len() < MOST_FINDINGS {
                self.passed.push(finding);
            }
            return;
        }
        if self.findings.len() < MOST_FINDINGS {
            self.findings.push(finding);
        } else if !self.more {
            self.more = true;
            let origin = finding.origin;
            self.findings.push(Finding::error(LIMIT, origin, format!("there are more than {MOST_FINDINGS} findings")));
        }
    }

    /// Whether so much was found that reading on says nothing new.
    pub fn is_full(&self) -> bool {
        self.more
    }

    /// What was found.
    pub fn finish(self) -> Vec<Finding> {
        self.findings
    }

    /// What was found, and what of statements of a test case was not understood.
    pub fn finish_all(self) -> (Vec<Finding>, Vec<Finding>) {
        (self.findings, self.passed)
    }
}

/// The bytes as text.
pub fn text<'t>(source: &mut Source<'_>, path: &VPath, bytes: &'t [u8]) -> Option<&'t str> {
    if bytes.len() as u64 > MOST_TEXT {
        source.say(LIMIT, whole(path), format!("the file has more than {MOST_TEXT} bytes"));
        return None;
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Some(text),
        Err(problem) => {
            let place = format!("byte {}", problem.valid_up_to());
            let origin = Origin::File { path: path.as_str().to_owned(), place };
            source.say(SYNTAX, origin, "the file is not text in UTF-8");
            None
        }
    }
}

/// A word of a file for a message: cut, without control characters.
pub fn shown(word: &str) -> String {
    const LETTERS: usize = 60;
    let cut: String = word.chars().take(LETTERS).flat_map(char::escape_debug).collect();
    if word.chars().nth(LETTERS).is_some() { format!("{cut}...") } else { cut }
}

/// A finite number, whole.
pub fn number(word: &str) -> Option<f64> {
    // `parse` takes "inf" and "nan" too.
    word.parse::<f64>().ok().filter(|value| value.is_finite())
}

/// Numbers between blanks, and commas where the format has them; none if one of them is not a number.
pub fn numbers(text: &str, commas: bool) -> Option<Vec<f64>> {
    let parts = text.split(|letter: char| letter.is_ascii_whitespace() || (commas && letter == ','));
    parts.filter(|part| !part.is_empty()).map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::MemoryFiles;

    #[test]
    fn what_is_not_there_is_said_with_its_line() {
        let files = MemoryFiles::default();
        let mut source = Source::new(&files);
        let path = VPath::resolve("", "a/scene.xml").expect("a path");
        let text = Text { path: &path, text: "one\ntwo\nthree" };
        assert!(source.path(&path, "../../b.ply", || text.origin(5)).is_none());
        let other = source.path(&path, "../b.ply", || text.origin(5)).expect("a path below the root");
        assert!(source.bytes(&other, || text.origin(9)).is_none());
        let found = source.finish();
        let places: Vec<&Origin> = found.iter().map(|finding| &finding.origin).collect();
        assert_eq!(places, [&text.origin(4), &text.origin(8)]);
        assert!(found[1].message.contains("`b.ply`"), "{}", found[1].message);
    }

    #[test]
    fn findings_and_files_come_to_an_end() {
        let mut files = MemoryFiles::default();
        files.insert("a", "x");
        let mut source = Source::new(&files);
        let path = VPath::resolve("", "a").expect("a path");
        for _ in 0..2 * MOST_FILES {
            source.bytes(&path, || whole(&path));
        }
        assert!(source.is_full());
        assert_eq!(source.finish().len(), MOST_FINDINGS + 1);
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!(numbers(" 1 -2.5e3\t0 ", false), Some(vec![1.0, -2500.0, 0.0]));
        assert_eq!(numbers("1, 2,3", true), Some(vec![1.0, 2.0, 3.0]));
        assert_eq!((numbers("1, 2", false), numbers("inf", true), number("nan"), number("")), (None, None, None, None));
    }
}
