//! Materials and textures.

use std::collections::BTreeMap;

use super::plugin::Plugin;
use super::tree::Element;
use crate::diag::{Origin, nearest};
use crate::files::VPath;
use crate::formats::shared::coat::Coat;
use crate::import::Builder;
use crate::import::color::Use;
use crate::import::metals;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Bsdf, Color, ColorOrTexture, Encoding, Handle, Texture};

/// What a surface is made of.
#[derive(Clone, Debug)]
pub struct Made {
    /// How it scatters light; none where it is not seen at all (`null`).
    pub bsdf: Option<Bsdf>,
    /// From the shape's texture coordinates to those of its image.
    pub uv: Map,
    /// Whether it scatters on both sides.
    pub two_sided: bool,
}

impl Made {
    fn one_sided(bsdf: Bsdf) -> Self {
        Self { bsdf: Some(bsdf), uv: Map::IDENTITY, two_sided: false }
    }

    fn clear(bsdf: Bsdf) -> Self {
        Self { bsdf: Some(bsdf), uv: Map::IDENTITY, two_sided: true }
    }

    /// What stands for a material that is not read: grey, and seen.
    fn stand_in() -> Self {
        let bsdf = Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() };
        Self { bsdf: Some(bsdf), uv: Map::IDENTITY, two_sided: true }
    }
}

/// An affine map of texture coordinates: two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map(pub [[f64; 3]; 2]);

impl Map {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

    /// Where a place goes.
    pub fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let (u, v) = (f64::from(u), f64::from(v));
        self.0.map(|row| (row[0] * u + row[1] * v + row[2]) as f32)
    }

    /// The same for coordinates whose v grows upwards in images; Mitsuba's grow downwards.
    pub fn upright(&self) -> Self {
        let [[a, b, c], [d, e, f]] = self.0;
        Self([[a, -b, c + b], [-d, e, 1.0 - f - e]])
    }
}

/// How deep materials may stand in each other.
const DEPTH: usize = 16;

/// The radius that a GGX distribution takes for the exponent of Phong's lobe, `alpha = sqrt(2 / (n + 2))` (Walter et al. 2007).
fn phong_alpha(exponent: f64) -> f64 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt()
}

/// What plugins refer to: elements by their ids, and the folder of the main file.
pub struct World<'e> {
    /// Elements by their ids.
    pub ids: BTreeMap<&'e str, &'e Element>,
    /// The folder from which paths are meant.
    pub folder: String,
}

impl<'e> World<'e> {
    /// The plugin that a reference stands for; what is wrong is a finding.
    pub fn referred(&self, reference: &Element, reader: &mut Reader<'_>) -> Option<Plugin<'e>> {
        reference.used.set(true);
        let id = reference.word("id");
        match self.ids.get(id) {
            Some(found) => Some(Plugin::new(found)),
            None => {
                let message = format!("there is nothing with the id `{}`", shown(id));
                let help = nearest(id, self.ids.keys().copied()).map(|near| format!("is `{near}` meant?"));
                let finding = crate::diag::Finding::error("unknown-name", reference.span, message);
                reader.add(finding.maybe_help(help));
                None
            }
        }
    }

    /// The file that a parameter names.
    pub fn path(&self, plugin: Plugin<'_>, name: &str, reader: &mut Reader<'_>) -> Option<VPath> {
        let Some(written) = plugin.string(name) else {
            let message = format!("`{}` names no file", shown(plugin.kind()));
            reader.lost(Fate::Dropped, plugin.span(), message);
            return None;
        };
        match VPath::resolve(&self.folder, &written.replace('\\', "/")) {
            Ok(path) => Some(path),
            Err(error) => {
                let message = format!("`{}` is not read: {error}", shown(written));
                let help = "copy the file below the root, or widen it by `--root`";
                reader.lost_with(Fate::Dropped, plugin.span_of(name), message, help);
                None
            }
        }
    }

    /// What a material plugin is.
    pub fn surface(&self, plugin: Plugin<'e>, depth: usize, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        if depth == DEPTH {
            reader.lost(Fate::Dropped, plugin.span(), "a material is left out: materials stand too deep in each other");
            return Made::stand_in();
        }
        let made = self.kind_of(plugin, depth, reader, to);
        plugin.finish(reader);
        made
    }

