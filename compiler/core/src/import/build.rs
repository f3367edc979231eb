//! The Scene in the making: arenas, names that are not used twice, files that are read once.

use std::collections::{HashMap, HashSet};

use super::color::BRIGHTEST;
use super::reader::{Fate, Reader, code_of};
use crate::diag::{Finding, Origin, Severity};
use crate::files::VPath;
use crate::image::write::Depth;
use crate::image::{self, Loaded, Loss, Pixels};
use crate::ir::{
    Affine, Arena, Bsdf, Camera, Color, ColorOrTexture, Documentation, Emission, Encoding, Film, Filter, Group, Handle,
    Instance, Integrator, LightKind, LightSource, Material, Mesh, Sampler, Scene, Shape, Sides, Texture,
};
use crate::mesh::{self, Geometry, file as mesh_file};

/// How the normals of a mesh from a file come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Those of the file; none where it has none.
    Given,
    /// Those of the file, else smooth ones, weighted by the angles of the faces.
    Smooth,
    /// Those of the faces, which are flat.
    Flat,
}

/// A mesh in a file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Wanted {
    /// The file.
    pub path: VPath,
    /// Which of its meshes.
    pub part: Option<String>,
    /// Its normals.
    pub shading: Shading,
    /// Whether its front is its back.
    pub flipped: bool,
    /// Whether the file's v grows downwards in images.
    pub down: bool,
}

/// What is known of a mesh in a file: the mesh, and whether the file has normals; none where it cannot be read.
type KnownMesh = Option<(Handle<Mesh>, bool)>;

/// What an image in a file is read by: the file, how it is decoded, and the bits of its factor.
type TextureKey = (VPath, Option<Encoding>, [u64; 3]);

/// The limits of the Scene itself, whatever the user allows.
const NAMED: usize = 1 << 20;

/// A scene in the making.
#[derive(Default)]
pub struct Builder {
    pub(super) meshes: Arena<Mesh>,
    textures: Arena<Texture>,
    materials: Arena<Material>,
    pub(super) shapes: Arena<Shape>,
    lights: Arena<LightSource>,
    pub(super) groups: Arena<Group>,
    pub(super) instances: Arena<Instance>,
    cameras: Arena<Camera>,
    /// Whether the format says that the numbers of images are taken as they are stored, whatever their files say of their colors.
    pub(super) as_stored: bool,
    known_meshes: HashMap<Wanted, KnownMesh>,
    /// That materials of a mesh file are not read: said once a shape without one of its own uses the mesh.
    unread_materials: HashMap<Wanted, Vec<Finding>>,
    known_textures: HashMap<TextureKey, Option<Handle<Texture>>>,
    remade_textures: HashMap<(usize, String), Option<Handle<Texture>>>,
    equal_materials: HashMap<String, Handle<Material>>,
    names: HashSet<String>,
    /// How often a name was asked for, so that a thousand equal ones are not tried a thousand times each.
    asked: HashMap<String, u64>,
    triangles: u64,
    /// Shapes and instances.
    pub(super) placed: u64,
    /// The largest coordinate of each mesh, and of what is in each group.
    pub(super) mesh_reach: HashMap<Handle<Mesh>, f64>,
    pub(super) group_reach: HashMap<Handle<Group>, f64>,
}

/// What a scene is rendered by.
pub struct Settings {
    /// Resolution and filter.
    pub film: Film,
    /// Algorithm.
    pub integrator: Integrator,
    /// Sampling.
    pub sampler: Sampler,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            film: Film { width: 512, height: 512, filter: Filter::Box { radius: 0.5 } },
            integrator: Integrator::Path { max_depth: 10 },
            sampler: Sampler::Independent { samples: 32, seed: 0 },
        }
    }
}

impl Builder {
    /// A name that nothing else has, near the one that is wished for.
    pub fn unique(&mut self, wish: &str) -> String {
        let wish = plain(wish);
        if self.names.insert(wish.clone()) {
            return wish;
        }
        let asked = self.asked.entry(wish.clone()).or_insert(1);
        loop {
            *asked += 1;
            let name = format!("{wish}_{asked}");
            if self.names.insert(name.clone()) {
                return name;
            }
        }
    }

