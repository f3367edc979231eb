//! A mesh of the scene and the same one in a file, vertex by vertex: for formats that hold the numbers themselves and may have
//! moved them.
//!
//! How far they may be apart follows from how they were made, and from nothing else. Let `u` be half the distance from 1 to the next
//! number of single precision, W the map that the scene asks for, N the map that the file says, and q what the file holds of
//! a vertex p: q is M p, where W is M followed by N, each of its numbers rounded once. A rounded number is off by `u` of itself,
//! and below the normal numbers by half the smallest one. So
//!
//! - a place: N q - W p = N (q - M p), hence each coordinate is off by at most the sum of |N_ij| u |q_j|;
//! - a normal: normals go by cofactors, and those of W are those of N times those of M, up to a factor. With m the file's normal and d its
//!   rounding (|d_j| <= u |m_j|) the direction is cof N (m - d), and two vectors that differ by e have directions that are apart by
//!   at most 2 |e| / |cof N m|: here e_i is the sum of |cof N_ij| u |m_j|;
//! - a texture coordinate: a format that turns v over writes 1 - v, rounded once, and 1 - (1 - v) is rounded again: u |1 - v| + u |v|.
//!
//! To this come operations in double precision, [`DOUBLE`] of the terms that they add, and, where a format holds maps in single
//! precision, [`PLACE`] of what the map makes.

use super::measure::Shown;
use crate::ir::{Affine, Vec3, dot, length, normalized, sub};

/// What a number loses that is rounded to single precision, of itself.
const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

/// Half of the smallest number of single precision.
const SMALLEST: f64 = 7.006_492_321_624_085e-46;

/// What 32 operations in double precision lose: maps are products of a few, of nine products and sums each.
const DOUBLE: f64 = 32.0 * f64::EPSILON;

/// What a place of single precision loses, of what it makes: its scale, `u`; its quaternion, whose four parts are off by `u` of themselves, hence
/// its direction by `u` and the turn by twice that, which takes a point off by as much of its distance, and by twice as much again where
/// its length is not 1; its offset, `u`. A turn moves a point across its distance, so that a coordinate near 0 may be off by a share of the others.
pub const PLACE: f64 = 8.0 * SINGLE;

/// A mesh as a map places it.
#[derive(Clone, Copy)]
pub struct Placed<'m> {
    /// The mesh.
    pub mesh: Shown<'m>,
    /// The map.
    pub map: &'m Affine,
}

/// The lengths that a map adds up for each coordinate of a point.
fn terms(map: &Affine, point: Vec3) -> Vec3 {
    map.rows.map(|row| (0..3).map(|at| (row[at] * point[at]).abs()).sum::<f64>())
}

/// What a vertex of a file may be off in each coordinate by its own rounding.
fn rounding(map: &Affine, point: Vec3) -> Vec3 {
    terms(map, point.map(|x| SINGLE * x.abs() + SMALLEST))
}

/// Whether two maps take `point` to the same place. `share` is what the second loses of what it makes.
pub fn same_place(asked: &Affine, said: &Affine, point: Vec3, share: f64) -> bool {
    // What is turned a little moves across its own length.
    let (linear, whole) = (length(terms(said, point)), asked.point(point));
    let (turned, there) = (sub(asked.vector(point), said.vector(point)), said.point(point));
    (0..3).all(|axis| {
        let near = |off: f64, most: f64| off.abs() <= share * most;
        // What is small and far away is compared in its own size, too.
        near(turned[axis], linear)
            && near(whole[axis] - there[axis], linear + said.rows[axis][3].abs() + asked.rows[axis][3].abs())
    })
}

