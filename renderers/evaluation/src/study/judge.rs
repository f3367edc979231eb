//! Images put together, compared in pairs, and written with all that is known of them.

use std::collections::BTreeMap;
use std::path::Path;

use ltsc_core::files::Sink;
use ltsc_core::pipeline::camera;
use ltsc_core::survey::Seen;
use ltsc_render::image::{Image, Provenance, layered_bytes, read, reduce};

use crate::chunk::{Chunks, Machine, VARIANCE};
use crate::compare::blame::{Blame, Noisy, blame, groups};
use crate::compare::moments::Moments;
use crate::compare::verdict::{Kept, Outcome, Rendered, Stated, judge_in, judge_kept, judge_moments, judge_stated};
use crate::compare::{CompareOptions, compare, grey_png};
use crate::disk::{DiskSink, unwritable};
use crate::failure::{Exit, Failure};
use crate::file::model::{self, Run};
use crate::reference::{Found, of_file};
use crate::watch::Watch;

use super::folder::copy;
use super::names::{Names, Places};
use super::prepare::Prepared;
use super::results::{self, FORM, Results, Settings, Status};
use super::timing::{self, Timing};
use super::work::Fate;
use super::{Done, Folder, Study, tables};

/// The evaluation's file, in the results.
const FILE: &str = "evaluation.toml";

/// Bytes of moments that are kept between the comparisons of a condition; beyond, they are gathered again.
const MOST_MOMENTS: usize = 1 << 30;

/// One side of a comparison, as it is.
enum Side<'s> {
    /// What was rendered.
    Rendered(&'s Chunks),
    /// A reference; without a variance it is taken to be free of noise.
    Reference(&'s Reference),
}

/// A reference at the size of the images.
struct Reference {
    image: Image,
    /// What `ltsc reference` keeps beside it.
    kept: Option<Found>,
}

impl Reference {
    fn kept(&self) -> Kept<'_> {
        let exact = Kept { mean: &self.image, variance: None, images: 1, samples: 1.0, correlation: (1.0, 1.0) };
        self.kept.as_ref().map_or(exact, Found::side)
    }
}

/// What the work on one condition needs.
struct At<'a> {
    study: &'a Study<'a>,
    prepared: &'a Prepared<'a>,
    fates: &'a [Fate],
    sink: &'a mut DiskSink,
    folder: &'a Folder,
    /// Mean images with their variances, by run.
    means: BTreeMap<usize, (Image, Option<Image>)>,
    /// Moments, by run, as far as memory allows.
    moments: BTreeMap<usize, Moments>,
    /// How many of them are kept.
    kept: usize,
    /// What pixels see, of images of a size; made when it is asked for.
    seen: BTreeMap<Size, Option<Seen>>,
    /// Reference images by the file as it is written and the size of the images; the reason where one cannot be used.
    references: BTreeMap<(String, Size), Result<Reference, String>>,
}

/// Width and height.
type Size = (usize, usize);

/// What of an evaluation belongs to a condition.
#[derive(Clone, Default)]
struct Own<'e> {
    runs: Vec<usize>,
    pairs: Vec<&'e model::Pair>,
}

impl<'e> Own<'e> {
    /// In the order of the conditions.
    fn of(evaluation: &'e model::Evaluation) -> Vec<Self> {
        let mut all = vec![Self::default(); evaluation.conditions.len()];
        for (at, run) in evaluation.runs.iter().enumerate() {
            all[run.condition].runs.push(at);
        }
        for pair in &evaluation.pairs {
            all[evaluation.runs[pair.b].condition].pairs.push(pair);
        }
        all
    }
}