    /// A mesh from a file, read once for each way in which it is wanted, and whether the file has normals.
    /// `dressed` says that the shape has a material, so that those which the file names mean nothing.
    pub fn mesh_file(
        &mut self,
        reader: &mut Reader<'_>,
        wanted: &Wanted,
        dressed: bool,
        at: &Origin,
    ) -> Option<(Handle<Mesh>, bool)> {
        let known = match self.known_meshes.get(wanted) {
            Some(known) => *known,
            None => {
                let mut materials = Vec::new();
                let made = read_mesh(reader, wanted, &mut materials, at);
                let known = made.map(|(geometry, normals)| {
                    (self.meshes.push(geometry.into_mesh(wanted.path.stem()), at.clone()), normals)
                });
                self.known_meshes.insert(wanted.clone(), known);
                self.unread_materials.insert(wanted.clone(), materials);
                known
            }
        };
        if !dressed {
            self.unread_materials.remove(wanted).into_iter().flatten().for_each(|finding| reader.add(finding));
        }
        known
    }

    /// A mesh that the file describes itself; none where its arrays do not belong together, it has no triangle, or all meshes together
    /// have more than is allowed, each of which is a finding.
    pub fn mesh(
        &mut self,
        reader: &mut Reader<'_>,
        name: &str,
        geometry: Geometry,
        at: &Origin,
    ) -> Option<Handle<Mesh>> {
        self.triangles += geometry.triangles.len() as u64;
        if self.triangles > reader.limits().triangles {
            let most = reader.limits().triangles;
            let message = format!("the meshes have more than {most} triangles together");
            reader.lost_with(Fate::Dropped, at.clone(), message, "`--limit triangles=N` allows more");
            return None;
        }
        let fault = match geometry.check() {
            Ok(()) if geometry.triangles.is_empty() => Some("it has no triangle".to_owned()),
            Ok(()) => None,
            Err(error) => Some(error.message),
        };
        if let Some(fault) = fault {
            reader.lost(Fate::Dropped, at.clone(), format!("the mesh `{name}` is left out: {fault}"));
            return None;
        }
        Some(self.meshes.push(geometry.into_mesh(name), at.clone()))
    }

    /// Another form of a mesh that is there.
    pub fn changed(&mut self, mesh: Handle<Mesh>, change: impl FnOnce(Geometry) -> Geometry) -> Handle<Mesh> {
        let (name, origin) = (self.meshes[mesh].name.clone(), self.meshes.origin(mesh).clone());
        let geometry = change(Geometry::from_mesh(&self.meshes[mesh]));
        self.meshes.push(geometry.into_mesh(name), origin)
    }

    /// A mesh.
    pub fn mesh_of(&self, mesh: Handle<Mesh>) -> &Mesh {
        &self.meshes[mesh]
    }

    /// An image file; none where it cannot be read, which is a finding. `factor` lies between 0 and 1.
    pub fn texture(
        &mut self,
        reader: &mut Reader<'_>,
        path: &VPath,
        encoding: Option<Encoding>,
        factor: [f64; 3],
        at: &Origin,
    ) -> Option<Handle<Texture>> {
        let key = (path.clone(), encoding, factor.map(f64::to_bits));
        if let Some(known) = self.known_textures.get(&key) {
            return *known;
        }
        let made = read_texture(reader, path, (encoding, self.as_stored), factor, at);
        let handle = made.map(|texture| self.textures.push(texture, at.clone()));
        self.known_textures.insert(key, handle);
        handle
    }

    /// An image whose bytes the scene's own file holds; none where it cannot be read, which is a finding. `factor` lies between 0 and 1.
    pub fn texture_inside(
        &mut self,
        reader: &mut Reader<'_>,
        (name, ending): (&str, &str),
        bytes: &[u8],
        factor: [f64; 3],
        at: &Origin,
    ) -> Option<Handle<Texture>> {
        let texture = load_texture(reader, (name, name, ending), bytes, (None, self.as_stored), factor, at)?;
        Some(self.textures.push(texture, at.clone()))
    }

    /// Squares of two colors, two by two for each step of the texture coordinates: the first of `colors` at the left of the first row.
    pub fn checkerboard(
        &mut self,
        reader: &mut Reader<'_>,
        colors: [[f64; 3]; 2],
        at: &Origin,
    ) -> Option<Handle<Texture>> {
        const SIDE: usize = 256;
        let color = |at: usize| colors[usize::from((at % SIDE < SIDE / 2) != (at / SIDE < SIDE / 2))];
        let values = (0..SIDE * SIDE).flat_map(color).map(|value| value as f32).collect();
        let pixels = Pixels { width: SIDE, height: SIDE, channels: 3, values };
        let bytes = image::write::png(&pixels, 16).ok()?;
        let Loaded { info, file, peak, remarks: _ } = image::load("png", &bytes, u64::MAX).ok()?;
        let message =
            format!("a checkerboard becomes an image of {SIDE} x {SIDE} pixels: its edges are as wide as one of them");
        reader.lost(Fate::Approximated, at.clone(), message);
        let name = "checkerboard".to_owned();
        let texture = Texture { name, file, image: info, encoding: Encoding::Linear, peak, factor: [1.0; 3] };
        Some(self.textures.push(texture, at.clone()))
    }

