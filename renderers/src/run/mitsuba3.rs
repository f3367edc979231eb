//! Mitsuba 3, through the Python package `mitsuba` or its program `mitsuba`.

use std::path::Path;
use std::process::Command;

use super::process::{End, Lines};
use super::{Asked, Delivery, Driver, Installation, Job, Packages, Plan, RenderError, emitted, script};

/// The variant that every installation has and that needs nothing else. The `llvm_*` variants are
/// about five times faster, but a wrong LLVM library ends the process at the first image (14 to 16
/// do so with 3.9.1), so they are used only if the user asks for them.
const VARIANT: &str = "scalar_rgb";

pub(super) const ROW: Driver = Driver {
    name: "mitsuba-3",
    aliases: &["mitsuba", "mitsuba3"],
    summary: "Mitsuba 3, path tracing",
    target: "mitsuba-3",
    main_file: "scene.xml",
    version: "3.9.1",
    installation: Installation::Python(Packages {
        requirements: &["mitsuba==3.9.1"],
        // Wheels of 3.9.1 on the package index.
        pythons: (9, 14),
        module: "mitsuba",
    }),
    programs: &["mitsuba"],
    asks_named: false,
    test_scene: &[
        ("scene.xml", include_str!("test_scenes/mitsuba3.xml")),
        ("emitter.ply", include_str!("test_scenes/emitter.ply")),
        ("surface.ply", include_str!("test_scenes/surface.ply")),
    ],
    wavelengths: None,
    seeds: super::Seeds::Free,
    least_samples: 1,
    defects: &[],
    failures: &[],
    hints: &[
        (
            "Cannot select: fminimum",
            "the LLVM library is too old; name version 19 or newer in DRJIT_LIBLLVM_PATH, or use \
             the variant `scalar_rgb`",
        ),
        (
            "LLVM backend",
            "name an LLVM library of version 19 or newer in DRJIT_LIBLLVM_PATH, or use the \
             variant `scalar_rgb`",
        ),
        ("unreferenced propert", "this version does not know a parameter in the file; emit it for `mitsuba-3`"),
        ("file not found", "a mesh is missing; emit the folder again and keep it together"),
        ("does not exist", "a file is missing; emit the folder again and keep it together"),
        ("bad_alloc", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe,
    plan,
};

fn probe(asked: Asked<'_>) -> Result<String, String> {
    let executable = asked.program;
    if script::is_python(executable) {
        return script::probe(asked, "mitsuba", "mitsuba.__version__");
    }
    if !is_program(executable) {
        return Err(super::find::wrong_program(executable, &ROW));
    }
    let mut command = Command::new(executable);
    command.arg("--help");
    let mut version = None;
    let (end, _) = script::ask(command, asked.until, Lines::All, &mut |line| {
        // "Mitsuba version 3.9.1 (master[478e193], Linux, 64bit, ...)"
        if let Some(rest) = line.strip_prefix("Mitsuba version ") {
            version = rest.split_whitespace().next().map(str::to_owned);
        }
    })?;
    match (end, version) {
        (End::Exited(_), Some(version)) if version.starts_with("3.") => Ok(version),
        (End::Exited(_), Some(version)) => Err(format!("it is version {version}")),
        (_, None) => Err("it does not tell its version".to_owned()),
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
    }
}

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    let variant = job.request.variant.as_deref().unwrap_or(VARIANT);
    if variant.starts_with("llvm_") {
        check_llvm(job)?;
    }
    let streams = Streams::new(job.request.width, job.request.height);
    streams.check(job.request.seed)?;
    if script::is_python(job.executable) {
        // Names in the file are resolved against the file, so the working directory is free to be
        // one where nothing is lost.
        let more = serde_json::json!({
            "variant": variant,
            "passes": streams.passes,
            "first_seed": streams.first(job.request.seed),
            "seed_step": streams.step,
        });
        script::plan(job, include_str!("mitsuba3.py"), more, job.scratch)
    } else {
        plan_program(job, variant, &streams)
    }
}

/// The renderer's own command line: one pass, and numbers that the file must ask for by
/// `<default name="samples" .../>` and `<default name="seed" .../>`. The latter is added to the
/// numbers of streams and not multiplied by anything.
fn plan_program(job: &Job<'_>, variant: &str, streams: &Streams) -> Result<Plan, RenderError> {
    for name in ["samples", "seed"] {
        if !emitted::declares(job, name) {
            let hint = format!(
                "write `<default name=\"{name}\" value=\"0\"/>` and use `${name}` in the sampler, or name a Python that \
                 has Mitsuba"
            );
            return Err(emitted::no_parameter(job, name, hint));
        }
    }
    let image = job.scratch.join("image.exr");
    let mut command = Command::new(job.executable);
    command.arg("-m").arg(variant);
    if let Some(threads) = job.request.threads {
        command.arg("-t").arg(threads.to_string());
    }
    command
        .arg(format!("-Dsamples={}", job.request.samples))
        .arg(format!("-Dseed={}", streams.first(job.request.seed) * streams.pixels))
        .arg("-o")
        .arg(&image)
        .arg(job.main)
        .current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, |_| None), above: 0, facts: Vec::new() })
}

