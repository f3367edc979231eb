//! Effective settings: what the files of a target say that decides how an image looks, in the Scene's units, whatever words said it.

use super::algorithms::{self, Algorithm, Convergence, Depth};
use super::shared::reading::{Part, Reading};
use crate::ir::Filter;

/// The settings with which an image is rendered. What is none is not known: the files say it in words that are not understood.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effective {
    /// The algorithm.
    pub algorithm: Option<&'static Algorithm>,
    /// Segments of a path, as `max_depth` of the Scene counts them; [`u32::MAX`] is no limit.
    pub max_depth: Option<u32>,
    /// The reconstruction filter.
    pub filter: Option<Filter>,
    /// Samples of a pixel: of algorithms that have them, mutations or passes.
    pub samples: Option<u32>,
    /// Width and height of the whole image.
    pub size: Option<[u32; 2]>,
    /// The part of it that is rendered: its left and upper edge, its width and height.
    pub area: Option<[u32; 4]>,
    /// Width and height of the image that is written.
    pub image: Option<[u32; 2]>,
    /// The largest value that a sample may have; infinite where nothing is clamped.
    pub clamped: Option<f64>,
    /// What of the statements that were given is not understood, and passes through.
    pub passed: Vec<String>,
}

/// Why two images cannot be compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Apart {
    /// What differs, so that the images do: `paths have 11 and 10 segments`.
    pub differs: Vec<String>,
    /// What is not known of one of them.
    pub unknown: Vec<&'static str>,
}

impl Apart {
    /// Whether the two are to show the same image.
    pub fn is_comparable(&self) -> bool {
        self.differs.is_empty() && self.unknown.is_empty()
    }
}

impl Effective {
    /// Of what was read of a target's files.
    pub fn of(target: &str, reading: &Reading) -> Self {
        let algorithm = reading.native.as_deref().and_then(|native| algorithms::find(target, native));
        let max_depth = algorithm.and_then(|algorithm| match algorithm.depth {
            Depth::Whole => reading.max_depth,
            Depth::Always(segments) => Some(segments),
            Depth::Own => None,
        });
        let said = &reading.sampling.samples;
        let samples = reading
            .sampling
            .passes
            .or_else(|| said.first().copied().filter(|first| said.iter().all(|one| one == first)));
        let whole = reading.film.map(|[width, height]| [0, 0, width, height]);
        let (area, image) = match reading.part {
            Part::Whole => (whole, reading.film),
            Part::Rectangle { area, cut: true } => (Some(area), Some([area[2], area[3]])),
            Part::Rectangle { area, cut: false } => (Some(area), reading.film),
            Part::Unknown => (None, None),
        };
        Self {
            algorithm,
            max_depth,
            filter: reading.filter.clone(),
            samples: samples.and_then(|samples| u32::try_from(samples).ok()),
            size: reading.film,
            area,
            image,
            clamped: Some(reading.clamped.unwrap_or(f64::INFINITY)).filter(|limit| !limit.is_nan()),
            passed: Vec::new(),
        }
    }

    /// Why an image of these settings and one of `other` are not the same image, but for noise.
    pub fn apart(&self, other: &Self) -> Apart {
        let mut apart = Apart::default();
        for algorithm in [self.algorithm, other.algorithm].into_iter().flatten() {
            let message = format!("`{}` is biased", algorithm.native);
            if algorithm.convergence == Convergence::Biased && !apart.differs.contains(&message) {
                // Two images of one biased algorithm are the same image.
                if self.algorithm != other.algorithm {
                    apart.differs.push(message);
                }
            }
        }
        let mut both = |what: &'static str, differs: Option<Option<String>>| match differs {
            Some(differs) => apart.differs.extend(differs),
            None => apart.unknown.push(what),
        };
        both("the algorithm", self.algorithm.zip(other.algorithm).map(|_| None));
        both(
            "the depth of paths",
            pair(
                self.max_depth,
                other.max_depth,
                |a, b| a == b,
                |a, b| {
                    let words =
                        |depth: u32| if depth == u32::MAX { "any number of".to_owned() } else { depth.to_string() };
                    format!("paths have {} and {} segments", words(a), words(b))
                },
            ),
        );
        both(
            "the filter",
            pair(self.filter.as_ref(), other.filter.as_ref(), same_filter, |a, b| {
                format!("the filters are {a:?} and {b:?}")
            }),
        );
        both(
            "the size of the image",
            pair(
                self.size,
                other.size,
                |a, b| a == b,
                |[a, b], [c, d]| format!("the images have {a} x {b} and {c} x {d} pixels"),
            ),
        );
        both(
            "the part that is rendered",
            pair(
                self.area,
                other.area,
                |a, b| a == b,
                |a, b| format!("the parts that are rendered are {a:?} and {b:?}"),
            ),
        );
        both(
            "clamping",
            pair(self.clamped, other.clamped, |a, b| a == b, |a, b| format!("samples are clamped to {a} and {b}")),
        );
        apart
    }
}

