//! `ltsc import --survey`: what a folder of other programs' scenes holds, how many convert, and what stands in the way.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use ltsc_core::diag::{Finding, Severity};
use ltsc_core::eval::Overrides;
use ltsc_core::import::IMPORTERS;
use ltsc_core::ir::{Filter, LightKind, Scene};
use ltsc_core::pipeline;
use ltsc_evaluation::disk::Changed;
use serde_json::{Value, json};

use super::said::plural;
use super::shared::{CheckedFile, check_each, disk_of};
use crate::args::{Findings, Format};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};
use crate::terminal::{self, Bar};

/// Reasons that people are shown.
const SHOWN: usize = 40;

/// What came of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// Nothing is dropped.
    Converts,
    /// Something is.
    Loses,
    /// It gives no scene.
    Broken,
}

impl Fate {
    fn word(self) -> &'static str {
        match self {
            Self::Converts => "converts",
            Self::Loses => "loses",
            Self::Broken => "broken",
        }
    }
}

/// What is kept of a file once its scene is let go.
struct Row {
    path: String,
    format: &'static str,
    fate: Fate,
    holds: BTreeSet<&'static str>,
    /// Code and reason.
    reasons: BTreeSet<(&'static str, String)>,
    /// Other files of scenes that it reads.
    includes: BTreeSet<String>,
    /// Files that it names and that are not there.
    missing: Vec<String>,
}

/// Surveys the scenes below `folder`.
pub fn run(folder: &Path, findings: &Findings) -> Result<Exit, Failure> {
    if !folder.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{} is no folder", folder.display()))
            .help("name a folder with scenes, or import a single one without `--survey`"));
    }
    let endings: Vec<&str> = IMPORTERS.iter().flat_map(|importer| importer.endings).copied().collect();
    let project::Found { files, problems } = project::files_ending(folder, &endings)?;
    let project = Project::of(folder)?;
    let root = findings.root.clone().unwrap_or_else(|| folder.to_path_buf());
    let findings = Findings { root: Some(root), ..findings.unlinted() };
    let disk = disk_of(&project, &findings)?;
    let from = Changed { disk: &disk, texts: &BTreeMap::new() };
    let (done, bar) = (AtomicU64::new(0), Mutex::new(Bar::new(files.len() as u64, "reading scenes")));
    let rows = check_each(&project, &files, &findings, Overrides::default(), &[], &from, |file| {
        let row = row(file);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Ok(mut bar) = bar.lock() {
            bar.set(done);
        }
        row
    });
    if let Ok(bar) = bar.lock() {
        bar.finish();
    }
    let all = rows?;
    // What another file includes is no scene of its own; of two that include each other the first is.
    let by_path: BTreeMap<&str, &Row> = all.iter().map(|row| (row.path.as_str(), row)).collect();
    let part_of = |part: &str, whole: &Row| {
        let back = by_path.get(part).is_some_and(|row| row.includes.contains(&whole.path));
        !back || whole.path.as_str() < part
    };
    let pairs = all.iter().flat_map(|row| row.includes.iter().map(move |part| (part.as_str(), row)));
    let parts: BTreeSet<&str> = pairs.filter(|(part, row)| part_of(part, row)).map(|(part, _)| part).collect();
    let included = |row: &Row| parts.contains(row.path.as_str());
    let parts = all.iter().filter(|row| included(row)).count();
    let scenes: Vec<&Row> = all.iter().filter(|row| !included(row)).collect();
    for problem in &problems {
        terminal::error(&problem.message);
    }
    match findings.format {
        Format::Json => terminal::print(&format!("{:#}\n", document(folder, &scenes, parts))),
        Format::Short => {
            let line = |row: &&Row| {
                let more = if row.missing.is_empty() { "" } else { ", incomplete" };
                format!("{}: {}{more}\n", terminal::harmless(&row.path), row.fate.word())
            };
            terminal::print(&scenes.iter().map(line).collect::<String>());
        }
        Format::Human | Format::Sarif | Format::Github => terminal::print(&people(folder, &scenes, parts)),
    }
    Ok(problems.first().map_or(Exit::Done, |problem| problem.exit))
}

