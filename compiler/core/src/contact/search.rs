//! The search for contacts: first boxes of uses, then boxes of triangles, then triangles.

use rayon::prelude::*;

use super::hash::QuickMap;
use super::overlap::{Distances, Triangle, overlap};
use super::tree::Tree;
use super::{Contact, Contacts, Overlap, Role, coplanarity, nearness, role};
use crate::ir::{Affine, Mesh, Vec3, dot, normalized};
use crate::survey::{Bounds, Placed, Survey};

/// Boxes and triangles that are looked at before pairs are left out. Some ten seconds.
const BUDGET: u64 = 1_000_000_000;

/// How much is kept.
#[derive(Clone, Copy, Debug)]
pub struct Most {
    /// Pairs of uses, of each kind.
    pub pairs: usize,
    /// So many pairs more than those are counted.
    pub counted: usize,
    /// Contacts.
    pub contacts: usize,
}

/// 32 MiB of pairs, and about as much of contacts.
const MOST: Most = Most { pairs: 1 << 22, counted: 1 << 24, contacts: 1 << 19 };

/// A mesh of so many triangles is scanned whenever it is asked for.
const SMALL: usize = 256;

/// A larger one is scanned so often before a tree is made, which takes about as long.
const SCANS: u32 = 8;

/// So many triangles are held against a scan of the other mesh.
const FEW: usize = 16;

/// A pair whose smaller mesh has more triangles waits until all others have been looked at: where the work runs out, what is left
/// out are pairs of large meshes.
const HEAVY: usize = 4096;

/// Pairs of opaque uses of one material, which matter to one renderer only, come last and get this part of the work; where neither mesh is
/// small as above they are not looked at.
const ALIKE: u64 = 4;

/// Triangles of one mesh that are looked for in the tree of another together: neighbors in a mesh mostly lie side by side.
const GROUP: usize = 8;

/// So many pairs of triangles are held against each other in the time of one box of a tree.
const TRIED: u64 = 4;

/// Triangles that one task looks at; results are summed in their order.
const PIECE: usize = 512;

/// Faces that look the same way, and opposite ones.
type Found = [Overlap; 2];

const NOTHING: Found = [Overlap::NONE; 2];

fn both(one: Found, other: Found) -> Found {
    [one[0].and(other[0]), one[1].and(other[1])]
}

/// Two meshes at the same places relative to each other. Linear parts are numbered, offsets are in thousandths of the larger distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Pose {
    meshes: [usize; 2],
    frames: [u32; 2],
    offset: [i64; 3],
    /// The bits of the larger distance.
    near: u64,
    /// Whether it is one use with itself.
    own: bool,
}

/// The linear part of a transform, rounded to a billionth of its largest entry, and that entry.
type Frame = ([i64; 9], u32);

pub(super) struct Search<'s> {
    survey: &'s Survey<'s>,
    roles: Vec<Role>,
    /// By use, its largest coordinate, rounded up to three bits: neighbors far from the origin have the same.
    reaches: Vec<f64>,
    /// By use, the number of its linear part.
    frames: Vec<u32>,
    /// How many uses have it.
    shared: Vec<u32>,
    /// By mesh.
    scans: Vec<u32>,
    /// By mesh.
    trees: Vec<Option<Tree>>,
    /// By small mesh, boxes around its triangles.
    small: Vec<Option<Vec<Bounds>>>,
    known: QuickMap<Pose, Found>,
    looked: u64,
    budget: u64,
    most: Most,
}

impl<'s> Search<'s> {
    pub fn of(survey: &'s Survey<'s>) -> Self {
        let mut numbers: QuickMap<Frame, u32> = QuickMap::default();
        let mut shared = Vec::new();
        let mut frames = Vec::with_capacity(survey.placed.len());
        for placed in &survey.placed {
            let number = *numbers.entry(frame(&placed.transform)).or_insert_with(|| {
                shared.push(0);
                shared.len() as u32 - 1
            });
            shared[number as usize] += 1;
            frames.push(number);
        }
        let meshes = survey.scene.meshes.len();
        Self {
            survey,
            reaches: survey.placed.iter().map(|placed| rounded_up(placed.bounds.reach())).collect(),
            roles: survey.placed.iter().map(|placed| role(survey, placed)).collect(),
            frames,
            shared,
            scans: vec![0; meshes],
            trees: (0..meshes).map(|_| None).collect(),
            small: vec![None; meshes],
            known: QuickMap::default(),
            looked: 0,
            budget: BUDGET,
            most: MOST,
        }
    }

