//! Scene to Mitsuba XML: `scene.xml`, which includes `settings.xml` and `description.xml`.

use std::borrow::Cow;
use std::io::{self, Write};

use super::names::{
    DEFAULT_CLIPPING, ENVIRONMENT, Names, PHOTON_ALPHA, RR_DEPTH, Version, emitter as plugin, photon_depth,
};
use super::statements;
use crate::files::Sink;
use crate::formats::shared::camera;
use crate::formats::shared::images::{self, Form};
use crate::formats::shared::names::Words;
use crate::formats::shared::number::{Num, Row, count};
use crate::formats::shared::text::{self, Head, Xml, XmlComment};
use crate::formats::{self, Emission};
use crate::ir::{
    Affine, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Encoding, Film, Filter, Group, Instance,
    Integrator, LightKind, LightSource, Material, Mesh, Sampler, Scene, Shape, Texture, sub,
};

/// Writes all files of the target.
pub fn emit(version: Version, emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let scene: &Scene = emission.scene;
    let head = Head { scene: &scene.name, target: version.target() }.to_string();
    text::file(sink, "scene.xml", |out| {
        open(version, &head, out)?;
        writeln!(out, "\t<include filename=\"settings.xml\"/>")?;
        writeln!(out, "\t<include filename=\"description.xml\"/>")?;
        close(out)
    })?;
    text::file(sink, "settings.xml", |out| {
        open(version, &head, out)?;
        settings(version, emission, out)?;
        close(out)
    })?;
    text::file(sink, "description.xml", |out| {
        open(version, &head, out)?;
        description(version, emission, out)?;
        close(out)
    })?;
    images::write_own(scene, version.images(), sink)
}

fn open(version: Version, head: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>")?;
    writeln!(out, "{}", XmlComment(head))?;
    writeln!(out, "<scene version=\"{}\">", version.number())
}

fn close(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "</scene>")
}

fn settings(version: Version, emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names = version.names();
    let (scene, given): (&Scene, _) = (emission.scene, emission.statements);
    let camera = &scene.cameras[emission.camera];
    let (sampler, samples, seed) = sampler(names, scene);
    let seed_name = if sampler == "sobol" { Some("scramble") } else { names.seed };
    let own = (i64::from(count(samples)), seed_name.map(|name| (name, i64::from(seed))));
    let own_sampler = given.find("sampler");
    let (samples, seed) = own_sampler.map_or(own, |sampler| statements::sampling(version, sampler));
    // `mitsuba -Dsamples=64` replaces a default (Mitsuba 0.5 manual, section 5.2; `scenehandler.cpp` keeps the value
    // of the command line where there is one).
    writeln!(out, "\t<default name=\"samples\" value=\"{samples}\"/>")?;
    if let Some((_, seed)) = seed {
        writeln!(out, "\t<default name=\"seed\" value=\"{seed}\"/>")?;
    }
    writeln!(out)?;
    match given.find("integrator") {
        Some(statement) => statements::write(statement, 1, &[], out, &mut nothing)?,
        None => integrator(version, scene, out)?,
    }
    let Camera { name: _, eye, target, up, fov_x, near: _, far: _ } = camera;
    writeln!(out, "\n\t<sensor type=\"perspective\">")?;
    float(out, 2, "fov", *fov_x)?;
    string(out, 2, names.fov_axis, "x")?;
    let (near, far) = camera::clipping(scene, camera, DEFAULT_CLIPPING);
    if let Some(near) = near {
        float(out, 2, names.near_clip, near)?;
    }
    if let Some(far) = far {
        float(out, 2, names.far_clip, far)?;
    }
    writeln!(out, "\t\t<transform name=\"{}\">", names.to_world)?;
    writeln!(
        out,
        "\t\t\t<lookat origin=\"{}\" target=\"{}\" up=\"{}\"/>",
        Row(eye, ", "),
        Row(target, ", "),
        Row(up, ", ")
    )?;
    writeln!(out, "\t\t</transform>")?;
    let sampling: Vec<(&str, &str)> =
        [(names.sample_count, "$samples")].into_iter().chain(seed.map(|(name, _)| (name, "$seed"))).collect();
    match own_sampler {
        Some(statement) => statements::write(statement, 2, &sampling, out, &mut nothing)?,
        None => {
            writeln!(out, "\t\t<sampler type=\"{sampler}\">")?;
            for (name, value) in sampling {
                integer(out, 3, name, value)?;
            }
            writeln!(out, "\t\t</sampler>")?;
        }
    }
    let mut rfilter = |out: &mut dyn Write| match given.find("rfilter") {
        Some(statement) => statements::write(statement, 3, &[], out, &mut nothing),
        None => rfilter(names, &scene.film.filter, out),
    };
    match given.find("film") {
        Some(statement) => statements::write(statement, 2, &[], out, &mut rfilter)?,
        None => film(names, &scene.film, out, &mut rfilter)?,
    }
    writeln!(out, "\t</sensor>")?;
    statements::others(given).try_for_each(|statement| {
        writeln!(out)?;
        statements::write(statement, 1, &[], out, &mut nothing)
    })
}