pub(super) fn judge(
    study: &Study<'_>,
    prepared: &Prepared<'_>,
    fates: &[Fate],
    folder: &Folder,
    watch: &mut (dyn Watch + Send),
) -> Result<Done, Failure> {
    let evaluation = study.evaluation;
    let mut sink = folder.begin(&evaluation.name)?;
    let failed = |error: std::io::Error| unwritable(&folder.path, &error);
    sink.file(FILE, &mut |out| out.write_all(study.text.as_bytes())).map_err(failed)?;
    watch.begin((evaluation.runs.len() + evaluation.pairs.len()) as u64, "comparing");
    let mut done = 0;
    let (mut conditions, mut runs) = (Vec::new(), Vec::new());
    let places = Places::of(evaluation);
    for (at, (condition, own)) in evaluation.conditions.iter().zip(Own::of(evaluation)).enumerate() {
        if own.runs.is_empty() {
            continue;
        }
        let name = &places.conditions[at];
        let mut here = At {
            study,
            prepared,
            fates,
            sink: &mut sink,
            folder,
            means: BTreeMap::new(),
            moments: BTreeMap::new(),
            kept: 0,
            seen: BTreeMap::new(),
            references: BTreeMap::new(),
        };
        let mut made = Vec::new();
        for run in &own.runs {
            watch.doing(&study.label(evaluation.runs[*run]));
            made.push(here.run(*run, name, &places.runs[*run])?);
            done += 1;
            watch.set(done);
        }
        let mut pairs = Vec::new();
        for pair in &own.pairs {
            pairs.push(here.pair(pair)?);
            done += 1;
            watch.set(done);
        }
        // That of the first comparison of each.
        let against: BTreeMap<usize, &model::Side> = own.pairs.iter().rev().map(|pair| (pair.b, &pair.a)).collect();
        for run in &own.runs {
            runs.extend(here.timing(*run, against.get(run).copied())?);
        }
        here.references(name).map_err(failed)?;
        let groups = here.groups(name, &pairs)?;
        conditions.push(results::Condition {
            name: condition.name.clone(),
            scene: evaluation.scenes[condition.scene].name.clone(),
            parameters: condition.set.iter().cloned().collect(),
            swept: condition.swept.iter().map(|(name, _)| name.clone()).collect(),
            groups,
            documentation: prepared.documentation.get(at).cloned().unwrap_or_default(),
            runs: made,
            pairs,
        });
    }
    watch.end();
    timing::relate(&mut runs);
    let results = Results {
        form: FORM,
        generator: concat!("ltsc ", env!("CARGO_PKG_VERSION")).to_owned(),
        name: evaluation.name.clone(),
        description: evaluation.description.clone(),
        file: FILE.to_owned(),
        conditions,
    };
    let timing = Timing { form: FORM, date: jiff::ZonedDateTime::now().to_string(), machine: Machine::here(), runs };
    let mut text =
        |name: &str, text: String| sink.file(name, &mut |out| out.write_all(text.as_bytes())).map_err(failed);
    text("results.json", json(&results)?)?;
    text("timing.json", json(&timing)?)?;
    text("summary.md", tables::markdown(&results, &timing))?;
    text("images.csv", tables::images(&results, &timing))?;
    text("comparisons.csv", tables::comparisons(&results))?;
    sink.finish().map_err(failed)?;
    Ok(Done { results, timing })
}

fn json<T: serde::Serialize>(value: &T) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::new(Exit::Fault, error.to_string()))?;
    Ok(text + "\n")
}

