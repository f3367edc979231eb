//! What a mesh measures, in one pass: area, place, and which way it faces by its winding and by its normals.

use rayon::prelude::*;

use crate::ir::{Affine, Mesh, Vec3, cross, dot, length, sub};
use crate::mesh::Geometry;

/// Triangles of one step. Sums of steps are added in their order, so that they do not depend on the number of threads.
const STEP: usize = 1 << 14;

/// What is measured of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// Triangles.
    pub triangles: usize,
    /// Whether it has normals at its corners.
    pub normals: bool,
    /// Whether it has texture coordinates.
    pub uvs: bool,
    /// Sum of the areas, in scene units squared.
    pub area: f64,
    /// Sum of the lengths of all edges: how much the area changes where corners move.
    pub edges: f64,
    /// Integral of the unit normal over the area, by the winding.
    pub winding: Vec3,
    /// The same on the side of the normals at the corners, where there are some.
    pub front: Vec3,
    /// Integral of the distance from the center along the normal, by the winding: three times the volume of a closed mesh,
    /// negative where its faces look inwards.
    pub winding_out: f64,
    /// The same on the side of the normals.
    pub front_out: f64,
    /// Integral of the cosine between the face and the mean of the normals at its corners.
    pub lean: f64,
    /// Mean place, by area.
    pub center: Vec3,
    /// Mean texture coordinates, by area.
    pub uv: [f64; 2],
    /// Smallest coordinates of all corners.
    pub low: Vec3,
    /// Largest coordinates of all corners.
    pub high: Vec3,
    /// Of all numbers as they are, where the mesh was measured by [`Measure::whole`].
    pub print: Print,
}

/// Sums that two meshes share if all their numbers are the same to the bit; of others they are different but for a chance of 2 to the
/// power -64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Print {
    positions: u64,
    normals: u64,
    uvs: u64,
    triangles: u64,
}

impl Print {
    fn of(mesh: Shown<'_>) -> Self {
        let sum = |words: &mut dyn Iterator<Item = u32>| {
            words.fold(0x9e37_79b9_7f4a_7c15_u64, |sum, word| {
                let mixed = (sum ^ u64::from(word)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                mixed ^ (mixed >> 29)
            })
        };
        let floats = |all: &[f32]| sum(&mut all.iter().map(|x| x.to_bits()));
        Self {
            positions: floats(mesh.positions.as_flattened()),
            normals: mesh.normals.map_or(0, |all| floats(all.as_flattened())),
            uvs: mesh.uvs.map_or(0, |all| floats(all.as_flattened())),
            triangles: sum(&mut mesh.triangles.as_flattened().iter().copied()),
        }
    }

    /// What is not the same, in words.
    pub fn difference(&self, said: &Self) -> Option<&'static str> {
        let Self { positions, normals, uvs, triangles } = self;
        let parts = [
            (triangles, &said.triangles, "other corners of its triangles"),
            (positions, &said.positions, "other positions of its vertices"),
            (normals, &said.normals, "other normals at its corners"),
            (uvs, &said.uvs, "other texture coordinates"),
        ];
        parts.into_iter().find(|(a, b, _)| a != b).map(|(_, _, what)| what)
    }
}

/// A mesh, borrowed. Triangles that use a vertex that is not there are passed over.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) normals: Option<&'a [[f32; 3]]>,
    pub(super) uvs: Option<&'a [[f32; 2]]>,
    pub(super) triangles: &'a [[u32; 3]],
}

impl<'a> From<&'a Mesh> for Shown<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
        let (normals, uvs) = (normals.as_ref().map(|all| all.as_slice()), uvs.as_ref().map(|all| all.as_slice()));
        Self { positions, normals, uvs, triangles }
    }
}

impl<'a> From<&'a Geometry> for Shown<'a> {
    fn from(geometry: &'a Geometry) -> Self {
        let Geometry { positions, normals, uvs, triangles } = geometry;
        Self { positions, normals: normals.as_deref(), uvs: uvs.as_deref(), triangles }
    }
}

fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn times(a: Vec3, by: f64) -> Vec3 {
    a.map(|x| x * by)
}

