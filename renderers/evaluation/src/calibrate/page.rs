//! The page `calibration.md`: what was counted, beside what is promised.

use super::before;
use super::draw::Design;
use super::interval::Rate;
use super::record::{BAR, Bar, Measured, Record, Row, SMALL, Scene, Test};
use super::suite;

/// The page, below the folder of pages.
pub const PAGE: &str = "calibration.md";

/// The record, beside it.
pub const FILE: &str = "calibration.json";

const HEAD: &str = "\
# How often the verdict is wrong

*Written by `ltsc calibrate`; a test holds it against `calibration.json`. Do not edit.*

`ltsc agree` and `ltsc eval` say of two lists of noisy images that they **agree**, that they **differ**, or that this is **undecided**.
Here those answers are counted on real renderings. Each scene is rendered in many chunks of few samples with seeds of their own. A pair
is drawn from these chunks, none of them twice; an image of more samples is the mean of several chunks. `8 x 16` is a side of 8 images
of 16 chunks each. Something is planted in the images of B or not, or B is drawn from chunks of another scene, and the verdict is asked
with one tolerance for tiles and the whole.

- **`differ` of equals** is wrong. It is counted at a tolerance of 1 %, which hides nothing, between images of one renderer, also where
  B has far more samples, and between two estimators of the same image.
- **`agree`** is wrong where something is off by one and a half tolerances or more in some tile or in the whole. It is counted with so
  many samples that equals are likely to agree, where the pools have them. What is planted has a known size; of another scene a row counts
  only where three standard errors leave one and a half tolerances; the largest tolerance of which that is true is among them. At one tolerance, which does not count, 5 % would be as promised.
  `differ` is right there as well as `undecided`: something is off that chance does not explain, and what is measured of it lies on either
  side of the tolerance.
- A **prediction** says how many samples show agreement of equals in one of two cases. Its median is held against the samples with
  which half of the pairs agree.

Rates have intervals of 95 % (Wilson 1927) that take pairs to be independent. Pairs of one pool share chunks with each other: where a pair
takes most of the pool, as those of 8192 samples do, the intervals are too narrow.

**This holds for independent chunks only.** A renderer whose chunks share an error is not told from a different scene by any number of
chunks: Cycles, for instance, places the first samples of a pixel on a fixed lattice, so that its chunks of 8 samples have 1 % less light on
cbox_classic at 128 x 128 pixels than those of many. Such renderers are compared with many samples in each chunk. Other image sizes, other
grids of tiles, Metropolis sampling and photon maps are not calibrated.

*Before* is what the procedure gave when it was designed, on other images (Mitsuba 3.9.1 `llvm_ad_rgb`, 2048 chunks of each scene).
";

/// The whole page.
pub fn page(record: &Record) -> String {
    let mut text = HEAD.to_owned();
    text.push_str("\n## In short\n\n| scene | promise | counted | worst row below | rate | 95 % interval | bar | |\n|---|---|---|---|---|---|---|---|\n");
    for scene in &record.scenes {
        for bar in scene.bars() {
            text.push_str(&in_short(&scene.scene, &bar));
        }
    }
    text.push_str(&absent(record));
    record.scenes.iter().for_each(|scene| text.push_str(&of_scene(scene)));
    text
}

/// What people see of it on a terminal.
#[must_use]
pub fn summary(record: &Record) -> String {
    let line = |scene: &Scene, bar: &Bar| {
        let found = bar.rate.map_or_else(|| bar.found.clone(), |rate| format!("{} of {}", rate.hits, rate.trials));
        format!("{:<26} {:<58} {:<22} {}\n", scene.scene, bar.what, found, word(bar))
    };
    let of = |scene: &Scene| {
        let bars: String = scene.bars().iter().map(|bar| line(scene, bar)).collect();
        let missing: String =
            scene.missing.iter().map(|what| format!("{:<26} missing: {what}\n", scene.scene)).collect();
        bars + &missing
    };
    record.scenes.iter().map(of).collect()
}

fn word(bar: &Bar) -> &'static str {
    match bar.met {
        Some(true) => "met",
        Some(false) => "MISSED",
        None => "not decided",
    }
}

