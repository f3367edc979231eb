//! Lights without a surface. They stand behind `emitter` without `with`.

use std::rc::Rc;

use crate::ir::{Affine, Color, ColorOrTexture, LightKind, Meaning, Spectrum, normalized};

use super::super::value::{Ty, Value};
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Light,
        name: "environment",
        summary: "Light from everywhere around the scene, the same from all directions or by an image; at most one in a scene.",
        params: &[
            Parameter {
                name: "radiance",
                ty: Ty::ColorOrTexture,
                default: None,
                doc: "radiance in W/(m2 sr), >= 0; an image of floats holds all directions, +z above, +y in its middle and +x to the right of that; \
                      `|> rotate(...)` turns it",
            },
            Parameter { name: "scale", ty: Ty::Number, default: Some("1"), doc: "a factor of it, >= 0" },
            Parameter { name: "tint", ty: Ty::Color, default: Some("1"), doc: "a factor of each channel, >= 0" },
        ],
        positional: 0,
        example: "emitter sky = environment(radiance: bitmap(\"sky.exr\"), scale: 2, tint: rgb(1, 0.9, 0.8)) |> rotate(z: 30deg)",
        build: |args, site| environment(args, site),
    },
    Constructor {
        family: Family::Light,
        name: "point",
        summary: "A point that sends the same light in all directions.",
        params: &[
            Parameter {
                name: "position",
                ty: Ty::Vec3,
                default: None,
                doc: "where it is; in a group it moves with it, and its intensity stays",
            },
            Parameter {
                name: "intensity",
                ty: Ty::Color,
                default: None,
                doc: "radiant intensity in W/sr, >= 0; at the distance r it gives the irradiance intensity / r^2",
            },
        ],
        positional: 0,
        example: "emitter bulb = point(position: (0, 0, 3), intensity: 40)",
        build: |args, _| {
            let position = args.vec3("position").unwrap_or_default();
            light(LightKind::Point { position, intensity: strength(args, "intensity")? })
        },
    },
    Constructor {
        family: Family::Light,
        name: "spot",
        summary: "A point that sends light into a cone, with a sharp edge or one that falls off linearly with the angle.",
        params: &[
            Parameter {
                name: "position",
                ty: Ty::Vec3,
                default: None,
                doc: "where it is; in a group it moves with it, and its intensity and angles stay",
            },
            Parameter { name: "target", ty: Ty::Vec3, default: None, doc: "a point that the axis goes through" },
            Parameter {
                name: "intensity",
                ty: Ty::Color,
                default: None,
                doc: "radiant intensity in W/sr within the inner cone, >= 0",
            },
            Parameter {
                name: "angle",
                ty: Ty::Angle,
                default: None,
                doc: "half of the cone's opening, above 0 and at most 90 degrees",
            },
            Parameter {
                name: "inner",
                ty: Ty::Angle,
                default: Some(""),
                doc: "half of the opening of the cone of full intensity, 0 to `angle`; left out it is `angle`, a sharp edge",
            },
        ],
        positional: 0,
        example: "emitter stage = spot(position: (0, -5, 6), target: (0, 0, 0), intensity: 200, angle: 20deg)",
        build: |args, _| spot(args),
    },
    Constructor {
        family: Family::Light,
        name: "directional",
        summary: "Parallel light from infinitely far away.",
        params: &[
            Parameter {
                name: "direction",
                ty: Ty::Vec3,
                default: None,
                doc: "where the light travels to, of any length but 0",
            },
            Parameter {
                name: "irradiance",
                ty: Ty::Color,
                default: None,
                doc: "irradiance in W/m2, >= 0, on a surface across the direction",
            },
        ],
        positional: 0,
        example: "emitter sun = directional(direction: (1, 2, -4), irradiance: rgb(3, 2.8, 2.5))",
        build: |args, _| {
            let direction = normalized(args.vec3("direction").unwrap_or_default()).ok_or_else(|| {
                Problem::new("direction", "`direction` has no length: the light travels nowhere")
                    .help("write for example `-Z` for light from straight above")
            })?;
            light(LightKind::Directional { direction, irradiance: strength(args, "irradiance")? })
        },
    },
];