/// What stands in an element beside its parameters: nothing.
fn nothing(_: &mut dyn Write) -> io::Result<()> {
    Ok(())
}

/// The plugin that takes the samples, their number, and the seed.
fn sampler(names: &Names, scene: &Scene) -> (&'static str, u32, u32) {
    // `pssmlt` refuses every other sampler than this ("requires the independent sampler"), `sppm` makes its own, and the
    // particles of `ptracer` have no pixel that a Sobol sequence could be scaled to.
    let own = match &scene.integrator {
        Integrator::Path { max_depth: _ } | Integrator::Bidirectional { max_depth: _ } => false,
        Integrator::LightTracing { max_depth: _ }
        | Integrator::Metropolis { max_depth: _ }
        | Integrator::PhotonMap { max_depth: _ } => true,
    };
    match &scene.sampler {
        Sampler::Sobol { samples, seed } if names.light_paths && !own => ("sobol", *samples, *seed),
        Sampler::Independent { samples, seed } | Sampler::Sobol { samples, seed } => ("independent", *samples, *seed),
    }
}

fn integrator(version: Version, scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let names = version.names();
    let open = |plugin: &str, max_depth: u32, out: &mut dyn Write| {
        writeln!(out, "\t<integrator type=\"{plugin}\">")?;
        integer(out, 2, names.max_depth, &count(max_depth).to_string())?;
        integer(out, 2, names.rr_depth, &RR_DEPTH.to_string())
    };
    match &scene.integrator {
        Integrator::Path { max_depth } => open("path", *max_depth, out)?,
        Integrator::LightTracing { max_depth } => open("ptracer", *max_depth, out)?,
        Integrator::Bidirectional { max_depth } if names.light_paths => open("bdpt", *max_depth, out)?,
        Integrator::Metropolis { max_depth } if names.light_paths => {
            open("pssmlt", *max_depth, out)?;
            writeln!(out, "\t\t<boolean name=\"bidirectional\" value=\"true\"/>")?;
            // Direct light is else computed by 16 samples of another algorithm, however many are asked for.
            integer(out, 2, "directSamples", "-1")?;
        }
        Integrator::PhotonMap { max_depth } if names.light_paths => {
            open("sppm", photon_depth(*max_depth), out)?;
            // As many photons in a pass as there are pixels, which is PBRT's default; Mitsuba's is 250000.
            let Film { width, height, filter: _ } = &scene.film;
            let photons = count(width.saturating_mul(*height));
            integer(out, 2, "photonCount", &photons.to_string())?;
            integer(out, 2, "maxPasses", "$samples")?;
            float(out, 2, "initialRadius", camera::photon_radius(scene))?;
            float(out, 2, "alpha", PHOTON_ALPHA)?;
        }
        other @ (Integrator::Bidirectional { max_depth }
        | Integrator::Metropolis { max_depth }
        | Integrator::PhotonMap { max_depth }) => {
            let note = text::replaced(other, version.target());
            writeln!(out, "\t{}", XmlComment(&note))?;
            open("path", *max_depth, out)?;
        }
    }
    writeln!(out, "\t</integrator>")
}

fn film(
    names: &Names,
    film: &Film,
    out: &mut dyn Write,
    rfilter: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let Film { width, height, filter: _ } = film;
    writeln!(out, "\t\t<film type=\"hdrfilm\">")?;
    integer(out, 3, "width", &count(*width).to_string())?;
    integer(out, 3, "height", &count(*height).to_string())?;
    string(out, 3, names.pixel_format, "rgb")?;
    // The default of all versions, float16, rounds to 0.05 %.
    string(out, 3, names.component_format, "float32")?;
    if let Some(banner) = names.banner {
        writeln!(out, "\t\t\t<boolean name=\"{banner}\" value=\"false\"/>")?;
    }
    rfilter(out)?;
    writeln!(out, "\t\t</film>")
}

