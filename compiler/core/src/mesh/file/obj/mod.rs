//! OBJ files: positions, texture coordinates, normals, and faces in objects and groups.
//!
//! Own code instead of the crate tobj, which gives errors without a line, takes index 0 for a missing one, reads `l`
//! lines as faces and overflows on negative indices before the first element. The tests compare the two on good files.

mod build;

use std::collections::BTreeMap;
use std::str::FromStr;

use super::model::Model;
use super::mtl::Materials;
use super::polygons::Faces;
use super::text::{file_name, lines, no_number, number, text};
use super::{Beside, FileError, Note, missing_part};
use crate::mesh::Geometry;

const NONE: u32 = u32::MAX;

/// How many vertices at one position are compared before a new one is made: the tip of a fan of a million triangles with
/// own normals would else take the square of that.
const MOST_COMPARED: usize = 64;

/// Reads the file, or the faces in the object or group called `part`.
pub(super) fn read(bytes: &[u8], part: Option<&str>) -> Result<(Geometry, Vec<Note>), FileError> {
    let bytes = &*text(bytes)?;
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
    let bytes = &*text(bytes)?;
    let mut reader = Reader { selected: true, split: true, ..Reader::default() };
    reader.run(bytes)?;
    reader.check_forward_indices()?;
    let mut notes = Vec::new();
    let mut materials = Materials::default();
    for (line, written) in std::mem::take(&mut reader.libraries) {
        library(&written, line, beside, &mut materials, &mut notes);
    }
    reader.model(bytes, materials, notes)
}

/// Reads the libraries that a statement `mtllib` names. Names may contain blanks, and a statement several names.
fn library(written: &[u8], line: usize, beside: &mut Beside<'_>, materials: &mut Materials, notes: &mut Vec<Note>) {
    let place = format!("line {line}");
    let whole = String::from_utf8_lossy(written).into_owned();
    let several = whole.to_ascii_lowercase().contains(".mtl ");
    let names: Vec<&str> =
        if several { whole.split_whitespace().take_while(|name| *name != "#").collect() } else { vec![&whole] };
    let mut read = |name: &str, notes: &mut Vec<Note>| {
        let (path, absolute) = file_name(name);
        let library = beside(path)?;
        if absolute {
            let message = format!("of an absolute path only `{}` is looked for", super::shown(path));
            notes.push(Note::warn(place.clone(), message));
        }
        materials.read((*library).as_ref(), path, notes);
        Ok(())
    };
    // A name with blanks may look like several.
    if several && read(&whole, notes).is_ok() {
        return;
    }
    for name in names {
        if let Err(message) = read(name, notes) {
            let message: String = message;
            notes.push(Note::materials(place.clone(), &message));
        }
    }
}

/// The names of the objects and groups that have faces.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<String>, FileError> {
    let mut reader = Reader { selected: true, ..Reader::default() };
    reader.run(&text(bytes)?)?;
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
    /// What is not read: for each kind of thing the first line and how often.
    unread: BTreeMap<Unread, (usize, u64)>,
    unknown: Option<(usize, String, u64)>,
    /// The current smoothing group, 0 for none; and where groups begin among the triangles, with the first line.
    group: u32,
    smoothing: Vec<(usize, u32)>,
    first_smooth: Option<usize>,
    /// Whether the faces are to be told apart by their material, the current one, and whether anything that tells them
    /// apart has changed since the last face.
    split: bool,
    material: Vec<u8>,
    same: bool,
    runs: Vec<Run>,
    /// Statements that name material libraries, with their lines.
    libraries: Vec<(usize, Vec<u8>)>,
}

