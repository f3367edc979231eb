//! One image of a scene by a renderer: emitted into a folder of its own, read back, rendered. The same for every command that
//! renders scenes of its own accord, and known by its content: what was written for the renderer, and how it is asked to render.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ltsc_core::capability::{Support, algorithm};
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ir::{Camera, Handle, Scene};
use ltsc_core::ledger::{self, Ledger};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::guard::Folder;
use ltsc_render::run::{
    DRIVERS, Driver, Found, Progress, RenderError, RenderRequest, Rendered, Search, Source, driver, find, render,
};

use crate::disk::{DiskSink, Manifest, no_temporary, unwritable};
use crate::failure::{Exit, Failure, why};

/// A renderer that is there, and how it is to be run.
pub struct Runner {
    /// The driver.
    pub driver: &'static Driver,
    /// Its program.
    pub found: Found,
    /// All processors if none.
    pub threads: Option<usize>,
    /// The longest time for one image.
    pub timeout: Option<Duration>,
    /// The environment in which it runs.
    pub env: Env,
    /// Where installations are.
    pub cache: Option<CachePaths>,
}

/// The driver called `name`.
///
/// # Errors
/// Usage, with the nearest name.
pub fn driver_called(name: &str) -> Result<&'static Driver, Failure> {
    if name.contains(',') {
        return Err(Failure::new(
            Exit::Usage,
            format!("`--renderer {name}` names several renderers, and one image comes from one"),
        )
        .help("render once for each, or compare them by `ltsc agree`"));
    }
    driver(name).ok_or_else(|| {
        let known: Vec<&str> = DRIVERS.iter().map(|driver| driver.name).collect();
        let failure = Failure::new(Exit::Usage, format!("there is no renderer `{name}`"));
        match ltsc_core::diag::nearest(name, known.iter().copied()) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help(format!("known: {}", known.join(", "))),
        }
    })
}

/// The target whose files a renderer reads.
#[must_use]
pub fn target_of(driver: &Driver) -> &'static Target {
    // A test compares the tables.
    formats::find(driver.target).unwrap_or_else(|| unreachable!("{} reads no target", driver.name))
}

/// Whether the renderer lacks the algorithm that the scene asks for.
#[must_use]
pub fn lacks(driver: &Driver, scene: &Scene) -> bool {
    matches!((target_of(driver).supports)(algorithm(&scene.integrator).0), Support::Unsupported { why: _ })
}

impl Runner {
    /// A program that is not asked for its version before it renders, because it takes a second to answer. What it renders is not known by
    /// its version, so that nothing of it is to be kept.
    #[must_use]
    pub fn unasked(driver: &'static Driver, program: &Path, timeout: Option<Duration>) -> Self {
        let env = Env::of_process();
        let cache = CachePaths::find(&env);
        let found = Found { path: program.to_path_buf(), version: String::new(), source: Source::Given };
        Self { driver, found, threads: None, timeout, env, cache }
    }

    /// Finds the renderer: what is `given`, what is `configured`, an installation, or one on the path.
    /// It answers within `timeout`, which each image also has.
    ///
    /// # Errors
    /// Where none is there, or what is named is none.
    pub fn find(
        driver: &'static Driver,
        given: Option<&Path>,
        configured: Option<&Path>,
        timeout: Option<Duration>,
    ) -> Result<Self, Failure> {
        let env = Env::of_process();
        let cache = CachePaths::find(&env);
        let until = timeout.map(|timeout| Instant::now() + timeout);
        let search = Search { env: &env, cache: cache.as_ref(), given, configured, until };
        let found = find(driver, &search).map_err(|error| {
            let over = timeout.filter(|_| until.is_some_and(|until| Instant::now() >= until));
            match over {
                // It would have answered that it is there.
                Some(after) => Failure::of_renderer(&RenderError::TimedOut {
                    driver: driver.name,
                    after,
                    tail: error.tail().to_vec(),
                    log: PathBuf::new(),
                }),
                None => Failure::of_renderer(&error),
            }
        })?;
        Ok(Self { driver, found, threads: None, timeout, env, cache })
    }
}

/// How a scene is written for a renderer.
#[derive(Default)]
pub struct Writing<'a> {
    /// The camera; the first one if none is said.
    pub camera: Option<Handle<Camera>>,
    /// What the target does only where it is asked for.
    pub choices: Choices,
    /// What becomes of the scene for the target, with what its reader has lost; that of the scene alone if nothing is said.
    pub ledger: Option<&'a Ledger>,
}

/// A hash of what a scene is for a target: [`Job::content`] without a renderer.
///
/// # Errors
/// As of [`Job::new`].
pub fn content(scene: &Valid, target: &'static Target, writing: &Writing<'_>) -> Result<String, Failure> {
    write(scene, target, writing).map(|(_, content)| content.to_hex().to_string())
}