impl Measure {
    /// Of a mesh as it is, with the sums of its numbers.
    pub fn whole(mesh: Shown<'_>) -> Self {
        Self { print: Print::of(mesh), ..Self::of(mesh, &Affine::IDENTITY) }
    }

    /// Of a mesh as `map` places it.
    pub fn of(mesh: Shown<'_>, map: &Affine) -> Self {
        let plain = *map == Affine::IDENTITY;
        let place = |point: [f32; 3]| {
            let point = point.map(f64::from);
            if plain { point } else { map.point(point) }
        };
        // Distances are taken from a corner of the mesh: far from the origin the terms would cancel.
        let pole = mesh.triangles.iter().flatten().find_map(|at| mesh.positions.get(*at as usize));
        let pole = pole.map_or([0.0; 3], |point| place(*point));
        let turn = map.cofactors();
        let side = if map.determinant() < 0.0 { -1.0 } else { 1.0 };
        let one = |sum: &mut Self, triangle: [u32; 3]| {
            let [Some(a), Some(b), Some(c)] = triangle.map(|at| mesh.positions.get(at as usize)) else { return };
            let corners = [*a, *b, *c].map(place);
            let [a, b, c] = corners;
            let (ab, ac) = (sub(b, a), sub(c, a));
            let face = times(cross(ab, ac), 0.5);
            let area = length(face);
            sum.triangles += 1;
            sum.area += area;
            sum.edges += length(ab) + length(ac) + length(sub(c, b));
            sum.winding = add(sum.winding, face);
            let middle = times(add(add(sub(a, pole), sub(b, pole)), sub(c, pole)), 1.0 / 3.0);
            sum.center = add(sum.center, times(middle, area));
            let out = dot(middle, face);
            sum.winding_out += out;
            let mut same = true;
            if let Some(normals) = mesh.normals {
                let mut mean = [0.0; 3];
                for at in triangle {
                    let normal = normals.get(at as usize).map_or([0.0; 3], |normal| normal.map(f64::from));
                    mean = add(mean, normal);
                }
                if !plain {
                    mean = times(turn.map(|row| dot(row, mean)), side);
                }
                let cosine = dot(mean, face);
                same = cosine >= 0.0;
                if area > 0.0 {
                    sum.lean += cosine / length(mean).max(f64::MIN_POSITIVE);
                }
            }
            sum.front = if same { add(sum.front, face) } else { sub(sum.front, face) };
            sum.front_out += if same { out } else { -out };
            if let Some(uvs) = mesh.uvs {
                for at in triangle {
                    let uv = uvs.get(at as usize).map_or([0.0; 2], |uv| uv.map(f64::from));
                    sum.uv = [sum.uv[0] + uv[0] * area / 3.0, sum.uv[1] + uv[1] * area / 3.0];
                }
            }
            for corner in corners {
                for (axis, x) in corner.into_iter().enumerate() {
                    sum.low[axis] = sum.low[axis].min(x);
                    sum.high[axis] = sum.high[axis].max(x);
                }
            }
        };
        let empty = Self {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            normals: mesh.normals.is_some(),
            uvs: mesh.uvs.is_some(),
            ..Self::default()
        };
        let step = |triangles: &[[u32; 3]]| {
            let mut sum = empty;
            triangles.iter().for_each(|triangle| one(&mut sum, *triangle));
            sum
        };
        let mut all = if mesh.triangles.len() <= STEP {
            step(mesh.triangles)
        } else {
            let steps: Vec<Self> = mesh.triangles.par_chunks(STEP).map(step).collect();
            steps.iter().fold(empty, |sum, next| sum.and(next))
        };
        if all.triangles == 0 {
            (all.low, all.high) = ([0.0; 3], [0.0; 3]);
        }
        if all.area > 0.0 {
            let middle = times(all.center, 1.0 / all.area);
            all.winding_out -= dot(middle, all.winding);
            all.front_out -= dot(middle, all.front);
            all.center = add(pole, middle);
            all.uv = all.uv.map(|x| x / all.area);
        } else {
            all.center = pole;
        }
        all
    }

