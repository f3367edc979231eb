//! How far pbrt-v4, which is always spectral, lies from RGB for the colors of one scene.

use super::uplift::{Light, TABLE, Values, given, in_daylight, reflectance, unbounded};
use crate::capability::{Bound, Feature};
use crate::formats::shared::bounds::{self, metals};
use crate::formats::shared::fresnel;
use crate::ir::{Bsdf, Color, ColorOrTexture, Emission, LightSource, Material, Scene, Shape};

/// More colors than this are not looked at: their pairs would take too long.
const MOST: usize = 100;

/// A channel with less than this share of the brightest one is black: what is seen in it may be anything of that order, below 0
/// even, and a share of it says nothing.
const BLACK: f64 = 0.02;

/// Angles in degrees at which metals are looked at.
const ANGLES: [f64; 6] = [0.0, 30.0, 45.0, 60.0, 75.0, 85.0];

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// See [`crate::formats::Target::bound`].
pub fn bound(feature: Feature, scene: &Scene) -> Option<Bound> {
    if feature == Feature::ColoredDiffuse {
        of_products(scene, |_, surfaces| surfaces > 0)
    } else if feature == Feature::ColoredEmitter {
        of_products(scene, |colored, _| colored)
    } else if feature == Feature::ColoredConductor {
        of_metals(scene)
    } else {
        bounds::of_correlation(feature, scene)
    }
}

/// A color of the scene: who has it, how much of each channel, and the spectrum that stands for it.
struct Colored<'s, S> {
    name: &'s str,
    rgb: [f64; 3],
    spectrum: S,
    /// Whether the spectrum is one that pbrt-v4 makes of a color, and not the scene's own.
    made: bool,
}

/// The worst product of a light's color with those of up to two surfaces, of those that are `wanted`: whether the light has a
/// color, and how many surfaces.
fn of_products(scene: &Scene, wanted: impl Fn(bool, usize) -> bool) -> Option<Bound> {
    let (lights, surfaces) = (lights(scene)?, surfaces(scene)?);
    let reflections = scene.integrator.max_depth().saturating_sub(1).min(2);
    let mut worst: Option<Bound> = None;
    let mut look = |light: &Colored<'_, Light>, chain: &[&Colored<'_, Values>]| {
        let colored = light.rgb.iter().any(|channel| *channel != light.rgb[0]);
        // Of spectra that the scene gives it is pbrt-v4 that is right.
        let made = (light.made && colored) || chain.iter().any(|surface| surface.made);
        if !made || !wanted(colored, chain.len()) {
            return;
        }
        let exact = [0, 1, 2].map(|c| chain.iter().fold(light.rgb[c], |product, surface| product * surface.rgb[c]));
        let brightest = exact.into_iter().fold(0.0, f64::max);
        let found = light.spectrum.after(chain.iter().map(|surface| &surface.spectrum));
        for channel in 0..3 {
            if exact[channel] <= BLACK * brightest {
                continue;
            }
            let size = (found[channel] / exact[channel] - 1.0).abs() + TABLE * brightest / exact[channel];
            if worst.as_ref().is_none_or(|Bound { size: known, what: _ }| size > *known) {
                let way = match chain {
                    [] => "seen directly".to_owned(),
                    [one] => format!("after `{}`", one.name),
                    more => {
                        let names: Vec<String> = more.iter().map(|surface| format!("`{}`", surface.name)).collect();
                        format!("after {}", names.join(" and "))
                    }
                };
                let shown = |value: f64| format!("{:.4}", value / brightest);
                let what = format!(
                    "of the {} light of `{}` {way} ({} instead of {}, of the brightest channel; channels below 2 % of it \
                     left out), more with each further reflection",
                    CHANNELS[channel],
                    light.name,
                    shown(found[channel]),
                    shown(exact[channel])
                );
                worst = Some(Bound { size, what });
            }
        }
    };
    for light in &lights {
        look(light, &[]);
        for (at, first) in surfaces.iter().enumerate() {
            if reflections >= 1 {
                look(light, &[first]);
            }
            for second in &surfaces[at..] {
                if reflections >= 2 {
                    look(light, &[first, second]);
                }
            }
        }
    }
    worst
}

/// The lights, one for each color; none if there are too many.
fn lights(scene: &Scene) -> Option<Vec<Colored<'_, Light>>> {
    let mut all: Vec<Colored<'_, Light>> = Vec::new();
    let groups = scene.groups.values().flat_map(|group| group.shapes.values());
    let surfaces = scene.shapes.values().chain(groups).filter_map(|Shape { name, emission, .. }| {
        emission.as_ref().map(|Emission { radiance }| (name.as_str(), radiance))
    });
    let plain = scene.lights.values().filter(|light| light.kind.texture().is_none());
    let others = plain.map(|LightSource { name, kind }| (name.as_str(), kind.color()));
    for (name, color) in surfaces.chain(others) {
        let largest = color.rgb().into_iter().fold(0.0, f64::max);
        let rgb = color.rgb().map(|channel| channel / largest);
        // A spectrum of its own is not looked for among the others.
        if largest <= 0.0 || (color.spectrum().is_none() && all.iter().any(|known| known.rgb == rgb)) {
            continue;
        }
        if all.len() == MOST {
            return None;
        }
        all.push(match color.spectrum() {
            Some(_) => Colored { name, rgb: color.rgb(), spectrum: Light::of(color), made: false },
            None => Colored { name, rgb, spectrum: Light::of(&Color::Rgb(rgb)), made: true },
        });
    }
    Some(all)
}

