//! glTF 2.0 files, binary (`.glb`) and text (`.gltf`): the triangles of the default scene, with the maps of their nodes, and
//! their materials. Coordinates are turned from y up to z up.
//!
//! The crate gltf reads the JSON and checks that indices point to something; containers, buffers and the tree of nodes are
//! checked here, since files may say anything of them.

mod accessor;
mod material;

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::{Checked, Error, Validate};

use super::finish::{Faces, finish, flat};
use super::model::{Model, Part, Unique};
use super::{Beside, FileError, Note, plural};
use crate::ir::{Affine, normalized};
use crate::mesh::Geometry;
use accessor::Buffers;

/// How much larger than the file what is made of it may be: primitives may share their bytes.
const GROWTH: u64 = 64;

/// The model, and which of its parts belong to the node or mesh called `part` (all for none).
pub(super) fn read(bytes: &[u8], part: Option<&str>, beside: &mut Beside<'_>) -> Result<(Model, Vec<Note>), FileError> {
    let (text, chunk) = container(bytes)?;
    let root = document(text)?;
    let mut notes = Vec::new();
    let owned = outer_buffers(&root, beside)?;
    let buffers: Vec<&[u8]> =
        owned.iter().map(|owned| owned.as_ref().map_or(chunk, |owned| (**owned).as_ref())).collect();
    for (at, (buffer, bytes)) in root.buffers.iter().zip(&buffers).enumerate() {
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let message = format!("it has {} bytes, and the file says {}", bytes.len(), buffer.byte_length.0);
            return Err(FileError::new(format!("buffer {at}"), message).help("the file is cut off or damaged"));
        }
    }
    let size = text.len() as u64 + buffers.iter().map(|bytes| bytes.len() as u64).sum::<u64>();
    let buffers = Buffers { root: &root, bytes: buffers };
    let surfaces = material::surfaces(&buffers);
    let reader = Reader {
        buffers,
        room: size.saturating_mul(GROWTH),
        model: Model { surfaces, ..Model::default() },
        known: BTreeMap::new(),
        shared: BTreeMap::new(),
        skipped: BTreeMap::new(),
        names: Unique::default(),
    };
    let (model, all, selected) = reader.run(part, &mut notes)?;
    let model = match part {
        None => model,
        Some(part) => model.only("node or mesh", part, &all, &selected)?,
    };
    if model.parts.is_empty() {
        return Err(FileError::new("", "the file has no triangles in its scene"));
    }
    Ok((model, notes))
}

/// The JSON and the binary chunk (glTF 2.0, 4.4).
fn container(bytes: &[u8]) -> Result<(&[u8], &[u8]), FileError> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return match text.trim_ascii_start().first() {
            Some(b'{') => Ok((bytes, &[])),
            Some(_) => {
                Err(FileError::new("byte 0", "the file begins neither with `glTF`, as a binary one, nor with `{`")
                    .help("is this a glTF file?"))
            }
            None => Err(FileError::new("", "the file is empty")),
        };
    };
    let cut = |what: &str| FileError::new("", format!("the file ends within {what}")).help("the file is cut off");
    let number = |at: usize| rest.get(at..).and_then(<[u8]>::first_chunk::<4>).map(|bytes| u32::from_le_bytes(*bytes));
    let (Some(version), Some(_length)) = (number(0), number(4)) else { return Err(cut("its header")) };
    if version != 2 {
        return Err(
            FileError::new("byte 4", format!("the file is of version {version} of glTF")).help("version 2 is read")
        );
    }
    let mut at = 8;
    let mut chunks: [Option<&[u8]>; 2] = [None, None];
    for (chunk, (kind, what)) in chunks.iter_mut().zip([(b"JSON", "its JSON"), (b"BIN\0", "its binary chunk")]) {
        let Some(length) = number(at) else { break };
        let head = rest.get(at + 4..at + 8).ok_or_else(|| cut(what))?;
        if head != kind {
            break;
        }
        let from = at + 8;
        let end = from.checked_add(length as usize).filter(|end| *end <= rest.len()).ok_or_else(|| cut(what))?;
        *chunk = Some(&rest[from..end]);
        at = end;
    }
    match chunks {
        [Some(json), bin] => Ok((json, bin.unwrap_or(&[]))),
        [None, _] if rest.len() < 16 => Err(cut("its header")),
        [None, _] => Err(FileError::new("byte 12", "the first chunk is not JSON")),
    }
}

/// Extensions that change no triangle, or that are read: a file that requires them can be read all the same.
fn harmless(extension: &str) -> bool {
    let beginnings =
        ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_", "KHR_mesh_quantization"];
    beginnings.iter().any(|beginning| extension.starts_with(beginning))
}

