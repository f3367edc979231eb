//! Scene to PBRT text: `scene.pbrt`, which includes `settings.pbrt` and `description.pbrt`.
//!
//! Arrays hold spaces and never commas: rs_pbrt 0.9.12 drops an array with commas together with every later parameter
//! of its directive, in silence, and pbrt-v4 refuses it. Every file ends with a line end, without which rs_pbrt panics.

use std::io::{self, Write};

use super::names::{self, Version};
use super::statements;
use crate::files::Sink;
use crate::formats::shared::camera;
use crate::formats::shared::coat::{self, Coat, Mapped};
use crate::formats::shared::images;
use crate::formats::shared::names::{Words, file_stem};
use crate::formats::shared::number::{Num, Row, count};
use crate::formats::shared::text::{self, Head, Line, Quoted};
use crate::formats::{self, Emission};
use crate::ir::{
    Affine, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Film, Filter, Group, Instance, Integrator,
    LightKind, LightSource, Material, Sampler, Scene, Shape, Texture,
};

/// Writes all files of the target.
pub fn emit(version: Version, emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let head = Head { scene: &scene.name, target: version.target() }.to_string();
    let head = Line(&head).to_string();
    text::file(sink, "scene.pbrt", |out| {
        writeln!(out, "# {head}")?;
        writeln!(out, "Include \"settings.pbrt\"\nInclude \"description.pbrt\"")
    })?;
    text::file(sink, "settings.pbrt", |out| {
        writeln!(out, "# {head}")?;
        settings(version, emission, out)
    })?;
    text::file(sink, "description.pbrt", |out| {
        writeln!(out, "# {head}")?;
        description(version, emission, out)
    })?;
    images::write_own(scene, version.images(), sink)
}

fn settings(version: Version, emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (scene, given): (&Scene, _) = (emission.scene, emission.statements);
    let camera = &scene.cameras[emission.camera];
    let mut own = |name: &str, write: &dyn Fn(&mut dyn Write) -> io::Result<()>| match given.find(name) {
        Some(statement) => statements::write(version, statement, out),
        None => write(out),
    };
    // PBRT has no clipping distances.
    let Camera { name: _, eye, target, up, fov_x, near: _, far: _ } = camera;
    own("Scale", &|out| writeln!(out, "# PBRT's camera is left-handed: x is mirrored first.\nScale -1 1 1"))?;
    own("LookAt", &|out| {
        let [eye, target, up] = [eye, target, up].map(|vector| Row(vector, " ").to_string());
        writeln!(out, "LookAt {eye}  {target}  {up}")
    })?;
    own("Camera", &|out| {
        let fov = names::fov(*fov_x, &scene.film);
        writeln!(out, "Camera \"perspective\" \"float fov\" [{}]", Num(fov))
    })?;
    own("Film", &|out| film(version, scene, out))?;
    own("PixelFilter", &|out| filter(version, &scene.film.filter, out))?;
    own("Sampler", &|out| sampler(version, &scene.sampler, out))?;
    own("Integrator", &|out| integrator(version, scene, count(scene.sampler.samples()), out))?;
    statements::others(given).try_for_each(|statement| statements::write(version, statement, out))
}

fn film(version: Version, scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let Film { width, height, filter: _ } = &scene.film;
    let (film, ending, more) = version.names().film;
    writeln!(
        out,
        "Film \"{film}\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]{more} \"string filename\" \
         [\"{}.{ending}\"]",
        count(*width),
        count(*height),
        file_stem(&scene.name)
    )
}

fn filter(version: Version, filter: &Filter, out: &mut dyn Write) -> io::Result<()> {
    let (x, y) = version.names().filter_radius;
    match filter {
        Filter::Box { radius } => {
            let radius = Num(*radius);
            writeln!(out, "PixelFilter \"box\" \"float {x}\" [{radius}] \"float {y}\" [{radius}]")
        }
        Filter::Gaussian { stddev, radius } => {
            let radius = Num(*radius);
            let (name, width) = match version {
                Version::V3 => ("alpha", names::gaussian_alpha(*stddev)),
                Version::V4 => ("sigma", *stddev),
            };
            writeln!(
                out,
                "PixelFilter \"gaussian\" \"float {x}\" [{radius}] \"float {y}\" [{radius}] \"float {name}\" [{}]",
                Num(width)
            )
        }
    }
}

