//! The metrics of images: their page, and where `ltsc diff` tells them.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use ltsc_evaluation::compare::{MAPS, METRICS};
use ltsc_render::image::{Image, Provenance, write_exr};

use super::{bless, ltsc, root, run};

const PAGE: &str = "docs/metrics.md";

/// The page with its tables as the program has them.
fn page(text: &str) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let row =
        |name: &str, summary: &str, formula: &str| format!("| `{name}` | {} | {} |\n", cell(summary), cell(formula));
    let mut metrics = "| metric | what it says | formula |\n|---|---|---|\n".to_owned();
    METRICS.iter().for_each(|metric| metrics.push_str(&row(metric.name, metric.summary, metric.formula)));
    let mut maps = "| map | what it says | range | formula |\n|---|---|---|---|\n".to_owned();
    for map in MAPS {
        let end = |value: f32| {
            if value.is_finite() { value.to_string() } else { format!("{}∞", if value < 0.0 { "-" } else { "" }) }
        };
        let range = format!("{} to {}", end(map.range.0), end(map.range.1));
        let _ = writeln!(maps, "| `{}` | {} | {range} | {} |", map.name, cell(map.summary), cell(map.formula));
    }
    [("metrics", metrics), ("maps", maps)].into_iter().fold(text.to_owned(), |text, (name, table)| {
        let (start, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->"));
        let (before, rest) = text.split_once(&start).unwrap_or_else(|| panic!("{PAGE} has no table of {name}"));
        let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("the table of {name} has no end"));
        format!("{before}{start}\n{table}\n{end}{after}")
    })
}

#[test]
fn the_page_has_every_formula() {
    let path = root().join(PAGE);
    let there = fs::read_to_string(&path).expect("the page");
    let made = page(&there);
    if bless() {
        fs::write(&path, made).expect("the page");
        return;
    }
    assert!(there == made, "{PAGE} is stale; run `INSTA_UPDATE=always cargo test --test suite metrics`");
}

#[test]
fn help_names_every_metric_with_its_formula() {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (short, long) = (run(ltsc().args(["diff", "-h"])), run(ltsc().args(["diff", "--help"])));
    let long = words(&long.out);
    for metric in METRICS {
        assert!(words(&short.out).contains(metric.name), "{}: {}", metric.name, short.out);
        assert!(long.contains(&words(metric.formula)), "{}: {long}", metric.name);
    }
}

/// Steps of gray with a little color, `gain` times as bright.
fn steps(path: &Path, gain: f32) {
    let pixels =
        (0..24 * 16).map(|at| [0.1, 0.12, 0.09].map(|value| value * gain * (1 + at % 24 / 4) as f32)).collect();
    write_exr(path, &Image { width: 24, height: 16, pixels }, &Provenance::default()).expect("an image");
}

#[test]
fn diff_tells_what_is_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    steps(&at("a.exr"), 1.0);
    steps(&at("b.exr"), 1.5);
    let diff =
        |other: &str, format: &str| run(ltsc().arg("diff").arg(at("a.exr")).arg(at(other)).args(["--format", format]));
    let document =
        |other: &str| -> serde_json::Value { serde_json::from_str(&diff(other, "json").out).expect("a document") };
    let value = |document: &serde_json::Value, name: &str| {
        let all = document["metrics"].as_array().expect("metrics");
        let found = all.iter().find(|metric| metric["name"] == name);
        found.unwrap_or_else(|| panic!("{name} is missing")).clone()
    };
    let brighter = document("b.exr");
    assert_eq!(brighter["metrics"].as_array().map(Vec::len), Some(METRICS.len()));
    for (name, least, most) in [("ssim", 0.5, 0.999), ("flip", 0.05, 0.5), ("hdr-flip", 0.05, 0.5)] {
        let found = value(&brighter, name);
        let number = found["overall"].as_f64().expect("a number");
        assert!((least..most).contains(&number), "{name}: {number}");
        assert!(found["channels"].as_array().is_some_and(|all| all.iter().all(serde_json::Value::is_null)), "{found}");
    }
    assert!(
        value(&brighter, "psnr")["channels"].as_array().is_some_and(|all| all.iter().all(serde_json::Value::is_f64))
    );
    let equal = document("a.exr");
    assert_eq!(value(&equal, "psnr")["overall"], serde_json::Value::Null, "infinite");
    assert_eq!((&value(&equal, "ssim")["overall"], &value(&equal, "hdr-flip")["overall"]), (&1.0.into(), &0.0.into()));
    let text = diff("b.exr", "human").out;
    let line = text.lines().find(|line| line.starts_with("hdr-flip ")).expect("a line");
    assert_eq!(line.split_whitespace().skip(2).collect::<Vec<_>>(), ["-", "-", "-"], "{line}");
    assert!(diff("b.exr", "short").out.starts_with("ratio 1.5000 1.5000 1.5000"), "a line of ratios");
}
