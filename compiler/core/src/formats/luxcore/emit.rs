//! Scene to LuxCore's scene description language: `scene.cfg` (settings) and `scene.scn` (camera, materials, objects), and
//! `srgb.ocio` where images are to be decoded.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::{fresnel, names, statements};
use crate::files::Sink;
use crate::formats::shared::camera;
use crate::formats::shared::coat::{self, Coat, Mapped};
use crate::formats::shared::images;
use crate::formats::shared::names::{Words, file_stem};
use crate::formats::shared::number::{Num, Row, count};
use crate::formats::shared::text::{self, Head, Line, Quoted};
use crate::formats::{self, Emission};
use crate::ir::{
    Affine, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Encoding, Film, Filter, Instance, Integrator,
    LightKind, LightSource, Material, Sampler, Scene, Shape, Texture,
};

/// Writes all files of the target.
pub fn emit(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let head = Head { scene: &scene.name, target: "luxcore" }.to_string();
    let head = Line(&head).to_string();
    text::file(sink, "scene.cfg", |out| {
        writeln!(out, "# {head}")?;
        settings(emission, out)
    })?;
    if scene.textures.values().any(|texture| encoding(texture) == Encoding::Srgb) {
        text::file(sink, names::SRGB_FILE, |out| {
            writeln!(out, "# {head}")?;
            out.write_all(names::SRGB_CONFIG.as_bytes())
        })?;
    }
    text::file(sink, "scene.scn", |out| {
        writeln!(out, "# {head}")?;
        view(scene, &scene.cameras[emission.camera], out)?;
        description(emission, out)
    })?;
    images::write_own(scene, images::shared_or_scaled, sink)
}

fn settings(emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (scene, given): (&Scene, _) = (emission.scene, emission.statements);
    let camera = &scene.cameras[emission.camera];
    let set = |out: &mut dyn Write, key: &str, value: &str| {
        if statements::replaced(given, key) { Ok(()) } else { set(out, key, value) }
    };
    set(out, "scene.file", "\"scene.scn\"")?;
    for (key, value) in names::FIXED {
        set(out, key, value)?;
    }
    if let Some(distance) = names::least_distance(camera) {
        set(out, "scene.epsilon.min", &Num(distance).to_string())?;
    }
    let (kind, seed, samples) = match &scene.sampler {
        Sampler::Independent { samples, seed } => ("random", seed, samples),
        Sampler::Sobol { samples, seed } => ("sobol", seed, samples),
    };
    set(out, "sampler.type", &format!("\"{}\"", kind.to_uppercase()))?;
    // No sampling by noise estimate.
    set(out, &format!("sampler.{kind}.adaptive.strength"), "0")?;
    let max_depth = match &scene.integrator {
        Integrator::Path { max_depth } => max_depth,
        Integrator::Bidirectional { max_depth }
        | Integrator::LightTracing { max_depth }
        | Integrator::Metropolis { max_depth }
        | Integrator::PhotonMap { max_depth } => {
            writeln!(out, "# {}", text::replaced(&scene.integrator, "luxcore"))?;
            max_depth
        }
    };
    let depth = names::depth(count(*max_depth)).to_string();
    // The limits per kind of scattering have defaults of their own (4 to 6).
    for key in ["total", "diffuse", "glossy", "specular"] {
        set(out, &format!("path.pathdepth.{key}"), &depth)?;
    }
    set(out, "path.russianroulette.depth", &depth)?;
    set(out, "renderengine.seed", &names::seed(*seed).to_string())?;
    set(out, "batch.haltspp", &count(*samples).to_string())?;
    let Film { width, height, filter } = &scene.film;
    set(out, "film.width", &count(*width).to_string())?;
    set(out, "film.height", &count(*height).to_string())?;
    match filter {
        Filter::Box { radius } => {
            if *radius == 0.5 {
                set(out, "film.filter.type", "\"NONE\"")?;
            } else {
                set(out, "film.filter.type", "\"BOX\"")?;
                set(out, "film.filter.width", &Num(*radius).to_string())?;
            }
        }
        Filter::Gaussian { stddev, radius } => {
            set(out, "film.filter.type", "\"GAUSSIAN\"")?;
            set(out, "film.filter.width", &Num(*radius).to_string())?;
            let alpha = Num(names::gaussian_alpha(*stddev)).to_string();
            set(out, "film.filter.gaussian.alpha", &alpha)?;
        }
    }
    set(out, "film.outputs.0.type", "\"RGB\"")?;
    set(out, "film.outputs.0.filename", &format!("\"{}.exr\"", file_stem(&scene.name)))?;
    statements::write(given, out)
}

