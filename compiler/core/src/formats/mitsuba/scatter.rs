//! What Mitsuba's scattering plugins and textures mean.

use std::collections::BTreeMap;

use super::names::Version;
use super::xml::{Plugin, Said};
use crate::files::VPath;
use crate::formats::shared::coat::normal_reflectance;
use crate::formats::shared::reading::{Fresnel, Inside, MIX_LIMIT, Model, Paint, Rgb};
use crate::formats::shared::source::{LIMIT, REFERENCE, SYNTAX, shown, whole};
use crate::ir::Affine;

/// The index of refraction that surroundings have unless told otherwise: air (`ior.h` of all versions).
const AIR: f64 = 1.000277;
/// That of glass, inside a dielectric: "bk7".
const GLASS: f64 = 1.5046;
/// That of a coat: "polypropylene".
const COAT: f64 = 1.49;

/// Plugins that are understood.
const KNOWN: &[&str] = &[
    "diffuse",
    "conductor",
    "roughconductor",
    "dielectric",
    "roughdielectric",
    "plastic",
    "roughplastic",
    "principled",
    "blendbsdf",
];

/// What plugins refer to.
pub struct Known<'k> {
    /// The version of the format.
    pub version: Version,
    /// Textures by their ids.
    pub textures: &'k BTreeMap<String, Paint>,
}

