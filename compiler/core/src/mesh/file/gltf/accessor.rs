//! Numbers in the buffers of a glTF file. Every range is held against the bytes that are there before anything is allocated, and
//! all that is read out together is at most so many times as large as the file.

use std::cell::Cell;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;

use super::super::FileError;
use super::document::{Document, Item};

/// How much larger than the file what is read out of it may be: meshes may share their bytes, and zeros need none.
pub const GROWTH: u64 = 64;

/// Below this many elements a loop is not worth other threads.
const WORTH_THREADS: usize = 1 << 15;

/// Bytes of a file.
pub type Blob<'b> = Box<dyn AsRef<[u8]> + 'b>;

/// The buffers of a file, each with the bytes that could be read, and the accessors over them.
pub struct Buffers<'v, 'b> {
    accessors: Vec<Item<'v>>,
    views: Vec<Item<'v>>,
    blobs: Vec<Blob<'b>>,
    /// Bytes that may still be made.
    left: Cell<u64>,
}

/// The type of a component (glTF 2.0, 3.6.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Elements in a buffer: `count` of them, `stride` bytes apart.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
}

/// An accessor whose ranges were checked.
struct Layout<'a> {
    count: usize,
    component: Component,
    normalized: bool,
    /// None for zeros.
    base: Option<Elements<'a>>,
    /// Which elements have other values, and those.
    sparse: Option<(Vec<u32>, Elements<'a>)>,
}

impl<'v, 'b> Buffers<'v, 'b> {
    /// The buffers of a document of `size` bytes; `own` is the chunk of a binary file, `open` gives the bytes of a file beside it.
    pub fn new(
        document: &Document<'v>,
        own: Option<Blob<'b>>,
        size: usize,
        open: &mut dyn FnMut(Item<'v>, &str) -> Result<Blob<'b>, FileError>,
    ) -> Result<Self, FileError> {
        let mut blobs: Vec<Blob<'b>> = Vec::new();
        let mut own = own;
        let mut all = size as u64;
        for item in document.list("buffers")? {
            let place = item.place();
            let blob: Blob<'b> = match item.text("uri") {
                None => {
                    let compressed = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
                        .iter()
                        .any(|name| item.extension(name).is_some());
                    match own.take() {
                        Some(own) if item.at() == 0 => own,
                        _ if compressed => {
                            return Err(FileError::new(
                                place,
                                "what the buffer holds is there only as compressed by meshopt",
                            )
                            .help("write it without compression: `gltf-transform copy` undoes Draco and meshopt"));
                        }
                        _ => Box::new([]),
                    }
                }
                Some(uri) => match uri.strip_prefix("data:") {
                    Some(data) => {
                        Box::new(decoded_data(data).map_err(|message| FileError::new(place.clone(), message))?.1)
                    }
                    None => {
                        let path =
                            decoded(uri).ok_or_else(|| FileError::new(place.clone(), "its address is malformed"))?;
                        open(item, &path)?
                    }
                },
            };
            let (there, asked) = ((*blob).as_ref().len(), item.count("byteLength"));
            let Some(asked) = asked else { return Err(FileError::new(place, "its `byteLength` is missing")) };
            if there < asked {
                let message = format!("it has {there} bytes, and the file says {asked}");
                return Err(FileError::new(place, message).help("the file is cut off or damaged"));
            }
            all = all.saturating_add(there as u64);
            blobs.push(blob);
        }
        let (accessors, views) = (document.list("accessors")?, document.list("bufferViews")?);
        Ok(Self { accessors, views, blobs, left: Cell::new(all.saturating_mul(GROWTH)) })
    }

    /// All accessors.
    pub fn accessors(&self) -> &[Item<'v>] {
        &self.accessors
    }

    /// Books `bytes` that are made of what is read.
    pub fn afford(&self, bytes: u64) -> Result<(), FileError> {
        let left = self.left.get().checked_sub(bytes).ok_or_else(|| {
            FileError::new("", format!("what the file describes is more than {GROWTH} times as large as the file"))
                .help("its meshes lie on top of each other: repair it in the program that made it")
        })?;
        self.left.set(left);
        Ok(())
    }

    /// `size` bytes of the view `at`, from byte `from` of it.
    fn range(&self, at: usize, from: usize, size: usize) -> Option<&[u8]> {
        let view = self.views.get(at)?;
        (from.checked_add(size)? <= view.count("byteLength")?).then_some(())?;
        let start = view.count("byteOffset").unwrap_or(0).checked_add(from)?;
        (**self.blobs.get(view.count("buffer")?)?).as_ref().get(start..start.checked_add(size)?)
    }