fn view(scene: &Scene, camera: &Camera, out: &mut dyn Write) -> io::Result<()> {
    let Camera { name: _, eye, target, up, fov_x, near: _, far: _ } = camera;
    let key = |name: &str| format!("scene.camera.{name}");
    set(out, &key("type"), "\"perspective\"")?;
    set(out, &key("lookat.orig"), &row(eye))?;
    set(out, &key("lookat.target"), &row(target))?;
    set(out, &key("up"), &row(up))?;
    set(out, &key("fieldofview"), &Num(*fov_x).to_string())?;
    set(out, &key("screenwindow"), &row(&names::screen_window(&scene.film)))?;
    let (near, far) = camera::clipping(scene, camera, names::DEFAULT_CLIPPING);
    if let Some(near) = near {
        set(out, &key("cliphither"), &Num(near).to_string())?;
    }
    if let Some(far) = far {
        set(out, &key("clipyon"), &Num(far).to_string())?;
    }
    Ok(())
}

/// A material and what it emits: LuxCore makes emission part of the material. Radiance by its bits, for the order.
type Surface = (usize, Option<[u64; 3]>);

fn description(emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (scene, meshes): (&Scene, &str) = (emission.scene, emission.meshes);
    let mut words = Words::default();
    let materials = words.assign(scene.materials.values().map(|material| material.name.as_str()));
    // The ending keeps these apart from the textures that belong to materials.
    let textures = Words::default().assign(scene.textures.values().map(|texture| texture.name.as_str()));
    let textures: Vec<String> = textures.iter().map(|id| format!("{id}_image")).collect();
    let painted = images::on_surfaces(scene);
    for ((handle, item), id) in scene.textures.iter().zip(&textures).filter(|((handle, _), _)| painted[handle.index()])
    {
        let path = images::path(emission, handle, images::Use::Surface, images::shared_or_scaled).unwrap_or_default();
        texture(item, id, &path, out)?;
    }
    for (item, id) in scene.materials.values().zip(&materials) {
        comment(&item.name, id, out)?;
        sided(item, id, &mut words, &textures, out)?;
    }
    // Emitting variants of a material are named after the first shape that has them.
    let mut variants: BTreeMap<Surface, String> = BTreeMap::new();
    for shape in scene.shapes.values() {
        let Shape { name, mesh: _, transform: _, material: base, emission } = shape;
        let surface = surface(base.index(), emission.as_ref());
        let Some(Light { radiance }) = emission else { continue };
        if variants.contains_key(&surface) {
            continue;
        }
        let id = words.assign(std::iter::once(name.as_str())).concat();
        sided(&scene.materials[*base], &id, &mut words, &textures, out)?;
        emission_of(radiance, &id, out)?;
        variants.insert(surface, id);
    }
    writeln!(out)?;
    let mut words = Words::default();
    let files = formats::mesh_files(scene);
    let stems = files.iter().map(|file| file.strip_suffix(".ply").unwrap_or(file));
    let shapes = words.assign(stems);
    let mut used = vec![false; scene.meshes.len()];
    scene.surfaces().for_each(|(_, shape)| used[shape.mesh.index()] = true);
    for ((id, file), used) in shapes.iter().zip(&files).zip(used) {
        if used {
            set(out, &format!("scene.shapes.{id}.type"), "\"mesh\"")?;
            let path = Quoted(&format!("{meshes}{file}")).to_string();
            set(out, &format!("scene.shapes.{id}.ply"), &path)?;
        }
    }
    writeln!(out)?;
    let lights = Words::default().assign(scene.lights.values().map(|light| light.name.as_str()));
    for (light, id) in scene.lights.values().zip(&lights) {
        let LightSource { name, kind } = light;
        comment(name, id, out)?;
        let file = images::sky_path(emission, kind, images::shared_or_scaled);
        light_source(kind, (id, file.as_deref()), out)?;
    }
    // LuxCore has no groups: each use of a shape is an object, and the meshes are shared.
    let own = scene.shapes.values().map(|shape| (shape.name.clone(), shape, shape.transform));
    let mut uses: Vec<(String, &Shape, Affine)> = own.collect();
    for instance in scene.instances.values() {
        let Instance { name: _, group, places: _ } = instance;
        for (name, place) in instance.named() {
            let shapes = scene.groups[*group].shapes.values();
            uses.extend(shapes.map(|shape| (format!("{name}/{}", shape.name), shape, shape.transform.then(place))));
        }
    }
    let objects = Words::default().assign(uses.iter().map(|(name, _, _)| name.as_str()));
    for ((name, shape, transform), id) in uses.iter().zip(&objects) {
        let Shape { name: _, mesh, transform: _, material, emission } = shape;
        // Names of instances differ from their ids only in their brackets.
        if !name.contains('[') {
            comment(name, id, out)?;
        }
        let base = &materials[material.index()];
        let used = variants.get(&surface(material.index(), emission.as_ref())).unwrap_or(base);
        set(out, &format!("scene.objects.{id}.shape"), &format!("\"{}\"", shapes[mesh.index()]))?;
        set(out, &format!("scene.objects.{id}.material"), &format!("\"{used}\""))?;
        placed(transform, id, out)?;
    }
    Ok(())
}

