//! Mitsuba XML to what it says: geometry, emitters, materials, camera, path depth and image size.
//!
//! Every element, attribute and parameter is either understood or a finding with its line.

use std::collections::BTreeMap;

use super::names::{DEFAULT_CLIPPING, ENVIRONMENT, PHOTON_ALPHA, Version};
use super::scatter::{self, Known};
use super::statements::DEFAULT_SIZE;
use super::xml::{self, Defaults, Element, Plugin, Said};
use crate::diag::Origin;
use crate::files::VPath;
use crate::formats::shared::number::count;
use crate::formats::shared::reading::{
    Clip, Emitted, Front, Item, Light, MeshPlace, MeshSource, Paint, Part, Reading, Surface, Use, View, inverse, turned,
};
use crate::formats::shared::source::{self, INCLUDE_DEPTH, LIMIT, REFERENCE, SYNTAX, Source, Text, UNKNOWN, shown};
use crate::ir::{Affine, Filter, normalized};

/// Reads the scene whose main file is `main`.
pub fn import(version: Version, main: &VPath, source: &mut Source<'_>) -> Reading {
    let mut reader = Reader::new(version);
    reader.file(main, 0, source, &source::whole(main));
    reader.reading
}

/// What an id stands for.
#[derive(Clone, Copy)]
enum Id {
    Material(usize),
    Group(usize),
    Other,
}

struct Reader {
    version: Version,
    reading: Reading,
    defaults: Defaults,
    textures: BTreeMap<String, Paint>,
    ids: BTreeMap<String, Id>,
    meshes: BTreeMap<(VPath, bool), usize>,
}

impl Reader {
    fn new(version: Version) -> Self {
        Self {
            version,
            reading: Reading { most: Some(count(u32::MAX)), ..Reading::default() },
            defaults: Defaults::new(),
            textures: BTreeMap::new(),
            ids: BTreeMap::new(),
            meshes: BTreeMap::new(),
        }
    }

    fn file(&mut self, path: &VPath, depth: usize, source: &mut Source<'_>, named: &Origin) {
        if depth > INCLUDE_DEPTH {
            source.say(LIMIT, named.clone(), format!("files include each other more than {INCLUDE_DEPTH} deep"));
            return;
        }
        let Some(bytes) = source.bytes(path, || named.clone()) else { return };
        let Some(text) = source::text(source, path, &bytes) else { return };
        let text = Text { path, text };
        let Some(root) = xml::parse(text, source) else { return };
        let to = &mut Said { source, text };
        if root.name != "scene" {
            to.unknown(root.at, "kind of file", &root.name, &["scene"]);
            return;
        }
        root.only(&["version"], to);
        if root.get("version") != Some(self.version.number()) {
            // 0.6 refuses what says 0.5.0, and 3 changes what says less than 3.
            to.say(SYNTAX, root.at, format!("the file is not of version {}", self.version.number()));
        }
        for child in &root.children {
            if to.source.is_full() {
                break;
            }
            if child.name == "include" {
                child.only(&["filename"], to);
                let origin = text.origin(child.at);
                let named = child.get("filename").unwrap_or_default();
                if let Some(path) = to.source.path(path, named, || origin.clone()) {
                    self.file(&path, depth + 1, to.source, &origin);
                }
            } else {
                self.child(child, to);
            }
        }
    }

