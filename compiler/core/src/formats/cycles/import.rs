//! `scene.py` to what it says: geometry, emitters, materials, camera, path depth and image size.
//!
//! The file is not run: it is read as the calls of literals that it consists of. What the called functions do is known, because
//! the file of functions beside it must be ltsc's own.

use std::collections::BTreeMap;

use super::names;
use super::python::{Arguments, Broken, Call, Said, Scanner, Value};
use super::statements::SCENE;
use crate::files::VPath;
use crate::formats::shared::camera::fov_y;
use crate::formats::shared::coat::normal_reflectance;
use crate::formats::shared::number::count;
use crate::formats::shared::reading::{
    Clip, Emitted, Fresnel, Front, Item, Light, MeshPlace, MeshSource, Model, Paint, Part, Reading, Surface, Use, View,
};
use crate::formats::shared::source::{self, REFERENCE, SYNTAX, Source, Text, UNKNOWN, shown};
use crate::ir::{Film, Filter, normalized};

/// Lines that every scene has, and that say nothing about it.
const FIXED: &[&str] = &[
    "import os, sys",
    "sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))",
    "from ltsc_blender import *",
    "if __name__ == \"__main__\":",
    "    finish()",
];

/// Limits of bounces: of all, and per kind of scattering.
const BOUNCES: [&str; 4] =
    ["cycles.max_bounces", "cycles.diffuse_bounces", "cycles.glossy_bounces", "cycles.transmission_bounces"];

/// Attributes with which Cycles computes something else than path tracing does.
const CHANGES: &[&str] = &[
    "cycles.use_fast_gi",
    "cycles.blur_glossy",
    "cycles.light_sampling_threshold",
    "cycles.caustics_reflective",
    "cycles.caustics_refractive",
    "cycles.use_denoising",
    "cycles.use_adaptive_sampling",
    "cycles.film_exposure",
    "render.engine",
];

/// Reads the scene in `main`.
pub fn import(main: &VPath, source: &mut Source<'_>) -> Reading {
    let mut reader = Reader::default();
    reader.reading.native = Some("CYCLES".to_owned());
    functions(main, source);
    let Some(bytes) = source.bytes(main, || source::whole(main)) else { return reader.reading };
    let Some(text) = source::text(source, main, &bytes) else { return reader.reading };
    let to = &mut Said { source, text: Text { path: main, text } };
    if let Err(Broken(at)) = reader.lines(to) {
        to.say(SYNTAX, at, "the line is no call of literals");
    }
    reader.finish(to)
}

/// The file of functions must be the one whose functions are known.
fn functions(main: &VPath, source: &mut Source<'_>) {
    let Some(path) = source.path(main, "ltsc_blender.py", || source::whole(main)) else { return };
    let Some(bytes) = source.bytes(&path, || source::whole(main)) else { return };
    if *bytes != *include_bytes!("ltsc_blender.py") {
        source.say(SYNTAX, source::whole(&path), "the functions are not those of this version of ltsc");
    }
}

#[derive(Default)]
struct Reader {
    reading: Reading,
    /// Bounces that statements of a test case set: of all, and per kind of scattering.
    bounces: [Option<u32>; BOUNCES.len()],
    /// `filter_width` and whether the filter is a Gaussian, by statements of a test case.
    filter: (Option<f64>, Option<bool>),
    textures: BTreeMap<String, Paint>,
    materials: BTreeMap<String, usize>,
    meshes: BTreeMap<String, usize>,
    groups: BTreeMap<String, usize>,
    group: Option<usize>,
    /// The camera without the angle of its height, which the image says.
    view: Option<View>,
}

