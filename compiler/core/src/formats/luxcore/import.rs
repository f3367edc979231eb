//! LuxCore's scene description language to what it says: geometry, emitters, materials, camera, path depth and image size.
//!
//! Every property is either understood, or a finding with its line.

use std::collections::HashSet;

use super::names;
use super::properties::{Property, Said, Things, lines, string};
use super::scatter;
use super::statements::{self, DEFAULT_SIZE};
use crate::files::VPath;
use crate::formats::shared::number::count;
use crate::formats::shared::reading::{
    Clip, Emitted, Front, Item, Light, MeshPlace, MeshSource, Model, Paint, Part, Reading, Replaced, Surface, Use,
    View, turned,
};
use crate::formats::shared::source::{self, REFERENCE, SYNTAX, Source, Text, UNKNOWN, number, shown};
use crate::ir::{Affine, Filter, Vec3, cross, normalized, sub};

/// Settings that say how long and where to, and not what.
const PASSED: &[&str] = &[
    "sampler.random.adaptive.strength",
    "sampler.sobol.adaptive.strength",
    "path.russianroulette.depth",
    "film.outputs.0.type",
    "film.outputs.0.filename",
    "scene.epsilon.min",
];

/// Limits of the length of paths: the whole, and per kind of scattering. The smallest is in force.
const DEPTHS: &[&str] =
    &["path.pathdepth.total", "path.pathdepth.diffuse", "path.pathdepth.glossy", "path.pathdepth.specular"];

/// The limits that are in force where a file gives none (LuxCore's reference of its language, `PATHCPU`).
const DEFAULT_DEPTHS: &[u32] = &[6, 4, 4, 6];

/// The largest value of a sample.
const CLAMPING: &str = "path.clamping.variance.maxvalue";

/// Reads the scene whose configuration is `main`.
pub fn import(main: &VPath, source: &mut Source<'_>) -> Reading {
    let mut reading = Reading { most: Some(count(u32::MAX)), ..Reading::default() };
    let Some(scene) = settings(main, source, &mut reading) else { return reading };
    let Some(bytes) = source.bytes(&scene, || source::whole(main)) else { return reading };
    let Some(text) = source::text(source, &scene, &bytes) else { return reading };
    description(Text { path: &scene, text }, source, &mut reading);
    reading
}

/// What the properties of the filter say; LuxCore's own values where they say nothing.
struct Lens {
    /// Whether all of it was understood, and whether its type was said.
    known: bool,
    said: bool,
    kind: Kind,
    width: f64,
    alpha: f64,
}

#[derive(Clone, Copy)]
enum Kind {
    Pixel,
    Box,
    Gaussian,
}

impl Default for Lens {
    fn default() -> Self {
        Self { known: true, said: false, kind: Kind::Pixel, width: 2.0, alpha: 2.0 }
    }
}

impl Lens {
    /// Takes a property behind `film.filter.`; false where it is not understood.
    fn set(&mut self, key: &str, value: &str) -> bool {
        let positive = || number(value).filter(|x| *x > 0.0);
        self.said |= key == "type";
        match (key, string(value), positive()) {
            ("type", Some("NONE"), _) => self.kind = Kind::Pixel,
            ("type", Some("BOX"), _) => self.kind = Kind::Box,
            ("type", Some("GAUSSIAN"), _) => self.kind = Kind::Gaussian,
            ("width", _, Some(width)) => self.width = width,
            ("gaussian.alpha", _, Some(alpha)) => self.alpha = alpha,
            _ => return false,
        }
        true
    }

    fn kernel(&self) -> Filter {
        match self.kind {
            Kind::Pixel => Filter::Box { radius: 0.5 },
            Kind::Box => Filter::Box { radius: self.width },
            // exp(-alpha x^2) is exp(-1/2) at one standard deviation.
            Kind::Gaussian => Filter::Gaussian { stddev: (0.5 / self.alpha).sqrt(), radius: self.width },
        }
    }
}

