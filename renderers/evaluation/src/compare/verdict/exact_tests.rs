//! Each number of a verdict against one computed by hand.

use ltsc_render::image::Image;

use super::*;

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() <= 1e-5 * wanted.abs() + 1e-12, "{found} instead of {wanted}");
}

/// A tile of the finest grid of 2 by 2 whose means differ by `difference`, with this variance for both proofs, and nothing else known.
fn test(difference: f64, spread: f64) -> Test {
    let exact = Estimate { mean: 1.0, freedom: f64::INFINITY, ..Estimate::default() };
    let cell = Cell { grid: 2, at: (0, 0), channel: 0, ratio: Some(1.0 + difference), z: 0.0 };
    let b = Estimate { mean: 1.0 + difference, ..exact };
    Test { cell, a: exact, b, scale: 1.0, tolerance: 0.05, spread: (spread, spread) }
}

/// Hall's correction at t = 3 and a skewness of 0.8: 3 + 0.8 * 9 / 3 + 0.64 * 27 / 27 + 0.8 / 6 = 6.173333; at -0.8: 3 - 2.4 + 0.64 - 0.133333.
#[test]
fn a_deviate_is_corrected_for_skewness() {
    for (difference, a, b, z) in [
        (0.3, 0.0, 0.0, 3.0),
        (0.3, 0.0, 8e-4, 6.173_333),
        (0.3, -3e-4, 5e-4, 6.173_333),
        (0.3, 8e-4, 0.0, 1.106_667),
        (-0.3, 8e-4, 0.0, -6.173_333),
        (-0.3, 0.0, 8e-4, -1.106_667),
        // A skewness of more than 3 counts as 3: 3 + 9 + 9 + 0.5.
        (0.3, 0.0, 0.1, 21.5),
        (0.3, 0.1, 0.0, 3.0 - 9.0 + 9.0 - 0.5),
        (0.0, 0.0, 8e-4, 0.0),
        // Beyond the largest deviate that is told; 2 + 4 * 8e4 ... would be more.
        (99.0, 0.0, 0.0, 990.0),
        (101.0, 0.0, 0.0, 1000.0),
        (-101.0, 0.0, 8e-4, -1000.0),
        (99.0, 0.0, 8e-4, 1000.0),
        (-99.0, 8e-4, 0.0, -1000.0),
    ] {
        let mut test = test(difference, 0.01);
        (test.a.third, test.b.third) = (a, b);
        near(test.deviate(), z);
    }
    // Without noise each difference is certain, and none is none.
    assert_eq!((test(1e-9, 0.0).deviate(), test(-1e-9, 0.0).deviate(), test(0.0, 0.0).deviate()), (1e3, -1e3, 0.0));
    // What is seen with few degrees of freedom is worth less; each proof has its own spread.
    let mut few = test(0.3, 0.01);
    (few.a.variance, few.a.freedom, few.b.freedom) = (0.01, 3.0, 5.0);
    near(few.deviate(), normal::of_t(3.0, 3.0));
    few.spread.0 = 1.0;
    near(few.deviate(), normal::of_t(3.0, 3.0));
}

/// Welch's degrees of freedom: (2 + 3)^2 / (4 / 4 + 9 / 6) = 10.
#[test]
fn degrees_of_freedom_are_those_of_welch() {
    let mut test = test(0.0, 1.0);
    (test.a.variance, test.a.freedom, test.b.variance, test.b.freedom) = (2.0, 4.0, 3.0, 6.0);
    near(test.freedom(), 10.0);
    (test.a.variance, test.b.variance) = (0.0, 3.0);
    near(test.freedom(), 6.0);
    test.b.variance = 0.0;
    assert_eq!(test.freedom(), f64::INFINITY);
}