impl Reader {
    fn lines(&mut self, to: &mut Said<'_, '_, '_>) -> Result<(), Broken> {
        let text = to.text.text;
        let mut at = 0;
        while at < text.len() && !to.source.is_full() {
            let line = text[at..].lines().next().unwrap_or_default();
            let next = text[at..].find('\n').map_or(text.len(), |end| at + end + 1);
            let inner = line.trim_start_matches(' ');
            let indent = line.len() - inner.len();
            if inner.is_empty() || inner.starts_with('#') || FIXED.contains(&line) {
                at = next;
                continue;
            }
            if indent != if self.group.is_some() && indent > 0 { 4 } else { 0 } {
                return Err(Broken(at));
            }
            if indent == 0 {
                self.group = None;
            }
            if let Some(rest) = line.strip_prefix(SCENE).filter(|_| !to.source.given().is_empty()) {
                let Some((attribute, _)) = rest.split_once(" = ") else { return Err(Broken(at)) };
                let mut scanner = Scanner::new(text, at + SCENE.len() + attribute.len() + 3);
                let value = scanner.literal()?;
                if !scanner.line_end("") {
                    return Err(Broken(scanner.at()));
                }
                self.set(attribute, &value, at, to);
                at = scanner.at();
                continue;
            }
            let block = inner.strip_prefix("with ").is_some();
            let mut scanner = Scanner::new(text, at + indent + if block { 5 } else { 0 });
            let call = scanner.call()?;
            if !scanner.line_end(if block { ":" } else { "" }) {
                return Err(Broken(scanner.at()));
            }
            if block != (call.name == "group") {
                return Err(Broken(at));
            }
            self.call(&call, to);
            at = scanner.at();
        }
        Ok(())
    }

    /// What a statement of a test case sets.
    fn set(&mut self, attribute: &str, value: &Value<'_>, at: usize, to: &mut Said<'_, '_, '_>) {
        let number = if let Value::Number(number) = value { Some(*number) } else { None };
        let count = number.filter(|x| x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(x)).map(|x| x as u32);
        let reading = &mut self.reading;
        if let Some(place) = BOUNCES.iter().position(|known| *known == attribute) {
            self.bounces[place] = count;
            reading.replaced.integrator = true;
            return;
        }
        match attribute {
            "cycles.samples" => {
                reading.replaced.sampler = true;
                reading.sampling.samples = count.map(i64::from).into_iter().collect();
            }
            "cycles.seed" => reading.replaced.sampler = true,
            "cycles.pixel_filter_type" => {
                reading.replaced.filter = true;
                self.filter.1 = match value {
                    Value::Text(word) if word == "GAUSSIAN" => Some(true),
                    Value::Text(word) if word == "BOX" => Some(false),
                    Value::Text(_) | Value::Number(_) | Value::Bool(_) | Value::Tuple(_) | Value::Call(_) => None,
                };
            }
            "cycles.filter_width" => {
                reading.replaced.filter = true;
                self.filter.0 = number;
            }
            "render.resolution_x" | "render.resolution_y" => {
                if let (Some([width, height]), Some(count)) = (&mut reading.film, count) {
                    *(if attribute.ends_with('x') { width } else { height }) = count;
                }
            }
            "cycles.sample_clamp_direct" | "cycles.sample_clamp_indirect" => {
                // 0 is no limit; of two the smaller is in force.
                let limit = number.map_or(Some(f64::NAN), |limit| Some(limit).filter(|limit| *limit > 0.0));
                reading.clamped = match (reading.clamped, limit) {
                    (Some(one), Some(other)) => Some(if one.is_nan() { one } else { other.min(one) }),
                    (one, other) => one.or(other),
                };
            }
            "render.use_border" => {
                reading.part = if *value == Value::Bool(true) { Part::Unknown } else { Part::Whole };
            }
            other => {
                if CHANGES.contains(&other) {
                    reading.native = None;
                    reading.replaced.integrator = true;
                }
                let loud = to.source.hush(true);
                to.say(UNKNOWN, at, format!("the attribute `{}` is set", shown(other)));
                to.source.hush(loud);
            }
        }
    }

    /// What statements of a test case make of depth and filter.
    fn replaced(&mut self) {
        if self.bounces.iter().any(Option::is_some) {
            // The functions set all of them alike.
            let own = self.reading.max_depth.map(|depth| depth.saturating_sub(2));
            let depths: Option<Vec<u32>> = self.bounces.iter().map(|said| said.or(own)).collect();
            let depth = depths.and_then(|all| Some(all[0]).filter(|most| all.iter().all(|depth| depth >= most)));
            self.reading.max_depth = depth.map(|bounces| bounces.saturating_add(2));
        }
        if self.reading.replaced.filter {
            let (width, own) = (self.filter.0, self.reading.filter.take());
            self.reading.filter = match (self.filter.1, own, width) {
                (Some(false), _, _) | (None, Some(Filter::Box { radius: _ }), Some(_)) => {
                    Some(Filter::Box { radius: 0.5 })
                }
                (Some(true), _, Some(width)) | (None, Some(Filter::Gaussian { stddev: _, radius: _ }), Some(width)) => {
                    let stddev = names::stddev(width);
                    Some(Filter::Gaussian { stddev, radius: 6.0 * stddev })
                }
                (Some(true), own @ Some(Filter::Gaussian { stddev: _, radius: _ }), None) => own,
                _ => None,
            };
        }
    }

