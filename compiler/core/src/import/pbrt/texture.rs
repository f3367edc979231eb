//! Textures: what colors a surface, and the maps of its coordinates.

use super::color::times;
use super::dialect::Dialect;
use super::params::Params;
use super::tokens::Tokens;
use super::world::World;
use crate::diag::{Span, nearest};
use crate::files::VPath;
use crate::import::color::{Use, of_rgb};
use crate::import::reader::Fate;
use crate::import::reader::shown;
use crate::ir::{Color, ColorOrTexture, Encoding};

/// A map of texture coordinates: factor and offset of u and of v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map(pub [[f64; 2]; 2]);

impl Map {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0], [1.0, 0.0]]);

    /// Where a place goes.
    pub fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|at: usize| (self.0[at][0] * f64::from(uv[at]) + self.0[at][1]) as f32)
    }

    fn scaled(self, by: f64) -> Self {
        Self(self.0.map(|row| row.map(|x| x * by)))
    }

    /// For images whose rows grow downwards with v.
    fn turned(self) -> Self {
        let [u, [factor, offset]] = self.0;
        Self([u, [-factor, 1.0 - offset]])
    }
}

/// What a texture is.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// The same everywhere.
    Color(Color),
    /// An image.
    Image {
        /// The file.
        path: VPath,
        /// How its numbers become linear.
        encoding: Encoding,
        /// A factor of them.
        factor: [f64; 3],
        /// The map of its coordinates.
        map: Map,
        /// Where it is described.
        span: Span,
    },
    /// Squares of two colors, one for each step of the coordinates; the first at the origin.
    Board {
        /// The colors.
        colors: [[f64; 3]; 2],
        /// The map of its coordinates.
        map: Map,
        /// Where it is described.
        span: Span,
    },
}

impl Paint {
    /// A grey that stands for what is not read.
    const GREY: Self = Self::Color(Color::Grey(0.5));

    fn times(&self, by: &Color) -> Self {
        let channels = by.rgb();
        let each = |color: [f64; 3]| [0, 1, 2].map(|at| color[at] * channels[at]);
        match self.clone() {
            Self::Color(color) => Self::Color(times(&color, by)),
            Self::Image { path, encoding, factor, map, span } => {
                Self::Image { path, encoding, factor: each(factor), map, span }
            }
            Self::Board { colors, map, span } => Self::Board { colors: colors.map(each), map, span },
        }
    }
}

impl World<'_, '_> {
    /// `Texture "name" "type" "class" ...`.
    pub fn texture_directive(&mut self, start: usize, tokens: &mut Tokens<'_>) {
        let words = [tokens.string(), tokens.string(), tokens.string()];
        let [Some(name), Some(kind), Some(class)] = words else {
            self.dropped(tokens.since(start), "`Texture` is left out: three strings must follow");
            tokens.skip();
            return;
        };
        let mut params = Params::read(&class, start, tokens, self.reader);
        if let Some(defaults) = self.state.defaults("texture") {
            params.inherit(&defaults);
        }
        let of_color = matches!(kind.as_str(), "color" | "spectrum");
        if !of_color && kind != "float" {
            let message = format!("the texture `{}` is left out: `{}` is no type", shown(&name), shown(&kind));
            self.dropped(params.span, message);
            params.pass_all();
            return;
        }
        let paint = self.texture(&params, of_color);
        params.finish(self.reader);
        let textures = if of_color { &mut self.paints } else { &mut self.floats };
        textures.insert(name, paint);
    }

    fn texture(&mut self, params: &Params, of_color: bool) -> Paint {
        match params.kind.as_str() {
            "constant" => self.part(params, "value", 1.0, of_color),
            "imagemap" => self.image(params).unwrap_or(Paint::GREY),
            "checkerboard" => self.board(params, of_color),
            "scale" => {
                let (first, second) =
                    if params.has("tex") || params.has("scale") { ("tex", "scale") } else { ("tex1", "tex2") };
                let a = self.part(params, first, 1.0, of_color);
                // v4's `scale` is a number, v3's `tex2` a color.
                let by_number = second == "scale";
                let b = self.part(params, second, 1.0, of_color && !by_number);
                match (&a, &b) {
                    (_, Paint::Color(color)) => a.times(color),
                    (Paint::Color(color), _) => b.times(color),
                    _ => {
                        self.dropped(params.span, "of a product of two textures the first one is taken");
                        a
                    }
                }
            }
            "mix" => {
                let a = self.part(params, "tex1", 0.0, of_color);
                let b = self.part(params, "tex2", 1.0, of_color);
                let amount = self.part(params, "amount", 0.5, false);
                let share = if let Paint::Color(color) = &amount { color.max().clamp(0.0, 1.0) } else { 0.5 };
                match (&a, &b, &amount) {
                    (Paint::Color(a), Paint::Color(b), Paint::Color(_)) => {
                        let (a, b) = (a.rgb(), b.rgb());
                        Paint::Color(of_rgb([0, 1, 2].map(|at| a[at] + (b[at] - a[at]) * share)))
                    }
                    (_, _, Paint::Color(_)) if share == 0.0 => a,
                    (_, _, Paint::Color(_)) if share == 1.0 => b,
                    _ => {
                        let message = "of a mixture of textures the one with the larger share is taken";
                        self.dropped(params.span, message);
                        if share > 0.5 { b } else { a }
                    }
                }
            }
            other => {
                let message = format!("the texture `{}` is not read: a grey of 0.5 stands in", shown(other));
                self.dropped(params.span, message);
                params.pass_all();
                Paint::GREY
            }
        }
    }

