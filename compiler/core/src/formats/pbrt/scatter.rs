//! What PBRT's materials and textures mean.

use std::collections::BTreeMap;

use super::names::{self, Version};
use super::text::{Params, Said};
use crate::files::VPath;
use crate::formats::shared::reading::{Fresnel, Inside, MIX_LIMIT, Model, Paint, Rgb};
use crate::formats::shared::source::{LIMIT, REFERENCE, SYNTAX, shown};
use crate::ir::Meaning;

/// What materials and textures refer to.
pub struct Known<'k> {
    /// The version of the format.
    pub version: Version,
    /// Textures by name.
    pub textures: &'k BTreeMap<String, Paint>,
    /// Materials by name.
    pub materials: &'k BTreeMap<String, Model>,
}

/// The materials of each version.
const V3: &[&str] = &["matte", "metal", "glass", "mirror", "substrate", "disney"];
const V4: &[&str] = &["diffuse", "conductor", "dielectric", "coateddiffuse", "mix"];

impl Known<'_> {
    /// The model of a material of the type `kind`. A type that is not known is a finding.
    pub fn material(&self, kind: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<Model> {
        match (self.version, kind) {
            (Version::V3, "matte") => {
                self.zero(&["sigma"], params, to);
                Some(Model::Diffuse { reflectance: self.paint("Kd", 0.5, params, to) })
            }
            (Version::V4, "diffuse") => {
                Some(Model::Diffuse { reflectance: self.paint("reflectance", 0.5, params, to) })
            }
            (Version::V3, "metal") => self.metal(0.01, params, to),
            (Version::V4, "conductor") => match self.color("reflectance", Meaning::Share, params, to) {
                Some(tint) => {
                    let alpha = self.alpha(0.0, params, to);
                    Some(Model::Conductor { fresnel: Fresnel::HeadOn, tint: Paint::Color(tint), alpha })
                }
                None => match self.texture("reflectance", params, to) {
                    Some(tint) => {
                        Some(Model::Conductor { fresnel: Fresnel::HeadOn, tint, alpha: self.alpha(0.0, params, to) })
                    }
                    None => self.metal(0.0, params, to),
                },
            },
            (Version::V3, "glass") => {
                for name in ["Kr", "Kt"] {
                    if self.color(name, Meaning::Share, params, to).is_some_and(|color| color != [1.0; 3]) {
                        to.say(SYNTAX, params.place(name), format!("glass with `{name}` other than 1 is not read"));
                    }
                }
                let index = params.float("index", to);
                let eta = params.float("eta", to).or(index).unwrap_or(1.5);
                Some(Model::Dielectric { eta, alpha: self.alpha(0.0, params, to) })
            }
            (Version::V4, "dielectric") => {
                let eta = params.float("eta", to).unwrap_or(1.5);
                Some(Model::Dielectric { eta, alpha: self.alpha(0.0, params, to) })
            }
            (Version::V3, "mirror") => {
                let tint = self.paint("Kr", 0.9, params, to);
                Some(Model::Conductor { fresnel: Fresnel::Constant, tint, alpha: 0.0 })
            }
            (Version::V3, "substrate") => {
                let base = self.paint("Kd", 0.5, params, to);
                let specular = self.color("Ks", Meaning::Share, params, to).unwrap_or([0.5; 3]);
                let alpha = self.alpha(0.1, params, to);
                // The reflectance head-on is ((n - 1) / (n + 1))^2.
                let root = specular[0].max(0.0).sqrt();
                if specular != [specular[0]; 3] || root >= 1.0 {
                    to.say(SYNTAX, params.place("Ks"), "`Ks` is not that of a clear coat");
                    return None;
                }
                Some(Model::Coated { base, inside: Inside::Seen, ior: (1.0 + root) / (1.0 - root), alpha })
            }
            (Version::V3, "disney") => {
                let base = self.paint("color", 0.5, params, to);
                let metallic = params.float("metallic", to).unwrap_or(0.0);
                let roughness = params.float("roughness", to).unwrap_or(0.5);
                let eta = params.float("eta", to).unwrap_or(1.5);
                self.zero(&["speculartint", "sheen", "clearcoat", "spectrans"], params, to);
                let root = (eta - 1.0) / (eta + 1.0);
                Some(Model::Principled {
                    base,
                    metallic,
                    alpha: roughness * roughness,
                    specular: root * root,
                    ceiling: 1.0,
                })
            }
            (Version::V4, "coateddiffuse") => {
                let base = self.paint("reflectance", 0.5, params, to);
                let ior = params.float("eta", to).unwrap_or(1.5);
                if params.float("thickness", to).is_none_or(|thickness| thickness > names::THICKNESS) {
                    to.say(SYNTAX, params.at, "a coat whose layer absorbs light by its `thickness` is not read");
                }
                Some(Model::Coated { base, inside: Inside::Base, ior, alpha: self.alpha(0.0, params, to) })
            }
            (Version::V4, "mix") => self.mix(params, to),
            (version, _) => {
                let known = match version {
                    Version::V3 => V3,
                    Version::V4 => V4,
                };
                to.unknown(params.at, "material", kind, known);
                None
            }
        }
    }

    fn metal(&self, roughness: f64, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<Model> {
        let eta = self.color("eta", Meaning::Index, params, to);
        let k = self.color("k", Meaning::Index, params, to);
        let alpha = self.alpha(roughness, params, to);
        let (Some(eta), Some(k)) = (eta, k) else {
            to.say(SYNTAX, params.at, "a metal without `eta` and `k` is not read");
            return None;
        };
        Some(Model::Conductor { fresnel: Fresnel::Exact { eta, k }, tint: Paint::WHITE, alpha })
    }

    fn mix(&self, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<Model> {
        let names = params.strings("string", "materials", to).unwrap_or_default();
        let share = params.float("amount", to).unwrap_or(0.5);
        let mut parts = Vec::new();
        for name in &names {
            match self.materials.get(name.as_ref()) {
                Some(part) => parts.push(part.clone()),
                None => {
                    let message = format!("there is no material `{}`", shown(name));
                    to.say(REFERENCE, params.place("materials"), message);
                }
            }
        }
        let Ok([first, second]) = <[Model; 2]>::try_from(parts) else {
            to.say(SYNTAX, params.at, "a mix is not made of two materials");
            return None;
        };
        let mixed = Model::Mix { share, parts: Box::new([first, second]) };
        if mixed.size() > MIX_LIMIT {
            to.say(LIMIT, params.at, "mixes of mixes are nested too deeply");
            return None;
        }
        Some(mixed)
    }

    /// Parameters that must be 0, since what they say is not read.
    fn zero(&self, names: &[&str], params: &Params<'_>, to: &mut Said<'_, '_, '_>) {
        for name in names {
            if params.float(name, to).is_some_and(|value| value != 0.0) {
                to.say(SYNTAX, params.place(name), format!("`{name}` other than 0 is not read"));
            }
        }
    }

    fn color(&self, name: &str, meaning: Meaning, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<Rgb> {
        params.color(name, meaning, to).map(|(rgb, _)| rgb)
    }

    fn texture(&self, name: &str, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Option<Paint> {
        let texture = params.one("texture", name, to)?;
        let found = self.textures.get(texture.as_ref());
        if found.is_none() {
            to.say(REFERENCE, params.place(name), format!("there is no texture `{}`", shown(&texture)));
        }
        found.cloned()
    }

    fn paint(&self, name: &str, default: f64, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> Paint {
        match self.color(name, Meaning::Share, params, to) {
            Some(color) => Paint::Color(color),
            None => self.texture(name, params, to).unwrap_or(Paint::Color([default; 3])),
        }
    }

    /// The GGX width of `roughness`, or of `uroughness` and `vroughness`, which must be equal.
    fn alpha(&self, default: f64, params: &Params<'_>, to: &mut Said<'_, '_, '_>) -> f64 {
        let one = params.float("roughness", to);
        let (u, v) = (params.float("uroughness", to), params.float("vroughness", to));
        let remapped = params.bool("remaproughness", to).unwrap_or(true);
        if u != v {
            to.say(SYNTAX, params.at, "roughness that differs along u and v is not read");
        }
        let given = u.or(one);
        let value = given.unwrap_or(default);
        // A smooth surface stays smooth: v3 looks at the numbers before they are mapped (`glass.cpp`), v4's root of 0 is 0.
        if !remapped || value == 0.0 {
            return value;
        }
        match self.version {
            // `TrowbridgeReitzDistribution::RoughnessToAlpha` of both.
            Version::V3 => {
                let x = libm::log(value.max(1e-3));
                1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
            }
            Version::V4 => value.max(0.0).sqrt(),
        }
    }

    /// A texture of the class `class`; `file` makes a path of a name.
    pub fn image(
        &self,
        class: &str,
        params: &Params<'_>,
        to: &mut Said<'_, '_, '_>,
        file: impl Fn(&mut Said<'_, '_, '_>, &str) -> Option<VPath>,
    ) -> Option<Paint> {
        match (self.version, class) {
            (_, "imagemap") => {
                let name = params.string("filename", to)?;
                let file = file(to, &name)?;
                let expected = |name: &str, value: &str, to: &mut Said<'_, '_, '_>| {
                    if params.string(name, to).is_some_and(|said| said != value) {
                        to.say(SYNTAX, params.place(name), format!("`{name}` other than \"{value}\" is not read"));
                    }
                };
                expected("wrap", "repeat", to);
                let linear = match self.version {
                    Version::V3 => {
                        // What `trilinear` chooses is how pixels are averaged.
                        params.bool("trilinear", to);
                        let eight_bits = file.extension() == "png" || file.extension() == "tga";
                        !params.bool("gamma", to).unwrap_or(eight_bits)
                    }
                    Version::V4 => {
                        expected("filter", "bilinear", to);
                        match params.string("encoding", to).as_deref() {
                            Some("linear") => true,
                            Some("sRGB") | None => false,
                            Some(other) => {
                                let message = format!("the encoding `{}` is not read", shown(other));
                                to.say(SYNTAX, params.place("encoding"), message);
                                false
                            }
                        }
                    }
                };
                Some(Paint::Image { file: file.into(), linear, factor: [1.0; 3] })
            }
            (Version::V3, "scale") => {
                let factor = self.color("tex2", Meaning::Share, params, to)?;
                Some(self.texture("tex1", params, to)?.scaled(factor))
            }
            (Version::V4, "scale") => {
                let factor = params.float("scale", to)?;
                Some(self.texture("tex", params, to)?.scaled([factor; 3]))
            }
            (Version::V3 | Version::V4, _) => {
                to.unknown(params.at, "texture", class, &["imagemap", "scale"]);
                None
            }
        }
    }
}
