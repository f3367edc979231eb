//! Scene to `scene.py`, which calls the functions of `ltsc_blender.py`.

use std::io::{self, Write};

use super::names::{self, literal};
use super::statements;
use crate::files::Sink;
use crate::formats::shared::camera;
use crate::formats::shared::coat::{self, Coat, Mapped};
use crate::formats::shared::images;
use crate::formats::shared::names::Words;
use crate::formats::shared::number::{Num, Row, count};
use crate::formats::shared::text::{self, Head, Line};
use crate::formats::{self, Emission};
use crate::ir::{
    Affine, Axes, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Encoding, Film, Filter, Group, Instance,
    Integrator, LightKind, LightSource, Material, Sampler, Scene, Shape, Texture, Vec3, cross, normalized, sub,
};

/// Writes all files of the target.
pub fn emit(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    text::file(sink, "ltsc_blender.py", |out| out.write_all(include_bytes!("ltsc_blender.py")))?;
    text::file(sink, "scene.py", |out| {
        let head = Head { scene: &scene.name, target: "cycles" }.to_string();
        writeln!(out, "# {}", Line(&head))?;
        writeln!(out, "# blender -b -P scene.py -- --save scene.blend --render image.exr\n")?;
        writeln!(out, "import os, sys\n\nsys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))")?;
        writeln!(out, "from ltsc_blender import *\n")?;
        writeln!(out, "scene({})", literal(&scene.name))?;
        settings(scene, out)?;
        statements::write(emission.statements, out)?;
        view(scene, &scene.cameras[emission.camera], out)?;
        description(emission, out)?;
        writeln!(out, "\nif __name__ == \"__main__\":\n    finish()")
    })?;
    images::write_own(scene, names::images, sink)
}

fn settings(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let Film { width, height, filter } = &scene.film;
    let filter = match filter {
        // Only that of a pixel exists.
        Filter::Box { radius: _ } => String::new(),
        // The radius is Cycles' own.
        Filter::Gaussian { stddev, radius: _ } => format!(", gaussian={}", Num(names::gaussian_width(*stddev))),
    };
    writeln!(out, "film({}, {}{filter})", count(*width), count(*height))?;
    let max_depth = match &scene.integrator {
        Integrator::Path { max_depth } => max_depth,
        Integrator::Bidirectional { max_depth }
        | Integrator::LightTracing { max_depth }
        | Integrator::Metropolis { max_depth }
        | Integrator::PhotonMap { max_depth } => {
            writeln!(out, "# {}", text::replaced(&scene.integrator, "Cycles"))?;
            max_depth
        }
    };
    writeln!(out, "path(max_depth={})", count(*max_depth))?;
    // Both are the same shuffled Sobol sequence.
    let (Sampler::Independent { samples, seed } | Sampler::Sobol { samples, seed }) = &scene.sampler;
    writeln!(out, "sampler(samples={}, seed={})", count(*samples), count(*seed))
}

fn view(scene: &Scene, camera: &Camera, out: &mut dyn Write) -> io::Result<()> {
    let Camera { name: _, eye, target: _, up: _, fov_x, near: _, far: _ } = camera;
    // Validation refuses cameras without axes.
    let Some(Axes { right, up, forward }) = camera.axes() else { return Ok(()) };
    let (near, far) = camera::clipping(scene, camera, names::DEFAULT_CLIPPING);
    let (near, far) = (near.unwrap_or(names::DEFAULT_CLIPPING.0), far.unwrap_or(names::DEFAULT_CLIPPING.1));
    let [near, far] = [near, far].map(Num);
    let axes = axes(right, up, forward.map(|part| -part));
    writeln!(out, "camera({}, {axes}, fov_x={}, near={near}, far={far})", tuple(eye), Num(*fov_x))
}

fn axes(x: Vec3, y: Vec3, z: Vec3) -> String {
    format!("x={}, y={}, z={}", tuple(&x), tuple(&y), tuple(&z))
}

/// Axes of something that shines along `direction`: its own -z.
fn along(direction: Vec3) -> String {
    let z = normalized(direction).unwrap_or([0.0, 0.0, 1.0]).map(|part| -part);
    let x = normalized(cross(camera::across(z), z)).unwrap_or([1.0, 0.0, 0.0]);
    axes(x, cross(z, x), z)
}

fn description(emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (scene, meshes): (&Scene, &str) = (emission.scene, emission.meshes);
    let textures = Words::default().assign(scene.textures.values().map(|texture| texture.name.as_str()));
    writeln!(out)?;
    let painted = images::on_surfaces(scene);
    for ((handle, item), id) in scene.textures.iter().zip(&textures) {
        let Texture { name, file: _, image: _, encoding: _, peak: _, factor: _ } = item;
        comment(name, id, out)?;
        // An image of the environment alone is a file of floats, which is not decoded.
        let purpose = if painted[handle.index()] { images::Use::Surface } else { images::Use::Sky([1.0; 3]) };
        let linear = match names::images(item, purpose).encoding(item) {
            Encoding::Srgb => "",
            Encoding::Linear => ", linear=True",
        };
        let path = images::path(emission, handle, purpose, names::images).unwrap_or_default();
        writeln!(out, "texture({}, {}{linear})", literal(id), literal(&path))?;
    }
    let materials = Words::default().assign(scene.materials.values().map(|material| material.name.as_str()));
    for (item, id) in scene.materials.values().zip(&materials) {
        let Material { name, bsdf, sides: _ } = item;
        comment(name, id, out)?;
        let surface = surface(bsdf, &textures);
        let surface = if item.is_one_sided() { format!("one_sided({surface})") } else { surface };
        writeln!(out, "material({}, {surface})", literal(id))?;
    }
    let files = formats::mesh_files(scene);
    let mut used = vec![false; scene.meshes.len()];
    scene.surfaces().for_each(|(_, shape)| used[shape.mesh.index()] = true);
    writeln!(out)?;
    let stems: Vec<&str> = files.iter().map(|file| file.strip_suffix(".ply").unwrap_or(file)).collect();
    for ((file, stem), _) in files.iter().zip(&stems).zip(used).filter(|(_, used)| *used) {
        writeln!(out, "mesh({}, {})", literal(stem), literal(&format!("{meshes}{file}")))?;
    }
    let known = Known { meshes: &stems, materials: &materials };
    writeln!(out)?;
    scene.shapes.values().try_for_each(|shape| known.shape(shape, "", out))?;
    for light in scene.lights.values() {
        light_source(light, &textures, out)?;
    }
    let groups = Words::default().assign(scene.groups.values().map(|group| group.name.as_str()));
    for (item, id) in scene.groups.values().zip(&groups) {
        let Group { name, shapes, instances: _ } = item;
        comment(name, id, out)?;
        writeln!(out, "with group({}):", literal(id))?;
        shapes.values().try_for_each(|shape| known.shape(shape, "    ", out))?;
    }
    for instance in scene.instances.values() {
        let Instance { name: _, group, places: _ } = instance;
        let id = literal(&groups[group.index()]);
        for (name, place) in instance.named() {
            writeln!(out, "instance({}, {id}, {})", literal(&name), rows(place))?;
        }
    }
    Ok(())
}

