//! Mitsuba's `.serialized` files: several meshes, packed one by one, with a table of their places at the end.
//!
//! The layout is that of the documentation of Mitsuba 0.5 and 3 (plugin `serialized`): the number 0x041C and a version (3 or 4), then for
//! each mesh the same two numbers and a zlib stream of flags, name (4 only), counts, positions, normals, texture coordinates,
//! colors and indices; at last the place of each mesh (4: 64 bits, 3: 32 bits) and their number.

use miniz_oxide::inflate::{TINFLStatus, decompress_to_vec_zlib_with_limit};

use super::finish::finish;
use super::{FileError, Note};
use crate::mesh::Geometry;

const MAGIC: u16 = 0x041c;
const NORMALS: u32 = 0x0001;
const UVS: u32 = 0x0002;
const COLORS: u32 = 0x0008;
const FLAT: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

/// How often its size a stream may grow: vertices and indices pack to a half or a third.
const GROWTH: usize = 100;

/// The most bytes in front of the counts: flags, and a name of any sensible length.
const HEAD: usize = 4096;

/// Reads the mesh whose number is `part`, the first without one.
pub(super) fn read(bytes: &[u8], part: Option<&str>) -> Result<(Geometry, Vec<Note>), FileError> {
    let number = part.map_or(Ok(0), |part| part.trim().parse::<usize>());
    let Ok(number) = number else {
        return Err(
            FileError::new("", "the meshes of a serialized file have numbers, from 0").help("write `part: \"0\"`")
        );
    };
    let (start, end) = place(bytes, number)?;
    let block = &bytes[start..end];
    let version = version(block, start)?;
    let packed = &block[4..];
    let damaged = |what: &str| FileError::new(format!("byte {start}"), format!("mesh {number} {what}"));
    let most = packed.len().saturating_mul(GROWTH).saturating_add(HEAD);
    let whole = decompress_to_vec_zlib_with_limit(packed, most).map_err(|fault| {
        let endless = fault.status == TINFLStatus::HasMoreOutput;
        damaged(if endless { "unpacks to more than a hundred times its size" } else { "cannot be unpacked" })
    })?;
    unpacked(&whole, version).ok_or_else(|| damaged("is cut off, or its counts are wrong"))?.made(start)
}

/// The numbers of the meshes, as names of parts.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<String>, FileError> {
    version(bytes, 0)?;
    let count = count(bytes).filter(|count| *count <= bytes.len() / 8).unwrap_or(1);
    Ok((0..count).map(|number| number.to_string()).collect())
}

fn version(bytes: &[u8], at: usize) -> Result<u16, FileError> {
    let number = |at: usize| bytes.get(at..at + 2).and_then(|two| two.try_into().ok()).map(u16::from_le_bytes);
    match (number(0), number(2)) {
        (Some(MAGIC), Some(version @ (3 | 4))) => Ok(version),
        (Some(MAGIC), Some(version)) => Err(FileError::new(
            format!("byte {}", at + 2),
            format!("version {version} of serialized files is not known"),
        )),
        _ => Err(FileError::new(format!("byte {at}"), "this is no serialized mesh of Mitsuba")),
    }
}

/// How many meshes the table says.
fn count(bytes: &[u8]) -> Option<usize> {
    let last = bytes.get(bytes.len().checked_sub(4)?..)?;
    usize::try_from(u32::from_le_bytes(last.try_into().ok()?)).ok()
}

