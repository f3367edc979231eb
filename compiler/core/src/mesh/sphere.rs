//! The sphere of latitude and longitude.

use super::error::{finite, round};
use super::{Geometry, MAX_TRIANGLES, MeshError, degenerate_triangles};
use crate::ir::sin_cos_degrees;

/// A sphere of `2 * segments * (rings - 1)` triangles with analytic normals: `segments` strips around the z axis,
/// `rings` from pole to pole. Closed: vertices on the seam have equal positions to the bit.
///
/// Texture coordinates: `u` is the longitude over 360 degrees, counter-clockwise seen from above, `v` the latitude from
/// 0 at the lower pole to 1 at the upper one. A pole has one vertex per triangle, its `u` in the middle.
///
/// # Errors
/// A radius that is not positive and finite, fewer than 3 segments or 2 rings, more than [`MAX_TRIANGLES`], a sphere so
/// small against its distance from the origin that triangles vanish in single precision.
pub fn sphere(radius: f64, center: [f64; 3], segments: u64, rings: u64) -> Result<Geometry, MeshError> {
    if finite("radius", radius)? <= 0.0 {
        return Err(MeshError::new("radius", format!("the radius is {radius}, it must be positive")));
    }
    for coordinate in center {
        finite("center", coordinate)?;
    }
    if segments < 3 {
        return Err(MeshError::new("segments", format!("a sphere of {segments} segments has no volume"))
            .help("write at least 3 segments"));
    }
    if rings < 2 {
        return Err(
            MeshError::new("rings", format!("a sphere of {rings} rings has no volume")).help("write at least 2 rings")
        );
    }
    let count = u128::from(segments).saturating_mul(u128::from(rings - 1)).saturating_mul(2);
    if count > u128::from(MAX_TRIANGLES) {
        let message = format!("the sphere would have {count} triangles, more than the limit of {MAX_TRIANGLES}");
        return Err(MeshError::new("segments", message).help("write fewer segments and rings"));
    }
    // Both fit: their product is at most 25 million.
    let (segments, rings) = (segments as usize, rings as usize);
    let geometry = build(radius, center, segments, rings)?;
    let flat = center.iter().any(|c| (c - radius) as f32 == *c as f32 || (c + radius) as f32 == *c as f32);
    if flat || degenerate_triangles((&geometry).into()) > 0 {
        let message = "the sphere is so small or so fine that triangles vanish in single precision";
        return Err(MeshError::new("radius", message).help("write fewer segments and rings, or make it larger"));
    }
    Ok(geometry)
}