fn sampler(version: Version, sampler: &Sampler, out: &mut dyn Write) -> io::Result<()> {
    let (sampler, samples, seed) = match sampler {
        Sampler::Independent { samples, seed } => (version.names().sampler, *samples, *seed),
        Sampler::Sobol { samples, seed } => ("sobol", *samples, *seed),
    };
    if seed != 0 {
        // v3 has no seed; v4 reads `--seed` only where the file gives none.
        writeln!(out, "# The seed is {seed}: pbrt-v4 takes it as `--seed {seed}`.")?;
    }
    writeln!(out, "Sampler \"{sampler}\" \"integer pixelsamples\" [{}]", count(samples))
}

fn integrator(version: Version, scene: &Scene, samples: u32, out: &mut dyn Write) -> io::Result<()> {
    let names = version.names();
    let mut write = |kind: &str, depth: u32, more: &str| {
        writeln!(out, "Integrator \"{kind}\" \"integer maxdepth\" [{depth}]{more}")
    };
    let depth = |segments: &u32| names::max_depth(count(*segments));
    match &scene.integrator {
        Integrator::Path { max_depth } => write("path", depth(max_depth), &names::path(version, scene)),
        Integrator::Bidirectional { max_depth } => write("bdpt", depth(max_depth), names.bidirectional),
        Integrator::LightTracing { max_depth } => match names.light_tracing {
            Some(kind) => write(kind, depth(max_depth), ""),
            None => {
                writeln!(out, "# {}", text::replaced(&scene.integrator, version.target()))?;
                let (depth, more) = (depth(max_depth), names::path(version, scene));
                writeln!(out, "Integrator \"path\" \"integer maxdepth\" [{depth}]{more}")
            }
        },
        Integrator::Metropolis { max_depth } => {
            let more = format!(" \"integer mutationsperpixel\" [{samples}]{}", names.metropolis);
            write("mlt", depth(max_depth), &more)
        }
        Integrator::PhotonMap { max_depth } => {
            let passes = names.passes.map(|name| format!(" \"integer {name}\" [{samples}]")).unwrap_or_default();
            let more = format!("{passes} \"float radius\" [{}]", Num(camera::photon_radius(scene)));
            write("sppm", names::photon_depth(count(*max_depth)), &more)
        }
    }
}

fn description(version: Version, emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let meshes = emission.meshes;
    let materials = Words::default().assign(scene.materials.values().map(|material| material.name.as_str()));
    let files = formats::mesh_files(scene);
    writeln!(out, "WorldBegin\n")?;
    let ids = Words::default().assign(scene.textures.values().map(|texture| texture.name.as_str()));
    let mut textures = Vec::new();
    let painted = images::on_surfaces(scene);
    for ((handle, item), id) in scene.textures.iter().zip(ids) {
        if painted[handle.index()] {
            let path = images::path(emission, handle, images::Use::Surface, version.images());
            texture(version, item, &id, &path.unwrap_or_default(), out)?;
        }
        textures.push(id);
    }
    for (item, id) in scene.materials.values().zip(&materials) {
        let Material { name, bsdf, sides: _ } = item;
        if name != id {
            writeln!(out, "# {}", Line(name))?;
        }
        material(version, bsdf, id, &textures, out)?;
    }
    for item in scene.lights.values() {
        let LightSource { name, kind } = item;
        writeln!(out, "\n# {}", Line(name))?;
        let image = images::sky_path(emission, kind, version.images());
        light(version, kind, image.as_deref().unwrap_or_default(), out)?;
    }
    let surface = |shape: &Shape, out: &mut dyn Write| {
        let Shape { name, mesh, transform, material, emission } = shape;
        let file = format!("{meshes}{}", files[mesh.index()]);
        writeln!(out, "\n# {}\nAttributeBegin", Line(name))?;
        placed(transform, out)?;
        writeln!(out, "\tNamedMaterial \"{}\"", materials[material.index()])?;
        if let Some(Light { radiance }) = emission {
            writeln!(out, "\tAreaLightSource \"diffuse\" {}", light_color(version, "L", radiance))?;
        }
        writeln!(out, "\tShape \"plymesh\" \"string filename\" [{}]", Quoted(&file))?;
        writeln!(out, "AttributeEnd")
    };
    let groups = Words::default().assign(scene.groups.values().map(|group| group.name.as_str()));
    for (group, id) in scene.groups.values().zip(&groups) {
        let Group { name, shapes, instances: _ } = group;
        if name != id {
            write!(out, "\n# {}", Line(name))?;
        }
        writeln!(out, "\nObjectBegin \"{id}\"")?;
        shapes.values().try_for_each(|shape| surface(shape, out))?;
        writeln!(out, "ObjectEnd")?;
    }
    scene.shapes.values().try_for_each(|shape| surface(shape, out))?;
    for instance in scene.instances.values() {
        let Instance { name: _, group, places: _ } = instance;
        for (name, place) in instance.named() {
            writeln!(out, "\n# {}\nAttributeBegin", Line(&name))?;
            placed(place, out)?;
            writeln!(out, "\tObjectInstance \"{}\"", groups[group.index()])?;
            writeln!(out, "AttributeEnd")?;
        }
    }
    if version.names().world_end {
        writeln!(out, "\nWorldEnd")?;
    }
    Ok(())
}

