//! What glTF 2.0 and its extensions ask of numbers: ranges of factors, indices that mean something, bounds that are those of the data.
//!
//! The numbers are those of the schemas of glTF 2.0 and of each extension.

use serde_json::Value;

use super::super::{FileError, shown};
use super::accessor::Buffers;
use super::document::{Document, Item, whole};

/// What a number, or each of a list of numbers, may be.
#[derive(Clone, Copy)]
enum Range {
    /// From 0 to 1.
    Share,
    /// At least this.
    From(f64),
    /// More than this.
    Above(f64),
    /// More than the first and at most the second.
    Within(f64, f64),
    /// 0 or at least 1.
    Index,
}

use Range::{Above, From, Index, Share, Within};

impl Range {
    fn holds(self, x: f64) -> bool {
        match self {
            Share => (0.0..=1.0).contains(&x),
            From(low) => x >= low,
            Above(low) => x > low,
            Within(low, high) => x > low && x <= high,
            Index => x == 0.0 || x >= 1.0,
        }
    }

    fn words(self) -> String {
        match self {
            Share => "0 to 1".to_owned(),
            From(low) => format!("at least {low}"),
            Above(low) => format!("more than {low}"),
            Within(low, high) => format!("more than {low} and at most {high}"),
            Index => "0 or at least 1".to_owned(),
        }
    }
}

const MATERIALS: &[(&str, Range)] = &[
    ("pbrMetallicRoughness/baseColorFactor", Share),
    ("pbrMetallicRoughness/metallicFactor", Share),
    ("pbrMetallicRoughness/roughnessFactor", Share),
    ("emissiveFactor", Share),
    ("alphaCutoff", From(0.0)),
    ("occlusionTexture/strength", Share),
    ("extensions/KHR_materials_anisotropy/anisotropyStrength", Share),
    ("extensions/KHR_materials_clearcoat/clearcoatFactor", Share),
    ("extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", Share),
    ("extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", Share),
    ("extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", Share),
    ("extensions/KHR_materials_dispersion/dispersion", From(0.0)),
    ("extensions/KHR_materials_emissive_strength/emissiveStrength", From(0.0)),
    ("extensions/KHR_materials_ior/ior", Index),
    ("extensions/KHR_materials_iridescence/iridescenceFactor", Share),
    ("extensions/KHR_materials_iridescence/iridescenceIor", From(1.0)),
    ("extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", From(0.0)),
    ("extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", From(0.0)),
    ("extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", Share),
    ("extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", Share),
    ("extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", Share),
    ("extensions/KHR_materials_sheen/sheenColorFactor", Share),
    ("extensions/KHR_materials_sheen/sheenRoughnessFactor", Share),
    ("extensions/KHR_materials_specular/specularFactor", Share),
    ("extensions/KHR_materials_specular/specularColorFactor", From(0.0)),
    ("extensions/KHR_materials_transmission/transmissionFactor", Share),
    ("extensions/KHR_materials_volume/thicknessFactor", From(0.0)),
    ("extensions/KHR_materials_volume/attenuationDistance", Above(0.0)),
    ("extensions/KHR_materials_volume/attenuationColor", Share),
];

const HALF_TURN: f64 = std::f64::consts::PI;

const CAMERAS: &[(&str, Range)] = &[
    ("perspective/aspectRatio", Above(0.0)),
    ("perspective/yfov", Within(0.0, HALF_TURN)),
    ("perspective/znear", Above(0.0)),
    ("perspective/zfar", Above(0.0)),
    ("orthographic/znear", From(0.0)),
    ("orthographic/zfar", Above(0.0)),
];

const LIGHTS: &[(&str, Range)] = &[
    ("color", Share),
    ("intensity", From(0.0)),
    ("range", Above(0.0)),
    ("spot/innerConeAngle", From(0.0)),
    ("spot/outerConeAngle", Within(0.0, HALF_TURN / 2.0)),
];