    /// Another form of an image that is there, once for each `word`: its linear pixels through `change`.
    pub fn remade(
        &mut self,
        reader: &mut Reader<'_>,
        texture: Handle<Texture>,
        word: &str,
        change: impl FnOnce(Pixels) -> Pixels,
        at: &Origin,
    ) -> Option<Handle<Texture>> {
        let key = (texture.index(), word.to_owned());
        if let Some(known) = self.remade_textures.get(&key) {
            return *known;
        }
        let old = &self.textures[texture];
        let (name, factor) = (old.name.clone(), old.factor);
        let made = image::linear(old).map(change).and_then(|pixels| {
            let depth = if image::write::fits_half(&pixels) { Depth::Half } else { Depth::Full };
            image::load("exr", &image::write::exr(&pixels, depth)?, u64::MAX)
        });
        let handle = match made {
            Ok(Loaded { info, file, peak, remarks: _ }) => {
                let texture = Texture { name, file, image: info, encoding: Encoding::Linear, peak, factor };
                Some(self.textures.push(texture, at.clone()))
            }
            Err(error) => {
                reader.lost(Fate::Dropped, at.clone(), format!("the image `{name}` {}", error.message));
                None
            }
        };
        self.remade_textures.insert(key, handle);
        handle
    }

    /// An image as one of an environment has to be: linear floats, whatever the file holds.
    pub fn floats(
        &mut self,
        reader: &mut Reader<'_>,
        texture: Handle<Texture>,
        at: &Origin,
    ) -> Option<Handle<Texture>> {
        if self.textures[texture].image.format.is_float() {
            return Some(texture);
        }
        self.remade(reader, texture, "floats", |pixels| pixels, at)
    }

    /// The mean of an image's linear pixels.
    pub fn mean(&self, texture: Handle<Texture>) -> Option<[f64; 3]> {
        let texture = &self.textures[texture];
        let pixels = image::linear(texture).ok()?;
        let mut sum = [0.0; 3];
        let count = pixels.width * pixels.height;
        for at in 0..count {
            let color = pixels.at(at % pixels.width, at / pixels.width);
            (0..3).for_each(|c| sum[c] += f64::from(color[c]) * texture.factor[c]);
        }
        Some(sum.map(|sum| sum / count.max(1) as f64))
    }

    /// A texture.
    pub fn texture_of(&self, texture: Handle<Texture>) -> &Texture {
        &self.textures[texture]
    }

    /// A material, once for each name and meaning.
    pub fn material(&mut self, name: &str, bsdf: Bsdf, sides: Sides, at: &Origin) -> Handle<Material> {
        // What is clear or black is the same from behind.
        let sides = if bsdf.is_clear() || bsdf.is_black() { Sides::Both } else { sides };
        let made = Material { name: plain(name), bsdf, sides };
        let materials = &mut self.materials;
        *self.equal_materials.entry(format!("{made:?}")).or_insert_with(|| materials.push(made, at.clone()))
    }

    /// A light; a second environment is left out with a finding.
    pub fn light(&mut self, reader: &mut Reader<'_>, name: &str, kind: LightKind, at: &Origin) {
        let sky = |kind: &LightKind| matches!(kind, LightKind::Environment { radiance: _, tint: _, turn: _ });
        if sky(&kind) && self.lights.values().any(|light| sky(&light.kind)) {
            reader.lost(Fate::Dropped, at.clone(), "a second environment is left out: a scene has one");
            return;
        }
        let name = self.unique(name);
        self.lights.push(LightSource { name, kind }, at.clone());
    }

    /// A camera.
    pub fn camera(&mut self, camera: Camera, at: &Origin) {
        self.cameras.push(camera, at.clone());
    }

