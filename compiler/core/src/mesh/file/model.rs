//! What a file of several parts holds: meshes, what they are made of, and where they lie.

use std::sync::Arc;

use super::finish::flat;
use super::{FileError, Note, missing_part};
use crate::ir::{Affine, Bsdf, Color, ColorOrTexture, Handle, Texture, Vec3};
use crate::mesh::{Geometry, faceted, transform};

/// The parts of a file with their materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Meshes in coordinates of their own, with their names.
    pub meshes: Vec<(String, Geometry)>,
    /// Materials.
    pub surfaces: Vec<Surface>,
    /// Meshes at their places, in the order of the file; names are not empty and not repeated.
    pub parts: Vec<Part>,
}

/// A mesh at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of the object, node or mesh.
    pub name: String,
    /// The mesh.
    pub mesh: usize,
    /// The material; none where the file gives none.
    pub surface: Option<usize>,
    /// From the mesh's coordinates to those of the file; invertible.
    pub transform: Affine,
}

/// A material as a file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its name; may be empty.
    pub name: String,
    /// How it scatters light.
    pub scatter: Scatter,
    /// The radiance that it sends out on its front; none for 0.
    pub emission: Option<Vec3>,
    /// The image that gives its diffuse or base color, over the first texture coordinates.
    pub picture: Option<Picture>,
    /// A factor of that image's linear numbers; 1 without an image.
    pub factor: Vec3,
    /// What the file says of it that is not in here, in words.
    pub lost: Vec<&'static str>,
}

/// An image that colors a surface, by the sRGB curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// A file, by its path from the folder of the mesh file.
    Beside(String),
    /// Within the mesh file.
    Inside {
        /// Its number in the file.
        image: usize,
        /// The ending that its file would have.
        ending: &'static str,
        /// Its bytes.
        bytes: Arc<[u8]>,
    },
}

/// How a surface of a file scatters light. Colors are linear sRGB.
#[derive(Clone, Debug, PartialEq)]
pub enum Scatter {
    /// Lambertian reflection.
    Diffuse(Vec3),
    /// Ideal specular reflection.
    Mirror(Vec3),
    /// Clear glass of this index of refraction and GGX width.
    Glass {
        /// Index of refraction behind the normals.
        ior: f64,
        /// GGX width.
        alpha: f64,
    },
    /// The metallic-roughness model of glTF 2.0.
    MetallicRoughness {
        /// Base color.
        base: Vec3,
        /// 0 for plastic, 1 for metal.
        metallic: f64,
        /// 0..1; the GGX width is its square.
        roughness: f64,
        /// Index of refraction of what is no metal.
        ior: f64,
    },
}

impl Scatter {
    /// The scattering of a surface, under a texture if it has one, and in words how it differs from what the file says.
    pub fn bsdf(&self, texture: Option<Handle<Texture>>) -> (Bsdf, Option<&'static str>) {
        let paint = |plain| texture.map_or_else(|| plain_color(plain).into(), ColorOrTexture::Texture);
        match *self {
            Self::Diffuse(reflectance) => (Bsdf::Diffuse { reflectance: paint(reflectance) }, None),
            Self::Mirror(reflectance) => (Bsdf::Mirror { reflectance: plain_color(reflectance) }, None),
            Self::Glass { ior, alpha } => (Bsdf::Dielectric { interior: ior, exterior: 1.0, alpha }, None),
            // At an index of 1 nothing is reflected at the surface.
            Self::MetallicRoughness { base, metallic: 0.0, roughness: _, ior } if ior <= 1.0 => {
                (Bsdf::Diffuse { reflectance: paint(base) }, None)
            }
            Self::MetallicRoughness { base, metallic, roughness, ior } => {
                let bsdf = Bsdf::Principled { base: paint(base), metallic, roughness, ior: ior.max(1.000_001) };
                (bsdf, Some("the model of glTF becomes `principled`, whose base is not Lambert's but Burley's"))
            }
        }
    }
}

/// A color, a gray where it is one.
pub fn plain_color([r, g, b]: Vec3) -> Color {
    if r == g && g == b { Color::Grey(r) } else { Color::Rgb([r, g, b]) }
}

/// The name of a part for which the file has none.
pub const NAMELESS: &str = "part";

/// The most triangles that a mesh made of all parts may have.
const MERGED_LIMIT: usize = 100_000_000;

