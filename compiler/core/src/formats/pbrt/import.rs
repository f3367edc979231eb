//! PBRT text to what it says: geometry, emitters, materials, camera, path depth and image size.
//!
//! Directives are executed in their order on a state, as PBRT does. Every directive and parameter is either understood or a
//! finding with its line.

use std::collections::BTreeMap;

use super::names::{self, Version};
use super::scatter::Known;
use super::statements::{DEFAULT_SIZE, PLACED};
use super::text::{Broken, Params, Said, Token, Tokens, unescaped};
use crate::diag::Origin;
use crate::files::VPath;
use crate::formats::shared::number::count;
use crate::formats::shared::reading::{
    Emitted, Front, Item, Light, MeshPlace, MeshSource, Model, Paint, Part, Reading, Surface, Use, View, turned,
};
use crate::formats::shared::source::{
    self, INCLUDE_DEPTH, LIMIT, REFERENCE, SYNTAX, Source, Text, UNKNOWN, number, shown,
};
use crate::ir::{Affine, Filter, Meaning, Vec3, cross, normalized, sub};

/// How deep attributes may be nested.
const STATE_DEPTH: usize = 1000;

/// All directives of both versions that are understood.
const DIRECTIVES: &[&str] = &[
    "Include",
    "Identity",
    "Scale",
    "Translate",
    "Rotate",
    "LookAt",
    "Transform",
    "ConcatTransform",
    "Camera",
    "Film",
    "PixelFilter",
    "Sampler",
    "Integrator",
    "WorldBegin",
    "WorldEnd",
    "AttributeBegin",
    "AttributeEnd",
    "TransformBegin",
    "TransformEnd",
    "ReverseOrientation",
    "Texture",
    "MakeNamedMaterial",
    "NamedMaterial",
    "Material",
    "LightSource",
    "AreaLightSource",
    "Shape",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
];

/// Reads the scene whose main file is `main`.
pub fn import(version: Version, main: &VPath, source: &mut Source<'_>) -> Reading {
    let mut reader = Reader::new(version);
    reader.file(main, 0, source, &source::whole(main));
    reader.finish(source, main)
}

/// What attributes hold.
#[derive(Clone)]
struct State {
    map: Affine,
    material: Option<usize>,
    emission: Option<Emitted>,
    reversed: bool,
}

/// What a begin waits for.
#[derive(Clone, Copy, PartialEq)]
enum Open {
    Attributes,
    Transform,
}

struct Reader {
    version: Version,
    reading: Reading,
    state: State,
    stack: Vec<(Open, State)>,
    /// Models of named materials, and their places among the surfaces.
    models: BTreeMap<String, Model>,
    named: BTreeMap<String, usize>,
    textures: BTreeMap<String, Paint>,
    meshes: BTreeMap<VPath, usize>,
    objects: BTreeMap<String, usize>,
    object: Option<usize>,
    world: bool,
    /// Map and angle of the camera; the angle is that of the shorter axis.
    camera: Option<(Affine, f64)>,
}

impl Reader {
    fn new(version: Version) -> Self {
        let state = State { map: Affine::IDENTITY, material: None, emission: None, reversed: false };
        Self {
            version,
            reading: Reading { most: Some(count(u32::MAX)), ..Reading::default() },
            state,
            stack: Vec::new(),
            models: BTreeMap::new(),
            named: BTreeMap::new(),
            textures: BTreeMap::new(),
            meshes: BTreeMap::new(),
            objects: BTreeMap::new(),
            object: None,
            world: false,
            camera: None,
        }
    }