fn document(text: &[u8]) -> Result<json::Root, FileError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut root: json::Root = json::deserialize::from_slice(text).map_err(|error| {
        FileError::new(format!("line {} of the JSON", error.line()), format!("the JSON is malformed: {error}"))
            .help("is this a glTF file?")
    })?;
    root.extensions_required.retain(|extension| !harmless(extension));
    // gltf-json 1.4.1 looks at the accessor of the positions before it checks that there is one (`mesh.rs`, line 151).
    for (at, mesh) in root.meshes.iter().enumerate() {
        let indices = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if indices.into_iter().any(|index| index.value() >= root.accessors.len()) {
            return Err(FileError::new(format!("mesh {at}"), "an index points to nothing"));
        }
    }
    let mut found: Option<(String, Error)> = None;
    root.validate(&root, json::Path::new, &mut |path, error| {
        let path = path().0;
        // Bounds are not read, so that they need not be there.
        let bounds = path.ends_with(".min") || path.ends_with(".max");
        if found.is_none() && !bounds {
            found = Some((path, error));
        }
    });
    let Some((path, error)) = found else { return Ok(root) };
    let path: String = path.chars().filter(|c| !c.is_control()).take(100).collect();
    Err(match error {
        Error::Unsupported => FileError::new(path, "the file requires an extension of glTF that is not read")
            .help("write it without compression: `gltf-transform copy` undoes Draco and meshopt"),
        Error::IndexOutOfBounds => FileError::new(path, "an index points to nothing"),
        Error::Missing => FileError::new(path, "something is missing"),
        other @ (Error::Invalid | Error::Oversize) => FileError::new(path, format!("the file is malformed: {other}")),
    })
}

/// Bytes from beside the file, or from an address in it.
type Outer = Box<dyn AsRef<[u8]>>;

/// The bytes of buffers that do not lie in the binary chunk.
fn outer_buffers(root: &json::Root, beside: &mut Beside<'_>) -> Result<Vec<Option<Outer>>, FileError> {
    let mut all: Vec<Option<Outer>> = Vec::new();
    for (at, buffer) in root.buffers.iter().enumerate() {
        let place = || format!("buffer {at}");
        all.push(match buffer.uri.as_deref() {
            None => None,
            Some(uri) => Some(match uri.strip_prefix("data:") {
                Some(data) => {
                    let (_, text) = data
                        .split_once(";base64,")
                        .ok_or_else(|| FileError::new(place(), "its `data:` address is not in base 64"))?;
                    Box::new(STANDARD.decode(text).map_err(|error| {
                        FileError::new(place(), format!("its `data:` address is malformed: {error}").to_lowercase())
                    })?)
                }
                None => {
                    let path = decoded(uri).ok_or_else(|| FileError::new(place(), "its address is malformed"))?;
                    beside(&path).map_err(|message| FileError::new(place(), message))?
                }
            }),
        });
    }
    Ok(all)
}

/// An address with its `%20` resolved.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
        } else {
            byte
        });
    }
    String::from_utf8(bytes).ok()
}

/// From y up to z up.
const UPRIGHT: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]] };

/// What makes two primitives the same mesh: positions, normals, texture coordinates, indices, mode.
type Key = (usize, Option<usize>, Option<usize>, Option<usize>, u8);

struct Reader<'a> {
    buffers: Buffers<'a>,
    /// Bytes that may still be made.
    room: u64,
    model: Model,
    known: BTreeMap<Key, Option<usize>>,
    /// How many primitives use each accessor of positions.
    shared: BTreeMap<usize, u32>,
    /// What is not read, and how often.
    skipped: BTreeMap<&'static str, u64>,
    names: Unique,
}

