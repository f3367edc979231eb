//! The table of metrics: one file each, one row each.

mod flip;
mod hdr_flip;
mod mape;
mod max_difference;
mod mean_a;
mod mean_b;
mod psnr;
mod ratio;
mod relative_mse;
mod rmse;
mod smape;
mod ssim;

use super::{Pair, Value};

/// A number that says how two images differ.
pub struct Metric {
    /// Name in results and on the command line.
    pub name: &'static str,
    /// What it says, in a few words.
    pub summary: &'static str,
    /// Its definition, with the guard against division by zero. Means are over pixels that are finite in A and B. "As shown" is at
    /// the exposure that [`super::exposure`] gives for A, clamped.
    pub formula: &'static str,
    /// Measures a pair.
    pub measure: fn(&Pair) -> Value,
}

/// All metrics, in the order of results.
pub const METRICS: &[&Metric] = &[
    &mean_a::ROW,
    &mean_b::ROW,
    &ratio::ROW,
    &rmse::ROW,
    &relative_mse::ROW,
    &mape::ROW,
    &smape::ROW,
    &max_difference::ROW,
    &psnr::ROW,
    &ssim::ROW,
    &flip::ROW,
    &hdr_flip::ROW,
];

/// The share of a channel's mean in A that relative metrics add to their divisor. A fixed number
/// would mean something else in every scene, because radiance has no common scale.
const GUARD: f64 = 0.01;

/// The guard of each channel; nothing if a channel of A is black, since nothing is relative to it.
pub(super) fn guards(pair: &Pair) -> [Option<f64>; 3] {
    pair.mean(|a, _, _| a.abs()).map_or([None; 3], |means| means.map(|mean| (mean > 0.0).then_some(GUARD * mean)))
}

/// The mean of a relative term in each channel that has a guard, and the mean of those channels.
fn relative(pair: &Pair, term: impl Fn(f64, f64, f64) -> f64) -> Value {
    let guards = guards(pair);
    let means = pair.mean(|a, b, channel| guards[channel].map_or(0.0, |guard| term(a, b, guard)));
    let Some(means) = means else { return Value::NONE };
    let channels: [Option<f64>; 3] = std::array::from_fn(|channel| guards[channel].map(|_| means[channel]));
    let known: Vec<f64> = channels.iter().copied().flatten().collect();
    let overall = (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64);
    Value { overall, channels }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;
    use ltsc_render::image::Image;

    /// A and B have two pixels: red 1, 3 against 2, 3; green 0, 2 against 1, 0; blue black in A.
    fn value(name: &str) -> Value {
        let a = Image { width: 2, height: 1, pixels: vec![[1.0, 0.0, 0.0], [3.0, 2.0, 0.0]] };
        let b = Image { width: 2, height: 1, pixels: vec![[2.0, 1.0, 4.0], [3.0, 0.0, 0.0]] };
        let metric = METRICS.iter().find(|metric| metric.name == name).expect("a metric");
        (metric.measure)(&Pair::new(&a, &b).expect("a pair"))
    }

    fn check(name: &str, overall: Option<f64>, channels: [Option<f64>; 3]) {
        let found = value(name);
        let all = |value: Value| [value.overall].into_iter().chain(value.channels);
        for (found, wanted) in all(found).zip(all(Value { overall, channels })) {
            match (found, wanted) {
                (Some(found), Some(wanted)) => {
                    assert!((found - wanted).abs() < 1e-12, "{name}: {found}, not {wanted}");
                }
                (found, wanted) => assert_eq!(found, wanted, "{name}"),
            }
        }
    }

    #[test]
    fn values_are_those_computed_by_hand() {
        check("mean-a", Some(1.0), [Some(2.0), Some(1.0), Some(0.0)]);
        check("mean-b", Some(5.0 / 3.0), [Some(2.5), Some(0.5), Some(2.0)]);
        check("ratio", Some(5.0 / 3.0), [Some(1.25), Some(0.5), None]);
        let mse: [f64; 3] = [0.5, 2.5, 8.0];
        check("rmse", Some((11.0_f64 / 3.0).sqrt()), mse.map(|mse| Some(mse.sqrt())));
        // Guards are 0.02 in red and 0.01 in green.
        let red = 1.0 / (1.0 + 0.0004) / 2.0;
        let green = (1.0 / 0.0001 + 4.0 / (4.0 + 0.0001)) / 2.0;
        check("relative-mse", Some(f64::midpoint(red, green)), [Some(red), Some(green), None]);
        let red = 1.0 / 1.02 / 2.0;
        let green = (1.0 / 0.01 + 2.0 / 2.01) / 2.0;
        check("mape", Some(f64::midpoint(red, green)), [Some(red), Some(green), None]);
        let [red, green, blue] = [2.0 / 3.0 / 2.0, 2.0, 1.0];
        check("smape", Some((red + green + blue) / 3.0), [Some(red), Some(green), Some(blue)]);
        check("max-difference", Some(4.0), [Some(1.0), Some(2.0), Some(4.0)]);
    }

    #[test]
    fn equal_images_have_no_error() {
        let a = Image::filled(3, 2, [0.5, 0.0, 7.0]);
        for metric in METRICS.iter().filter(|metric| !metric.name.starts_with("mean")) {
            let found = (metric.measure)(&Pair::new(&a, &a).expect("a pair"));
            let wanted = match metric.name {
                "ratio" | "ssim" => Some(1.0),
                "psnr" => None,
                _ => Some(0.0),
            };
            assert_eq!(found.overall, wanted, "{}", metric.name);
        }
    }

    #[test]
    fn every_file_is_a_row_of_its_name() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/compare/metrics");
        let files: BTreeSet<String> = fs::read_dir(folder)
            .expect("list the folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .filter(|name| name != "mod.rs")
            .collect();
        let rows: BTreeSet<String> =
            METRICS.iter().map(|metric| format!("{}.rs", metric.name.replace('-', "_"))).collect();
        assert_eq!(files, rows);
        assert_eq!(rows.len(), METRICS.len());
    }
}
