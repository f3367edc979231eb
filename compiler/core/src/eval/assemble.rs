//! The evaluated file to the Scene.

use std::collections::HashMap;
use std::rc::Rc;

use crate::diag::{Finding, Span, nearest};
use crate::files::VPath;
use crate::ir::{
    Affine, Arena, Bsdf, Camera, Color, Documentation, Emission, Film, Group, Handle, Instance, LightKind, LightPaths,
    LightSource, Material, Mesh, Scene, Shape, Similar,
};
use crate::syntax::{ExprKind, Kind, Name};

use super::items::{GroupBody, Item, Lit, Placed};
use super::module::{Header, Module};
use super::value::{CameraValue, GroupValue, MaterialValue, Value};
use super::{Interpreter, Overrides, Reported};

/// The fields of a scene's header.
const FIELDS: [&str; 5] = ["paths", "similar", "comments", "source", "license"];

impl Interpreter<'_> {
    /// The scene of a scene file; none for a library, and where settings are missing.
    pub(super) fn assemble(&mut self, module: Module, path: &VPath, overrides: &Overrides) -> Option<Scene> {
        let Module { header, items, lights, instances: placed, cameras, film, integrator, sampler, broken, .. } =
            module;
        let header = header?;
        let documentation = self.documentation(&header);
        let Header { name, doc: _, fields: _ } = header;
        if name.text != path.stem() {
            self.findings.push(
                Finding::error("scene-name", name.span, format!("the scene `{}` lies in `{}`", name.text, path.name()))
                    .note("a scene is named as its file: generated folders and similar scenes are found by that name")
                    .help(format!("write `scene {}`, or rename the file", path.stem())),
            );
        }
        if !names_a_folder(&name.text) {
            self.findings.push(
                Finding::error("scene-name", name.span, "the name of a scene is also that of its folder")
                    .label("cannot be the name of a folder on every system")
                    .help("use letters, digits, `_` and `-`, at most 100, beginning with a letter"),
            );
        }
        let missing = [
            (
                Kind::Camera,
                cameras.is_empty(),
                "camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)",
            ),
            (Kind::Film, film.is_none(), "film = image(512, 512)"),
            (Kind::Integrator, integrator.is_none(), "integrator = path(max_depth: 10)"),
            (Kind::Sampler, sampler.is_none(), "sampler = independent(samples: 32)"),
        ];
        // A setting whose statement could not be read is not missing.
        let unread = |word: &str| {
            let text = &self.sources.get(name.span.file).text;
            self.findings.iter().any(|found| found.id == "syntax-error")
                && text.lines().any(|line| line.trim_start().starts_with(word))
        };
        let lacking: Vec<(&str, &str)> = missing
            .iter()
            .filter(|(kind, missing, _)| *missing && !broken.contains(kind) && !unread(kind.word()))
            .map(|(kind, _, example)| (kind.word(), *example))
            .collect();
        if let Some(((last, _), more)) = lacking.split_last() {
            let more: Vec<&str> = more.iter().map(|(word, _)| *word).collect();
            let more = if more.is_empty() { String::new() } else { format!("{} and no ", more.join(", no ")) };
            let lines: String = lacking.iter().map(|(_, example)| format!("\n        {example}")).collect();
            let help = if lacking.len() == 1 {
                format!("write for example `{}`", lacking[0].1)
            } else {
                format!("write for example:{lines}")
            };
            self.findings.push(
                Finding::error("missing-setting", name.span, format!("the scene has no {more}{last}")).help(help),
            );
        }
        let (Some((film, _)), Some((integrator, _)), Some((sampler, _))) = (film, integrator, sampler) else {
            return None;
        };
        let film = overrides.film(&film);
        let mut built = Builder::default();
        let cameras = cameras.into_iter().fold(Arena::default(), |mut arena, (name, camera, span)| {
            let _handle: Handle<Camera> = arena.push(finish_camera(name, &camera, &film), span);
            arena
        });
        let instances = built.instances(&placed);
        let shapes = built.shapes(&items);
        let mut all_lights = Arena::default();
        place_lights(&mut all_lights, &lights, &placed, &Affine::IDENTITY, "");
        let Builder { meshes, materials, groups, .. } = built;
        let documentation = Documentation { parameters: self.scene_parameters.clone(), ..documentation };
        Some(Scene {
            name: name.text,
            origin: name.span.into(),
            documentation,
            meshes,
            textures: std::mem::take(&mut self.textures),
            materials,
            shapes,
            lights: all_lights,
            groups,
            instances,
            cameras,
            film,
            integrator: overrides.integrator(&integrator),
            sampler: overrides.sampler(&sampler),
        })
    }

    pub(super) fn documentation(&mut self, header: &Header) -> Documentation {
        let (brief, full) = split_doc(&header.doc);
        let mut documentation = Documentation { brief, full, ..Documentation::default() };
        for (name, value, _) in &header.fields {
            // What is wrong is reported; the field stays empty.
            let _reported: Result<(), Reported> = match name.text.as_str() {
                "paths" => self.strings(name, value).map(|paths| documentation.paths = paths),
                "similar" => self.similar(name, value).map(|similar| documentation.similar = similar),
                "comments" => self.string(name, value).map(|text| documentation.comments = text),
                "source" => self.string(name, value).map(|text| documentation.source = text),
                "license" => self.string(name, value).map(|text| documentation.license = text),
                other => {
                    let similar = nearest(other, FIELDS).map(|name| format!("did you mean `{name}`?"));
                    self.report(
                        Finding::error("unknown-field", name.span, format!("a scene has no field `{other}`"))
                            .note(format!("known: {}", FIELDS.join(", ")))
                            .maybe_help(similar),
                    )
                }
            };
        }
        for (at, path) in documentation.paths.iter().enumerate() {
            let Err(error) = LightPaths::parse(path) else { continue };
            self.findings.push(
                Finding::error(
                    "invalid-path-class",
                    path_span(header, at, path, error.at),
                    format!("`{path}` is no class of light paths"),
                )
                .label(error.message)
                .note("letters are L (light), E (eye), D (diffuse), G (glossy), S (specular), with `( ) | * +`")
                .help("write for example `LDDE` or `LS+DE`, in full form `LDD S+ D DSE`"),
            );
        }
        documentation
    }

    fn field_type<T>(&mut self, name: &Name, wants: &str, example: &str) -> Result<T, Reported> {
        self.report(
            Finding::error("type-mismatch", name.span, format!("`{}` takes {wants}", name.text))
                .help(format!("write for example `{example}`")),
        )
    }

    fn string(&mut self, name: &Name, value: &Value) -> Result<String, Reported> {
        match value {
            Value::String(text) => Ok(text.to_string()),
            _ => self.field_type(name, "a string", &format!("{}: \"...\"", name.text)),
        }
    }

    fn strings(&mut self, name: &Name, value: &Value) -> Result<Vec<String>, Reported> {
        let items = match value {
            Value::List(items) => items
                .iter()
                .map(|item| if let Value::String(text) = item { Some(text.to_string()) } else { None })
                .collect(),
            _ => None,
        };
        match items {
            Some(items) => Ok(items),
            None => self.field_type(name, "a list of strings", "paths: [\"LDE\", \"LDDE\"]"),
        }
    }

    fn similar(&mut self, name: &Name, value: &Value) -> Result<Vec<Similar>, Reported> {
        let pair = |item: &Value| match item {
            Value::Tuple(parts) => match (parts.first(), parts.get(1), parts.len()) {
                (Some(Value::String(scene)), Some(Value::String(reason)), 2) => {
                    Some(Similar { scene: scene.to_string(), reason: reason.to_string() })
                }
                _ => None,
            },
            _ => None,
        };
        let items: Option<Vec<Similar>> = match value {
            Value::List(items) => items.iter().map(pair).collect(),
            _ => None,
        };
        match items {
            Some(items) => Ok(items),
            None => self.field_type(
                name,
                "a list of pairs (scene, reason)",
                "similar: [(\"cbox_empty\", \"without the boxes\")]",
            ),
        }
    }
}

