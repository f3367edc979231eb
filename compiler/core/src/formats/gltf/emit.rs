//! Scene to glTF 2.0: `NAME.gltf` and `NAME.bin`.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use super::buffer::{Layout, Part, Place};
use super::document as doc;
use super::names;
use crate::files::Sink;
use crate::formats::shared::camera;
use crate::formats::shared::coat::{self, Coat, Mapped};
use crate::formats::shared::names::file_stem;
use crate::formats::shared::text::{self, Head};
use crate::formats::{self, Emission};
use crate::ir::{
    Affine, Axes, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Film, Filter, Group, Handle, Instance,
    LightKind, LightSource, Material, Mesh, Sampler, Scene, Shape, Texture, sub,
};

/// Writes all files of the target.
pub fn emit(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let stem = file_stem(&scene.name);
    let (document, layout) = document(scene, &scene.cameras[emission.camera], &stem);
    text::file(sink, &format!("{stem}.gltf"), |out| {
        serde_json::to_writer_pretty(&mut *out, &document)?;
        out.write_all(b"\n")
    })?;
    for ((texture, file), _) in textures(scene) {
        sink.file(&format!("textures/{file}"), &mut |out| out.write_all(&texture.file))?;
    }
    if layout.bytes == 0 {
        return Ok(());
    }
    sink.file(&format!("{stem}.bin"), &mut |out| layout.write(scene, out))
}

/// The textures that glTF can hold, each with its file and its index in the document.
fn textures(scene: &Scene) -> impl Iterator<Item = ((&Texture, String), usize)> {
    let files = formats::texture_files(scene);
    scene.textures.values().zip(files).filter(|(texture, _)| names::reads(texture)).zip(0..)
}

fn document(scene: &Scene, camera: &Camera, stem: &str) -> (doc::Document, Layout) {
    let mut made = Made::default();
    let mut nodes = vec![doc::Node {
        name: scene.name.clone(),
        matrix: Some(names::matrix(&names::Z_UP_TO_Y_UP)),
        ..doc::Node::default()
    }];
    nodes.push(camera_node(camera));
    for shape in scene.shapes.values() {
        nodes.push(made.node(scene, shape));
    }
    for instance in scene.instances.values() {
        let Instance { name: _, group, places: _ } = instance;
        for (name, place) in instance.named() {
            nodes.push(made.instance(scene, &name, *group, place));
        }
    }
    let mut lights = Vec::new();
    for source in scene.lights.values() {
        if let Some((light, mut node)) = light(source) {
            node.extensions = Some(doc::NodeExtensions { lights_punctual: doc::LightIndex { light: lights.len() } });
            lights.push(light);
            nodes.push(node);
        }
    }
    nodes[0].children = (1..nodes.len()).collect();

    let Made { layout, meshes, materials, places: _, known_materials: _, known_meshes: _, known_groups: _ } = made;
    let mut extensions: BTreeSet<_> = materials.iter().flat_map(|material| material.extensions.names()).collect();
    let lights = (!lights.is_empty()).then_some(doc::DocumentExtensions { lights_punctual: doc::Lights { lights } });
    extensions.extend(lights.iter().map(|_| "KHR_lights_punctual"));
    let buffers = if layout.bytes == 0 {
        Vec::new()
    } else {
        vec![doc::Buffer { uri: format!("{stem}.bin"), byte_length: layout.bytes }]
    };
    let head = Head { scene: &scene.name, target: "gltf" }.to_string();
    let mut layout = layout;
    let (mut images, mut uses) = (Vec::new(), Vec::new());
    for ((Texture { name, file: _, image: _, encoding: _ }, file), index) in textures(scene) {
        images.push(doc::Image { name: name.clone(), uri: format!("textures/{file}") });
        uses.push(doc::Texture { name: name.clone(), sampler: 0, source: index });
    }
    let sampler = doc::TextureSampler {
        mag_filter: names::LINEAR,
        min_filter: names::LINEAR,
        wrap_s: names::REPEAT,
        wrap_t: names::REPEAT,
    };
    let document = doc::Document {
        samplers: if uses.is_empty() { Vec::new() } else { vec![sampler] },
        textures: uses,
        images,
        asset: doc::Asset {
            version: "2.0",
            generator: "ltsc",
            copyright: scene.documentation.license.clone(),
            extras: doc::Comment { comment: head },
        },
        extensions_used: extensions.into_iter().collect(),
        extensions: lights,
        scene: 0,
        scenes: vec![doc::Scene { name: scene.name.clone(), nodes: vec![0], extras: settings(scene) }],
        nodes,
        cameras: vec![camera_item(scene, camera)],
        meshes,
        materials,
        accessors: std::mem::take(&mut layout.accessors),
        buffer_views: std::mem::take(&mut layout.views),
        buffers,
    };
    (document, layout)
}

/// A material, what it emits (radiance by its bits, for the order), and for dielectrics how thick the mesh is.
type Surface = (usize, Option<[u64; 3]>);

