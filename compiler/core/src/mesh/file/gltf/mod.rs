//! glTF 2.0 files, binary (`.glb`) and text (`.gltf`): the triangles of the default scene, with the maps of their nodes, and
//! their materials. Coordinates are turned from y up to z up.
//!
//! `document`, `accessor`, `nodes` and `ranges` are how any of ours reads glTF; the format of that name stands on them, too. The
//! crate gltf is what tests hold them against: it refuses valid files (scenes without nodes, channels without a target) and rounds
//! numbers to single precision, which an audit to 1e-9 cannot use.

pub mod accessor;
mod deform;
pub mod document;
mod extensions;
mod material;
pub mod nodes;
pub mod ranges;

use std::collections::BTreeMap;

use super::finish::{finish, flat};
use super::model::{Model, Part, Scatter, Unique};
use super::{Beside, FileError, Note, Surface};
use crate::ir::{Affine, Vec3, cross, length, sub};
use crate::mesh::Geometry;
use accessor::Buffers;
use document::{Document, Item};
use material::{Look, PLAIN, UvMap};

/// Parts that any file may have; more need bytes of the file.
const PARTS: u64 = 250_000;
/// What a part takes in memory, about.
const PART: u64 = 256;

/// The model, and which of its parts belong to the node or mesh called `part` (all for none).
pub(super) fn read(bytes: &[u8], part: Option<&str>, beside: &mut Beside<'_>) -> Result<(Model, Vec<Note>), FileError> {
    let (text, chunk) = document::split(bytes)?;
    let values = document::parse(text)?;
    let document = Document::new(&values)?;
    let own = chunk.map(|range| &bytes[range]);
    let Reader { model, all, selected, notes, .. } = Reader::new(&document, own, text.len(), part, beside)?;
    let model = match part {
        None => model,
        Some(part) => model.only("node or mesh", part, &all, &selected)?,
    };
    if model.parts.is_empty() {
        return Err(FileError::new("", "the file has no triangles in its scene"));
    }
    Ok((model, notes))
}

/// All that stands in the default scene of a document.
pub struct Whole<'v> {
    /// The shapes, with normals, flat ones where the file has none. The surfaces are first those of `materials`, in their order.
    pub model: Model,
    /// Which use of a mesh each part of the model belongs to.
    pub uses: Vec<Use>,
    /// Nodes with a camera or a light, and where they stand, z up.
    pub others: Vec<(Item<'v>, Affine)>,
    /// What is to be said.
    pub notes: Vec<Note>,
}

/// A mesh at a node: parts of the same use are its primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Use {
    /// The node.
    pub node: usize,
    /// Which of the places of EXT_mesh_gpu_instancing; 0 without it.
    pub copy: usize,
    /// The mesh; none where the primitives stand where their joints do.
    pub mesh: Option<usize>,
}

/// Reads the whole default scene of a document of `size` bytes; `own` is the chunk of a binary file. A primitive that is broken is a
/// note, and the others are read.
///
/// # Errors
/// Whatever is wrong with the document or its buffers.
pub fn whole<'v>(
    document: &Document<'v>,
    own: Option<&[u8]>,
    size: usize,
    beside: &mut Beside<'_>,
) -> Result<Whole<'v>, FileError> {
    let mut reader = Reader::open(document, own, size, None, beside)?;
    reader.others = Some(Vec::new());
    reader.run(document)?;
    let Reader { model, uses, others, notes, .. } = reader;
    Ok(Whole { model, uses, others: others.unwrap_or_default(), notes: super::note::merged(notes) })
}

/// Numbers out of range that are looked at.
const FAULTS: usize = 10_000;