    /// A camera that sees all that is there, for a file without one: along y, from in front of everything.
    pub fn stand_back(&mut self, at: Origin) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut meet = |mesh: &Mesh, map: &Affine| {
            for position in mesh.positions.iter() {
                let place = map.point(position.map(f64::from));
                (0..3).for_each(|axis| {
                    low[axis] = low[axis].min(place[axis]);
                    high[axis] = high[axis].max(place[axis]);
                });
            }
        };
        for shape in self.shapes.values() {
            meet(&self.meshes[shape.mesh], &shape.transform);
        }
        for instance in self.instances.values() {
            for place in instance.places.maps() {
                for shape in self.groups[instance.group].shapes.values() {
                    meet(&self.meshes[shape.mesh], &shape.transform.then(place));
                }
            }
        }
        // Nothing, or what is farther away than a camera may be.
        if !low.iter().chain(&high).all(|x| x.abs() <= 1e29) {
            (low, high) = ([-1.0; 3], [1.0; 3]);
        }
        let middle = [0, 1, 2].map(|axis: usize| f64::midpoint(low[axis], high[axis]));
        let size = (0..3).map(|axis| high[axis] - low[axis]).fold(1e-6, f64::max);
        let eye = [middle[0], middle[1] - 2.0 * size, middle[2]];
        let up = [0.0, 0.0, 1.0];
        self.camera(Camera { name: None, eye, target: middle, up, fov_x: 45.0, near: None, far: None }, &at);
    }

    /// Multiplies all light by a factor, which does the same to the image.
    pub fn brighten(&mut self, factor: f64) {
        // No brighter than colors are read.
        let more =
            |color: &mut Color| *color = color.scaled(factor.min(BRIGHTEST / color.max().max(f64::MIN_POSITIVE)));
        let in_groups = self.groups.iter_mut().flat_map(|(_, group)| group.shapes.iter_mut());
        let shapes = self.shapes.iter_mut().chain(in_groups).map(|(_, shape)| shape);
        shapes.filter_map(|shape| shape.emission.as_mut()).for_each(|emission| more(&mut emission.radiance));
        for (_, light) in self.lights.iter_mut() {
            match &mut light.kind {
                LightKind::Environment { radiance: ColorOrTexture::Color(color), tint: _, turn: _ }
                | LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint: color, turn: _ }
                | LightKind::Point { position: _, intensity: color }
                | LightKind::Spot { position: _, target: _, intensity: color, angle: _, inner: _ }
                | LightKind::Directional { direction: _, irradiance: color } => more(color),
            }
        }
    }

    /// Whether anything sends out light.
    pub fn shines(&self) -> bool {
        let in_groups = self.groups.values().flat_map(|group| group.shapes.values());
        !self.lights.is_empty() || self.shapes.values().chain(in_groups).any(|shape| shape.emission.is_some())
    }

    /// The cameras so far.
    pub fn cameras(&self) -> usize {
        self.cameras.len()
    }

    /// The emission that a color is; none for black.
    pub fn emission(radiance: Color) -> Option<Emission> {
        (!radiance.is_black()).then_some(Emission { radiance })
    }

    /// The scene.
    pub fn finish(self, name: String, origin: Origin, settings: Settings) -> Scene {
        let mut cameras = self.cameras;
        // The only camera has no name, several have different ones.
        let several = cameras.len() > 1;
        let mut taken = HashSet::new();
        for (at, (_, camera)) in cameras.iter_mut().enumerate() {
            let wish = camera.name.take().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("camera_{at}"));
            let mut name = wish.clone();
            let mut more = 1;
            while several && !taken.insert(name.clone()) && more < NAMED {
                more += 1;
                name = format!("{wish}_{more}");
            }
            camera.name = several.then_some(name);
        }
        // What was made of a mesh takes its place.
        let mut used = vec![false; self.meshes.len()];
        let (mut shapes, mut groups) = (self.shapes, self.groups);
        let in_groups = groups.values().flat_map(|group| group.shapes.values());
        shapes.values().chain(in_groups).for_each(|shape| used[shape.mesh.index()] = true);
        let mut meshes = Arena::default();
        let kept: Vec<Option<Handle<Mesh>>> = self
            .meshes
            .entries()
            .zip(&used)
            .map(|((origin, mesh), used)| used.then(|| meshes.push(mesh.clone(), origin.clone())))
            .collect();
        let in_groups = groups.iter_mut().flat_map(|(_, group)| group.shapes.iter_mut());
        for (_, shape) in shapes.iter_mut().chain(in_groups) {
            if let Some(kept) = kept[shape.mesh.index()] {
                shape.mesh = kept;
            }
        }
        Scene {
            name,
            origin,
            documentation: Documentation::default(),
            meshes,
            textures: self.textures,
            materials: self.materials,
            shapes,
            lights: self.lights,
            groups,
            instances: self.instances,
            cameras,
            film: settings.film,
            integrator: settings.integrator,
            sampler: settings.sampler,
        }
    }
}

/// A name as the Scene has them: short, without control characters.
pub(super) fn plain(name: &str) -> String {
    let name: String = name.chars().filter(|c| !c.is_control()).take(200).collect();
    if name.trim().is_empty() { "unnamed".to_owned() } else { name }
}

