//! Polygons of mesh files, cut into triangles.
//!
//! | polygon | its triangles |
//! |---|---|
//! | convex | a fan around its first corner, or another one where that would have no area |
//! | of 4 corners | by the diagonal that lies inside |
//! | other | a constrained Delaunay triangulation in the plane of two axes that it fills best |
//! | that crosses itself, or has no area | a fan |
//!
//! All corners stay in use, so that meshes that were closed still are; only corners at the place of others may fall away.

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeMap;

use super::{FileError, Note, plural};
use crate::ir::{Vec3, cross, dot, sub};

/// How far a polygon may be out of its plane, as a share of its size, before that is said.
const FLAT: f64 = 1e-3;

/// How much of its area a polygon may lose by rounding.
const SAME: f64 = 1e-9;

/// Faces on their way to triangles.
#[derive(Default)]
pub(super) struct Faces {
    pub triangles: Vec<[u32; 3]>,
    /// Where among the triangles polygons lie, as fans around their first corners.
    polygons: Vec<Run>,
    /// Faces of fewer than three corners, and where the first one is.
    small: u64,
    first_small: Option<String>,
}

/// Polygons of the same number of corners, one after the other.
struct Run {
    first: usize,
    corners: usize,
    count: usize,
}

impl Run {
    /// One past their triangles.
    fn end(&self) -> usize {
        self.first + self.count * (self.corners - 2)
    }
}

/// What was made of faces.
pub(super) struct Cut {
    pub triangles: Vec<[u32; 3]>,
    /// How many triangles fell away before each place, in order.
    gone: Vec<(usize, usize)>,
}

impl Cut {
    /// Where among the triangles that lies which was at `at` in [`Faces::triangles`]: the beginning of a face, or the end.
    pub fn place(&self, at: usize) -> usize {
        match self.gone.partition_point(|(from, _)| *from <= at) {
            0 => at,
            after => at - self.gone[after - 1].1,
        }
    }
}

/// What is to be said of polygons.
#[derive(Default)]
struct Told {
    cut: u64,
    /// Out of their plane, and by how much at most, as a share of the size.
    bent: u64,
    most: f64,
    /// Crossing themselves, and a corner of the first.
    crossing: u64,
    first: [f32; 3],
}