fn rfilter(names: &Names, filter: &Filter, out: &mut dyn Write) -> io::Result<()> {
    match filter {
        Filter::Box { radius } => match names.box_radius.filter(|_| *radius != 0.5) {
            Some(name) => {
                writeln!(out, "\t\t\t<rfilter type=\"box\">")?;
                float(out, 4, name, *radius)?;
                writeln!(out, "\t\t\t</rfilter>")
            }
            None => writeln!(out, "\t\t\t<rfilter type=\"box\"/>"),
        },
        Filter::Gaussian { stddev, radius: _ } => {
            writeln!(out, "\t\t\t<rfilter type=\"gaussian\">")?;
            float(out, 4, "stddev", *stddev)?;
            writeln!(out, "\t\t\t</rfilter>")
        }
    }
}

fn description(version: Version, emission: &Emission<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names = version.names();
    let scene: &Scene = emission.scene;
    // Everything shares one space of ids. Shapes within a group need none: nothing refers to them.
    let mut words = Words::default();
    let materials = words.assign(scene.materials.values().map(|material| material.name.as_str()));
    let groups = words.assign(scene.groups.values().map(|group| group.name.as_str()));
    let shapes = words.assign(scene.shapes.values().map(|shape| shape.name.as_str()));
    let textures = words.assign(scene.textures.values().map(|texture| texture.name.as_str()));
    let painted = images::on_surfaces(scene);
    for ((handle, item), id) in scene.textures.iter().zip(&textures).filter(|((handle, _), _)| painted[handle.index()])
    {
        comment(&item.name, id, out)?;
        let path = images::path(emission, handle, images::Use::Surface, version.images()).unwrap_or_default();
        texture(names, item, id, &path, out)?;
    }
    let placed_names: Vec<Cow<'_, str>> =
        scene.instances.values().flat_map(|instance| instance.named().map(|(name, _)| name)).collect();
    let mut instances = words.assign(placed_names.iter().map(Cow::as_ref)).into_iter();
    for (item, id) in scene.materials.values().zip(&materials) {
        comment(&item.name, id, out)?;
        material(names, item, id, &textures, out)?;
    }
    writeln!(out)?;
    let lights = words.assign(scene.lights.values().map(|light| light.name.as_str()));
    let surfaces = Surfaces { names, scene, materials, files: formats::mesh_files(scene), folder: emission.meshes };
    for (group, id) in scene.groups.values().zip(&groups) {
        let Group { name, shapes, instances: _ } = group;
        comment(name, id, out)?;
        writeln!(out, "\t<shape type=\"shapegroup\" id=\"{id}\">")?;
        for shape in shapes.values() {
            writeln!(out, "\t\t{}", XmlComment(&shape.name))?;
            surfaces.write(shape, None, 2, out)?;
        }
        writeln!(out, "\t</shape>")?;
    }
    for (shape, id) in scene.shapes.values().zip(&shapes) {
        comment(&shape.name, id, out)?;
        surfaces.write(shape, Some(id), 1, out)?;
    }
    for (light, id) in scene.lights.values().zip(&lights) {
        let LightSource { name, kind } = light;
        comment(name, id, out)?;
        let file = images::sky_path(emission, kind, version.images());
        emitter(names, kind, (id, file.as_deref()), out)?;
    }
    for instance in scene.instances.values() {
        // The id says enough: thousands of comments would only make the file larger.
        let Instance { name: _, group, places } = instance;
        for (place, id) in places.maps().iter().zip(&mut instances) {
            writeln!(out, "\t<shape type=\"instance\" id=\"{id}\">")?;
            writeln!(out, "\t\t<ref id=\"{}\"/>", groups[group.index()])?;
            placed(names, place, 2, out)?;
            writeln!(out, "\t</shape>")?;
        }
    }
    Ok(())
}

/// What every shape needs to know of the scene.
struct Surfaces<'a> {
    names: &'a Names,
    scene: &'a Scene,
    /// The ids of the materials.
    materials: Vec<String>,
    /// The names of the mesh files.
    files: Vec<String>,
    /// Where these lie, with a final `/`.
    folder: &'a str,
}

