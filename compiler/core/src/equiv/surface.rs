//! Uses of shapes of one scene found again in the other, and what they are made of and emit.

use std::collections::HashMap;

use super::body::{Bodies, Corners, Use};
use super::fact::{Measure, point, shown};
use super::fit::{Fit, Fitter};
use super::look::{self, Images, Rows};
use super::near::{Spot, pairs};
use super::report::{Kind, Place, Report};
use super::rest;
use crate::ir::{Handle, Material, Scene, cross, normalized, sub};
use crate::survey::{PLACED_LIMIT, Survey};

/// Compares all surfaces; how many of A's were found again.
pub fn compare(surveys: &[Survey<'_>; 2], measure: Measure, report: &mut Report) -> usize {
    if surveys.iter().any(|survey| survey.cut) {
        let words = |survey: &Survey<'_>| {
            if survey.cut { format!("more than {PLACED_LIMIT}") } else { survey.placed.len().to_string() }
        };
        let what = "uses of shapes, of which the first are compared";
        report.add(Kind::Surface, what, [words(&surveys[0]), words(&surveys[1])], [None, None]);
    }
    let sides = [Bodies::of(&surveys[0]), Bodies::of(&surveys[1])];
    let mut fitter = Fitter::new([&sides[0], &sides[1]], measure);
    let mut looks = Looks::of(surveys[0].scene, surveys[1].scene, measure);
    let (a, b) = (&sides[0].uses, &sides[1].uses);
    let ours: Vec<Spot> = a.iter().map(|one| Spot { at: one.mean, reach: fitter.within(one) }).collect();
    let theirs: Vec<Spot> = b.iter().map(|one| Spot { at: one.mean, reach: 0.0 }).collect();
    let mut fits: HashMap<(usize, usize), Fit> = HashMap::new();
    // Of several surfaces in one place the ones that look alike belong together.
    let found = pairs(&ours, &theirs, |at, to| {
        let fit = fitter.fit(&a[at], &b[to])?;
        fits.insert((at, to), fit);
        Some(2 * u32::from(fit.turned) + u32::from(!looks.same(&a[at], &b[to], fit)))
    });
    let mut left = [vec![true; a.len()], vec![true; b.len()]];
    for &(at, to) in &found {
        (left[0][at], left[1][to]) = (false, false);
        looks.compare(&fitter, &a[at], &b[to], fits[&(at, to)], report);
    }
    let open = |side: usize| (0..left[side].len()).filter(|at| left[side][*at]).collect::<Vec<usize>>();
    found.len() + rest::compare(&fitter, [open(0), open(1)], &mut looks, report)
}

/// Where a use is written, and what it is called.
pub fn place(one: &Use<'_>) -> Option<Place> {
    Some(Place { name: one.placed.name(), origin: one.placed.origin.clone() })
}

/// What surfaces are made of; each pair of materials is compared once.
#[derive(Debug)]
pub struct Looks<'s> {
    scenes: [&'s Scene; 2],
    measure: Measure,
    images: Images<'s>,
    known: HashMap<(Handle<Material>, Handle<Material>, bool), Rows>,
}

impl<'s> Looks<'s> {
    /// Those of A and B.
    pub fn of(a: &'s Scene, b: &'s Scene, measure: Measure) -> Self {
        Self { scenes: [a, b], measure, images: Images::of(a, b, measure), known: HashMap::new() }
    }

    fn material(&self, side: usize, one: &Use<'_>) -> &'s Material {
        &self.scenes[side].materials[one.placed.shape.material]
    }

    fn rows(&mut self, a: &Use<'_>, b: &Use<'_>, turned: bool) -> &Rows {
        let (one, other) = (self.material(0, a), self.material(1, b));
        let key = (a.placed.shape.material, b.placed.shape.material, turned);
        let (images, measure) = (&mut self.images, self.measure);
        self.known.entry(key).or_insert_with(|| look::materials(one, other, turned, images, measure))
    }

    /// Whether two uses look the same.
    fn same(&mut self, a: &Use<'_>, b: &Use<'_>, fit: Fit) -> bool {
        let lit = [a, b].map(|one| look::radiance(one.placed.shape.emission.as_ref()));
        let light = match lit {
            [Some(a), Some(b)] => self.measure.colors(a, b),
            [None, None] => true,
            [Some(_), None] | [None, Some(_)] => false,
        };
        light && self.rows(a, b, fit.turned).is_empty()
    }

    /// Adds what differs of two uses that lie at one place.
    pub fn compare(&mut self, fitter: &Fitter<'_>, a: &Use<'_>, b: &Use<'_>, fit: Fit, report: &mut Report) {
        let mut add = |kind, what: &str, words| report.add(kind, what, words, [place(a), place(b)]);
        let fronts = || [(0, a), (1, b)].map(|(side, one)| front(fitter.sides[side], one));
        match [a, b].map(|one| look::radiance(one.placed.shape.emission.as_ref())) {
            [None, None] => {}
            [Some(radiance), None] => add(Kind::Emission, "radiance", [shown(radiance), "none".to_owned()]),
            [None, Some(radiance)] => add(Kind::Emission, "radiance", ["none".to_owned(), shown(radiance)]),
            [Some(one), Some(other)] => {
                if !self.measure.colors(one, other) {
                    add(Kind::Emission, "radiance", [shown(one), shown(other)]);
                }
                if fit.turned {
                    add(Kind::Emission, "side", fronts().map(|front| format!("towards {front}")));
                }
            }
        }
        let has_sides = |material: &Material| material.bsdf.is_clear() || material.is_one_sided();
        let turned = fit.turned && has_sides(self.material(0, a)) && has_sides(self.material(1, b));
        let clear = self.material(0, a).bsdf.is_clear();
        if clear && turned && !self.rows(a, b, true).is_empty() && self.rows(a, b, false).is_empty() {
            add(Kind::Material, "dielectric side of the inside", fronts().map(|front| format!("behind {front}")));
        } else {
            for (what, words) in self.rows(a, b, turned) {
                add(Kind::Material, what, words.clone());
            }
        }
        if fit.normals {
            let words = [(0, a), (1, b)].map(|(side, one)| {
                let given = fitter.sides[side].mesh(one.placed.shape.mesh).normals.is_some();
                if given { "as given" } else { "none, so that it is flat" }.to_owned()
            });
            add(Kind::Surface, "shading normals", words);
        }
        let painted = self.material(0, a).bsdf.texture().is_some() || self.material(1, b).bsdf.texture().is_some();
        if fit.uvs && painted {
            let words = [(0, a), (1, b)].map(|(side, one)| {
                let given = fitter.sides[side].mesh(one.placed.shape.mesh).uvs.is_some();
                if given { "as given" } else { "none" }.to_owned()
            });
            add(Kind::Surface, "texture coordinates", words);
        }
    }
}

/// The direction that the first triangle of a use looks to, in words.
fn front(side: &Bodies<'_>, one: &Use<'_>) -> String {
    let first = side.triangles(one).next();
    let normal = first.and_then(|Corners { indices: _, at: [a, b, c] }| normalized(cross(sub(b, a), sub(c, a))));
    point(normal.unwrap_or([0.0; 3]).map(|x| (x * 1e4).round() / 1e4))
}