impl At<'_> {
    /// An image and its log, written; and what is known of it.
    fn run(&mut self, at: usize, condition: &str, name: &str) -> Result<results::Run, Failure> {
        let evaluation = self.study.evaluation;
        let run = evaluation.runs[at];
        let (ready, renderer) = (&self.prepared.runs[at], evaluation.renderer(run));
        let job = &self.prepared.jobs[ready.job];
        let failed = |error: std::io::Error| unwritable(&self.folder.path, &error);
        let mut made = results::Run {
            label: evaluation.label(run),
            case: evaluation.cases[run.case].name.value.clone(),
            renderer: renderer.name.clone(),
            driver: job.runner().driver.name.to_owned(),
            target: target_of_run(evaluation, run).to_owned(),
            version: job.runner().found.version.clone(),
            status: Status::Skipped,
            failure: None,
            image: None,
            files: None,
            expected: None,
            width: job.size().0,
            height: job.size().1,
            samples: ready.plan.total(),
            chunks: ready.plan.count,
            first_seed: ready.first_seed,
            identity: job.identity(),
            settings: job.effective().map(Settings::of),
            noise: None,
            non_finite: 0,
            stated: ready.stated.clone(),
            defects: job.defects().map(str::to_owned).collect(),
        };
        let fate = &self.fates[at];
        if let Some(manual) = &ready.manual {
            let shown = manual.image.strip_prefix(self.study.base).unwrap_or(&manual.image);
            made.expected = Some(shown.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/"));
        }
        if matches!(fate, Fate::Awaited) {
            made.status = Status::Awaited;
        }
        if let Fate::Failed(failure) = fate {
            made.status = Status::Failed;
            made.failure = Some(failure.message.clone());
        }
        if let Fate::Done(chunks) = fate {
            made.status = Status::Done;
            made.samples = chunks.cost.samples;
            made.chunks = u32::try_from(chunks.files.len()).unwrap_or(u32::MAX);
            if !chunks.cost.version.is_empty() {
                made.version.clone_from(&chunks.cost.version);
            }
            let moments = match chunks.images().moments() {
                Ok(moments) => moments,
                Err(error) => {
                    made.status = Status::Failed;
                    made.failure = Some(format!("{error}; remove that chunk: it is rendered again"));
                    return Ok(made);
                }
            };
            let mean = moments.mean_image();
            made.noise = timing::noise(&moments);
            made.non_finite = mean.non_finite();
            let variance = (chunks.files.len() > 1).then(|| moments.variance_image());
            let bytes = 64 * mean.pixels.len().max(1);
            if self.kept < MOST_MOMENTS / bytes {
                self.kept += 1;
                self.moments.insert(at, moments);
            }
            let path = format!("scenes/{condition}/{name}.exr");
            let bytes = image_bytes(&self.folder.path.join(&path), &mean, variance.as_ref(), &made, job.scene())?;
            self.sink.file(&path, &mut |out| out.write_all(&bytes)).map_err(failed)?;
            let log = format!("scenes/{condition}/{name}.log");
            self.sink.file(&log, &mut |out| chunks.write_logs(out)).map_err(failed)?;
            made.image = Some(path);
            self.means.insert(at, (mean, variance));
        }
        if !matches!(fate, Fate::Skipped | Fate::Awaited) && self.folder.keeps(matches!(fate, Fate::Failed(_))) {
            let below = format!("files/{condition}/{name}");
            copy(job, self.sink, &below).map_err(failed)?;
            made.files = Some(below);
        }
        Ok(made)
    }

    /// A comparison.
    fn pair(&mut self, pair: &model::Pair) -> Result<results::Pair, Failure> {
        let evaluation = self.study.evaluation;
        let b = &self.prepared.runs[pair.b];
        // What one renderer is off by, it is off by in both images.
        let driver = |run: usize| self.prepared.jobs[self.prepared.runs[run].job].runner().driver.name;
        let one = matches!(pair.a, model::Side::Run(a) if driver(a) == driver(pair.b));
        let mut stated: Vec<Stated> = if one { Vec::new() } else { b.stated.clone() };
        let (mut not_comparable, mut unknown) = (Vec::new(), Vec::new());
        let (a, reference) = match &pair.a {
            model::Side::Run(at) => {
                let of = |run: usize| self.prepared.jobs[self.prepared.runs[run].job].effective();
                if let (Some(one), Some(other)) = (of(*at), of(pair.b)) {
                    let apart = one.apart(other);
                    not_comparable = apart.differs;
                    unknown = apart.unknown.iter().map(|what| (*what).to_owned()).collect();
                }
                stated.extend(self.prepared.runs[*at].stated.iter().filter(|_| !one).cloned());
                (evaluation.label(evaluation.runs[*at]), false)
            }
            model::Side::File(file) => (file.clone(), true),
        };
        stated.sort_by(|one, other| other.share.total_cmp(&one.share));
        stated.dedup();
        let mut made = results::Pair {
            a,
            reference,
            b: evaluation.label(evaluation.runs[pair.b]),
            samples: (None, b.plan.total()),
            not_comparable,
            unknown,
            stated,
            excused: false,
            verdict: None,
            refused: None,
            blame: Vec::new(),
            metrics: Vec::new(),
            shift: None,
        };
        if let Err(why) = self.compare(pair, &mut made)? {
            made.refused = Some(why);
        }
        Ok(made)
    }

    /// Compares the two; the reason where that is impossible.
    fn compare(&mut self, pair: &model::Pair, made: &mut results::Pair) -> Result<Result<(), String>, Failure> {
        if let model::Side::File(file) = &pair.a {
            self.load(file, pair.b);
        }
        let evaluation = self.study.evaluation;
        let Fate::Done(b) = &self.fates[pair.b] else { return Ok(Err(format!("`{}` was not rendered", made.b))) };
        made.samples.1 = b.cost.samples;
        let Some((of_b, _)) = self.means.get(&pair.b) else { return Ok(Err(format!("`{}` has no image", made.b))) };
        let (of_a, side_a) = match &pair.a {
            model::Side::File(file) => match self.reference(file, pair.b) {
                Some(Ok(reference)) => (&reference.image, Side::Reference(reference)),
                Some(Err(why)) => return Ok(Err(why.clone())),
                None => return Ok(Err("the reference was not read".to_owned())),
            },
            model::Side::Run(at) => match (&self.fates[*at], self.means.get(at)) {
                (Fate::Done(chunks), Some((image, _))) => {
                    made.samples.0 = Some(chunks.cost.samples);
                    (image, Side::Rendered(chunks))
                }
                _ => return Ok(Err(format!("`{}` was not rendered", made.a))),
            },
        };
        let options =
            CompareOptions { tiles: evaluation.tiles as usize, mask_non_finite: true, ..CompareOptions::default() };
        let compared = match compare(of_a, of_b, &options) {
            Ok(compared) => compared,
            Err(error) => return Ok(Err(error.to_string())),
        };
        made.metrics = compared.metrics;
        made.shift = compared.shift;
        if b.files.len() < 2 {
            return Ok(Err(format!("`{}` is one image, whose noise is not known", made.b)));
        }
        let more: f64 = made.stated.iter().map(|one| one.share).sum();
        let b = Rendered { images: b.images(), samples: f64::from(b.samples) };
        let fine = evaluation.tiles as usize;
        let judged = match side_a {
            Side::Rendered(a) if a.files.len() < 2 => {
                return Ok(Err(format!("`{}` is one image, whose noise is not known", made.a)));
            }
            Side::Rendered(a) => {
                let a = Rendered { images: a.images(), samples: f64::from(a.samples) };
                let kept = match &pair.a {
                    model::Side::Run(at) => self.moments.get(at).zip(self.moments.get(&pair.b)),
                    model::Side::File(_) => None,
                };
                let judge = |within| match kept {
                    Some((of_a, of_b)) => judge_moments((a, of_a), (b, of_b), within, fine),
                    None => judge_in(a, b, within, fine),
                };
                judge_stated(judge, evaluation.tolerance, more)
            }
            Side::Reference(a) => {
                judge_stated(|within| judge_kept(a.kept(), b, within, fine), evaluation.tolerance, more)
            }
        };
        match judged {
            Ok((verdict, excused)) => {
                let agrees = verdict.outcome == Outcome::Agree;
                made.excused = excused;
                made.verdict = Some(verdict);
                if !agrees {
                    made.blame = self.blame(pair);
                }
                Ok(Ok(()))
            }
            Err(error) => Ok(Err(error.to_string())),
        }
    }

    /// On what the difference of two images lies.
    fn blame(&mut self, pair: &model::Pair) -> Vec<Blame> {
        let run = self.study.evaluation.runs[pair.b];
        let size = self.size(pair.b);
        let scene = &self.study.conditions[run.condition].scene;
        let asked = &self.study.evaluation.scenes[self.study.evaluation.conditions[run.condition].scene];
        let make = || Seen::of(scene, &scene.cameras[camera(scene, asked.camera.as_deref())?], size);
        self.seen.entry(size).or_insert_with(make);
        let Some(Some(seen)) = self.seen.get(&size) else { return Vec::new() };
        let Some((b, vb)) = self.means.get(&pair.b) else { return Vec::new() };
        let b = Noisy { mean: b, variance: vb.as_ref() };
        let a = match &pair.a {
            model::Side::Run(at) => {
                self.means.get(at).map(|(mean, variance)| Noisy { mean, variance: variance.as_ref() })
            }
            model::Side::File(file) => {
                self.reference(file, pair.b).and_then(|found| found.as_ref().ok()).map(|found| Noisy {
                    mean: &found.image,
                    variance: found.kept.as_ref().and_then(|kept| kept.variance.as_ref()),
                })
            }
        };
        a.map_or(Vec::new(), |a| blame(a, b, seen))
    }

    /// Which pixels are in the groups on which differences lie, beside the images.
    fn groups(&mut self, condition: &str, pairs: &[results::Pair]) -> Result<Vec<results::Groups>, Failure> {
        if pairs.iter().all(|pair| pair.blame.is_empty()) {
            return Ok(Vec::new());
        }
        let mut all = Vec::new();
        for ((width, height), seen) in &self.seen {
            let Some(seen) = seen else { continue };
            let (names, pixels) = groups(seen);
            let file = format!("scenes/{condition}/seen {width} x {height}.png");
            let bytes = grey_png(&self.folder.path.join(&file), *width, *height, &pixels)
                .map_err(|error| Failure::new(Exit::Environment, error.to_string()))?;
            self.sink
                .file(&file, &mut |out| out.write_all(&bytes))
                .map_err(|error| unwritable(&self.folder.path, &error))?;
            all.push(results::Groups { file, width: *width, height: *height, names });
        }
        Ok(all)
    }

    /// The size of a run's image.
    fn size(&self, run: usize) -> Size {
        self.prepared.jobs[self.prepared.runs[run].job].size()
    }

    /// A reference that was read for the run that is held against it.
    fn reference(&self, file: &str, b: usize) -> Option<&Result<Reference, String>> {
        self.references.get(&(file.to_owned(), self.size(b)))
    }

    /// Reads a reference, at the size of the run that is held against it.
    fn load(&mut self, file: &str, b: usize) {
        let size = self.size(b);
        let key = (file.to_owned(), size);
        if self.references.contains_key(&key) {
            return;
        }
        let path = self.study.base.join(file);
        let loaded =
            match of_file(&path) {
                Err(failure) => Err(failure.message),
                Ok(Some(found)) => found
                    .reduced(size.0, size.1)
                    .map(|found| Reference { image: found.image.clone(), kept: Some(found) })
                    .map_err(|error| error.to_string()),
                Ok(None) => read(&path)
                    .and_then(|(image, _)| {
                        if (image.width, image.height) == size { Ok(image) } else { reduce(&image, size.0, size.1) }
                    })
                    .map(|image| Reference { image, kept: None })
                    .map_err(|error| error.to_string()),
            };
        self.references.insert(key, loaded);
    }

    /// References beside the images.
    fn references(&mut self, condition: &str) -> std::io::Result<()> {
        let mut names = Names::default();
        for ((file, _), reference) in &self.references {
            let Ok(Reference { image, kept }) = reference else { continue };
            let stem = Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            let path = format!("references/{condition}/{}.exr", names.of(&stem));
            let variance = kept.as_ref().and_then(|kept| kept.variance.as_ref());
            let layers: Vec<(&str, &Image)> =
                std::iter::once(("", image)).chain(variance.map(|variance| (VARIANCE, variance))).collect();
            let provenance = Provenance { extra: vec![("from".to_owned(), file.clone())], ..Provenance::default() };
            let bytes = layered_bytes(&self.folder.path.join(&path), &layers, &provenance)
                .map_err(|error| std::io::Error::other(error.to_string()))?;
            self.sink.file(&path, &mut |out| out.write_all(&bytes))?;
        }
        Ok(())
    }

    /// Times of a run that is done, and how its error fell against an image.
    fn timing(&self, at: usize, against: Option<&model::Side>) -> Result<Option<timing::Run>, Failure> {
        let evaluation = self.study.evaluation;
        let (Fate::Done(chunks), true) = (&self.fates[at], self.means.contains_key(&at)) else { return Ok(None) };
        let run = evaluation.runs[at];
        let reference = against.and_then(|side| match side {
            model::Side::Run(other) => self.means.get(other).map(|(mean, _)| mean),
            model::Side::File(file) => self.reference(file, at)?.as_ref().ok().map(|reference| &reference.image),
        });
        let job = &self.prepared.jobs[self.prepared.runs[at].job];
        Ok(Some(timing::Run {
            condition: evaluation.conditions[run.condition].name.clone(),
            label: evaluation.label(run),
            cost: chunks.cost.clone(),
            steps: timing::steps(chunks, reference)?,
            efficiency: None,
            group: timing::group(job.runner().driver.name, &evaluation.renderer(run).name, &chunks.cost),
            equal_error_seconds: None,
        }))
    }
}

fn target_of_run(evaluation: &model::Evaluation, run: Run) -> &'static str {
    evaluation.renderer(run).target.name
}

/// The image with its variance. Its header tells nothing that another run would not: no times, no machine.
fn image_bytes(
    path: &Path,
    mean: &Image,
    variance: Option<&Image>,
    run: &results::Run,
    scene: &str,
) -> Result<Vec<u8>, Failure> {
    let layers: Vec<(&str, &Image)> =
        std::iter::once(("", mean)).chain(variance.map(|variance| (VARIANCE, variance))).collect();
    let extra = [("case", run.label.clone()), ("chunks", run.chunks.to_string())];
    let provenance = Provenance {
        scene: scene.to_owned(),
        scene_hash: run.identity.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        renderer: run.driver.clone(),
        renderer_version: run.version.clone(),
        samples: run.samples,
        seed: u64::from(run.first_seed),
        seconds: 0.0,
        extra: extra.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
    };
    layered_bytes(path, &layers, &provenance)
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))
}