impl Faces {
    /// Adds a face. Polygons are a fan around their first corner until [`Faces::finish`].
    pub fn push(&mut self, corners: &[u32], place: impl FnOnce() -> String) {
        match corners {
            [a, b, c] => self.triangles.push([*a, *b, *c]),
            [] | [_] | [_, _] => {
                self.small += 1;
                self.first_small.get_or_insert_with(place);
            }
            [first, rest @ ..] => {
                let at = self.triangles.len();
                match self.polygons.last_mut() {
                    Some(run) if run.corners == corners.len() && run.end() == at => run.count += 1,
                    _ => self.polygons.push(Run { first: at, corners: corners.len(), count: 1 }),
                }
                self.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
        }
    }

    /// The triangles over corners, where `position` says where a corner lies; what was changed is added to `notes`.
    ///
    /// # Errors
    /// No triangles.
    pub fn finish(self, position: impl Fn(u32) -> [f32; 3], notes: &mut Vec<Note>) -> Result<Cut, FileError> {
        let Self { triangles, polygons, small, first_small } = self;
        if let Some(place) = first_small {
            notes.push(Note::dropped(place, "with fewer than 3 corners left out").counting(small, "face"));
        }
        let mut told = Told::default();
        let cut = cut(triangles, &polygons, &position, &mut told);
        told.say(notes);
        if cut.triangles.is_empty() {
            return Err(FileError::new("", "the file has no triangles")
                .help("a mesh needs faces; points and lines cannot be used"));
        }
        Ok(cut)
    }
}

impl Told {
    fn say(&self, notes: &mut Vec<Note>) {
        if self.cut > 0 {
            notes.push(Note::baked("", "with more than 3 corners cut into triangles").counting(self.cut, "face"));
        }
        if self.bent > 0 {
            let message = format!(
                "{} not flat, by up to {:.1} % of the size: the cut into triangles decides the shape",
                plural(self.bent, "face"),
                self.most * 100.0
            );
            notes.push(Note::approximated("", message));
        }
        if self.crossing > 0 {
            let [x, y, z] = self.first;
            let note =
                Note::warn(format!("at ({x}, {y}, {z})"), "crossing itself cut as a fan around the first corner");
            notes.push(note.counting(self.crossing, "face").help("repair the mesh in the program that made the file"));
        }
    }
}

/// How one polygon is cut.
enum Way {
    /// As the fan that it is.
    Fan,
    /// In [`Room::made`].
    Made,
}

/// Cuts polygons in place, since no polygon has more triangles than its fan.
fn cut(mut triangles: Vec<[u32; 3]>, polygons: &[Run], position: &impl Fn(u32) -> [f32; 3], told: &mut Told) -> Cut {
    let mut room = Room::default();
    let mut gone = Vec::new();
    let (mut read, mut write) = (0, 0);
    for run in polygons {
        told.cut += run.count as u64;
        shift(&mut triangles, read..run.first, &mut write);
        read = run.first;
        let size = run.corners - 2;
        for _ in 0..run.count {
            let way = match triangles[read..read + size] {
                [[a, b, c], [_, _, d]] => room.quad([a, b, c, d], position, told),
                ref fan => {
                    room.corners.clear();
                    room.corners.extend_from_slice(&fan[0][..2]);
                    room.corners.extend(fan.iter().map(|triangle| triangle[2]));
                    room.cut(position, told)
                }
            };
            match way {
                Way::Fan => shift(&mut triangles, read..read + size, &mut write),
                Way::Made => {
                    let made = &room.made[..room.made.len().min(size)];
                    triangles[write..write + made.len()].copy_from_slice(made);
                    write += made.len();
                }
            }
            read += size;
            if gone.last().map_or(0, |(_, before)| *before) != read - write {
                gone.push((read, read - write));
            }
        }
    }
    let end = triangles.len();
    shift(&mut triangles, read..end, &mut write);
    triangles.truncate(write);
    Cut { triangles, gone }
}

/// Moves a range down to `write`, and `write` behind it.
fn shift(triangles: &mut [[u32; 3]], range: std::ops::Range<usize>, write: &mut usize) {
    let length = range.len();
    if range.start != *write {
        triangles.copy_within(range, *write);
    }
    *write += length;
}

/// Room for one polygon.
#[derive(Default)]
struct Room {
    corners: Vec<u32>,
    points: Vec<Vec3>,
    flat: Vec<[f64; 2]>,
    turns: Vec<f64>,
    made: Vec<[u32; 3]>,
}

impl Room {
    /// A polygon of more than four corners.
    fn cut(&mut self, position: &impl Fn(u32) -> [f32; 3], told: &mut Told) -> Way {
        self.points.clear();
        self.points.extend(self.corners.iter().map(|corner| position(*corner).map(f64::from)));
        let Some(normal) = self.flatten() else { return Way::Fan };
        self.measure(normal, told);
        if let Some(apex) = self.fan() {
            if apex == 0 {
                return Way::Fan;
            }
            let count = self.corners.len();
            let corner = |at: usize| self.corners[(apex + at) % count];
            self.made.clear();
            self.made.extend((1..count - 1).map(|at| [corner(0), corner(at), corner(at + 1)]));
            return Way::Made;
        }
        if self.delaunay(normal) {
            return Way::Made;
        }
        told.cross(position(self.corners[0]));
        Way::Fan
    }

