//! A comparison as plain text in aligned columns.

use std::fmt::Write;

use super::{Comparison, METRICS, Value, WorstTile};

/// Renders a comparison for a terminal of 80 columns or for a log.
#[must_use]
pub fn to_text(comparison: &Comparison) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail, so the results are of no interest.
    let _ = render(comparison, &mut text);
    text
}

fn render(comparison: &Comparison, text: &mut String) -> std::fmt::Result {
    let name = METRICS.iter().map(|metric| metric.name.len()).max().unwrap_or_default();
    writeln!(text, "{}x{} pixels, A is the reference", comparison.width, comparison.height)?;
    if comparison.masked > 0 {
        writeln!(
            text,
            "{} pixels left out (not finite: {} in A, {} in B)",
            comparison.masked, comparison.non_finite_a, comparison.non_finite_b
        )?;
    }
    writeln!(text, "{:name$} {:>12} {:>12} {:>12} {:>12}", "", "all", "R", "G", "B")?;
    for measure in &comparison.metrics {
        let Value { overall, channels } = &measure.value;
        write!(text, "{:name$} {:>12}", measure.name, number(*overall))?;
        for channel in channels {
            write!(text, " {:>12}", number(*channel))?;
        }
        writeln!(text)?;
    }
    let tiles = &comparison.tiles;
    let columns = tiles.rows.first().map_or(0, Vec::len);
    writeln!(text, "ratios B/A in {} x {} tiles, all channels (-: A is black)", columns, tiles.rows.len())?;
    for row in &tiles.rows {
        for tile in row {
            let ratio = tile.overall.map_or_else(|| "-".to_owned(), ratio);
            write!(text, " {ratio:>8}")?;
        }
        writeln!(text)?;
    }
    match &tiles.worst {
        Some(tile) => writeln!(text, "worst tile: {}", place(tile))?,
        None if tiles.worst_guarded.is_none() => writeln!(text, "worst tile: none, all are equal")?,
        None => {}
    }
    if let Some(tile) = &tiles.worst_guarded
        && tiles.worst.is_none_or(|worst| (worst.column, worst.row) != (tile.column, tile.row))
    {
        writeln!(text, "worst tile that is not almost black: {}", place(tile))?;
    }
    match &comparison.shift {
        Some(shift) if (shift.dx, shift.dy) == (0, 0) => writeln!(text, "best shift: none"),
        Some(shift) => writeln!(
            text,
            "best shift: B by ({}, {}) pixels right and down, mean difference {} instead of {}",
            shift.dx,
            shift.dy,
            number(Some(shift.error)),
            number(Some(shift.error_unshifted))
        ),
        None => writeln!(text, "best shift: the images are too small to tell"),
    }
}

fn place(tile: &WorstTile) -> String {
    let ratio = tile.ratio.map_or_else(|| "light where A is black".to_owned(), ratio);
    format!("{ratio} in column {}, row {} (from the top left, 0)", tile.column, tile.row)
}

/// Four decimals, as long as they fit a column.
fn ratio(value: f64) -> String {
    if value.abs() < 100.0 { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// Six significant digits at any magnitude.
fn number(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) if (1e-3..1e6).contains(&value.abs()) => {
            let digits = 5 - value.abs().log10().floor() as i32;
            format!("{value:.*}", usize::try_from(digits).unwrap_or_default())
        }
        Some(value) => format!("{value:.4e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CompareOptions, compare};
    use super::*;
    use ltsc_render::image::Image;

    #[test]
    fn an_image_is_equal_to_itself() {
        let mut a = Image::filled(8, 8, [0.5, 0.0, 2.0]);
        a.pixels[..16].fill([0.0; 3]);
        let text = to_text(&compare(&a, &a, &CompareOptions { tiles: 4, ..Default::default() }).expect("comparable"));
        assert!(text.ends_with("worst tile: none, all are equal\nbest shift: none\n"), "{text}");
    }

    #[test]
    fn columns_are_aligned() {
        let a = Image::filled(8, 8, [0.5, 0.0, 123.0]);
        let mut b = Image::filled(8, 8, [0.55, 0.0, 1.0e7]);
        b.pixels[0] = [f32::NAN; 3];
        let options = CompareOptions { tiles: 2, mask_non_finite: true, ..Default::default() };
        let text = to_text(&compare(&a, &b, &options).expect("comparable"));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "8x8 pixels, A is the reference");
        assert_eq!(lines[1], "1 pixels left out (not finite: 0 in A, 1 in B)");
        assert_eq!(lines[2], "                        all            R            G            B");
        assert_eq!(lines[3], "mean-a              41.1667     0.500000            0      123.000");
        assert!(lines[2..2 + METRICS.len()].iter().all(|line| line.len() == lines[2].len()));
        assert!(text.lines().all(|line| line.len() <= 80), "{text}");
        let tiles = lines.iter().position(|line| line.contains("2 x 2 tiles")).expect("tiles");
        assert_eq!(lines[tiles + 1].len(), lines[tiles + 2].len());
        assert!(text.ends_with("best shift: none\n"), "{text}");
    }
}