/// The settings; gives the path of the scene's file.
fn settings(main: &VPath, source: &mut Source<'_>, reading: &mut Reading) -> Option<VPath> {
    let bytes = source.bytes(main, || source::whole(main))?;
    let text = Text { path: main, text: source::text(source, main, &bytes)? };
    let (mut scene, mut size, mut depths) = (None, [None; 2], [None; DEPTHS.len()]);
    let mut filter = Lens::default();
    let mut fixed = vec![false; names::FIXED.len()];
    let given = source.given();
    let replaced = |key: &str| statements::replaced(given, key);
    reading.replaced = Replaced {
        integrator: ["renderengine.type", "path.pathdepth"].into_iter().any(replaced),
        sampler: ["sampler.type", "batch.haltspp", "renderengine.seed"].into_iter().any(replaced),
        filter: replaced("film.filter.type"),
        camera: false,
    };
    let (mut engine, mut metropolis) = (None, false);
    lines(text, source, |Property { key, value, at }, source| {
        let given = replaced(key);
        let loud = source.hush(given);
        if given {
            let of = |names: &[&str]| names.iter().any(|name| statements::begins(key, name));
            reading.replaced.integrator |= of(&["renderengine.type", "path"]);
            reading.replaced.sampler |= of(&["sampler", "batch", "renderengine.seed"]);
            reading.replaced.filter |= of(&["film.filter"]);
        }
        if key == "renderengine.type" {
            engine = string(value).map(str::to_owned);
        }
        if key == CLAMPING {
            // 0 is no limit; what is no number is not known.
            reading.clamped = number(value).map_or(Some(f64::NAN), |limit| Some(limit).filter(|limit| *limit > 0.0));
        }
        let whole = || number(value).filter(|x| x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(x));
        let count = |source: &mut Source<'_>| {
            let found = whole().map(|x| x as u32);
            if found.is_none() {
                source.say(SYNTAX, text.origin(at), format!("`{key}` is no count"));
            }
            found
        };
        if key == "scene.file" {
            match string(value) {
                Some(name) => scene = source.path(main, name, || text.origin(at)),
                None => source.say(SYNTAX, text.origin(at), "`scene.file` is no string in double quotes"),
            }
        } else if key == "film.width" {
            size[0] = count(source);
        } else if key == "film.height" {
            size[1] = count(source);
        } else if key == "batch.haltspp" {
            reading.sampling.samples.extend(count(source).map(i64::from));
        } else if key == "renderengine.seed" {
            let of: fn(u32) -> i64 = |seed| names::seed(seed).into();
            reading.sampling.seed = count(source).map(|seed| (seed.into(), of));
        } else if key == "film.subregion" && given {
            reading.part = part(value);
        } else if key == "sampler.type" {
            metropolis = string(value) == Some("METROPOLIS");
            reading.sampling.sobol = match string(value) {
                Some("SOBOL") => Some(true),
                Some("RANDOM") => Some(false),
                _ => {
                    source.say(SYNTAX, text.origin(at), format!("`{key}` with the value {} is not read", shown(value)));
                    None
                }
            };
        } else if key.ends_with(".adaptive.strength") && number(value) != Some(0.0) {
            source.say(SYNTAX, text.origin(at), format!("`{key}` other than 0 is not read"));
        } else if let Some(place) = DEPTHS.iter().position(|known| *known == key) {
            depths[place] = count(source);
        } else if let Some(place) = names::FIXED.iter().position(|(known, _)| *known == key) {
            fixed[place] = true;
            let wanted = names::FIXED[place].1;
            if value != wanted {
                source.say(SYNTAX, text.origin(at), format!("`{key}` other than {wanted} is not read"));
            }
        } else if let Some(rest) = key.strip_prefix("film.filter.") {
            if !filter.set(rest, value) {
                filter.known = false;
                source.say(SYNTAX, text.origin(at), format!("`{key}` with the value {} is not read", shown(value)));
            }
        } else if !PASSED.contains(&key) {
            source.say(UNKNOWN, text.origin(at), format!("the property `{}` is not known", shown(key)));
        }
        source.hush(loud);
    });
    // The sampler makes another algorithm of it.
    reading.native =
        engine.or_else(|| replaced("renderengine.type").then(|| "PATHCPU".to_owned())).filter(|_| !metropolis);
    for ((key, _), _) in names::FIXED.iter().zip(fixed).filter(|((key, _), found)| !found && !replaced(key)) {
        source.say(SYNTAX, source::whole(main), format!("`{key}` is missing, and its default is another image"));
    }
    if let [Some(width), Some(height)] = size {
        reading.film = Some([width, height]);
    } else if replaced("film.width") {
        let [width, height] = [0, 1].map(|at| size[at].unwrap_or(DEFAULT_SIZE[at]));
        reading.film = Some([width, height]);
    }
    reading.filter = Some(filter.kernel()).filter(|_| filter.known && (filter.said || !reading.replaced.filter));
    if reading.replaced.integrator {
        // LuxCore's own limits where a file gives none; one per kind of scattering that is smaller is in force.
        let depths: Vec<u32> =
            depths.iter().zip(DEFAULT_DEPTHS).map(|(said, default)| said.unwrap_or(*default)).collect();
        reading.max_depth = Some(depths[0]).filter(|total| depths.iter().all(|depth| depth >= total));
        return scene;
    }
    // The limits per kind of scattering have defaults of their own.
    if depths.iter().all(Option::is_some) {
        reading.max_depth = depths.into_iter().flatten().min();
        // One that is smaller is in force; one that is larger would else not be seen.
        let least = depths.iter().filter(|depth| **depth == reading.max_depth).count();
        if (2..depths.len()).contains(&least) {
            source.say(SYNTAX, source::whole(main), "different depths for kinds of scattering are not read");
        }
    }
    if scene.is_none() {
        source.say(SYNTAX, source::whole(main), "`scene.file` is missing");
    }
    scene
}

