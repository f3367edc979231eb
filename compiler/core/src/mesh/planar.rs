//! How many triangles a surface needs when neighbors that lie in one plane are merged.

use super::smooth::{Groups, position_ids};
use super::{View, face_normal};
use crate::ir::{Vec3, cross, dot, sub};

/// How far, as a part of the largest coordinate, a point may lie from a plane or a line that it belongs to: four units in the last
/// place of single precision, the rounding of the points that span the plane.
const FLAT: f64 = 1.0 / (1 << 21) as f64;

/// The least number of triangles that make the same surface, at most the number of its triangles.
///
/// Neighbors belong together where exactly two faces share an edge and one plane. A vertex at the border of a plane may go
/// where its border runs straight on through it, so that the surface stays closed. A polygon of `n` corners in `l` loops is cut
/// into `n + 2 l - 4` triangles; `l` follows from Euler's formula. Triangles without area and those with a wrong index do not
/// count.
pub fn fewest_triangles(view: View<'_>) -> usize {
    let ids = position_ids(view.positions);
    let place = |id: u32| view.positions[id as usize].map(f64::from);
    let mut faces: Vec<([u32; 3], Vec3)> = Vec::with_capacity(view.triangles.len());
    for triangle in view.triangles {
        if triangle.iter().any(|index| *index as usize >= ids.len()) {
            continue;
        }
        let points = triangle.map(|index| ids[index as usize]);
        if let Some(normal) = face_normal(points.map(place)) {
            faces.push((points, normal));
        }
    }

    // Every edge with its face, the ends in order.
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(faces.len() * 3);
    for (at, ([a, b, c], _)) in (0_u32..).zip(&faces) {
        edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([*from.min(to), *from.max(to)], at)));
    }
    edges.sort_unstable();
    let reach = view.positions.as_flattened().iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    let near = FLAT * f64::from(reach);
    let one_plane = |one: u32, other: u32| {
        let on = |face: u32, of: u32| {
            let (points, normal) = faces[face as usize];
            let start = place(points[0]);
            faces[of as usize].0.iter().all(|point| dot(normal, sub(place(*point), start)).abs() <= near)
        };
        let normals = dot(faces[one as usize].1, faces[other as usize].1);
        normals > 0.0 && on(one, other) && on(other, one)
    };
    let mut groups = Groups::new(faces.len());
    for same in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [(_, one), (_, other)] = same
            && one_plane(*one, *other)
        {
            groups.join(*one, *other);
        }
    }
    let region: Vec<u32> = (0..faces.len() as u32).map(|face| groups.find(face)).collect();

    // Vertices less edges plus faces, by region: the Euler characteristic.
    let mut euler = vec![0_i64; faces.len()];
    let mut vertices: Vec<(u32, u32)> = Vec::with_capacity(faces.len() * 3);
    for ((points, _), own) in faces.iter().zip(&region) {
        euler[*own as usize] += 1;
        vertices.extend(points.map(|point| (point, *own)));
    }
    vertices.sort_unstable();
    vertices.dedup();
    for (_, own) in &vertices {
        euler[*own as usize] += 1;
    }
    // The ends of edges between regions, each from both sides.
    let mut border: Vec<(u32, u32)> = Vec::new();
    for same in edges.chunk_by(|one, other| one.0 == other.0) {
        let mut own: Vec<u32> = same.iter().map(|(_, face)| region[*face as usize]).collect();
        own.sort_unstable();
        let inner = same.len() == 2 && own[0] == own[1];
        own.dedup();
        for region in own {
            euler[region as usize] -= 1;
        }
        if !inner {
            let [from, to] = same[0].0;
            border.extend([(from, to), (to, from)]);
        }
    }
    border.sort_unstable();

    let mut needed: Vec<i64> = euler.iter().map(|characteristic| 2 * (2 - characteristic) - 4).collect();
    let mut ends = border.chunk_by(|one, other| one.0 == other.0).peekable();
    for here in vertices.chunk_by(|one, other| one.0 == other.0) {
        let Some(around) = ends.next_if(|around| around[0].0 == here[0].0) else { continue };
        if let [(_, one), (_, other)] = around
            && straight([*one, here[0].0, *other].map(place), near)
        {
            continue;
        }
        for (_, own) in here {
            needed[*own as usize] += 1;
        }
    }
    let mut counts = vec![0_i64; faces.len()];
    for own in &region {
        counts[*own as usize] += 1;
    }
    let least = |(needed, count): (i64, i64)| if count == 0 { 0 } else { needed.clamp(1, count) as usize };
    needed.into_iter().zip(counts).map(least).sum()
}

/// Whether the way through the points is straight: the middle one lies between the others, and near their line.
fn straight([from, here, to]: [Vec3; 3], near: f64) -> bool {
    let (whole, part) = (sub(to, from), sub(here, from));
    let across = cross(whole, part);
    let square = dot(whole, whole);
    (0.0..=square).contains(&dot(whole, part)) && dot(across, across) <= near * near * square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Affine;
    use crate::mesh::{Field, Geometry, Hole, boxed, height_field, plate, sphere, transform};

    fn fewest(geometry: &Geometry) -> usize {
        fewest_triangles(geometry.into())
    }

    fn raster(height: f64) -> Geometry {
        let field = Field::new((0.0, 1.0), (0.0, 1.0), (41, 41)).expect("a good field");
        let heights: Vec<f64> = field.places().map(|(x, _)| height * (x - 0.5).max(0.0)).collect();
        height_field(field, &heights).expect("good heights")
    }

    #[test]
    fn flat_rasters_need_two_triangles_a_side() {
        assert_eq!(fewest(&raster(0.0)), 2);
        // Folded once along a line of vertices.
        assert_eq!(fewest(&raster(0.5)), 4);
        let map = Affine::rotation([0.6, 0.0, 0.8], 37.0).then(&Affine::translation([50.0, -70.0, 11.0]));
        assert_eq!(fewest(&transform(raster(0.5), &map).expect("it fits")), 4);
    }

    #[test]
    fn nothing_can_be_merged_where_nothing_is_flat() {
        let ball = sphere(1.0, [0.0; 3], 16, 8).expect("a good sphere");
        // Two triangles of each quad lie in one plane, and it takes two to make it.
        assert_eq!(fewest(&ball), ball.triangles.len());
        assert_eq!(fewest(&boxed([0.0; 3], [1.0; 3]).expect("a good box")), 12);
        assert_eq!(fewest(&Geometry::default()), 0);
    }

    #[test]
    fn holes_are_counted_by_euler() {
        let hole = Hole { raster: [9, 9], columns: (2, 6), rows: (2, 6) };
        let plate = plate([0.0; 3], [9.0, 9.0, 0.5], hole).expect("a good plate");
        // Its documentation says that 32 is the least.
        assert_eq!((fewest(&plate), plate.triangles.len()), (32, 32));
    }
}
