//! Pools: many small images of one scene by one renderer, which pairs are drawn from.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::Overrides;
use ltsc_core::files::{Files, VPath};
use ltsc_core::formats::statements::{Parameter, Statement, Statements, Value};
use ltsc_core::ir::Integrator;
use ltsc_core::lint::{Level, Levels};
use ltsc_core::pipeline::{self, Options};
use ltsc_core::valid::Valid;
use ltsc_render::image::{Image, read};
use ltsc_render::regular;
use rayon::prelude::*;

use super::suite::{Change, SAMPLES, SIZE, Scene};
use crate::chunk::Store;
use crate::disk::{Changed, DiskFiles};
use crate::executor::{Executor, Local, News, Order, Outcome, Resources, Task};
use crate::failure::{Exit, Failure, why};
use crate::job::{Job, Runner, Writing, target_of};
use crate::watch::Watch;

/// The chunks of a pool, by their seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seeds {
    /// The first one.
    pub first: u32,
    /// How many are asked for.
    pub count: u32,
}

impl Seeds {
    fn all(self) -> impl Iterator<Item = u32> {
        (0..self.count).map(move |at| self.first + at)
    }
}

/// Where scenes are read: the root of a project, and the folder of its scenes.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// The root.
    pub root: &'a Path,
    /// The folder of the scenes.
    pub scenes: &'a Path,
}

impl Place<'_> {
    /// The text of a scene, changed, with its path below the root.
    fn text(&self, disk: &DiskFiles, scene: &Scene, change: Option<Change>) -> Result<(VPath, String), Failure> {
        let file = self.scenes.join(format!("{}.lts", scene.name));
        let missing = |message: String| {
            Failure::new(Exit::Input, message)
                .help("calibration needs ltsc's own scenes: run it in a checkout of ltsc, as its documentation says")
        };
        let path =
            disk.path_of(&file).ok_or_else(|| missing(format!("{} does not lie in the project", file.display())))?;
        let text = regular::read_text(&file, regular::TEXT)
            .map_err(|error| missing(format!("{}: {}", file.display(), why(&error))))?;
        let text = match change {
            None | Some(Change::Roulette(_)) => text,
            Some(Change::Text(from, to)) => match text.matches(from).count() {
                1 => text.replacen(from, to, 1),
                found => {
                    let message = format!("{}: `{from}` stands there {found} times, not once", file.display());
                    return Err(missing(message));
                }
            },
            Some(Change::DarkLights(count)) => text + &dark_lights(count),
        };
        Ok((path, text))
    }

    /// The scene, or one of its variants, as it is rendered.
    fn valid(&self, scene: &Scene, change: Option<Change>) -> Result<Valid, Failure> {
        let bad =
            |error: &std::io::Error| Failure::new(Exit::Input, format!("{}: {}", self.root.display(), why(error)));
        let disk = DiskFiles::new(self.root).map_err(|error| bad(&error))?;
        let (path, text) = self.text(&disk, scene, change)?;
        let texts = BTreeMap::from([(path.clone(), text)]);
        prepared(&Changed { disk: &disk, texts: &texts }, &path, scene)
    }

    /// The pool of a scene, or of one of its variants, written for a renderer.
    ///
    /// # Errors
    /// Where the scene is missing, or is not what the variant changes.
    pub fn job<'r>(&self, runner: &'r Runner, scene: &Scene, change: Option<Change>) -> Result<Job<'r>, Failure> {
        let mut valid = self.valid(scene, change)?;
        let given = statements(&valid, change)?;
        let target = target_of(runner.driver);
        valid = pipeline::take_statements(valid, target, &given).map_err(|found| refused(scene, &found))?.0;
        valid.set_sampling(SAMPLES, 0);
        Job::written(&valid, runner, &Writing { statements: &given, ..Writing::default() })
    }
}

fn refused(scene: &Scene, found: &[ltsc_core::diag::Finding]) -> Failure {
    let worst = found.iter().find(|finding| finding.severity >= Severity::Deny).or(found.first());
    let why = worst.map_or("it is not valid", |finding| finding.message.as_str());
    Failure::new(Exit::Input, format!("{}: {why}", scene.name))
        .help("calibration needs ltsc's own scenes as they are: run it in a checkout of ltsc")
}

