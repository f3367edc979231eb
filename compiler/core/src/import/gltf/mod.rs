//! Scenes of glTF 2.0, text (`.gltf`) and binary (`.glb`).
//!
//! Meshes, materials and the tree of nodes are read by the one reader of glTF, [`crate::mesh::file::gltf`], which turns y up to z up;
//! here cameras, lights and settings are read, and shapes are put together. Places in findings are JSON pointers.

mod light;
mod shape;
mod surface;
mod view;

use super::build::Settings;
use super::reader::{Fate, Reader, code_of};
use super::{Builder, Importer, name_of};
use crate::diag::{Finding, Origin};
use crate::files::VPath;
use crate::ir::{Color, LightKind, Scene};
use crate::mesh::file::FileError;
use crate::mesh::file::gltf::document::{self, Document};
use crate::mesh::file::gltf::{Whole, whole};

/// Its row.
pub(super) const IMPORTER: Importer =
    Importer { name: "gltf", summary: "a scene in glTF", endings: &["gltf", "glb"], read };

fn read(reader: &mut Reader<'_>, path: &VPath) -> Option<Scene> {
    let whole = at(path, String::new());
    let bytes = match reader.bytes(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            reader.error("missing-file", whole, format!("`{path}` cannot be read: {error}"));
            return None;
        }
    };
    match scene(reader, path, &bytes) {
        Ok(scene) => Some(scene),
        Err(FileError { message, place, help }) => {
            reader.add(Finding::error("invalid-mesh-file", at(path, place), message).maybe_help(help));
            None
        }
    }
}

/// A place in the file.
fn at(path: &VPath, place: String) -> Origin {
    Origin::File { path: path.to_string(), place }
}

fn scene(reader: &mut Reader<'_>, path: &VPath, bytes: &[u8]) -> Result<Scene, FileError> {
    let (text, chunk) = document::split(bytes)?;
    let values = document::parse(text)?;
    let document = Document::new(&values)?;
    let own = chunk.map(|range| &bytes[range]);
    let Whole { model, uses, others, notes } = whole(&document, own, text.len(), &mut |written| {
        // Some programs write the backslashes of Windows.
        let file = VPath::resolve(path.folder(), &written.replace('\\', "/"))
            .map_err(|error| format!("it names another file, and {error}"))?;
        match reader.bytes(&file) {
            Ok(bytes) => Ok(Box::new(bytes)),
            Err(error) => Err(format!("`{file}` cannot be read: {error}")),
        }
    })?;
    for note in notes {
        let finding = Finding::new(code_of(&note), note.severity, at(path, note.place), note.message);
        reader.add(finding.maybe_help(note.help));
    }
    let start = at(path, String::new());
    let of_ltsc = document.whole().inner("asset").and_then(|asset| asset.text("generator")) == Some("ltsc");
    // What PNG and JPEG files say of their color space must be ignored (glTF 2.0, 5.19).
    let mut to = Builder::default();
    to.as_stored = true;
    let mut settings = Settings::default();
    let sized = view::settings(&document, path, &mut settings, reader);
    let surfaces = surface::Surfaces::new(&document, &model, path, of_ltsc)?;
    shape::add(model, &uses, surfaces, of_ltsc, reader, &mut to);
    view::cameras(&document, &others, path, (&mut settings.film, sized), reader, &mut to)?;
    light::add(&document, &others, path, of_ltsc, reader, &mut to)?;
    if to.cameras() == 0 {
        reader.lost(Fate::Approximated, start.clone(), "the scene has no camera: one is put before it");
        to.stand_back(start.clone());
    }
    if !to.shines() {
        let message = "the scene has no light: an environment of radiance 1 is put around it";
        reader.lost(Fate::Approximated, start.clone(), message);
        to.light(reader, "environment", LightKind::environment(Color::Grey(1.0).into()), &start);
    }
    if document.list("scenes")?.len() > 1 {
        let message = "scenes of the file other than its default one are left out";
        reader.lost(Fate::Noise, at(path, "/scenes".to_owned()), message);
    }
    Ok(to.finish(name_of(path), start, settings))
}

#[cfg(test)]
mod tests;
