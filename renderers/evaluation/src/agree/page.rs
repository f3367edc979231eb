//! What agreed: a record in JSON, into which each run puts its rows, and the page made from it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::compare::verdict::{Outcome, Stated, Told, Verdict};
use ltsc_render::regular;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::disk::{Pages, probe_file};
use crate::failure::{Exit, Failure};

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
    /// What the targets state of the scene; the tolerance is wider by it.
    pub stated: Vec<Stated>,
    /// Whether the images differ by more than the tolerance, and by no more than is stated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub excused: bool,
    /// What is proved.
    pub verdict: Verdict,
}

impl Row {
    /// For people.
    pub fn text(&self) -> String {
        let (name, verdict) = (&self.scene, &self.verdict);
        let settings = self.settings.iter().map(|one| format!(" {one}")).collect::<String>();
        let mut text = format!(
            "{name}{settings}: {} and {}: {}: {}\n    B / A {}\n",
            self.a.name,
            self.b.name,
            verdict.outcome.word(),
            self.told().proof(),
            self.told().channels()
        );
        for note in self.told().notes() {
            text.push_str(&format!("    {note}\n"));
        }
        text
    }

    /// The same in a line, without the ratios.
    pub fn short(&self) -> String {
        let text = self.text();
        format!("{}\n", text.lines().next().unwrap_or_default())
    }

    fn told(&self) -> Told<'_> {
        Told { verdict: &self.verdict, stated: &self.stated, excused: self.excused }
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
    let text = match regular::read_text(record, regular::TEXT) {
        Ok(text) => text,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(Vec::new()),
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
pub fn record(record: &Path, new: &[Row], force: bool) -> Result<(), Failure> {
    let ours = is_as_recorded(record);
    let mut rows = load(record)?;
    rows.retain(|row| new.iter().all(|other| other.key() != row.key()));
    rows.extend_from_slice(new);
    rows.sort_by(|one, other| one.key().cmp(&other.key()));
    let (folder, names) = place_of(record)?;
    let mut pages = Pages::new(folder, BY);
    let [data, text] = names;
    pages.put_merged(data, format!("{:#}\n", json!({ "rows": rows })));
    if ours {
        pages.put_merged(text, page(&rows))
    } else {
        pages.put(text, page(&rows))
    }
    // There may be other records in the folder.
    pages.keep(|_| true);
    pages.finish(false, force).map(|_| ())
}

/// What the record of pages says of who wrote them.
const BY: &str = "agree";

/// The folder of a record, and the names of its file and its page there.
fn place_of(record: &Path) -> Result<(&Path, [String; 2]), Failure> {
    if record.extension().is_none_or(|ending| ending != "json") {
        return Err(Failure::new(Exit::Usage, format!("{} is no JSON file", record.display()))
            .help("end the name in `.json`; the page is written beside it"));
    }
    let folder = record.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Ok((folder, [name(record), name(&beside(record))]))
}

/// Refuses what [`record`] would refuse, before anything is rendered for it.
pub fn check(record: &Path, force: bool) -> Result<(), Failure> {
    let (folder, [_, page]) = place_of(record)?;
    probe_file(record)?;
    load(record)?;
    if is_as_recorded(record) { Ok(()) } else { Pages::new(folder, BY).refuse(&page, force) }
}

/// Whether the page holds nothing but what the record says.
fn is_as_recorded(record: &Path) -> bool {
    record.is_file() && is_fresh(record).unwrap_or(false)
}

/// Whether the page is the one that the record makes.
pub fn is_fresh(record: &Path) -> Result<bool, Failure> {
    if !record.is_file() {
        return Err(Failure::new(Exit::Input, format!("{} is missing", record.display())));
    }
    let page = page(&load(record)?);
    Ok(regular::read_text(&beside(record), regular::TEXT).is_ok_and(|there| there.replace("\r\n", "\n") == page))
}

fn page(rows: &[Row]) -> String {
    let mut text = "# Agreement of renderers\n\n*Written by `ltsc agree --record`; do not edit.*\n\n\
        The scenes in several renderers, several seeds each. **agree** and **differ** are proved, in red, green and blue each: *agree* at \
        5 % that\nevery tile of an 8 x 8 grid and the whole image lie within the tolerance, *differ* at 0.5 % that something lies beyond \
        it; *undecided*\nsays how many samples per pixel would show agreement if there is one. More noise never makes more agreement. \
        The tolerance is 5 % in a\ntile and 1 % in the whole, unless a row says otherwise, and what the targets state of the scene beside \
        it, up to 10 %. B / A are ratios of means.\n"
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
                "| A | B | images | R, G, B of B / A, standard errors | verdict | tiles that agree | |\n|---|---|---|---|---|---|---|\n",
            );
        }
        text.push_str(&line(row));
    }
    text
}

