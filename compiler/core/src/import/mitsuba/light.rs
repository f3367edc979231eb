//! Lights without a surface.

use super::plugin::Plugin;
use super::surface::World;
use crate::diag::Origin;
use crate::formats::mitsuba::names::ENVIRONMENT;
use crate::import::Builder;
use crate::import::color::Use;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Affine, Color, ColorOrTexture, Encoding, LightKind, Vec3, length, normalized, sub};

/// A light of the scene.
pub fn add<'e>(plugin: Plugin<'e>, world: &World<'e>, reader: &mut Reader<'_>, to: &mut Builder) {
    let at = Origin::from(plugin.span());
    plugin.pass(&["sampling_weight", "samples", "cache"]);
    let kind = match plugin.kind() {
        "constant" => {
            let radiance = plugin.color("radiance", Use::Light, reader).unwrap_or(Color::Grey(1.0));
            Some(LightKind::environment(radiance.into()))
        }
        "envmap" => envmap(plugin, world, reader, to),
        "point" => {
            let map = plugin.transform("to_world", reader);
            let position = plugin.vector("position", reader).unwrap_or([0.0; 3]);
            Some(LightKind::Point { position: map.point(position), intensity: intensity(plugin, reader) })
        }
        "spot" => {
            let map = plugin.transform("to_world", reader);
            let angle = plugin.float_in("cutoff_angle", (1e-3, 90.0), 20.0, reader);
            let inner = plugin.float("beam_width", reader).unwrap_or(angle * 0.75).clamp(0.0, angle);
            plugin.drop(Fate::Dropped, &["texture"], "a spot has one color", reader);
            let position = map.point([0.0; 3]);
            let target = map.point([0.0, 0.0, 1.0]);
            Some(LightKind::Spot { position, target, intensity: intensity(plugin, reader), angle, inner })
        }
        "directional" => {
            let direction = direction(plugin, reader);
            let irradiance = plugin.color("irradiance", Use::Light, reader).unwrap_or(Color::Grey(1.0));
            direction.map(|direction| LightKind::Directional { direction, irradiance })
        }
        other => {
            let message = format!("the light `{}` is left out: it is not read", shown(other));
            reader.lost(Fate::Dropped, plugin.span(), message);
            plugin.element.children.iter().for_each(|child| child.used.set(true));
            None
        }
    };
    plugin.finish(reader);
    if let Some(kind) = kind {
        let id = plugin.id();
        to.light(reader, if id.is_empty() { plugin.kind() } else { id }, kind, &at);
    }
}

fn intensity(plugin: Plugin<'_>, reader: &mut Reader<'_>) -> Color {
    plugin.color("intensity", Use::Light, reader).unwrap_or(Color::Grey(1.0))
}

/// Where parallel light travels to.
fn direction(plugin: Plugin<'_>, reader: &mut Reader<'_>) -> Option<Vec3> {
    let map = plugin.transform("to_world", reader);
    let along = plugin.vector("direction", reader).unwrap_or([0.0, 0.0, 1.0]);
    let found = normalized(map.vector(along));
    if found.is_none() {
        reader.lost(Fate::Dropped, plugin.span(), "a light without a direction is left out");
    }
    found
}

fn envmap<'e>(plugin: Plugin<'e>, world: &World<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Option<LightKind> {
    let path = world.path(plugin, "filename", reader)?;
    let at = Origin::from(plugin.span());
    let scale = plugin.float("scale", reader).unwrap_or(1.0).max(0.0);
    let map = plugin.transform("to_world", reader);
    let encoding = match plugin.float("gamma", reader) {
        Some(1.0) => Some(Encoding::Linear),
        _ => None,
    };
    let texture = to.texture(reader, &path, encoding, [1.0; 3], &at)?;
    let texture = to.floats(reader, texture, &at)?;
    // The Scene's directions of an image become Mitsuba's, then those of the file's transform.
    let turn = rotation(&inverse(&ENVIRONMENT).then(&map));
    let turn = turn.unwrap_or_else(|| {
        let message = "an environment that is scaled or mirrored is only turned";
        reader.lost(Fate::Dropped, plugin.span_of("to_world"), message);
        inverse(&ENVIRONMENT)
    });
    Some(LightKind::Environment { radiance: ColorOrTexture::Texture(texture), tint: Color::Grey(scale), turn })
}

/// The inverse of a rotation: its transpose.
fn inverse(map: &Affine) -> Affine {
    let entry = |row: usize, column: usize| map.rows[column][row];
    Affine { rows: [0, 1, 2].map(|row| [entry(row, 0), entry(row, 1), entry(row, 2), 0.0]) }
}

/// The rotation of a map, without its translation and an even scale; none where it does something else to directions.
pub fn rotation(map: &Affine) -> Option<Affine> {
    let columns = [0, 1, 2].map(|column: usize| [0, 1, 2].map(|row: usize| map.rows[row][column]));
    let unit = [normalized(columns[0])?, normalized(columns[1])?, normalized(columns[2])?];
    let sizes = columns.map(length);
    let even = sizes.iter().all(|size| (size / sizes[0] - 1.0).abs() < 1e-4);
    let rows = [0, 1, 2].map(|row: usize| [unit[0][row], unit[1][row], unit[2][row], 0.0]);
    let turn = straightened(&Affine { rows })?;
    (even && length(sub(columns[2], unit[2].map(|x| x * sizes[0]))) <= 1e-4 * sizes[0]).then_some(turn)
}

/// A rotation to within single precision, as texts have them, made one to double precision.
fn straightened(map: &Affine) -> Option<Affine> {
    use crate::ir::{cross, dot};
    let column = |at: usize| [0, 1, 2].map(|row: usize| map.rows[row][at]);
    let (x, y, z) = (column(0), column(1), column(2));
    if dot(x, y).abs() > 1e-4 || dot(y, z).abs() > 1e-4 || dot(x, z).abs() > 1e-4 || map.determinant() < 0.0 {
        return None;
    }
    let z = normalized(z)?;
    let x = normalized(sub(x, z.map(|part| part * dot(x, z))))?;
    let y = cross(z, x);
    Some(Affine { rows: [0, 1, 2].map(|row: usize| [x[row], y[row], z[row], 0.0]) })
}