fn in_short(scene: &str, bar: &Bar) -> String {
    let met = match bar.met {
        Some(false) => "**missed**",
        Some(true) | None => word(bar),
    };
    match bar.rate {
        Some(rate) => format!(
            "| {scene} | {} | {} of {} | {} | {} | {} | at most {} % | {met} |\n",
            bar.what,
            rate.hits,
            rate.trials,
            bar.found,
            share(rate),
            interval(rate),
            100.0 * BAR
        ),
        None => format!("| {scene} | {} | {} | | | | | {met} |\n", bar.what, bar.found),
    }
}

/// Scenes and trials that are not there.
fn absent(record: &Record) -> String {
    let is_there = |scene: &&suite::Scene| record.scenes.iter().any(|known| known.scene == scene.label());
    let mut lines: Vec<String> = suite::SCENES
        .iter()
        .filter(|scene| !is_there(scene))
        .map(|scene| format!("- {}: not counted", scene.label()))
        .collect();
    for scene in &record.scenes {
        lines.extend(scene.missing.iter().map(|what| format!("- {}: {what}", scene.scene)));
        let small = scene.pools.iter().filter(|pool| pool.chunks < pool.wanted);
        lines.extend(
            small.map(|pool| {
                format!("- {}: `{}` has {} of {} chunks", scene.scene, pool.name, pool.chunks, pool.wanted)
            }),
        );
    }
    if lines.is_empty() { String::new() } else { format!("\n### What is missing\n\n{}\n", lines.join("\n")) }
}

/// A tolerance as people write it.
fn percent(tolerance: f64) -> String {
    let tenths = (1000.0 * tolerance).round();
    format!("{} %", tenths / 10.0)
}

fn share(rate: Rate) -> String {
    rate.share().map_or_else(|| "-".to_owned(), |share| format!("{:.2} %", 100.0 * share))
}

fn interval(rate: Rate) -> String {
    if rate.trials == 0 {
        return "-".to_owned();
    }
    let (low, high) = rate.interval();
    format!("{:.2} to {:.2} %", 100.0 * low, 100.0 * high)
}

fn sides(design: Design) -> String {
    format!("{} x {}", design.images, design.chunks)
}

fn of_scene(scene: &Scene) -> String {
    let mut text = format!(
        "\n## {}\n\n{}, {size} x {size} pixels, chunks of {} samples, draws from the seed {}.\n\n",
        scene.scene,
        scene.renderer,
        scene.samples,
        scene.seed,
        size = scene.size
    );
    text.push_str(
        "| pool | what it is | chunks | first seed | mean over that of the base | farthest tile, and what it is at least |\n\
         |---|---|---|---|---|---|\n",
    );
    for pool in &scene.pools {
        let [r, g, b] = pool.ratio;
        let (ratio, far) = if pool.name == "base" || pool.chunks == 0 {
            (String::new(), String::new())
        } else {
            let (far, least) = (100.0 * pool.distance.share, 100.0 * pool.distance.proved.max(0.0));
            (format!("{r:.4}, {g:.4}, {b:.4}"), format!("{far:.1} %, {least:.1} %"))
        };
        text.push_str(&format!(
            "| `{}` | {} | {} | {} | {ratio} | {far} |\n",
            pool.name, pool.what, pool.chunks, pool.first_seed
        ));
    }
    text.push_str(&equals(scene));
    text.push_str(&grown(scene));
    text.push_str(&off(scene));
    text.push_str(&found(scene));
    text
}

fn before(scene: &Scene, row: &Row) -> String {
    before::share(&scene.scene, row).map_or_else(String::new, |share| format!("{:.1} %", 100.0 * share))
}

/// Equal images: `differ` is wrong.
fn equals(scene: &Scene) -> String {
    let head = "\n### Equals that are said to differ\n\n\
        | | A | B | pairs | differ | rate | 95 % interval | before |\n|---|---|---|---|---|---|---|---|\n";
    let rows = scene.of(Test::Same).chain(scene.of(Test::Estimator));
    let line = |row: &Row| {
        let (a, b, rate) = (sides(row.a), sides(row.b), row.differed());
        let (share, interval, before) = (share(rate), interval(rate), before(scene, row));
        format!("| {} | {a} | {b} | {} | {} | {share} | {interval} | {before} |\n", row.what, row.pairs, row.differ)
    };
    head.to_owned() + &rows.map(line).collect::<String>()
}

