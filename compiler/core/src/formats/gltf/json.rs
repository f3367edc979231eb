//! The JSON of a glTF file and its buffers, with places as JSON pointers and every range held against the bytes that are there.

use serde_json::{Map, Value};

use crate::diag::Origin;
use crate::files::{Bytes, VPath};
use crate::formats::shared::source::{LIMIT, REFERENCE, SYNTAX, Source, UNKNOWN, shown};

/// How many times the bytes of all buffers may be read out: meshes share their numbers.
const AGAIN: u64 = 16;

/// An object of the document and where it stands: `/nodes/17`.
#[derive(Clone, Copy)]
pub struct Item<'v> {
    kind: &'static str,
    at: usize,
    map: &'v Map<String, Value>,
}

/// The document.
pub struct Document<'v> {
    /// Its file.
    pub path: &'v VPath,
    root: &'v Map<String, Value>,
    buffers: Vec<Option<Bytes>>,
    /// Bytes that may still be read out.
    left: u64,
}

/// The JSON of a file, and of a GLB its own buffer: where it lies in the file.
pub fn split(bytes: &[u8]) -> Option<(&[u8], Option<std::ops::Range<usize>>)> {
    if !bytes.starts_with(b"glTF") {
        return Some((bytes, None));
    }
    // glTF 2.0, 4.4: a header of 12 bytes, then chunks: length, type, data.
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let chunk = |at: usize, kind: &[u8]| {
        let length = word(at)? as usize;
        let start = at.checked_add(8)?;
        let end = start.checked_add(length)?;
        (bytes.get(at + 4..start)? == kind && end <= bytes.len()).then_some(start..end)
    };
    if word(4)? != 2 || word(8)? as usize != bytes.len() {
        return None;
    }
    let json = chunk(12, b"JSON")?;
    let binary = chunk(json.end, b"BIN\0");
    Some((&bytes[json], binary))
}

impl<'v> Document<'v> {
    /// Of a parsed file; `own` is the buffer that lies in it.
    pub fn new(path: &'v VPath, root: &'v Value, own: Option<Bytes>, source: &mut Source<'_>) -> Option<Self> {
        let Value::Object(root) = root else {
            source.say(SYNTAX, place(path, String::new()), "the file is no object");
            return None;
        };
        let mut document = Self { path, root, buffers: Vec::new(), left: 0 };
        let buffers: Vec<Item<'v>> = document.list("buffers", source);
        let mut own = own;
        for item in buffers {
            item.only(&["uri", "byteLength", "name"], &document, source);
            let bytes = match item.get("uri") {
                None => own.take(),
                Some(Value::String(uri)) if uri.starts_with("data:") => {
                    document.say(item, SYNTAX, "a buffer within the text is not read", source);
                    None
                }
                Some(_) => {
                    let uri = item.text("uri").unwrap_or_default();
                    let found = source.path(path, uri, || document.origin(item));
                    found.and_then(|file| source.bytes(&file, || document.origin(item)))
                }
            };
            let length = item.count("byteLength");
            let enough = bytes.as_ref().zip(length).is_some_and(|(bytes, length)| length <= bytes.len());
            if !enough {
                document.say(item, REFERENCE, "the buffer has not the bytes that it should have", source);
            }
            document.left = document.left.saturating_add(AGAIN * bytes.as_ref().map_or(0, |bytes| bytes.len() as u64));
            document.buffers.push(bytes.filter(|_| enough));
        }
        Some(document)
    }

