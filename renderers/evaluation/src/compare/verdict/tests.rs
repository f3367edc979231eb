//! Planted differences, channel by channel and tile by tile, under small and large noise; false alarms and false agreements counted.

use ltsc_render::image::Image;

use super::*;

/// Random numbers from 0 to 1 (xorshift).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Images of 32 x 32 pixels of radiance 1, 0.5 and 0.2, times `level` of the pixel and channel, with uniform noise of this width.
pub(super) fn noisy(count: usize, noise: f64, seed: u64, level: impl Fn(usize, usize) -> f64) -> Vec<Image> {
    let mut random = Random::new(seed);
    let image = |_| {
        let pixel = |at: usize, random: &mut Random| {
            let grain = 1.0 + noise * (random.next() - 0.5);
            [0, 1, 2].map(|channel: usize| ([1.0, 0.5, 0.2][channel] * level(at, channel) * grain) as f32)
        };
        Image { width: 32, height: 32, pixels: (0..1024).map(|at| pixel(at, &mut random)).collect() }
    };
    (0..count).map(image).collect()
}

pub(super) fn even(count: usize, noise: f64, seed: u64) -> Vec<Image> {
    noisy(count, noise, seed, |_, _| 1.0)
}

fn judged(a: &[Image], b: &[Image]) -> Verdict {
    let side = |images| Rendered { images: Images::Held(images), samples: 16.0 };
    judge(side(a), side(b), Tolerance::default()).expect("comparable")
}

#[test]
fn equal_truth_agrees_where_the_noise_is_small_and_is_undecided_where_it_is_not() {
    let quiet = judged(&even(8, 0.05, 1), &even(8, 0.05, 2));
    assert_eq!((quiet.outcome, quiet.needed), (Outcome::Agree, None), "{:?}", quiet.worst);
    assert!(quiet.tiles.iter().all(|tile| *tile == Outcome::Agree));
    let loud = judged(&even(8, 1.5, 3), &even(8, 1.5, 4));
    assert_eq!(loud.outcome, Outcome::Undecided);
    let needed = loud.needed.expect("a prediction");
    let (half, most) = (needed.half.expect("samples"), needed.most.expect("samples"));
    assert!(half > 128.0 && most > half && most < 1e5, "{needed:?}");
    // With so many samples it is decided: sixteen times as many images of the same noise.
    let factor = (most / 128.0).ceil() as usize;
    let many = judged(&even(8 * factor, 1.5, 5), &even(8 * factor, 1.5, 6));
    assert_eq!(many.outcome, Outcome::Agree, "{factor} times: {:?}", many.worst);
}

#[test]
fn the_standard_error_is_that_of_the_noise() {
    let verdict = judged(&even(8, 0.5, 7), &even(8, 0.5, 8));
    // Uniform noise has a deviation of its width / sqrt(12); 8 images of 1024 pixels, both sides.
    let expected = 0.5 * (1.0 / 12.0_f64 / 1024.0 / 8.0 * 2.0).sqrt();
    for channel in verdict.channels {
        assert!((channel.error / expected - 1.0).abs() < 0.3, "{} for {expected}", channel.error);
    }
}

#[test]
fn a_single_channel_that_is_off_is_found() {
    for wrong in 0..3 {
        let b = noisy(8, 0.2, 10, |_, channel| if channel == wrong { 1.03 } else { 1.0 });
        let verdict = judged(&even(8, 0.2, 9), &b);
        assert_eq!((verdict.outcome, verdict.worst.channel), (Outcome::Differ, wrong), "{:?}", verdict.worst);
        let off = verdict.channels.map(|channel| channel.ratio.expect("light") - 1.0);
        assert!((off[wrong] - 0.03).abs() < 0.005 && off[(wrong + 1) % 3].abs() < 0.005, "{off:?}");
    }
}

#[test]
fn a_single_tile_that_is_off_is_found_where_it_is() {
    let b = noisy(
        8,
        0.2,
        12,
        |at, _| if (20..24).contains(&(at % 32)) && (8..12).contains(&(at / 32)) { 1.2 } else { 1.0 },
    );
    let verdict = judged(&even(8, 0.2, 11), &b);
    assert_eq!(verdict.outcome, Outcome::Differ);
    assert_eq!((verdict.worst.grid, verdict.worst.at), (8, (5, 2)));
    assert_eq!(verdict.tiles[2 * 8 + 5], Outcome::Differ);
    assert_eq!(verdict.tiles.iter().filter(|tile| **tile == Outcome::Differ).count(), 1);
}

