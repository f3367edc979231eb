//! glTF and GLB to what they say: geometry, emitters, materials, camera, path depth and image size.
//!
//! Every key is either understood or a finding with its JSON pointer.

use std::collections::BTreeMap;

use serde_json::Value;

use super::names;
use crate::diag::Origin;
use crate::files::{Bytes, VPath};
use crate::formats::shared::camera::has_orthogonal_columns;
use crate::formats::shared::coat::normal_reflectance;
use crate::formats::shared::reading::{
    self, Clip, Emitted, Fresnel, Front, Light, MeshPlace, MeshSource, Model, Paint, Picture, Reading, Surface, Use,
    View,
};
use crate::formats::shared::source::{self, REFERENCE, SYNTAX, Source, UNKNOWN, shown};
use crate::ir::{Affine, Filter, ImageFile, normalized};
use crate::mesh::Geometry;
use crate::mesh::file::FileError;
use crate::mesh::file::gltf::accessor::{Blob, Buffers};
use crate::mesh::file::gltf::document::{self, Document, Item};
use crate::mesh::file::gltf::{nodes, ranges};

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

/// The keys of the items of lists that are read.
const KEYS: &[(&str, &[&str])] = &[
    (
        "accessors",
        &["bufferView", "byteOffset", "componentType", "count", "max", "min", "name", "normalized", "sparse", "type"],
    ),
    ("bufferViews", &["buffer", "byteLength", "byteOffset", "byteStride", "name", "target"]),
    ("buffers", &["byteLength", "name", "uri"]),
    ("cameras", &["name", "perspective", "type"]),
    ("images", &["bufferView", "mimeType", "name", "uri"]),
    ("materials", &["doubleSided", "emissiveFactor", "extensions", "extras", "name", "pbrMetallicRoughness"]),
    ("meshes", &["extras", "name", "primitives"]),
    (
        "nodes",
        &["camera", "children", "extensions", "extras", "matrix", "mesh", "name", "rotation", "scale", "translation"],
    ),
    ("samplers", &["magFilter", "minFilter", "wrapS", "wrapT"]),
    ("scenes", &["extras", "name", "nodes"]),
    ("textures", &["name", "sampler", "source"]),
];

/// Numbers out of range and the like: more than the door to files takes, which says so then.
const FAULTS: usize = 101;

/// Reads the scene in `main`.
pub fn import(main: &VPath, source: &mut Source<'_>) -> Reading {
    let Some(bytes) = source.bytes(main, || source::whole(main)) else { return Reading::default() };
    match read(main, &bytes, source) {
        Ok(reading) => reading,
        Err(fault) => {
            told(main, fault, source);
            Reading::default()
        }
    }
}

/// Adds what is wrong with the file.
fn told(path: &VPath, fault: FileError, source: &mut Source<'_>) {
    // What the door to files has said has no message here.
    if !fault.message.is_empty() {
        source.say(SYNTAX, place(path, fault.place), fault.message);
    }
}

