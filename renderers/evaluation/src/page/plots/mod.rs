//! Plots of a page: which there are, and their numbers. Each is a file of its own in SVG, with the numbers beside it as CSV, so that it
//! can go into a paper as it is.

mod chart;

use std::collections::{BTreeMap, BTreeSet};

use super::model::{Model, Plot, Scene};
use crate::study::timing::{Run, Step, Timing};
use chart::{Axis, Chart, Mark, Series, histogram};

/// The metric that is drawn over parameters.
const OVER_PARAMETERS: &str = "relative-mse";

/// How an error is known.
struct Quantity {
    name: &'static str,
    words: &'static str,
    of: fn(&Step) -> Option<f64>,
}

const QUANTITIES: &[Quantity] = &[
    Quantity { name: "noise", words: "standard error of a pixel over the mean", of: |step| step.noise },
    Quantity {
        name: "error",
        words: "root of the mean squared difference from A over the mean of A",
        of: |step| step.error,
    },
];

/// What an error is drawn against.
struct Against {
    name: &'static str,
    words: &'static str,
    of: fn(&Step) -> f64,
}

const AGAINST: &[Against] = &[
    Against { name: "samples", words: "samples per pixel", of: |step| step.samples as f64 },
    Against { name: "time", words: "seconds of rendering", of: |step| step.seconds },
];

/// All plots, put into the model; and their files.
pub(super) fn all(model: &mut Model, timing: Option<&Timing>) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let mut by_scene: BTreeMap<&str, Vec<&Run>> = BTreeMap::new();
    for run in timing.iter().flat_map(|timing| &timing.runs) {
        by_scene.entry(&run.condition).or_default().push(run);
    }
    for (at, scene) in model.scenes.iter_mut().enumerate() {
        let runs = by_scene.get(scene.name.as_str()).cloned().unwrap_or_default();
        for (quantity, against) in QUANTITIES.iter().flat_map(|one| AGAINST.iter().map(move |other| (one, other))) {
            let chart = falling(&scene.name, &runs, quantity, against);
            if let Some(chart) = chart {
                let name = format!("plots/{at}-{}-{}", quantity.name, against.name);
                scene.plots.push(keep(&chart, &name, &mut files));
            }
        }
        for (number, pair) in scene.pairs.iter().enumerate() {
            let Some(tiles) = &pair.tiles else { continue };
            let ratios: Vec<f64> = tiles.ratios.iter().flatten().copied().collect();
            let title = format!("{}: tiles of {} over {}", scene.name, pair.b_label, pair.a_label);
            if let Some(chart) = histogram(&title, &ratios, tiles.tolerance) {
                scene.plots.push(keep(&chart, &format!("plots/{at}-tiles-{number}"), &mut files));
            }
        }
    }
    for (number, chart) in swept(&model.scenes).iter().enumerate() {
        let plot = keep(chart, &format!("plots/swept-{number}"), &mut files);
        model.plots.push(plot);
    }
    files
}

fn keep(chart: &Chart, name: &str, files: &mut Vec<(String, String)>) -> Plot {
    let (svg, csv) = (format!("{name}.svg"), format!("{name}.csv"));
    files.push((svg.clone(), chart.svg()));
    files.push((csv.clone(), chart.csv()));
    Plot { title: chart.title.clone(), svg, csv, text: chart.words() }
}

/// How an error fell: both axes logarithmic, with the slope that independent samples have.
fn falling(scene: &str, runs: &[&Run], quantity: &Quantity, against: &Against) -> Option<Chart> {
    let series: Vec<Series> = runs
        .iter()
        .map(|run| {
            let points = run.steps.iter().filter_map(|step| Some(((against.of)(step), (quantity.of)(step)?)));
            let points: Vec<(f64, f64)> = points.filter(|(x, y)| *x > 0.0 && *y > 0.0).collect();
            Series { name: run.label.clone(), points }
        })
        .filter(|series| series.points.len() > 1)
        .collect();
    (!series.is_empty()).then(|| Chart {
        title: format!("{scene}: {} against {}", quantity.name, against.name),
        x: Axis { words: against.words.to_owned(), log: true },
        y: Axis { words: quantity.words.to_owned(), log: true },
        series,
        mark: Mark::Lines,
        slope: Some(-0.5),
        bands: Vec::new(),
    })
}

