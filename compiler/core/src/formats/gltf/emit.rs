//! Scene to glTF 2.0: `NAME.gltf` with `NAME.bin` and images beside it, or all in `NAME.glb`.

use std::collections::BTreeSet;
use std::io;

use super::buffer::Layout;
use super::container::Plan;
use super::document as doc;
use super::instancing;
use super::names::{self, textures};
use super::nodes::{Made, light};
use crate::files::Sink;
use crate::formats::Emission;
use crate::formats::shared::camera;
use crate::formats::shared::names::file_stem;
use crate::formats::shared::text::{self, Head};
use crate::ir::{Affine, Axes, Camera, Film, Filter, Instance, Sampler, Scene, Texture};

/// The choice of both targets by which instances become one node.
pub const INSTANCING: &str = "instancing";

/// Writes `NAME.gltf`, `NAME.bin` and the images.
pub fn separate(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let stem = file_stem(&scene.name);
    let (document, layout) = document(emission, &Form::Separate { stem: &stem });
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
    sink.file(&format!("{stem}.bin"), &mut |out| layout.write(out))
}

/// Writes `NAME.glb`, which holds all.
pub fn container(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let (document, layout) = document(emission, &Form::Container);
    let text = serde_json::to_vec(&document)?;
    let plan = Plan::new(text.len() as u64, layout.bytes)?;
    let path = format!("{}.glb", file_stem(&emission.scene.name));
    sink.file(&path, &mut |out| plan.write(&text, |out| layout.write(out), out))
}

/// Where the bytes of a document lie.
enum Form<'a> {
    /// In files beside it.
    Separate { stem: &'a str },
    /// In the file that it lies in itself.
    Container,
}

fn document<'a>(emission: &Emission<'a>, form: &Form<'_>) -> (doc::Document, Layout<'a>) {
    let scene: &Scene = emission.scene;
    let camera = &scene.cameras[emission.camera];
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
            let index = doc::LightIndex { light: lights.len() };
            node.extensions =
                Some(doc::NodeExtensions { lights_punctual: Some(index), ..doc::NodeExtensions::default() });
            lights.push(light);
            nodes.push(node);
        }
    }
    let Made { mut layout, meshes, materials, moved, .. } = made;
    let (target, uri) = match form {
        Form::Separate { stem } => ("gltf", Some(format!("{stem}.bin"))),
        Form::Container => ("glb", None),
    };
    let mut comment = Head { scene: &scene.name, target }.to_string();
    let mut required = Vec::new();
    if emission.choices.has(target, INSTANCING) {
        nodes = instancing::gather(nodes, &mut layout);
        if moved > 0 {
            comment.push_str(&format!(
                "; instances have no shear: {moved} sheared uses of meshes have vertices of their own"
            ));
        }
        if nodes.iter().any(|node| node.extensions.as_ref().is_some_and(|those| those.instancing.is_some())) {
            required.push(instancing::NAME);
        }
    }
    nodes[0].children = (1..nodes.len()).collect();

    let mut extensions: BTreeSet<_> = materials.iter().flat_map(|material| material.extensions.names()).collect();
    let lights = (!lights.is_empty()).then_some(doc::DocumentExtensions { lights_punctual: doc::Lights { lights } });
    extensions.extend(lights.iter().map(|_| "KHR_lights_punctual"));
    extensions.extend(&required);
    let (mut images, mut uses) = (Vec::new(), Vec::new());
    for ((Texture { name, file: bytes, image, encoding: _, peak: _, factor: _ }, file), index) in textures(scene) {
        let place = match form {
            Form::Separate { stem: _ } => doc::ImagePlace::Uri { uri: format!("textures/{file}") },
            Form::Container => {
                doc::ImagePlace::View { buffer_view: layout.file(bytes), mime_type: names::mime(image.format) }
            }
        };
        images.push(doc::Image { name: name.clone(), place });
        uses.push(doc::Texture { name: name.clone(), sampler: 0, source: index });
    }
    let buffers = if layout.bytes == 0 { Vec::new() } else { vec![doc::Buffer { uri, byte_length: layout.bytes }] };
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
            extras: doc::Comment { comment },
        },
        extensions_used: extensions.into_iter().collect(),
        // Who passes over it would see one instance of many.
        extensions_required: required,
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
    let Camera { name, eye: _, target: _, up: _, fov_x, near: _, far } = camera;
    let Film { width, height, filter: _ } = &scene.film;
    let znear = camera::must_near(scene, camera);
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
