//! Binary PLY: element after element, each by the fast path or by ply-rs-bw.

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{
    Addable, ElementDef, Property as Value, PropertyAccess, PropertyAccessResult, PropertyDef, PropertyType, ScalarType,
};

use super::header::{Element, Encoding, Kind, Scalar};
use super::{COLUMNS, Faces, File, FileError, List, Note, Vertices, add, fast, shown, too_short};

/// Reads the elements after the header.
pub(super) fn read(file: &File<'_>, notes: &mut Vec<Note>, quick: bool) -> Result<(Vertices, Faces), FileError> {
    let big = file.header.encoding == Encoding::Big;
    let mut at = file.header.payload;
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    for (index, element) in file.header.elements.iter().enumerate() {
        let left = file.bytes.len() - at;
        let least = u128::from(element.count) * element.least_bytes() as u128;
        if least > left as u128 {
            return Err(too_short(element, u64::try_from(least).unwrap_or(u64::MAX), left, file.header));
        }
        if index == file.layout.vertex {
            let read = if quick { fast::vertices(file, at, big) } else { None };
            at = match read {
                Some((read, end)) => {
                    vertices = read;
                    end
                }
                None => read_vertices(file, element, at, big, &mut vertices)?,
            };
        } else if let Some(list) = file.layout.list(index) {
            let end = if quick && !list.strip { fast::faces(file, list, at, big, &mut faces) } else { None };
            at = match end {
                Some(end) => end?,
                None => read_lists(file, list, at, big, &mut faces)?,
            };
        } else {
            at = skip(file.bytes, at, element, element.count, big)?;
        }
    }
    if at < file.bytes.len() {
        let message = format!("{} bytes after the last element are not read", file.bytes.len() - at);
        notes.push(Note::warn(format!("byte {at}"), message));
    }
    Ok((vertices, faces))
}

/// The first byte of a vertex that has been read before.
pub(super) fn place_of_vertex(file: &File<'_>, vertex: usize) -> String {
    let big = file.header.encoding == Encoding::Big;
    let mut at = file.header.payload;
    for element in &file.header.elements[..file.layout.vertex] {
        match skip(file.bytes, at, element, element.count, big) {
            Ok(end) => at = end,
            Err(error) => return error.place,
        }
    }
    match skip(file.bytes, at, file.vertex(), vertex as u64, big) {
        Ok(end) => format!("byte {end}"),
        Err(error) => error.place,
    }
}

/// The end of `count` items of an element that begins at byte `at`.
fn skip(bytes: &[u8], mut at: usize, element: &Element, count: u64, big: bool) -> Result<usize, FileError> {
    let cut = |at: usize| {
        FileError::new(format!("byte {at}"), format!("the file ends within element `{}`", shown(&element.name)))
            .help("the file is cut off, or a count is wrong")
    };
    if let Some(stride) = element.stride() {
        // Nothing to read, however many there are.
        if stride == 0 {
            return Ok(at);
        }
        let size = usize::try_from(count).ok().and_then(|count| count.checked_mul(stride));
        return size.and_then(|size| at.checked_add(size)).filter(|end| *end <= bytes.len()).ok_or_else(|| cut(at));
    }
    for _ in 0..count {
        for property in &element.properties {
            let size = match property.kind {
                Kind::One(scalar) => scalar.size(),
                Kind::List(length, item) => {
                    let word = bytes.get(at..at + length.size()).ok_or_else(|| cut(at))?;
                    let items = integer(word, length, big);
                    let items = usize::try_from(items).map_err(|_| {
                        let message = format!("list `{}` has length {items}", shown(&property.name));
                        FileError::new(format!("byte {at}"), message)
                    })?;
                    items.saturating_mul(item.size()).saturating_add(length.size())
                }
            };
            at = at.checked_add(size).filter(|end| *end <= bytes.len()).ok_or_else(|| cut(at))?;
        }
    }
    Ok(at)
}

/// The integer in `word`, which has the size of its type; 0 for the types that are no integers.
pub(super) fn integer(word: &[u8], scalar: Scalar, big: bool) -> i64 {
    let mut bytes = [0; 4];
    for (at, byte) in word.iter().take(4).enumerate() {
        // Little endian from here on.
        bytes[if big { word.len() - 1 - at } else { at }] = *byte;
    }
    let value = u32::from_le_bytes(bytes);
    match scalar {
        Scalar::I8 => i64::from(value as u8 as i8),
        Scalar::I16 => i64::from(value as u16 as i16),
        Scalar::I32 => i64::from(value as i32),
        Scalar::U8 | Scalar::U16 | Scalar::U32 => i64::from(value),
        Scalar::F32 | Scalar::F64 => 0,
    }
}