/// What differs between a mesh of the scene and that of a file, in words. `share` is what the file's map loses.
pub fn difference(asked: Placed<'_>, said: Placed<'_>, share: f64) -> Option<String> {
    let (a, b) = (asked.mesh, said.mesh);
    if a.triangles != b.triangles {
        return Some(match (a.triangles.len(), b.triangles.len()) {
            (wanted, there) if wanted != there => format!("{there} triangles instead of {wanted}"),
            _ => "other corners of its triangles".to_owned(),
        });
    }
    if a.positions.len() != b.positions.len() {
        return Some(format!("{} vertices instead of {}", b.positions.len(), a.positions.len()));
    }
    for (at, (p, q)) in a.positions.iter().zip(b.positions).enumerate() {
        let (p, q) = (p.map(f64::from), q.map(f64::from));
        let (wanted, there) = (asked.map.point(p), said.map.point(q));
        let (own, sums, other) = (rounding(said.map, q), terms(said.map, q), terms(asked.map, p));
        for axis in 0..3 {
            let offset = |map: &Affine| map.rows[axis][3].abs();
            let doubles = DOUBLE * (sums[axis] + other[axis] + offset(said.map) + offset(asked.map));
            let by = own[axis] + doubles + share * (length(sums) + offset(said.map));
            let off = (wanted[axis] - there[axis]).abs();
            if off.is_nan() || off > by {
                return Some(format!("vertex {at} at {there:?} instead of {wanted:?}"));
            }
        }
    }
    normals(asked, said, share).or_else(|| coordinates(a.uvs, b.uvs))
}

fn normals(asked: Placed<'_>, said: Placed<'_>, share: f64) -> Option<String> {
    let (a, b) = match (asked.mesh.normals, said.mesh.normals) {
        (Some(a), Some(b)) if a.len() == b.len() => (a, b),
        (None, None) => return None,
        (None, Some(_)) => return Some("normals where the scene has none".to_owned()),
        (Some(_), _) => return Some("no normals".to_owned()),
    };
    let (wanted_by, said_by) = (asked.map.cofactors(), said.map.cofactors());
    // A cofactor is a difference of two products of lengths of rows at most.
    let most = |map: &Affine| {
        let [x, y, z] = map.rows.map(|row| length([row[0], row[1], row[2]]));
        DOUBLE * (y * z).max(z * x).max(x * y) * 3.0
    };
    let (doubles, others) = (most(asked.map), most(said.map));
    for (at, (n, m)) in a.iter().zip(b).enumerate() {
        let (n, m) = (n.map(f64::from), m.map(f64::from));
        let (wanted, there) = (wanted_by.map(|row| dot(row, n)), said_by.map(|row| dot(row, m)));
        let (Some(one), Some(other)) = (normalized(wanted), normalized(there)) else { continue };
        let own = said_by.map(|row| (0..3).map(|at| row[at].abs() * (SINGLE * m[at].abs() + SMALLEST)).sum::<f64>());
        let by = 2.0 * (length(own) + others * length(m)) / length(there)
            + 2.0 * doubles * length(n) / length(wanted)
            + 2.0 * share;
        if length(sub(one, other)) > by + DOUBLE {
            return Some(format!("other normals at its corners: {other:?} instead of {one:?} at vertex {at}"));
        }
    }
    None
}