/// Says what is not as glTF asks for, once for each key of each list.
fn faults(document: &Document<'_>, notes: &mut Vec<Note>) -> Result<(), FileError> {
    let mut known: BTreeMap<(String, String), (FileError, u64)> = BTreeMap::new();
    for fault in ranges::check(document, FAULTS)? {
        let mut words = fault.place.split('/').skip(1).map(str::to_owned);
        let key = (words.next().unwrap_or_default(), words.last().unwrap_or_default());
        known.entry(key).or_insert((fault, 0)).1 += 1;
    }
    for (fault, count) in known.into_values() {
        let times = if count > 1 { format!(" ({})", super::plural(count, "time")) } else { String::new() };
        notes.push(Note::warn(fault.place, format!("{}{times}", fault.message)));
    }
    Ok(())
}

/// What makes two primitives the same mesh: accessors of positions, normals, texture coordinates, indices and colors, the mode, how
/// texture coordinates are turned, and for morph targets the primitive with their weights.
type Key = ([Option<usize>; 5], usize, [u64; 6], Option<(usize, usize, Vec<u64>)>);

/// A mesh that was made of a primitive.
#[derive(Clone, Copy)]
struct Made {
    mesh: usize,
    colors: Colors,
    /// Whether texture coordinates leave 0..1.
    leaves: bool,
    /// Whether it stands where its node does; else where its joints do.
    placed: bool,
}

/// The colors of the vertices of a mesh, by which its base color is multiplied.
#[derive(Clone, Copy)]
struct Colors {
    mean: Vec3,
    vary: bool,
}

const WHITE: Colors = Colors { mean: [1.0; 3], vary: false };

struct Reader<'v, 'b> {
    buffers: Buffers<'v, 'b>,
    nodes: Vec<Item<'v>>,
    meshes: Vec<Item<'v>>,
    skins: Vec<Item<'v>>,
    /// Where all nodes stand; computed for the first skin.
    maps: Option<Vec<Option<Affine>>>,
    looks: Vec<Look>,
    /// Parts that may still be made for nothing.
    parts: u64,
    /// Its surfaces are those that stand behind the file's own.
    model: Model,
    known: BTreeMap<Key, Option<Made>>,
    /// How many primitives use each accessor of positions.
    shared: BTreeMap<usize, u32>,
    /// Materials under the color of vertices.
    tinted: BTreeMap<(Option<usize>, [u64; 3], bool), usize>,
    /// What is not read: where first, how often, and whether it may be seen.
    skipped: BTreeMap<&'static str, (String, u64, bool)>,
    names: Unique,
    /// The node or mesh that is asked for.
    part: Option<&'v str>,
    /// The names that parts can be asked by.
    all: Vec<String>,
    /// Which parts were asked for.
    selected: Vec<bool>,
    /// The use of a mesh that each part belongs to.
    uses: Vec<Use>,
    /// Nodes with a camera or a light, where these are read; then broken primitives are notes.
    others: Option<Vec<(Item<'v>, Affine)>>,
    notes: Vec<Note>,
}

/// A node and where its mesh stands.
#[derive(Clone, Copy)]
struct Place<'v> {
    node: Item<'v>,
    map: Affine,
    copy: usize,
    chosen: bool,
}

/// A primitive in what holds it.
struct Primitive<'v, 'w> {
    mesh: Item<'v>,
    at: usize,
    item: Item<'v>,
    material: Option<usize>,
    weights: &'w [f64],
    joints: Option<&'w [Affine]>,
}

impl<'v, 'b> Reader<'v, 'b> {
    /// A reader that has read all of the default scene.
    fn new(
        document: &Document<'v>,
        own: Option<&'b [u8]>,
        size: usize,
        part: Option<&'v str>,
        beside: &mut Beside<'_>,
    ) -> Result<Self, FileError> {
        let mut reader = Self::open(document, own, size, part, beside)?;
        reader.run(document)?;
        Ok(reader)
    }

