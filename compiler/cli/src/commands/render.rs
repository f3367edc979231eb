//! `ltsc render`: a scene through a real renderer to an EXR that says how it came to be.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ltsc_core::capability::algorithm;
use ltsc_core::ir::Scene;
use ltsc_render::image::{Provenance, exr_bytes};
use ltsc_render::run::{Driver, Progress, Rendered, Usage};
use serde_json::json;

use crate::args::{Format, Render};
use crate::output::{Exit, Failure};
use crate::terminal::{self, Bar, Watcher};
use ltsc_evaluation::chunk::{self, Plan, Store, plan_of_one};
use ltsc_evaluation::disk::{Log, append, check_log, probe_file, unwritable, write_whole};

use super::shared::{One, one};
use ltsc_evaluation::job::{Job, Runner, Writing, driver_called, lacks, target_of};

pub fn run(command: &Render) -> Result<Exit, Failure> {
    let driver = driver_called(&command.renderer)?;
    check_output(command)?;
    let mut scene = match one(&command.scene, &command.findings, &command.settings)? {
        Ok(scene) => scene,
        Err(exit) => return Ok(exit),
    };
    let target = target_of(driver);
    check_algorithm(driver, &scene.scene)?;
    let exit = scene.report(target, &command.findings, command.findings.format == Format::Json)?;
    if exit != Exit::Done {
        return Ok(exit);
    }
    let (samples, seed) = (scene.scene.sampler.samples(), scene.scene.sampler.seed());
    let plan = plan_of_one(driver, u64::from(samples));
    let runner = runner(command, driver, plan, &scene)?;
    if plan.count > 1 {
        // What is written tells the chunks apart by nothing but what the driver sets.
        scene.scene.set_sampling(plan.samples, 0);
    }
    let ledger = scene.ledger(target);
    let choices = scene.project.choices.clone();
    let writing = Writing { camera: Some(scene.camera), choices, ledger: Some(&ledger), ..Writing::default() };
    let job = Job::written(&scene.scene, &runner, &writing)?;
    let log = log_of(command);
    let rendered = watch(&job, plan, seed, (&log, command.force))?;
    let provenance = provenance(command, driver, (&scene, seed), &rendered);
    let bytes = exr_bytes(&command.output, &rendered.image, &provenance)
        .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
    write_whole(&command.output, &mut |out| out.write_all(&bytes))
        .map_err(|error| unwritable(&command.output, &error))?;
    if command.findings.format == Format::Json {
        let facts: BTreeMap<&str, &str> =
            rendered.facts.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
        let document = json!({
            "image": command.output, "log": log, "renderer": driver.name, "renderer_version": rendered.renderer_version,
            "samples": rendered.samples_done, "facts": facts, "non_finite_pixels": rendered.image.non_finite(), "seconds": rendered.seconds, "scene_hash": scene.hash,
        });
        terminal::print(&format!("{document:#}\n"));
    } else {
        let bad = rendered.image.non_finite();
        if bad > 0 {
            terminal::say(&format!("warning: {bad} pixels are infinite or not a number"));
        }
        for (_, what) in rendered.facts.iter().filter(|(name, _)| name == "defects") {
            terminal::say(&format!("warning: {} is known to render this otherwise: {what}", driver.name));
        }
        terminal::say(&format!(
            "{} written: {} {}, {} samples, {:.1} s",
            command.output.display(),
            driver.name,
            rendered.renderer_version,
            rendered.samples_done,
            rendered.seconds
        ));
    }
    Ok(Exit::Done)
}

/// Refuses what would be found out only after the rendering.
fn check_output(command: &Render) -> Result<(), Failure> {
    let path = &command.output;
    let usage = |message: String| Failure::new(Exit::Usage, message);
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("exr")) {
        return Err(usage(format!("{} is no EXR file", path.display()))
            .help("images are written as linear 32-bit EXR: end the name in `.exr`"));
    }
    let log = log_of(command);
    let scene = |path: &Path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("lts"));
    if scene(&log) || log == *path {
        return Err(usage(format!("{} is no place for a log", log.display())).help("end its name in `.log`"));
    }
    // It may have taken hours, with more samples than now.
    match std::fs::symlink_metadata(path) {
        Ok(meta) if !meta.is_dir() && !command.force => {
            return Err(usage(format!("{} is there", path.display()))
                .help("choose another name, or add `--force` to write over it"));
        }
        _ => {}
    }
    probe_file(path)?;
    check_log(&log, command.force)?;
    Ok(())
}

/// Where the log goes.
fn log_of(command: &Render) -> PathBuf {
    let beside = || {
        let mut name = command.output.clone().into_os_string();
        name.push(".log");
        PathBuf::from(name)
    };
    command.log.clone().unwrap_or_else(beside)
}

