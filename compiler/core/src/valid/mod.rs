//! What every emitter may rely on.
//!
//! A [`Valid`] scene has at least one shape or instance and one camera, a name, and handles that point into its arenas. Its meshes have
//! triangles, indices in range, finite numbers and unit normals where they have any. Its textures have pixels, and meshes
//! under them have texture coordinates. Its groups hold shapes only, none of which
//! emits. At most one of its lights is an environment. Its materials, lights, cameras and
//! settings lie in the ranges that [`crate::ir`] documents. One file per entity; each function adds all it finds.

mod camera;
mod group;
mod light;
mod material;
mod mesh;
mod names;
mod settings;
mod shape;
mod texture;

use std::ops::Deref;

use crate::diag::Finding;
use crate::ir::Scene;
use crate::mesh::bounds;
use mesh::is_readable;

/// The largest number that is written. Renderers compute in single precision, which ends at 3.4e38: this leaves room for
/// sums and small products.
const LARGEST: f64 = 1e30;

/// Whether renderers can compute with `x`.
fn fits(x: f64) -> bool {
    x.abs() <= LARGEST
}

/// A scene that has been checked; the only way to one is [`validate`].
#[derive(Clone, Debug)]
pub struct Valid(Scene);

impl Deref for Valid {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.0
    }
}

impl Valid {
    /// The scene itself, to be changed and validated again.
    pub fn into_inner(self) -> Scene {
        self.0
    }

    /// Lets it be rendered with other samples, at least one, and another seed, which makes no scene invalid.
    pub fn set_sampling(&mut self, samples: u32, seed: u32) {
        self.0.sampler = self.0.sampler.with(samples.max(1), seed);
    }
}

/// Checks everything an emitter relies on; all findings, not the first.
///
/// # Errors
/// Findings of severity `Error` (`invalid-...`: the scene is malformed).
pub fn validate(scene: Scene) -> Result<Valid, Vec<Finding>> {
    let mut findings = Vec::new();
    names::check(&scene, &mut findings);
    mesh::check(&scene, &mut findings);
    texture::check(&scene, &mut findings);
    material::check(&scene, &mut findings);
    // The bounds of each mesh, computed once; none for a mesh that has a finding of its own.
    let bounds: Vec<_> =
        scene.meshes.values().map(|mesh| if is_readable(mesh) { bounds(mesh.into()) } else { None }).collect();
    shape::check(&scene, &bounds, &mut findings);
    group::check(&scene, &bounds, &mut findings);
    light::check(&scene, &mut findings);
    camera::check(&scene, &mut findings);
    settings::check(&scene, &mut findings);
    if findings.is_empty() { Ok(Valid(scene)) } else { Err(findings) }
}

#[cfg(test)]
mod tests;
