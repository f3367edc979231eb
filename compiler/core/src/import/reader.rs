//! What an importer reads from, and where its findings go.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::Options;
use crate::diag::{FileId, Finding, Origin, Severity, Sources, nearest};
use crate::eval::Limits;
use crate::files::{Bytes, Files, ReadError, VPath};
use crate::mesh::file::{self as mesh_file, Note};

/// What became of something in a file that the Scene does not hold as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Left out, which changes the image.
    Dropped,
    /// Read as something that is near it.
    Approximated,
    /// Read as something else with the same image.
    Baked,
    /// Left out, which changes noise or time, not what is rendered.
    Noise,
}

impl Fate {
    fn code(self) -> &'static str {
        match self {
            Self::Dropped => "loss-dropped",
            Self::Approximated => "loss-approximated",
            Self::Baked | Self::Noise => "loss-baked",
        }
    }

    fn severity(self) -> Severity {
        match self {
            Self::Dropped | Self::Approximated => Severity::Warn,
            Self::Baked | Self::Noise => Severity::Info,
        }
    }
}

/// The code of what a mesh file has to say: what is left out of it and is not seen is no loss of the scene.
pub fn code_of(note: &Note) -> &'static str {
    let unseen = note.fate == mesh_file::Fate::Dropped && note.severity == Severity::Info;
    if unseen { Fate::Noise.code() } else { note.fate.code() }
}

/// The files around a scene, and what is found in them.
pub struct Reader<'f> {
    files: &'f dyn Files,
    /// The texts that were read.
    pub sources: &'f mut Sources,
    /// What the user has said.
    pub options: &'f Options,
    inputs: BTreeMap<VPath, Bytes>,
    /// Files that are not there.
    pub(super) missing: BTreeSet<VPath>,
    findings: Vec<Finding>,
    /// What was said already, by code and message: the finding, and in how many more places.
    said: HashMap<(&'static str, String), (usize, usize)>,
    /// Parameters that the file declares.
    declared: BTreeSet<String>,
}

impl<'f> Reader<'f> {
    pub(super) fn new(files: &'f dyn Files, sources: &'f mut Sources, options: &'f Options) -> Self {
        Self {
            files,
            sources,
            options,
            inputs: BTreeMap::new(),
            missing: BTreeSet::new(),
            findings: Vec::new(),
            said: HashMap::new(),
            declared: BTreeSet::new(),
        }
    }

    /// How large things may be.
    pub fn limits(&self) -> &'f Limits {
        &self.options.limits
    }

    /// Says that the file has a parameter, so that the user may give it a value.
    pub fn declare(&mut self, name: &str) {
        self.declared.insert(name.to_owned());
    }

    /// The bytes of a file, read once; what is wrong, in words.
    ///
    /// # Errors
    /// If it is not there, cannot be read or is too large.
    pub fn bytes(&mut self, path: &VPath) -> Result<Bytes, String> {
        if let Some(bytes) = self.inputs.get(path) {
            return Ok(bytes.clone());
        }
        let bytes = self.files.read(path, self.limits().file).map_err(|error| {
            if matches!(error, ReadError::Missing { beside: _ }) {
                self.missing.insert(path.clone());
            }
            error.to_string()
        })?;
        self.inputs.insert(path.clone(), bytes.clone());
        Ok(bytes)
    }

    /// A file as a text, which then is among the sources; what is wrong, in words.
    ///
    /// # Errors
    /// As of [`Self::bytes`], and if it is no UTF-8 or longer than places in a text can say.
    pub fn text(&mut self, path: &VPath) -> Result<FileId, String> {
        if let Some(file) = self.sources.find(path.as_str()) {
            return Ok(file);
        }
        let bytes = self.bytes(path)?;
        if bytes.len() as u64 > self.limits().text.min(u64::from(u32::MAX)) {
            return Err(format!("it has more than {} bytes (`--limit text=N` allows more)", self.limits().text));
        }
        let plain = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        let text = match std::str::from_utf8(plain) {
            Ok(text) => text.to_owned(),
            // Old files have the names of their authors in Latin-1, in comments.
            Err(_) => plain.iter().map(|byte| char::from(*byte)).collect(),
        };
        Ok(self.sources.add(path.as_str(), text))
    }

    /// Says what became of something at a place. What is said of many places is said once, with their number.
    pub fn lost(&mut self, fate: Fate, at: impl Into<Origin>, message: impl Into<String>) {
        self.lost_with(fate, at, message, "");
    }

    /// The same with advice.
    pub fn lost_with(&mut self, fate: Fate, at: impl Into<Origin>, message: impl Into<String>, help: &str) {
        let message = message.into();
        let key = (fate.code(), message);
        if let Some((_, more)) = self.said.get_mut(&key) {
            *more += 1;
            return;
        }
        let finding = Finding::new(fate.code(), fate.severity(), at, key.1.clone());
        let finding = if help.is_empty() { finding } else { finding.help(help) };
        self.said.insert(key, (self.findings.len(), 0));
        self.findings.push(finding);
    }

    /// Says what is wrong with the file, so that there is no scene.
    pub fn error(&mut self, id: &'static str, at: impl Into<Origin>, message: impl Into<String>) {
        self.findings.push(Finding::error(id, at, message));
    }

    /// Adds a finding.
    pub fn add(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    pub(super) fn finish(mut self, path: &VPath) -> (Vec<Finding>, BTreeMap<VPath, Bytes>) {
        let known: Vec<&str> = self.declared.iter().map(String::as_str).collect();
        for name in self.options.defines.keys().filter(|name| !known.contains(&name.as_str())) {
            let origin = Origin::File { path: path.to_string(), place: String::new() };
            let finding = Finding::error("unknown-parameter", origin, format!("the scene has no parameter `{name}`"));
            let has = if known.is_empty() {
                "the file declares none".to_owned()
            } else {
                format!("the file declares {}", known.join(", "))
            };
            let near = nearest(name, known.iter().copied()).map(|near| format!("did you mean `{near}`?"));
            self.findings.push(finding.note(has).maybe_help(near));
        }
        for (at, more) in self.said.into_values().filter(|(_, more)| *more > 0) {
            let finding = &mut self.findings[at];
            let places = if more == 1 { "one more place".to_owned() } else { format!("{more} more places") };
            finding.notes.push(format!("the same in {places}"));
        }
        (self.findings, self.inputs)
    }
}

/// A word from a file as it can stand in a message.
pub fn shown(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).take(60).collect();
    if plain.len() < text.len() { format!("{plain}...") } else { plain }
}