/// Lists, the indices in their items, and the lists that those point into.
const INDICES: &[(&str, &str, &str)] = &[
    ("accessors", "bufferView", "bufferViews"),
    ("accessors", "sparse/indices/bufferView", "bufferViews"),
    ("accessors", "sparse/values/bufferView", "bufferViews"),
    ("bufferViews", "buffer", "buffers"),
    ("images", "bufferView", "bufferViews"),
    ("materials", "emissiveTexture/index", "textures"),
    ("materials", "normalTexture/index", "textures"),
    ("materials", "occlusionTexture/index", "textures"),
    ("materials", "pbrMetallicRoughness/baseColorTexture/index", "textures"),
    ("materials", "pbrMetallicRoughness/metallicRoughnessTexture/index", "textures"),
    ("nodes", "camera", "cameras"),
    ("nodes", "children", "nodes"),
    ("nodes", "mesh", "meshes"),
    ("nodes", "skin", "skins"),
    ("scenes", "nodes", "nodes"),
    ("skins", "inverseBindMatrices", "accessors"),
    ("skins", "joints", "nodes"),
    ("skins", "skeleton", "nodes"),
    ("textures", "sampler", "samplers"),
    ("textures", "source", "images"),
];

/// How far a rotation may be from unit length.
const UNIT: f64 = 1e-3;

/// All that is not as glTF asks for, at most `most`.
pub fn check(document: &Document<'_>, most: usize) -> Result<Vec<FileError>, FileError> {
    let mut found = Found { all: Vec::new(), most };
    for (kind, table) in [("materials", MATERIALS), ("cameras", CAMERAS)] {
        for item in document.list(kind)? {
            found.ranges(item, table);
        }
    }
    for light in document.lights()? {
        found.ranges(light, LIGHTS);
        let angle = |key: &str| light.value(&format!("spot/{key}")).and_then(Value::as_f64);
        let outer = angle("outerConeAngle").unwrap_or(HALF_TURN / 4.0);
        if light.text("type") == Some("spot") && angle("innerConeAngle").unwrap_or(0.0) >= outer {
            found.say(light, "/spot/innerConeAngle", "`innerConeAngle` is not less than `outerConeAngle`");
        }
    }
    for lens in document.list("cameras")? {
        for kind in ["perspective", "orthographic"] {
            let distance = |key: &str| lens.value(&format!("{kind}/{key}")).and_then(Value::as_f64);
            if distance("zfar").zip(distance("znear")).is_some_and(|(far, near)| far <= near) {
                found.say(lens, &format!("/{kind}/zfar"), "`zfar` is not more than `znear`");
            }
        }
    }
    for (kind, path, list) in INDICES {
        let length = document.list(list)?.len();
        for item in document.list(kind)? {
            found.index(item, path, item.value(path), length);
        }
    }
    let (accessors, materials) = (document.list("accessors")?.len(), document.list("materials")?.len());
    for mesh in document.list("meshes")? {
        for (at, primitive) in mesh.objects("primitives").enumerate() {
            let place = |key: &str| format!("primitives/{at}/{key}");
            for (key, length) in [("indices", accessors), ("material", materials)] {
                found.index(mesh, &place(key), primitive.get(key), length);
            }
            for key in primitive.inner("attributes").iter().flat_map(Item::keys) {
                let path = format!("attributes/{key}");
                found.index(mesh, &place(&path), primitive.value(&path), accessors);
            }
        }
    }
    let lights = document.lights()?.len();
    for node in document.list("nodes")? {
        found.index(
            node,
            "extensions/KHR_lights_punctual/light",
            node.value("extensions/KHR_lights_punctual/light"),
            lights,
        );
        found.node(node);
    }
    Ok(found.all)
}

/// Accessors whose `min` and `max` are not those of their data, and positions that have none; at most `most`.
pub fn bounds(document: &Document<'_>, buffers: &Buffers<'_, '_>, most: usize) -> Result<Vec<FileError>, FileError> {
    let mut found = Found { all: Vec::new(), most };
    for (at, accessor) in buffers.accessors().iter().enumerate() {
        if accessor.count("count") == Some(0) {
            found.say(*accessor, "/count", "`count` is 0, and glTF asks for at least 1");
        }
        if accessor.get("min").is_none() && accessor.get("max").is_none() {
            continue;
        }
        let floats = accessor.count("componentType") == Some(5126);
        // Bounds are those of the numbers as they are stored; only floats are compared.
        if !floats || accessor.get("normalized") == Some(&Value::Bool(true)) {
            continue;
        }
        match buffers.kind(at) {
            "SCALAR" => found.bounds::<1>(*accessor, buffers)?,
            "VEC2" => found.bounds::<2>(*accessor, buffers)?,
            "VEC3" => found.bounds::<3>(*accessor, buffers)?,
            "VEC4" => found.bounds::<4>(*accessor, buffers)?,
            _ => {}
        }
    }
    for mesh in document.list("meshes")? {
        for primitive in mesh.objects("primitives") {
            let at = primitive.inner("attributes").and_then(|attributes| attributes.count("POSITION"));
            let accessor = at.and_then(|at| buffers.accessors().get(at));
            if let Some(accessor) = accessor.filter(|one| one.get("min").is_none() || one.get("max").is_none()) {
                found.say(*accessor, "", "positions have no `min` and `max`");
            }
        }
    }
    Ok(found.all)
}

