//! Binary PLY in its usual layout, straight from the bytes: vertices without lists whose columns are 32-bit floats, faces
//! whose only list has a length of one byte and 32-bit indices. Measured against ply-rs-bw in `benches/mesh.rs`.

use rayon::prelude::*;

use super::header::{Kind, Scalar};
use super::{Faces, File, FileError, List, Vertices, wrong_index};

/// Below this many items a loop is not worth other threads.
const WORTH_THREADS: usize = 1 << 15;

/// The vertices from byte `at` and their end; none if their layout is another one. The file is long enough.
pub(super) fn vertices(file: &File<'_>, at: usize, big: bool) -> Option<(Vertices, usize)> {
    let element = file.vertex();
    let stride = element.stride()?;
    // The first byte of each property.
    let mut offsets = Vec::with_capacity(element.properties.len());
    let mut offset = 0;
    for property in &element.properties {
        offsets.push(offset);
        let Kind::One(scalar) = property.kind else { return None };
        offset += scalar.size();
    }
    let float = |column: usize| {
        let property = file.layout.columns[column]?;
        (element.properties[property].kind == Kind::One(Scalar::F32)).then(|| offsets[property])
    };
    let bytes = file.bytes.get(at..at.checked_add(file.layout.vertices.checked_mul(stride)?)?)?;
    let positions = [float(0)?, float(1)?, float(2)?];
    let normals = match file.layout.has_normals() {
        true => Some([float(3)?, float(4)?, float(5)?]),
        false => None,
    };
    let uvs = match file.layout.has_uvs() {
        true => Some([float(6)?, float(7)?]),
        false => None,
    };
    let vertices = Vertices {
        positions: gather(bytes, stride, positions, big),
        normals: normals.map(|offsets| gather(bytes, stride, offsets, big)),
        uvs: uvs.map(|offsets| gather(bytes, stride, offsets, big)),
    };
    Some((vertices, at + bytes.len()))
}

/// Adds the faces from byte `at` and gives their end; none if their layout is another one.
pub(super) fn faces(
    file: &File<'_>,
    list: List,
    at: usize,
    big: bool,
    faces: &mut Faces,
) -> Option<Result<usize, FileError>> {
    let element = &file.header.elements[list.element];
    let (mut before, mut after) = (0, 0);
    for (index, property) in element.properties.iter().enumerate() {
        match property.kind {
            Kind::One(scalar) if index < list.property => before += scalar.size(),
            Kind::One(scalar) => after += scalar.size(),
            Kind::List(Scalar::I8 | Scalar::U8, Scalar::I32 | Scalar::U32) if index == list.property => {}
            Kind::List(..) => return None,
        }
    }
    let count = usize::try_from(element.count).ok()?;
    let layout = Records { before, after, signed: false, big, vertices: file.layout.vertices };
    let signed = element.properties[list.property].kind;
    let layout = Records { signed: matches!(signed, Kind::List(Scalar::I8, _)), ..layout };
    Some(match layout.triangles(file.bytes, at, count) {
        Some(triangles) => {
            let end = at + count * layout.stride();
            // Strips may have come before.
            if faces.triangles.is_empty() {
                faces.triangles = triangles;
            } else {
                faces.triangles.extend(triangles);
            }
            Ok(end)
        }
        None => layout.polygons(file.bytes, at, count, faces),
    })
}

fn gather<const N: usize>(bytes: &[u8], stride: usize, offsets: [usize; N], big: bool) -> Vec<[f32; N]> {
    let record = |record: &[u8]| offsets.map(|offset| f32::from_bits(word(record, offset, big)));
    if bytes.len() / stride < WORTH_THREADS {
        bytes.chunks_exact(stride).map(record).collect()
    } else {
        bytes.par_chunks_exact(stride).with_min_len(WORTH_THREADS / 2).map(record).collect()
    }
}

/// The four bytes of `record` from `offset` as a number; 0 beyond its end, which the callers rule out.
#[inline(always)]
fn word(record: &[u8], offset: usize, big: bool) -> u32 {
    let Some(bytes) = record.get(offset..).and_then(<[u8]>::first_chunk::<4>) else { return 0 };
    if big { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) }
}

/// Faces: `before` bytes, the length, the indices, `after` bytes.
struct Records {
    before: usize,
    after: usize,
    /// Whether the length is a signed byte.
    signed: bool,
    big: bool,
    vertices: usize,
}

impl Records {
    /// Bytes of a triangle.
    fn stride(&self) -> usize {
        self.before + 1 + 12 + self.after
    }

    /// All faces, if they are triangles with indices in range.
    fn triangles(&self, bytes: &[u8], at: usize, count: usize) -> Option<Vec<[u32; 3]>> {
        let bytes = bytes.get(at..at.checked_add(count.checked_mul(self.stride())?)?)?;
        let first = self.before + 1;
        let good = |record: &[u8]| {
            let corners = [0, 4, 8].map(|offset| word(record, first + offset, self.big));
            let inside = corners.iter().all(|corner| (*corner as usize) < self.vertices);
            (record[self.before] == 3 && inside).then_some(corners)
        };
        if count < WORTH_THREADS {
            return bytes.chunks_exact(self.stride()).map(good).collect();
        }
        // Two passes: to check first costs less than to collect options from many threads.
        let all = bytes.par_chunks_exact(self.stride()).with_min_len(WORTH_THREADS / 2);
        if !all.clone().all(|record| good(record).is_some()) {
            return None;
        }
        Some(all.map(|record| [0, 4, 8].map(|offset| word(record, first + offset, self.big))).collect())
    }

    /// Faces of any number of corners, one after the other.
    fn polygons(&self, bytes: &[u8], start: usize, count: usize, faces: &mut Faces) -> Result<usize, FileError> {
        let mut at = start;
        let mut corners = Vec::new();
        let cut = |face: usize, at: usize| {
            FileError::new(format!("byte {at}"), format!("the file ends within face {face} of {count}"))
                .help("the file is cut off, or a count is wrong")
        };
        for face in 0..count {
            let rest = &bytes[at..];
            let length = *rest.get(self.before).ok_or_else(|| cut(face, at))?;
            if self.signed && length > 127 {
                let message = format!("face {face} has {} corners", i32::from(length as i8));
                return Err(FileError::new(format!("byte {at}"), message));
            }
            let indices = usize::from(length) * 4;
            let list = rest.get(self.before + 1..).and_then(|rest| rest.get(..indices + self.after));
            let list = list.ok_or_else(|| cut(face, at))?;
            corners.clear();
            for offset in (0..indices).step_by(4) {
                let corner = word(list, offset, self.big);
                if corner as usize >= self.vertices {
                    // No mesh has 2^31 vertices by mistake: it is a negative number.
                    return Err(wrong_index(format!("byte {at}"), i64::from(corner as i32), self.vertices));
                }
                corners.push(corner);
            }
            faces.push(&corners, || format!("byte {at}"));
            at += self.before + 1 + list.len();
        }
        Ok(at)
    }
}