fn read(main: &VPath, bytes: &Bytes, source: &mut Source<'_>) -> Result<Reading, FileError> {
    let (text, chunk) = document::split(bytes)?;
    let length = bytes.get(8..).and_then(<[u8]>::first_chunk::<4>).map(|word| u32::from_le_bytes(*word) as usize);
    if bytes.starts_with(b"glTF") && length != Some(bytes.len()) {
        source.say(SYNTAX, place(main, "byte 8".to_owned()), "the file has another length than it says");
    }
    let values = document::parse(text)?;
    let document = Document::new(&values)?;
    let own = chunk.map(|range| -> Blob<'static> { Box::new(Part { bytes: bytes.clone(), range }) });
    let buffers = Buffers::new(&document, own, text.len(), &mut |item, uri| {
        let origin = || place(main, item.place());
        let file = source.path(main, uri, origin).and_then(|file| source.bytes(&file, origin));
        let silent = || FileError { message: String::new(), place: item.place(), help: None };
        file.map(|file| -> Blob<'static> { Box::new(file) }).ok_or_else(silent)
    })?;
    for fault in ranges::check(&document, FAULTS)? {
        told(main, fault, source);
    }
    for fault in ranges::bounds(&document, &buffers, FAULTS)? {
        told(main, fault, source);
    }
    let mut reader = Reader {
        path: main,
        nodes: document.list("nodes")?,
        meshes: document.list("meshes")?,
        cameras: document.list("cameras")?,
        lights: document.lights()?,
        buffers,
        document,
        reading: Reading { capped: true, ..Reading::default() },
        emissions: Vec::new(),
        known_meshes: BTreeMap::new(),
        known_groups: BTreeMap::new(),
    };
    reader.read(source)?;
    Ok(reader.reading)
}

/// A place in the file.
fn place(path: &VPath, place: String) -> Origin {
    Origin::File { path: path.as_str().to_owned(), place }
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

struct Reader<'v, 'p> {
    path: &'p VPath,
    document: Document<'v>,
    buffers: Buffers<'v, 'static>,
    nodes: Vec<Item<'v>>,
    meshes: Vec<Item<'v>>,
    cameras: Vec<Item<'v>>,
    lights: Vec<Item<'v>>,
    reading: Reading,
    emissions: Vec<Option<Emitted>>,
    /// Meshes by their accessors.
    known_meshes: BTreeMap<[Option<usize>; 4], Option<usize>>,
    known_groups: BTreeMap<usize, usize>,
}

impl<'v> Reader<'v, '_> {
    /// Adds a finding about an item.
    fn say(&self, item: Item<'_>, id: &'static str, message: impl Into<String>, source: &mut Source<'_>) {
        source.say(id, place(self.path, item.place()), message);
    }

    /// Keys other than `known` are findings.
    fn only(&self, item: Item<'_>, known: &[&str], source: &mut Source<'_>) {
        for key in item.keys().filter(|key| !known.contains(key)) {
            self.say(item, UNKNOWN, format!("there is an unknown key `{}`", shown(key)), source);
        }
    }

    fn read(&mut self, source: &mut Source<'_>) -> Result<(), FileError> {
        let whole = self.document.whole();
        let own = ["asset", "extensionsUsed", "extensionsRequired", "extensions", "scene"];
        let known: Vec<&str> = own.iter().chain(KEYS.iter().map(|(kind, _)| kind)).copied().collect();
        self.only(whole, &known, source);
        if let Some(asset) = whole.inner("asset") {
            self.only(asset, &["version", "generator", "copyright", "extras"], source);
            if asset.text("version") != Some("2.0") {
                self.say(asset, SYNTAX, "a version other than 2.0 is not read", source);
            }
        }
        for (kind, keys) in KEYS {
            let items = self.document.list(kind)?;
            if items.is_empty() && whole.get(kind).is_some() {
                source.say(SYNTAX, place(self.path, format!("/{kind}")), "the list is empty");
            }
            for item in items {
                self.only(item, keys, source);
            }
        }
        for name in ["extensionsUsed", "extensionsRequired"] {
            for used in self.document.words(name).filter(|used| !EXTENSIONS.contains(used)) {
                let message = format!("the extension `{}` is not read", shown(used));
                source.say(UNKNOWN, place(self.path, format!("/{name}")), message);
            }
        }
        self.materials(source)?;
        let scenes = self.document.list("scenes")?;
        let Some(scene) = scenes.get(whole.count("scene").unwrap_or(0)).copied() else {
            self.say(whole, REFERENCE, "there is no scene", source);
            return Ok(());
        };
        self.settings(scene, source);
        let nodes = std::mem::take(&mut self.nodes);
        nodes::walk(&nodes, &scene.counts("nodes"), (), |node, map, ()| {
            if source.is_full() {
                return Ok(None);
            }
            self.node(node, map, source)?;
            Ok(Some(()))
        })
    }

    /// Image, depth and samples, which glTF has no words for.
    fn settings(&mut self, scene: Item<'v>, source: &mut Source<'_>) {
        let Some(extras) = scene.inner("extras") else { return };
        if let Some(film) = extras.inner("film") {
            let size = ["width", "height"].map(|name| film.count(name).and_then(|size| u32::try_from(size).ok()));
            if let [Some(width), Some(height)] = size {
                self.reading.film = Some([width, height]);
            }
        }
        self.only(extras, &["film", "integrator", "sampler"], source);
        if let Some(filter) = extras.inner("film").and_then(|film| film.inner("filter")) {
            self.only(filter, &["type", "radius", "stddev"], source);
            self.reading.noted = match (filter.text("type"), filter.number("radius"), filter.number("stddev")) {
                (Some("box"), Some(radius), None) => Some(Filter::Box { radius }),
                (Some("gaussian"), Some(radius), Some(stddev)) => Some(Filter::Gaussian { stddev, radius }),
                _ => None,
            };
        }
        let word = extras.inner("integrator").and_then(|integrator| integrator.text("type"));
        let words = ["path", "bidirectional", "light_tracing", "metropolis", "photon_map"];
        self.reading.algorithm = words.into_iter().find(|known| Some(*known) == word);
        if self.reading.noted.is_none() || self.reading.algorithm.is_none() {
            self.say(scene, SYNTAX, "the settings have no filter or no algorithm that is known", source);
        }
        let parts = [
            ("film", &["width", "height", "filter"][..]),
            ("integrator", &["type", "max_depth"]),
            ("sampler", &["type", "samples", "seed"]),
        ];
        for (name, keys) in parts {
            match extras.inner(name) {
                Some(part) => self.only(part, keys, source),
                None => self.say(scene, SYNTAX, format!("the settings have no `{name}`"), source),
            }
        }
        if let Some(sampler) = extras.inner("sampler") {
            let whole = |name: &str| sampler.count(name).and_then(|count| i64::try_from(count).ok());
            self.reading.sampling.samples.extend(whole("samples"));
            self.reading.sampling.seed = whole("seed").map(|seed| (seed, i64::from as _));
            self.reading.sampling.sobol = match sampler.text("type") {
                Some("sobol") => Some(true),
                Some("independent") => Some(false),
                Some(_) | None => {
                    self.say(
                        sampler,
                        SYNTAX,
                        "a sampler that is neither `independent` nor `sobol` is not read",
                        source,
                    );
                    None
                }
            };
        }
        let depth = extras.inner("integrator").and_then(|integrator| integrator.count("max_depth"));
        self.reading.max_depth = depth.and_then(|depth| u32::try_from(depth).ok());
    }

    fn node(&mut self, node: Item<'v>, map: &Affine, source: &mut Source<'_>) -> Result<(), FileError> {
        let name = node.text("name").unwrap_or_default().to_owned();
        if node.get("camera").is_some() {
            self.camera(node, map, source);
        }
        let extensions = node.inner("extensions");
        if let Some(extensions) = extensions {
            self.only(extensions, &["KHR_lights_punctual", "EXT_mesh_gpu_instancing"], source);
        }
        if let Some(light) = node.extension("KHR_lights_punctual") {
            match light.count("light").and_then(|at| self.lights.get(at).copied()) {
                Some(light) => self.light(light, node, map, source),
                None => self.say(node, REFERENCE, "the light is not there", source),
            }
        }
        let Some(mesh) = node.link("mesh", &self.meshes)?.copied() else { return Ok(()) };
        let group = match self.known_groups.get(&mesh.at()) {
            Some(group) => *group,
            None => {
                let parts = self.parts(mesh, source)?;
                self.reading.groups.push(parts);
                self.known_groups.insert(mesh.at(), self.reading.groups.len() - 1);
                self.reading.groups.len() - 1
            }
        };
        let places = match node.extension("EXT_mesh_gpu_instancing") {
            None => vec![(name, *map)],
            Some(instancing) => self.places(instancing, node, map, source)?,
        };
        for (name, transform) in places {
            // A mesh of one part is a shape.
            let item = match self.reading.groups[group].as_slice() {
                [one] => reading::Item::Shape(Use { name, transform, ..one.clone() }),
                _ => reading::Item::Instance { name, group, transform },
            };
            self.reading.items.push(item);
        }
        Ok(())
    }

    /// The places of a mesh that the buffer holds, in single precision, with the names that ltsc gives them.
    fn places(
        &mut self,
        instancing: Item<'v>,
        node: Item<'v>,
        map: &Affine,
        source: &mut Source<'_>,
    ) -> Result<Vec<(String, Affine)>, FileError> {
        self.reading.gathered = true;
        self.only(instancing, &["attributes"], source);
        if let Some(attributes) = instancing.inner("attributes") {
            self.only(attributes, &["TRANSLATION", "ROTATION", "SCALE"], source);
        }
        let names = node.inner("extras").and_then(|extras| extras.get("names")?.as_array());
        let name = |at: usize| names.and_then(|names| names.get(at)?.as_str()).unwrap_or_default().to_owned();
        let places = nodes::instances(instancing, &self.buffers)?;
        Ok(places.iter().enumerate().map(|(at, place)| (name(at), place.then(map))).collect())
    }

    /// The primitives of a mesh.
    fn parts(&mut self, mesh: Item<'v>, source: &mut Source<'_>) -> Result<Vec<Use>, FileError> {
        let mut parts = Vec::new();
        for primitive in mesh.objects("primitives") {
            self.only(primitive, &["attributes", "indices", "material", "mode"], source);
            if primitive.count("mode").is_some_and(|mode| mode != 4) {
                self.say(mesh, SYNTAX, "a mesh that is not made of triangles is not read", source);
                continue;
            }
            let Some(material) = primitive.count("material").filter(|at| *at < self.reading.materials.len()) else {
                self.say(mesh, REFERENCE, "the mesh has no material", source);
                continue;
            };
            let Some(index) = self.geometry(primitive, mesh, source)? else { continue };
            let emission = self.emissions[material];
            let (name, transform) = (String::new(), Affine::IDENTITY);
            parts.push(Use { name, mesh: index, material, transform, emission });
        }
        Ok(parts)
    }

    fn geometry(
        &mut self,
        primitive: Item<'v>,
        mesh: Item<'v>,
        source: &mut Source<'_>,
    ) -> Result<Option<usize>, FileError> {
        let attributes = primitive.inner("attributes");
        if let Some(attributes) = attributes {
            self.only(attributes, &["POSITION", "NORMAL", "TEXCOORD_0"], source);
        }
        let accessor = |name: &str| attributes.and_then(|attributes| attributes.count(name));
        let [position, normal, uv] = ["POSITION", "NORMAL", "TEXCOORD_0"].map(accessor);
        let key = [position, normal, uv, primitive.count("indices")];
        if let Some(known) = self.known_meshes.get(&key) {
            return Ok(*known);
        }
        let (Some(position), Some(indices)) = (position, key[3]) else {
            self.say(mesh, SYNTAX, "a mesh without positions or indices is not read", source);
            return Ok(None);
        };
        let views = self.document.list("bufferViews")?;
        let mut view = |accessor: usize, target: u32| {
            let view = self.buffers.accessors().get(accessor)?.count("bufferView")?;
            let said = views.get(view)?.get("target")?;
            if said.as_u64() != Some(target.into()) {
                self.say(mesh, SYNTAX, format!("a part of the buffer is for {said} and not for {target}"), source);
            }
            Some(())
        };
        for at in [Some(position), normal, uv].into_iter().flatten() {
            view(at, names::ARRAY_BUFFER);
        }
        view(indices, names::ELEMENT_ARRAY_BUFFER);
        let geometry = self.numbers((position, normal, uv, indices))?;
        let found = match geometry.check() {
            Err(problem) => {
                self.say(mesh, SYNTAX, problem.to_string(), source);
                None
            }
            Ok(()) => {
                // The side of the winding is the front (glTF 2.0, 3.7.4).
                let place = MeshPlace::Here(geometry);
                self.reading.meshes.push(MeshSource { place, front: Front::Winding, flat: None });
                Some(self.reading.meshes.len() - 1)
            }
        };
        self.known_meshes.insert(key, found);
        Ok(found)
    }

    /// The numbers of a mesh, by its accessors: positions, normals, texture coordinates, corners.
    fn numbers(
        &self,
        (position, normal, uv, indices): (usize, Option<usize>, Option<usize>, usize),
    ) -> Result<Geometry, FileError> {
        let buffers = &self.buffers;
        let positions = buffers.vectors::<3>(position)?;
        let normals = normal.map(|at| buffers.vectors::<3>(at)).transpose()?;
        let uvs = uv.map(|at| buffers.vectors::<2>(at)).transpose()?;
        // glTF's v grows downwards in the image.
        let uvs = uvs.map(|all| all.into_iter().map(|[u, v]| [u, 1.0 - v]).collect());
        let corners = buffers.whole::<1>(indices)?.into_flattened();
        let (triangles, rest) = corners.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(FileError {
                message: "its corners make no triangles".to_owned(),
                place: format!("/accessors/{indices}"),
                help: None,
            });
        }
        Ok(Geometry { positions, normals, uvs, triangles: triangles.to_vec() })
    }

    fn camera(&mut self, node: Item<'v>, map: &Affine, source: &mut Source<'_>) {
        let camera = node.count("camera").and_then(|at| self.cameras.get(at).copied());
        let Some((camera, lens)) = camera.and_then(|camera| Some((camera, camera.inner("perspective")?))) else {
            self.say(node, REFERENCE, "there is no such camera with a perspective", source);
            return;
        };
        self.only(lens, &["aspectRatio", "yfov", "znear", "zfar"], source);
        self.reading.clip = Some(Clip { near: lens.number("znear"), far: lens.number("zfar"), default: None });
        let (Some(yfov), Some(ratio)) = (lens.number("yfov"), lens.number("aspectRatio")) else {
            self.say(camera, SYNTAX, "a camera without angle and ratio is not read", source);
            return;
        };
        let column = |at: usize| map.rows.map(|row| row[at]);
        let axes = [column(0), column(1), column(2).map(|part| -part)].map(normalized);
        let [Some(right), Some(up), Some(forward)] = axes else {
            self.say(node, SYNTAX, "the camera has no axes", source);
            return;
        };
        let fov_x = (2.0 * libm::atan(libm::tan(yfov / 2.0) * ratio)).to_degrees();
        let (fov_y, eye) = (yfov.to_degrees(), column(3));
        if self.reading.view.is_some() {
            self.say(node, SYNTAX, "a second camera is not read", source);
        }
        self.reading.view = Some(View { eye, right, up, forward, fov_x, fov_y, shift: [0.0; 2] });
    }

    fn light(&mut self, light: Item<'v>, node: Item<'v>, map: &Affine, source: &mut Source<'_>) {
        self.only(light, &["name", "type", "color", "intensity", "spot"], source);
        let color = light.row::<3>("color").unwrap_or([1.0; 3]);
        let strength = color.map(|channel| channel * light.number("intensity").unwrap_or(1.0));
        if !has_orthogonal_columns(map) {
            self.say(node, SYNTAX, "the node of the light shears", source);
        }
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
            None => self.say(node, SYNTAX, "the light cannot be read", source),
        }
    }

    fn materials(&mut self, source: &mut Source<'_>) -> Result<(), FileError> {
        let (images, textures) = (self.document.list("images")?, self.document.list("textures")?);
        for sampler in self.document.list("samplers")? {
            if ["wrapS", "wrapT"].iter().any(|key| sampler.count(key).is_some_and(|how| how != names::REPEAT as usize))
            {
                self.say(sampler, SYNTAX, "an image that does not repeat is not read", source);
            }
        }
        for item in self.document.list("materials")? {
            let (model, emission, two_sided) = self.material(item, (&textures, &images), source);
            let name = item.text("name").unwrap_or_default().to_owned();
            self.reading.materials.push(Surface { name, model, two_sided });
            self.emissions.push(emission);
        }
        Ok(())
    }

    /// An image: a file, or bytes of a buffer.
    fn picture(&self, image: Item<'v>, source: &mut Source<'_>) -> Option<Picture> {
        if let Some(uri) = image.text("uri") {
            return source.path(self.path, uri, || place(self.path, image.place())).map(Picture::File);
        }
        self.buffers.view(image.count("bufferView")?).map(|bytes| Picture::Here(ImageFile::new(bytes)))
    }

    fn material(
        &self,
        item: Item<'v>,
        (textures, images): (&[Item<'v>], &[Item<'v>]),
        source: &mut Source<'_>,
    ) -> (Model, Option<Emitted>, bool) {
        let surface = item.inner("pbrMetallicRoughness");
        if let Some(surface) = surface {
            let known = ["baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor"];
            self.only(surface, &known, source);
        }
        let number = |name: &str| surface.and_then(|surface| surface.number(name)).unwrap_or(1.0);
        let [r, g, b, a] = surface.and_then(|surface| surface.row::<4>("baseColorFactor")).unwrap_or([1.0; 4]);
        if a != 1.0 {
            self.say(item, SYNTAX, "a base color with an alpha other than 1 is not read", source);
        }
        let mut base = Paint::Color([r, g, b]);
        if let Some(used) = surface.and_then(|surface| surface.inner("baseColorTexture")) {
            self.only(used, &["index"], source);
            let texture = used.count("index").and_then(|at| textures.get(at));
            let image = texture.and_then(|texture| images.get(texture.count("source")?));
            match image.and_then(|image| self.picture(*image, source)) {
                Some(file) => base = Paint::Image { file, linear: false, factor: [r, g, b] },
                None => self.say(item, REFERENCE, "the image of the base color is not there", source),
            }
        }
        let extension = |name: &str, key: &'static str, source: &mut Source<'_>| {
            let found = item.extension(name)?;
            self.only(found, &[key], source);
            found.number(key)
        };
        if let Some(extensions) = item.inner("extensions") {
            let known: Vec<&str> =
                EXTENSIONS.iter().copied().filter(|name| name.starts_with("KHR_materials")).collect();
            self.only(extensions, &known, source);
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
                self.say(
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
                self.say(item, SYNTAX, "the emission is no color", source);
                [0.0; 3]
            });
            let radiance = factor.map(|channel| channel * strength);
            Emitted { radiance, both_sides: two_sided, reversed: false }
        });
        (model, emission, two_sided)
    }
}