    fn open(
        document: &Document<'v>,
        own: Option<&'b [u8]>,
        size: usize,
        part: Option<&'v str>,
        beside: &mut Beside<'_>,
    ) -> Result<Self, FileError> {
        extensions::required(document)?;
        let mut notes = Vec::new();
        extensions::used(document, &mut notes);
        let own = own.map(|bytes| Box::new(bytes) as accessor::Blob<'_>);
        let buffers = Buffers::new(document, own, size, &mut |item, path| {
            let found: accessor::Blob<'_> = beside(path).map_err(|message| FileError::new(item.place(), message))?;
            Ok(found)
        })?;
        faults(document, &mut notes)?;
        Ok(Self {
            nodes: document.list("nodes")?,
            meshes: document.list("meshes")?,
            skins: document.list("skins")?,
            maps: None,
            looks: material::looks(document, &buffers)?,
            buffers,
            parts: PARTS,
            model: Model::default(),
            known: BTreeMap::new(),
            shared: BTreeMap::new(),
            tinted: BTreeMap::new(),
            skipped: BTreeMap::new(),
            names: Unique::default(),
            part,
            all: Vec::new(),
            selected: Vec::new(),
            uses: Vec::new(),
            others: None,
            notes,
        })
    }

    fn run(&mut self, document: &Document<'v>) -> Result<(), FileError> {
        for primitive in self.meshes.iter().flat_map(|mesh| mesh.objects("primitives")) {
            let positions = primitive.inner("attributes").and_then(|attributes| attributes.count("POSITION"));
            if let Some(positions) = positions {
                *self.shared.entry(positions).or_default() += 1;
            }
        }
        for animation in document.list("animations")? {
            self.skip(animation, "animations are not read: all stands as the nodes say", false);
        }
        let nodes = std::mem::take(&mut self.nodes);
        let found = nodes::walk(&nodes, &document.roots(&nodes)?, false, |node, map, chosen| {
            if node.extension("KHR_node_visibility").is_some_and(|own| own.get("visible") == Some(&false.into())) {
                return Ok(None);
            }
            let chosen = chosen || self.part == Some(node.text("name").unwrap_or(""));
            self.node(node, map, chosen, &nodes)?;
            Ok(Some(chosen))
        });
        found?;
        for (what, (place, count, seen)) in &self.skipped {
            let note = Note::dropped(place, format!("{what} ({})", super::plural(*count, "time")));
            self.notes.push(if *seen { note } else { note.slight() });
        }
        let mut known = std::collections::BTreeSet::new();
        self.all.retain(|name| known.insert(name.clone()));
        let own = std::mem::take(&mut self.looks).into_iter().map(|look| look.surface);
        self.model.surfaces.splice(0..0, own);
        Ok(())
    }

    fn skip(&mut self, item: Item<'_>, what: &'static str, seen: bool) {
        self.skipped.entry(what).or_insert_with(|| (item.place(), 0, seen)).1 += 1;
    }

    fn node(&mut self, node: Item<'v>, map: &Affine, chosen: bool, nodes: &[Item<'v>]) -> Result<(), FileError> {
        let (films, shines) = (node.get("camera").is_some(), node.extension("KHR_lights_punctual").is_some());
        match &mut self.others {
            Some(others) if films || shines => others.push((node, *map)),
            Some(_) => {}
            None => {
                if films {
                    self.skip(node, "cameras are not read", false);
                }
                if shines {
                    self.skip(node, "lights (`KHR_lights_punctual`) are not read", true);
                }
            }
        }
        let Some(mesh) = node.link("mesh", &self.meshes)?.copied() else { return Ok(()) };
        for name in [node, mesh].iter().filter_map(|item| item.text("name")).filter(|name| !name.is_empty()) {
            self.all.push(name.to_owned());
        }
        let joints = match node.link("skin", &self.skins)?.copied() {
            None => None,
            Some(skin) => {
                let maps = self.maps.get_or_insert_with(|| nodes::maps(nodes));
                Some(deform::joints(skin, maps, &self.buffers)?)
            }
        };
        let weights = deform::weights(node, mesh);
        let places = match node.extension("EXT_mesh_gpu_instancing") {
            None => vec![*map],
            Some(own) => nodes::instances(own, &self.buffers)?.iter().map(|place| place.then(map)).collect(),
        };
        for (copy, map) in places.into_iter().enumerate() {
            self.mesh(mesh, Place { node, map, copy, chosen }, &weights, joints.as_deref())?;
        }
        Ok(())
    }