/// The reflectances of diffuse surfaces that are no greys, one for each color; none if there are too many.
fn surfaces(scene: &Scene) -> Option<Vec<Colored<'_, Values>>> {
    let mut all: Vec<Colored<'_, Values>> = Vec::new();
    for Material { name, bsdf, sides: _ } in scene.materials.values() {
        let color = match bsdf {
            Bsdf::Diffuse { reflectance: ColorOrTexture::Color(color) } => color,
            Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(_) }
            | Bsdf::Mirror { reflectance: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
            | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => continue,
        };
        let rgb = color.rgb();
        if color.is_grey() || all.iter().any(|known| known.rgb == rgb) {
            continue;
        }
        if all.len() == MOST {
            return None;
        }
        all.push(match color.spectrum() {
            Some(spectrum) => Colored { name, rgb, spectrum: given(spectrum), made: false },
            None => Colored { name, rgb, spectrum: reflectance(rgb), made: true },
        });
    }
    Some(all)
}

/// The largest share by which what metals reflect of daylight differs from what their channels say.
fn of_metals(scene: &Scene) -> Option<Bound> {
    let mut worst: Option<Bound> = None;
    let mut looked = Vec::new();
    for (name, eta, k, _) in metals(scene, Feature::ColoredConductor) {
        if looked.contains(&(eta, k)) || looked.len() == MOST {
            continue;
        }
        looked.push((eta, k));
        let (etas, ks) = (unbounded(&Color::Rgb(eta)), unbounded(&Color::Rgb(k)));
        for degrees in ANGLES {
            let cosine = libm::cos(degrees.to_radians());
            let found = in_daylight(&std::array::from_fn(|at| fresnel::conductor(etas[at], ks[at], cosine)));
            for channel in 0..3 {
                let exact = fresnel::conductor(eta[channel], k[channel], cosine);
                let size = (found[channel] / exact - 1.0).abs();
                if worst.as_ref().is_none_or(|Bound { size: known, what: _ }| size > *known) {
                    let what = format!(
                        "of the light that `{name}` reflects once, in {} at {degrees} degrees ({:.4} instead of {exact:.4})",
                        CHANNELS[channel], found[channel]
                    );
                    worst = Some(Bound { size, what });
                }
            }
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;
    use crate::ir::{Integrator, LightKind};

    fn room(light: [f64; 3], wall: [f64; 3], max_depth: u32) -> Scene {
        let mut scene = sample::empty("s");
        scene.integrator = Integrator::Path { max_depth };
        sample::material(&mut scene, "wall", Bsdf::Diffuse { reflectance: Color::Rgb(wall).into() });
        let kind = LightKind::Point { position: [0.0; 3], intensity: Color::Rgb(light) };
        scene.lights.push(LightSource { name: "lamp".to_owned(), kind }, crate::diag::Origin::Made);
        scene
    }

    #[test]
    fn one_reflection_of_white_light_is_met_and_others_are_not() {
        let size = |feature, scene: &Scene| bound(feature, scene).map(|Bound { size, what: _ }| size);
        let white = room([1.0; 3], [0.63, 0.065, 0.05], 2);
        assert!(
            size(Feature::ColoredDiffuse, &white).is_some_and(|size| size < 0.025),
            "{:?}",
            bound(Feature::ColoredDiffuse, &white)
        );
        assert_eq!(size(Feature::ColoredEmitter, &white), None);
        let twice = bound(Feature::ColoredDiffuse, &room([1.0; 3], [0.6, 0.2, 0.15], 3)).expect("a bound");
        assert!((0.02..1.0).contains(&twice.size) && twice.what.contains("after `wall` and `wall`"), "{twice:?}");
        // Measured: 79 % of the blue light (`point_light`); the table adds a little.
        let point = bound(Feature::ColoredEmitter, &room([100.0, 50.0, 10.0], [0.8, 0.4, 0.2], 2)).expect("a bound");
        assert!(
            (0.79..0.87).contains(&point.size) && point.what.contains("blue light of `lamp` after `wall`"),
            "{point:?}"
        );
        assert_eq!(size(Feature::ColoredDiffuse, &room([1.0; 3], [0.5; 3], 6)), None);
    }

    #[test]
    fn a_metal_like_copper_is_off_by_what_was_measured() {
        let mut scene = sample::empty("s");
        let (eta, k) = (Color::Rgb([0.200_438, 0.924_033, 1.102_212]), Color::Rgb([3.912_949, 2.452_848, 2.142_188]));
        sample::material(&mut scene, "copper", Bsdf::Conductor { eta, k, alpha: 0.1 });
        let Bound { size, what } = bound(Feature::ColoredConductor, &scene).expect("a bound");
        assert!((0.025..0.1).contains(&size) && what.contains("`copper`"), "{size} {what}");
    }
}
