//! OBJ files: positions, texture coordinates, normals, and faces in objects and groups.
//!
//! Own code instead of the crate tobj, which gives errors without a line, takes index 0 for a missing one, reads `l`
//! lines as faces and overflows on negative indices before the first element. The tests compare the two on good files.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use super::finish::finish;
use super::model::{Model, Part, Surface, Unique};
use super::polygons::{Cut, Faces};
use super::{Beside, FileError, Note, missing_part, mtl, plural};
use crate::ir::Affine;
use crate::mesh::Geometry;

const NONE: u32 = u32::MAX;

/// How many vertices at one position are compared before a new one is made: the tip of a fan of a million triangles with
/// own normals would else take the square of that.
const MOST_COMPARED: usize = 64;

/// Reads the file, or the faces in the object or group called `part`.
pub(super) fn read(bytes: &[u8], part: Option<&str>) -> Result<(Geometry, Vec<Note>), FileError> {
    let mut reader = Reader { part: part.map(str::as_bytes), selected: part.is_none(), ..Reader::default() };
    reader.run(bytes)?;
    reader.check_forward_indices()?;
    if let Some(part) = part
        && !reader.found
    {
        return Err(missing_part("object or group", part, &reader.names()));
    }
    reader.finish(bytes)
}

/// Reads the objects or groups, one part for each material in each, with the materials of the libraries that it names.
pub(super) fn read_parts(bytes: &[u8], beside: &mut Beside<'_>) -> Result<(Model, Vec<Note>), FileError> {
    let mut reader = Reader { selected: true, split: true, ..Reader::default() };
    reader.run(bytes)?;
    reader.check_forward_indices()?;
    let mut notes = Vec::new();
    let mut surfaces = Vec::new();
    let mut known = BTreeMap::new();
    for (name, line) in std::mem::take(&mut reader.libraries) {
        let path = String::from_utf8_lossy(&name).into_owned();
        match beside(&path) {
            Ok(library) => mtl::read((*library).as_ref(), &path, &mut surfaces, &mut known, &mut notes)?,
            Err(message) => notes.push(Note::warn(format!("line {line}"), message)),
        }
    }
    reader.model(bytes, surfaces, &known, notes)
}

/// The names of the objects and groups that have faces.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<String>, FileError> {
    let mut reader = Reader { selected: true, ..Reader::default() };
    reader.run(bytes)?;
    reader.check_forward_indices()?;
    Ok(reader.names())
}

/// A corner of a face: a position, and a texture coordinate and a normal or [`NONE`].
type Corner = [u32; 3];

/// The three lists that a corner points into.
const LISTS: [&str; 3] = ["position (`v`)", "texture coordinate (`vt`)", "normal (`vn`)"];

#[derive(Default)]
struct Reader<'a> {
    part: Option<&'a [u8]>,
    /// Whether faces are read now, and whether one has been.
    selected: bool,
    found: bool,
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    corners: Vec<Corner>,
    /// Triangles and polygons over `corners`.
    faces: Faces,
    scratch: Vec<u32>,
    /// The current object and groups, and whether they have been named since the last face.
    object: Vec<u8>,
    groups: Vec<u8>,
    fresh: bool,
    /// Names that have faces, with their rank.
    named: BTreeMap<Vec<u8>, usize>,
    /// Indices beyond the end of their list so far: list, index from 0, line.
    forward: Vec<(usize, u32, usize)>,
    /// What is not read: for each reason the first line and how often.
    unread: BTreeMap<&'static str, (usize, u64)>,
    unknown: Option<(usize, String, u64)>,
    /// The first line with a color behind a position, and how many there are.
    colors: Option<(usize, u64)>,
    smoothing: Option<usize>,
    /// Whether the faces are to be told apart by their material, the current one, and whether anything that tells them
    /// apart has changed since the last face.
    split: bool,
    material: Vec<u8>,
    same: bool,
    runs: Vec<Run>,
    /// Material libraries with their lines.
    libraries: Vec<(Vec<u8>, usize)>,
}

/// Faces of one part and one material, from triangle `first` on.
struct Run {
    first: usize,
    part: Vec<u8>,
    material: Vec<u8>,
}

