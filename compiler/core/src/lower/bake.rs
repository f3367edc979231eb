//! Transforms are applied to the vertices where a mesh has one use, and everywhere where they mirror.
//!
//! A mesh that is used several times is written once, and each use keeps its transform. A mirroring transform would turn
//! the front of a surface to its back in renderers that derive the side from the winding, so it always gives an own copy
//! of the mesh with the winding turned.

use std::sync::Arc;

use super::Pass;
use crate::diag::{Finding, Severity};
use crate::ir::{Affine, Mesh, Scene, Shape};
use crate::mesh::{transform_normals, transform_positions};

pub(super) const PASS: Pass =
    Pass { name: "bake", summary: "transforms are applied to the vertices of meshes with one use", run };

fn run(mut scene: Scene) -> (Scene, Vec<Finding>) {
    let mut uses = vec![0_usize; scene.meshes.len()];
    for (_, shape) in scene.surfaces() {
        uses[shape.mesh.index()] += 1;
    }
    // First the mirrored uses of shared meshes: what remains may then be a single use.
    let mut copied = 0;
    let mut meshes = std::mem::take(&mut scene.meshes);
    for shape in scene.surfaces_mut() {
        let Shape { name: _, mesh, transform, material: _, emission: _ } = shape;
        if uses[mesh.index()] == 1 || transform.determinant() >= 0.0 {
            continue;
        }
        // What cannot be baked (no inverse, beyond single precision) stays as it is, for validation to report.
        let Some(baked) = baked(&meshes[*mesh], transform) else { continue };
        let origin = meshes.origin(*mesh).clone();
        uses[mesh.index()] -= 1;
        uses.push(1);
        *mesh = meshes.push(baked, origin);
        *transform = Affine::IDENTITY;
        copied += 1;
    }
    let mut moved = 0;
    for shape in scene.surfaces_mut() {
        let Shape { name: _, mesh, transform, material: _, emission: _ } = shape;
        if uses[mesh.index()] > 1 || *transform == Affine::IDENTITY {
            continue;
        }
        let Some(baked) = baked(&meshes[*mesh], transform) else { continue };
        meshes[*mesh] = baked;
        *transform = Affine::IDENTITY;
        moved += 1;
    }
    scene.meshes = meshes;
    let mut findings = Vec::new();
    let mut say = |message: String| {
        findings.push(Finding::new("loss-baked", Severity::Info, scene.origin.clone(), message));
    };
    if moved > 0 {
        say(format!("the transforms of {moved} shapes are applied to the vertices of their meshes"));
    }
    if copied > 0 {
        say(format!("{copied} mirrored uses of shared meshes become meshes of their own"));
    }
    (scene, findings)
}

fn baked(mesh: &Mesh, map: &Affine) -> Option<Mesh> {
    let Mesh { name, positions, normals, uvs, triangles } = mesh;
    if !map.is_invertible() {
        return None;
    }
    let triangles = if map.determinant() < 0.0 {
        Arc::new(triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect())
    } else {
        Arc::clone(triangles)
    };
    Some(Mesh {
        name: name.clone(),
        positions: Arc::new(transform_positions(positions, map).ok()?),
        normals: normals.as_ref().map(|normals| Arc::new(transform_normals(normals, map))),
        uvs: uvs.clone(),
        triangles,
    })
}
