//! Colors: `rgb`, `color`, `xyz`, `spectrum` in all its forms, `blackbody`.

use super::dialect::Dialect;
use super::params::{Param, Params, Values};
use super::world::World;
use crate::diag::{Span, nearest};
use crate::import::color::{self, Use, of_rgb};
use crate::import::metals;
use crate::import::reader::shown;
use crate::ir::{Color, Meaning, Spectrum};

/// v4's glasses: indices at the yellow line of helium (587.6 nm), by the catalogue of Schott. The names are those of `spectrum.cpp`.
const GLASSES: [(&str, f64); 7] = [
    ("glass-BK7", 1.5168),
    ("glass-BAF10", 1.67003),
    ("glass-FK51A", 1.48656),
    ("glass-LASF9", 1.85025),
    ("glass-F5", 1.67271),
    ("glass-F10", 1.72828),
    ("glass-F11", 1.78472),
];

/// The index of a glass that v4 knows by name.
pub fn glass(name: &str) -> Option<f64> {
    GLASSES.iter().find(|(known, _)| *known == name).map(|(_, ior)| *ior)
}

/// A color times another one.
pub fn times(a: &Color, b: &Color) -> Color {
    let ((Color::Grey(factor), other) | (other, Color::Grey(factor))) = (a, b) else {
        let (a, b) = (a.rgb(), b.rgb());
        return of_rgb([0, 1, 2].map(|at| a[at] * b[at]));
    };
    match other {
        Color::Grey(grey) => Color::Grey(grey * factor),
        Color::Rgb(rgb) => Color::Rgb(rgb.map(|channel| channel * factor)),
        // Of light, since only light is multiplied.
        Color::Spectrum(_) if *factor == 1.0 => other.clone(),
        Color::Spectrum(spectrum) => {
            let points: Vec<(f64, f64)> = spectrum.points().iter().map(|(at, value)| (*at, value * factor)).collect();
            Color::Spectrum(Spectrum::new(&points, Meaning::Light))
        }
    }
}

/// By wavelength, its largest value 1 (`BlackbodyNormalized`), at Wien's wavelength.
fn black_body(kelvin: f64) -> Spectrum {
    color::black_body(kelvin, 1.0 / color::planck(kelvin, 2.897_771_955e6 / kelvin))
}

impl World<'_, '_> {
    /// The color that a parameter says; none where it is not there, is a texture, or is no color, which is a finding.
    pub fn color(&mut self, params: &Params, name: &str, use_of: Use) -> Option<Color> {
        let param = params.find(name)?;
        if param.kind == "texture" {
            return None;
        }
        match self.color_of(param, use_of) {
            Ok(color) => Some(self.cut(color, use_of, param.span)),
            Err(problem) => {
                let message = format!("`{}` of `{}` is left out: {problem}", shown(name), shown(&params.kind));
                self.dropped(param.span, message);
                None
            }
        }
    }

    fn color_of(&mut self, param: &Param, use_of: Use) -> Result<Color, String> {
        match (param.kind.as_str(), &param.values) {
            ("spectrum", Values::Strings(names)) => match names.as_slice() {
                [name] => self.named(name, use_of, param.span),
                _ => Err("it is not one name of a spectrum".to_owned()),
            },
            ("spectrum", Values::Numbers(numbers)) => {
                let spectrum = points(numbers)?;
                Ok(self.measured(&spectrum, use_of))
            }
            ("blackbody", Values::Numbers(numbers)) => self.black_body(numbers, param.span),
            ("xyz", Values::Numbers(numbers)) => match numbers.as_slice() {
                [x, y, z] => Ok(of_rgb(from_xyz([*x, *y, *z]))),
                _ => Err("it is not three numbers".to_owned()),
            },
            ("rgb" | "color" | "float", Values::Numbers(numbers)) => match numbers.as_slice() {
                [r, g, b] => Ok(of_rgb([*r, *g, *b])),
                [grey] => Ok(Color::Grey(*grey)),
                _ => Err("it is not three finite numbers".to_owned()),
            },
            (kind, _) => Err(format!("`{}` with such values is no color", shown(kind))),
        }
    }

    /// Values at wavelengths. v4 divides light by its luminance (`SpectrumToPhotometric`).
    fn measured(&self, points: &[(f64, f64)], use_of: Use) -> Color {
        let spectrum = Spectrum::new(points, use_of.meaning());
        let luminance = spectrum.luminance();
        if self.dialect == Dialect::V4 && use_of == Use::Light && luminance > 0.0 {
            return times(&Color::Spectrum(spectrum), &Color::Grey(1.0 / luminance));
        }
        Color::Spectrum(spectrum)
    }