fn surface(material: usize, emission: Option<&Light>) -> Surface {
    (material, emission.map(|Light { radiance }| radiance.rgb().map(f64::to_bits)))
}

/// How the numbers of an image on surfaces become linear, in the form that LuxCore gets.
fn encoding(texture: &Texture) -> Encoding {
    images::shared_or_scaled(texture, images::Use::Surface).encoding(texture)
}

/// An image. LuxCore's v grows downwards in it (measured with 2.11.2), so it is mirrored.
fn texture(texture: &Texture, id: &str, path: &str, out: &mut dyn Write) -> io::Result<()> {
    comment(&texture.name, id.strip_suffix("_image").unwrap_or(id), out)?;
    let mut put = |name: &str, value: &str| set(out, &format!("scene.textures.{id}.{name}"), value);
    put("type", "\"imagemap\"")?;
    put("file", &Quoted(path).to_string())?;
    names::decoding(encoding(texture)).iter().try_for_each(|(name, value)| put(name, value))?;
    // Numbers that are decoded and then kept in bytes lose most of their dark ones.
    put("storage", "\"float\"")?;
    put("wrap", "\"repeat\"")?;
    put("mapping.type", "\"uvmapping2d\"")?;
    put("mapping.uvscale", "1 -1")?;
    put("mapping.uvdelta", "0 1")
}

/// A color, or the name of the texture that says it.
fn paint(value: &ColorOrTexture, textures: &[String]) -> String {
    match value {
        ColorOrTexture::Color(color) => rgb(color),
        ColorOrTexture::Texture(texture) => format!("\"{}\"", textures[texture.index()]),
    }
}

