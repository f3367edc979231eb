//! How much light a material reflects at some angles: from the Scene, and from what the parameters of a format mean.
//!
//! Of a rough material it is the Fresnel term of the mean surface; the width of its distribution is compared as a number of its
//! own. Of an image it is what a grey of 0.5 in it would give; that it is the same image is compared apart.

use crate::formats::shared::coat::{Coat, normal_reflectance};
use crate::formats::shared::fresnel::{conductor, dielectric};
use crate::formats::shared::reading::{Fresnel, Inside, Model, Paint, Rgb, Surface};
use crate::ir::{Bsdf, ColorOrTexture};

/// Angles of incidence in degrees.
pub const ANGLES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// A number that went through text, and a few operations in double precision.
pub const TEXT: f64 = 1e-9;

/// Whether two numbers are farther apart than `by`; what is not a number is.
pub fn off(a: f64, b: f64, by: f64) -> bool {
    let away = (a - b).abs();
    away.is_nan() || away > by
}

/// The grey of an image that is not looked at.
const GREY: f64 = 0.5;

/// What a material looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The share of light reflected at each of [`ANGLES`].
    pub reflected: [Rgb; 4],
    /// How many of the angles mean something: all, or only the first, where a program has a Fresnel term of its own.
    pub known: usize,
    /// The GGX width; none for a diffuse surface.
    pub alpha: Option<f64>,
    /// The share of metal.
    pub metal: f64,
    /// The relative index of refraction of a surface that lets light through.
    pub through: Option<f64>,
}

fn cosines() -> [f64; 4] {
    ANGLES.map(|degrees| crate::ir::sin_cos_degrees(degrees).1)
}

fn all(channel: impl Fn(f64, usize) -> f64) -> [Rgb; 4] {
    cosines().map(|cosine| [0, 1, 2].map(|at| channel(cosine, at)))
}

fn over(coat: f64, base: f64) -> f64 {
    coat + (1.0 - coat) * base
}

/// The color, or what stands for an image with this factor.
fn painted(paint: &ColorOrTexture, factor: Rgb) -> Rgb {
    paint.color().map_or(factor.map(|x| x * GREY), crate::ir::Color::rgb)
}

/// What the scene asks for. `ceiling` is the largest reflectance head-on that a format can give a coat, `factor` that of an image
/// which is not in the image itself.
pub fn asked(bsdf: &Bsdf, ceiling: f64, factor: Rgb) -> Look {
    let look = |reflected, known, alpha, metal| Look { reflected, known, alpha, metal, through: None };
    match bsdf {
        Bsdf::Diffuse { reflectance } => {
            let base = painted(reflectance, factor);
            look(all(|_, at| base[at]), 4, None, 0.0)
        }
        Bsdf::Conductor { eta, k, alpha } => {
            let (eta, k) = (eta.rgb(), k.rgb());
            look(all(|cosine, at| conductor(eta[at], k[at], cosine)), 4, Some(*alpha), 1.0)
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let eta = interior / exterior;
            let reflected = all(|cosine, _| dielectric(eta, cosine));
            Look { through: Some(eta), ..look(reflected, 4, Some(*alpha), 0.0) }
        }
        Bsdf::Mirror { reflectance } => {
            let tint = reflectance.rgb();
            look(all(|_, at| tint[at]), 4, Some(0.0), 1.0)
        }
        Bsdf::Plastic { reflectance, ior, alpha } => {
            let (base, coat) = (painted(reflectance, factor), Coat::new(*ior));
            let reflected = all(|cosine, at| over(dielectric(*ior, cosine), coat.seen(base[at])));
            look(reflected, 4, Some(*alpha), 0.0)
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            let (base, coat) = (painted(base, factor), normal_reflectance(*ior).min(ceiling));
            let reflected = all(|_, at| metallic * base[at] + (1.0 - metallic) * over(coat, base[at]));
            look(reflected, 1, Some(roughness * roughness), *metallic)
        }
    }
}

fn tinted(paint: &Paint) -> Rgb {
    match paint {
        Paint::Color(color) => *color,
        Paint::Image { file: _, linear: _, factor } => factor.map(|x| x * GREY),
    }
}

