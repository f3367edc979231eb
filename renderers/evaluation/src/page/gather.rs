//! What there is to show: a folder of results, with images that were put there by hand, or loose files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ltsc_core::files::VPath;
use ltsc_render::image::{self, Attributes, Image, ImageError};
use ltsc_render::regular;

use super::described;
use super::model::{Blamed, Fact, Model, Pair, Picture, Row, Scene, Worst};
use crate::chunk::VARIANCE;
use crate::compare::blame::Kind;
use crate::compare::verdict::{Stated, Told};
use crate::compare::{MAPS, METRICS};
use crate::failure::{Exit, Failure, why};
use crate::study::results::{self, Results, Settings, Status};
use crate::study::timing::{self, Timing};

/// The number of the form of a page's data.
const FORM: u32 = 1;

/// The largest table of results that is read.
const LARGEST: u64 = 1 << 28;

/// An image, its variance, and what its header says.
pub(super) type Read = (Image, Option<Image>, Attributes);

/// Which pixels see what: scene, file, size, names of groups.
pub(super) type Seen = (usize, PathBuf, (usize, usize), Vec<String>);

/// A page before its pixels are looked at.
pub struct Book {
    pub(super) model: Model,
    /// Where each image lies; none of those that are not there.
    pub(super) paths: Vec<Option<PathBuf>>,
    /// The layers that are meant, of files that have several and no picture of their own.
    pub(super) layers: BTreeMap<usize, String>,
    /// Which pixels see what: scene, file, size, names of groups.
    pub(super) groups: Vec<Seen>,
    /// Comparisons that no evaluation has made: scene, number in its list.
    pub(super) open: BTreeSet<(usize, usize)>,
    /// Labels that images have, by scene.
    labels: BTreeSet<(usize, String)>,
    /// How errors fell, where it is known.
    pub(super) timing: Option<Timing>,
    /// What was found of references, by the file they were made from: image.
    pub(super) wanted: Vec<Wanted>,
}

/// A side of a comparison that is a file, whose image is known once its header is read.
pub(super) struct Wanted {
    pub scene: usize,
    pub pair: usize,
    pub from: String,
}

impl Book {
    /// How many images there are, those that are missing too.
    #[must_use]
    pub fn count(&self) -> usize {
        self.model.images.len()
    }

    fn new(title: String) -> Self {
        let number = |value: f32| value.is_finite().then_some(value);
        let maps = MAPS.iter().map(|map| Row {
            name: map.name.to_owned(),
            summary: map.summary.to_owned(),
            formula: map.formula.to_owned(),
            range: (number(map.range.0), number(map.range.1)),
        });
        let metrics = METRICS.iter().map(|metric| Row {
            name: metric.name.to_owned(),
            summary: metric.summary.to_owned(),
            formula: metric.formula.to_owned(),
            range: (None, None),
        });
        let model = Model {
            form: FORM,
            generator: concat!("ltsc ", env!("CARGO_PKG_VERSION")).to_owned(),
            title,
            maps: maps.collect(),
            metrics: metrics.collect(),
            ..Model::default()
        };
        Self {
            model,
            paths: Vec::new(),
            layers: BTreeMap::new(),
            groups: Vec::new(),
            open: BTreeSet::new(),
            labels: BTreeSet::new(),
            timing: None,
            wanted: Vec::new(),
        }
    }

    /// Adds an image to a scene, with a label that no other one of the scene has.
    fn add(&mut self, scene: usize, mut picture: Picture, path: Option<PathBuf>) -> usize {
        let plain = picture.label.clone();
        let mut number = 2;
        while !self.labels.insert((scene, picture.label.clone())) {
            picture.label = format!("{plain} {number}");
            number += 1;
        }
        self.model.scenes[scene].images.push(self.model.images.len());
        self.model.images.push(picture);
        self.paths.push(path);
        self.paths.len() - 1
    }

    /// Adds an image, or each layer of a file that has several and no picture of its own.
    pub(super) fn add_all(&mut self, scene: usize, picture: &Picture, path: &Path) {
        // A file that cannot be read is told when its pixels are looked at.
        let layers = image::layers(path).unwrap_or_default();
        if layers.is_empty() {
            self.add(scene, picture.clone(), Some(path.to_path_buf()));
        }
        for layer in layers {
            let label = format!("{}: {layer}", picture.label);
            let number = self.add(scene, Picture { label, ..picture.clone() }, Some(path.to_path_buf()));
            self.layers.insert(number, layer);
        }
    }

