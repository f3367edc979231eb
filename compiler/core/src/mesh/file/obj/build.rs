//! From the statements of an OBJ file to meshes and parts, and what is to be said of them.

use std::collections::{BTreeMap, BTreeSet};

use super::super::finish::finish;
use super::super::model::{Model, Part, Unique};
use super::super::mtl::{Materials, Placing};
use super::super::polygons::Cut;
use super::super::{FileError, Note, plural};
use super::{Corner, MOST_COMPARED, NONE, Reader, Run, Unread, shown, words};
use crate::ir::Affine;
use crate::mesh::{Geometry, smooth_groups};

/// The triangles of one part and material, and their smoothing groups.
struct Gathered<'r> {
    run: &'r Run,
    triangles: Vec<[u32; 3]>,
    groups: Vec<u32>,
}

impl Reader<'_> {
    /// Notes what was not read.
    fn say(&self, notes: &mut Vec<Note>) {
        for (what, (line, count)) in &self.unread {
            let dropped = |message: &str| Note::dropped(format!("line {line}"), message);
            notes.push(match what {
                Unread::AbsentUvs => {
                    dropped("used by faces, but the file has none").counting(*count, "texture coordinate")
                }
                Unread::AbsentNormals => dropped("used by faces, but the file has none").counting(*count, "normal"),
                Unread::Colors => dropped("not read").counting(*count, "vertex color"),
                Unread::Surfaces => dropped("not read").counting(*count, "free-form surface"),
                Unread::Curves => dropped("curves and what belongs to free-form surfaces are not read").slight(),
                Unread::Lines => dropped("points and lines are not read").slight(),
                Unread::Weights => {
                    dropped("weights of rational curves, the fourth number of a position, are not read").slight()
                }
                Unread::Materials => Note::materials(format!("line {line}"), "a shape gets its own by `with`").slight(),
                Unread::Attributes => dropped("display and rendering attributes are not read").slight(),
                Unread::Maps => dropped("textures that stand outside of materials (`usemap`) are not read"),
            });
        }
        if let Some((line, word, count)) = &self.unknown {
            let message = format!("{} not understood, the first is `{word}`", plural(*count, "line"));
            notes.push(Note::dropped(format!("line {line}"), message).help("is this an OBJ file?"));
        }
    }

    /// The triangles of all faces.
    fn cut(&mut self, notes: &mut Vec<Note>) -> Result<Cut, FileError> {
        let faces = std::mem::take(&mut self.faces);
        let cut = faces.finish(|corner| self.positions[self.corners[corner as usize][0] as usize], notes);
        cut.map_err(|error| match &self.unknown {
            Some((line, word, _)) => error.help(format!("line {line} begins with `{word}`: is this an OBJ file?")),
            None => error,
        })
    }

    /// The smoothing group of each triangle; empty where there are no groups.
    fn groups(&self, cut: &Cut) -> Vec<u32> {
        let mut groups = Vec::new();
        if !self.smoothing.is_empty() {
            groups.resize(cut.triangles.len(), 0);
        }
        for (at, (first, group)) in self.smoothing.iter().enumerate() {
            let end = self.smoothing.get(at + 1).map_or(cut.triangles.len(), |(next, _)| cut.place(*next));
            if let Some(range) = groups.get_mut(cut.place(*first)..end) {
                range.fill(*group);
            }
        }
        groups
    }

    pub(super) fn finish(mut self, bytes: &[u8]) -> Result<(Geometry, Vec<Note>), FileError> {
        let mut notes = Vec::new();
        self.say(&mut notes);
        let cut = self.cut(&mut notes)?;
        let groups = self.groups(&cut);
        let mut newest = vec![NONE; self.positions.len()];
        let geometry = self.build(&cut.triangles, &groups, None, &mut newest, bytes, &mut notes)?;
        Ok((geometry, notes))
    }

    pub(super) fn model(
        mut self,
        bytes: &[u8],
        materials: Materials,
        mut notes: Vec<Note>,
    ) -> Result<(Model, Vec<Note>), FileError> {
        self.say(&mut notes);
        let cut = self.cut(&mut notes)?;
        let (triangles, groups) = (&cut.triangles, self.groups(&cut));
        // In the order in which parts and materials come first.
        let mut ranks = BTreeMap::new();
        let mut parts: Vec<Gathered<'_>> = Vec::new();
        for (at, run) in self.runs.iter().enumerate() {
            let end = self.runs.get(at + 1).map_or(triangles.len(), |next| cut.place(next.first));
            let range = cut.place(run.first).min(end)..end;
            if range.is_empty() {
                continue;
            }
            let rank = *ranks.entry((&run.part, &run.material)).or_insert(parts.len());
            if rank == parts.len() {
                parts.push(Gathered { run, triangles: Vec::new(), groups: Vec::new() });
            }
            parts[rank].triangles.extend_from_slice(&triangles[range.clone()]);
            parts[rank].groups.extend_from_slice(groups.get(range).unwrap_or_default());
        }
        let mut model = Model::default();
        let mut names = Unique::default();
        let mut newest = vec![NONE; self.positions.len()];
        let mut missing = BTreeSet::new();
        let mut several: BTreeMap<&[u8], BTreeSet<&[u8]>> = BTreeMap::new();
        for Run { first: _, part, material } in &self.runs {
            several.entry(part).or_default().insert(material);
        }
        for Gathered { run: Run { first: _, part, material }, triangles: own, groups } in parts {
            let surface = materials.find(material);
            if surface.is_none() && !material.is_empty() {
                missing.insert(shown(material));
            }
            let placing = surface.and_then(|surface| materials.placings[surface].as_ref());
            let geometry = self.build(&own, &groups, placing, &mut newest, bytes, &mut notes)?;
            let several = several.get(part.as_slice()).is_some_and(|all| all.len() > 1);
            let name = String::from_utf8_lossy(part).into_owned();
            let name = match (several, name.is_empty()) {
                (false, _) => name,
                (true, true) => String::from_utf8_lossy(material).into_owned(),
                (true, false) => format!("{name} {}", String::from_utf8_lossy(material)),
            };
            let name = names.name(&name);
            model.parts.push(Part { name, mesh: model.meshes.len(), surface, transform: Affine::IDENTITY });
            model.meshes.push((String::from_utf8_lossy(part).into_owned(), geometry));
        }
        if let Some(first) = missing.first() {
            let message = format!("{} in no library, the first is `{first}`", plural(missing.len() as u64, "material"));
            notes.push(Note::dropped("", message));
        }
        model.surfaces = materials.surfaces;
        Ok((model, notes))
    }

    /// The mesh of some triangles over the corners, of these smoothing groups. `newest` is as long as the positions and full of
    /// [`NONE`], also afterwards.
    fn build(
        &self,
        triangles: &[[u32; 3]],
        groups: &[u32],
        placing: Option<&Placing>,
        newest: &mut [u32],
        bytes: &[u8],
        notes: &mut Vec<Note>,
    ) -> Result<Geometry, FileError> {
        let total = triangles.len() as u64 * 3;
        // Per corner of a triangle: faces of fewer than three corners do not count.
        let having = |list: usize| {
            let has = |corner: &&u32| self.corners[**corner as usize][list] != NONE;
            triangles.as_flattened().iter().filter(has).count() as u64
        };
        let mut complete = |list: usize, what: &'static str| {
            let count = having(list);
            if count > 0 && count < total {
                let note = Note::dropped("", "left out, since other corners of the same part have none");
                notes.push(note.counting(count, what));
            }
            count == total
        };
        let (with_uvs, with_normals) = (complete(1, "texture coordinate"), complete(2, "normal"));
        let mut geometry = Geometry {
            positions: Vec::new(),
            normals: with_normals.then(Vec::new),
            uvs: with_uvs.then(Vec::new),
            triangles: Vec::with_capacity(triangles.len()),
        };
        // For each position `newest` has the newest vertex made from it, `made` for each vertex the one before it and its
        // corner.
        let mut made: Vec<(u32, Corner)> = Vec::new();
        for triangle in triangles {
            geometry.triangles.push(triangle.map(|corner| {
                let [position, uv, normal] = self.corners[corner as usize];
                let key = [position, if with_uvs { uv } else { NONE }, if with_normals { normal } else { NONE }];
                let mut at = newest[position as usize];
                for _ in 0..MOST_COMPARED {
                    if at == NONE {
                        break;
                    }
                    let (before, other) = made[at as usize];
                    if other == key {
                        return at;
                    }
                    at = before;
                }
                let vertex = made.len() as u32;
                made.push((std::mem::replace(&mut newest[position as usize], vertex), key));
                geometry.positions.push(self.positions[position as usize]);
                if let Some(uvs) = &mut geometry.uvs {
                    uvs.push(self.uvs[uv as usize]);
                }
                if let Some(normals) = &mut geometry.normals {
                    normals.push(self.normals[normal as usize]);
                }
                vertex
            }));
        }
        for (_, [position, _, _]) in &made {
            newest[*position as usize] = NONE;
        }
        finish(&mut geometry, notes, |vertex| {
            let [_, uv, normal] = made[vertex].1;
            let fit = self.uvs.get(uv as usize).is_none_or(|uv| uv.iter().all(|x| x.is_finite()));
            if fit { line_of(bytes, b"vn", normal) } else { line_of(bytes, b"vt", uv) }
        })?;
        if let (Some(placing), Some(uvs)) = (placing, &mut geometry.uvs) {
            uvs.iter_mut().for_each(|uv| *uv = placing.apply(*uv));
            notes.push(Note::baked("", "the options `-s` and `-o` of a texture are in the texture coordinates"));
        }
        if geometry.normals.is_none() && groups.iter().any(|group| *group != 0) {
            return Ok(self.smoothed(geometry, groups, notes));
        }
        Ok(geometry)
    }

    /// The mesh with the normals that its smoothing groups ask for.
    fn smoothed(&self, geometry: Geometry, groups: &[u32], notes: &mut Vec<Note>) -> Geometry {
        let count = geometry.triangles.len();
        match smooth_groups(&geometry, groups) {
            // Without any triangle that has an area there are no normals.
            Ok(made) if !made.triangles.is_empty() => {
                let place = self.first_smooth.map_or(String::new(), |line| format!("line {line}"));
                notes.push(Note::baked(place, "normals are computed from smoothing groups"));
                let gone = count - made.triangles.len();
                if gone > 0 {
                    notes.push(Note::baked("", "without area left out").counting(gone as u64, "triangle"));
                }
                made
            }
            Ok(_) | Err(_) => geometry,
        }
    }
}

/// The line of statement `index` (from 0) with this keyword; slow, for messages.
fn line_of(bytes: &[u8], keyword: &[u8], index: u32) -> String {
    let is = |line: &[u8]| words(line).next() == Some(keyword);
    let mut lines = bytes.split(|byte| *byte == b'\n').enumerate().filter(|(_, line)| is(line));
    lines.nth(index as usize).map_or(String::new(), |(line, _)| format!("line {}", line + 1))
}
