//! The buffer of a glTF: which bytes lie where, and writing them in blocks.

use std::io::{self, Write};

use super::container::pad;
use super::document::{Accessor, Attributes, BufferView};
use super::names::{ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, FLOAT, UNSIGNED_INT};
use crate::ir::{Affine, Mesh, dot, normalized};

/// Items that are turned to bytes at a time.
const BLOCK: usize = 1 << 16;

/// What lies in the buffer.
enum Part<'a> {
    /// A mesh, as it is or moved by a map that no glTF node can hold.
    Mesh { mesh: &'a Mesh, map: Option<Affine> },
    /// A file, padded to a multiple of four bytes.
    File(&'a [u8]),
    /// Numbers.
    Floats(Vec<f32>),
}

/// Where a mesh lies: indices of accessors.
#[derive(Clone, Copy)]
pub struct Place {
    pub attributes: Attributes,
    pub indices: usize,
}

/// All parts in the order in which they are written.
#[derive(Default)]
pub struct Layout<'a> {
    parts: Vec<Part<'a>>,
    pub accessors: Vec<Accessor>,
    pub views: Vec<BufferView>,
    pub bytes: u64,
}

impl<'a> Layout<'a> {
    /// Adds a mesh, which has vertices and triangles, moved by `map`.
    pub fn mesh(&mut self, mesh: &'a Mesh, map: Option<Affine>) -> Place {
        let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
        let count = positions.len();
        let (low, high) = bounds(positions, map.as_ref());
        let position = self.push(count, 12, FLOAT, "VEC3", Some(ARRAY_BUFFER));
        if let Some(accessor) = self.accessors.last_mut() {
            accessor.min = Some(low);
            accessor.max = Some(high);
        }
        let normal = normals.is_some().then(|| self.push(count, 12, FLOAT, "VEC3", Some(ARRAY_BUFFER)));
        let texcoord = uvs.is_some().then(|| self.push(count, 8, FLOAT, "VEC2", Some(ARRAY_BUFFER)));
        let corners = triangles.len() * 3;
        let indices = self.push(corners, 4, UNSIGNED_INT, "SCALAR", Some(ELEMENT_ARRAY_BUFFER));
        self.parts.push(Part::Mesh { mesh, map });
        Place { attributes: Attributes { position, normal, texcoord }, indices }
    }

    /// Adds vectors; gives their accessor.
    pub fn floats<const N: usize>(&mut self, items: Vec<[f32; N]>, r#type: &'static str) -> usize {
        let accessor = self.push(items.len(), 4 * N, FLOAT, r#type, None);
        self.parts.push(Part::Floats(items.into_flattened()));
        accessor
    }

    /// Adds a file; gives its buffer view.
    pub fn file(&mut self, bytes: &'a [u8]) -> usize {
        self.view(bytes.len(), None);
        self.bytes += pad(bytes.len()) as u64;
        self.parts.push(Part::File(bytes));
        self.views.len() - 1
    }

    /// Writes the bytes of all parts.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for part in &self.parts {
            match part {
                Part::Mesh { mesh, map } => write_mesh(mesh, map.as_ref(), out)?,
                Part::Floats(numbers) => rows(numbers.as_chunks::<1>().0, |number| number, out)?,
                Part::File(bytes) => {
                    out.write_all(bytes)?;
                    out.write_all(&[0; 3][..pad(bytes.len())])?;
                }
            }
        }
        Ok(())
    }

    /// Adds an accessor over a view of its own.
    fn push(
        &mut self,
        count: usize,
        size: usize,
        component_type: u32,
        r#type: &'static str,
        target: Option<u32>,
    ) -> usize {
        let buffer_view = self.views.len();
        self.view(count * size, target);
        let accessor = Accessor { buffer_view, component_type, count, r#type, min: None, max: None };
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: usize, target: Option<u32>) {
        let byte_length = bytes as u64;
        self.views.push(BufferView { buffer: 0, byte_offset: self.bytes, byte_length, target });
        self.bytes += byte_length;
    }
}

fn write_mesh(mesh: &Mesh, map: Option<&Affine>, out: &mut dyn Write) -> io::Result<()> {
    let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
    match map {
        None => rows(positions, |position| position, out)?,
        Some(map) => rows(positions, |position| moved(map, position), out)?,
    }
    match (normals, map) {
        (None, _) => {}
        (Some(normals), None) => rows(normals, |normal| normal, out)?,
        (Some(normals), Some(map)) => {
            let cofactors = map.cofactors();
            rows(normals, |normal| turned(&cofactors, normal), out)?;
        }
    }
    if let Some(uvs) = uvs {
        // glTF's v grows downwards in the image.
        rows(uvs, |[u, v]| [u, 1.0 - v], out)?;
    }
    let mut block = Vec::with_capacity(12 * BLOCK.min(triangles.len()));
    for some in triangles.chunks(BLOCK) {
        block.clear();
        block.extend(some.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
        out.write_all(&block)?;
    }
    Ok(())
}

fn rows<const N: usize>(items: &[[f32; N]], map: impl Fn([f32; N]) -> [f32; N], out: &mut dyn Write) -> io::Result<()> {
    let mut block = Vec::with_capacity(4 * N * BLOCK.min(items.len()));
    for some in items.chunks(BLOCK) {
        block.clear();
        block.extend(some.iter().flat_map(|item| map(*item)).flat_map(f32::to_le_bytes));
        out.write_all(&block)?;
    }
    Ok(())
}

fn moved(map: &Affine, position: [f32; 3]) -> [f32; 3] {
    map.point(position.map(f64::from)).map(|x| x as f32)
}

fn turned(cofactors: &[[f64; 3]; 3], normal: [f32; 3]) -> [f32; 3] {
    let turned = cofactors.map(|row| dot(row, normal.map(f64::from)));
    normalized(turned).map_or(normal, |unit| unit.map(|x| x as f32))
}

/// The exact bounds of the positions as they are written.
pub fn bounds(positions: &[[f32; 3]], map: Option<&Affine>) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in positions {
        let position = map.map_or(*position, |map| moved(map, *position));
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    // Negative zeros would print as such.
    (low.map(|x| f64::from(x) + 0.0), high.map(|x| f64::from(x) + 0.0))
}
