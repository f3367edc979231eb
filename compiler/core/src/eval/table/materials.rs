//! Materials, emission and colours.

use std::rc::Rc;

use crate::ir::{Bsdf, Color, ColorOrTexture};

use super::super::value::{EmissionValue, MaterialValue, Ty, Value};
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Material,
        name: "diffuse",
        summary: "Lambertian reflection, the same on both sides.",
        params: &[Parameter {
            name: "reflectance",
            ty: Ty::ColorOrTexture,
            default: None,
            doc: "share of light reflected, 0..1",
        }],
        positional: 1,
        example: "material ochre = diffuse(rgb(0.882, 0.776, 0.341))",
        build: |args, site| material(site, Bsdf::Diffuse { reflectance: paint(args, "reflectance")? }),
    },
    Constructor {
        family: Family::Material,
        name: "conductor",
        summary: "Metal: GGX microfacets with the Fresnel term of a complex index of refraction, the same on both sides.",
        params: &[
            Parameter { name: "eta", ty: Ty::Color, default: None, doc: "real part of the index of refraction, > 0" },
            Parameter { name: "k", ty: Ty::Color, default: None, doc: "imaginary part (extinction), >= 0" },
            Parameter {
                name: "alpha",
                ty: Ty::Number,
                default: None,
                doc: "GGX width, 0..1; 0 is smooth, portable from 0.01 on",
            },
        ],
        positional: 0,
        example: "material copper = conductor(\n    eta: rgb(0.200438, 0.924033, 1.102212),\n    k: rgb(3.912949, 2.452848, 2.142188),\n    alpha: 0.0625,\n)",
        build: |args, site| {
            let eta = positive(args, "eta", false)?;
            let k = positive(args, "k", true)?;
            material(site, Bsdf::Conductor { eta, k, alpha: alpha(args)? })
        },
    },
    Constructor {
        family: Family::Material,
        name: "dielectric",
        summary: "Clear glass or water: reflects and refracts, absorbs nothing.",
        params: &[
            Parameter {
                name: "ior",
                ty: Ty::Number,
                default: None,
                doc: "index of refraction inside, behind the normals",
            },
            Parameter { name: "outside", ty: Ty::Number, default: Some("1"), doc: "index of refraction outside" },
            Parameter { name: "alpha", ty: Ty::Number, default: Some("0"), doc: "GGX width, 0..1; 0 is smooth" },
        ],
        positional: 0,
        example: "material water = dielectric(ior: 1.33)",
        build: |args, site| {
            let index = |name: &'static str, default: f64| {
                let value = args.number(name).unwrap_or(default);
                if value > 0.0 {
                    Ok(value)
                } else {
                    Err(Problem::new(name, format!("`{name}` must be greater than 0")))
                }
            };
            let (interior, exterior) = (index("ior", 1.5)?, index("outside", 1.0)?);
            material(site, Bsdf::Dielectric { interior, exterior, alpha: alpha(args)? })
        },
    },
    Constructor {
        family: Family::Material,
        name: "mirror",
        summary: "Ideal specular reflection without a Fresnel term, the same on both sides.",
        params: &[Parameter {
            name: "reflectance",
            ty: Ty::Color,
            default: Some("1"),
            doc: "share of light reflected, 0..1",
        }],
        positional: 1,
        example: "material silver = mirror(0.95)",
        build: |args, site| material(site, Bsdf::Mirror { reflectance: share(args, "reflectance")? }),
    },
    Constructor {
        family: Family::Emission,
        name: "radiance",
        summary: "Diffuse emission along the normals, the same over the whole surface.",
        params: &[
            Parameter { name: "value", ty: Ty::Color, default: None, doc: "radiance in W/(m2 sr), >= 0" },
            Parameter {
                name: "over",
                ty: Ty::Material,
                default: Some("diffuse(0)"),
                doc: "the material of the emitting surface",
            },
        ],
        positional: 1,
        example: "emitter lamp = rectangle(x: -10..10, y: -10..10, z: 99, normal: -Z) with radiance(30)",
        build: |args, _| {
            let over = match args.get("over") {
                Some(Value::Material(material)) => Some(Rc::clone(material)),
                _ => None,
            };
            Ok(Value::Emission(Rc::new(EmissionValue { radiance: positive(args, "value", true)?, over })))
        },
    },
    Constructor {
        family: Family::Color,
        name: "rgb",
        summary: "A linear colour with sRGB primaries.",
        params: &[
            Parameter { name: "r", ty: Ty::Number, default: None, doc: "red" },
            Parameter { name: "g", ty: Ty::Number, default: None, doc: "green" },
            Parameter { name: "b", ty: Ty::Number, default: None, doc: "blue" },
        ],
        positional: 3,
        example: "let red = rgb(0.529, 0.024, 0.024)",
        build: |args, _| {
            let part = |name| args.number(name).unwrap_or(0.0);
            Ok(Value::Color(Color::Rgb([part("r"), part("g"), part("b")])))
        },
    },
    Constructor {
        family: Family::Color,
        name: "srgb",
        summary: "A colour as screens write it: decoded from the sRGB curve (IEC 61966-2-1) to linear values.",
        params: &[Parameter { name: "hex", ty: Ty::String, default: None, doc: "`#rrggbb`" }],
        positional: 1,
        example: "let ochre = srgb(\"#e1c657\")",
        build: |args, _| {
            let text = match args.get("hex") {
                Some(Value::String(text)) => text.to_string(),
                _ => String::new(),
            };
            let digits = text.strip_prefix('#').filter(|rest| rest.len() == 6);
            let code = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).ok_or_else(|| {
                Problem::new("hex", "a screen colour has six hexadecimal digits")
                    .help("write for example `srgb(\"#e1c657\")`")
            })?;
            Ok(Value::Color(Color::Rgb([16, 8, 0].map(|shift| decode((code >> shift & 0xff) as u8)))))
        },
    },
];

