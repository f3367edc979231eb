//! Materials: the metallic-roughness model, as the scattering function that is nearest to it.

use std::collections::HashMap;

use super::at;
use crate::diag::Origin;
use crate::files::VPath;
use crate::formats::shared::coat::Coat;
use crate::formats::shared::fresnel;
use crate::import::Builder;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Bsdf, Color, ColorOrTexture, Emission, Handle, Material, Sides, Texture, Vec3};
use crate::mesh::file::gltf::document::Document;
use crate::mesh::file::{FileError, Model, Picture, Scatter, Surface, plain_color};

/// The surface of parts for which the file gives none: glTF's default material, without its gloss.
const GREY: f64 = 0.8;
/// Up to this difference from Schlick's Fresnel term a metal's own stands for it.
const NEAR: f64 = 0.05;
/// The gray by which it is said how a coat changes an image.
const MIDDLE: f64 = 0.5;

/// A material, and what its surface emits.
type Made = (Handle<Material>, Option<Emission>);

/// The materials of a file.
pub struct Surfaces<'p> {
    path: &'p VPath,
    all: Vec<Surface>,
    of_file: Vec<OfFile>,
    of_ltsc: bool,
    /// Images of the file by number and the bits of their factor.
    images: HashMap<(usize, [u64; 3]), Option<Handle<Texture>>>,
    /// What was made of a surface, with and without its image.
    made: HashMap<(Option<usize>, bool), Made>,
}

/// What the importer asks of a material beside what the mesh's reader says.
struct OfFile {
    place: String,
    /// Whether it gives an index of refraction.
    has_index: bool,
    two_sided: bool,
}

impl<'p> Surfaces<'p> {
    /// Those of a model.
    ///
    /// # Errors
    /// A list of materials that is none.
    pub fn new(document: &Document<'_>, model: &Model, path: &'p VPath, of_ltsc: bool) -> Result<Self, FileError> {
        let of_file = document.list("materials")?.into_iter().map(|item| OfFile {
            place: item.place(),
            has_index: item.extension("KHR_materials_ior").is_some(),
            two_sided: item.get("doubleSided") == Some(&true.into()),
        });
        Ok(Self {
            path,
            all: model.surfaces.clone(),
            of_file: of_file.collect(),
            of_ltsc,
            images: HashMap::new(),
            made: HashMap::new(),
        })
    }

    /// The file that they stand in.
    pub fn path(&self) -> &'p VPath {
        self.path
    }

    /// The material of a surface and what it emits; `laid` says whether the mesh has texture coordinates.
    pub fn get(&mut self, surface: Option<usize>, laid: bool, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        if let Some(made) = self.made.get(&(surface, laid)) {
            return made.clone();
        }
        let made = self.make(surface, laid, reader, to);
        self.made.insert((surface, laid), made.clone());
        made
    }

    fn make(&mut self, index: Option<usize>, laid: bool, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let Some(mut surface) = index.and_then(|index| self.all.get(index).cloned()) else {
            let here = at(self.path, "/meshes".to_owned());
            let message = format!("meshes without a material become `diffuse({GREY})`");
            reader.lost(Fate::Approximated, here.clone(), message);
            return (
                to.material("grey", Bsdf::Diffuse { reflectance: Color::Grey(GREY).into() }, Sides::Both, &here),
                None,
            );
        };
        let of_file = index.and_then(|index| self.of_file.get(index));
        let here = at(self.path, of_file.map_or("/materials".to_owned(), |own| own.place.clone()));
        let (has_index, two_sided) = of_file.map_or((false, true), |own| (own.has_index, own.two_sided));
        for what in &surface.lost {
            reader.lost(Fate::Dropped, here.clone(), format!("not read of materials: {what}"));
        }
        let glass = matches!(surface.scatter, Scatter::Glass { ior: _, alpha: _ });
        // What ltsc writes of a lamp has no `doubleSided` either, whatever its surface is.
        let front = !two_sided && surface.emission.is_none() && !glass;
        let sides = if front && self.of_ltsc { Sides::Front } else { Sides::Both };
        if front && !self.of_ltsc {
            let message = "surfaces that are not drawn from behind scatter light on both sides";
            reader.lost(Fate::Approximated, here.clone(), message);
        }
        let coated = if self.of_ltsc { darkened(&surface) } else { None };
        if let Some(factor) = coated.filter(|_| laid) {
            surface.factor = factor;
        }
        let texture = match &surface.picture {
            Some(_) if !laid => {
                reader.lost(Fate::Dropped, here.clone(), "a texture is left out: its mesh has no texture coordinates");
                None
            }
            Some(picture) => self.texture(picture, &surface, &here, reader, to),
            None => None,
        };
        let bsdf = scattering(&surface.scatter, texture, has_index, coated.is_some());
        if texture.is_some() && bsdf.texture().is_none() {
            reader.lost(Fate::Dropped, here.clone(), "a texture of the color is left out: glass and mirrors take none");
        }
        if let (Scatter::MetallicRoughness { .. }, false) = (&surface.scatter, self.of_ltsc) {
            let message = "the material of glTF becomes the nearest of `conductor`, `plastic` and `principled`";
            reader.lost(Fate::Approximated, here.clone(), message);
        }
        let emission = surface.emission.filter(|radiance| {
            let held = radiance.iter().all(|x| *x <= 1e30);
            if !held {
                reader.lost(Fate::Dropped, here.clone(), "emission beyond 1e30 is left out");
            } else if !self.of_ltsc {
                let message = "emission in candela per square meter is read as the number of W/(m2 sr)";
                reader.lost(Fate::Approximated, here.clone(), message);
            }
            held
        });
        let name = if surface.name.is_empty() { bsdf.word() } else { &surface.name };
        (to.material(name, bsdf, sides, &here), emission.and_then(|radiance| Builder::emission(plain_color(radiance))))
    }

    fn texture(
        &mut self,
        picture: &Picture,
        surface: &Surface,
        here: &Origin,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<Handle<Texture>> {
        match picture {
            Picture::Inside { image, ending, bytes } => {
                let key = (*image, surface.factor.map(f64::to_bits));
                if let Some(known) = self.images.get(&key) {
                    return *known;
                }
                let name = if surface.name.is_empty() { "image" } else { surface.name.as_str() };
                let made = to.texture_inside(reader, (name, ending), bytes, surface.factor, here);
                self.images.insert(key, made);
                made
            }
            Picture::Beside(written) => match VPath::resolve(self.path.folder(), &written.replace('\\', "/")) {
                Ok(file) => to.texture(reader, &file, None, surface.factor, here),
                Err(error) => {
                    reader.lost(Fate::Dropped, here.clone(), format!("an image is left out: {error}"));
                    None
                }
            },
        }
    }
}

