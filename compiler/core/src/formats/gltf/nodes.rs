//! Nodes of shapes, instances and lights, and the meshes and materials that they share.

use std::collections::BTreeMap;

use super::buffer::{Layout, Place};
use super::document as doc;
use super::{names, surface};
use crate::formats::shared::camera;
use crate::ir::{Affine, Emission as Light, Group, Handle, LightKind, LightSource, Mesh, Scene, Shape, Vec3, sub};

/// A material, what it emits, and for dielectrics how thick the mesh is; floats by their bits, for the order.
type Surface = (usize, Option<[u64; 3]>, u64);

/// What was made so far, each thing once.
#[derive(Default)]
pub struct Made<'a> {
    pub layout: Layout<'a>,
    places: BTreeMap<usize, Place>,
    pub materials: Vec<doc::Material>,
    known_materials: BTreeMap<Surface, usize>,
    pub meshes: Vec<doc::Mesh>,
    known_meshes: BTreeMap<(usize, usize), usize>,
    known_groups: BTreeMap<usize, usize>,
    /// Uses of meshes and groups whose vertices were moved, because no node can hold their map.
    pub moved: usize,
}

impl<'a> Made<'a> {
    /// The node of a shape.
    pub fn node(&mut self, scene: &'a Scene, shape: &Shape) -> doc::Node {
        let Shape { name, mesh: handle, transform, material: _, emission: _ } = shape;
        let mut node = doc::Node { name: name.clone(), ..doc::Node::default() };
        let mesh = &scene.meshes[*handle];
        // A node's matrix must be translation, rotation and scale (glTF 2.0, 3.5.2); other maps move the vertices.
        if camera::has_orthogonal_columns(transform) {
            let material = self.material(scene, shape, &Affine::IDENTITY);
            let known = self.known_meshes.get(&(handle.index(), material)).copied();
            node.mesh = Some(known.unwrap_or_else(|| {
                let primitive = self.primitive(scene, *handle, &Affine::IDENTITY, material);
                let made = self.mesh(&mesh.name, vec![primitive]);
                self.known_meshes.insert((handle.index(), material), made);
                made
            }));
            place(&mut node, transform);
        } else {
            self.moved += 1;
            let (inner, outer) = about(transform, middle([(mesh, Affine::IDENTITY)]));
            let material = self.material(scene, shape, &inner);
            let primitive = self.primitive(scene, *handle, &inner, material);
            node.mesh = Some(self.mesh(&mesh.name, vec![primitive]));
            place(&mut node, &outer);
        }
        node
    }

    /// A group is a mesh with a primitive for each shape: a node of its own for each would have to be repeated in every
    /// instance, because a node has one parent.
    pub fn instance(&mut self, scene: &'a Scene, name: &str, group: Handle<Group>, transform: &Affine) -> doc::Node {
        let mut node = doc::Node { name: name.to_owned(), ..doc::Node::default() };
        if camera::has_orthogonal_columns(transform) {
            let known = self.known_groups.get(&group.index()).copied();
            node.mesh = Some(known.unwrap_or_else(|| {
                let made = self.group(scene, group, &Affine::IDENTITY);
                self.known_groups.insert(group.index(), made);
                made
            }));
            place(&mut node, transform);
        } else {
            self.moved += 1;
            let Group { name: _, shapes, instances: _ } = &scene.groups[group];
            let parts = shapes.values().map(|shape| (&scene.meshes[shape.mesh], shape.transform));
            let (inner, outer) = about(transform, middle(parts));
            node.mesh = Some(self.group(scene, group, &inner));
            place(&mut node, &outer);
        }
        node
    }

    fn group(&mut self, scene: &'a Scene, handle: Handle<Group>, outer: &Affine) -> usize {
        let Group { name, shapes, instances: _ } = &scene.groups[handle];
        let mut primitives = Vec::new();
        for shape in shapes.values() {
            let Shape { name: _, mesh, transform, material: _, emission: _ } = shape;
            let map = transform.then(outer);
            let material = self.material(scene, shape, &map);
            primitives.push(self.primitive(scene, *mesh, &map, material));
        }
        self.mesh(name, primitives)
    }

