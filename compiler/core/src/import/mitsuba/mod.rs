//! Scenes of Mitsuba 0.4 to 0.6, 2 and 3.
//!
//! Names of parameters are read in both spellings (`toWorld`, `to_world`), so that it is of no matter which version wrote them. What they
//! mean is said by the documentation of 0.6 and 3.9 and, where marked so, measured.

mod color;
mod light;
mod plugin;
mod settings;
mod shape;
mod surface;
mod tree;

use std::collections::BTreeMap;

use super::build::Settings;
use super::reader::shown;
use super::reader::{Fate, Reader};
use super::{Builder, Importer, name_of};
use crate::files::VPath;
use crate::ir::{Affine, Scene, Vec3, cross, normalized};
use plugin::Plugin;
use shape::Shapes;
use surface::World;
use tree::Element;

/// Its row.
pub(super) const IMPORTER: Importer =
    Importer { name: "mitsuba", summary: "a scene of Mitsuba", endings: &["xml"], read };

fn read(reader: &mut Reader<'_>, path: &VPath) -> Option<Scene> {
    let whole = tree::read(reader, path)?;
    let mut ids = BTreeMap::new();
    // An `alias` gives an element a second name.
    let mut aliases = Vec::new();
    collect(&whole.elements, &mut ids, &mut aliases);
    for alias in aliases {
        if let Some(found) = ids.get(alias.word("id")).copied() {
            ids.insert(alias.word("as"), found);
        }
    }
    let world = World { ids, folder: path.folder().to_owned() };
    let mut to = Builder::default();
    let mut settings = Settings::default();
    let mut shapes = Shapes::default();
    // Settings that stand alone come first: cameras need the film.
    let mut rendered = false;
    for element in whole.elements.iter().filter(|element| element.tag == "integrator") {
        if rendered {
            reader.lost(Fate::Dropped, element.span, "a second algorithm is left out");
            continue;
        }
        rendered = true;
        settings.integrator = settings::integrator(Plugin::new(element), 0, reader);
    }
    for element in &whole.elements {
        match element.tag.as_str() {
            "sensor" => settings::sensor(Plugin::new(element), &world, &mut settings, reader, &mut to),
            "shape" => shapes.add(Plugin::new(element), &world, reader, &mut to),
            "emitter" => light::add(Plugin::new(element), &world, reader, &mut to),
            // Read where they are referred to, as are texts about the scene.
            "bsdf" | "texture" | "film" | "sampler" | "alias" | "integrator" | "string" | "rfilter" | "spectrum"
            | "rgb" | "float" | "integer" | "boolean" | "phase" => {}
            // Of slongle/Rainbow: how it shows the image while it renders.
            "mode" => {}
            "medium" | "volume" | "subsurface" => {
                reader.lost(Fate::Dropped, element.span, "a medium is left out: light travels through nothing");
            }
            other => {
                let message = format!("`{}` is left out: it is not known", shown(other));
                reader.lost(Fate::Dropped, element.span, message);
            }
        }
    }
    if to.cameras() == 0 {
        let message = "the scene has no camera: one is put before it";
        reader.lost(Fate::Approximated, whole.start, message);
        to.stand_back(whole.start.into());
    }
    Some(to.finish(name_of(path), whole.start.into(), settings))
}

/// Elements by their ids, and the aliases; the first of several equal ids counts, which Mitsuba refuses.
fn collect<'e>(elements: &'e [Element], ids: &mut BTreeMap<&'e str, &'e Element>, aliases: &mut Vec<&'e Element>) {
    for element in elements {
        if element.tag == "alias" {
            aliases.push(element);
        } else if let Some(id) = element.get("id").filter(|_| element.tag != "ref") {
            ids.entry(id).or_insert(element);
        }
        collect(&element.children, ids, aliases);
    }
}

/// A rotation that takes the z axis to a direction; none without one.
fn frame(axis: Vec3) -> Option<Affine> {
    let z = normalized(axis)?;
    let help = if z[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = normalized(cross(help, z))?;
    let y = cross(z, x);
    Some(Affine { rows: [0, 1, 2].map(|row: usize| [x[row], y[row], z[row], 0.0]) })
}

#[cfg(test)]
mod tests;
