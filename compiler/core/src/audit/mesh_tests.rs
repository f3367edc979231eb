//! Meshes in sums and number by number: what is a little beyond a bound is seen, and what is within is not.

use super::measure::{Pair, Shown, difference};
use super::vertices::{self, Placed};
use super::*;
use crate::mesh::{Geometry, sphere};

/// Each sum of a mesh is compared within its bound: what is a little more is seen, what is a little less is not.
#[test]
fn every_sum_of_a_mesh() {
    let ball = sphere(2.0, [1.0, 2.0, 3.0], 12, 6).expect("a good sphere");
    let asked = Measure::of((&ball).into(), &Affine::IDENTITY);
    let slack = 1e-4;
    let area = asked.edges * slack + 1e-9 * asked.area;
    let out = area * asked.extent() + asked.area * slack;
    let middle = slack + (asked.edges * slack / asked.area + 1e-9) * asked.extent();
    type Part = fn(&mut Measure) -> &mut f64;
    let rows: &[(Part, f64, &str)] = &[
        (|measure| &mut measure.area, area, "the area"),
        (|measure| &mut measure.winding[0], area, "the sum of the faces"),
        (|measure| &mut measure.winding[2], area, "the sum of the faces"),
        (|measure| &mut measure.front[1], area, "the sum of the faces by their normals"),
        (|measure| &mut measure.winding_out, out, "faces towards the outside"),
        (|measure| &mut measure.front_out, out, "normals towards the outside"),
        (|measure| &mut measure.center[0], middle, "the center"),
        (|measure| &mut measure.center[1], middle, "the center"),
        (|measure| &mut measure.center[2], middle, "the center"),
        (|measure| &mut measure.low[0], slack, "the lower corner"),
        (|measure| &mut measure.low[2], slack, "the lower corner"),
        (|measure| &mut measure.high[0], slack, "the upper corner"),
        (|measure| &mut measure.high[1], slack, "the upper corner"),
    ];
    assert_eq!(difference(Pair { asked: &asked, said: &asked, slack: 0.0 }), None);
    for (part, by, words) in rows {
        for sign in [1.0, -1.0] {
            let mut said = asked;
            *part(&mut said) += sign * by * 0.999;
            assert_eq!(difference(Pair { asked: &asked, said: &said, slack }), None, "{words}");
            *part(&mut said) += sign * by * 0.002;
            let what = difference(Pair { asked: &asked, said: &said, slack });
            assert!(what.as_ref().is_some_and(|what| what.starts_with(words)), "{words}: {what:?}");
        }
        let mut said = asked;
        *part(&mut said) = f64::NAN;
        let what = difference(Pair { asked: &asked, said: &said, slack });
        assert!(what.as_ref().is_some_and(|what| what.starts_with(words)), "{words}: {what:?}");
    }
    let other = |change: fn(&mut Measure)| {
        let mut said = asked;
        change(&mut said);
        difference(Pair { asked: &asked, said: &said, slack }).unwrap_or_default()
    };
    assert_eq!(
        other(|said| said.triangles += 1),
        format!("{} triangles instead of {}", asked.triangles + 1, asked.triangles)
    );
    assert_eq!(other(|said| said.normals = false), "no normals");
    let bare = Measure { normals: false, ..asked };
    let what = difference(Pair { asked: &bare, said: &asked, slack });
    assert_eq!(what.as_deref(), Some("normals where the scene has none"));
}

/// The print of a mesh changes with each of its numbers, and names what is not the same.
#[test]
fn every_number_of_a_mesh_file() {
    let uvs = Some(vec![[0.25, 0.5]; 3]);
    let normals = Some(vec![[0.0, 0.0, 1.0]; 3]);
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Geometry { positions, normals, uvs, triangles: vec![[0, 1, 2]] };
    let print = |mesh: &Geometry| Measure::whole(mesh.into()).print;
    let rows: &[(fn(&mut Geometry), &str)] = &[
        (|mesh| mesh.triangles[0] = [1, 2, 0], "other corners of its triangles"),
        (|mesh| mesh.positions[2][2] = -0.0, "other positions of its vertices"),
        (|mesh| mesh.positions.swap(1, 2), "other positions of its vertices"),
        (|mesh| mesh.normals.as_mut().expect("normals")[2][0] = 1e-6, "other normals at its corners"),
        (|mesh| mesh.normals = None, "other normals at its corners"),
        (|mesh| mesh.uvs.as_mut().expect("coordinates")[0][1] = 0.500_001, "other texture coordinates"),
        (|mesh| mesh.uvs = None, "other texture coordinates"),
    ];
    assert_eq!(print(&mesh).difference(&print(&mesh)), None);
    for (change, words) in rows {
        let mut other = mesh.clone();
        change(&mut other);
        assert_eq!(print(&mesh).difference(&print(&other)), Some(*words));
        // Where the file holds the numbers itself, they are compared one by one; corners in turn and zeros of two signs are other numbers.
        let placed = |mesh| Placed { mesh: Shown::from(mesh), map: &Affine::IDENTITY };
        let what = vertices::difference(placed(&mesh), placed(&other), 0.0);
        assert_eq!(what.is_some(), !other.positions[2][2].is_sign_negative(), "{words}: {what:?}");
    }
}

#[test]
fn every_vertex_that_a_file_holds_itself() {
    let ball = sphere(2.0, [1.0, 2.0, 3.0], 12, 6).expect("a good sphere");
    let map = Affine::rotation([0.6, 0.0, 0.8], 40.0);
    let what = |change: fn(&mut Geometry)| {
        let mut other = ball.clone();
        change(&mut other);
        let placed = |mesh| Placed { mesh: Shown::from(mesh), map: &map };
        vertices::difference(placed(&ball), placed(&other), 0.0).unwrap_or_default()
    };
    assert_eq!(what(|_| ()), "");
    let rows: &[(fn(&mut Geometry), &str)] = &[
        (|mesh| mesh.triangles.truncate(9), "triangles instead of"),
        (|mesh| mesh.triangles.swap(0, 1), "other corners of its triangles"),
        (|mesh| mesh.positions.push([0.0; 3]), "vertices instead of"),
        (|mesh| mesh.positions[5][0] *= 1.000_001, "vertex 5 at"),
        (|mesh| mesh.positions[6][1] *= 1.000_001, "vertex 6 at"),
        (|mesh| mesh.positions[0][2] = f32::NAN, "vertex 0 at"),
        (|mesh| mesh.normals = None, "no normals"),
        (|mesh| mesh.normals.as_mut().expect("normals").truncate(9), "no normals"),
        (|mesh| mesh.normals.as_mut().expect("normals")[9][1] += 1e-5, "other normals at its corners"),
        (|mesh| mesh.uvs = None, "other texture coordinates"),
        (|mesh| mesh.uvs.as_mut().expect("coordinates").truncate(9), "other texture coordinates"),
        (|mesh| mesh.uvs.as_mut().expect("coordinates")[9][0] += 1e-6, "other texture coordinates"),
        (|mesh| mesh.uvs.as_mut().expect("coordinates")[9][1] -= 1e-6, "other texture coordinates"),
    ];
    for (change, words) in rows {
        let what = what(*change);
        assert!(what.contains(words), "`{words}`: `{what}`");
    }
    let bare = Geometry { normals: None, ..ball.clone() };
    let placed = |mesh| Placed { mesh: Shown::from(mesh), map: &map };
    let more = vertices::difference(placed(&bare), placed(&ball), 0.0);
    assert_eq!(more.as_deref(), Some("normals where the scene has none"));
}
