//! Surfaces of revolution about the z axis: what the round generators share.

use super::error::{finite, round};
use super::{Geometry, MAX_TRIANGLES, MeshError, degenerate_triangles};
use crate::ir::sin_cos_degrees;

/// A circle of a surface of revolution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Distance from the axis, at least 0; 0 makes a pole.
    pub r: f64,
    /// Height.
    pub z: f64,
    /// Away from the axis and along it, of unit length.
    pub normal: [f64; 2],
    /// The second texture coordinate.
    pub v: f64,
}

/// A surface of revolution in the making.
pub(super) struct Revolution {
    /// What is made, in words and with its article.
    what: &'static str,
    /// The argument that says how large it is.
    argument: &'static str,
    /// Sine and cosine of the longitude of each corner of the regular polygon.
    around: Vec<(f64, f64)>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Revolution {
    /// A surface that is still empty and will have `slice` triangles in each of `segments` segments.
    ///
    /// # Errors
    /// Fewer than 3 segments, more than [`MAX_TRIANGLES`].
    pub fn new(what: &'static str, argument: &'static str, segments: u64, slice: u64) -> Result<Self, MeshError> {
        if segments < 3 {
            return Err(MeshError::new("segments", format!("{what} of {segments} segments is flat"))
                .help("write at least 3 segments"));
        }
        let count = u128::from(segments) * u128::from(slice);
        if count > u128::from(MAX_TRIANGLES) {
            let message = format!("{what} would have {count} triangles, more than the limit of {MAX_TRIANGLES}");
            return Err(MeshError::new("segments", message).help("write fewer segments"));
        }
        Ok(Self {
            what,
            argument,
            around: (0..segments).map(|at| sin_cos_degrees(360.0 * at as f64 / segments as f64)).collect(),
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            // The product is below the limit, so it fits.
            triangles: Vec::with_capacity(count as usize),
        })
    }

    /// Joins each row to the next. Outside is on the right hand of the direction of the rows, in the half-plane where
    /// the radius grows to the right and z upwards. The first texture coordinate is the longitude over 360 degrees,
    /// counter-clockwise seen from above, with a seam at 0; a pole has one vertex per segment, in its middle.
    ///
    /// # Errors
    /// A vertex beyond the range of single precision.
    pub fn strip(&mut self, rows: &[Row]) -> Result<(), MeshError> {
        let mut below: Option<(u32, bool)> = None;
        for row in rows {
            // At most MAX_TRIANGLES use these vertices, and no vertex is unused: 32 bits are enough.
            let start = self.positions.len() as u32;
            let pole = row.r == 0.0;
            self.circle(row)?;
            if let Some((first, was_pole)) = below {
                self.band(first, was_pole, start, pole);
            }
            below = Some((start, pole));
        }
        Ok(())
    }

    /// The vertices of a row: one for each end of a segment, or for a pole one for each segment.
    fn circle(&mut self, row: &Row) -> Result<(), MeshError> {
        let segments = self.around.len();
        let pole = row.r == 0.0;
        for at in 0..segments + usize::from(!pole) {
            let longitude = if pole { at as f64 + 0.5 } else { at as f64 } / segments as f64;
            let (sine, cosine) = if pole { sin_cos_degrees(360.0 * longitude) } else { self.around[at % segments] };
            let [out, up] = row.normal;
            self.vertex([row.r * cosine, row.r * sine, row.z], [out * cosine, out * sine, up], [longitude, row.v])?;
        }
        Ok(())
    }

    /// The triangles between two rows that begin at the vertices `a` and `b`.
    fn band(&mut self, a: u32, a_is_pole: bool, b: u32, b_is_pole: bool) {
        for at in 0..self.around.len() as u32 {
            let (a, b) = (a + at, b + at);
            match (a_is_pole, b_is_pole) {
                (false, false) => self.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]),
                (true, false) => self.triangles.push([a, b + 1, b]),
                (false, true) => self.triangles.push([a, a + 1, b]),
                // A stretch of the axis has no area.
                (true, true) => {}
            }
        }
    }

    /// A flat disk at height `z` from radius `inner` (0: none is left out) to `outer`, facing up or down. Its vertices
    /// lie on those of a strip that ends there; its texture is a square round it, upright for someone before it.
    ///
    /// # Errors
    /// A vertex beyond the range of single precision.
    pub fn disk(&mut self, outer: f64, inner: f64, z: f64, up: bool) -> Result<(), MeshError> {
        let sign = if up { 1.0 } else { -1.0 };
        let start = self.positions.len() as u32;
        let count = self.around.len() as u32;
        for r in if inner == 0.0 { vec![outer] } else { vec![outer, inner] } {
            for at in 0..self.around.len() {
                let (sine, cosine) = self.around[at];
                let uv = [0.5 + 0.5 * sign * cosine * (r / outer), 0.5 + 0.5 * sine * (r / outer)];
                self.vertex([r * cosine, r * sine, z], [0.0, 0.0, sign], uv)?;
            }
        }
        if inner == 0.0 {
            self.vertex([0.0, 0.0, z], [0.0, 0.0, sign], [0.5, 0.5])?;
        }
        for at in 0..count {
            let (here, next) = (start + at, start + (at + 1) % count);
            let (from, to) = if up { (here, next) } else { (next, here) };
            if inner == 0.0 {
                self.triangles.push([start + count, from, to]);
            } else {
                self.triangles.extend([[from + count, from, to], [from + count, to, to + count]]);
            }
        }
        Ok(())
    }

    /// The surface.
    ///
    /// # Errors
    /// A triangle without area: the surface is too small or too fine.
    pub fn finish(self) -> Result<Geometry, MeshError> {
        let Self { what, argument, around: _, positions, normals, uvs, triangles } = self;
        let geometry = Geometry { positions, normals: Some(normals), uvs: Some(uvs), triangles };
        if degenerate_triangles((&geometry).into()) > 0 {
            let message = format!("{what} so small or so fine has triangles that vanish in single precision");
            return Err(MeshError::new(argument, message).help("write fewer segments, or make it larger"));
        }
        Ok(geometry)
    }

    fn vertex(&mut self, position: [f64; 3], normal: [f64; 3], uv: [f64; 2]) -> Result<(), MeshError> {
        // Adding 0 turns -0 to 0: a place has one pattern of bits.
        self.positions.push(round(self.argument, position)?.map(|x| x + 0.0));
        self.normals.push(normal.map(|x| x as f32 + 0.0));
        self.uvs.push(uv.map(|x| x as f32));
        Ok(())
    }
}