/// A light without a surface. v4 divides each of them by the luminance of its white, as it does with emitting surfaces, so
/// that the numbers pass through as long as there is neither `scale` nor `power` nor `illuminance` (`lights.cpp`, `Create`
/// of each light). Light of `distant` goes from `from` to `to`, and `L` is the irradiance across it (`Sample_Li`).
fn light(version: Version, kind: &LightKind, image: &str, out: &mut dyn Write) -> io::Result<()> {
    let point = version.names().point;
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint, turn } => {
            let tint = tint.rgb();
            let (file, still, more) = match version {
                Version::V3 => {
                    let more =
                        if tint == [1.0; 3] { String::new() } else { format!(" \"rgb L\" [{}]", Row(&tint, " ")) };
                    ("mapname", names::ENVIRONMENT, more)
                }
                // The image is laid by the Scene's own directions.
                Version::V4 => {
                    let (scale, _) = images::split(tint);
                    let more = if scale == 1.0 { String::new() } else { format!(" \"float scale\" [{}]", Num(scale)) };
                    ("filename", Affine::IDENTITY, more)
                }
            };
            writeln!(out, "AttributeBegin")?;
            placed(&still.then(turn), out)?;
            writeln!(out, "\tLightSource \"infinite\" \"string {file}\" [{}]{more}", Quoted(image))?;
            writeln!(out, "AttributeEnd")
        }
        LightKind::Environment { radiance: ColorOrTexture::Color(radiance), tint: _, turn: _ } => {
            writeln!(out, "LightSource \"infinite\" {}", light_color(version, "L", radiance))
        }
        LightKind::Point { position, intensity } => {
            let from = Row(position, " ");
            writeln!(out, "LightSource \"point\" \"{point} from\" [{from}] {}", light_color(version, "I", intensity))
        }
        LightKind::Spot { position, target, intensity, angle, inner } => writeln!(
            out,
            "LightSource \"spot\" \"{point} from\" [{}] \"{point} to\" [{}] {} \"float coneangle\" [{}] \"float \
             conedeltaangle\" [{}]",
            Row(position, " "),
            Row(target, " "),
            light_color(version, "I", intensity),
            Num(*angle),
            Num(angle - inner)
        ),
        LightKind::Directional { direction, irradiance } => writeln!(
            out,
            "LightSource \"distant\" \"{point} from\" [0 0 0] \"{point} to\" [{}] {}",
            Row(direction, " "),
            light_color(version, "L", irradiance)
        ),
    }
}

