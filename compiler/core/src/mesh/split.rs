//! Giving corners their own normals: a vertex becomes as many vertices as it has different normals.

use super::Geometry;

const NONE: u32 = u32::MAX;

/// How many normals of one vertex are compared before a new one is made: the tip of a fan of a million flat triangles
/// would else take the square of that.
const MOST_COMPARED: usize = 64;

/// Builds a geometry corner by corner. Corners with the same original vertex and the same normal, to the bit, share a
/// vertex (unless more than [`MOST_COMPARED`] others lie between them); texture coordinates come along.
pub(super) struct Splitter<'a> {
    old: &'a Geometry,
    new: Geometry,
    normals: Vec<[f32; 3]>,
    /// The newest vertex made from each original one, and for each made vertex the one before it.
    newest: Vec<u32>,
    before: Vec<u32>,
}

impl<'a> Splitter<'a> {
    /// Of `old`, whose indices have been checked.
    pub fn new(old: &'a Geometry) -> Self {
        let triangles = Vec::with_capacity(old.triangles.len());
        let uvs = old.uvs.as_ref().map(|_| Vec::new());
        let new = Geometry { positions: Vec::new(), normals: None, uvs, triangles };
        Self { old, new, normals: Vec::new(), newest: vec![NONE; old.positions.len()], before: Vec::new() }
    }

    /// Adds a triangle of the old geometry with a normal for each corner.
    pub fn push(&mut self, triangle: [u32; 3], normals: [[f32; 3]; 3]) {
        let mut corners = [0; 3];
        for ((corner, index), normal) in corners.iter_mut().zip(triangle).zip(normals) {
            *corner = self.vertex(index, normal);
        }
        self.new.triangles.push(corners);
    }

    /// The geometry, without the original vertices that no triangle used.
    pub fn finish(mut self) -> Geometry {
        self.new.normals = Some(self.normals);
        self.new
    }

    fn vertex(&mut self, original: u32, normal: [f32; 3]) -> u32 {
        let mut at = self.newest[original as usize];
        for _ in 0..MOST_COMPARED {
            if at == NONE {
                break;
            }
            if self.normals[at as usize].map(f32::to_bits) == normal.map(f32::to_bits) {
                return at;
            }
            at = self.before[at as usize];
        }
        let made = self.normals.len() as u32;
        self.new.positions.push(self.old.positions[original as usize]);
        self.normals.push(normal);
        if let (Some(new), Some(old)) = (&mut self.new.uvs, &self.old.uvs) {
            new.push(old[original as usize]);
        }
        self.before.push(std::mem::replace(&mut self.newest[original as usize], made));
        made
    }
}
