//! What the procedure of the verdict gave when it was designed: Mitsuba 3.9.1 `llvm_ad_rgb`, 64 x 64 pixels, 2048 chunks of 16 samples
//! for each scene and 512 for each variant, in a program of its own. Other images, other draws and other estimators than here; the same
//! statistics.

use super::draw::Design;
use super::record::{Row, Test};

/// A share that was counted then: scene, kind, what, images and chunks of A and of B, the tolerance, and the share of `differ`, or of
/// `agree` for pairs that grow.
type Before = (&'static str, Test, &'static str, [usize; 4], f64, f64);

const RING: &str = "ring";
const BOX: &str = "cbox_classic";
const POOL: &str = "pool_simple, lamp_side=40";
const VEACH: &str = "veach_mis";

const fn same(scene: &'static str, sides: [usize; 4], share: f64) -> Before {
    (scene, Test::Same, "equal", sides, 0.01, share)
}

const fn dark(scene: &'static str, sides: [usize; 4], share: f64) -> Before {
    (scene, Test::Estimator, "dark-lights", sides, 0.01, share)
}

const fn grown(scene: &'static str, chunks: usize, tolerance: f64, share: f64) -> Before {
    (scene, Test::Growing, "equal", [8, chunks, 8, chunks], tolerance, share)
}

const fn real(scene: &'static str, what: &'static str, chunks: usize, share: f64) -> Before {
    (scene, Test::Real, what, [8, chunks, 8, chunks], 0.01, share)
}

const fn power(scene: &'static str, what: &'static str, chunks: usize, share: f64) -> Before {
    (scene, Test::Power, what, [8, chunks, 8, chunks], 0.01, share)
}

const BEFORE: &[Before] = &[
    same(BOX, [4, 1, 4, 1], 0.0),
    same(BOX, [8, 1, 8, 1], 0.002),
    same(BOX, [16, 1, 16, 1], 0.007),
    same(BOX, [8, 1, 8, 16], 0.0),
    same(POOL, [4, 1, 4, 1], 0.004),
    same(POOL, [8, 1, 8, 1], 0.0),
    same(POOL, [16, 1, 16, 1], 0.0),
    same(POOL, [8, 1, 8, 16], 0.0),
    same(VEACH, [4, 1, 4, 1], 0.0),
    same(VEACH, [8, 1, 8, 1], 0.0),
    same(VEACH, [16, 1, 16, 1], 0.0),
    same(VEACH, [8, 1, 8, 16], 0.0),
    same(RING, [4, 1, 4, 1], 0.0),
    same(RING, [8, 1, 8, 1], 0.0),
    same(RING, [16, 1, 16, 1], 0.0),
    same(RING, [8, 1, 8, 16], 0.0),
    dark(BOX, [8, 1, 8, 1], 0.0),
    dark(POOL, [8, 1, 8, 1], 0.003),
    dark(VEACH, [8, 1, 8, 1], 0.003),
    dark(RING, [8, 1, 8, 1], 0.0),
    dark(BOX, [16, 16, 4, 1], 0.0),
    dark(POOL, [16, 16, 4, 1], 0.0),
    dark(VEACH, [16, 16, 4, 1], 0.0),
    dark(RING, [16, 16, 4, 1], 0.0),
    grown(BOX, 16, 0.03, 0.03),
    grown(BOX, 24, 0.03, 0.51),
    grown(BOX, 32, 0.03, 0.81),
    grown(BOX, 64, 0.03, 1.0),
    grown(RING, 16, 0.2, 0.0),
    grown(RING, 24, 0.2, 0.05),
    grown(RING, 32, 0.2, 0.19),
    grown(RING, 64, 0.2, 0.97),
    grown(POOL, 8, 0.15, 0.0),
    grown(POOL, 16, 0.15, 0.08),
    grown(POOL, 24, 0.15, 0.83),
    grown(POOL, 32, 0.15, 1.0),
    grown(VEACH, 16, 0.1, 0.0),
    grown(VEACH, 32, 0.1, 0.0),
    grown(VEACH, 64, 0.1, 0.27),
    real(BOX, "fov", 1, 0.98),
    real(BOX, "fov", 4, 1.0),
    real(BOX, "fov", 16, 1.0),
    real(BOX, "depth", 1, 0.28),
    real(BOX, "depth", 4, 1.0),
    real(BOX, "depth", 16, 1.0),
    real(VEACH, "fov", 1, 1.0),
    real(VEACH, "fov", 4, 1.0),
    real(VEACH, "fov", 16, 1.0),
    real(VEACH, "alpha", 1, 0.0),
    real(VEACH, "alpha", 4, 0.38),
    real(VEACH, "alpha", 16, 1.0),
    real(RING, "fov", 1, 0.0),
    real(RING, "fov", 4, 0.0),
    real(RING, "fov", 16, 0.63),
    real(POOL, "depth", 1, 0.0),
    real(POOL, "depth", 4, 0.0),
    real(POOL, "depth", 16, 0.0),
    power(BOX, "whole image +2 %", 1, 1.0),
    power(BOX, "green +2 %", 1, 1.0),
    power(BOX, "one tile +2 %", 1, 0.04),
    power(BOX, "one tile +5 %", 1, 0.35),
    power(BOX, "one tile +2 %", 16, 0.71),
    power(BOX, "one tile +5 %", 16, 0.97),
    power(VEACH, "whole image +2 %", 1, 1.0),
    power(VEACH, "green +2 %", 1, 1.0),
    power(VEACH, "one tile +2 %", 1, 0.0),
    power(VEACH, "one tile +5 %", 1, 0.08),
    power(RING, "whole image +2 %", 1, 0.05),
    power(RING, "whole image +5 %", 1, 0.99),
    power(RING, "green +2 %", 1, 0.01),
    power(RING, "green +5 %", 1, 0.39),
    power(RING, "one tile +2 %", 16, 0.05),
    power(RING, "one tile +5 %", 16, 0.37),
    power(POOL, "whole image +2 %", 1, 0.10),
    power(POOL, "whole image +5 %", 1, 1.0),
    power(POOL, "green +2 %", 1, 0.07),
    power(POOL, "green +5 %", 1, 1.0),
    power(POOL, "one tile +2 %", 16, 0.05),
    power(POOL, "one tile +5 %", 16, 0.10),
];

/// The share that was counted then for the same trial.
pub fn share(scene: &str, row: &Row) -> Option<f64> {
    let sides = [row.a.images, row.a.chunks, row.b.images, row.b.chunks];
    let is = |one: &&Before| {
        (one.0, one.1, one.2, one.3) == (scene, row.test, row.what.as_str(), sides)
            && (one.4 - row.tolerance).abs() < 1e-9
    };
    BEFORE.iter().find(is).map(|one| one.5)
}

/// Samples that were predicted then from so many images of one chunk, and those at which half of the pairs agreed.
pub fn predicted(scene: &str, tolerance: f64, from: Design) -> Option<(f64, f64)> {
    let of = |scene: &str| match scene {
        BOX => Some((0.03, [3485.0, 3300.0, 3257.0], 3300.0)),
        RING => Some((0.2, [8000.0, 6000.0, 5230.0], 5200.0)),
        POOL => Some((0.15, [3490.0, 3060.0, 2740.0], 2600.0)),
        VEACH => Some((0.1, [16_700.0, 15_600.0, 13_800.0], 10_500.0)),
        _ => None,
    };
    let (at, all, measured) = of(scene)?;
    let place = [4, 8, 16].iter().position(|images| *images == from.images)?;
    ((at - tolerance).abs() < 1e-9).then(|| (all[place], measured))
}