    fn finish(mut self, to: &mut Said<'_, '_, '_>) -> Reading {
        self.replaced();
        match (self.view, self.reading.film) {
            (Some(view), Some([width, height])) if width > 0 && height > 0 => {
                let film = Film { width, height, filter: Filter::Box { radius: 0.5 } };
                // Pixels are square.
                self.reading.view = Some(View { fov_y: fov_y(view.fov_x, &film), ..view });
            }
            _ => to.source.say(SYNTAX, source::whole(to.text.path), "there is no camera, or the image has no size"),
        }
        self.reading
    }

    fn call(&mut self, call: &Call<'_>, to: &mut Said<'_, '_, '_>) {
        let arguments = match call.name {
            "scene" => {
                let arguments = Arguments::new(call, &["name"]);
                arguments.text("name", to);
                arguments
            }
            "film" => {
                let arguments = Arguments::new(call, &["width", "height", "gaussian"]);
                let size = ["width", "height"].map(|name| arguments.count(name, to));
                self.reading.filter =
                    Some(match arguments.get("gaussian").and_then(|_| arguments.float("gaussian", to)) {
                        Some(width) => {
                            let stddev = names::stddev(width);
                            Filter::Gaussian { stddev, radius: 6.0 * stddev }
                        }
                        None => Filter::Box { radius: 0.5 },
                    });
                if let [Some(width), Some(height)] = size {
                    self.reading.film = Some([width, height]);
                }
                arguments
            }
            "path" => {
                let arguments = Arguments::new(call, &["max_depth"]);
                // The functions cannot make paths of one segment: with no bounce there is direct light.
                self.reading.max_depth = arguments.count("max_depth", to);
                self.reading.most = Some(count(u32::MAX));
                arguments
            }
            "sampler" => {
                let arguments = Arguments::new(call, &["samples", "seed"]);
                let samples = arguments.count("samples", to);
                self.reading.sampling.samples.extend(samples.map(i64::from));
                let of: fn(u32) -> i64 = |seed| count(seed).into();
                self.reading.sampling.seed = arguments.count("seed", to).map(|seed| (seed.into(), of));
                arguments
            }
            "camera" => self.camera(call, to),
            "texture" => {
                let arguments = Arguments::new(call, &["name", "file", "linear"]);
                let (name, file) = (arguments.text("name", to), arguments.text("file", to));
                let linear = arguments.get("linear") == Some(&Value::Bool(true));
                if let Some(file) = path(call, file, to) {
                    let image = Paint::Image { file: file.into(), linear, factor: [1.0; 3] };
                    self.textures.insert(name.to_owned(), image);
                }
                arguments
            }
            "material" => {
                let arguments = Arguments::new(call, &["name", "surface"]);
                let name = arguments.text("name", to).to_owned();
                let mut two_sided = true;
                let model = match arguments.get("surface") {
                    Some(Value::Call(outer)) if outer.name == "one_sided" => {
                        two_sided = false;
                        let inner = Arguments::new(outer, &["front"]);
                        let model = match inner.get("front") {
                            Some(Value::Call(surface)) => self.surface(surface, to),
                            Some(Value::Number(_) | Value::Bool(_) | Value::Text(_) | Value::Tuple(_)) | None => {
                                to.say(SYNTAX, outer.at, "the front has no surface");
                                Model::Diffuse { reflectance: Paint::BLACK }
                            }
                        };
                        inner.finish(to);
                        model
                    }
                    Some(Value::Call(surface)) => self.surface(surface, to),
                    Some(Value::Number(_) | Value::Bool(_) | Value::Text(_) | Value::Tuple(_)) | None => {
                        to.say(SYNTAX, call.at, "the material has no surface");
                        Model::Diffuse { reflectance: Paint::BLACK }
                    }
                };
                self.materials.insert(name.clone(), self.reading.materials.len());
                self.reading.materials.push(Surface { name, model, two_sided });
                arguments
            }
            "mesh" => {
                let arguments = Arguments::new(call, &["name", "file"]);
                let (name, file) = (arguments.text("name", to), arguments.text("file", to));
                if let Some(file) = path(call, file, to) {
                    self.meshes.insert(name.to_owned(), self.reading.meshes.len());
                    // Backfacing goes by the winding.
                    let place = MeshPlace::File(file);
                    self.reading.meshes.push(MeshSource { place, front: Front::Winding, flat: None });
                }
                arguments
            }
            "shape" | "emitter" => self.shape(call, to),
            "group" => {
                let arguments = Arguments::new(call, &["name"]);
                self.groups.insert(arguments.text("name", to).to_owned(), self.reading.groups.len());
                self.group = Some(self.reading.groups.len());
                self.reading.groups.push(Vec::new());
                arguments
            }
            "instance" => {
                let arguments = Arguments::new(call, &["name", "group", "matrix"]);
                let name = arguments.text("name", to).to_owned();
                let group = arguments.text("group", to);
                let transform = arguments.matrix("matrix", to);
                match self.groups.get(group) {
                    Some(group) => self.reading.items.push(Item::Instance { name, group: *group, transform }),
                    None => to.say(REFERENCE, call.at, format!("there is no group `{}`", shown(group))),
                }
                arguments
            }
            "environment" | "point" | "directional" | "spot" => self.light(call, to),
            other => {
                to.say(UNKNOWN, call.at, format!("there is no function `{}`", shown(other)));
                return;
            }
        };
        arguments.finish(to);
    }