impl Reader<'_> {
    fn run(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        if bytes.is_empty() {
            return Err(FileError::new("", "the file is empty"));
        }
        self.fresh = true;
        let mut joined = Vec::new();
        let mut lines = bytes.split(|byte| *byte == b'\n').enumerate();
        while let Some((index, line)) = lines.next() {
            let number = index + 1;
            let mut line = line.trim_ascii();
            if line.ends_with(b"\\") {
                // A backslash joins the next line.
                joined.clear();
                while let Some(start) = line.strip_suffix(b"\\") {
                    joined.extend_from_slice(start);
                    joined.push(b' ');
                    line = lines.next().map_or(&[][..], |(_, next)| next.trim_ascii());
                }
                joined.extend_from_slice(line);
                self.line(&joined, number)?;
            } else {
                self.line(line, number)?;
            }
        }
        Ok(())
    }

    fn line(&mut self, line: &[u8], number: usize) -> Result<(), FileError> {
        let line = match line.iter().position(|byte| *byte == b'#') {
            // Names may contain `#`, numbers may not: a comment behind them ends the line.
            Some(at) if at == 0 || line.starts_with(b"v") || line.starts_with(b"f") => &line[..at],
            Some(_) | None => line,
        };
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, rest) = (&line[..end], line[end..].trim_ascii());
        match keyword {
            b"" => Ok(()),
            b"v" => self.position(rest, number),
            b"vt" => {
                let mut words = words(rest);
                let u = float(words.next(), number, "texture coordinate")?;
                let v = match words.next() {
                    Some(word) => float(Some(word), number, "texture coordinate")?,
                    None => 0.0,
                };
                self.uvs.push([u, v]);
                Ok(())
            }
            b"vn" => {
                let mut words = words(rest);
                let mut next = || number_of(words.next(), number, "normal");
                let normal = [next()?, next()?, next()?];
                self.normals.push(normal);
                Ok(())
            }
            b"f" | b"fo" => self.face(rest, number),
            b"o" => {
                self.object = rest.to_vec();
                self.select();
                Ok(())
            }
            b"g" => {
                self.groups = rest.to_vec();
                self.select();
                Ok(())
            }
            b"s" => {
                if rest != b"off" && rest != b"0" {
                    self.smoothing.get_or_insert(number);
                }
                Ok(())
            }
            b"mtllib" if self.split => {
                // Names may contain blanks, and a statement several names: only one with an ending is told.
                let several = rest.windows(5).any(|end| end.eq_ignore_ascii_case(b".mtl "));
                let names = if several { words(rest).map(<[u8]>::to_vec).collect() } else { vec![rest.to_vec()] };
                for name in names {
                    if !self.libraries.iter().any(|(known, _)| *known == name) {
                        self.libraries.push((name, number));
                    }
                }
                Ok(())
            }
            b"usemtl" if self.split => {
                self.material = rest.to_vec();
                self.same = false;
                Ok(())
            }
            b"mtllib" | b"usemtl" => {
                self.skip("materials are not read: a shape gets its own by `with`", number);
                Ok(())
            }
            b"p" | b"l" => {
                self.skip("points and lines are not read", number);
                Ok(())
            }
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"mg" => {
                self.skip("curves and free-form surfaces are not read", number);
                Ok(())
            }
            b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech"
            | b"maplib" | b"usemap" => {
                self.skip("display and rendering attributes are not read", number);
                Ok(())
            }
            _ => {
                let unknown = self.unknown.get_or_insert_with(|| (number, shown(keyword), 0));
                unknown.2 += 1;
                Ok(())
            }
        }
    }

    fn position(&mut self, rest: &[u8], number: usize) -> Result<(), FileError> {
        let mut words = words(rest);
        let mut next = || float(words.next(), number, "position");
        let point = [next()?, next()?, next()?];
        self.positions.push(point);
        let further = words.next();
        match (further, words.count()) {
            (None, _) => {}
            (Some(weight), 0) => {
                if float(Some(weight), number, "position")? != 1.0 {
                    self.skip("weights of rational curves, the fourth number of a position, are not read", number);
                }
            }
            (Some(_), _) => self.colors.get_or_insert((number, 0)).1 += 1,
        }
        Ok(())
    }

    fn face(&mut self, rest: &[u8], number: usize) -> Result<(), FileError> {
        if self.fresh {
            self.fresh = false;
            self.name();
        }
        if !self.selected {
            return Ok(());
        }
        self.found = true;
        if self.split && !self.same {
            self.same = true;
            let part = if self.object.is_empty() { &self.groups } else { &self.object };
            let first = self.faces.triangles.len();
            self.runs.push(Run { first, part: part.clone(), material: self.material.clone() });
        }
        self.scratch.clear();
        for word in words(rest) {
            let mut corner = [NONE; 3];
            for (list, part) in word.split(|byte| *byte == b'/').enumerate() {
                let Some(place) = corner.get_mut(list) else {
                    let message = format!("the corner `{}` has more than three indices", shown(word));
                    return Err(FileError::new(format!("line {number}"), message));
                };
                if part.is_empty() && list > 0 {
                    continue;
                }
                *place = self.index(part, list, number, word)?;
            }
            self.scratch.push(self.corners.len() as u32);
            self.corners.push(corner);
            if self.corners.len() as u64 >= u64::from(NONE) {
                return Err(FileError::new(format!("line {number}"), "the file has more than 2^32 corners")
                    .help("split the mesh"));
            }
        }
        self.faces.push(&self.scratch, || format!("line {number}"));
        Ok(())
    }

    /// The index of a corner into list `list`, from 0.
    fn index(&mut self, part: &[u8], list: usize, number: usize, word: &[u8]) -> Result<u32, FileError> {
        let length = [self.positions.len(), self.uvs.len(), self.normals.len()][list] as i64;
        let place = || format!("line {number}");
        let index: i64 = parse(part).ok_or_else(|| {
            FileError::new(place(), format!("`{}` is no corner of a face", shown(word)))
                .help("corners are written `v`, `v/vt`, `v//vn` or `v/vt/vn`")
        })?;
        let from_zero = match index {
            0 => {
                return Err(FileError::new(place(), format!("the corner `{}` has the index 0", shown(word)))
                    .help("indices go from 1, or backwards from -1"));
            }
            1.. => index - 1,
            // Backwards from the newest.
            ..0 => length.saturating_add(index),
        };
        let Some(found) = u32::try_from(from_zero).ok().filter(|found| *found != NONE) else {
            let message = format!("the corner `{}` uses a {} that is not there", shown(word), LISTS[list]);
            return Err(FileError::new(place(), message).help(format!("there are {length} so far")));
        };
        if from_zero >= length {
            // The format allows faces before their vertices; whether they come shows at the end.
            self.forward.push((list, found, number));
        }
        Ok(found)
    }

    fn check_forward_indices(&self) -> Result<(), FileError> {
        let lengths = [self.positions.len(), self.uvs.len(), self.normals.len()];
        match self.forward.iter().find(|(list, index, _)| *index as usize >= lengths[*list]) {
            None => Ok(()),
            Some((list, index, number)) => {
                let message =
                    format!("a face uses {} {}, but there are {}", LISTS[*list], u64::from(*index) + 1, lengths[*list]);
                Err(FileError::new(format!("line {number}"), message).help("the file is cut off or damaged"))
            }
        }
    }

    /// Decides whether the faces that follow are wanted.
    fn select(&mut self) {
        (self.fresh, self.same) = (true, false);
        if let Some(part) = self.part {
            self.selected =
                self.object == part || self.groups == part || words(&self.groups).any(|group| group == part);
        }
    }

    /// Notes the names of a face. A statement `g` may name several groups.
    fn name(&mut self) {
        let several = words(&self.groups).filter(|group| *group != self.object);
        for name in std::iter::once(&self.object[..]).chain(several).filter(|name| !name.is_empty()) {
            if !self.named.contains_key(name) {
                self.named.insert(name.to_vec(), self.named.len());
            }
        }
    }

    fn names(&self) -> Vec<String> {
        let mut ranked: Vec<(usize, String)> =
            self.named.iter().map(|(name, rank)| (*rank, String::from_utf8_lossy(name).into_owned())).collect();
        ranked.sort_unstable();
        ranked.into_iter().map(|(_, name)| name).collect()
    }

    fn skip(&mut self, reason: &'static str, number: usize) {
        self.unread.entry(reason).or_insert((number, 0)).1 += 1;
    }

    /// Notes what was not read.
    fn say(&self, notes: &mut Vec<Note>) {
        for (reason, (line, _)) in &self.unread {
            notes.push(Note::dropped(format!("line {line}"), *reason).slight());
        }
        if let Some((line, count)) = self.colors {
            notes.push(Note::dropped(format!("line {line}"), "not read").counting(count, "vertex color"));
        }
        if let Some((line, word, count)) = &self.unknown {
            let message = format!("{} not understood, the first is `{word}`", plural(*count, "line"));
            notes.push(Note::warn(format!("line {line}"), message).help("is this an OBJ file?"));
        }
    }

    /// The triangles of all faces.
    fn cut(&mut self, notes: &mut Vec<Note>) -> Result<Cut, FileError> {
        let faces = std::mem::take(&mut self.faces);
        faces.finish(|corner| self.positions[self.corners[corner as usize][0] as usize], notes)
    }

    fn finish(mut self, bytes: &[u8]) -> Result<(Geometry, Vec<Note>), FileError> {
        let mut notes = Vec::new();
        self.say(&mut notes);
        let triangles = self.cut(&mut notes)?.triangles;
        let mut newest = vec![NONE; self.positions.len()];
        let geometry = self.build(&triangles, &mut newest, bytes, &mut notes)?;
        Ok((geometry, notes))
    }

    fn model(
        mut self,
        bytes: &[u8],
        surfaces: Vec<Surface>,
        known: &BTreeMap<Vec<u8>, usize>,
        mut notes: Vec<Note>,
    ) -> Result<(Model, Vec<Note>), FileError> {
        self.say(&mut notes);
        let cut = self.cut(&mut notes)?;
        let triangles = &cut.triangles;
        // The triangles of each part and material, in the order in which these come first.
        let mut ranks = BTreeMap::new();
        let mut parts: Vec<(&Run, Vec<[u32; 3]>)> = Vec::new();
        for (at, run) in self.runs.iter().enumerate() {
            let end = self.runs.get(at + 1).map_or(triangles.len(), |next| cut.place(next.first));
            let own = &triangles[cut.place(run.first).min(end)..end];
            if own.is_empty() {
                continue;
            }
            let rank = *ranks.entry((&run.part, &run.material)).or_insert(parts.len());
            if rank == parts.len() {
                parts.push((run, Vec::new()));
            }
            parts[rank].1.extend_from_slice(own);
        }
        let mut model = Model { surfaces, ..Model::default() };
        let mut names = Unique::default();
        let mut newest = vec![NONE; self.positions.len()];
        let mut missing = BTreeSet::new();
        let mut materials: BTreeMap<&[u8], BTreeSet<&[u8]>> = BTreeMap::new();
        for Run { first: _, part, material } in &self.runs {
            materials.entry(part).or_default().insert(material);
        }
        for (Run { first: _, part, material }, own) in parts {
            let geometry = self.build(&own, &mut newest, bytes, &mut notes)?;
            let surface = known.get(material).copied();
            if surface.is_none() && !material.is_empty() {
                missing.insert(shown(material));
            }
            let several = materials.get(part.as_slice()).is_some_and(|all| all.len() > 1);
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
            notes.push(Note::warn("", message));
        }
        Ok((model, notes))
    }

    /// The mesh of some triangles over the corners. `newest` is as long as the positions and full of [`NONE`], also
    /// afterwards.
    fn build(
        &self,
        triangles: &[[u32; 3]],
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
        let mut complete = |list: usize, what: &str| {
            let count = having(list);
            if count > 0 && count < total {
                let message = format!("only {count} of {total} corners have {what}, so none are read");
                notes.push(Note::warn("", message));
            }
            count == total
        };
        let (with_uvs, with_normals) = (complete(1, "texture coordinates"), complete(2, "normals"));
        if let (Some(line), false) = (self.smoothing, with_normals) {
            let note = Note::info(format!("line {line}"), "smoothing groups are not read");
            notes.push(note.help("write `|> smooth(crease: 30deg)` behind the file"));
        }
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
        // Only a normal can be unfit now.
        finish(&mut geometry, notes, |vertex| line_of(bytes, b"vn", made[vertex].1[2]))?;
        Ok(geometry)
    }
}

