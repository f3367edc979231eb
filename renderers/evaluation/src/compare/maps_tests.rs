//! Maps: values by hand, agreement with the metrics of the same names, and images that have none.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::super::{METRICS, Value};
use super::*;
use ltsc_render::image::Image;

fn map(name: &str, a: &Image, b: &Image) -> Option<Vec<f32>> {
    let map = MAPS.iter().find(|map| map.name == name).expect("a map");
    (map.measure)(&Pair::new(a, b).expect("a pair"))
}

fn metric(name: &str, a: &Image, b: &Image) -> Value {
    let metric = METRICS.iter().find(|metric| metric.name == name).expect("a metric");
    (metric.measure)(&Pair::new(a, b).expect("a pair"))
}

fn line(pixels: &[[f32; 3]]) -> Image {
    Image { width: pixels.len(), height: 1, pixels: pixels.to_vec() }
}

#[test]
fn values_are_those_computed_by_hand() {
    let a = line(&[[1.0, 0.0, 4.0], [1.0, 1.0, 1.0], [0.0; 3], [f32::NAN; 3]]);
    let b = line(&[[3.0, 2.0, 3.0], [0.0, 1.0, 1.0], [0.0; 3], [1.0; 3]]);
    let check = |name: &str, wanted: [f64; 3]| {
        let found = map(name, &a, &b).expect("a map");
        assert_eq!(found.len(), 4);
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((f64::from(*found) - wanted).abs() < 1e-6 * wanted.abs().max(1.0), "{name}: {found}, not {wanted}");
        }
        assert!(found[3].is_nan(), "{name}");
    };
    check("signed", [3.0, -1.0, 0.0]);
    check("absolute", [3.0, 1.0, 0.0]);
    // 2 / 1, 2 / 1 (A is 0), -1 / 4.
    check("relative", [(8.0_f64 + 1.0 / 16.0).sqrt(), -1.0, 0.0]);
    check("squared", [3.0, 1.0 / 3.0, 0.0]);
    // Means of A over the first three pixels: 2/3, 1/3, 5/3.
    let guards = [2.0 / 300.0, 1.0 / 300.0, 5.0 / 300.0_f64];
    let relative = 4.0 / (1.0 + guards[0].powi(2)) + 4.0 / guards[1].powi(2) + 1.0 / (16.0 + guards[2].powi(2));
    check("relative-squared", [relative / 3.0, 1.0 / (1.0 + guards[0].powi(2)) / 3.0, 0.0]);
    let mape = 2.0 / (1.0 + guards[0]) + 2.0 / guards[1] + 1.0 / (4.0 + guards[2]);
    check("mape", [mape / 3.0, 1.0 / (1.0 + guards[0]) / 3.0, 0.0]);
    check("smape", [(1.0 + 2.0 + 2.0 / 7.0) / 3.0, 2.0 / 3.0, 0.0]);
    check("relative-squared-fixed", [(4.0 / 1.0001 + 4.0e4 + 1.0 / 16.0001) / 3.0, 1.0 / 1.0001 / 3.0, 0.0]);
    check("mape-fixed", [(2.0 / 1.01 + 200.0 + 1.0 / 4.01) / 3.0, 1.0 / 1.01 / 3.0, 0.0]);
    check("smape-fixed", [(4.0 / 4.02 + 4.0 / 2.02 + 2.0 / 7.02) / 3.0, 2.0 / 1.02 / 3.0, 0.0]);
}

#[test]
fn names_are_unique_and_said_to_be_what_they_are() {
    let names: BTreeSet<&str> = MAPS.iter().map(|map| map.name).collect();
    assert_eq!(names.len(), MAPS.len());
    for map in MAPS {
        assert!(!map.summary.is_empty() && !map.formula.is_empty() && map.range.0 < map.range.1, "{}", map.name);
    }
}

#[test]
fn black_images_have_the_maps_that_are_defined() {
    let (black, light) = (Image::filled(3, 2, [0.0; 3]), Image::filled(3, 2, [0.5; 3]));
    let zeros = Some(vec![0.0; 6]);
    assert_eq!(map("hdr-flip", &black, &black), zeros);
    assert_eq!(map("flip", &black, &black), zeros);
    assert_eq!(map("ssim", &black, &black), Some(vec![1.0; 6]));
    // No exposure shows a black reference, and nothing is relative to it.
    assert_eq!(map("hdr-flip", &black, &light), None);
    assert_eq!((map("mape", &black, &light), map("relative-squared", &black, &light)), (None, None));
    assert_eq!(metric("hdr-flip", &black, &light), Value::NONE);
    assert!(metric("flip", &black, &light).overall.is_some_and(|value| value > 0.5));
    assert!(map("hdr-flip", &light, &black).is_some_and(|map| map.iter().all(|value| *value > 0.5)));
    let negative = Image::filled(3, 2, [-1.0; 3]);
    assert_eq!(map("hdr-flip", &black, &negative), zeros);
    let red = metric("psnr", &light, &Image::filled(3, 2, [0.4, 0.5, 0.5]));
    assert!(red.channels[0].is_some() && red.channels[1].is_none() && red.overall > red.channels[0], "{red:?}");
}