    fn finish(mut self, source: &mut Source<'_>, main: &VPath) -> Reading {
        if !self.stack.is_empty() || self.object.is_some() {
            source.say(SYNTAX, source::whole(main), "attributes or an object do not end");
        }
        if let (Some((map, fov)), Some([width, height])) = (self.camera, self.reading.film) {
            // The angle is that of the shorter axis of the image.
            let (width, height) = (f64::from(width), f64::from(height));
            let half = libm::tan(fov.to_radians() / 2.0);
            let other = |long: f64, short: f64| (2.0 * libm::atan(half * long / short)).to_degrees();
            let (fov_x, fov_y) = if width > height { (other(width, height), fov) } else { (fov, other(height, width)) };
            self.reading.view = View::of_rows(&map, fov_x, fov_y);
            if self.reading.view.is_none() && !self.reading.replaced.camera {
                source.say(SYNTAX, source::whole(main), "the camera has no axes");
            }
        }
        self.reading
    }

    fn file(&mut self, path: &VPath, depth: usize, source: &mut Source<'_>, named: &Origin) {
        if depth > INCLUDE_DEPTH {
            source.say(LIMIT, named.clone(), format!("files include each other more than {INCLUDE_DEPTH} deep"));
            return;
        }
        let Some(bytes) = source.bytes(path, || named.clone()) else { return };
        let Some(text) = source::text(source, path, &bytes) else { return };
        let text = Text { path, text };
        if !text.text.ends_with('\n') {
            // rs_pbrt 0.9.12 panics.
            source.say(SYNTAX, text.origin(text.text.len()), "the file does not end with a line end");
        }
        let mut tokens = Tokens::new(text.text);
        if let Err(Broken(at)) = self.directives(&mut tokens, text, depth, source) {
            source.say(SYNTAX, text.origin(at), "the text cannot be read from here on");
        }
    }

    fn directives(
        &mut self,
        tokens: &mut Tokens<'_>,
        text: Text<'_>,
        depth: usize,
        source: &mut Source<'_>,
    ) -> Result<(), Broken> {
        while let Some((at, token)) = tokens.next()? {
            if source.is_full() {
                break;
            }
            let Token::Word(word) = token else { return Err(Broken(at)) };
            if word == "Include" {
                let name = string(tokens, at)?;
                let origin = text.origin(at);
                if let Some(path) = source.path(text.path, &name, || origin.clone()) {
                    self.file(&path, depth + 1, source, &origin);
                }
                continue;
            }
            self.directive(word, at, tokens, &mut Said { source, text })?;
        }
        Ok(())
    }