/// What the parameters of a format mean.
pub fn said(model: &Model) -> Look {
    let look = |reflected, known, alpha, metal| Look { reflected, known, alpha, metal, through: None };
    match model {
        Model::Diffuse { reflectance } => {
            let base = tinted(reflectance);
            look(all(|_, at| base[at]), 4, None, 0.0)
        }
        Model::Conductor { fresnel, tint, alpha } => {
            let tint = tinted(tint);
            let (reflected, known) = match fresnel {
                Fresnel::Exact { eta, k } => (all(|cosine, at| tint[at] * conductor(eta[at], k[at], cosine)), 4),
                Fresnel::Fitted { n, k, term, most: _ } => (all(|cosine, at| tint[at] * term(n[at], k[at], cosine)), 4),
                Fresnel::Constant => (all(|_, at| tint[at]), 4),
                Fresnel::HeadOn => (all(|_, at| tint[at]), 1),
            };
            look(reflected, known, Some(*alpha), 1.0)
        }
        Model::Dielectric { eta, alpha } => {
            let reflected = all(|cosine, _| dielectric(*eta, cosine));
            Look { through: Some(*eta), ..look(reflected, 4, Some(*alpha), 0.0) }
        }
        Model::Coated { base, inside, ior, alpha } => {
            let (base, coat) = (tinted(base), Coat::new(*ior));
            let seen = |share: f64| match inside {
                Inside::Base => coat.seen(share),
                Inside::Seen => share,
            };
            look(all(|cosine, at| over(dielectric(*ior, cosine), seen(base[at]))), 4, Some(*alpha), 0.0)
        }
        Model::Principled { base, metallic, alpha, specular, ceiling: _ } => {
            let base = tinted(base);
            let reflected = all(|_, at| metallic * base[at] + (1.0 - metallic) * over(*specular, base[at]));
            look(reflected, 1, Some(*alpha), *metallic)
        }
        Model::Mix { share, parts } => {
            let [first, second] = [said(&parts[0]), said(&parts[1])];
            let blend = |a: f64, b: f64| (1.0 - share) * a + share * b;
            let at = |angle: usize| [0, 1, 2].map(|at| blend(first.reflected[angle][at], second.reflected[angle][at]));
            let same = first.alpha == second.alpha && first.through.is_none() && second.through.is_none();
            Look {
                reflected: [0, 1, 2, 3].map(at),
                known: first.known.min(second.known),
                // A width that is none of both is equal to nothing.
                alpha: if same { first.alpha } else { Some(f64::NAN) },
                metal: blend(first.metal, second.metal),
                through: None,
            }
        }
    }
}

/// What a surface is from behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Back {
    /// The same as from the front.
    Scatters,
    /// Black.
    Black,
    /// One or the other: where the format lights no back of an emitter, or has no surfaces that are black from behind.
    Either,
}

/// What is compared.
pub struct Materials<'a> {
    /// By the scene.
    pub bsdf: &'a Bsdf,
    /// By the file.
    pub surface: &'a Surface,
    /// What a surface is to be from behind.
    pub back: Back,
    /// Whether the format says of this material that it cannot be exact in what is seen of it: only its kind is compared.
    pub excused: bool,
    /// The factor of the material's image that is not in the image itself; 1 without one.
    pub factor: Rgb,
}

/// How far reflectances may be apart, for each channel.
fn bounds(bsdf: &Bsdf, model: &Model) -> Rgb {
    let fitted = match model {
        Model::Conductor { fresnel: Fresnel::Fitted { n: _, k: _, term: _, most }, tint: _, alpha: _ } => Some(most),
        Model::Conductor {
            fresnel: Fresnel::Exact { .. } | Fresnel::Constant | Fresnel::HeadOn,
            tint: _,
            alpha: _,
        }
        | Model::Diffuse { reflectance: _ }
        | Model::Dielectric { eta: _, alpha: _ }
        | Model::Coated { base: _, inside: _, ior: _, alpha: _ }
        | Model::Principled { base: _, metallic: _, alpha: _, specular: _, ceiling: _ }
        | Model::Mix { share: _, parts: _ } => None,
    };
    match (bsdf, fitted) {
        (Bsdf::Conductor { eta, k, alpha: _ }, Some(most)) => {
            // The fit says how far it is from the exact term of this very metal.
            let (eta, k) = (eta.rgb(), k.rgb());
            let mut known: Vec<([u64; 2], f64)> = Vec::with_capacity(3);
            [0, 1, 2].map(|at| {
                let key = [eta[at].to_bits(), k[at].to_bits()];
                if let Some((_, most)) = known.iter().find(|(other, _)| *other == key) {
                    return *most;
                }
                let most = most(eta[at], k[at]) + TEXT;
                known.push((key, most));
                most
            })
        }
        (
            Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ }
            | Bsdf::Mirror { reflectance: _ }
            | Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ },
            _,
        ) => [TEXT; 3],
    }
}