#[test]
fn agreement_leaves_room_of_a_deviate_of_the_noise() {
    // Room for 0.05 - 0.03; 1.644854 deviates of it.
    let least = 0.02 / ONE_SIDED;
    for difference in [0.03, -0.03] {
        for (spread, agrees) in [(least * 0.999, true), (least * 1.001, false)] {
            assert_eq!(test(difference, spread * spread).agrees(), agrees);
        }
    }
    assert!(!test(0.06, 1e-6).agrees() && !test(-0.06, 1e-6).agrees(), "outside");
    // Of a brighter cell it is the same share.
    let mut bright = test(0.3, 0.01);
    assert!(!bright.agrees());
    bright.scale = 10.0;
    assert!(bright.agrees());
    // With few degrees of freedom a deviate is less.
    let mut few = test(0.03, (least * 0.999_f64).powi(2));
    (few.a.variance, few.a.freedom) = (1.0, 3.0);
    assert!(!few.agrees());
    // Without noise what lies within the tolerance agrees, its end included.
    let exact = |difference: f64| Test { tolerance: 0.5, ..test(difference, 0.0) }.agrees();
    assert!(exact(0.5) && exact(-0.5) && exact(0.0) && !exact(0.501) && !exact(-0.501));
    // The spread that counts is the first.
    let mut rare = test(0.03, 1e-8);
    rare.spread.1 = 1.0;
    assert!(rare.agrees());
}

#[test]
fn a_difference_is_larger_than_chance_and_than_the_tolerance() {
    for sign in [1.0, -1.0] {
        let of = |difference: f64, z: f64| {
            let mut test = test(sign * difference, 1.0);
            test.cell.z = sign * z;
            test.differs(4.0)
        };
        assert!(of(0.06, 4.1) && !of(0.06, 3.9) && !of(0.04, 4.1) && !of(0.04, 3.9));
    }
}

/// Two one-sided tests of what is equal pass with 2 Phi(sqrt(factor) * 0.05 / spread - 1.644854) - 1: a half at 0.674490, nine tenths at
/// 1.644854.
#[test]
fn samples_that_would_prove_agreement_are_predicted() {
    let noisy = test(0.0, 0.01);
    let half = ((0.674_490 + ONE_SIDED) * 0.1_f64 / 0.05).powi(2);
    let most = (2.0 * ONE_SIDED * 0.1_f64 / 0.05).powi(2);
    near(noisy.chance(half), 0.5);
    near(noisy.chance(most), 0.9);
    assert_eq!((noisy.chance(1e-3), test(0.0, 0.0).chance(1e-3)), (0.0, 1.0));
    let of = |at: (usize, usize), channel: usize, spread: f64, grid: usize| {
        let mut test = test(0.0, spread);
        (test.cell.at, test.cell.channel, test.cell.grid) = (at, channel, grid);
        test
    };
    let alone = needed(&[of((1, 0), 0, 0.01, 2)], 100.0, 2);
    near(alone.half.expect("samples"), 100.0 * half);
    near(alone.most.expect("samples"), 100.0 * most);
    assert_eq!(alone.tile, Some((1, 0)));
    // Fewer samples than there are may be enough.
    near(needed(&[of((1, 0), 0, 1e-4, 2)], 100.0, 2).half.expect("samples"), half);
    // Of a cell the channel with the most noise decides; grids in between do not count.
    let list = [of((1, 0), 0, 0.01, 2), of((1, 0), 1, 0.002, 2), of((0, 0), 0, 0.1, 4), of((1, 0), 2, 0.01, 2)];
    near(needed(&list, 100.0, 2).half.expect("samples"), 100.0 * half);
    // Two cells must both be proved: each with the root of a half, 0.707107 = 2 Phi(1.051796) - 1.
    let two = needed(&[of((1, 0), 0, 0.01, 2), of((1, 1), 0, 0.01, 2)], 100.0, 2);
    near(two.half.expect("samples"), 100.0 * ((1.051_796 + ONE_SIDED) * 0.1_f64 / 0.05).powi(2));
    // The cell that needs them most is named, and none where it is the whole image.
    let whole = [of((0, 0), 0, 0.02, 1), of((1, 1), 0, 0.01, 2)];
    assert_eq!(needed(&whole, 100.0, 2).tile, None);
    let tile = [of((0, 0), 0, 0.01, 1), of((0, 1), 0, 0.001, 2), of((1, 1), 0, 0.02, 2)];
    assert_eq!(needed(&tile, 100.0, 2).tile, Some((1, 1)));
    assert_eq!(needed(&[of((0, 0), 0, 0.01, 1)], 100.0, 1).tile, None, "one tile is the whole image");
    // Ten thousand times the samples are the farthest: an error of 3 needs 19 366 times for a half, one of 2 needs 8 607 and 17 316.
    let far = needed(&[of((1, 0), 0, 9.0, 2), of((0, 0), 0, 1e-9, 2)], 100.0, 2);
    assert_eq!((far.half, far.most, far.tile), (None, None, Some((1, 0))));
    let between = needed(&[of((1, 0), 0, 4.0, 2)], 100.0, 2);
    near(between.half.expect("samples"), 100.0 * ((0.674_490 + ONE_SIDED) * 2.0_f64 / 0.05).powi(2));
    assert_eq!(between.most, None);
}

