//! Mesh files: PLY, OBJ, STL, glTF and Mitsuba's serialized ones, as bytes in memory.
//!
//! A file may be anything: no input makes a reader panic, and no number in a header makes it allocate more than a small
//! multiple of the bytes that are there.

mod finish;
pub(crate) mod gltf;
mod model;
mod mtl;
mod note;
mod obj;
mod ply;
mod polygons;
mod serialized;
mod stl;
mod text;

use std::fmt;

pub use model::{Model, NAMELESS, Part, Picture, Scatter, Surface, plain_color};
pub use note::{Fate, Note};

use super::Geometry;
use crate::diag::nearest;

/// Why a mesh file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// What is wrong; lower-case, one sentence.
    pub message: String,
    /// Where: `line 7`, `byte 120`; empty for the whole file.
    pub place: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl FileError {
    fn new(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self { message: message.into(), place: place.into(), help: None }
    }

    #[must_use]
    fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place.as_str() {
            "" => f.write_str(&self.message),
            place => write!(f, "{place}: {}", self.message),
        }
    }
}

impl std::error::Error for FileError {}

/// The endings of the files that [`read`] knows.
pub const EXTENSIONS: &[&str] = &["ply", "obj", "stl", "glb", "gltf", "serialized"];

/// The bytes of a file that a mesh file names, by its path from the folder of the mesh file; what is wrong, in words.
pub type Beside<'f> = dyn FnMut(&str) -> Result<Box<dyn AsRef<[u8]>>, String> + 'f;

/// The mesh in the file with these bytes; `part` selects an object or a group of an OBJ file, a solid of an STL file that is
/// text, a node or a mesh of a glTF file, the number of a mesh of a serialized file. The result has at least one triangle and passes [`Geometry::check`]; it has
/// normals and texture coordinates where the file has them for every corner.
///
/// # Errors
/// An ending that is not in [`EXTENSIONS`], a part that is not there, and whatever is wrong with the bytes.
pub fn read(
    extension: &str,
    bytes: &[u8],
    part: Option<&str>,
    beside: &mut Beside<'_>,
) -> Result<(Geometry, Vec<Note>), FileError> {
    let (geometry, notes) = match extension.to_ascii_lowercase().as_str() {
        "ply" => match part {
            None => ply::read(bytes)?,
            Some(_) => return Err(FileError::new("", "a PLY file has no parts").help("leave out `part`")),
        },
        "obj" => obj::read(bytes, part)?,
        "stl" => stl::read(bytes, part)?,
        "serialized" => serialized::read(bytes, part)?,
        "glb" | "gltf" => {
            let (model, mut notes) = gltf::read(bytes, part, beside)?;
            (model.merged(&mut notes)?, notes)
        }
        other => return Err(unknown(other)),
    };
    Ok((geometry, note::merged(notes)))
}

/// All parts of the file with these bytes, with their materials where it has some. Each mesh has at least one triangle,
/// normals, flat ones where the file has none, and passes [`Geometry::check`].
///
/// # Errors
/// As [`read`].
pub fn read_parts(extension: &str, bytes: &[u8], beside: &mut Beside<'_>) -> Result<(Model, Vec<Note>), FileError> {
    let (model, mut notes) = match extension.to_ascii_lowercase().as_str() {
        "ply" => ply::read(bytes).map(|(geometry, notes)| (Model::of(geometry), notes))?,
        "obj" => obj::read_parts(bytes, beside)?,
        "stl" => stl::read(bytes, None).map(|(geometry, notes)| (Model::of(geometry), notes))?,
        "serialized" => serialized::read(bytes, None).map(|(geometry, notes)| (Model::of(geometry), notes))?,
        "glb" | "gltf" => gltf::read(bytes, None, beside)?,
        other => return Err(unknown(other)),
    };
    Ok((model.with_normals(&mut notes)?, note::merged(notes)))
}

/// A [`Beside`] for where there is nothing but the file.
///
/// # Errors
/// Always.
pub fn alone(path: &str) -> Result<Box<dyn AsRef<[u8]>>, String> {
    Err(format!("`{}` cannot be read: only the mesh file itself is there", shown(path)))
}

fn unknown(extension: &str) -> FileError {
    FileError::new("", format!("mesh files with the ending `{extension}` cannot be read"))
        .help("convert the mesh to PLY, OBJ, STL or glTF")
}

/// The names of the objects and groups of an OBJ file that have faces, or of the solids of an STL file, in their order; none
/// for other files.
///
/// # Errors
/// As [`read`] of the whole file.
pub fn parts(extension: &str, bytes: &[u8]) -> Result<Vec<String>, FileError> {
    match extension.to_ascii_lowercase().as_str() {
        "obj" => obj::parts(bytes),
        "stl" => stl::parts(bytes),
        "serialized" => serialized::parts(bytes),
        _ => Ok(Vec::new()),
    }
}

/// A part is not among those of the file, which are called `names`; `kind` says what parts are.
fn missing_part(kind: &str, part: &str, names: &[String]) -> FileError {
    let error = FileError::new("", format!("the file has no {kind} `{}` with faces", shown(part)));
    if names.is_empty() {
        return error.help(format!("leave out `part`: the file has no {kind} with a name"));
    }
    if let Some(meant) = nearest(part, names.iter().map(String::as_str)) {
        return error.help(format!("is `{}` meant?", shown(meant)));
    }
    let listed: Vec<String> = names.iter().take(12).map(|name| format!("`{}`", shown(name))).collect();
    let more = if names.len() > 12 { ", ..." } else { "" };
    error.help(format!("its parts are {}{more}", listed.join(", ")))
}

/// `1 face`, `2 faces`.
fn plural(count: u64, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// A word of the file for a message: cut, without control characters.
fn shown(word: &str) -> String {
    const LETTERS: usize = 40;
    let cut: String = word.chars().take(LETTERS).flat_map(char::escape_debug).collect();
    if word.chars().nth(LETTERS).is_some() { format!("{cut}...") } else { cut }
}

#[cfg(test)]
mod tests;
