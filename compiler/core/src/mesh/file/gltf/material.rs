//! Materials of glTF 2.0: the metallic-roughness model, the extensions that Scenes have words for, and what is lost of the others.
//!
//! `occlusionTexture` is no loss: it stands for light that is computed here.

use std::collections::BTreeMap;

use serde_json::Value;

use super::super::FileError;
use super::super::model::{Picture, Scatter, Surface};
use super::accessor::{Buffers, decoded, decoded_data};
use super::document::{Document, Item};
use super::extensions::UNREAD_OF_MATERIALS;
use crate::ir::Vec3;

/// A material with how its image lies.
pub struct Look {
    pub surface: Surface,
    /// The set of texture coordinates.
    pub set: usize,
    /// From the texture coordinates to those of the image: KHR_texture_transform.
    pub map: UvMap,
    /// Whether the image ends at its edges, or is mirrored there.
    pub ends: bool,
}

/// Two rows by three columns.
pub type UvMap = [[f64; 3]; 2];

pub const PLAIN: UvMap = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// The lists that materials point into.
struct Lists<'v> {
    textures: Vec<Item<'v>>,
    images: Vec<Item<'v>>,
    samplers: Vec<Item<'v>>,
}

/// The materials in their order.
pub fn looks(document: &Document<'_>, buffers: &Buffers<'_, '_>) -> Result<Vec<Look>, FileError> {
    let lists = Lists {
        textures: document.list("textures")?,
        images: document.list("images")?,
        samplers: document.list("samplers")?,
    };
    // Materials may share an image: its bytes are there once.
    let mut images = BTreeMap::new();
    let mut look = |material: Item<'_>| {
        let mut open = |image: Item<'_>| images.entry(image.at()).or_insert_with(|| picture(image, buffers)).clone();
        look(material, &lists, &mut open)
    };
    document.list("materials")?.into_iter().map(&mut look).collect()
}

/// An image; none where it cannot be had.
fn picture(image: Item<'_>, buffers: &Buffers<'_, '_>) -> Option<Picture> {
    let ending = |kind: Option<&str>, bytes: &[u8]| match kind {
        Some("image/png") => Some("png"),
        Some("image/jpeg") => Some("jpg"),
        _ if bytes.starts_with(b"\x89PNG") => Some("png"),
        _ if bytes.starts_with(b"\xff\xd8\xff") => Some("jpg"),
        _ => None,
    };
    let inside = |kind: Option<&str>, bytes: &[u8]| {
        Some(Picture::Inside { image: image.at(), ending: ending(kind, bytes)?, bytes: bytes.into() })
    };
    if let Some(view) = image.count("bufferView") {
        return inside(image.text("mimeType"), buffers.view(view)?);
    }
    let uri = image.text("uri")?;
    match uri.strip_prefix("data:") {
        Some(data) => {
            let (kind, bytes) = decoded_data(data).ok()?;
            inside(Some(kind), &bytes)
        }
        None => decoded(uri).map(Picture::Beside),
    }
}

/// The image of a texture with how it lies, and what is lost of it.
struct Texture {
    picture: Option<Picture>,
    set: usize,
    map: UvMap,
    ends: bool,
    lost: Vec<&'static str>,
}

fn texture(
    used: Item<'_>,
    lists: &Lists<'_>,
    open: &mut dyn FnMut(Item<'_>) -> Option<Picture>,
) -> Result<Texture, FileError> {
    let nothing = || FileError::new(used.place(), "the index of its texture points to nothing");
    let texture = used.link("index", &lists.textures).map_err(|_| nothing())?.ok_or_else(nothing)?;
    let transform = used.extension("KHR_texture_transform");
    let set = transform.and_then(|own| own.count("texCoord")).or_else(|| used.count("texCoord")).unwrap_or(0);
    let map = transform.map_or(PLAIN, |own| {
        let [sx, sy] = own.row::<2>("scale").unwrap_or([1.0; 2]);
        let [x, y] = own.row::<2>("offset").unwrap_or_default();
        let angle = own.number("rotation").unwrap_or(0.0);
        // Counter-clockwise as the image is seen, where v grows downwards.
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]]
    });
    let mut lost = Vec::new();
    let sampler = texture.link("sampler", &lists.samplers)?;
    let code = |key: &str| sampler.and_then(|sampler| sampler.count(key));
    const NEAREST: usize = 9728;
    const REPEAT: usize = 10497;
    if code("magFilter") == Some(NEAREST) {
        lost.push("that its image is not interpolated (`magFilter` of its sampler)");
    }
    let ends = ["wrapS", "wrapT"].iter().any(|key| code(key).is_some_and(|how| how != REPEAT));
    let image = texture.link("source", &lists.images)?;
    let other = [
        ("KHR_texture_basisu", "its image, which is there only in KTX 2 (`KHR_texture_basisu`)"),
        ("EXT_texture_webp", "its image, which is there only in WebP (`EXT_texture_webp`)"),
        ("EXT_texture_avif", "its image, which is there only in AVIF (`EXT_texture_avif`)"),
        ("MSFT_texture_dds", "its image, which is there only in DDS (`MSFT_texture_dds`)"),
    ];
    let picture = image.and_then(|image| open(*image));
    if picture.is_none() {
        let known = other.iter().find(|(name, _)| image.is_none() && texture.extension(name).is_some());
        lost.push(known.map_or("its image, which is neither PNG nor JPEG or cannot be had", |(_, words)| *words));
    }
    Ok(Texture { picture, set, map, ends, lost })
}

