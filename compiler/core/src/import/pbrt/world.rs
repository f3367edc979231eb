//! The state that directives change, and what they do to it.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use super::dialect::{self, Dialect};
use super::light::Area;
use super::material::Surface;
use super::params::{Param, Params};
use super::settings::Wanted;
use super::texture::Paint;
use super::tokens::{Token, Tokens};
use crate::diag::{FileId, Finding, Span};
use crate::files::VPath;
use crate::import::Builder;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{self, Affine, Handle, Mesh, Scene, Texture, cross, normalized, sub};

/// How deep files may include each other.
const INCLUDES: usize = 32;
/// How deep attributes may be nested.
const NESTED: usize = 4096;

/// What a medium becomes.
pub const MEDIUM: &str = "a medium is left out: light travels through nothing";

/// A text that is being read.
struct Frame {
    path: VPath,
    file: FileId,
    text: Arc<str>,
    at: usize,
}

/// What blocks restore.
#[derive(Clone)]
pub struct State {
    /// From object coordinates to those of the world.
    pub map: Affine,
    /// Whether orientations are reversed.
    pub reverse: bool,
    /// The material.
    pub material: Option<Rc<Surface>>,
    /// What shapes emit.
    pub area: Option<Rc<Area>>,
    /// Whether transforms change the start of the shutter's time.
    start: bool,
    /// Parameters that directives of a kind have beside their own (v4's `Attribute`), the newest first.
    defaults: BTreeMap<String, Rc<Vec<Param>>>,
}

impl State {
    /// What `Attribute` has given directives of a kind.
    pub fn defaults(&self, target: &str) -> Option<Rc<Vec<Param>>> {
        self.defaults.get(target).map(Rc::clone)
    }
}

/// An open block.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    Attributes,
    Transform,
    Object,
}

/// The scene in the making and the state of its reading.
pub struct World<'r, 'f> {
    /// Where files and findings are.
    pub reader: &'r mut Reader<'f>,
    /// Where shapes go.
    pub to: Builder,
    /// The version of the format.
    pub dialect: Dialect,
    /// The state.
    pub state: State,
    /// From PBRT's world to the Scene's: mirrored where the camera is not.
    pub outer: Affine,
    /// By what the film multiplies light.
    pub exposure: f64,
    /// What was said before the world.
    pub wanted: Wanted,
    /// Colors of surfaces by name.
    pub paints: BTreeMap<String, Paint>,
    /// Numbers on surfaces by name.
    pub floats: BTreeMap<String, Paint>,
    /// Materials by name.
    pub materials: BTreeMap<String, Rc<Surface>>,
    /// Checkerboards that are there already.
    pub boards: HashMap<[[u64; 3]; 2], Option<Handle<Texture>>>,
    /// Bodies with a formula that are there already, by what they are.
    pub bodies: HashMap<String, Handle<Mesh>>,
    /// Forms of meshes that are there already, by the mesh and what was changed.
    pub forms: HashMap<(usize, String), Handle<Mesh>>,
    /// Objects by name; none for one without shapes.
    pub objects: BTreeMap<String, Option<Handle<ir::Group>>>,
    /// The object that is being described.
    pub object: Option<(String, ir::Arena<ir::Shape>, Span)>,
    /// The last `LookAt` with the transforms before and behind it.
    pub look: Option<([f64; 9], Affine, Affine)>,
    systems: BTreeMap<String, Affine>,
    stack: Vec<(Block, State, Span)>,
    frames: Vec<Frame>,
    main: VPath,
    begin: Span,
    /// Whether the world is described.
    inside: bool,
    ended: bool,
    steps: u64,
    bytes: u64,
}

