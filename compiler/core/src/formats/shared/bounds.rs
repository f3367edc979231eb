//! How far off a target is for one scene: bounds that several formats compute from a scene's own numbers.

use super::fresnel;
use super::microfacet::{Masking, albedo};
use crate::capability::{Bound, Feature, SHARP_ALPHA, WIDE_ALPHA};
use crate::ir::{Bsdf, Material, Scene};

/// Angles of incidence that are looked at: so many to a degree, from 0 to 90.
const TO_A_DEGREE: u32 = 4;

/// Directions for which masking is compared, as cosines of their angles to the normal. What is stated says where they end.
const SEEN: [f64; 5] = [1.0, 0.8, 0.6, 0.4, 0.2];

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// A metal of a scene: its name, `eta` and `k` per channel, `alpha`.
pub type Metal<'s> = (&'s str, [f64; 3], [f64; 3], f64);

/// The metals of a scene of which `feature` is asked.
pub fn metals(scene: &Scene, feature: Feature) -> impl Iterator<Item = Metal<'_>> {
    scene.materials.values().filter_map(move |Material { name, bsdf, sides: _ }| match bsdf {
        Bsdf::Conductor { eta, k, alpha } => {
            let kinds = [
                (Feature::SmoothConductor, *alpha == 0.0),
                (Feature::RoughConductor, *alpha > 0.0),
                (Feature::SharpConductor, *alpha > 0.0 && *alpha < SHARP_ALPHA),
                (Feature::WideConductor, *alpha > WIDE_ALPHA),
                (Feature::ColoredConductor, !eta.is_grey() || !k.is_grey()),
            ];
            kinds.contains(&(feature, true)).then(|| (name.as_str(), eta.rgb(), k.rgb(), *alpha))
        }
        Bsdf::Diffuse { reflectance: _ }
        | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
        | Bsdf::Mirror { reflectance: _ }
        | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
        | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => None,
    })
}

/// The larger of two bounds.
pub fn larger(a: Option<Bound>, b: Option<Bound>) -> Option<Bound> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.size > a.size { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// Two bounds that hold at once: the larger product of both changes.
pub fn both(a: Option<Bound>, b: Option<Bound>) -> Option<Bound> {
    match (a, b) {
        (Some(a), Some(b)) => {
            let size = (1.0 + a.size) * (1.0 + b.size) - 1.0;
            let what = format!("of it: {:.2} % {}, and {:.2} % {}", 100.0 * a.size, a.what, 100.0 * b.size, b.what);
            Some(Bound { size, what })
        }
        (a, b) => a.or(b),
    }
}

/// The largest share by which a Fresnel term differs from the exact one, over metals, channels and angles.
/// `term` takes `eta` and `k` and gives what the target computes for a cosine.
pub fn of_fresnel<'s, F: Fn(f64) -> f64>(
    metals: impl Iterator<Item = Metal<'s>>,
    term: impl Fn(f64, f64) -> F,
) -> Option<Bound> {
    let mut worst = None;
    for (name, eta, k, _) in metals {
        for (channel, word) in CHANNELS.iter().enumerate() {
            let of = term(eta[channel], k[channel]);
            for at in 0..=90 * TO_A_DEGREE {
                let degrees = f64::from(at) / f64::from(TO_A_DEGREE);
                let cosine = libm::cos(degrees.to_radians()).max(0.0);
                let exact = fresnel::conductor(eta[channel], k[channel], cosine);
                let size = (of(cosine) - exact).abs() / exact;
                if worst.as_ref().is_none_or(|Bound { size: known, what: _ }| size > *known) {
                    let what = format!(
                        "of the light that `{name}` reflects once, in {word} at {degrees} degrees ({:.4} instead of {exact:.4})",
                        of(cosine)
                    );
                    worst = Some(Bound { size, what });
                }
            }
        }
    }
    worst
}

/// The largest share by which a masking term changes what metals reflect, against Smith's.
pub fn of_masking<'s>(metals: impl Iterator<Item = Metal<'s>>, masking: Masking) -> Option<Bound> {
    let mut worst: Option<Bound> = None;
    let mut known: Vec<f64> = Vec::new();
    for (name, _, _, alpha) in metals {
        if alpha == 0.0 || known.contains(&alpha) {
            continue;
        }
        known.push(alpha);
        for cosine in SEEN {
            let change = albedo(alpha, cosine, masking) / albedo(alpha, cosine, Masking::Smith) - 1.0;
            if worst.as_ref().is_none_or(|Bound { size, what: _ }| change.abs() > *size) {
                let degrees = libm::acos(cosine).to_degrees();
                let most = libm::acos(SEEN[SEEN.len() - 1]).to_degrees();
                let way = if change < 0.0 { "too dark" } else { "too bright" };
                let what = format!(
                    "of the light that `{name}` of `alpha` {alpha} reflects once, {way}, seen at {degrees:.0} degrees (flatter than {most:.0} is not looked at)"
                );
                worst = Some(Bound { size: change.abs(), what });
            }
        }
    }
    worst
}