/// What shapes refer to.
struct Known<'a> {
    meshes: &'a [&'a str],
    materials: &'a [String],
}

impl Known<'_> {
    fn shape(&self, shape: &Shape, indent: &str, out: &mut dyn Write) -> io::Result<()> {
        let Shape { name, mesh, transform, material, emission } = shape;
        let word = if emission.is_some() { "emitter" } else { "shape" };
        let (mesh, material) = (literal(self.meshes[mesh.index()]), literal(&self.materials[material.index()]));
        write!(out, "{indent}{word}({}, {mesh}, {material}", literal(name))?;
        if let Some(Light { radiance }) = emission {
            write!(out, ", radiance={}", rgb(radiance))?;
        }
        if *transform != Affine::IDENTITY {
            write!(out, ", matrix={}", rows(transform))?;
        }
        writeln!(out, ")")
    }
}

/// A color, or the name of the texture that says it.
fn paint(value: &ColorOrTexture, textures: &[String]) -> String {
    match value {
        ColorOrTexture::Color(color) => rgb(color),
        ColorOrTexture::Texture(texture) => literal(&textures[texture.index()]),
    }
}

fn surface(bsdf: &Bsdf, textures: &[String]) -> String {
    match bsdf {
        Bsdf::Diffuse { reflectance } => format!("diffuse({})", paint(reflectance, textures)),
        Bsdf::Conductor { eta, k, alpha } => {
            format!("conductor(eta={}, k={}, alpha={})", rgb(eta), rgb(k), Num(*alpha))
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            format!("dielectric(interior={}, exterior={}, alpha={})", Num(*interior), Num(*exterior), Num(*alpha))
        }
        Bsdf::Mirror { reflectance } => format!("mirror({})", rgb(reflectance)),
        Bsdf::Plastic { reflectance, ior, alpha } => {
            // Blender's coat does not darken its base: what is seen of a color is written.
            let base = match coat::mapped(reflectance, |share| Coat::new(*ior).seen(share)) {
                Mapped::Color(color) => rgb(&color),
                Mapped::Texture(_, _) => paint(reflectance, textures),
            };
            principled(&base, 0.0, alpha.sqrt(), *ior)
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            principled(&paint(base, textures), *metallic, *roughness, *ior)
        }
    }
}

fn principled(base: &str, metallic: f64, roughness: f64, ior: f64) -> String {
    let (metallic, roughness, ior) = (Num(metallic), Num(roughness), Num(ior));
    format!("principled({base}, metallic={metallic}, roughness={roughness}, ior={ior})")
}

fn light_source(light: &LightSource, textures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let LightSource { name, kind } = light;
    let name = literal(name);
    match kind {
        LightKind::Environment { radiance, tint, turn } => {
            write!(out, "environment({}", paint(radiance, textures))?;
            if tint.rgb() != [1.0; 3] {
                write!(out, ", tint={}", rgb(tint))?;
            }
            if *turn != Affine::IDENTITY {
                write!(out, ", turn={}", rows(turn))?;
            }
            writeln!(out, ")")
        }
        LightKind::Point { position, intensity } => {
            writeln!(out, "point({name}, {}, intensity={})", tuple(position), rgb(intensity))
        }
        LightKind::Spot { position, target, intensity, angle, inner } => {
            let axes = along(sub(*target, *position));
            let (intensity, half) = (rgb(intensity), Num(*angle));
            let blend = Num(names::spot_blend(*angle, *inner));
            writeln!(
                out,
                "spot({name}, {}, {axes}, intensity={intensity}, angle={half}, blend={blend})",
                tuple(position)
            )
        }
        LightKind::Directional { direction, irradiance } => {
            writeln!(out, "directional({name}, {}, irradiance={})", along(*direction), rgb(irradiance))
        }
    }
}

fn comment(name: &str, id: &str, out: &mut dyn Write) -> io::Result<()> {
    if name == id { Ok(()) } else { writeln!(out, "# {}", Line(name)) }
}

fn rgb(color: &Color) -> String {
    tuple(&color.rgb())
}

fn tuple(values: &[f64]) -> String {
    format!("({})", Row(values, ", "))
}

fn rows(transform: &Affine) -> String {
    let Affine { rows } = transform;
    format!("({})", rows.iter().map(|row| tuple(row)).collect::<Vec<_>>().join(", "))
}
