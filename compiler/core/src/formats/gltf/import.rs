//! glTF and GLB to what they say: geometry, emitters, materials, camera, path depth and image size.
//!
//! Every key is either understood or a finding with its JSON pointer.

use std::collections::BTreeMap;

use serde_json::Value;

use super::json::{Document, Item, place, split};
use super::names;
use crate::files::{Bytes, VPath};
use crate::formats::shared::coat::normal_reflectance;
use crate::formats::shared::reading::{
    self, Emitted, Fresnel, Front, Light, MeshPlace, MeshSource, Model, Paint, Picture, Reading, Surface, Use, View,
};
use crate::formats::shared::source::{self, LIMIT, REFERENCE, SYNTAX, Source, UNKNOWN, shown};
use crate::ir::{Affine, ImageFile, normalized};
use crate::mesh::Geometry;

/// How deep nodes may hold each other.
const DEPTH: usize = 64;

/// What is read of extensions.
const EXTENSIONS: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
];

/// Reads the scene in `main`.
pub fn import(main: &VPath, source: &mut Source<'_>) -> Reading {
    let Some(bytes) = source.bytes(main, || source::whole(main)) else { return Reading::default() };
    let Some((text, binary)) = split(&bytes) else {
        source.say(SYNTAX, source::whole(main), "the file is no whole GLB file of version 2");
        return Reading::default();
    };
    // The parser refuses values that are nested more than 128 deep.
    let root: Value = match serde_json::from_slice(text) {
        Ok(root) => root,
        Err(problem) => {
            source.say(SYNTAX, place(main, format!("line {}", problem.line())), format!("this is no JSON: {problem}"));
            return Reading::default();
        }
    };
    let own = binary.map(|range| Bytes::new(Part { bytes: bytes.clone(), range }));
    let Some(document) = Document::new(main, &root, own, source) else { return Reading::default() };
    let mut reader = Reader {
        accessors: document.list("accessors", source),
        views: document.list("bufferViews", source),
        nodes: document.list("nodes", source),
        meshes: document.list("meshes", source),
        document,
        reading: Reading::default(),
        emissions: Vec::new(),
        known_meshes: BTreeMap::new(),
        known_groups: BTreeMap::new(),
        lights: Vec::new(),
    };
    reader.read(source);
    reader.reading
}

/// A part of a file's bytes.
struct Part {
    bytes: Bytes,
    range: std::ops::Range<usize>,
}

impl AsRef<[u8]> for Part {
    fn as_ref(&self) -> &[u8] {
        self.bytes.get(self.range.clone()).unwrap_or_default()
    }
}

struct Reader<'v> {
    document: Document<'v>,
    accessors: Vec<Item<'v>>,
    views: Vec<Item<'v>>,
    nodes: Vec<Item<'v>>,
    meshes: Vec<Item<'v>>,
    reading: Reading,
    emissions: Vec<Option<Emitted>>,
    /// Meshes by their accessors.
    known_meshes: BTreeMap<[Option<usize>; 4], Option<usize>>,
    known_groups: BTreeMap<usize, usize>,
    lights: Vec<Item<'v>>,
}

impl<'v> Reader<'v> {
    fn read(&mut self, source: &mut Source<'_>) {
        let whole = self.document.whole();
        let known = [
            "asset",
            "extensionsUsed",
            "extensionsRequired",
            "extensions",
            "scene",
            "scenes",
            "nodes",
            "cameras",
            "meshes",
            "materials",
            "textures",
            "images",
            "samplers",
            "accessors",
            "bufferViews",
            "buffers",
        ];
        whole.only(&known, &self.document, source);
        for name in ["extensionsUsed", "extensionsRequired"] {
            let used = whole.get(name).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            for used in used.iter().filter_map(Value::as_str).filter(|used| !EXTENSIONS.contains(used)) {
                let message = format!("the extension `{}` is not read", shown(used));
                source.say(UNKNOWN, place(self.document.path, format!("/{name}")), message);
            }
        }
        if let Some(lights) = whole.inner("extensions").and_then(|all| all.inner("KHR_lights_punctual")) {
            let all = lights.get("lights").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            // They stand deeper than other lists; a list with the same keys gives them places.
            self.lights = all.iter().filter_map(Value::as_object).map(|map| whole.with(map)).collect();
        }
        self.materials(source);
        let scenes = self.document.list("scenes", source);
        let Some(scene) = scenes.get(whole.count("scene").unwrap_or(0)).copied() else {
            self.document.say(whole, REFERENCE, "there is no scene", source);
            return;
        };
        scene.only(&["name", "nodes", "extras"], &self.document, source);
        self.settings(scene);
        self.walk(&scene.counts("nodes"), source);
    }