    fn camera<'c, 't>(&mut self, call: &'c Call<'t>, to: &mut Said<'_, '_, '_>) -> Arguments<'c, 't> {
        let arguments = Arguments::new(call, &["eye", "x", "y", "z", "fov_x", "near", "far"]);
        let [eye, x, y, z] = ["eye", "x", "y", "z"].map(|name| arguments.row(name, to));
        let fov = arguments.float("fov_x", to);
        let [near, far] = ["near", "far"].map(|name| arguments.float(name, to));
        self.reading.clip = Some(Clip { near, far, default: Some(names::DEFAULT_CLIPPING) });
        let axes = [x, y, z].map(|axis| axis.and_then(normalized));
        if let (Some(eye), [Some(right), Some(up), Some(back)], Some(fov_x)) = (eye, axes, fov) {
            let forward = back.map(|part| -part);
            self.view = Some(View { eye, right, up, forward, fov_x, fov_y: fov_x, shift: [0.0; 2] });
        } else {
            to.say(SYNTAX, call.at, "the camera has no axes");
        }
        arguments
    }

    fn shape<'c, 't>(&mut self, call: &'c Call<'t>, to: &mut Said<'_, '_, '_>) -> Arguments<'c, 't> {
        let emits = call.name == "emitter";
        let names: &[&str] = if emits {
            &["name", "mesh", "material", "radiance", "matrix"]
        } else {
            &["name", "mesh", "material", "matrix"]
        };
        let arguments = Arguments::new(call, names);
        let name = arguments.text("name", to).to_owned();
        let (mesh, material) = (arguments.text("mesh", to), arguments.text("material", to));
        let transform = arguments.matrix("matrix", to);
        let emission = emits.then(|| {
            // The functions mix the emission with nothing on the back.
            Emitted { radiance: arguments.rgb("radiance", to), both_sides: false, reversed: false }
        });
        match (self.meshes.get(mesh), self.materials.get(material)) {
            (Some(mesh), Some(material)) => {
                let one = Use { name, mesh: *mesh, material: *material, transform, emission };
                match self.group.and_then(|group| self.reading.groups.get_mut(group)) {
                    Some(group) => group.push(one),
                    None => self.reading.items.push(Item::Shape(one)),
                }
            }
            (None, _) => to.say(REFERENCE, call.at, format!("there is no mesh `{}`", shown(mesh))),
            (_, None) => to.say(REFERENCE, call.at, format!("there is no material `{}`", shown(material))),
        }
        arguments
    }

    fn paint(&self, name: &str, arguments: &Arguments<'_, '_>, to: &mut Said<'_, '_, '_>) -> Paint {
        let Some(Value::Text(texture)) = arguments.get(name) else { return Paint::Color(arguments.rgb(name, to)) };
        match self.textures.get(texture) {
            Some(paint) => paint.clone(),
            None => {
                to.say(REFERENCE, arguments.at(), format!("there is no texture `{}`", shown(texture)));
                Paint::BLACK
            }
        }
    }

