//! Compares two images of the same scene. A is the reference: ratios are B/A, differences B - A.

pub mod blame;
mod flip;
mod images;
mod maps;
pub mod metrics;
pub mod moments;
mod pair;
mod picture;
mod shift;
mod shown;
mod ssim;
mod text;
mod tiles;
pub mod verdict;

use std::fmt;

use serde::{Deserialize, Serialize};

use ltsc_render::image::Image;

pub use flip::Exposures;
pub use images::Images;
pub use maps::{MAPS, Map, flip_exposures, flip_map, hdr_flip_map, mean_of_map};
pub use metrics::{METRICS, Metric};
pub use pair::{Pair, Value};
pub use picture::{difference_png, difference_rgb8, exposure, grey_png, png, read_grey_png, relative_rgb8, shown_rgb8};
pub use shift::Shift;
pub use shown::pair_exposure;
pub use ssim::ssim_map;
pub use text::to_text;
pub use tiles::{Tile, Tiles, WorstTile};

/// How to compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompareOptions {
    /// Tiles along each side, 8 by default; smaller images get as many tiles as they have pixels.
    pub tiles: usize,
    /// The largest shift that is tried in each direction, in pixels, 2 by default.
    pub max_shift: usize,
    /// Gives the best shift also where noise may have made it, for images whose shift is asked for and not looked for.
    pub any_shift: bool,
    /// The names of the metrics that are measured, all of [`METRICS`] where none is named: those of what is seen take longer than all others.
    pub only: &'static [&'static str],
    /// Leaves out pixels that are not finite in A or B instead of refusing the images.
    pub mask_non_finite: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { tiles: 8, max_shift: 2, any_shift: false, only: &[], mask_non_finite: false }
    }
}

/// The result of a comparison. Its serialized form is stable: fields may come, but not go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Pixels in a row of both images.
    pub width: usize,
    /// Rows of both images.
    pub height: usize,
    /// Pixels of A that are infinite or not a number.
    pub non_finite_a: usize,
    /// Pixels of B that are infinite or not a number.
    pub non_finite_b: usize,
    /// Pixels that were left out of all numbers because A or B is not finite there.
    pub masked: usize,
    /// One entry for each row of [`METRICS`] that was asked for, in that order.
    pub metrics: Vec<Measure>,
    /// Ratios of means over a grid of tiles.
    pub tiles: Tiles,
    /// The shift that moves B onto A; nothing if the images are too small to tell.
    pub shift: Option<Shift>,
}

impl Comparison {
    /// The value of the metric of this name.
    #[must_use]
    pub fn metric(&self, name: &str) -> Option<&Value> {
        self.metrics.iter().find(|measure| measure.name == name).map(|measure| &measure.value)
    }
}

/// The value of one metric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// Name of the metric, as in [`METRICS`].
    pub name: String,
    /// The value over all channels and in each.
    #[serde(flatten)]
    pub value: Value,
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompareError {
    /// Their sizes differ.
    Size {
        /// Width and height of A.
        a: (usize, usize),
        /// Width and height of B.
        b: (usize, usize),
    },
    /// Pixels are infinite or not a number.
    NonFinite {
        /// How many in A.
        a: usize,
        /// How many in B.
        b: usize,
    },
    /// Too few images to tell their noise.
    Few {
        /// How many there are.
        images: usize,
    },
    /// Nothing is left to compare.
    Empty,
    /// An image cannot be read.
    Unreadable {
        /// Why.
        message: String,
    },
}

impl CompareError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Size { .. } => "render both at one size, or average the larger one down with `--reduce`".to_owned(),
            Self::NonFinite { .. } => {
                "such pixels spoil every mean; look for their cause, or leave them out with `--mask-nonfinite`"
                    .to_owned()
            }
            Self::Few { .. } => "give 4 images or more with different seeds; 8 tell their noise well".to_owned(),
            Self::Empty => "look at the images: one of them holds no finite pixel".to_owned(),
            Self::Unreadable { .. } => "render it again".to_owned(),
        }
    }
}