/// The mesh and whether the file has normals. What it says of materials of the file goes to `materials`, all else to the reader.
fn read_mesh(
    reader: &mut Reader<'_>,
    wanted: &Wanted,
    materials: &mut Vec<Finding>,
    at: &Origin,
) -> Option<(Geometry, bool)> {
    let path = &wanted.path;
    let bytes = match reader.bytes(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            reader.lost(Fate::Dropped, at.clone(), format!("a mesh is left out: `{path}` cannot be read: {error}"));
            return None;
        }
    };
    let read = mesh_file::read(&path.extension(), &bytes, wanted.part.as_deref(), &mut mesh_file::alone);
    let (mut geometry, notes) = match read {
        Ok(read) => read,
        Err(error) => {
            reader.lost(Fate::Dropped, at.clone(), format!("a mesh is left out: `{path}`: {error}"));
            return None;
        }
    };
    for note in notes {
        let place = if note.place.is_empty() { String::new() } else { format!(", {}", note.place) };
        let message = format!("`{path}`{place}: {}", note.message);
        if note.is_of_materials() {
            // Without one of its own a shape is seen with those of the file.
            materials.push(Finding::new(note.fate.code(), Severity::Warn, at.clone(), message).maybe_help(note.help));
        } else {
            reader.add(Finding::new(code_of(&note), note.severity, at.clone(), message).maybe_help(note.help));
        }
    }
    let normals = geometry.normals.is_some();
    match wanted.shading {
        Shading::Given => {}
        Shading::Flat => match mesh::faceted(geometry) {
            Ok((flat, _)) => geometry = flat,
            Err(error) => {
                reader.lost(Fate::Dropped, at.clone(), format!("a mesh is left out: `{path}`: {}", error.message));
                return None;
            }
        },
        Shading::Smooth if normals => {}
        Shading::Smooth => match mesh::smooth(geometry, 180.0) {
            Ok((smooth, _)) => geometry = smooth,
            Err(error) => {
                reader.lost(Fate::Dropped, at.clone(), format!("a mesh is left out: `{path}`: {}", error.message));
                return None;
            }
        },
    }
    if wanted.down {
        for uv in geometry.uvs.iter_mut().flatten() {
            uv[1] = 1.0 - uv[1];
        }
    }
    if geometry.triangles.is_empty() {
        reader.lost(Fate::Dropped, at.clone(), format!("a mesh is left out: `{path}` has no triangle with an area"));
        return None;
    }
    Some((if wanted.flipped { mesh::flip(geometry) } else { geometry }, normals))
}

fn read_texture(
    reader: &mut Reader<'_>,
    path: &VPath,
    decoding: (Option<Encoding>, bool),
    factor: [f64; 3],
    at: &Origin,
) -> Option<Texture> {
    let bytes = match reader.bytes(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            reader.lost(Fate::Dropped, at.clone(), format!("an image is left out: `{path}` cannot be read: {error}"));
            return None;
        }
    };
    load_texture(reader, (path.stem(), path.as_str(), &path.extension()), &bytes, decoding, factor, at)
}

/// An image of a name, which is called otherwise where it is told of, and of an ending.
fn load_texture(
    reader: &mut Reader<'_>,
    (name, told, ending): (&str, &str, &str),
    bytes: &[u8],
    (encoding, as_stored): (Option<Encoding>, bool),
    factor: [f64; 3],
    at: &Origin,
) -> Option<Texture> {
    let Loaded { info, file, peak, remarks } = match image::load(ending, bytes, reader.limits().pixels) {
        Ok(loaded) => loaded,
        Err(error) => {
            let message = format!("an image is left out: `{told}` {}", error.message);
            reader.lost_with(Fate::Dropped, at.clone(), message, error.help.unwrap_or_default());
            return None;
        }
    };
    for remark in remarks.into_iter().filter(|remark| !(as_stored && remark.of_color)) {
        let id = match remark.loss {
            Loss::Baked => "loss-baked",
            Loss::Approximated => "loss-approximated",
            Loss::Dropped => "loss-dropped",
        };
        let message = format!("`{told}` {}", remark.message);
        reader.add(Finding::new(id, Severity::Warn, at.clone(), message));
    }
    let encoding = if info.format.is_float() { Encoding::Linear } else { encoding.unwrap_or(Encoding::Srgb) };
    let peak = if encoding == Encoding::Srgb { image::decoded(peak) } else { peak };
    Some(Texture { name: plain(name), file, image: info, encoding, peak, factor })
}
