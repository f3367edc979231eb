//! `timing.json`: what an evaluation took, and what follows from it. It is another one on each machine, and in each run.

use std::collections::BTreeMap;

use ltsc_render::image::Image;
use serde::{Deserialize, Serialize};

use crate::chunk::{Chunks, Cost, Machine};
use crate::compare::moments::Moments;
use crate::failure::{Exit, Failure};

/// Times of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// The number of this form; it grows where a field goes or means something else.
    pub form: u32,
    /// When it ended, by the clock of the machine.
    pub date: String,
    /// The machine on which ltsc ran; those that rendered are with each image.
    pub machine: Machine,
    /// Images, in the order of the results.
    pub runs: Vec<Run>,
}

impl Timing {
    /// The times by condition and label.
    #[must_use]
    pub fn by_name(&self) -> BTreeMap<(&str, &str), &Run> {
        // The first of a name, as one who reads the file finds it.
        self.runs.iter().rev().map(|run| ((run.condition.as_str(), run.label.as_str()), run)).collect()
    }
}

/// Times of an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The condition.
    pub condition: String,
    /// The image's label.
    pub label: String,
    /// What its chunks took, whenever they were rendered.
    pub cost: Cost,
    /// How its error fell with samples and time.
    pub steps: Vec<Step>,
    /// 1 / (variance x seconds): the variance is that of a pixel of the image over the squared mean. Comparable within a group.
    pub efficiency: Option<f64>,
    /// Images whose times can be compared have the same: renderer, version, machine, threads, how many ran at once.
    pub group: String,
    /// The seconds in which this one would have the error of the first image of its group and condition.
    pub equal_error_seconds: Option<f64>,
}

/// The mean of the first chunks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Chunks.
    pub chunks: u32,
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// The standard error of a pixel over the mean, by the scatter of these chunks; none of one chunk.
    pub noise: Option<f64>,
    /// The root of the mean squared difference from the reference of the first comparison, over the reference's mean: noise of both,
    /// and whatever else differs.
    pub error: Option<f64>,
}

/// The root of the mean variance of a pixel of the mean image over its mean, all channels together; none of one image, and where all
/// is black.
#[must_use]
pub fn noise(moments: &Moments) -> Option<f64> {
    if moments.count() < 2 {
        return None;
    }
    let (mean, variance) = (moments.mean_image(), moments.variance_image());
    let sum = |image: &Image| {
        let finite = image.pixels.iter().flatten().filter(|value| value.is_finite());
        finite.fold((0.0, 0_usize), |(sum, count), value| (sum + f64::from(*value), count + 1))
    };
    let ((mean, count), (variance, _)) = (sum(&mean), sum(&variance));
    (count > 0 && mean > 0.0).then(|| (variance / count as f64).sqrt() / (mean / count as f64))
}

/// The root of the mean squared difference of B from A over A's mean, over pixels that are finite in both.
fn error(a: &Image, b: &Image) -> Option<f64> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let finite = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
    let (mut squares, mut mean, mut count) = (0.0, 0.0, 0_usize);
    for (a, b) in finite {
        squares += (f64::from(*b) - f64::from(*a)).powi(2);
        mean += f64::from(*a);
        count += 1;
    }
    let count = count as f64;
    (mean > 0.0).then(|| (squares / count).sqrt() / (mean / count))
}

/// How the error fell: after 1, 2, 4 chunks and so on, and after all. One image is held at a time, beside the reference.
///
/// # Errors
/// If a chunk cannot be read.
pub fn steps(chunks: &Chunks, reference: Option<&Image>) -> Result<Vec<Step>, Failure> {
    let failed = |error: crate::compare::CompareError| {
        Failure::new(Exit::Environment, error.to_string()).help("remove that chunk: it is rendered again")
    };
    let images = chunks.images();
    let count = images.count();
    let mut steps = Vec::new();
    let mut moments: Option<Moments> = None;
    for at in 0..count {
        let image = images.get(at).map_err(failed)?;
        let moments = moments.get_or_insert_with(|| Moments::new(image.width, image.height));
        moments.add(&image).map_err(failed)?;
        let done = at + 1;
        if !done.is_power_of_two() && done != count {
            continue;
        }
        steps.push(Step {
            chunks: u32::try_from(done).unwrap_or(u32::MAX),
            samples: done as u64 * u64::from(chunks.samples),
            seconds: chunks.seconds.iter().take(done).sum(),
            noise: noise(moments),
            error: reference.and_then(|reference| error(reference, &moments.mean_image())),
        });
    }
    Ok(steps)
}