#[test]
fn the_fourth_of_the_neighbors_is_found() {
    let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0];
    let of = |at: usize| fourth_around(at, 4, &|at: usize| values[at]);
    // In the middle: 11 10 9 7 of 1 2 3 5 6 7 9 10 11.
    assert_eq!((of(5), of(10)), (7.0, 12.0));
    // At the left edge tile 4 is between 1 1 2, 5 5 6, 9 9 10; in the corner 0 there are 1 1 2 twice and 5 5 6.
    assert_eq!((of(4), of(0)), (6.0, 2.0));
    // At the right edge 7 has 3 4 4, 7 8 8, 11 12 12; in the corner 15 there are 11 12 12 and 15 16 16 twice.
    assert_eq!((of(7), of(15)), (8.0, 16.0));
    // At the lower edge 13 has 9 10 11 and 13 14 15 twice.
    assert_eq!(of(13), 14.0);
    // One large value beside it is not the fourth.
    assert_eq!(fourth_around(0, 4, &|at: usize| if at == 5 { 9.0 } else { 1.0 }), 1.0);
}

#[test]
fn glare_is_a_hundred_times_the_mean_with_the_pixels_around_it() {
    let out = |at: usize, height: usize, bright: f64| -> Vec<usize> {
        let mut light = vec![Some(1.0); 16 * height];
        light[at] = Some(bright);
        let found = glare(&light, 16);
        (0..light.len()).filter(|at| found[*at]).collect()
    };
    // Of 256 pixels, 255 of them 1: bright is 100 times the mean from 100 * 255 / 156 = 163.46 on.
    assert_eq!(out(100, 16, 163.4), Vec::<usize>::new());
    assert_eq!(out(100, 16, 163.6), [83, 84, 85, 99, 100, 101, 115, 116, 117]);
    assert_eq!(out(0, 16, 200.0), [0, 1, 16, 17]);
    assert_eq!(out(15, 16, 200.0), [14, 15, 30, 31]);
    assert_eq!(out(255, 16, 200.0), [238, 239, 254, 255]);
    // What is not known counts for nothing: 100 of 256 pixels are left, and none is 100 times their mean.
    let mut light = vec![None; 256];
    light[..100].fill(Some(1.0));
    light[50] = Some(1e6);
    assert!(glare(&light, 16).iter().all(|out| !out));
    light[..110].fill(Some(1.0));
    light[50] = Some(1e6);
    assert_eq!(glare(&light, 16).iter().filter(|out| **out).count(), 9);
    assert!(glare(&[], 0).is_empty() && glare(&[None], 1) == [false]);
}

