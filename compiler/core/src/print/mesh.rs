//! Meshes that a constructor makes to the bit, as its call.

use super::number::{number, rounder, single, vector};
use crate::ir::Mesh;
use crate::mesh::{Axis, Extent, Geometry, MeshError, SignedAxis, boxed, cylinder, disk, is_unit, rectangle, sphere};

/// The segments and rings that a call does not have to say.
const SEGMENTS: u64 = 64;
const RINGS: u64 = 32;

/// The call that makes the mesh, equal in every bit; none where no short one does. A candidate is made only where the counts of
/// vertices and triangles are its own, so that this takes time linear in the mesh.
pub(super) fn constructor(mesh: &Mesh) -> Option<String> {
    if mesh.normals.is_none() || mesh.uvs.is_none() {
        return None;
    }
    let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    if (vertices, triangles) == (4, 2) {
        return flat(mesh);
    }
    if (vertices, triangles) == (24, 12)
        && let Some(made) = solid(mesh)
    {
        return Some(made);
    }
    if triangles >= 3 && vertices == triangles + 1 {
        return round_plate(mesh, triangles);
    }
    ball(mesh, vertices, triangles).or_else(|| tube(mesh, vertices, triangles))
}

/// What of a mesh the reader of files would refuse or change, in words.
pub(super) fn fault(mesh: &Mesh) -> Option<String> {
    let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
    let count = positions.len();
    let lengths = [normals.as_ref().map(|all| all.len()), uvs.as_ref().map(|all| all.len())];
    if triangles.is_empty() {
        return Some("it has no triangle".to_owned());
    }
    if lengths.into_iter().flatten().any(|length| length != count) {
        return Some("its arrays have different lengths".to_owned());
    }
    if triangles.as_flattened().iter().any(|index| *index as usize >= count) {
        return Some("a triangle uses a vertex that is not there".to_owned());
    }
    let finite = positions.as_flattened().iter().all(|x| x.is_finite());
    if !(finite && uvs.iter().all(|uvs| uvs.as_flattened().iter().all(|x| x.is_finite()))) {
        return Some("it has numbers that are not finite".to_owned());
    }
    let lengthy = normals.iter().flat_map(|normals| normals.iter()).any(|normal| !is_unit(*normal));
    lengthy.then(|| "it has normals of another length than 1".to_owned())
}

/// Whether the candidate is the mesh, in every bit.
fn same(mesh: &Mesh, made: Result<Geometry, MeshError>) -> bool {
    fn bits<const N: usize>(one: Option<&[[f32; N]]>, other: Option<&[[f32; N]]>) -> bool {
        let (Some(one), Some(other)) = (one, other) else { return one.is_none() && other.is_none() };
        let pairs = || one.as_flattened().iter().zip(other.as_flattened());
        one.len() == other.len() && pairs().all(|(a, b)| a.to_bits() == b.to_bits())
    }
    let Ok(Geometry { positions, normals, uvs, triangles }) = made else { return false };
    *mesh.triangles == triangles
        && bits(Some(&mesh.positions), Some(&positions))
        && bits(mesh.normals.as_ref().map(|all| &all[..]), normals.as_deref())
        && bits(mesh.uvs.as_ref().map(|all| &all[..]), uvs.as_deref())
}

/// The smallest and the largest coordinate along each axis.
fn bounds(mesh: &Mesh) -> [[f32; 2]; 3] {
    [0, 1, 2].map(|axis: usize| {
        let along = mesh.positions.iter().map(|position| position[axis]);
        along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    })
}

/// `0..1`, and the numbers that are read there.
fn range([low, high]: [f32; 2]) -> (String, [f64; 2]) {
    let ((from, low), (to, high)) = (single(low), single(high));
    (format!("{from}..{to}"), [low, high])
}

fn flat(mesh: &Mesh) -> Option<String> {
    let normal = mesh.normals.as_ref()?.first()?.map(f64::from);
    let normal = SignedAxis::from_vector(normal)?;
    let mut extents = [Extent::At(0.0); 3];
    let mut words = Vec::new();
    for (axis, bounds) in Axis::ALL.into_iter().zip(bounds(mesh)) {
        let (text, extent) = if axis == normal.axis {
            let (text, at) = single(bounds[0]);
            (text, Extent::At(at))
        } else {
            let (text, [low, high]) = range(bounds);
            (text, Extent::Range(low, high))
        };
        extents[axis.index()] = extent;
        words.push(format!("{}: {text}", axis.name()));
    }
    let sign = if normal.negative { "-" } else { "" };
    let axis = normal.axis.name().to_ascii_uppercase();
    let call = format!("rectangle({}, normal: {sign}{axis})", words.join(", "));
    same(mesh, rectangle(extents, normal)).then_some(call)
}

fn solid(mesh: &Mesh) -> Option<String> {
    let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
    let mut words = Vec::new();
    for (axis, bounds) in Axis::ALL.into_iter().zip(bounds(mesh)) {
        let (text, ends) = range(bounds);
        (low[axis.index()], high[axis.index()]) = (ends[0], ends[1]);
        words.push(format!("{}: {text}", axis.name()));
    }
    // A cube about the origin has a shorter form.
    let side = high[0] - low[0];
    if low == [-high[0]; 3] && high == [high[0]; 3] && same(mesh, boxed([-side / 2.0; 3], [side / 2.0; 3])) {
        return Some(format!("box(size: {})", number(side)));
    }
    same(mesh, boxed(low, high)).then(|| format!("box({})", words.join(", ")))
}

