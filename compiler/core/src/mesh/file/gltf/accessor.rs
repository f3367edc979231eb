//! Numbers in the buffers of a glTF file. Every range is held against the bytes that are there before anything is allocated.

use gltf::json;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use rayon::prelude::*;

use super::FileError;

/// Below this many elements a loop is not worth other threads.
const WORTH_THREADS: usize = 1 << 15;

/// The buffers of a file, each with the bytes that could be read.
pub(super) struct Buffers<'a> {
    pub root: &'a json::Root,
    pub bytes: Vec<&'a [u8]>,
}

/// Elements in a buffer: `count` of them, `stride` bytes apart.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Buffers<'a> {
    /// `size` bytes of the view `at`, from byte `from` of it.
    pub fn range(&self, at: usize, from: u64, size: u64) -> Option<&'a [u8]> {
        let view = self.root.buffer_views.get(at)?;
        let start = view.byte_offset.unwrap_or_default().0.checked_add(from)?;
        (from.checked_add(size)? <= view.byte_length.0).then_some(())?;
        let (start, size) = (usize::try_from(start).ok()?, usize::try_from(size).ok()?);
        self.bytes.get(view.buffer.value())?.get(start..start.checked_add(size)?)
    }

    /// The elements of an accessor.
    fn elements(&self, at: usize, wanted: Type) -> Result<Elements<'a>, FileError> {
        let place = format!("accessor {at}");
        let wrong = |message: &str| FileError::new(place.clone(), message);
        let accessor = self.root.accessors.get(at).ok_or_else(|| wrong("it is not in the file"))?;
        let (Checked::Valid(kind), Checked::Valid(component)) = (accessor.type_, accessor.component_type) else {
            return Err(wrong("its type is not known"));
        };
        if kind != wanted {
            return Err(wrong(&format!("its elements are {kind:?}, not {wanted:?}")));
        }
        let component = component.0;
        let Some(view) = accessor.buffer_view.filter(|_| accessor.sparse.is_none()) else {
            return Err(wrong("it is sparse, or has no bytes").help("write the file without sparse accessors"));
        };
        let view = view.value();
        let size = component.size() * kind.multiplicity();
        let stride = self.root.buffer_views.get(view).and_then(|view| view.byte_stride).map_or(0, |stride| stride.0);
        let stride = if stride == 0 { size } else { stride };
        if stride < size {
            return Err(wrong("its elements lie within each other"));
        }
        let count = accessor.count.0;
        let last = count.saturating_sub(1).checked_mul(stride as u64).and_then(|last| last.checked_add(size as u64));
        let span = if count == 0 { Some(0) } else { last };
        let bytes = span.and_then(|span| self.range(view, accessor.byte_offset.unwrap_or_default().0, span));
        let bytes = bytes.ok_or_else(|| {
            wrong(&format!("its {count} elements do not lie within its buffer")).help("the file is cut off or damaged")
        })?;
        Ok(Elements { bytes, stride, count: count as usize, component, normalized: accessor.normalized })
    }

    /// Vectors in single precision.
    pub fn vectors<const N: usize>(&self, at: usize, kind: Type) -> Result<Vec<[f32; N]>, FileError> {
        let elements = self.elements(at, kind)?;
        let Elements { component, normalized, .. } = elements;
        Ok(match component {
            ComponentType::F32 => elements.gather(|bytes| f32::from_le_bytes(word(bytes))),
            ComponentType::I8 => {
                elements.gather(|bytes| share(bytes.first().map_or(0, |b| b.cast_signed()), 127.0, normalized))
            }
            ComponentType::U8 => elements.gather(|bytes| share(bytes.first().copied().unwrap_or(0), 255.0, normalized)),
            ComponentType::I16 => elements.gather(|bytes| share(i16::from_le_bytes(word(bytes)), 32_767.0, normalized)),
            ComponentType::U16 => elements.gather(|bytes| share(u16::from_le_bytes(word(bytes)), 65_535.0, normalized)),
            ComponentType::U32 => {
                return Err(FileError::new(format!("accessor {at}"), "its components are 32-bit whole numbers"));
            }
        })
    }

    /// Indices.
    pub fn indices(&self, at: usize) -> Result<Vec<u32>, FileError> {
        let elements = self.elements(at, Type::Scalar)?;
        let made: Vec<[u32; 1]> = match elements.component {
            ComponentType::U8 => elements.gather(|bytes| bytes.first().copied().map_or(0, u32::from)),
            ComponentType::U16 => elements.gather(|bytes| u32::from(u16::from_le_bytes(word(bytes)))),
            ComponentType::U32 => elements.gather(|bytes| u32::from_le_bytes(word(bytes))),
            ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => {
                return Err(FileError::new(format!("accessor {at}"), "indices are unsigned whole numbers"));
            }
        };
        Ok(made.into_flattened())
    }
}

impl Elements<'_> {
    fn gather<T: Copy + Default + Send + Sync, const N: usize>(
        &self,
        number: impl Fn(&[u8]) -> T + Sync,
    ) -> Vec<[T; N]> {
        let size = self.component.size();
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
