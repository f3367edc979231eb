//! What agreed: a record in JSON, into which each run puts its rows, and the page made from it.

use std::fs;
use std::path::{Path, PathBuf};

use ltsc_render::compare::Agreement;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::disk::{unwritable, write_atomically};
use crate::output::{Exit, Failure};

/// One side of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Side {
    /// The renderer's name, or `reference`.
    pub name: String,
    /// Its version; of a reference, where it comes from.
    pub version: String,
    /// Rendering time of all its images.
    pub seconds: Option<f64>,
}

/// A comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The scene's name.
    pub scene: String,
    /// Parameters of the scene that were set, `name=value`.
    pub settings: Vec<String>,
    /// Width and height in pixels.
    pub size: u32,
    /// Samples per pixel of each image.
    pub samples: u32,
    /// The reference.
    pub a: Side,
    /// What is compared with it.
    pub b: Side,
    /// The share by which the means may differ.
    pub bound: f64,
    /// The numbers.
    pub agreement: Agreement,
    /// What does not hold; empty where they agree.
    pub failures: Vec<String>,
}

impl Row {
    /// For people.
    pub fn line(&self) -> String {
        let Agreement { ratio, error, rms, worst, worst_tile: (column, row), .. } = &self.agreement;
        let verdict = if self.failures.is_empty() { "agree" } else { "do not agree" };
        let name = &self.scene;
        let settings = self.settings.iter().map(|one| format!(" {one}")).collect::<String>();
        format!(
            "{name}{settings}: {} and {} {verdict}: means {ratio:.4} +- {error:.4}, tiles rms z {rms:.2}, largest {worst:.1} ({column}, {row})",
            self.a.name, self.b.name
        )
    }

    fn key(&self) -> (&str, &[String], &str, &str) {
        (&self.scene, &self.settings, &self.a.name, &self.b.name)
    }
}

/// The thesis's own Mitsuba 0.5 images against its PBRT 3 ones, 512 x 512 in tiles of 32 pixels: ratio of the means (Mitsuba / PBRT,
/// red), the farthest tiles of the worst channel, and within how much 95 % of the tiles lie. Measured on the published images.
const THESIS: &[(&str, &str, &str, &str)] = &[
    ("cbox_classic", "1.0000", "0.998..1.002", "0.05 %"),
    ("cbox_empty", "1.0000", "0.998..1.002", "0.09 %"),
    ("cbox_indirect", "0.9998", "0.994..1.007", "0.23 %"),
    ("cboxm_diffuse_lsame", "1.0001", "0.992..1.007", "0.37 %"),
    ("cboxm_diffuse_lvar", "1.0002", "0.995..1.010", "0.46 %"),
    ("cboxm_glossy_lsame", "0.9990", "0.988..1.009", "0.60 %"),
    ("cboxm_glossy_lvar", "0.9989", "0.987..1.014", "0.81 %"),
    ("veach_mis", "1.0004", "0.993..1.004", "0.16 %"),
    ("ring", "1.0002", "0.991..1.020", "0.46 %"),
    ("pool_simple", "1.011 (fireflies)", "0.79..1.26", "3.5 %"),
    ("pool_classic", "0.719 (not converged)", "0.48..1.09", "5.6 %"),
];

/// The page beside a record.
pub fn beside(record: &Path) -> PathBuf {
    record.with_extension("md")
}

fn load(record: &Path) -> Result<Vec<Row>, Failure> {
    let text = match fs::read_to_string(record) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(Failure::new(Exit::Input, format!("{}: {error}", record.display()))),
    };
    #[derive(Deserialize)]
    struct Record {
        rows: Vec<Row>,
    }
    serde_json::from_str::<Record>(&text).map(|record| record.rows).map_err(|error| {
        Failure::new(Exit::Input, format!("{} is no record of agreement: {error}", record.display()))
            .help("name another file, or remove it")
    })
}

/// Puts rows into a record, in the place of older ones of the same comparison, and writes its page anew.
pub fn record(record: &Path, new: &[Row]) -> Result<(), Failure> {
    if record.extension().is_none_or(|ending| ending != "json") {
        return Err(Failure::new(Exit::Usage, format!("{} is no JSON file", record.display()))
            .help("end the name in `.json`; the page is written beside it"));
    }
    let mut rows = load(record)?;
    rows.retain(|row| new.iter().all(|other| other.key() != row.key()));
    rows.extend_from_slice(new);
    rows.sort_by(|one, other| one.key().cmp(&other.key()));
    let failed = |error: std::io::Error| unwritable(record, &error);
    let text = format!("{:#}\n", json!({ "rows": rows }));
    write_atomically(record, &mut |out| out.write_all(text.as_bytes())).map_err(failed)?;
    let page = page(&rows);
    write_atomically(&beside(record), &mut |out| out.write_all(page.as_bytes())).map_err(failed)
}

/// Whether the page is the one that the record makes.
pub fn is_fresh(record: &Path) -> Result<bool, Failure> {
    if !record.is_file() {
        return Err(Failure::new(Exit::Input, format!("{} is missing", record.display())));
    }
    let page = page(&load(record)?);
    Ok(fs::read_to_string(beside(record)).is_ok_and(|there| there.replace("\r\n", "\n") == page))
}