/// The vertices ring by ring from the lower pole: a pole's vertices, then rings of `segments + 1`, the last on the first.
fn build(radius: f64, center: [f64; 3], segments: usize, rings: usize) -> Result<Geometry, MeshError> {
    let around: Vec<(f64, f64)> = (0..segments).map(|s| sin_cos_degrees(360.0 * s as f64 / segments as f64)).collect();
    let vertices = (segments + 1) * (rings - 1) + 2 * segments;
    let mut positions = Vec::with_capacity(vertices);
    let mut normals = Vec::with_capacity(vertices);
    let mut uvs = Vec::with_capacity(vertices);
    let mut push = |normal: [f64; 3], u: f64, v: f64| {
        let point = [0, 1, 2].map(|i| center[i] + radius * normal[i]);
        positions.push(round("radius", point)?);
        normals.push(normal.map(|x| x as f32));
        uvs.push([u as f32, v as f32]);
        Ok::<(), MeshError>(())
    };
    for ring in 0..=rings {
        let v = ring as f64 / rings as f64;
        // The latitude from the lower pole: the radius of the ring and its height.
        let (out, down) = sin_cos_degrees(180.0 * v);
        if ring == 0 || ring == rings {
            for segment in 0..segments {
                push([0.0, 0.0, -down], (segment as f64 + 0.5) / segments as f64, v)?;
            }
        } else {
            for segment in 0..=segments {
                let (sine, cosine) = around[segment % segments];
                push([out * cosine, out * sine, -down], segment as f64 / segments as f64, v)?;
            }
        }
    }
    // At most 75 million vertices, which fits in 32 bits.
    let row = segments as u32 + 1;
    let first = segments as u32;
    let last = first + row * (rings as u32 - 2);
    let top = last + row;
    let mut triangles = Vec::with_capacity(2 * segments * (rings - 1));
    for segment in 0..segments as u32 {
        triangles.push([segment, first + segment + 1, first + segment]);
    }
    for ring in 1..rings as u32 - 1 {
        let below = first + row * (ring - 1);
        let above = below + row;
        for segment in 0..segments as u32 {
            let (a, b) = (below + segment, below + segment + 1);
            let (c, d) = (above + segment + 1, above + segment);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for segment in 0..segments as u32 {
        triangles.push([last + segment, last + segment + 1, top + segment]);
    }
    Ok(Geometry { positions, normals: Some(normals), uvs: Some(uvs), triangles })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{area, bounds, is_closed, largest_normal_deviation, signed_volume};
    use std::f64::consts::PI;

    #[test]
    fn fine_spheres_have_the_area_and_volume_of_the_ball() {
        let g = sphere(3.0, [1.0, 2.0, 3.0], 256, 128).expect("a good sphere");
        assert_eq!((g.triangles.len(), g.check()), (2 * 256 * 127, Ok(())));
        let view = (&g).into();
        assert!((area(view) / (4.0 * PI * 9.0) - 1.0).abs() < 5e-4, "{}", area(view));
        assert!((signed_volume(view) / (4.0 / 3.0 * PI * 27.0) - 1.0).abs() < 5e-4, "{}", signed_volume(view));
        assert!(is_closed(view) && degenerate_triangles(view) == 0);
        assert_eq!(bounds(view), Some([[-2.0, -1.0, 0.0], [4.0, 5.0, 6.0]]));
        // A triangle at the pole spans a ring of latitude, and its normal leans a half ring from its far vertices'.
        let deviation = largest_normal_deviation(view).expect("it has normals");
        assert!(deviation > 0.5 && deviation < 2.0 * 180.0 / 128.0, "{deviation}");
    }

    #[test]
    fn volume_is_that_of_the_polyhedron() {
        // Stacked frusta over regular polygons: the exact volume of the coarse mesh.
        for (segments, rings) in [(3, 2), (4, 2), (5, 3), (8, 7)] {
            let g = sphere(1.0, [0.0; 3], segments, rings).expect("a good sphere");
            let polygon = 0.5 * segments as f64 * libm::sin(2.0 * PI / segments as f64);
            let slice = |ring: u64| libm::sincos(PI * ring as f64 / rings as f64);
            // Quads of the sphere are plane trapezoids, so each layer is a frustum of a pyramid.
            let volume: f64 = (0..rings)
                .map(|ring| {
                    let ((r0, z0), (r1, z1)) = (slice(ring), slice(ring + 1));
                    polygon * (z0 - z1) * (r0 * r0 + r0 * r1 + r1 * r1) / 3.0
                })
                .sum();
            assert!((signed_volume((&g).into()) - volume).abs() < 1e-6, "{segments} x {rings}");
            assert!(is_closed((&g).into()));
        }
    }

    #[test]
    fn the_axes_are_met_exactly() {
        let g = sphere(1.0, [0.0; 3], 8, 4).expect("a good sphere");
        for point in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]] {
            assert!(g.positions.contains(&point), "{point:?}");
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        let at = |radius, center, segments, rings| {
            sphere(radius, center, segments, rings).map(|_| ()).expect_err("bad").argument
        };
        let fault = |radius, segments, rings| at(radius, [0.0; 3], segments, rings);
        assert_eq!(fault(0.0, 64, 32), "radius");
        assert_eq!(fault(f64::NAN, 64, 32), "radius");
        assert_eq!(fault(-1.0, 64, 32), "radius");
        assert_eq!(fault(1.0, 0, 32), "segments");
        assert_eq!(fault(1.0, 64, 1), "rings");
        assert_eq!(fault(1.0, 4_000_000_000, 4_000_000_000), "segments");
        assert_eq!(fault(1.0, u64::MAX, u64::MAX), "segments");
        assert_eq!(fault(1e300, 3, 2), "radius");
        assert_eq!(at(1e-6, [1e6, 0.0, 0.0], 64, 32), "radius");
        assert_eq!(at(1.0, [1e6; 3], 64, 32), "radius");
        assert_eq!(at(1.0, [f64::INFINITY, 0.0, 0.0], 64, 32), "center");
    }
}
