//! FLIP against numbers of NVIDIA's `flip-evaluator`, and what holds for any images.

use proptest::prelude::*;

use super::exposure::aces;
use super::{Colors, Exposures, hdr, ldr};

/// Two images: steps of brightness, a pattern, and noise. Radiance has `levels` steps of a stop; without any, values end at 1.
///
/// The numbers below are `flip_evaluator.evaluate(a, b, "LDR" or "HDR", inputsRGB=False, applyMagma=False)` of version 1.7 for the same
/// arrays, made by the same arithmetic in NumPy's single precision.
fn pictures(width: usize, height: usize, levels: Option<usize>) -> [Vec<[f32; 3]>; 2] {
    let mut seed = 1_u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for at in 0..width * height {
        let (x, y) = (at % width, at / width);
        let level = levels.map_or(0.5, |levels| ((x / 8 + y / 4) % levels) as f32 - 2.0);
        let level = if levels.is_some() { level.exp2() } else { level };
        let (mut one, mut other) = ([0.0; 3], [0.0; 3]);
        for channel in 0..3 {
            let pattern = ((3 * x + 5 * y + 7 * channel) % 16) as f32 / 16.0;
            one[channel] = level * (pattern + noise());
            other[channel] = match levels {
                Some(_) => one[channel] * (0.8 + 0.4 * noise()),
                None => (one[channel] + 0.2 * (noise() - 0.5)).clamp(0.0, 1.0),
            };
        }
        a.push(one);
        b.push(other);
    }
    [a, b]
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64
}

#[test]
fn ldr_has_the_numbers_of_the_oracle() {
    // Width and height; mean, last pixel.
    let wanted = [
        (1, 1, 0.242_217, 0.242_217),
        (7, 5, 0.129_727, 0.158_270),
        (40, 30, 0.103_117, 0.303_410),
        (133, 70, 0.105_295, 0.154_096),
    ];
    for (width, height, whole, last) in wanted {
        let [a, b] = pictures(width, height, None);
        let map = ldr(Colors { a: &a, b: &b, width });
        assert!((mean(&map) - whole).abs() < 5e-5, "{width}x{height}: {}, not {whole}", mean(&map));
        assert!((f64::from(map[map.len() - 1]) - last).abs() < 5e-5, "{width}x{height}: {:?}", map.last());
    }
}

#[test]
fn even_colors_have_the_numbers_of_the_oracle() {
    let (red, green, blue, white) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]);
    let wanted = [
        (red, blue, 0.965_082),
        (green, blue, 1.0),
        ([0.0; 3], white, 0.967_390),
        ([1.0, 1.0, 0.0], blue, 0.998_972),
        ([0.0, 0.5, 0.0], [1.0, 0.0, 1.0], 0.980_217),
        ([0.2; 3], [0.25, 0.2, 0.2], 0.153_734),
    ];
    for (a, b, wanted) in wanted {
        let map = ldr(Colors { a: &[a; 12 * 9], b: &[b; 12 * 9], width: 12 });
        assert!(map.iter().all(|value| (f64::from(*value) - wanted).abs() < 5e-5), "{a:?}, {b:?}: {:?}", map[0]);
    }
}

#[test]
fn hdr_has_the_numbers_of_the_oracle() {
    // Width, height and levels; mean, last pixel; first and last exposure, and how many.
    let wanted = [
        (1, 1, 5, 0.092_878, 0.092_878, (3.422_22, 3.422_22, 2)),
        (7, 5, 5, 0.093_009, 0.107_065, (1.679_23, 2.971_60, 2)),
        (40, 30, 5, 0.077_886, 0.254_904, (-1.666_34, 1.175_96, 3)),
        (40, 30, 12, 0.079_904, 0.132_051, (-8.224_72, -2.023_05, 7)),
        (133, 70, 5, 0.077_994, 0.104_976, (-1.683_18, 1.193_07, 3)),
    ];
    for (width, height, levels, whole, last, (start, stop, count)) in wanted {
        let [a, b] = pictures(width, height, Some(levels));
        let exposures = Exposures::of(a.iter().copied()).expect("light");
        assert!((exposures.start - start).abs() < 1e-3 && (exposures.stop - stop).abs() < 1e-3, "{exposures:?}");
        assert_eq!(exposures.count, count);
        let map = hdr(Colors { a: &a, b: &b, width }, &exposures);
        assert!((mean(&map) - whole).abs() < 5e-5, "{width}x{height}, {levels}: {}, not {whole}", mean(&map));
        assert!((f64::from(map[map.len() - 1]) - last).abs() < 5e-5, "{width}x{height}, {levels}: {:?}", map.last());
    }
}

