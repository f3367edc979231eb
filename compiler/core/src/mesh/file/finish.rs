//! What all mesh files have in common once they are decoded: finite numbers, unit normals.

#[cfg(test)]
pub(super) use super::polygons::Faces;
use super::{FileError, Note};
use crate::ir::normalized;
use crate::mesh::smooth::Face;
use crate::mesh::{Geometry, faceted, is_unit};

/// Checks the numbers of a geometry whose indices are in range, and makes its normals whole. `place` says where a vertex
/// stands in the file.
pub(super) fn finish(
    geometry: &mut Geometry,
    notes: &mut Vec<Note>,
    place: impl Fn(usize) -> String,
) -> Result<(), FileError> {
    if let Some(at) = geometry.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let message = format!("the position of vertex {at} is not finite in single precision");
        return Err(FileError::new(place(at), message).help("repair the mesh in the program that made the file"));
    }
    if let Some(uvs) = &mut geometry.uvs {
        let mut unfit = Found::default();
        for (at, uv) in uvs.iter_mut().enumerate().filter(|(_, uv)| !uv.iter().all(|x| x.is_finite())) {
            unfit.add(at);
            *uv = [0.0; 2];
        }
        if let Some((first, count)) = unfit.all() {
            notes.push(Note::dropped(place(first), "not finite set to (0, 0)").counting(count, "texture coordinate"));
        }
    }
    let Some(normals) = &geometry.normals else { return Ok(()) };
    let Some(first) = normals.iter().position(|normal| !is_unit(*normal)) else { return Ok(()) };
    mend(geometry, first, notes, place);
    Ok(())
}

/// How many vertices have something, and the first of them.
#[derive(Default)]
struct Found {
    first: usize,
    count: u64,
}

impl Found {
    fn add(&mut self, at: usize) {
        if self.count == 0 {
            self.first = at;
        }
        self.count += 1;
    }

    fn all(&self) -> Option<(usize, u64)> {
        (self.count > 0).then_some((self.first, self.count))
    }
}

/// Makes unit normals of those from vertex `first` on, and new ones of those that are zero or not finite.
fn mend(geometry: &mut Geometry, first: usize, notes: &mut Vec<Note>, place: impl Fn(usize) -> String) {
    let Geometry { positions, normals: Some(normals), triangles, .. } = geometry else { return };
    // Programs write zero or NaN for vertices without faces; their normals are never seen.
    let mut used = vec![false; positions.len()];
    for index in triangles.as_flattened() {
        used[*index as usize] = true;
    }
    let (mut changed, mut unused, mut unfit) = (Found::default(), Found::default(), Found::default());
    for (at, normal) in normals.iter_mut().enumerate().skip(first) {
        if is_unit(*normal) {
            continue;
        }
        match normalized(normal.map(f64::from)) {
            Some(unit) => {
                changed.add(at);
                *normal = unit.map(|x| x as f32);
            }
            None if !used[at] => {
                unused.add(at);
                *normal = [0.0, 0.0, 1.0];
            }
            None => {
                unfit.add(at);
                *normal = [0.0; 3];
            }
        }
    }
    let help = "`|> faceted()` or `|> smooth()` behind the file makes all normals anew";
    if let Some((first, count)) = unfit.all() {
        let many = used.iter().filter(|used| **used).count() as u64;
        if count == many {
            geometry.normals = None;
            let note = Note::warn(place(first), "that are zero or not finite left out, and no others are there");
            notes.push(note.counting(count, "normal").help(help));
            return;
        }
        from_faces(geometry);
        let note =
            Note::warn(place(first), "that cannot be used, zero or not finite, computed from the faces around it");
        notes.push(note.counting(count, "normal").help(help));
    }
    if let Some((first, count)) = changed.all() {
        notes.push(Note::lengths(place(first), "brought to unit length").counting(count, "normal"));
    }
    if let Some((first, count)) = unused.all() {
        let note = Note::info(place(first), "that cannot be used set to +z, at vertices without faces");
        notes.push(note.counting(count, "normal"));
    }
}

/// Gives vertices with the normal zero that of the faces around them, weighted by their angles.
fn from_faces(geometry: &mut Geometry) {
    let Some(mut normals) = geometry.normals.take() else { return };
    let mut sums: std::collections::BTreeMap<u32, [f64; 3]> = std::collections::BTreeMap::new();
    for triangle in &geometry.triangles {
        if triangle.iter().all(|corner| normals[*corner as usize] != [0.0; 3]) {
            continue;
        }
        let Some(face) = Face::new(*triangle, geometry) else { continue };
        for (corner, angle) in triangle.iter().zip(face.angles) {
            let sum = sums.entry(*corner).or_default();
            for (sum, x) in sum.iter_mut().zip(face.normal) {
                *sum += angle * x;
            }
        }
    }
    for (at, normal) in normals.iter_mut().enumerate().filter(|(_, normal)| **normal == [0.0; 3]) {
        let unit = sums.get(&(at as u32)).and_then(|sum| normalized(*sum)).unwrap_or([0.0, 0.0, 1.0]);
        *normal = unit.map(|x| x as f32);
    }
    geometry.normals = Some(normals);
}

/// The geometry with the normals of its faces. Triangles without area are left out.
pub(super) fn flat(geometry: Geometry, notes: &mut Vec<Note>) -> Result<Geometry, FileError> {
    let (made, dropped) = faceted(geometry).map_err(|error| FileError::new("", error.message))?;
    if dropped > 0 {
        notes.push(Note::baked("", "without area left out").counting(dropped as u64, "triangle"));
    }
    Ok(made)
}