struct Found {
    all: Vec<FileError>,
    most: usize,
}

impl Found {
    fn say(&mut self, item: Item<'_>, path: &str, message: impl Into<String>) {
        if self.all.len() < self.most {
            self.all.push(FileError::new(format!("{}{path}", item.place()), message));
        }
    }

    fn ranges(&mut self, item: Item<'_>, table: &[(&str, Range)]) {
        for (path, range) in table {
            let Some(value) = item.value(path) else { continue };
            let all = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
            let key = path.rsplit('/').next().unwrap_or(path);
            for one in all {
                match one.as_f64() {
                    Some(number) if range.holds(number) => continue,
                    Some(number) => {
                        let words = range.words();
                        self.say(item, &format!("/{path}"), format!("`{key}` is {number}, and glTF asks for {words}"));
                    }
                    None => self.say(item, &format!("/{path}"), format!("`{key}` is no number")),
                }
                break;
            }
        }
    }

    fn index(&mut self, item: Item<'_>, path: &str, value: Option<&Value>, length: usize) {
        let Some(value) = value else { return };
        let all = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        if let Some(wrong) = all.iter().find(|one| whole(one).is_none_or(|at| at >= length)) {
            let wrong = shown(&wrong.to_string());
            self.say(item, &format!("/{path}"), format!("the index {wrong} points to nothing: there are {length}"));
        }
    }

    fn node(&mut self, node: Item<'_>) {
        if let Some(matrix) = node.get("matrix") {
            let affine =
                node.row::<16>("matrix").is_some_and(|all| [all[3], all[7], all[11], all[15]] == [0.0, 0.0, 0.0, 1.0]);
            if !affine && matrix.is_array() || !matrix.is_array() {
                self.say(node, "/matrix", "the matrix is not affine");
            }
            if ["translation", "rotation", "scale"].iter().any(|key| node.get(key).is_some()) {
                self.say(node, "/matrix", "the matrix stands beside another transform");
            }
        }
        if let Some(rotation) = node.get("rotation") {
            let size = node.row::<4>("rotation").map(|all| all.iter().map(|x| x * x).sum::<f64>().sqrt());
            if size.is_none_or(|size| (size - 1.0).abs() > UNIT) {
                let rotation = shown(&rotation.to_string());
                self.say(node, "/rotation", format!("the rotation {rotation} is no unit quaternion"));
            }
        }
        for key in ["translation", "scale"] {
            if node.get(key).is_some() && node.row::<3>(key).is_none() {
                self.say(node, &format!("/{key}"), format!("`{key}` is not three numbers"));
            }
        }
    }

    fn bounds<const N: usize>(&mut self, accessor: Item<'_>, buffers: &Buffers<'_, '_>) -> Result<(), FileError> {
        let all = buffers.vectors::<N>(accessor.at())?;
        let (mut low, mut high) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        for row in &all {
            for axis in 0..N {
                low[axis] = low[axis].min(row[axis]);
                high[axis] = high[axis].max(row[axis]);
            }
        }
        for (key, own) in [("min", low), ("max", high)] {
            let Some(value) = accessor.get(key) else { continue };
            // Texts hold the shortest form of a double or of a single.
            let said = accessor.row::<N>(key).map(|row| row.map(|x| x as f32));
            if said != Some(own) {
                let message = format!("`{key}` is {}, and that of the data is {own:?}", shown(&value.to_string()));
                self.say(accessor, &format!("/{key}"), message);
            }
        }
        Ok(())
    }
}