/// What glTF 2.0 and the extensions say where a file is silent.
const IOR: f64 = 1.5;

fn look(
    material: Item<'_>,
    lists: &Lists<'_>,
    open: &mut dyn FnMut(Item<'_>) -> Option<Picture>,
) -> Result<Look, FileError> {
    let mut lost = Vec::new();
    let pbr = material.inner("pbrMetallicRoughness");
    let glossy = material.extension("KHR_materials_pbrSpecularGlossiness");
    let unlit = material.extension("KHR_materials_unlit").is_some();
    let (colored, factor, image) = match (glossy, unlit) {
        (Some(glossy), false) => (Some(glossy), "diffuseFactor", "diffuseTexture"),
        _ => (pbr, "baseColorFactor", "baseColorTexture"),
    };
    let [r, g, b, alpha] = colored.and_then(|item| item.row::<4>(factor)).unwrap_or([1.0; 4]).map(unit);
    let base = [r, g, b];
    let painted = colored.and_then(|item| item.inner(image)).map(|used| texture(used, lists, open)).transpose()?;
    let scatter = match (glossy, unlit) {
        (_, true) => {
            lost.push("that it shows its color whatever light falls on it (`KHR_materials_unlit`)");
            Scatter::Diffuse(base)
        }
        (Some(glossy), false) => specular_glossiness(glossy, base, &mut lost),
        (None, false) => metallic_roughness(material, pbr, base, &mut lost),
    };
    let mut lose = |is: bool, what: &'static str| {
        if is {
            lost.push(what);
        }
    };
    lose(material.get("normalTexture").is_some(), "normal maps");
    let cut = material.text("alphaMode").is_some_and(|mode| mode != "OPAQUE");
    lose(
        cut && (painted.is_some() || alpha != 1.0),
        "alpha, by which things are seen through a surface without being refracted",
    );
    if !unlit {
        for (name, factor, off, what) in UNREAD_OF_MATERIALS {
            let Some(own) = material.extension(name) else { continue };
            let zero = |value: &Value| {
                let all = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
                all.iter().all(|one| one.as_f64() == Some(0.0))
            };
            lose(own.get(factor).map_or(!off, |value| !zero(value)), what);
        }
    }
    let strength = material.extension("KHR_materials_emissive_strength");
    let gain = strength.and_then(|own| own.number("emissiveStrength")).unwrap_or(1.0);
    let emission: Vec3 = material.row::<3>("emissiveFactor").unwrap_or_default().map(|x| x * gain);
    let shines = emission.iter().all(|x| x.is_finite() && *x >= 0.0) && emission != [0.0; 3];
    let pictured = shines && material.get("emissiveTexture").is_some();
    lose(pictured, "emission that an image gives (`emissiveTexture`)");
    let shines = shines && !pictured;
    lose(shines && material.get("doubleSided") == Some(&Value::Bool(true)), "that it emits on its back, too");
    let Texture { picture, set, map, ends, lost: of_image } =
        painted.unwrap_or(Texture { picture: None, set: 0, map: PLAIN, ends: false, lost: Vec::new() });
    lost.extend(of_image);
    let name = material.text("name").unwrap_or_default().to_owned();
    let factor = if picture.is_some() { base } else { [1.0; 3] };
    let surface = Surface { name, scatter, emission: shines.then_some(emission), picture, factor, lost };
    Ok(Look { surface, set, map, ends })
}

