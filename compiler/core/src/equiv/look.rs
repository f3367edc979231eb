//! Materials and emission as facts.

use std::collections::HashMap;

use super::fact::{Fact, Facts, Measure, short};
use crate::image::{self, Pixels};
use crate::ir::{Bsdf, Color, ColorOrTexture, Emission, Handle, Material, Scene, Texture};

/// How two materials differ: what, what A has, what B has.
pub type Rows = Vec<(String, [String; 2])>;

/// Which images of two scenes are the same: each pair is decoded once.
#[derive(Debug)]
pub struct Images<'s> {
    scenes: [&'s Scene; 2],
    share: f64,
    known: HashMap<(Handle<Texture>, Handle<Texture>), bool>,
}

impl<'s> Images<'s> {
    /// Those of A and B.
    pub fn of(a: &'s Scene, b: &'s Scene, measure: Measure) -> Self {
        Self { scenes: [a, b], share: measure.share, known: HashMap::new() }
    }

    /// Both as facts: the same word where they show the same.
    pub fn facts(&mut self, a: &ColorOrTexture, b: &ColorOrTexture) -> [Fact; 2] {
        let of = |side: usize, paint: &ColorOrTexture| match paint {
            ColorOrTexture::Color(color) => Fact::Color(color.clone()),
            ColorOrTexture::Texture(texture) => Fact::Exact(words(&self.scenes[side].textures[*texture])),
        };
        let facts = [of(0, a), of(1, b)];
        let (Some(one), Some(other)) = (a.texture(), b.texture()) else { return facts };
        let [in_a, in_b] = self.scenes;
        let share = self.share;
        let same = *self
            .known
            .entry((one, other))
            .or_insert_with(|| same_image(&in_a.textures[one], &in_b.textures[other], share));
        let [first, second] = facts;
        match (same, &first, &second) {
            (true, _, _) => [first.clone(), first],
            (false, Fact::Exact(a), Fact::Exact(b)) if a == b => {
                [first.clone(), Fact::Exact(format!("{b}, other pixels"))]
            }
            (false, _, _) => [first, second],
        }
    }
}

/// An image in words: size and mean color, which do not depend on what its file is called.
fn words(texture: &Texture) -> String {
    let mean = image::linear(texture).map_or([0.0; 3], |pixels| mean(&pixels.times(texture.factor)));
    let [r, g, b] = mean.map(|channel| short((channel * 1e4).round() / 1e4));
    format!("an image of {} x {} pixels, mean rgb({r}, {g}, {b})", texture.image.width, texture.image.height)
}

fn mean(pixels: &Pixels) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for y in 0..pixels.height {
        for x in 0..pixels.width {
            sum.iter_mut().zip(pixels.at(x, y)).for_each(|(sum, value)| *sum += f64::from(value));
        }
    }
    let count = (pixels.width * pixels.height).max(1) as f64;
    sum.map(|channel| channel / count)
}

/// Whether two images show the same: every pixel to `share` of the brightest one.
fn same_image(a: &Texture, b: &Texture, share: f64) -> bool {
    if a.file == b.file && a.encoding == b.encoding && a.factor == b.factor {
        return true;
    }
    let plain = |texture: &Texture| image::linear(texture).map(|pixels| pixels.times(texture.factor)).ok();
    let (Some(one), Some(other)) = (plain(a), plain(b)) else { return false };
    let within = share * f64::from(one.peak().max(other.peak()));
    let near =
        |x, y| one.at(x, y).iter().zip(other.at(x, y)).all(|(a, b)| (f64::from(*a) - f64::from(b)).abs() <= within);
    (one.width, one.height) == (other.width, other.height)
        && (0..one.height).all(|y| (0..one.width).all(|x| near(x, y)))
}

/// How two materials differ. Where `turned`, B's surface has its normals to the other side, so that its inside is A's outside.
pub fn materials(a: &Material, b: &Material, turned: bool, images: &mut Images<'_>, measure: Measure) -> Rows {
    let sides = [sides(a, false), sides(b, turned)];
    let (a, b) = (&a.bsdf, &b.bsdf);
    if a.is_black() && b.is_black() {
        return Vec::new();
    }
    let paints = match (a.paint(), b.paint()) {
        (Some(a), Some(b)) => images.facts(a, b).map(Some),
        (Some(a), None) => [Some(images.facts(a, a)[0].clone()), None],
        (None, Some(b)) => [None, Some(only_b(images, b))],
        (None, None) => [None, None],
    };
    let [paint_a, paint_b] = paints;
    let mut rows = facts(a, paint_a, false).differences(&facts(b, paint_b, turned), measure);
    if sides[0] != sides[1] {
        rows.push(("sides that scatter light".to_owned(), sides.map(str::to_owned)));
    }
    rows
}

/// On which sides of A's surface a material scatters light.
fn sides(material: &Material, turned: bool) -> &'static str {
    match (material.is_one_sided(), turned) {
        (false, _) => "both",
        (true, false) => "the front",
        (true, true) => "the back",
    }
}

fn only_b(images: &Images<'_>, paint: &ColorOrTexture) -> Fact {
    match paint {
        ColorOrTexture::Color(color) => Fact::Color(color.clone()),
        ColorOrTexture::Texture(texture) => Fact::Exact(words(&images.scenes[1].textures[*texture])),
    }
}

/// A material as facts; `paint` is that of what may be a texture.
fn facts(bsdf: &Bsdf, paint: Option<Fact>, turned: bool) -> Facts {
    let paint = || paint.clone().unwrap_or(Fact::Color(Color::BLACK));
    let number = |value: &f64| Fact::Number(*value, "");
    let rows = match bsdf {
        Bsdf::Diffuse { reflectance: _ } => vec![("reflectance", paint())],
        Bsdf::Conductor { eta, k, alpha } => {
            vec![("eta", Fact::Color(eta.clone())), ("k", Fact::Color(k.clone())), ("alpha", number(alpha))]
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let (inside, outside) = if turned { (exterior, interior) } else { (interior, exterior) };
            vec![("interior", number(inside)), ("exterior", number(outside)), ("alpha", number(alpha))]
        }
        Bsdf::Mirror { reflectance } => vec![("reflectance", Fact::Color(reflectance.clone()))],
        Bsdf::Plastic { reflectance: _, ior, alpha } => {
            vec![("reflectance", paint()), ("ior", number(ior)), ("alpha", number(alpha))]
        }
        Bsdf::Principled { base: _, metallic, roughness, ior } => vec![
            ("base", paint()),
            ("metallic", number(metallic)),
            ("roughness", number(roughness)),
            ("ior", number(ior)),
        ],
    };
    Facts { word: bsdf.word(), rows }
}

/// The radiance of what emits any light.
pub fn radiance(emission: Option<&Emission>) -> Option<&Color> {
    emission.map(|emission| &emission.radiance).filter(|radiance| !radiance.is_black())
}