#[test]
fn psnr_is_that_of_what_is_shown() {
    // The 95th percentile is shown at 0.8: a stop less than 0.8 is 0.4, whose sRGB values are 0.9063 and 0.6652.
    let (a, b) = (Image::filled(4, 4, [1.6; 3]), Image::filled(4, 4, [0.8; 3]));
    let found = metric("psnr", &a, &b).overall.expect("they differ");
    assert!((found - -20.0 * (0.906_332_f64 - 0.665_185).log10()).abs() < 1e-3, "{found}");
}

#[test]
fn images_without_finite_pixels_have_no_value() {
    let (nan, light) = (Image::filled(2, 2, [f32::NAN; 3]), Image::filled(2, 2, [1.0; 3]));
    for map in MAPS {
        let found = (map.measure)(&Pair::new(&light, &nan).expect("a pair"));
        assert!(found.is_none_or(|map| map.iter().all(|value| value.is_nan())), "{}", map.name);
    }
    for row in METRICS {
        assert_eq!((row.measure)(&Pair::new(&light, &nan).expect("a pair")), Value::NONE, "{}", row.name);
    }
}

#[test]
fn a_pixel_that_is_not_finite_shows_no_difference_around_it() {
    let a = Image::filled(9, 9, [0.5; 3]);
    let mut b = a.clone();
    b.pixels[40] = [f32::INFINITY, 0.0, 0.0];
    for name in ["flip", "hdr-flip", "ssim"] {
        let found = map(name, &a, &b).expect("a map");
        assert!(found[40].is_nan(), "{name}");
        let equal = if name == "ssim" { 1.0 } else { 0.0 };
        assert!(found.iter().enumerate().all(|(at, value)| at == 40 || *value == equal), "{name}: {found:?}");
    }
}

fn image() -> impl Strategy<Value = (Image, Image)> {
    let odd = prop::sample::select(vec![0.0, -1.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, 1e-45]);
    let value = prop_oneof![150 => 0.0..4.0_f32, 1 => odd];
    (1..12_usize, 1..9_usize).prop_flat_map(move |(width, height)| {
        let pixels = || prop::collection::vec(prop::array::uniform3(value.clone()), width * height);
        (pixels(), pixels()).prop_map(move |(a, b)| {
            let of = |pixels| Image { width, height, pixels };
            (of(a), of(b))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn maps_stay_in_their_range_and_mean_what_metrics_say((a, b) in image()) {
        let pair = Pair::new(&a, &b).expect("a pair");
        let bad: Vec<bool> = a.pixels.iter().zip(&b.pixels).map(|(a, b)| !finite(a) || !finite(b)).collect();
        for map in MAPS {
            let Some(found) = (map.measure)(&pair) else { continue };
            prop_assert_eq!(found.len(), a.pixels.len());
            for (value, bad) in found.iter().zip(&bad) {
                let (least, most) = map.range;
                prop_assert!(value.is_nan() == *bad, "{}: {}", map.name, value);
                let known = value.is_finite() && (least..=most).contains(value);
                prop_assert!(*bad || known, "{}: {}", map.name, value);
            }
            // Where single precision holds the values.
            let large = found.iter().any(|value| value.abs() > 1e18);
            let same = if map.name == "relative-squared" { "relative-mse" } else { map.name };
            let root = map.name == "squared";
            let name = if root { "rmse" } else { same };
            let Some(row) = METRICS.iter().find(|row| row.name == name && !large) else { continue };
            let mean = mean_of_map(&found).map(|mean| if root { mean.sqrt() } else { mean });
            let wanted = (row.measure)(&pair).overall;
            match (mean, wanted) {
                (Some(mean), Some(wanted)) => {
                    prop_assert!((mean - wanted).abs() <= 1e-5 * wanted.abs().max(1e-3), "{}: {mean}, not {wanted}", map.name);
                }
                (mean, wanted) => prop_assert_eq!(mean, wanted, "{}", map.name),
            }
        }
        for name in ["absolute", "squared", "smape", "smape-fixed"] {
            let (one, other) = (map(name, &a, &b), map(name, &b, &a));
            let equal = |(one, other): (&f32, &f32)| one.is_nan() && other.is_nan() || one == other;
            prop_assert!(one.iter().flatten().zip(other.iter().flatten()).all(equal), "{name} is symmetric");
        }
        for exposure in [0.0, -3.0] {
            let swapped = Pair::new(&b, &a).expect("a pair");
            let near = |(one, other): (&f32, &f32)| one.is_nan() && other.is_nan() || (one - other).abs() < 1e-6;
            prop_assert!(ssim_map(&pair, exposure).iter().zip(&ssim_map(&swapped, exposure)).all(near));
            prop_assert!(flip_map(&pair, exposure).iter().zip(&flip_map(&swapped, exposure)).all(near));
        }
    }

    #[test]
    fn an_image_is_equal_to_itself((a, _) in image()) {
        let pair = Pair::new(&a, &a).expect("a pair");
        for map in MAPS {
            let found = (map.measure)(&pair).unwrap_or_default();
            let equal = if map.name == "ssim" { 1.0 } else { 0.0 };
            prop_assert!(found.iter().all(|value| value.is_nan() || *value == equal), "{}: {:?}", map.name, found);
        }
    }
}
