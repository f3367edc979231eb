//! Lights with and without a surface.

use std::f64::consts::PI;
use std::rc::Rc;

use super::color::times;
use super::dialect::Dialect;
use super::params::Params;
use super::settings::FARTHEST;
use super::world::{World, inverse};
use crate::diag::Span;
use crate::files::VPath;
use crate::formats::pbrt::names::ENVIRONMENT;
use crate::image::Pixels;
use crate::import::color::Use;
use crate::import::reader::shown;
use crate::ir::{
    Affine, Color, ColorOrTexture, Handle, LightKind, Meaning, Texture, Vec3, cross, dot, normalized, sub,
};

/// What shapes emit.
#[derive(Clone, Debug)]
pub struct Area {
    /// Radiance, `power` aside.
    pub radiance: Color,
    /// v4's `power`, of each shape.
    pub power: Option<f64>,
    /// Whether both sides emit.
    pub both_sides: bool,
    /// Where it is said.
    pub span: Span,
}

impl World<'_, '_> {
    /// The strength that a light has, times its `scale`, which is a number or a color.
    fn strength(&mut self, params: &Params, name: &str) -> Color {
        let color = self.color(params, name, Use::Light).unwrap_or(Color::Grey(1.0));
        let scale = self.color(params, "scale", Use::Light).unwrap_or(Color::Grey(1.0));
        let strength = times(&color, &scale).meant(Meaning::Light);
        self.cut(strength, Use::Light, params.span)
    }

    /// `AreaLightSource`.
    pub fn area_light(&mut self, params: &Params) {
        if !matches!(params.kind.as_str(), "area" | "diffuse") {
            let message = format!("the light `{}` of surfaces is left out: it is not read", shown(&params.kind));
            self.dropped(params.span, message);
            params.pass_all();
            return;
        }
        let mut radiance = self.strength(params, "L");
        if let Some(name) = params.string("filename", self.reader).map(str::to_owned) {
            let path = self.path(&name, params.span_of("filename"));
            let at = params.span_of("filename");
            let image = path.and_then(|path| self.to.texture(self.reader, &path, None, [1.0; 3], &at.into()));
            self.near(at, "a light with an image emits its mean color everywhere");
            if let Some(mean) = image.and_then(|image| self.to.mean(image)) {
                radiance = times(&radiance, &Color::Rgb(mean));
            }
        }
        params.pass(&["nsamples", "samples"]);
        let both_sides = params.boolean("twosided", self.reader).unwrap_or(false);
        let power = params.float("power", self.reader).filter(|power| *power > 0.0);
        self.state.area = Some(Rc::new(Area { radiance, power, both_sides, span: params.span }));
    }

    /// `LightSource`.
    pub fn light(&mut self, params: &Params) {
        params.pass(&["nsamples", "samples"]);
        let map = self.place();
        let point = |name: &str, default: Vec3, world: &mut Self| {
            map.point(params.vector(name, world.reader).unwrap_or(default))
        };
        let kind = match params.kind.as_str() {
            "infinite" | "exinfinite" | "infinitesample" => self.infinite(params),
            "point" => {
                let position = point("from", [0.0; 3], self);
                let intensity = self.strength(params, "I");
                let intensity = self.powered(params, intensity, "power", 1.0 / (4.0 * PI));
                Some(LightKind::Point { position, intensity })
            }
            "spot" => {
                let (position, target) = (point("from", [0.0; 3], self), point("to", [0.0, 0.0, 1.0], self));
                let angle = params.float_in("coneangle", (1e-3, 90.0), 30.0, self.reader);
                let delta = params.float("conedeltaangle", self.reader).unwrap_or(5.0);
                let inner = (angle - delta).clamp(0.0, angle);
                let [start, end] = [inner, angle].map(|degrees| libm::cos(degrees.to_radians()));
                let intensity = self.strength(params, "I");
                let share = 2.0 * PI * ((1.0 - start) + (start - end) / 2.0);
                let intensity = self.powered(params, intensity, "power", 1.0 / share.max(1e-12));
                if inner < angle {
                    let message =
                        "light of a spot falls off linearly with the angle between its inner cone and its edge";
                    self.near(params.span, message);
                }
                let direction = normalized(sub(target, position));
                direction.map(|_| LightKind::Spot { position, target, intensity, angle, inner })
            }
            "distant" => {
                let (from, target) = (point("from", [0.0; 3], self), point("to", [0.0, 0.0, 1.0], self));
                let irradiance = self.strength(params, "L");
                let irradiance = self.powered(params, irradiance, "illuminance", 1.0);
                let direction = normalized(sub(target, from));
                direction.map(|direction| LightKind::Directional { direction, irradiance })
            }
            other => {
                let message = format!("the light `{}` is left out: it is not read", shown(other));
                self.dropped(params.span, message);
                params.pass_all();
                return;
            }
        };
        let places = match &kind {
            Some(LightKind::Point { position, intensity: _ }) => [*position; 2],
            Some(LightKind::Spot { position, target, intensity: _, angle: _, inner: _ }) => [*position, *target],
            _ => [[0.0; 3]; 2],
        };
        if !places.iter().flatten().all(|x| x.abs() <= FARTHEST) {
            self.dropped(params.span, "a light that is farther away than 1e30 is left out");
            return;
        }
        match kind {
            Some(kind) => self.to.light(self.reader, &params.kind, kind, &params.span.into()),
            None if params.kind == "spot" || params.kind == "distant" => {
                self.dropped(params.span, "a light without a direction is left out");
            }
            None => {}
        }
    }

