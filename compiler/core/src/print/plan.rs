//! What of a scene is written, under which names, what is declared by a statement of its own, and which files there are.

use std::collections::BTreeMap;

use super::mesh::{constructor, fault};
use super::names::Names;
use super::notes::Notes;
use super::number::string;
use super::{Content, Options};
use crate::formats::shared::names::file_stems;
use crate::ir::{
    Affine, Arena, Bsdf, Color, ColorOrTexture, Group, Handle, Instance, LightKind, LightSource, Material, Mesh, Scene,
    Shape, Texture,
};

/// How a value is written where it is used.
#[derive(Clone, Debug, Default)]
pub(super) enum Said {
    /// Nothing uses it.
    #[default]
    Unused,
    /// By the name of its declaration.
    Named(String),
    /// In place.
    InPlace,
}

/// How often a value is used, and by what first.
#[derive(Clone, Copy, Debug, Default)]
struct Uses {
    count: u64,
    /// A place of [`Plan::name_of_item`].
    first: (usize, usize),
}

impl Uses {
    fn add(&mut self, place: (usize, usize)) {
        if self.count == 0 {
            self.first = place;
        }
        self.count += 1;
    }
}

/// The plan of a text.
pub(super) struct Plan<'s> {
    scene: &'s Scene,
    /// Why a mesh cannot be written; of used ones.
    faults: Vec<Option<String>>,
    /// Names of shapes and emitters that differ from their own, by what holds them (the number of groups stands for the scene) and
    /// their position there.
    renamed: BTreeMap<(usize, usize), String>,
    /// Names of lights.
    pub lights: Vec<String>,
    /// Names of groups; none for those that are not placed.
    pub groups: Vec<Option<String>>,
    /// Materials.
    pub materials: Vec<Said>,
    /// Of each material the first of its name and meaning.
    equal: Vec<usize>,
    /// Meshes, and the call that makes each.
    pub meshes: Vec<(Said, String)>,
    /// Images, and the path of each.
    pub textures: Vec<(Said, String)>,
    /// Files by path.
    pub files: Vec<(String, Content<'s>)>,
}

impl<'s> Plan<'s> {
    pub fn new(scene: &'s Scene, options: &Options, notes: &mut Notes) -> Self {
        let mut plan = Plan {
            scene,
            faults: scene.meshes.values().map(|_| None).collect(),
            renamed: BTreeMap::new(),
            lights: Vec::new(),
            groups: vec![None; scene.groups.len()],
            materials: vec![Said::Unused; scene.materials.len()],
            equal: equal(&scene.materials),
            meshes: vec![(Said::Unused, String::new()); scene.meshes.len()],
            textures: vec![(Said::Unused, String::new()); scene.textures.len()],
            files: Vec::new(),
        };
        let placed = plan.placed();
        plan.look_at_meshes(&placed);
        plan.name_items(&placed, notes);
        let mut values = Names::of_values();
        for (at, (group, origin)) in scene.groups.values().zip(origins(&scene.groups)).enumerate() {
            if placed[at] {
                let name = values.take(&group.name);
                notes.named(origin, "group", &group.name, &name);
                plan.groups[at] = Some(name);
            }
        }
        let (meshes, materials) = plan.uses(&placed);
        plan.say_materials(&materials, &mut values, notes);
        plan.say_meshes(&meshes, &mut values, options, notes);
        plan.say_textures(&materials, &mut values, options, notes);
        plan
    }

    /// Whether each group is placed, itself or in others.
    fn placed(&self) -> Vec<bool> {
        let Scene { groups, instances, .. } = self.scene;
        let mut placed = vec![false; groups.len()];
        let mark = |instances: &Arena<Instance>, below: usize, placed: &mut Vec<bool>| {
            for instance in instances.values().filter(|instance| lost_instance(instance, below).is_none()) {
                placed[instance.group.index()] = true;
            }
        };
        mark(instances, groups.len(), &mut placed);
        // Groups stand behind those that they hold.
        let all: Vec<&Group> = groups.values().collect();
        for at in (0..all.len()).rev() {
            if placed[at] {
                mark(&all[at].instances, at, &mut placed);
            }
        }
        placed
    }

