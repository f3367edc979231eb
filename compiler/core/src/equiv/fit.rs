//! Whether two uses are the same triangles, and how they lie on each other.

use std::collections::HashMap;

use super::body::{Bodies, Corners, Use, between};
use super::fact::Measure;
use super::near::{Spot, pairs};
use crate::ir::{Affine, Handle, Mesh, length, sub};
use crate::survey::Bounds;

/// How the surfaces of two uses lie on each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fit {
    /// B's front is A's back.
    pub turned: bool,
    /// Their shading normals differ.
    pub normals: bool,
    /// Their texture coordinates differ.
    pub uvs: bool,
}

impl Fit {
    /// Both together.
    pub fn and(self, other: Self) -> Self {
        Self { turned: self.turned || other.turned, normals: self.normals || other.normals, uvs: self.uvs || other.uvs }
    }
}

/// How triangle B lies on triangle A: which of its corners is A's first, and whether they go round the other way.
#[derive(Clone, Copy, Debug)]
struct Laid {
    first: usize,
    turned: bool,
}

impl Laid {
    /// The corner of B that lies on corner `at` of A.
    fn corner(self, at: usize) -> usize {
        if self.turned { (self.first + 3 - at) % 3 } else { (self.first + at) % 3 }
    }
}

fn laid(a: &Corners, b: &Corners, within: f64) -> Option<Laid> {
    let ways = [false, true].into_iter().flat_map(|turned| (0..3).map(move |first| Laid { first, turned }));
    ways.into_iter().find(|way| (0..3).all(|at| length(sub(a.at[at], b.at[way.corner(at)])) <= within))
}

/// Fits of meshes that are known: for each pair of meshes the ways in which one lies on the other.
#[derive(Debug, Default)]
struct Known(HashMap<(Handle<Mesh>, Handle<Mesh>), Vec<Way>>);

/// How one mesh lies on another, and whether that is a fit.
type Way = (Affine, Option<Fit>);

/// Ways that are kept for a pair of meshes.
const WAYS: usize = 32;

/// Lays uses of two scenes on each other.
#[derive(Debug)]
pub struct Fitter<'s> {
    /// The scenes.
    pub sides: [&'s Bodies<'s>; 2],
    /// How near is near.
    pub measure: Measure,
    known: Known,
}

impl<'s> Fitter<'s> {
    /// For A and B.
    pub fn new(sides: [&'s Bodies<'s>; 2], measure: Measure) -> Self {
        Self { sides, measure, known: Known::default() }
    }

    /// How far a corner of what lies on `one` may be from it.
    pub fn within(&self, one: &Use<'_>) -> f64 {
        self.measure.distance(one.bounds().reach())
    }

    /// How two uses lie on each other; none where they are not the same triangles.
    pub fn fit(&mut self, a: &Use<'s>, b: &Use<'s>) -> Option<Fit> {
        let within = self.within(a);
        if a.count != b.count || !self.same_sums(a, b, within) {
            return None;
        }
        let meshes = (a.placed.shape.mesh, b.placed.shape.mesh);
        let (from, to) = (a.placed.transform, b.placed.transform);
        let corners = self.sides[0].boxes[meshes.0.index()].map(Bounds::corners).unwrap_or_default();
        let again = |way: &Affine| {
            corners.iter().all(|corner| length(sub(from.point(*corner), to.point(way.point(*corner)))) <= 0.1 * within)
        };
        let ways = self.known.0.entry(meshes).or_default();
        if let Some((_, fit)) = ways.iter().find(|(way, _)| again(way)) {
            return *fit;
        }
        let fit = self.compute(a, b, within);
        if let Some(way) = between(&from, &to) {
            let ways = self.known.0.entry(meshes).or_default();
            if ways.len() < WAYS {
                ways.push((way, fit));
            }
        }
        fit
    }

    /// Whether the sums agree that must where every corner lies within `within` of its partner.
    fn same_sums(&self, a: &Use<'_>, b: &Use<'_>, within: f64) -> bool {
        let most = 2.0 * within * (a.bounds().diagonal().max(b.bounds().diagonal()) + within);
        let near = a.spread.iter().flatten().zip(b.spread.iter().flatten()).all(|(a, b)| (a - b).abs() <= most);
        near && length(sub(a.mean, b.mean)) <= within
    }