    /// The bytes of a view.
    pub fn view(&self, at: usize) -> Option<&[u8]> {
        self.range(at, 0, self.views.get(at)?.count("byteLength")?)
    }

    /// How many elements an accessor has; 0 where it is not there.
    pub fn count(&self, at: usize) -> usize {
        self.accessors.get(at).and_then(|accessor| accessor.count("count")).unwrap_or(0)
    }

    /// The type of an accessor's elements.
    pub fn kind(&self, at: usize) -> &'v str {
        self.accessors.get(at).and_then(|accessor| accessor.text("type")).unwrap_or("")
    }

    /// The elements of an accessor, whose type must be `kind` of `parts` numbers.
    fn layout(&self, at: usize, kind: &str, parts: usize) -> Result<Layout<'_>, FileError> {
        let place = || format!("/accessors/{at}");
        let wrong = |message: &str| FileError::new(place(), message);
        let accessor = self.accessors.get(at).ok_or_else(|| wrong("an index points to nothing"))?;
        let component = accessor.count("componentType").and_then(Component::new);
        let component = component.ok_or_else(|| wrong("its type is not known"))?;
        match accessor.text("type") {
            Some(found) if found == kind => {}
            Some(found) => {
                let found: String = found.chars().filter(|c| c.is_ascii_alphanumeric()).take(20).collect();
                return Err(wrong(&format!("its elements are {found}, not {kind}")));
            }
            None => return Err(wrong("its type is not known")),
        }
        let count = accessor.count("count").ok_or_else(|| wrong("its `count` is missing"))?;
        let size = component.size() * parts;
        // What is made are 4 bytes for each number.
        self.afford((count as u64).saturating_mul(4 * parts as u64))
            .map_err(|error| FileError { place: place(), ..error })?;
        let away = |what: &str, count: usize| {
            wrong(&format!("{what} {count} elements do not lie within its buffer"))
                .help("the file is cut off or damaged")
        };
        let base = match accessor.get("bufferView") {
            None => None,
            Some(_) => {
                let view = accessor.count("bufferView").filter(|view| *view < self.views.len());
                let view = view.ok_or_else(|| wrong("an index points to nothing"))?;
                let stride = self.views[view].count("byteStride").filter(|stride| *stride > 0).unwrap_or(size);
                if stride < size {
                    return Err(wrong("its elements lie within each other"));
                }
                let last = count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(size));
                let span = if count == 0 { Some(0) } else { last };
                let from = accessor.count("byteOffset").unwrap_or(0);
                let bytes = span.and_then(|span| self.range(view, from, span)).ok_or_else(|| away("its", count))?;
                Some(Elements { bytes, stride, count })
            }
        };
        let sparse = accessor.inner("sparse").map(|sparse| {
            let many = sparse.count("count").ok_or_else(|| wrong("how many elements are other is missing"))?;
            self.afford((many as u64).saturating_mul(4 * (parts as u64 + 1)))
                .map_err(|error| FileError { place: place(), ..error })?;
            let elements = |key: &str, size: usize| {
                let part = sparse.inner(key)?;
                let bytes = self.range(
                    part.count("bufferView")?,
                    part.count("byteOffset").unwrap_or(0),
                    many.checked_mul(size)?,
                )?;
                Some(Elements { bytes, stride: size, count: many })
            };
            let index = sparse.inner("indices").and_then(|part| part.count("componentType")).and_then(Component::new);
            let index = index.ok_or_else(|| wrong("the type of its sparse indices is not known"))?;
            if !matches!(index, Component::U8 | Component::U16 | Component::U32) {
                return Err(wrong("indices are unsigned whole numbers"));
            }
            let found = elements("indices", index.size()).zip(elements("values", size));
            let (slots, values) = found.ok_or_else(|| away("its other", many))?;
            let slots = whole_numbers::<1>(&slots, index).ok_or_else(|| wrong("indices are unsigned whole numbers"))?;
            let slots = slots.into_flattened();
            if let Some(slot) = slots.iter().find(|slot| **slot as usize >= count) {
                return Err(wrong(&format!("element {slot} has another value, but there are {count} elements")));
            }
            Ok((slots, values))
        });
        let normalized = accessor.get("normalized") == Some(&serde_json::Value::Bool(true));
        Ok(Layout { count, component, normalized, base, sparse: sparse.transpose()? })
    }

    /// Vectors in single precision, or single numbers; whole numbers as they are, or as shares where the file says so.
    pub fn vectors<const N: usize>(&self, at: usize) -> Result<Vec<[f32; N]>, FileError> {
        let layout = self.layout(at, kind_of(N), N)?;
        let normalized = layout.normalized;
        Ok(match layout.component {
            Component::F32 => layout.gather(|bytes| f32::from_le_bytes(word(bytes))),
            Component::I8 => layout.gather(|bytes| share(i8::from_le_bytes(word(bytes)), 127.0, normalized)),
            Component::U8 => layout.gather(|bytes| share(u8::from_le_bytes(word(bytes)), 255.0, normalized)),
            Component::I16 => layout.gather(|bytes| share(i16::from_le_bytes(word(bytes)), 32_767.0, normalized)),
            Component::U16 => layout.gather(|bytes| share(u16::from_le_bytes(word(bytes)), 65_535.0, normalized)),
            Component::U32 => {
                return Err(FileError::new(format!("/accessors/{at}"), "its components are 32-bit whole numbers"));
            }
        })
    }

    /// Unsigned whole numbers.
    pub fn whole<const N: usize>(&self, at: usize) -> Result<Vec<[u32; N]>, FileError> {
        let layout = self.layout(at, kind_of(N), N)?;
        Ok(match layout.component {
            Component::U8 => layout.gather(|bytes| u32::from(u8::from_le_bytes(word(bytes)))),
            Component::U16 => layout.gather(|bytes| u32::from(u16::from_le_bytes(word(bytes)))),
            Component::U32 => layout.gather(|bytes| u32::from_le_bytes(word(bytes))),
            Component::I8 | Component::I16 | Component::F32 => {
                return Err(FileError::new(format!("/accessors/{at}"), "indices are unsigned whole numbers"));
            }
        })
    }
}