/// An image. Both versions turn it over, so that v grows upwards in it (`ImageTexture` of both).
fn texture(version: Version, texture: &Texture, id: &str, path: &str, out: &mut dyn Write) -> io::Result<()> {
    let path = Quoted(path);
    let name = if texture.name == id { String::new() } else { format!("# {}\n", Line(&texture.name)) };
    let more = names::lookup(version, texture);
    writeln!(
        out,
        "{name}Texture \"{id}\" \"spectrum\" \"imagemap\" \"string filename\" [{path}] \"string wrap\" [\"repeat\"] {more}"
    )
}

/// A color, or the texture that says it, as the parameter `name`.
fn paint(version: Version, name: &str, value: &ColorOrTexture, textures: &[String]) -> String {
    match value {
        ColorOrTexture::Color(color) => self::color(version, name, color),
        ColorOrTexture::Texture(texture) => format!("\"texture {name}\" [\"{}\"]", textures[texture.index()]),
    }
}

fn material(version: Version, bsdf: &Bsdf, id: &str, textures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let names = version.names();
    let made = format!("MakeNamedMaterial \"{id}\" \"string type\" ");
    match bsdf {
        Bsdf::Diffuse { reflectance } => {
            let (kind, name, more) = names.diffuse;
            writeln!(out, "{made}[\"{kind}\"] {}{more}", paint(version, name, reflectance, textures))
        }
        Bsdf::Conductor { eta, k, alpha } => writeln!(
            out,
            "{made}[\"{}\"] {} {} \"float roughness\" [{}] {}",
            names.conductor,
            color(version, "eta", eta),
            color(version, "k", k),
            Num(*alpha),
            names.plain_roughness
        ),
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let (kind, more) = names.dielectric;
            // Only the ratio matters: the surroundings of a PBRT dielectric have index 1.
            let eta = Num(interior / exterior);
            write!(out, "{made}[\"{kind}\"]{more} \"float eta\" [{eta}]")?;
            if *alpha != 0.0 {
                let (alpha, plain) = (Num(*alpha), names.plain_roughness);
                write!(out, " \"float uroughness\" [{alpha}] \"float vroughness\" [{alpha}] {plain}")?;
            }
            writeln!(out)
        }
        Bsdf::Mirror { reflectance } => {
            let (kind, name, more) = names.mirror;
            writeln!(out, "{made}[\"{kind}\"] {}{more}", color(version, name, reflectance))
        }
        Bsdf::Plastic { reflectance, ior, alpha } => match version {
            Version::V3 => {
                let seen = |share| Coat::new(*ior).seen(share);
                let base = coated("Kd", reflectance, seen, version, id, textures, out)?;
                let specular = rgb(&Color::Grey(coat::normal_reflectance(*ior)));
                let (alpha, plain) = (Num(*alpha), names.plain_roughness);
                writeln!(
                    out,
                    "{made}[\"substrate\"] {base} \"rgb Ks\" [{specular}] \"float uroughness\" [{alpha}] \"float vroughness\" \
                     [{alpha}] {plain}"
                )
            }
            Version::V4 => {
                let base = paint(version, "reflectance", reflectance, textures);
                writeln!(out, "{made}{}", coat_over(&base, *ior, *alpha))
            }
        },
        Bsdf::Principled { base, metallic, roughness, ior } => match version {
            Version::V3 => writeln!(
                out,
                "{made}[\"disney\"] {} \"float metallic\" [{}] \"float roughness\" [{}] \"float eta\" [{}] \"float \
                 speculartint\" [0] \"float sheen\" [0] \"float clearcoat\" [0] \"float spectrans\" [0]",
                paint(version, "color", base, textures),
                Num(*metallic),
                Num(*roughness),
                Num(*ior)
            ),
            Version::V4 => {
                let alpha = roughness * roughness;
                // The coat darkens its base: what is seen of this one is the color that is asked for.
                let coat = if *metallic < 1.0 {
                    let base =
                        coated("reflectance", base, |share| Coat::new(*ior).base(share), version, id, textures, out)?;
                    coat_over(&base, *ior, alpha)
                } else {
                    String::new()
                };
                let metal = format!(
                    "[\"conductor\"] {} \"float roughness\" [{}] {}",
                    paint(version, "reflectance", base, textures),
                    Num(alpha),
                    names.plain_roughness
                );
                if *metallic <= 0.0 {
                    return writeln!(out, "{made}{coat}");
                }
                if *metallic >= 1.0 {
                    return writeln!(out, "{made}{metal}");
                }
                // Names with a blank are no words, so that no other material has them.
                writeln!(out, "MakeNamedMaterial \"{id} coat\" \"string type\" {coat}")?;
                writeln!(out, "MakeNamedMaterial \"{id} metal\" \"string type\" {metal}")?;
                let parts = format!("[\"{id} coat\" \"{id} metal\"]");
                writeln!(out, "{made}[\"mix\"] \"string materials\" {parts} \"float amount\" [{}]", Num(*metallic))
            }
        },
    }
}

