//! Meshes without normals get those of their faces.
//!
//! Renderers disagree on what a mesh without normals means: some shade it flat, some compute smooth normals. Flat is what
//! the triangles themselves say.

use super::Pass;
use crate::diag::{Finding, Severity};
use crate::ir::{Mesh, Scene};
use crate::mesh::{Geometry, faceted};

pub(super) const PASS: Pass = Pass { name: "normals", summary: "meshes without normals get those of their faces", run };

fn run(mut scene: Scene) -> (Scene, Vec<Finding>) {
    let mut changed = Vec::new();
    for (handle, mesh) in scene.meshes.iter_mut() {
        let Mesh { name, positions: _, normals, uvs: _, triangles: _ } = &*mesh;
        if normals.is_some() {
            continue;
        }
        // A mesh with indices out of range, or without any area, is for validation and lint to report.
        let Ok((geometry, dropped)) = faceted(Geometry::from_mesh(mesh)) else { continue };
        if geometry.triangles.is_empty() {
            continue;
        }
        *mesh = geometry.into_mesh(name.clone());
        changed.push((handle, dropped));
    }
    let findings = changed.into_iter().map(|(handle, dropped)| {
        let name = scene.meshes[handle].name.escape_debug();
        let message = format!("mesh `{name}` has no normals: every triangle gets its own");
        let finding = Finding::new("loss-baked", Severity::Info, scene.meshes.origin(handle).clone(), message);
        match dropped {
            0 => finding,
            _ => finding.note(format!("{dropped} triangles without area have no normal and are left out")),
        }
    });
    let findings = findings.collect();
    (scene, findings)
}