/// A sphere of `segments` and `rings` has 2 s (r - 1) triangles and (s + 1)(r - 1) + 2 s vertices.
fn ball(mesh: &Mesh, vertices: u64, triangles: u64) -> Option<String> {
    let inner = triangles / 2;
    let rest = vertices.checked_sub(inner)?;
    // s and r - 1 are known by their product, `inner`, and (r - 1) + 2 s, `rest`: 2 s is a root of x^2 - rest x + 2 inner.
    let square = rest.checked_mul(rest)?.checked_sub(inner.checked_mul(8)?)?;
    let root = square.isqrt();
    if !triangles.is_multiple_of(2) || root * root != square {
        return None;
    }
    for double in [rest + root, rest - root] {
        let (segments, rings) = (double / 4, rest - double / 2 + 1);
        if !double.is_multiple_of(4) || segments < 3 || rings < 2 || segments * (rings - 1) != inner {
            continue;
        }
        let (bottom, top) = (mesh.positions.first()?, mesh.positions.last()?);
        let (low, high) = (f64::from(bottom[2]), f64::from(top[2]));
        let [x, y] = [bottom[0], bottom[1]].map(|x| single(x).1);
        let sizes = rounder((high - low) / 2.0);
        let middles = rounder(f64::midpoint(low, high));
        let tries = sizes.iter().flat_map(|radius| middles.iter().map(move |z| (*radius, *z)));
        // Its poles are computed as the generator does.
        let fits = |(radius, z): &(f64, f64)| (z - radius) as f32 == bottom[2] && (z + radius) as f32 == top[2];
        for (radius, z) in tries.filter(fits).take(3) {
            let middle = [x, y, z];
            if radius > 0.0 && same(mesh, sphere(radius, middle, segments, rings)) {
                let words = [
                    (radius != 1.0).then(|| format!("radius: {}", number(radius))),
                    (middle != [0.0; 3]).then(|| format!("center: {}", vector(&middle))),
                    segmented(segments),
                    (rings != RINGS).then(|| format!("rings: {rings}")),
                ];
                return Some(format!("sphere({})", words.into_iter().flatten().collect::<Vec<_>>().join(", ")));
            }
        }
    }
    None
}

fn segmented(segments: u64) -> Option<String> {
    (segments != SEGMENTS).then(|| format!("segments: {segments}"))
}

fn round_plate(mesh: &Mesh, segments: u64) -> Option<String> {
    let (text, radius) = single(bounds(mesh)[0][1]);
    let words = [Some(format!("radius: {text}")), segmented(segments)];
    let call = format!("disk({})", words.into_iter().flatten().collect::<Vec<_>>().join(", "));
    same(mesh, disk(radius, 0.0, segments)).then_some(call)
}

fn tube(mesh: &Mesh, vertices: u64, triangles: u64) -> Option<String> {
    let [x, _, z] = bounds(mesh);
    let ((text, radius), (ends, [low, high])) = (single(x[1]), range(z));
    for (share, caps) in [(2, false), (4, true)] {
        let segments = triangles / share;
        // The side has a row of vertices at either end, whose last lies on the first.
        if !triangles.is_multiple_of(share) || segments < 3 || vertices < 2 * (segments + 1) {
            continue;
        }
        if same(mesh, cylinder(radius, (low, high), segments, caps)) {
            let words = [Some(format!("radius: {text}")), Some(format!("z: {ends}")), segmented(segments)];
            let caps = (!caps).then(|| "caps: false".to_owned());
            let words: Vec<String> = words.into_iter().chain([caps]).flatten().collect();
            return Some(format!("cylinder({})", words.join(", ")));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(made: Result<Geometry, MeshError>) -> Option<String> {
        constructor(&made.expect("a good mesh").into_mesh("m"))
    }

    #[test]
    fn meshes_of_constructors_are_told_from_others() {
        let z = SignedAxis { axis: Axis::Z, negative: true };
        let made = rectangle([Extent::Range(-1.5, 0.1), Extent::Range(0.0, 1e-7), Extent::At(3.0)], z);
        assert_eq!(of(made).as_deref(), Some("rectangle(x: -1.5..0.1, y: 0..1e-7, z: 3, normal: -Z)"));
        assert_eq!(of(boxed([-1.0; 3], [1.0; 3])).as_deref(), Some("box(size: 2)"));
        assert_eq!(of(boxed([0.0; 3], [1.0, 2.0, 0.3])).as_deref(), Some("box(x: 0..1, y: 0..2, z: 0..0.3)"));
        assert_eq!(of(sphere(1.0, [0.0; 3], 64, 32)).as_deref(), Some("sphere()"));
        let made = sphere(0.3, [1.0, 0.0, 2.0], 7, 40);
        assert_eq!(of(made).as_deref(), Some("sphere(radius: 0.3, center: (1, 0, 2), segments: 7, rings: 40)"));
        assert_eq!(of(disk(0.7, 0.0, 64)).as_deref(), Some("disk(radius: 0.7)"));
        assert_eq!(of(cylinder(0.3, (0.0, 4.0), 64, true)).as_deref(), Some("cylinder(radius: 0.3, z: 0..4)"));
        let made = cylinder(2.0, (1.0, 4.0), 5, false);
        assert_eq!(of(made).as_deref(), Some("cylinder(radius: 2, z: 1..4, segments: 5, caps: false)"));
    }

    #[test]
    fn one_other_bit_makes_it_another_mesh() {
        let mut other = boxed([0.0; 3], [1.0; 3]).expect("a box");
        other.positions[0][0] = -0.0;
        assert_eq!(constructor(&other.clone().into_mesh("m")), None);
        other.positions[0][0] = 0.0;
        other.uvs.as_mut().expect("it has some")[3] = [0.5, 0.5];
        assert_eq!(constructor(&other.into_mesh("m")), None);
    }
}