/// What is not finite in an image of either side is left out, and what glares in A.
#[test]
fn pixels_are_left_out_for_what_they_are() {
    let of = |at: usize, value: f32| {
        let mut moments = Moments::new(16, 16);
        for _ in 0..3 {
            let mut image = Image::filled(16, 16, [1.0; 3]);
            image.pixels[at] = [value; 3];
            moments.add(&image).expect("one size");
        }
        moments
    };
    let out = |a: &Moments, b: &Moments| -> Vec<usize> {
        mask(a, b).into_iter().enumerate().filter(|(_, out)| *out).map(|(at, _)| at).collect()
    };
    let plain = of(0, 1.0);
    assert_eq!(out(&plain, &of(34, f32::NAN)), [34]);
    assert_eq!(out(&of(34, f32::NAN), &plain), [34]);
    assert_eq!(out(&of(255, 1e4), &of(34, f32::INFINITY)), [34, 238, 239, 254, 255]);
    assert!(out(&plain, &of(34, 1e4)).is_empty(), "a light that only B has is a difference");
}

/// Images of 8 by 8 pixels that are `level` in each tile, with one value of `extra` in the first image.
fn flat(count: usize, level: impl Fn(usize, usize) -> f32, extra: (usize, f32)) -> Vec<Image> {
    let pixel = |image: usize, at: usize| {
        let more = if image == 0 && at == extra.0 { extra.1 } else { 0.0 };
        [0, 1, 2].map(|channel| level(at, channel) + more)
    };
    let of = |image| Image { width: 8, height: 8, pixels: (0..64).map(|at| pixel(image, at)).collect() };
    (0..count).map(of).collect()
}

fn all_tests(a: &[Image], b: &[Image], fine: usize) -> Result<Vec<Test>, CompareError> {
    let side = |images: &[Image], samples: f64| {
        let images = Images::Held(images);
        Side::of(&images.moments().expect("images"), images, &[false; 64], samples).expect("a side")
    };
    let none = Noise { tiles: 1.0, cells: 1.0, together: false };
    tests(&[side(a, 4.0), side(b, 2.0)], [none; 2], Tolerance { tiles: 0.05, whole: 0.01 }, fine)
}

fn of_cell(tests: &[Test], grid: usize, at: (usize, usize), channel: usize) -> &Test {
    let is = |test: &&Test| test.cell.grid == grid && test.cell.at == at && test.cell.channel == channel;
    let mut found = tests.iter().filter(is);
    let test = found.next().expect("a test");
    assert!(found.next().is_none());
    test
}

