//! PBRT version 4, by its program `pbrt`.

use std::process::Command;

use super::process::Lines;
use super::{Asked, Delivery, Driver, Installation, Job, Plan, RenderError, bar, emitted, pbrt, script};

pub(super) const ROW: Driver = Driver {
    name: "pbrt-v4",
    aliases: &["pbrt", "pbrt4"],
    summary: "PBRT version 4, path tracing on the processor",
    target: "pbrt-v4",
    main_file: "scene.pbrt",
    version: "4",
    installation: Installation::User { source: "https://github.com/mmp/pbrt-v4" },
    programs: &["pbrt", "pbrt4", "pbrt-v4"],
    asks_named: true,
    test_scene: &[],
    wavelengths: Some(pbrt::FOUR_WAVELENGTHS),
    seeds: super::Seeds::Free,
    least_samples: 1,
    defects: &[],
    failures: &[],
    hints: &[
        ("No such file or directory", "a file is missing; emit the folder again and keep it together"),
        ("unused parameter", "this version does not know a parameter in the file; emit the scene for `pbrt-v4`"),
        ("expected a number", "the file is one for version 3; emit the scene for `pbrt-v4`"),
        ("unknown", "this version does not know a name in the file; emit the scene for `pbrt-v4`"),
        ("bad_alloc", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe,
    plan,
};

/// Options that the first versions of it lack, as its help writes them.
const OPTIONS: [&str; 2] = ["--seed", "--spp"];

fn probe(asked: Asked<'_>) -> Result<String, String> {
    let version = pbrt::version(asked, 4)?;
    let mut command = Command::new(asked.program);
    command.arg("--help");
    let (_, help) = script::ask(command, asked.until, Lines::All, &mut |_| {})?;
    match OPTIONS.iter().find(|option| !help.iter().any(|line| line.contains(**option))) {
        None => Ok(version),
        Some(option) => Err(format!("it is version {version}, which is too old: it has no option `{option}`")),
    }
}

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    // It reads a signed number.
    if i64::from(job.request.seed) > i64::from(i32::MAX) {
        return Err(RenderError::Request {
            message: format!("the seed {} is too large for pbrt-v4", job.request.seed),
            hint: "count seeds from 0".to_owned(),
        });
    }
    // The option says how many samples a sampler takes; mutations and passes stand in the file alone.
    let changed = pbrt::samples(job)?;
    let main = if changed.is_empty() { job.main.to_owned() } else { emitted::copy(job, &changed)? };
    let image = job.scratch.join("image.exr");
    let mut command = Command::new(job.executable);
    if let Some(threads) = job.request.threads {
        command.arg("--nthreads").arg(threads.to_string());
    }
    command.arg("--spp").arg(job.request.samples.to_string());
    command.arg("--seed").arg(job.request.seed.to_string());
    command.arg("--outfile").arg(&image).arg(main).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, bar::plusses), above: 0, facts: Vec::new() })
}