    /// A polygon of four corners, nearly always convex.
    #[inline]
    fn quad(&mut self, corners: [u32; 4], position: &impl Fn(u32) -> [f32; 3], told: &mut Told) -> Way {
        let [p, q, r, s] = corners.map(|corner| position(corner).map(f64::from));
        let (to_q, to_r, to_s) = (sub(q, p), sub(r, p), sub(s, p));
        let (one, two) = (cross(to_q, to_r), cross(to_r, to_s));
        let normal = [one[0] + two[0], one[1] + two[1], one[2] + two[2]];
        let across = sub(s, q);
        let size = dot(to_r, to_r).max(dot(across, across));
        // The distance of the diagonals.
        let off = dot(to_q, two);
        let (off, scale) = (off * off, dot(normal, normal) * size);
        if off > FLAT * FLAT * scale {
            told.bend((off / scale).sqrt());
        }
        let along = dot(one, two);
        if along > 0.0 {
            return Way::Fan;
        }
        let [a, b, c, d] = corners;
        // The other diagonal, from the second corner to the fourth.
        let (three, four) = (cross(sub(r, q), across), cross(across, sub(p, q)));
        let other = dot(three, four);
        self.made.clear();
        if other > 0.0 {
            self.made.extend([[b, c, d], [b, d, a]]);
            return Way::Made;
        }
        // Two corners at one place.
        if p == q || q == r {
            self.made.push([a, c, d]);
            return Way::Made;
        }
        if r == s || s == p {
            self.made.push([a, b, c]);
            return Way::Made;
        }
        if along < 0.0 && other < 0.0 {
            told.cross(position(a));
        }
        Way::Fan
    }

    /// Lays the points into the plane of two axes that the polygon fills best, where it runs counter-clockwise; gives its
    /// normal, which has twice its area as length. None for a polygon without area.
    fn flatten(&mut self) -> Option<Vec3> {
        let mut normal = [0.0; 3];
        let pole = self.points[0];
        for pair in self.points.windows(2) {
            let part = cross(sub(pair[0], pole), sub(pair[1], pole));
            for (sum, x) in normal.iter_mut().zip(part) {
                *sum += x;
            }
        }
        let axis = (0..3).max_by(|a: &usize, b: &usize| normal[*a].abs().total_cmp(&normal[*b].abs()))?;
        if !(normal[axis].abs() > 0.0 && normal[axis].is_finite()) {
            return None;
        }
        let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        self.flat.clear();
        // Adding 0 turns -0 to 0.
        self.flat.extend(self.points.iter().map(|point| [point[x] + 0.0, point[y] + 0.0]));
        Some(normal)
    }