fn page(rows: &[Row]) -> String {
    let mut text = "# Agreement of renderers\n\n*Written by `ltsc agree --record`; do not edit.*\n\n\
        The scenes in several renderers, several seeds each. B / A are ratios of means; the tiles are those of an 8 x 8 grid, their \
        luminance\njudged against the noise that the seeds show: z is the difference of two tiles over its standard error, with 0.2 % of the \
        tile and 0.25 % of\nthe image's mean allowed. Two renderers agree where the means differ by no more than the bound or four standard \
        errors, the root mean\nsquare of z is below 1.6, and no z is above 6.\n"
        .to_owned();
    let mut versions: Vec<String> =
        rows.iter().flat_map(|row| [&row.a, &row.b]).map(|side| format!("{} {}", side.name, side.version)).collect();
    versions.sort();
    versions.dedup();
    text.push_str(&format!("\nRendered by {}.\n", versions.join(", ")));
    let mut scene = "";
    for row in rows {
        if row.scene != scene {
            scene = &row.scene;
            text.push_str(&format!("\n## {scene}\n\n"));
            if let Some((_, ratio, tiles, most)) = THESIS.iter().find(|(name, _, _, _)| *name == scene) {
                text.push_str(&format!(
                    "The thesis's own two images, Mitsuba 0.5 / PBRT 3, of 20 000 samples and more: means {ratio}, tiles {tiles}, 95 % of \
                     them within {most}.\n\n"
                ));
            }
            text.push_str(
                "| A | B | images | R, G, B | means, standard error | tiles: rms z, largest z | farthest tile | |\n|---|---|---|---|---|---|---|---|\n",
            );
        }
        text.push_str(&line(row));
    }
    text
}

fn line(row: &Row) -> String {
    let Agreement { images, channels, ratio, error, rms, worst, worst_tile: (x, y), farthest, masked } = &row.agreement;
    let channels: Vec<String> =
        channels.iter().map(|channel| channel.map_or("-".to_owned(), |ratio| format!("{ratio:.4}"))).collect();
    let verdict = if row.failures.is_empty() {
        format!("agree within {:.1} %", 100.0 * row.bound.max(4.0 * error))
    } else {
        row.failures.join("; ")
    };
    let settings = row.settings.iter().map(|one| format!("`{one}`; ")).collect::<String>();
    let masked = if *masked > 0 { format!("; {masked} pixels left out") } else { String::new() };
    let (a, b) = images;
    let counts = if row.a.name == "reference" { format!("{a}, {b}") } else { format!("{a} each") };
    format!(
        "| {} | {} | {counts}, {size} x {size}, {} samples | {} | {ratio:.4}, {:.2} % | {rms:.2}, {worst:.1} ({x}, {y}) | {:.1} % | {settings}{verdict}{masked} |\n",
        row.a.name,
        row.b.name,
        row.samples,
        channels.join(", "),
        100.0 * error,
        100.0 * farthest,
        size = row.size,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(scene: &str, b: &str, ratio: f64) -> Row {
        let side = |name: &str| Side { name: name.to_owned(), version: "1.0".to_owned(), seconds: Some(1.5) };
        let agreement = Agreement {
            images: (4, 4),
            channels: [Some(ratio), Some(1.0), None],
            ratio,
            error: 0.001,
            rms: 0.9,
            worst: 2.5,
            worst_tile: (3, 4),
            farthest: 0.02,
            masked: 0,
        };
        let (settings, failures) = (Vec::new(), Vec::new());
        let (a, b) = (side("mitsuba-3"), side(b));
        Row { scene: scene.to_owned(), settings, size: 128, samples: 64, a, b, bound: 0.005, agreement, failures }
    }

    #[test]
    fn newer_rows_take_the_place_of_older_ones() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("agreement.json");
        record(&file, &[row("ring", "luxcore", 1.01), row("cbox_classic", "luxcore", 1.0)]).expect("written");
        record(&file, &[row("ring", "luxcore", 1.002), row("ring", "cycles", 1.0)]).expect("written");
        let rows = load(&file).expect("a record");
        let known: Vec<_> =
            rows.iter().map(|row| (row.scene.as_str(), row.b.name.as_str(), row.agreement.ratio)).collect();
        assert_eq!(known, [("cbox_classic", "luxcore", 1.0), ("ring", "cycles", 1.0), ("ring", "luxcore", 1.002)]);
        let page = fs::read_to_string(beside(&file)).expect("a page");
        assert!(
            page.contains("## ring") && page.contains("1.0020, 1.0000, -") && page.contains("0.991..1.020"),
            "{page}"
        );
        assert!(is_fresh(&file).expect("a record"));
        fs::write(beside(&file), "other").expect("written");
        assert!(!is_fresh(&file).expect("a record"));
    }

    #[test]
    fn what_is_no_record_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("agreement.json");
        fs::write(&file, "{\"other\": 1}").expect("written");
        assert!(record(&file, &[]).is_err());
        assert_eq!(fs::read_to_string(&file).expect("still there"), "{\"other\": 1}");
        assert!(record(&folder.path().join("page.md"), &[]).is_err());
    }
}
