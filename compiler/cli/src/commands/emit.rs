//! `ltsc emit`: one scene for one target, as a self-contained folder.

use std::path::PathBuf;

use ltsc_core::pipeline;

use crate::args::{Build, Emit, Format};
use crate::output::{Exit, Failure};
use crate::project;
use crate::terminal;
use ltsc_evaluation::disk::{DiskSink, unwritable};

use super::shared::one;

pub fn run(command: &Emit) -> Result<Exit, Failure> {
    if command.target.is_empty() {
        let names: Vec<&str> = ltsc_core::formats::TARGETS.iter().map(|target| target.name).collect();
        return Err(Failure::new(Exit::Usage, "`emit` writes for one target")
            .help(format!("name it by `--target`: {}", names.join(", "))));
    }
    let target = project::target(&command.target)?;
    let Some(file) = &command.scene else { return all(command) };
    let scene = match one(file, &command.findings, &command.settings)? {
        Ok(scene) => scene,
        Err(exit) => return Ok(exit),
    };
    let exit = scene.report(target, &command.findings, false)?;
    if exit != Exit::Done {
        return Ok(exit);
    }
    let choices = scene.project.choices_with(&command.option, &[target])?;
    let name = format!("{}-{}", scene.scene.name, target.name);
    let folder = command.output.clone().unwrap_or_else(|| PathBuf::from(name));
    let failed = |error: std::io::Error| unwritable(&folder, &error);
    let mut sink = DiskSink::new(&folder, &scene.scene.name, false, command.force).map_err(failed)?;
    pipeline::emit_alone(&scene.scene, scene.camera, target, &scene.ledger(target), &choices, &mut sink)
        .map_err(failed)?;
    if let Some(exit) = scene.audited(target, &sink, command.findings.format) {
        return Ok(exit);
    }
    let changes = sink.finish().map_err(failed)?;
    if command.findings.format == Format::Human {
        let main = folder.join(target.main_file_of(&scene.scene.name));
        let what = if changes.is_empty() { "is up to date" } else { "written" };
        terminal::say(&format!("{} {what}", main.display()));
    }
    Ok(Exit::Done)
}

/// Without a scene: what `build` does for all targets, for one.
fn all(command: &Emit) -> Result<Exit, Failure> {
    let crate::args::Settings { width, height, samples, max_depth, seed, set, camera } = &command.settings;
    if [width, height, samples, max_depth, seed].into_iter().any(Option::is_some) || camera.is_some() || !set.is_empty()
    {
        return Err(Failure::new(Exit::Usage, "settings go with one scene").help("name the scene"));
    }
    super::build::run(&Build {
        paths: Vec::new(),
        check: false,
        target: vec![command.target.clone()],
        option: command.option.clone(),
        output: command.output.clone(),
        force: command.force,
        set: Vec::new(),
        stats: false,
        verbose: false,
        findings: command.findings.clone(),
    })
}
