//! Materials of all versions.

use std::rc::Rc;

use super::color::glass;
use super::dialect::Dialect;
use super::params::{Params, Values};
use super::texture::Map;
use super::world::World;
use crate::diag::{Span, nearest};
use crate::formats::shared::coat::Coat;
use crate::import::color::{Use, of_rgb};
use crate::import::metals;
use crate::import::reader::Fate;
use crate::import::reader::shown;
use crate::ir::{Bsdf, Color, ColorOrTexture};

/// What a surface is made of.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Its name, or its kind.
    pub name: String,
    /// How it scatters light; none where it is not seen at all.
    pub bsdf: Option<Bsdf>,
    /// From the shape's texture coordinates to those of its image.
    pub map: Map,
}

/// What stands for a material that is not read, and PBRT's own default: grey.
pub fn grey() -> Bsdf {
    Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() }
}

/// v3's map of roughness to the width of GGX (`TrowbridgeReitzDistribution::RoughnessToAlpha`).
pub fn alpha_v3(roughness: f64) -> f64 {
    let x = libm::log(roughness.max(1e-3));
    1.62142 + 0.819955 * x + 0.1734 * x * x + 0.0171201 * x * x * x + 0.000640711 * x * x * x * x
}

/// The width of GGX that is like Blinn's lobe with the exponent 1 / roughness of v1 and v2, `alpha = sqrt(2 / (n + 2))` (Walter et al.
/// 2007).
pub fn alpha_old(roughness: f64) -> f64 {
    (2.0 / (1.0 / roughness.max(1e-4) + 2.0)).sqrt()
}

