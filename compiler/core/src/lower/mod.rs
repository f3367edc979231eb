//! Scene to Scene: what is simplified before any target sees the scene.
//!
//! One pass per file. No pass changes what is seen: the triangles in scene space, their order within a shape, their
//! fronts, materials and emissions stay as they are. A scene that is not valid passes through unharmed.

mod bake;
mod instances;
mod merge;
mod normals;

use crate::diag::Finding;
use crate::ir::{Group, Handle, Scene};

/// A step of [`lower`].
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// The name of its file.
    pub name: &'static str,
    /// What it does, in one sentence.
    pub summary: &'static str,
    /// Runs it; what it changed comes back as findings.
    pub run: fn(Scene) -> (Scene, Vec<Finding>),
}

/// All passes in their order: normals first, because baking moves them; instances before baking, because they say how often
/// a mesh is used; merging last, because it sees what is equal then.
pub static PASSES: &[Pass] = &[normals::PASS, instances::PASS, bake::PASS, merge::PASS];

/// Runs all passes in their order; what they changed comes back as findings.
pub fn lower(scene: Scene) -> (Scene, Vec<Finding>) {
    // Passes follow handles. A broken one is for validation to report.
    if !is_sound(&scene) {
        return (scene, Vec::new());
    }
    let mut findings = Vec::new();
    let scene = PASSES.iter().fold(scene, |scene, pass| {
        let (scene, found) = (pass.run)(scene);
        findings.extend(found);
        scene
    });
    (scene, findings)
}

/// Whether all handles point into their arenas, and groups only to those before them.
fn is_sound(scene: &Scene) -> bool {
    let shapes = scene
        .surfaces()
        .all(|(_, shape)| shape.mesh.index() < scene.meshes.len() && shape.material.index() < scene.materials.len());
    let textures = scene
        .materials
        .values()
        .filter_map(|material| material.bsdf.texture())
        .all(|texture| texture.index() < scene.textures.len());
    let count = scene.groups.len();
    let outer = scene.instances.values().all(|instance| instance.group.index() < count);
    let inner = |(handle, group): (Handle<Group>, &Group)| {
        group.instances.values().all(|instance| instance.group.index() < handle.index())
    };
    shapes && textures && outer && scene.groups.iter().all(inner)
}

#[cfg(test)]
mod tests;
