//! The header of an array: a Python dictionary of three entries, and the types of numbers.

use super::NpyError;

/// What the header says.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub kind: Kind,
    /// Whether the bytes are swapped: the first axis runs fastest.
    pub fortran: bool,
    pub shape: Vec<usize>,
}

/// A type of numbers: kind, bytes, and whether the lowest byte comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    /// Signed, of 1, 2, 4 or 8 bytes.
    Int(usize, bool),
    /// Unsigned, of 1, 2, 4 or 8 bytes.
    Uint(usize, bool),
    /// Of 2, 4 or 8 bytes.
    Float(usize, bool),
}

impl Kind {
    /// The type that `descr` names: `<f8`.
    fn parse(text: &str) -> Result<Self, NpyError> {
        let refuse = || {
            let shown: String = text.chars().take(40).flat_map(char::escape_debug).collect();
            NpyError::new(format!("the array has the type `{shown}`"))
                .help("numbers are read: save `array.astype(float)`")
        };
        let mut letters = text.chars();
        let little = match letters.next() {
            // `=` is the machine that wrote the file, and all that NumPy supports today are little-endian or say `>`.
            Some('<' | '|' | '=') => true,
            Some('>') => false,
            _ => return Err(refuse()),
        };
        let kind = match (letters.next(), letters.as_str()) {
            (Some('b'), "1") => Self::Bool,
            (Some('i'), "1") => Self::Int(1, little),
            (Some('i'), "2") => Self::Int(2, little),
            (Some('i'), "4") => Self::Int(4, little),
            (Some('i'), "8") => Self::Int(8, little),
            (Some('u'), "1") => Self::Uint(1, little),
            (Some('u'), "2") => Self::Uint(2, little),
            (Some('u'), "4") => Self::Uint(4, little),
            (Some('u'), "8") => Self::Uint(8, little),
            (Some('f'), "2") => Self::Float(2, little),
            (Some('f'), "4") => Self::Float(4, little),
            (Some('f'), "8") => Self::Float(8, little),
            _ => return Err(refuse()),
        };
        Ok(kind)
    }

    /// As NumPy calls it.
    pub fn name(self) -> String {
        match self {
            Self::Bool => "bool".to_owned(),
            Self::Int(bytes, _) => format!("int{}", bytes * 8),
            Self::Uint(bytes, _) => format!("uint{}", bytes * 8),
            Self::Float(bytes, _) => format!("float{}", bytes * 8),
        }
    }

    /// Bytes of a number, at least 1.
    pub fn size(self) -> usize {
        match self {
            Self::Bool => 1,
            Self::Int(bytes, _) | Self::Uint(bytes, _) | Self::Float(bytes, _) => bytes,
        }
    }

    /// Whether not every number of it is one in double precision.
    pub fn is_wide(self) -> bool {
        matches!(self, Self::Int(8, _) | Self::Uint(8, _))
    }

    /// The numbers in their order.
    pub fn decode(self, data: &[u8]) -> Vec<f64> {
        match self {
            Self::Bool => data.iter().map(|byte| f64::from(u8::from(*byte != 0))).collect(),
            Self::Int(1, _) => data.iter().map(|byte| f64::from(byte.cast_signed())).collect(),
            Self::Uint(1, _) => data.iter().map(|byte| f64::from(*byte)).collect(),
            Self::Int(2, little) => each(data, little, |bytes| f64::from(i16::from_le_bytes(bytes))),
            Self::Int(4, little) => each(data, little, |bytes| f64::from(i32::from_le_bytes(bytes))),
            Self::Int(_, little) => each(data, little, |bytes| i64::from_le_bytes(bytes) as f64),
            Self::Uint(2, little) => each(data, little, |bytes| f64::from(u16::from_le_bytes(bytes))),
            Self::Uint(4, little) => each(data, little, |bytes| f64::from(u32::from_le_bytes(bytes))),
            Self::Uint(_, little) => each(data, little, |bytes| u64::from_le_bytes(bytes) as f64),
            Self::Float(2, little) => each(data, little, |bytes| half(u16::from_le_bytes(bytes))),
            Self::Float(4, little) => each(data, little, |bytes| f64::from(f32::from_le_bytes(bytes))),
            Self::Float(_, little) => each(data, little, f64::from_le_bytes),
        }
    }
}