fn coordinates(asked: Option<&[[f32; 2]]>, said: Option<&[[f32; 2]]>) -> Option<String> {
    let asked = asked?;
    let other = || Some("other texture coordinates".to_owned());
    let Some(said) = said.filter(|said| said.len() == asked.len()) else { return other() };
    let far = |(a, b): (&[f32; 2], &[f32; 2])| {
        (0..2).any(|at| {
            let (a, b) = (f64::from(a[at]), f64::from(b[at]));
            // The rounded numbers are the file's and its reader's; those of the scene are a little apart from them.
            let by = 2.0 * SINGLE * ((1.0 - a).abs() + a.abs());
            (a - b).abs() > by
        })
    };
    if asked.iter().zip(said).any(far) { other() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Geometry, sphere, torus};

    /// A mesh as a writer moves it by `map` into single precision.
    fn moved(mesh: &Geometry, map: &Affine) -> Geometry {
        let cofactors = map.cofactors();
        let turn = |normal: &[f32; 3]| {
            let turned = cofactors.map(|row| dot(row, normal.map(f64::from)));
            normalized(turned).expect("a direction").map(|x| x as f32)
        };
        Geometry {
            positions: mesh.positions.iter().map(|p| map.point(p.map(f64::from)).map(|x| x as f32)).collect(),
            normals: mesh.normals.as_ref().map(|all| all.iter().map(turn).collect()),
            uvs: mesh.uvs.as_ref().map(|all| all.iter().map(|[u, v]| [*u, 1.0 - (1.0 - v)]).collect()),
            triangles: mesh.triangles.clone(),
        }
    }

    fn compared(mesh: &Geometry, wanted: &Affine, file: &Geometry, map: &Affine) -> Option<String> {
        let placed = |mesh, map| Placed { mesh: Shown::from(mesh), map };
        difference(placed(mesh, wanted), placed(file, map), 0.0)
    }

    /// Maps that are thin, sheared, tiny, and far away, and what a file makes of them.
    fn maps() -> Vec<(Affine, Affine)> {
        let thin = Affine::scaling([20.0, 0.1, 3.0]);
        let shear = Affine { rows: [[1.0, -1.0, 0.0, 7.0], [0.0, 2.0, 0.0, 0.0], [0.4, 0.0, 1.0, 0.0]] };
        let turn = Affine::rotation(normalized([1.0, 2.0, 3.0]).expect("an axis"), 40.0);
        let far = Affine::translation([1e5, -3e4, 7.0]);
        let tiny = Affine::scaling([1e-6; 3]);
        let inner = [thin, shear.then(&thin), turn.then(&shear), tiny.then(&shear).then(&thin), shear.then(&far)];
        let outer = [Affine::IDENTITY, turn, thin.then(&far), tiny.then(&turn)];
        inner.iter().flat_map(|inner| outer.map(|outer| (*inner, outer))).collect()
    }

    #[test]
    fn what_is_rounded_once_is_the_same() {
        for mesh in [torus(1.0, 0.3, 9, 5).expect("a torus"), sphere(0.5, [9.0, -8.0, 7.0], 17, 5).expect("a ball")] {
            for (inner, outer) in maps() {
                let file = moved(&mesh, &inner);
                assert_eq!(compared(&mesh, &inner.then(&outer), &file, &outer), None, "{inner:?} {outer:?}");
            }
        }
    }

    #[test]
    fn each_number_that_is_changed_by_a_ten_thousandth_is_seen() {
        let mesh = torus(1.0, 0.3, 5, 4).expect("a torus");
        for (inner, outer) in maps() {
            let file = moved(&mesh, &inner);
            let wanted = inner.then(&outer);
            for at in 0..file.positions.len() {
                for axis in 0..3 {
                    let mut other = file.clone();
                    let old = other.positions[at][axis];
                    other.positions[at][axis] = old * 1.0001;
                    // What is near to 0 is smaller than the rounding of the numbers beside it.
                    let size = file.positions[at].iter().fold(0.0_f32, |most, x| most.max(x.abs()));
                    if old.abs() > 0.1 * size && !far_away(&wanted) {
                        assert!(compared(&mesh, &wanted, &other, &outer).is_some(), "{at} {axis} {inner:?} {outer:?}");
                    }
                    let mut other = file.clone();
                    if let Some(normals) = &mut other.normals {
                        normals[at][axis] = -normals[at][axis] + 0.01;
                    }
                    let found = compared(&mesh, &inner, &other, &Affine::IDENTITY);
                    assert!(found.is_some_and(|found| found.contains("normals")), "{at} {axis}");
                }
            }
        }
    }

    /// Whether a map takes small things so far away that they are known less well.
    fn far_away(map: &Affine) -> bool {
        map.rows.iter().any(|row| row[3].abs() > 1e3 || row[0].abs().max(row[1].abs()) < 1e-3)
    }

    #[test]
    fn small_things_far_away_are_compared_in_their_own_size() {
        let tiny = Affine::scaling([1e-7; 3]).then(&Affine::translation([1e6, 0.0, 0.0]));
        let mut other = tiny;
        other.rows[1][1] *= 1.001;
        assert!(same_place(&tiny, &tiny, [1.0, 2.0, 3.0], 1e-9) && !same_place(&tiny, &other, [1.0, 2.0, 3.0], 1e-9));
    }
}