/// What stands for a surface. What ltsc writes is read back as it was: of metals a principled one has an index of refraction, and a
/// conductor has none. `coated` says that the factor of a texture is that of a base under a coat.
fn scattering(scatter: &Scatter, texture: Option<Handle<Texture>>, has_index: bool, coated: bool) -> Bsdf {
    let Scatter::MetallicRoughness { base, metallic, roughness, ior } = *scatter else {
        return scatter.bsdf(texture).0;
    };
    let alpha = roughness * roughness;
    if metallic == 1.0 && !has_index && texture.is_none() {
        let fits: Option<Vec<[f64; 2]>> = base.iter().map(|share| metal(*share)).collect();
        if let Some(&[r, g, b]) = fits.as_deref() {
            let channel = |at: usize| plain_color([r[at], g[at], b[at]]);
            return Bsdf::Conductor { eta: channel(0), k: channel(1), alpha };
        }
    }
    if metallic == 0.0 && ior > 1.0 {
        // glTF's coat does not darken its base, ours does: what is seen of the base stands in the file.
        let coat = Coat::new(ior);
        let reflectance = match texture {
            None => Some(ColorOrTexture::Color(plain_color(base.map(|seen| coat.base(seen))))),
            Some(texture) => coated.then_some(ColorOrTexture::Texture(texture)),
        };
        if let Some(reflectance) = reflectance {
            return Bsdf::Plastic { reflectance, ior, alpha };
        }
    }
    scatter.bsdf(texture).0
}

/// The factor of a texture under a coat, where what is seen of it can be that: of a gray of 0.5 both are the same.
fn darkened(surface: &Surface) -> Option<Vec3> {
    let Scatter::MetallicRoughness { base: _, metallic: 0.0, roughness: _, ior } = surface.scatter else { return None };
    let coat = Coat::new(ior.max(1.000_001));
    let factor = surface.factor.map(|seen| coat.base(MIDDLE * seen) / MIDDLE);
    factor.iter().all(|x| *x <= 1.0 + 1e-9).then(|| factor.map(|x| x.min(1.0)))
}

/// The index of refraction and the extinction of a metal that reflects this share head-on and is as near to Schlick's term as can be;
/// none where that is not near.
fn metal(head_on: f64) -> Option<[f64; 2]> {
    const STEPS: u32 = 200;
    let share = head_on.clamp(1e-6, 0.9999);
    let root = share.sqrt();
    // Where nothing is absorbed; between both lie all indices of this reflectance.
    let (low, high) = ((1.0 - root) / (1.0 + root), (1.0 + root) / (1.0 - root));
    let mut best = (f64::INFINITY, [1.0, 0.0]);
    for step in 0..=STEPS {
        let eta = low * libm::pow(high / low, f64::from(step) / f64::from(STEPS));
        let square = (share * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - share);
        let k = square.max(0.0).sqrt();
        let off = (1..=40)
            .map(|at| f64::from(at) / 40.0)
            .map(|cosine| (fresnel::conductor(eta, k, cosine) - fresnel::schlick(share, cosine)).abs());
        let off = off.fold(0.0, f64::max);
        if off < best.0 {
            best = (off, [eta, k]);
        }
    }
    (best.0 <= NEAR).then_some(best.1)
}
