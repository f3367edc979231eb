//! pbrt-r4, PBRT version 4 ported to Rust by Toru Matsuoka.
//!
//! It reads the files of version 4 and draws nearly the same random numbers. It takes unknown parameters and materials
//! that are not there in silence, where version 4 ends, so that only files that are known to be right should be given to it.

use std::path::PathBuf;
use std::process::Command;

use super::{Crate, Defect, Delivery, Driver, Installation, Job, Plan, RenderError, bar, emitted, pbrt};

pub(super) const ROW: Driver = Driver {
    name: "pbrt-r4",
    aliases: &["pbrt_r4", "r4"],
    summary: "a port of PBRT version 4 to Rust, path tracing on the processor",
    target: "pbrt-v4",
    main_file: "scene.pbrt",
    version: "4.5.2",
    installation: Installation::Cargo(Crate {
        name: "pbrt-r4",
        program: "pbrt-r4",
        // The newest of its locked dependencies, hashbrown 0.17.1, asks for Rust 1.85.
        oldest: 85,
        // Its renderer for graphics cards brings a hundred crates more.
        flags: &["--no-default-features"],
        // Its build script computes tables of spectra, for which it needs ten minutes without optimization.
        environment: &[("CARGO_PROFILE_RELEASE_BUILD_OVERRIDE_OPT_LEVEL", "3")],
    }),
    programs: &["pbrt-r4"],
    asks_named: true,
    test_scene: &[
        ("scene.pbrt", include_str!("test_scenes/pbrt4.pbrt")),
        ("emitter.ply", include_str!("test_scenes/emitter.ply")),
        ("surface.ply", include_str!("test_scenes/surface.ply")),
    ],
    wavelengths: Some(pbrt::FOUR_WAVELENGTHS),
    seeds: super::Seeds::Free,
    least_samples: 1,
    // Against its own path tracing (docs/conventions.md).
    defects: &[Defect {
        features: &["bidirectional path tracing"],
        what: "its bidirectional path tracing makes a room 4.6 % darker than its path tracing",
    }],
    failures: &[" ERROR] "],
    hints: pbrt::PORT_HINTS,
    probe: |asked| pbrt::port(asked, "pbrt-r4"),
    plan,
};

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    // It reads a signed number.
    if i64::from(job.request.seed) > i64::from(i32::MAX) {
        return Err(RenderError::Request {
            message: format!("the seed {} is too large for pbrt-r4", job.request.seed),
            hint: "count seeds from 0".to_owned(),
        });
    }
    let mut changed = pbrt::samples(job)?;
    seed(job, &mut changed);
    let main = if changed.is_empty() { job.main.to_owned() } else { emitted::copy(job, &changed)? };
    let image = job.scratch.join("image.exr");
    let mut command = Command::new(job.executable);
    if let Some(threads) = job.request.threads {
        command.arg("--nthreads").arg(threads.to_string());
    }
    // Otherwise it keeps images in the system's temporary folder.
    command.args(["--texture-cache", "off"]);
    command.arg("--spp").arg(job.request.samples.to_string());
    command.arg("--outfile").arg(&image).arg(main).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, bar::plusses), above: 0, facts: Vec::new() })
}

/// It has no option for the seed: what draws random numbers is told in the file (`IndependentSampler::create` and its like,
/// `create_sppm_integrator`, `MLTSampler` by the option).
fn seed(job: &Job<'_>, changed: &mut Vec<(PathBuf, String)>) {
    let seed = job.request.seed;
    if seed == 0 {
        return;
    }
    for (path, text) in emitted::texts(job.folder, "pbrt") {
        let before = changed.iter().find(|(file, _)| *file == path).map_or(text, |(_, text)| text.clone());
        let parameter = format!(" \"integer seed\" [{seed}]");
        let mut after = pbrt::with_parameter(&before, "Sampler", None, &parameter);
        after = pbrt::with_parameter(&after, "Integrator", Some("sppm"), &parameter);
        if let Some((start, _)) = pbrt::directive(&after, "Integrator")
            && after[start..].contains("\"mlt\"")
        {
            after.insert_str(start, &format!("Option \"seed\" {seed}\n"));
        }
        if after != before {
            changed.retain(|(file, _)| *file != path);
            changed.push((path, after));
        }
    }
}