    /// What the functions make of a surface (`ltsc_blender.py`).
    fn surface(&self, call: &Call<'_>, to: &mut Said<'_, '_, '_>) -> Model {
        let mut float = |arguments: &Arguments<'_, '_>, name: &str| arguments.float(name, to).unwrap_or(f64::NAN);
        let (model, arguments) = match call.name {
            "diffuse" => {
                let arguments = Arguments::new(call, &["reflectance"]);
                (Model::Diffuse { reflectance: self.paint("reflectance", &arguments, to) }, arguments)
            }
            "conductor" => {
                let arguments = Arguments::new(call, &["eta", "k", "alpha"]);
                let alpha = float(&arguments, "alpha");
                let fresnel = Fresnel::Exact { eta: arguments.rgb("eta", to), k: arguments.rgb("k", to) };
                (Model::Conductor { fresnel, tint: Paint::WHITE, alpha }, arguments)
            }
            "dielectric" => {
                let arguments = Arguments::new(call, &["interior", "exterior", "alpha"]);
                let [inside, outside, alpha] = ["interior", "exterior", "alpha"].map(|name| float(&arguments, name));
                (Model::Dielectric { eta: inside / outside, alpha }, arguments)
            }
            "mirror" => {
                let arguments = Arguments::new(call, &["reflectance"]);
                let tint = self.paint("reflectance", &arguments, to);
                (Model::Conductor { fresnel: Fresnel::Constant, tint, alpha: 0.0 }, arguments)
            }
            "principled" => {
                let arguments = Arguments::new(call, &["base", "metallic", "roughness", "ior"]);
                let [metallic, roughness, ior] = ["metallic", "roughness", "ior"].map(|name| float(&arguments, name));
                let base = self.paint("base", &arguments, to);
                let (alpha, specular) = (roughness * roughness, normal_reflectance(ior));
                (Model::Principled { base, metallic, alpha, specular, ceiling: 1.0 }, arguments)
            }
            other => {
                to.say(UNKNOWN, call.at, format!("there is no surface `{}`", shown(other)));
                return Model::Diffuse { reflectance: Paint::BLACK };
            }
        };
        arguments.finish(to);
        model
    }

    fn light<'c, 't>(&mut self, call: &'c Call<'t>, to: &mut Said<'_, '_, '_>) -> Arguments<'c, 't> {
        let names: &[&str] = match call.name {
            "environment" => &["radiance", "tint", "turn"],
            "point" => &["name", "position", "intensity"],
            "directional" => &["name", "x", "y", "z", "irradiance"],
            _ => &["name", "position", "x", "y", "z", "intensity", "angle", "blend"],
        };
        let arguments = Arguments::new(call, names);
        if call.name != "environment" {
            arguments.text("name", to);
        }
        // Lights shine along their own -z; the other axes only turn what looks the same from all sides.
        let along = |arguments: &Arguments<'_, '_>, to: &mut Said<'_, '_, '_>| {
            for name in ["x", "y"] {
                arguments.row(name, to);
            }
            arguments.row("z", to).and_then(normalized).map(|axis| axis.map(|part| -part))
        };
        let light = match call.name {
            "environment" => {
                let radiance = self.paint("radiance", &arguments, to);
                let tint = arguments.get("tint").map_or([1.0; 3], |_| arguments.rgb("tint", to));
                let turn = arguments.matrix("turn", to);
                Some(Light::Environment { radiance: radiance.scaled(tint), turn })
            }
            "point" => {
                let position = arguments.row("position", to);
                let intensity = arguments.rgb("intensity", to);
                position.map(|position| Light::Point { position, intensity })
            }
            "directional" => {
                let irradiance = arguments.rgb("irradiance", to);
                along(&arguments, to).map(|direction| Light::Directional { direction, irradiance })
            }
            _ => {
                let position = arguments.row("position", to);
                let intensity = arguments.rgb("intensity", to);
                let [angle, blend] = ["angle", "blend"].map(|name| arguments.float(name, to).unwrap_or(0.0));
                let inner = names::spot_inner(angle, blend);
                let direction = along(&arguments, to);
                position.zip(direction).map(|(position, direction)| Light::Spot {
                    position,
                    direction,
                    intensity,
                    angle,
                    inner,
                })
            }
        };
        match light {
            Some(light) => self.reading.lights.push(light),
            None => to.say(SYNTAX, call.at, "the light cannot be read"),
        }
        arguments
    }
}

fn path(call: &Call<'_>, name: &str, to: &mut Said<'_, '_, '_>) -> Option<VPath> {
    let text = to.text;
    to.source.path(text.path, name, || text.origin(call.at))
}
