//! Names: something to print, and unique where people address things by them.

use std::collections::BTreeMap;

use crate::diag::{Finding, Origin};
use crate::ir::{Arena, LightSource, Scene, Shape};

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    printable("scene", &scene.name, &scene.origin, findings);
    for (handle, material) in scene.materials.iter() {
        printable("material", &material.name, scene.materials.origin(handle), findings);
    }
    for (handle, mesh) in scene.meshes.iter() {
        printable("mesh", &mesh.name, scene.meshes.origin(handle), findings);
    }
    surfaces(&scene.shapes, &scene.lights, findings);
    for (origin, group) in scene.groups.entries() {
        printable("group", &group.name, origin, findings);
        surfaces(&group.shapes, &Arena::default(), findings);
    }
    let mut instances = BTreeMap::new();
    for (origin, instance) in scene.instances.entries() {
        printable("instance", &instance.name, origin, findings);
        unique("instance", &instance.name, origin, &mut instances, findings);
    }
    let mut cameras = BTreeMap::new();
    for (handle, camera) in scene.cameras.iter() {
        let origin = scene.cameras.origin(handle);
        match &camera.name {
            Some(name) => {
                printable("camera", name, origin, findings);
                unique("camera", name, origin, &mut cameras, findings);
            }
            None if scene.cameras.len() > 1 => findings.push(
                Finding::error("invalid-name", origin.clone(), "one of several cameras has no name")
                    .help("name every camera"),
            ),
            None => {}
        }
    }
}

/// Shapes and emitters have a space of names each; lights without a surface are emitters.
fn surfaces(shapes: &Arena<Shape>, lights: &Arena<LightSource>, findings: &mut Vec<Finding>) {
    let mut taken = [BTreeMap::new(), BTreeMap::new()];
    for (origin, shape) in shapes.entries() {
        let emits = shape.emission.is_some();
        let kind = if emits { "emitter" } else { "shape" };
        printable(kind, &shape.name, origin, findings);
        unique(kind, &shape.name, origin, &mut taken[usize::from(emits)], findings);
    }
    for (origin, light) in lights.entries() {
        printable("emitter", &light.name, origin, findings);
        unique("emitter", &light.name, origin, &mut taken[1], findings);
    }
}

fn printable(kind: &str, name: &str, origin: &Origin, findings: &mut Vec<Finding>) {
    if name.is_empty() {
        findings.push(Finding::error("invalid-name", origin.clone(), format!("the {kind} has an empty name")));
    } else if name.chars().any(char::is_control) {
        let message = format!("the name of the {kind} `{}` contains a control character", name.escape_debug());
        findings.push(Finding::error("invalid-name", origin.clone(), message));
    }
}

fn unique<'a>(
    kind: &str,
    name: &'a str,
    origin: &'a Origin,
    taken: &mut BTreeMap<&'a str, &'a Origin>,
    findings: &mut Vec<Finding>,
) {
    if let Some(first) = taken.insert(name, origin) {
        let message = format!("two {kind}s are called `{}`", name.escape_debug());
        let mut finding = Finding::error("invalid-name", origin.clone(), message).help("rename one of them");
        if let Some(span) = first.span() {
            finding = finding.also(span, "the other one");
        }
        findings.push(finding);
    }
}