    /// What a texture is made of: a number, a color, or another texture.
    fn part(&mut self, params: &Params, name: &str, default: f64, of_color: bool) -> Paint {
        let grey = Paint::Color(Color::Grey(default));
        let Some(param) = params.find(name) else { return grey };
        if param.kind == "texture" {
            let Some(texture) = param.strings().first().cloned() else { return grey };
            return self.referred(&texture, of_color, param.span).unwrap_or(grey);
        }
        // Factors may be larger than 1: what comes of them is cut where it is used.
        let color = if of_color { self.color(params, name, Use::Index) } else { None };
        match color {
            Some(color) => Paint::Color(color.meant(crate::ir::Meaning::Share)),
            None if of_color => grey,
            None => params.float(name, self.reader).map_or(grey, |value| Paint::Color(Color::Grey(value))),
        }
    }

    /// A texture by its name.
    pub fn referred(&mut self, name: &str, of_color: bool, span: Span) -> Option<Paint> {
        let textures = if of_color { &self.paints } else { &self.floats };
        if let Some(paint) = textures.get(name) {
            return Some(paint.clone());
        }
        let near = nearest(name, textures.keys().map(String::as_str)).map(|near| format!("is `{near}` meant?"));
        let message = format!("there is no texture `{}`", shown(name));
        self.reader.lost_with(Fate::Dropped, span, message, near.as_deref().unwrap_or_default());
        None
    }

    /// The map of coordinates of a texture.
    fn map(&mut self, params: &Params) -> Map {
        if let Some(mapping) = params.string("mapping", self.reader).filter(|mapping| *mapping != "uv") {
            let message = format!("the mapping `{}` of a texture is read as `uv`", shown(mapping));
            self.dropped(params.span_of("mapping"), message);
            params.pass(&["v1", "v2"]);
        }
        let of = |name: &str, default: f64, world: &mut Self| params.float(name, world.reader).unwrap_or(default);
        let (u, v) = (of("uscale", 1.0, self), of("vscale", 1.0, self));
        Map([[u, of("udelta", 0.0, self)], [v, of("vdelta", 0.0, self)]])
    }

    fn image(&mut self, params: &Params) -> Option<Paint> {
        let span = params.span;
        let map = self.map(params);
        let Some(name) = params.string("filename", self.reader).map(str::to_owned) else {
            self.dropped(span, "an image without `filename` is left out");
            params.pass_all();
            return None;
        };
        let path = self.path(&name, params.span_of("filename"))?;
        // v3 decodes whole numbers by the sRGB curve where the file is PNG or TGA; v1 and v2 read them as sRGB too.
        let whole = matches!(path.extension().as_str(), "png" | "tga" | "jpg" | "jpeg" | "bmp");
        let gamma = match params.find("gamma").map(|found| found.kind.clone()).as_deref() {
            Some("bool") => params.boolean("gamma", self.reader),
            Some(_) => params.float("gamma", self.reader).map(|gamma| gamma != 1.0),
            None => None,
        };
        let encoding = match params.string("encoding", self.reader) {
            Some("linear") => Encoding::Linear,
            Some("sRGB") => Encoding::Srgb,
            Some(other) => {
                let message = format!("an image of the encoding `{}` is read by the sRGB curve", shown(other));
                self.near(params.span_of("encoding"), message);
                Encoding::Srgb
            }
            None if gamma.unwrap_or(whole) => Encoding::Srgb,
            None => Encoding::Linear,
        };
        if let Some(wrap) = params.string("wrap", self.reader).filter(|wrap| *wrap != "repeat") {
            let message = format!("`wrap` `{}` is left out: images repeat", shown(wrap));
            self.dropped(params.span_of("wrap"), message);
        }
        if params.boolean("invert", self.reader) == Some(true) {
            self.dropped(params.span_of("invert"), "`invert` is left out: an image is what its file says");
        }
        if params.string("filter", self.reader) == Some("point") {
            let message = "an image without interpolation between its pixels is interpolated";
            self.near(params.span_of("filter"), message);
        }
        params.pass(&["trilinear", "maxanisotropy"]);
        let scale = params.float("scale", self.reader).unwrap_or(1.0);
        // v3 turns images over, so that v grows upwards in them (`ImageTexture::GetTexture`), as v4 does; v1 and v2 do not.
        let map = if self.dialect == Dialect::Old { map.turned() } else { map };
        Some(Paint::Image { path, encoding, factor: [scale; 3], map, span })
    }