/// What is kept of a file.
fn row(mut file: CheckedFile) -> Row {
    let path = file.path.to_string();
    let format = ltsc_core::import::find(&file.path).map_or("", |importer| importer.name);
    let inputs = file.checked.inputs.keys().filter(|other| **other != file.path);
    let includes = inputs.filter(|other| ltsc_core::import::find(other).is_some()).map(ToString::to_string).collect();
    let mut found = std::mem::take(&mut file.checked.findings);
    let mut holds = BTreeSet::new();
    let scene = file.checked.scene.take();
    let mut broken = scene.is_none();
    if let Some(scene) = scene {
        holds = constructs(&scene);
        // Nothing that a panic leaves half done is looked at afterwards.
        let prepared = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| pipeline::prepare(scene)));
        match prepared {
            Ok(Ok((_, remarks))) => found.extend(remarks),
            Ok(Err(invalid)) => {
                broken = true;
                found.extend(invalid);
            }
            Err(payload) => {
                broken = true;
                found.extend(pipeline::fault(&file.path, &terminal::panic_text(payload.as_ref())).findings);
            }
        }
    }
    let told = |finding: &&Finding| {
        finding.severity == Severity::Error || matches!(finding.id, "loss-dropped" | "loss-approximated")
    };
    let reasons: BTreeSet<(&'static str, String)> =
        found.iter().filter(told).map(|finding| (finding.id, reason(&finding.message))).collect();
    let fate = match broken {
        true => Fate::Broken,
        false if found.iter().any(|finding| finding.id == "loss-dropped" || finding.severity == Severity::Error) => {
            Fate::Loses
        }
        false => Fate::Converts,
    };
    let missing = file.checked.missing.iter().map(ToString::to_string).collect();
    Row { path, format, fate, holds, reasons, includes, missing }
}

/// What a scene holds, by kind.
fn constructs(scene: &Scene) -> BTreeSet<&'static str> {
    let surfaces = scene.surfaces().map(|(_, shape)| if shape.emission.is_some() { "area light" } else { "surface" });
    let mut all: BTreeSet<&'static str> = surfaces.collect();
    all.extend(scene.surfaces().map(|(_, shape)| scene.materials[shape.material].bsdf.kind()));
    let one_sided = scene.surfaces().any(|(_, shape)| scene.materials[shape.material].is_one_sided());
    all.extend(one_sided.then_some("surface that is black from behind"));
    all.extend(scene.lights.values().map(|light| match &light.kind {
        LightKind::Environment { .. } if light.kind.texture().is_some() => "environment image",
        LightKind::Environment { .. } => "environment",
        LightKind::Point { .. } => "point light",
        LightKind::Spot { .. } => "spot light",
        LightKind::Directional { .. } => "directional light",
    }));
    all.extend((!scene.textures.is_empty()).then_some("image"));
    all.extend((!scene.instances.is_empty()).then_some("instances"));
    all.extend((scene.cameras.len() > 1).then_some("several cameras"));
    all.extend([scene.integrator.word(), scene.sampler.word()]);
    all.insert(match scene.film.filter {
        Filter::Box { .. } => "box filter",
        Filter::Gaussian { .. } => "gaussian filter",
    });
    all
}

/// A message without what differs from file to file: paths and numbers.
fn reason(message: &str) -> String {
    let mut text = String::new();
    for (at, part) in message.split('`').enumerate() {
        let quoted = at % 2 == 1;
        let path = quoted && part.contains(['/', '.']);
        if at > 0 {
            text.push('`');
        }
        if path {
            text.push_str("...");
        } else if quoted {
            text.push_str(part);
        } else {
            let words = part.split(' ').map(|word| if word.parse::<f64>().is_ok() { "N" } else { word });
            text.push_str(&words.collect::<Vec<_>>().join(" "));
        }
    }
    text
}

/// How many scenes have each of something, the most frequent first.
fn counted<T: Ord>(all: impl Iterator<Item = T>) -> Vec<(usize, T)> {
    let mut counts: BTreeMap<T, usize> = BTreeMap::new();
    for one in all {
        *counts.entry(one).or_default() += 1;
    }
    let mut rows: Vec<(usize, T)> = counts.into_iter().map(|(one, count)| (count, one)).collect();
    rows.sort_by(|(a, one), (b, other)| b.cmp(a).then_with(|| one.cmp(other)));
    rows
}

