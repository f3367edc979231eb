//! A folder to attach to a report: the scene for both renderers, images, the verdict, versions, and what was done.

use std::fmt::Write as _;
use std::path::Path;

use ltsc_core::files::Sink;
use ltsc_render::image::{Provenance, layered_bytes};

use super::{Reduced, Shown};
use crate::chunk::VARIANCE;
use crate::compare::verdict::Told;
use crate::compare::{difference_png, exposure};
use crate::disk::{DiskSink, Manifest, unwritable};
use crate::failure::{Exit, Failure};

/// The folder as it is begun.
fn begin(scene: &str, folder: &Path, force: bool) -> Result<DiskSink, Failure> {
    DiskSink::new(folder, &format!("reduced {scene}"), false, force).map_err(|error| unwritable(folder, &error))
}

/// Refuses a folder that cannot be written or holds what ltsc did not write, before anything is rendered for it.
///
/// # Errors
/// Why.
pub fn check(scene: &str, folder: &Path, force: bool) -> Result<(), Failure> {
    begin(scene, folder, force).map(drop)
}

/// Writes it.
///
/// # Errors
/// If it cannot be written.
pub fn write(reduced: &Reduced<'_>, folder: &Path, force: bool) -> Result<(), Failure> {
    let failed = |error: std::io::Error| unwritable(folder, &error);
    let fault = |message: String| Failure::new(Exit::Environment, message);
    let shown = &reduced.shown;
    let names = names(shown);
    let mut sink = begin(&shown.scene.name, folder, force)?;
    let mut means = Vec::new();
    for ((job, chunks), name) in shown.jobs.iter().zip(&shown.chunks).zip(&names) {
        if let Some(manifest) = Manifest::read(job.folder()) {
            for path in manifest.files.keys() {
                let from = job.folder().join(path);
                let copy = &mut |out: &mut dyn std::io::Write| {
                    let (mut file, _) = ltsc_render::regular::open(&from)?;
                    std::io::copy(&mut file, out).map(|_| ())
                };
                sink.file(&format!("{name}/{path}"), copy).map_err(failed)?;
            }
        }
        let (mean, variance) = chunks.combined()?;
        let mut layers = vec![("", &mean)];
        layers.extend(variance.iter().map(|variance| (VARIANCE, variance)));
        let provenance = Provenance {
            scene: shown.scene.name.clone(),
            scene_hash: job.identity(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            renderer: job.runner().driver.name.to_owned(),
            renderer_version: chunks.cost.version.clone(),
            samples: chunks.cost.samples,
            ..Provenance::default()
        };
        let path = format!("{name}.exr");
        let bytes =
            layered_bytes(&folder.join(&path), &layers, &provenance).map_err(|error| fault(error.to_string()))?;
        sink.file(&path, &mut |out| out.write_all(&bytes)).map_err(failed)?;
        means.push(mean);
    }
    if let [a, b] = means.as_slice() {
        let picture = difference_png(&folder.join("difference.png"), a, b, exposure(a) + 2.0)
            .map_err(|error| fault(error.to_string()))?;
        sink.file("difference.png", &mut |out| out.write_all(&picture)).map_err(failed)?;
    }
    let verdict = serde_json::to_string_pretty(&shown.verdict).map_err(|error| fault(error.to_string()))?;
    sink.file("verdict.json", &mut |out| out.write_all(format!("{verdict}\n").as_bytes())).map_err(failed)?;
    let report = report(reduced, &names);
    sink.file("report.md", &mut |out| out.write_all(report.as_bytes())).map_err(failed)?;
    sink.finish().map(|_| ()).map_err(failed)
}

/// Names of the two sides, which may be one renderer in two places.
fn names(shown: &Shown<'_>) -> [String; 2] {
    let [a, b] = [0, 1].map(|at: usize| shown.jobs[at].runner().driver.name.to_owned());
    if a == b { [format!("{a}-a"), format!("{b}-b")] } else { [a, b] }
}

fn report(reduced: &Reduced<'_>, names: &[String; 2]) -> String {
    let shown = &reduced.shown;
    let told = Told { verdict: &shown.verdict, stated: &shown.stated, excused: false };
    let mut text = format!("# {} and {} differ on `{}`\n\n", names[0], names[1], shown.scene.name);
    let _written = writeln!(
        text,
        "**{}**: {}. B / A in red, green and blue: {}. A is `{}`.\n",
        shown.verdict.outcome.word(),
        told.proof(),
        told.channels(),
        names[0]
    );
    for note in told.notes() {
        let _written = writeln!(text, "- {note}");
    }
    let (before, after) = reduced.things;
    let _written = writeln!(
        text,
        "\nOf {before} surfaces, instances and lights {after} are left; {} scenes were rendered.\n",
        reduced.tried
    );
    for step in &reduced.steps {
        let _written = writeln!(text, "- {step}");
    }
    text.push_str("\n| side | renderer | file | samples | image |\n|---|---|---|---|---|\n");
    for ((job, chunks), name) in shown.jobs.iter().zip(&shown.chunks).zip(names) {
        let main = job.runner().driver.main_file.replace("SCENE", job.scene());
        let _written = writeln!(
            text,
            "| {name} | {} {} | `{name}/{main}` | {} | `{name}.exr` |",
            job.runner().driver.name,
            chunks.cost.version,
            chunks.cost.samples
        );
    }
    let film = &shown.scene.film;
    let _written = writeln!(
        text,
        "\nImages are {} x {} pixels, with the variance of their means in `variance.R` and so on. `difference.png` is green where B is \
         brighter, red where it is dimmer.\n\nWhat is left:\n",
        film.width, film.height
    );
    for (_, shape) in shown.scene.surfaces() {
        let material = &shown.scene.materials[shape.material];
        let lamp = if shape.emission.is_some() { ", emits" } else { "" };
        let _written = writeln!(text, "- `{}`: {}{lamp}", shape.name, material.bsdf.word());
    }
    for light in shown.scene.lights.values() {
        let _written = writeln!(text, "- light `{}`", light.name);
    }
    let _written = writeln!(text, "\nWritten by ltsc {}.", env!("CARGO_PKG_VERSION"));
    text
}
