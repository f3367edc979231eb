//! Groups and instances: handles in range, one level, no emitters within, nothing empty.

use crate::diag::Finding;
use crate::ir::{GROUP_DEPTH, Group, INSTANCE_LIMIT, Instance, Scene, Shape};

use super::shape::{Bounds, corners, transformed};

pub(super) fn check(scene: &Scene, bounds: &[Option<Bounds>], findings: &mut Vec<Finding>) {
    let mut extents = Vec::new();
    for (handle, group) in scene.groups.iter() {
        let Group { name, shapes, instances } = group;
        let mut fault = |message: &str, note: Option<String>| {
            let message = format!("group `{}`: {message}", name.escape_debug());
            let finding = Finding::error("invalid-group", scene.groups.origin(handle).clone(), message);
            findings.push(note.into_iter().fold(finding, Finding::note));
        };
        if !instances.is_empty() {
            let limits = format!(
                "at most {INSTANCE_LIMIT} shapes and instances are written, of groups at most {GROUP_DEPTH} deep"
            );
            fault("it holds instances that could not be multiplied out", Some(limits));
        } else if shapes.is_empty() {
            fault("it is empty", None);
        } else if shapes.values().any(|shape| shape.emission.is_some()) {
            fault("it holds an emitter, which no target can place by instances", None);
        }
        extents.push(extent(shapes.values(), bounds));
    }
    for (origin, instance) in scene.instances.entries() {
        let Instance { name: _, group, places: _ } = instance;
        let Some(extent) = extents.get(group.index()) else {
            let message = format!("instance `{}`: its group is not in the scene", instance.name.escape_debug());
            findings.push(Finding::error("invalid-group", origin.clone(), message));
            continue;
        };
        // One of many places says enough: what is wrong with a thousand is the same.
        let before = findings.len();
        for (name, transform) in instance.named() {
            transformed("instance", &name, origin, transform, *extent, findings);
            if findings.len() > before {
                break;
            }
        }
    }
}

/// A box around shapes; none where one of their meshes has none.
fn extent<'a>(shapes: impl Iterator<Item = &'a Shape>, bounds: &[Option<Bounds>]) -> Option<Bounds> {
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for shape in shapes {
        let Shape { name: _, mesh, transform, material: _, emission: _ } = shape;
        for corner in corners(bounds.get(mesh.index()).copied().flatten()?, transform) {
            for axis in 0..3 {
                all[0][axis] = all[0][axis].min(corner[axis]);
                all[1][axis] = all[1][axis].max(corner[axis]);
            }
        }
    }
    Some(all)
}