fn environment(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let scale = args.number("scale").unwrap_or(1.0);
    if scale < 0.0 {
        return Err(Problem::new("scale", "`scale` must be at least 0"));
    }
    let tint = if args.get("tint").is_some() { strength(args, "tint")? } else { Color::Grey(1.0) };
    let tint = match tint {
        Color::Grey(tint) => Color::Grey(tint * scale),
        tint @ (Color::Rgb(_) | Color::Spectrum(_)) => Color::Rgb(tint.rgb().map(|part| part * scale)),
    };
    let Some(ColorOrTexture::Texture(texture)) = args.color_or_texture("radiance") else {
        return light(LightKind::environment(tinted(strength(args, "radiance")?, &tint)?.into()));
    };
    let image = site.host.image(texture);
    if image.is_scaled() {
        return Err(Problem::new("radiance", "the image of an environment has no scale of its own")
            .help("write `scale` and `tint` of `environment(...)`, which may be any numbers from 0 on"));
    }
    let format = image.image.format;
    if !format.is_float() {
        return Err(Problem::new(
            "radiance",
            format!("the image of an environment is {}, which holds no radiance", format.words()),
        )
        .id("invalid-texture")
        .note("its codes end at white, and a sun or a lamp is brighter")
        .help("save it as OpenEXR or PFM"));
    }
    let turn = Affine::IDENTITY;
    light(LightKind::Environment { radiance: ColorOrTexture::Texture(texture), tint, turn })
}

/// A color times a tint, both light.
fn tinted(color: Color, tint: &Color) -> Result<Color, Problem> {
    match (color, tint) {
        (color, Color::Grey(1.0)) => Ok(color),
        (Color::Grey(color), Color::Grey(tint)) => Ok(Color::Grey(color * tint)),
        (Color::Spectrum(spectrum), Color::Grey(tint)) => {
            let points: Vec<_> = spectrum.points().iter().map(|(place, value)| (*place, value * tint)).collect();
            Ok(Color::Spectrum(Spectrum::new(&points, Meaning::Light)))
        }
        (Color::Spectrum(_), Color::Rgb(_) | Color::Spectrum(_)) => {
            Err(Problem::new("tint", "a spectrum has no red, green and blue that could be tinted")
                .help("write the spectrum that is meant"))
        }
        (color, tint) => {
            let (color, tint) = (color.rgb(), tint.rgb());
            Ok(Color::Rgb([0, 1, 2].map(|at| color[at] * tint[at])))
        }
    }
}

fn spot(args: &Args) -> Result<Value, Problem> {
    let position = args.vec3("position").unwrap_or_default();
    let target = args.vec3("target").unwrap_or_default();
    if position == target {
        return Err(Problem::new("target", "`target` equals `position`: the spot shines nowhere"));
    }
    let angle = args.number("angle").unwrap_or(0.0);
    if !(angle > 0.0 && angle <= 90.0) {
        return Err(Problem::new("angle", format!("`angle` is {angle} degrees, it must be above 0 and at most 90"))
            .note("it is half of the cone's opening"));
    }
    let inner = args.number("inner").unwrap_or(angle);
    if !(0.0..=angle).contains(&inner) {
        return Err(Problem::new(
            "inner",
            format!("`inner` is {inner} degrees, it must lie between 0 and `angle`, {angle}"),
        )
        .note("both are halves of a cone's opening"));
    }
    light(LightKind::Spot { position, target, intensity: strength(args, "intensity")?, angle, inner })
}

fn light(kind: LightKind) -> Result<Value, Problem> {
    Ok(Value::Light(Rc::new(kind)))
}

fn strength(args: &Args, name: &'static str) -> Result<Color, Problem> {
    let color = args.color(name).unwrap_or(Color::BLACK);
    if color.min() >= 0.0 {
        return Ok(color.meant(Meaning::Light));
    }
    Err(Problem::new(name, format!("`{name}` must be at least 0 in every channel")))
}
