//! A profile turned about an axis.

use super::error::{finite, round};
use super::revolve::{Revolution, Row};
use super::{Geometry, MeshError};

/// How far below the largest coordinate of a profile a radius counts as 0: the radius of a pole is often the rounding
/// error of a sine or cosine. Far below the resolution of the single precision of vertices.
const ON_AXIS: f64 = 1e-9;

/// The surface of revolution about the z axis of a profile of points (distance from the axis, z). Outside is on the
/// right hand of the direction of the profile, in the half-plane where the distance grows to the right and z upwards:
/// a profile that runs upwards faces away from the axis. `closed` joins the last point to the first.
///
/// The normal at a point is the unweighted mean of those of both neighboring stretches of the profile; at an end it
/// is that of its only one. Points on the axis become poles with a normal along the axis, and stretches on the axis
/// have no surface. Where the profile turns back on itself each side keeps its own normal.
///
/// Texture coordinates: `u` is the longitude over 360 degrees, counter-clockwise seen from above, `v` the length along
/// the profile, from 0 to 1; both have a seam where the surface closes.
///
/// # Errors
/// A distance that is negative, a number that is not finite, equal neighbors, fewer than 2 points (3 where it is
/// closed), a profile on the axis, fewer than 3 segments, more than [`super::MAX_TRIANGLES`], a surface so small or so
/// fine that triangles vanish in single precision.
pub fn lathe(profile: &[[f64; 2]], segments: u64, closed: bool) -> Result<Geometry, MeshError> {
    let points = checked(profile, closed)?;
    let stretches = stretches(&points, closed);
    let slice = stretches.iter().map(Stretch::triangles).sum();
    if slice == 0 {
        return Err(MeshError::new("profile", "the profile lies on the axis, it has no surface")
            .help("give points (distance from the axis, z) with distances greater than 0"));
    }
    let mut lathe = Revolution::new("a lathe", "profile", segments, slice)?;
    for rows in strips(&stretches, closed) {
        lathe.strip(&rows)?;
    }
    lathe.finish()
}

/// The points with radii that are 0 up to rounding set to 0.
fn checked(profile: &[[f64; 2]], closed: bool) -> Result<Vec<[f64; 2]>, MeshError> {
    let fault = |message: String| MeshError::new("profile", message);
    let least = if closed { 3 } else { 2 };
    if profile.len() < least {
        let kind = if closed { "closed profile" } else { "profile" };
        return Err(fault(format!("a {kind} of {} points has no surface", profile.len()))
            .help(format!("give at least {least} points")));
    }
    let mut largest: f64 = 0.0;
    for [r, z] in profile {
        finite("profile", *r)?;
        finite("profile", *z)?;
        round("profile", [*r, 0.0, *z])?;
        largest = largest.max(r.abs()).max(z.abs());
    }
    let snap = |r: f64| if r.abs() <= ON_AXIS * largest { 0.0 } else { r };
    let points: Vec<[f64; 2]> = profile.iter().map(|[r, z]| [snap(*r), *z]).collect();
    if let Some(at) = points.iter().position(|[r, _]| *r < 0.0) {
        return Err(fault(format!(
            "point {at} has the distance {} from the axis, it must be at least 0",
            points[at][0]
        )));
    }
    let single = |at: usize| points[at].map(|x| x as f32);
    if let Some(at) = (1..points.len()).find(|at| single(at - 1) == single(*at)) {
        return Err(fault(format!("points {} and {at} of the profile are equal in single precision", at - 1))
            .help("leave one of them out"));
    }
    let last = points.len() - 1;
    if closed && single(last) == single(0) {
        return Err(fault("the last point of the closed profile is the first again".to_owned())
            .help("leave it out: `closed: true` joins the last point to the first"));
    }
    Ok(points)
}

/// The profile from one point to the next.
struct Stretch {
    from: [f64; 2],
    to: [f64; 2],
    /// Of unit length, on the right hand.
    normal: [f64; 2],
    /// The length along the profile at both ends, over the whole.
    v: [f64; 2],
}

impl Stretch {
    fn on_axis(&self) -> bool {
        self.from[0] == 0.0 && self.to[0] == 0.0
    }

    /// How many triangles a segment has between both ends.
    fn triangles(&self) -> u64 {
        u64::from(self.from[0] > 0.0) + u64::from(self.to[0] > 0.0)
    }

    /// The normal at a pole: the mean of this stretch's and of its mirror image's on the other side of the axis.
    fn pole(&self) -> [f64; 2] {
        [0.0, if self.normal[1] < 0.0 { -1.0 } else { 1.0 }]
    }
}

fn stretches(points: &[[f64; 2]], closed: bool) -> Vec<Stretch> {
    let count = if closed { points.len() } else { points.len() - 1 };
    let mut length = 0.0;
    let mut stretches: Vec<Stretch> = Vec::with_capacity(count);
    for at in 0..count {
        let (from, to) = (points[at], points[(at + 1) % points.len()]);
        let [dr, dz] = [to[0] - from[0], to[1] - from[1]];
        // Not 0: neighbors are different points.
        let own = libm::hypot(dr, dz);
        stretches.push(Stretch { from, to, normal: [dz / own, -dr / own], v: [length, length + own] });
        length += own;
    }
    for stretch in &mut stretches {
        stretch.v = stretch.v.map(|v| v / length);
    }
    stretches
}