/// Whether a folder can have this name on every system; device names are Windows's.
fn names_a_folder(name: &str) -> bool {
    let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    let device = |word: &str| {
        matches!(word, "con" | "prn" | "aux" | "nul")
            || word.len() == 4
                && (word.starts_with("com") || word.starts_with("lpt"))
                && word.ends_with(|c: char| c.is_ascii_digit())
    };
    plain
        && name.len() <= 100
        && name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && !device(&name.to_ascii_lowercase())
}

/// The place of byte `byte` of the class of light paths number `at`, as exactly as it can be told.
fn path_span(header: &Header, at: usize, path: &str, byte: usize) -> Span {
    let Some((name, _, written)) = header.fields.iter().find(|(name, ..)| name.text == "paths") else {
        return header.name.span;
    };
    let ExprKind::List(parts) = &written.kind else { return name.span };
    let Some(span) = parts.get(at).map(|part| part.span) else { return name.span };
    // Between its quotes a string without escapes is as long as its text.
    if (span.end - span.start) as usize != path.len() + 2 {
        return span;
    }
    let start = span.start + 1 + byte as u32;
    Span { start, end: (start + 1).min(span.end), ..span }
}

/// The first paragraph on one line, and the rest.
fn split_doc(doc: &str) -> (String, String) {
    let lines: Vec<&str> = doc.lines().collect();
    let end = lines.iter().position(|line| line.trim().is_empty()).unwrap_or(lines.len());
    (lines[..end].join(" ").trim().to_owned(), lines[end..].join("\n").trim().to_owned())
}

/// The arenas in the making.
#[derive(Default)]
struct Builder {
    meshes: Arena<Mesh>,
    materials: Arena<Material>,
    groups: Arena<Group>,
    /// By address; the values are kept alive so that no address is used twice.
    known_meshes: HashMap<*const Mesh, (Handle<Mesh>, Rc<Mesh>)>,
    known_materials: HashMap<*const MaterialValue, (Handle<Material>, Rc<MaterialValue>)>,
    /// By name and numbers.
    equal_materials: HashMap<String, Handle<Material>>,
    known_groups: HashMap<*const GroupBody, (Handle<Group>, Rc<GroupBody>)>,
    black: Option<Handle<Material>>,
}