    fn mesh(
        &mut self,
        mesh: Item<'v>,
        place: Place<'v>,
        weights: &[f64],
        joints: Option<&[Affine]>,
    ) -> Result<(), FileError> {
        let Place { node, map, copy, chosen } = place;
        let own = mesh.text("name").unwrap_or("");
        let name = node.text("name").filter(|name| !name.is_empty()).unwrap_or(own);
        for (at, item) in mesh.objects("primitives").enumerate() {
            let pointer = || format!("{}/primitives/{at}", mesh.place());
            let material = item.count("material");
            if item.get("material").is_some() && material.is_none_or(|at| at >= self.looks.len()) {
                return Err(FileError::new(format!("{}/material", pointer()), "an index points to nothing"));
            }
            let primitive = Primitive { mesh, at, item, material, weights, joints };
            let made = match self.primitive(&primitive) {
                Ok(made) => made,
                Err(error) => {
                    let place = if error.place.is_empty() { pointer() } else { error.place };
                    if self.others.is_none() {
                        return Err(FileError { place, ..error });
                    }
                    self.notes.push(Note::dropped(place, format!("a primitive is left out: {}", error.message)));
                    continue;
                }
            };
            let Some(Made { mesh: made, colors, leaves, placed }) = made else { continue };
            if placed && !map.is_invertible() {
                self.skip(node, "meshes that a node flattens are left out", true);
                continue;
            }
            match self.parts.checked_sub(1) {
                Some(left) => self.parts = left,
                None => self.buffers.afford(PART)?,
            }
            let surface = self.tinted(material, colors);
            if let Some(surface) = surface.filter(|_| material.is_some_and(|at| self.looks[at].ends)) {
                self.lose(
                    surface,
                    if leaves {
                        "that its image does not repeat (`wrapS` and `wrapT` of its sampler)"
                    } else {
                        "what its image is next to its edges, in half a pixel (`wrapS` and `wrapT` of its sampler)"
                    },
                );
            }
            let transform = if placed { map } else { Affine::IDENTITY };
            self.model.parts.push(Part { name: self.names.name(name), mesh: made, surface, transform });
            self.selected.push(chosen || self.part == Some(own));
            self.uses.push(Use { node: node.at(), copy, mesh: placed.then_some(mesh.at()) });
        }
        Ok(())
    }

    /// The surface of a number, among the file's own and those that stand behind them.
    fn surface(&mut self, at: usize) -> Option<&mut Surface> {
        let own = self.looks.len();
        match self.looks.get_mut(at) {
            Some(look) => Some(&mut look.surface),
            None => self.model.surfaces.get_mut(at - own),
        }
    }

    fn lose(&mut self, at: usize, what: &'static str) {
        if let Some(surface) = self.surface(at).filter(|surface| !surface.lost.contains(&what)) {
            surface.lost.push(what);
        }
    }