    fn directive(
        &mut self,
        word: &str,
        at: usize,
        tokens: &mut Tokens<'_>,
        to: &mut Said<'_, '_, '_>,
    ) -> Result<(), Broken> {
        let given = given(to, word);
        if given && !PLACED.contains(&word) {
            let loud = to.source.hush(true);
            to.say(UNKNOWN, at, format!("`{}` is added to the settings", shown(word)));
            to.source.hush(loud);
            return skip(tokens);
        }
        if given && ["Scale", "LookAt", "Camera"].contains(&word) {
            self.reading.replaced.camera = true;
        }
        match word {
            "Identity" => self.state.map = Affine::IDENTITY,
            "Scale" => self.concat(Affine::scaling(row(tokens, at)?)),
            "Translate" => self.concat(Affine::translation(row(tokens, at)?)),
            "Rotate" => {
                let [degrees, x, y, z] = row(tokens, at)?;
                match normalized([x, y, z]) {
                    Some(axis) => self.concat(Affine::rotation(axis, degrees)),
                    None => to.say(SYNTAX, at, "the axis has no direction"),
                }
            }
            "LookAt" => match look_at(row(tokens, at)?) {
                Some(map) => self.concat(map),
                None => to.say(SYNTAX, at, "the camera has no axes"),
            },
            "Transform" | "ConcatTransform" => {
                let map = matrix(tokens, at)?;
                let Some(map) = map else {
                    to.say(SYNTAX, at, "the matrix is not affine");
                    return Ok(());
                };
                if word == "Transform" {
                    self.state.map = map;
                } else {
                    self.concat(map);
                }
            }
            "AttributeBegin" => self.open(Open::Attributes, at, to),
            "AttributeEnd" => self.close(Open::Attributes, at, to),
            "TransformBegin" => self.open(Open::Transform, at, to),
            "TransformEnd" => self.close(Open::Transform, at, to),
            "ReverseOrientation" => self.state.reversed = !self.state.reversed,
            "WorldBegin" => {
                if self.world {
                    to.say(SYNTAX, at, "the world begins twice");
                }
                self.world = true;
                self.state.map = Affine::IDENTITY;
            }
            "WorldEnd" => {
                if !self.version.names().world_end {
                    to.say(SYNTAX, at, format!("{} has no `WorldEnd`", self.version.target()));
                }
            }
            "NamedMaterial" => {
                let name = string(tokens, at)?;
                self.state.material = self.named.get(name.as_ref()).copied();
                if self.state.material.is_none() {
                    to.say(REFERENCE, at, format!("there is no material `{}`", shown(&name)));
                }
            }
            "ObjectBegin" => {
                let name = string(tokens, at)?;
                if self.object.is_some() {
                    to.say(SYNTAX, at, "an object stands within another");
                }
                self.open(Open::Attributes, at, to);
                self.object = Some(self.reading.groups.len());
                if self.objects.insert(name.into_owned(), self.reading.groups.len()).is_some() {
                    to.say(SYNTAX, at, "two objects have the same name");
                }
                self.reading.groups.push(Vec::new());
            }
            "ObjectEnd" => {
                if self.object.take().is_none() {
                    to.say(SYNTAX, at, "no object begins here");
                }
                self.close(Open::Attributes, at, to);
            }
            "ObjectInstance" => {
                let name = string(tokens, at)?;
                let transform = self.state.map;
                match self.objects.get(name.as_ref()) {
                    Some(group) if self.object.is_none() => {
                        let (group, name) = (*group, name.into_owned());
                        self.reading.items.push(Item::Instance { name, group, transform });
                    }
                    Some(_) => to.say(SYNTAX, at, "an instance stands within an object"),
                    None => to.say(REFERENCE, at, format!("there is no object `{}`", shown(&name))),
                }
            }
            "Texture" => {
                let (name, kind, class) = (string(tokens, at)?, string(tokens, at)?, string(tokens, at)?);
                let params = Params::read(at, tokens, to.source, to.text)?;
                if kind != "spectrum" {
                    to.unknown(at, "type of textures", &kind, &["spectrum"]);
                }
                let known = Known { version: self.version, textures: &self.textures, materials: &self.models };
                let paint = known.image(&class, &params, to, file_of);
                params.finish("the texture", to);
                if let Some(paint) = paint {
                    self.textures.insert(name.into_owned(), paint);
                }
            }
            "Camera" | "Film" | "PixelFilter" | "Sampler" | "Integrator" | "MakeNamedMaterial" | "Material"
            | "LightSource" | "AreaLightSource" | "Shape" => {
                let name = string(tokens, at)?;
                let loud = to.source.hush(given);
                let params = Params::read(at, tokens, to.source, to.text)?;
                self.declare(word, &name, &params, to);
                if given {
                    self.take(word, &name, &params, to);
                }
                params.finish(&format!("`{word}`"), to);
                to.source.hush(loud);
            }
            _ => {
                to.unknown(at, "directive", word, DIRECTIVES);
                skip(tokens)?;
            }
        }
        Ok(())
    }

    fn concat(&mut self, map: Affine) {
        self.state.map = map.then(&self.state.map);
    }

    fn open(&mut self, kind: Open, at: usize, to: &mut Said<'_, '_, '_>) {
        if self.stack.len() == STATE_DEPTH {
            to.say(LIMIT, at, format!("attributes are nested more than {STATE_DEPTH} deep"));
        }
        if self.stack.len() <= STATE_DEPTH {
            self.stack.push((kind, self.state.clone()));
        }
    }

    fn close(&mut self, kind: Open, at: usize, to: &mut Said<'_, '_, '_>) {
        match self.stack.pop() {
            Some((opened, state)) if opened == kind => match kind {
                Open::Attributes => self.state = state,
                Open::Transform => self.state.map = state.map,
            },
            _ => to.say(SYNTAX, at, "nothing begins here that could end"),
        }
    }