impl Known<'_> {
    /// The model of a plugin, and whether it scatters on both sides.
    pub fn surface(&self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> (Model, bool) {
        let two_sided = plugin.kind() == "twosided";
        let inner = if two_sided { plugin.inner("bsdf").next() } else { Some(plugin) };
        if two_sided {
            plugin.finish(to);
        }
        let model = inner.and_then(|inner| self.model(inner, to));
        // What is not understood is black, so that what refers to it is not a second finding.
        (model.unwrap_or(Model::Diffuse { reflectance: Paint::BLACK }), two_sided)
    }

    fn model(&self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<Model> {
        let names = self.version.names();
        let kind = plugin.kind();
        let model = match kind {
            "diffuse" => Some(Model::Diffuse { reflectance: self.paint(plugin, "reflectance", 0.5, to) }),
            "conductor" | "roughconductor" => self.conductor(plugin, to),
            "dielectric" | "roughdielectric" => {
                let alpha = self.alpha(plugin, to);
                let inside = plugin.float(names.int_ior, to).unwrap_or(GLASS);
                let outside = plugin.float(names.ext_ior, to).unwrap_or(AIR);
                Some(Model::Dielectric { eta: inside / outside, alpha })
            }
            "plastic" | "roughplastic" => {
                let alpha = self.alpha(plugin, to);
                let base = self.paint(plugin, names.diffuse_reflectance, 0.5, to);
                let ior = plugin.float(names.int_ior, to).unwrap_or(COAT);
                let ior = ior / plugin.float(names.ext_ior, to).unwrap_or(AIR);
                // Without it the light that the coat throws back does not take the base's color again.
                let inside = if plugin.boolean("nonlinear", to).unwrap_or(false) { Inside::Base } else { Inside::Seen };
                Some(Model::Coated { base, inside, ior, alpha })
            }
            "principled" if names.principled => {
                let base = self.paint(plugin, "base_color", 0.5, to);
                let metallic = plugin.float("metallic", to).unwrap_or(0.0);
                let roughness = plugin.float("roughness", to).unwrap_or(0.5);
                // The default is a reflectance of 0.04 head-on, that of 1.5.
                let specular = normal_reflectance(plugin.float("eta", to).unwrap_or(1.5));
                Some(Model::Principled { base, metallic, alpha: roughness * roughness, specular, ceiling: 1.0 })
            }
            "blendbsdf" => {
                let share = plugin.float("weight", to).unwrap_or(0.5);
                // Elements are nested to a bounded depth, and so are blends.
                let parts: Vec<Model> = plugin.inner("bsdf").filter_map(|part| self.model(part, to)).collect();
                let mixed = <[Model; 2]>::try_from(parts).map(|parts| Model::Mix { share, parts: Box::new(parts) });
                match mixed {
                    Ok(mixed) if mixed.size() <= MIX_LIMIT => Some(mixed),
                    Ok(_) => {
                        to.say(LIMIT, plugin.at(), "blends of blends are nested too deeply");
                        None
                    }
                    Err(_) => {
                        to.say(SYNTAX, plugin.at(), "a blend is not made of two materials");
                        None
                    }
                }
            }
            _ => {
                to.unknown(plugin.at(), "material", kind, KNOWN);
                return None;
            }
        };
        plugin.finish(to);
        model
    }

    fn conductor(&self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<Model> {
        let names = self.version.names();
        let alpha = self.alpha(plugin, to);
        let tint = self.paint(plugin, names.specular_reflectance, 1.0, to);
        if let Some(material) = plugin.string("material", to) {
            if material != "none" {
                to.unknown(plugin.at(), "metal", material, &["none"]);
            }
            return Some(Model::Conductor { fresnel: Fresnel::Constant, tint, alpha });
        }
        let outside = match names.ext_eta {
            Some(name) => plugin.float(name, to).unwrap_or(AIR),
            None => 1.0,
        };
        let part = |value: Option<Rgb>| value.map(|rgb| rgb.map(|x| x / outside));
        let (eta, k) = (part(plugin.rgb("eta", to)), part(plugin.rgb("k", to)));
        match eta.zip(k) {
            Some((eta, k)) => Some(Model::Conductor { fresnel: Fresnel::Exact { eta, k }, tint, alpha }),
            None => {
                to.say(SYNTAX, plugin.at(), "a metal without `eta` and `k` is not read");
                None
            }
        }
    }

    /// The GGX width of a rough plugin; 0 of another one.
    fn alpha(&self, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> f64 {
        if !plugin.kind().starts_with("rough") {
            return 0.0;
        }
        if plugin.string("distribution", to) != Some("ggx") {
            // The default of all versions is Beckmann's.
            to.say(SYNTAX, plugin.at(), "a distribution other than `ggx` is not read");
        }
        plugin.float("alpha", to).unwrap_or(0.1)
    }

    fn paint(&self, plugin: Plugin<'_>, name: &str, default: f64, to: &mut Said<'_, '_, '_>) -> Paint {
        if let Some(color) = plugin.rgb(name, to) {
            return Paint::Color(color);
        }
        let Some((element, id)) = plugin.refers(Some(name), to) else { return Paint::Color([default; 3]) };
        match self.textures.get(id) {
            Some(paint) => paint.clone(),
            None => {
                to.say(REFERENCE, element.at, format!("there is no texture `{}`", shown(id)));
                Paint::BLACK
            }
        }
    }
}

/// The image that a texture plugin is.
pub fn image(version: Version, plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<Paint> {
    let names = version.names();
    if plugin.kind() != "bitmap" {
        to.unknown(plugin.at(), "texture", plugin.kind(), &["bitmap"]);
        return None;
    }
    let file = file(plugin, to);
    plugin.expect(names.filter_type.0, &[names.filter_type.1], to);
    plugin.expect(names.wrap_mode, &["repeat"], to);
    // Mitsuba's v grows downwards in the image.
    let mirrored = |scale: f64, offset: f64| scale == -1.0 && offset == 1.0;
    let (linear, upright) = if names.to_uv {
        let map = plugin.transform("to_uv", to);
        let mut plain = Affine::IDENTITY;
        plain.rows[1] = [0.0, -1.0, 0.0, 1.0];
        (plugin.boolean("raw", to).unwrap_or(false), map == plain)
    } else {
        let gamma = plugin.float("gamma", to).unwrap_or(0.0);
        if gamma != 1.0 && gamma != -1.0 {
            to.say(SYNTAX, plugin.at(), "a `gamma` other than 1 and -1 (sRGB) is not read");
        }
        let scale = plugin.float("vscale", to).unwrap_or(1.0);
        (gamma == 1.0, mirrored(scale, plugin.float("voffset", to).unwrap_or(0.0)))
    };
    if !upright {
        to.say(
            SYNTAX,
            plugin.at(),
            "an image that lies otherwise than with its lower left corner at (0, 0) is not read",
        );
    }
    plugin.finish(to);
    Some(Paint::Image { file: file?.into(), linear, factor: [1.0; 3] })
}

/// The file that a plugin names.
pub fn file(plugin: Plugin<'_>, to: &mut Said<'_, '_, '_>) -> Option<VPath> {
    let Some(name) = plugin.string("filename", to) else {
        to.say(SYNTAX, plugin.at(), "there is no `filename`");
        return None;
    };
    let text = to.text;
    let at = plugin.at();
    let origin = || if at == 0 { whole(text.path) } else { text.origin(at) };
    to.source.path(text.path, name, origin)
}