    fn child(&mut self, child: &Element, to: &mut Said<'_, '_, '_>) {
        if child.name == "default" {
            child.only(&["name", "value"], to);
            let [name, value] = ["name", "value"].map(|name| child.get(name).unwrap_or_default().to_owned());
            self.defaults.entry(name).or_insert(value);
            return;
        }
        // What test cases add to the settings has a place of its own, or is not read.
        if given(to, &child.name) && !["integrator", "sensor"].contains(&child.name.as_str()) {
            let loud = to.source.hush(true);
            to.say(UNKNOWN, child.at, format!("`{}` is added to the scene", shown(&child.name)));
            to.source.hush(loud);
            return;
        }
        // Defaults stand before what uses them.
        let defaults = std::mem::take(&mut self.defaults);
        let plugin = Plugin::new(child, &defaults);
        match child.name.as_str() {
            "integrator" => self.integrator(plugin, to),
            "sensor" => self.sensor(plugin, to),
            "texture" => {
                if let Some(image) = scatter::image(self.version, plugin, to) {
                    self.textures.insert(child.get("id").unwrap_or_default().to_owned(), image);
                }
                self.name(child, Id::Other, to);
            }
            "bsdf" => {
                let material = self.material(plugin, to);
                self.name(child, Id::Material(material), to);
            }
            "shape" => self.shape(plugin, to),
            "emitter" => self.emitter(plugin, to),
            other => {
                let known = ["default", "include", "integrator", "sensor", "texture", "bsdf", "shape", "emitter"];
                to.unknown(child.at, "element", other, &known);
            }
        }
        self.defaults = defaults;
    }

    /// Gives an element the id that it asks for.
    fn name(&mut self, element: &Element, id: Id, to: &mut Said<'_, '_, '_>) {
        if let Some(name) = element.get("id")
            && self.ids.insert(name.to_owned(), id).is_some()
        {
            to.say(SYNTAX, element.at, format!("the id `{}` is given twice", shown(name)));
        }
    }