    /// Reads an image, with its variance where the file has one.
    pub(super) fn read(&self, number: usize) -> Option<Result<Read, ImageError>> {
        let path = self.paths[number].as_deref()?;
        Some(match self.layers.get(&number) {
            Some(layer) => image::read_layer(path, layer).map(|(image, attributes)| (image, None, attributes)),
            None => image::read_layered(path, VARIANCE),
        })
    }

    /// Asks for comparisons of the images of a scene that no evaluation has compared, with its reference or its first image.
    fn ask(&mut self, at: usize) {
        let images = &self.model.images;
        let scene = &mut self.model.scenes[at];
        let there = |image: &&usize| matches!(images[**image].status, "done");
        let reference = scene.images.iter().filter(there).find(|image| images[**image].kind == "reference");
        let Some(a) = reference.or_else(|| scene.images.iter().find(there)).copied() else { return };
        let known: BTreeSet<usize> = scene.pairs.iter().flat_map(|pair| pair.b.into_iter().chain(pair.a)).collect();
        let new: Vec<usize> =
            scene.images.iter().filter(there).copied().filter(|b| *b != a && !known.contains(b)).collect();
        for b in new {
            self.open.insert((at, scene.pairs.len()));
            let label = |image: usize| images[image].label.clone();
            let (a_label, b_label) = (label(a), label(b));
            scene.pairs.push(Pair { a: Some(a), b: Some(b), a_label, b_label, ..Pair::default() });
        }
    }
}

/// The page of loose files, in their order; the first is the reference.
///
/// # Errors
/// If one of them is not there.
pub fn of_files(files: &[PathBuf]) -> Result<Book, Failure> {
    let mut book = Book::new("images".to_owned());
    book.model.scenes.push(Scene { name: "images".to_owned(), scene: "images".to_owned(), ..Scene::default() });
    for file in files {
        if !file.is_file() {
            return Err(Failure::new(Exit::Input, format!("{}: there is no such file", file.display()))
                .help("name OpenEXR or PFM files"));
        }
        let label = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let facts = vec![Fact("file".to_owned(), name)];
        let picture = Picture { label, kind: "image", status: "done", facts, ..Picture::default() };
        book.add_all(0, &picture, file);
    }
    book.ask(0);
    Ok(book)
}

/// The page of a folder in the layout of results, with images that were put there by hand.
///
/// # Errors
/// If the folder or its tables cannot be read.
pub fn of_folder(folder: &Path) -> Result<Book, Failure> {
    if !folder.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{}: there is no such folder", folder.display()))
            .help("name a folder of results, or one with OpenEXR or PFM images"));
    }
    let real = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let name = real.file_name().map_or_else(|| "images".to_owned(), |name| name.to_string_lossy().into_owned());
    let mut book = Book::new(name);
    let results: Option<Results> = table(folder, "results.json")?;
    let timing: Option<Timing> = table(folder, "timing.json")?;
    let mut folders = BTreeMap::new();
    if let Some(results) = &results {
        of_results(&mut book, results, timing.as_ref(), folder, &mut folders);
    }
    super::loose::by_hand(&mut book, folder, &mut folders)?;
    for scene in 0..book.model.scenes.len() {
        book.ask(scene);
    }
    book.timing = timing;
    Ok(book)
}

/// A table of results; nothing where there is none.
fn table<T: serde::de::DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<T>, Failure> {
    let path = folder.join(name);
    if std::fs::symlink_metadata(&path).is_err() {
        return Ok(None);
    }
    let text = regular::read(&path, LARGEST)
        .map_err(|error| Failure::new(Exit::Input, format!("{}: {}", path.display(), why(&error))))?;
    serde_json::from_slice(&text).map(Some).map_err(|error| {
        Failure::new(Exit::Input, format!("{}: {error}", path.display()))
            .help("carry out the evaluation again, or move this file away to see the images alone")
    })
}