/// None where one is unknown, else what differs, if anything does.
fn pair<T: Copy>(
    one: Option<T>,
    other: Option<T>,
    same: impl Fn(T, T) -> bool,
    say: impl Fn(T, T) -> String,
) -> Option<Option<String>> {
    let (one, other) = one.zip(other)?;
    Some((!same(one, other)).then(|| say(one, other)))
}

/// Whether two filters show the same image. Where a Gaussian is cut beyond three standard deviations does not matter: 0.3 % of it is
/// left there.
fn same_filter(one: &Filter, other: &Filter) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.max(b);
    match (one, other) {
        (Filter::Box { radius: a }, Filter::Box { radius: b }) => near(*a, *b),
        (Filter::Gaussian { stddev: a, radius: from }, Filter::Gaussian { stddev: b, radius: to }) => {
            near(*a, *b) && (near(*from, *to) || from.min(*to) >= 3.0 * a)
        }
        (Filter::Box { radius: _ }, Filter::Gaussian { stddev: _, radius: _ })
        | (Filter::Gaussian { stddev: _, radius: _ }, Filter::Box { radius: _ }) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(target: &str, native: &str, depth: u32) -> Effective {
        let reading = Reading {
            native: Some(native.to_owned()),
            max_depth: Some(depth),
            film: Some([8, 4]),
            filter: Some(Filter::Box { radius: 0.5 }),
            ..Reading::default()
        };
        Effective::of(target, &reading)
    }

    #[test]
    fn depths_are_compared_as_segments() {
        let (path, bidirectional) = (known("mitsuba-0.5", "path", 10), known("pbrt-v3", "bdpt", 10));
        assert!(path.apart(&bidirectional).is_comparable(), "{:?}", path.apart(&bidirectional));
        let deeper = path.apart(&known("pbrt-v3", "path", 11));
        assert_eq!(deeper.differs, ["paths have 10 and 11 segments"]);
        assert_eq!(known("mitsuba-3", "direct", 10).max_depth, Some(2));
    }

    #[test]
    fn what_is_not_known_is_said() {
        let apart = known("mitsuba-0.5", "path", 10).apart(&known("mitsuba-0.5", "new", 10));
        assert_eq!((apart.differs.len(), &apart.unknown[..]), (0, &["the algorithm", "the depth of paths"][..]));
        let biased = known("mitsuba-0.5", "vpl", 10);
        assert_eq!(biased.apart(&known("mitsuba-0.5", "path", 10)).differs, ["`vpl` is biased"]);
        assert!(biased.apart(&biased.clone()).is_comparable());
    }

    #[test]
    fn a_far_cut_of_a_gaussian_is_none() {
        let gaussian = |stddev: f64, radius: f64| Filter::Gaussian { stddev, radius };
        assert!(same_filter(&gaussian(0.5, 2.0), &gaussian(0.5, 3.0)));
        assert!(!same_filter(&gaussian(0.5, 1.0), &gaussian(0.5, 2.0)));
        assert!(!same_filter(&gaussian(0.5, 2.0), &gaussian(0.6, 2.4)));
        assert!(!same_filter(&gaussian(0.5, 2.0), &Filter::Box { radius: 0.5 }));
    }
}
