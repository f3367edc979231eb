//! `ltsc equiv`: whether two scenes mean the same, and every difference.

use std::path::Path;

use ltsc_core::diag::Origin;
use ltsc_core::equiv::{self, Comparison, Difference, Place, Side};
use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;
use serde_json::{Value, json};

use super::said::plural;
use super::shared::{CheckedFile, check, report};
use crate::args::{Equiv, Format};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal;

/// Differences that people are shown, and places of each of them.
const SHOWN: usize = 100;
const PLACES: usize = 3;

/// A scene with its file.
struct Read {
    scene: Scene,
    file: CheckedFile,
}

impl Read {
    fn side(&self) -> Side<'_> {
        Side { scene: &self.scene, findings: &self.file.checked.findings }
    }
}

pub fn run(command: &Equiv) -> Result<Exit, Failure> {
    let (a, b) = match (read(&command.a, command)?, read(&command.b, command)?) {
        (Ok(a), Ok(b)) => (a, b),
        (Err(exit), _) | (_, Err(exit)) => return Ok(exit),
    };
    let comparison = equiv::compare(a.side(), b.side(), command.tolerance);
    let both = [&a, &b];
    match command.findings.format {
        Format::Json => terminal::print(&format!("{:#}\n", document(&comparison, command, both))),
        Format::Short => {
            let lines = comparison.differences.iter().map(|difference| short(difference, both) + "\n");
            terminal::print(&lines.collect::<String>());
        }
        Format::Human | Format::Sarif | Format::Github => {
            terminal::print(&people(&comparison, command, both));
        }
    }
    Ok(if comparison.equal() { Exit::Done } else { Exit::No })
}

/// Reads a scene; where it gives none, its findings are printed and the exit code comes back.
fn read(path: &Path, command: &Equiv) -> Result<Result<Read, Exit>, Failure> {
    if path.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{} is a folder", path.display())).help("name one scene"));
    }
    let project = Project::of(path)?;
    let unlinted = command.findings.unlinted();
    let mut files = check(&project, &[path.to_path_buf()], &unlinted, Overrides::default(), &[])?;
    if let Some(scene) = files.first_mut().and_then(|file| file.checked.scene.take())
        && let Some(file) = files.pop()
    {
        return Ok(Ok(Read { scene, file }));
    }
    let (exit, _) = report(&files, Vec::new(), command.findings.format, false, true);
    if exit != Exit::Done {
        return Ok(Err(exit));
    }
    Err(Failure::new(Exit::Input, format!("{} is a library: it has no `scene`", path.display()))
        .help("name a scene that uses it"))
}

/// Where something is written: path, and line and column where it is a text.
fn written(place: &Place, read: &Read) -> Option<(String, Option<(usize, usize)>)> {
    match &place.origin {
        Origin::Text(span) => {
            let at = read.file.sources.position(span.file, span.start);
            Some((read.file.sources.get(span.file).path.clone(), Some((at.line, at.column))))
        }
        Origin::File { path, place: _ } => Some((path.clone(), None)),
        Origin::Made => None,
    }
}

/// A place in words: `floor`, scene.xml:12.
fn words(place: &Place, read: &Read) -> String {
    let written = written(place, read).map(|(path, at)| match at {
        Some((line, column)) => format!("{path}:{line}:{column}"),
        None => path,
    });
    let name = (!place.name.is_empty()).then(|| format!("`{}`", place.name));
    terminal::harmless(&[name, written].into_iter().flatten().collect::<Vec<_>>().join(", ")).into_owned()
}

fn people(comparison: &Comparison, command: &Equiv, both: [&Read; 2]) -> String {
    let mut text = String::new();
    for difference in comparison.differences.iter().take(SHOWN) {
        let Difference { kind, what, a, b, places } = difference;
        text.push_str(&format!("{}: {}\n", kind.word(), terminal::harmless(what)));
        for (side, (name, value)) in [("A", a), ("B", b)].into_iter().enumerate() {
            let known: Vec<&Place> = places.iter().filter_map(|pair| pair[side].as_ref()).collect();
            let first = known.first().map(|place| words(place, both[side])).unwrap_or_default();
            let next: Vec<String> = known
                .iter()
                .take(PLACES)
                .skip(1)
                .map(|place| format!("`{}`", terminal::harmless(&place.name)))
                .collect();
            let mut at = if first.is_empty() { String::new() } else { format!("  at {first}") };
            if !next.is_empty() {
                at.push_str(&format!("; {}", next.join(", ")));
            }
            if known.len() > PLACES {
                at.push_str(&format!(" and {} more", known.len() - PLACES));
            }
            text.push_str(&format!("  {name}  {}{at}\n", terminal::harmless(value)));
        }
        text.push('\n');
    }
    let count = comparison.differences.len();
    if count > SHOWN {
        text.push_str(&format!("... and {} more differences; `--format short` shows all\n\n", count - SHOWN));
    }
    let places: usize = comparison.differences.iter().map(|difference| difference.places.len()).sum();
    let answer = match count {
        0 => "no difference".to_owned(),
        count if places == count => plural(count, "difference"),
        count => format!("{} at {}", plural(count, "difference"), plural(places, "place")),
    };
    let Comparison { surfaces: [a, b], found, .. } = comparison;
    text.push_str(&format!(
        "{answer} (tolerance {}); {found} of {} of A found again in B, which has {b}\n",
        command.tolerance,
        plural(*a, "surface")
    ));
    text
}

/// `scene.xml:12:3: material: diffuse reflectance: A 0.5, B 0.6 (`floor`, 3 places)`
fn short(difference: &Difference, both: [&Read; 2]) -> String {
    let Difference { kind, what, a, b, places } = difference;
    let first = places.first().and_then(|[one, other]| match (one, other) {
        (Some(place), _) => Some((place, both[0])),
        (None, Some(place)) => Some((place, both[1])),
        (None, None) => None,
    });
    let at = first.and_then(|(place, read)| written(place, read)).map_or(String::new(), |(path, at)| match at {
        Some((line, column)) => format!("{path}:{line}:{column}: "),
        None => format!("{path}: "),
    });
    let name = first.map(|(place, _)| &place.name).filter(|name| !name.is_empty());
    let name = name.map_or(String::new(), |name| format!(" `{name}`"));
    let count = if places.len() > 1 { format!(" ({})", plural(places.len(), "place")) } else { String::new() };
    let line = format!("{at}{}: {what}:{name} A {a}, B {b}{count}", kind.word());
    terminal::harmless(&line).replace('\n', " ")
}

fn document(comparison: &Comparison, command: &Equiv, both: [&Read; 2]) -> Value {
    let place = |place: &Option<Place>, side: usize| {
        place.as_ref().map(|place| {
            let (path, at) = written(place, both[side]).unzip();
            let (line, column) = at.flatten().unzip();
            json!({ "name": place.name, "path": path, "line": line, "column": column })
        })
    };
    let rows: Vec<Value> = comparison
        .differences
        .iter()
        .map(|Difference { kind, what, a, b, places }| {
            let places: Vec<Value> =
                places.iter().map(|[a, b]| json!({ "a": place(a, 0), "b": place(b, 1) })).collect();
            json!({ "kind": kind.word(), "what": what, "a": a, "b": b, "count": places.len(), "places": places })
        })
        .collect();
    let [a, b] = comparison.surfaces;
    json!({
        "a": command.a.display().to_string(),
        "b": command.b.display().to_string(),
        "equal": comparison.equal(),
        "tolerance": command.tolerance,
        "surfaces": { "a": a, "b": b, "found": comparison.found },
        "differences": rows,
    })
}