/// Reasons with codes: those that keep a scene from being converted as it is, and those that are only near.
fn reasons<'r>(scenes: &[&'r Row], near: bool) -> Vec<(usize, &'r (&'static str, String))> {
    let all = scenes.iter().flat_map(|row| &row.reasons);
    counted(all.filter(|(id, _)| (*id == "loss-approximated") == near))
}

fn fates(scenes: &[&Row]) -> [usize; 3] {
    [Fate::Converts, Fate::Loses, Fate::Broken].map(|fate| scenes.iter().filter(|row| row.fate == fate).count())
}

/// Scenes whose files are all there, and the others.
fn split<'r>(scenes: &[&'r Row]) -> (Vec<&'r Row>, Vec<&'r Row>) {
    scenes.iter().partition(|row| row.missing.is_empty())
}

fn people(folder: &Path, scenes: &[&Row], parts: usize) -> String {
    let formats: Vec<String> = counted(scenes.iter().map(|row| row.format))
        .iter()
        .map(|(count, format)| format!("{count} {format}"))
        .collect();
    let mut text = format!("{}: {} ({})", folder.display(), plural(scenes.len(), "scene"), formats.join(", "));
    if parts > 0 {
        text.push_str(&format!(", and {} that they include", plural(parts, "file")));
    }
    text.push_str("\n\n scenes  hold\n");
    let (complete, lacking) = split(scenes);
    for (count, what) in counted(scenes.iter().flat_map(|row| &row.holds)) {
        text.push_str(&format!("{count:>7}  {what}\n"));
    }
    for (near, title) in [(false, "what stands in the way"), (true, "what is read as something near it")] {
        let rows = reasons(&complete, near);
        if rows.is_empty() {
            continue;
        }
        text.push_str(&format!("\n scenes  {title}\n"));
        for (count, (id, reason)) in rows.iter().take(SHOWN) {
            text.push_str(&format!("{count:>7}  {id}: {}\n", terminal::harmless(reason).replace('\n', " ")));
        }
        if rows.len() > SHOWN {
            text.push_str(&format!("         ... and {} more; `--format json` has all\n", rows.len() - SHOWN));
        }
    }
    let [converts, loses, broken] = fates(&complete);
    let share = 100.0 * converts as f64 / complete.len().max(1) as f64;
    let whole = if lacking.is_empty() { "" } else { "complete " };
    text.push_str(&format!(
        "\n{converts} of {} {whole}scenes ({share:.0} %) convert with no `loss-dropped`, {loses} lose something, {broken} give no scene; \
         `--format short` names them\n",
        complete.len()
    ));
    if !lacking.is_empty() {
        text.push_str(&format!("not counted in this: {} with missing files\n", plural(lacking.len(), "scene")));
    }
    text
}

fn document(folder: &Path, scenes: &[&Row], parts: usize) -> Value {
    let (complete, lacking) = split(scenes);
    let [converts, loses, broken] = fates(&complete);
    let holds: Vec<Value> = counted(scenes.iter().flat_map(|row| &row.holds))
        .into_iter()
        .map(|(count, what)| json!({ "what": what, "scenes": count }))
        .collect();
    let reason =
        |(count, (id, reason)): (usize, &(&str, String))| json!({ "id": id, "reason": reason, "scenes": count });
    let list = |near| reasons(&complete, near).into_iter().map(reason).collect::<Vec<Value>>();
    let files: Vec<Value> = scenes
        .iter()
        .map(|row| {
            let reasons = row.reasons.iter().map(|(id, reason)| json!({ "id": id, "reason": reason }));
            json!({
                "path": row.path, "format": row.format, "verdict": row.fate.word(),
                "reasons": reasons.collect::<Vec<_>>(), "missing": row.missing,
            })
        })
        .collect();
    json!({
        "folder": folder.display().to_string(),
        "counts": {
            "scenes": scenes.len(), "included": parts, "incomplete": lacking.len(), "complete": complete.len(),
            "converts": converts, "loses": loses, "broken": broken,
        },
        "holds": holds, "in_the_way": list(false), "approximated": list(true), "scenes": files,
    })
}
