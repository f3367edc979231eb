//! What can be wrong with a mesh that is well-formed, found in one pass over its triangles, and triangles that lie at one place.

use rayon::prelude::*;

use super::View;
use crate::ir::{Vec3, cross, dot, sub};

/// Triangles that one task looks at. The sums are those of the pieces in their order, whatever the number of threads.
const PIECE: usize = 1 << 15;

/// Heights of a triangle below this part of its largest coordinate vanish in the rounding of single precision (half a unit in
/// the last place).
const VANISHING: f64 = 1.0 / (1 << 24) as f64;

/// A number of triangles, and the first of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// How many.
    pub count: usize,
    /// The first one's place in the list of triangles; 0 for none.
    pub first: usize,
}

impl Found {
    fn add(&mut self, at: usize) {
        if self.count == 0 {
            self.first = at;
        }
        self.count += 1;
    }

    fn join(&mut self, later: Self) {
        if self.count == 0 {
            self.first = later.first;
        }
        self.count += later.count;
    }
}

/// Measures and faults of a mesh in its own coordinates. Triangles that use a vertex that is not there are passed over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// Triangles without a normal: of no area, or so thin that rounding decides where they look.
    pub degenerate: Found,
    /// Triangles with a vertex normal on the side from which their corners run clockwise.
    pub flipped: Found,
    /// The largest angle in degrees, 0..180, between a face and the normal of one of its vertices; 0 without normals.
    pub lean: f64,
    /// The sum of the areas, in units squared.
    pub area: f64,
    /// The enclosed volume in units cubed, negative where the faces look inwards; of an open mesh it means nothing.
    pub volume: f64,
    /// The sine of the lean squared; beyond 90 degrees 2 less that. It grows with the angle and needs no arc.
    turned: f64,
}

/// Looks at every triangle once. Time is linear, over as many threads as there are.
pub fn faults(view: View<'_>) -> Faults {
    let pole = view.positions.first().map_or([0.0; 3], |point| point.map(f64::from));
    let pieces: Vec<Faults> = if view.triangles.len() <= PIECE {
        vec![piece(view, pole, 0, view.triangles)]
    } else {
        let pieces = view.triangles.par_chunks(PIECE).enumerate();
        pieces.map(|(at, triangles)| piece(view, pole, at * PIECE, triangles)).collect()
    };
    let mut whole = Faults::default();
    for piece in pieces {
        whole.degenerate.join(piece.degenerate);
        whole.flipped.join(piece.flipped);
        whole.turned = whole.turned.max(piece.turned);
        whole.area += piece.area;
        whole.volume += piece.volume;
    }
    let sine = libm::asin(whole.turned.min(2.0 - whole.turned).clamp(0.0, 1.0).sqrt()).to_degrees();
    whole.lean = if whole.turned > 1.0 { 180.0 - sine } else { sine };
    whole
}

fn piece(view: View<'_>, pole: Vec3, start: usize, triangles: &[[u32; 3]]) -> Faults {
    let mut found = Faults::default();
    for (at, triangle) in (start..).zip(triangles) {
        let Some(corners) = corners(view, *triangle) else { continue };
        let [a, b, c] = corners.map(|corner| sub(corner, pole));
        let (ab, ac) = (sub(b, a), sub(c, a));
        let face = cross(ab, ac);
        let square = dot(face, face);
        found.area += 0.5 * square.sqrt();
        found.volume += dot(a, cross(b, c)) / 6.0;
        if vanishes(corners, square) {
            found.degenerate.add(at);
            continue;
        }
        let Some(normals) = view.normals else { continue };
        let mut flipped = false;
        for index in triangle {
            let Some(normal) = normals.get(*index as usize).map(|normal| normal.map(f64::from)) else { continue };
            let across = cross(face, normal);
            let sine = dot(across, across) / (square * dot(normal, normal));
            let backwards = dot(face, normal) < 0.0;
            flipped |= backwards;
            found.turned = found.turned.max(if backwards { 2.0 - sine } else { sine });
        }
        if flipped {
            found.flipped.add(at);
        }
    }
    found
}

/// Whether a triangle is too thin to have a normal in single precision. `square` is twice its area, squared.
fn vanishes(corners: [Vec3; 3], square: f64) -> bool {
    let [a, b, c] = corners;
    let longest = [sub(b, a), sub(c, b), sub(a, c)].map(|edge| dot(edge, edge)).into_iter().fold(0.0, f64::max);
    let reach = corners.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // The height over the longest edge is twice the area over its length.
    square <= longest * (VANISHING * reach) * (VANISHING * reach)
}

fn corners(view: View<'_>, triangle: [u32; 3]) -> Option<[Vec3; 3]> {
    let [a, b, c] = triangle.map(|index| view.positions.get(index as usize));
    Some([*a?, *b?, *c?].map(|point| point.map(f64::from)))
}