    /// The material under the colors of vertices (glTF 2.0, 3.7.2.1).
    fn tinted(&mut self, material: Option<usize>, colors: Colors) -> Option<usize> {
        let Colors { mean, vary } = colors;
        if mean == [1.0; 3] && !vary {
            return material;
        }
        let key = (material, mean.map(f64::to_bits), vary);
        if let Some(known) = self.tinted.get(&key) {
            return Some(*known);
        }
        let mut surface = match material.and_then(|at| self.surface(at)) {
            Some(surface) => surface.clone(),
            None => Surface {
                name: String::new(),
                scatter: Scatter::Diffuse([1.0; 3]),
                emission: None,
                picture: None,
                factor: [1.0; 3],
                lost: vec!["what it is made of, but for the colors of its vertices"],
            },
        };
        let times = |color: &mut Vec3| *color = [0, 1, 2].map(|channel| color[channel] * mean[channel]);
        match &mut surface.scatter {
            Scatter::Diffuse(color) | Scatter::Mirror(color) => times(color),
            Scatter::MetallicRoughness { base, metallic: _, roughness: _, ior: _ } => times(base),
            Scatter::Glass { ior: _, alpha: _ } => {
                surface.lost.push("the tint of transmitted light by colors of vertices")
            }
        }
        if surface.picture.is_some() {
            surface.lost.push("colors of vertices over an image");
        } else if vary {
            surface.lost.push("how the colors of its vertices vary: their mean stands for them");
        }
        self.model.surfaces.push(surface);
        let index = self.looks.len() + self.model.surfaces.len() - 1;
        self.tinted.insert(key, index);
        Some(index)
    }

    /// The mesh of a primitive; none where it has no triangles.
    fn primitive(&mut self, primitive: &Primitive<'v, '_>) -> Result<Option<Made>, FileError> {
        let Primitive { mesh, at, item, material, weights, joints } = primitive;
        let mode = item.count("mode").unwrap_or(4);
        match mode {
            4..=6 => {}
            0..=3 => {
                self.skip(*mesh, "points and lines are not read", true);
                return Ok(None);
            }
            _ => return Err(FileError::new("", "its mode is not known")),
        }
        let look = material.and_then(|at| self.looks.get(at)).filter(|look| look.surface.picture.is_some());
        let (set, map) = look.map_or((0, PLAIN), |look| (look.set, look.map));
        let uv = format!("TEXCOORD_{set}");
        let attributes = item.inner("attributes");
        let mut others: Vec<(&'static str, bool)> = Vec::new();
        for name in attributes.iter().flat_map(Item::keys) {
            if name.starts_with('_') {
                others.push(("attributes of applications, whose names begin with `_`, are not read", false));
            } else if name.starts_with("TEXCOORD_") && name != uv && look.is_some() {
                others.push(("texture coordinates that the image of the base color does not use are not read", false));
            } else if name.starts_with("COLOR_") && name != "COLOR_0" {
                others.push(("colors of vertices after the first are not read", false));
            }
        }
        for (what, seen) in others {
            self.skip(*mesh, what, seen);
        }
        let colored = |target: Item<'_>| target.keys().any(|key| key.starts_with("COLOR_"));
        if weights.iter().any(|weight| *weight != 0.0) && item.objects("targets").any(colored) {
            self.skip(*mesh, "morph targets of colors are not read", true);
        }
        let index = |holder: Option<Item<'v>>, key: &str| match holder.and_then(|holder| holder.get(key)) {
            None => Ok(None),
            Some(value) => match document::whole(value).filter(|at| *at < self.buffers.accessors().len()) {
                Some(at) => Ok(Some(at)),
                None => Err(FileError::new("", format!("the index of `{key}` points to nothing"))),
            },
        };
        let (positions, indices) = (index(attributes, "POSITION")?, index(Some(*item), "indices")?);
        let (normals, uvs, colors) =
            (index(attributes, "NORMAL")?, index(attributes, &uv)?, index(attributes, "COLOR_0")?);
        let Some(_) = positions else {
            self.skip(*mesh, "primitives without positions are left out", true);
            return Ok(None);
        };
        let morphs = item.get("targets").is_some() && weights.iter().any(|weight| *weight != 0.0);
        let morphed = morphs.then(|| (mesh.at(), *at, weights.iter().map(|weight| weight.to_bits()).collect()));
        let turned = [0, 1, 2, 3, 4, 5].map(|at: usize| map[at / 3][at % 3].to_bits());
        let key: Key = ([positions, normals, uvs, indices, colors], mode, turned, morphed);
        if joints.is_none()
            && let Some(known) = self.known.get(&key)
        {
            return Ok(*known);
        }
        let made = self.geometry(primitive, &key, &map)?.map(|(geometry, colors, placed)| {
            let leaves = |[u, v]: &[f32; 2]| !(0.0..=1.0).contains(u) || !(0.0..=1.0).contains(v);
            let leaves = geometry.uvs.iter().flatten().any(leaves);
            self.model.meshes.push((mesh.text("name").unwrap_or("").to_owned(), geometry));
            Made { mesh: self.model.meshes.len() - 1, colors, leaves, placed }
        });
        if joints.is_none() {
            self.known.insert(key, made);
        }
        Ok(made)
    }