fn read_vertices(
    file: &File<'_>,
    element: &Element,
    at: usize,
    big: bool,
    vertices: &mut Vertices,
) -> Result<usize, FileError> {
    let columns = file.layout.column_of(element.properties.len());
    let definition = definition(element, |property| columns[property].map(|column| column.to_string()));
    *vertices = Vertices::with_room(file.layout);
    each(file.bytes, at, element, &definition, big, |item, _| {
        vertices.push(item.values);
        Ok(())
    })
}

fn read_lists(file: &File<'_>, list: List, at: usize, big: bool, faces: &mut Faces) -> Result<usize, FileError> {
    let element = &file.header.elements[list.element];
    let definition = definition(element, |property| (property == list.property).then(|| "corners".to_owned()));
    let mut corners: Vec<u32> = Vec::new();
    each(file.bytes, at, element, &definition, big, |item, at| {
        let indices = item.corners.into_iter().map(Ok);
        add(list, indices, file.layout.vertices, &mut corners, faces, || format!("byte {at}"))
    })
}

/// Reads all items of an element by ply-rs-bw and gives each with its first byte to `take`; returns the end.
fn each(
    bytes: &[u8],
    start: usize,
    element: &Element,
    definition: &ElementDef,
    big: bool,
    mut take: impl FnMut(Item, usize) -> Result<(), FileError>,
) -> Result<usize, FileError> {
    if element.properties.is_empty() {
        return Ok(start);
    }
    let parser = Parser::<Item>::new();
    let mut rest = &bytes[start..];
    for number in 0..element.count {
        let at = bytes.len() - rest.len();
        let item = if big {
            parser.read_big_endian_element(&mut rest, definition)
        } else {
            parser.read_little_endian_element(&mut rest, definition)
        };
        let item = item.map_err(|error| {
            let name = shown(&element.name);
            let cut = error.kind() == std::io::ErrorKind::UnexpectedEof;
            let message = if cut {
                format!("the file ends within item {number} of {} of element `{name}`", element.count)
            } else {
                // The library's messages have several lines, the first says what is wrong.
                let reason = error.to_string();
                let reason = reason.lines().next().unwrap_or_default();
                format!("item {number} of element `{name}` cannot be read: {}", shown(reason))
            };
            FileError::new(format!("byte {at}"), message).help("the file is cut off or damaged")
        })?;
        take(item, at)?;
    }
    Ok(bytes.len() - rest.len())
}

/// The element for ply-rs-bw. Properties that are read get the name by which [`Item`] knows them, others a blank and a
/// number.
fn definition(element: &Element, name: impl Fn(usize) -> Option<String>) -> ElementDef {
    let mut definition = ElementDef::new(element.name.clone());
    for (at, property) in element.properties.iter().enumerate() {
        let kind = match property.kind {
            Kind::One(scalar) => PropertyType::Scalar(scalar_type(scalar)),
            Kind::List(length, item) => PropertyType::List(scalar_type(length), scalar_type(item)),
        };
        let name = name(at).unwrap_or_else(|| format!(" {at}"));
        definition.properties.add(PropertyDef::new(name, kind));
    }
    definition
}

fn scalar_type(scalar: Scalar) -> ScalarType {
    match scalar {
        Scalar::I8 => ScalarType::Char,
        Scalar::U8 => ScalarType::UChar,
        Scalar::I16 => ScalarType::Short,
        Scalar::U16 => ScalarType::UShort,
        Scalar::I32 => ScalarType::Int,
        Scalar::U32 => ScalarType::UInt,
        Scalar::F32 => ScalarType::Float,
        Scalar::F64 => ScalarType::Double,
    }
}

/// A vertex or a face.
struct Item {
    values: [f32; COLUMNS],
    corners: Vec<i64>,
}

impl PropertyAccess for Item {
    fn new() -> Self {
        Self { values: [0.0; COLUMNS], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Value) -> PropertyAccessResult {
        if name == "corners" {
            self.corners = match property {
                Value::ListChar(all) => all.into_iter().map(i64::from).collect(),
                Value::ListUChar(all) => all.into_iter().map(i64::from).collect(),
                Value::ListShort(all) => all.into_iter().map(i64::from).collect(),
                Value::ListUShort(all) => all.into_iter().map(i64::from).collect(),
                Value::ListInt(all) => all.into_iter().map(i64::from).collect(),
                Value::ListUInt(all) => all.into_iter().map(i64::from).collect(),
                Value::ListFloat(_)
                | Value::ListDouble(_)
                | Value::Char(_)
                | Value::UChar(_)
                | Value::Short(_)
                | Value::UShort(_)
                | Value::Int(_)
                | Value::UInt(_)
                | Value::Float(_)
                | Value::Double(_) => return PropertyAccessResult::UnsupportedType,
            };
            return PropertyAccessResult::Set;
        }
        let Some(column) = name.parse().ok().and_then(|column: usize| self.values.get_mut(column)) else {
            return PropertyAccessResult::Ignored;
        };
        match property.to_f32_lossy() {
            Some(value) => {
                *column = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}