#[test]
fn tiles_have_no_seams() {
    // A spot that lies across the corner of four tiles, and the same in the middle of one.
    let at = |left: usize, top: usize| {
        let (mut a, mut b) = (vec![[0.3; 3]; 192 * 160], vec![[0.3; 3]; 192 * 160]);
        for y in 0..6 {
            for x in 0..6 {
                a[(top + y) * 192 + left + x] = [0.1 * x as f32, 0.4, 0.1 * y as f32];
                b[(top + y) * 192 + left + x] = [0.4, 0.1 * x as f32, 0.6];
            }
        }
        ldr(Colors { a: &a, b: &b, width: 192 })
    };
    let (across, inside) = (at(125, 125), at(60, 64));
    let mut seen = 0;
    for y in 0..30 {
        for x in 0..30 {
            let (one, other) = (across[(113 + y) * 192 + 113 + x], inside[(52 + y) * 192 + 48 + x]);
            assert_eq!(one, other, "({x}, {y})");
            seen += usize::from(one > 0.01);
        }
    }
    assert!(seen > 36, "the spot and what it reaches");
}

#[test]
fn exposures_end_where_the_paper_says() {
    let exposures = Exposures::of([[1.0; 3], [8.0; 3], [64.0; 3]].into_iter()).expect("light");
    assert!((aces(64.0, exposures.start.exp2() as f32) - 0.85).abs() < 1e-5);
    assert!((aces(8.0, exposures.stop.exp2() as f32) - 0.85).abs() < 1e-5);
    assert_eq!(exposures.count, 3);
    assert_eq!(
        [aces(100.0, 1.0), aces(f32::MAX, f32::MAX), aces(0.0, f32::MAX), aces(-1.0, 1.0)],
        [1.0, 1.0, 0.0, 0.0]
    );
    let gains: Vec<f32> = exposures.gains().collect();
    assert!((gains[2] / gains[0] - 8.0).abs() < 1e-4 && gains.len() == 3);
}

#[test]
fn a_median_of_zero_is_that_of_what_is_lit() {
    let lit = [[2.0; 3], [4.0; 3], [32.0; 3]];
    let dark = [[0.0; 3], [-1.0; 3], [0.0; 3], [0.0; 3]];
    let exposures = Exposures::of(lit.into_iter().chain(dark));
    assert_eq!(exposures, Exposures::of(lit.into_iter()));
    assert_eq!(exposures.expect("light").count, 3);
    assert_eq!(Exposures::of(dark.into_iter()), None);
    assert_eq!(Exposures::of(std::iter::empty()), None);
}

#[test]
fn a_range_without_bounds_has_a_bounded_number_of_exposures() {
    let exposures = Exposures::of([[1e-45; 3], [1e-45; 3], [f32::MAX; 3]].into_iter()).expect("light");
    assert_eq!(exposures.count, 64);
    assert!(exposures.gains().all(f32::is_finite), "{exposures:?}");
}

/// Values of radiance, also ones that no rendering should have.
fn value() -> impl Strategy<Value = f32> {
    let odd = prop::sample::select(vec![0.0, -1.0, f32::MAX, f32::MIN, 1e-45, 1e30]);
    prop_oneof![150 => 0.0..4.0_f32, 1 => odd]
}

/// Two images of as many pixels, and their width.
fn images() -> impl Strategy<Value = (Vec<[f32; 3]>, Vec<[f32; 3]>, usize)> {
    (1..12_usize, 1..9_usize).prop_flat_map(|(width, height)| {
        let image = || prop::collection::vec(prop::array::uniform3(value()), width * height);
        (image(), image(), Just(width))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn flip_is_symmetric_bounded_and_zero_for_one_image((a, b, width) in images()) {
        let map = ldr(Colors { a: &a, b: &b, width });
        prop_assert!(map.iter().all(|value| (0.0..=1.0).contains(value)), "{map:?}");
        prop_assert_eq!(&map, &ldr(Colors { a: &b, b: &a, width }));
        let itself = Colors { a: &a, b: &a, width };
        prop_assert!(ldr(itself).iter().all(|value| *value == 0.0));
        if let Some(exposures) = Exposures::of(a.iter().copied()) {
            let map = hdr(Colors { a: &a, b: &b, width }, &exposures);
            prop_assert!(map.iter().all(|value| (0.0..=1.0).contains(value)), "{map:?}");
            // At given exposures it is symmetric; they are those of the reference.
            prop_assert_eq!(&map, &hdr(Colors { a: &b, b: &a, width }, &exposures));
            prop_assert!(hdr(itself, &exposures).iter().all(|value| *value == 0.0));
        }
    }

    #[test]
    fn hdr_flip_has_no_unit(seed in 0..1000_u32, stops in -20..20_i32) {
        let [a, b] = pictures(5 + seed as usize % 9, 7, Some(3));
        let scaled = |image: &[[f32; 3]]| -> Vec<[f32; 3]> {
            image.iter().map(|color| color.map(|value| value * (stops as f32).exp2())).collect()
        };
        let width = 5 + seed as usize % 9;
        let of = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            hdr(Colors { a, b, width }, &Exposures::of(a.iter().copied()).expect("light"))
        };
        let (one, other) = (of(&a, &b), of(&scaled(&a), &scaled(&b)));
        prop_assert!(one.iter().zip(&other).all(|(one, other)| (one - other).abs() < 1e-4));
    }
}
