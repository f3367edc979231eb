//! The Scene as a text of the language, and the files that the text names: what people edit of a scene that comes from elsewhere.
//!
//! [`print`](fn@print) writes; evaluation of what it wrote gives the same scene. Reading order: `number` and `names` (words of the
//! language), `notes` (what is lost), `place` (transforms as stages), `mesh` (meshes that a constructor makes), `surface` (colors,
//! materials, images), `light`, `settings` (the header too), `plan` (what is declared and what stands in place), `write` (statements), `compare` (whether two scenes are equal).

mod compare;
mod light;
mod mesh;
mod names;
mod notes;
mod number;
mod place;
mod plan;
mod settings;
mod surface;
mod write;

use std::io::{self, Write};

use crate::diag::{Finding, Severity, Sources};
use crate::files::Sink;
use crate::format::{self, FormatError};
use crate::formats::shared::ply;
use crate::ir::{Affine, ImageFile, Mesh, Scene};
use crate::npy;

pub use compare::difference;

/// How a scene is written.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// What the scene is called instead of its own name: that of the file without its ending, which the language asks for.
    pub name: Option<String>,
    /// Where it comes from, as a comment above it says: "Imported from scene.xml."
    pub origin: Option<String>,
    /// The folder of the files that it names, from the folder of the text, with a final `/`; empty for the same folder.
    pub folder: String,
}

/// A scene as a text.
#[derive(Debug)]
pub struct Printed<'s> {
    /// What the scene is called: the text belongs into the file `NAME.lts`.
    pub name: String,
    /// The text, formatted.
    pub text: String,
    /// The files that it names, by their paths from the folder of the text, in the order in which it names them.
    pub files: Vec<(String, Content<'s>)>,
    /// What of the scene the text does not say, or says otherwise; none where evaluation gives the same scene.
    pub findings: Vec<Finding>,
}

impl Printed<'_> {
    /// The name of the text's file.
    pub fn file(&self) -> String {
        format!("{}.lts", self.name)
    }

    /// Writes the text and all files.
    ///
    /// # Errors
    /// What the sink says.
    pub fn write(&self, sink: &mut dyn Sink) -> io::Result<()> {
        for (path, content) in &self.files {
            sink.file(path, &mut |out| content.write(out))?;
        }
        sink.file(&self.file(), &mut |out| out.write_all(self.text.as_bytes()))
    }
}

/// What is in a file that a text names. Nothing is copied before it is written.
#[derive(Clone, Copy, Debug)]
pub enum Content<'s> {
    /// A mesh, as binary PLY.
    Mesh(&'s Mesh),
    /// An image, byte by byte.
    Image(&'s ImageFile),
    /// Places of a group, as an array of NumPy.
    Places(&'s [Affine]),
}

impl Content<'_> {
    /// Writes the bytes of the file.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Mesh(mesh) => ply::write(mesh, out),
            Self::Image(image) => out.write_all(image),
            Self::Places(maps) => {
                npy::write::header(&[maps.len(), 3, 4], out)?;
                let mut block = Vec::new();
                for some in maps.chunks(1 << 12) {
                    block.clear();
                    let numbers = some.iter().flat_map(|map| map.rows.as_flattened());
                    block.extend(numbers.flat_map(|number| number.to_le_bytes()));
                    out.write_all(&block)?;
                }
                Ok(())
            }
        }
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // A vector takes all.
        let _done: io::Result<()> = self.write(&mut bytes);
        bytes
    }
}

/// Writes `scene` as a text, and says what is lost.
///
/// Where there are no findings, evaluation of the text gives an equal scene. Equal, as [`difference`] finds it, means: the same name, documentation and settings;
/// the same cameras, shapes, emitters, lights and instances in the same order and with the same names; and of each the same numbers,
/// where 0 and -0 are one. Numbers of meshes are the same to the bit, files of images to the byte. Two shapes have one mesh
/// in the one scene where they have one in the other, and groups and textures are shared likewise. What does not count:
///
/// - origins, and the order of meshes, textures, materials and groups in their arenas;
/// - meshes, textures, materials and groups that nothing uses, which are left out;
/// - materials of one name and meaning, which become one;
/// - what evaluation reads from the file of an image: its header, and its largest number;
/// - the turn of an environment without an image.
///
/// Findings: `print-renamed` where a name is taken or cannot be written, `loss-dropped` where something is left out (parameters, whose
/// values are written; what is not valid in a scene), `loss-approximated` where the nearest that the language has is written.
///
/// Takes time linear in shapes, instances, vertices and characters.
pub fn print<'s>(scene: &'s Scene, options: &Options) -> Printed<'s> {
    let (name, raw, files, mut findings) = write::scene(scene, options);
    let text = match format::format(&mut Sources::default(), "printed.lts", &raw) {
        Ok(text) => text,
        Err(error) => {
            let (FormatError::Malformed(_) | FormatError::Fault(_)) = &error;
            let message = "the text could not be formatted: a fault of ltsc";
            findings.push(Finding::new("loss-approximated", Severity::Warn, scene.origin.clone(), message));
            raw
        }
    };
    Printed { name, text, files, findings }
}

#[cfg(test)]
mod property_tests;
#[cfg(test)]
mod read_tests;
#[cfg(test)]
mod tests;