fn of_results(
    book: &mut Book,
    results: &Results,
    timing: Option<&Timing>,
    folder: &Path,
    folders: &mut BTreeMap<String, usize>,
) {
    let model = &mut book.model;
    model.title.clone_from(&results.name);
    model.description.clone_from(&results.description);
    model.generator.clone_from(&results.generator);
    model.date = timing.map(|timing| timing.date.chars().take(16).collect::<String>().replace('T', " "));
    let mut facts = vec![Fact("written by".to_owned(), results.generator.clone())];
    facts.extend(timing.map(|timing| Fact("machine".to_owned(), timing.machine.to_string())));
    model.facts = facts;
    let text = regular::read_text(&folder.join("evaluation.toml"), regular::TEXT);
    model.cases = text.map(|text| described::cases(&text)).unwrap_or_default();
    let times = timing.map(Timing::by_name).unwrap_or_default();
    for condition in &results.conditions {
        let at = book.model.scenes.len();
        book.model.scenes.push(Scene {
            name: condition.name.clone(),
            scene: condition.scene.clone(),
            documentation: condition.documentation.clone(),
            parameters: condition.parameters.iter().map(|(name, value)| Fact(name.clone(), value.clone())).collect(),
            ..Scene::default()
        });
        let mut numbers = BTreeMap::new();
        for run in &condition.runs {
            let run = &kept_inside(run);
            let time = times.get(&(condition.name.as_str(), run.label.as_str())).copied();
            let path = run.image.as_ref().map(|path| folder.join(path));
            if let Some((around, _)) = run.image.as_ref().and_then(|path| path.rsplit_once('/')) {
                folders.insert(around.to_owned(), at);
                folders.insert(around.replacen("scenes/", "references/", 1), at);
            }
            let picture = picture(run, time, folder);
            numbers.insert(run.label.clone(), book.add(at, picture, path));
        }
        for found in condition.groups.iter().filter(|found| inside(&found.file)) {
            let names = found.names.iter().map(|one| group(one.kind, &one.name)).collect();
            book.groups.push((at, folder.join(&found.file), (found.width, found.height), names));
        }
        for pair in &condition.pairs {
            if pair.reference {
                let wanted = Wanted { scene: at, pair: book.model.scenes[at].pairs.len(), from: pair.a.clone() };
                book.wanted.push(wanted);
            }
            let made = compared(pair, &numbers);
            book.model.scenes[at].pairs.push(made);
        }
    }
}

/// Whether a path that a table names stays in the folder of the table, which may be anybody's.
fn inside(path: &str) -> bool {
    VPath::resolve("", path).is_ok()
}

/// A run without an image that would lie elsewhere.
fn kept_inside(run: &results::Run) -> results::Run {
    let image = run.image.clone().filter(|path| inside(path));
    results::Run { image, ..run.clone() }
}

/// An image of an evaluation.
fn picture(run: &results::Run, time: Option<&timing::Run>, folder: &Path) -> Picture {
    let status = match run.status {
        Status::Done => "done",
        Status::Failed => "failed",
        Status::Skipped => "skipped",
        // Somebody is to make it, and it is not there.
        Status::Awaited => "missing",
    };
    let lacks = run.status == Status::Done && run.image.as_ref().is_none_or(|path| !folder.join(path).is_file());
    let log = run.image.as_ref().and_then(|path| path.strip_suffix(".exr")).map(|path| format!("{path}.log"));
    Picture {
        label: run.label.clone(),
        kind: "image",
        case: run.case.clone(),
        renderer: run.renderer.clone(),
        status: if lacks { "missing" } else { status },
        why: match &run.expected {
            Some(expected) if run.status == Status::Awaited => Some(format!("it is awaited as {expected}")),
            _ if lacks => Some("its file is not there any more".to_owned()),
            _ => run.failure.clone(),
        },
        file: run.image.as_ref().map(|path| format!("../{path}")),
        log: log.filter(|path| folder.join(path).is_file()).map(|path| format!("../{path}")),
        facts: facts(run, time),
        stated: run.stated.iter().map(stated).collect(),
        samples: Some(run.samples),
        seconds: time.map(|time| time.cost.seconds),
        noise: run.noise,
        ..Picture::default()
    }
}

fn stated(stated: &Stated) -> String {
    format!("{} states up to {:.1} % for {}", stated.by, 100.0 * stated.share, stated.what)
}