/// `value` if it is finite and greater than 0.
pub(super) fn positive(argument: &'static str, value: f64) -> Result<f64, MeshError> {
    if finite(argument, value)? > 0.0 {
        return Ok(value);
    }
    Err(MeshError::new(argument, format!("`{argument}` is {value}, it must be greater than 0")))
}

/// `value` if it is finite and not negative.
pub(super) fn not_negative(argument: &'static str, value: f64) -> Result<f64, MeshError> {
    if finite(argument, value)? >= 0.0 {
        return Ok(value);
    }
    Err(MeshError::new(argument, format!("`{argument}` is {value}, it must be at least 0")))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::ir::dot;
    use crate::mesh::{View, area, face_normal, signed_volume};
    use std::f64::consts::PI;

    /// Area and volume of the polyhedron whose horizontal sections are regular polygons with corners on the surface:
    /// each stretch of the profile makes a frustum of a pyramid, its sides plane trapezoids.
    pub(in crate::mesh) fn polyhedron(stretches: &[[[f64; 2]; 2]], segments: u64) -> (f64, f64) {
        let n = segments as f64;
        let (half_edge, apothem) = (libm::sin(PI / n), libm::cos(PI / n));
        let polygon = n * half_edge * apothem;
        let mut sums = (0.0, 0.0);
        for [[r0, z0], [r1, z1]] in stretches {
            let slant = libm::hypot(z1 - z0, apothem * (r1 - r0));
            sums.0 += n * half_edge * (r0 + r1) * slant;
            sums.1 += polygon * (z1 - z0) * (r0 * r0 + r0 * r1 + r1 * r1) / 3.0;
        }
        sums
    }

    /// Holds for every mesh of a generator; `closed` where the surface must be.
    pub(in crate::mesh) fn sound(g: &Geometry, stretches: &[[[f64; 2]; 2]], segments: u64, closed: bool) {
        assert_eq!(g.check(), Ok(()));
        let view = View::from(g);
        let (expected_area, expected_volume) = polyhedron(stretches, segments);
        assert!((area(view) / expected_area - 1.0).abs() < 1e-5, "area {} {expected_area}", area(view));
        if closed {
            let volume = signed_volume(view);
            assert!((volume / expected_volume - 1.0).abs() < 1e-5, "volume {volume} {expected_volume}");
            assert!(volume > 0.0);
        }
        assert_eq!(crate::mesh::is_closed(view), closed);
        assert_eq!(degenerate_triangles(view), 0);
        assert!(g.uvs.iter().flatten().flatten().all(|x| (0.0..=1.0).contains(x)));
        assert!(g.normals.iter().flatten().all(|n| (dot(n.map(f64::from), n.map(f64::from)) - 1.0).abs() < 1e-6));
        // The winding and the normals agree, and every vertex is used.
        let normals = g.normals.as_ref().expect("it has normals");
        let mut used = vec![false; g.positions.len()];
        for triangle in &g.triangles {
            let corners = triangle.map(|index| g.positions[index as usize].map(f64::from));
            let face = face_normal(corners).expect("it has an area");
            for index in triangle {
                used[*index as usize] = true;
                assert!(dot(face, normals[*index as usize].map(f64::from)) > 0.0, "{triangle:?}");
            }
        }
        assert!(used.iter().all(|used| *used));
    }
}