    fn black_body(&mut self, numbers: &[f64], span: Span) -> Result<Color, String> {
        // v3 has pairs of a temperature and a factor, v4 a temperature.
        let (kelvin, scale) = match numbers {
            [kelvin] => (*kelvin, 1.0),
            [kelvin, scale] => (*kelvin, *scale),
            [kelvin, scale, ..] => {
                self.dropped(span, "of several black bodies the first one counts");
                (*kelvin, *scale)
            }
            [] => return Err("it has no temperature".to_owned()),
        };
        if !color::KELVIN.contains(&kelvin) {
            return Err("its temperature is not between 100 and 1e6 kelvin".to_owned());
        }
        if self.dialect == Dialect::Old {
            self.near(span, "a black body of pbrt-v2 has the strength that pbrt-v3 gives it");
        }
        let spectrum = black_body(kelvin);
        let scale = if self.dialect == Dialect::V4 { 1.0 / spectrum.luminance().max(1e-300) } else { scale };
        Ok(times(&Color::Spectrum(spectrum), &Color::Grey(scale)))
    }

    /// A spectrum by its name: of v4's own ones, of a metal, or of a file.
    fn named(&mut self, name: &str, use_of: Use, span: Span) -> Result<Color, String> {
        if let Some(ior) = glass(name) {
            return Ok(Color::Grey(ior));
        }
        if let Some(light) = name.strip_prefix("stdillum-").or(name.strip_prefix("illum-")) {
            return Ok(self.illuminant(light, span));
        }
        // `metal-Cu-eta`, `spds/Cu.eta.spd`.
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let stem = file.strip_suffix(".spd").unwrap_or(file);
        let words = name.strip_prefix("metal-").and_then(|rest| rest.rsplit_once('-'));
        let words = words.or_else(|| stem.rsplit_once('.'));
        if let Some((metal, part @ ("eta" | "k"))) = words {
            if let Some((eta, k)) = metals::metal(metal) {
                return Ok(Color::Rgb(if part == "eta" { eta } else { k }));
            }
            if name.starts_with("metal-") {
                let help = nearest(metal, metals::metals()).map(|near| format!(", is `{near}` meant?"));
                let message = format!(
                    "the metal `{}` is not known{}: copper stands in",
                    shown(metal),
                    help.as_deref().unwrap_or_default()
                );
                self.dropped(span, message);
                let (eta, k) = metals::metal("Cu").unwrap_or(([1.0; 3], [1.0; 3]));
                return Ok(Color::Rgb(if part == "eta" { eta } else { k }));
            }
        }
        let Some(path) = self.path(name, span) else { return Err(format!("`{}` is no file", shown(name))) };
        let bytes = self.reader.bytes(&path).map_err(|error| format!("`{path}` cannot be read: {error}"))?;
        if bytes.len() as u64 > self.reader.limits().text {
            return Err(format!("`{path}` is too large a text"));
        }
        let text = String::from_utf8_lossy(&bytes);
        let mut numbers = Vec::new();
        for line in text.lines() {
            let plain = line.split('#').next().unwrap_or_default();
            for word in plain.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty()) {
                let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
                numbers.push(number.ok_or_else(|| format!("`{path}` is no list of wavelengths and values"))?);
            }
        }
        let points = points(&numbers)?;
        Ok(self.measured(&points, use_of))
    }

    /// A light of the CIE with the luminance 1.
    fn illuminant(&mut self, name: &str, span: Span) -> Color {
        let kelvin = match name {
            "D65" => return Color::Grey(1.0),
            "A" => 2856.0,
            "D50" => 5003.0,
            "acesD60" => 6000.0,
            other => {
                self.near(span, format!("the light `{}` is read as white", shown(other)));
                return Color::Grey(1.0);
            }
        };
        if name != "A" {
            self.near(span, format!("the light `{name}` is read as a black body of {kelvin} kelvin"));
        }
        let spectrum = black_body(kelvin);
        let luminance = spectrum.luminance();
        times(&Color::Spectrum(spectrum), &Color::Grey(1.0 / luminance))
    }

    /// A color without what lies outside of what one of this use can be.
    pub fn cut(&mut self, color: Color, use_of: Use, span: Span) -> Color {
        color::cut(color, use_of, span, self.reader)
    }
}

/// Pairs of wavelength and value.
fn points(numbers: &[f64]) -> Result<Vec<(f64, f64)>, String> {
    let pairs: Vec<(f64, f64)> = numbers
        .chunks_exact(2)
        .filter_map(|pair| if let [at, value] = pair { Some((*at, *value)) } else { None })
        .collect();
    let grows = pairs.windows(2).all(|two| matches!(two, [a, b] if a.0 < b.0));
    if pairs.is_empty() || !numbers.len().is_multiple_of(2) || !grows || pairs.iter().any(|pair| pair.0 <= 0.0) {
        return Err("it is no list of growing wavelengths with their values".to_owned());
    }
    Ok(pairs)
}

/// Linear sRGB (`XYZToRGB`).
fn from_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240479 * x - 1.537150 * y - 0.498535 * z,
        -0.969256 * x + 1.875991 * y + 0.041556 * z,
        0.055648 * x - 0.204043 * y + 1.057311 * z,
    ]
}
