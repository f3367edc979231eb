//! PBRT version 3, by its program `pbrt`.

use std::process::Command;

use super::tiles::{self, Outside};
use super::{Asked, Delivery, Driver, Installation, Job, Plan, RenderError, bar, emitted, pbrt};

pub(super) const ROW: Driver = Driver {
    name: "pbrt-v3",
    aliases: &["pbrt3"],
    summary: "PBRT version 3, path tracing",
    target: "pbrt-v3",
    main_file: "scene.pbrt",
    version: "3",
    installation: Installation::User { source: "https://github.com/mmp/pbrt-v3" },
    programs: &["pbrt", "pbrt3", "pbrt-v3"],
    asks_named: true,
    test_scene: &[],
    wavelengths: None,
    seeds: super::Seeds::Free,
    least_samples: 1,
    defects: &[],
    failures: &[],
    hints: &[
        ("No such file or directory", "a file is missing; emit the folder again and keep it together"),
        ("Unable to open", "a file is missing; emit the folder again and keep it together"),
        ("unused", "this version does not know a parameter in the file; emit the scene for `pbrt-v3`"),
        ("unknown", "this version does not know a name in the file; emit the scene for `pbrt-v3`"),
        ("bad_alloc", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe,
    plan,
};

fn probe(asked: Asked<'_>) -> Result<String, String> {
    pbrt::version(asked, 3)
}

/// Its command line has neither samples nor a seed, so the samples are written into a copy of the settings.
fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    let mut changed = pbrt::samples(job)?;
    let above = tiles::seed(job, Outside::Skipped, &mut changed)?;
    let main = if changed.is_empty() { job.main.to_owned() } else { emitted::copy(job, &changed)? };
    // The ending says the format; its OpenEXR files would have 16 bits only (`imageio.cpp`).
    let image = job.scratch.join("image.pfm");
    let mut command = Command::new(job.executable);
    if let Some(threads) = job.request.threads {
        command.arg("--nthreads").arg(threads.to_string());
    }
    // Otherwise it leaves log files in the system's temporary folder.
    command.arg("--logdir").arg(job.scratch);
    command.arg("--outfile").arg(&image).arg(main).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, bar::plusses), above, facts: Vec::new() })
}