/// One sample of the first of 4 images of A is 3 brighter in tile (3, 2). Its event is 3 - 3 / 4 above the mean, with 4 samples each 9; missed
/// once by A (of 16 samples) and by B (of 5 images of 2 samples), it makes a variance of (9 / size)^2 * (1 / 16^2 + 1 / 10^2).
#[test]
fn an_event_that_may_have_been_missed_widens_what_is_around_it() {
    let a = flat(4, |_, _| 1.0, (2 * 8 + 3, 3.0));
    let b = flat(5, |_, _| 1.0, (0, 0.0));
    let found = all_tests(&a, &b, 8).expect("tests");
    assert_eq!(found.len(), 3 * (64 + 16 + 4 + 1));
    let missed = 81.0 * (1.0 / 256.0 + 1.0 / 100.0);
    // The variance of 4, 1, 1, 1 is 9 / 4, of their mean 9 / 16.
    let variance = 9.0 / 16.0;
    for channel in 0..3 {
        let own = of_cell(&found, 8, (3, 2), channel);
        near(own.spread.0, variance + missed);
        near(own.spread.1, variance + missed);
        near(own.a.mean, 1.75);
        near(own.cell.ratio.expect("light"), 1.0 / 1.75);
        assert!((own.cell.z - own.deviate()).abs() < 1e-12 && own.cell.z < 0.0);
        // One event is not the fourth largest beside it.
        assert_eq!(of_cell(&found, 8, (2, 2), channel).spread, (0.0, 0.0));
        // Coarser cells: 4 pixels of grid 4, 16 of grid 2, all 64.
        for (grid, at, size) in [(4, (1, 1), 4.0), (2, (0, 0), 16.0), (1, (0, 0), 64.0)] {
            let cell = of_cell(&found, grid, at, channel);
            near(cell.spread.0, variance / (size * size) + missed / (size * size));
            assert_eq!(cell.spread.0, cell.spread.1);
            assert_eq!(cell.tolerance, if grid == 1 { 0.01 } else { 0.05 });
        }
    }
    // Four events around a tile widen the proof of a difference there, and not that of agreement. B's count as A's do.
    let mut b = flat(5, |_, _| 1.0, (0, 0.0));
    for at in [9, 10, 11, 17] {
        b[1].pixels[at] = [6.0; 3];
    }
    let found = all_tests(&flat(4, |_, _| 1.0, (0, 0.0)), &b, 8).expect("tests");
    // The event is 6 - 2, of 2 samples 8.
    let missed = 64.0 * (1.0 / 256.0 + 1.0 / 100.0);
    let beside = of_cell(&found, 8, (2, 2), 1);
    assert_eq!(beside.spread.0, 0.0);
    near(beside.spread.1, missed);
    assert_eq!(of_cell(&found, 8, (5, 5), 1).spread, (0.0, 0.0));
    // A reference of one image has missed nothing.
    let found = all_tests(&flat(1, |_, _| 1.0, (0, 0.0)), &b, 8).expect("tests");
    near(of_cell(&found, 8, (2, 2), 1).spread.1, 64.0 / 100.0);
}

/// Tolerances are held against the darker mean; where that is below a tenth of the channel's, against that tenth; where the channel is below
/// 1 % of the image, against a tenth of the image's.
#[test]
fn what_a_tolerance_is_a_share_of() {
    // A tile of 2 among ones, in B of 4; one of 0.05 in both; blue all but dark.
    let level = |two: f32| {
        move |at: usize, channel: usize| match (channel, at) {
            (2, _) => 0.004,
            (_, 0) => two,
            (_, 63) => 0.05,
            _ => 1.0,
        }
    };
    let found = all_tests(&flat(3, level(2.0), (0, 0.0)), &flat(3, level(4.0), (0, 0.0)), 8).expect("tests");
    // The least means over the image: (62 + 2.05) / 64 in red and green, 0.004 in blue.
    let least = 64.05 / 64.0;
    let light = (2.0 * least + 0.004) / 3.0;
    near(of_cell(&found, 8, (0, 0), 0).scale, 2.0);
    near(of_cell(&found, 8, (1, 0), 0).scale, 1.0);
    near(of_cell(&found, 8, (7, 7), 0).scale, 0.1 * least);
    near(of_cell(&found, 8, (7, 7), 2).scale, 0.1 * light);
    near(of_cell(&found, 1, (0, 0), 1).scale, least);
    // A channel of a little more than 1 % of the image is its own measure.
    let faint = |at: usize, channel: usize| if channel == 2 { if at == 0 { 0.0 } else { 0.008 } } else { 1.0 };
    let found = all_tests(&flat(3, faint, (1, 0.0)), &flat(3, faint, (1, 0.0)), 8).expect("tests");
    near(of_cell(&found, 8, (0, 0), 2).scale, 0.1 * 0.008 * 63.0 / 64.0);
    assert_eq!(of_cell(&found, 8, (0, 0), 2).cell.ratio, None, "of black there is no ratio");
    // One channel with light is enough, none is refused.
    let red = |_: usize, channel: usize| if channel == 0 { 1.0 } else { 0.0 };
    assert!(all_tests(&flat(3, red, (0, 0.0)), &flat(3, red, (0, 0.0)), 8).is_ok());
    let black = flat(3, |_, _| 0.0, (0, 0.0));
    assert!(matches!(all_tests(&black, &flat(3, red, (0, 0.0)), 8), Err(CompareError::Empty)));
    // Coarser verdicts have fewer cells, the first of which are their tiles.
    let found = all_tests(&flat(3, red, (0, 0.0)), &flat(3, red, (0, 0.0)), 2).expect("tests");
    assert_eq!((found.len(), found[0].cell.grid), (3 * (4 + 1), 2));
}

