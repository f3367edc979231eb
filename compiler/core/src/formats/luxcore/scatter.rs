//! What LuxCore's materials and textures mean.

use super::properties::{Said, Thing, Things};
use super::{fresnel, names};
use crate::formats::shared::reading::{Emitted, Fresnel, Inside, Model, Paint, Rgb};
use crate::formats::shared::source::{LIMIT, REFERENCE, SYNTAX, UNKNOWN, shown};

/// How deep textures may refer to each other.
const DEPTH: usize = 8;

/// The largest reflectance head-on of `disney` (`disney.cpp`).
const DISNEY: f64 = 0.08;

/// The model of a material; black where it is not understood, so that what refers to it is not a second finding.
pub fn model(thing: &Thing<'_>, textures: &Things<'_>, to: &mut Said<'_, '_, '_>) -> Model {
    let kind = thing.string("type", to).unwrap_or_default();
    let white = |name: &str, to: &mut Said<'_, '_, '_>| thing.expect(name, "1 1 1", to);
    match kind {
        "matte" => Model::Diffuse { reflectance: paint(thing, "kd", textures, to) },
        "metal2" => {
            let alpha = alpha(thing, to);
            let name = thing.string("fresnel", to).unwrap_or_default();
            let found = textures.find(name).and_then(|texture| {
                texture.expect("type", "\"fresnelconst\"", to);
                let (n, k) = (texture.rgb("n", to), texture.rgb("k", to));
                n.zip(k)
            });
            match found {
                Some((n, k)) => {
                    let most = |eta, k| fresnel::fit(eta, k).most;
                    let fresnel = Fresnel::Fitted { n, k, term: fresnel::approximate, most };
                    Model::Conductor { fresnel, tint: Paint::WHITE, alpha }
                }
                None => {
                    let message = format!("`{}` is no texture with `n` and `k`", shown(name));
                    to.say(REFERENCE, thing.place("fresnel"), message);
                    Model::Diffuse { reflectance: Paint::BLACK }
                }
            }
        }
        "glass" | "roughglass" => {
            white("kr", to);
            white("kt", to);
            let inside = thing.float("interiorior", to).unwrap_or(1.5);
            let outside = thing.float("exteriorior", to).unwrap_or(1.0);
            let alpha = if kind == "roughglass" { alpha(thing, to) } else { 0.0 };
            Model::Dielectric { eta: inside / outside, alpha }
        }
        "mirror" => {
            let tint = paint(thing, "kr", textures, to);
            Model::Conductor { fresnel: Fresnel::Constant, tint, alpha: 0.0 }
        }
        "glossy2" => {
            let base = paint(thing, "kd", textures, to);
            let specular = thing.rgb("ks", to).unwrap_or([0.5; 3]);
            thing.demand("multibounce", "0", to);
            // The reflectance head-on is ((n - 1) / (n + 1))^2.
            let root = specular[0].max(0.0).sqrt();
            if specular != [specular[0]; 3] || root >= 1.0 {
                to.say(SYNTAX, thing.place("ks"), "`ks` is not that of a clear coat");
            }
            let ior = if root < 1.0 { (1.0 + root) / (1.0 - root) } else { 1.0 };
            Model::Coated { base, inside: Inside::Seen, ior, alpha: alpha(thing, to) }
        }
        "disney" => {
            let base = paint(thing, "basecolor", textures, to);
            let metallic = thing.float("metallic", to).unwrap_or(0.0);
            let roughness = thing.float("roughness", to).unwrap_or(0.0);
            let specular = DISNEY * thing.float("specular", to).unwrap_or(0.0);
            for name in
                ["speculartint", "subsurface", "sheen", "sheentint", "clearcoat", "clearcoatgloss", "anisotropic"]
            {
                thing.expect(name, "0", to);
            }
            Model::Principled { base, metallic, alpha: roughness * roughness, specular, ceiling: DISNEY }
        }
        other => {
            to.say(UNKNOWN, thing.place("type"), format!("there is no material `{}`", shown(other)));
            Model::Diffuse { reflectance: Paint::BLACK }
        }
    }
}