impl Builder {
    fn shapes(&mut self, items: &[Item]) -> Arena<Shape> {
        let mut shapes = Arena::default();
        for item in items {
            let Item { name, span, mesh, material, emission } = item;
            let (material, emission) = match (material, emission) {
                (Some(material), _) => (self.material(material, name), None),
                (None, Some(emission)) => {
                    let over = emission.over.as_ref().map(|over| self.material(over, name));
                    (over.unwrap_or_else(|| self.black(*span)), Some(Emission { radiance: emission.radiance.clone() }))
                }
                (None, None) => continue,
            };
            let handle = self.mesh(&mesh.mesh, mesh.span);
            let shape = Shape { name: name.clone(), mesh: handle, transform: mesh.transform, material, emission };
            shapes.push(shape, *span);
        }
        shapes
    }

    /// Groups come first, so that handles point backwards. How deep they hold each other is limited.
    fn instances(&mut self, placed: &[Placed]) -> Arena<Instance> {
        let mut instances = Arena::default();
        for Placed { name, span, group: GroupValue { body, places } } in placed {
            let group = self.group(body);
            instances.push(Instance { name: name.clone(), group, places: places.clone() }, *span);
        }
        instances
    }

    fn group(&mut self, body: &Rc<GroupBody>) -> Handle<Group> {
        if let Some((known, _)) = self.known_groups.get(&Rc::as_ptr(body)) {
            return *known;
        }
        let GroupBody { name, span, items, lights: _, instances, size: _, depth: _, lit: _ } = &**body;
        let shapes = self.shapes(items);
        let instances = self.instances(instances);
        let handle = self.groups.push(Group { name: name.clone(), shapes, instances }, *span);
        self.known_groups.insert(Rc::as_ptr(body), (handle, Rc::clone(body)));
        handle
    }

    fn mesh(&mut self, mesh: &Rc<Mesh>, span: Span) -> Handle<Mesh> {
        let meshes = &mut self.meshes;
        let entry = self.known_meshes.entry(Rc::as_ptr(mesh));
        entry.or_insert_with(|| (meshes.push((**mesh).clone(), span), Rc::clone(mesh))).0
    }

    /// A declared material once, also where equal calls of a function made it; one written in place takes the name of
    /// the first shape that it is made for.
    fn material(&mut self, material: &Rc<MaterialValue>, shape: &str) -> Handle<Material> {
        let key = Rc::as_ptr(material);
        if let Some((known, _)) = self.known_materials.get(&key) {
            return *known;
        }
        let name = material.name.clone().unwrap_or_else(|| shape.to_owned());
        let materials = &mut self.materials;
        let made = Material { name, bsdf: material.bsdf.clone(), sides: material.sides };
        let handle =
            *self.equal_materials.entry(format!("{made:?}")).or_insert_with(|| materials.push(made, material.span));
        self.known_materials.insert(key, (handle, Rc::clone(material)));
        handle
    }

    /// The surface of emitters that say nothing else.
    fn black(&mut self, span: Span) -> Handle<Material> {
        let materials = &mut self.materials;
        let bsdf = Bsdf::Diffuse { reflectance: Color::BLACK.into() };
        *self.black.get_or_insert_with(|| materials.push(Material::new("black", bsdf), span))
    }
}

/// Lights of the scene, and those of groups wherever instances place them: no target can hold a light in a group.
fn place_lights(placed: &mut Arena<LightSource>, lights: &[Lit], instances: &[Placed], map: &Affine, path: &str) {
    let joined = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
    for Lit { name, span, kind } in lights {
        let kind = match kind {
            LightKind::Point { position, intensity } => {
                LightKind::Point { position: map.point(*position), intensity: intensity.clone() }
            }
            LightKind::Spot { position, target, intensity, angle, inner } => LightKind::Spot {
                position: map.point(*position),
                target: map.point(*target),
                intensity: intensity.clone(),
                angle: *angle,
                inner: *inner,
            },
            // Groups hold neither; those of the scene are not moved.
            LightKind::Environment { radiance: _, tint: _, turn: _ }
            | LightKind::Directional { direction: _, irradiance: _ } => kind.clone(),
        };
        placed.push(LightSource { name: joined(name), kind }, *span);
    }
    for Placed { name, span: _, group: GroupValue { body, places } } in
        instances.iter().filter(|placed| placed.group.body.lit)
    {
        for (at, place) in places.maps().iter().enumerate() {
            let path = joined(&places.name_of(name, at));
            place_lights(placed, &body.lights, &body.instances, &place.then(map), &path);
        }
    }
}

fn finish_camera(name: Option<String>, camera: &CameraValue, film: &Film) -> Camera {
    let CameraValue { eye, target, up, fov, vertical, near, far } = *camera;
    let fov_x = if vertical {
        let aspect = f64::from(film.width) / f64::from(film.height);
        (2.0 * libm::atan(libm::tan((fov / 2.0).to_radians()) * aspect)).to_degrees()
    } else {
        fov
    };
    Camera { name, eye, target, up, fov_x, near, far }
}
