//! The JSON of a glTF file, binary or text: objects with their places as JSON pointers, and the lists they stand in.
//!
//! Nothing is asked of keys that nobody reads, so that no valid file is refused for what is an extension's or an application's.

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::super::FileError;
use super::extensions::is_read;

/// An object of the document and where it stands: `/nodes/17`.
#[derive(Clone, Copy)]
pub struct Item<'v> {
    kind: &'static str,
    at: usize,
    map: &'v Map<String, Value>,
}

/// The document.
pub struct Document<'v> {
    root: &'v Map<String, Value>,
}

/// The JSON of a file, and of a binary one the chunk behind it (glTF 2.0, 4.4).
pub fn split(bytes: &[u8]) -> Result<(&[u8], Option<std::ops::Range<usize>>), FileError> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return match text.trim_ascii_start().first() {
            Some(b'{') => Ok((text, None)),
            Some(_) => {
                Err(FileError::new("byte 0", "the file begins neither with `glTF`, as a binary one, nor with `{`")
                    .help("is this a glTF file?"))
            }
            None => Err(FileError::new("", "the file is empty")),
        };
    };
    let cut = |what: &str| FileError::new("", format!("the file ends within {what}")).help("the file is cut off");
    let number = |at: usize| bytes.get(at..).and_then(<[u8]>::first_chunk::<4>).map(|word| u32::from_le_bytes(*word));
    let (Some(version), Some(_length)) = (number(4), number(8)) else { return Err(cut("its header")) };
    if version != 2 {
        return Err(
            FileError::new("byte 4", format!("the file is of version {version} of glTF")).help("version 2 is read")
        );
    }
    let mut at = 12;
    let mut chunks = [None, None];
    for (chunk, (kind, what)) in chunks.iter_mut().zip([(b"JSON", "its JSON"), (b"BIN\0", "its binary chunk")]) {
        let Some(length) = number(at) else { break };
        let head = bytes.get(at + 4..at + 8).ok_or_else(|| cut(what))?;
        if head != kind {
            break;
        }
        let from = at + 8;
        let end = from.checked_add(length as usize).filter(|end| *end <= bytes.len()).ok_or_else(|| cut(what))?;
        *chunk = Some(from..end);
        at = end;
    }
    let [json, binary] = chunks;
    match json {
        Some(json) => Ok((&bytes[json], binary)),
        None if rest.len() < 16 => Err(cut("its header")),
        None => Err(FileError::new("byte 12", "the first chunk is not JSON")),
    }
}

/// The values of a text. Where they are nested deeper than serde_json goes (128), what applications and extensions put there is left
/// out.
pub fn parse(text: &[u8]) -> Result<Value, FileError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let without = || {
        let mut reader = serde_json::Deserializer::from_slice(text);
        let value = Pruned { of_extensions: false }.deserialize(&mut reader).ok()?;
        reader.end().ok().map(|()| value)
    };
    serde_json::from_slice(text).or_else(|error| {
        without().ok_or_else(|| {
            FileError::new(format!("line {} of the JSON", error.line()), format!("the JSON is malformed: {error}"))
                .help("is this a glTF file?")
        })
    })
}

/// Reads a value without `extras` and without what stands in extensions that are not read.
#[derive(Clone, Copy)]
struct Pruned {
    /// Whether the keys are names of extensions.
    of_extensions: bool,
}

impl<'de> DeserializeSeed<'de> for Pruned {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<Value, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Pruned {
    type Value = Value;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a value of JSON")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut all = Vec::new();
        while let Some(one) = list.next_element_seed(Self { of_extensions: false })? {
            all.push(one);
        }
        Ok(all.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut all = Map::new();
        while let Some(key) = map.next_key::<String>()? {
            if key == "extras" || self.of_extensions && !is_read(&key) {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let value = map.next_value_seed(Self { of_extensions: key == "extensions" })?;
            all.insert(key, value);
        }
        Ok(all.into())
    }
}

impl<'v> Document<'v> {
    /// Of parsed values, which must say that they are glTF of version 2.
    pub fn new(root: &'v Value) -> Result<Self, FileError> {
        let Value::Object(root) = root else {
            return Err(FileError::new("", "the file is no object of JSON").help("is this a glTF file?"));
        };
        let asset = root.get("asset").and_then(Value::as_object);
        let version = asset.and_then(|asset| asset.get("version")).and_then(Value::as_str);
        match version {
            Some(version) if version == "2" || version.starts_with("2.") => Ok(Self { root }),
            Some(version) => {
                let version: String = version.chars().flat_map(char::escape_debug).take(20).collect();
                Err(FileError::new("/asset/version", format!("the file is of version {version} of glTF"))
                    .help("version 2 is read"))
            }
            None => Err(FileError::new("/asset/version", "the version is missing").help("is this a glTF file?")),
        }
    }

    /// The document as an item.
    pub fn whole(&self) -> Item<'v> {
        Item { kind: "", at: 0, map: self.root }
    }

    /// The items of an array at the top; none where it is not there.
    pub fn list(&self, kind: &'static str) -> Result<Vec<Item<'v>>, FileError> {
        items(self.root.get(kind), kind)
    }

    /// The lights of KHR_lights_punctual.
    pub fn lights(&self) -> Result<Vec<Item<'v>>, FileError> {
        let extension = self.whole().extension("KHR_lights_punctual");
        items(extension.and_then(|lights| lights.get("lights")), "extensions/KHR_lights_punctual/lights")
    }