fn metallic_roughness(material: Item<'_>, pbr: Option<Item<'_>>, base: Vec3, lost: &mut Vec<&'static str>) -> Scatter {
    let mut lose = |is: bool, what: &'static str| {
        if is {
            lost.push(what);
        }
    };
    let number = |key: &str| unit(pbr.and_then(|pbr| pbr.number(key)).unwrap_or(1.0));
    let (metallic, roughness) = (number("metallicFactor"), number("roughnessFactor"));
    lose(pbr.is_some_and(|pbr| pbr.get("metallicRoughnessTexture").is_some()), "textures of metallicity and roughness");
    let transmission = material.extension("KHR_materials_transmission");
    let factor = transmission.and_then(|own| own.number("transmissionFactor")).unwrap_or(0.0);
    let transmitted = unit(factor) * (1.0 - metallic);
    let index = material.extension("KHR_materials_ior").and_then(|own| own.number("ior")).unwrap_or(IOR);
    let ior = if index >= 1.0 { index } else { IOR };
    if transmitted > 0.0 {
        lose(transmitted < 1.0, "the part of light that glass does not transmit");
        lose(base != [1.0; 3], "the tint of transmitted light");
        lose(transmission.is_some_and(|own| own.get("transmissionTexture").is_some()), "textures of transmission");
        let volume = material.extension("KHR_materials_volume");
        let thick = volume.and_then(|own| own.number("thicknessFactor")).unwrap_or(0.0) > 0.0;
        lose(!thick, "that its glass is thin, so that light passes it straight");
        let absorbs = volume.filter(|own| own.get("attenuationDistance").is_some());
        let color = absorbs.and_then(|own| own.row::<3>("attenuationColor")).unwrap_or([1.0; 3]);
        lose(thick && color != [1.0; 3], "absorption within glass (`attenuationColor`)");
        return Scatter::Glass { ior, alpha: roughness * roughness };
    }
    let specular = material.extension("KHR_materials_specular");
    let strength = specular.and_then(|own| own.number("specularFactor")).unwrap_or(1.0);
    if metallic == 1.0 {
        return match roughness {
            0.0 => Scatter::Mirror(base),
            _ => Scatter::MetallicRoughness { base, metallic, roughness, ior },
        };
    }
    if metallic == 0.0 && strength == 0.0 {
        return Scatter::Diffuse(base);
    }
    let drawn = specular
        .is_some_and(|own| ["specularTexture", "specularColorTexture"].iter().any(|key| own.get(key).is_some()));
    lose(drawn, "textures of specular reflection");
    let [r, g, b] = specular.and_then(|own| own.row::<3>("specularColorFactor")).unwrap_or([1.0; 3]);
    // An index of 0 is one without end (KHR_materials_ior); a grey factor of the reflectance head-on is another index.
    let root = if index == 0.0 { 1.0 } else { (ior - 1.0) / (ior + 1.0) };
    let head_on = root * root;
    let scaled = head_on * r;
    let says = strength == 1.0 && r == g && g == b && (0.0..=MOST_HEAD_ON).contains(&scaled);
    lose(!says, "strength and color of specular reflection");
    let ior = if says && (r != 1.0 || index == 0.0) { index_of(scaled) } else { ior };
    Scatter::MetallicRoughness { base, metallic, roughness, ior }
}

/// The largest reflectance head-on that an index of refraction stands for here.
const MOST_HEAD_ON: f64 = 0.5;

/// The index of refraction whose reflectance head-on this is.
fn index_of(head_on: f64) -> f64 {
    let root = head_on.clamp(0.0, MOST_HEAD_ON).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// The specular-glossiness model: exactly where it is diffuse, a metal or a grey coat, else by what is brightest of it.
fn specular_glossiness(own: Item<'_>, diffuse: Vec3, lost: &mut Vec<&'static str>) -> Scatter {
    let specular = own.row::<3>("specularFactor").unwrap_or([1.0; 3]).map(unit);
    let roughness = 1.0 - unit(own.number("glossinessFactor").unwrap_or(1.0));
    if own.get("specularGlossinessTexture").is_some() {
        lost.push("textures of specular reflection and gloss");
    }
    let most = specular.iter().fold(0.0_f64, |most, x| most.max(*x));
    if most == 0.0 {
        return Scatter::Diffuse(diffuse);
    }
    if diffuse == [0.0; 3] && own.get("diffuseTexture").is_none() {
        return match roughness {
            0.0 => Scatter::Mirror(specular),
            _ => Scatter::MetallicRoughness { base: specular, metallic: 1.0, roughness, ior: IOR },
        };
    }
    // The diffuse part is what the brightest channel of the specular one leaves.
    let base = diffuse.map(|x| x * (1.0 - most));
    if specular != [most; 3] || most > MOST_HEAD_ON {
        lost.push("the color of specular reflection (`KHR_materials_pbrSpecularGlossiness`)");
    }
    let head_on = most.min(MOST_HEAD_ON);
    // Ours takes the share of the coat from the base itself, as glTF's metallic-roughness model does.
    let base = base.map(|x| unit(x / (1.0 - head_on)));
    Scatter::MetallicRoughness { base, metallic: 0.0, roughness, ior: index_of(head_on) }
}

/// A number held to 0..1.
fn unit(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}
