//! Where surfaces of a scene lie in or next to one another: faces that are parallel, close, and one over the other.
//!
//! Lines along which surfaces meet are no contacts: boxes on floors, walls in corners, plates that cross. Only areas count.

mod hash;
mod overlap;
mod search;
mod tree;

pub use overlap::Overlap;

use crate::ir::{Bsdf, Vec3};
use crate::survey::{Placed, Survey};

/// The distance below which renderers mistake one surface for another: 2e-4 (1 + largest coordinate), `reach` being that
/// coordinate. Mitsuba 0.x passes over hits nearer than 1e-4 of it, Mitsuba 3 starts rays 8.94e-5 (1 + reach) off the surface;
/// glass over a diffuse floor was wrong at a distance of a third of this and right at three times this, in both.
pub fn nearness(reach: f64) -> f64 {
    2e-4 * (1.0 + reach)
}

/// The distance below which surfaces lie in one plane: what rounding to single precision makes of equal numbers, with room for a
/// transform. It grows with the coordinates and nothing else: a scene in other units has the same contacts.
pub fn coplanarity(reach: f64) -> f64 {
    4e-6 * reach
}

/// Two uses of shapes with faces close to each other, or one whose own faces are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The places of both in [`Survey::placed`], the lower first; equal for faces of one shape.
    pub uses: [usize; 2],
    /// Faces that look the same way.
    pub same: Overlap,
    /// Faces that look at or away from each other.
    pub opposite: Overlap,
    /// The distance within which faces were near.
    pub nearness: f64,
}

/// The contacts of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// In the order of [`Survey::placed`].
    pub found: Vec<Contact>,
    /// How many pairs of shapes were left out because the work would have taken too long.
    pub left_out: usize,
    /// Whether still more were left out, and not counted.
    pub uncounted: bool,
}

impl Contacts {
    /// Finds the contacts that can matter: of a dielectric or an emitter with anything within [`nearness`], and of others within
    /// [`coplanarity`]; where those have one material, if one of the two has at most 256 triangles. A dielectric is also held against itself, for
    /// walls that are too thin.
    ///
    /// Time is near-linear in the number of uses and triangles where few boxes of uses overlap; a pair of meshes at the same
    /// places relative to each other is looked at once.
    pub fn of(survey: &Survey<'_>) -> Self {
        search::Search::of(survey).run()
    }
}

/// A place where faces of two uses look the same way and lie over each other: its middle, and the direction in which both look.
pub type Place = (Vec3, Vec3);

/// The places where two uses lie in one plane and look the same way, the first of them where there are very many.
pub fn places(survey: &Survey<'_>, uses: [usize; 2]) -> Vec<Place> {
    const TRIED: usize = 1 << 24;
    const FOUND: usize = 1 << 12;
    let [one, other] = uses.map(|at| &survey.placed[at]);
    let near = coplanarity(one.bounds.reach().min(other.bounds.reach()));
    let Some(common) = one.bounds.grown(near).common(other.bounds.grown(near)) else { return Vec::new() };
    let [first, second] = [one, other].map(|placed| {
        let triangles = survey.triangles(placed).filter_map(overlap::Triangle::of);
        triangles.filter(|triangle| triangle.bounds.grown(near).touches(common)).collect::<Vec<_>>()
    });
    let within = overlap::Distances { near, coplanar: near };
    let pairs = first.iter().flat_map(|one| second.iter().map(move |other| (one, other)));
    pairs.take(TRIED).filter_map(|(one, other)| overlap::place(one, other, within)).take(FOUND).collect()
}

/// What a surface is to a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It emits light.
    Emitter,
    /// Light passes through it.
    Dielectric,
    /// Neither.
    Opaque,
}

/// What a use of a shape is to a contact; a material that is not in the scene is opaque.
pub fn role(survey: &Survey<'_>, placed: &Placed<'_>) -> Role {
    let materials = &survey.scene.materials;
    if placed.shape.emission.is_some() {
        return Role::Emitter;
    }
    if placed.shape.material.index() < materials.len()
        && let Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } = &materials[placed.shape.material].bsdf
    {
        return Role::Dielectric;
    }
    Role::Opaque
}

#[cfg(test)]
mod tests;