/// Metrics over parameters of which a scene has several values, all others being the same.
fn swept(scenes: &[Scene]) -> Vec<Chart> {
    let mut names: BTreeSet<(&str, &str)> = BTreeSet::new();
    for scene in scenes {
        names.extend(scene.parameters.iter().map(|fact| (scene.scene.as_str(), fact.0.as_str())));
    }
    let mut charts = Vec::new();
    for (scene, parameter) in names {
        // Series by the values of all other parameters, and the two images.
        let mut series: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
        let mut values: BTreeSet<String> = BTreeSet::new();
        for one in scenes.iter().filter(|one| one.scene == scene) {
            let Some(value) = one.parameters.iter().find(|fact| fact.0 == parameter) else { continue };
            let Ok(x) = value.1.trim().parse::<f64>() else { continue };
            let others: Vec<String> = one
                .parameters
                .iter()
                .filter(|fact| fact.0 != parameter)
                .map(|fact| format!("{}={}", fact.0, fact.1))
                .collect();
            for pair in &one.pairs {
                let y = pair.metrics.iter().find(|(name, _)| name == OVER_PARAMETERS).and_then(|(_, value)| *value);
                let Some(y) = y.filter(|y| y.is_finite()) else { continue };
                values.insert(value.1.clone());
                let name = [format!("{} / {}", pair.b_label, pair.a_label)].into_iter().chain(others.clone());
                series.entry(name.collect::<Vec<_>>().join(", ")).or_default().push((x, y));
            }
        }
        series.values_mut().for_each(|points| points.sort_by(|one, other| one.0.total_cmp(&other.0)));
        if values.len() < 2 {
            continue;
        }
        let positive = |of: fn(&(f64, f64)) -> f64| series.values().flatten().all(|point| of(point) > 0.0);
        charts.push(Chart {
            title: format!("{scene}: {OVER_PARAMETERS} over {parameter}"),
            x: Axis { words: parameter.to_owned(), log: positive(|point| point.0) },
            y: Axis { words: OVER_PARAMETERS.to_owned(), log: positive(|point| point.1) },
            series: series.into_iter().map(|(name, points)| Series { name, points }).collect(),
            mark: Mark::Lines,
            slope: None,
            bands: Vec::new(),
        });
    }
    charts
}

#[cfg(test)]
mod tests {
    use super::super::model::{Fact, Pair};
    use super::*;

    #[test]
    fn parameters_with_several_values_have_plots() {
        let scene = |value: &str, y: f64| Scene {
            scene: "pool".to_owned(),
            parameters: vec![Fact("lamp".to_owned(), value.to_owned()), Fact("name".to_owned(), "x".to_owned())],
            pairs: vec![Pair { metrics: vec![(OVER_PARAMETERS.to_owned(), Some(y))], ..Pair::default() }],
            ..Scene::default()
        };
        let charts = swept(&[scene("4", 0.2), scene("1", 0.1)]);
        assert_eq!(charts.len(), 1);
        assert_eq!(charts[0].series[0].points, [(1.0, 0.1), (4.0, 0.2)]);
        assert!(charts[0].x.log && charts[0].title.contains("lamp"));
        assert!(swept(&[scene("4", 0.2)]).is_empty());
    }

    #[test]
    fn errors_that_fall_are_drawn_with_the_slope_of_independent_samples() {
        let step = |samples: u64, noise| Step { chunks: 1, samples, seconds: 1.0, noise, error: None };
        let run = Run {
            condition: "a".to_owned(),
            label: "path & <b>".to_owned(),
            cost: Default::default(),
            steps: vec![step(8, None), step(16, Some(0.2)), step(64, Some(0.1))],
            efficiency: None,
            group: String::new(),
            equal_error_seconds: None,
        };
        let chart = falling("a", &[&run], &QUANTITIES[0], &AGAINST[0]).expect("two points");
        let svg = chart.svg();
        assert!(svg.contains("path &amp; &lt;b&gt;") && svg.contains("slope -1/2") && !svg.contains("<b>"), "{svg}");
        assert_eq!(
            chart.csv(),
            "series,samples per pixel,standard error of a pixel over the mean\npath & <b>,16,0.2\npath & <b>,64,0.1\n"
        );
        assert!(falling("a", &[&run], &QUANTITIES[1], &AGAINST[0]).is_none());
    }
}