/// A part of the image: its first and last column, its first and last row.
fn part(value: &str) -> Part {
    let edges: Option<Vec<u32>> = value.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    match edges.as_deref() {
        Some([left, right, top, bottom]) if left <= right && top <= bottom => {
            Part::Rectangle { area: [*left, *top, right - left + 1, bottom - top + 1], cut: true }
        }
        _ => Part::Unknown,
    }
}

fn description(text: Text<'_>, source: &mut Source<'_>, reading: &mut Reading) {
    const KINDS: [&str; 6] = ["camera", "textures", "materials", "shapes", "objects", "lights"];
    let mut things: [Things<'_>; 6] = Default::default();
    lines(text, source, |property, source| {
        let rest = property.key.strip_prefix("scene.");
        let found = rest.and_then(|rest| {
            let (kind, inner) = rest.split_once('.')?;
            let place = KINDS.iter().position(|known| *known == kind)?;
            // The camera has no id.
            Some((place, if place == 0 { rest } else { inner }))
        });
        match found {
            Some((place, rest)) => things[place].add(rest, property, text, source),
            None => {
                let message = format!("the property `{}` is not known", shown(property.key));
                source.say(UNKNOWN, text.origin(property.at), message);
            }
        }
    });
    let [cameras, textures, materials, shapes, objects, lights] = things;
    let to = &mut Said { source, text };
    camera(&cameras, to, reading);
    if textures.all.iter().any(|texture| texture.reference("colorspace").is_some()) {
        curve(to);
    }
    let mut emissions: Vec<Option<Emitted>> = Vec::new();
    let mut sides = Vec::new();
    for (at, thing) in materials.all.iter().enumerate() {
        let one_sided = thing.string("type", to) == Some("twosided");
        let model = if one_sided {
            sides.push((at, scatter::sides(thing, &materials, to)));
            Model::Diffuse { reflectance: Paint::BLACK }
        } else {
            scatter::model(thing, &textures, to)
        };
        emissions.push(scatter::emission(thing, to));
        thing.finish(to);
        reading.materials.push(Surface { name: thing.id.to_owned(), model, two_sided: !one_sided });
    }
    let mut parts = HashSet::new();
    for (at, sides) in sides {
        let Some([front, back]) = sides else { continue };
        parts.extend([front, back]);
        if !matches!(&reading.materials[back].model, Model::Diffuse { reflectance: Paint::Color([0.0, 0.0, 0.0]) }) {
            to.say(SYNTAX, materials.all[at].place("backmaterial"), "a back that is not black is not read");
        }
        reading.materials[at].model = reading.materials[front].model.clone();
        // They are parts of it, and no surface is made of them alone.
        reading.materials[back] =
            Surface { name: reading.materials[back].name.clone(), ..reading.materials[at].clone() };
    }
    textures.all.iter().for_each(|thing| thing.finish(to));
    let mut sources: Vec<Option<usize>> = Vec::new();
    for thing in &shapes.all {
        thing.expect("type", "\"mesh\"", to);
        let at = thing.place("ply");
        let file = thing.string("ply", to).and_then(|name| to.source.path(text.path, name, || text.origin(at)));
        if file.is_none() {
            to.say(SYNTAX, at, "the shape has no mesh file");
        }
        sources.push(file.map(|file| {
            // The side of the winding emits (`GetGeometryNormal`).
            reading.meshes.push(MeshSource { place: MeshPlace::File(file), front: Front::Winding, flat: None });
            reading.meshes.len() - 1
        }));
        thing.finish(to);
    }
    for thing in &objects.all {
        let [shape, material] = ["shape", "material"].map(|name| thing.string(name, to).unwrap_or_default());
        let transform = placed(thing, to);
        let (found, used) = (shapes.place(shape), materials.place(material));
        match (found, used) {
            (_, Some(part)) if parts.contains(&part) => {
                let message = format!("`{}` is one side of another material", shown(material));
                to.say(REFERENCE, thing.place("material"), message);
            }
            (Some(shape), Some(material)) => {
                if let Some(mesh) = sources[shape] {
                    let name = thing.id.to_owned();
                    let emission = emissions[material];
                    reading.items.push(Item::Shape(Use { name, mesh, material, transform, emission }));
                }
            }
            (None, _) => to.say(REFERENCE, thing.place("shape"), format!("there is no shape `{}`", shown(shape))),
            (_, None) => {
                to.say(REFERENCE, thing.place("material"), format!("there is no material `{}`", shown(material)));
            }
        }
        thing.finish(to);
    }
    for thing in &lights.all {
        light(thing, to, reading);
        thing.finish(to);
    }
}

/// The file that says what sRGB is must say what ltsc's says.
fn curve(to: &mut Said<'_, '_, '_>) {
    let text = to.text;
    let Some(path) = to.source.path(text.path, names::SRGB_FILE, || source::whole(text.path)) else { return };
    let Some(bytes) = to.source.bytes(&path, || source::whole(text.path)) else { return };
    let lines = std::str::from_utf8(&bytes).unwrap_or_default().lines().filter(|line| !line.starts_with('#'));
    if !lines.eq(names::SRGB_CONFIG.lines()) {
        to.source.say(SYNTAX, source::whole(&path), "a curve other than that of sRGB is not read");
    }
}

/// A matrix by columns.
fn affine(all: &[f64; 16]) -> Option<Affine> {
    let rows = [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]]);
    ([all[3], all[7], all[11], all[15]] == [0.0, 0.0, 0.0, 1.0]).then_some(Affine { rows })
}