    /// The document as an item.
    pub fn whole(&self) -> Item<'v> {
        Item { kind: "", at: 0, map: self.root }
    }

    /// Where an item stands.
    pub fn origin(&self, item: Item<'_>) -> Origin {
        let pointer = if item.kind.is_empty() { String::new() } else { format!("/{}/{}", item.kind, item.at) };
        place(self.path, pointer)
    }

    /// Adds a finding about an item.
    pub fn say(&self, item: Item<'_>, id: &'static str, message: impl Into<String>, source: &mut Source<'_>) {
        source.say(id, self.origin(item), message);
    }

    /// The items of an array at the top.
    pub fn list(&self, kind: &'static str, source: &mut Source<'_>) -> Vec<Item<'v>> {
        let all = match self.root.get(kind) {
            None => return Vec::new(),
            Some(Value::Array(all)) => all.as_slice(),
            Some(_) => &[],
        };
        let items = all.iter().enumerate().map(|(at, value)| value.as_object().map(|map| Item { kind, at, map }));
        let found: Option<Vec<Item<'v>>> = items.collect();
        if found.as_ref().is_none_or(Vec::is_empty) {
            source.say(SYNTAX, place(self.path, format!("/{kind}")), "this is no list of objects");
        }
        found.unwrap_or_default()
    }

    /// Rows of `N` numbers of an accessor whose numbers have `component` as their type.
    fn elements(
        &mut self,
        accessors: &[Item<'v>],
        views: &[Item<'v>],
        (at, wanted, component, size): (usize, &str, u32, usize),
        source: &mut Source<'_>,
    ) -> Option<&[u8]> {
        let Some(accessor) = accessors.get(at).copied() else {
            source.say(REFERENCE, place(self.path, format!("/accessors/{at}")), "it is not there");
            return None;
        };
        let known = ["bufferView", "componentType", "count", "type", "min", "max", "name", "byteOffset"];
        accessor.only(&known, self, source);
        let kinds =
            accessor.text("type") == Some(wanted) && accessor.count("componentType") == Some(component as usize);
        if !kinds {
            self.say(accessor, SYNTAX, format!("its elements are not {wanted} of {component}"), source);
            return None;
        }
        let range = || {
            let view = views.get(accessor.count("bufferView")?)?;
            let (offset, length) = (view.count("byteOffset").unwrap_or(0), view.count("byteLength")?);
            let bytes = accessor.count("count")?.checked_mul(size)?;
            let inner = accessor.count("byteOffset").unwrap_or(0);
            let start = offset.checked_add(inner)?;
            let end = start.checked_add(bytes)?;
            (inner.checked_add(bytes)? <= length).then_some((view.count("buffer")?, start..end))
        };
        let found = range();
        if let Some(view) = accessor.count("bufferView").and_then(|view| views.get(view)) {
            view.only(&["buffer", "byteOffset", "byteLength", "target", "name"], self, source);
        }
        let Some((buffer, range)) = found else {
            self.say(accessor, REFERENCE, "its elements do not lie within its buffer", source);
            return None;
        };
        match self.left.checked_sub(range.len() as u64) {
            Some(left) => self.left = left,
            None => {
                self.say(accessor, LIMIT, "the same numbers are used too often", source);
                return None;
            }
        }
        let bytes = self.buffers.get(buffer).and_then(Option::as_ref).and_then(|bytes| bytes.get(range));
        if bytes.is_none() {
            source.say(REFERENCE, self.origin(accessor), "its elements do not lie within its buffer");
        }
        bytes
    }

    /// The bytes of a view.
    pub fn view(&self, view: Item<'v>, source: &mut Source<'_>) -> Option<&[u8]> {
        let known = ["buffer", "byteOffset", "byteLength", "target", "name"];
        view.only(&known, self, source);
        let start = view.count("byteOffset").unwrap_or(0);
        let end = start.checked_add(view.count("byteLength")?)?;
        self.buffers.get(view.count("buffer")?)?.as_ref()?.get(start..end)
    }

    /// Vectors in single precision.
    pub fn vectors<const N: usize>(
        &mut self,
        accessors: &[Item<'v>],
        views: &[Item<'v>],
        at: usize,
        source: &mut Source<'_>,
    ) -> Option<Vec<[f32; N]>> {
        let wanted = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N.min(4)];
        let bytes = self.elements(accessors, views, (at, wanted, super::names::FLOAT, 4 * N), source)?;
        let (rows, _) = bytes.as_chunks::<4>();
        let row = |row: &[[u8; 4]]| std::array::from_fn(|at| row.get(at).map_or(0.0, |word| f32::from_le_bytes(*word)));
        Some(rows.chunks_exact(N).map(row).collect())
    }

    /// Corners of triangles.
    pub fn triangles(
        &mut self,
        accessors: &[Item<'v>],
        views: &[Item<'v>],
        at: usize,
        source: &mut Source<'_>,
    ) -> Option<Vec<[u32; 3]>> {
        let bytes = self.elements(accessors, views, (at, "SCALAR", super::names::UNSIGNED_INT, 4), source)?;
        let (words, _) = bytes.as_chunks::<4>();
        let (corners, rest) = words.as_chunks::<3>();
        let whole = rest.is_empty();
        let found = corners.iter().map(|corners| corners.map(u32::from_le_bytes)).collect();
        if !whole {
            source.say(SYNTAX, place(self.path, format!("/accessors/{at}")), "its corners make no triangles");
        }
        Some(found)
    }
}

/// A place in the file.
pub fn place(path: &VPath, place: String) -> Origin {
    Origin::File { path: path.as_str().to_owned(), place }
}

impl<'v> Item<'v> {
    /// Its place in its list.
    pub fn at(&self) -> usize {
        self.at
    }

    /// A value.
    pub fn get(&self, key: &str) -> Option<&'v Value> {
        self.map.get(key)
    }

    /// An object within it, which keeps the item's place.
    pub fn inner(&self, key: &str) -> Option<Item<'v>> {
        self.map.get(key)?.as_object().map(|map| Item { map, ..*self })
    }

    /// Another object at the same place.
    pub fn with(&self, map: &'v Map<String, Value>) -> Item<'v> {
        Item { map, ..*self }
    }

    /// The keys.
    pub fn keys(&self) -> impl Iterator<Item = &'v str> {
        self.map.keys().map(String::as_str)
    }

    /// Keys other than `known` are findings.
    pub fn only(&self, known: &[&str], document: &Document<'_>, source: &mut Source<'_>) {
        for key in self.keys().filter(|key| !known.contains(key)) {
            let message = format!("there is an unknown key `{}`", shown(key));
            source.say(UNKNOWN, document.origin(*self), message);
        }
    }

    /// A string.
    pub fn text(&self, key: &str) -> Option<&'v str> {
        self.map.get(key)?.as_str()
    }

    /// A finite number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.map.get(key)?.as_f64().filter(|value| value.is_finite())
    }

    /// A whole number, as indices and sizes are.
    pub fn count(&self, key: &str) -> Option<usize> {
        self.map.get(key)?.as_u64().and_then(|value| usize::try_from(value).ok())
    }

    /// Whole numbers.
    pub fn counts(&self, key: &str) -> Vec<usize> {
        let all = self.map.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        all.iter().filter_map(|value| usize::try_from(value.as_u64()?).ok()).collect()
    }

    /// As many finite numbers as `N`.
    pub fn row<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        let all = self.map.get(key)?.as_array()?;
        let mut row = [0.0; N];
        for (place, value) in row.iter_mut().zip(all) {
            *place = value.as_f64().filter(|value| value.is_finite())?;
        }
        (all.len() == N).then_some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_binary_file_is_cut_into_its_chunks() {
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(36_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend(b"JSON{}  ");
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend(b"BIN\0abcd");
        assert_eq!(split(&bytes), Some((&b"{}  "[..], Some(32..36))));
        assert_eq!(split(b"{}"), Some((&b"{}"[..], None)));
        for cut in 4..bytes.len() {
            assert_eq!(split(&bytes[..cut]), None);
        }
    }
}