    fn and(mut self, other: &Self) -> Self {
        self.triangles += other.triangles;
        self.area += other.area;
        self.edges += other.edges;
        self.winding = add(self.winding, other.winding);
        self.front = add(self.front, other.front);
        self.winding_out += other.winding_out;
        self.front_out += other.front_out;
        self.lean += other.lean;
        self.center = add(self.center, other.center);
        self.uv = [self.uv[0] + other.uv[0], self.uv[1] + other.uv[1]];
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
        self
    }

    /// The measure after a map that keeps angles; none for another map, which needs the mesh.
    pub fn placed(&self, map: &Affine) -> Option<Self> {
        let size = area_factor(map)?;
        let (turn, volume) = (map.cofactors(), map.determinant());
        let side = volume.signum();
        let turned = |vector: Vec3, side: f64| times(turn.map(|row| dot(row, vector)), side);
        let corners = self.corners().map(|corner| map.point(corner));
        let pick = |choose: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|axis| corners.iter().fold(start, |found, corner| choose(found, corner[axis])))
        };
        Some(Self {
            area: self.area * size,
            edges: self.edges * size.sqrt(),
            winding: turned(self.winding, 1.0),
            front: turned(self.front, if self.normals { side } else { 1.0 }),
            winding_out: self.winding_out * volume,
            front_out: self.front_out * if self.normals { volume.abs() } else { volume },
            lean: self.lean * size * side,
            center: map.point(self.center),
            low: pick(f64::min, f64::INFINITY),
            high: pick(f64::max, f64::NEG_INFINITY),
            ..*self
        })
    }

    /// The corners of the box around the mesh.
    pub fn corners(&self) -> [Vec3; 8] {
        [0_u8, 1, 2, 3, 4, 5, 6, 7].map(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            [pick(0), pick(1), pick(2)]
        })
    }

    /// The diagonal of the box.
    pub fn extent(&self) -> f64 {
        length(sub(self.high, self.low))
    }

    /// The mean normal of the side that emits, whose length is 1 for a plane and 0 for what is closed.
    pub fn facing(&self, by_normals: bool) -> Vec3 {
        let sum = if by_normals { self.front } else { self.winding };
        if self.area > 0.0 { times(sum, 1.0 / self.area) } else { [0.0; 3] }
    }
}

/// What a map makes of areas: the square of its scale; none for a map that does not keep angles.
pub fn area_factor(map: &Affine) -> Option<f64> {
    let rows = map.rows.map(|row| [row[0], row[1], row[2]]);
    if rows == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        return Some(1.0);
    }
    map.is_similarity().then(|| dot(rows[0], rows[0]))
}

/// Two measures that should be the same.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'m> {
    /// By the scene.
    pub asked: &'m Measure,
    /// By the file.
    pub said: &'m Measure,
    /// How far corners may be apart, in scene units.
    pub slack: f64,
}