    /// Looks at fewer boxes and triangles.
    #[cfg(test)]
    pub fn with_budget(mut self, budget: u64) -> Self {
        self.budget = budget;
        self
    }

    /// Keeps less.
    #[cfg(test)]
    pub fn with_most(mut self, most: Most) -> Self {
        self.most = most;
        self
    }

    pub fn run(mut self) -> Contacts {
        let placed = &self.survey.placed;
        let mut contacts = Contacts::default();
        let count = |placed: &Placed<'_>| self.survey.scene.meshes[placed.shape.mesh].triangles.len();
        let large: Vec<bool> = placed.iter().map(|placed| count(placed) > HEAVY).collect();
        let small: Vec<bool> = placed.iter().map(|placed| count(placed) <= SMALL).collect();
        // What two uses have in common reaches no farther than either, so that each box may be grown by its own distance.
        let grown: Vec<Bounds> =
            placed.iter().zip(&self.reaches).map(|(placed, reach)| placed.bounds.grown(nearness(*reach))).collect();
        // Opaque uses of one material matter little to each other, and wait: equal numbers.
        let classes: Vec<Option<usize>> = placed
            .iter()
            .zip(&self.roles)
            .map(|(placed, role)| (*role == Role::Opaque).then(|| placed.shape.material.index()))
            .collect();
        let (mut pairs, mut alike): (Vec<[u32; 2]>, Vec<[u32; 2]>) = (Vec::new(), Vec::new());
        let own = (0..placed.len()).filter(|at| self.roles[*at] == Role::Dielectric);
        pairs.extend(own.map(|at| [at as u32; 2]));
        let most = self.most;
        let tree = Tree::of(placed.len(), |at| grown[at]);
        self.looked += tree.each_pair(
            |at| grown[at],
            |one, other| {
                let same = classes[one].is_some() && classes[one] == classes[other];
                if same && !small[one] && !small[other] {
                    return true;
                }
                let into = if same { &mut alike } else { &mut pairs };
                if into.len() < most.pairs {
                    into.push([one as u32, other as u32]);
                } else {
                    contacts.left_out += 1;
                }
                // So many more are not even counted.
                contacts.uncounted = contacts.left_out >= most.counted;
                !contacts.uncounted
            },
        );
        // In the order of the scene, for the work may run out.
        pairs.sort_unstable();
        let mut heavy: Vec<([usize; 2], Bounds)> = Vec::new();
        for uses in pairs.into_iter().map(|uses| uses.map(|at| at as usize)) {
            let [one, other] = uses;
            let region = if one == other { Some(placed[one].bounds) } else { self.region(one, other) };
            match region {
                Some(region) if large[one] && large[other] => heavy.push((uses, region)),
                Some(region) => self.contact(uses, region, &mut contacts),
                None => {}
            }
        }
        for (uses, region) in heavy {
            self.contact(uses, region, &mut contacts);
        }
        alike.sort_unstable();
        self.budget = self.budget.min(self.looked.saturating_add(self.budget / ALIKE));
        for uses in alike.into_iter().map(|uses| uses.map(|at| at as usize)) {
            if let Some(region) = self.region(uses[0], uses[1]) {
                self.contact(uses, region, &mut contacts);
            }
        }
        contacts.found.sort_unstable_by_key(|contact| contact.uses);
        contacts
    }

    fn distances(&self, [one, other]: [usize; 2]) -> Distances {
        // What they have in common reaches no farther than either.
        let reach = self.reaches[one].min(self.reaches[other]);
        let coplanar = coplanarity(reach);
        let opaque = self.roles[one] == Role::Opaque && self.roles[other] == Role::Opaque;
        Distances { near: if opaque { coplanar } else { nearness(reach) }, coplanar }
    }

    /// Where both may be close; none where that is nowhere or along a line.
    fn region(&self, one: usize, other: usize) -> Option<Bounds> {
        let [a, b] = [one, other].map(|at| self.survey.placed[at].bounds);
        let Distances { near, coplanar: _ } = self.distances([one, other]);
        let region = a.grown(near).common(b.grown(near))?;
        let thin = region.size().into_iter().filter(|side| *side <= 4.0 * near).count();
        (thin < 2).then_some(region)
    }