fn line(row: &Row) -> String {
    let verdict = &row.verdict;
    let settings = row.settings.iter().map(|one| format!("`{one}`"));
    let notes: Vec<String> = settings.chain([row.told().proof()]).chain(row.told().notes()).collect();
    let (a, b) = verdict.images;
    let counts = if row.a.name == "reference" { format!("{a}, {b}") } else { format!("{a} each") };
    format!(
        "| {} | {} | {counts}, {size} x {size}, {} samples | {} | **{}** | {} of {} | {} |\n",
        row.a.name,
        row.b.name,
        row.samples,
        row.told().channels(),
        verdict.outcome.word(),
        verdict.tiles.iter().filter(|tile| **tile == Outcome::Agree).count(),
        verdict.tiles.len(),
        notes.join("; "),
        size = row.size,
    )
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::compare::verdict::{Cell, Channel, Tolerance};

    use super::*;

    fn row(scene: &str, b: &str, ratio: f64) -> Row {
        let side = |name: &str| Side { name: name.to_owned(), version: "1.0".to_owned(), seconds: Some(1.5) };
        let channel = |ratio| Channel { ratio, error: 0.001 };
        let verdict = Verdict {
            outcome: Outcome::Agree,
            tolerance: Tolerance::default(),
            images: (4, 4),
            channels: [channel(Some(ratio)), channel(Some(1.0)), channel(None)],
            tiles: vec![Outcome::Agree; 64],
            worst: Cell { grid: 8, at: (3, 4), channel: 1, ratio: Some(1.02), z: 2.5 },
            differing: 0,
            needed: None,
            rare: 0,
            together: (false, false),
            masked: 0,
        };
        let stated = vec![Stated { by: "luxcore".to_owned(), what: "a rough conductor".to_owned(), share: 0.03 }];
        let (a, b) = (side("mitsuba-3"), side(b));
        Row {
            scene: scene.to_owned(),
            settings: Vec::new(),
            size: 128,
            samples: 64,
            a,
            b,
            stated,
            excused: false,
            verdict,
        }
    }

    #[test]
    fn newer_rows_take_the_place_of_older_ones() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("agreement.json");
        record(&file, &[row("ring", "luxcore", 1.01), row("cbox_classic", "luxcore", 1.0)], false).expect("written");
        record(&file, &[row("ring", "luxcore", 1.002), row("ring", "cycles", 1.0)], false).expect("written");
        let rows = load(&file).expect("a record");
        let known: Vec<_> = rows
            .iter()
            .map(|row| (row.scene.as_str(), row.b.name.as_str(), row.verdict.channels[0].ratio.expect("light")))
            .collect();
        assert_eq!(known, [("cbox_classic", "luxcore", 1.0), ("ring", "cycles", 1.0), ("ring", "luxcore", 1.002)]);
        let page = fs::read_to_string(beside(&file)).expect("a page");
        assert!(
            page.contains("## ring")
                && page.contains("1.0020 +- 0.0010, 1.0000 +- 0.0010, -")
                && page.contains("0.991..1.020"),
            "{page}"
        );
        assert!(is_fresh(&file).expect("a record"));
        fs::write(beside(&file), "other").expect("written");
        assert!(!is_fresh(&file).expect("a record"));
    }

    #[test]
    fn what_is_stated_excuses_a_difference_and_makes_no_agreement() {
        let mut row = row("ring", "luxcore", 1.2);
        (row.excused, row.verdict.outcome) = (true, Outcome::Undecided);
        let text = row.text();
        assert!(text.contains("undecided: green of tile 3, 4: 1.0200, by more than"), "{text}");
        assert!(
            text.contains("which the targets state\n")
                && text.contains("luxcore states up to 3.0 % for a rough conductor"),
            "{text}"
        );
        let kept: Row = serde_json::from_str(&serde_json::to_string(&row).expect("JSON")).expect("a row");
        assert!(kept.excused);
    }

    #[test]
    fn what_is_no_record_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("agreement.json");
        fs::write(&file, "{\"other\": 1}").expect("written");
        assert!(record(&file, &[], false).is_err());
        assert_eq!(fs::read_to_string(&file).expect("still there"), "{\"other\": 1}");
        assert!(record(&folder.path().join("page.md"), &[], false).is_err());
    }
}
