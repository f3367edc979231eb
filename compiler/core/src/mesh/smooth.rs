//! Smooth shading: normals averaged over the faces that meet at a point, with creases.

use super::split::Splitter;
use super::{Geometry, MeshError, face_normal};
use crate::ir::{Vec3, cross, dot, length, normalized, sub};

/// The geometry with angle-weighted vertex normals (Thürmer and Wüthrich 1998), and how many triangles had no area and
/// were dropped. Vertices at equal positions count as one point, whatever their texture coordinates.
///
/// `crease` is the largest angle in degrees between the normals of two neighboring faces that are still shaded as one
/// surface: where faces meet at an edge at a larger angle, or where more than two meet, the normal breaks. At 180
/// degrees all faces around a point share one normal.
///
/// # Errors
/// A crease that is not between 0 and 180 degrees; indices out of range, or arrays of different lengths.
pub fn smooth(geometry: Geometry, crease: f64) -> Result<(Geometry, usize), MeshError> {
    if !(0.0..=180.0).contains(&crease) {
        return Err(MeshError::new("crease", format!("the crease angle is {crease} degrees"))
            .help("write an angle from `0deg` to `180deg`"));
    }
    geometry.check_indices()?;
    let points = position_ids(&geometry.positions);
    let faces: Vec<Face> = geometry.triangles.iter().filter_map(|triangle| Face::new(*triangle, &geometry)).collect();
    let dropped = geometry.triangles.len() - faces.len();

    let mut groups = Groups::new(faces.len() * 3);
    if crease >= 180.0 {
        // The first corner at each point.
        let mut first = vec![u32::MAX; geometry.positions.len()];
        for (at, face) in faces.iter().enumerate() {
            for (corner, index) in face.triangle.into_iter().enumerate() {
                let here = (3 * at + corner) as u32;
                let first = &mut first[points[index as usize] as usize];
                if *first == u32::MAX {
                    *first = here;
                } else {
                    groups.join(*first, here);
                }
            }
        }
    } else {
        join_over_edges(&faces, &points, crease, &mut groups);
    }
    Ok((averaged(&geometry, &faces, &mut groups), dropped))
}

/// The geometry with normals averaged over the faces of each smoothing group, of which `groups` has one for each triangle; those of
/// group 0 stay flat. Triangles without area are left out.
///
/// # Errors
/// Indices out of range, or arrays of different lengths.
pub fn smooth_groups(geometry: &Geometry, groups: &[u32]) -> Result<Geometry, MeshError> {
    geometry.check_indices()?;
    let points = position_ids(&geometry.positions);
    let mut faces = Vec::new();
    // Point, group, corner.
    let mut corners: Vec<(u32, u32, u32)> = Vec::new();
    for (at, triangle) in geometry.triangles.iter().enumerate() {
        let Some(face) = Face::new(*triangle, geometry) else { continue };
        let group = groups.get(at).copied().unwrap_or(0);
        if group != 0 {
            let corner = |corner: usize| (points[triangle[corner] as usize], group, (3 * faces.len() + corner) as u32);
            corners.extend([0, 1, 2].map(corner));
        }
        faces.push(face);
    }
    corners.sort_unstable();
    let mut joined = Groups::new(faces.len() * 3);
    for pair in corners.windows(2) {
        let ((point, group, one), (other_point, other_group, two)) = (pair[0], pair[1]);
        if (point, group) == (other_point, other_group) {
            joined.join(one, two);
        }
    }
    Ok(averaged(geometry, &faces, &mut joined))
}

/// The geometry of these faces, the normals of which are averaged over joined corners.
fn averaged(geometry: &Geometry, faces: &[Face], groups: &mut Groups) -> Geometry {
    let mut sums: Vec<Vec3> = vec![[0.0; 3]; faces.len() * 3];
    for (at, face) in faces.iter().enumerate() {
        for corner in 0..3 {
            let sum = &mut sums[groups.find((3 * at + corner) as u32) as usize];
            for (sum, x) in sum.iter_mut().zip(face.normal) {
                *sum += face.angles[corner] * x;
            }
        }
    }
    let mut splitter = Splitter::new(geometry);
    for (at, face) in faces.iter().enumerate() {
        let normals = [0, 1, 2].map(|corner| {
            let sum = sums[groups.find((3 * at + corner) as u32) as usize];
            // Faces back to back cancel (their sum is rounding error): each keeps its own normal.
            let sum = if length(sum) > 1e-9 { normalized(sum) } else { None };
            sum.unwrap_or(face.normal).map(|x| x as f32 + 0.0)
        });
        splitter.push(face.triangle, normals);
    }
    splitter.finish()
}

/// For each position the index of the first position equal to it (0 and -0 are equal).
pub(super) fn position_ids(positions: &[[f32; 3]]) -> Vec<u32> {
    // Adding 0 turns -0 to 0.
    let key = |index: &u32| positions[*index as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|index| (key(index), *index));
    let mut ids = vec![0; positions.len()];
    for same in order.chunk_by(|one, other| key(one) == key(other)) {
        for index in same {
            ids[*index as usize] = same[0];
        }
    }
    ids
}

/// A triangle that has an area.
pub(super) struct Face {
    triangle: [u32; 3],
    pub normal: Vec3,
    /// The angle at each corner in radians.
    pub angles: [f64; 3],
}

