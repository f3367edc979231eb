//! Trials on noise whose truth is known.

use super::*;
use crate::calibrate::record::BAR;
use crate::calibrate::suite::Change;

const SCENE: Scene = Scene { name: "noise", set: &[], tolerances: &[0.1], variants: &[OTHER, BRIGHTER] };

const OTHER: Variant =
    Variant { name: "other", what: "other noise", change: Change::DarkLights(1), same: true, first_seed: 10_000 };

const BRIGHTER: Variant =
    Variant { name: "brighter", what: "brighter", change: Change::DarkLights(2), same: false, first_seed: 20_000 };

/// Chunks of 16 x 16 pixels of radiance 1, 0.5 and 0.2 times `level`, with even noise of this width in each pixel.
fn noisy(count: usize, noise: f64, level: f64, seed: u64) -> Vec<Image> {
    let one = |at: u64| {
        let mut random = Random::of(seed, "noise", at);
        let mut pixel = || {
            let grain = level * (1.0 + noise * (random.below(1 << 30) as f64 / f64::from(1 << 30) - 0.5));
            [1.0, 0.5, 0.2].map(|value| (value * grain) as f32)
        };
        Image { width: 16, height: 16, pixels: (0..256).map(|_| pixel()).collect() }
    };
    (0..count as u64).map(one).collect()
}

fn counted(base: &[Image], variants: &[(&Variant, Vec<Image>)], pairs: usize) -> Counted {
    count(&Pools { scene: &SCENE, base, variants, seed: 1, pairs }).expect("images that can be judged")
}

#[test]
fn what_is_known_of_noise_is_found() {
    // A tile has 4 pixels; with a deviation of 0.29 a chunk has 0.14 in a tile, 64 of them 0.018, and a tolerance of 0.1 is five of those
    // of a difference.
    let base = noisy(600, 1.0, 1.0, 5);
    let variants = [(&OTHER, noisy(64, 1.5, 1.0, 6)), (&BRIGHTER, noisy(128, 1.0, 1.16, 7))];
    let found = counted(&base, &variants, 120);
    let rows = |test: Test| found.rows.iter().filter(move |row| row.test == test);
    let same: u64 = rows(Test::Same).map(|row| row.differ).sum();
    assert!(rows(Test::Same).map(|row| row.pairs).sum::<u64>() == 120 && same <= 3, "{same}");
    assert!(rows(Test::Estimator).count() == 3 && rows(Test::Estimator).all(|row| row.differ <= 1 && row.is_equal()));
    // Agreement comes with samples, and never of what is off by one and a half tolerances.
    let agreed: Vec<u64> = rows(Test::Growing).filter(|row| row.tolerance == 0.1).map(|row| row.agree).collect();
    // 4, 8 and 16 images of one chunk, twelve pairs each, and five levels of 18 pairs.
    assert!(agreed.len() == 8 && agreed[3] < 9 && agreed[7] >= 17 && agreed.is_sorted(), "{agreed:?}");
    assert_eq!(rows(Test::Planted).filter(|row| row.what != "shifted by a pixel").count(), 5);
    for row in rows(Test::Planted).filter(|row| row.is_clear()) {
        assert!(row.agree as f64 <= BAR * row.pairs as f64, "{row:?}");
    }
    // A shift changes nothing here, so that agreement is right.
    let shifted = rows(Test::Planted).find(|row| row.what == "shifted by a pixel").expect("a shift");
    assert!(!shifted.is_clear() && shifted.agree >= 17, "{shifted:?}");
    let real: Vec<_> = rows(Test::Real).collect();
    assert!(real.len() == 5 && real.iter().all(|row| row.is_clear() && row.agree == 0), "{real:?}");
    // The largest tolerance that it is far beyond is a little less than 0.16 / 1.5, and equals of as many samples stand beside it.
    let widest = real[4].tolerance;
    assert!((0.09..0.107).contains(&widest), "{widest}");
    assert_eq!(rows(Test::Growing).filter(|row| row.tolerance == widest).count(), 1);
    assert!(real[2].differ == real[2].pairs && real[3].differ > 0, "{real:?}");
    let [few, _, many] = found.predictions.as_slice() else { panic!("three predictions") };
    let half = few.half[1].expect("samples");
    // From 4 images the guard against rare events takes noise for more than it is.
    assert!((256.0..4096.0).contains(&half), "{few:?}");
    assert!(many.half[1].expect("samples") <= half && few.most > few.half[1], "{many:?}");
}

#[test]
fn the_same_input_gives_the_same_counts() {
    let base = noisy(40, 1.0, 1.0, 9);
    let (one, other) = (counted(&base, &[], 40), counted(&base, &[], 40));
    assert_eq!((one.rows.clone(), one.predictions), (other.rows, other.predictions));
    assert!(!one.rows.is_empty());
}

#[test]
fn what_cannot_be_drawn_is_told() {
    let base = noisy(20, 1.0, 1.0, 9);
    let found = counted(&base, &[(&OTHER, Vec::new())], 10);
    assert_eq!(found.rows.iter().filter(|row| row.test == Test::Same).count(), 2, "4 and 8 images of a side fit");
    let told = |part: &str| found.missing.iter().any(|line| line.contains(part));
    assert!(
        told("`other` was not rendered") && told("16 x 1 chunks against 16 x 1: needs 32 chunks"),
        "{:?}",
        found.missing
    );
    assert!(told("predictions from 16") && told("pairs of 8 x 4 chunks and more need 64"), "{:?}", found.missing);
    assert_eq!(counted(&[], &[], 10).missing, ["the base was not rendered"]);
}

#[test]
fn numbers_are_rounded_to_three_digits() {
    assert_eq!([1234.5, 9996.0, 0.012_345, 7.0].map(three_digits), [1230.0, 10_000.0, 0.0123, 7.0]);
}