/// A difference of twice the tolerance: whatever the noise, it is never called agreement.
#[test]
fn more_noise_never_makes_more_agreement() {
    let mut last = 0;
    for (at, noise) in [0.01, 0.1, 0.5, 1.0, 1.9].into_iter().enumerate() {
        let b = noisy(6, noise, 200 + at as u64, |_, _| 1.02);
        let verdict = judged(&even(6, noise, 100 + at as u64), &b);
        assert_ne!(verdict.outcome, Outcome::Agree, "{noise}");
        let rank = usize::from(verdict.outcome == Outcome::Undecided);
        assert!(rank >= last, "{noise}: {:?}", verdict.outcome);
        last = rank;
    }
    // And what is equal is agreed upon less and less.
    let agreed = |noise: f64| {
        judged(&even(6, noise, 31), &even(6, noise, 32)).tiles.iter().filter(|tile| **tile == Outcome::Agree).count()
    };
    let counts = [0.05, 0.3, 0.6, 1.2, 1.9].map(agreed);
    assert!(counts.is_sorted_by(|one, other| one >= other), "{counts:?}");
}

/// Fireflies: one sample in two thousand is a thousand times as bright, so that most tiles have met none.
fn fireflies(count: usize, seed: u64) -> Vec<Image> {
    let mut random = Random::new(seed);
    let mut images = even(count, 0.3, seed + 1);
    for pixel in images.iter_mut().flat_map(|image| &mut image.pixels) {
        if random.next() < 1.0 / 2000.0 {
            let add = 20.0 * random.next() as f32;
            pixel.iter_mut().for_each(|value| *value += add);
        }
    }
    images
}

#[test]
fn false_alarms_are_as_rare_as_promised() {
    let (mut quiet, mut bright) = (0, 0);
    for pair in 0..100 {
        quiet += usize::from(
            judged(&even(4, 0.4, 2 * pair + 1000), &even(4, 0.4, 2 * pair + 1001)).outcome == Outcome::Differ,
        );
        bright += usize::from(
            judged(&fireflies(6, 4 * pair + 5000), &fireflies(6, 4 * pair + 5002)).outcome == Outcome::Differ,
        );
    }
    assert!(quiet <= 2 && bright <= 2, "{quiet} and {bright} of 100");
}

/// One tile off by one and a half times the tolerance, with about the noise at which equal images are agreed upon in half of all cases.
#[test]
fn false_agreements_are_as_rare_as_promised() {
    let mut agreed = 0;
    for pair in 0..60 {
        let b = noisy(8, 0.25, 2 * pair + 8001, |at, _| if at % 32 < 4 && at / 32 < 4 { 1.075 } else { 1.0 });
        agreed += usize::from(judged(&even(8, 0.25, 2 * pair + 8000), &b).outcome == Outcome::Agree);
    }
    assert!(agreed <= 1, "{agreed} of 60");
}

#[test]
fn images_that_go_up_and_down_together_are_noticed() {
    let swinging = |seed: u64| {
        let mut random = Random::new(seed);
        let mut images = even(6, 0.05, seed + 1);
        for image in &mut images {
            let swing = (1.0 + 0.1 * (random.next() - 0.5)) as f32;
            image.pixels.iter_mut().flatten().for_each(|value| *value *= swing);
        }
        images
    };
    let mut alarms = 0;
    for pair in 0..40 {
        let verdict = judged(&swinging(3 * pair + 1), &swinging(3 * pair + 700));
        assert_ne!(verdict.outcome, Outcome::Agree);
        alarms += usize::from(verdict.outcome == Outcome::Differ);
    }
    assert!(alarms <= 2, "{alarms} of 40");
    assert_eq!(judged(&swinging(9), &even(6, 0.05, 77)).together, (true, false));
}

