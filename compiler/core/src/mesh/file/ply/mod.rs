//! PLY files: the header, what of it a mesh needs, and the way to read the rest.
//!
//! Three ways: [`fast`] for binary vertices of fixed size with 32-bit floats and faces of 32-bit indices, straight from
//! the bytes; [`general`] for every other binary file, through ply-rs-bw; [`ascii`] for text, because ply-rs-bw knows
//! neither `1.`, nor `.5`, nor lines in error messages that count as an editor does.

mod ascii;
mod fast;
mod general;
mod header;

use super::finish::finish;
use super::polygons::Faces;
use super::text::without_mark;
use super::{FileError, Note, shown};
use crate::diag::nearest;
use crate::mesh::Geometry;
use header::{Element, Encoding, Header, Kind, Property};

/// Columns of a vertex: x y z, nx ny nz, u v.
const COLUMNS: usize = 8;

/// What of the file a mesh needs.
struct Layout {
    /// The position of the element in the file.
    vertex: usize,
    /// Polygons, and strips of triangles; one of the two at least.
    face: Option<List>,
    strips: Option<List>,
    /// The property of the vertex in each column; normals and texture coordinates may be missing.
    columns: [Option<usize>; COLUMNS],
    /// Vertices declared, which fits in 32 bits.
    vertices: usize,
}

/// A property that lists vertices, and the element that has it.
#[derive(Clone, Copy)]
struct List {
    element: usize,
    property: usize,
    /// Whether the vertices are a strip of triangles, not a polygon.
    strip: bool,
}

impl Layout {
    /// The list of the element at this position, if it is read.
    fn list(&self, element: usize) -> Option<List> {
        [self.face, self.strips].into_iter().flatten().find(|list| list.element == element)
    }

    fn has_normals(&self) -> bool {
        self.columns[3].is_some()
    }

    fn has_uvs(&self) -> bool {
        self.columns[6].is_some()
    }

    /// The column of each property of the vertex.
    fn column_of(&self, properties: usize) -> Vec<Option<usize>> {
        let column = |property| self.columns.iter().position(|column| *column == Some(property));
        (0..properties).map(column).collect()
    }
}

/// Reads a whole PLY file.
pub(super) fn read(bytes: &[u8]) -> Result<(Geometry, Vec<Note>), FileError> {
    read_by(bytes, true)
}

/// [`read`]; without `fast` the general path also where the fast one would do, for comparison.
fn read_by(bytes: &[u8], fast: bool) -> Result<(Geometry, Vec<Note>), FileError> {
    let bytes = without_mark(bytes);
    let header = Header::parse(bytes)?;
    let mut notes = Vec::new();
    let layout = layout(&header, &mut notes)?;
    let file = File { bytes, header: &header, layout: &layout };
    let (vertices, faces) = match header.encoding {
        Encoding::Ascii => ascii::read(&file, &mut notes)?,
        Encoding::Little | Encoding::Big => general::read(&file, &mut notes, fast)?,
    };
    let Vertices { positions, normals, uvs } = vertices;
    let triangles = faces.finish(|vertex| positions[vertex as usize], &mut notes)?.triangles;
    let mut geometry = Geometry { positions, normals, uvs, triangles };
    finish(&mut geometry, &mut notes, |vertex| file.place_of_vertex(vertex))?;
    Ok((geometry, notes))
}

/// The file with its header understood.
struct File<'a> {
    bytes: &'a [u8],
    header: &'a Header,
    layout: &'a Layout,
}

impl File<'_> {
    fn vertex(&self) -> &Element {
        &self.header.elements[self.layout.vertex]
    }

    /// Where a vertex stands; slow, for messages.
    fn place_of_vertex(&self, vertex: usize) -> String {
        match self.header.encoding {
            Encoding::Ascii => ascii::place_of_vertex(self, vertex),
            Encoding::Little | Encoding::Big => general::place_of_vertex(self, vertex),
        }
    }
}

/// The columns of the vertices.
#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    uvs: Option<Vec<[f32; 2]>>,
}

impl Vertices {
    /// Room for the declared vertices; the caller has made sure that the file is as long.
    fn with_room(layout: &Layout) -> Self {
        Self {
            positions: Vec::with_capacity(layout.vertices),
            normals: layout.has_normals().then(|| Vec::with_capacity(layout.vertices)),
            uvs: layout.has_uvs().then(|| Vec::with_capacity(layout.vertices)),
        }
    }

