//! Targets: one folder per format, and the table of all.

pub mod algorithms;
mod choices;
pub mod cycles;
pub mod effective;
pub mod gltf;
pub mod luxcore;
pub mod mitsuba;
pub mod pbrt;
pub mod shared;
pub mod statements;
#[cfg(test)]
mod toy;

use std::io;

pub use choices::{Choice, ChoiceError, Choices, all as choices};

use crate::capability::{Bound, Feature, Support};
use crate::files::{Sink, VPath};
use crate::ir::{Camera, Handle, Scene};
use crate::valid::Valid;
use shared::images::Forms;
use shared::reading::Reading;
use shared::source::Source;
use statements::{Native, Statements};

/// A reader of a target's files: see [`Target::import`].
pub type Importer = fn(&VPath, &mut Source<'_>) -> Reading;

/// A target: a scene format that ltsc writes.
pub struct Target {
    /// The name people type: `mitsuba-3`.
    pub name: &'static str,
    /// Other names: `mitsuba`.
    pub aliases: &'static [&'static str],
    /// One line for help texts.
    pub summary: &'static str,
    /// The file a renderer opens, with `SCENE` for the scene's name where it is part of the file name; see
    /// [`Target::main_file_of`].
    pub main_file: &'static str,
    /// Whether meshes and images lie in files shared with other targets (else the target writes its own).
    pub shares_meshes: bool,
    /// What it can say.
    pub supports: fn(Feature) -> Support,
    /// The formula by which the Scene's numbers become the target's, where they are not the same numbers.
    pub conversions: &'static [(Feature, &'static str)],
    /// What it does with an image: the scene's own file, or one in another form in its own folder.
    pub images: Forms,
    /// How far off it is for one scene, where that can be computed for what it does not say exactly.
    pub bound: fn(Feature, &Scene) -> Option<Bound>,
    /// What it does only where it is asked for.
    pub choices: &'static [Choice],
    /// Writes all files of the scene but the shared meshes.
    pub emit: fn(&Emission<'_>, &mut dyn Sink) -> io::Result<()>,
    /// Reads what its files say, from the main file on, and tells the source what it does not understand. Where there is none, what
    /// is written cannot be audited.
    pub import: Option<Importer>,
    /// How it takes native statements of test cases; none where it has no words for settings.
    pub statements: Option<Native>,
}

impl Target {
    /// The formula by which the numbers of `feature` become the target's; none where they are the same numbers.
    pub fn conversion(&self, feature: Feature) -> Option<&'static str> {
        self.conversions.iter().find(|(converted, _)| *converted == feature).map(|(_, formula)| *formula)
    }

    /// The file a renderer opens for the scene called `name`, made safe for file systems.
    pub fn main_file_of(&self, name: &str) -> String {
        self.main_file.replace("SCENE", &shared::names::file_stem(name))
    }
}

/// What an emitter is given. The scene has been lowered and validated.
pub struct Emission<'a> {
    /// The scene.
    pub scene: &'a Valid,
    /// The camera to look through.
    pub camera: Handle<Camera>,
    /// The way from the target's folder to the folder of the shared meshes, with a final `/`: `../meshes/`, `meshes/`.
    pub meshes: &'a str,
    /// The way to the folder of the shared images of textures, likewise.
    pub textures: &'a str,
    /// What was asked for beyond what targets do anyway.
    pub choices: &'a Choices,
    /// Native statements that replace those of the target, which has been asked about them; see [`Target::statements`].
    pub statements: &'a Statements,
}

/// All targets, in the order in which they are shown.
pub static TARGETS: &[Target] = &[
    mitsuba::MITSUBA_3,
    mitsuba::MITSUBA_0_6,
    mitsuba::MITSUBA_0_5,
    pbrt::PBRT_V4,
    pbrt::PBRT_V3,
    luxcore::LUXCORE,
    cycles::CYCLES,
    gltf::GLTF,
    gltf::GLB,
    #[cfg(test)]
    toy::TOY,
];

/// The grey that stands for a texture that a target cannot read.
const STAND_IN: f64 = 0.5;

/// What RGB targets answer to a spectrum.
const RGB_ONLY: Support = Support::approximate(
    "it computes with RGB: a spectrum becomes its color under D65 (CIE 1931), as an emitter its own color",
    "exact for the first bounce of light like D65; each further product of colors differs, of saturated ones by up to 16 % of the \
     largest channel (computed for reflectances whose smallest channel is a fifth of the largest); moss under light of 3000 K 0.469, 0.271, \
     0.024 for 0.457, 0.276, 0.008 (an RGB renderer, and the integral)",
);

/// What targets answer to a colored tint of an environment for which they have no word but a number.
const TINTED: Support = Support::approximate(
    "it has a number as a factor of the image and no color: the image is written anew, times the color, as floats in OpenEXR",
    "6e-8 of each number: single precision",
);

/// What every target answers to several cameras.
const ONE_CAMERA: Support = Support::approximate(
    "a folder of a target holds one camera",
    "exact for that camera; the others are emitted one by one",
);

/// The target called `name`, by name or alias.
pub fn find(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name || target.aliases.contains(&name))
}

/// The file name of each mesh of the arena, in its order: unique on every file system, `NAME.ply`.
pub fn mesh_files(scene: &Scene) -> Vec<String> {
    let stems = shared::names::file_stems(scene.meshes.values().map(|mesh| mesh.name.as_str()));
    stems.into_iter().map(|stem| stem + ".ply").collect()
}

/// Writes the meshes that targets share, as [`mesh_files`] names them, below `folder` (with a final `/`, empty for
/// none).
pub fn write_meshes(scene: &Valid, folder: &str, sink: &mut dyn Sink) -> io::Result<()> {
    for (mesh, file) in scene.meshes.values().zip(mesh_files(scene)) {
        let path = format!("{folder}{file}");
        sink.file(&path, &mut |out| shared::ply::write(mesh, out))?;
    }
    Ok(())
}

/// The file name of each texture of the arena, in its order: unique on every file system, with the ending of its format.
pub fn texture_files(scene: &Scene) -> Vec<String> {
    let stems = shared::names::file_stems(scene.textures.values().map(|texture| texture.name.as_str()));
    let endings = scene.textures.values().map(|texture| texture.image.format.ending());
    stems.into_iter().zip(endings).map(|(stem, ending)| format!("{stem}.{ending}")).collect()
}

/// Writes the images that one of `targets` has as they are, as [`texture_files`] names them, below `folder` (with a final `/`, empty
/// for none).
pub fn write_textures(scene: &Scene, targets: &[&Target], folder: &str, sink: &mut dyn Sink) -> io::Result<()> {
    let shared: Vec<Vec<bool>> = targets
        .iter()
        .filter(|target| target.shares_meshes)
        .map(|target| shared::images::shared(scene, target.images))
        .collect();
    let files = scene.textures.values().zip(texture_files(scene)).enumerate();
    for (_, (texture, file)) in files.filter(|(at, _)| shared.iter().any(|used| used[*at])) {
        sink.file(&format!("{folder}{file}"), &mut |out| out.write_all(&texture.file))?;
    }
    Ok(())
}

#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod tests;
