//! What all mesh files have in common once they are decoded: finite numbers, unit normals.

#[cfg(test)]
pub(super) use super::polygons::Faces;
use super::{FileError, Note, plural};
use crate::ir::normalized;
use crate::mesh::{Geometry, faceted, is_unit};

/// Checks the numbers of a geometry whose indices are in range, and normalises its normals. `place` says where a vertex
/// stands in the file.
pub(super) fn finish(
    geometry: &mut Geometry,
    notes: &mut Vec<Note>,
    place: impl Fn(usize) -> String,
) -> Result<(), FileError> {
    let Geometry { positions, normals, uvs, triangles } = geometry;
    let unfit = |at: usize, what: &str| {
        FileError::new(place(at), format!("the {what} of vertex {at} is not finite in single precision"))
            .help("repair the mesh in the program that made the file")
    };
    if let Some(at) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(unfit(at, "position"));
    }
    if let Some(at) = uvs.iter().flatten().position(|uv| !uv.iter().all(|x| x.is_finite())) {
        return Err(unfit(at, "texture coordinate"));
    }
    let Some(normals) = normals else { return Ok(()) };
    let Some(first) = normals.iter().position(|normal| !is_unit(*normal)) else { return Ok(()) };
    // Programs write zero or NaN for vertices without faces; their normals are never seen.
    let mut used = vec![false; positions.len()];
    for index in triangles.as_flattened() {
        used[*index as usize] = true;
    }
    // How many, and the first one.
    let mut changed = (0, first);
    let mut unused = (0, first);
    let count = |(count, first): &mut (u64, usize), at: usize| {
        if *count == 0 {
            *first = at;
        }
        *count += 1;
    };
    for (at, normal) in normals.iter_mut().enumerate().skip(first) {
        if is_unit(*normal) {
            continue;
        }
        *normal = match normalized(normal.map(f64::from)) {
            Some(unit) => {
                count(&mut changed, at);
                unit.map(|x| x as f32)
            }
            None if !used[at] => {
                count(&mut unused, at);
                [0.0, 0.0, 1.0]
            }
            None => {
                let what = if normal.iter().all(|x| x.is_finite()) { "zero" } else { "not finite" };
                return Err(FileError::new(place(at), format!("the normal of vertex {at} is {what}")).help(
                    "remove the normals from the file: flat ones are then computed, or `|> smooth()` makes smooth ones",
                ));
            }
        };
    }
    if let (many @ 1.., first) = changed {
        let message = format!("{} brought to unit length", plural(many, "normal"));
        notes.push(Note::lengths(place(first), message));
    }
    if let (many @ 1.., first) = unused {
        let normals = plural(many, "normal");
        let message = format!("{normals} that cannot be used set to +z, at vertices without faces");
        notes.push(Note::info(place(first), message));
    }
    Ok(())
}

/// The geometry with the normals of its faces. Triangles without area are left out.
pub(super) fn flat(geometry: Geometry, notes: &mut Vec<Note>) -> Result<Geometry, FileError> {
    let (made, dropped) = faceted(geometry).map_err(|error| FileError::new("", error.message))?;
    if dropped > 0 {
        let message = format!("{} without area left out", plural(dropped as u64, "triangle"));
        notes.push(Note::baked("", message));
    }
    Ok(made)
}