/// A material under an id. One that is black from behind is made of two others.
fn sided(one: &Material, id: &str, words: &mut Words, textures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let Material { name: _, bsdf, sides: _ } = one;
    if !one.is_one_sided() {
        return material(bsdf, id, textures, out);
    }
    let [front, back] =
        ["front", "back"].map(|side| words.assign(std::iter::once(format!("{id}_{side}").as_str())).concat());
    material(bsdf, &front, textures, out)?;
    material(&Bsdf::Diffuse { reflectance: Color::BLACK.into() }, &back, textures, out)?;
    let mut put = |name: &str, value: &str| set(out, &format!("scene.materials.{id}.{name}"), value);
    put("type", "\"twosided\"")?;
    put("frontmaterial", &format!("\"{front}\""))?;
    put("backmaterial", &format!("\"{back}\""))
}

fn material(bsdf: &Bsdf, id: &str, textures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let mut put = |name: &str, value: &str| set(out, &format!("scene.materials.{id}.{name}"), value);
    match bsdf {
        Bsdf::Diffuse { reflectance } => {
            put("type", "\"matte\"")?;
            put("kd", &paint(reflectance, textures))
        }
        Bsdf::Conductor { eta, k, alpha } => {
            put("type", "\"metal2\"")?;
            put("fresnel", &format!("\"{id}_fresnel\""))?;
            // The square of this is the width's square in the GGX distribution (measured with 2.11.2).
            put("uroughness", &Num(*alpha).to_string())?;
            put("vroughness", &Num(*alpha).to_string())?;
            let (eta, k) = (eta.rgb(), k.rgb());
            writeln!(
                out,
                "# eta {}, k {}: n and k are fitted, LuxCore's Fresnel term being its own",
                row(&eta),
                row(&k)
            )?;
            let fits = [0, 1, 2].map(|channel| fresnel::fit(eta[channel], k[channel]));
            let mut put = |name: &str, value: &str| set(out, &format!("scene.textures.{id}_fresnel.{name}"), value);
            put("type", "\"fresnelconst\"")?;
            put("n", &row(&fits.map(|fit| fit.n)))?;
            put("k", &row(&fits.map(|fit| fit.k)))
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            put("type", if *alpha == 0.0 { "\"glass\"" } else { "\"roughglass\"" })?;
            put("kr", "1 1 1")?;
            put("kt", "1 1 1")?;
            put("interiorior", &Num(*interior).to_string())?;
            put("exteriorior", &Num(*exterior).to_string())?;
            if *alpha != 0.0 {
                put("uroughness", &Num(*alpha).to_string())?;
                put("vroughness", &Num(*alpha).to_string())?;
            }
            Ok(())
        }
        Bsdf::Mirror { reflectance } => {
            put("type", "\"mirror\"")?;
            put("kr", &rgb(reflectance))
        }
        Bsdf::Plastic { reflectance, ior, alpha } => {
            // Its coat does not darken the base: what is seen of the base is written.
            let base = match coat::mapped(reflectance, |share| Coat::new(*ior).seen(share)) {
                Mapped::Color(color) => rgb(&color),
                Mapped::Texture(texture, factor) => {
                    let mut put =
                        |name: &str, value: &str| set(out, &format!("scene.textures.{id}_base.{name}"), value);
                    put("type", "\"scale\"")?;
                    put("texture1", &format!("\"{}\"", textures[texture.index()]))?;
                    put("texture2", &row(&[factor; 3]))?;
                    format!("\"{id}_base\"")
                }
            };
            let mut put = |name: &str, value: &str| set(out, &format!("scene.materials.{id}.{name}"), value);
            put("type", "\"glossy2\"")?;
            put("kd", &base)?;
            put("ks", &row(&[coat::normal_reflectance(*ior); 3]))?;
            put("uroughness", &Num(*alpha).to_string())?;
            put("vroughness", &Num(*alpha).to_string())?;
            put("multibounce", "0")
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            put("type", "\"disney\"")?;
            put("basecolor", &paint(base, textures))?;
            put("metallic", &Num(*metallic).to_string())?;
            put("roughness", &Num(*roughness).to_string())?;
            put("specular", &Num(names::specular(*ior)).to_string())?;
            ["speculartint", "subsurface", "sheen", "sheentint", "clearcoat", "clearcoatgloss", "anisotropic"]
                .into_iter()
                .try_for_each(|name| put(name, "0"))
        }
    }
}