impl<'r, 'f> World<'r, 'f> {
    /// Opens the main file.
    pub fn new(reader: &'r mut Reader<'f>, path: &VPath) -> Option<Self> {
        let file = match reader.text(path) {
            Ok(file) => file,
            Err(error) => {
                let origin = crate::diag::Origin::File { path: path.as_str().to_owned(), place: String::new() };
                reader.error("missing-file", origin, format!("`{path}` cannot be read: {error}"));
                return None;
            }
        };
        let dialect = dialect::of(reader, path, file);
        let text = Arc::clone(&reader.sources.get(file).text);
        let state = State {
            map: Affine::IDENTITY,
            reverse: false,
            material: None,
            area: None,
            start: true,
            defaults: BTreeMap::new(),
        };
        Some(Self {
            reader,
            to: Builder::default(),
            dialect,
            state,
            outer: Affine::IDENTITY,
            exposure: 1.0,
            wanted: Wanted::new(dialect),
            paints: BTreeMap::new(),
            floats: BTreeMap::new(),
            materials: BTreeMap::new(),
            boards: HashMap::new(),
            bodies: HashMap::new(),
            forms: HashMap::new(),
            objects: BTreeMap::new(),
            object: None,
            look: None,
            systems: BTreeMap::new(),
            stack: Vec::new(),
            begin: Span::new(file, 0, 1),
            bytes: text.len() as u64,
            frames: vec![Frame { path: path.clone(), file, text, at: 0 }],
            main: path.clone(),
            inside: false,
            ended: false,
            steps: 0,
        })
    }

    /// Reads all directives.
    pub fn run(&mut self) {
        while let Some(frame) = self.frames.last() {
            let (text, file, at) = (Arc::clone(&frame.text), frame.file, frame.at);
            let depth = self.frames.len();
            let mut tokens = Tokens::new(&text, at, file);
            let Some((token, span)) = tokens.next() else {
                self.frames.pop();
                continue;
            };
            self.steps += 1;
            if self.steps > self.reader.limits().steps {
                let message =
                    format!("reading ends here: there are more than {} directives", self.reader.limits().steps);
                self.reader.lost_with(Fate::Dropped, span, message, "`--limit steps=N` allows more");
                break;
            }
            if self.ended {
                self.reader.lost(Fate::Dropped, span, "what stands behind `WorldEnd` is left out");
                break;
            }
            match token {
                Token::Word(word) => self.directive(&word, span, &mut tokens),
                Token::Number(_) | Token::Quoted(_) | Token::Open | Token::Close => {
                    self.reader.lost(Fate::Dropped, span, "values that belong to no directive are left out");
                    tokens.skip();
                }
                Token::Broken => {
                    self.reader.lost(Fate::Dropped, span, "a text in quotes without an end is left out");
                }
            }
            // A file that was included lies above this one.
            if let Some(frame) = self.frames.get_mut(depth - 1) {
                frame.at = tokens.at;
            }
        }
    }

    /// The scene; none where the file says nothing.
    pub fn finish(mut self, name: String) -> Option<Scene> {
        if self.steps == 0 {
            let finding = Finding::error("syntax-error", self.begin, "the file holds no scene");
            self.reader.add(finding.help("a scene of PBRT has a `Camera` before `WorldBegin`"));
            return None;
        }
        if let Some((_, _, span)) = self.stack.first() {
            self.reader.lost(Fate::Dropped, *span, "a block is not ended");
        }
        if self.object.is_some() {
            self.end_object();
        }
        if !self.inside {
            self.place_camera();
        }
        let begin = self.begin;
        if self.to.cameras() == 0 {
            self.reader.lost(Fate::Approximated, begin, "the scene has no camera: one is put before it");
            self.to.stand_back(begin.into());
        }
        let settings = self.wanted.settings();
        if self.exposure != 1.0 {
            self.to.brighten(self.exposure);
        }
        Some(self.to.finish(name, begin.into(), settings))
    }

    /// Says that something is left out, which changes the image.
    pub fn dropped(&mut self, at: Span, message: impl Into<String>) {
        self.reader.lost(Fate::Dropped, at, message);
    }