    /// The words of a list of words at the top.
    pub fn words(&self, key: &str) -> impl Iterator<Item = &'v str> {
        self.root.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
    }

    /// The nodes of the default scene; of a file without scenes those that lie in no other.
    pub fn roots(&self, nodes: &[Item<'v>]) -> Result<Vec<usize>, FileError> {
        let scenes = self.list("scenes")?;
        if scenes.is_empty() {
            let mut inner = vec![false; nodes.len()];
            for child in nodes.iter().flat_map(|node| node.counts("children")) {
                if let Some(inner) = inner.get_mut(child) {
                    *inner = true;
                }
            }
            return Ok((0..nodes.len()).filter(|at| !inner[*at]).collect());
        }
        let scene = self.whole().count("scene").unwrap_or(0);
        let scene = scenes.get(scene).ok_or_else(|| FileError::new("/scene", "an index points to nothing"))?;
        Ok(scene.counts("nodes"))
    }
}

fn items<'v>(list: Option<&'v Value>, kind: &'static str) -> Result<Vec<Item<'v>>, FileError> {
    let wrong = |at: String| FileError::new(at, "this is no list of objects");
    let all = match list {
        None => return Ok(Vec::new()),
        Some(Value::Array(all)) => all.as_slice(),
        Some(_) => return Err(wrong(format!("/{kind}"))),
    };
    let item = |(at, value): (usize, &'v Value)| match value.as_object() {
        Some(map) => Ok(Item { kind, at, map }),
        None => Err(wrong(format!("/{kind}/{at}"))),
    };
    all.iter().enumerate().map(item).collect()
}

impl<'v> Item<'v> {
    /// Its place in its list.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Its JSON pointer.
    pub fn place(&self) -> String {
        if self.kind.is_empty() { String::new() } else { format!("/{}/{}", self.kind, self.at) }
    }

    /// A value.
    pub fn get(&self, key: &str) -> Option<&'v Value> {
        self.map.get(key)
    }

    /// A value by keys with `/` between them.
    pub fn value(&self, path: &str) -> Option<&'v Value> {
        let mut keys = path.split('/');
        let first = self.map.get(keys.next()?)?;
        keys.try_fold(first, |value, key| value.as_object()?.get(key))
    }

    /// An object within it, which keeps the item's place.
    pub fn inner(&self, key: &str) -> Option<Item<'v>> {
        self.map.get(key)?.as_object().map(|map| Item { map, ..*self })
    }

    /// What an extension says of it.
    pub fn extension(&self, name: &str) -> Option<Item<'v>> {
        self.inner("extensions")?.inner(name)
    }

    /// The objects of a list within it, which keep the item's place.
    pub fn objects(&self, key: &str) -> impl Iterator<Item = Item<'v>> {
        let item = *self;
        let list = self.map.get(key).and_then(Value::as_array).into_iter().flatten();
        list.filter_map(Value::as_object).map(move |map| Item { map, ..item })
    }

    /// The keys.
    pub fn keys(&self) -> impl Iterator<Item = &'v str> {
        self.map.keys().map(String::as_str)
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
        whole(self.map.get(key)?)
    }

    /// The whole numbers of a list.
    pub fn counts(&self, key: &str) -> Vec<usize> {
        let list = self.map.get(key).and_then(Value::as_array);
        list.map(|all| all.iter().filter_map(whole).collect()).unwrap_or_default()
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

    /// The item that the index `key` means; none where there is no index.
    ///
    /// # Errors
    /// An index that means nothing.
    pub fn link<'l>(&self, key: &str, list: &'l [Item<'v>]) -> Result<Option<&'l Item<'v>>, FileError> {
        let Some(value) = self.map.get(key) else { return Ok(None) };
        let found = whole(value).and_then(|at| list.get(at));
        found.map(Some).ok_or_else(|| FileError::new(format!("{}/{key}", self.place()), "an index points to nothing"))
    }
}

/// A whole number from 0; some programs write `4.0`.
pub fn whole(value: &Value) -> Option<usize> {
    let exact = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 9e15).then_some(x as u64);
    let number = value.as_u64().or_else(|| value.as_f64().and_then(exact))?;
    usize::try_from(number).ok()
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
        assert_eq!(split(&bytes), Ok((&b"{}  "[..], Some(32..36))));
        assert_eq!(split(b" {}"), Ok((&b" {}"[..], None)));
        for cut in (4..24).chain(30..bytes.len()) {
            assert!(split(&bytes[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn numbers_are_whole_however_they_are_written() {
        let root =
            serde_json::json!({"a": 4.0, "b": 4.5, "c": -1, "d": 1e300, "e": {"f": {"g": 3}}, "h": [0, 2.0, "x"]});
        let item = Item { kind: "", at: 0, map: root.as_object().expect("an object") };
        let counts = ["a", "b", "c", "d"].map(|key| item.count(key));
        assert_eq!(counts, [Some(4), None, None, None]);
        assert_eq!((item.value("e/f/g").and_then(whole), item.value("e/x/g")), (Some(3), None));
        assert_eq!(item.counts("h"), [0, 2]);
    }
}
