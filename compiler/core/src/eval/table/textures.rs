//! Textures.

use crate::diag::{Finding, Severity, Span};
use crate::image::{self, ImageError, Loaded, Loss, Remark};
use crate::ir::{Color, Encoding, Texture};

use super::super::Limit;
use super::super::value::{Ty, Value};
use super::meshes::read;
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[Constructor {
    family: Family::Texture,
    name: "bitmap",
    summary: "An image laid over a surface by its texture coordinates; it repeats beyond 0..1, and `v` grows upwards in it.",
    params: &[
        Parameter {
            name: "path",
            ty: Ty::String,
            default: None,
            doc: "a PNG, JPEG, OpenEXR, PFM or Radiance HDR file, from the folder of this file, with `/`",
        },
        Parameter {
            name: "encoding",
            ty: Ty::String,
            default: Some(""),
            doc: "`\"srgb\"` or `\"linear\"`; left out it is `\"srgb\"` for PNG and JPEG, `\"linear\"` for the formats of floats",
        },
        Parameter {
            name: "scale",
            ty: Ty::Color,
            default: Some("1"),
            doc: "a factor of its linear red, green and blue, 0..1",
        },
    ],
    positional: 1,
    example: "texture oak = bitmap(\"textures/oak.png\")\nmaterial table = diffuse(oak)",
    build: bitmap,
}];

fn bitmap(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let wanted = match args.get("encoding") {
        Some(Value::String(word)) => Some(encoding(word)?),
        _ => None,
    };
    let (path, bytes) = read(args, site)?;
    let loaded = image::load(&path.extension(), &bytes, site.limits.pixels);
    let Loaded { info, file, peak, remarks } = loaded.map_err(|ImageError { id, message, place, help }| {
        let help = if id == "image-limit" { Some(Limit::help("pixels")) } else { help.map(str::to_owned) };
        Problem::new("path", format!("`{path}` {message}")).id(id).label(place).maybe_help(help)
    })?;
    let float = info.format.is_float();
    if float && wanted == Some(Encoding::Srgb) {
        return Err(Problem::new("encoding", format!("`{path}` holds floats, which are linear in every renderer"))
            .id("invalid-texture")
            .help("leave `encoding` out, or save the image as PNG"));
    }
    let encoding = wanted.unwrap_or(if float { Encoding::Linear } else { Encoding::Srgb });
    for remark in remarks {
        site.findings.push(lost(&path.to_string(), remark, site.span));
    }
    let name = path.stem().to_owned();
    let peak = if encoding == Encoding::Srgb { image::decoded(peak) } else { peak };
    let factor = args.color("scale").unwrap_or(Color::Grey(1.0));
    if factor.spectrum().is_some() {
        return Err(Problem::new(
            "scale",
            "`scale` is a number or a color of red, green and blue, and this is a spectrum",
        )
        .id("invalid-texture")
        .note("an image has no spectrum that could be multiplied"));
    }
    let factor = factor.rgb();
    if !factor.iter().all(|part| (0.0..=1.0).contains(part)) {
        return Err(Problem::new("scale", "`scale` lies between 0 and 1 in each channel")
            .id("invalid-texture")
            .note("glTF has no larger factor, and a surface reflects no more than it receives")
            .help("make the image itself brighter"));
    }
    let texture = Texture { name, file, image: info, encoding, peak, factor };
    Ok(Value::Texture(site.host.texture(texture, site.span)))
}

/// What is to be said of a part of an image file that does not stay as it is.
pub(super) fn lost(path: &str, remark: Remark, span: Span) -> Finding {
    let Remark { loss, message, of_color: _ } = remark;
    let id = match loss {
        Loss::Baked => "loss-baked",
        Loss::Approximated => "loss-approximated",
        Loss::Dropped => "loss-dropped",
    };
    Finding::new(id, Severity::Warn, span, format!("`{path}` {message}"))
}

fn encoding(word: &str) -> Result<Encoding, Problem> {
    match word {
        "srgb" => Ok(Encoding::Srgb),
        "linear" => Ok(Encoding::Linear),
        other => Err(Problem::new("encoding", format!("there is no encoding `{other}`"))
            .id("invalid-texture")
            .help("write `\"srgb\"` for images as screens show them, `\"linear\"` for numbers that are reflectances")),
    }
}