/// The scene in a text, at the size of all images. Lint is not asked: variants are made to be wrong.
fn prepared(files: &dyn Files, path: &VPath, scene: &Scene) -> Result<Valid, Failure> {
    let mut levels = Levels::default();
    levels.set("all", Level::Allow).map_err(|error| Failure::new(Exit::Fault, error.message))?;
    let set = scene.set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    let overrides = Overrides { width: Some(SIZE), height: Some(SIZE), set, ..Overrides::default() };
    let checked =
        pipeline::check(files, &mut Sources::default(), path, &Options { overrides, levels, ..Options::default() });
    let made = checked.scene.filter(|_| checked.findings.iter().all(|finding| finding.severity != Severity::Error));
    let valid = made.ok_or(checked.findings).and_then(pipeline::prepare);
    Ok(valid.map_err(|found| refused(scene, &found))?.0)
}

/// Lights far above everything that shine upwards: a millionth of the light of the dimmest scene, and nothing of it is seen.
fn dark_lights(count: u32) -> String {
    let light = |at: u32| {
        let z = 5000 + at;
        format!("emitter dark_{at} = rectangle(x: -1..1, y: -1..1, z: {z}, normal: Z) with radiance(0.000001)\n")
    };
    std::iter::once("\n".to_owned()).chain((0..count).map(light)).collect()
}

fn statements(scene: &Valid, change: Option<Change>) -> Result<Statements, Failure> {
    let mut given = Statements::default();
    let Some(Change::Roulette(from)) = change else { return Ok(given) };
    let Integrator::Path { max_depth } = &scene.integrator else {
        return Err(Failure::new(Exit::Input, format!("{} is not rendered by path tracing", scene.name))
            .help("calibration needs ltsc's own scenes as they are"));
    };
    let integer = |name: &str, value: i64| Parameter::new(name, Value::Integer(value));
    let own = Parameter::new("type", Value::String("path".to_owned()));
    let depth = integer("max_depth", i64::from(*max_depth));
    given.give(Statement::new("integrator", vec![own, depth, integer("rr_depth", from)]));
    Ok(given)
}

/// Renders the chunks of pools that are not there, several at once.
///
/// # Errors
/// The first thing that a renderer or the disk says.
pub fn render(
    jobs: &[Job<'_>],
    seeds: &[Seeds],
    store: &Store,
    at_once: usize,
    watch: &mut (dyn Watch + Send),
) -> Result<(), Failure> {
    let mut tasks = Vec::new();
    for ((at, job), seeds) in jobs.iter().enumerate().zip(seeds) {
        let identity = job.identity();
        let open = seeds.all().filter(|seed| !store.has(&identity, SAMPLES, *seed));
        tasks.extend(open.map(|seed| Task { job: at, samples: SAMPLES, seed }));
    }
    if tasks.is_empty() {
        return Ok(());
    }
    watch.begin(tasks.len() as u64, "chunks");
    let shown = Mutex::new((watch, 0_u64));
    let news = |news: News<'_>| {
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        match news {
            News::Begun(at) => shown.0.doing(jobs[tasks[at].job].scene()),
            News::Ended(..) => {
                shown.1 += 1;
                let done = shown.1;
                shown.0.set(done);
            }
            News::Note(text) => shown.0.note(&text),
        }
    };
    let memory = crate::chunk::Machine::here().memory;
    let local = Local::new(Resources { jobs: at_once, memory, shared: None, options: Vec::new() });
    let order = Order { jobs, tasks: &tasks, store, keep_going: false };
    let outcomes = local.run(&order, &news);
    let (watch, _) = shown.into_inner().unwrap_or_else(PoisonError::into_inner);
    watch.end();
    for outcome in outcomes? {
        if let Outcome::Failed(failure) = outcome {
            return Err(failure);
        }
    }
    Ok(())
}

/// The chunks of a pool that are there, in the order of their seeds.
///
/// # Errors
/// If one cannot be read.
pub fn load(job: &Job<'_>, seeds: Seeds, store: &Store) -> Result<Vec<Image>, Failure> {
    let identity = job.identity();
    let there: Vec<u32> = seeds.all().filter(|seed| store.has(&identity, SAMPLES, *seed)).collect();
    let one = |seed: &u32| {
        let path = store.path(&identity, SAMPLES, *seed);
        let damaged =
            |message: String| Failure::new(Exit::Environment, message).help("remove that file: it is rendered again");
        let (image, _) = read(&path).map_err(|error| damaged(error.to_string()))?;
        if (image.width, image.height) == job.size() {
            return Ok(image);
        }
        Err(damaged(format!("{} is {} x {} pixels", path.display(), image.width, image.height)))
    };
    there.par_iter().map(one).collect()
}