    /// The numbers of a mesh, the colors of its vertices, and whether it stands where its node does.
    fn geometry(
        &mut self,
        primitive: &Primitive<'v, '_>,
        key: &Key,
        map: &UvMap,
    ) -> Result<Option<(Geometry, Colors, bool)>, FileError> {
        let ([Some(positions), normals, uvs, indices, colors], mode, ..) = key else { return Ok(None) };
        let buffers = &self.buffers;
        // Twelve bytes for a triangle, and a strip has nearly as many as indices; as much again where normals are made flat.
        let corners = buffers.count(indices.unwrap_or(*positions)) as u64;
        buffers.afford(corners.saturating_mul(24))?;
        let mut all = buffers.vectors::<3>(*positions)?;
        let count = all.len();
        let mut normals = normals.map(|at| buffers.vectors::<3>(at)).transpose()?;
        let mut uvs = uvs.map(|at| buffers.vectors::<2>(at)).transpose()?;
        let colors = colors.map(|at| color(at, buffers)).transpose()?;
        let lengths = [
            ("normals", normals.as_ref().map(Vec::len)),
            ("texture coordinates", uvs.as_ref().map(Vec::len)),
            ("colors", colors.as_ref().map(Vec::len)),
        ];
        for (what, length) in lengths {
            if let Some(length) = length.filter(|length| *length != count) {
                return Err(FileError::new("", format!("it has {count} positions and {length} {what}")));
            }
        }
        let corners = match indices {
            Some(at) => buffers.whole::<1>(*at)?.into_flattened(),
            None => {
                (0..u32::try_from(count).map_err(|_| FileError::new("", "it has more than 2^32 vertices"))?).collect()
            }
        };
        if let Some(index) = corners.iter().find(|index| **index as usize >= count) {
            return Err(FileError::new("", format!("a triangle uses vertex {index}, but there are {count} vertices")));
        }
        let mut triangles: Vec<[u32; 3]> = match mode {
            4 => {
                let (triangles, rest) = corners.as_chunks::<3>();
                if !rest.is_empty() {
                    let message = "behind the last triangle not read";
                    self.notes.push(Note::warn(primitive.mesh.place(), message).counting(rest.len() as u64, "index"));
                }
                triangles.to_vec()
            }
            // Every other triangle of a strip is wound the other way (glTF 2.0, 3.7.2.1).
            5 => {
                let wound =
                    |(at, w): (usize, &[u32])| if at % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
                corners.windows(3).enumerate().map(wound).collect()
            }
            _ => match corners.split_first() {
                Some((first, rest)) => rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect(),
                None => Vec::new(),
            },
        };
        if triangles.is_empty() {
            return Ok(None);
        }
        let set = format!("TEXCOORD_{}", self.looks_set(primitive));
        let buffers = &self.buffers;
        if let Some(moved) = deform::morph(primitive.item, primitive.weights, &set, count, buffers)? {
            deform::displace(&mut all, moved.positions.as_ref());
            if let Some(normals) = &mut normals {
                deform::displace(normals, moved.normals.as_ref());
                // What is no longer of unit length was so as the file meant it.
                deform::straighten(normals);
            }
            if let Some(uvs) = &mut uvs {
                deform::displace(uvs, moved.uvs.as_ref());
            }
        }
        let mut placed = true;
        if let Some(joints) = primitive.joints {
            match deform::skinned(primitive.item, joints, &mut all, normals.as_mut(), buffers)? {
                None => self.skip(primitive.mesh, "skins of meshes without joints are not read", true),
                Some(mirrored) => {
                    placed = false;
                    if mirrored {
                        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                    }
                }
            }
        }
        let colors = colors.map_or(WHITE, |colors| mean(&colors, &triangles, &all));
        // v grows downwards in glTF.
        let turn = |[u, v]: [f32; 2]| {
            let at = [u, v].map(f64::from);
            let [u, v] = map.map(|row| (row[0] * at[0] + row[1] * at[1] + row[2]) as f32);
            [u, 1.0 - v]
        };
        let uvs = uvs.map(|uvs| uvs.into_iter().map(turn).collect());
        let mut geometry = Geometry { positions: all, normals, uvs, triangles };
        if self.shared.get(positions).is_some_and(|uses| *uses > 1) {
            geometry = compact(geometry);
        }
        finish(&mut geometry, &mut self.notes, |vertex| format!("vertex {vertex}"))?;
        // Where a file gives no normals they are flat (glTF 2.0, 3.7.2.1).
        let geometry = if geometry.normals.is_some() { geometry } else { flat(geometry, &mut self.notes)? };
        Ok((!geometry.triangles.is_empty()).then_some((geometry, colors, placed)))
    }