    /// A mesh whose vertices are moved; those that are not moved are written once.
    fn primitive(&mut self, scene: &'a Scene, mesh: Handle<Mesh>, map: &Affine, material: usize) -> doc::Primitive {
        let moved = *map != Affine::IDENTITY;
        let known = if moved { None } else { self.places.get(&mesh.index()).copied() };
        let Place { attributes, indices } = known.unwrap_or_else(|| {
            let place = self.layout.mesh(&scene.meshes[mesh], moved.then_some(*map));
            if !moved {
                self.places.insert(mesh.index(), place);
            }
            place
        });
        doc::Primitive { attributes, indices, material }
    }

    fn mesh(&mut self, name: &str, primitives: Vec<doc::Primitive>) -> usize {
        self.meshes.push(doc::Mesh { name: name.to_owned(), primitives });
        self.meshes.len() - 1
    }

    /// The material of a shape whose vertices are moved by `map`: another one for each thickness, which is the mesh's.
    fn material(&mut self, scene: &'a Scene, shape: &Shape, map: &Affine) -> usize {
        let Shape { name: _, mesh, transform: _, material, emission } = shape;
        let own = &scene.materials[*material];
        let thickness = surface::thickness(&own.bsdf, &scene.meshes[*mesh], map);
        let surface: Surface = (material.index(), bits(emission.as_ref()), thickness.to_bits());
        if let Some(known) = self.known_materials.get(&surface) {
            return *known;
        }
        self.materials.push(surface::material(scene, own, emission.as_ref(), thickness));
        let index = self.materials.len() - 1;
        self.known_materials.insert(surface, index);
        index
    }
}

/// The middle of what meshes fill at their places.
fn middle<'m>(parts: impl IntoIterator<Item = (&'m Mesh, Affine)>) -> Vec3 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (mesh, map) in parts {
        for position in mesh.positions.iter() {
            let point = map.point(position.map(f64::from));
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
    }
    let middle = [0, 1, 2].map(|axis| (low[axis] + high[axis]) / 2.0);
    if middle.iter().all(|x| x.is_finite()) { middle } else { [0.0; 3] }
}

/// A map as one that moves vertices and one that places them: vertices round to single precision, so that they are moved about
/// `middle`, where they are as exact as the mesh is small, and the node takes them to their place in double precision.
fn about(map: &Affine, middle: Vec3) -> (Affine, Affine) {
    let there = map.point(middle);
    let linear = Affine { rows: map.rows.map(|[x, y, z, _]| [x, y, z, 0.0]) };
    let inner = Affine::translation(middle.map(|x| -x)).then(&linear);
    (inner, Affine::translation(there))
}

/// Gives a node its place.
fn place(node: &mut doc::Node, transform: &Affine) {
    let Affine { rows } = transform;
    let offset = rows.map(|row| row[3] + 0.0);
    if *transform == Affine::translation(offset) {
        node.translation = (offset != [0.0; 3]).then_some(offset);
    } else {
        node.matrix = Some(names::matrix(transform));
    }
}

fn bits(emission: Option<&Light>) -> Option<[u64; 3]> {
    emission.map(|Light { radiance }| radiance.rgb().map(f64::to_bits))
}

/// A light of KHR_lights_punctual and its node; none for an environment, which that extension has not.
pub fn light(source: &LightSource) -> Option<(doc::Light, doc::Node)> {
    let LightSource { name, kind } = source;
    let mut node = doc::Node { name: name.clone(), ..doc::Node::default() };
    let mut spot = None;
    let kind_name = match kind {
        LightKind::Environment { radiance: _, tint: _, turn: _ } => return None,
        LightKind::Point { position, intensity: _ } => {
            place(&mut node, &Affine::translation(*position));
            "point"
        }
        LightKind::Spot { position, target, intensity: _, angle, inner } => {
            place(&mut node, &names::aim(sub(*target, *position)).then(&Affine::translation(*position)));
            let (inner_cone_angle, outer_cone_angle) = names::cone(*angle, *inner);
            spot = Some(doc::Spot { inner_cone_angle, outer_cone_angle });
            "spot"
        }
        LightKind::Directional { direction, irradiance: _ } => {
            place(&mut node, &names::aim(*direction));
            "directional"
        }
    };
    let (color, intensity) = names::strength(kind.color());
    Some((doc::Light { name: name.clone(), r#type: kind_name, color, intensity, spot }, node))
}