/// Where a mesh begins and ends.
fn place(bytes: &[u8], number: usize) -> Result<(usize, usize), FileError> {
    let version = version(bytes, 0)?;
    let wide = if version == 4 { 8 } else { 4 };
    let table = |count: usize| bytes.len().checked_sub(4)?.checked_sub(count.checked_mul(wide)?);
    let wrong = || {
        let at = format!("byte {}", bytes.len().saturating_sub(4));
        FileError::new(at, "the table of meshes at the end does not fit the file")
            .help("the file is cut off, or damaged")
    };
    let count = count(bytes).ok_or_else(wrong)?;
    let table = table(count).ok_or_else(wrong)?;
    if number >= count {
        let message = format!("the file has no mesh {number}: it has {count}, counted from 0");
        return Err(FileError::new("", message));
    }
    let entry = |number: usize| -> Option<usize> {
        let at = table + number * wide;
        let field = bytes.get(at..at + wide)?;
        let place = match <[u8; 8]>::try_from(field) {
            Ok(eight) => u64::from_le_bytes(eight),
            Err(_) => u64::from(u32::from_le_bytes(field.try_into().ok()?)),
        };
        usize::try_from(place).ok()
    };
    let start = entry(number).ok_or_else(wrong)?;
    let end = if number + 1 < count { entry(number + 1).ok_or_else(wrong)? } else { table };
    if start + 4 > end || end > table { Err(wrong()) } else { Ok((start, end)) }
}

/// What a mesh holds.
struct Unpacked {
    geometry: Geometry,
    flags: u32,
}

impl Unpacked {
    fn made(self, start: usize) -> Result<(Geometry, Vec<Note>), FileError> {
        let Self { mut geometry, flags } = self;
        let mut notes = Vec::new();
        if flags & COLORS != 0 {
            notes.push(Note::dropped(format!("byte {start}"), "colors of vertices are left out"));
        }
        if flags & FLAT != 0 {
            geometry.normals = None;
        }
        if geometry.triangles.is_empty() {
            return Err(FileError::new(format!("byte {start}"), "the mesh has no triangle"));
        }
        if let Err(error) = geometry.check_indices() {
            return Err(FileError::new(format!("byte {start}"), error.message));
        }
        finish(&mut geometry, &mut notes, |vertex| format!("vertex {vertex}"))?;
        Ok((geometry, notes))
    }
}

/// A mesh from its bytes; none where they end too early.
fn unpacked(bytes: &[u8], version: u16) -> Option<Unpacked> {
    let mut rest = bytes;
    let flags = u32::from_le_bytes(*take::<4>(&mut rest)?);
    if version == 4 {
        let end = rest.iter().take(HEAD).position(|byte| *byte == 0)?;
        rest = &rest[end + 1..];
    }
    let vertices = usize::try_from(u64::from_le_bytes(*take::<8>(&mut rest)?)).ok()?;
    let triangles = usize::try_from(u64::from_le_bytes(*take::<8>(&mut rest)?)).ok()?;
    let double = match flags & (SINGLE | DOUBLE) {
        SINGLE => false,
        DOUBLE => true,
        _ => return None,
    };
    let positions = vectors::<3>(&mut rest, vertices, double)?;
    let normals = if flags & NORMALS != 0 { Some(vectors::<3>(&mut rest, vertices, double)?) } else { None };
    let uvs = if flags & UVS != 0 { Some(vectors::<2>(&mut rest, vertices, double)?) } else { None };
    if flags & COLORS != 0 {
        vectors::<3>(&mut rest, vertices, double)?;
    }
    // Indices of 64 bits stand only where there are more vertices than 32 bits can say, which no mesh of the Scene has.
    let size = triangles.checked_mul(12)?;
    let indices = rest.get(..size)?.as_chunks::<4>().0;
    let triangles = indices.as_chunks::<3>().0.iter().map(|three| three.map(u32::from_le_bytes)).collect();
    Some(Unpacked { geometry: Geometry { positions, normals, uvs, triangles }, flags })
}

fn take<'b, const N: usize>(rest: &mut &'b [u8]) -> Option<&'b [u8; N]> {
    let (first, others) = rest.split_first_chunk::<N>()?;
    *rest = others;
    Some(first)
}

