//! One image of a scene by a renderer: emitted into a folder of its own, read back, rendered. The same for every command that
//! renders scenes of its own accord, and known by its content: what was written for the renderer, and how it is asked to render.

use std::path::Path;
use std::time::{Duration, Instant};

use ltsc_core::capability::{Support, algorithm};
use ltsc_core::formats::Choices;
use ltsc_core::ir::Scene;
use ltsc_core::ledger::{self, Ledger};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::guard::Folder;
use ltsc_render::run::{Driver, Found, Progress, RenderError, RenderRequest, Rendered, Search, find, render};

use crate::disk::{DiskSink, no_temporary, unwritable};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};

use super::render::failure;

/// A renderer that is there, and how it is to be run.
pub struct Runner {
    pub driver: &'static Driver,
    pub found: Found,
    /// All processors if none.
    pub threads: Option<usize>,
    /// The longest time for one image.
    pub timeout: Option<Duration>,
    pub env: Env,
    pub cache: Option<CachePaths>,
}

/// Whether the renderer is there; one that the project names and the user does not trust is an error.
pub fn is_there(driver: &'static Driver, project: &Project, timeout: Duration) -> Result<bool, Failure> {
    project.program(driver.name)?;
    Ok(Runner::find(driver, None, Some(project), Some(timeout)).is_ok())
}

/// Whether the renderer lacks the algorithm that the scene asks for.
pub fn lacks(driver: &Driver, scene: &Scene) -> Result<bool, Failure> {
    let target = project::target(driver.target)?;
    Ok(matches!((target.supports)(algorithm(&scene.integrator).0), Support::Unsupported { why: _ }))
}

impl Runner {
    /// Finds the renderer: what is `given`, what the project names, an installation, or one on the path.
    /// It answers within `timeout`, which each image also has.
    pub fn find(
        driver: &'static Driver,
        given: Option<&Path>,
        project: Option<&Project>,
        timeout: Option<Duration>,
    ) -> Result<Self, Failure> {
        let env = Env::of_process();
        let cache = CachePaths::find(&env);
        let configured = match project.filter(|_| given.is_none()) {
            Some(project) => project.program(driver.name)?,
            None => None,
        };
        let until = timeout.map(|timeout| Instant::now() + timeout);
        let search = Search { env: &env, cache: cache.as_ref(), given, configured, until };
        let found = find(driver, &search).map_err(|error| failure(&error))?;
        Ok(Self { driver, found, threads: None, timeout, env, cache })
    }
}

/// A scene as it was written for a renderer, in a folder that goes with it.
pub struct Job<'r> {
    runner: &'r Runner,
    work: Folder,
    scene: String,
    size: (usize, usize),
    /// Of everything that was written for the renderer.
    content: blake3::Hash,
}

impl<'r> Job<'r> {
    /// Emits the scene, seen by its first camera, and reads it back; a file that says something else than the scene is refused.
    pub fn new(scene: &Valid, runner: &'r Runner) -> Result<Self, Failure> {
        let target = project::target(runner.driver.target)?;
        let work = Folder::new().map_err(|error| no_temporary(&error))?;
        let camera = pipeline::camera(scene, None)
            .ok_or_else(|| Failure::new(Exit::Fault, format!("the scene `{}` lost its camera", scene.name)))?;
        let failed = |error: std::io::Error| unwritable(work.path(), &error);
        let mut sink = DiskSink::own(work.path(), &scene.name);
        pipeline::emit_alone(scene, camera, target, &Ledger::of(scene, target, &[]), &Choices::default(), &mut sink)
            .map_err(failed)?;
        if let Some(wrong) = pipeline::audit(scene, camera, &[target], &sink, |_| String::new()).findings().next() {
            let message = format!("{}: {} for {}", scene.name, wrong.message, target.name);
            return Err(Failure::new(Exit::Fault, message)
                .help("ltsc wrote something else than the scene says: please report it with the scene"));
        }
        // The ledger is for people.
        let content = sink.content(|path| path != ledger::FILE);
        sink.finish().map_err(failed)?;
        let size = (scene.film.width as usize, scene.film.height as usize);
        Ok(Self { runner, work, scene: scene.name.clone(), size, content })
    }

    /// A hash of everything that decides how the image looks: files, renderer, version, samples and seed.
    pub fn key(&self, samples: u32, seed: u32) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.content.as_bytes());
        let Runner { driver, found, .. } = self.runner;
        hasher.update(format!("{} {:?} {samples} {seed}", driver.name, found.version).as_bytes());
        hasher.finalize().to_hex().to_string()
    }

    /// Renders it.
    pub fn render(&self, samples: u32, seed: u32, progress: &mut dyn FnMut(Progress)) -> Result<Rendered, RenderError> {
        let Runner { driver, found, threads, timeout, env, cache } = self.runner;
        let request = RenderRequest {
            executable: Some(found.path.clone()),
            env: env.clone(),
            cache: cache.clone(),
            main_file: driver.main_file.replace("SCENE", &self.scene),
            samples,
            seed,
            threads: *threads,
            timeout: *timeout,
            ..RenderRequest::new(driver, self.work.path().to_path_buf(), self.size, self.work.path().join("log"))
        };
        render(&request, &mut |news| progress(news))
    }
}
