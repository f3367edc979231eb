//! Shapes: meshes of files, and bodies with a formula.

use std::collections::HashMap;

use super::frame;
use super::plugin::Plugin;
use super::surface::{Made, Map, World};
use crate::diag::Origin;
use crate::import::Builder;
use crate::import::build::{Shading, Wanted};
use crate::import::color::Use;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Affine, Arena, Bsdf, Color, Group, Handle, Mesh, Shape, Sides, length, sub};
use crate::mesh::{self, Axis, Extent, Geometry, SignedAxis};

/// Segments around a sphere, a disk or a cylinder that becomes a mesh; rings of a sphere are half as many.
const SEGMENTS: u64 = 96;

/// What shapes of a scene share.
#[derive(Default)]
pub struct Shapes {
    /// Bodies with a formula that are there already, by what they are.
    bodies: HashMap<String, Handle<Mesh>>,
    /// Meshes whose texture coordinates were moved, by the mesh and the map.
    moved: HashMap<(usize, String), Handle<Mesh>>,
    /// Groups by their ids.
    groups: HashMap<String, Handle<Group>>,
    /// Materials that were read, by the place of their element.
    surfaces: HashMap<u32, Vec<(crate::diag::FileId, Made)>>,
}

/// A mesh at its place.
struct Body {
    mesh: Handle<Mesh>,
    transform: Affine,
    name: String,
}

