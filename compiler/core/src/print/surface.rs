//! Colors, materials and images as calls of their constructors.

use super::notes::Notes;
use super::number::{number, string};
use crate::diag::Origin;
use crate::ir::{Bsdf, Color, ColorOrTexture, Encoding, Material, Meaning, Sides, Spectrum, Texture};

/// The number above 0 that is nearest to it, for what must be greater.
const LEAST: f64 = f64::MIN_POSITIVE;

/// What a color may be where it stands.
pub(super) struct Place<'p> {
    /// Where it comes from.
    pub at: &'p Origin,
    /// What it is, for findings: `` the reflectance of `wall` ``.
    pub what: &'p str,
    /// What a spectrum says there.
    pub meaning: Meaning,
    /// The smallest number.
    pub least: f64,
}

/// A color: a number for a grey, else `rgb(...)` or `spectrum(...)`.
pub(super) fn color(notes: &mut Notes, color: &Color, place: &Place<'_>) -> String {
    let mut part = |value: f64| number(notes.within(place.at, place.what, value, place.least, f64::MAX));
    match color {
        Color::Grey(value) => part(*value),
        Color::Rgb(rgb) => {
            let [r, g, b] = rgb.map(part);
            format!("rgb({r}, {g}, {b})")
        }
        Color::Spectrum(spectrum) => values(notes, spectrum, place),
    }
}

fn values(notes: &mut Notes, spectrum: &Spectrum, place: &Place<'_>) -> String {
    let points = spectrum.points();
    let grows = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
    let wavelengths = points.iter().all(|(wavelength, _)| (1.0..=1e6).contains(wavelength));
    let nanometers = points.iter().any(|(wavelength, _)| *wavelength >= 20.0);
    let numbers = points.iter().all(|(_, value)| (place.least..=f64::MAX).contains(value));
    if !(points.len() >= 2 && grows && wavelengths && nanometers && numbers) {
        let message = format!("{} is a spectrum that the language does not have: its color is written", place.what);
        notes.changed(place.at, message);
        return color(notes, &Color::Rgb(spectrum.rgb()), place);
    }
    if Spectrum::new(points, place.meaning) != *spectrum {
        let message = format!("{} is a spectrum of something else than {:?} here", place.what, place.meaning);
        notes.changed(place.at, message);
    }
    let pairs: Vec<String> =
        points.iter().map(|(at, value)| format!("({}, {})", number(*at), number(*value))).collect();
    format!("spectrum([{}])", pairs.join(", "))
}

/// A material's call; `texture` writes that of an image.
pub(super) fn material(
    notes: &mut Notes,
    Material { name, bsdf, sides }: &Material,
    at: &Origin,
    texture: &dyn Fn(crate::ir::Handle<Texture>) -> String,
) -> String {
    let name = name.escape_debug();
    let what = |part: &str| format!("`{part}` of the material `{name}`");
    let paint = |notes: &mut Notes, paint: &ColorOrTexture, part: &str| match paint {
        ColorOrTexture::Color(plain) => {
            color(notes, plain, &Place { at, what: &what(part), meaning: Meaning::Share, least: 0.0 })
        }
        ColorOrTexture::Texture(image) => texture(*image),
    };
    let mut words = Vec::new();
    match bsdf {
        Bsdf::Diffuse { reflectance } => words.push(paint(notes, reflectance, "reflectance")),
        Bsdf::Conductor { eta, k, alpha } => {
            for (part, value, least) in [("eta", eta, LEAST), ("k", k, 0.0)] {
                let place = Place { at, what: &what(part), meaning: Meaning::Index, least };
                words.push(format!("{part}: {}", color(notes, value, &place)));
            }
            words.push(format!("alpha: {}", number(notes.within(at, &what("alpha"), *alpha, 0.0, 1.0))));
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let ior = notes.within(at, &what("ior"), *interior, LEAST, f64::MAX);
            let outside = notes.within(at, &what("outside"), *exterior, LEAST, f64::MAX);
            let alpha = notes.within(at, &what("alpha"), *alpha, 0.0, 1.0);
            words.push(format!("ior: {}", number(ior)));
            words.extend(unless("outside", outside, 1.0));
            words.extend(unless("alpha", alpha, 0.0));
        }
        Bsdf::Mirror { reflectance } => {
            let place = Place { at, what: &what("reflectance"), meaning: Meaning::Share, least: 0.0 };
            words.push(color(notes, reflectance, &place));
        }
        Bsdf::Plastic { reflectance, ior, alpha } => {
            words.push(paint(notes, reflectance, "reflectance"));
            words.extend(unless("ior", notes.within(at, &what("ior"), *ior, 1.0_f64.next_up(), f64::MAX), 1.5));
            words.extend(unless("alpha", notes.within(at, &what("alpha"), *alpha, 0.0, 1.0), 0.0));
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            words.push(paint(notes, base, "base"));
            words.extend(unless("metallic", notes.within(at, &what("metallic"), *metallic, 0.0, 1.0), 0.0));
            words.extend(unless("roughness", notes.within(at, &what("roughness"), *roughness, 0.0, 1.0), 0.5));
            words.extend(unless("ior", notes.within(at, &what("ior"), *ior, 1.0_f64.next_up(), f64::MAX), 1.5));
        }
    }
    let call = format!("{}({})", bsdf.word(), words.join(", "));
    match sides {
        Sides::Both => call,
        Sides::Front => format!("one_sided({call})"),
    }
}

/// An argument, unless it is what the constructor takes by itself.
fn unless(label: &str, value: f64, default: f64) -> Option<String> {
    (value != default).then(|| format!("{label}: {}", number(value)))
}

/// The call of an image in the file at `path`.
pub(super) fn bitmap(notes: &mut Notes, texture: &Texture, path: &str, at: &Origin) -> String {
    let Texture { name, file: _, image, encoding, peak: _, factor } = texture;
    let what = format!("the factor of the image `{}`", name.escape_debug());
    let mut words = vec![string(path)];
    match (encoding, image.format.is_float()) {
        (Encoding::Srgb, false) | (Encoding::Linear, true) => {}
        (Encoding::Linear, false) => words.push("encoding: \"linear\"".to_owned()),
        (Encoding::Srgb, true) => {
            let message = format!("the image `{}` holds floats, which are linear", name.escape_debug());
            notes.changed(at, message);
        }
    }
    let factor @ [r, g, b] = factor.map(|part| notes.within(at, &what, part, 0.0, 1.0));
    if factor != [1.0; 3] {
        let grey = r == g && g == b;
        words.push(if grey {
            format!("scale: {}", number(r))
        } else {
            format!("scale: rgb({}, {}, {})", number(r), number(g), number(b))
        });
    }
    format!("bitmap({})", words.join(", "))
}