    fn material(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> usize {
        let known = Known { version: self.version, textures: &self.textures };
        let (model, two_sided) = known.surface(plugin, to);
        let name = plugin.element.get("id").unwrap_or_default().to_owned();
        self.reading.materials.push(Surface { name, model, two_sided });
        self.reading.materials.len() - 1
    }

    fn integrator(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) {
        let names = self.version.names();
        let given = given(to, "integrator");
        let loud = to.source.hush(given);
        self.reading.replaced.integrator = given;
        self.reading.native = Some(plugin.kind().to_owned());
        let known: &[&str] =
            if names.light_paths { &["path", "ptracer", "bdpt", "pssmlt", "sppm"] } else { &["path", "ptracer"] };
        if !known.contains(&plugin.kind()) {
            to.unknown(plugin.at(), "integrator", plugin.kind(), known);
        }
        // -1 is no limit, and the default of most.
        let said = plugin.integer(names.max_depth, to);
        let unlimited = !plugin.has(names.max_depth) && !BOUNDED.contains(&plugin.kind());
        self.reading.max_depth = match said.or(unlimited.then_some(-1)) {
            Some(-1) => Some(u32::MAX),
            depth => depth.and_then(|depth| u32::try_from(depth).ok()),
        };
        self.reading.algorithm = match plugin.kind() {
            "path" => Some("path"),
            "ptracer" => Some("light_tracing"),
            "bdpt" => Some("bidirectional"),
            "pssmlt" => Some("metropolis"),
            "sppm" => Some("photon_map"),
            _ => None,
        };
        plugin.integer(names.rr_depth, to);
        if plugin.integer("directSamples", to).is_some_and(|samples| samples != -1) {
            to.say(SYNTAX, plugin.at(), "`directSamples` other than -1 is not read");
        }
        let passes = plugin.integer("maxPasses", to);
        if given {
            // Without a number there is no end, which no sampler's number is either.
            self.reading.sampling.passes = passes.or((plugin.kind() == "sppm").then_some(-1));
        } else {
            self.reading.sampling.samples.extend(passes);
        }
        self.reading.photons = (plugin.float("initialRadius", to), plugin.integer("photonCount", to));
        if plugin.float("alpha", to).is_some_and(|alpha| alpha != PHOTON_ALPHA) {
            to.say(SYNTAX, plugin.at(), format!("`alpha` other than {PHOTON_ALPHA} is not read"));
        }
        if plugin.boolean("bidirectional", to) == Some(false) {
            to.say(SYNTAX, plugin.at(), "`bidirectional` switched off is not read");
        }
        plugin.finish(to);
        to.source.hush(loud);
    }

    fn sensor(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) {
        let names = self.version.names();
        if plugin.kind() != "perspective" {
            to.unknown(plugin.at(), "sensor", plugin.kind(), &["perspective"]);
        }
        let fov = plugin.float("fov", to);
        let axis = plugin.string(names.fov_axis, to).unwrap_or("x");
        let [near, far] = [names.near_clip, names.far_clip].map(|name| plugin.float(name, to));
        self.reading.clip = Some(Clip { near, far, default: Some(DEFAULT_CLIPPING) });
        self.reading.settings = Some(to.text.path.clone());
        for sampler in plugin.inner("sampler") {
            let given = given(to, "sampler");
            let loud = to.source.hush(given);
            self.reading.replaced.sampler = given;
            if !["independent", "sobol"].contains(&sampler.kind()) {
                to.unknown(sampler.at(), "sampler", sampler.kind(), &["independent", "sobol"]);
            }
            let samples = sampler.integer(names.sample_count, to);
            self.reading.sampling.samples.extend(samples);
            let seeds = ["seed", "scramble"].map(|name| sampler.integer(name, to));
            self.reading.sampling.seed = seeds.into_iter().flatten().next().map(|seed| (seed, i64::from as _));
            self.reading.sampling.sobol = Some(sampler.kind() == "sobol");
            sampler.finish(to);
            to.source.hush(loud);
        }
        let mut film = DEFAULT_SIZE;
        for inner in plugin.inner("film") {
            film = self.film(inner, to);
        }
        self.reading.film = Some(film);
        let map = plugin.transform(names.to_world, to);
        let [width, height] = film.map(f64::from);
        let vertical = match axis {
            "x" => false,
            "y" => true,
            "smaller" => height < width,
            "larger" => height > width,
            other => {
                to.unknown(plugin.at(), "axis of the angle", other, &["x", "y", "smaller", "larger"]);
                false
            }
        };
        let fov = fov.unwrap_or_else(|| {
            to.say(SYNTAX, plugin.at(), "a camera without `fov` is not read");
            45.0
        });
        let half = libm::tan(fov.to_radians() / 2.0);
        let other = |factor: f64| (2.0 * libm::atan(half * factor)).to_degrees();
        let (fov_x, fov_y) = if vertical { (other(width / height), fov) } else { (fov, other(height / width)) };
        // The camera's own x points to the left of the image (`perspective.cpp` of all versions).
        self.reading.view = inverse(&map)
            .and_then(|map| View::of_rows(&map, fov_x, fov_y))
            .map(|view| View { right: view.right.map(|x| -x), ..view });
        if self.reading.view.is_none() {
            to.say(SYNTAX, plugin.at(), "the camera has no axes");
        }
        plugin.finish(to);
    }

    fn film(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> [u32; 2] {
        let names = self.version.names();
        let is_given = given(to, "film");
        let loud = to.source.hush(is_given);
        if plugin.kind() != "hdrfilm" {
            to.unknown(plugin.at(), "film", plugin.kind(), &["hdrfilm"]);
        }
        let size = ["width", "height"].map(|name| plugin.integer(name, to).and_then(|size| u32::try_from(size).ok()));
        let size = [size[0].unwrap_or(DEFAULT_SIZE[0]), size[1].unwrap_or(DEFAULT_SIZE[1])];
        plugin.expect(names.pixel_format, &["rgb"], to);
        plugin.expect(names.component_format, &["float32"], to);
        if names.banner.and_then(|name| plugin.boolean(name, to)).unwrap_or(names.banner.is_some()) {
            to.say(SYNTAX, plugin.at(), "a film with a banner is not read");
        }
        if is_given && names.crop.iter().any(|name| plugin.has(name)) {
            let default = [0, 0, size[0], size[1]];
            let read = |at: usize, to: &mut Said<'_, '_, '_>| match plugin.integer(names.crop[at], to) {
                Some(value) => u32::try_from(value).ok(),
                None => Some(default[at]).filter(|_| !plugin.has(names.crop[at])),
            };
            self.reading.part = match [0, 1, 2, 3].map(|at| read(at, to)) {
                [Some(x), Some(y), Some(width), Some(height)] => {
                    Part::Rectangle { area: [x, y, width, height], cut: true }
                }
                _ => Part::Unknown,
            };
        }
        to.source.hush(loud);
        let is_given = given(to, "rfilter");
        let loud = to.source.hush(is_given);
        self.reading.replaced.filter = is_given;
        // The default of all versions.
        let mut read = Some(gaussian(0.5));
        for filter in plugin.inner("rfilter") {
            read = match filter.kind() {
                "gaussian" => Some(gaussian(filter.float("stddev", to).unwrap_or(0.5))),
                "box" => {
                    let radius = names.box_radius.and_then(|name| filter.float(name, to));
                    Some(Filter::Box { radius: radius.unwrap_or(0.5) })
                }
                kind => {
                    to.unknown(filter.at(), "filter", kind, &["box", "gaussian"]);
                    None
                }
            };
            filter.finish(to);
        }
        self.reading.filter = read;
        to.source.hush(given(to, "film"));
        plugin.finish(to);
        to.source.hush(loud);
        size
    }

    fn shape(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) {
        self.reading.description.get_or_insert_with(|| to.text.path.clone());
        let names = self.version.names();
        let name = plugin.element.get("id").unwrap_or_default().to_owned();
        match plugin.kind() {
            "shapegroup" => {
                let mut group = Vec::new();
                for inner in plugin.inner("shape") {
                    match self.surface(inner, to) {
                        Some(one) if one.emission.is_some() => {
                            to.say(SYNTAX, inner.at(), "Mitsuba takes no emitter in a group");
                        }
                        Some(one) => group.push(one),
                        None => {}
                    }
                }
                self.reading.groups.push(group);
                let id = Id::Group(self.reading.groups.len() - 1);
                self.name(plugin.element, id, to);
                plugin.finish(to);
            }
            "instance" => {
                let transform = plugin.transform(names.to_world, to);
                let (at, group) = plugin.refers(None, to).map_or((plugin.at(), ""), |(found, id)| (found.at, id));
                match self.ids.get(group) {
                    Some(Id::Group(group)) => {
                        let group = *group;
                        self.reading.items.push(Item::Instance { name, group, transform });
                    }
                    Some(Id::Material(_) | Id::Other) | None => {
                        to.say(REFERENCE, at, format!("there is no group `{}`", shown(group)));
                    }
                }
                self.name(plugin.element, Id::Other, to);
                plugin.finish(to);
            }
            _ => {
                if let Some(one) = self.surface(plugin, to) {
                    self.reading.items.push(Item::Shape(one));
                }
                self.name(plugin.element, Id::Other, to);
            }
        }
    }

    fn surface(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<Use> {
        let names = self.version.names();
        if plugin.kind() != "ply" {
            to.unknown(plugin.at(), "shape", plugin.kind(), &["ply", "shapegroup", "instance"]);
            return None;
        }
        let file = scatter::file(plugin, to);
        let flat = plugin.boolean(names.face_normals, to).unwrap_or(false);
        let transform = plugin.transform(names.to_world, to);
        let inner = plugin.inner("bsdf").next();
        let material = match inner {
            Some(inner) => Some(self.material(inner, to)),
            None => self.referred(plugin, to),
        };
        let mut emission = None;
        for light in plugin.inner("emitter") {
            if light.kind() != "area" {
                to.unknown(light.at(), "light of surfaces", light.kind(), &["area"]);
            }
            let radiance = light.rgb("radiance", to).unwrap_or_else(|| {
                to.say(SYNTAX, light.at(), "the light has no `radiance` in RGB");
                [0.0; 3]
            });
            emission = Some(Emitted { radiance, both_sides: false, reversed: false });
            light.finish(to);
        }
        plugin.finish(to);
        let meshes = &mut self.reading.meshes;
        let mesh = *self.meshes.entry((file?, flat)).or_insert_with_key(|(file, flat)| {
            // Normals that a file has decide which side is in front (`area.cpp`: the shading frame), unless faces stay flat.
            let front = if *flat { Front::Winding } else { Front::Normals };
            meshes.push(MeshSource { place: MeshPlace::File(file.clone()), front, flat: Some(*flat) });
            meshes.len() - 1
        });
        let name = plugin.element.get("id").unwrap_or_default().to_owned();
        Some(Use { name, mesh, material: material?, transform, emission })
    }

    /// The material that a shape refers to.
    fn referred(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<usize> {
        let (at, id) = plugin.refers(None, to).map_or((plugin.at(), ""), |(found, id)| (found.at, id));
        match self.ids.get(id) {
            Some(Id::Material(material)) => Some(*material),
            Some(Id::Group(_) | Id::Other) | None => {
                to.say(REFERENCE, at, format!("there is no material `{}`", shown(id)));
                None
            }
        }
    }

    fn emitter(&mut self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) {
        let names = self.version.names();
        let color = |name: &str, to: &mut Said<'_, '_, '_>| {
            plugin.rgb(name, to).unwrap_or_else(|| {
                to.say(SYNTAX, plugin.at(), format!("the light has no `{name}` in RGB"));
                [0.0; 3]
            })
        };
        let light = match plugin.kind() {
            "constant" => {
                Some(Light::Environment { radiance: Paint::Color(color("radiance", to)), turn: Affine::IDENTITY })
            }
            "envmap" => {
                let turn = turned(&ENVIRONMENT, &plugin.transform(names.to_world, to));
                let factor = [plugin.float("scale", to).unwrap_or(1.0); 3];
                let file = scatter::file(plugin, to);
                let radiance = |file: VPath| Paint::Image { file: file.into(), linear: true, factor };
                file.map(|file| Light::Environment { radiance: radiance(file), turn })
            }
            "point" => {
                let position = plugin.vector("point", "position", to).unwrap_or([0.0; 3]);
                Some(Light::Point { position, intensity: color("intensity", to) })
            }
            "spot" => {
                let Affine { rows } = plugin.transform(names.to_world, to);
                let (cutoff, beam) = names.spot;
                let angle = plugin.float(cutoff, to).unwrap_or(20.0);
                let inner = plugin.float(beam, to).unwrap_or(angle * 0.75);
                let intensity = color("intensity", to);
                let position = rows.map(|row| row[3]);
                let axis = normalized(rows.map(|row| row[2]));
                axis.map(|direction| Light::Spot { position, direction, intensity, angle, inner })
            }
            "directional" => {
                let axis = plugin.vector("vector", "direction", to).and_then(normalized);
                let irradiance = color("irradiance", to);
                axis.map(|direction| Light::Directional { direction, irradiance })
            }
            other => {
                to.unknown(plugin.at(), "light", other, &["constant", "envmap", "point", "spot", "directional"]);
                return;
            }
        };
        self.name(plugin.element, Id::Other, to);
        plugin.finish(to);
        match light {
            Some(light) => self.reading.lights.push(light),
            None => to.say(SYNTAX, plugin.at(), "the light cannot be read"),
        }
    }
}

/// Whether a statement of a test case stands in this file.
fn given(to: &Said<'_, '_, '_>, name: &str) -> bool {
    to.text.path.name() == "settings.xml" && to.source.given().find(name).is_some()
}

/// Integrators whose depth is bounded by default.
const BOUNDED: &[&str] = &["photonmapper", "ppm", "sppm", "vpl"];

/// Mitsuba's Gaussian, which it cuts itself.
fn gaussian(stddev: f64) -> Filter {
    Filter::Gaussian { stddev, radius: 4.0 * stddev }
}
