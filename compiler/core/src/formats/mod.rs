//! Targets: one folder per format.

use std::io;

use crate::capability::{Feature, Support};
use crate::files::Sink;
use crate::ir::{Camera, Handle};
use crate::valid::Valid;

/// A target: a scene format that ltsc writes.
pub struct Target {
    /// The name people type: `mitsuba-3`.
    pub name: &'static str,
    /// Other names: `mitsuba`.
    pub aliases: &'static [&'static str],
    /// One line for help texts.
    pub summary: &'static str,
    /// The file a renderer opens, with `SCENE` for the scene's name where it is part of the file name.
    pub main_file: &'static str,
    /// Whether meshes lie in files shared with other targets (else the target writes its own).
    pub shares_meshes: bool,
    /// What it can say.
    pub supports: fn(Feature) -> Support,
    /// Writes all files of the scene but the shared meshes.
    pub emit: fn(&Emission<'_>, &mut dyn Sink) -> io::Result<()>,
}

/// What an emitter is given. The scene has been lowered and validated.
pub struct Emission<'a> {
    /// The scene.
    pub scene: &'a Valid,
    /// The camera to look through.
    pub camera: Handle<Camera>,
    /// The way from the target's folder to the folder of the shared meshes, with a final `/`: `../meshes/`, `meshes/`.
    pub meshes: &'a str,
}

/// All targets, in the order in which they are shown.
pub static TARGETS: &[Target] = &[];

/// The target called `name`, by name or alias.
pub fn find(name: &str) -> Option<&'static Target> {
    TARGETS
        .iter()
        .find(|target| target.name == name || target.aliases.contains(&name))
}

/// Writes the meshes that targets share, as `NAME.ply` below `folder` (with a final `/`, empty for none).
pub fn write_meshes(_scene: &Valid, _folder: &str, _sink: &mut dyn Sink) -> io::Result<()> {
    Ok(())
}