    /// v4's `power` and `illuminance`: the strength is `share` of it, in the color that is given. A spectrum has the luminance 1 here,
    /// and RGB is measured by its white (`SpectrumToPhotometric`).
    fn powered(&mut self, params: &Params, strength: Color, name: &str, share: f64) -> Color {
        match params.float(name, self.reader).filter(|power| *power > 0.0) {
            Some(power) => {
                let strength = times(&strength, &Color::Grey(power * share));
                self.cut(strength, Use::Light, params.span)
            }
            None => strength,
        }
    }

    fn infinite(&mut self, params: &Params) -> Option<LightKind> {
        let strength = self.strength(params, "L");
        if params.has("portal") {
            params.pass(&["portal"]);
            self.dropped(params.span_of("portal"), "a portal is left out: the environment is seen all around");
        }
        let name = params.string("filename", self.reader).or(params.string("mapname", self.reader)).map(str::to_owned);
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            let radiance = self.powered(params, strength, "illuminance", 1.0 / PI);
            return Some(LightKind::environment(radiance.into()));
        };
        if params.float("illuminance", self.reader).is_some() {
            let message = "`illuminance` of an environment with an image is left out: the image says how bright it is";
            self.dropped(params.span_of("illuminance"), message);
        }
        let span = params.span;
        let path = self.path(&name, span)?;
        let octahedral = self.dialect == Dialect::V4 && params.has("filename");
        // From the directions of the file's image to those of the Scene.
        let own = if octahedral { Affine::IDENTITY } else { inverse(&ENVIRONMENT)? };
        let mut map = own.then(&self.place());
        // A mirrored image is laid by a rotation of its mirror image.
        let mirrored = map.determinant() < 0.0;
        if mirrored {
            map = Affine::scaling([-1.0, 1.0, 1.0]).then(&map);
        }
        let turn = rotation(&map).unwrap_or_else(|| {
            let message = "an environment that is scaled unevenly is only turned";
            self.dropped(span, message);
            Affine::IDENTITY
        });
        let texture = self.sky(&path, octahedral, mirrored, span)?;
        Some(LightKind::Environment { radiance: ColorOrTexture::Texture(texture), tint: strength, turn })
    }

    /// The image of an environment by longitude and latitude.
    fn sky(&mut self, path: &VPath, octahedral: bool, mirrored: bool, span: Span) -> Option<Handle<Texture>> {
        let at = span.into();
        let texture = self.to.texture(self.reader, path, None, [1.0; 3], &at)?;
        let info = self.to.texture_of(texture).image;
        let (width, height) = (info.width as usize, info.height as usize);
        if octahedral && width != height {
            let message = format!("`{path}` is not square: it is read by longitude and latitude");
            self.near(span, message);
        }
        let octahedral = octahedral && width == height;
        if !octahedral && !mirrored {
            return self.to.floats(self.reader, texture, &at);
        }
        let most = self.reader.limits().pixels as f64;
        // As high as the square: no pixel of it is smaller than one of the image.
        let rows = if octahedral { (height as f64).min((most / 2.0).sqrt()).max(1.0) as usize } else { height };
        if octahedral {
            let message = format!("an environment on an octahedron becomes an image of {} x {rows} pixels", 2 * rows);
            self.near(span, message);
        }
        let change = |pixels: Pixels| {
            let pixels = if octahedral { unfolded(&pixels, rows) } else { pixels };
            if mirrored { across(pixels) } else { pixels }
        };
        self.to.remade(self.reader, texture, &format!("sky {octahedral} {mirrored}"), change, &at)
    }
}

