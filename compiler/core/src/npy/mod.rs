//! Arrays of numbers in NumPy's `.npy` format, as bytes in memory.
//!
//! The format (NumPy Enhancement Proposal 1): the magic `\x93NUMPY`, two bytes of version, the length of the header (two
//! bytes little-endian in version 1, four in 2 and 3), the header itself, which is a Python dictionary with the keys `descr`,
//! `fortran_order` and `shape`, and the numbers. A file may be anything: shape and type are held against the bytes that are
//! there before anything is allocated.

mod header;
pub mod write;

use std::fmt;

use header::{Header, Kind};

/// The most axes of an array; NumPy has 64.
pub const AXES: usize = 8;

/// The longest header in bytes; real ones have 118.
const HEADER_LIMIT: usize = 1 << 16;

/// Why an array cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NpyError {
    /// What is wrong; lower-case, one sentence.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl NpyError {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None }
    }

    fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

impl fmt::Display for NpyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for NpyError {}

/// An array whose header has been read and fits its bytes; the numbers have not been looked at.
#[derive(Debug)]
pub struct Array<'b> {
    header: Header,
    data: &'b [u8],
}

impl<'b> Array<'b> {
    /// Reads the header.
    ///
    /// # Errors
    /// Bytes that are no `.npy` file, a type that is no number, and a shape that does not fit the bytes.
    pub fn open(bytes: &'b [u8]) -> Result<Self, NpyError> {
        let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(|| {
            NpyError::new("the file is no `.npy` array").help("write it by `numpy.save`; `.npz` archives are not read")
        })?;
        let cut = || NpyError::new("the file ends within its header");
        let [major, _minor, rest @ ..] = rest else { return Err(cut()) };
        let (length, rest) = match (major, rest) {
            (1, [a, b, rest @ ..]) => (usize::from(u16::from_le_bytes([*a, *b])), rest),
            (2 | 3, [a, b, c, d, rest @ ..]) => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
            (1..=3, _) => return Err(cut()),
            (version, _) => {
                return Err(NpyError::new(format!("version {version} of the `.npy` format is not known"))
                    .help("versions 1, 2 and 3 are read: write the file by `numpy.save`"));
            }
        };
        if length > HEADER_LIMIT {
            return Err(NpyError::new(format!("the header has {length} bytes, more than {HEADER_LIMIT}")));
        }
        let (text, data) = rest.split_at_checked(length).ok_or_else(cut)?;
        let header = header::parse(text)?;
        if header.shape.len() > AXES {
            return Err(NpyError::new(format!("the array has {} axes, more than {AXES}", header.shape.len())));
        }
        let size = header.shape.iter().try_fold(header.kind.size(), |size, axis| size.checked_mul(*axis));
        match size {
            Some(size) if size == data.len() => Ok(Self { header, data }),
            size => {
                let claims = size.map_or("more bytes than can be counted".to_owned(), |size| format!("{size} bytes"));
                let message = format!(
                    "the header says {} of type `{}`, which take {claims}, but {} follow",
                    shape_words(&header.shape),
                    header.kind.name(),
                    data.len()
                );
                Err(NpyError::new(message).help("the file is cut off, or its header is wrong: write it again"))
            }
        }
    }

    /// The length along each axis; empty for a single number.
    pub fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.data.len() / self.header.kind.size()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Whether it holds truth values.
    pub fn is_bool(&self) -> bool {
        self.header.kind == Kind::Bool
    }

    /// The numbers, the last axis running fastest, whatever the order in the file. Truth values are 0 and 1.
    ///
    /// # Errors
    /// NaN, infinity, and whole numbers beyond 2^53, with the place of the first.
    pub fn numbers(&self) -> Result<Vec<f64>, NpyError> {
        let numbers = self.header.kind.decode(self.data);
        let numbers = if self.header.fortran { self.turned(&numbers) } else { numbers };
        let whole = self.header.kind.is_wide();
        let bad = numbers.iter().position(|x| !x.is_finite() || whole && x.abs() > 9_007_199_254_740_992.0);
        let Some(at) = bad else { return Ok(numbers) };
        let mut place = Vec::new();
        let mut rest = at;
        for axis in self.header.shape.iter().rev() {
            place.insert(0, (rest % axis).to_string());
            rest /= axis;
        }
        let what = if numbers[at].is_nan() {
            "not a number (NaN)"
        } else if numbers[at].is_infinite() {
            "infinite"
        } else {
            "a whole number beyond 2^53"
        };
        Err(NpyError::new(format!("the element [{}] is {what}", place.join(", ")))
            .help("repair the array in the program that wrote it"))
    }

    /// Numbers whose first axis runs fastest, with the last one fastest.
    fn turned(&self, numbers: &[f64]) -> Vec<f64> {
        let shape = &self.header.shape;
        let mut strides = vec![1; shape.len()];
        for axis in 1..shape.len() {
            strides[axis] = strides[axis - 1] * shape[axis - 1];
        }
        let mut index = vec![0; shape.len()];
        let mut from = 0;
        let mut out = Vec::with_capacity(numbers.len());
        while out.len() < numbers.len() {
            out.push(numbers[from]);
            for axis in (0..shape.len()).rev() {
                index[axis] += 1;
                from += strides[axis];
                if index[axis] < shape[axis] {
                    break;
                }
                from -= strides[axis] * shape[axis];
                index[axis] = 0;
            }
        }
        out
    }
}

/// `shape (3, 4)`, as Python writes it.
pub fn shape_words(shape: &[usize]) -> String {
    let axes: Vec<String> = shape.iter().map(usize::to_string).collect();
    if let [only] = axes.as_slice() { format!("shape ({only},)") } else { format!("shape ({})", axes.join(", ")) }
}

#[cfg(test)]
mod tests;