    fn board(&mut self, params: &Params, of_color: bool) -> Paint {
        let map = self.map(params);
        params.pass(&["aamode"]);
        if params.float("dimension", self.reader).is_some_and(|dimension| dimension != 2.0) {
            let message = "a checkerboard in space is read as a grey of 0.5";
            self.dropped(params.span_of("dimension"), message);
            params.pass_all();
            return Paint::GREY;
        }
        let parts = [self.part(params, "tex1", 1.0, of_color), self.part(params, "tex2", 0.0, of_color)];
        let colors = parts.map(|part| match part {
            Paint::Color(color) => color.rgb(),
            Paint::Image { .. } | Paint::Board { .. } => {
                self.dropped(params.span, "a checkerboard of textures has a grey of 0.5 in their place");
                [0.5; 3]
            }
        });
        if colors[0] == colors[1] {
            return Paint::Color(of_rgb(colors[0]));
        }
        Paint::Board { colors, map, span: params.span }
    }

    /// A color or a texture of a material, with the map of its coordinates.
    pub fn paint(&mut self, params: &Params, name: &str, default: f64) -> (ColorOrTexture, Map) {
        let plain = |color: Color| (ColorOrTexture::Color(color), Map::IDENTITY);
        let Some(param) = params.find(name) else { return plain(Color::Grey(default)) };
        if param.kind != "texture" {
            return plain(self.color(params, name, Use::Share).unwrap_or(Color::Grey(default)));
        }
        let Some(texture) = param.strings().first().cloned() else { return plain(Color::Grey(default)) };
        match self.referred(&texture, true, param.span) {
            Some(paint) => self.made(&paint, param.span),
            None => plain(Color::Grey(default)),
        }
    }

    fn made(&mut self, paint: &Paint, span: Span) -> (ColorOrTexture, Map) {
        let grey = (ColorOrTexture::Color(Color::Grey(0.5)), Map::IDENTITY);
        match paint {
            Paint::Color(color) => {
                let color = self.cut(color.clone(), Use::Share, span);
                (ColorOrTexture::Color(color), Map::IDENTITY)
            }
            Paint::Image { path, encoding, factor, map, span } => {
                let cut = factor.map(|factor| factor.clamp(0.0, 1.0));
                if cut != *factor {
                    self.near(*span, "a factor of an image beyond 0 to 1 is cut");
                }
                match self.to.texture(self.reader, path, Some(*encoding), cut, &(*span).into()) {
                    Some(handle) => (ColorOrTexture::Texture(handle), *map),
                    None => grey,
                }
            }
            Paint::Board { colors, map, span } => {
                let cut = colors.map(|color| color.map(|channel| channel.clamp(0.0, 1.0)));
                if cut != *colors {
                    self.near(*span, "a share of light beyond 0 to 1 is cut");
                }
                let key = cut.map(|color| color.map(f64::to_bits));
                let known = self.boards.get(&key).copied();
                let handle = known.unwrap_or_else(|| {
                    // The first color lies at the left of the last row, v growing upwards.
                    let made = self.to.checkerboard(self.reader, [cut[1], cut[0]], &(*span).into());
                    self.boards.insert(key, made);
                    made
                });
                // The image has two squares by two.
                handle.map_or(grey, |handle| (ColorOrTexture::Texture(handle), map.scaled(0.5)))
            }
        }
    }

    /// A color that cannot be a texture here.
    pub fn tint(&mut self, params: &Params, name: &str, default: f64) -> Color {
        match self.paint(params, name, default).0 {
            ColorOrTexture::Color(color) => color,
            ColorOrTexture::Texture(texture) => {
                let message = format!("a texture of `{}` is read as its mean", shown(name));
                self.dropped(params.span_of(name), message);
                let mean = self.to.mean(texture).unwrap_or([default; 3]);
                of_rgb(mean.map(|channel| channel.clamp(0.0, 1.0)))
            }
        }
    }

    /// A number of a material; a texture that is the same everywhere is one.
    pub fn number(&mut self, params: &Params, name: &str) -> Option<f64> {
        let param = params.find(name)?;
        if param.kind != "texture" {
            return params.float(name, self.reader);
        }
        let texture = param.strings().first().cloned()?;
        match self.referred(&texture, false, param.span)? {
            Paint::Color(color) => Some(color.max()),
            Paint::Image { path, encoding, factor, map: _, span } => {
                let image = self.to.texture(self.reader, &path, Some(encoding), [1.0; 3], &span.into());
                let [r, g, b] = image.and_then(|image| self.to.mean(image))?;
                self.near(param.span, format!("a texture of `{}` is read as its mean", shown(name)));
                Some((r * factor[0] + g * factor[1] + b * factor[2]) / 3.0)
            }
            Paint::Board { colors, map: _, span: _ } => {
                self.near(param.span, format!("a texture of `{}` is read as its mean", shown(name)));
                Some(f64::midpoint(colors[0][0], colors[1][0]))
            }
        }
    }
}