    fn declare(&mut self, word: &str, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        match word {
            "Camera" => {
                if name != "perspective" {
                    to.unknown(params.at, "camera", name, &["perspective"]);
                }
                self.reading.settings = Some(to.text.path.clone());
                self.camera = Some((self.state.map, params.float("fov", to).unwrap_or(90.0)));
            }
            "Film" => {
                let known = self.version.names().film.0;
                if name != known {
                    to.unknown(params.at, "film", name, &[known]);
                }
                let (x, y) = (params.integer("xresolution", to), params.integer("yresolution", to));
                self.reading.film = Some([x.unwrap_or(DEFAULT_SIZE[0]), y.unwrap_or(DEFAULT_SIZE[1])]);
                params.string("filename", to);
                params.bool("savefp16", to);
            }
            "PixelFilter" => {
                let (x, y) = self.version.names().filter_radius;
                let [across, along] = [x, y].map(|name| params.float(name, to));
                if across != along {
                    to.say(SYNTAX, params.at, "a filter of two widths is not read");
                }
                self.reading.filter = match name {
                    "box" => Some(Filter::Box { radius: across.unwrap_or(0.5) }),
                    "gaussian" => {
                        // exp(-alpha x^2) is exp(-1/2) at one standard deviation.
                        let stddev = match self.version {
                            Version::V3 => (0.5 / params.float("alpha", to).unwrap_or(2.0)).sqrt(),
                            Version::V4 => params.float("sigma", to).unwrap_or(0.5),
                        };
                        // The default of version 3 is 2, that of version 4 1.5.
                        let radius = match self.version {
                            Version::V3 => 2.0,
                            Version::V4 => 1.5,
                        };
                        Some(Filter::Gaussian { stddev, radius: across.unwrap_or(radius) })
                    }
                    _ => {
                        to.unknown(params.at, "filter", name, &["box", "gaussian"]);
                        None
                    }
                };
            }
            "Sampler" => {
                let samples = params.integer("pixelsamples", to);
                self.reading.sampling.samples.extend(samples.map(i64::from));
                self.reading.sampling.sobol = Some(name == "sobol");
                if ![self.version.names().sampler, "sobol"].contains(&name) {
                    to.unknown(params.at, "sampler", name, &[self.version.names().sampler, "sobol"]);
                }
            }
            "Integrator" => self.integrator(name, params, to),
            "MakeNamedMaterial" => {
                let kind = params.string("type", to).unwrap_or_default();
                self.make(name.to_owned(), &kind, params, to);
            }
            "Material" => {
                self.make(String::new(), name, params, to);
                self.state.material = self.reading.materials.len().checked_sub(1);
            }
            "LightSource" => self.light(name, params, to),
            "AreaLightSource" => {
                if name != "diffuse" {
                    to.unknown(params.at, "light of surfaces", name, &["diffuse"]);
                }
                let radiance = self.strength("L", params, to).unwrap_or([1.0; 3]);
                let both_sides = params.bool("twosided", to).unwrap_or(false);
                self.state.emission = Some(Emitted { radiance, both_sides, reversed: false });
            }
            _ => self.shape(name, params, to),
        }
    }