    fn contact(&mut self, uses: [usize; 2], region: Bounds, contacts: &mut Contacts) {
        if self.looked > self.budget || contacts.found.len() == self.most.contacts {
            contacts.left_out += 1;
            return;
        }
        let within = self.distances(uses);
        let pose = self.pose(uses, within);
        let known = pose.and_then(|pose| self.known.get(&pose)).copied();
        let found = known.unwrap_or_else(|| {
            let found = if uses[0] == uses[1] { self.own(uses[0], within) } else { self.pair(uses, region, within) };
            if let Some(pose) = pose {
                self.known.insert(pose, found);
            }
            found
        });
        let [same, opposite] = found;
        if same.near > 0.0 || opposite.near > 0.0 {
            contacts.found.push(Contact { uses, same, opposite, nearness: within.near });
        }
    }

    /// What both have in common with other pairs; none where there can be no other.
    fn pose(&self, uses: [usize; 2], within: Distances) -> Option<Pose> {
        let frames = uses.map(|at| self.frames[at]);
        if frames.iter().any(|frame| self.shared[*frame as usize] < 2) {
            return None;
        }
        let [one, other] = uses.map(|at| &self.survey.placed[at]);
        let offset = [0, 1, 2].map(|axis| {
            let from = one.transform.rows[axis][3];
            ((other.transform.rows[axis][3] - from) / (1e-3 * within.near)).round() as i64
        });
        let meshes = [one, other].map(|placed| placed.shape.mesh.index());
        Some(Pose { meshes, frames, offset, near: within.near.to_bits(), own: uses[0] == uses[1] })
    }

    /// The triangles of a use that may reach into `region`, and at least those.
    fn reaching(&mut self, at: usize, region: Bounds) -> Vec<u32> {
        let placed = &self.survey.placed[at];
        let mesh = &self.survey.scene.meshes[placed.shape.mesh];
        let Some(near) = into_mesh(placed).map(|into| into(region)) else { return Vec::new() };
        let number = placed.shape.mesh.index();
        let count = mesh.triangles.len();
        if self.trees[number].is_none() && count <= SMALL {
            self.looked += count as u64;
            let boxes = self.small[number]
                .get_or_insert_with(|| (0..count).map(|at| own_bounds_or_nowhere(mesh, at)).collect());
            return (0..).zip(boxes).filter(|(_, own)| own.touches(near)).map(|(at, _)| at).collect();
        }
        if self.trees[number].is_none() && self.scans[number] < SCANS {
            self.scans[number] += 1;
            self.looked += count as u64;
            return (0..count as u32).filter(|at| own_bounds_or_nowhere(mesh, *at as usize).touches(near)).collect();
        }
        self.plant(number, mesh);
        let Some(tree) = &self.trees[number] else { return Vec::new() };
        let mut found = Vec::new();
        self.looked += tree.each(near, |items| found.extend_from_slice(items));
        found.sort_unstable();
        found
    }

    fn plant(&mut self, number: usize, mesh: &Mesh) {
        if self.trees[number].is_none() {
            self.looked += 4 * mesh.triangles.len() as u64;
            let tree = Tree::of(mesh.triangles.len(), |at| own_bounds_or_nowhere(mesh, at));
            self.trees[number] = Some(tree);
        }
    }

