//! pbrt-r3, PBRT version 3 ported to Rust by Toru Matsuoka.

use std::process::Command;

use super::tiles::{self, Outside};
use super::{Crate, Defect, Delivery, Driver, Installation, Job, Plan, RenderError, bar, emitted, pbrt};

pub(super) const ROW: Driver = Driver {
    name: "pbrt-r3",
    aliases: &["pbrt_r3", "r3"],
    summary: "a port of PBRT version 3 to Rust, path tracing on the processor",
    target: "pbrt-v3",
    main_file: "scene.pbrt",
    version: "3.2.0",
    installation: Installation::Cargo(Crate {
        name: "pbrt-r3",
        program: "pbrt-r3",
        // The newest of its locked dependencies, clap 4.5.21, asks for Rust 1.74; its own code for 1.80.
        oldest: 80,
        flags: &[],
        environment: &[],
    }),
    programs: &["pbrt-r3"],
    asks_named: true,
    test_scene: &[
        ("scene.pbrt", include_str!("test_scenes/pbrt3.pbrt")),
        ("emitter.ply", include_str!("test_scenes/emitter.ply")),
        ("surface.ply", include_str!("test_scenes/surface.ply")),
    ],
    wavelengths: None,
    seeds: super::Seeds::Costly,
    least_samples: 1,
    // Against PBRT 3 (docs/conventions.md).
    defects: &[Defect {
        features: &["a principled material", "a principled material with a texture"],
        what: "its principled materials differ: of metals half as much again is seen, at grazing angles less",
    }],
    failures: &[" ERROR] "],
    hints: pbrt::PORT_HINTS,
    probe: |asked| pbrt::port(asked, "pbrt-r3"),
    plan,
};

/// It has no seed, and does not read `pixelbounds` (`create_path_integrator`).
fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    let mut changed = pbrt::samples(job)?;
    let above = tiles::seed(job, Outside::Rendered, &mut changed)?;
    let main = if changed.is_empty() { job.main.to_owned() } else { emitted::copy(job, &changed)? };
    let image = job.scratch.join("image.exr");
    let mut command = Command::new(job.executable);
    if let Some(threads) = job.request.threads {
        command.arg("--nthreads").arg(threads.to_string());
    }
    // It keeps images in the system's temporary folder.
    for variable in ["TMPDIR", "TEMP", "TMP"] {
        command.env(variable, job.scratch);
    }
    command.arg("--outfile").arg(&image).arg(main).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, bar::plusses), above, facts: Vec::new() })
}