fn each<const N: usize>(data: &[u8], little: bool, number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let (chunks, _) = data.as_chunks::<N>();
    if little {
        return chunks.iter().map(|bytes| number(*bytes)).collect();
    }
    let turned = |bytes: &[u8; N]| {
        let mut bytes = *bytes;
        bytes.reverse();
        number(bytes)
    };
    chunks.iter().map(turned).collect()
}

/// A number of half precision (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let fraction = f64::from(bits & 0x3ff);
    let size = match bits >> 10 & 0x1f {
        0 => fraction / 16_777_216.0,
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction / 1024.0) * f64::from(1_u32 << exponent) / 32_768.0,
    };
    sign * size
}

pub(super) fn parse(text: &[u8]) -> Result<Header, NpyError> {
    let text = std::str::from_utf8(text).map_err(|_| malformed("it is no text"))?;
    let mut reader = Reader { rest: text.trim() };
    let (mut kind, mut fortran, mut shape) = (None, None, None);
    reader.expect('{')?;
    while !reader.take('}') {
        let key = reader.string()?;
        reader.expect(':')?;
        let again = match key {
            "descr" => kind.replace(reader.descr()?).is_some(),
            "fortran_order" => fortran.replace(reader.truth()?).is_some(),
            "shape" => shape.replace(reader.shape()?).is_some(),
            _ => return Err(malformed("it has an unknown entry")),
        };
        if again {
            return Err(malformed(&format!("it has two entries `{key}`")));
        }
        if !reader.take(',') {
            reader.expect('}')?;
            break;
        }
    }
    if !reader.rest.trim().is_empty() {
        return Err(malformed("something stands behind it"));
    }
    match (kind, fortran, shape) {
        (Some(kind), Some(fortran), Some(shape)) => Ok(Header { kind, fortran, shape }),
        _ => Err(malformed("`descr`, `fortran_order` or `shape` is missing")),
    }
}

fn malformed(why: &str) -> NpyError {
    NpyError::new(format!("the header is malformed: {why}")).help("write the file by `numpy.save`")
}

/// What has not been read of the header.
struct Reader<'t> {
    rest: &'t str,
}

impl<'t> Reader<'t> {
    fn take(&mut self, sign: char) -> bool {
        let rest = self.rest.trim_start();
        let found = rest.strip_prefix(sign);
        self.rest = found.unwrap_or(rest);
        found.is_some()
    }

    fn expect(&mut self, sign: char) -> Result<(), NpyError> {
        if self.take(sign) { Ok(()) } else { Err(malformed(&format!("`{sign}` is missing"))) }
    }

    fn string(&mut self) -> Result<&'t str, NpyError> {
        let quote = if self.take('\'') {
            '\''
        } else if self.take('"') {
            '"'
        } else {
            return Err(malformed("a string is missing"));
        };
        let (text, rest) = self.rest.split_once(quote).ok_or_else(|| malformed("a string is not closed"))?;
        self.rest = rest;
        Ok(text)
    }

    fn descr(&mut self) -> Result<Kind, NpyError> {
        if self.rest.trim_start().starts_with('[') {
            return Err(NpyError::new("the array has records of several fields")
                .help("save one array of plain numbers: `array[\"field\"].astype(float)`"));
        }
        Kind::parse(self.string()?)
    }

    fn truth(&mut self) -> Result<bool, NpyError> {
        let rest = self.rest.trim_start();
        let (truth, rest) = match (rest.strip_prefix("True"), rest.strip_prefix("False")) {
            (Some(rest), _) => (true, rest),
            (None, Some(rest)) => (false, rest),
            (None, None) => return Err(malformed("`fortran_order` is neither `True` nor `False`")),
        };
        self.rest = rest;
        Ok(truth)
    }

    fn shape(&mut self) -> Result<Vec<usize>, NpyError> {
        let mut shape = Vec::new();
        self.expect('(')?;
        while !self.take(')') {
            let rest = self.rest.trim_start();
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            let axis = rest[..end].parse().map_err(|_| malformed("`shape` is no tuple of whole numbers"))?;
            shape.push(axis);
            // Python 2 wrote `100L`.
            self.rest = rest[end..].strip_prefix('L').unwrap_or(&rest[end..]);
            if !self.take(',') {
                self.expect(')')?;
                break;
            }
        }
        Ok(shape)
    }
}