    /// How far the points are out of the plane.
    fn measure(&self, normal: Vec3, told: &mut Told) {
        let square = dot(normal, normal);
        let count = self.points.len() as f64;
        let middle = [0, 1, 2].map(|axis| self.points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let (mut off, mut size) = (0.0_f64, 0.0_f64);
        for point in &self.points {
            let away = sub(*point, middle);
            off = off.max(dot(away, normal).abs());
            size = size.max(dot(away, away));
        }
        // From one side of the plane to the other, and across the polygon.
        let share = off / (square * size).sqrt();
        if share > FLAT {
            told.bend(share);
        }
    }

    /// The corner around which a fan has no triangle without area; none where the polygon is not convex.
    fn fan(&mut self) -> Option<usize> {
        let count = self.flat.len();
        self.turns.clear();
        let mut sides = 0;
        let mut last = 0.0;
        let mut first = 0.0;
        for at in 0..count {
            let [before, here, after] = [at + count - 1, at, at + 1].map(|at| self.flat[at % count]);
            let (to, from) = ([here[0] - before[0], here[1] - before[1]], [after[0] - here[0], after[1] - here[1]]);
            let turn = to[0] * from[1] - to[1] * from[0];
            // A turn of 0 may be one back.
            let on = turn > 0.0 || turn == 0.0 && to[0] * from[0] + to[1] * from[1] > 0.0;
            if !on {
                return None;
            }
            self.turns.push(turn);
            let x = from[0];
            if x != 0.0 {
                if first == 0.0 {
                    first = x;
                } else if (x > 0.0) != (last > 0.0) {
                    sides += 1;
                }
                last = x;
            }
        }
        sides += i32::from(first != 0.0 && (first > 0.0) != (last > 0.0));
        // More than once around is a star.
        if sides > 2 {
            return None;
        }
        (0..count).find(|at| self.turns[(at + 1) % count] > 0.0 && self.turns[(at + count - 1) % count] > 0.0)
    }

    /// Cuts any polygon that does not cross itself; it may touch itself, as those do that lead to a hole and back. `normal` is that of
    /// [`Room::flatten`].
    fn delaunay(&mut self, normal: Vec3) -> bool {
        // One vertex for each place, in the order in which they come.
        let key = |point: &[f64; 2]| point.map(f64::to_bits);
        let mut known = BTreeMap::new();
        let mut vertices = Vec::new();
        let mut first = Vec::new();
        let mut ring = Vec::new();
        for (at, point) in self.flat.iter().enumerate() {
            let vertex = *known.entry(key(point)).or_insert(vertices.len());
            if vertex == vertices.len() {
                vertices.push(Point2::new(point[0], point[1]));
                first.push(at);
            }
            if ring.last() != Some(&vertex) {
                ring.push(vertex);
            }
        }
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        let Ok(mut plane) = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(vertices, Vec::new()) else {
            return false;
        };
        if plane.num_vertices() != first.len() {
            return false;
        }
        let handles: Vec<_> = plane.fixed_vertices().collect();
        // How often an edge is walked from its lower to its higher end, less how often back.
        let mut walls: BTreeMap<(usize, usize), i32> = BTreeMap::new();
        for (at, from) in ring.iter().enumerate() {
            let to = ring[(at + 1) % ring.len()];
            let edges = plane.try_add_constraint(handles[*from], handles[to]);
            if edges.is_empty() {
                return false;
            }
            for edge in edges {
                let edge = plane.directed_edge(edge);
                let (from, to) = (edge.from().index(), edge.to().index());
                *walls.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        // How often the polygon runs around each face, from the outermost inwards.
        let mut around: Vec<Option<i32>> = vec![None; plane.num_all_faces()];
        let mut open = vec![plane.outer_face().fix()];
        around[plane.outer_face().index()] = Some(0);
        let mut edges_of = vec![Vec::new(); plane.num_all_faces()];
        for edge in plane.directed_edges() {
            edges_of[edge.face().index()].push(edge.fix());
        }
        while let Some(face) = open.pop() {
            let Some(times) = around[face.index()] else { continue };
            for edge in &edges_of[face.index()] {
                let edge = plane.directed_edge(*edge);
                let other = edge.rev().face();
                let (from, to) = (edge.from().index(), edge.to().index());
                let wall = walls.get(&(from.min(to), from.max(to))).copied().unwrap_or(0);
                // This face lies to the left of the edge: who leaves it over a wall that runs along goes out of the polygon.
                let along = if from < to { wall } else { -wall };
                if around[other.index()].is_none() {
                    around[other.index()] = Some(times - along);
                    open.push(other.fix());
                }
            }
        }
        self.made.clear();
        let (mut sum, mut size) = ([0.0; 3], 0.0);
        for face in plane.inner_faces() {
            let [a, b, c] = face.vertices().map(|vertex| first[vertex.index()]);
            let corners = match around[face.index()] {
                Some(1) => [a, b, c],
                // A loop that runs the other way around.
                Some(-1) => [a, c, b],
                Some(0) | None => continue,
                // It lies on itself.
                Some(_) => return false,
            };
            self.made.push(corners.map(|at| self.corners[at]));
            let [a, b, c] = corners.map(|at| self.points[at]);
            let twice = cross(sub(b, a), sub(c, a));
            size += dot(twice, twice).sqrt();
            for (sum, x) in sum.iter_mut().zip(twice) {
                *sum += x;
            }
        }
        // Of a polygon that is far from flat corners may coincide in the plane which do not in space.
        let off = sub(sum, normal);
        let same = dot(off, off).sqrt() <= SAME * size;
        same && !self.made.is_empty() && self.made.len() <= self.corners.len() - 2
    }
}

impl Told {
    #[cold]
    fn bend(&mut self, share: f64) {
        self.bent += 1;
        self.most = self.most.max(share);
    }

    #[cold]
    fn cross(&mut self, first: [f32; 3]) {
        if self.crossing == 0 {
            self.first = first;
        }
        self.crossing += 1;
    }
}

#[cfg(test)]
mod tests;
