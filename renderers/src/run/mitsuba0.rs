//! Mitsuba 0.5 and 0.6, by their program `mitsuba`. Each reads only files that name its own version.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use super::process::{End, Lines};
use super::{Asked, Delivery, Driver, Installation, Job, Plan, RenderError, bar, emitted, script};

pub(super) const ROW_06: Driver = Driver {
    name: "mitsuba-0.6",
    summary: "Mitsuba 0.6, path tracing and bidirectional methods",
    target: "mitsuba-0.6",
    version: "0.6.0",
    probe: |asked| version(asked, "0.6"),
    ..ROW
};

pub(super) const ROW_05: Driver = Driver {
    name: "mitsuba-0.5",
    summary: "Mitsuba 0.5, path tracing and bidirectional methods",
    target: "mitsuba-0.5",
    version: "0.5.0",
    probe: |asked| version(asked, "0.5"),
    ..ROW
};

/// What both have in common.
const ROW: Driver = Driver {
    name: "",
    aliases: &[],
    summary: "",
    target: "",
    main_file: "scene.xml",
    version: "",
    installation: Installation::User { source: "https://github.com/mitsuba-renderer/mitsuba" },
    programs: &["mitsuba", "mitsuba0"],
    asks_named: true,
    test_scene: &[],
    wavelengths: None,
    // Its program ends with code 0 when the job of rendering has thrown (`renderjob.cpp`).
    seeds: super::Seeds::Some,
    least_samples: 1,
    defects: &[],
    failures: &["caught exception", "did not complete successfully"],
    hints: &[
        (
            "error while loading shared libraries",
            "its libraries are missing; keep it in its folder `dist`, or source its `setpath.sh`",
        ),
        ("from an older version of Mitsuba", "the file names another version; emit the scene for this one"),
        ("from an incompatible future version", "the file names another version; emit the scene for this one"),
        ("Unable to open", "a file is missing; emit the folder again and keep it together"),
        ("not found", "a file or a plugin is missing; emit the folder again and keep it together"),
        ("bad_alloc", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe: |asked| version(asked, "0."),
    plan,
};

/// The program with its libraries. They lie in its own folder, `dist`, and its `setpath.sh` tells the system so; where the
/// program lies elsewhere, as packages have it, the system knows.
fn program(executable: &Path) -> Command {
    let mut command = Command::new(executable);
    let folder = executable.parent().unwrap_or(Path::new("."));
    let libraries = ["libmitsuba-core.so", "libmitsuba-core.dylib"];
    if libraries.iter().any(|name| folder.join(name).exists()) {
        for variable in ["LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH"] {
            let before = env::var_os(variable).unwrap_or_default();
            let all = std::iter::once(folder.to_owned())
                .chain(env::split_paths(&before).filter(|path| !path.as_os_str().is_empty()));
            command.env(variable, env::join_paths(all).unwrap_or_else(|_| OsString::from(folder)));
        }
    }
    command
}

/// The version of a program that must be `wanted`, such as 0.6.
fn version(asked: Asked<'_>, wanted: &str) -> Result<String, String> {
    let mut command = program(asked.program);
    command.arg("-h");
    let mut found = None;
    let (end, tail) = script::ask(command, asked.until, Lines::All, &mut |line| {
        // "Mitsuba version 0.6.0 (Linux, 64 bit), Copyright (c) 2017 Wenzel Jakob"
        if let Some(rest) = line.strip_prefix("Mitsuba version ") {
            let number = rest.split([' ', ',']).next().unwrap_or_default();
            found = found.take().or_else(|| Some(number.to_owned()));
        }
    })?;
    match (end, found) {
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
        (End::Exited(_), None) => Err(format!(
            "it does not say `Mitsuba version`: {}",
            tail.first().map_or("it says nothing", String::as_str)
        )),
        (End::Exited(_), Some(number)) if number == wanted || number.starts_with(&format!("{wanted}.")) => Ok(number),
        (End::Exited(_), Some(number)) => {
            let advice = match number.split('.').take(2).collect::<Vec<_>>()[..] {
                ["3", _] => "; name it for `mitsuba-3`".to_owned(),
                ["0", minor @ ("5" | "6")] => format!("; name it for `mitsuba-0.{minor}`"),
                ["0", _] => ", which is too old".to_owned(),
                _ => String::new(),
            };
            Err(format!("it is version {number}, and this reads the files of version {wanted}{advice}"))
        }
    }
}

/// Equal seeds give equal images only with one thread: samples are given out as threads come for them
/// (`independent.cpp`).
fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    if !emitted::declares(job, "samples") {
        let hint = format!("emit the scene for the target `{}` again", job.request.driver.target);
        return Err(emitted::no_parameter(job, "samples", hint));
    }
    let seeds = emitted::declares(job, "seed");
    if job.request.seed != 0 && !seeds {
        return Err(RenderError::Request {
            message: format!(
                "the independent sampler of Mitsuba 0.x has no seed, so that it cannot be {}",
                job.request.seed
            ),
            hint: "leave the seed at 0, or let the scene say `sampler = sobol(...)`, whose scramble is the seed"
                .to_owned(),
        });
    }
    let image = job.scratch.join("image.exr");
    let mut command = program(job.executable);
    if let Some(threads) = job.request.threads {
        command.arg("-p").arg(threads.to_string());
    }
    command.arg("-D").arg(format!("samples={}", job.request.samples));
    if seeds {
        command.arg("-D").arg(format!("seed={}", job.request.seed));
    }
    // It writes a log of its own into the working directory.
    command.arg("-o").arg(&image).arg(job.main).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, bar::mitsuba), above: 0, facts: Vec::new() })
}
