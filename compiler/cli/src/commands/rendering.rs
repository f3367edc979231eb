//! A scene through a renderer, for commands that render several.

use std::path::PathBuf;
use std::time::Duration;

use ltsc_core::capability::{Support, algorithm};
use ltsc_core::formats::Choices;
use ltsc_core::ir::Scene;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::run::{Driver, Progress, RenderRequest, Rendered, Search, find, render};

use crate::disk::{DiskSink, unwritable};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};

use super::render::failure;

/// Whether the renderer is there.
pub fn is_there(driver: &'static Driver, project: &Project) -> bool {
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let configured = project.executables.get(driver.name).map(PathBuf::as_path);
    find(driver, &Search { env: &env, cache: cache.as_ref(), given: None, configured }).is_ok()
}

/// Whether the renderer lacks the algorithm that the scene asks for.
pub fn lacks(driver: &Driver, scene: &Scene) -> Result<bool, Failure> {
    let target = project::target(driver.target)?;
    Ok(matches!((target.supports)(algorithm(&scene.integrator).0), Support::Unsupported { why: _ }))
}

/// Renders a scene, seen by its first camera, with samples and a seed.
pub fn rendered(
    project: &Project,
    scene: &Valid,
    driver: &'static Driver,
    (samples, seed): (u32, u32),
    timeout: Option<Duration>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Rendered, Failure> {
    let target = project::target(driver.target)?;
    let work = tempfile::Builder::new().prefix("ltsc-render-").tempdir();
    let work = work.map_err(|error| Failure::new(Exit::Environment, error.to_string()))?;
    let failed = |error: std::io::Error| unwritable(work.path(), &error);
    let camera = pipeline::camera(scene, None)
        .ok_or_else(|| Failure::new(Exit::Fault, format!("the scene `{}` lost its camera", scene.name)))?;
    let mut sink = DiskSink::own(work.path(), &scene.name);
    pipeline::emit_alone(scene, camera, target, &Ledger::of(scene, target, &[]), &Choices::default(), &mut sink)
        .map_err(failed)?;
    sink.finish().map_err(failed)?;
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let size = (scene.film.width as usize, scene.film.height as usize);
    let request = RenderRequest {
        executable: project.executables.get(driver.name).cloned(),
        env,
        cache,
        main_file: driver.main_file.replace("SCENE", &scene.name),
        samples,
        seed,
        timeout,
        ..RenderRequest::new(driver, work.path().to_path_buf(), size, work.path().join("log"))
    };
    render(&request, &mut |news| progress(news)).map_err(|error| failure(&error))
}