    /// Image, depth and samples, which glTF has no words for.
    fn settings(&mut self, scene: Item<'v>) {
        let Some(extras) = scene.inner("extras") else { return };
        if let Some(film) = extras.inner("film") {
            let size = ["width", "height"].map(|name| film.count(name).and_then(|size| u32::try_from(size).ok()));
            if let [Some(width), Some(height)] = size {
                self.reading.film = Some([width, height]);
            }
        }
        let depth = extras.inner("integrator").and_then(|integrator| integrator.count("max_depth"));
        self.reading.max_depth = depth.and_then(|depth| u32::try_from(depth).ok());
    }

    fn walk(&mut self, roots: &[usize], source: &mut Source<'_>) {
        let mut seen = vec![false; self.nodes.len()];
        let mut stack: Vec<(usize, Affine, usize)> = roots.iter().rev().map(|at| (*at, upright(), 0)).collect();
        while let Some((at, outer, depth)) = stack.pop() {
            if source.is_full() {
                break;
            }
            let (Some(node), Some(visited)) = (self.nodes.get(at).copied(), seen.get_mut(at)) else {
                source.say(REFERENCE, place(self.document.path, format!("/nodes/{at}")), "the node is not there");
                continue;
            };
            if *visited || depth > DEPTH {
                let (id, what) = if *visited { (SYNTAX, "has two parents") } else { (LIMIT, "is nested too deeply") };
                self.document.say(node, id, format!("the node {what}"), source);
                continue;
            }
            *visited = true;
            let map = self.transform(node, source).then(&outer);
            self.node(node, &map, source);
            stack.extend(node.counts("children").into_iter().rev().map(|child| (child, map, depth + 1)));
        }
    }

