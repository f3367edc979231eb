//! Rule `saturated-albedo`: colors that mean the same in RGB and as spectra.
#![doc = include_str!("saturated_albedo.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{Bsdf, Color};

pub(super) const RULE: Rule = Rule {
    id: "saturated-albedo",
    level: Level::Warn,
    summary: "A saturated reflectance is seen over several bounces, which RGB and spectral renderers multiply differently.",
    doc: include_str!("saturated_albedo.md"),
    targets: &["pbrt-v4"],
    check,
};

/// The least ratio of the smallest channel to the largest. At 0.2 two bounces differ by up to 16 % of the largest channel, and in
/// their luminance by up to 24 %; at 0.4 by 7 and 9 % (computed, see the page).
const RATIO: f64 = 0.2;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    // Two bounces off surfaces: the light's segment, one between them, and the camera's.
    if scene.integrator.max_depth() < 3 {
        return;
    }
    for (handle, material) in scene.materials.iter() {
        let color = match &material.bsdf {
            Bsdf::Diffuse { reflectance } | Bsdf::Plastic { reflectance, ior: _, alpha: _ } => reflectance.color(),
            Bsdf::Principled { base, metallic: _, roughness: _, ior: _ } => base.color(),
            Bsdf::Mirror { reflectance } => Some(reflectance),
            Bsdf::Conductor { eta: _, k: _, alpha: _ } | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {
                None
            }
        };
        let rgb = match color {
            Some(Color::Rgb(rgb)) => *rgb,
            // A grey is the same everywhere, and pbrt-v4 keeps a spectrum as it is.
            Some(Color::Grey(_) | Color::Spectrum(_)) | None => continue,
        };
        let (least, most) =
            (rgb.iter().fold(f64::INFINITY, |a, b| a.min(*b)), rgb.iter().fold(0.0_f64, |a, b| a.max(*b)));
        if most <= 0.0 || least >= RATIO * most {
            continue;
        }
        report.add(
            scene.materials.origin(handle),
            format!("the reflectance of `{}` is saturated", material.name),
            &format!("its smallest channel is {:.2} of its largest", least / most),
            "pbrt-v4 makes a spectrum of it, whose square is not the square of its channels: light that meets it twice has another color",
            format!("keep the smallest channel above {RATIO} of the largest"),
        );
    }
}
