//! `ltsc diff`: numbers and a picture of how two images differ.

use std::path::Path;

use ltsc_core::files::Sink;
use ltsc_evaluation::compare::{CompareOptions, Comparison, METRICS, compare, difference_png, to_text};
use ltsc_render::image::{Image, ImageError, laid, read_placed, reduce};
use serde_json::json;

use crate::args::{Diff, Format};
use crate::output::{Exit, Failure};
use crate::terminal;
use ltsc_evaluation::disk::{DiskSink, unwritable};

/// What stands below the options of `ltsc diff --help`: examples, and the metrics; with their formulas where there is room.
pub fn help(formulas: bool) -> String {
    let mut text = "Examples:\n  ltsc diff a.exr b.exr\n  ltsc diff reference.exr b.exr --reduce -o difference\n  \
                    ltsc diff a.exr b.exr --tolerance 0.02 --format json\n\nMetrics"
        .to_owned();
    if !formulas {
        let names: Vec<&str> = METRICS.iter().map(|metric| metric.name).collect();
        return format!("{text}, whose formulas `ltsc diff --help` has:\n  {}", names.join(", "));
    }
    text.push_str(", means being over pixels that are finite in A and B:");
    for metric in METRICS {
        text.push_str(&format!("\n  {}: {}\n      {}", metric.name, metric.summary, metric.formula));
    }
    text.push_str(
        "\n\n\"As shown\" is at the exposure that brings the 95th percentile of A to 0.8, clamped between 0 and 1.",
    );
    text
}

pub fn run(command: &Diff) -> Result<Exit, Failure> {
    if command.tolerance.is_some_and(|tolerance| tolerance < 0.0 || !tolerance.is_finite()) {
        return Err(Failure::new(Exit::Usage, "the tolerance is a share of at least 0, for example 0.02"));
    }
    let placed = |path| read_placed(path).map(|(image, window, _)| (image, window)).map_err(|error| unreadable(&error));
    let (a, b) = laid(placed(&command.a)?, placed(&command.b)?).map_err(|error| unreadable(&error))?;
    let (a, b) = if command.reduce { same_size(a, b)? } else { (a, b) };
    let options = CompareOptions {
        tiles: command.tiles as usize,
        mask_non_finite: command.mask_nonfinite,
        // A line of ratios needs no more.
        only: if command.answer.format == Format::Short && command.output.is_none() { &["ratio"] } else { &[] },
        ..CompareOptions::default()
    };
    let comparison =
        compare(&a, &b, &options).map_err(|error| Failure::new(Exit::Input, error.to_string()).help(error.hint()))?;
    let beyond = command.tolerance.map(|tolerance| exceeds(&comparison, tolerance, &a, &b));
    let mut document =
        serde_json::to_value(&comparison).map_err(|error| Failure::new(Exit::Fault, error.to_string()))?;
    if let (Some(object), Some(beyond), Some(tolerance)) = (document.as_object_mut(), beyond, command.tolerance) {
        object.insert("tolerance".to_owned(), json!(tolerance));
        object.insert("within_tolerance".to_owned(), json!(!beyond));
    }
    if let Some(folder) = &command.output {
        write_folder(folder, command, &a, &b, &document)?;
    }
    match command.answer.format {
        Format::Json => terminal::print(&format!("{document:#}\n")),
        Format::Short => terminal::print(&short(&comparison, beyond)),
        Format::Human | Format::Sarif | Format::Github => {
            terminal::print(&to_text(&comparison));
            if comparison.metric("rmse").and_then(|value| value.overall).is_some_and(|error| error > 0.0) {
                // Two images alone do not tell it; several of each side do.
                terminal::say(
                    "their noise is not known: what differs may be noise; `ltsc eval` and `ltsc agree` tell the two apart",
                );
            }
            if let (Some(beyond), Some(tolerance)) = (beyond, command.tolerance) {
                let word = if beyond { "beyond" } else { "within" };
                terminal::print(&format!("{word} the tolerance of {:.3} %\n", tolerance * 100.0));
            }
        }
    }
    Ok(if beyond == Some(true) { Exit::No } else { Exit::Done })
}