/// Refuses an algorithm that the renderer lacks: an image of another one would be taken for what was asked.
fn check_algorithm(driver: &Driver, scene: &Scene) -> Result<(), Failure> {
    if !lacks(driver, scene) {
        return Ok(());
    }
    let (asked, _) = algorithm(&scene.integrator);
    let mut others = Vec::new();
    for other in ltsc_render::run::DRIVERS {
        if !lacks(other, scene) {
            others.push(format!("`{}`", other.name));
        }
    }
    let (word, name) = (scene.integrator.word(), driver.name);
    let path = format!("`integrator = path(max_depth: {})`", scene.integrator.max_depth());
    let failure =
        Failure::new(Exit::Usage, format!("{name} has no {}, which the scene asks for by `{word}`", asked.name()));
    Err(failure.help(if others.is_empty() {
        format!("no renderer that ltsc runs has it: write {path}, or emit the scene for a target that has it")
    } else {
        format!("write {path}, or render with {}", others.join(" or "))
    }))
}

/// The renderer, which answers and renders within the time that is given.
fn runner(command: &Render, driver: &'static Driver, plan: Plan, scene: &One) -> Result<Runner, Failure> {
    let given = command.executable.as_deref();
    let configured = if given.is_none() { scene.project.program(driver.name)? } else { None };
    let begun = Instant::now();
    let timeout = command.timeout.map(Duration::from_secs);
    let found = match given.or(configured).filter(|_| plan.count == 1 && !driver.asks_named) {
        Some(program) => Runner::unasked(driver, program, timeout),
        None => Runner::find(driver, given, configured, timeout)?,
    };
    let left = timeout.map(|timeout| timeout.saturating_sub(begun.elapsed()));
    Ok(Runner { threads: command.threads.map(|threads| threads as usize), timeout: left, ..found })
}

/// Renders under a progress bar.
fn watch(job: &Job<'_>, plan: Plan, seed: u32, (log, force): (&Path, bool)) -> Result<Rendered, Failure> {
    let what = format!("{} ({})", job.scene(), job.runner().driver.name);
    let samples = plan.samples;
    if let (2.., Some(cache)) = (plan.count, &job.runner().cache) {
        return chunked(&Store::of(cache), job, plan, seed, (log, force));
    }
    let _whole = Log::begin(log, force)?;
    let mut bar = Bar::new(u64::from(samples), &what);
    let rendered = job.render_logged(samples, seed, log, &mut |progress| match progress {
        Progress::Samples { done, total: _, seconds: _ } => bar.set(done),
        Progress::Started { version } => bar.say(&format!("{what} {version}")),
        Progress::Loaded { seconds: _ } => bar.say(&what),
    });
    bar.finish();
    rendered.map_err(|error| Failure::of_renderer(&error))
}

/// Renders a long image in chunks, which are kept, so that a run that is ended goes on where it was.
fn chunked(
    store: &Store,
    job: &Job<'_>,
    plan: Plan,
    seed: u32,
    (log, force): (&Path, bool),
) -> Result<Rendered, Failure> {
    let first = seed.checked_mul(plan.count).ok_or_else(|| {
        Failure::new(Exit::Usage, format!("the seed {seed} is too large for an image in {} chunks", plan.count))
            .help("count seeds from 0")
    })?;
    let chunks = chunk::render(store, job, plan, first, &mut Watcher::default())?;
    let (image, _) = chunks.combined()?;
    // Each chunk has a log of its own; a run that is killed before leaves none here.
    let _whole = Log::begin(log, force)?;
    append(log, &mut |out| chunks.write_logs(out)).map_err(|error| unwritable(log, &error))?;
    let cost = chunks.cost;
    Ok(Rendered {
        image,
        seconds: cost.seconds,
        wall_seconds: cost.seconds,
        renderer_version: cost.version,
        samples_done: cost.samples,
        executable: job.runner().found.path.clone(),
        log_path: log.to_path_buf(),
        usage: Usage { cpu_seconds: cost.cpu_seconds, peak_memory: cost.peak_memory },
        facts: vec![("chunks".to_owned(), format!("{} of {} samples", plan.count, plan.samples))],
    })
}

fn provenance(command: &Render, driver: &Driver, (scene, seed): (&One, u32), rendered: &Rendered) -> Provenance {
    let camera = command.settings.camera.iter().map(|name| ("camera".to_owned(), name.clone()));
    let parameters = &scene.scene.documentation.parameters;
    let values: Vec<String> = parameters.iter().map(|one| format!("{}={}", one.name, one.value)).collect();
    let values = (!values.is_empty()).then(|| ("parameters".to_owned(), values.join(", ")));
    Provenance {
        scene: scene.scene.name.clone(),
        scene_hash: scene.hash.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        renderer: driver.name.to_owned(),
        renderer_version: rendered.renderer_version.clone(),
        samples: rendered.samples_done,
        seed: u64::from(seed),
        seconds: rendered.seconds,
        extra: camera.chain(values).chain(rendered.facts.iter().cloned()).collect(),
    }
}