impl Shapes {
    /// A shape of the scene.
    pub fn add<'e>(&mut self, plugin: Plugin<'e>, world: &World<'e>, reader: &mut Reader<'_>, to: &mut Builder) {
        match plugin.kind() {
            "shapegroup" => {
                // Read once, also where it is referred to before.
                let _group: Option<Handle<Group>> = self.group(plugin, world, reader, to);
            }
            "instance" => self.instance(plugin, world, reader, to),
            _ => {
                if let Some((shape, at)) = self.shape(plugin, world, reader, to) {
                    to.shape(reader, shape, &at);
                }
            }
        }
    }

    fn group<'e>(
        &mut self,
        plugin: Plugin<'e>,
        world: &World<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<Handle<Group>> {
        let id = plugin.id();
        if let Some(known) = self.groups.get(id) {
            return Some(*known);
        }
        let mut shapes = Arena::default();
        for inner in plugin.inner("shape") {
            if let Some((mut shape, at)) = self.shape(inner, world, reader, to) {
                if shape.emission.take().is_some() {
                    reader.lost(Fate::Dropped, inner.span(), "an emitter in a group of shapes does not emit");
                }
                to.shape_in(reader, &mut shapes, shape, &at);
            }
        }
        plugin.finish(reader);
        if shapes.is_empty() {
            reader.lost(Fate::Dropped, plugin.span(), "a group without shapes is left out");
            return None;
        }
        let at = Origin::from(plugin.span());
        let group = to.group(if id.is_empty() { "group" } else { id }, shapes, &at);
        self.groups.insert(id.to_owned(), group);
        Some(group)
    }

    fn instance<'e>(&mut self, plugin: Plugin<'e>, world: &World<'e>, reader: &mut Reader<'_>, to: &mut Builder) {
        let place = plugin.transform("to_world", reader);
        let reference = plugin.element.children.iter().find(|child| child.tag == "ref");
        let referred = match reference {
            Some(reference) => world.referred(reference, reader),
            None => plugin.inner("shape").next(),
        };
        let group = referred.filter(|group| group.kind() == "shapegroup");
        let group = group.and_then(|group| self.group(group, world, reader, to));
        let at = Origin::from(plugin.span());
        match group {
            Some(group) => {
                let id = plugin.id();
                to.instance(reader, if id.is_empty() { "instance" } else { id }, group, place, &at);
            }
            None => reader.lost(Fate::Dropped, plugin.span(), "an instance without its group is left out"),
        }
        plugin.finish(reader);
    }

    fn shape<'e>(
        &mut self,
        plugin: Plugin<'e>,
        world: &World<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<(Shape, Origin)> {
        let at = Origin::from(plugin.span());
        let body = self.body(plugin, world, reader, to);
        let radiance = self.radiance(plugin, world, reader, to);
        let (made, name) = self.material(plugin, radiance.is_some(), world, reader, to);
        for child in plugin.element.children.iter().filter(|child| {
            matches!(child.tag.as_str(), "medium" | "subsurface" | "sensor")
                || child.tag == "ref" && matches!(child.word("name"), "interior" | "exterior")
        }) {
            child.used.set(true);
            if child.tag != "sensor" {
                let message = "a medium is left out: light travels through nothing";
                reader.lost(Fate::Dropped, child.span, message);
            }
        }
        plugin.finish(reader);
        let Body { mut mesh, transform, name: of_mesh } = body?;
        let Made { bsdf, uv, two_sided } = made;
        let Some(bsdf) = bsdf.or_else(|| radiance.is_some().then(black)) else {
            // Light passes it as if it was not there.
            return None;
        };
        if bsdf.texture().is_some() {
            mesh = self.moved(mesh, uv.upright(), to);
            if to.mesh_of(mesh).uvs.is_none() {
                let message =
                    format!("the mesh of `{}` has no texture coordinates: its image is one color", shown(&of_mesh));
                reader.lost(Fate::Approximated, plugin.span(), message);
                mesh = to.changed(mesh, |geometry| Geometry {
                    uvs: Some(vec![[0.5; 2]; geometry.positions.len()]),
                    ..geometry
                });
            }
        }
        let material = to.material(
            if name.is_empty() { &of_mesh } else { &name },
            bsdf,
            if two_sided { Sides::Both } else { Sides::Front },
            &at,
        );
        let id = plugin.id();
        let name = if id.is_empty() { of_mesh } else { id.to_owned() };
        let emission = radiance.and_then(Builder::emission);
        Some((Shape { name, mesh, transform, material, emission }, at))
    }

    /// The material of a shape, and its name.
    fn material<'e>(
        &mut self,
        plugin: Plugin<'e>,
        lit: bool,
        world: &World<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> (Made, String) {
        let children = plugin.element.children.iter();
        let candidates = children.filter(|child| {
            child.tag == "bsdf" || child.tag == "ref" && !matches!(child.word("name"), "interior" | "exterior")
        });
        for child in candidates {
            let found = if child.tag == "ref" { world.referred(child, reader) } else { Some(Plugin::new(child)) };
            let Some(found) = found.filter(|found| found.element.tag == "bsdf") else { continue };
            let span = found.span();
            let known = self.surfaces.get(&span.start).and_then(|all| all.iter().find(|(file, _)| *file == span.file));
            let made = match known {
                Some((_, made)) => made.clone(),
                None => {
                    let made = world.surface(found, 0, reader, to);
                    self.surfaces.entry(span.start).or_default().push((span.file, made.clone()));
                    made
                }
            };
            return (made, found.id().to_owned());
        }
        // Mitsuba's own default: grey, and black under a light.
        let bsdf = if lit { black() } else { Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() } };
        (Made { bsdf: Some(bsdf), uv: Map::IDENTITY, two_sided: false }, "default".to_owned())
    }

    /// What a shape emits.
    fn radiance<'e>(
        &mut self,
        plugin: Plugin<'e>,
        world: &World<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<Color> {
        let mut emitters = plugin.inner("emitter");
        let emitter = emitters.next()?;
        if emitter.kind() != "area" {
            let message = format!("the emitter `{}` of a shape is not read", shown(emitter.kind()));
            reader.lost(Fate::Dropped, emitter.span(), message);
            return None;
        }
        emitter.pass(&["sampling_weight", "samples"]);
        let radiance = match emitter.find("radiance") {
            Some(found) if found.tag == "texture" => {
                let texture = Plugin::new(found);
                let handle = if texture.kind() == "bitmap" { world.bitmap(texture, reader, to) } else { None };
                let mean = handle.and_then(|(handle, _)| to.mean(handle));
                let message = "a light with an image emits its mean color everywhere";
                reader.lost(Fate::Approximated, found.span, message);
                Some(mean.map_or(Color::Grey(1.0), Color::Rgb))
            }
            _ => emitter.color("radiance", Use::Light, reader),
        };
        emitter.finish(reader);
        Some(radiance.unwrap_or(Color::Grey(1.0)))
    }

    /// A mesh with its texture coordinates moved, once for each map.
    fn moved(&mut self, mesh: Handle<Mesh>, map: Map, to: &mut Builder) -> Handle<Mesh> {
        if map == Map::IDENTITY || to.mesh_of(mesh).uvs.is_none() {
            return mesh;
        }
        *self.moved.entry((mesh.index(), format!("{map:?}"))).or_insert_with(|| {
            to.changed(mesh, |mut geometry| {
                geometry.uvs.iter_mut().flatten().for_each(|uv| *uv = map.apply(*uv));
                geometry
            })
        })
    }

    fn body<'e>(
        &mut self,
        plugin: Plugin<'e>,
        world: &World<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<Body> {
        let transform = plugin.transform("to_world", reader);
        let flipped = plugin.boolean("flip_normals", reader).unwrap_or(false);
        let kind = plugin.kind();
        let at = Origin::from(plugin.span());
        let made = match kind {
            "obj" | "ply" | "stl" | "serialized" => {
                let path = world.path(plugin, "filename", reader)?;
                let flat = plugin.boolean("face_normals", reader).unwrap_or(false);
                let angle = plugin.float("max_smooth_angle", reader);
                if angle.is_some() {
                    let message = "`maxSmoothAngle` is left out: normals are smooth, or those of the file";
                    reader.lost(Fate::Approximated, plugin.span_of("max_smooth_angle"), message);
                }
                plugin.pass(&["collapse", "srgb", "load_materials"]);
                let mirrored = transform.determinant() < 0.0;
                let shading = if flat { Shading::Flat } else { Shading::Smooth };
                // Files of OBJ have v upwards in images, others downwards, unless they say otherwise.
                let down = if kind == "obj" {
                    !plugin.boolean("flip_tex_coords", reader).unwrap_or(true)
                } else {
                    !plugin.boolean("flip_tex_coords", reader).unwrap_or(false)
                };
                let part =
                    plugin.integer("shape_index", reader).filter(|index| *index > 0).map(|index| index.to_string());
                let dressed = plugin.element.children.iter().any(|child| {
                    let referred = world.ids.get(child.word("id")).filter(|_| child.tag == "ref");
                    referred.map_or(child.tag.as_str(), |found| found.tag.as_str()) == "bsdf"
                });
                let mut wanted = Wanted { path, part, shading, flipped, down };
                let (mut mesh, normals) = to.mesh_file(reader, &wanted, dressed, &at)?;
                // Under a mirroring transform the front of a mesh without normals of its own is where its corners run the other way.
                if mirrored && (flat || !normals) {
                    wanted.flipped = !flipped;
                    mesh = to.mesh_file(reader, &wanted, dressed, &at)?.0;
                }
                let name = wanted.path.stem().to_owned();
                return Some(Body { mesh, transform, name });
            }
            "rectangle" => self.formula(kind, flipped, reader, to, &at, || {
                let side = Extent::Range(-1.0, 1.0);
                mesh::rectangle([side, side, Extent::At(0.0)], SignedAxis { axis: Axis::Z, negative: false })
            }),
            "cube" => self.formula(kind, flipped, reader, to, &at, || mesh::boxed([-1.0; 3], [1.0; 3])),
            "disk" => {
                round("a disk", plugin, reader);
                self.formula(kind, flipped, reader, to, &at, || mesh::disk(1.0, 0.0, SEGMENTS))
            }
            "sphere" => {
                round("a sphere", plugin, reader);
                let center = plugin.vector("center", reader).unwrap_or([0.0; 3]);
                let radius = plugin.float("radius", reader).unwrap_or(1.0);
                let ball = self
                    .formula(kind, flipped, reader, to, &at, || mesh::sphere(1.0, [0.0; 3], SEGMENTS, SEGMENTS / 2));
                let own = Affine::scaling([radius; 3]).then(&Affine::translation(center));
                return ball.map(|mesh| Body { mesh, transform: own.then(&transform), name: "sphere".to_owned() });
            }
            "cylinder" => {
                round("a cylinder", plugin, reader);
                let from = plugin.vector("p0", reader).unwrap_or([0.0; 3]);
                let end = plugin.vector("p1", reader).unwrap_or([0.0, 0.0, 1.0]);
                let radius = plugin.float("radius", reader).unwrap_or(1.0);
                let tube =
                    self.formula(kind, flipped, reader, to, &at, || mesh::cylinder(1.0, (0.0, 1.0), SEGMENTS, false));
                let axis = sub(end, from);
                let Some(own) = frame(axis) else {
                    reader.lost(Fate::Dropped, plugin.span(), "a cylinder without a length is left out");
                    return None;
                };
                let own = Affine::scaling([radius, radius, length(axis)]).then(&own).then(&Affine::translation(from));
                return tube.map(|mesh| Body { mesh, transform: own.then(&transform), name: "cylinder".to_owned() });
            }
            other => {
                let message = format!("shapes of the kind `{}` are left out: they are not read", shown(other));
                reader.lost(Fate::Dropped, plugin.span(), message);
                plugin.element.children.iter().for_each(|child| child.used.set(true));
                None
            }
        };
        made.map(|mesh| Body { mesh, transform, name: kind.to_owned() })
    }

    /// A body that a formula makes, once.
    fn formula(
        &mut self,
        kind: &str,
        flipped: bool,
        reader: &mut Reader<'_>,
        to: &mut Builder,
        at: &Origin,
        make: impl FnOnce() -> Result<Geometry, mesh::MeshError>,
    ) -> Option<Handle<Mesh>> {
        let key = format!("{kind} {flipped}");
        if let Some(known) = self.bodies.get(&key) {
            return Some(*known);
        }
        // Its numbers are constants that generators take.
        let mut geometry = make().ok()?;
        for uv in geometry.uvs.iter_mut().flatten() {
            uv[1] = 1.0 - uv[1];
        }
        let geometry = if flipped { mesh::flip(geometry) } else { geometry };
        let made = to.mesh(reader, kind, geometry, at)?;
        self.bodies.insert(key, made);
        Some(made)
    }
}

/// Says that a round body becomes a mesh.
fn round(what: &str, plugin: Plugin<'_>, reader: &mut Reader<'_>) {
    // The middle of a segment lies inside by 1 - cos(pi / n) of the radius.
    let inside = 100.0 * (1.0 - libm::cos(std::f64::consts::PI / SEGMENTS as f64));
    let message =
        format!("{what} becomes a mesh of {SEGMENTS} segments, inside of it by up to {inside:.2} % of its radius");
    reader.lost(Fate::Approximated, plugin.span(), message);
}

fn black() -> Bsdf {
    Bsdf::Diffuse { reflectance: Color::BLACK.into() }
}
