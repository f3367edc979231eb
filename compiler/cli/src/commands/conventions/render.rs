//! An image of a view by a renderer.

use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::formats::Choices;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::run::{Driver, Found, RenderError, RenderRequest, Rendered, Search, find, render};

use crate::disk::DiskSink;
use crate::output::{Exit, Failure};
use crate::project;

use super::super::render::failure;

/// A renderer and how it is to be run.
pub struct Runner {
    pub driver: &'static Driver,
    pub found: Found,
    pub threads: usize,
    pub timeout: Duration,
    env: Env,
    cache: Option<CachePaths>,
}

impl Runner {
    /// Finds the renderer: what is `given`, what is `configured`, an installation, or one on the path.
    pub fn find(
        driver: &'static Driver,
        given: Option<&Path>,
        configured: Option<&Path>,
        threads: usize,
        timeout: Duration,
    ) -> Result<Self, Failure> {
        let env = Env::of_process();
        let cache = CachePaths::find(&env);
        let search = Search { env: &env, cache: cache.as_ref(), given, configured };
        let found = find(driver, &search).map_err(|error| failure(&error))?;
        Ok(Self { driver, found, threads, timeout, env, cache })
    }

    /// Emits the scene into a folder that is gone afterwards, and renders it with so many samples per pixel.
    pub fn image(&self, scene: &Valid, samples: u32) -> Result<Result<Rendered, RenderError>, Failure> {
        let target = project::target(self.driver.target)?;
        let failed = |error: std::io::Error| Failure::new(Exit::Environment, format!("no temporary folder: {error}"));
        let work = tempfile::Builder::new().prefix("ltsc-conventions-").tempdir().map_err(failed)?;
        let camera = pipeline::camera(scene, None)
            .ok_or_else(|| Failure::new(Exit::Fault, format!("the scene `{}` lost its camera", scene.name)))?;
        let mut sink = DiskSink::new(work.path(), &scene.name, false, false).map_err(failed)?;
        pipeline::emit_alone(scene, camera, target, &Ledger::of(scene, target, &[]), &Choices::default(), &mut sink)
            .map_err(failed)?;
        sink.finish().map_err(failed)?;
        let size = (scene.film.width as usize, scene.film.height as usize);
        let log: PathBuf = work.path().join("log");
        let request = RenderRequest {
            executable: Some(self.found.path.clone()),
            env: self.env.clone(),
            cache: self.cache.clone(),
            main_file: self.driver.main_file.replace("SCENE", &scene.name),
            samples,
            seed: scene.sampler.seed(),
            threads: Some(self.threads),
            timeout: Some(self.timeout),
            ..RenderRequest::new(self.driver, work.path().to_path_buf(), size, log)
        };
        Ok(render(&request, &mut |_| {}))
    }
}