/// Which random streams the passes of each seed use.
///
/// In the scalar variants the stream of a pixel has the number `base + seed * pixels + index`,
/// modulo 2^32, where `base` is the sampler's own parameter, `seed` the one that is given to the
/// rendering, and `index` counts pixels in blocks of 32 by 32 of which those at the border may be
/// incomplete (measured with 3.9.1 by an integrator that shows its random numbers: images of 128 by
/// 128 pixels with bases 0 and 1 share all their numbers, those with seeds 0 and 2^32 / 128^2 are
/// the same, and of 37 by 50 pixels those with seeds 0 and 1 share one number in six). In the LLVM
/// variants only the sum of base and seed counts. So bases stay as they are, and seeds keep a
/// distance of whole blocks.
struct Streams {
    pixels: u64,
    /// The least distance of two seeds that share no stream.
    step: u64,
    /// How many of them each seed of a request has.
    passes: u64,
}

impl Streams {
    fn new(width: usize, height: usize) -> Self {
        // Images of no pixels are refused when they come.
        let (width, height) = (width.max(1) as u64, height.max(1) as u64);
        let pixels = width * height;
        let padded = width.next_multiple_of(32) * height.next_multiple_of(32);
        // Progress in fewer steps leaves large images more seeds.
        let passes = if pixels <= 1 << 20 { 16 } else { 4 };
        Self { pixels, step: padded.div_ceil(pixels), passes }
    }

    /// The renderer's seed for the first pass.
    fn first(&self, seed: u32) -> u64 {
        u64::from(seed) * self.passes * self.step
    }

    /// How many seeds there are before streams are used again; always at least one.
    fn seeds(&self) -> u64 {
        ((1 << 32) / (self.passes * self.step * self.pixels)).max(1)
    }

    fn check(&self, seed: u32) -> Result<(), RenderError> {
        if u64::from(seed) < self.seeds() {
            return Ok(());
        }
        Err(RenderError::Request {
            message: format!("the seed {seed} gives random numbers that a smaller seed has given at this image size"),
            hint: format!("use seeds below {}", self.seeds()),
        })
    }
}

/// Refuses a variant that would end the process for want of its library.
fn check_llvm(job: &Job<'_>) -> Result<(), RenderError> {
    // The renderer reads the variable of the process, and so does this.
    let library = std::env::var_os("DRJIT_LIBLLVM_PATH");
    if library.as_ref().is_some_and(|path| Path::new(path).is_file()) {
        return Ok(());
    }
    Err(RenderError::Request {
        message: format!(
            "the variant `{}` needs an LLVM library, and DRJIT_LIBLLVM_PATH names none",
            job.request.variant.as_deref().unwrap_or_default()
        ),
        hint: "set it to the file of LLVM 19 or newer, or use the variant `scalar_rgb`".to_owned(),
    })
}

fn is_program(executable: &Path) -> bool {
    executable.file_stem().and_then(|name| name.to_str()).is_some_and(|name| ROW.programs.contains(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of streams that a pass may use, from the first to behind the last.
    fn range(streams: &Streams, size: (usize, usize), seed: u32, pass: u64) -> (u64, u64) {
        let first = (streams.first(seed) + pass * streams.step) * streams.pixels;
        let padded = size.0.next_multiple_of(32) * size.1.next_multiple_of(32);
        (first, first + padded as u64)
    }

    #[test]
    fn no_two_passes_share_a_stream() {
        for size in [(1, 1), (8, 8), (37, 50), (128, 128), (100, 100), (512, 512), (1920, 1080)] {
            let streams = Streams::new(size.0, size.1);
            let last = u32::try_from(streams.seeds().min(40) - 1).expect("a small number");
            let mut end = 0;
            for seed in 0..=last {
                for pass in 0..streams.passes {
                    let (from, to) = range(&streams, size, seed, pass);
                    assert!(from >= end, "{size:?} {seed} {pass}");
                    end = to;
                }
            }
            assert!(streams.check(last).is_ok());
        }
    }

    #[test]
    fn seeds_that_would_repeat_are_refused() {
        let streams = Streams::new(512, 512);
        assert_eq!(streams.seeds(), 1024);
        assert!(streams.check(1023).is_ok());
        let error = streams.check(1024).expect_err("the last stream is used");
        assert!(error.hint().contains("1024"));
        // The last number of the renderer's 32 bits is not passed, whatever the size.
        for size in [(1, 1), (8, 8), (37, 50), (1000, 1), (4096, 4096)] {
            let streams = Streams::new(size.0, size.1);
            let last = u32::try_from(streams.seeds() - 1).expect("32 bits");
            let (_, end) = range(&streams, size, last, streams.passes - 1);
            assert!(end <= 1 << 32, "{size:?}");
        }
        assert!(Streams::new(65_536, 65_536).check(0).is_ok());
    }
}