/// The ratios of the means, the tile that is farthest off, and the answer, in a line.
fn short(comparison: &Comparison, beyond: Option<bool>) -> String {
    let number = |value: &Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
    let ratios: Vec<String> =
        comparison.metric("ratio").map_or(Vec::new(), |value| value.channels.iter().map(number).collect());
    let worst = comparison.tiles.worst.as_ref().map_or("none".to_owned(), |worst| number(&worst.ratio));
    let answer = beyond.map_or("", |beyond| if beyond { ", beyond the tolerance" } else { ", within the tolerance" });
    format!("ratio {}, worst tile {worst}{answer}\n", ratios.join(" "))
}

fn unreadable(error: &ImageError) -> Failure {
    Failure::new(Exit::Input, error.to_string()).help(error.hint())
}

/// The larger image averaged down to the size of the smaller one.
fn same_size(a: Image, b: Image) -> Result<(Image, Image), Failure> {
    let to = |image: &Image, like: &Image| reduce(image, like.width, like.height).map_err(|error| unreadable(&error));
    if a.width > b.width {
        Ok((to(&a, &b)?, b))
    } else if b.width > a.width {
        let reduced = to(&b, &a)?;
        Ok((a, reduced))
    } else {
        Ok((a, b))
    }
}

/// Whether a channel's mean or a tile differs by more than `tolerance`, as a share of A. Light where A is black differs by
/// more than any share.
fn exceeds(comparison: &Comparison, tolerance: f64, a: &Image, b: &Image) -> bool {
    let off = |ratio: &Option<f64>| ratio.is_some_and(|ratio| (ratio - 1.0).abs() > tolerance);
    let means = comparison.metric("ratio").is_some_and(|value| value.channels.iter().any(off));
    let tiles = comparison.tiles.rows.iter().flatten().any(|tile| tile.channels.iter().any(off));
    means || tiles || light_in_black_tiles(comparison, a, b)
}

/// Whether B has light in a channel of a tile, or of the image, in which A has none: no ratio stands there.
fn light_in_black_tiles(comparison: &Comparison, a: &Image, b: &Image) -> bool {
    let lines = comparison.tiles.rows.len();
    comparison.tiles.rows.iter().enumerate().any(|(row, tiles)| {
        tiles.iter().enumerate().any(|(column, tile)| {
            let black = |channel: usize| tile.channels[channel].is_none();
            if !(0..3).any(black) {
                return false;
            }
            let part = |at: usize, of: usize, size: usize| at * size / of..(at + 1) * size / of;
            part(row, lines, a.height).any(|y| {
                part(column, tiles.len(), a.width).any(|x| {
                    let (dark, light) = (a.at(x, y), b.at(x, y));
                    (0..3)
                        .any(|channel| black(channel) && light[channel].is_finite() && light[channel] != dark[channel])
                })
            })
        })
    })
}

/// Writes the picture and the numbers into a folder of their own.
fn write_folder(
    folder: &Path,
    command: &Diff,
    a: &Image,
    b: &Image,
    document: &serde_json::Value,
) -> Result<(), Failure> {
    let failed = |error: std::io::Error| unwritable(folder, &error);
    let picture = difference_png(&folder.join("difference.png"), a, b, f64::from(command.exposure))
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()))?;
    let text = format!("{document:#}\n");
    let mut sink = DiskSink::new(folder, "diff", false, command.force).map_err(failed)?;
    sink.file("difference.png", &mut |out| out.write_all(&picture)).map_err(failed)?;
    sink.file("diff.json", &mut |out| out.write_all(text.as_bytes())).map_err(failed)?;
    sink.finish().map_err(failed)?;
    terminal::say(&format!("{} written (green: B brighter, red: B dimmer)", folder.join("difference.png").display()));
    Ok(())
}
