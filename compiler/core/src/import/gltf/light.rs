//! Lights of KHR_lights_punctual.
//!
//! Their units are candela and lux. What is read is the number of W/sr and W/m2, as emission is read as that of W/(m2 sr): lights and
//! emitters of a file keep their ratios, and what ltsc writes is read back as it was.

use super::at;
use crate::files::VPath;
use crate::import::Builder;
use crate::import::reader::{Fate, Reader, shown};
use crate::ir::{Affine, LightKind, normalized};
use crate::mesh::file::gltf::document::{Document, Item};
use crate::mesh::file::{FileError, plain_color};

/// The inner cone of a sharp edge is smaller than the outer one by this share, since glTF asks for a smaller one.
const SHARP: f64 = 2e-6;

/// The lights at these nodes.
///
/// # Errors
/// A list of lights that is none.
pub fn add(
    document: &Document<'_>,
    nodes: &[(Item<'_>, Affine)],
    path: &VPath,
    of_ltsc: bool,
    reader: &mut Reader<'_>,
    to: &mut Builder,
) -> Result<(), FileError> {
    let lights = document.lights()?;
    for (node, map) in nodes {
        let Some(own) = node.extension("KHR_lights_punctual") else { continue };
        let here = at(path, node.place());
        let Some(light) = own.count("light").and_then(|at| lights.get(at).copied()) else {
            reader.lost(Fate::Dropped, here, "a light is left out: its index points to nothing");
            continue;
        };
        let Some(kind) = kind(light, map, path, reader) else { continue };
        if !of_ltsc {
            let message = "the candela and lux of lights are read as the numbers of W/sr and W/m2";
            reader.lost(Fate::Approximated, here.clone(), message);
        }
        let names = [node.text("name"), light.text("name"), Some(kind.word())];
        let name = names.into_iter().flatten().find(|name| !name.is_empty()).unwrap_or_default();
        to.light(reader, name, kind, &here);
    }
    Ok(())
}

fn kind(light: Item<'_>, map: &Affine, path: &VPath, reader: &mut Reader<'_>) -> Option<LightKind> {
    let here = || at(path, light.place());
    let given = light.number("intensity").unwrap_or(1.0);
    let strength = light.row::<3>("color").unwrap_or([1.0; 3]).map(|channel| channel * given);
    if !strength.iter().all(|x| (0.0..=1e30).contains(x)) {
        reader.lost(Fate::Dropped, here(), "a light is left out: its intensity is negative or beyond 1e30");
        return None;
    }
    let strength = plain_color(strength);
    let position = map.rows.map(|row| row[3]);
    let ahead = normalized(map.rows.map(|row| -row[2]));
    let word = light.text("type").unwrap_or_default();
    if light.get("range").is_some() && word != "directional" {
        reader.lost(Fate::Dropped, here(), "the range behind which a light ends is left out: it shines on");
    }
    if ahead.is_none() && word != "point" {
        reader.lost(Fate::Dropped, here(), "a light is left out: its node has no direction");
        return None;
    }
    let ahead = ahead.unwrap_or([0.0, 0.0, -1.0]);
    match word {
        "point" => Some(LightKind::Point { position, intensity: strength }),
        "directional" => Some(LightKind::Directional { direction: ahead, irradiance: strength }),
        "spot" => {
            let cone = |key: &str| light.inner("spot").and_then(|spot| spot.number(key));
            let angle = cone("outerConeAngle").map_or(45.0, f64::to_degrees);
            if !(1e-3..=90.0 + 1e-9).contains(&angle) {
                reader.lost(Fate::Approximated, here(), "the cone of a spot is brought to within 0.001 and 90 degrees");
            }
            let angle = angle.clamp(1e-3, 90.0);
            let inner = cone("innerConeAngle").map_or(0.0, f64::to_degrees).clamp(0.0, angle);
            let inner = if inner >= angle * (1.0 - SHARP) { angle } else { inner };
            if inner < angle {
                let message = "between its cones a spot falls off linearly with the angle, in glTF as programs like it";
                reader.lost(Fate::Approximated, here(), message);
            }
            // Far from the origin a step of 1 may be none.
            let step = position.iter().fold(1.0, |most: f64, x| most.max(x.abs() * 1e-3));
            let target = [0, 1, 2].map(|axis: usize| position[axis] + ahead[axis] * step);
            Some(LightKind::Spot { position, target, intensity: strength, angle, inner })
        }
        other => {
            reader.lost(Fate::Dropped, here(), format!("a light of the type `{}` is left out", shown(other)));
            None
        }
    }
}