fn emission_of(radiance: &Color, id: &str, out: &mut dyn Write) -> io::Result<()> {
    let mut put = |name: &str, value: &str| set(out, &format!("scene.materials.{id}.emission{name}"), value);
    put("", &rgb(radiance))?;
    put(".gain", "1 1 1")?;
    // With a power or an efficiency the radiance would be rescaled.
    put(".power", "0")?;
    put(".efficiency", "0")?;
    put(".theta", "90")?;
    // The default leaves meshes of more than 256 triangles to chance hits.
    put(".directlightsampling.type", "\"ENABLED\"")
}

/// A light without a surface; without power and efficiency its strength is color times gain.
fn light_source(kind: &LightKind, (id, image): (&str, Option<&str>), out: &mut dyn Write) -> io::Result<()> {
    let mut put = |name: &str, value: &str| set(out, &format!("scene.lights.{id}.{name}"), value);
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint, turn } => {
            put("type", "\"infinite\"")?;
            put("file", &Quoted(image.unwrap_or_default()).to_string())?;
            put("gamma", "1")?;
            put("storage", "\"float\"")?;
            put("gain", &row(&tint.rgb()))?;
            put("transformation", &row(columns(&names::ENVIRONMENT.then(turn)).as_flattened()))
        }
        LightKind::Environment { radiance: ColorOrTexture::Color(radiance), tint: _, turn: _ } => {
            put("type", "\"constantinfinite\"")?;
            put("color", &rgb(radiance))?;
            put("gain", "1 1 1")
        }
        LightKind::Point { position, intensity } => {
            put("type", "\"point\"")?;
            put("position", &row(position))?;
            put("color", &rgb(intensity))?;
            put("gain", &row(&[names::POINT_GAIN; 3]))?;
            put("power", "0")?;
            put("efficiency", "0")
        }
        LightKind::Spot { position, target, intensity, angle, inner } => {
            put("type", "\"spot\"")?;
            put("position", &row(position))?;
            put("target", &row(target))?;
            put("coneangle", &Num(*angle).to_string())?;
            put("conedeltaangle", &Num(angle - inner).to_string())?;
            put("color", &rgb(intensity))?;
            put("gain", "1 1 1")?;
            put("power", "0")?;
            put("efficiency", "0")
        }
        LightKind::Directional { direction, irradiance } => {
            put("type", "\"sharpdistant\"")?;
            put("direction", &row(direction))?;
            put("color", &rgb(irradiance))?;
            put("gain", "1 1 1")
        }
    }
}

/// The transform of a shape, by columns as LuxCore writes matrices.
fn placed(transform: &Affine, id: &str, out: &mut dyn Write) -> io::Result<()> {
    if *transform == Affine::IDENTITY {
        return Ok(());
    }
    set(out, &format!("scene.objects.{id}.transformation"), &row(columns(transform).as_flattened()))
}

fn columns(transform: &Affine) -> [[f64; 4]; 4] {
    let Affine { rows } = transform;
    [0, 1, 2, 3].map(|column| {
        let [x, y, z] = rows.map(|row| row[column]);
        [x, y, z, if column == 3 { 1.0 } else { 0.0 }]
    })
}

fn comment(name: &str, id: &str, out: &mut dyn Write) -> io::Result<()> {
    if name == id { Ok(()) } else { writeln!(out, "# {}", Line(name)) }
}

fn set(out: &mut dyn Write, key: &str, value: &str) -> io::Result<()> {
    writeln!(out, "{key} = {value}")
}

fn rgb(color: &Color) -> String {
    row(&color.rgb())
}

fn row(values: &[f64]) -> String {
    Row(values, " ").to_string()
}