#[derive(Default)]
struct Made {
    layout: Layout,
    places: BTreeMap<usize, Place>,
    materials: Vec<doc::Material>,
    known_materials: BTreeMap<Surface, usize>,
    meshes: Vec<doc::Mesh>,
    known_meshes: BTreeMap<(usize, usize), usize>,
    known_groups: BTreeMap<usize, usize>,
}

impl Made {
    fn node(&mut self, scene: &Scene, shape: &Shape) -> doc::Node {
        let Shape { name, mesh: handle, transform, material, emission } = shape;
        let mut node = doc::Node { name: name.clone(), ..doc::Node::default() };
        let mesh = &scene.meshes[*handle];
        let material = self.material(scene, shape, (material.index(), bits(emission.as_ref())));
        // A node's matrix must be translation, rotation and scale (glTF 2.0, 3.5.2); other maps move the vertices.
        if camera::has_orthogonal_columns(transform) {
            let known = self.known_meshes.get(&(handle.index(), material)).copied();
            node.mesh = Some(known.unwrap_or_else(|| {
                let primitive = self.primitive(scene, *handle, &Affine::IDENTITY, material);
                let made = self.mesh(&mesh.name, vec![primitive]);
                self.known_meshes.insert((handle.index(), material), made);
                made
            }));
            place(&mut node, transform);
        } else {
            let primitive = self.primitive(scene, *handle, transform, material);
            node.mesh = Some(self.mesh(&mesh.name, vec![primitive]));
        }
        node
    }

    /// A group is a mesh with a primitive for each shape: a node of its own for each would have to be repeated in every
    /// instance, because a node has one parent.
    fn instance(&mut self, scene: &Scene, name: &str, group: Handle<Group>, transform: &Affine) -> doc::Node {
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
            node.mesh = Some(self.group(scene, group, transform));
        }
        node
    }

    fn group(&mut self, scene: &Scene, handle: Handle<Group>, outer: &Affine) -> usize {
        let Group { name, shapes, instances: _ } = &scene.groups[handle];
        let mut primitives = Vec::new();
        for shape in shapes.values() {
            let Shape { name: _, mesh, transform, material, emission } = shape;
            let material = self.material(scene, shape, (material.index(), bits(emission.as_ref())));
            primitives.push(self.primitive(scene, *mesh, &transform.then(outer), material));
        }
        self.mesh(name, primitives)
    }

    /// A mesh whose vertices are moved; those that are not moved are written once.
    fn primitive(&mut self, scene: &Scene, mesh: Handle<Mesh>, map: &Affine, material: usize) -> doc::Primitive {
        let moved = *map != Affine::IDENTITY;
        let known = if moved { None } else { self.places.get(&mesh.index()).copied() };
        let Place { attributes, indices } = known.unwrap_or_else(|| {
            let place = self.layout.add(scene, Part { mesh, map: moved.then_some(*map) });
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

    fn material(&mut self, scene: &Scene, shape: &Shape, surface: Surface) -> usize {
        if let Some(known) = self.known_materials.get(&surface) {
            return *known;
        }
        let Shape { name: _, mesh, transform: _, material, emission } = shape;
        let thickness = thickness(&scene.meshes[*mesh]);
        let made = made_material(scene, &scene.materials[*material], emission.as_ref(), thickness);
        self.materials.push(made);
        let index = self.materials.len() - 1;
        self.known_materials.insert(surface, index);
        index
    }
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

/// The factor and the texture of a base color.
fn paint(scene: &Scene, value: &ColorOrTexture) -> ([f64; 3], Option<doc::TextureIndex>) {
    match value {
        ColorOrTexture::Color(color) => (color.rgb(), None),
        ColorOrTexture::Texture(handle) => {
            let own = &scene.textures[*handle];
            let known = textures(scene).find(|((texture, _), _)| std::ptr::eq(*texture, own));
            match known {
                Some((_, index)) => ([1.0; 3], Some(doc::TextureIndex { index })),
                None => (Color::Grey(formats::STAND_IN).rgb(), None),
            }
        }
    }
}

fn made_material(scene: &Scene, material: &Material, emission: Option<&Light>, thickness: f64) -> doc::Material {
    let Material { name, bsdf } = material;
    let mut extensions = doc::Extensions::default();
    let opaque = |[r, g, b]: [f64; 3], metallic_factor, roughness_factor| doc::Metallic {
        base_color_factor: [r, g, b, 1.0],
        base_color_texture: None,
        metallic_factor,
        roughness_factor,
    };
    let (pbr_metallic_roughness, two_sided) = match bsdf {
        Bsdf::Diffuse { reflectance } => {
            // Without the specular layer that every glTF dielectric has, what remains is Lambert's reflection.
            extensions.specular = Some(doc::Specular { specular_factor: 0.0 });
            let (factor, base_color_texture) = paint(scene, reflectance);
            (doc::Metallic { base_color_texture, ..opaque(factor, 0.0, 1.0) }, true)
        }
        Bsdf::Conductor { eta, k, alpha } => (opaque(names::base_color(eta, k), 1.0, names::roughness(*alpha)), true),
        Bsdf::Dielectric { interior, exterior, alpha } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*interior, *exterior) });
            extensions.transmission = Some(doc::Transmission { transmission_factor: 1.0 });
            // A thickness above 0 says that the surface bounds a volume, hence refracts; rasterisers use its size.
            extensions.volume = Some(doc::Volume { thickness_factor: thickness });
            (opaque([1.0; 3], 0.0, names::roughness(*alpha)), false)
        }
        Bsdf::Mirror { reflectance } => (opaque(reflectance.rgb(), 1.0, 0.0), true),
        Bsdf::Plastic { reflectance, ior, alpha } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*ior, 1.0) });
            // glTF's coat does not darken its base: what is seen of the base is written.
            let (factor, base_color_texture) = match coat::mapped(reflectance, |share| Coat::new(*ior).seen(share)) {
                Mapped::Color(color) => (color.rgb(), None),
                Mapped::Texture(_, scale) => {
                    let (factor, texture) = paint(scene, reflectance);
                    (factor.map(|x| x * scale), texture)
                }
            };
            (doc::Metallic { base_color_texture, ..opaque(factor, 0.0, names::roughness(*alpha)) }, true)
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            extensions.ior = Some(doc::Ior { ior: names::ior(*ior, 1.0) });
            let (factor, base_color_texture) = paint(scene, base);
            (doc::Metallic { base_color_texture, ..opaque(factor, *metallic, *roughness) }, true)
        }
    };
    let mut emissive_factor = None;
    if let Some(Light { radiance }) = emission {
        let (factor, strength) = names::emission(radiance);
        emissive_factor = Some(factor);
        if strength != 1.0 && strength > 0.0 {
            let emissive_strength = doc::EmissiveStrength { emissive_strength: strength };
            extensions.emissive_strength = Some(emissive_strength);
        }
    }
    doc::Material {
        name: name.clone(),
        pbr_metallic_roughness,
        emissive_factor,
        // A double-sided emitter would emit on both sides.
        double_sided: two_sided && emission.is_none(),
        extensions,
    }
}