    fn transform(&self, node: Item<'v>, source: &mut Source<'_>) -> Affine {
        let moves = ["translation", "rotation", "scale"].iter().any(|key| node.get(key).is_some());
        if node.get("matrix").is_some() {
            let affine = node
                .row::<16>("matrix")
                .filter(|all| [all[3], all[7], all[11], all[15]] == [0.0, 0.0, 0.0, 1.0] && !moves);
            let Some(all) = affine else {
                self.document.say(node, SYNTAX, "the matrix is not affine, or stands beside another transform", source);
                return Affine::IDENTITY;
            };
            return Affine { rows: [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]]) };
        }
        let scale = node.row::<3>("scale").map_or(Affine::IDENTITY, Affine::scaling);
        let turn = node.row::<4>("rotation").map_or(Affine::IDENTITY, turned_by);
        let offset = node.row::<3>("translation").map_or(Affine::IDENTITY, Affine::translation);
        scale.then(&turn).then(&offset)
    }

    fn node(&mut self, node: Item<'v>, map: &Affine, source: &mut Source<'_>) {
        let known = [
            "name",
            "camera",
            "mesh",
            "translation",
            "rotation",
            "scale",
            "matrix",
            "children",
            "extensions",
            "extras",
        ];
        node.only(&known, &self.document, source);
        let name = node.text("name").unwrap_or_default().to_owned();
        if node.get("camera").is_some() {
            self.camera(node, map, source);
        }
        let extensions = node.inner("extensions");
        if let Some(extensions) = extensions {
            extensions.only(&["KHR_lights_punctual", "EXT_mesh_gpu_instancing"], &self.document, source);
        }
        if let Some(light) = extensions.and_then(|extensions| extensions.inner("KHR_lights_punctual")) {
            match light.count("light").and_then(|at| self.lights.get(at).copied()) {
                Some(light) => self.light(light, node, map, source),
                None => self.document.say(node, REFERENCE, "the light is not there", source),
            }
        }
        if node.get("mesh").is_none() {
            return;
        }
        let Some(mesh) = node.count("mesh").and_then(|at| self.meshes.get(at).copied()) else {
            self.document.say(node, REFERENCE, "the mesh is not there", source);
            return;
        };
        let group = match self.known_groups.get(&mesh.at()) {
            Some(group) => *group,
            None => {
                let parts = self.parts(mesh, source);
                self.reading.groups.push(parts);
                self.known_groups.insert(mesh.at(), self.reading.groups.len() - 1);
                self.reading.groups.len() - 1
            }
        };
        let places = match extensions.and_then(|extensions| extensions.inner("EXT_mesh_gpu_instancing")) {
            None => vec![(name, *map)],
            Some(instancing) => self.places(instancing, node, map, source),
        };
        for (name, transform) in places {
            // A mesh of one part is a shape.
            let item = match self.reading.groups[group].as_slice() {
                [one] => reading::Item::Shape(Use { name, transform, ..one.clone() }),
                _ => reading::Item::Instance { name, group, transform },
            };
            self.reading.items.push(item);
        }
    }

    /// The places of a mesh that the buffer holds, in single precision, with the names that ltsc gives them.
    fn places(
        &mut self,
        instancing: Item<'v>,
        node: Item<'v>,
        map: &Affine,
        source: &mut Source<'_>,
    ) -> Vec<(String, Affine)> {
        self.reading.gathered = true;
        instancing.only(&["attributes"], &self.document, source);
        let Some(attributes) = instancing.inner("attributes") else {
            self.document.say(node, SYNTAX, "the instances have no places", source);
            return Vec::new();
        };
        attributes.only(&["TRANSLATION", "ROTATION", "SCALE"], &self.document, source);
        let Self { document, accessors, views, .. } = self;
        let mut read =
            |name: &str| attributes.count(name).map(|at| document.vectors::<3>(accessors, views, at, source));
        let (moved, scaled) = (read("TRANSLATION"), read("SCALE"));
        let turned = attributes.count("ROTATION").map(|at| document.vectors::<4>(accessors, views, at, source));
        let (Some(moved), scaled, turned) = (moved.flatten(), scaled.flatten(), turned.flatten()) else {
            self.document.say(node, SYNTAX, "instances without translations are not read", source);
            return Vec::new();
        };
        let counts = [scaled.as_ref().map(Vec::len), turned.as_ref().map(Vec::len)];
        if counts.into_iter().flatten().any(|count| count != moved.len()) {
            self.document.say(node, SYNTAX, "the instances have not as many places as turns and scales", source);
            return Vec::new();
        }
        let names = node.inner("extras").and_then(|extras| extras.get("names")?.as_array());
        let place = |at: usize| {
            let single = |all: &Option<Vec<[f32; 3]>>, default: f64| {
                all.as_ref().map_or([default; 3], |all| all[at].map(f64::from))
            };
            let turn = turned.as_ref().map_or(Affine::IDENTITY, |all| turned_by(all[at].map(f64::from)));
            let own = Affine::scaling(single(&scaled, 1.0)).then(&turn);
            let own = own.then(&Affine::translation(moved[at].map(f64::from)));
            let name = names.and_then(|names| names.get(at)?.as_str()).unwrap_or_default();
            (name.to_owned(), own.then(map))
        };
        (0..moved.len()).map(place).collect()
    }

    /// The primitives of a mesh.
    fn parts(&mut self, mesh: Item<'v>, source: &mut Source<'_>) -> Vec<Use> {
        mesh.only(&["name", "primitives", "extras"], &self.document, source);
        let primitives = mesh.get("primitives").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let mut parts = Vec::with_capacity(primitives.len());
        for primitive in primitives.iter().filter_map(Value::as_object).map(|map| mesh.with(map)) {
            primitive.only(&["attributes", "indices", "material", "mode"], &self.document, source);
            if primitive.count("mode").is_some_and(|mode| mode != 4) {
                self.document.say(mesh, SYNTAX, "a mesh that is not made of triangles is not read", source);
                continue;
            }
            let Some(material) = primitive.count("material").filter(|at| *at < self.reading.materials.len()) else {
                self.document.say(mesh, REFERENCE, "the mesh has no material", source);
                continue;
            };
            let Some(index) = self.geometry(primitive, mesh, source) else { continue };
            let emission = self.emissions[material];
            let (name, transform) = (String::new(), Affine::IDENTITY);
            parts.push(Use { name, mesh: index, material, transform, emission });
        }
        parts
    }

    fn geometry(&mut self, primitive: Item<'v>, mesh: Item<'v>, source: &mut Source<'_>) -> Option<usize> {
        let attributes = primitive.inner("attributes");
        if let Some(attributes) = attributes {
            attributes.only(&["POSITION", "NORMAL", "TEXCOORD_0"], &self.document, source);
        }
        let accessor = |name: &str| attributes.and_then(|attributes| attributes.count(name));
        let [position, normal, uv] = ["POSITION", "NORMAL", "TEXCOORD_0"].map(accessor);
        let key = [position, normal, uv, primitive.count("indices")];
        if let Some(known) = self.known_meshes.get(&key) {
            return *known;
        }
        let (Some(position), Some(indices)) = (position, key[3]) else {
            self.document.say(mesh, SYNTAX, "a mesh without positions or indices is not read", source);
            return None;
        };
        let geometry = self.numbers((position, normal, uv, indices), source);
        let found = geometry.and_then(|geometry| {
            if let Err(problem) = geometry.check() {
                self.document.say(mesh, SYNTAX, problem.to_string(), source);
                return None;
            }
            // The side of the winding is the front (glTF 2.0, 3.7.4).
            let place = MeshPlace::Here(geometry);
            self.reading.meshes.push(MeshSource { place, front: Front::Winding, flat: None });
            Some(self.reading.meshes.len() - 1)
        });
        self.known_meshes.insert(key, found);
        found
    }

    /// The numbers of a mesh, by its accessors: positions, normals, texture coordinates, corners.
    fn numbers(
        &mut self,
        (position, normal, uv, indices): (usize, Option<usize>, Option<usize>, usize),
        source: &mut Source<'_>,
    ) -> Option<Geometry> {
        let Self { document, accessors, views, .. } = self;
        let positions = document.vectors::<3>(accessors, views, position, source)?;
        let normals = match normal {
            Some(at) => Some(document.vectors::<3>(accessors, views, at, source)?),
            None => None,
        };
        let uvs = match uv {
            // glTF's v grows downwards in the image.
            Some(at) => Some(document.vectors::<2>(accessors, views, at, source)?),
            None => None,
        };
        let uvs = uvs.map(|all| all.into_iter().map(|[u, v]| [u, 1.0 - v]).collect());
        let triangles = document.triangles(accessors, views, indices, source)?;
        Some(Geometry { positions, normals, uvs, triangles })
    }

    fn camera(&mut self, node: Item<'v>, map: &Affine, source: &mut Source<'_>) {
        let cameras = self.document.list("cameras", source);
        let camera = node.count("camera").and_then(|at| cameras.get(at).copied());
        let Some((camera, lens)) = camera.and_then(|camera| Some((camera, camera.inner("perspective")?))) else {
            self.document.say(node, REFERENCE, "there is no such camera with a perspective", source);
            return;
        };
        camera.only(&["name", "type", "perspective"], &self.document, source);
        lens.only(&["aspectRatio", "yfov", "znear", "zfar"], &self.document, source);
        let (Some(yfov), Some(ratio)) = (lens.number("yfov"), lens.number("aspectRatio")) else {
            self.document.say(camera, SYNTAX, "a camera without angle and ratio is not read", source);
            return;
        };
        let column = |at: usize| map.rows.map(|row| row[at]);
        let axes = [column(0), column(1), column(2).map(|part| -part)].map(normalized);
        let [Some(right), Some(up), Some(forward)] = axes else {
            self.document.say(node, SYNTAX, "the camera has no axes", source);
            return;
        };
        let fov_x = (2.0 * libm::atan(libm::tan(yfov / 2.0) * ratio)).to_degrees();
        let (fov_y, eye) = (yfov.to_degrees(), column(3));
        if self.reading.view.is_some() {
            self.document.say(node, SYNTAX, "a second camera is not read", source);
        }
        self.reading.view = Some(View { eye, right, up, forward, fov_x, fov_y, shift: [0.0; 2] });
    }

    fn light(&mut self, light: Item<'v>, node: Item<'v>, map: &Affine, source: &mut Source<'_>) {
        light.only(&["name", "type", "color", "intensity", "spot"], &self.document, source);
        let color = light.row::<3>("color").unwrap_or([1.0; 3]);
        let strength = color.map(|channel| channel * light.number("intensity").unwrap_or(1.0));
        let position = map.rows.map(|row| row[3]);
        let direction = normalized(map.rows.map(|row| -row[2]));
        let made = match light.text("type") {
            Some("point") => Some(Light::Point { position, intensity: strength }),
            Some("directional") => direction.map(|direction| Light::Directional { direction, irradiance: strength }),
            Some("spot") => direction.map(|direction| {
                let angle = |name: &str, default: f64| {
                    light.inner("spot").and_then(|spot| spot.number(name)).unwrap_or(default).to_degrees()
                };
                let outer = angle("outerConeAngle", std::f64::consts::FRAC_PI_4);
                let inner = angle("innerConeAngle", 0.0);
                Light::Spot { position, direction, intensity: strength, angle: outer, inner }
            }),
            Some(_) | None => None,
        };
        match made {
            Some(light) => self.reading.lights.push(light),
            None => self.document.say(node, SYNTAX, "the light cannot be read", source),
        }
    }

    fn materials(&mut self, source: &mut Source<'_>) {
        let images = self.document.list("images", source);
        let textures = self.document.list("textures", source);
        for sampler in self.document.list("samplers", source) {
            sampler.only(&["magFilter", "minFilter", "wrapS", "wrapT"], &self.document, source);
            if ["wrapS", "wrapT"].iter().any(|key| sampler.count(key).is_some_and(|how| how != names::REPEAT as usize))
            {
                self.document.say(sampler, SYNTAX, "an image that does not repeat is not read", source);
            }
        }
        for item in self.document.list("materials", source) {
            let (model, emission, two_sided) = self.material(item, (&textures, &images), source);
            let name = item.text("name").unwrap_or_default().to_owned();
            self.reading.materials.push(Surface { name, model, two_sided });
            self.emissions.push(emission);
        }
    }

    /// An image: a file, or bytes of a buffer.
    fn picture(&self, image: Item<'v>, source: &mut Source<'_>) -> Option<Picture> {
        let document = &self.document;
        image.only(&["name", "uri", "bufferView", "mimeType"], document, source);
        if let Some(uri) = image.text("uri") {
            return source.path(document.path, uri, || document.origin(image)).map(Picture::File);
        }
        let view = self.views.get(image.count("bufferView")?)?;
        let bytes = document.view(*view, source)?;
        Some(Picture::Here(ImageFile::new(bytes)))
    }

    fn material(
        &self,
        item: Item<'v>,
        (textures, images): (&[Item<'v>], &[Item<'v>]),
        source: &mut Source<'_>,
    ) -> (Model, Option<Emitted>, bool) {
        let document = &self.document;
        let known = ["name", "pbrMetallicRoughness", "emissiveFactor", "doubleSided", "extensions", "extras"];
        item.only(&known, document, source);
        let surface = item.inner("pbrMetallicRoughness");
        if let Some(surface) = surface {
            let known = ["baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor"];
            surface.only(&known, document, source);
        }
        let number = |name: &str| surface.and_then(|surface| surface.number(name)).unwrap_or(1.0);
        let [r, g, b, a] = surface.and_then(|surface| surface.row::<4>("baseColorFactor")).unwrap_or([1.0; 4]);
        if a != 1.0 {
            document.say(item, SYNTAX, "a base color with an alpha other than 1 is not read", source);
        }
        let mut base = Paint::Color([r, g, b]);
        if let Some(used) = surface.and_then(|surface| surface.inner("baseColorTexture")) {
            used.only(&["index"], document, source);
            let image = used.count("index").and_then(|at| textures.get(at)).and_then(|texture| {
                texture.only(&["name", "sampler", "source"], document, source);
                images.get(texture.count("source")?)
            });
            match image.and_then(|image| self.picture(*image, source)) {
                Some(file) => base = Paint::Image { file, linear: false, factor: [r, g, b] },
                None => document.say(item, REFERENCE, "the image of the base color is not there", source),
            }
        }
        let extension = |name: &str, key: &'static str, source: &mut Source<'_>| {
            let found = item.inner("extensions")?.inner(name)?;
            found.only(&[key], document, source);
            found.number(key)
        };
        if let Some(extensions) = item.inner("extensions") {
            let known: Vec<&str> =
                EXTENSIONS.iter().copied().filter(|name| name.starts_with("KHR_materials")).collect();
            extensions.only(&known, document, source);
        }
        let strength = extension("KHR_materials_emissive_strength", "emissiveStrength", source).unwrap_or(1.0);
        let ior = extension("KHR_materials_ior", "ior", source).unwrap_or(1.5);
        let specular = extension("KHR_materials_specular", "specularFactor", source).unwrap_or(1.0);
        let through = extension("KHR_materials_transmission", "transmissionFactor", source).unwrap_or(0.0);
        let thickness = extension("KHR_materials_volume", "thicknessFactor", source).unwrap_or(0.0);
        let (metallic, roughness) = (number("metallicFactor"), number("roughnessFactor"));
        let alpha = roughness * roughness;
        let model = if through != 0.0 {
            // Without a thickness the surface is a thin sheet that does not refract.
            if through != 1.0 || base != Paint::WHITE || thickness <= 0.0 || metallic != 0.0 {
                document.say(
                    item,
                    SYNTAX,
                    "a material that lets light through other than as clear glass is not read",
                    source,
                );
            }
            Model::Dielectric { eta: ior, alpha }
        } else if metallic == 1.0 {
            Model::Conductor { fresnel: Fresnel::HeadOn, tint: base, alpha }
        } else if metallic == 0.0 && specular == 0.0 {
            Model::Diffuse { reflectance: base }
        } else {
            let specular = normal_reflectance(ior) * specular;
            Model::Principled { base, metallic, alpha, specular, ceiling: 1.0 }
        };
        let two_sided = item.get("doubleSided") == Some(&Value::Bool(true));
        let emission = item.get("emissiveFactor").map(|_| {
            let factor = item.row::<3>("emissiveFactor").unwrap_or_else(|| {
                document.say(item, SYNTAX, "the emission is no color", source);
                [0.0; 3]
            });
            let radiance = factor.map(|channel| channel * strength);
            Emitted { radiance, both_sides: two_sided, reversed: false }
        });
        (model, emission, two_sided)
    }
}

/// The rotation of a quaternion (x, y, z, w), whatever its length.
fn turned_by(quaternion: [f64; 4]) -> Affine {
    let size = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z, w] = quaternion.map(|part| if size > 0.0 { part / size } else { 0.0 });
    Affine {
        rows: [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), 0.0],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), 0.0],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), 0.0],
        ],
    }
}

/// From glTF's coordinates, whose y is up, to the Scene's.
fn upright() -> Affine {
    Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]] }
}
