//! Meshes: arrays that belong together, finite numbers, unit normals. Missing normals are a question of portability, not
//! of validity.

use std::fmt::Display;

use crate::diag::Finding;
use crate::ir::{Mesh, Scene};
use crate::mesh::{face_normal, is_unit};

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    for (handle, mesh) in scene.meshes.iter() {
        faults(mesh, |message, help: Option<&str>| {
            let message = format!("mesh `{}`: {message}", mesh.name.escape_debug());
            let finding = Finding::error("invalid-mesh", scene.meshes.origin(handle).clone(), message);
            findings.push(finding.maybe_help(help.map(str::to_owned)));
        });
    }
}

/// Whether the indices of the mesh are in range; other checks may then read its corners.
pub(super) fn is_readable(mesh: &Mesh) -> bool {
    mesh.triangles.iter().flatten().all(|index| (*index as usize) < mesh.positions.len())
}

fn faults(mesh: &Mesh, mut add: impl FnMut(String, Option<&str>)) {
    let Mesh { name: _, positions, normals, uvs, triangles } = mesh;
    let count = positions.len();
    if triangles.is_empty() {
        add("it has no triangles".to_owned(), Some("remove the shapes that use it"));
    }
    if u32::try_from(count).is_err() {
        add(format!("{count} vertices are more than 32-bit indices can address"), Some("split the mesh"));
    }
    if let Some(message) = all(positions, "position", "is not finite", |p| p.iter().all(|x| x.is_finite())) {
        add(message, None);
    }
    if !is_readable(mesh) {
        let inside = |triangle: &[u32; 3]| triangle.iter().all(|index| (*index as usize) < count);
        if let Some(message) = all(triangles, "triangle", "uses a vertex that is not there", inside) {
            add(format!("{message} (there are {count})"), None);
        }
    }
    if !triangles.is_empty() && is_readable(mesh) {
        let flat = |triangle: &[u32; 3]| face_normal(mesh.corners(*triangle)).is_none();
        if triangles.iter().all(flat) {
            let help = "scale the scene, or move it nearer to the origin";
            add("all its triangles have no area in single precision".to_owned(), Some(help));
        }
    }
    if let Some(normals) = normals {
        length("normals", normals.len(), count, &mut add);
        if let Some(message) = all(normals, "normal", "is not of unit length", |normal| is_unit(*normal)) {
            add(message, Some("normalize the normals, or leave them out"));
        }
    }
    if let Some(uvs) = uvs {
        length("texture coordinates", uvs.len(), count, &mut add);
        let finite = |uv: &[f32; 2]| uv.iter().all(|x| x.is_finite());
        if let Some(message) = all(uvs, "texture coordinate", "is not finite", finite) {
            add(message, None);
        }
    }
}

fn length(what: &str, found: usize, expected: usize, add: &mut impl FnMut(String, Option<&str>)) {
    if found != expected {
        add(format!("it has {expected} positions but {found} {what}"), None);
    }
}

/// A message on the first item that fails and the number of others, if any fails.
fn all<T>(items: &[T], what: impl Display, fault: &str, holds: impl Fn(&T) -> bool) -> Option<String> {
    let first = items.iter().position(|item| !holds(item))?;
    let others = items[first + 1..].iter().filter(|item| !holds(item)).count();
    Some(match others {
        0 => format!("{what} {first} {fault}"),
        _ => format!("{what} {first} {fault}, and {others} more"),
    })
}
