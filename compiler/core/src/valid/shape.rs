//! Shapes: handles in range, transforms that keep a front a front, emission without negative light.

use crate::diag::{Finding, Origin};
use crate::ir::{Affine, Emission, Scene, Shape, Vec3};

use super::fits;

/// The bounds of something in its own coordinates: lowest and highest corner.
pub(super) type Bounds = [Vec3; 2];

/// Checks the shapes of the scene. `bounds` are those of the meshes; none for a mesh that has a finding of its own.
pub(super) fn check(scene: &Scene, bounds: &[Option<Bounds>], findings: &mut Vec<Finding>) {
    if scene.shapes.is_empty() && scene.instances.is_empty() {
        findings.push(
            Finding::error("invalid-scene", scene.origin.clone(), "the scene has no shape and no emitter")
                .help("add a shape: `shape floor = rectangle(...) with diffuse(0.5)`"),
        );
    }
    for (origin, shape) in scene.surfaces() {
        let Shape { name, mesh, transform, material, emission } = shape;
        let kind = if emission.is_some() { "emitter" } else { "shape" };
        let mut fault = |id, message: &str| {
            let message = format!("{kind} `{}`: {message}", name.escape_debug());
            findings.push(Finding::error(id, origin.clone(), message));
        };
        if mesh.index() >= scene.meshes.len() {
            fault("invalid-shape", "its mesh is not in the scene");
        }
        if material.index() >= scene.materials.len() {
            fault("invalid-shape", "its material is not in the scene");
        }
        if let Some(Emission { radiance }) = emission
            && !radiance.rgb().iter().all(|x| fits(*x) && *x >= 0.0)
        {
            fault("invalid-emission", "its radiance is negative, not finite, or beyond 1e30");
        }
        let bounds = bounds.get(mesh.index()).copied().flatten();
        transformed(kind, name, origin, transform, bounds, findings);
    }
}

/// Checks a transform of something with `bounds`.
pub(super) fn transformed(
    kind: &str,
    name: &str,
    origin: &Origin,
    transform: &Affine,
    bounds: Option<Bounds>,
    findings: &mut Vec<Finding>,
) {
    let mut fault = |message: &str, help: &str| {
        let message = format!("{kind} `{}`: {message}", name.escape_debug());
        findings.push(Finding::error("invalid-transform", origin.clone(), message).help(help));
    };
    if !transform.is_invertible() {
        fault("its transform cannot be inverted", "scale by numbers that are finite and not 0");
    } else if transform.determinant() < 0.0 {
        let help = "apply the mirroring to the vertices of the mesh and turn the winding of its triangles";
        fault("its transform mirrors, which would turn its front to the back", help);
    } else if let Some(bounds) = bounds {
        let fits = |point: Vec3| point.iter().all(|x| (*x as f32).is_finite());
        if !corners(bounds, transform).into_iter().all(fits) {
            fault("its transform moves it out of the range of single precision", "scale the scene down");
        }
    }
}

/// Where a map takes the corners of a box: the extremes of what lies in the box are among them.
pub(super) fn corners(bounds: Bounds, map: &Affine) -> [Vec3; 8] {
    [0_usize, 1, 2, 3, 4, 5, 6, 7].map(|i| map.point([0, 1, 2].map(|axis| bounds[i >> axis & 1][axis])))
}
