//! Bodies with a formula as meshes: what turns about the z axis, whole or in part.

use std::f64::consts::{PI, TAU};

use crate::mesh::Geometry;

/// Segments of a whole turn.
pub const SEGMENTS: usize = 96;

/// A profile that turns about the z axis: `at(v)` is radius, height and their derivatives, v from 0 to 1.
pub struct Profile<'p> {
    /// The profile.
    pub at: &'p dyn Fn(f64) -> [f64; 4],
    /// Steps along it.
    pub rows: usize,
    /// The angle of the turn.
    pub turn: f64,
}

/// The surface in the coordinates of PBRT: u along the turn, v along the profile, the normal dp/du x dp/dv.
pub fn turned(profile: &Profile<'_>) -> Geometry {
    let columns = ((SEGMENTS as f64 * profile.turn / TAU).ceil() as usize).clamp(3, SEGMENTS);
    let rows = profile.rows.max(1);
    let mut geometry = Geometry::default();
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    for row in 0..=rows {
        let v = row as f64 / rows as f64;
        let [radius, height, dr, dz] = (profile.at)(v);
        let size = (dr * dr + dz * dz).sqrt().max(1e-300);
        for column in 0..=columns {
            let u = column as f64 / columns as f64;
            // The seam of a whole turn meets itself.
            let closed = column == columns && profile.turn >= TAU - 1e-9;
            let angle = if closed { 0.0 } else { u * profile.turn };
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            geometry.positions.push([(radius * cosine) as f32, (radius * sine) as f32, height as f32]);
            let (out, up) = (dz / size, 0.0 - dr / size);
            normals.push([(out * cosine) as f32, (out * sine) as f32, up as f32]);
            uvs.push([u as f32, v as f32]);
        }
    }
    let index = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    let point = |row: usize| (profile.at)(row as f64 / rows as f64)[0].abs() < 1e-9;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [index(row, column), index(row, column + 1)];
            let [c, d] = [index(row + 1, column + 1), index(row + 1, column)];
            if !point(row) {
                geometry.triangles.push([a, b, c]);
            }
            if !point(row + 1) {
                geometry.triangles.push([a, c, d]);
            }
        }
    }
    geometry.normals = Some(normals);
    geometry.uvs = Some(uvs);
    geometry
}

/// A sphere between two heights.
pub fn sphere(radius: f64, low: f64, high: f64, turn: f64) -> Geometry {
    let angle = |z: f64| libm::acos((z / radius).clamp(-1.0, 1.0));
    let (from, to) = (angle(low), angle(high));
    let at = |v: f64| {
        let theta = from + v * (to - from);
        // Both poles exactly.
        let pole = (v == 0.0 && low <= -radius) || (v == 1.0 && high >= radius);
        let (sine, cosine) = (if pole { 0.0 } else { libm::sin(theta) }, libm::cos(theta));
        let step = to - from;
        [radius * sine, radius * cosine, radius * libm::cos(theta) * step, 0.0 - radius * libm::sin(theta) * step]
    };
    let rows = ((SEGMENTS as f64 / 2.0 * (from - to) / PI).ceil() as usize).clamp(2, SEGMENTS / 2);
    turned(&Profile { at: &at, rows, turn })
}

/// A line that turns: from radius and height to another.
pub fn line(from: [f64; 2], to: [f64; 2], turn: f64) -> Geometry {
    let (dr, dz) = (to[0] - from[0], to[1] - from[1]);
    let at = |v: f64| [from[0] + v * dr, from[1] + v * dz, dr, dz];
    turned(&Profile { at: &at, rows: 1, turn })
}

/// A paraboloid between two heights, as wide as `radius` at the height `top`.
pub fn paraboloid(radius: f64, top: f64, low: f64, high: f64, turn: f64) -> Geometry {
    let at = |v: f64| {
        let z = low + v * (high - low);
        let wide = radius * (z / top).max(0.0).sqrt();
        // At its tip it is flat.
        let dr = if wide > 0.0 { radius * radius / (2.0 * top * wide) * (high - low) } else { 1.0 };
        [wide, z, dr, if wide > 0.0 { high - low } else { 0.0 }]
    };
    turned(&Profile { at: &at, rows: SEGMENTS / 4, turn })
}