#[test]
fn dark_tiles_are_judged_by_the_image_and_black_ones_agree() {
    let dark = |at: usize| if at % 32 < 8 { 1e-3 } else { 1.0 };
    let a = noisy(6, 0.1, 41, |at, _| dark(at));
    // Ten times as bright where it is all but black.
    let b = noisy(6, 0.1, 42, |at, _| if at % 32 < 4 { 1e-2 } else { dark(at) });
    assert_ne!(
        judged(&a, &b).outcome,
        Outcome::Agree,
        "0.7 % of the image's mean is more than a twentieth of a tenth of it"
    );
    let b = noisy(6, 0.1, 43, |at, _| if at % 32 < 4 { 2e-3 } else { dark(at) });
    assert_eq!(judged(&a, &b).outcome, Outcome::Agree);
    let black = |seed| noisy(6, 0.1, seed, |at, _| if at % 32 < 8 { 0.0 } else { 1.0 });
    assert_eq!(judged(&black(44), &black(45)).outcome, Outcome::Agree);
}

#[test]
fn glare_and_what_is_no_number_is_left_out() {
    let mut a = even(3, 0.1, 6);
    let mut b = even(3, 0.1, 7);
    a.iter_mut().for_each(|image| image.pixels[7] = [5000.0; 3]);
    b[1].pixels[9] = [f32::NAN; 3];
    let verdict = judged(&a, &b);
    // One in the first row with the five around it, and one that is no number.
    assert_eq!((verdict.masked, verdict.images), (7, (3, 3)));
    assert!((verdict.channels[0].ratio.expect("light") - 1.0).abs() < 0.01);
}

/// A light covers one pixel, and of the one beside it a part that few samples hit.
#[test]
fn the_edge_of_a_light_is_left_out_with_it() {
    let lit = |seed: u64| {
        let mut random = Random::new(seed);
        let mut images = even(8, 0.1, seed + 1);
        for image in &mut images {
            image.pixels[100] = [5000.0; 3];
            image.pixels[101] = [if random.next() < 0.3 { 40.0 } else { 0.0 }; 3];
        }
        images
    };
    for seed in 0..5 {
        let verdict = judged(&lit(10 * seed + 3), &lit(10 * seed + 7));
        assert_eq!((verdict.outcome, verdict.masked), (Outcome::Agree, 9), "{:?}", verdict.worst);
    }
    // Two pixels away nothing is left out.
    let off = |seed| {
        let mut images = lit(seed);
        images.iter_mut().for_each(|image| image.pixels[102] = [9.0; 3]);
        images
    };
    assert_eq!(judged(&lit(61), &off(67)).outcome, Outcome::Differ);
}

#[test]
fn what_tells_no_noise_is_refused() {
    let refused = |a: &[Image], b: &[Image]| {
        let (a, b) =
            (Rendered { images: Images::Held(a), samples: 1.0 }, Rendered { images: Images::Held(b), samples: 1.0 });
        judge(a, b, Tolerance::default()).expect_err("refused")
    };
    let a = even(3, 0.1, 8);
    assert_eq!(refused(&a, &a[..2]), CompareError::Few { images: 2 });
    assert_eq!(refused(&a[..2], &a), CompareError::Few { images: 2 });
    assert_eq!(refused(&[], &a), CompareError::Empty);
    assert!(matches!(refused(&vec![Image::filled(8, 8, [1.0; 3]); 3], &a), CompareError::Size { .. }));
    assert_eq!(refused(&vec![Image::filled(32, 32, [0.0; 3]); 3], &a), CompareError::Empty);
    // A reference of one image is taken to be exact.
    assert_eq!(judged(&[Image::filled(32, 32, [1.0, 0.5, 0.2])], &even(8, 0.05, 9)).outcome, Outcome::Agree);
}

#[test]
fn images_without_noise_are_told_apart_by_the_tolerance_alone() {
    let flat = |level: f32| vec![Image::filled(16, 16, [level; 3]); 3];
    assert_eq!(judged(&flat(1.0), &flat(1.0)).outcome, Outcome::Agree);
    assert_eq!(judged(&flat(1.0), &flat(1.009)).outcome, Outcome::Agree);
    assert_eq!(judged(&flat(1.0), &flat(1.02)).outcome, Outcome::Differ);
    // Fewer pixels than tiles.
    let small = |level: f32| vec![Image::filled(4, 2, [level; 3]); 3];
    assert_eq!(judged(&small(1.0), &small(1.0)).outcome, Outcome::Agree);
    assert_eq!(judged(&small(1.0), &small(1.2)).outcome, Outcome::Differ);
}
