//! LuxCore, through the Python package `pyluxcore`.

use super::{Asked, Driver, Installation, Job, Packages, Plan, RenderError, script};

pub(super) const ROW: Driver = Driver {
    name: "luxcore",
    aliases: &["lux", "luxcorerender"],
    summary: "LuxCore, path tracing on the processor",
    target: "luxcore",
    main_file: "scene.cfg",
    version: "2.11.2",
    installation: Installation::Python(Packages {
        requirements: &["pyluxcore==2.11.2"],
        // Wheels of 2.11.2 on the package index.
        pythons: (10, 14),
        module: "pyluxcore",
    }),
    programs: &[],
    asks_named: false,
    test_scene: &[
        ("scene.cfg", include_str!("test_scenes/luxcore.cfg")),
        ("scene.scn", include_str!("test_scenes/luxcore.scn")),
        ("emitter.ply", include_str!("test_scenes/emitter.ply")),
        ("surface.ply", include_str!("test_scenes/surface.ply")),
    ],
    wavelengths: None,
    seeds: super::Seeds::Free,
    least_samples: 1,
    defects: &[],
    failures: &[],
    hints: &[
        ("Unable to read PLY", "a mesh is missing; emit the folder again and keep it together"),
        ("File not found", "a file is missing; emit the folder again and keep it together"),
        ("bad_alloc", "it ran out of memory; make the image or the meshes smaller"),
    ],
    probe,
    plan,
};

fn probe(asked: Asked<'_>) -> Result<String, String> {
    if script::is_python(asked.program) {
        script::probe(asked, "pyluxcore", "pyluxcore.Version()")
    } else {
        Err(super::find::wrong_program(asked.program, &ROW))
    }
}

fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    // The script adds 1, and the renderer reads a signed number.
    if i64::from(job.request.seed) >= i64::from(i32::MAX) {
        return Err(RenderError::Request {
            message: format!("the seed {} is too large for LuxCore", job.request.seed),
            hint: "count seeds from 0".to_owned(),
        });
    }
    script::plan(job, include_str!("luxcore.py"), serde_json::json!({}), job.folder)
}