/// What an OBJ file may have that is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Unread {
    AbsentUvs,
    AbsentNormals,
    Colors,
    Surfaces,
    Curves,
    Lines,
    Weights,
    Materials,
    Attributes,
    Maps,
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
        lines(bytes, |line, number| self.line(line, number))
    }

    fn line(&mut self, line: &[u8], number: usize) -> Result<(), FileError> {
        let line = match line.iter().position(|byte| *byte == b'#') {
            Some(0) => return self.comment(line, number),
            // Names may contain `#`, numbers may not: a comment behind them ends the line.
            Some(at) if line.starts_with(b"v") || line.starts_with(b"f") => &line[..comment(line, at)],
            Some(_) | None => line,
        };
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, rest) = (&line[..end], line[end..].trim_ascii());
        match keyword {
            b"" => Ok(()),
            b"v" => self.position(rest, number),
            b"vt" => {
                let mut words = words(rest);
                let u = number_of(words.next(), number, "texture coordinate")?;
                let v = match words.next() {
                    Some(word) => number_of(Some(word), number, "texture coordinate")?,
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
                self.group = match rest {
                    b"" | b"off" => 0,
                    b"on" => 1,
                    _ => words(rest).next().and_then(parse).unwrap_or(u32::MAX),
                };
                if self.group != 0 {
                    self.first_smooth.get_or_insert(number);
                }
                Ok(())
            }
            b"mtllib" if self.split => {
                if !self.libraries.iter().any(|(_, known)| known == rest) {
                    self.libraries.push((number, rest.to_vec()));
                }
                Ok(())
            }
            b"usemtl" if self.split => {
                self.material = rest.to_vec();
                self.same = false;
                Ok(())
            }
            b"mtllib" | b"usemtl" => self.skip(Unread::Materials, number),
            b"p" | b"l" => self.skip(Unread::Lines, number),
            b"surf" => self.skip(Unread::Surfaces, number),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"parm" | b"trim" | b"hole"
            | b"scrv" | b"sp" | b"end" | b"con" | b"mg" => self.skip(Unread::Curves, number),
            b"maplib" | b"usemap" => self.skip(Unread::Maps, number),
            b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech" => {
                self.skip(Unread::Attributes, number)
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
                    self.skip(Unread::Weights, number)?;
                }
            }
            (Some(_), _) => self.skip(Unread::Colors, number)?,
        }
        Ok(())
    }

    /// ZBrush writes colors of vertices into comments.
    fn comment(&mut self, line: &[u8], number: usize) -> Result<(), FileError> {
        if line.starts_with(b"#MRGB ") { self.skip(Unread::Colors, number) } else { Ok(()) }
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
        if self.group != self.smoothing.last().map_or(0, |(_, group)| *group) {
            self.smoothing.push((self.faces.triangles.len(), self.group));
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

    fn check_forward_indices(&mut self) -> Result<(), FileError> {
        let lengths = [self.positions.len(), self.uvs.len(), self.normals.len()];
        // Some programs number texture coordinates and normals of which they write none.
        for (list, what) in [(1, Unread::AbsentUvs), (2, Unread::AbsentNormals)] {
            if lengths[list] > 0 {
                continue;
            }
            let mut absent = self.forward.iter().filter(|(other, _, _)| *other == list).map(|(_, _, number)| *number);
            if let Some(line) = absent.next() {
                self.unread.insert(what, (line, absent.count() as u64 + 1));
                self.forward.retain(|(other, _, _)| *other != list);
                self.corners.iter_mut().for_each(|corner| corner[list] = NONE);
            }
        }
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

    /// Counts something that is not read.
    #[expect(clippy::unnecessary_wraps, reason = "it ends the reading of a line")]
    fn skip(&mut self, what: Unread, number: usize) -> Result<(), FileError> {
        self.unread.entry(what).or_insert((number, 0)).1 += 1;
        Ok(())
    }
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

fn parse<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Where the comment begins whose `#` may be the one at `at`; some programs write `1.#IND` for what is no number.
fn comment(line: &[u8], at: usize) -> usize {
    let sign = |at: &usize| line[*at] == b'#' && line[*at - 1] != b'.';
    (at..line.len()).find(sign).unwrap_or(line.len())
}

/// A number that may be infinite or NaN: who needs no normals or texture coordinates can do with those.
fn number_of(word: Option<&[u8]>, line: usize, what: &str) -> Result<f32, FileError> {
    let Some(word) = word else {
        return Err(FileError::new(format!("line {line}"), format!("the {what} has too few numbers")));
    };
    number(word).ok_or_else(|| no_number(format!("line {line}"), word, ""))
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