    /// Says that something is read as what is near it.
    pub fn near(&mut self, at: Span, message: impl Into<String>) {
        self.reader.lost(Fate::Approximated, at, message);
    }

    /// From object coordinates to those of the Scene.
    pub fn place(&self) -> Affine {
        self.state.map.then(&self.outer)
    }

    /// The file of a path: beside the main file, as PBRT has it, else beside the file that names it.
    pub fn path(&mut self, written: &str, at: Span) -> Option<VPath> {
        let own = self.frames.last().map_or_else(|| self.main.clone(), |frame| frame.path.clone());
        let written = written.replace('\\', "/");
        let mut first = None;
        for folder in [self.main.folder(), own.folder()] {
            match VPath::resolve(folder, &written) {
                Ok(path) if self.reader.bytes(&path).is_ok() => return Some(path),
                found => {
                    first.get_or_insert(found);
                }
            }
        }
        match first? {
            Ok(path) => Some(path),
            Err(error) => {
                let message = format!("`{}` is not read: {error}", shown(&written));
                let help = "copy the file below the root, or widen it by `--root`";
                self.reader.lost_with(Fate::Dropped, at, message, help);
                None
            }
        }
    }

    /// Parameters of a directive of a kind, with those that `Attribute` has given it.
    fn params(&mut self, kind: &str, target: &str, start: usize, tokens: &mut Tokens<'_>) -> Params {
        let mut params = Params::read(kind, start, tokens, self.reader);
        if let Some(defaults) = self.state.defaults.get(target) {
            params.inherit(defaults);
        }
        params
    }