/// The name of the type of vectors of `parts` numbers.
fn kind_of(parts: usize) -> &'static str {
    match parts {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

fn whole_numbers<const N: usize>(elements: &Elements<'_>, component: Component) -> Option<Vec<[u32; N]>> {
    Some(match component {
        Component::U8 => elements.gather(1, |bytes| u32::from(u8::from_le_bytes(word(bytes)))),
        Component::U16 => elements.gather(2, |bytes| u32::from(u16::from_le_bytes(word(bytes)))),
        Component::U32 => elements.gather(4, |bytes| u32::from_le_bytes(word(bytes))),
        Component::I8 | Component::I16 | Component::F32 => return None,
    })
}

impl Layout<'_> {
    fn gather<T: Copy + Default + Send + Sync, const N: usize>(
        &self,
        number: impl Fn(&[u8]) -> T + Sync,
    ) -> Vec<[T; N]> {
        let size = self.component.size();
        let mut made = match &self.base {
            Some(base) => base.gather(size, &number),
            None => vec![[T::default(); N]; self.count],
        };
        if let Some((slots, values)) = &self.sparse {
            for (slot, value) in slots.iter().zip(values.gather(size, &number)) {
                made[*slot as usize] = value;
            }
        }
        made
    }
}

impl Elements<'_> {
    fn gather<T: Copy + Default + Send + Sync, const N: usize>(
        &self,
        size: usize,
        number: impl Fn(&[u8]) -> T + Sync,
    ) -> Vec<[T; N]> {
        let element = |at: usize| {
            let start = at * self.stride;
            let mut made = [T::default(); N];
            for (axis, made) in made.iter_mut().enumerate() {
                *made = self.bytes.get(start + axis * size..).map_or(T::default(), &number);
            }
            made
        };
        if self.count < WORTH_THREADS {
            (0..self.count).map(element).collect()
        } else {
            (0..self.count).into_par_iter().with_min_len(WORTH_THREADS / 2).map(element).collect()
        }
    }
}

/// The first bytes; 0 beyond the end, which the callers rule out.
#[inline(always)]
fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk::<N>().copied().unwrap_or([0; N])
}

/// A whole number as it is, or as a share of the largest (glTF 2.0, 3.6.2.2).
fn share(number: impl Into<f32>, largest: f32, normalized: bool) -> f32 {
    let number = number.into();
    if normalized { (number / largest).max(-1.0) } else { number }
}

/// What a `data:` address holds, behind its `data:`: the type of its content, and its bytes.
pub fn decoded_data(data: &str) -> Result<(&str, Vec<u8>), String> {
    let (kind, text) = data.split_once(";base64,").ok_or("its `data:` address is not in base 64")?;
    let bytes = STANDARD.decode(text);
    bytes
        .map(|bytes| (kind, bytes))
        .map_err(|error| format!("its `data:` address is malformed: {error}").to_lowercase())
}

/// An address with its `%20` resolved.
pub fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
        } else {
            byte
        });
    }
    String::from_utf8(bytes).ok()
}