    fn compute(&self, a: &Use<'s>, b: &Use<'s>, within: f64) -> Option<Fit> {
        let [ours, theirs] = self.sides;
        let (one, other): (Vec<_>, Vec<_>) = (ours.triangles(a).collect(), theirs.triangles(b).collect());
        let in_order: Option<Vec<Laid>> = one.iter().zip(&other).map(|(a, b)| laid(a, b, within)).collect();
        // Of two triangles on each other, a front and a back, the one that looks to the same side may stand elsewhere.
        let all: Vec<(usize, usize, Laid)> = match in_order.filter(|all| all.iter().all(|laid| !laid.turned)) {
            Some(all) => all.into_iter().enumerate().map(|(at, laid)| (at, at, laid)).collect(),
            None => matched(&one, &other, |_| within),
        };
        let each = || all.iter().map(|(at, to, laid)| self.triangle(a, &one[*at], b, &other[*to], *laid));
        (all.len() == one.len()).then(|| each().fold(Fit::default(), Fit::and))
    }

    /// How two triangles lie on each other.
    fn triangle(&self, a: &Use<'s>, one: &Corners, b: &Use<'s>, other: &Corners, laid: Laid) -> Fit {
        let [ours, theirs] = self.sides;
        let sign = if laid.turned { -1.0 } else { 1.0 };
        let (normals, towards) = (ours.normals(a, one), theirs.normals(b, other));
        let normals = (0..3).any(|at| !self.measure.normals(normals[at], towards[laid.corner(at)].map(|x| sign * x)));
        let (uvs, others) = (ours.uvs(a, one), theirs.uvs(b, other));
        let uvs = (0..3).any(|at| (0..2).any(|axis| !self.same_uv(&uvs, &others, laid, at, axis)));
        Fit { turned: laid.turned, normals, uvs }
    }

    /// Whether texture coordinates are the same but for whole images, by which they may differ.
    fn same_uv(&self, a: &[[f64; 2]; 3], b: &[[f64; 2]; 3], laid: Laid, at: usize, axis: usize) -> bool {
        let apart = |at: usize| a[at][axis] - b[laid.corner(at)][axis];
        (apart(at) - apart(0).round()).abs() <= 10.0 * self.measure.share
    }

    /// Triangles of uses of A and of B that lie on each other, each with the use that it belongs to, and how these do.
    pub fn triangles(&self, a: &[(&Use<'s>, Corners)], b: &[(&Use<'s>, Corners)]) -> Vec<(usize, usize, Fit)> {
        let only = |all: &[(&Use<'s>, Corners)]| -> Vec<Corners> { all.iter().map(|(_, corners)| *corners).collect() };
        let all = matched(&only(a), &only(b), |at| self.within(a[at].0));
        let fit =
            |(at, to, laid): (usize, usize, Laid)| (at, to, self.triangle(a[at].0, &a[at].1, b[to].0, &b[to].1, laid));
        all.into_iter().map(fit).collect()
    }
}

/// Pairs of triangles that lie on each other; those that look to the same side first.
fn matched(a: &[Corners], b: &[Corners], within: impl Fn(usize) -> f64) -> Vec<(usize, usize, Laid)> {
    let spots = |all: &[Corners], ours: bool| -> Vec<Spot> {
        let spot = |(at, corners): (usize, &Corners)| Spot {
            at: corners.middle(),
            reach: if ours { within(at) } else { 0.0 },
        };
        all.iter().enumerate().map(spot).collect()
    };
    let grade = |at: usize, to: usize| laid(&a[at], &b[to], within(at)).map(|laid| u32::from(laid.turned));
    let pairs = pairs(&spots(a, true), &spots(b, false), grade);
    pairs.into_iter().filter_map(|(at, to)| Some((at, to, laid(&a[at], &b[to], within(at))?))).collect()
}