    fn push(&mut self, [x, y, z, nx, ny, nz, u, v]: [f32; COLUMNS]) {
        self.positions.push([x, y, z]);
        if let Some(normals) = &mut self.normals {
            normals.push([nx, ny, nz]);
        }
        if let Some(uvs) = &mut self.uvs {
            uvs.push([u, v]);
        }
    }
}

/// Adds the polygon or the strip of a list; `corners` is room for it.
fn add(
    list: List,
    indices: impl IntoIterator<Item = Result<i64, FileError>>,
    vertices: usize,
    corners: &mut Vec<u32>,
    faces: &mut Faces,
    place: impl Fn() -> String,
) -> Result<(), FileError> {
    corners.clear();
    for index in indices {
        let index = index?;
        match u32::try_from(index) {
            Ok(corner) if (corner as usize) < vertices => corners.push(corner),
            // A strip ends, and the next one begins.
            _ if list.strip && (index == -1 || index == i64::from(u32::MAX)) => strip(corners, faces),
            _ => return Err(wrong_index(place(), index, vertices)),
        }
    }
    if list.strip {
        strip(corners, faces);
    } else {
        faces.push(corners, place);
    }
    Ok(())
}

/// Adds a strip, of which every other triangle is wound the other way, and empties it. Corners that stand twice join strips to one.
fn strip(corners: &mut Vec<u32>, faces: &mut Faces) {
    for (at, window) in corners.windows(3).enumerate() {
        let [a, b, c] = [window[0], window[1], window[2]];
        if a != b && b != c && a != c {
            faces.triangles.push(if at % 2 == 0 { [a, b, c] } else { [a, c, b] });
        }
    }
    corners.clear();
}

/// An index of a corner that is not there.
fn wrong_index(place: String, index: i64, vertices: usize) -> FileError {
    let error = FileError::new(place, format!("a face uses vertex {index}, but the file has {vertices} vertices"));
    if vertices == 0 { error } else { error.help(format!("indices go from 0 to {}", vertices - 1)) }
}

/// An element that does not fit in what is left of the file.
fn too_short(element: &Element, least: u64, left: usize, header: &Header) -> FileError {
    let name = shown(&element.name);
    let message = format!(
        "element `{name}` declares {} items, which take at least {least} bytes, but {left} are left in the file",
        element.count
    );
    let place = format!("line {}", element.line);
    debug_assert!(element.line <= header.lines, "the element stands in the header");
    FileError::new(place, message).help("the file is cut off, or the count is wrong")
}

fn layout(header: &Header, notes: &mut Vec<Note>) -> Result<Layout, FileError> {
    let find = |name: &str| header.elements.iter().position(|element| element.name == name);
    let missing = |name: &str, why: &str| {
        let known = header.elements.iter().map(|element| element.name.as_str());
        let error = FileError::new("", format!("the file has no element `{name}`"));
        match nearest(name, known) {
            Some(meant) => error.help(format!("is `{}` meant?", shown(meant))),
            None => error.help(why),
        }
    };
    let vertex = find("vertex").ok_or_else(|| missing("vertex", "a mesh needs vertices"))?;
    let (face, strips) = (find("face"), find("tristrips"));
    if face.is_none() && strips.is_none() {
        return Err(missing("face", "a mesh needs faces: this file holds points"));
    }
    let element = &header.elements[vertex];
    let property = |name: &str| element.properties.iter().position(|property| property.name == name);
    let mut columns = [None; COLUMNS];
    for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
        let place = format!("line {}", element.line);
        let message = format!("element `vertex` has no property `{name}`");
        let at = property(name).ok_or_else(|| FileError::new(place.clone(), message))?;
        if matches!(element.properties[at].kind, Kind::List(..)) {
            return Err(FileError::new(place, format!("property `{name}` of element `vertex` is a list")));
        }
        *column = Some(at);
    }
    let scalar = |name: &str| property(name).filter(|at| matches!(element.properties[*at].kind, Kind::One(_)));
    if let [Some(x), Some(y), Some(z)] = ["nx", "ny", "nz"].map(scalar) {
        columns[3..6].copy_from_slice(&[Some(x), Some(y), Some(z)]);
    }
    // What Blender, MeshLab and pbrt-v4, Mitsuba, and older MeshLab write.
    for names in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]] {
        if let [Some(u), Some(v)] = names.map(scalar) {
            columns[6..8].copy_from_slice(&[Some(u), Some(v)]);
            break;
        }
    }
    let list = |element: Option<usize>, strip: bool| {
        let list = |element| Ok(List { element, property: corners(&header.elements[element])?, strip });
        element.map(list).transpose()
    };
    let (face, strips) = (list(face, false)?, list(strips, true)?);
    let count = element.count;
    let vertices = u32::try_from(count).map_err(|_| {
        let place = format!("line {}", element.line);
        FileError::new(place, format!("{count} vertices are more than 32-bit indices can address"))
            .help("the file is damaged, or the mesh must be split")
    })?;
    let layout = Layout { vertex, face, strips, columns, vertices: vertices as usize };
    unread(header, &layout, notes);
    Ok(layout)
}

