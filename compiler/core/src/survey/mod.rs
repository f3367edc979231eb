//! What a scene holds, and where: every use of a shape at its place, boxes around things, what a camera sees.
//!
//! Lint rules and statistics look at a scene through a [`Survey`]; it is made once for each scene and costs time linear in the
//! number of uses. Meshes are not copied: a use is a shape and the map from its mesh to the scene.

mod bounds;
mod frustum;
mod inside;
mod seen;

pub use bounds::Bounds;
pub use frustum::{Frustum, Span};
pub use inside::{faces_against, whole, winding};
pub use seen::{Seen, Thing};

use crate::diag::Origin;
use crate::ir::{Affine, Arena, Instance, Scene, Shape, Vec3};

/// The most uses of shapes that are looked at one by one; a scene with more is surveyed up to here.
pub const PLACED_LIMIT: usize = 2_000_000;

/// How deep groups are followed; validation allows no deeper ones.
const DEPTH: usize = crate::ir::GROUP_DEPTH;

/// One use of a shape: itself, or as a part of a group that an instance places.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'s> {
    /// The shape.
    pub shape: &'s Shape,
    /// Where the shape is written.
    pub origin: &'s Origin,
    /// The outermost instance that places it, if one does, where that is written, and which of its places this is.
    pub instance: Option<(&'s Instance, &'s Origin, usize)>,
    /// From the coordinates of its mesh to those of the scene.
    pub transform: Affine,
    /// A box around it in the scene.
    pub bounds: Bounds,
}

impl Placed<'_> {
    /// The name, with that of the instance: `cell[0,1,2]/back`.
    pub fn name(&self) -> String {
        match self.instance {
            Some((instance, _, at)) => format!("{}/{}", instance.name_of(at), self.shape.name),
            None => self.shape.name.clone(),
        }
    }
}

/// A scene as it lies in space.
#[derive(Debug)]
pub struct Survey<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// Every use of a shape: first the scene's own in their order, then those of the instances.
    pub placed: Vec<Placed<'s>>,
    /// Whether there are more uses than [`PLACED_LIMIT`], so that some are missing.
    pub cut: bool,
    /// The box around each mesh in its own coordinates; none for a mesh without vertices.
    pub meshes: Vec<Option<Bounds>>,
    /// A box around everything; none for an empty scene.
    pub bounds: Option<Bounds>,
}

impl<'s> Survey<'s> {
    /// Surveys a scene. Handles that point nowhere are passed over: validation reports them.
    pub fn of(scene: &'s Scene) -> Self {
        let meshes = scene.meshes.values().map(|mesh| Bounds::of_points(mesh.positions.iter().copied())).collect();
        let mut survey = Self { scene, placed: Vec::new(), cut: false, meshes, bounds: None };
        survey.shapes(&scene.shapes, &Affine::IDENTITY, None);
        survey.instances(&scene.instances, &Affine::IDENTITY, None, 0);
        for placed in &survey.placed {
            survey.bounds = Some(survey.bounds.map_or(placed.bounds, |all| all.union(placed.bounds)));
        }
        survey
    }

    /// The corners of the triangles of a use, in the scene's coordinates and in the order of its mesh. Triangles with an index
    /// out of range are passed over.
    pub fn triangles(&self, placed: &Placed<'s>) -> impl Iterator<Item = [Vec3; 3]> + use<'_, 's> {
        let mesh = &self.scene.meshes[placed.shape.mesh];
        let transform = placed.transform;
        let whole = |triangle: &&[u32; 3]| triangle.iter().all(|index| (*index as usize) < mesh.positions.len());
        let mirrored = transform.determinant() < 0.0;
        mesh.triangles.iter().filter(whole).map(move |triangle| {
            let [a, b, c] = mesh.corners(*triangle).map(|corner| transform.point(corner));
            // A mirroring map turns the winding: the front stays the front.
            if mirrored { [a, c, b] } else { [a, b, c] }
        })
    }

    fn shapes(
        &mut self,
        shapes: &'s Arena<Shape>,
        outer: &Affine,
        instance: Option<(&'s Instance, &'s Origin, usize)>,
    ) {
        for (origin, shape) in shapes.entries() {
            if self.placed.len() == PLACED_LIMIT {
                self.cut = true;
                return;
            }
            let transform = shape.transform.then(outer);
            let Some(own) = self.meshes.get(shape.mesh.index()).copied().flatten() else { continue };
            self.placed.push(Placed { shape, origin, instance, transform, bounds: own.transformed(&transform) });
        }
    }

    fn instances(
        &mut self,
        instances: &'s Arena<Instance>,
        outer: &Affine,
        outermost: Option<(&'s Instance, &'s Origin, usize)>,
        depth: usize,
    ) {
        for (origin, instance) in instances.entries() {
            if depth == DEPTH || instance.group.index() >= self.scene.groups.len() {
                return;
            }
            let group = &self.scene.groups[instance.group];
            for (at, place) in instance.places.maps().iter().enumerate() {
                if self.cut {
                    return;
                }
                let transform = place.then(outer);
                let outermost = outermost.or(Some((instance, origin, at)));
                self.shapes(&group.shapes, &transform, outermost);
                self.instances(&group.instances, &transform, outermost, depth + 1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;

    #[test]
    fn every_use_is_found_at_its_place() {
        let scene = sample::room();
        let survey = Survey::of(&scene);
        assert_eq!(survey.placed.len(), scene.shapes.len());
        let all = survey.bounds.expect("a box");
        for placed in &survey.placed {
            for corner in survey.triangles(placed).flatten() {
                assert!(placed.bounds.grown(1e-9).contains(corner) && all.grown(1e-9).contains(corner));
            }
        }
    }
}
