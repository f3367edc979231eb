//! On what a difference lies: on edges, on lamps, on a material.
//!
//! The square of a difference has the variances of both images in it on average, whatever else it has. What is left without them is the
//! difference itself, and can be shared out among the pixels that see something in common. Pixels that the verdict leaves out because
//! they show a light directly have no part in it.

use serde::{Deserialize, Serialize};

use ltsc_core::survey::Seen;
use ltsc_render::image::{Image, finite};

use super::verdict::glare;

/// Groups of pixels with less of the difference than this share are not told.
const LEAST: f64 = 0.1;

/// A group is told of where its squared difference is larger than that of noise by so many standard errors of it.
const SIGNIFICANT: f64 = 4.0;

/// A value that differs by less than this share of itself is the same one, rounded: renderers calculate in single precision.
const ROUNDED: f64 = 1e-4;

/// What pixels have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A neighbor sees something else.
    Edge,
    /// A lamp is seen.
    Emitter,
    /// A material is seen.
    Material,
    /// No surface is seen.
    Background,
}

/// A group of pixels, and its part of the difference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Blame {
    /// What its pixels have in common.
    pub kind: Kind,
    /// The name of the material, or of its constructor where it has none; empty for the others.
    pub name: String,
    /// Its share of the pixels.
    pub pixels: f64,
    /// Its share of the squared difference that is found on all groups, without that of noise.
    pub share: f64,
    /// B / A over its pixels and channels; none where A is black.
    pub ratio: Option<f64>,
}

/// A mean with its variance in each pixel, where that is known.
#[derive(Clone, Copy)]
pub struct Noisy<'i> {
    /// The mean.
    pub mean: &'i Image,
    /// The variance of that mean; none of a reference that is taken to be free of noise.
    pub variance: Option<&'i Image>,
}

impl Noisy<'_> {
    fn variance(&self, pixel: usize) -> [f64; 3] {
        self.variance.map_or([0.0; 3], |variance| variance.pixels[pixel].map(f64::from))
    }
}

/// Sums over the pixels of a group.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: f64,
    a: f64,
    b: f64,
    /// Squared differences without the variances.
    squares: f64,
    /// What the variance of that sum is, if there is no difference.
    spread: f64,
}

/// The groups that a difference lies on, the largest part first; none where noise may have made all of it, or sizes differ.
#[must_use]
pub fn blame(a: Noisy<'_>, b: Noisy<'_>, seen: &Seen) -> Vec<Blame> {
    let size = (seen.width, seen.height);
    let fits = |image: &Image| (image.width, image.height) == size;
    if !fits(a.mean) || !fits(b.mean) || !a.variance.is_none_or(fits) || !b.variance.is_none_or(fits) {
        return Vec::new();
    }
    let mut groups: std::collections::BTreeMap<(Kind, &str), Sums> = std::collections::BTreeMap::new();
    let mut pixels = 0.0;
    let both = || a.mean.pixels.iter().zip(&b.mean.pixels);
    let light = |(a, b): (&[f32; 3], &[f32; 3])| {
        (finite(a) && finite(b)).then(|| a.iter().map(|value| f64::from(*value)).sum::<f64>())
    };
    let light: Vec<Option<f64>> = both().map(light).collect();
    let glare = glare(&light, seen.width);
    for (pixel, (of_a, of_b)) in both().enumerate() {
        if light[pixel].is_none() || glare[pixel] {
            continue;
        }
        let (va, vb) = (a.variance(pixel), b.variance(pixel));
        let mut sums = Sums { pixels: 1.0, ..Sums::default() };
        for channel in 0..3 {
            let (x, y) = (f64::from(of_a[channel]), f64::from(of_b[channel]));
            let variance = va[channel] + vb[channel] + (ROUNDED * x).powi(2);
            sums.a += x;
            sums.b += y;
            sums.squares += (y - x).powi(2) - variance;
            // Of a normal deviate the square has a variance of twice its own squared; channels of a pixel go together.
            sums.spread += 3.0 * 2.0 * variance * variance;
        }
        pixels += 1.0;
        let of = groups.entry(group(seen, pixel)).or_default();
        of.pixels += sums.pixels;
        of.a += sums.a;
        of.b += sums.b;
        of.squares += sums.squares;
        of.spread += sums.spread;
    }
    // A group whose noise hides its part has none to tell: edges of lamps must not hide what lies on walls.
    let told: Vec<_> = groups.into_iter().filter(|(_, sums)| sums.squares > SIGNIFICANT * sums.spread.sqrt()).collect();
    let total: f64 = told.iter().map(|(_, sums)| sums.squares).sum();
    let mut all: Vec<Blame> = told
        .into_iter()
        .map(|((kind, name), sums)| Blame {
            kind,
            name: name.to_owned(),
            pixels: sums.pixels / pixels,
            share: sums.squares / total,
            ratio: (sums.a > 0.0).then(|| sums.b / sums.a),
        })
        .filter(|one| one.share >= LEAST)
        .collect();
    all.sort_by(|one, other| other.share.total_cmp(&one.share).then_with(|| one.name.cmp(&other.name)));
    all
}

fn group(seen: &Seen, pixel: usize) -> (Kind, &str) {
    if seen.is_edge(pixel) {
        return (Kind::Edge, "");
    }
    match seen.thing(pixel) {
        None => (Kind::Background, ""),
        Some(thing) if thing.emits => (Kind::Emitter, ""),
        Some(thing) if thing.material.is_empty() => (Kind::Material, thing.kind),
        Some(thing) => (Kind::Material, &thing.material),
    }
}