/// Stretches with common normals at their joints, as rows of vertices.
fn strips(stretches: &[Stretch], closed: bool) -> Vec<Vec<Row>> {
    let count = stretches.len();
    // The normal where the stretch before `at`, or the one after it, meets it; none where nothing does.
    let joint = |at: usize, other: Option<usize>| {
        let (one, other) = (stretches[at].normal, stretches[other?].normal);
        let sum = [one[0] + other[0], one[1] + other[1]];
        let length = libm::hypot(sum[0], sum[1]);
        // Opposite normals have no mean: their sum is rounding error.
        if length > 1e-9 { Some(sum.map(|x| x / length)) } else { None }
    };
    let mut strips = Vec::new();
    let mut rows: Vec<Row> = Vec::new();
    for (at, stretch) in stretches.iter().enumerate().filter(|(_, stretch)| !stretch.on_axis()) {
        let row = |end: usize, meeting: Option<[f64; 2]>| {
            let [r, z] = [stretch.from, stretch.to][end];
            let normal = if r == 0.0 { stretch.pole() } else { meeting.unwrap_or(stretch.normal) };
            Row { r, z, normal, v: stretch.v[end] }
        };
        if rows.is_empty() {
            let before = if closed { Some((at + count - 1) % count) } else { at.checked_sub(1) };
            rows.push(row(0, joint(at, before)));
        }
        let after = if at + 1 < count { Some(at + 1) } else { closed.then_some(0) };
        let meeting = joint(at, after);
        rows.push(row(1, meeting));
        if stretch.to[0] == 0.0 || meeting.is_none() {
            strips.push(std::mem::take(&mut rows));
        }
    }
    if !rows.is_empty() {
        strips.push(rows);
    }
    strips
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{cross, length};
    use crate::mesh::revolve::tests::sound;
    use crate::mesh::{bounds, cylinder, is_closed, largest_normal_deviation, signed_volume, sphere, torus};
    use std::f64::consts::PI;

    /// The profile as the formula of the polyhedron wants it.
    fn pairs(profile: &[[f64; 2]], closed: bool) -> Vec<[[f64; 2]; 2]> {
        let mut pairs: Vec<_> = profile.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        if closed {
            pairs.push([profile[profile.len() - 1], profile[0]]);
        }
        pairs
    }

    fn half_circle(count: usize) -> Vec<[f64; 2]> {
        let turn = |at: usize| libm::sincos(PI * (at as f64 / count as f64 - 0.5));
        (0..=count).map(|at| [turn(at).1, turn(at).0]).collect()
    }

    #[test]
    fn a_half_circle_makes_a_sphere() {
        // Its end points miss the axis by the rounding error of the cosine, on the wrong side for some counts.
        let profile = half_circle(32);
        let g = lathe(&profile, 64, false).expect("a good lathe");
        let ball = sphere(1.0, [0.0; 3], 64, 32).expect("a good sphere");
        assert_eq!((g.positions.len(), &g.triangles), (ball.positions.len(), &ball.triangles));
        sound(&g, &pairs(&profile, false), 64, true);
        let both = g.positions.iter().zip(&ball.positions).zip(g.normals.iter().flatten());
        for ((position, expected), normal) in both {
            assert!((0..3).all(|axis| (position[axis] - expected[axis]).abs() < 1e-6));
            // Equal stretches to both sides: the mean is radial.
            assert!(length(cross(position.map(f64::from), normal.map(f64::from))) < 1e-6);
        }
    }

    #[test]
    fn direction_of_the_profile_says_what_is_outside() {
        let up = lathe(&[[1.0, 0.0], [1.0, 2.0]], 16, false).expect("a good lathe");
        assert_eq!(up, cylinder(1.0, (0.0, 2.0), 16, false).expect("a good cylinder"));
        let down = lathe(&[[1.0, 2.0], [1.0, 0.0]], 16, false).expect("a good lathe");
        assert!(down.normals.iter().flatten().zip(&down.positions).all(|(n, p)| n[0] == -p[0] && n[1] == -p[1]));
        let square = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
        sound(&lathe(&square, 16, true).expect("a good lathe"), &pairs(&square, true), 16, true);
        let mut turned = square;
        turned.reverse();
        let inside_out = lathe(&turned, 16, true).expect("a good lathe");
        assert!(is_closed((&inside_out).into()) && signed_volume((&inside_out).into()) < 0.0);
        assert!(largest_normal_deviation((&inside_out).into()).expect("it has normals") < 90.0);
    }

    #[test]
    fn a_closed_circle_makes_a_torus() {
        let turn = |at: usize| libm::sincos(2.0 * PI * at as f64 / 32.0);
        let circle: Vec<_> = (0..32).map(|at| [3.0 + turn(at).1, turn(at).0]).collect();
        let g = lathe(&circle, 64, true).expect("a good lathe");
        let expected = torus(3.0, 1.0, 64, 32).expect("a good torus");
        assert_eq!(g.triangles, expected.triangles);
        sound(&g, &pairs(&circle, true), 64, true);
        let normals = |g: &Geometry| g.normals.clone().expect("it has normals");
        for (normal, other) in normals(&g).into_iter().zip(normals(&expected)) {
            assert!((0..3).all(|axis| (normal[axis] - other[axis]).abs() < 1e-6));
        }
        // A texture goes once round the tube and meets itself with equal normals.
        let uvs = g.uvs.as_ref().expect("it has texture coordinates");
        assert_eq!((uvs[0], uvs[uvs.len() - 1]), ([0.0, 0.0], [1.0, 1.0]));
        assert_eq!(normals(&g)[..65], normals(&g)[32 * 65..]);
    }

    #[test]
    fn normals_are_unweighted_means() {
        // A short stretch outwards, a long one upwards: the lengths do not count.
        let g = lathe(&[[1.0, 0.0], [1.1, 0.0], [1.1, 9.0]], 4, false).expect("a good lathe");
        let normals = g.normals.as_ref().expect("it has normals");
        let half = 0.5_f32.sqrt();
        assert_eq!((normals[0], normals[10]), ([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]));
        assert!((normals[5][0] - half).abs() < 1e-6 && (normals[5][2] + half).abs() < 1e-6);
    }

    #[test]
    fn the_axis_may_be_part_of_the_profile() {
        // A solid cylinder whose profile comes back along the axis, with a point on the way.
        let profile = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
        let g = lathe(&profile, 12, true).expect("a good lathe");
        assert_eq!(g.triangles.len(), 4 * 12);
        sound(&g, &pairs(&profile, true), 12, true);
        // Two balls that touch on the axis.
        let profile = [[0.0, 0.0], [1.0, 1.0], [0.0, 2.0], [1.0, 3.0], [0.0, 4.0]];
        let g = lathe(&profile, 12, false).expect("a good lathe");
        assert_eq!((g.triangles.len(), g.positions.len()), (4 * 12, 4 * 12 + 2 * 13));
        sound(&g, &pairs(&profile, false), 12, true);
    }

    #[test]
    fn a_profile_that_turns_back_has_two_sides() {
        let g = lathe(&[[1.0, 0.0], [1.0, 2.0], [1.0, 0.0]], 8, false).expect("a good lathe");
        let radial: Vec<f32> = (0..4).map(|row| g.normals.as_ref().expect("it has normals")[row * 9][0]).collect();
        assert_eq!(radial, [1.0, 1.0, -1.0, -1.0]);
        let g = lathe(&[[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]], 8, true).expect("a good lathe");
        assert!(largest_normal_deviation((&g).into()).expect("it has normals") < 1e-3);
    }

    #[test]
    fn the_bowl_has_its_bounds() {
        let g = lathe(&[[0.0, 0.0], [3.0, 1.0], [4.0, 5.0]], 32, false).expect("a good lathe");
        assert_eq!(bounds((&g).into()), Some([[-4.0, -4.0, 0.0], [4.0, 4.0, 5.0]]));
        assert_eq!(g.normals.as_ref().expect("it has normals")[0], [0.0, 0.0, -1.0]);
    }

    #[test]
    fn bad_profiles_are_explained() {
        let fault = |profile: &[[f64; 2]], closed| lathe(profile, 64, closed).expect_err("a bad profile");
        let says = |profile: &[[f64; 2]], closed, words: &str| {
            let error = fault(profile, closed);
            assert!(error.argument == "profile" && error.message.contains(words), "{error}");
        };
        says(&[], false, "0 points");
        says(&[[1.0, 0.0]], false, "1 points");
        says(&[[1.0, 0.0], [1.0, 1.0]], true, "closed profile of 2 points");
        says(&[[1.0, 0.0], [-1.0, 1.0]], false, "point 1 has the distance -1");
        says(&[[1.0, 0.0], [f64::NAN, 1.0]], false, "not finite");
        says(&[[1.0, 0.0], [1.0, f64::INFINITY]], false, "not finite");
        says(&[[1.0, 0.0], [1.0, 1e200]], false, "single precision");
        says(&[[1.0, 0.0], [1.0, 1.0], [1.0, 1.0 + 1e-12]], false, "points 1 and 2");
        says(&[[1.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 0.0]], true, "the first again");
        says(&[[0.0, 0.0], [0.0, 1.0]], false, "lies on the axis");
        // Hardly above the least number of single precision: corners of the polygon coincide.
        says(&[[1e-44, 0.0], [1e-44, 3e-44]], false, "vanish");
        let segments = |segments| lathe(&[[1.0, 0.0], [1.0, 1.0]], segments, false).expect_err("bad").argument;
        assert_eq!([2, (1 << 29) + 1, u64::MAX].map(segments), ["segments"; 3]);
    }
}
