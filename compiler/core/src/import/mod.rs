//! Scenes of other programs, read into the Scene: one folder for each format, and the table of all.
//!
//! A reader goes on where it does not understand: what it leaves out, or reads as something else, is a finding at its place, and all
//! findings of a file come in one run. Nothing in here panics, opens a file outside the root, or takes memory by a claim of the input.

mod build;
mod color;
mod gltf;
mod metals;
pub mod mitsuba;
pub mod pbrt;
mod placing;
mod reader;

use std::collections::{BTreeMap, BTreeSet};

use crate::diag::{Finding, Sources};
use crate::eval::Limits;
use crate::files::{Bytes, Files, VPath};
use crate::ir::Scene;

pub use build::Builder;
pub use reader::{Fate, Reader};

/// A format of scenes that is read.
#[derive(Clone, Copy, Debug)]
pub struct Importer {
    /// The name of its folder.
    pub name: &'static str,
    /// What it reads, as it stands in a sentence: "a scene of Mitsuba".
    pub summary: &'static str,
    /// How the names of its files end, without the dot.
    pub endings: &'static [&'static str],
    /// Reads the file; none where it holds no scene, which is a finding then.
    pub read: fn(&mut Reader<'_>, &VPath) -> Option<Scene>,
}

/// All formats that are read.
pub static IMPORTERS: &[Importer] = &[gltf::IMPORTER, mitsuba::IMPORTER, pbrt::IMPORTER];

/// The importer of a file, by the ending of its name.
pub fn find(path: &VPath) -> Option<&'static Importer> {
    let ending = path.extension();
    IMPORTERS.iter().find(|importer| importer.endings.contains(&ending.as_str()))
}

/// How a file is read.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Values of parameters that the file declares (`<default>` of Mitsuba), by name.
    pub defines: BTreeMap<String, String>,
    /// How large it may be.
    pub limits: Limits,
}

/// What came of a file.
#[derive(Debug, Default)]
pub struct Imported {
    /// The scene; none where there is none to speak of.
    pub scene: Option<Scene>,
    /// Everything found, in the order of the texts.
    pub findings: Vec<Finding>,
    /// Every file that was read, by path.
    pub inputs: BTreeMap<VPath, Bytes>,
    /// Files that it names and that are not there.
    pub missing: BTreeSet<VPath>,
}

/// Reads a scene of another program; texts that were read are added to `sources`.
pub fn import(
    importer: &Importer,
    files: &dyn Files,
    sources: &mut Sources,
    path: &VPath,
    options: &Options,
) -> Imported {
    let mut reader = Reader::new(files, sources, options);
    let scene = (importer.read)(&mut reader, path);
    let missing = std::mem::take(&mut reader.missing);
    let (findings, inputs) = reader.finish(path);
    Imported { scene, findings, inputs, missing }
}

/// The name of a scene that does not say one: that of its file, or of the folders around it where many scenes have files of that name.
pub fn name_of(path: &VPath) -> String {
    const NAMELESS: [&str; 8] = ["scene", "main", "index", "untitled", "mitsuba", "pbrt", "render", "description"];
    let parts = std::iter::once(path.stem()).chain(path.folder().rsplit('/').filter(|part| !part.is_empty()));
    let nameless = |part: &str| {
        let plain = part.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '_' | '-' | '.' | 'v'));
        NAMELESS.contains(&plain.to_ascii_lowercase().as_str())
    };
    let name = parts.clone().find(|part| !nameless(part)).unwrap_or(path.stem());
    let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(word).take(100).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') { name } else { format!("_{name}") }
}
