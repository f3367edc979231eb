//! Scenes of PBRT, versions 1 to 4, and of the programs that read its format.
//!
//! Which version a file is of is found out from its words ([`dialect`]). What they mean was read in the sources of pbrt-v3 and pbrt-v4,
//! as marked, and is tested by small cases; the thesis's scenes agree with those for Mitsuba.
//!
//! The world of PBRT is left-handed: a file whose camera does not mirror has its x mirrored, so that the image is the same.

mod color;
mod dialect;
mod light;
mod material;
mod params;
mod round;
mod settings;
mod shape;
mod texture;
mod tokens;
mod world;

use super::reader::Reader;
use super::{Importer, name_of};
use crate::files::VPath;
use crate::ir::Scene;
use world::World;

/// Its row.
pub(super) const IMPORTER: Importer = Importer { name: "pbrt", summary: "a scene of PBRT", endings: &["pbrt"], read };

fn read(reader: &mut Reader<'_>, path: &VPath) -> Option<Scene> {
    let mut world = World::new(reader, path)?;
    world.run();
    world.finish(name_of(path))
}

#[cfg(test)]
mod tests;
