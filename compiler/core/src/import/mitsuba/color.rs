//! Colors: `rgb`, `srgb`, `spectrum`, `blackbody`.

use super::plugin::{number, numbers};
use super::tree::Element;
use crate::image;
use crate::import::color::{self, Use};
use crate::import::reader::Reader;
use crate::ir::{Color, Meaning, Spectrum};

/// The color that an element says; what is wrong, in words.
pub fn read(element: &Element, use_of: Use, reader: &mut Reader<'_>) -> Result<Color, String> {
    let value = element.word("value").trim();
    let color = match element.tag.as_str() {
        "rgb" | "color" => triple(value)?,
        "srgb" => match triple(value)? {
            Color::Grey(grey) => Color::Grey(image::decoded(grey)),
            Color::Rgb(rgb) => Color::Rgb(rgb.map(image::decoded)),
            Color::Spectrum(spectrum) => Color::Spectrum(spectrum),
        },
        "spectrum" if value.contains(':') => Color::Spectrum(Spectrum::new(&points(value)?, use_of.meaning())),
        "spectrum" if element.get("filename").is_some() => return Err("spectra in files are not read yet".to_owned()),
        // The same at every wavelength, which as light is not the white of the RGB colors (measured with 3.9.1: 1.20, 0.95, 0.91).
        "spectrum" if use_of == Use::Light => match triple(value)? {
            Color::Grey(all) => Color::Spectrum(Spectrum::new(&[(360.0, all), (830.0, all)], Meaning::Light)),
            other @ (Color::Rgb(_) | Color::Spectrum(_)) => other,
        },
        "spectrum" | "float" | "integer" => triple(value)?,
        "blackbody" => black_body(element)?,
        other => return Err(format!("`{other}` is no color")),
    };
    Ok(color::cut(color, use_of, element.span, reader))
}

/// One number, three, or `#rrggbb` by the sRGB curve.
fn triple(text: &str) -> Result<Color, String> {
    if let Some(hex) = text.strip_prefix('#') {
        let byte = |at: usize| hex.get(at..at + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
        return match (byte(0), byte(2), byte(4), hex.len()) {
            (Some(r), Some(g), Some(b), 6) => {
                Ok(Color::Rgb([r, g, b].map(|value| image::decoded(f64::from(value) / 255.0))))
            }
            _ => Err("it is no `#rrggbb`".to_owned()),
        };
    }
    match numbers(text).as_deref() {
        Some([grey]) => Ok(Color::Grey(*grey)),
        Some([r, g, b]) => Ok(color::of_rgb([*r, *g, *b])),
        _ => Err("it is neither one finite number nor three".to_owned()),
    }
}

/// `400:0.5, 500:0.7`; wavelengths grow.
fn points(text: &str) -> Result<Vec<(f64, f64)>, String> {
    let pairs = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let pair = |word: &str| {
        let (wavelength, value) = word.split_once(':')?;
        number(wavelength).zip(number(value))
    };
    let points: Vec<(f64, f64)> =
        pairs.map(pair).collect::<Option<_>>().ok_or("its points are not `WAVELENGTH:VALUE`")?;
    let grows = points.windows(2).all(|two| two[0].0 < two[1].0);
    if points.is_empty() || !grows || points[0].0 <= 0.0 {
        return Err("its wavelengths do not grow".to_owned());
    }
    Ok(points)
}

/// In W/(m2 sr nm), as Mitsuba has it (`BlackBodySpectrum` of 0.6).
fn black_body(element: &Element) -> Result<Color, String> {
    let written = element.word("temperature").trim().trim_end_matches(['K', 'k']);
    let kelvin = number(written).filter(|kelvin| color::KELVIN.contains(kelvin));
    let kelvin = kelvin.ok_or("its `temperature` is not between 100 and 1e6 kelvin")?;
    let scale = element.get("scale").map_or(Some(1.0), number).ok_or("its `scale` is no number")?;
    Ok(Color::Spectrum(color::black_body(kelvin, scale)))
}