/// The smallest extent of a mesh that is not flat along it; 1 for a point.
fn thickness(mesh: &Mesh) -> f64 {
    let [low, high] = camera::bounds(&mesh.positions);
    let extents = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let smallest = extents.into_iter().filter(|extent| *extent > 0.0).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 1.0 }
}

/// A light of KHR_lights_punctual and its node; none for an environment, which that extension has not.
fn light(source: &LightSource) -> Option<(doc::Light, doc::Node)> {
    let LightSource { name, kind } = source;
    let mut node = doc::Node { name: name.clone(), ..doc::Node::default() };
    let mut spot = None;
    let kind_name = match kind {
        LightKind::Environment { radiance: _ } => return None,
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

/// A camera looks along its node's -z with y up.
fn camera_node(camera: &Camera) -> doc::Node {
    let name = camera.name.clone().unwrap_or_else(|| "camera".to_owned());
    let matrix = camera.axes().map(|Axes { right, up, forward }| {
        let [x, y, z] = camera.eye;
        names::matrix(&Affine {
            rows: [
                [right[0], up[0], -forward[0], x],
                [right[1], up[1], -forward[1], y],
                [right[2], up[2], -forward[2], z],
            ],
        })
    });
    doc::Node { name, camera: Some(0), matrix, ..doc::Node::default() }
}

fn camera_item(scene: &Scene, camera: &Camera) -> doc::Camera {
    let Camera { name, eye: _, target: _, up: _, fov_x, near, far } = camera;
    let Film { width, height, filter: _ } = &scene.film;
    // glTF requires a near distance: a thousandth of the way to the farthest surface keeps a depth buffer precise.
    let reach = camera::reach(scene, camera);
    let open = if reach > 0.0 { reach * 1e-3 } else { 1e-2 };
    let znear = near.unwrap_or_else(|| far.map_or(open, |far| open.min(far * 1e-3)));
    doc::Camera {
        name: name.clone(),
        r#type: "perspective",
        perspective: doc::Perspective {
            aspect_ratio: f64::from(*width) / f64::from(*height),
            yfov: camera::fov_y(*fov_x, &scene.film).to_radians(),
            znear,
            zfar: *far,
        },
    }
}

fn settings(scene: &Scene) -> doc::Settings {
    let Film { width, height, filter } = &scene.film;
    let filter = match filter {
        Filter::Box { radius } => doc::Filter::Box { radius: *radius },
        Filter::Gaussian { stddev, radius } => doc::Filter::Gaussian { stddev: *stddev, radius: *radius },
    };
    let integrator = doc::Integrator { r#type: scene.integrator.word(), max_depth: scene.integrator.max_depth() };
    let sampler = match &scene.sampler {
        Sampler::Independent { samples, seed } => doc::Sampler::Independent { samples: *samples, seed: *seed },
        Sampler::Sobol { samples, seed } => doc::Sampler::Sobol { samples: *samples, seed: *seed },
    };
    let film = doc::Film { width: *width, height: *height, filter };
    doc::Settings { film, integrator, sampler }
}