impl Surfaces<'_> {
    fn write(&self, shape: &Shape, id: Option<&str>, depth: usize, out: &mut dyn Write) -> io::Result<()> {
        let Self { names, scene, materials, files, folder } = self;
        let Shape { name: _, mesh, transform, material, emission } = shape;
        indent(out, depth)?;
        match id {
            Some(id) => writeln!(out, "<shape type=\"ply\" id=\"{id}\">")?,
            None => writeln!(out, "<shape type=\"ply\">")?,
        }
        string(out, depth + 1, "filename", &format!("{folder}{}", files[mesh.index()]))?;
        let Mesh { name: _, positions: _, normals, uvs: _, triangles: _ } = &scene.meshes[*mesh];
        if normals.is_none() {
            // Without this Mitsuba makes smooth normals for a file that has none.
            indent(out, depth + 1)?;
            writeln!(out, "<boolean name=\"{}\" value=\"true\"/>", names.face_normals)?;
        }
        placed(names, transform, depth + 1, out)?;
        indent(out, depth + 1)?;
        writeln!(out, "<ref id=\"{}\"/>", materials[material.index()])?;
        if let Some(Light { radiance }) = emission {
            indent(out, depth + 1)?;
            writeln!(out, "<emitter type=\"area\">")?;
            rgb(out, depth + 2, "radiance", radiance)?;
            indent(out, depth + 1)?;
            writeln!(out, "</emitter>")?;
        }
        indent(out, depth)?;
        writeln!(out, "</shape>")
    }
}

/// A light without a surface. `direction` is where the light goes, and `irradiance` that of a surface across it, in all
/// versions (`directional.cpp` of 0.6 and 3.9.1; measured with 3.9.1).
fn emitter(names: &Names, kind: &LightKind, (id, image): (&str, Option<&str>), out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\t<emitter type=\"{}\" id=\"{id}\">", plugin(kind))?;
    let vector = |tag: &str, name: &str, [x, y, z]: [f64; 3], out: &mut dyn Write| {
        writeln!(out, "\t\t<{tag} name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", Num(x), Num(y), Num(z))
    };
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Color(radiance), tint: _, turn: _ } => {
            rgb(out, 2, "radiance", radiance)?
        }
        LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint, turn } => {
            string(out, 2, "filename", image.unwrap_or_default())?;
            let (scale, _) = images::split(tint.rgb());
            if scale != 1.0 {
                float(out, 2, "scale", scale)?;
            }
            placed(names, &ENVIRONMENT.then(turn), 2, out)?;
        }
        LightKind::Point { position, intensity } => {
            vector("point", "position", *position, out)?;
            rgb(out, 2, "intensity", intensity)?;
        }
        LightKind::Spot { position, target, intensity, angle, inner } => {
            let (cutoff, beam) = names.spot;
            // The light shines along its z, and looks the same from all sides of it.
            let up = camera::across(sub(*target, *position));
            writeln!(out, "\t\t<transform name=\"{}\">", names.to_world)?;
            let [from, to, up] = [position, target, &up].map(|vector| Row(vector, ", ").to_string());
            writeln!(out, "\t\t\t<lookat origin=\"{from}\" target=\"{to}\" up=\"{up}\"/>")?;
            writeln!(out, "\t\t</transform>")?;
            rgb(out, 2, "intensity", intensity)?;
            float(out, 2, cutoff, *angle)?;
            float(out, 2, beam, *inner)?;
        }
        LightKind::Directional { direction, irradiance } => {
            vector("vector", "direction", *direction, out)?;
            rgb(out, 2, "irradiance", irradiance)?;
        }
    }
    writeln!(out, "\t</emitter>")
}

/// An image. Mitsuba's v grows downwards in it (measured with 3.9.1; `Texture2D` and `TMIPMap` of 0.6), so it is mirrored.
fn texture(names: &Names, texture: &Texture, id: &str, path: &str, out: &mut dyn Write) -> io::Result<()> {
    let form = images::on_surface(texture, Form::Shared);
    let floats = form.holds_floats(texture);
    writeln!(out, "\t<texture type=\"bitmap\" id=\"{id}\">")?;
    string(out, 2, "filename", path)?;
    string(out, 2, names.filter_type.0, names.filter_type.1)?;
    string(out, 2, names.wrap_mode, "repeat")?;
    let linear = form.encoding(texture) == Encoding::Linear;
    if names.to_uv {
        // Nothing is decoded then; images of floats never are.
        if linear && !floats {
            writeln!(out, "\t\t<boolean name=\"raw\" value=\"true\"/>")?;
        }
        writeln!(out, "\t\t<transform name=\"to_uv\">")?;
        writeln!(out, "\t\t\t<scale x=\"1\" y=\"-1\"/>")?;
        writeln!(out, "\t\t\t<translate x=\"0\" y=\"1\"/>")?;
        writeln!(out, "\t\t</transform>")?;
    } else {
        // -1 is the sRGB curve (`bitmap.cpp` of 0.6).
        float(out, 2, "gamma", if linear { 1.0 } else { -1.0 })?;
        float(out, 2, "vscale", -1.0)?;
        float(out, 2, "voffset", 1.0)?;
    }
    writeln!(out, "\t</texture>")
}