/// The line of statement `index` (from 0) with this keyword; slow, for messages.
fn line_of(bytes: &[u8], keyword: &[u8], index: u32) -> String {
    let is = |line: &[u8]| line.split(u8::is_ascii_whitespace).next() == Some(keyword);
    let mut lines = bytes.split(|byte| *byte == b'\n').enumerate().filter(|(_, line)| is(line.trim_ascii()));
    lines.nth(index as usize).map_or(String::new(), |(line, _)| format!("line {}", line + 1))
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

fn parse<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A number that may be infinite or NaN: normals that no face uses may be.
fn number_of(word: Option<&[u8]>, line: usize, what: &str) -> Result<f32, FileError> {
    let Some(word) = word else {
        return Err(FileError::new(format!("line {line}"), format!("the {what} has too few numbers")));
    };
    parse(word).ok_or_else(|| FileError::new(format!("line {line}"), format!("`{}` is no number", shown(word))))
}

fn float(word: Option<&[u8]>, line: usize, what: &str) -> Result<f32, FileError> {
    let value = number_of(word, line, what)?;
    if value.is_finite() {
        return Ok(value);
    }
    let message = format!("the {what} is not finite in single precision");
    Err(FileError::new(format!("line {line}"), message).help("repair the mesh in the program that made the file"))
}

/// A word of the file for a message: cut, without control characters.
fn shown(word: &[u8]) -> String {
    super::shown(&String::from_utf8_lossy(&word[..word.len().min(200)]))
}