fn camera(cameras: &Things<'_>, to: &mut Said<'_, '_, '_>, reading: &mut Reading) {
    let Some(thing) = cameras.all.first() else { return };
    thing.expect("type", "\"perspective\"", to);
    let [orig, target, up] = ["lookat.orig", "lookat.target", "up"].map(|name| thing.row::<3>(name, to));
    let (fov, window) = (thing.float("fieldofview", to), thing.row::<4>("screenwindow", to));
    let [near, far] = ["cliphither", "clipyon"].map(|name| thing.float(name, to));
    reading.clip = Some(Clip { near, far, default: Some(names::DEFAULT_CLIPPING) });
    reading.description = Some(to.text.path.clone());
    thing.finish(to);
    let axes = |eye: Vec3, target: Vec3, up: Vec3| {
        let forward = normalized(sub(target, eye))?;
        let right = normalized(cross(forward, normalized(up)?))?;
        Some((right, cross(right, forward), forward))
    };
    let (Some(eye), Some(target), Some(up), Some(fov), Some([left, end, bottom, top]), Some([width, height])) =
        (orig, target, up, fov, window, reading.film)
    else {
        to.say(SYNTAX, thing.at, "the camera lacks its place, angle or window, or the image its size");
        return;
    };
    let Some((right, up, forward)) = axes(eye, target, up) else {
        to.say(SYNTAX, thing.at, "the camera has no axes");
        return;
    };
    // The angle spans 2 of the window.
    let half = libm::tan(fov.to_radians() / 2.0);
    let angle = |size: f64| (2.0 * libm::atan(half * size / 2.0)).to_degrees();
    let [column, row] = [(end - left) / f64::from(width), (top - bottom) / f64::from(height)];
    // The image lies one row too low (measured with 2.11.2): with its window one row down it is where it should be.
    let shift = [-(left + end) / 2.0 / column, -(bottom + top) / 2.0 / row - 1.0];
    let (fov_x, fov_y) = (angle(end - left), angle(top - bottom));
    reading.view = Some(View { eye, right, up, forward, fov_x, fov_y, shift });
}