/// Where the front and the back of a material of two stand among all.
pub fn sides(thing: &Thing<'_>, materials: &Things<'_>, to: &mut Said<'_, '_, '_>) -> Option<[usize; 2]> {
    let mut side = |name: &str| {
        let id = thing.string(name, to)?;
        let found = materials.place(id);
        if found.is_none() {
            to.say(REFERENCE, thing.place(name), format!("there is no material `{}`", shown(id)));
        }
        found
    };
    let (front, back) = (side("frontmaterial"), side("backmaterial"));
    front.zip(back).map(|(front, back)| [front, back])
}

/// What a material emits. LuxCore makes emission part of the material.
pub fn emission(thing: &Thing<'_>, to: &mut Said<'_, '_, '_>) -> Option<Emitted> {
    let color = thing.rgb("emission", to)?;
    let gain = thing.rgb("emission.gain", to).unwrap_or([1.0; 3]);
    // With a power or an efficiency the radiance would be rescaled; with another angle it would not be diffuse. The default of
    // the last leaves large meshes to chance.
    thing.demand("emission.power", "0", to);
    thing.demand("emission.efficiency", "0", to);
    thing.demand("emission.theta", "90", to);
    thing.demand("emission.directlightsampling.type", "\"ENABLED\"", to);
    let radiance = [0, 1, 2].map(|channel| color[channel] * gain[channel]);
    Some(Emitted { radiance, both_sides: false, reversed: false })
}

/// The GGX width (measured with 2.11.2); equal along u and v.
fn alpha(thing: &Thing<'_>, to: &mut Said<'_, '_, '_>) -> f64 {
    let [u, v] = ["uroughness", "vroughness"].map(|name| thing.float(name, to).unwrap_or(0.1));
    if u != v {
        to.say(SYNTAX, thing.at, "roughness that differs along u and v is not read");
    }
    u
}

fn paint(thing: &Thing<'_>, name: &str, textures: &Things<'_>, to: &mut Said<'_, '_, '_>) -> Paint {
    match thing.reference(name) {
        Some(id) => texture(id, thing.place(name), textures, 0, to).unwrap_or(Paint::BLACK),
        None => Paint::Color(thing.rgb(name, to).unwrap_or_else(|| {
            to.say(SYNTAX, thing.at, format!("`{name}` is missing or no color"));
            [0.0; 3]
        })),
    }
}

fn texture(id: &str, at: usize, textures: &Things<'_>, depth: usize, to: &mut Said<'_, '_, '_>) -> Option<Paint> {
    if depth > DEPTH {
        to.say(LIMIT, at, "textures refer to each other too deeply");
        return None;
    }
    let Some(thing) = textures.find(id) else {
        to.say(REFERENCE, at, format!("there is no texture `{}`", shown(id)));
        return None;
    };
    match thing.string("type", to).unwrap_or_default() {
        "imagemap" => image(thing, to),
        "scale" => {
            let factor: Rgb = thing.rgb("texture2", to)?;
            let inner = thing.string("texture1", to)?;
            Some(texture(inner, thing.place("texture1"), textures, depth + 1, to)?.scaled(factor))
        }
        other => {
            to.say(UNKNOWN, thing.place("type"), format!("there is no texture `{}`", shown(other)));
            None
        }
    }
}

fn image(thing: &Thing<'_>, to: &mut Said<'_, '_, '_>) -> Option<Paint> {
    let name = thing.string("file", to)?;
    let text = to.text;
    let at = thing.place("file");
    let file = to.source.path(text.path, name, || text.origin(at))?;
    let linear = thing.reference("colorspace").is_none();
    if linear {
        thing.demand("gamma", "1", to);
    } else {
        thing.expect("colorspace", "\"opencolorio\"", to);
        thing.demand("colorspace.config", &format!("\"{}\"", names::SRGB_FILE), to);
        thing.demand("colorspace.name", "\"srgb\"", to);
    }
    thing.expect("storage", "\"float\"", to);
    thing.expect("wrap", "\"repeat\"", to);
    // LuxCore's v grows downwards in the image (measured with 2.11.2).
    thing.expect("mapping.type", "\"uvmapping2d\"", to);
    thing.demand("mapping.uvscale", "1 -1", to);
    thing.demand("mapping.uvdelta", "0 1", to);
    Some(Paint::Image { file: file.into(), linear, factor: [1.0; 3] })
}