impl fmt::Display for CompareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { a, b } => {
                write!(f, "the images differ in size: A has {}x{} pixels, B has {}x{}", a.0, a.1, b.0, b.1)
            }
            Self::NonFinite { a, b } => {
                write!(f, "{a} pixels of A and {b} pixels of B are infinite or not a number")
            }
            Self::Few { images } => write!(f, "{images} images tell too little of their noise"),
            Self::Empty => write!(f, "the images have no pixel in common that could be compared"),
            Self::Unreadable { message } => f.write_str(message),
        }
    }
}

impl std::error::Error for CompareError {}

/// Compares B with the reference A.
///
/// # Errors
/// Refuses images of different sizes, of no pixels, and, unless told to mask them, pixels that are
/// not finite.
pub fn compare(a: &Image, b: &Image, options: &CompareOptions) -> Result<Comparison, CompareError> {
    let pair = Pair::new(a, b)?;
    let (non_finite_a, non_finite_b) = (a.non_finite(), b.non_finite());
    if non_finite_a + non_finite_b > 0 && !options.mask_non_finite {
        return Err(CompareError::NonFinite { a: non_finite_a, b: non_finite_b });
    }
    let masked = a.pixels.len() - pair.pixels().count();
    if masked == a.pixels.len() {
        return Err(CompareError::Empty);
    }
    let metrics = METRICS
        .iter()
        .filter(|metric| options.only.is_empty() || options.only.contains(&metric.name))
        .map(|metric| Measure { name: metric.name.to_owned(), value: (metric.measure)(&pair) })
        .collect();
    Ok(Comparison {
        width: a.width,
        height: a.height,
        non_finite_a,
        non_finite_b,
        masked,
        metrics,
        tiles: tiles::tiles(&pair, options.tiles),
        shift: shift::best(&pair, options.max_shift, options.any_shift),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_bad_pixels_are_refused_with_a_hint() {
        let options = CompareOptions::default();
        let a = Image::filled(8, 8, [1.0; 3]);
        let error = compare(&a, &Image::filled(16, 16, [1.0; 3]), &options).expect_err("sizes");
        assert!(error.hint().contains("`--reduce`"), "{}", error.hint());
        let mut b = a.clone();
        b.pixels[5][1] = f32::NAN;
        b.pixels[6][1] = f32::INFINITY;
        let error = compare(&a, &b, &options).expect_err("not finite");
        assert_eq!(error, CompareError::NonFinite { a: 0, b: 2 });
        let empty = Image::filled(0, 0, [0.0; 3]);
        assert_eq!(compare(&empty, &empty, &options), Err(CompareError::Empty));
        let nan = Image::filled(2, 2, [f32::NAN; 3]);
        let masked = CompareOptions { mask_non_finite: true, ..options };
        assert_eq!(compare(&nan, &nan, &masked), Err(CompareError::Empty));
    }

    #[test]
    fn masked_pixels_count_nowhere() {
        let a = Image::filled(8, 8, [2.0; 3]);
        let mut b = Image::filled(8, 8, [3.0; 3]);
        b.pixels[9][0] = f32::NEG_INFINITY;
        let options = CompareOptions { mask_non_finite: true, ..CompareOptions::default() };
        let found = compare(&a, &b, &options).expect("masked");
        assert_eq!((found.masked, found.non_finite_a, found.non_finite_b), (1, 0, 1));
        assert_eq!(found.metric("ratio").and_then(|value| value.overall), Some(1.5));
        assert_eq!(found.metric("rmse").and_then(|value| value.overall), Some(1.0));
        assert_eq!(found.tiles.rows[1][1].overall, None);
        assert_eq!(found.shift.map(|shift| (shift.dx, shift.dy)), Some((0, 0)));
    }

    #[test]
    fn the_result_survives_json() {
        let a = Image::filled(9, 5, [0.0, 1.0, 2.0]);
        let found = compare(&a, &a, &CompareOptions::default()).expect("equal images");
        let json = serde_json::to_value(&found).expect("to JSON");
        assert_eq!(json["metrics"][0]["name"], "mean-a");
        assert_eq!(json["metrics"][2]["channels"][0], serde_json::Value::Null);
        assert_eq!(json["tiles"]["rows"][0][0]["overall"], 1.0);
        let back: Comparison = serde_json::from_value(json).expect("from JSON");
        assert_eq!(back, found);
    }
}