    fn directive(&mut self, word: &str, span: Span, tokens: &mut Tokens<'_>) {
        let start = span.start as usize;
        match word {
            "Include" | "Import" => match tokens.string() {
                Some(name) => self.include(word, &name, tokens.since(start)),
                None => self.malformed(word, span, "the name of a file", tokens),
            },
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform" => {
                self.transform(word, span, tokens);
            }
            "CoordinateSystem" | "CoordSysTransform" => match tokens.string() {
                Some(name) if word == "CoordinateSystem" => {
                    self.systems.insert(name, self.state.map);
                }
                Some(name) => match self.systems.get(&name) {
                    Some(map) => self.state.map = *map,
                    None => {
                        let message = format!("there is no coordinate system `{}`: it changes nothing", shown(&name));
                        self.dropped(tokens.since(start), message);
                    }
                },
                None => self.malformed(word, span, "a name", tokens),
            },
            "ActiveTransform" => {
                let which = match tokens.next() {
                    Some((Token::Word(which) | Token::Quoted(which), _)) => which,
                    _ => String::new(),
                };
                self.state.start = which != "EndTime";
                if which != "All" {
                    self.dropped(span, "motion is left out: all is where it is when the shutter opens");
                }
            }
            "TransformTimes" => {
                if tokens.row::<2>().is_none() {
                    self.malformed(word, span, "two numbers", tokens);
                }
            }
            "ReverseOrientation" => self.state.reverse = !self.state.reverse,
            "AttributeBegin" => self.open(Block::Attributes, span),
            "TransformBegin" => self.open(Block::Transform, span),
            "AttributeEnd" => self.close(Block::Attributes, word, span),
            "TransformEnd" => self.close(Block::Transform, word, span),
            "ObjectBegin" => match tokens.string() {
                Some(name) => self.begin_object(name, tokens.since(start)),
                None => self.malformed(word, span, "a name", tokens),
            },
            "ObjectEnd" => {
                if self.object.is_none() {
                    self.dropped(span, "`ObjectEnd` ends nothing");
                    return;
                }
                self.end_object();
                self.close(Block::Object, word, span);
            }
            "ObjectInstance" => match tokens.string() {
                Some(name) => self.instance(&name, tokens.since(start)),
                None => self.malformed(word, span, "a name", tokens),
            },
            "WorldBegin" => {
                if self.inside {
                    self.dropped(span, "a second `WorldBegin` is left out");
                    return;
                }
                self.inside = true;
                self.place_camera();
                self.state.map = Affine::IDENTITY;
                self.state.start = true;
                self.systems.insert("world".to_owned(), Affine::IDENTITY);
            }
            "WorldEnd" => self.ended = true,
            "MediumInterface" => {
                // One name or two.
                let inside = tokens.string();
                let outside = if tokens.peek() == Some(b'"') { tokens.string() } else { None };
                if inside.iter().chain(&outside).any(|name| !name.is_empty()) {
                    self.dropped(tokens.since(start), MEDIUM);
                }
            }
            "NamedMaterial" => match tokens.string() {
                Some(name) => self.named_material(&name, tokens.since(start)),
                None => self.malformed(word, span, "a name", tokens),
            },
            "Texture" => self.texture_directive(start, tokens),
            "Camera" | "Film" | "PixelFilter" | "Filter" | "Sampler" | "Integrator" | "SurfaceIntegrator"
            | "VolumeIntegrator" | "Accelerator" | "Renderer" | "MakeNamedMedium" | "Volume" | "MakeNamedMaterial"
            | "Material" | "LightSource" | "AreaLightSource" | "Shape" | "Attribute" => match tokens.string() {
                Some(kind) => self.with_params(word, &kind, start, tokens),
                None => self.malformed(word, span, "a kind in quotes", tokens),
            },
            "ColorSpace" => match tokens.string() {
                Some(space) if space == "srgb" => {}
                Some(space) => {
                    let message = format!("colors of the space `{}` are read as those of sRGB", shown(&space));
                    self.near(tokens.since(start), message);
                }
                None => self.malformed(word, span, "a name", tokens),
            },
            "Option" => {
                let params = Params::read(word, start, tokens, self.reader);
                self.options(&params);
                params.finish(self.reader);
            }
            "SearchPath" => {
                let _folder: Option<String> = tokens.string();
                self.dropped(tokens.since(start), "`SearchPath` is left out: files are looked for beside the scene");
            }
            other => {
                let message = format!("`{}` is left out: it is no directive that is known", shown(other));
                self.dropped(span, message);
                tokens.skip();
            }
        }
    }

    fn malformed(&mut self, word: &str, span: Span, wanted: &str, tokens: &mut Tokens<'_>) {
        self.dropped(span, format!("`{word}` is left out: {wanted} must follow"));
        tokens.skip();
    }

    fn with_params(&mut self, word: &str, kind: &str, start: usize, tokens: &mut Tokens<'_>) {
        let target = match word {
            "Shape" => "shape",
            "LightSource" | "AreaLightSource" => "light",
            "Material" | "MakeNamedMaterial" => "material",
            "MakeNamedMedium" => "medium",
            _ => "",
        };
        let mut params = self.params(kind, target, start, tokens);
        if word == "MakeNamedMaterial" {
            // What is said of it is said of its kind.
            let kind = params.string("type", self.reader).map(str::to_owned);
            params.kind = kind.unwrap_or_else(|| "MakeNamedMaterial".to_owned());
        }
        let params = params;
        match word {
            "Camera" => {
                self.systems.insert("camera".to_owned(), inverse(&self.state.map).unwrap_or(Affine::IDENTITY));
                if self.wanted.camera.is_some() {
                    self.dropped(params.span, "a second camera is left out");
                } else {
                    self.wanted.camera = Some((params, self.state.map));
                }
                return;
            }
            "Film" => self.film(&params),
            "PixelFilter" | "Filter" => self.filter(&params),
            "Sampler" => self.sampler(&params),
            "Integrator" | "SurfaceIntegrator" => self.integrator(&params),
            "Renderer" => self.renderer(&params),
            // They change time, or what media look like, each of which is a finding.
            "Accelerator" | "VolumeIntegrator" => params.pass_all(),
            "MakeNamedMedium" | "Volume" => {
                params.pass_all();
                self.dropped(params.span, MEDIUM);
            }
            "MakeNamedMaterial" => self.make_named_material(kind, &params),
            "Material" => {
                let surface = self.surface(kind, kind, &params);
                self.state.material = Some(Rc::new(surface));
            }
            "LightSource" => self.light(&params),
            "AreaLightSource" => self.area_light(&params),
            "Attribute" => {
                let before = self.state.defaults.get(kind).cloned().unwrap_or_default();
                let mut params = params;
                params.inherit(&before);
                self.state.defaults.insert(kind.to_owned(), Rc::new(params.into_list()));
                return;
            }
            _ => self.shape(&params),
        }
        params.finish(self.reader);
    }

    fn include(&mut self, word: &str, name: &str, span: Span) {
        if name.to_ascii_lowercase().ends_with(".gz") {
            let message = format!("`{}` is left out: compressed texts are not read", shown(name));
            self.reader.lost_with(Fate::Dropped, span, message, "decompress it, and name it without `.gz`");
            return;
        }
        let Some(path) = self.path(name, span) else { return };
        if self.frames.iter().any(|frame| frame.path == path) {
            self.reader.error("import-limit", span, format!("`{path}` includes itself"));
            return;
        }
        if self.frames.len() >= INCLUDES {
            let message = format!("files include each other more than {INCLUDES} deep");
            self.reader.error("import-limit", span, message);
            return;
        }
        let file = match self.reader.text(&path) {
            Ok(file) => file,
            Err(error) => {
                self.dropped(span, format!("`{path}` is not included: it cannot be read: {error}"));
                return;
            }
        };
        let text = Arc::clone(&self.reader.sources.get(file).text);
        self.bytes += text.len() as u64;
        if self.bytes > self.reader.limits().memory {
            let message = format!("included texts have more than {} bytes together", self.reader.limits().memory);
            self.reader.lost_with(Fate::Dropped, span, message, "`--limit memory=N` allows more");
            return;
        }
        if word == "Import" {
            // Its own state: what it changes does not last. Blocks that it leaves open are ended with a finding.
            self.reader.lost(Fate::Noise, span, "`Import` is read as `Include`");
        }
        self.frames.push(Frame { path, file, text, at: 0 });
    }

    fn open(&mut self, block: Block, span: Span) {
        if self.stack.len() >= NESTED {
            self.dropped(span, format!("blocks are nested more than {NESTED} deep"));
            return;
        }
        self.stack.push((block, self.state.clone(), span));
    }

    fn close(&mut self, block: Block, word: &str, span: Span) {
        match self.stack.last() {
            Some((open, ..)) if *open == block => {}
            _ => {
                self.dropped(span, format!("`{word}` is left out: it ends nothing"));
                return;
            }
        }
        let Some((_, state, _)) = self.stack.pop() else { return };
        if block == Block::Transform {
            (self.state.map, self.state.start) = (state.map, state.start);
        } else {
            self.state = state;
        }
    }

    fn begin_object(&mut self, name: String, span: Span) {
        if self.object.is_some() {
            self.dropped(span, "an object in an object is left out: its shapes belong to the outer one");
            self.open(Block::Attributes, span);
            return;
        }
        self.open(Block::Object, span);
        self.object = Some((name, ir::Arena::default(), span));
    }

    fn end_object(&mut self) {
        let Some((name, shapes, span)) = self.object.take() else { return };
        let group = if shapes.is_empty() { None } else { Some(self.to.group(&name, shapes, &span.into())) };
        if self.objects.insert(name.clone(), group).is_some() {
            let message =
                format!("the object `{}` is described twice: from here on the second one counts", shown(&name));
            // v4 refuses it (`Redefining object instance`), all others replace it.
            let fate = if self.dialect == Dialect::V4 { Fate::Approximated } else { Fate::Noise };
            self.reader.lost(fate, span, message);
        }
    }

    fn instance(&mut self, name: &str, span: Span) {
        if self.object.is_some() {
            let message = "an object that is placed in an object is left out, as PBRT leaves it out";
            self.reader.lost(Fate::Noise, span, message);
            return;
        }
        match self.objects.get(name) {
            Some(Some(group)) => {
                let (group, place) = (*group, self.place());
                self.to.instance(self.reader, name, group, place, &span.into());
            }
            Some(None) => {}
            None => self.dropped(span, format!("there is no object `{}`: it is placed nowhere", shown(name))),
        }
    }

    fn transform(&mut self, word: &str, span: Span, tokens: &mut Tokens<'_>) {
        let map = match word {
            "Identity" => Some(Affine::IDENTITY),
            "Translate" => tokens.row().map(Affine::translation),
            "Scale" => tokens.row().map(Affine::scaling),
            "Rotate" => tokens.row().map(|[degrees, x, y, z]| match normalized([x, y, z]) {
                Some(axis) => Affine::rotation(axis, degrees),
                None => {
                    self.dropped(span, "a rotation about no axis is left out");
                    Affine::IDENTITY
                }
            }),
            "LookAt" => match tokens.row() {
                Some(row) => {
                    if look_at(row).is_none() {
                        self.dropped(span, "`LookAt` is left out: it has no direction");
                    }
                    let map = look_at(row).unwrap_or(Affine::IDENTITY);
                    self.look = look_at(row).map(|map| (row, self.state.map, map.then(&self.state.map)));
                    Some(map)
                }
                None => None,
            },
            _ => tokens.row().map(|row| self.matrix(&row, span)),
        };
        let Some(map) = map else {
            let wanted = match word {
                "Translate" | "Scale" => "three numbers",
                "Rotate" => "four numbers",
                "LookAt" => "nine numbers",
                _ => "sixteen numbers",
            };
            self.malformed(word, span, wanted, tokens);
            return;
        };
        if !self.state.start {
            return;
        }
        self.state.map = match word {
            "Identity" | "Transform" => map,
            _ => map.then(&self.state.map),
        };
    }

    /// A matrix by columns.
    fn matrix(&mut self, all: &[f64; 16], span: Span) -> Affine {
        let scale = all[15];
        if [all[3], all[7], all[11]] != [0.0; 3] || scale == 0.0 {
            self.dropped(span, "the last row of a matrix is left out: it is not 0 0 0 1");
        }
        let scale = if scale == 0.0 { 1.0 } else { scale };
        let rows = [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]].map(|x| x / scale));
        Affine { rows }
    }
}

/// From world to camera coordinates, x = up x forward, y up, z along the axis: PBRT's are left-handed (`LookAt` of
/// `transform.cpp`).
fn look_at([ex, ey, ez, tx, ty, tz, ux, uy, uz]: [f64; 9]) -> Option<Affine> {
    let eye = [ex, ey, ez];
    let forward = normalized(sub([tx, ty, tz], eye))?;
    let x = normalized(cross(normalized([ux, uy, uz])?, forward))?;
    let axes = [x, cross(forward, x), forward];
    Some(Affine { rows: axes.map(|axis| [axis[0], axis[1], axis[2], -ir::dot(axis, eye)]) })
}

/// The inverse; none where there is none.
pub fn inverse(map: &Affine) -> Option<Affine> {
    if !map.is_invertible() {
        return None;
    }
    let (cofactors, determinant) = (map.cofactors(), map.determinant());
    let linear = [0, 1, 2].map(|row: usize| [0, 1, 2].map(|column: usize| cofactors[column][row] / determinant));
    let moved = map.rows.map(|row| row[3]);
    Some(Affine { rows: linear.map(|row| [row[0], row[1], row[2], 0.0 - ir::dot(row, moved)]) })
}