/// What differs between a material of the scene and that of a file, in words.
pub fn difference(Materials { bsdf, surface, back, excused, factor }: &Materials<'_>) -> Option<String> {
    let model = &surface.model;
    let ceiling = match model {
        Model::Principled { base: _, metallic: _, alpha: _, specular: _, ceiling } => *ceiling,
        Model::Diffuse { reflectance: _ }
        | Model::Conductor { fresnel: _, tint: _, alpha: _ }
        | Model::Dielectric { eta: _, alpha: _ }
        | Model::Coated { base: _, inside: _, ior: _, alpha: _ }
        | Model::Mix { share: _, parts: _ } => 1.0,
    };
    let (asked, said) = (asked(bsdf, ceiling, *factor), said(model));
    let clear = |look: &Look| look.through.is_some();
    if clear(&asked) != clear(&said) {
        return Some(if clear(&said) { "lets light through" } else { "lets no light through" }.to_owned());
    }
    match back {
        Back::Scatters if !clear(&asked) && !surface.two_sided => return Some("scatters on one side only".to_owned()),
        Back::Black if surface.two_sided => return Some("scatters on both sides".to_owned()),
        Back::Scatters | Back::Black | Back::Either => {}
    }
    let near = |a: f64, b: f64| !off(a, b, TEXT * a.abs().max(1e-3));
    match (asked.alpha, said.alpha) {
        (None, None) => {}
        (Some(a), Some(b)) if near(a, b) => {}
        (a, b) => {
            let word = |alpha: Option<f64>| alpha.map_or("none (a diffuse surface)".to_owned(), |x| x.to_string());
            return Some(format!("has the width `alpha` {} instead of {}", word(b), word(a)));
        }
    }
    if let (Bsdf::Plastic { reflectance: _, ior, alpha: _ }, Model::Coated { base: _, inside: _, ior: coat, alpha: _ }) =
        (bsdf, model)
        && !near(*ior, *coat)
    {
        return Some(format!("has a coat of the index of refraction {coat} instead of {ior}"));
    }
    if *excused {
        return None;
    }
    if !near(asked.metal, said.metal) {
        return Some(format!("is metal by {} instead of {}", said.metal, asked.metal));
    }
    if let (Some(a), Some(b)) = (asked.through, said.through)
        && !near(a, b)
    {
        return Some(format!("has the relative index of refraction {b} instead of {a}"));
    }
    let by = bounds(bsdf, model);
    for (at, degrees) in ANGLES.iter().enumerate().take(asked.known.min(said.known)) {
        let (a, b) = (asked.reflected[at], said.reflected[at]);
        if (0..3).any(|channel| off(a[channel], b[channel], by[channel])) {
            return Some(format!("reflects {b:?} of the light instead of {a:?} at {degrees} degrees"));
        }
    }
    None
}