    fn pair(&mut self, uses: [usize; 2], region: Bounds, within: Distances) -> Found {
        let survey = self.survey;
        let count = |at: usize| survey.scene.meshes[survey.placed[at].shape.mesh].triangles.len();
        // The triangles of the smaller mesh are looked for in the larger one.
        let [one, other] = if count(uses[0]) <= count(uses[1]) { uses } else { [uses[1], uses[0]] };
        // In a region as thin as a sheet only faces along it have an area.
        let size = region.size();
        let sheet = (0..3).find(|axis| size[*axis] <= 4.0 * within.near);
        let lies = |triangle: &Triangle| sheet.is_none_or(|axis| triangle.normal[axis].abs() > 0.9);
        let other_use = &survey.placed[other];
        let [of_one, of_other] = [one, other].map(|at| triangles(survey, &survey.placed[at]));
        let [of_one, of_other] = [&of_one, &of_other].map(|of| move |at: u32| of(at as usize).filter(lies));

        let candidates = self.reaching(one, region);
        if candidates.len() <= FEW || count(other) <= SMALL {
            let few: Vec<Triangle> = candidates.into_iter().filter_map(&of_one).collect();
            let Some(around) = few.iter().map(|triangle| triangle.bounds).reduce(Bounds::union) else { return NOTHING };
            let Some(closer) = around.grown(within.near).common(region) else { return NOTHING };
            let others = self.reaching(other, closer);
            self.looked += (few.len() * others.len()) as u64;
            let each = |found: Found, at: u32| match of_other(at) {
                Some(second) => few.iter().fold(found, |found, first| add(found, overlap(first, &second, within))),
                None => found,
            };
            return others.into_iter().fold(NOTHING, each);
        }
        let number = other_use.shape.mesh.index();
        self.plant(number, &survey.scene.meshes[other_use.shape.mesh]);
        let (Some(tree), Some(into)) = (&self.trees[number], into_mesh(other_use)) else { return NOTHING };
        let each = |piece: &[u32]| {
            let (mut found, mut looked) = (NOTHING, 0);
            for group in piece.chunks(GROUP) {
                let firsts: Vec<Triangle> = group.iter().filter_map(|at| of_one(*at)).collect();
                let Some(around) = firsts.iter().map(|first| first.bounds).reduce(Bounds::union) else { continue };
                let mut tried = 0;
                looked += tree.each(into(around.grown(within.near)), |items| {
                    tried += (items.len() * firsts.len()) as u64;
                    for second in items.iter().filter_map(|at| of_other(*at)) {
                        found = firsts.iter().fold(found, |found, first| add(found, overlap(first, &second, within)));
                    }
                });
                looked += tried / TRIED;
            }
            (found, looked)
        };
        let pieces: Vec<(Found, u64)> = candidates.par_chunks(PIECE).map(each).collect();
        self.looked += pieces.iter().map(|(_, looked)| looked).sum::<u64>();
        pieces.into_iter().fold(NOTHING, |found, (piece, _)| both(found, piece))
    }

    /// Opposite faces of one use that are close to each other.
    fn own(&mut self, at: usize, within: Distances) -> Found {
        let survey = self.survey;
        let placed = &survey.placed[at];
        let mesh = &survey.scene.meshes[placed.shape.mesh];
        self.looked += mesh.triangles.len() as u64;
        if one_way(survey, placed) {
            return NOTHING;
        }
        let number = placed.shape.mesh.index();
        self.plant(number, mesh);
        let (Some(tree), Some(into)) = (&self.trees[number], into_mesh(placed)) else { return NOTHING };
        let of = triangles(survey, placed);
        let of = |at: u32| of(at as usize);
        let each = |piece: usize| {
            let (mut found, mut looked) = (NOTHING, 0);
            let end = mesh.triangles.len().min((piece + 1) * PIECE);
            for start in (piece * PIECE..end).step_by(GROUP) {
                let group = (start..end.min(start + GROUP)).map(|at| at as u32);
                let firsts: Vec<(u32, Triangle)> = group.filter_map(|at| Some((at, of(at)?))).collect();
                let Some(around) = firsts.iter().map(|(_, first)| first.bounds).reduce(Bounds::union) else { continue };
                let mut tried = 0;
                looked += tree.each(into(around.grown(within.near)), |items| {
                    tried += (items.len() * firsts.len()) as u64;
                    for item in items.iter().filter(|item| **item as usize > start) {
                        let Some(second) = of(*item) else { continue };
                        let earlier = firsts.iter().filter(|(at, _)| at < item).map(|(_, first)| first);
                        for first in earlier.filter(|first| dot(first.normal, second.normal) < 0.0) {
                            found = add(found, overlap(first, &second, within));
                        }
                    }
                });
                looked += tried / TRIED;
            }
            (found, looked)
        };
        let pieces = mesh.triangles.len().div_ceil(PIECE);
        let pieces: Vec<(Found, u64)> = (0..pieces).into_par_iter().map(each).collect();
        self.looked += pieces.iter().map(|(_, looked)| looked).sum::<u64>();
        pieces.into_iter().fold(NOTHING, |found, (piece, _)| both(found, piece))
    }
}

fn add([same, opposite]: Found, found: Option<(bool, Overlap)>) -> Found {
    match found {
        None => [same, opposite],
        Some((true, more)) => [same.and(more), opposite],
        Some((false, more)) => [same, opposite.and(more)],
    }
}