    /// The shapes that may be written, with their places.
    fn shapes(&self, placed: &[bool]) -> impl Iterator<Item = ((usize, usize), &'s Shape)> {
        let Scene { groups, shapes, .. } = self.scene;
        let of_groups: Vec<(usize, &'s Arena<Shape>)> =
            groups.values().enumerate().filter(|(at, _)| placed[*at]).map(|(at, group)| (at, &group.shapes)).collect();
        let all = of_groups.into_iter().chain([(groups.len(), shapes)]);
        all.flat_map(|(holder, shapes)| shapes.values().enumerate().map(move |(at, shape)| ((holder, at), shape)))
    }

    fn look_at_meshes(&mut self, placed: &[bool]) {
        let mut used = vec![false; self.faults.len()];
        for (_, shape) in self.shapes(placed) {
            used[shape.mesh.index()] = true;
        }
        let looked = self.scene.meshes.values().zip(used).map(|(mesh, used)| if used { fault(mesh) } else { None });
        self.faults = looked.collect();
    }

    fn name_items(&mut self, placed: &[bool], notes: &mut Notes) {
        let scene = self.scene;
        let mut renamed = BTreeMap::new();
        let groups = scene.groups.values().enumerate().filter(|(at, _)| placed[*at]);
        let all = groups.map(|(at, group)| (at, &group.shapes)).chain([(scene.groups.len(), &scene.shapes)]);
        // Those of the scene come last, and lights have the names of its emitters beside them.
        let mut emitters = Names::default();
        for (holder, shapes) in all {
            let mut plain = Names::default();
            emitters = Names::default();
            for (at, (origin, shape)) in shapes.entries().enumerate() {
                if self.lost_shape(shape).is_some() {
                    continue;
                }
                let lit = shape.emission.is_some();
                let name = if lit { emitters.take(&shape.name) } else { plain.take(&shape.name) };
                if name != shape.name {
                    notes.named(origin, if lit { "emitter" } else { "shape" }, &shape.name, &name);
                    renamed.insert((holder, at), name);
                }
            }
        }
        self.renamed = renamed;
        for (origin, LightSource { name, kind: _ }) in scene.lights.entries() {
            let written = emitters.take(name);
            notes.named(origin, "light", name, &written);
            self.lights.push(written);
        }
    }

    /// The name of a shape or emitter, by what holds it and its position there.
    pub fn name_of_item<'p>(&'p self, place: (usize, usize), shape: &'p Shape) -> &'p str {
        self.renamed.get(&place).map_or(&shape.name, String::as_str)
    }

    /// Why a shape is not written.
    pub fn lost_shape(&self, shape: &Shape) -> Option<String> {
        let Shape { name: _, mesh, transform, material, emission: _ } = shape;
        if !transform.is_invertible() {
            return Some("its transform has no inverse".to_owned());
        }
        if let Some(fault) = &self.faults[mesh.index()] {
            return Some(format!("of its mesh, {fault}"));
        }
        let bare = self.scene.meshes[*mesh].uvs.is_none();
        let textured = self.scene.materials[*material].bsdf.texture().is_some();
        (bare && textured).then(|| "its material has an image, and its mesh no texture coordinates".to_owned())
    }

    /// The material that stands for this one.
    pub fn material(&self, material: Handle<Material>) -> usize {
        self.equal[material.index()]
    }

    fn uses(&self, placed: &[bool]) -> (Vec<Uses>, Vec<Uses>) {
        let mut meshes = vec![Uses::default(); self.meshes.len()];
        let mut materials = vec![Uses::default(); self.materials.len()];
        for (place, shape) in self.shapes(placed).filter(|(_, shape)| self.lost_shape(shape).is_none()) {
            meshes[shape.mesh.index()].add(place);
            if shape.emission.is_none() || !is_usual(&self.scene.materials[shape.material]) {
                materials[self.material(shape.material)].add(place);
            }
        }
        (meshes, materials)
    }

    /// Whether a value of this name, used once, takes it from the shape that uses it.
    fn is_of_its_shape(&self, uses: Uses, name: &str) -> bool {
        let (holder, at) = uses.first;
        let shapes = self.scene.groups.values().nth(holder).map_or(&self.scene.shapes, |group| &group.shapes);
        let shape = shapes.values().nth(at);
        uses.count == 1 && shape.is_some_and(|shape| self.name_of_item(uses.first, shape) == name)
    }

    fn say_materials(&mut self, uses: &[Uses], values: &mut Names, notes: &mut Notes) {
        for (at, (origin, material)) in self.scene.materials.entries().enumerate() {
            if uses[at].count == 0 {
                continue;
            }
            self.materials[at] = if self.is_of_its_shape(uses[at], &material.name) {
                Said::InPlace
            } else {
                let name = values.take(&material.name);
                notes.named(origin, "material", &material.name, &name);
                Said::Named(name)
            };
        }
    }

    fn say_meshes(&mut self, uses: &[Uses], values: &mut Names, options: &Options, notes: &mut Notes) {
        let scene = self.scene;
        let mut of_files: Vec<(usize, &'s Mesh)> = Vec::new();
        for (at, (origin, mesh)) in scene.meshes.entries().enumerate() {
            if uses[at].count == 0 {
                continue;
            }
            self.meshes[at].0 = if self.is_of_its_shape(uses[at], &mesh.name) {
                Said::InPlace
            } else {
                let name = values.take(&mesh.name);
                notes.named(origin, "mesh", &mesh.name, &name);
                Said::Named(name)
            };
            match constructor(mesh) {
                Some(call) => self.meshes[at].1 = call,
                None => of_files.push((at, mesh)),
            }
        }
        let stems = file_stems(of_files.iter().map(|(_, mesh)| mesh.name.as_str()));
        for ((at, mesh), stem) in of_files.into_iter().zip(stems) {
            let path = format!("{}meshes/{stem}.ply", options.folder);
            self.meshes[at].1 = format!("file({})", string(&path));
            self.files.push((path, Content::Mesh(mesh)));
        }
    }

    fn say_textures(&mut self, materials: &[Uses], values: &mut Names, options: &Options, notes: &mut Notes) {
        let scene = self.scene;
        let mut uses = vec![0_u64; scene.textures.len()];
        let painted = scene.materials.values().zip(materials).filter(|(_, uses)| uses.count > 0);
        let painted = painted.filter_map(|(material, _)| material.bsdf.texture());
        let lit = scene.lights.values().filter_map(|light: &LightSource| LightKind::texture(&light.kind));
        painted.chain(lit).for_each(|texture: Handle<Texture>| uses[texture.index()] += 1);
        // Textures of one image share its file, which is called as the first of them.
        let used = || scene.textures.values().enumerate().filter(|(at, _)| uses[*at] > 0);
        let mut files: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut first = Vec::new();
        let mut of: Vec<(usize, usize)> = Vec::new();
        for (at, texture) in used() {
            let key = (texture.file.as_ptr() as usize, texture.file.len());
            let file = *files.entry(key).or_insert_with(|| {
                first.push(texture);
                first.len() - 1
            });
            of.push((at, file));
        }
        let stems = file_stems(first.iter().map(|texture| texture.name.as_str()));
        let path = |stem: &str, texture: &Texture| {
            format!("{}textures/{stem}.{}", options.folder, texture.image.format.ending())
        };
        for (texture, stem) in first.iter().zip(&stems) {
            self.files.push((path(stem, texture), Content::Image(&texture.file)));
        }
        let origins: Vec<_> = scene.textures.entries().collect();
        for (at, file) in of {
            let (origin, texture) = origins[at];
            let stem = &stems[file];
            let own = texture.name == *stem;
            // In place it is called as its file.
            let said = if own && (uses[at] == 1 || !values.is_free(&texture.name)) {
                Said::InPlace
            } else {
                let name = values.take(&texture.name);
                notes.named(origin, "texture", &texture.name, &name);
                Said::Named(name)
            };
            self.textures[at] = (said, path(stem, first[file]));
        }
    }
}

/// Why an instance is not written; `below` is how many groups stand before what holds it.
pub(super) fn lost_instance(instance: &Instance, below: usize) -> Option<&'static str> {
    if instance.group.index() >= below {
        return Some("its group does not stand before what holds it");
    }
    let maps = instance.places.maps();
    if maps.is_empty() {
        return Some("it has no place");
    }
    let flat = maps.iter().any(|map: &Affine| !map.is_invertible());
    flat.then_some("a transform of it has no inverse")
}

/// Whether it is the surface of emitters that say nothing else.
pub(super) fn is_usual(material: &Material) -> bool {
    let Material { name, bsdf, sides: _ } = material;
    let black = matches!(bsdf, Bsdf::Diffuse { reflectance: ColorOrTexture::Color(Color::Grey(0.0)) });
    black && name == "black"
}

/// Of each material the first of its name and meaning.
fn equal(materials: &Arena<Material>) -> Vec<usize> {
    let mut known = BTreeMap::new();
    let all = materials.values().enumerate();
    all.map(|(at, material)| *known.entry(format!("{material:?}")).or_insert(at)).collect()
}

fn origins<T>(arena: &Arena<T>) -> impl Iterator<Item = &crate::diag::Origin> {
    arena.entries().map(|(origin, _)| origin)
}