/// A list with the whole image and four tiles in one channel.
fn five() -> Vec<Test> {
    let mut all: Vec<Test> = [(0, 0), (1, 0), (0, 1), (1, 1)]
        .map(|at| {
            let mut test = test(0.0, 1e-6);
            test.cell.at = at;
            test
        })
        .into();
    let mut whole = test(0.0, 1e-6);
    (whole.cell.grid, whole.tolerance) = (1, 0.01);
    all.push(whole);
    all
}

fn told(tests: Vec<Test>) -> Verdict {
    let noise = |together| Noise { tiles: 1.0, cells: 1.0, together };
    verdict(tests, 4.0, (Tolerance::default(), 2), (3, 4), [noise(true), noise(false)], 5, 100.0)
}

#[test]
fn an_outcome_is_that_of_its_cells() {
    use Outcome::{Agree, Differ, Undecided};
    assert_eq!([Agree, Differ, Undecided].map(Outcome::word), ["agree", "differ", "undecided"]);
    let agreed = told(five());
    assert_eq!((agreed.outcome, agreed.tiles, agreed.differing), (Agree, vec![Agree; 4], 0));
    assert_eq!((agreed.images, agreed.masked, agreed.together, agreed.needed), ((3, 4), 5, (true, false), None));
    // One tile too noisy to tell, and one that differs: whatever differs decides.
    let mut list = five();
    list[1].spread = (1.0, 1.0);
    let open = told(list);
    assert_eq!((open.outcome, open.tiles), (Undecided, vec![Agree, Undecided, Agree, Agree]));
    assert_eq!(open.needed.and_then(|needed| needed.tile), Some((1, 0)));
    let mut list = five();
    list[1].spread = (1.0, 1.0);
    list[2].b.mean = 1.2;
    list[2].cell.z = -5.0;
    let differs = told(list);
    assert_eq!((differs.outcome, differs.tiles), (Differ, vec![Agree, Undecided, Differ, Agree]));
    assert_eq!((differs.differing, differs.worst.at, differs.needed), (1, (0, 1), None));
    // The whole image alone, which all tiles do not prove to agree.
    let mut list = five();
    list[4].spread = (1.0, 1.0);
    assert_eq!(told(list).outcome, Undecided);
    // What is off by more than the tolerance comes before what is only sure to be off, on either side.
    for sign in [1.0, -1.0] {
        let mut list = five();
        list[0].cell.z = sign * 50.0;
        list[3].b.mean = 1.2;
        list[3].cell.z = -sign * 4.5;
        assert_eq!(told(list).worst.at, (1, 1));
        let mut list = five();
        list[0].cell.z = sign * 3.0;
        list[3].cell.z = -sign * 2.0;
        assert_eq!(told(list).worst.at, (0, 0));
    }
}

/// Rare events widen the proof of a difference: agreement is told to stand beside them where that alone is wider than the tolerance, from a
/// spread of 0.05 / 1.644854 = 0.030398 on.
#[test]
fn tiles_that_agree_beside_rare_events_are_counted() {
    let of = |spread: f64, differs: bool| {
        let mut list = five();
        list[0].spread.1 = spread * spread;
        list[3].spread.1 = spread * spread;
        if differs {
            list[3].b.mean = 1.2;
        }
        told(list).rare
    };
    assert_eq!((of(0.0303, false), of(0.0305, false), of(0.0305, true)), (0, 2, 1));
}