/// The sRGB transfer function of IEC 61966-2-1.
fn decode(code: u8) -> f64 {
    let value = f64::from(code) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

fn material(site: &Site<'_>, bsdf: Bsdf) -> Result<Value, Problem> {
    Ok(Value::Material(Rc::new(MaterialValue { name: None, bsdf, span: site.span })))
}

/// A reflectance: from 0 on; more than 1 is left to a finding of its own, since the scene is still meaningful.
fn share(args: &Args, name: &'static str) -> Result<Color, Problem> {
    positive(args, name, true)
}

/// A reflectance, or the texture that says it.
fn paint(args: &Args, name: &'static str) -> Result<ColorOrTexture, Problem> {
    match args.color_or_texture(name) {
        Some(ColorOrTexture::Texture(texture)) => Ok(ColorOrTexture::Texture(texture)),
        Some(ColorOrTexture::Color(color)) => at_least(color, name, true).map(ColorOrTexture::Color),
        None => Ok(ColorOrTexture::Color(Color::Grey(1.0))),
    }
}

fn positive(args: &Args, name: &'static str, zero: bool) -> Result<Color, Problem> {
    at_least(args.color(name).unwrap_or(Color::Grey(1.0)), name, zero)
}

fn at_least(color: Color, name: &'static str, zero: bool) -> Result<Color, Problem> {
    let good = if zero { color.min() >= 0.0 } else { color.min() > 0.0 };
    if good {
        return Ok(color);
    }
    let least = if zero { "at least 0" } else { "greater than 0" };
    Err(Problem::new(name, format!("`{name}` must be {least} in every channel")))
}

fn alpha(args: &Args) -> Result<f64, Problem> {
    let alpha = args.number("alpha").unwrap_or(0.0);
    if (0.0..=1.0).contains(&alpha) {
        return Ok(alpha);
    }
    Err(Problem::new("alpha", format!("`alpha` is {alpha}, it must be between 0 and 1"))
        .note("`alpha` is the width of the GGX distribution, not its root and not an angle"))
}