impl Reader<'_> {
    /// The model, the names that parts can be asked by, and which parts belong to `part`.
    fn run(mut self, part: Option<&str>, notes: &mut Vec<Note>) -> Result<(Model, Vec<String>, Vec<bool>), FileError> {
        let root = self.buffers.root;
        for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            if let Some(positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) {
                *self.shared.entry(positions.value()).or_default() += 1;
            }
        }
        let mut all = Vec::new();
        let mut selected = Vec::new();
        let mut seen = vec![false; root.nodes.len()];
        for (index, map, chosen) in roots(root).into_iter().map(|index| (index, UPRIGHT, false)) {
            // A stack: trees may be deep.
            let mut open = vec![(index, map, chosen)];
            while let Some((index, outer, chosen)) = open.pop() {
                let Some(node) = root.nodes.get(index) else { continue };
                if std::mem::replace(&mut seen[index], true) {
                    let message = "it lies in two places, or within itself";
                    return Err(FileError::new(format!("node {index}"), message));
                }
                let name = node.name.as_deref().unwrap_or("");
                let chosen = chosen || part == Some(name);
                let map = local(node).then(&outer);
                if node.skin.is_some() {
                    *self
                        .skipped
                        .entry("skins are not read: the mesh has the pose in which it was bound")
                        .or_default() += 1;
                }
                if node.camera.is_some() {
                    *self.skipped.entry("cameras are not read").or_default() += 1;
                }
                if let Some(mesh) = node.mesh {
                    if !name.is_empty() {
                        all.push(name.to_owned());
                    }
                    self.mesh(mesh.value(), name, &map, part, chosen, &mut all, &mut selected, notes)?;
                }
                let children = node.children.iter().flatten().rev();
                open.extend(children.map(|child| (child.value(), map, chosen)));
            }
        }
        for (what, count) in &self.skipped {
            notes.push(Note::info("", format!("{what} ({})", plural(*count, "time"))));
        }
        let mut known = std::collections::BTreeSet::new();
        all.retain(|name| known.insert(name.clone()));
        Ok((self.model, all, selected))
    }

    #[expect(clippy::too_many_arguments, reason = "what is known of a node, and three lists to add to")]
    fn mesh(
        &mut self,
        index: usize,
        node: &str,
        map: &Affine,
        part: Option<&str>,
        chosen: bool,
        all: &mut Vec<String>,
        selected: &mut Vec<bool>,
        notes: &mut Vec<Note>,
    ) -> Result<(), FileError> {
        let Some(mesh) = self.buffers.root.meshes.get(index) else { return Ok(()) };
        let own = mesh.name.as_deref().unwrap_or("");
        if !own.is_empty() {
            all.push(own.to_owned());
        }
        if !map.is_invertible() {
            let message = "a node flattens its mesh, which is left out";
            notes.push(Note::warn(format!("mesh {index}"), message));
            return Ok(());
        }
        let name = if node.is_empty() { own } else { node };
        for (at, primitive) in mesh.primitives.iter().enumerate() {
            let Some(made) = self.primitive(primitive, own, notes).map_err(|error| {
                let place = format!("mesh {index}, primitive {at}");
                let place = if error.place.is_empty() { place } else { format!("{place}, {}", error.place) };
                FileError { place, ..error }
            })?
            else {
                continue;
            };
            let name = self.names.name(name);
            let surface = primitive.material.map(|material| material.value());
            self.model.parts.push(Part { name, mesh: made, surface, transform: *map });
            selected.push(chosen || part == Some(own));
        }
        Ok(())
    }

    /// The mesh of a primitive; none where it has no triangles.
    fn primitive(
        &mut self,
        primitive: &json::mesh::Primitive,
        name: &str,
        notes: &mut Vec<Note>,
    ) -> Result<Option<usize>, FileError> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
        let Checked::Valid(mode) = primitive.mode else { return Err(FileError::new("", "its mode is not known")) };
        let mode = match mode {
            Mode::Triangles => 0,
            Mode::TriangleStrip => 1,
            Mode::TriangleFan => 2,
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                *self.skipped.entry("points and lines are not read").or_default() += 1;
                return Ok(None);
            }
        };
        if primitive.targets.is_some() {
            *self.skipped.entry("morph targets are not read").or_default() += 1;
        }
        if attribute(Semantic::Colors(0)).is_some() {
            *self.skipped.entry("vertex colours are not read").or_default() += 1;
        }
        let Some(positions) = attribute(Semantic::Positions) else {
            *self.skipped.entry("primitives without positions are left out").or_default() += 1;
            return Ok(None);
        };
        let indices = primitive.indices.map(|index| index.value());
        let key = (positions, attribute(Semantic::Normals), attribute(Semantic::TexCoords(0)), indices, mode);
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let made = self.geometry(key, notes)?.map(|geometry| {
            self.model.meshes.push((name.to_owned(), geometry));
            self.model.meshes.len() - 1
        });
        self.known.insert(key, made);
        Ok(made)
    }

    fn geometry(&mut self, key: Key, notes: &mut Vec<Note>) -> Result<Option<Geometry>, FileError> {
        let (positions, normals, uvs, indices, mode) = key;
        let length = |at: Option<usize>| at.and_then(|at| self.buffers.root.accessors.get(at)).map_or(0, |a| a.count.0);
        // Twelve bytes for a position or triangle; a strip has nearly as many triangles as indices.
        let corners = if indices.is_some() { length(indices) } else { length(Some(positions)) };
        let lengths = [length(Some(positions)), length(normals), length(uvs), corners];
        let size = lengths.into_iter().fold(0, u64::saturating_add).saturating_mul(12);
        self.room = self.room.checked_sub(size).ok_or_else(|| {
            FileError::new("", format!("what the file describes is more than {GROWTH} times as large as the file"))
                .help("its meshes lie on top of each other: repair it in the program that made it")
        })?;
        let all = self.buffers.vectors::<3>(positions, Type::Vec3)?;
        let count = all.len();
        let normals = normals.map(|at| self.buffers.vectors::<3>(at, Type::Vec3)).transpose()?;
        let uvs = uvs.map(|at| self.buffers.vectors::<2>(at, Type::Vec2)).transpose()?;
        for (what, length) in
            [("normals", normals.as_ref().map(Vec::len)), ("texture coordinates", uvs.as_ref().map(Vec::len))]
        {
            if let Some(length) = length.filter(|length| *length != count) {
                return Err(FileError::new("", format!("it has {count} positions and {length} {what}")));
            }
        }
        let corners = match indices {
            Some(at) => self.buffers.indices(at)?,
            None => {
                (0..u32::try_from(count).map_err(|_| FileError::new("", "it has more than 2^32 vertices"))?).collect()
            }
        };
        if let Some(index) = corners.iter().find(|index| **index as usize >= count) {
            return Err(FileError::new("", format!("a triangle uses vertex {index}, but there are {count} vertices")));
        }
        let triangles: Vec<[u32; 3]> = match mode {
            0 => {
                let (triangles, rest) = corners.as_chunks::<3>();
                if !rest.is_empty() {
                    notes.push(Note::warn(
                        "",
                        format!("{} behind the last triangle not read", plural(rest.len() as u64, "index")),
                    ));
                }
                triangles.to_vec()
            }
            // Every other triangle of a strip is wound the other way (glTF 2.0, 3.7.2.1).
            1 => corners
                .windows(3)
                .enumerate()
                .map(|(at, w)| if at % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
                .collect(),
            _ => {
                let mut faces = Faces::default();
                faces.push(&corners, String::new);
                faces.triangles
            }
        };
        if triangles.is_empty() {
            return Ok(None);
        }
        // v grows downwards in glTF.
        let uvs = uvs.map(|uvs| uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect());
        let mut geometry = Geometry { positions: all, normals, uvs, triangles };
        if self.shared.get(&positions).is_some_and(|uses| *uses > 1) {
            geometry = compact(geometry);
        }
        finish(&mut geometry, notes, |vertex| format!("vertex {vertex}"))?;
        // Where a file gives no normals they are flat (glTF 2.0, 3.7.2.1).
        let geometry = if geometry.normals.is_some() { geometry } else { flat(geometry, notes)? };
        Ok((!geometry.triangles.is_empty()).then_some(geometry))
    }
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

/// The nodes of the default scene; of a file without scenes those that lie in no other.
fn roots(root: &json::Root) -> Vec<usize> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(scene) {
        return scene.nodes.iter().map(|node| node.value()).collect();
    }
    let mut inner = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(inner) = inner.get_mut(child.value()) {
            *inner = true;
        }
    }
    (0..root.nodes.len()).filter(|at| !inner[*at]).collect()
}

/// The map of a node: a matrix by columns, or scale, rotation and translation in this order.
fn local(node: &json::scene::Node) -> Affine {
    if let Some(matrix) = node.matrix {
        let rows = [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| f64::from(matrix[4 * column + row])));
        return Affine { rows };
    }
    let scale = node.scale.map_or([1.0; 3], |scale| scale.map(f64::from));
    let translation = node.translation.map_or([0.0; 3], |by| by.map(f64::from));
    Affine::scaling(scale).then(&turn(node)).then(&Affine::translation(translation))
}

/// The rotation of a node, from its quaternion x, y, z, w.
fn turn(node: &json::scene::Node) -> Affine {
    let Some(rotation) = &node.rotation else { return Affine::IDENTITY };
    let [x, y, z, w] = rotation.0.map(f64::from);
    let size = (x * x + y * y + z * z + w * w).sqrt();
    if normalized([x, y, z]).is_none() || !size.is_finite() {
        return Affine::IDENTITY;
    }
    let [x, y, z, w] = [x, y, z, w].map(|part| part / size);
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), 0.0],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), 0.0],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), 0.0],
    ];
    Affine { rows }
}

#[cfg(test)]
mod tests;
