//! Shapes and instances: what is used once is a shape, what is used many times a group.

use std::collections::BTreeMap;

use super::at;
use super::surface::Surfaces;
use crate::diag::Origin;
use crate::import::Builder;
use crate::import::reader::Reader;
use crate::ir::{Affine, Arena, Group, Handle, Mesh, Shape};
use crate::mesh::file::gltf::Use;
use crate::mesh::file::{Model, Part};

/// What makes uses of meshes the same: meshes and surfaces of their parts.
type Key = Vec<(usize, Option<usize>)>;

/// A group at all places of a node.
struct Placed<'n> {
    group: Handle<Group>,
    name: &'n str,
    places: Vec<Affine>,
    node: usize,
    here: Origin,
}

/// Adds all parts of a model. `of_ltsc` says that a mesh of several primitives is a group, as ltsc writes it.
pub fn add(
    model: Model,
    uses: &[Use],
    mut surfaces: Surfaces<'_>,
    of_ltsc: bool,
    reader: &mut Reader<'_>,
    to: &mut Builder,
) {
    let Model { meshes, surfaces: _, parts } = model;
    // A mesh without a name takes that of its first part.
    let mut first = vec![""; meshes.len()];
    parts.iter().rev().for_each(|part| first[part.mesh] = &part.name);
    let path = surfaces.path().clone();
    let mut made: Vec<Option<Handle<Mesh>>> = Vec::with_capacity(meshes.len());
    for ((name, geometry), first) in meshes.into_iter().zip(&first) {
        let name = if name.is_empty() { (*first).to_owned() } else { name };
        made.push(to.mesh(reader, &name, geometry, &at(&path, "/meshes".to_owned())));
    }
    // The parts of each use of a mesh, and how often each mesh is used.
    let mut all: Vec<(Use, Vec<&Part>)> = Vec::new();
    for (part, own) in parts.iter().zip(uses) {
        match all.last_mut() {
            Some((last, parts)) if last == own => parts.push(part),
            _ => all.push((*own, vec![part])),
        }
    }
    let mut count: BTreeMap<usize, usize> = BTreeMap::new();
    for mesh in all.iter().filter_map(|(own, _)| own.mesh) {
        *count.entry(mesh).or_default() += 1;
    }
    let mut groups: BTreeMap<Key, Option<Handle<Group>>> = BTreeMap::new();
    let mut at_once: Vec<Placed<'_>> = Vec::new();
    for (index, (own, parts)) in all.iter().enumerate() {
        let here = at(&path, format!("/nodes/{}", own.node));
        let Some(head) = parts.first() else { continue };
        let next = all.get(index + 1).is_some_and(|(next, _)| next.node == own.node);
        let many = own.copy > 0 || next;
        let often = own.mesh.is_some_and(|mesh| count.get(&mesh).is_some_and(|count| *count > 1));
        let grouped = own.mesh.is_some() && (many || parts.len() > 1 && (often || of_ltsc));
        if !grouped {
            for part in parts {
                let Some(mesh) = made[part.mesh] else { continue };
                let shape = shape(part, mesh, part.transform, &mut surfaces, reader, to);
                to.shape(reader, shape, &here);
            }
            continue;
        }
        let key: Key = parts.iter().map(|part| (part.mesh, part.surface)).collect();
        let known = groups.get(&key).copied();
        let group = known.unwrap_or_else(|| {
            let mut shapes = Arena::default();
            for part in parts {
                let Some(mesh) = made[part.mesh] else { continue };
                let shape = shape(part, mesh, Affine::IDENTITY, &mut surfaces, reader, to);
                to.shape_in(reader, &mut shapes, shape, &here);
            }
            let group = (!shapes.is_empty()).then(|| to.group(&head.name, shapes, &here));
            groups.insert(key, group);
            group
        });
        let Some(group) = group else { continue };
        match at_once.last_mut() {
            Some(last) if many && last.group == group && last.node == own.node => last.places.push(head.transform),
            _ if many => {
                let places = vec![head.transform];
                at_once.push(Placed { group, name: &head.name, places, node: own.node, here });
            }
            _ => to.instance(reader, &head.name, group, head.transform, &here),
        }
    }
    for Placed { group, name, places, node: _, here } in at_once {
        to.instances(reader, name, group, places, &here);
    }
}

fn shape(
    part: &Part,
    mesh: Handle<Mesh>,
    transform: Affine,
    surfaces: &mut Surfaces<'_>,
    reader: &mut Reader<'_>,
    to: &mut Builder,
) -> Shape {
    let laid = to.mesh_of(mesh).uvs.is_some();
    let (material, emission) = surfaces.get(part.surface, laid, reader, to);
    Shape { name: part.name.clone(), mesh, transform, material, emission }
}