/// The error of a ratio of B's mean 3 to A's 2, of variances 0.04 and 0.09: sqrt(0.04 * 1.5^2 + 0.09) / 2.
#[test]
fn the_error_of_a_ratio_has_both_sides() {
    let mut list = five();
    let whole = &mut list[4];
    (whole.a.mean, whole.a.variance, whole.b.mean, whole.b.variance) = (2.0, 0.04, 3.0, 0.09);
    whole.cell.ratio = Some(1.5);
    let found = told(list);
    assert_eq!(found.channels[0].ratio, Some(1.5));
    near(found.channels[0].error, 0.18_f64.sqrt() / 2.0);
    assert_eq!(found.channels[1], Channel { ratio: None, error: 0.0 });
    let mut black = five();
    (black[4].a.mean, black[4].b.variance, black[4].cell.ratio) = (0.0, 0.09, None);
    assert_eq!(told(black).channels[0], Channel { ratio: None, error: 0.0 });
}

/// Images of 8 by 8 pixels that alternate by 0.01 about a level, so that nothing is skewed.
fn alternating(level: f64) -> Vec<Image> {
    let sign = |image: usize, at: usize| if (image + at).is_multiple_of(2) { 0.01 } else { -0.01 };
    let pixels = |image: usize| (0..64).map(|at| [(level + sign(image, at)) as f32; 3]).collect();
    (0..32).map(|image| Image { width: 8, height: 8, pixels: pixels(image) }).collect()
}

/// All tests together have 0.5 %: two-sided deviates of 1 - 0.995^(1 / n), for the 3 tests of the whole image, the 15 with four tiles, the 255
/// with 64 (an independent error function). What is off by a little more differs, by a little less does not.
#[test]
fn the_level_is_that_of_all_tests_together() {
    for (fine, deviate) in [(1, 3.1434), (2, 3.5873), (8, 4.2687)] {
        let outcome = |z: f64| {
            // A pixel's variance is 1e-4 * 32 / 31, that of the mean of 64 pixels and 32 images a share of 2048, of both sides twice that.
            let error = (1e-4 * 32.0 / 31.0 / 2048.0 * 2.0_f64).sqrt();
            let (a, b) = (alternating(1.0), alternating(1.0 + z * error));
            let side = |images| Rendered { images: Images::Held(images), samples: 16.0 };
            judge_in(side(&a), side(&b), Tolerance { tiles: 1e-6, whole: 1e-6 }, fine).expect("a verdict").outcome
        };
        // The degrees of freedom are nearly 4000, and events make the errors wider by 0.03 %.
        assert_eq!((outcome(deviate - 0.02), outcome(deviate + 0.03)), (Outcome::Undecided, Outcome::Differ), "{fine}");
    }
}

/// Samples are told of all images of B: where the error is as large as the tolerance, (0.674490 + 1.644854)^2 times those.
#[test]
fn samples_of_all_images_are_told() {
    let images = alternating(1.0);
    let error = (1e-4 * 32.0 / 31.0 / 2048.0 * 2.0_f64).sqrt();
    let side = Rendered { images: Images::Held(&images), samples: 16.0 };
    let verdict = judge_in(side, side, Tolerance { tiles: 1.0, whole: error }, 1).expect("a verdict");
    let half = verdict.needed.and_then(|needed| needed.half).expect("samples");
    assert!((half / (16.0 * 32.0 * (0.674_490 + ONE_SIDED).powi(2)) - 1.0).abs() < 2e-3, "{half}");
}

#[test]
fn too_few_images_are_counted_on_their_side() {
    let images = flat(3, |_, _| 1.0, (0, 0.0));
    let of = |a: usize, b: usize| enough(Images::Held(&images[..a]), Images::Held(&images[..b]));
    assert!(of(1, 3).is_ok() && of(3, 3).is_ok());
    assert_eq!((of(2, 3), of(3, 1)), (Err(CompareError::Few { images: 2 }), Err(CompareError::Few { images: 1 })));
    assert_eq!((of(1, 1), of(0, 3)), (Err(CompareError::Few { images: 1 }), Err(CompareError::Empty)));
}