fn vectors<const N: usize>(rest: &mut &[u8], count: usize, double: bool) -> Option<Vec<[f32; N]>> {
    let each = if double { 8 } else { 4 };
    let size = count.checked_mul(N)?.checked_mul(each)?;
    let (numbers, others) = rest.split_at_checked(size)?;
    *rest = others;
    Some(if double {
        let values = numbers.as_chunks::<8>().0.as_chunks::<N>().0;
        values.iter().map(|vector| vector.map(|value| f64::from_le_bytes(value) as f32)).collect()
    } else {
        let values = numbers.as_chunks::<4>().0.as_chunks::<N>().0;
        values.iter().map(|vector| vector.map(f32::from_le_bytes)).collect()
    })
}

#[cfg(test)]
mod tests {
    use miniz_oxide::deflate::compress_to_vec_zlib;

    use super::*;

    fn mesh(version: u16, flags: u32, double: bool, shift: f64) -> Vec<u8> {
        let mut plain = (flags | if double { DOUBLE } else { SINGLE }).to_le_bytes().to_vec();
        if version == 4 {
            plain.extend(b"a name\0");
        }
        plain.extend(4_u64.to_le_bytes());
        plain.extend(2_u64.to_le_bytes());
        let mut put = |values: &[f64]| {
            for value in values {
                if double {
                    plain.extend(value.to_le_bytes());
                } else {
                    plain.extend((*value as f32).to_le_bytes());
                }
            }
        };
        put(&[shift, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        if flags & NORMALS != 0 {
            put(&[0.0, 0.0, 1.0].repeat(4));
        }
        if flags & UVS != 0 {
            put(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
        }
        if flags & COLORS != 0 {
            put(&[0.5; 12]);
        }
        for index in [0_u32, 1, 2, 0, 2, 3] {
            plain.extend(index.to_le_bytes());
        }
        let mut bytes = MAGIC.to_le_bytes().to_vec();
        bytes.extend(version.to_le_bytes());
        bytes.extend(compress_to_vec_zlib(&plain, 6));
        bytes
    }

    fn file(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut places = Vec::new();
        for mesh in meshes {
            places.push(bytes.len());
            bytes.extend(mesh);
        }
        for place in &places {
            if version == 4 {
                bytes.extend((*place as u64).to_le_bytes());
            } else {
                bytes.extend((*place as u32).to_le_bytes());
            }
        }
        bytes.extend((places.len() as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn all_meshes_of_a_file_are_read() {
        for version in [3, 4] {
            let bytes = file(version, &[mesh(version, NORMALS | UVS, false, 0.0), mesh(version, COLORS, true, 0.25)]);
            assert_eq!(parts(&bytes), Ok(vec!["0".to_owned(), "1".to_owned()]));
            let (first, notes) = read(&bytes, None).expect("a mesh");
            assert_eq!((first.positions.len(), first.triangles, notes.len()), (4, vec![[0, 1, 2], [0, 2, 3]], 0));
            assert_eq!(first.uvs.expect("coordinates")[2], [1.0, 1.0]);
            assert_eq!(first.normals.expect("normals")[3], [0.0, 0.0, 1.0]);
            let (second, notes) = read(&bytes, Some("1")).expect("a mesh");
            assert_eq!((second.positions[0], second.normals, notes.len()), ([0.25, 0.0, 0.0], None, 1));
            assert!(read(&bytes, Some("2")).is_err() && read(&bytes, Some("x")).is_err());
        }
    }

    #[test]
    fn a_damaged_file_is_refused_wherever_it_is_cut() {
        let bytes = file(4, &[mesh(4, NORMALS, false, 0.0)]);
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end], None).is_err(), "{end}");
        }
        // A stream that grows without end, and an index beyond the vertices.
        let mut bomb = MAGIC.to_le_bytes().to_vec();
        bomb.extend(4_u16.to_le_bytes());
        bomb.extend(compress_to_vec_zlib(&vec![0; 1 << 22], 9));
        let told = read(&file(4, &[bomb]), None).expect_err("too large");
        assert!(told.message.contains("hundred"), "{told}");
    }
}