/// A color, or the reference to the texture that says it.
fn paint(out: &mut dyn Write, depth: usize, name: &str, value: &ColorOrTexture, textures: &[String]) -> io::Result<()> {
    match value {
        ColorOrTexture::Color(color) => rgb(out, depth, name, color),
        ColorOrTexture::Texture(texture) => {
            indent(out, depth)?;
            writeln!(out, "<ref name=\"{name}\" id=\"{}\"/>", textures[texture.index()])
        }
    }
}

/// A material within `twosided`, without which a reflecting surface is black from behind.
fn material(names: &Names, material: &Material, id: &str, textures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let Material { name: _, bsdf, sides: _ } = material;
    if bsdf.is_clear() || material.is_one_sided() {
        return scattering(names, bsdf, (1, Some(id)), textures, out);
    }
    writeln!(out, "\t<bsdf type=\"twosided\" id=\"{id}\">")?;
    scattering(names, bsdf, (2, None), textures, out)?;
    writeln!(out, "\t</bsdf>")
}

/// What scatters, `depth` tabs from the left, with its id where nothing around it has one.
fn scattering(
    names: &Names,
    bsdf: &Bsdf,
    (depth, id): (usize, Option<&str>),
    textures: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let inner = depth + 1;
    match bsdf {
        Bsdf::Diffuse { reflectance } => {
            begin(out, depth, "diffuse", id)?;
            paint(out, inner, "reflectance", reflectance, textures)?;
        }
        Bsdf::Conductor { eta, k, alpha } => {
            if *alpha == 0.0 {
                begin(out, depth, "conductor", id)?;
            } else {
                begin(out, depth, "roughconductor", id)?;
                // The default distribution of all versions is Beckmann's.
                string(out, inner, "distribution", "ggx")?;
                float(out, inner, "alpha", *alpha)?;
            }
            rgb(out, inner, "eta", eta)?;
            rgb(out, inner, "k", k)?;
            if let Some(ext_eta) = names.ext_eta {
                float(out, inner, ext_eta, 1.0)?;
            }
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            if *alpha == 0.0 {
                begin(out, depth, "dielectric", id)?;
            } else {
                begin(out, depth, "roughdielectric", id)?;
                string(out, inner, "distribution", "ggx")?;
                float(out, inner, "alpha", *alpha)?;
            }
            float(out, inner, names.int_ior, *interior)?;
            float(out, inner, names.ext_ior, *exterior)?;
        }
        Bsdf::Mirror { reflectance } => {
            begin(out, depth, "conductor", id)?;
            // "none" is the conductor that reflects all light at every angle.
            string(out, inner, "material", "none")?;
            rgb(out, inner, names.specular_reflectance, reflectance)?;
        }
        Bsdf::Plastic { reflectance, ior, alpha } => {
            return plastic(names, (depth, id), reflectance, (*ior, *alpha), true, textures, out);
        }
        Bsdf::Principled { base, metallic, roughness, ior } if names.principled => {
            begin(out, depth, "principled", id)?;
            paint(out, inner, "base_color", base, textures)?;
            float(out, inner, "metallic", *metallic)?;
            float(out, inner, "roughness", *roughness)?;
            float(out, inner, "eta", *ior)?;
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            return blend(names, (depth, id), base, (*metallic, roughness * roughness, *ior), textures, out);
        }
    }
    end(out, depth)
}

/// A base under a coat; `nonlinear` where light that the coat throws back takes the base's color again.
fn plastic(
    names: &Names,
    (depth, id): (usize, Option<&str>),
    reflectance: &ColorOrTexture,
    (ior, alpha): (f64, f64),
    nonlinear: bool,
    textures: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    if alpha == 0.0 {
        begin(out, depth, "plastic", id)?;
    } else {
        begin(out, depth, "roughplastic", id)?;
        string(out, depth + 1, "distribution", "ggx")?;
        float(out, depth + 1, "alpha", alpha)?;
    }
    paint(out, depth + 1, names.diffuse_reflectance, reflectance, textures)?;
    float(out, depth + 1, names.int_ior, ior)?;
    float(out, depth + 1, names.ext_ior, 1.0)?;
    indent(out, depth + 1)?;
    writeln!(out, "<boolean name=\"nonlinear\" value=\"{nonlinear}\"/>")?;
    end(out, depth)
}

