//! `ltsc render`: a scene through a real renderer to an EXR that says how it came to be.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::capability::algorithm;
use ltsc_core::ir::Scene;
use ltsc_core::pipeline;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::guard::Folder;
use ltsc_render::image::{Provenance, exr_bytes};
use ltsc_render::run::{Driver, Progress, RenderError, RenderRequest, Rendered, driver, render};
use serde_json::json;

use crate::args::{Format, Render};
use crate::disk::{DiskSink, Log, check_log, no_temporary, probe_file, unwritable, write_whole};
use crate::output::{Exit, Failure};
use crate::project;
use crate::terminal::{self, Bar};

use super::job::lacks;
use super::shared::{One, one};

pub fn run(command: &Render) -> Result<Exit, Failure> {
    let driver = find_driver(&command.renderer)?;
    check_output(command)?;
    let scene = match one(&command.scene, &command.findings, &command.settings)? {
        Ok(scene) => scene,
        Err(exit) => return Ok(exit),
    };
    let target = project::target(driver.target)?;
    check_algorithm(driver, &scene.scene)?;
    let exit = scene.report(target, &command.findings, command.findings.format == Format::Json)?;
    if exit != Exit::Done {
        return Ok(exit);
    }
    let work = Folder::new().map_err(|error| no_temporary(&error))?;
    let failed = |error: std::io::Error| unwritable(work.path(), &error);
    let mut sink = DiskSink::own(work.path(), &scene.scene.name);
    pipeline::emit_alone(&scene.scene, scene.camera, target, &scene.ledger(target), &scene.project.choices, &mut sink)
        .map_err(failed)?;
    if let Some(exit) = scene.audited(target, &sink, command.findings.format) {
        return Ok(exit);
    }
    sink.finish().map_err(failed)?;
    let executable = match &command.executable {
        Some(given) => Some(given.clone()),
        None => scene.project.program(driver.name)?.map(Path::to_path_buf),
    };
    let log = log_of(command);
    let request = request(command, driver, &scene, (executable, work.path(), &log));
    let whole = Log::begin(&log, command.force)?;
    let rendered = watch(&request, &scene)?;
    drop(whole);
    let provenance = provenance(command, driver, &scene, &rendered);
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

/// The driver called `name`.
pub fn find_driver(name: &str) -> Result<&'static Driver, Failure> {
    if name.contains(',') {
        return Err(Failure::new(
            Exit::Usage,
            format!("`--renderer {name}` names several renderers, and one image comes from one"),
        )
        .help("render once for each, or compare them by `ltsc agree`"));
    }
    driver(name).ok_or_else(|| {
        let known: Vec<&str> = ltsc_render::run::DRIVERS.iter().map(|driver| driver.name).collect();
        let failure = Failure::new(Exit::Usage, format!("there is no renderer `{name}`"));
        match ltsc_core::diag::nearest(name, known.iter().copied()) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help(format!("known: {}", known.join(", "))),
        }
    })
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
    if !lacks(driver, scene)? {
        return Ok(());
    }
    let (asked, _) = algorithm(&scene.integrator);
    let mut others = Vec::new();
    for other in ltsc_render::run::DRIVERS {
        if !lacks(other, scene)? {
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

fn request(
    command: &Render,
    driver: &'static Driver,
    scene: &One,
    (executable, folder, log): (Option<PathBuf>, &Path, &Path),
) -> RenderRequest {
    let film = &scene.scene.film;
    let (samples, seed) = (scene.scene.sampler.samples(), scene.scene.sampler.seed());
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let size = (film.width as usize, film.height as usize);
    RenderRequest {
        executable,
        env,
        cache,
        main_file: driver.main_file.replace("SCENE", &scene.scene.name),
        samples,
        seed,
        threads: command.threads.map(|threads| threads as usize),
        timeout: command.timeout.map(Duration::from_secs),
        ..RenderRequest::new(driver, folder.to_path_buf(), size, log.to_path_buf())
    }
}

/// Renders under a progress bar.
fn watch(request: &RenderRequest, scene: &One) -> Result<Rendered, Failure> {
    let what = format!("{} ({})", scene.scene.name, request.driver.name);
    let mut bar = Bar::new(u64::from(request.samples), &what);
    let rendered = render(request, &mut |progress| match progress {
        Progress::Samples { done, total: _, seconds: _ } => bar.set(done),
        Progress::Started { version } => bar.say(&format!("{what} {version}")),
        Progress::Loaded { seconds: _ } => bar.say(&what),
    });
    bar.finish();
    rendered.map_err(|error| failure(&error))
}

/// What becomes of a renderer that is missing or fails, with the places looked at or the end of its log.
pub fn failure(error: &RenderError) -> Failure {
    let mut message = error.to_string();
    if !error.tail().is_empty() {
        let head = if matches!(error, RenderError::NotFound { .. }) { "looked at:" } else { "the end of its log:" };
        message.push('\n');
        message.push_str(head);
        for line in error.tail() {
            message.push_str("\n    ");
            message.push_str(line);
        }
    }
    Failure {
        help: Some(error.hint().to_owned()).filter(|hint| !hint.is_empty()),
        ..Failure::new(Exit::Environment, message)
    }
}

fn provenance(command: &Render, driver: &Driver, scene: &One, rendered: &Rendered) -> Provenance {
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
        seed: u64::from(scene.scene.sampler.seed()),
        seconds: rendered.seconds,
        extra: camera.chain(values).chain(rendered.facts.iter().cloned()).collect(),
    }
}