/// Writes a scene for a target into a folder of its own, and reads it back.
fn write(scene: &Valid, target: &'static Target, writing: &Writing<'_>) -> Result<(Folder, blake3::Hash), Failure> {
    let work = Folder::new().map_err(|error| no_temporary(&error))?;
    let camera = writing
        .camera
        .or_else(|| pipeline::camera(scene, None))
        .ok_or_else(|| Failure::new(Exit::Fault, format!("the scene `{}` lost its camera", scene.name)))?;
    let failed = |error: std::io::Error| unwritable(work.path(), &error);
    let mut sink = DiskSink::own(work.path(), &scene.name);
    let own;
    let ledger = match writing.ledger {
        Some(ledger) => ledger,
        None => {
            own = Ledger::of(scene, target, &[]);
            &own
        }
    };
    pipeline::emit_alone(scene, camera, target, ledger, &writing.choices, &mut sink).map_err(failed)?;
    if let Some(wrong) = pipeline::audit(scene, camera, &[target], &sink, |_| String::new()).findings().next() {
        let message = format!("{}: {} for {}", scene.name, wrong.message, target.name);
        return Err(Failure::new(Exit::Fault, message)
            .help("ltsc wrote something else than the scene says: please report it with the scene"));
    }
    // The ledger is for people.
    let content = sink.content(|path| path != ledger::FILE);
    sink.finish().map_err(failed)?;
    Ok((work, content))
}

/// A scene as it was written for a renderer, in a folder that goes with it, or in one that was there.
pub struct Job<'r> {
    runner: &'r Runner,
    folder: PathBuf,
    /// Where logs go: what was written for the renderer if it is of this job alone.
    work: Folder,
    scene: String,
    size: (usize, usize),
    /// Of everything that was written for the renderer.
    content: blake3::Hash,
}

impl<'r> Job<'r> {
    /// Emits the scene, seen by its first camera, and reads it back; a file that says something else than the scene is refused.
    ///
    /// # Errors
    /// Where no folder can be written, or what was written is wrong.
    pub fn new(scene: &Valid, runner: &'r Runner) -> Result<Self, Failure> {
        Self::written(scene, runner, &Writing::default())
    }

    /// The same, written as is asked.
    ///
    /// # Errors
    /// As of [`Job::new`].
    pub fn written(scene: &Valid, runner: &'r Runner, writing: &Writing<'_>) -> Result<Self, Failure> {
        let (work, content) = write(scene, target_of(runner.driver), writing)?;
        let size = (scene.film.width as usize, scene.film.height as usize);
        Ok(Self { runner, folder: work.path().to_owned(), work, scene: scene.name.clone(), size, content })
    }

    /// One that was written before, into a folder that stays; each file is compared with what its manifest says.
    ///
    /// # Errors
    /// Where a file is missing or another one.
    pub fn there(folder: &Path, size: (usize, usize), runner: &'r Runner) -> Result<Self, Failure> {
        let wrong =
            |error: std::io::Error| Failure::new(Exit::Environment, format!("{}: {}", folder.display(), why(&error)));
        let manifest = Manifest::verified(folder).map_err(wrong)?;
        let content = manifest.content(|path| path != ledger::FILE);
        let work = Folder::new().map_err(|error| no_temporary(&error))?;
        Ok(Self { runner, folder: folder.to_owned(), work, scene: manifest.scene, size, content })
    }

    /// The scene's name.
    #[must_use]
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// The renderer.
    #[must_use]
    pub fn runner(&self) -> &'r Runner {
        self.runner
    }

    /// Width and height of the image.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// The folder of what was written, as long as this is there.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A hash of everything that was written for the renderer, whichever version of it there is.
    #[must_use]
    pub fn content(&self) -> String {
        self.content.to_hex().to_string()
    }

    /// A hash of everything that decides how the image looks but for samples and seed: files, renderer and version.
    #[must_use]
    pub fn identity(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.content.as_bytes());
        let Runner { driver, found, .. } = self.runner;
        hasher.update(format!("{} {:?}", driver.name, found.version).as_bytes());
        hasher.finalize().to_hex().to_string()
    }

    /// A hash of everything that decides how the image looks: files, renderer, version, samples and seed.
    #[must_use]
    pub fn key(&self, samples: u32, seed: u32) -> String {
        let text = format!("{} {samples} {seed}", self.identity());
        blake3::hash(text.as_bytes()).to_hex().to_string()
    }

    /// Renders it.
    ///
    /// # Errors
    /// What the renderer says.
    pub fn render(&self, samples: u32, seed: u32, progress: &mut dyn FnMut(Progress)) -> Result<Rendered, RenderError> {
        self.render_logged(samples, seed, &self.work.path().join("log"), progress)
    }

    /// The same, with the renderer's whole output in `log`.
    ///
    /// # Errors
    /// What the renderer says.
    pub fn render_logged(
        &self,
        samples: u32,
        seed: u32,
        log: &Path,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Rendered, RenderError> {
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
            ..RenderRequest::new(driver, self.folder.clone(), self.size, log.to_path_buf())
        };
        render(&request, &mut |news| progress(news))
    }
}