    /// What a statement of a test case says beyond what ltsc writes itself.
    fn take(&mut self, word: &str, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        let whole = |name: &str, to: &mut Said<'_, '_, '_>| params.numbers(&["integer"], name, Some(4), to);
        match word {
            "Film" => {
                let limit = match self.version {
                    Version::V3 => "maxsampleluminance",
                    Version::V4 => "maxcomponentvalue",
                };
                self.reading.clamped = params.float(limit, to);
                let size = self.reading.film.unwrap_or(DEFAULT_SIZE).map(f64::from);
                let window = params.numbers(&["float"], "cropwindow", Some(4), to);
                let window = window.map(|x| [0, 1, 2, 3].map(|at| (x[at] * size[at / 2]).ceil()));
                let bounds = whole("pixelbounds", to).and_then(|x| <[f64; 4]>::try_from(x).ok());
                if params.has("cropwindow") || params.has("pixelbounds") {
                    self.reading.part = part(bounds.or(window), size, true);
                }
            }
            "PixelFilter" => {
                let (x, y) = self.version.names().filter_radius;
                let equal = params.float(x, to) == params.float(y, to);
                self.reading.filter = self.reading.filter.take().filter(|_| equal);
                self.reading.replaced.filter = true;
            }
            "Sampler" => self.reading.replaced.sampler = true,
            "Integrator" => {
                self.reading.replaced.integrator = true;
                self.reading.native = Some(name.to_owned()).filter(|_| params.bool("regularize", to) != Some(true));
                if params.has("maxdepth") && params.integer("maxdepth", to).is_none() {
                    self.reading.max_depth = None;
                }
                // The defaults of the two that count on their own.
                let counts = match name {
                    "mlt" => Some(("mutationsperpixel", 100)),
                    "sppm" => self.version.names().passes.map(|name| (name, 64)),
                    _ => None,
                };
                let passes = counts.map(|(name, default)| params.integer(name, to).unwrap_or(default));
                self.reading.sampling.passes = passes.map(i64::from);
                if params.has("pixelbounds") {
                    let size = self.reading.film.unwrap_or(DEFAULT_SIZE).map(f64::from);
                    let bounds = whole("pixelbounds", to).and_then(|x| <[f64; 4]>::try_from(x).ok());
                    let alone = self.reading.part == Part::Whole;
                    self.reading.part = if alone { part(bounds, size, false) } else { Part::Unknown };
                }
            }
            _ => {}
        }
    }

    fn integrator(&mut self, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        let mut known = vec!["path", "bdpt", "mlt", "sppm"];
        known.extend(self.version.names().light_tracing);
        if !known.contains(&name) {
            to.unknown(params.at, "integrator", name, &known);
        }
        self.reading.native = Some(name.to_owned());
        // Bounces lie between segments.
        self.reading.max_depth = params.integer("maxdepth", to).unwrap_or(5).checked_add(1);
        params.float("rrthreshold", to);
        self.reading.photons = (params.float("radius", to), None);
        self.reading.algorithm = match name {
            "path" => Some("path"),
            "bdpt" => Some("bidirectional"),
            "mlt" => Some("metropolis"),
            "sppm" => Some("photon_map"),
            _ if Some(name) == self.version.names().light_tracing => Some("light_tracing"),
            _ => None,
        };
        for name in ["lightsampler", "lightsamplestrategy"] {
            params.string(name, to);
        }
        let given = given(to, "Integrator");
        for name in ["iterations", "mutationsperpixel"] {
            let samples = params.integer(name, to).filter(|_| !given);
            self.reading.sampling.samples.extend(samples.map(i64::from));
        }
        if params.bool("regularize", to) == Some(true) {
            to.say(SYNTAX, params.place("regularize"), "`regularize` widens materials, which is not read");
        }
    }

    fn make(&mut self, name: String, kind: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        let known = Known { version: self.version, textures: &self.textures, materials: &self.models };
        // What is not understood is black, so that what refers to it is not a second finding.
        let model = known.material(kind, params, to).unwrap_or(Model::Diffuse { reflectance: Paint::BLACK });
        self.named.insert(name.clone(), self.reading.materials.len());
        self.models.insert(name.clone(), model.clone());
        let two_sided = true;
        self.reading.materials.push(Surface { name, model, two_sided });
    }

