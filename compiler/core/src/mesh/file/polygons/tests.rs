//! Polygons: their area, the side to which they look, all corners in use, noise.

use proptest::prelude::*;

use super::*;
use crate::ir::length;

/// The triangles of one polygon whose corners are the points in their order.
fn one(points: &[[f32; 3]]) -> (Vec<[u32; 3]>, Vec<Note>) {
    let corners: Vec<u32> = (0..points.len() as u32).collect();
    let mut faces = Faces::default();
    faces.push(&corners, String::new);
    let mut notes = Vec::new();
    let cut = faces.finish(|corner| points[corner as usize], &mut notes).expect("triangles");
    (cut.triangles, notes)
}

/// The sum of areas, and the sum of areas with their directions.
fn areas(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> (f64, Vec3) {
    let mut sum = (0.0, [0.0; 3]);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| points[corner as usize].map(f64::from));
        let twice = cross(sub(b, a), sub(c, a));
        sum.0 += 0.5 * length(twice);
        sum.1 = [0, 1, 2].map(|axis| sum.1[axis] + 0.5 * twice[axis]);
    }
    sum
}

/// That the triangles are the polygon in the plane z = 0 with this area, seen from +z, all its corners in use; in other planes too, from
/// other corners on, and from the back.
#[track_caller]
fn fills(flat: &[[f32; 2]], area: f64) {
    for plane in 0..3 {
        for turned in 0..flat.len() {
            for back in [false, true] {
                let mut ring: Vec<[f32; 2]> = flat.to_vec();
                ring.rotate_left(turned);
                if back {
                    ring.reverse();
                }
                let points: Vec<[f32; 3]> = ring
                    .iter()
                    .map(|[x, y]| {
                        let mut point = [*x, *y, 7.0];
                        point.rotate_left(plane);
                        point
                    })
                    .collect();
                let (triangles, notes) = one(&points);
                let (sum, vector) = areas(&points, &triangles);
                let up = vector.into_iter().sum::<f64>() * if back { -1.0 } else { 1.0 };
                let close = |found: f64| (found - area).abs() <= 1e-9 * area;
                assert!(close(sum) && close(up), "{sum} {up} {area}: {points:?} {triangles:?} {notes:?}");
                assert_eq!(notes.len(), 1, "{notes:?}");
            }
        }
    }
}

/// Every edge lies between two triangles or on the rim, which is the polygon.
#[track_caller]
fn closes(count: u32, triangles: &[[u32; 3]]) {
    assert_eq!(triangles.len() as u32, count - 2);
    let mut edges = BTreeMap::new();
    for [a, b, c] in triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            assert_eq!(edges.insert(edge, ()), None, "{edge:?} twice");
        }
    }
    for (from, to) in edges.keys().filter(|(from, to)| !edges.contains_key(&(*to, *from))) {
        assert_eq!((from + 1) % count, *to, "a rim that is none");
    }
}

#[test]
fn concave_polygons_keep_their_area() {
    // A dart, from each of its corners on.
    fills(&[[4.0, 2.0], [0.0, 0.0], [4.0, -2.0], [1.0, 0.0]], 2.0);
    fills(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]], 10.0);
    // A square with a square hole, to which an edge leads and back.
    let hole = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1]];
    fills(&hole.map(|point| point.map(|x| x as f32)), 12.0);
    // Letters with corners on straight edges.
    let letter = [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 1]];
    fills(&letter.map(|point| point.map(|x| x as f32)), 3.0);
    let comb = [[0, 0], [5, 0], [5, 3], [4, 3], [4, 1], [3, 1], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]];
    fills(&comb.map(|point| point.map(|x| x as f32)), 11.0);
    let spiral = [[0, 0], [6, 0], [6, 5], [1, 5], [1, 2], [4, 2], [4, 3], [2, 3], [2, 4], [5, 4], [5, 1], [0, 1]];
    fills(&spiral.map(|point| point.map(|x| x as f32)), 18.0);
}

#[test]
fn convex_polygons_are_a_fan_around_their_first_corner() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(one(&square).0, [[0, 1, 2], [0, 2, 3]]);
    let six: Vec<[f32; 3]> =
        [[2, 0], [1, 2], [-1, 2], [-2, 0], [-1, -2], [1, -2]].map(|[x, y]| [x as f32, 3.0, y as f32]).into();
    assert_eq!(one(&six).0, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    // A corner on a straight edge makes no triangle without area.
    let five = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let (triangles, _) = one(&five);
    closes(5, &triangles);
    assert!(triangles.iter().all(|triangle| areas(&five, &[*triangle]).0 > 0.5), "{triangles:?}");
    let four = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    assert_eq!(one(&four).0, [[1, 2, 3], [1, 3, 0]]);
    // Two corners at one place are one.
    let three = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    assert_eq!(one(&three).0, [[0, 2, 3]]);
    let three = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    assert_eq!(one(&three).0, [[0, 2, 3]]);
}