/// Which pixels are in which group: the groups, and for each pixel the number of its own, 255 where there are more than 255 of them.
#[must_use]
pub fn groups(seen: &Seen) -> (Vec<Group>, Vec<u8>) {
    let mut found: Vec<Group> = Vec::new();
    let pixels = (0..seen.width * seen.height).map(|pixel| {
        let (kind, name) = group(seen, pixel);
        let at = found.iter().position(|known| known.kind == kind && known.name == name).unwrap_or_else(|| {
            found.push(Group { kind, name: name.to_owned() });
            found.len() - 1
        });
        u8::try_from(at).unwrap_or(u8::MAX)
    });
    let pixels = pixels.collect();
    found.truncate(usize::from(u8::MAX));
    (found, pixels)
}

/// Pixels that have something in common.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Group {
    /// What it is.
    pub kind: Kind,
    /// The name of the material, as of [`Blame::name`].
    pub name: String,
}

impl Blame {
    /// In words: `82 % of the difference lies on edges, 7 % of the pixels`.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { kind, name, pixels, share, ratio } = self;
        let on = match kind {
            Kind::Edge => "edges".to_owned(),
            Kind::Emitter => "lamps".to_owned(),
            Kind::Background => "what lies behind all surfaces".to_owned(),
            Kind::Material => format!("the material `{name}`"),
        };
        let ratio = ratio.map_or(String::new(), |ratio| format!(", B / A {ratio:.4}"));
        format!(
            "{:.0} % of the squared difference lies on {on}, {:.0} % of the pixels{ratio}",
            100.0 * share,
            100.0 * pixels
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltsc_core::diag::Sources;
    use ltsc_core::files::{MemoryFiles, VPath};
    use ltsc_core::pipeline::{self, Options};

    /// A wall of `left` and of `right` before the camera, with nothing above them.
    fn seen() -> Seen {
        let text = "lts 1\n/// A.\n///\n/// B.\nscene one { paths: [\"LDE\"] }\ncamera = perspective(eye: (0, -10, 0), target: (0, 0, \
                    0), fov_x: 45deg)\nfilm = image(32, 32)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
                    material left = diffuse(0.5)\nmaterial right = diffuse(0.2)\nshape a = rectangle(x: -9..0, y: 0, z: -9..1, normal: \
                    -Y) with left\nshape b = rectangle(x: 0..9, y: 0, z: -9..1, normal: -Y) with right\nemitter lamp = rectangle(x: \
                    -1..1, y: -9..-8, z: 20, normal: -Z) with radiance(10)\n";
        let mut files = MemoryFiles::default();
        files.insert("one.lts", text);
        let path = VPath::resolve("", "one.lts").expect("a path");
        let scene =
            pipeline::check(&files, &mut Sources::default(), &path, &Options::default()).scene.expect("a scene");
        let camera = scene.cameras.values().next().expect("a camera");
        Seen::of(&scene, camera, (32, 32)).expect("an image")
    }

    fn noisy<'i>(mean: &'i Image, variance: &'i Image) -> Noisy<'i> {
        Noisy { mean, variance: Some(variance) }
    }

    #[test]
    fn a_difference_is_found_on_what_it_lies_on() {
        let seen = seen();
        let flat = Image::filled(32, 32, [1.0; 3]);
        let quiet = Image::filled(32, 32, [1e-6; 3]);
        let mut right = flat.clone();
        let mut edges = flat.clone();
        for pixel in 0..1024 {
            if seen.thing(pixel).is_some_and(|thing| thing.material == "right") && !seen.is_edge(pixel) {
                right.pixels[pixel] = [0.9; 3];
            }
            if seen.is_edge(pixel) {
                edges.pixels[pixel] = [1.2; 3];
            }
        }
        let found = blame(noisy(&flat, &quiet), noisy(&right, &quiet), &seen);
        assert_eq!((found.len(), found[0].kind, found[0].name.as_str()), (1, Kind::Material, "right"), "{found:?}");
        assert!((found[0].ratio.expect("a ratio") - 0.9).abs() < 1e-6 && found[0].share > 0.99);
        let found = blame(noisy(&flat, &quiet), noisy(&edges, &quiet), &seen);
        assert_eq!((found.len(), found[0].kind), (1, Kind::Edge), "{found:?}");
        assert!(found[0].text().contains("lies on edges"), "{}", found[0].text());
    }

    #[test]
    fn noise_is_blamed_on_nothing() {
        let seen = seen();
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        // Uniform noise of width 1 has a variance of 1 / 12.
        let variance = Image::filled(32, 32, [1.0 / 12.0; 3]);
        for _ in 0..50 {
            let mut image = || Image {
                width: 32,
                height: 32,
                pixels: (0..1024).map(|_| [random(), random(), random()].map(|noise| 1.0 + noise)).collect(),
            };
            let (a, b) = (image(), image());
            assert!(blame(noisy(&a, &variance), noisy(&b, &variance), &seen).is_empty());
        }
        // Nor is a light that is seen directly, whose noise nobody knows, and what is rounded.
        let flat = Image::filled(32, 32, [1.0; 3]);
        let free = |mean| Noisy { mean, variance: None };
        let rounded = Image::filled(32, 32, [1.0 + 3e-5; 3]);
        assert!(blame(free(&flat), free(&rounded), &seen).is_empty());
        let (mut lamp, mut other) = (flat.clone(), flat.clone());
        (lamp.pixels[500], other.pixels[500]) = ([1e4; 3], [2e4; 3]);
        assert!(blame(free(&lamp), free(&other), &seen).is_empty());
        assert!(!blame(free(&flat), free(&Image::filled(32, 32, [1.001; 3])), &seen).is_empty());
        let small = Image::filled(8, 8, [1.0; 3]);
        assert!(blame(noisy(&small, &small), noisy(&small, &small), &seen).is_empty(), "another size");
    }
}