    /// A light's color times its `scale`. v4 divides a spectrum by its luminance (`SpectrumToPhotometric`).
    fn strength(&self, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<[f64; 3]> {
        let (rgb, luminance) = params.color(name, Meaning::Light, to)?;
        let scale = params.float("scale", to).unwrap_or(1.0);
        let share = match (self.version, luminance) {
            (Version::V4, Some(luminance)) if luminance > 0.0 => scale / luminance,
            (Version::V3 | Version::V4, _) => scale,
        };
        Some(rgb.map(|channel| channel * share))
    }

    fn light(&mut self, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        let point = self.version.names().point;
        let map = self.state.map;
        let place = |name: &str, to: &mut Said<'_, '_, '_>| params.point(point, name, to).map(|at| map.point(at));
        let light = match name {
            "infinite" => {
                let (file, still) = match self.version {
                    Version::V3 => ("mapname", names::ENVIRONMENT),
                    Version::V4 => ("filename", Affine::IDENTITY),
                };
                let (radiance, turn) = match params.string(file, to) {
                    None => (Paint::Color(self.strength("L", params, to).unwrap_or([1.0; 3])), Affine::IDENTITY),
                    Some(image) => {
                        let factor = match self.version {
                            Version::V3 => self.strength("L", params, to).unwrap_or([1.0; 3]),
                            Version::V4 => [params.float("scale", to).unwrap_or(1.0); 3],
                        };
                        let paint = file_of(to, &image).map_or(Paint::BLACK, |file| Paint::Image {
                            file: file.into(),
                            linear: true,
                            factor,
                        });
                        (paint, turned(&still, &map))
                    }
                };
                Some(Light::Environment { radiance, turn })
            }
            "point" => {
                let position = place("from", to).unwrap_or(map.point([0.0; 3]));
                let intensity = self.strength("I", params, to).unwrap_or([1.0; 3]);
                Some(Light::Point { position, intensity })
            }
            "spot" => {
                let position = place("from", to).unwrap_or(map.point([0.0; 3]));
                let target = place("to", to).unwrap_or(map.point([0.0, 0.0, 1.0]));
                let angle = params.float("coneangle", to).unwrap_or(30.0);
                let inner = angle - params.float("conedeltaangle", to).unwrap_or(5.0);
                let intensity = self.strength("I", params, to).unwrap_or([1.0; 3]);
                let axis = normalized(sub(target, position));
                axis.map(|direction| Light::Spot { position, direction, intensity, angle, inner })
            }
            "distant" => {
                let from = place("from", to).unwrap_or(map.point([0.0; 3]));
                let target = place("to", to).unwrap_or(map.point([0.0, 0.0, 1.0]));
                let irradiance = self.strength("L", params, to).unwrap_or([1.0; 3]);
                normalized(sub(target, from)).map(|direction| Light::Directional { direction, irradiance })
            }
            _ => {
                to.unknown(params.at, "light", name, &["infinite", "point", "spot", "distant"]);
                return;
            }
        };
        match light {
            Some(light) => self.reading.lights.push(light),
            None => to.say(SYNTAX, params.at, "the light has no direction"),
        }
    }

    fn shape(&mut self, kind: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        if kind != "plymesh" {
            to.unknown(params.at, "shape", kind, &["plymesh"]);
            return;
        }
        let Some(name) = params.string("filename", to) else {
            to.say(SYNTAX, params.at, "the mesh has no `filename`");
            return;
        };
        let Some(file) = file_of(to, &name) else { return };
        let meshes = &mut self.reading.meshes;
        let mesh = *self.meshes.entry(file).or_insert_with_key(|file| {
            // Where a mesh has normals they decide which side is in front (`Triangle::Intersect`: `Faceforward`).
            meshes.push(MeshSource { place: MeshPlace::File(file.clone()), front: Front::Normals, flat: None });
            meshes.len() - 1
        });
        let material = self.state.material.unwrap_or_else(|| {
            let model = Model::Diffuse { reflectance: Paint::Color([0.5; 3]) };
            self.reading.materials.push(Surface { name: String::new(), model, two_sided: true });
            self.reading.materials.len() - 1
        });
        self.state.material = Some(material);
        // Normals of a mirrored shape are turned over along with it.
        self.reading.description.get_or_insert_with(|| to.text.path.clone());
        let reversed = self.state.reversed;
        let emission = self.state.emission.map(|emission| Emitted { reversed, ..emission });
        let one = Use { name: String::new(), mesh, material, transform: self.state.map, emission };
        match self.object.and_then(|group| self.reading.groups.get_mut(group)) {
            Some(_) if one.emission.is_some() => {
                to.say(SYNTAX, params.at, "PBRT leaves out the light of a shape in an object")
            }
            Some(group) => group.push(one),
            None => self.reading.items.push(Item::Shape(one)),
        }
    }
}

/// Whether a statement of a test case stands in this file.
fn given(to: &Said<'_, '_, '_>, name: &str) -> bool {
    to.text.path.name() == "settings.pbrt" && to.source.given().find(name).is_some()
}

/// Passes over what belongs to a directive: the next one is a word that is no number.
fn skip(tokens: &mut Tokens<'_>) -> Result<(), Broken> {
    while let Some(token) = tokens.peek()? {
        if matches!(token, Token::Word(word) if number(word).is_none() && word != "true" && word != "false") {
            break;
        }
        tokens.next()?;
    }
    Ok(())
}

/// The part of an image from the bounds of its columns and rows, each with the first one behind.
fn part(bounds: Option<[f64; 4]>, [width, height]: [f64; 2], cut: bool) -> Part {
    let Some([left, right, top, bottom]) = bounds else { return Part::Unknown };
    let ([left, right], [top, bottom]) =
        ([left, right].map(|x| x.clamp(0.0, width)), [top, bottom].map(|y| y.clamp(0.0, height)));
    if left >= right || top >= bottom {
        return Part::Unknown;
    }
    Part::Rectangle { area: [left as u32, top as u32, (right - left) as u32, (bottom - top) as u32], cut }
}

fn file_of(to: &mut Said<'_, '_, '_>, name: &str) -> Option<VPath> {
    let text = to.text;
    // Places of paths are those of the directive's file; the line is said by what uses the file.
    to.source.path(text.path, name, || source::whole(text.path))
}

/// The string that a directive asks for.
fn string<'t>(tokens: &mut Tokens<'t>, at: usize) -> Result<std::borrow::Cow<'t, str>, Broken> {
    match tokens.next()? {
        Some((_, Token::Quoted(raw))) => Ok(unescaped(raw)),
        Some((at, Token::Open | Token::Close | Token::Word(_))) => Err(Broken(at)),
        None => Err(Broken(at)),
    }
}

