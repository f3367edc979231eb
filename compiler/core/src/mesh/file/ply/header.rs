//! The header of a PLY file: what elements there are, of which properties, in which encoding.
//!
//! Own code, so that every fault has its line and duplicates, impossible types and absurd counts are seen before
//! anything is allocated.

use super::super::{FileError, shown};

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_integer(self) -> bool {
        match self {
            Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::I32 | Self::U32 => true,
            Self::F32 | Self::F64 => false,
        }
    }

    fn parse(word: &str) -> Option<Self> {
        // Turk's original names, and the sized names that later files use.
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

/// A number, or a list with the type of its length and of its items.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List(Scalar, Scalar),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    /// The line that declares it.
    pub line: usize,
}

impl Element {
    /// Bytes of one item in a binary file, with empty lists.
    pub fn least_bytes(&self) -> usize {
        let size = |property: &Property| match property.kind {
            Kind::One(scalar) => scalar.size(),
            Kind::List(count, _) => count.size(),
        };
        self.properties.iter().map(size).sum()
    }

    /// Bytes of every item in a binary file, if there are no lists.
    pub fn stride(&self) -> Option<usize> {
        let fixed = self.properties.iter().all(|property| matches!(property.kind, Kind::One(_)));
        fixed.then(|| self.least_bytes())
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The first byte after the header.
    pub payload: usize,
    /// Lines of the header.
    pub lines: usize,
    /// The first texture that a comment of MeshLab names, and its line.
    pub texture: Option<(usize, String)>,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, FileError> {
        if bytes.is_empty() {
            return Err(FileError::new("", "the file is empty"));
        }
        // Old files of the Macintosh end lines with a carriage return alone.
        let carriage = bytes.starts_with(b"ply\r") && bytes.get(4) != Some(&b'\n');
        let end = if carriage { b'\r' } else { b'\n' };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut texture = None;
        let mut at = 0;
        let mut number = 0;
        loop {
            number += 1;
            let place = format!("line {number}");
            let rest = &bytes[at..];
            let length = rest.iter().position(|byte| *byte == end);
            let line = rest[..length.unwrap_or(rest.len())].trim_ascii();
            if number == 1 && line != b"ply" {
                return Err(FileError::new(place, "a PLY file begins with the line `ply`").help("is this a PLY file?"));
            }
            // A comment may be in any encoding; it is not looked at.
            let keyword = line.split(|byte| byte.is_ascii_whitespace()).next().unwrap_or_default();
            if keyword == b"end_header" && line.len() == keyword.len() {
                at += length.map_or(rest.len(), |length| length + 1);
                break;
            }
            if let Some(name) = line.strip_prefix(b"comment TextureFile ") {
                texture.get_or_insert_with(|| (number, String::from_utf8_lossy(name).trim().to_owned()));
            }
            if !(number == 1 || line.is_empty() || keyword == b"comment" || keyword == b"obj_info") {
                let Ok(line) = std::str::from_utf8(line) else {
                    return Err(FileError::new(place, "the header is not text")
                        .help("the line `end_header` is missing, or the file is damaged"));
                };
                statement(line, number, &mut encoding, &mut elements).map_err(|(message, help)| {
                    let error = FileError::new(place, message);
                    if help.is_empty() { error } else { error.help(help) }
                })?;
            }
            let Some(length) = length else {
                return Err(FileError::new(format!("line {number}"), "the header ends without `end_header`")
                    .help("the file is cut off or damaged"));
            };
            at += length + 1;
        }
        let Some(encoding) = encoding else {
            return Err(FileError::new(format!("line {number}"), "the header has no `format` line")
                .help("write for example `format binary_little_endian 1.0` below `ply`"));
        };
        Ok(Self { encoding, elements, payload: at, lines: number, texture })
    }
}

type Fault = (String, &'static str);

/// More elements, or properties of one element, than any file has; it bounds the search for duplicates.
const MOST: usize = 1000;

fn statement(
    line: &str,
    number: usize,
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element>,
) -> Result<(), Fault> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    match words[..] {
        ["format", name, version] => {
            let found = match name {
                "ascii" => Encoding::Ascii,
                "binary_little_endian" => Encoding::Little,
                "binary_big_endian" => Encoding::Big,
                _ => {
                    let help = "the formats are `ascii`, `binary_little_endian` and `binary_big_endian`";
                    return Err((format!("unknown format `{}`", shown(name)), help));
                }
            };
            if version != "1.0" {
                return Err((format!("PLY version `{}` is not known", shown(version)), "the only version is `1.0`"));
            }
            if encoding.replace(found).is_some_and(|before| before != found) {
                return Err(("the header has two different `format` lines".to_owned(), ""));
            }
            Ok(())
        }
        ["element", name, count] => {
            let Ok(count) = count.parse::<u64>() else {
                let message =
                    format!("the count `{}` of element `{}` is not a whole number", shown(count), shown(name));
                return Err((message, "counts go from 0 upwards"));
            };
            if elements.iter().any(|element| element.name == name) {
                return Err((format!("element `{}` is declared twice", shown(name)), ""));
            }
            if elements.len() >= MOST {
                return Err((format!("the header declares more than {MOST} elements"), "is this a PLY file?"));
            }
            elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), line: number });
            Ok(())
        }
        ["property", kind, name] => property(elements, name, Kind::One(scalar(kind)?)),
        ["property", "list", count, item, name] => {
            let kind = Kind::List(scalar(count)?, scalar(item)?);
            if !scalar(count)?.is_integer() {
                let message = format!("the length of list `{}` has the type `{count}`", shown(name));
                return Err((message, "the length of a list is an integer, for example `uchar`"));
            }
            property(elements, name, kind)
        }
        ["ply"] => Err(("`ply` stands twice".to_owned(), "")),
        _ => Err((format!("`{}` is no line of a PLY header", shown(line)), "is the line `end_header` missing?")),
    }
}

fn scalar(word: &str) -> Result<Scalar, Fault> {
    let help = "the types are char, uchar, short, ushort, int, uint, float, double";
    Scalar::parse(word).ok_or_else(|| (format!("unknown type `{}`", shown(word)), help))
}

fn property(elements: &mut [Element], name: &str, kind: Kind) -> Result<(), Fault> {
    let Some(element) = elements.last_mut() else {
        return Err((format!("property `{}` stands before the first element", shown(name)), ""));
    };
    if element.properties.iter().any(|property| property.name == name) {
        let message = format!("property `{}` of element `{}` is declared twice", shown(name), shown(&element.name));
        return Err((message, ""));
    }
    if element.properties.len() >= MOST {
        return Err((
            format!("element `{}` has more than {MOST} properties", shown(&element.name)),
            "is this a PLY file?",
        ));
    }
    element.properties.push(Property { name: name.to_owned(), kind });
    Ok(())
}
