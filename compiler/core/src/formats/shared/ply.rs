//! Binary little-endian PLY files, written in large blocks.

use std::io::{self, Write};

use crate::ir::Mesh;

/// Vertices or triangles that are turned to bytes at a time: about 2 MB, which stays in the cache and makes the
/// number of writes small.
const BLOCK: usize = 1 << 16;

/// Writes `mesh` with float32 `x y z`, `nx ny nz` where it has normals, `s t` where it has texture coordinates, and
/// triangles as `list uchar int vertex_indices`.
///
/// These are the properties that Mitsuba 0.5 to 3.9, PBRT v3 and v4, rs_pbrt 0.9.12 and LuxCore 2.11 all read; `s t`
/// rather than `u v` because LuxCore knows only those (`exttrianglemeshfile.cpp`). The header holds no comment, hence
/// nothing that differs from run to run.
pub fn write(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    header.push_str(&format!("element vertex {}\n", positions.len()));
    let has_normals = normals.is_some();
    let has_uvs = uvs.is_some();
    let properties: &[&str] = match (has_normals, has_uvs) {
        (false, false) => &["x", "y", "z"],
        (true, false) => &["x", "y", "z", "nx", "ny", "nz"],
        (false, true) => &["x", "y", "z", "s", "t"],
        (true, true) => &["x", "y", "z", "nx", "ny", "nz", "s", "t"],
    };
    for property in properties {
        header.push_str(&format!("property float {property}\n"));
    }
    header.push_str(&format!("element face {}\n", triangles.len()));
    header.push_str("property list uchar int vertex_indices\nend_header\n");
    out.write_all(header.as_bytes())?;

    let stride = 4 * properties.len();
    let mut block = vec![0_u8; BLOCK.min(positions.len()) * stride];
    for (at, some) in positions.chunks(BLOCK).enumerate() {
        let bytes = &mut block[..some.len() * stride];
        put(bytes, stride, 0, some);
        let same = at * BLOCK..at * BLOCK + some.len();
        if let Some(normals) = normals {
            put(bytes, stride, 12, &normals[same.clone()]);
        }
        if let Some(uvs) = uvs {
            put(bytes, stride, if has_normals { 24 } else { 12 }, &uvs[same]);
        }
        out.write_all(bytes)?;
    }

    let mut block = vec![0_u8; BLOCK.min(triangles.len()) * 13];
    for some in triangles.chunks(BLOCK) {
        let bytes = &mut block[..some.len() * 13];
        for (face, corners) in bytes.chunks_exact_mut(13).zip(some) {
            face[0] = 3;
            for (place, index) in face[1..].chunks_exact_mut(4).zip(corners) {
                place.copy_from_slice(&index.to_le_bytes());
            }
        }
        out.write_all(bytes)?;
    }
    Ok(())
}

/// Puts the components of each item at `offset` of its row.
fn put<const N: usize>(rows: &mut [u8], stride: usize, offset: usize, items: &[[f32; N]]) {
    for (row, item) in rows.chunks_exact_mut(stride).zip(items) {
        for (place, value) in row[offset..].chunks_exact_mut(4).zip(item) {
            place.copy_from_slice(&value.to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Geometry;

    fn triangle() -> Geometry {
        Geometry {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            normals: None,
            uvs: None,
            triangles: vec![[0, 1, 2]],
        }
    }

    fn written(geometry: Geometry) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&geometry.into_mesh("m"), &mut bytes).expect("memory takes all");
        bytes
    }

    fn split(bytes: &[u8]) -> (String, &[u8]) {
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|window| window == end).expect("a header");
        let (head, body) = bytes.split_at(at + end.len());
        (String::from_utf8_lossy(head).into_owned(), body)
    }

    #[test]
    fn a_triangle_has_these_bytes() {
        let bytes = written(triangle());
        let (head, body) = split(&bytes);
        assert_eq!(
            head,
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty \
             float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        );
        let one = 1.0_f32.to_le_bytes();
        assert_eq!((body.len(), &body[12..16]), (3 * 12 + 13, &one[..]));
        assert_eq!(body[36..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    }

    #[test]
    fn normals_and_texture_coordinates_lie_beside_the_positions() {
        let mut full = triangle();
        full.normals = Some(vec![[0.0, 0.0, 1.0]; 3]);
        full.uvs = Some(vec![[0.25, 0.5]; 3]);
        let bytes = written(full);
        let (head, body) = split(&bytes);
        assert!(head.contains("nz\nproperty float s\nproperty float t\n"));
        let row: Vec<f32> =
            body[32..64].chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect();
        assert_eq!(row, [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.25, 0.5]);
    }

    #[test]
    fn large_meshes_cross_block_borders() {
        let count = BLOCK as u32 + 5;
        let geometry = Geometry {
            positions: (0..count).map(|i| [i as f32, 0.0, 0.0]).collect(),
            normals: Some((0..count).map(|i| [0.0, i as f32, 1.0]).collect()),
            uvs: None,
            triangles: (0..count).map(|i| [i, 0, 1]).collect(),
        };
        let bytes = written(geometry);
        let (_, body) = split(&bytes);
        assert_eq!(body.len(), count as usize * (24 + 13));
        let last = (count as usize - 1) * 24;
        assert_eq!(body[last..last + 4], (count as f32 - 1.0).to_le_bytes());
        assert_eq!(body[last + 16..last + 20], (count as f32 - 1.0).to_le_bytes());
        let face = count as usize * 24 + (count as usize - 1) * 13;
        assert_eq!(body[face + 1..face + 5], (count - 1).to_le_bytes());
    }
}