/// The property of an element that lists its corners, by its usual names, else the only list of integers.
fn corners(element: &Element) -> Result<usize, FileError> {
    let name = shown(&element.name);
    let fault = |message: String| FileError::new(format!("line {}", element.line), message);
    let named = |name: &str| element.properties.iter().position(|property| property.name == name);
    if let Some(at) = named("vertex_indices").or_else(|| named("vertex_index")) {
        return match element.properties[at].kind {
            Kind::List(_, index) if index.is_integer() => Ok(at),
            Kind::List(..) => Err(fault(format!("the corners of element `{name}` are no integers"))),
            Kind::One(_) => Err(fault(format!("the corners of element `{name}` are no list"))),
        };
    }
    let integers =
        |(_, property): &(usize, &Property)| matches!(property.kind, Kind::List(_, index) if index.is_integer());
    let mut lists = element.properties.iter().enumerate().filter(integers);
    match (lists.next(), lists.next()) {
        (Some((at, _)), None) => Ok(at),
        _ => Err(fault(format!("element `{name}` has no property `vertex_indices` or `vertex_index`"))),
    }
}

/// Whether a property that is not read could be seen in an image: colors, texture coordinates, normals.
fn is_seen(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let whole = ["r", "g", "b", "a", "s", "t", "u", "v", "nx", "ny", "nz"];
    let parts = ["red", "green", "blue", "alpha", "color", "colour", "tex", "normal", "opacity"];
    whole.contains(&name.as_str()) || parts.iter().any(|part| name.contains(part))
}

/// A note on every property and element that is not read.
fn unread(header: &Header, layout: &Layout, notes: &mut Vec<Note>) {
    if let Some((line, name)) = &header.texture {
        let message = format!("the texture `{}`, which a comment names, is not read", shown(name));
        notes.push(Note::dropped(format!("line {line}"), message).slight());
    }
    for (at, element) in header.elements.iter().enumerate() {
        let place = format!("line {}", element.line);
        if element.count == 0 {
            continue;
        }
        let list = layout.list(at);
        if at != layout.vertex && list.is_none() {
            let note = Note::dropped(place, format!("element `{}` is not read", shown(&element.name)));
            let seen = is_seen(&element.name) || element.properties.iter().any(|property| is_seen(&property.name));
            // Edges are in no image, whatever their color.
            notes.push(if seen && element.name != "edge" { note } else { note.slight() });
            continue;
        }
        let read = |property: usize| {
            let column = at == layout.vertex && layout.columns.contains(&Some(property));
            column || list.is_some_and(|list| list.property == property)
        };
        let unread = element.properties.iter().enumerate().filter(|(property, _)| !read(*property));
        let (seen, other): (Vec<&str>, Vec<&str>) =
            unread.map(|(_, property)| property.name.as_str()).partition(|name| is_seen(name));
        for (names, is_seen) in [(seen, true), (other, false)] {
            if names.is_empty() {
                continue;
            }
            let listed: Vec<String> = names.iter().take(12).map(|name| format!("`{}`", shown(name))).collect();
            let more = if names.len() > 12 { ", ..." } else { "" };
            let (noun, verb) = if names.len() == 1 { ("property", "is") } else { ("properties", "are") };
            let message =
                format!("the {noun} {}{more} of element `{}` {verb} not read", listed.join(", "), shown(&element.name));
            let note = Note::dropped(place.clone(), message);
            notes.push(if is_seen { note } else { note.slight() });
        }
    }
}

#[cfg(test)]
mod tests;