/// What differs between two measures, in words.
pub fn difference(Pair { asked, said, slack }: Pair<'_>) -> Option<String> {
    let counts = |what: &str, a: usize, b: usize| (a != b).then(|| format!("{b} {what} instead of {a}"));
    if let Some(found) = counts("triangles", asked.triangles, said.triangles) {
        return Some(found);
    }
    if asked.normals != said.normals {
        return Some(if said.normals { "normals where the scene has none" } else { "no normals" }.to_owned());
    }
    let extent = asked.extent();
    let apart = |a: Vec3, b: Vec3| length(sub(a, b));
    // Each corner moves by the slack at most, hence the area of a triangle by half of its edges times that.
    let area = asked.edges * slack;
    let number = |what: &str, a: f64, b: f64, by: f64| {
        ((a - b).abs() > by || !b.is_finite()).then(|| format!("{what} {b} instead of {a}"))
    };
    let vector = |what: &str, a: Vec3, b: Vec3, by: f64| {
        (apart(a, b) > by || !b.iter().all(|x| x.is_finite())).then(|| format!("{what} {b:?} instead of {a:?}"))
    };
    let share = if asked.area > 0.0 { area / asked.area } else { 0.0 };
    // A triangle that is turned over changes these by twice its area; sums of millions of triangles round.
    let noise = 1e-9 * asked.area;
    number("the area", asked.area, said.area, area + noise)
        .or_else(|| vector("the sum of the faces", asked.winding, said.winding, area + noise))
        .or_else(|| vector("the sum of the faces by their normals", asked.front, said.front, area + noise))
        .or_else(|| {
            let by = (area + noise) * extent + asked.area * slack;
            number("faces towards the outside", asked.winding_out, said.winding_out, by)
                .or_else(|| number("normals towards the outside", asked.front_out, said.front_out, by))
        })
        .or_else(|| vector("the center", asked.center, said.center, slack + share * extent + 1e-9 * extent))
        .or_else(|| vector("the lower corner", asked.low, said.low, slack))
        .or_else(|| vector("the upper corner", asked.high, said.high, slack))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boxed, flip, sphere};

    const PLAIN: Affine = Affine::IDENTITY;

    #[test]
    fn a_box_by_hand() {
        let solid = boxed([10.0; 3], [11.0, 12.0, 13.0]).expect("a good box");
        let measure = Measure::of((&solid).into(), &PLAIN);
        // 2 (1 2 + 1 3 + 2 3), and three times 1 2 3.
        assert!((measure.area - 22.0).abs() < 1e-9 && (measure.winding_out - 18.0).abs() < 1e-9, "{measure:?}");
        assert!(length(sub(measure.center, [10.5, 11.0, 11.5])) < 1e-9 && length(measure.winding) < 1e-9);
        assert!((measure.lean - measure.area).abs() < 1e-9 && measure.front_out == measure.winding_out);
        let turned = Measure::of((&flip(solid)).into(), &PLAIN);
        assert!((turned.winding_out + 18.0).abs() < 1e-9 && (turned.front_out + 18.0).abs() < 1e-9);
        let pair = Pair { asked: &measure, said: &turned, slack: 1e-6 };
        assert!(difference(pair).is_some_and(|found| found.contains("outside")), "a closed mesh turned over is seen");
    }

    #[test]
    fn maps_that_keep_angles_need_no_mesh() {
        let ball = sphere(2.0, [1.0, 2.0, 3.0], 12, 6).expect("a good sphere");
        let measure = Measure::of((&ball).into(), &PLAIN);
        let turn = Affine::rotation([0.6, 0.0, 0.8], 40.0).then(&Affine::scaling([3.0; 3]));
        for map in [turn.then(&Affine::translation([7.0, 8.0, 9.0])), Affine::scaling([-1.0, 1.0, 1.0])] {
            let (fast, slow) = (measure.placed(&map).expect("it keeps angles"), Measure::of((&ball).into(), &map));
            // The box around a turned box is larger than that around the mesh.
            let fast = Measure { low: slow.low, high: slow.high, ..fast };
            let pair = Pair { asked: &slow, said: &fast, slack: 1e-9 };
            assert_eq!(difference(pair), None, "{map:?}");
            assert!((slow.lean - fast.lean).abs() <= 1e-6 * slow.area, "{map:?}");
        }
        assert!(measure.placed(&Affine::scaling([1.0, 1.0, 2.0])).is_none());
    }

    #[test]
    fn many_triangles_are_added_in_their_order() {
        let fine = sphere(1.0, [0.0; 3], 200, 100).expect("a good sphere");
        assert!(fine.triangles.len() > 2 * STEP, "{}", fine.triangles.len());
        let measure = Measure::of((&fine).into(), &PLAIN);
        assert_eq!(measure, Measure::of((&fine).into(), &PLAIN));
        assert!((measure.area - 4.0 * std::f64::consts::PI).abs() < 1e-2);
    }

    #[test]
    fn wrong_indices_do_no_harm() {
        let broken = Geometry {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: Some(vec![[0.0, 0.0, 1.0]]),
            uvs: Some(vec![]),
            triangles: vec![[0, 1, 2], [0, 1, 9]],
        };
        let measure = Measure::of((&broken).into(), &PLAIN);
        assert_eq!((measure.triangles, measure.area), (1, 0.5));
        assert_eq!(Measure::of((&Geometry::default()).into(), &PLAIN).area, 0.0);
    }
}