/// What stands for a principled material where there is none: a blend of plastic, whose base is not darkened, and of a metal
/// without a Fresnel term.
fn blend(
    names: &Names,
    (outer, own): (usize, Option<&str>),
    base: &ColorOrTexture,
    (metallic, alpha, ior): (f64, f64, f64),
    textures: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mixed = metallic > 0.0 && metallic < 1.0;
    let (depth, id) = if mixed { (outer + 1, None) } else { (outer, own) };
    if mixed {
        begin(out, outer, "blendbsdf", own)?;
        float(out, depth, "weight", metallic)?;
    }
    if metallic < 1.0 {
        plastic(names, (depth, id), base, (ior, alpha), false, textures, out)?;
    }
    if metallic > 0.0 {
        if alpha == 0.0 {
            begin(out, depth, "conductor", id)?;
        } else {
            begin(out, depth, "roughconductor", id)?;
            string(out, depth + 1, "distribution", "ggx")?;
            float(out, depth + 1, "alpha", alpha)?;
        }
        string(out, depth + 1, "material", "none")?;
        paint(out, depth + 1, names.specular_reflectance, base, textures)?;
        end(out, depth)?;
    }
    if mixed { end(out, outer) } else { Ok(()) }
}

fn begin(out: &mut dyn Write, depth: usize, kind: &str, id: Option<&str>) -> io::Result<()> {
    indent(out, depth)?;
    match id {
        Some(id) => writeln!(out, "<bsdf type=\"{kind}\" id=\"{id}\">"),
        None => writeln!(out, "<bsdf type=\"{kind}\">"),
    }
}

fn end(out: &mut dyn Write, depth: usize) -> io::Result<()> {
    indent(out, depth)?;
    writeln!(out, "</bsdf>")
}

/// The transform of a shape or instance, by rows as Mitsuba writes matrices.
fn placed(names: &Names, transform: &Affine, depth: usize, out: &mut dyn Write) -> io::Result<()> {
    if *transform == Affine::IDENTITY {
        return Ok(());
    }
    let Affine { rows } = transform;
    let [x, y, z] = rows.map(|row| row[3]);
    indent(out, depth)?;
    writeln!(out, "<transform name=\"{}\">", names.to_world)?;
    indent(out, depth + 1)?;
    if *transform == Affine::translation([x, y, z]) {
        writeln!(out, "<translate x=\"{}\" y=\"{}\" z=\"{}\"/>", Num(x), Num(y), Num(z))?;
    } else {
        let all = Row(rows.as_flattened(), " ");
        writeln!(out, "<matrix value=\"{all} 0 0 0 1\"/>")?;
    }
    indent(out, depth)?;
    writeln!(out, "</transform>")
}

fn comment(name: &str, id: &str, out: &mut dyn Write) -> io::Result<()> {
    if name == id { Ok(()) } else { writeln!(out, "\t{}", XmlComment(name)) }
}

fn indent(out: &mut dyn Write, depth: usize) -> io::Result<()> {
    (0..depth).try_for_each(|_| out.write_all(b"\t"))
}

fn integer(out: &mut dyn Write, depth: usize, name: &str, value: &str) -> io::Result<()> {
    indent(out, depth)?;
    writeln!(out, "<integer name=\"{name}\" value=\"{value}\"/>")
}

fn float(out: &mut dyn Write, depth: usize, name: &str, value: f64) -> io::Result<()> {
    indent(out, depth)?;
    writeln!(out, "<float name=\"{name}\" value=\"{}\"/>", Num(value))
}

fn string(out: &mut dyn Write, depth: usize, name: &str, value: &str) -> io::Result<()> {
    indent(out, depth)?;
    writeln!(out, "<string name=\"{name}\" value=\"{}\"/>", Xml(value))
}

fn rgb(out: &mut dyn Write, depth: usize, name: &str, value: &Color) -> io::Result<()> {
    indent(out, depth)?;
    writeln!(out, "<rgb name=\"{name}\" value=\"{}\"/>", Row(&value.rgb(), ", "))
}