/// Whether all faces of a use look into one half of space, so far that no two are opposite.
fn one_way(survey: &Survey<'_>, placed: &Placed<'_>) -> bool {
    let mut sum: Vec3 = [0.0; 3];
    let of = triangles(survey, placed);
    let faces = || (0..survey.scene.meshes[placed.shape.mesh].triangles.len()).filter_map(&of);
    for face in faces() {
        sum = [0, 1, 2].map(|axis| sum[axis] + face.area * face.normal[axis]);
    }
    // At most 81 degrees from the middle, at most 163 from each other.
    normalized(sum).is_some_and(|middle| faces().all(|face| dot(face.normal, middle) > 0.15))
}

/// The triangles of a use in the scene, by number; a mirroring transform turns their corners, so that the front stays in front.
fn triangles<'a>(survey: &'a Survey<'_>, placed: &'a Placed<'_>) -> impl Fn(usize) -> Option<Triangle> + Sync + 'a {
    let mesh = &survey.scene.meshes[placed.shape.mesh];
    let mirrors = placed.transform.determinant() < 0.0;
    move |at| {
        let [a, b, c] = own_corners(mesh, at)?.map(|corner| placed.transform.point(corner));
        Triangle::of(if mirrors { [a, c, b] } else { [a, b, c] })
    }
}

fn own_corners(mesh: &Mesh, at: usize) -> Option<[Vec3; 3]> {
    let [a, b, c] = mesh.triangles.get(at)?.map(|index| mesh.positions.get(index as usize));
    Some([*a?, *b?, *c?].map(|point| point.map(f64::from)))
}

/// A box around a triangle in the coordinates of its mesh. One with an index out of range lies nowhere near.
fn own_bounds_or_nowhere(mesh: &Mesh, at: usize) -> Bounds {
    const NOWHERE: Bounds = Bounds { low: [f64::MAX; 3], high: [f64::MAX; 3] };
    own_corners(mesh, at).map_or(NOWHERE, Bounds::of_triangle)
}

/// Puts boxes around boxes of the scene in the coordinates of the mesh; none for a transform without an inverse.
fn into_mesh(placed: &Placed<'_>) -> Option<impl Fn(Bounds) -> Bounds + Sync + use<>> {
    let moved = placed.transform != Affine::IDENTITY;
    let inverse = if moved { inverse(&placed.transform)? } else { Affine::IDENTITY };
    Some(move |region: Bounds| {
        if !moved {
            return region;
        }
        let near = region.transformed(&inverse);
        near.grown(1e-12 * near.reach())
    })
}

fn inverse(map: &Affine) -> Option<Affine> {
    let determinant = map.determinant();
    if !map.is_invertible() {
        return None;
    }
    let cofactors = map.cofactors();
    let offset: Vec3 = map.rows.map(|row| row[3]);
    let rows = [0, 1, 2].map(|row| {
        let [x, y, z] = [0, 1, 2].map(|column: usize| cofactors[column][row] / determinant);
        [x, y, z, -dot([x, y, z], offset)]
    });
    Some(Affine { rows })
}

fn rounded_up(reach: f64) -> f64 {
    const REST: u64 = (1 << 49) - 1;
    f64::from_bits((reach.to_bits() + REST) & !REST)
}

fn frame(map: &Affine) -> Frame {
    let entries = map.rows.map(|row| [row[0], row[1], row[2]]);
    let largest = entries.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let scale = if largest > 0.0 { 1e9 / largest } else { 0.0 };
    let mut rounded = [0; 9];
    for (to, from) in rounded.iter_mut().zip(entries.as_flattened()) {
        *to = (from * scale).round() as i64;
    }
    (rounded, (largest as f32).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_goes_back() {
        let map = Affine::scaling([2.0, -0.5, 3.0])
            .then(&Affine::rotation([0.6, 0.0, 0.8], 37.0))
            .then(&Affine::translation([5.0, -7.0, 11.0]));
        let back = inverse(&map).expect("a regular map");
        for point in [[0.0; 3], [1.0, 2.0, 3.0], [-9.0, 0.5, 4.0]] {
            let again = back.point(map.point(point));
            assert!((0..3).all(|axis| (again[axis] - point[axis]).abs() < 1e-12), "{again:?}");
        }
        assert!(inverse(&Affine::scaling([1.0, 0.0, 1.0])).is_none());
    }
}