/// v4's coat over a diffuse base: its type and parameters.
fn coat_over(base: &str, ior: f64, alpha: f64) -> String {
    let plain = Version::V4.names().plain_roughness;
    let (ior, alpha, thickness) = (Num(ior), Num(alpha), Num(names::THICKNESS));
    format!(
        "[\"coateddiffuse\"] {base} \"float eta\" [{ior}] \"float roughness\" [{alpha}] {plain} \"float thickness\" [{thickness}]"
    )
}

/// A color through `map` as the parameter `name`; a texture through a factor, as a texture of its own that is written here.
fn coated(
    name: &str,
    value: &ColorOrTexture,
    map: impl Fn(f64) -> f64,
    version: Version,
    id: &str,
    textures: &[String],
    out: &mut dyn Write,
) -> io::Result<String> {
    match coat::mapped(value, &map) {
        Mapped::Color(color) => Ok(format!("\"rgb {name}\" [{}]", rgb(&color))),
        Mapped::Texture(texture, factor) => {
            let image = &textures[texture.index()];
            let more = match version {
                Version::V3 => {
                    format!("\"texture tex1\" [\"{image}\"] \"rgb tex2\" [{}]", rgb(&Color::Grey(factor)))
                }
                Version::V4 => format!("\"texture tex\" [\"{image}\"] \"float scale\" [{}]", Num(factor)),
            };
            writeln!(out, "Texture \"{id} base\" \"spectrum\" \"scale\" {more}")?;
            Ok(format!("\"texture {name}\" [\"{id} base\"]"))
        }
    }
}

/// The transform of a shape or instance, by columns as PBRT writes matrices.
fn placed(transform: &Affine, out: &mut dyn Write) -> io::Result<()> {
    if *transform == Affine::IDENTITY {
        return Ok(());
    }
    let Affine { rows } = transform;
    let [x, y, z] = rows.map(|row| row[3]);
    if *transform == Affine::translation([x, y, z]) {
        return writeln!(out, "\tTranslate {}", Row(&[x, y, z], " "));
    }
    write!(out, "\tConcatTransform [")?;
    for column in 0..4 {
        let entries = rows.map(|row| row[column]);
        write!(out, "{} {}", Row(&entries, " "), if column == 3 { "1]" } else { "0  " })?;
    }
    writeln!(out)
}

/// A color as the parameter `name`. v3 is built for RGB, and takes a reflectance's spectrum for that of a light (`FromSampled`), so
/// that it gets RGB.
fn color(version: Version, name: &str, color: &Color) -> String {
    match (version, color) {
        (Version::V4, Color::Spectrum(spectrum)) => {
            format!("\"spectrum {name}\" [{}]", Row(names::samples(spectrum.points()).as_flattened(), " "))
        }
        (Version::V3 | Version::V4, _) => format!("\"rgb {name}\" [{}]", rgb(color)),
    }
}

/// The strength of a light. v4 divides a spectrum by its luminance, which `scale` gives back (`SpectrumToPhotometric`).
fn light_color(version: Version, name: &str, strength: &Color) -> String {
    let written = color(version, name, strength);
    match (version, strength) {
        (Version::V4, Color::Spectrum(spectrum)) => {
            format!("{written} \"float scale\" [{}]", Num(spectrum.luminance()))
        }
        (Version::V3 | Version::V4, _) => written,
    }
}

fn rgb(color: &Color) -> String {
    Row(&color.rgb(), " ").to_string()
}