/// The index of a coat that reflects this share head-on.
fn ior_of(share: f64) -> f64 {
    let root = share.clamp(1e-6, 0.25).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// A metal of index 1 that reflects this share head-on: v4's own rule for `reflectance`, and v1's for its metals (`FresnelApproxK`).
fn metal_of(reflectance: &Color, alpha: f64) -> Bsdf {
    let k = reflectance.rgb().map(|share| {
        let share = share.clamp(0.0, 0.9999);
        2.0 * (share / (1.0 - share)).sqrt()
    });
    Bsdf::Conductor { eta: Color::Grey(1.0), k: Color::Rgb(k), alpha }
}

impl World<'_, '_> {
    /// `MakeNamedMaterial`.
    pub fn make_named_material(&mut self, name: &str, params: &Params) {
        if !params.has("type") {
            let message = format!("the material `{}` is left out: it has no `type`", shown(name));
            self.dropped(params.span, message);
            params.pass_all();
            return;
        }
        let surface = self.surface(&params.kind, name, params);
        if self.materials.insert(name.to_owned(), Rc::new(surface)).is_some() {
            let message = format!("the material `{}` is made twice: the last one counts from here on", shown(name));
            self.reader.lost(Fate::Noise, params.span, message);
        }
    }

    /// `NamedMaterial`.
    pub fn named_material(&mut self, name: &str, span: Span) {
        match self.materials.get(name) {
            Some(surface) => self.state.material = Some(Rc::clone(surface)),
            None => {
                let near = nearest(name, self.materials.keys().map(String::as_str));
                let help = near.map(|near| format!("is `{near}` meant?")).unwrap_or_default();
                let message = format!("there is no material `{}`: the one before it stays", shown(name));
                self.reader.lost_with(Fate::Dropped, span, message, &help);
            }
        }
    }

    /// What a material is.
    pub fn surface(&mut self, kind: &str, name: &str, params: &Params) -> Surface {
        let (bsdf, map) = self.scattering(kind, params);
        params.drop(Fate::Dropped, &["bumpmap", "displacement", "normalmap"], "the surface is smooth", self.reader);
        let name = if name.is_empty() { "none" } else { name };
        Surface { name: name.to_owned(), bsdf, map }
    }

    fn scattering(&mut self, kind: &str, params: &Params) -> (Option<Bsdf>, Map) {
        let alone = |bsdf: Bsdf| (Some(bsdf), Map::IDENTITY);
        match kind {
            "matte" | "diffuse" => {
                let (reflectance, map) = self.paint(params, if kind == "matte" { "Kd" } else { "reflectance" }, 0.5);
                if self.number(params, "sigma").is_some_and(|sigma| sigma != 0.0) {
                    let message = "`sigma` is left out: the surface is ideally diffuse";
                    self.near(params.span_of("sigma"), message);
                }
                (Some(Bsdf::Diffuse { reflectance }), map)
            }
            "plastic" => self.plastic(params, (0.25, 0.25), 0.04),
            "uber" => self.uber(params),
            "substrate" => self.plastic(params, (0.5, 0.5), 1.0),
            "glass" | "dielectric" | "roughglass" => {
                let default = 0.0;
                let alpha = self.alpha(params, default);
                let interior = self.ior(params, 1.5);
                for name in ["Kr", "Kt"] {
                    let tint = self.tint(params, name, 1.0);
                    if !tint.is_grey() || tint.max() != 1.0 {
                        let message = format!("`{name}` of `{kind}` is left out: glass is clear");
                        self.dropped(params.span_of(name), message);
                    }
                }
                alone(Bsdf::Dielectric { interior, exterior: 1.0, alpha })
            }
            "thindielectric" => {
                params.pass(&["eta"]);
                let message = "a thin dielectric is read as nothing: light passes it straight, none is reflected";
                self.near(params.span, message);
                (None, Map::IDENTITY)
            }
            "metal" | "conductor" => {
                let alpha = self.alpha(params, if kind == "metal" { 0.01 } else { 0.0 });
                if params.has("reflectance") {
                    let reflectance = self.tint(params, "reflectance", 1.0);
                    return alone(metal_of(&reflectance, alpha));
                }
                let (eta, k) = self.metal(params, "eta", "k");
                alone(Bsdf::Conductor { eta, k, alpha })
            }
            "shinymetal" => {
                let alpha = self.alpha(params, 0.1);
                let (rough, smooth) = (self.tint(params, "Ks", 1.0), self.tint(params, "Kr", 1.0));
                let message = "a shiny metal of two lobes is read as one of a metal";
                self.near(params.span, message);
                alone(if rough.is_black() { metal_of(&smooth, 0.0) } else { metal_of(&rough, alpha) })
            }
            "mirror" => {
                let reflectance = self.tint(params, "Kr", 0.9);
                alone(Bsdf::Mirror { reflectance })
            }
            "coateddiffuse" => {
                let alpha = self.alpha(params, 0.0);
                let ior = self.ior(params, 1.5).max(1.0001);
                let (reflectance, map) = self.paint(params, "reflectance", 0.5);
                self.layers(params);
                (Some(Bsdf::Plastic { reflectance, ior, alpha }), map)
            }
            "coatedconductor" => {
                let message = "the coat of a metal is left out";
                self.dropped(params.span, message);
                params.pass(&["interface.roughness", "interface.uroughness", "interface.vroughness", "interface.eta"]);
                params.pass(&["thickness", "g", "albedo", "maxdepth", "nsamples"]);
                let alpha =
                    self.alpha_of(params, ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"], 0.0);
                if params.has("reflectance") {
                    let reflectance = self.tint(params, "reflectance", 1.0);
                    return alone(metal_of(&reflectance, alpha));
                }
                let (eta, k) = self.metal(params, "conductor.eta", "conductor.k");
                alone(Bsdf::Conductor { eta, k, alpha })
            }
            "translucent" | "diffusetransmission" => {
                let (name, part) = if kind == "translucent" { ("Kd", "reflect") } else { ("reflectance", "") };
                let (mut reflectance, map) = self.paint(params, name, 0.25);
                let message = format!("`{kind}` lets no light through: what it reflects is read as a diffuse surface");
                self.dropped(params.span, message);
                params.pass(&["Ks", "transmit", "transmittance", "roughness", "remaproughness", "scale"]);
                if !part.is_empty() {
                    let share = self.tint(params, part, 0.5);
                    if let ColorOrTexture::Color(color) = &reflectance {
                        reflectance = super::color::times(color, &share).into();
                    }
                }
                (Some(Bsdf::Diffuse { reflectance }), map)
            }
            "disney" => self.disney(params),
            "mix" => self.mix(params),
            "none" | "" | "interface" => (None, Map::IDENTITY),
            other => {
                let message = format!("the material `{}` is not read: a grey diffuse surface stands in", shown(other));
                self.dropped(params.span, message);
                params.pass_all();
                alone(grey())
            }
        }
    }

    /// The width of GGX that a material's roughness means.
    fn alpha(&mut self, params: &Params, default: f64) -> f64 {
        self.alpha_of(params, ["roughness", "uroughness", "vroughness"], default)
    }

    fn alpha_of(&mut self, params: &Params, [both, u, v]: [&str; 3], default: f64) -> f64 {
        let all = self.number(params, both).unwrap_or(default);
        let (along, across) = (self.number(params, u).unwrap_or(all), self.number(params, v).unwrap_or(all));
        let remap = params.boolean("remaproughness", self.reader).unwrap_or(true);
        let dialect = self.dialect;
        let width = |roughness: f64| match dialect {
            _ if roughness <= 0.0 => 0.0,
            Dialect::Old => alpha_old(roughness),
            Dialect::V3 if remap => alpha_v3(roughness),
            Dialect::V4 if remap => roughness.sqrt(),
            Dialect::V3 | Dialect::V4 => roughness,
        };
        let (along, across) = (width(along), width(across));
        if along != across {
            let at = params.span_of(if params.has(u) { u } else { v });
            self.near(at, "an anisotropic surface is read as an isotropic one of the mean width");
        }
        if dialect == Dialect::Old && along > 0.0 {
            let message = "Blinn's lobe is read as GGX of the same width, whose highlights have longer tails";
            self.near(params.span, message);
        }
        let alpha = if along == across { along } else { (along * across).sqrt() };
        if alpha > 1.0 {
            self.near(params.span_of(both), "a surface rougher than GGX of the width 1 is read as one of 1");
        }
        // v4 takes what is smoother for smooth (`EffectivelySmooth`).
        let smooth = dialect == Dialect::V4 && alpha < 1e-3;
        if smooth { 0.0 } else { alpha.min(1.0) }
    }

    /// The index of refraction of something clear.
    fn ior(&mut self, params: &Params, default: f64) -> f64 {
        let name = if params.has("eta") { "eta" } else { "index" };
        let Some(param) = params.find(name) else { return default };
        let value = match (&param.values, param.kind.as_str()) {
            (_, "texture" | "float" | "integer") => self.number(params, name),
            (Values::Strings(names), _) if names.first().is_some_and(|name| glass(name).is_some()) => {
                let message = "glass whose index grows towards blue has that of yellow light everywhere";
                self.near(param.span, message);
                names.first().and_then(|name| glass(name))
            }
            _ => {
                let color = self.color(params, name, Use::Index);
                if color.as_ref().is_some_and(|color| color.min() != color.max()) {
                    let message = "glass whose index depends on the color has that of green light everywhere";
                    self.near(param.span, message);
                }
                color.map(|color| color.rgb()[1])
            }
        };
        let Some(value) = value else { return default };
        if value > 0.0 && value <= 100.0 {
            return value;
        }
        // v1 to v3 count an index of 0 as one that is not there.
        self.near(param.span, format!("an index of refraction of {value} is read as {default}"));
        default
    }

    /// Index of refraction and extinction of a metal; copper where they are not said, as in all versions.
    fn metal(&mut self, params: &Params, eta: &str, k: &str) -> (Color, Color) {
        let copper = metals::metal("Cu").unwrap_or(([1.0; 3], [1.0; 3]));
        let index = |name: &str, default: [f64; 3], world: &mut Self| {
            if params.find(name).is_some_and(|found| found.kind == "texture") {
                let texture = params.find(name).and_then(|found| found.strings().first().cloned()).unwrap_or_default();
                return match world.referred(&texture, true, params.span_of(name)) {
                    Some(super::texture::Paint::Color(color)) => color,
                    Some(_) => {
                        world.dropped(params.span_of(name), format!("a texture of `{name}` is read as copper"));
                        Color::Rgb(default)
                    }
                    None => Color::Rgb(default),
                };
            }
            world.color(params, name, Use::Index).unwrap_or(Color::Rgb(default))
        };
        let (eta, k) = (index(eta, copper.0, self), index(k, copper.1, self));
        if eta.min() > 0.0 {
            return (eta, k);
        }
        self.near(params.span, "a conductor whose index of refraction is 0 is read as one of 0.001");
        (Color::Rgb(eta.rgb().map(|x| x.max(1e-3))), k)
    }

    /// A base under a lobe (`plastic`, `uber`, `substrate`): a coat that reflects as much head-on, and the base of which as much is
    /// seen. `head_on` is the coat's reflectance where the lobe's color is 1.
    fn plastic(&mut self, params: &Params, (base, lobe): (f64, f64), head_on: f64) -> (Option<Bsdf>, Map) {
        let (reflectance, map) = self.paint(params, "Kd", base);
        let specular = self.tint(params, "Ks", lobe);
        let alpha = self.alpha(params, 0.1);
        let [r, g, b] = specular.rgb();
        let share = (r + g + b) / 3.0;
        if share == 0.0 {
            return (Some(Bsdf::Diffuse { reflectance }), map);
        }
        let ior = ior_of(share * head_on);
        let message = format!(
            "`{}` is read as a diffuse base under a clear coat that reflects as much head-on",
            shown(&params.kind)
        );
        self.near(params.span, message);
        if !specular.is_grey() {
            self.near(params.span_of("Ks"), "the highlights of a coat have no color");
        }
        if share * head_on > 0.25 {
            self.near(params.span_of("Ks"), "a coat that reflects more than 0.25 head-on reflects 0.25");
        }
        let coat = Coat::new(ior);
        let reflectance = match reflectance {
            ColorOrTexture::Color(color) => {
                ColorOrTexture::Color(of_rgb(color.rgb().map(|share| coat.base(share).min(1.0))))
            }
            texture @ ColorOrTexture::Texture(_) => {
                let message = "a texture under a coat is darker than in the file, more so where it is bright";
                self.near(params.span_of("Kd"), message);
                texture
            }
        };
        (Some(Bsdf::Plastic { reflectance, ior, alpha }), map)
    }

    fn uber(&mut self, params: &Params) -> (Option<Bsdf>, Map) {
        let eta = self.ior(params, 1.5);
        let root = (eta - 1.0) / (eta + 1.0);
        let (mirrored, through) = (self.tint(params, "Kr", 0.0), self.tint(params, "Kt", 0.0));
        let opacity = self.tint(params, "opacity", 1.0);
        if opacity.is_black() {
            params.pass_all();
            return (None, Map::IDENTITY);
        }
        if opacity.min() < 1.0 {
            let message = "`opacity` is left out: a surface is there or it is not";
            self.dropped(params.span_of("opacity"), message);
        }
        let dark = |name: &str, default: f64, world: &mut Self| match world.paint(params, name, default).0 {
            ColorOrTexture::Color(color) => color.is_black(),
            ColorOrTexture::Texture(_) => false,
        };
        if dark("Kd", 0.25, self) && dark("Ks", 0.25, self) && !(mirrored.is_black() && through.is_black()) {
            params.pass_all();
            let message = "`uber` that reflects and lets through alone is read as clear glass";
            self.near(params.span, message);
            return (Some(Bsdf::Dielectric { interior: eta, exterior: 1.0, alpha: 0.0 }), Map::IDENTITY);
        }
        for (name, color) in [("Kr", mirrored), ("Kt", through)] {
            if !color.is_black() {
                let message = format!("`{name}` of `uber` is left out: it has a base and a coat");
                self.dropped(params.span_of(name), message);
            }
        }
        self.plastic(params, (0.25, 0.25), root * root)
    }

    /// What stands between a coat and its base in v4.
    fn layers(&mut self, params: &Params) {
        params.pass(&["maxdepth", "nsamples", "g"]);
        let thickness = self.number(params, "thickness").unwrap_or(0.01);
        if thickness > 1e-4 {
            let message = format!("a layer of the thickness {thickness} under a coat absorbs nothing");
            self.near(params.span_of("thickness"), message);
        }
        let albedo = self.tint(params, "albedo", 0.0);
        if !albedo.is_black() {
            self.dropped(params.span_of("albedo"), "a medium under a coat is left out");
        }
    }

    fn disney(&mut self, params: &Params) -> (Option<Bsdf>, Map) {
        let (base, map) = self.paint(params, "color", 0.5);
        let share =
            |name: &str, default: f64, world: &mut Self| world.number(params, name).unwrap_or(default).clamp(0.0, 1.0);
        let (metallic, roughness) = (share("metallic", 0.0, self), share("roughness", 0.5, self));
        let ior = self.ior(params, 1.5).clamp(1.0001, 10.0);
        let others = ["speculartint", "anisotropic", "sheen", "clearcoat", "spectrans", "flatness", "difftrans"];
        for name in others {
            // v3's default of `difftrans` is 1, which counts for thin surfaces only.
            let counts = name != "difftrans" || params.boolean("thin", self.reader) == Some(true);
            if self.number(params, name).is_some_and(|value| value != 0.0) && counts {
                self.dropped(params.span_of(name), format!("`{name}` of `disney` is left out"));
            }
        }
        if params.has("scatterdistance") {
            let distance = self.color(params, "scatterdistance", Use::Light);
            if distance.is_none_or(|distance| !distance.is_black()) {
                self.dropped(params.span_of("scatterdistance"), "light does not travel below a surface");
            }
        }
        if params.boolean("thin", self.reader) == Some(true) {
            self.dropped(params.span_of("thin"), "a thin `disney` surface lets no light through");
        }
        params.pass(&["sheentint", "clearcoatgloss"]);
        (Some(Bsdf::Principled { base, metallic, roughness, ior }), map)
    }

    /// Two diffuse colors are mixed; of other materials the one with the larger share is taken.
    fn mix(&mut self, params: &Params) -> (Option<Bsdf>, Map) {
        let names: Vec<String> = match params.find("materials") {
            Some(found) => found.strings().to_vec(),
            None => ["namedmaterial1", "namedmaterial2"]
                .iter()
                .filter_map(|name| params.string(name, self.reader).map(str::to_owned))
                .collect(),
        };
        let v3 = !params.has("materials");
        let amount = match params.find("amount") {
            Some(found) if found.kind != "texture" => {
                let [r, g, b] = self.color(params, "amount", Use::Share).unwrap_or(Color::Grey(0.5)).rgb();
                (r + g + b) / 3.0
            }
            // v3's is a color, v4's a number.
            Some(_) if self.dialect == Dialect::V4 => self.number(params, "amount").unwrap_or(0.5),
            Some(_) => {
                let [r, g, b] = self.tint(params, "amount", 0.5).rgb();
                (r + g + b) / 3.0
            }
            None => 0.5,
        };
        // v3's amount is the first one's share, v4's the second one's.
        let second = if v3 { 1.0 - amount } else { amount };
        let found: Vec<_> = names.iter().map(|name| self.materials.get(name).cloned()).collect();
        let (a, b) = match found.as_slice() {
            [Some(a), Some(b)] => (Rc::clone(a), Rc::clone(b)),
            _ => {
                self.dropped(
                    params.span,
                    "a mixture of materials that are not there is read as a grey diffuse surface",
                );
                return (Some(grey()), Map::IDENTITY);
            }
        };
        if let (Some(Bsdf::Diffuse { reflectance: one }), Some(Bsdf::Diffuse { reflectance: other })) =
            (&a.bsdf, &b.bsdf)
            && let (Some(one), Some(other)) = (one.color(), other.color())
        {
            let (one, other) = (one.rgb(), other.rgb());
            let mixed = [0, 1, 2].map(|at| one[at] + (other[at] - one[at]) * second);
            return (Some(Bsdf::Diffuse { reflectance: of_rgb(mixed).into() }), Map::IDENTITY);
        }
        if second > 0.0 && second < 1.0 {
            self.dropped(params.span, "of a mixture of materials the one with the larger share is taken");
        }
        let taken = if second > 0.5 { b } else { a };
        (taken.bsdf.clone(), taken.map)
    }
}
