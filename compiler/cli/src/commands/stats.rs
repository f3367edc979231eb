//! `ltsc build --stats`: what the build of each scene takes and makes, as a table in Markdown.

use std::io::{self, Write};
use std::time::Instant;

use ltsc_core::catalogue;
use ltsc_core::eval::Overrides;
use ltsc_core::files::Sink;
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ir::Scene;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;

use crate::args::Build;
use crate::output::{Exit, Failure};
use crate::terminal;

use super::shared::{all_files_of, check, report};

/// How often a build is timed at most; the shortest counts.
const TIMES: usize = 5;

/// Seconds after which no further one begins.
const ENOUGH: f64 = 0.5;

/// Counts bytes and keeps none.
#[derive(Default)]
struct Counter(u64);

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for Counter {
    fn file(&mut self, _: &str, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        write(self)
    }
}

/// Prints a row for each scene: time from the text to the last byte of all targets, disk left out, and sizes.
pub fn run(command: &Build, only: &[&'static Target]) -> Result<Exit, Failure> {
    let mut rows: Vec<String> = Vec::new();
    let mut columns: Vec<&'static Target> = Vec::new();
    for (project, files) in all_files_of(&command.paths, &command.findings)? {
        let targets: &[&'static Target] = if only.is_empty() { &project.targets } else { only };
        if columns.is_empty() {
            columns = targets.to_vec();
        }
        for file in &files {
            let mut best: Option<(f64, String)> = None;
            let begun = Instant::now();
            for round in 0..TIMES {
                if round > 0 && begun.elapsed().as_secs_f64() > ENOUGH {
                    break;
                }
                let start = Instant::now();
                let checked =
                    check(&project, std::slice::from_ref(file), &command.findings, Overrides::default(), &[])?;
                let Some(scene) = checked.first().and_then(|file| file.checked.scene.clone()) else {
                    let (exit, _) = report(&checked, Vec::new(), command.findings.format, false, true);
                    if exit != Exit::Done {
                        return Ok(exit);
                    }
                    break;
                };
                let counts = counts(&scene);
                let (bytes, name) = emitted(scene, &columns, &project.choices)?;
                let seconds = start.elapsed().as_secs_f64();
                if best.as_ref().is_none_or(|(least, _)| seconds < *least) {
                    let bytes: Vec<String> = bytes.into_iter().map(grouped).collect();
                    let row =
                        format!("| `{name}` | {} ms | {counts} | {} |\n", milliseconds(seconds), bytes.join(" | "));
                    best = Some((seconds, row));
                }
            }
            rows.extend(best.map(|(_, row)| row));
        }
    }
    let names: Vec<String> = columns.iter().map(|target| format!("`{}`", target.name)).collect();
    terminal::print(&format!(
        "| scene | time | triangles | instances | bytes: meshes, images | {} |\n|---|---|---|---|---|{}\n{}",
        names.join(" | "),
        "---|".repeat(names.len()),
        rows.concat()
    ));
    Ok(Exit::Done)
}

fn counts(scene: &Scene) -> String {
    let triangles: usize = scene.meshes.values().map(|mesh| mesh.triangles.len()).sum();
    format!("{} | {}", grouped(triangles as u64), grouped(catalogue::instances(scene)))
}

/// The bytes of the shared meshes and images, and of each target's own files but the ledger, and the scene's name.
fn emitted(scene: Scene, targets: &[&'static Target], choices: &Choices) -> Result<(Vec<u64>, String), Failure> {
    let name = scene.name.clone();
    let fault = |what: &str| Failure::new(Exit::Fault, format!("the scene `{name}` {what}"));
    let (scene, _) = pipeline::prepare(scene).map_err(|_| fault("is not valid: `ltsc build` says why"))?;
    let camera = pipeline::camera(&scene, None).ok_or_else(|| fault("lost its camera"))?;
    let mut meshes = Counter::default();
    formats::write_meshes(&scene, "meshes/", &mut meshes).map_err(|error| fault(&error.to_string()))?;
    formats::write_textures(&scene, targets, "textures/", &mut meshes).map_err(|error| fault(&error.to_string()))?;
    let mut bytes = vec![meshes.0];
    for target in targets {
        let mut own = Counter::default();
        let ledger = Ledger::of(&scene, target, &[]);
        pipeline::emit_shared(&scene, camera, target, &ledger, choices, &mut own)
            .map_err(|error| fault(&error.to_string()))?;
        bytes.push(own.0 - ledger.json().len() as u64);
    }
    Ok((bytes, name))
}

/// Two significant digits.
fn milliseconds(seconds: f64) -> String {
    let value = seconds * 1e3;
    if value < 10.0 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// A whole number with blanks between groups of three digits.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}
