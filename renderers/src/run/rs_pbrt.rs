//! rs_pbrt, PBRT version 3 written anew in Rust.
//!
//! It writes `pbrt.png` into the working directory and nothing else: 8 bits, sRGB, clamped. Its images are the same bit by
//! bit each time and for any number of threads, so exposures of different `Film "float scale"` are put together, each a
//! rendering of its own; see [`super::brackets`].

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::brackets::Brackets;
use super::process::{End, Lines};
use super::{Crate, Delivery, Driver, Installation, Job, Plan, RenderError, Series, bar, emitted, pbrt, script};
use crate::image::Image;

pub(super) const ROW: Driver = Driver {
    name: "rs-pbrt",
    aliases: &["rs_pbrt", "rspbrt"],
    summary: "PBRT version 3 in Rust, path tracing",
    target: "pbrt-v3",
    main_file: "scene.pbrt",
    version: "0.9.12",
    // The newest of its locked dependencies, clap 4.4.18, asks for Rust 1.70.
    installation: Installation::Cargo(Crate { name: "rs_pbrt", program: "rs_pbrt", oldest: 70 }),
    programs: &["rs_pbrt"],
    asks_named: true,
    test_scene: &[
        ("scene.pbrt", include_str!("test_scenes/pbrt3.pbrt")),
        ("emitter.ply", include_str!("test_scenes/emitter.ply")),
        ("surface.ply", include_str!("test_scenes/surface.ply")),
    ],
    // Of a scene as small as the test scene; larger images have 1.1 %.
    precision: 0.0055,
    hints: &[
        ("unsuccessful parse", "it cannot parse a file; emit the folder again for `pbrt-v3`"),
        ("No such file or directory", "a file is missing; emit the folder again and keep it together"),
        ("Error reading", "it cannot read an image; write textures as PNG or JPEG"),
        // Its banner says "(unknown)" too.
        ("\" unknown", "it has no such material, shape or integrator; emit the scene for `pbrt-v3`"),
        ("memory allocation", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe,
    plan,
};

fn probe(executable: &Path) -> Result<String, String> {
    let mut command = Command::new(executable);
    command.arg("--version");
    let mut version = None;
    let (end, tail) = script::ask(command, Lines::All, &mut |line| {
        // "rs_pbrt version 0.9.12 (unknown) [Detected 2 cores]", and "rs_pbrt 0.9.12" below it.
        if let Some(rest) = line.strip_prefix("rs_pbrt version ") {
            version = version.take().or_else(|| rest.split_whitespace().next().map(str::to_owned));
        }
    })?;
    match (end, version) {
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
        (End::Exited(_), None) => Err(format!(
            "it does not say `rs_pbrt version`: {}",
            tail.first().map_or("it says nothing", String::as_str)
        )),
        // Everything that is said here about files and images was seen with this release only.
        (End::Exited(_), Some(version)) if version == ROW.version => Ok(version),
        (End::Exited(_), Some(version)) => {
            Err(format!("it is version {version}, and only {} is known to give images that can be used", ROW.version))
        }
    }
}

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    pbrt::no_seed(job, "rs_pbrt")?;
    readable(job)?;
    single(job)?;
    let mut changed = pbrt::samples(job)?;
    let film = pbrt::Film::find(job, &changed, "scale")?;
    let brackets = Brackets::new(job.request.width, job.request.height, job.request.samples);
    let (path, text) = film.with(1.0);
    changed.retain(|(file, _)| *file != path);
    changed.push((path, text));
    let main = emitted::copy(job, &changed)?;
    // It finds meshes beside the main file only if that has a relative name.
    let main = main.strip_prefix(job.scratch).map(Path::to_owned).unwrap_or(main);
    let exposures = Exposures {
        executable: job.executable.to_owned(),
        // A number of 8 bits, in which 0 means all processors.
        threads: job.request.threads.map_or(0, |threads| threads.min(255)),
        scratch: job.scratch.to_owned(),
        main,
        film,
        brackets,
        defects: defects(job),
        size: (job.request.width, job.request.height),
    };
    let command = exposures.command();
    Ok(Plan { command, delivery: Delivery::Series(Box::new(exposures), bar::counted) })
}

/// Refuses images that it would take for something else. Textures become 8 bits, whatever they were, and PFM ends it
/// (`imagemap.rs`); an image of the environment that is no Radiance HDR becomes a constant light, with a warning in the
/// log (`infinite.rs`).
fn readable(job: &Job<'_>) -> Result<(), RenderError> {
    for (path, text) in emitted::texts(job.folder, "pbrt") {
        for line in text.lines() {
            let (parameter, kinds) = if line.trim_start().starts_with("Texture") {
                ("\"string filename\"", &["png", "jpg", "jpeg", "tga"][..])
            } else {
                ("\"string mapname\"", &["hdr"][..])
            };
            let Some(file) = line.split(parameter).nth(1).and_then(|rest| rest.split('"').nth(1)) else { continue };
            let ending = file.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
            if !kinds.contains(&ending.as_str()) {
                return Err(RenderError::Request {
                    message: {
                        let place = path.file_name().unwrap_or_default().to_string_lossy();
                        format!("rs_pbrt would read the image `{file}` of `{place}` as something else")
                    },
                    hint: format!("it reads {} here; use `pbrt-v3`, which reads all of them", kinds.join(", ")),
                });
            }
        }
    }
    Ok(())
}

/// Refuses groups that are used more than once: it shows them in one of their places only (measured: of two spheres of a
/// group one is missing; with a group for each the image is that of PBRT 3).
fn single(job: &Job<'_>) -> Result<(), RenderError> {
    let mut seen = BTreeSet::new();
    for (_, text) in emitted::texts(job.folder, "pbrt") {
        for line in text.lines() {
            let Some(name) = line.trim_start().strip_prefix("ObjectInstance") else { continue };
            if !seen.insert(name.trim().to_owned()) {
                return Err(RenderError::Request {
                    message: format!(
                        "the group {} is used more than once, and rs_pbrt shows it in one place only",
                        name.trim()
                    ),
                    hint: "render with `pbrt-v3`, or write the shapes without a group".to_owned(),
                });
            }
        }
    }
    Ok(())
}

/// What it renders otherwise than PBRT 3 by more than noise, of what is in the scene (measured with version 0.9.12 against
/// pbrt-v3 and Mitsuba 3.9.1, which agree; docs/conventions.md).
fn defects(job: &Job<'_>) -> Vec<&'static str> {
    const KNOWN: [(&str, &str, &str); 2] = [
        ("\"glass\"", "\"float uroughness\"", "its rough glass makes a Cornell box 3 to 5 % darker"),
        ("\"disney\"", "", "its principled materials are darker, metals by half"),
    ];
    let texts: Vec<String> = emitted::texts(job.folder, "pbrt").map(|(_, text)| text).collect();
    let has = |kind: &str, parameter: &str| {
        texts.iter().flat_map(|text| text.lines()).any(|line| line.contains(kind) && line.contains(parameter))
    };
    KNOWN.iter().filter(|(kind, parameter, _)| has(kind, parameter)).map(|(_, _, what)| *what).collect()
}

struct Exposures {
    executable: PathBuf,
    threads: usize,
    scratch: PathBuf,
    /// Seen from `scratch`.
    main: PathBuf,
    film: pbrt::Film,
    brackets: Brackets,
    /// What it is known to render otherwise than PBRT 3.
    defects: Vec<&'static str>,
    size: (usize, usize),
}

impl Exposures {
    fn command(&self) -> Command {
        let mut command = Command::new(&self.executable);
        command.args(["-t", &self.threads.to_string(), "-p"]).arg(&self.main).current_dir(&self.scratch);
        command
    }

    /// The codes of the image, which is deleted so that it is not taken for the next one.
    fn take(&self) -> Result<Vec<u8>, String> {
        let path = self.scratch.join("pbrt.png");
        let bytes = fs::read(&path).map_err(|_| "left no image".to_owned())?;
        fs::remove_file(&path).map_err(|error| format!("left an image that cannot be deleted: {error}"))?;
        let image = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
            .map_err(|error| format!("left an image that cannot be read: {error}"))?;
        let (width, height) = (image.width() as usize, image.height() as usize);
        if (width, height) != self.size {
            return Err(super::render::wrong_size((width, height), self.size));
        }
        Ok(image.into_rgb8().into_raw())
    }
}

impl Series for Exposures {
    fn next(&mut self) -> Result<Option<Command>, String> {
        self.brackets.add(&self.take()?)?;
        let Some(scale) = self.brackets.wanted() else { return Ok(None) };
        let (path, text) = self.film.with(scale);
        let folder = self.scratch.join(&self.main);
        let file = folder.with_file_name(path.file_name().unwrap_or_default());
        fs::write(&file, text).map_err(|error| format!("cannot be given `{}`: {error}", file.display()))?;
        Ok(Some(self.command()))
    }

    fn expected(&self) -> usize {
        self.brackets.expected()
    }

    fn finish(self: Box<Self>) -> Result<(Image, Vec<(String, String)>), String> {
        let scales: Vec<String> = self.brackets.scales().iter().map(ToString::to_string).collect();
        let mut facts = vec![
            ("exposures".to_owned(), scales.join(" ")),
            ("quantisation".to_owned(), format!("{:.5}", self.brackets.error())),
        ];
        if !self.defects.is_empty() {
            facts.push(("defects".to_owned(), self.defects.join("; ")));
        }
        Ok((self.brackets.image(), facts))
    }
}
