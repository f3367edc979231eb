//! Rule `out-of-gamut`: spectra whose color RGB can hold.
#![doc = include_str!("out_of_gamut.md")]

use super::{Level, Report, Rule, Subject};
use crate::diag::Origin;
use crate::ir::{Bsdf, Color, Spectrum};

pub(super) const RULE: Rule = Rule {
    id: "out-of-gamut",
    level: Level::Warn,
    summary: "A spectrum has a color that linear sRGB cannot hold.",
    doc: include_str!("out_of_gamut.md"),
    targets: &["mitsuba-3", "mitsuba-0.6", "mitsuba-0.5", "pbrt-v3", "luxcore", "gltf", "glb"],
    check,
};

/// How much of the largest channel is cut before it is said: below lies the accuracy of the conversion.
const LEAST: f64 = 1e-3;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let mut say = |origin: &Origin, what: String, color: Option<&Color>| {
        let Some(spectrum) = color.and_then(Color::spectrum).filter(|spectrum| is_cut(spectrum)) else { return };
        let exact = spectrum.exact_rgb().map(|channel| (channel * 1e4).round() / 1e4);
        let written = spectrum.rgb().map(|channel| (channel * 1e4).round() / 1e4);
        report.add(
            origin,
            format!("the spectrum of {what} has a color that RGB cannot hold"),
            "this spectrum",
            &format!("it is {exact:?} in linear sRGB; RGB targets get {written:?}"),
            "broaden its peak, or write the `rgb(...)` that is meant".to_owned(),
        );
    };
    for (handle, material) in scene.materials.iter() {
        let color = match &material.bsdf {
            Bsdf::Diffuse { reflectance } | Bsdf::Plastic { reflectance, ior: _, alpha: _ } => reflectance.color(),
            Bsdf::Principled { base, metallic: _, roughness: _, ior: _ } => base.color(),
            Bsdf::Mirror { reflectance } => Some(reflectance),
            // Indices of refraction are no colors.
            Bsdf::Conductor { eta: _, k: _, alpha: _ } | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {
                None
            }
        };
        say(scene.materials.origin(handle), format!("`{}`", material.name), color);
    }
    for (origin, shape) in scene.surfaces() {
        say(origin, format!("`{}`", shape.name), shape.emission.as_ref().map(|emission| &emission.radiance));
    }
    for (origin, light) in scene.lights.entries() {
        say(origin, format!("`{}`", light.name), Some(light.kind.color()));
    }
}

fn is_cut(spectrum: &Spectrum) -> bool {
    let written = spectrum.rgb();
    let largest = written.iter().fold(0.0_f64, |most, channel| most.max(*channel));
    spectrum
        .exact_rgb()
        .iter()
        .zip(written)
        .any(|(exact, written)| (exact - written).abs() > LEAST * largest.max(LEAST))
}