impl Face {
    /// The face of a triangle whose indices are in range; none for one without area.
    pub fn new(triangle: [u32; 3], geometry: &Geometry) -> Option<Self> {
        let corners = triangle.map(|index| geometry.positions[index as usize].map(f64::from));
        let normal = face_normal(corners)?;
        let angles = [0, 1, 2].map(|at: usize| {
            let here = corners[at];
            let (to, from) = (sub(corners[(at + 1) % 3], here), sub(corners[(at + 2) % 3], here));
            libm::atan2(length(cross(to, from)), dot(to, from))
        });
        Some(Self { triangle, normal, angles })
    }
}

/// Joins the corners at both ends of every edge where exactly two faces meet at an angle of at most `crease` degrees.
fn join_over_edges(faces: &[Face], points: &[u32], crease: f64, groups: &mut Groups) {
    // The ends of the edge by point, lower first, then the corner (3 * face + 0..3) that lies at each.
    let mut edges: Vec<([u32; 2], [u32; 2])> = Vec::with_capacity(faces.len() * 3);
    for (at, face) in faces.iter().enumerate() {
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let ends = [corner, next].map(|i| points[face.triangle[i] as usize]);
            let corners = [corner, next].map(|i| (3 * at + i) as u32);
            edges.push(if ends[0] <= ends[1] {
                (ends, corners)
            } else {
                ([ends[1], ends[0]], [corners[1], corners[0]])
            });
        }
    }
    edges.sort_unstable();
    for edge in edges.chunk_by(|one, other| one.0 == other.0) {
        let [(_, one), (_, other)] = edge else { continue };
        let [a, b] = [one, other].map(|corners| faces[corners[0] as usize / 3].normal);
        let angle = libm::atan2(length(cross(a, b)), dot(a, b)).to_degrees();
        // Faces at exactly the crease angle, up to the rounding of positions to single precision, belong together.
        if angle <= crease + 1e-4 {
            groups.join(one[0], other[0]);
            groups.join(one[1], other[1]);
        }
    }
}

/// Disjoint sets of corners or faces.
pub(super) struct Groups(Vec<u32>);

impl Groups {
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    pub fn find(&mut self, mut at: u32) -> u32 {
        while self.0[at as usize] != at {
            // Halving the path keeps it short.
            self.0[at as usize] = self.0[self.0[at as usize] as usize];
            at = self.0[at as usize];
        }
        at
    }

    pub fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.find(one), self.find(other));
        // The lower becomes the root, so that the result does not depend on the order of joining.
        self.0[one.max(other) as usize] = one.min(other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::faceted::tests::cube;
    use crate::mesh::{faceted, is_closed, largest_normal_deviation, signed_volume, sphere};

    #[test]
    fn a_faceted_sphere_gets_its_radial_normals_back() {
        let flat = faceted(sphere(2.0, [0.0; 3], 64, 32).expect("a good sphere")).expect("consistent").0;
        let (g, dropped) = smooth(flat, 180.0).expect("consistent");
        assert_eq!((dropped, g.check()), (0, Ok(())));
        for (position, normal) in g.positions.iter().zip(g.normals.iter().flatten()) {
            let away = length(cross(position.map(f64::from), normal.map(f64::from))) / 2.0;
            assert!(away < 0.01, "{position:?} {normal:?}");
        }
        assert!(is_closed((&g).into()));
    }

    #[test]
    fn angle_weights_make_a_cube_symmetric() {
        let (g, _) = smooth(cube(), 180.0).expect("consistent");
        assert_eq!(g.positions.len(), 8);
        for (position, normal) in g.positions.iter().zip(g.normals.iter().flatten()) {
            for axis in 0..3 {
                let expected = (position[axis] * 2.0 - 1.0) / 3.0_f32.sqrt();
                assert!((normal[axis] - expected).abs() < 1e-6, "{normal:?}");
            }
        }
    }

    #[test]
    fn creases_split_a_cube_into_flat_sides() {
        let (g, _) = smooth(cube(), 89.0).expect("consistent");
        assert_eq!(g.positions.len(), 24);
        assert_eq!(largest_normal_deviation((&g).into()), Some(0.0));
        assert_eq!(signed_volume((&g).into()), 1.0);
        let (whole, _) = smooth(cube(), 90.0).expect("consistent");
        assert_eq!(whole.positions.len(), 8);
    }

    #[test]
    fn the_result_is_the_same_for_any_start_of_a_group() {
        let (once, _) = smooth(cube(), 120.0).expect("consistent");
        let (twice, _) = smooth(cube(), 180.0).expect("consistent");
        assert_eq!(once, twice);
    }

    #[test]
    fn a_fan_of_many_triangles_is_not_quadratic() {
        let rim = 200_000;
        let around = |i: u32| libm::sincos(f64::from(i) * std::f64::consts::TAU / f64::from(rim));
        let mut positions = vec![[0.0, 0.0, 1.0]];
        positions.extend((0..rim).map(|i| [around(i).1 as f32, around(i).0 as f32, 0.0]));
        let triangles = (0..rim).map(|i| [0, 1 + i, 1 + (i + 1) % rim]).collect();
        let cone = Geometry { positions, triangles, ..Geometry::default() };
        let (g, _) = smooth(cone, 30.0).expect("consistent");
        let tip = g.normals.as_ref().expect("normals")[0];
        assert!((f64::from(tip[2]) - 1.0).abs() < 1e-3, "{tip:?}");
    }

    #[test]
    fn faces_back_to_back_keep_their_normals() {
        let mut g = cube();
        g.triangles = vec![[0, 1, 3], [0, 3, 1]];
        let (g, _) = smooth(g, 180.0).expect("consistent");
        assert_eq!((g.positions.len(), largest_normal_deviation((&g).into())), (6, Some(0.0)));
        assert!(smooth(g.clone(), f64::NAN).is_err() && smooth(g, -1.0).is_err());
    }
}