/// What tells whether two times can be compared.
#[must_use]
pub fn group(driver: &str, renderer: &str, cost: &Cost) -> String {
    let threads = cost.threads.map_or("all".to_owned(), |threads| threads.to_string());
    let beside = cost.at_once.map_or("an unknown number of".to_owned(), |count| count.to_string());
    let machines = cost.machines.join(" and ");
    format!("{driver} ({renderer}) {}, {threads} threads, {beside} at once, {machines}", cost.version)
}

/// Fills in what is known only when all images of a condition are: times to an equal error within their groups.
pub fn relate(runs: &mut [Run]) {
    // The first image of each group and condition, with its error.
    let mut first: BTreeMap<(String, String), f64> = BTreeMap::new();
    for run in runs {
        let Some(noise) = run.steps.last().and_then(|step| step.noise).filter(|noise| *noise > 0.0) else { continue };
        let seconds = run.cost.seconds;
        if seconds > 0.0 {
            run.efficiency = Some(1.0 / (noise * noise * seconds));
            let wanted = *first.entry((run.condition.clone(), run.group.clone())).or_insert(noise);
            run.equal_error_seconds = Some(seconds * (noise / wanted).powi(2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(condition: &str, group: &str, seconds: f64, noise: f64) -> Run {
        let step = Step { chunks: 8, samples: 64, seconds, noise: Some(noise), error: None };
        Run {
            condition: condition.to_owned(),
            label: String::new(),
            cost: Cost { seconds, ..Cost::default() },
            steps: vec![step],
            efficiency: None,
            group: group.to_owned(),
            equal_error_seconds: None,
        }
    }

    #[test]
    fn times_to_an_equal_error_are_those_of_one_group() {
        // Half the error takes four times the samples: 10 s at 0.2 are 40 s at 0.1.
        let mut runs =
            vec![run("a", "x", 20.0, 0.1), run("a", "x", 10.0, 0.2), run("a", "y", 1.0, 0.3), run("b", "x", 5.0, 0.2)];
        relate(&mut runs);
        let found: Vec<Option<f64>> = runs.iter().map(|run| run.equal_error_seconds).collect();
        assert_eq!(found, [Some(20.0), Some(40.0), Some(1.0), Some(5.0)]);
        assert!((runs[0].efficiency.expect("known") - 5.0).abs() < 1e-9);
        let mut still = vec![run("a", "x", 0.0, 0.1), run("a", "x", 1.0, 0.0)];
        relate(&mut still);
        assert!(still.iter().all(|run| run.efficiency.is_none()), "nothing is divided by zero");
    }

    #[test]
    fn noise_and_errors_are_shares_of_the_mean() {
        let image = |value: f32| Image::filled(4, 4, [value; 3]);
        let mut moments = Moments::new(4, 4);
        moments.add(&image(1.0)).expect("one size");
        assert_eq!(noise(&moments), None);
        moments.add(&image(3.0)).expect("one size");
        // Mean 2, variance of one image 2, of the mean 1.
        assert!((noise(&moments).expect("two images") - 0.5).abs() < 1e-6);
        assert_eq!(error(&image(2.0), &image(3.0)), Some(0.5));
        assert_eq!(error(&image(2.0), &Image::filled(2, 2, [1.0; 3])), None);
        assert_eq!(error(&image(0.0), &image(3.0)), None);
    }
}