/// The rotation of a map, without its translation and an even scale; none where it does something else to directions.
fn rotation(map: &Affine) -> Option<Affine> {
    let column = |at: usize| [0, 1, 2].map(|row: usize| map.rows[row][at]);
    let [x, y, z] = [column(0), column(1), column(2)];
    let sizes = [x, y, z].map(|axis| dot(axis, axis).sqrt());
    let even = sizes.iter().all(|size| (size / sizes[0] - 1.0).abs() < 1e-4);
    let [x, y, z] = [normalized(x)?, normalized(y)?, normalized(z)?];
    let straight = dot(x, y).abs() < 1e-4 && dot(y, z).abs() < 1e-4 && dot(x, z).abs() < 1e-4;
    if !even || !straight || map.determinant() <= 0.0 {
        return None;
    }
    // To double precision, where a text has less.
    let x = normalized(sub(x, z.map(|part| part * dot(x, z))))?;
    let y = cross(z, x);
    Some(Affine { rows: [0, 1, 2].map(|row: usize| [x[row], y[row], z[row], 0.0]) })
}

/// The place of a direction on the square (`EqualAreaSphereToSquare`): the way back of [`crate::image::sphere::direction`].
pub fn square([x, y, z]: Vec3) -> [f64; 2] {
    let radius = (1.0 - z.abs()).max(0.0).sqrt();
    let (a, b) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let turn = libm::atan2(b, a) * 2.0 / PI;
    let turn = if x.abs() < y.abs() { 1.0 - turn } else { turn };
    let (mut u, mut v) = (radius - turn * radius, turn * radius);
    if z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    [u.copysign(x), v.copysign(y)].map(|part| (part + 1.0) / 2.0)
}

/// An image on the square by longitude and latitude.
fn unfolded(image: &Pixels, rows: usize) -> Pixels {
    let side = image.width as i64;
    let texel = |mut x: i64, mut y: i64| {
        // Beyond an edge the square goes on turned over along it.
        if x < 0 || x >= side {
            x = if x < 0 { -1 - x } else { 2 * side - 1 - x };
            y = side - 1 - y;
        }
        if y < 0 || y >= side {
            y = if y < 0 { -1 - y } else { 2 * side - 1 - y };
            x = side - 1 - x;
        }
        image.at(x.clamp(0, side - 1) as usize, y.clamp(0, side - 1) as usize)
    };
    let width = 2 * rows;
    let mut values = Vec::with_capacity(width * rows * 3);
    for row in 0..rows {
        let polar = PI * (row as f64 + 0.5) / rows as f64;
        let (sine, z) = (libm::sin(polar), libm::cos(polar));
        for at in 0..width {
            // The middle is +y, a quarter of the width to the right of it +x.
            let angle = 2.0 * PI * ((at as f64 + 0.5) / width as f64 - 0.5);
            let [u, v] = square([sine * libm::sin(angle), sine * libm::cos(angle), z]);
            let (u, v) = (u * side as f64 - 0.5, v * side as f64 - 0.5);
            let (left, top) = (libm::floor(u), libm::floor(v));
            let (fu, fv) = ((u - left) as f32, (v - top) as f32);
            let (left, top) = (left as i64, top as i64);
            let four = [texel(left, top), texel(left + 1, top), texel(left, top + 1), texel(left + 1, top + 1)];
            for channel in 0..3 {
                let [a, b, c, d] = four.map(|color| color[channel]);
                let (upper, lower) = (a + (b - a) * fu, c + (d - c) * fu);
                values.push(upper + (lower - upper) * fv);
            }
        }
    }
    Pixels { width, height: rows, channels: 3, values }
}

/// The image with its columns in the other order.
fn across(mut pixels: Pixels) -> Pixels {
    let (width, channels) = (pixels.width, pixels.channels);
    for row in pixels.values.chunks_exact_mut((width * channels).max(1)) {
        for at in 0..width / 2 {
            for channel in 0..channels {
                row.swap(at * channels + channel, (width - 1 - at) * channels + channel);
            }
        }
    }
    pixels
}
