//! Shapes: handles in range, transforms that keep a front a front, emission without negative light.

use crate::diag::Finding;
use crate::ir::{Emission, Scene, Shape};
use crate::mesh::bounds;

use super::fits;
use super::mesh::is_readable;

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    if scene.shapes.is_empty() {
        findings.push(
            Finding::error("invalid-scene", scene.origin.clone(), "the scene has no shape and no emitter")
                .help("add a shape: `shape floor = rectangle(...) with diffuse(0.5)`"),
        );
    }
    // The bounds of each mesh, computed once; none for a mesh that has a finding of its own.
    let bounds: Vec<_> =
        scene.meshes.values().map(|mesh| if is_readable(mesh) { bounds(mesh.into()) } else { None }).collect();
    for (handle, Shape { name, mesh, transform, material, emission }) in scene.shapes.iter() {
        let kind = if emission.is_some() { "emitter" } else { "shape" };
        let mut fault = |id, message: &str, help: Option<&str>| {
            let message = format!("{kind} `{}`: {message}", name.escape_debug());
            let finding = Finding::error(id, scene.shapes.origin(handle).clone(), message);
            findings.push(finding.maybe_help(help.map(str::to_owned)));
        };
        if mesh.index() >= scene.meshes.len() {
            fault("invalid-shape", "its mesh is not in the scene", None);
        }
        if material.index() >= scene.materials.len() {
            fault("invalid-shape", "its material is not in the scene", None);
        }
        if !transform.is_invertible() {
            let help = "scale by numbers that are finite and not 0";
            fault("invalid-transform", "its transform cannot be inverted", Some(help));
        } else if transform.determinant() < 0.0 {
            let help = "apply the mirroring to the vertices of the mesh and turn the winding of its triangles";
            fault("invalid-transform", "its transform mirrors, which would turn its front to the back", Some(help));
        } else if let Some(Some(bounds)) = bounds.get(mesh.index()) {
            // An affine map takes the box around the mesh to a body whose extremes are at the box's corners.
            let corners = (0..8_usize).map(|i| [0, 1, 2].map(|axis| bounds[i >> axis & 1][axis]));
            let fits = |point: [f64; 3]| transform.point(point).iter().all(|x| (*x as f32).is_finite());
            if !corners.into_iter().all(fits) {
                let help = "scale the scene down";
                fault("invalid-transform", "its transform moves it out of the range of single precision", Some(help));
            }
        }
        if let Some(Emission { radiance }) = emission
            && !radiance.rgb().iter().all(|x| fits(*x) && *x >= 0.0)
        {
            fault("invalid-emission", "its radiance is negative, not finite, or beyond 1e30", None);
        }
    }
}