/// Pairs that grow, and what was predicted of them.
fn grown(scene: &Scene) -> String {
    let mut text = "\n### Equals with more and more samples\n\n\
        | tolerance | samples of each side | A, B | pairs | agree | undecided | differ | agreed before |\n|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for row in scene.of(Test::Growing) {
        let part = |count: u64| share(Rate { hits: count, trials: row.pairs });
        text.push_str(&format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} |\n",
            percent(row.tolerance),
            scene.samples_of(row.a),
            sides(row.a),
            row.pairs,
            part(row.agree),
            part(row.pairs - row.agree - row.differ),
            part(row.differ),
            before(scene, row)
        ));
    }
    text.push_str(
        "\n| tolerance | predicted from | samples for one of two: median | 10 to 90 of 100 predictions | measured | for nine of ten: median | \
         measured | before: predicted, measured |\n|---|---|---|---|---|---|---|---|\n",
    );
    let samples =
        |value: Option<f64>| value.map_or_else(|| "more than can be told".to_owned(), |value| format!("{value:.0}"));
    for one in &scene.predictions {
        let [low, middle, high] = one.half.map(samples);
        let before = before::predicted(&scene.scene, one.tolerance, one.from)
            .map_or_else(String::new, |(predicted, measured)| format!("{predicted}, {measured}"));
        text.push_str(&format!(
            "| {:.0} % | {} | {middle} | {low} to {high} | {} | {} | {} | {before} |\n",
            100.0 * one.tolerance,
            sides(one.from),
            measured(scene.measured(one.tolerance, 0.5)),
            samples(one.most),
            measured(scene.measured(one.tolerance, 0.9))
        ));
    }
    text
}

fn measured(found: Measured) -> String {
    match found {
        Measured::At(samples) => format!("{samples:.0}"),
        Measured::More(than) => format!("more than {than:.0}"),
        Measured::Fewer(than) => format!("{than:.0} or fewer"),
        Measured::Unknown => "-".to_owned(),
    }
}

/// What is off by tolerances: `agree` is wrong.
fn off(scene: &Scene) -> String {
    let mut text = "\n### What is off and said to agree\n\n\
        | | off by, in tolerances; at least | tolerance | A, B | samples of each side | equals agree | pairs | agree | rate | 95 % interval | counts | differ |\n\
        |---|---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let rows = scene.of(Test::Planted).chain(scene.of(Test::Real).filter(|row| row.tolerance > SMALL));
    for row in rows {
        let equal = scene
            .of(Test::Growing)
            .find(|equal| (equal.a, equal.tolerance) == (row.a, row.tolerance))
            .and_then(|equal| equal.agreed().share())
            .map_or_else(|| "-".to_owned(), |share| format!("{:.0} %", 100.0 * share));
        let distance = row.distance.unwrap_or_default();
        let (by, least) = (distance.share / row.tolerance, distance.proved.max(0.0) / row.tolerance);
        let (rate, counts) = (row.agreed(), if row.is_clear() { "yes" } else { "no" });
        let (rate, interval) = (share(rate), interval(rate));
        text.push_str(&format!(
            "| {} | {by:.1}; {least:.1} | {} | {} | {} | {equal} | {} | {} | {rate} | {interval} | {counts} | {} |\n",
            row.what,
            percent(row.tolerance),
            sides(row.a),
            scene.samples_of(row.a),
            row.pairs,
            row.agree,
            share(row.differed())
        ));
    }
    text
}