    /// The set of texture coordinates that a primitive is laid out by.
    fn looks_set(&self, primitive: &Primitive<'_, '_>) -> usize {
        let look = primitive.material.and_then(|at| self.looks.get(at));
        look.filter(|look| look.surface.picture.is_some()).map_or(0, |look| look.set)
    }
}

/// The colors of vertices, which are linear; alpha is left out.
fn color(at: usize, buffers: &Buffers<'_, '_>) -> Result<Vec<[f32; 3]>, FileError> {
    match buffers.kind(at) {
        "VEC4" => Ok(buffers.vectors::<4>(at)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()),
        _ => buffers.vectors::<3>(at),
    }
}

/// The mean of colors over triangles by their areas.
fn mean(colors: &[[f32; 3]], triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Colors {
    let at = |index: u32| colors[index as usize].map(|x| f64::from(x.clamp(0.0, 1.0)));
    let first = triangles.first().map_or([1.0; 3], |triangle| at(triangle[0]));
    if triangles.as_flattened().iter().all(|index| at(*index) == first) {
        return Colors { mean: first, vary: false };
    }
    let (mut sum, mut size) = ([0.0; 3], 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| positions[index as usize].map(f64::from));
        let area = length(cross(sub(b, a), sub(c, a)));
        if area.is_finite() {
            size += area;
            for corner in triangle.map(at) {
                sum = [0, 1, 2].map(|channel| sum[channel] + area * corner[channel] / 3.0);
            }
        }
    }
    let mean = if size > 0.0 { sum.map(|x| x / size) } else { first };
    Colors { mean, vary: true }
}

/// The geometry without the vertices that no triangle uses.
fn compact(geometry: Geometry) -> Geometry {
    let Geometry { positions, normals, uvs, mut triangles } = geometry;
    let mut new = vec![u32::MAX; positions.len()];
    let mut kept = Vec::new();
    for index in triangles.as_flattened_mut() {
        let slot = &mut new[*index as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(*index as usize);
        }
        *index = *slot;
    }
    Geometry {
        positions: kept.iter().map(|at| positions[*at]).collect(),
        normals: normals.map(|normals| kept.iter().map(|at| normals[*at]).collect()),
        uvs: uvs.map(|uvs| kept.iter().map(|at| uvs[*at]).collect()),
        triangles,
    }
}

#[cfg(test)]
mod cases_tests;
#[cfg(test)]
mod tests;