impl Model {
    /// One part without a material.
    pub(super) fn of(geometry: Geometry) -> Self {
        let part = Part { name: NAMELESS.to_owned(), mesh: 0, surface: None, transform: Affine::IDENTITY };
        Self { meshes: vec![(String::new(), geometry)], surfaces: Vec::new(), parts: vec![part] }
    }

    /// The model with flat normals where a mesh has none, without the parts that have no area then.
    pub(super) fn with_normals(mut self, notes: &mut Vec<Note>) -> Result<Self, FileError> {
        let mut good = vec![true; self.meshes.len()];
        for ((_, geometry), good) in self.meshes.iter_mut().zip(&mut good) {
            if geometry.normals.is_none() {
                *geometry = flat(std::mem::take(geometry), notes)?;
                *good = !geometry.triangles.is_empty();
                notes.push(Note::baked("", "without normals shaded flat").counting(1, "part"));
            }
        }
        self.parts.retain(|part| good[part.mesh]);
        if self.parts.is_empty() {
            return Err(FileError::new("", "no triangle of the file has an area"));
        }
        Ok(self)
    }

    /// All parts as one mesh, each at its place. Parts without normals among others that have some get flat ones.
    pub(super) fn merged(self, notes: &mut Vec<Note>) -> Result<Geometry, FileError> {
        let Self { meshes, surfaces: _, parts } = self;
        let own = |part: &Part| &meshes[part.mesh].1;
        let count: usize = parts.iter().map(|part| own(part).triangles.len()).sum();
        let vertices: usize = parts.iter().map(|part| own(part).positions.len()).sum();
        if count > MERGED_LIMIT || u32::try_from(vertices).is_err() {
            return Err(FileError::new("", format!("all parts together have {count} triangles"))
                .help("read it as a group, whose parts share their meshes: `group name = file(...)`"));
        }
        let having = |has: fn(&Geometry) -> bool| parts.iter().filter(|part| has(own(part))).count();
        let normals = having(|geometry| geometry.normals.is_some()) > 0;
        let uvs = having(|geometry| geometry.uvs.is_some());
        if uvs > 0 && uvs < parts.len() {
            let message = format!("only {uvs} of {} parts have texture coordinates, so none are read", parts.len());
            notes.push(Note::dropped("", message));
        }
        let uvs = uvs == parts.len();
        let mut all = Geometry {
            positions: Vec::new(),
            normals: normals.then(Vec::new),
            uvs: uvs.then(Vec::new),
            triangles: Vec::with_capacity(count),
        };
        for part in &parts {
            let broken = |error: crate::mesh::MeshError| FileError::new(part.name.clone(), error.message);
            let mut geometry = own(part).clone();
            if normals && geometry.normals.is_none() {
                geometry = faceted(geometry).map_err(broken)?.0;
            }
            if part.transform != Affine::IDENTITY {
                geometry = transform(geometry, &part.transform).map_err(broken)?;
            }
            let Geometry { positions, normals, uvs, triangles } = geometry;
            let base = all.positions.len() as u32;
            all.positions.extend(positions);
            all.triangles.extend(triangles.into_iter().map(|triangle| triangle.map(|index| index + base)));
            if let (Some(all), Some(own)) = (&mut all.normals, normals) {
                all.extend(own);
            }
            if let (Some(all), Some(own)) = (&mut all.uvs, uvs) {
                all.extend(own);
            }
        }
        if all.triangles.is_empty() {
            return Err(FileError::new("", "the file has no triangles"));
        }
        Ok(all)
    }

    /// Keeps the parts that `select` chooses by their position; an error where there are none.
    pub(super) fn only(mut self, kind: &str, part: &str, names: &[String], select: &[bool]) -> Result<Self, FileError> {
        let mut at = 0;
        self.parts.retain(|_| {
            at += 1;
            select[at - 1]
        });
        if self.parts.is_empty() { Err(missing_part(kind, part, names)) } else { Ok(self) }
    }
}

/// Hands out names that are not empty and not repeated.
#[derive(Default)]
pub(super) struct Unique(std::collections::BTreeMap<String, u32>);

impl Unique {
    /// `name`, or with a number behind it where it is taken.
    pub fn name(&mut self, name: &str) -> String {
        let name = if name.trim().is_empty() { NAMELESS } else { name };
        // Control characters cannot stand in names; neither can anything without end.
        let name: String = name.chars().filter(|c| !c.is_control()).take(100).collect();
        let mut made = name.clone();
        loop {
            let count = self.0.entry(made.clone()).or_insert(0);
            *count += 1;
            if *count == 1 {
                return made;
            }
            let next = format!("{name}_{count}");
            made = next;
        }
    }
}