    /// The materials that stand in one, or that it refers to, in their order.
    fn inner(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>) -> Vec<Plugin<'e>> {
        let children = plugin.element.children.iter();
        let inner = children.filter(|child| child.tag == "bsdf" || child.tag == "ref");
        inner
            .filter_map(
                |child| if child.tag == "ref" { self.referred(child, reader) } else { Some(Plugin::new(child)) },
            )
            .filter(|inner| inner.element.tag == "bsdf")
            .collect()
    }

    fn only_inner(&self, plugin: Plugin<'e>, depth: usize, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        match self.inner(plugin, reader).first() {
            Some(inner) => self.surface(*inner, depth + 1, reader, to),
            None => {
                let message = format!("`{}` holds no material", shown(plugin.kind()));
                reader.lost(Fate::Dropped, plugin.span(), message);
                Made::stand_in()
            }
        }
    }

    fn kind_of(&self, plugin: Plugin<'e>, depth: usize, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        match plugin.kind() {
            "diffuse" | "roughdiffuse" => {
                if plugin.kind() == "roughdiffuse" {
                    let why = "the surface is read as an ideally diffuse one";
                    plugin.drop(Fate::Approximated, &["alpha", "use_fast_approx"], why, reader);
                }
                let (reflectance, uv) = self.paint(plugin, "reflectance", 0.5, reader, to);
                Made { uv, ..Made::one_sided(Bsdf::Diffuse { reflectance }) }
            }
            "conductor" | "roughconductor" => self.conductor(plugin, reader, to),
            "dielectric" | "roughdielectric" | "thindielectric" => self.dielectric(plugin, reader, to),
            "plastic" | "roughplastic" => self.plastic(plugin, reader, to),
            // The next two are names of a renderer that reads Mitsuba's files (slongle/Rainbow, `mirror.cpp` and `glass.cpp`).
            "mirror" => {
                let reflectance = self.tint(plugin, "reflectance", 1.0, reader, to);
                Made { two_sided: true, ..Made::one_sided(Bsdf::Mirror { reflectance }) }
            }
            "glass" => {
                self.untinted(plugin, ["reflectance", "transmission"], reader, to);
                let interior = self.ior(plugin, "int_ior", 1.5, reader);
                let exterior = self.ior(plugin, "ext_ior", 1.0, reader);
                Made::clear(Bsdf::Dielectric { interior, exterior, alpha: 0.0 })
            }
            "phong" => {
                let message = "Phong's lobe is read as a coat of GGX microfacets over a diffuse base";
                reader.lost(Fate::Approximated, plugin.span(), message);
                let exponent = plugin.float_in("exponent", (0.0, 1e9), 30.0, reader);
                self.tint(plugin, "specular_reflectance", 0.2, reader, to);
                let (reflectance, uv) = self.paint(plugin, "diffuse_reflectance", 0.5, reader, to);
                let alpha = phong_alpha(exponent);
                Made { uv, ..Made::one_sided(Bsdf::Plastic { reflectance, ior: 1.5, alpha }) }
            }
            "ward" => {
                let message = "Ward's lobe is read as a coat of GGX microfacets over a diffuse base";
                reader.lost(Fate::Approximated, plugin.span(), message);
                let alpha = self.alpha(plugin, 0.1, reader);
                plugin.pass(&["variant"]);
                self.tint(plugin, "specular_reflectance", 0.2, reader, to);
                let (reflectance, uv) = self.paint(plugin, "diffuse_reflectance", 0.5, reader, to);
                Made { uv, ..Made::one_sided(Bsdf::Plastic { reflectance, ior: 1.5, alpha }) }
            }
            "principled" | "principledthin" => self.principled(plugin, reader, to),
            "twosided" => {
                let inner = self.inner(plugin, reader);
                if inner.len() > 1 {
                    let message = "a surface of two materials has that of its front on both sides";
                    reader.lost(Fate::Dropped, plugin.span(), message);
                }
                Made { two_sided: true, ..self.only_inner(plugin, depth, reader, to) }
            }
            "mask" => {
                let opacity = plugin.color("opacity", Use::Share, reader).map(|color| color.max());
                let texture = opacity.is_none() && plugin.has("opacity");
                let opaque = opacity.unwrap_or(if texture { 1.0 } else { 0.5 });
                if texture || opaque > 0.0 && opaque < 1.0 {
                    let message = "`opacity` of `mask` is left out: a surface is there or it is not";
                    reader.lost(Fate::Dropped, plugin.span_of("opacity"), message);
                }
                let made = self.only_inner(plugin, depth, reader, to);
                if opaque == 0.0 { Made { bsdf: None, ..made } } else { made }
            }
            "bumpmap" | "normalmap" => {
                let what = if plugin.kind() == "bumpmap" { "bump" } else { "normal" };
                reader.lost(Fate::Dropped, plugin.span(), format!("a {what} map is left out: the surface is smooth"));
                plugin.pass(&["normalmap", "arbitrary", "scale", "texture"]);
                plugin.inner("texture").for_each(drop);
                self.only_inner(plugin, depth, reader, to)
            }
            "coating" | "roughcoating" => {
                reader.lost(Fate::Dropped, plugin.span(), "a coating is left out: the surface has its material alone");
                plugin.pass(&["int_ior", "ext_ior", "thickness", "sigma_a", "alpha", "distribution"]);
                plugin.pass(&["specular_reflectance"]);
                self.only_inner(plugin, depth, reader, to)
            }
            "blendbsdf" | "mixturebsdf" => self.blend(plugin, depth, reader, to),
            "null" => Made { bsdf: None, uv: Map::IDENTITY, two_sided: true },
            other => {
                let message = format!("the material `{}` is not read: a grey diffuse surface stands in", shown(other));
                reader.lost(Fate::Dropped, plugin.span(), message);
                // Whatever it holds belongs to it.
                plugin.element.children.iter().for_each(|child| child.used.set(true));
                Made::stand_in()
            }
        }
    }

    /// Of a mixture the material with the largest weight.
    fn blend(&self, plugin: Plugin<'e>, depth: usize, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let parts = self.inner(plugin, reader);
        let message = "of a mixture of materials the one with the largest weight is taken";
        reader.lost(Fate::Dropped, plugin.span(), message);
        let weights: Vec<f64> = if plugin.kind() == "blendbsdf" {
            let weight = plugin.float("weight", reader).unwrap_or(0.5);
            vec![1.0 - weight, weight]
        } else {
            plugin.string("weights").and_then(super::plugin::numbers).unwrap_or_default()
        };
        let weight = |at: usize| weights.get(at).copied().unwrap_or(0.0);
        let heaviest = (0..parts.len()).max_by(|a, b| weight(*a).total_cmp(&weight(*b)).then(b.cmp(a)));
        let made = heaviest.and_then(|at| parts.get(at)).map(|part| self.surface(*part, depth + 1, reader, to));
        plugin.inner("texture").for_each(drop);
        made.unwrap_or_else(Made::stand_in)
    }

    fn conductor(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let alpha = if plugin.kind() == "roughconductor" { self.alpha(plugin, 0.1, reader) } else { 0.0 };
        let tint = self.tint(plugin, "specular_reflectance", 1.0, reader, to);
        let outside = self.ior(plugin, "ext_eta", 1.0, reader);
        let named = plugin.string("material");
        if named.is_some_and(|name| name.eq_ignore_ascii_case("none")) {
            if alpha == 0.0 {
                return Made::one_sided(Bsdf::Mirror { reflectance: tint });
            }
            let message = "a rough mirror without a Fresnel term is read as silver";
            reader.lost(Fate::Approximated, plugin.span(), message);
        }
        if !tint.is_grey() || tint.max() != 1.0 {
            let message =
                "`specular_reflectance` of a conductor is left out: it follows from its indices of refraction";
            reader.lost(Fate::Dropped, plugin.span_of("specular_reflectance"), message);
        }
        let given = plugin.color("eta", Use::Index, reader).zip(plugin.color("k", Use::Index, reader));
        let (eta, k) = given.unwrap_or_else(|| {
            let name = match named {
                Some("none") => "Ag",
                Some(name) => name,
                // Mitsuba's default.
                None => "Cu",
            };
            let found = metals::metal(name).or_else(|| {
                let help = nearest(name, metals::metals()).map(|near| format!("is `{near}` meant?"));
                let message = format!("the metal `{}` is not known: copper stands in", shown(name));
                reader.lost_with(Fate::Dropped, plugin.span(), message, help.as_deref().unwrap_or_default());
                metals::metal("Cu")
            });
            let (eta, k) = found.unwrap_or(([1.0; 3], [1.0; 3]));
            (Color::Rgb(eta), Color::Rgb(k))
        });
        let scaled = |color: Color| if outside == 1.0 { color } else { Color::Rgb(color.rgb().map(|x| x / outside)) };
        let (eta, k) = (scaled(eta), scaled(k));
        if eta.min() <= 0.0 {
            let message = "a conductor whose index of refraction is 0 is read as one of 0.001";
            reader.lost(Fate::Approximated, plugin.span(), message);
        }
        let eta = if eta.min() <= 0.0 { Color::Rgb(eta.rgb().map(|x| x.max(1e-3))) } else { eta };
        Made::one_sided(Bsdf::Conductor { eta, k, alpha })
    }

    fn dielectric(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let alpha = if plugin.kind() == "roughdielectric" { self.alpha(plugin, 0.1, reader) } else { 0.0 };
        let interior = self.ior(plugin, "int_ior", 1.5046, reader);
        let exterior = self.ior(plugin, "ext_ior", 1.000277, reader);
        self.untinted(plugin, ["specular_reflectance", "specular_transmittance"], reader, to);
        if plugin.kind() == "thindielectric" {
            let message = "a thin dielectric is read as nothing: light passes it straight, none is reflected";
            reader.lost(Fate::Approximated, plugin.span(), message);
            return Made { bsdf: None, uv: Map::IDENTITY, two_sided: true };
        }
        Made::clear(Bsdf::Dielectric { interior, exterior, alpha })
    }

    /// Says that factors of a dielectric which are not 1 are left out.
    fn untinted(&self, plugin: Plugin<'e>, names: [&str; 2], reader: &mut Reader<'_>, to: &mut Builder) {
        for name in names {
            let tint = self.tint(plugin, name, 1.0, reader, to);
            if !tint.is_grey() || tint.max() != 1.0 {
                let message = format!("`{name}` of a dielectric is left out: it is clear");
                reader.lost(Fate::Dropped, plugin.span_of(name), message);
            }
        }
    }

    fn plastic(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let alpha = if plugin.kind() == "roughplastic" { self.alpha(plugin, 0.1, reader) } else { 0.0 };
        let interior = self.ior(plugin, "int_ior", 1.49, reader);
        let exterior = self.ior(plugin, "ext_ior", 1.000277, reader);
        let ior = (interior / exterior).max(1.0001);
        let tint = self.tint(plugin, "specular_reflectance", 1.0, reader, to);
        if !tint.is_grey() || tint.max() != 1.0 {
            let message = "`specular_reflectance` of a plastic is left out: its coat is clear";
            reader.lost(Fate::Dropped, plugin.span_of("specular_reflectance"), message);
        }
        let nonlinear = plugin.boolean("nonlinear", reader).unwrap_or(false);
        let (base, uv) = self.paint(plugin, "diffuse_reflectance", 0.5, reader, to);
        // Without `nonlinear` the light that the coat throws back does not take the base's color again: the base of which as much is seen.
        let coat = Coat::new(ior);
        let reflectance = match base {
            ColorOrTexture::Color(color) if !nonlinear => {
                ColorOrTexture::Color(Color::Rgb(color.rgb().map(|share| coat.base(share))))
            }
            ColorOrTexture::Texture(_) if !nonlinear => {
                let message = "a plastic with a texture and without `nonlinear` is read as one with it: it is darker, \
                               more so where it is bright";
                reader.lost(Fate::Approximated, plugin.span(), message);
                base
            }
            other @ (ColorOrTexture::Color(_) | ColorOrTexture::Texture(_)) => other,
        };
        Made { uv, ..Made::one_sided(Bsdf::Plastic { reflectance, ior, alpha }) }
    }

    fn principled(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Made {
        let (base, uv) = self.paint(plugin, "base_color", 0.5, reader, to);
        let metallic = plugin.float_in("metallic", (0.0, 1.0), 0.0, reader);
        let roughness = plugin.float_in("roughness", (0.0, 1.0), 0.5, reader);
        let ior = match (plugin.float("eta", reader), plugin.float("specular", reader)) {
            (Some(eta), _) => eta,
            (None, Some(specular)) => {
                let root = (0.08 * specular.clamp(0.0, 1.0)).sqrt();
                (1.0 + root) / (1.0 - root)
            }
            (None, None) => 1.5,
        };
        let ior = ior.clamp(1.0001, 10.0);
        let others = [
            "anisotropic",
            "spec_tint",
            "spec_trans",
            "sheen",
            "sheen_tint",
            "clearcoat",
            "clearcoat_gloss",
            "flatness",
            "diff_trans",
        ];
        for name in others {
            // The gloss of a coat that is not there means nothing.
            let counts = !matches!(name, "clearcoat_gloss" | "sheen_tint");
            if plugin.has(name) && plugin.float(name, reader).is_none_or(|value| value != 0.0) && counts {
                let message = format!("`{name}` of `principled` is left out");
                reader.lost(Fate::Dropped, plugin.span_of(name), message);
            }
        }
        plugin.pass(&["diffuse_reflectance_sampling_rate", "specular_reflectance_sampling_rate", "eta", "specular"]);
        if plugin.kind() == "principledthin" {
            reader.lost(Fate::Dropped, plugin.span(), "a thin principled surface lets no light through");
        }
        Made { uv, ..Made::one_sided(Bsdf::Principled { base, metallic, roughness, ior }) }
    }

    /// The width of the microfacets' distribution.
    fn alpha(&self, plugin: Plugin<'_>, default: f64, reader: &mut Reader<'_>) -> f64 {
        let kind = plugin.string("distribution").unwrap_or("beckmann");
        if !kind.eq_ignore_ascii_case("ggx") && plugin.kind() != "ward" {
            let message = format!(
                "the distribution `{}` is read as GGX of the same width, whose highlights have longer tails",
                shown(kind)
            );
            reader.lost(Fate::Approximated, plugin.span(), message);
        }
        plugin.pass(&["sample_visible", "nonlinear"]);
        if plugin.has("alpha_u") || plugin.has("alpha_v") {
            let (u, v) = (plugin.float("alpha_u", reader), plugin.float("alpha_v", reader));
            let (u, v) = (u.or(v).unwrap_or(default), v.or(u).unwrap_or(default));
            if u != v {
                let message = "an anisotropic surface is read as an isotropic one of the mean width";
                reader.lost(Fate::Approximated, plugin.span_of("alpha_u"), message);
            }
            return (u * v).max(0.0).sqrt();
        }
        if plugin.find("alpha").is_some_and(|found| found.tag == "texture" || found.tag == "ref") {
            let message = "a texture of `alpha` is left out: the width is 0.1 everywhere";
            reader.lost(Fate::Dropped, plugin.span_of("alpha"), message);
            return 0.1;
        }
        plugin.float_in("alpha", (0.0, 1.0), default, reader)
    }

    /// An index of refraction, as a number or by the name of a material.
    fn ior(&self, plugin: Plugin<'_>, name: &str, default: f64, reader: &mut Reader<'_>) -> f64 {
        let Some(found) = plugin.find(name) else { return default };
        if found.tag == "string" {
            let word = found.word("value").trim();
            return metals::clear(word).unwrap_or_else(|| {
                let message = format!(
                    "the material `{}` is not known: its index of refraction is taken for {default}",
                    shown(word)
                );
                reader.lost(Fate::Dropped, found.span, message);
                default
            });
        }
        plugin.float(name, reader).filter(|ior| *ior > 0.0 && *ior <= 100.0).unwrap_or(default)
    }

    /// A color that cannot be a texture here.
    fn tint(&self, plugin: Plugin<'e>, name: &str, default: f64, reader: &mut Reader<'_>, to: &mut Builder) -> Color {
        match self.paint(plugin, name, default, reader, to).0 {
            ColorOrTexture::Color(color) => color,
            ColorOrTexture::Texture(_) => {
                let message = format!("a texture of `{name}` is left out");
                reader.lost(Fate::Dropped, plugin.span_of(name), message);
                Color::Grey(default)
            }
        }
    }

    /// A color or a texture, with the map of its coordinates.
    pub fn paint(
        &self,
        plugin: Plugin<'e>,
        name: &str,
        default: f64,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> (ColorOrTexture, Map) {
        let grey = (Color::Grey(default).into(), Map::IDENTITY);
        let Some(found) = plugin.find(name) else { return grey };
        let texture = match found.tag.as_str() {
            "texture" => Plugin::new(found),
            "ref" => match self.referred(found, reader) {
                Some(texture) if texture.element.tag == "texture" => texture,
                Some(other) => {
                    let message = format!("`{name}` refers to a `{}`, not to a texture", shown(&other.element.tag));
                    reader.lost(Fate::Dropped, found.span, message);
                    return grey;
                }
                None => return grey,
            },
            _ => return (plugin.color(name, Use::Share, reader).map_or(grey.0, ColorOrTexture::from), Map::IDENTITY),
        };
        self.texture(texture, reader, to).unwrap_or(grey)
    }

    fn texture(&self, plugin: Plugin<'e>, reader: &mut Reader<'_>, to: &mut Builder) -> Option<(ColorOrTexture, Map)> {
        let made = match plugin.kind() {
            "bitmap" => self.bitmap(plugin, reader, to).map(|(handle, map)| (ColorOrTexture::Texture(handle), map)),
            "checkerboard" => {
                let of = |name: &str, default: f64, reader: &mut Reader<'_>| {
                    plugin.color(name, Use::Share, reader).map_or([default; 3], |color| color.rgb())
                };
                let colors = [of("color0", 0.4, reader), of("color1", 0.2, reader)];
                let map = self.uv_map(plugin, reader);
                let at = Origin::from(plugin.span());
                to.checkerboard(reader, colors, &at).map(|handle| (ColorOrTexture::Texture(handle), map))
            }
            "rgb" | "srgb" | "uniform" => plugin
                .color("color", Use::Share, reader)
                .or_else(|| plugin.color("value", Use::Share, reader))
                .map(|color| (ColorOrTexture::Color(color), Map::IDENTITY)),
            other => {
                let message = format!("the texture `{}` is not read: a grey of 0.5 stands in", shown(other));
                reader.lost(Fate::Dropped, plugin.span(), message);
                plugin.element.children.iter().for_each(|child| child.used.set(true));
                Some((Color::Grey(0.5).into(), Map::IDENTITY))
            }
        };
        plugin.finish(reader);
        made
    }

    /// An image, with the map of its coordinates.
    pub fn bitmap(
        &self,
        plugin: Plugin<'e>,
        reader: &mut Reader<'_>,
        to: &mut Builder,
    ) -> Option<(Handle<Texture>, Map)> {
        let path = self.path(plugin, "filename", reader)?;
        let map = self.uv_map(plugin, reader);
        let raw = plugin.boolean("raw", reader).unwrap_or(false);
        let encoding = match plugin.float("gamma", reader) {
            Some(1.0) => Encoding::Linear,
            Some(gamma) if gamma > 0.0 => {
                let message = format!("an image with a gamma of {gamma} is read by the sRGB curve");
                reader.lost(Fate::Approximated, plugin.span_of("gamma"), message);
                Encoding::Srgb
            }
            _ if raw => Encoding::Linear,
            _ => Encoding::Srgb,
        };
        for name in ["wrap_mode", "wrap_mode_u", "wrap_mode_v"] {
            if plugin.string(name).is_some_and(|mode| mode != "repeat") {
                reader.lost(Fate::Dropped, plugin.span_of(name), format!("`{name}` is left out: images repeat"));
            }
        }
        if plugin.string("filter_type").is_some_and(|kind| kind == "nearest") {
            let message = "an image without interpolation between its pixels is interpolated";
            reader.lost(Fate::Approximated, plugin.span_of("filter_type"), message);
        }
        plugin.pass(&["max_anisotropy", "cache", "format", "accel"]);
        plugin.drop(Fate::Dropped, &["channel"], "all channels of an image are used", reader);
        let at = Origin::from(plugin.span());
        to.texture(reader, &path, Some(encoding), [1.0; 3], &at).map(|handle| (handle, map))
    }

    /// From a shape's texture coordinates to those of an image.
    fn uv_map(&self, plugin: Plugin<'_>, reader: &mut Reader<'_>) -> Map {
        let rows = plugin.transform("to_uv", reader).rows;
        let [[a, b, _, c], [d, e, _, f], _] = rows;
        let of = |name: &str, default: f64, reader: &mut Reader<'_>| plugin.float(name, reader).unwrap_or(default);
        let all = of("uvscale", 1.0, reader);
        let (u, v) = (of("uscale", all, reader), of("vscale", all, reader));
        let (du, dv) = (of("uoffset", 0.0, reader), of("voffset", 0.0, reader));
        Map([[a * u, b * u, c * u + du], [d * v, e * v, f * v + dv]])
    }
}
