//! Materials, emission and colors.

use std::rc::Rc;

use crate::ir::{Bsdf, Color, ColorOrTexture, Meaning, Sides, Spectrum};

use super::super::value::{EmissionValue, MaterialValue, Ty, Value};
use super::meshes::points;
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
            let eta = positive(args, "eta", false)?.meant(Meaning::Index);
            let k = positive(args, "k", true)?.meant(Meaning::Index);
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
        family: Family::Material,
        name: "plastic",
        summary: "A Lambertian base under a clear coat, the same on both sides; no two renderers have the same one.",
        params: &[
            Parameter {
                name: "reflectance",
                ty: Ty::ColorOrTexture,
                default: None,
                doc: "share of light that the base reflects, 0..1; seen through the coat it is darker",
            },
            Parameter {
                name: "ior",
                ty: Ty::Number,
                default: Some("1.5"),
                doc: "index of refraction of the coat, > 1",
            },
            Parameter {
                name: "alpha",
                ty: Ty::Number,
                default: Some("0"),
                doc: "GGX width of the coat, 0..1; 0 is smooth",
            },
        ],
        positional: 1,
        example: "material porcelain = plastic(rgb(0.9, 0.88, 0.85), ior: 1.5, alpha: 0.05)",
        build: |args, site| {
            let reflectance = paint(args, "reflectance")?;
            material(site, Bsdf::Plastic { reflectance, ior: coat(args)?, alpha: alpha(args)? })
        },
    },
    Constructor {
        family: Family::Material,
        name: "principled",
        summary: "A blend of a coated base and a metal after Burley (2012), the same on both sides; no two renderers have the same one.",
        params: &[
            Parameter {
                name: "base",
                ty: Ty::ColorOrTexture,
                default: None,
                doc: "color of the base, and of the metal head-on, 0..1",
            },
            Parameter { name: "metallic", ty: Ty::Number, default: Some("0"), doc: "from 0 (none) to 1 (metal only)" },
            Parameter { name: "roughness", ty: Ty::Number, default: Some("0.5"), doc: "root of the GGX width, 0..1" },
            Parameter {
                name: "ior",
                ty: Ty::Number,
                default: Some("1.5"),
                doc: "index of refraction of the coat, > 1",
            },
        ],
        positional: 1,
        example: "material paint = principled(rgb(0.1, 0.2, 0.6), metallic: 0.3, roughness: 0.4)",
        build: |args, site| {
            let base = paint(args, "base")?;
            let (metallic, roughness) = (unit(args, "metallic", 0.0)?, unit(args, "roughness", 0.5)?);
            material(site, Bsdf::Principled { base, metallic, roughness, ior: coat(args)? })
        },
    },
    Constructor {
        family: Family::Material,
        name: "one_sided",
        summary: "A material that scatters light on the side of the normals only: from behind the surface is black.",
        params: &[Parameter {
            name: "material",
            ty: Ty::Material,
            default: None,
            doc: "what the front is made of; no dielectric, which has no sides",
        }],
        positional: 1,
        example: "material paper = one_sided(diffuse(0.8))",
        build: |args, site| {
            let Some(Value::Material(front)) = args.get("material") else {
                return material(site, Bsdf::Diffuse { reflectance: Color::BLACK.into() });
            };
            if front.bsdf.is_clear() {
                return Err(Problem::new("material", "a dielectric has no sides: light goes through it"));
            }
            let front = MaterialValue { name: None, sides: Sides::Front, span: site.span, ..(**front).clone() };
            Ok(Value::Material(Rc::new(front)))
        },
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
            Ok(Value::Emission(Rc::new(EmissionValue {
                radiance: positive(args, "value", true)?.meant(Meaning::Light),
                over,
            })))
        },
    },
    Constructor {
        family: Family::Color,
        name: "rgb",
        summary: "A linear color with sRGB primaries.",
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
        summary: "A color as screens write it: decoded from the sRGB curve (IEC 61966-2-1) to linear values.",
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
                Problem::new("hex", "a screen color has six hexadecimal digits")
                    .help("write for example `srgb(\"#e1c657\")`")
            })?;
            Ok(Value::Color(Color::Rgb([16, 8, 0].map(|shift| decode((code >> shift & 0xff) as u8)))))
        },
    },
    Constructor {
        family: Family::Color,
        name: "spectrum",
        summary: "Values at wavelengths, linear between them and constant beyond; RGB targets get the color of it.",
        params: &[Parameter {
            name: "values",
            ty: Ty::Points2,
            default: None,
            doc: "pairs (wavelength in nm, value), the wavelengths growing",
        }],
        positional: 1,
        example: "let moss = spectrum([(400, 0.05), (550, 0.3), (700, 0.1)])",
        build: spectrum,
    },
];

/// Values at wavelengths: finite, in order, the first at least a nanometer above 0.
fn spectrum(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    site.hold(size_of::<[f64; 2]>() * args.list("values").map_or(0, <[Value]>::len))?;
    let points: Vec<(f64, f64)> = points::<2>(args, "values")
        .unwrap_or_default()
        .into_iter()
        .map(|[wavelength, value]| (wavelength, value))
        .collect();
    let wrong = |message: String| {
        Err(Problem::new("values", message)
            .help("write for example `spectrum([(400, 0.1), (700, 0.6)])`, in nanometers"))
    };
    if points.len() < 2 {
        return wrong("a spectrum has values at two wavelengths or more".to_owned());
    }
    if let Some((wavelength, _)) = points.iter().find(|(wavelength, _)| !(1.0..=1e6).contains(wavelength)) {
        return wrong(format!("`{wavelength}` nm is no wavelength between 1 and 1000000"));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        return wrong(format!("the wavelength {} stands behind {}: they must grow", pair[1].0, pair[0].0));
    }
    if points.iter().all(|(wavelength, _)| *wavelength < 20.0) {
        return wrong("these wavelengths are below 20 nm: micrometers?".to_owned());
    }
    Ok(Value::Color(Color::Spectrum(Spectrum::new(&points, Meaning::Share))))
}

/// The sRGB transfer function of IEC 61966-2-1.
fn decode(code: u8) -> f64 {
    let value = f64::from(code) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

fn material(site: &Site<'_>, bsdf: Bsdf) -> Result<Value, Problem> {
    Ok(Value::Material(Rc::new(MaterialValue { name: None, bsdf, sides: Sides::Both, span: site.span })))
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

/// The index of refraction of a coat.
fn coat(args: &Args) -> Result<f64, Problem> {
    let ior = args.number("ior").unwrap_or(1.5);
    if ior > 1.0 {
        return Ok(ior);
    }
    Err(Problem::new("ior", format!("`ior` is {ior}, it must be greater than 1"))
        .note("it is that of the coat against the vacuum around it"))
}

/// A number between 0 and 1.
fn unit(args: &Args, name: &'static str, default: f64) -> Result<f64, Problem> {
    let value = args.number(name).unwrap_or(default);
    if (0.0..=1.0).contains(&value) {
        return Ok(value);
    }
    Err(Problem::new(name, format!("`{name}` is {value}, it must be between 0 and 1")))
}

fn alpha(args: &Args) -> Result<f64, Problem> {
    let alpha = args.number("alpha").unwrap_or(0.0);
    if (0.0..=1.0).contains(&alpha) {
        return Ok(alpha);
    }
    Err(Problem::new("alpha", format!("`alpha` is {alpha}, it must be between 0 and 1"))
        .note("`alpha` is the width of the GGX distribution, not its root and not an angle"))
}