/// What is found at a small tolerance.
fn found(scene: &Scene) -> String {
    let mut text = "\n### What is found at a tolerance of 1 %\n\n\
        | | A, B | samples of each side | pairs | differ | 95 % interval | agree | before |\n|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let rows = scene.of(Test::Power).chain(scene.of(Test::Real).filter(|row| row.tolerance <= SMALL));
    for row in rows {
        let rate = row.differed();
        text.push_str(&format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} |\n",
            row.what,
            sides(row.a),
            scene.samples_of(row.a),
            row.pairs,
            share(rate),
            interval(rate),
            row.agree,
            before(scene, row)
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::plant::Distance;
    use super::super::record::{Pool, Prediction};
    use super::*;

    fn scene() -> Scene {
        let design = |images, chunks| Design { images, chunks };
        let row = |test, what: &str, chunks, tolerance, distance: Option<f64>, agree, differ| Row {
            test,
            what: what.to_owned(),
            a: design(8, chunks),
            b: design(8, chunks),
            tolerance,
            distance: distance.map(|share| Distance { share, proved: share }),
            pairs: 200,
            agree,
            differ,
        };
        Scene {
            scene: "ring".to_owned(),
            renderer: "mitsuba-3 3.9.1".to_owned(),
            size: 64,
            samples: 16,
            seed: 1,
            pools: vec![Pool {
                name: "fov".to_owned(),
                what: "another angle".to_owned(),
                chunks: 100,
                wanted: 128,
                first_seed: 30_000,
                ratio: [1.001, 1.0, 0.999],
                distance: Distance { share: 0.12, proved: 0.05 },
            }],
            rows: vec![
                row(Test::Same, "equal", 1, 0.01, None, 0, 3),
                row(Test::Same, "equal", 16, 0.01, None, 0, 0),
                Row { pairs: 100, ..row(Test::Growing, "equal", 16, 0.2, None, 0, 0) },
                row(Test::Growing, "equal", 64, 0.2, None, 200, 0),
                row(Test::Planted, "one tile +1.5 tolerances", 64, 0.2, Some(0.3), 1, 190),
                row(Test::Real, "fov", 64, 0.2, Some(0.12), 150, 0),
            ],
            predictions: vec![Prediction {
                tolerance: 0.2,
                from: design(8, 1),
                pairs: 100,
                half: [Some(4930.0), Some(6000.0), None],
                most: Some(9300.0),
            }],
            missing: vec!["`dark-lights` was not rendered".to_owned()],
        }
    }

    #[test]
    fn the_page_says_what_was_counted_and_what_was_not() {
        let text = page(&Record { scenes: vec![scene()] });
        for line in [
            "| ring | `differ` of equals, one renderer, tolerance 1 % | 3 of 400 | 3 of 200 | 0.75 % | 0.26 to 2.18 % | at most 1 % | met |",
            "| ring | `agree` of what is planted, 1.5 tolerances and more | 1 of 200 | 1 of 200 | 0.50 % | 0.09 to 2.78 % | at most 1 % | met |",
            // Half way between 2048 and 8192 in the logarithm.
            "| ring | median prediction within a factor of 2, tolerance 20 % | 6000 for 4096 | | | | | met |",
            "| ring | `undecided` falls with samples, tolerance 20 % | 100, 0 % | | | | | met |",
            "- veach_mis: not counted",
            "- ring: `dark-lights` was not rendered",
            "- ring: `fov` has 100 of 128 chunks",
            "| equal | 8 x 1 | 8 x 1 | 200 | 3 | 1.50 % | 0.51 to 4.32 % | 0.0 % |",
            "| 20 % | 8192 | 8 x 64 | 200 | 100.00 % | 0.00 % | 0.00 % | 97.0 % |",
            "| 20 % | 8 x 1 | 6000 | 4930 to more than can be told | 4096 | 9300 | 7132 | 6000, 5200 |",
            "| one tile +1.5 tolerances | 1.5; 1.5 | 20 % | 8 x 64 | 8192 | 100 % | 200 | 1 | 0.50 % | 0.09 to 2.78 % | yes | 95.00 % |",
            "| fov | 0.6; 0.6 | 20 % | 8 x 64 | 8192 | 100 % | 200 | 150 | 75.00 % | 68.57 to 80.49 % | no | 0.00 % |",
        ] {
            assert!(text.contains(line), "{line}\nis not in\n{text}");
        }
    }

    /// Of few pairs at first and of many later the shares are compared, not the counts.
    #[test]
    fn undecided_falls_by_its_share() {
        let mut scene = scene();
        let of = |scene: &Scene| scene.bars().into_iter().find(|bar| bar.what.starts_with("`undecided`"));
        // All of 100, then 130 of 200.
        scene.rows[3].agree = 70;
        assert_eq!(of(&scene).expect("a bar").met, Some(true));
        scene.rows[3].agree = 0;
        assert_eq!(of(&scene).expect("a bar").met, Some(false));
    }

    #[test]
    fn what_is_missed_is_said_and_fails() {
        let mut scene = scene();
        assert!(Record { scenes: vec![scene.clone()] }.is_met());
        scene.rows[0].differ = 7;
        scene.predictions[0].half[1] = Some(8300.0);
        let record = Record { scenes: vec![scene] };
        let text = page(&record);
        assert!(
            !record.is_met()
                && text.contains("| 7 of 400 | 7 of 200 | 1.75 % | 0.85 to 3.57 % | at most 1 % | **missed** |"),
            "{text}"
        );
        assert!(text.contains("| 8300 for 4096 | | | | | **missed** |"), "{text}");
        assert!(summary(&record).contains("MISSED"));
    }
}