/// The place of a thing.
fn placed(thing: &super::properties::Thing<'_>, to: &mut Said<'_, '_, '_>) -> Affine {
    match thing.row::<16>("transformation", to) {
        Some(all) => affine(&all).unwrap_or_else(|| {
            to.say(SYNTAX, thing.place("transformation"), "the matrix is not affine");
            Affine::IDENTITY
        }),
        None => Affine::IDENTITY,
    }
}

fn light(thing: &super::properties::Thing<'_>, to: &mut Said<'_, '_, '_>, reading: &mut Reading) {
    let text = to.text;
    let kind = thing.string("type", to).unwrap_or_default();
    let strength = |to: &mut Said<'_, '_, '_>| {
        let color = thing.rgb("color", to).unwrap_or([1.0; 3]);
        let gain = thing.rgb("gain", to).unwrap_or([1.0; 3]);
        [0, 1, 2].map(|channel| color[channel] * gain[channel])
    };
    let light = match kind {
        "constantinfinite" => Some(Light::Environment { radiance: Paint::Color(strength(to)), turn: Affine::IDENTITY }),
        "infinite" => {
            thing.demand("gamma", "1", to);
            thing.expect("storage", "\"float\"", to);
            let turn = turned(&names::ENVIRONMENT, &placed(thing, to));
            let factor = thing.rgb("gain", to).unwrap_or([1.0; 3]);
            let at = thing.place("file");
            let file = thing.string("file", to).and_then(|name| to.source.path(text.path, name, || text.origin(at)));
            file.map(|file| Light::Environment {
                radiance: Paint::Image { file: file.into(), linear: true, factor },
                turn,
            })
        }
        "point" => {
            thing.demand("power", "0", to);
            thing.demand("efficiency", "0", to);
            let position = thing.row::<3>("position", to).unwrap_or([0.0; 3]);
            // The whole sphere of directions shares color times gain.
            Some(Light::Point { position, intensity: strength(to).map(|x| x / names::POINT_GAIN) })
        }
        "spot" => {
            thing.demand("power", "0", to);
            thing.demand("efficiency", "0", to);
            let position = thing.row::<3>("position", to).unwrap_or([0.0; 3]);
            let target = thing.row::<3>("target", to).unwrap_or([0.0, 0.0, 1.0]);
            let angle = thing.float("coneangle", to).unwrap_or(30.0);
            let inner = angle - thing.float("conedeltaangle", to).unwrap_or(5.0);
            let intensity = strength(to);
            let axis = normalized(sub(target, position));
            axis.map(|direction| Light::Spot { position, direction, intensity, angle, inner })
        }
        "sharpdistant" => {
            let irradiance = strength(to);
            let axis = thing.row::<3>("direction", to).and_then(normalized);
            axis.map(|direction| Light::Directional { direction, irradiance })
        }
        other => {
            to.say(UNKNOWN, thing.place("type"), format!("there is no light `{}`", shown(other)));
            return;
        }
    };
    match light {
        Some(light) => reading.lights.push(light),
        None => to.say(SYNTAX, thing.at, "the light cannot be read"),
    }
}
