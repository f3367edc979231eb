//! Cycles, through the Python package `bpy` or the program `blender`.

use std::path::Path;
use std::process::Command;

use super::process::{End, Lines};
use super::{Asked, Driver, Installation, Job, Packages, Plan, RenderError, script};

pub(super) const ROW: Driver = Driver {
    name: "cycles",
    aliases: &["blender", "bpy"],
    summary: "Cycles in Blender, path tracing on the processor",
    target: "cycles",
    main_file: "scene.py",
    version: "4.5.15",
    installation: Installation::Python(Packages {
        requirements: &["bpy==4.5.15"],
        // Wheels of 4.5.15 on the package index.
        pythons: (11, 11),
        module: "bpy",
    }),
    programs: &["blender"],
    asks_named: false,
    test_scene: &[("scene.py", include_str!("test_scenes/cycles.py"))],
    wavelengths: None,
    // Places of samples within a pixel are those of a lattice that all pixels and seeds share: an edge is off by up to half of 1 / samples
    // of a pixel. Measured (4.5.15, 32 seeds, a lamp's edge at a small angle to the pixels, tiles that it lights by less than a pixel):
    // -16 % with 8 samples, -3.6 % with 32; cbox_classic, 128 x 128, whole image: -1.0 % with 8, -0.3 % with 32, 0.0 % with 128.
    seeds: super::Seeds::Free,
    least_samples: 64,
    defects: &[],
    failures: &[],
    hints: &[
        ("MemoryError", "it ran out of memory; make the image or the meshes smaller"),
        ("ShaderNodeBsdfMetallic", "this Blender has no metals with `eta` and `k`; 4.3 is the first that has"),
        ("No such file or directory", "a file is missing; emit the folder again and keep it together"),
    ],
    probe,
    plan,
};

/// The first Blender with the metal that scenes use.
const OLDEST: (u32, u32) = (4, 3);

fn probe(asked: Asked<'_>) -> Result<String, String> {
    let executable = asked.program;
    let version = if script::is_python(executable) {
        script::probe(asked, "bpy", "bpy.app.version_string.split()[0]")?
    } else if is_program(executable) {
        ask(asked)?
    } else {
        return Err(super::find::wrong_program(executable, &ROW));
    };
    let mut numbers = version.split('.').map(|part| part.parse::<u32>().unwrap_or_default());
    let found = (numbers.next().unwrap_or_default(), numbers.next().unwrap_or_default());
    if found >= OLDEST {
        return Ok(version);
    }
    Err(format!("it is version {version}, and {}.{} is the first that can be used", OLDEST.0, OLDEST.1))
}

/// The version of the program.
fn ask(asked: Asked<'_>) -> Result<String, String> {
    let mut command = Command::new(asked.program);
    command.arg("--version");
    let mut version = None;
    let (end, _) = script::ask(command, asked.until, Lines::All, &mut |line| {
        // "Blender 4.5.15 LTS"
        if let Some(rest) = line.strip_prefix("Blender ") {
            version = version.take().or_else(|| rest.split_whitespace().next().map(str::to_owned));
        }
    })?;
    match (end, version) {
        (End::Exited(_), Some(version)) => Ok(version),
        (End::Exited(_), None) => Err("it does not tell its version".to_owned()),
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
    }
}

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    // Blender's seed and threads are signed numbers, and it has at most 1024 threads.
    if i64::from(job.request.seed) > i64::from(i32::MAX) {
        return Err(RenderError::Request {
            message: format!("the seed {} is too large for Cycles", job.request.seed),
            hint: "count seeds from 0".to_owned(),
        });
    }
    let mut plan = script::plan(job, include_str!("cycles.py"), serde_json::json!({}), job.scratch)?;
    if !script::is_python(job.executable) {
        // The program runs the same script; its own arguments end at `--`.
        let arguments: Vec<_> = plan.command.get_args().map(std::ffi::OsStr::to_owned).collect();
        let [.., file, argument] = &arguments[..] else { return Ok(plan) };
        let mut command = Command::new(job.executable);
        command.args(["-b", "--factory-startup", "--python-exit-code", "1", "-P"]);
        command.arg(file).arg("--").arg(argument).current_dir(job.scratch);
        plan.command = command;
    }
    Ok(plan)
}

fn is_program(executable: &Path) -> bool {
    executable.file_stem().and_then(|name| name.to_str()).is_some_and(|name| ROW.programs.contains(&name))
}