/// The image that a model shows, if it shows one.
pub fn image(model: &Model) -> Option<&Paint> {
    let of = |paint| if matches!(paint, &Paint::Image { .. }) { Some(paint) } else { None };
    match model {
        Model::Diffuse { reflectance } => of(reflectance),
        Model::Conductor { fresnel: _, tint, alpha: _ } => of(tint),
        Model::Dielectric { eta: _, alpha: _ } => None,
        Model::Coated { base, inside: _, ior: _, alpha: _ }
        | Model::Principled { base, metallic: _, alpha: _, specular: _, ceiling: _ } => of(base),
        Model::Mix { share: _, parts } => parts.iter().find_map(image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::luxcore::fresnel;
    use crate::ir::Color;

    fn like_luxcore(n: Rgb, k: Rgb) -> Fresnel {
        Fresnel::Fitted { n, k, term: fresnel::approximate, most: |eta, k| fresnel::fit(eta, k).most }
    }

    fn surface(model: Model) -> Surface {
        Surface { name: "m".to_owned(), model, two_sided: true }
    }

    fn differs(bsdf: &Bsdf, model: Model) -> Option<String> {
        difference(&Materials {
            bsdf,
            surface: &surface(model),
            back: Back::Scatters,
            excused: false,
            factor: [1.0; 3],
        })
    }

    #[test]
    fn the_fitted_metal_is_near_and_another_one_is_not() {
        let (eta, k) = ([0.2, 0.924, 1.102], [3.913, 2.453, 2.142]);
        let bsdf = Bsdf::Conductor { eta: Color::Rgb(eta), k: Color::Rgb(k), alpha: 0.0625 };
        let fits = [0, 1, 2].map(|at| fresnel::fit(eta[at], k[at]));
        let (n, fitted) = (fits.map(|fit| fit.n), fits.map(|fit| fit.k));
        let metal = |n, k, alpha| Model::Conductor { fresnel: like_luxcore(n, k), tint: Paint::WHITE, alpha };
        assert_eq!(differs(&bsdf, metal(n, fitted, 0.0625)), None);
        assert!(differs(&bsdf, metal(n, fitted, 0.0625 * 0.0625)).is_some_and(|found| found.contains("alpha")));
        assert!(differs(&bsdf, metal(eta, k, 0.0625)).is_some(), "the numbers themselves are not near");
        assert!(differs(&bsdf, metal(n, fitted.map(|x| x * 1.5), 0.0625)).is_some());
    }

    #[test]
    fn what_is_seen_of_a_base_and_the_base_are_the_same() {
        let bsdf = Bsdf::Plastic { reflectance: Color::Grey(0.4).into(), ior: 1.5, alpha: 0.1 };
        let coated = |base: f64, inside| Model::Coated { base: Paint::Color([base; 3]), inside, ior: 1.5, alpha: 0.1 };
        assert_eq!(differs(&bsdf, coated(0.4, Inside::Base)), None);
        assert_eq!(differs(&bsdf, coated(Coat::new(1.5).seen(0.4), Inside::Seen)), None);
        assert!(differs(&bsdf, coated(0.4, Inside::Seen)).is_some());
    }

    #[test]
    fn a_mix_of_coat_and_metal_is_principled_head_on() {
        let bsdf = Bsdf::Principled { base: Color::Grey(0.3).into(), metallic: 0.4, roughness: 0.5, ior: 1.5 };
        let paint = || Paint::Color([0.3; 3]);
        let mix = |share: f64, alpha: f64| Model::Mix {
            share,
            parts: Box::new([
                Model::Coated { base: paint(), inside: Inside::Seen, ior: 1.5, alpha: 0.25 },
                Model::Conductor { fresnel: Fresnel::HeadOn, tint: paint(), alpha },
            ]),
        };
        assert_eq!(differs(&bsdf, mix(0.4, 0.25)), None);
        assert!(differs(&bsdf, mix(0.5, 0.25)).is_some_and(|found| found.contains("metal")));
        assert!(differs(&bsdf, mix(0.4, 0.5)).is_some_and(|found| found.contains("alpha")));
    }

    #[test]
    fn numbers_that_are_none_differ() {
        let bsdf = Bsdf::Diffuse { reflectance: Color::Grey(0.3).into() };
        assert!(differs(&bsdf, Model::Diffuse { reflectance: Paint::Color([f64::NAN; 3]) }).is_some());
        let one = Surface { two_sided: false, ..surface(Model::Diffuse { reflectance: Paint::Color([0.3; 3]) }) };
        let found = difference(&Materials {
            bsdf: &bsdf,
            surface: &one,
            back: Back::Scatters,
            excused: false,
            factor: [1.0; 3],
        });
        assert_eq!(found.as_deref(), Some("scatters on one side only"));
    }
}