#[test]
fn polygons_without_one_answer_are_told() {
    let said = |points: &[[f32; 3]]| -> Vec<String> { one(points).1.into_iter().map(|note| note.message).collect() };
    let bow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let crossing = "1 face crossing itself cut as a fan around the first corner";
    assert_eq!(said(&bow)[1..], [crossing]);
    // A star of five points, which turns left at each.
    let star = [[0, 0], [4, 0], [1, 3], [2, -1], [3, 3]].map(|[x, y]: [i32; 2]| [x as f32, y as f32, 0.0]);
    assert_eq!(said(&star)[1..], [crossing]);
    // A square of 1, one corner lifted by 0.1.
    let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]];
    let words = "1 face not flat, by up to 3.5 % of the size: the cut into triangles decides the shape";
    assert_eq!(said(&bent)[1..], [words]);
    assert_eq!(said(&[[1.0; 3]; 5]).len(), 1);
    assert_eq!(said(&[[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]).len(), 1);
    assert_eq!(one(&[[f32::NAN; 3]; 6]).0.len(), 4);
}

#[test]
fn places_move_with_what_falls_away() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut faces = Faces::default();
    for face in [&[0, 1, 2, 3][..], &[0, 0, 1, 2], &[0, 1, 2], &[1, 1, 2, 3], &[0, 1, 3]] {
        faces.push(face, String::new);
    }
    let cut = faces.finish(|corner| points[corner as usize], &mut Vec::new()).expect("triangles");
    assert_eq!(cut.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 2], [1, 2, 3], [0, 1, 3]]);
    assert_eq!([0, 2, 4, 5, 7, 8].map(|at| cut.place(at)), [0, 2, 3, 4, 5, 6]);
}

#[test]
fn large_polygons_take_no_time() {
    let circle = |count: u32, radius: &dyn Fn(u32) -> f64| -> Vec<[f32; 3]> {
        let at = |i: u32| {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            [radius(i) * libm::cos(angle), 0.0, radius(i) * libm::sin(angle)].map(|x| x as f32)
        };
        (0..count).map(at).collect()
    };
    let star = circle(20_000, &|i| f64::from(1 + i % 2));
    let (triangles, notes) = one(&star);
    assert_eq!((triangles.len(), notes.len()), (19_998, 1), "{notes:?}");
    closes(20_000, &triangles);
    // Noise, which crosses itself nearly everywhere.
    let noise = circle(20_000, &|i| f64::from(i.wrapping_mul(2_654_435_761) >> 8) * f64::from(i % 7) - 1e7);
    assert_eq!(one(&noise).0.len(), 19_998);
}

fn noisy() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let grid = (-3_i8..4).prop_map(f32::from);
    let any = prop_oneof![4 => grid.clone(), 1 => any::<f32>(), 1 => -1e-30_f32..1e-30, 1 => -1e3_f32..1e3];
    let flat = prop::collection::vec((grid.clone(), grid).prop_map(|(x, y)| [x, y, 0.0]), 4..30);
    prop_oneof![flat, prop::collection::vec([any.clone(), any.clone(), any], 4..20)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn areas_stay(radii in prop::collection::vec(0.1_f64..5.0, 4..40), axes in any::<[i8; 6]>(), turn in 0.0_f64..7.0) {
        // A star in a slanted plane: its corners in the order of their angles.
        let count = radii.len();
        let (u, v) = ([0, 1, 2].map(|at| f64::from(axes[at])), [3, 4, 5].map(|at| f64::from(axes[at])));
        let normal = cross(u, v);
        prop_assume!(length(normal) > 0.05 * length(u) * length(v) && length(normal) > 1.0);
        let points: Vec<[f32; 3]> = radii.iter().enumerate().map(|(at, radius)| {
            let angle = turn + std::f64::consts::TAU * at as f64 / count as f64;
            [0, 1, 2].map(|axis| (radius * (libm::cos(angle) * u[axis] + libm::sin(angle) * v[axis])) as f32)
        }).collect();
        let (triangles, notes) = one(&points);
        prop_assert_eq!(notes.len(), 1, "{:?}", &notes);
        closes(count as u32, &triangles);
        let (sum, vector) = areas(&points, &triangles);
        prop_assert!((sum - length(vector)).abs() <= 1e-5 * sum, "{} {:?}", sum, vector);
        prop_assert!(dot(vector, normal) > 0.0);
        let fan: Vec<[u32; 3]> = (1..count as u32 - 1).map(|at| [0, at, at + 1]).collect();
        let (_, expected) = areas(&points, &fan);
        prop_assert!(length(sub(vector, expected)) <= 1e-5 * sum);
    }

    #[test]
    fn noise_does_no_harm(points in noisy()) {
        let (triangles, _) = one(&points);
        prop_assert!(!triangles.is_empty() && triangles.len() <= points.len() - 2);
        prop_assert!(triangles.as_flattened().iter().all(|corner| (*corner as usize) < points.len()));
        // A cut that is no fan has the area of the polygon, by both sums.
        let fan: Vec<[u32; 3]> = (1..points.len() as u32 - 1).map(|at| [0, at, at + 1]).collect();
        let (_, expected) = areas(&points, &fan);
        let (sum, vector) = areas(&points, &triangles);
        if sum.is_finite() {
            // Beside coordinates of 1e30 small ones are rounding errors.
            let reach = points.as_flattened().iter().fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
            let slack = 1e-5 * areas(&points, &fan).0.max(sum) + 1e-12 * reach * reach;
            prop_assert!(length(sub(vector, expected)) <= slack);
        }
    }
}