/// Numbers that a directive asks for.
fn row<const N: usize>(tokens: &mut Tokens<'_>, at: usize) -> Result<[f64; N], Broken> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = match tokens.next()? {
            Some((at, Token::Word(word))) => number(word).ok_or(Broken(at))?,
            Some((at, Token::Open | Token::Close | Token::Quoted(_))) => return Err(Broken(at)),
            None => return Err(Broken(at)),
        };
    }
    Ok(values)
}

/// A matrix by columns, in brackets or not; none within where its last row is not 0 0 0 1.
fn matrix(tokens: &mut Tokens<'_>, at: usize) -> Result<Option<Affine>, Broken> {
    let bracket = tokens.peek()? == Some(Token::Open);
    if bracket {
        tokens.next()?;
    }
    let all: [f64; 16] = row(tokens, at)?;
    if bracket && tokens.next()?.map(|(_, token)| token) != Some(Token::Close) {
        return Err(Broken(at));
    }
    let affine = [all[3], all[7], all[11], all[15]] == [0.0, 0.0, 0.0, 1.0];
    let rows = [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]]);
    Ok(affine.then_some(Affine { rows }))
}

/// From scene to camera coordinates, x = up x forward, y up, z along the axis: PBRT's are left-handed (`LookAt` of
/// `transform.cpp`).
fn look_at([ex, ey, ez, tx, ty, tz, ux, uy, uz]: [f64; 9]) -> Option<Affine> {
    let eye: Vec3 = [ex, ey, ez];
    let forward = normalized(sub([tx, ty, tz], eye))?;
    let x = normalized(cross(normalized([ux, uy, uz])?, forward))?;
    let up = cross(forward, x);
    let axes = [x, up, forward];
    Some(Affine { rows: axes.map(|axis| [axis[0], axis[1], axis[2], -crate::ir::dot(axis, eye)]) })
}