/// Triangles that have their three corners where an earlier one has them, in whatever order.
pub fn duplicate_triangles(view: View<'_>) -> Found {
    // 0 and -0 are one place.
    let bits = |index: u32| view.positions[index as usize].map(|x| (x + 0.0).to_bits());
    let inside = |triangle: &[u32; 3]| triangle.iter().all(|index| (*index as usize) < view.positions.len());
    // A hash that does not depend on the order of the corners; only equal hashes are looked at closely.
    let hash = |triangle: &[u32; 3]| triangle.iter().fold(0_u64, |sum, index| sum.wrapping_add(mixed(bits(*index))));
    let hashes: Vec<u64> = view.triangles.iter().map(|t| if inside(t) { hash(t) } else { 0 }).collect();
    let mut sorted = hashes.clone();
    sorted.par_sort_unstable();
    let mut again: Vec<u64> = sorted.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    again.dedup();
    let mut found = Found::default();
    if again.is_empty() {
        return found;
    }
    let mut close: Vec<([[u32; 3]; 3], usize)> = Vec::new();
    for (at, triangle) in view.triangles.iter().enumerate() {
        if again.binary_search(&hashes[at]).is_err() || !inside(triangle) {
            continue;
        }
        let mut key = triangle.map(bits);
        key.sort_unstable();
        // What has no area has a rule of its own.
        if key[0] != key[1] && key[1] != key[2] {
            close.push((key, at));
        }
    }
    close.sort_unstable();
    let mut later: Vec<usize> =
        close.chunk_by(|one, other| one.0 == other.0).flat_map(|same| same[1..].iter().map(|(_, at)| *at)).collect();
    later.sort_unstable();
    later.into_iter().for_each(|at| found.add(at));
    found
}

/// The bits of a position, well spread (the finaliser of SplitMix64, Steele et al. 2014).
fn mixed([x, y, z]: [u32; 3]) -> u64 {
    let start = (u64::from(x) | u64::from(y) << 32) ^ u64::from(z).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let once = (start ^ start >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let twice = (once ^ once >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    twice ^ twice >> 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Geometry, area, boxed, flip, largest_normal_deviation, signed_volume, sphere};

    fn of(geometry: &Geometry) -> Faults {
        faults(geometry.into())
    }

    #[test]
    fn one_pass_measures_what_the_single_measures_do() {
        for geometry in [
            boxed([10.0; 3], [11.0, 12.0, 13.0]).expect("a good box"),
            flip(sphere(2.0, [5.0, 0.0, 1.0], 40, 20).expect("a good sphere")),
            // More than one piece.
            sphere(2.0, [5.0, 0.0, 1.0], 400, 201).expect("a good sphere"),
        ] {
            let found = of(&geometry);
            let view = (&geometry).into();
            assert!((found.area - area(view)).abs() < 1e-9 * found.area);
            assert!((found.volume - signed_volume(view)).abs() < 1e-9 * found.area);
            assert!((found.lean - largest_normal_deviation(view).expect("normals")).abs() < 1e-6, "{}", found.lean);
            assert_eq!((found.degenerate.count, found.flipped.count), (0, 0));
        }
    }

    #[test]
    fn turned_triangles_are_counted() {
        let mut geometry = boxed([0.0; 3], [1.0; 3]).expect("a good box");
        geometry.triangles[3].swap(0, 1);
        geometry.triangles[7].swap(1, 2);
        let found = of(&geometry);
        assert_eq!((found.flipped, found.lean), (Found { count: 2, first: 3 }, 180.0));
    }

    #[test]
    fn slivers_of_single_precision_are_degenerate() {
        let mut geometry = Geometry {
            positions: vec![[1000.0, 0.0, 0.0], [1001.0, 0.0, 0.0], [1000.5, 2e-5, 0.0], [1000.5, 0.1, 0.0]],
            triangles: vec![[0, 1, 3], [0, 1, 2], [0, 0, 3], [0, 1, 9]],
            ..Geometry::default()
        };
        assert_eq!(of(&geometry).degenerate, Found { count: 2, first: 1 });
        // Near the origin the same sliver has a normal.
        geometry.positions.iter_mut().for_each(|position| position[0] -= 1000.5);
        assert_eq!(of(&geometry).degenerate, Found { count: 1, first: 2 });
    }

    #[test]
    fn duplicates_are_found_in_any_order_of_corners() {
        let mut geometry = boxed([0.0; 3], [1.0; 3]).expect("a good box");
        assert_eq!(duplicate_triangles((&geometry).into()), Found::default());
        let [a, b, c] = geometry.triangles[4];
        // At the same place by another vertex, turned over.
        let copy = geometry.positions[b as usize];
        geometry.positions.push(copy.map(|x| if x == 0.0 { -0.0 } else { x }));
        let twin = geometry.positions.len() as u32 - 1;
        geometry.triangles.extend([[c, twin, a], [a, b, c], [a, a, b], [a, a, b]]);
        assert_eq!(duplicate_triangles((&geometry).into()), Found { count: 2, first: 12 });
    }
}
