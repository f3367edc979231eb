//! Whether two scenes mean the same, whatever they were written in: what a renderer would make of them, not names, order or groups.
//!
//! Surfaces are found again by where they lie in the scene: neither the order of vertices, triangles and shapes nor the groups that
//! place them matter, nor how triangles are shared out among shapes. Then what the found ones are made of is compared, what they emit
//! and to which side, and beside them cameras, lights and settings. Work grows with the number of triangles, not with its square.
//!
//! | file | what it does |
//! |---|---|
//! | `report` | differences, each kept once with all its places |
//! | `fact` | single facts of two things, and how near is near |
//! | `look` | materials and emission as facts |
//! | `settings` | cameras, film, integrator, sampler, and losses of reading |
//! | `light` | lights without a surface |
//! | `near` | pairs of what lies at one place |
//! | `body` | meshes and their uses in sums that move with them |
//! | `fit` | whether two uses are the same triangles |
//! | `surface` | uses of one scene found again in the other |
//! | `rest` | those that are not: tessellated otherwise, moved, only in one |

mod body;
mod fact;
mod fit;
mod light;
mod look;
mod near;
mod report;
mod rest;
mod settings;
mod surface;
#[cfg(test)]
mod tests;

use crate::diag::Finding;
use crate::ir::Scene;
use crate::survey::Survey;

pub use report::{Difference, Kind, Place};

use fact::Measure;
use report::Report;

/// What counts as equal by default: numbers and colors to this share, places to this share of the scene's size.
pub const TOLERANCE: f64 = 1e-4;

/// A scene, and what its reader could not put into it.
#[derive(Clone, Copy, Debug)]
pub struct Side<'s> {
    /// The scene; its handles must be valid.
    pub scene: &'s Scene,
    /// What was found when it was read. Those that say that something was left out or is only near (`loss-dropped`,
    /// `loss-approximated`) are differences where the other scene does not have them too.
    pub findings: &'s [Finding],
}

/// What came of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// All differences: settings first, then lights, then surfaces.
    pub differences: Vec<Difference>,
    /// Uses of shapes in A and in B: a shape in a group counts once for each place.
    pub surfaces: [usize; 2],
    /// How many of A's were found again in B as a whole or in parts.
    pub found: usize,
}

impl Comparison {
    /// Whether there is no difference.
    pub fn equal(&self) -> bool {
        self.differences.is_empty()
    }
}

/// Compares two scenes; A is the reference. `tolerance` is a share: of numbers and of channels of colors (of the brightest channel),
/// of angles in radians, and for places of the size of the scene, or of the largest coordinate of the surface where that is
/// smaller. Normals may differ by ten times as much.
pub fn compare(a: Side<'_>, b: Side<'_>, tolerance: f64) -> Comparison {
    let surveys = [Survey::of(a.scene), Survey::of(b.scene)];
    let size = surveys.iter().find_map(|survey| survey.bounds).map_or(1.0, |bounds| bounds.diagonal());
    let measure = Measure { share: tolerance, size };
    let mut report = Report::default();
    settings::compare(a, b, &surveys, measure, &mut report);
    light::compare(a.scene, b.scene, measure, &mut report);
    let found = surface::compare(&surveys, measure, &mut report);
    let [one, other] = &surveys;
    Comparison { differences: report.finish(), surfaces: [one.placed.len(), other.placed.len()], found }
}