/// What was measured of rough glass at a width: the largest share by which rings of a ball under even light differ from Mitsuba 3.
pub type Glass = (f64, f64);

/// How far off rough glass is where that was `measured` at some widths, from narrow to wide; between two of them by a straight line.
pub fn of_glass(scene: &Scene, measured: &[Glass]) -> Option<Bound> {
    let at = |alpha: f64| {
        let above = measured.partition_point(|(width, _)| *width < alpha);
        match (above.checked_sub(1).and_then(|below| measured.get(below)), measured.get(above)) {
            (Some((low, a)), Some((high, b))) => a + (b - a) * (alpha - low) / (high - low),
            (None, Some((_, size))) | (Some((_, size)), None) => *size,
            (None, None) => 0.0,
        }
    };
    let rough = scene.materials.values().filter_map(|Material { name, bsdf, sides: _ }| match bsdf {
        Bsdf::Dielectric { interior: _, exterior: _, alpha } if *alpha > 0.0 => Some((name, *alpha)),
        Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
        | Bsdf::Diffuse { reflectance: _ }
        | Bsdf::Conductor { eta: _, k: _, alpha: _ }
        | Bsdf::Mirror { reflectance: _ }
        | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
        | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => None,
    });
    let (name, alpha) = rough.max_by(|a, b| at(a.1).total_cmp(&at(b.1)))?;
    let what = format!(
        "of the light from a ball of `{name}` of `alpha` {alpha} and index 1.5 under even light, against Mitsuba 3, by what was measured up to \
         0.95 of its radius"
    );
    Some(Bound { size: at(alpha), what })
}

/// How far off the targets are whose masking and shadowing are correlated by height.
pub fn of_correlation(feature: Feature, scene: &Scene) -> Option<Bound> {
    let wide = (feature == Feature::WideConductor).then(|| metals(scene, feature));
    wide.and_then(|metals| of_masking(metals, Masking::HeightCorrelated))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;
    use crate::ir::Color;

    fn gold(alpha: f64) -> Scene {
        let mut scene = sample::empty("s");
        let (eta, k) = (Color::Rgb([0.143_119, 0.374_957, 1.442_48]), Color::Rgb([3.983_16, 2.385_72, 1.603_22]));
        sample::material(&mut scene, "gold", Bsdf::Conductor { eta, k, alpha });
        scene
    }

    #[test]
    fn the_exact_term_is_not_off_and_schlick_is() {
        let scene = gold(0.1);
        let metals = || metals(&scene, Feature::RoughConductor);
        let exact = of_fresnel(metals(), |eta, k| move |cosine| fresnel::conductor(eta, k, cosine)).expect("a metal");
        assert_eq!(exact.size, 0.0);
        let schlick = of_fresnel(metals(), |eta, k| {
            let head_on = fresnel::head_on(eta, k);
            move |cosine| fresnel::schlick(head_on, cosine)
        })
        .expect("a metal");
        assert!((0.02..0.2).contains(&schlick.size) && schlick.what.contains("`gold`"), "{schlick:?}");
    }

    #[test]
    fn glass_is_as_far_off_as_was_measured() {
        let measured = [(0.1, 0.02), (0.5, 0.1), (1.0, 0.6)];
        let of = |alpha: f64| {
            let mut scene = sample::empty("s");
            for (at, alpha) in [0.0, alpha].into_iter().enumerate() {
                let name = format!("glass {at}");
                sample::material(&mut scene, &name, Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha });
            }
            of_glass(&scene, &measured)
        };
        let close = |alpha: f64, size: f64| (of(alpha).expect("rough glass").size - size).abs() < 1e-12;
        assert!(close(0.01, 0.02) && close(0.1, 0.02) && close(0.3, 0.06) && close(0.75, 0.35) && close(1.0, 0.6));
        assert_eq!(of(0.0), None);
        assert!(of(0.3).expect("rough glass").what.contains("`glass 1` of `alpha` 0.3"));
    }

    #[test]
    fn only_the_metals_that_are_asked_for_count() {
        assert_eq!(of_correlation(Feature::WideConductor, &gold(0.1)), None);
        let wide = of_correlation(Feature::WideConductor, &gold(1.0)).expect("a wide metal");
        assert!((0.01..0.3).contains(&wide.size) && wide.what.contains("too bright"), "{wide:?}");
        assert_eq!(metals(&gold(0.0), Feature::RoughConductor).count(), 0);
        assert_eq!(metals(&gold(0.0), Feature::SmoothConductor).count(), 1);
    }
}