/// How an image came to be.
fn facts(run: &results::Run, time: Option<&timing::Run>) -> Vec<Fact> {
    let mut facts = Vec::new();
    let mut add = |name: &str, value: String| {
        if !value.is_empty() {
            facts.push(Fact(name.to_owned(), value));
        }
    };
    add("case", run.case.clone());
    add("renderer", format!("{} {}", run.driver, run.version));
    add("called in the file", run.renderer.clone());
    add("target", run.target.clone());
    add("samples per pixel", run.samples.to_string());
    add("chunks", format!("{}, first seed {}", run.chunks, run.first_seed));
    if let Some(settings) = &run.settings {
        let Settings { algorithm, family, convergence, max_depth, unbounded, filter, clamped, passed } = settings;
        let family = family.as_ref().filter(|family| Some(*family) != algorithm.as_ref());
        let of = [algorithm.clone(), family.map(|family| format!("({family})")), convergence.clone()];
        add("algorithm", of.into_iter().flatten().collect::<Vec<_>>().join(" "));
        let depth = max_depth.map_or_else(String::new, |depth| format!("{depth} segments"));
        add("depth of paths", if *unbounded { "not bounded".to_owned() } else { depth });
        add("filter", filter.clone().unwrap_or_default());
        add("samples clamped at", clamped.map_or_else(String::new, |limit| limit.to_string()));
        add("passed through", passed.join("; "));
    }
    add("noise of a pixel", run.noise.map_or_else(String::new, |noise| format!("{:.3} % of the mean", 100.0 * noise)));
    if let Some(time) = time {
        let cost = &time.cost;
        add("seconds", format!("{:.1}", cost.seconds));
        add("processor seconds", cost.cpu_seconds.map_or_else(String::new, |seconds| format!("{seconds:.1}")));
        add("memory", cost.peak_memory.map_or_else(String::new, |bytes| format!("{:.0} MB", bytes as f64 / 1e6)));
        add("efficiency", time.efficiency.map_or_else(String::new, |value| format!("{value:.3}")));
        add("times compare within", time.group.clone());
    }
    add("hash of scene and settings", run.identity.clone());
    add("files for the renderer", run.files.clone().unwrap_or_default());
    facts
}

/// What a group of pixels is called within a page.
fn group(kind: Kind, name: &str) -> String {
    format!("{kind:?} {name}")
}

/// A comparison of an evaluation.
fn compared(pair: &results::Pair, numbers: &BTreeMap<String, usize>) -> Pair {
    let told = pair.verdict.as_ref().map(|verdict| Told { verdict, stated: &pair.stated, excused: pair.excused });
    let mut notes: Vec<String> = pair.not_comparable.iter().map(|why| format!("not comparable: {why}")).collect();
    if !pair.unknown.is_empty() {
        notes.push(format!("not known whether they are alike: {}", pair.unknown.join(", ")));
    }
    match &told {
        Some(told) => notes.extend(told.notes()),
        None => notes.extend(pair.stated.iter().map(stated)),
    }
    if let Some(shift) = pair.shift.filter(|shift| (shift.dx, shift.dy) != (0, 0)) {
        notes.push(format!("B lies {}, {} pixels off A", shift.dx, shift.dy));
    }
    let verdict = pair.verdict.as_ref();
    Pair {
        a: if pair.reference { None } else { numbers.get(&pair.a).copied() },
        b: numbers.get(&pair.b).copied(),
        a_label: pair.a.clone(),
        b_label: pair.b.clone(),
        verdict: verdict.map(|verdict| verdict.outcome.word()),
        proof: told.as_ref().map(Told::proof),
        channels: verdict.map(|verdict| verdict.channels.map(|channel| (channel.ratio, channel.error))),
        notes,
        refused: pair.refused.clone(),
        metrics: pair.metrics.iter().map(|measure| (measure.name.clone(), measure.value.overall)).collect(),
        blame: pair
            .blame
            .iter()
            .map(|blame| Blamed { words: blame.text(), group: group(blame.kind, &blame.name) })
            .collect(),
        tiles: verdict.map(super::measured::judged),
        worst: verdict.map(|verdict| Worst {
            grid: verdict.worst.grid,
            at: verdict.worst.at,
            words: told.as_ref().map_or_else(String::new, Told::blame),
        }),
    }
}
