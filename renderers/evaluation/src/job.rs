//! One image of a scene by a renderer: emitted into a folder of its own, read back, rendered. The same for every command that
//! renders scenes of its own accord, and known by its content: what was written for the renderer, and how it is asked to render.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ltsc_core::capability::{self, Support, algorithm};
use ltsc_core::formats::effective::Effective;
use ltsc_core::formats::statements::{self, Statements};
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ir::{Camera, Handle, Integrator, Scene};
use ltsc_core::ledger::{self, Ledger};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::guard::Folder;
use ltsc_render::run::{
    DRIVERS, Driver, Found, Progress, RenderError, RenderRequest, Rendered, Search, Source, driver, find, is_python,
    refuse, render,
};

use crate::command::Command;
use crate::compare::verdict::Stated;
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
    /// Further arguments of the program.
    pub options: Vec<String>,
    /// How the program is called, where that is not the driver's affair.
    pub command: Option<Command>,
    /// What tells a program that may change without changing its version: the beginning of a hash of its file. None of installations of
    /// our own and of a Python.
    pub mark: Option<String>,
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

/// What a renderer's target states of a scene with a number: by how much its light may be off.
#[must_use]
pub fn stated(scene: &Scene, driver: &Driver) -> Vec<Stated> {
    let ledger = Ledger::of(scene, target_of(driver), &[]);
    let here = ledger.approximated.iter().filter_map(|one| {
        let share = one.here.as_ref()?.at_most;
        (share > 0.0).then(|| Stated { by: driver.name.to_owned(), what: one.what.to_owned(), share })
    });
    here.collect()
}

impl Runner {
    /// A program that is not asked for its version before it renders, because it takes a second to answer. What it renders is not known by
    /// its version, so that nothing of it is to be kept.
    #[must_use]
    pub fn unasked(driver: &'static Driver, program: &Path, timeout: Option<Duration>) -> Self {
        let env = Env::of_process();
        let cache = CachePaths::find(&env);
        let found = Found { path: program.to_path_buf(), version: String::new(), source: Source::Given };
        Self { driver, found, threads: None, timeout, env, cache, options: Vec::new(), command: None, mark: None }
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
        let ours = found.source == Source::Installed || is_python(&found.path);
        let mark = if ours { None } else { Some(content_of(&found.path)?) };
        Ok(Self { driver, found, threads: None, timeout, env, cache, options: Vec::new(), command: None, mark })
    }
}

impl Runner {
    /// Nothing that is run: files are written for it, and somebody else renders them.
    #[must_use]
    pub fn manual(driver: &'static Driver) -> Self {
        let env = Env::of_process();
        let found = Found { path: PathBuf::new(), version: String::new(), source: Source::Given };
        let (cache, options) = (CachePaths::find(&env), Vec::new());
        Self { driver, found, threads: None, timeout: None, env, cache, options, command: None, mark: None }
    }

    /// A program that is called by a command: what is `given`, or found for the driver. It is not asked for its version; what tells one from
    /// another is the content of its file.
    ///
    /// # Errors
    /// Where it is not there.
    pub fn called(
        driver: &'static Driver,
        command: Command,
        given: Option<&Path>,
        timeout: Option<Duration>,
    ) -> Result<Self, Failure> {
        let env = Env::of_process();
        let path = match given {
            Some(given) => located(given, &env)?,
            None if command.uses("exe") => Self::find(driver, None, None, timeout)?.found.path,
            // The first word names it.
            None => {
                let first = command.fill(&[], |_| String::new()).into_iter().next().unwrap_or_default();
                located(Path::new(&first), &env)?
            }
        };
        let mark = Some(content_of(&path)?);
        let found = Found { path, version: String::new(), source: Source::Given };
        let (cache, command) = (CachePaths::find(&env), Some(command));
        Ok(Self { driver, found, threads: None, timeout, env, cache, options: Vec::new(), command, mark })
    }
}

/// The program of a path, or of a bare name on the path of the system.
fn located(name: &Path, env: &Env) -> Result<PathBuf, Failure> {
    let bare = name.components().count() == 1;
    let on_path = || name.to_str().filter(|_| bare).and_then(|name| env.on_path(name).into_iter().next());
    let there = name.is_file().then(|| std::path::absolute(name).ok()).flatten();
    there.or_else(on_path).ok_or_else(|| {
        Failure::new(Exit::Environment, format!("`{}`: no such program", name.display()))
            .help("a relative path starts at the evaluation file; a bare name is looked up on the PATH")
    })
}

/// What tells one program from another that does not say its version: the beginning of a hash of its file.
fn content_of(program: &Path) -> Result<String, Failure> {
    let failed = |error: std::io::Error| {
        Failure::new(Exit::Environment, format!("`{}` cannot be read: {}", program.display(), why(&error)))
    };
    let mut hasher = blake3::Hasher::new();
    let (mut file, _) = ltsc_render::regular::open(program).map_err(failed)?;
    std::io::copy(&mut file, &mut hasher).map_err(failed)?;
    Ok(hasher.finalize().to_hex()[..12].to_owned())
}

/// How a scene is written for a renderer.
pub struct Writing<'a> {
    /// The camera; the first one if none is said.
    pub camera: Option<Handle<Camera>>,
    /// What the target does only where it is asked for.
    pub choices: Choices,
    /// What becomes of the scene for the target, with what its reader has lost; that of the scene alone if nothing is said.
    pub ledger: Option<&'a Ledger>,
    /// Statements of a test case, which `pipeline::take_statements` has looked at, in the place of the target's own.
    pub statements: &'a Statements,
}

impl Default for Writing<'_> {
    fn default() -> Self {
        Self { camera: None, choices: Choices::default(), ledger: None, statements: &statements::NONE }
    }
}

/// A hash of what a scene is for a target: [`Job::content`] without a renderer.
///
/// # Errors
/// As of [`Job::new`].
pub fn content(scene: &Valid, target: &'static Target, writing: &Writing<'_>) -> Result<String, Failure> {
    write(scene, target, writing).map(|written| written.content.to_hex().to_string())
}

/// A scene in a folder of its own: a hash of its files, what they mean, and the features that they use.
struct Written {
    work: Folder,
    content: blake3::Hash,
    effective: Option<Effective>,
    features: Vec<String>,
}

/// The features of a scene by their names, with the algorithm that its files really have.
fn used(scene: &Scene, effective: Option<&Effective>) -> Vec<String> {
    let own = algorithm(&scene.integrator).0;
    let native = effective.and_then(|effective| effective.algorithm);
    let native = native.and_then(|native| Integrator::of_word(native.family, scene.integrator.max_depth()));
    let of = native.map_or(own, |native| algorithm(&native).0);
    let all = capability::features(scene).into_iter().map(|(feature, _)| feature);
    all.map(|feature| if feature == own { of } else { feature }).map(|feature| feature.name().to_owned()).collect()
}

/// Writes a scene for a target into a folder of its own, and reads it back.
fn write(scene: &Valid, target: &'static Target, writing: &Writing<'_>) -> Result<Written, Failure> {
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
    let given = writing.statements;
    pipeline::emit_given(scene, camera, target, ledger, &writing.choices, given, &mut sink).map_err(failed)?;
    let audited = pipeline::audit_given(scene, camera, &[target], given, &sink, |_| String::new());
    if let Some(wrong) = audited.findings().next() {
        let message = format!("{}: {} for {}", scene.name, wrong.message, target.name);
        return Err(Failure::new(Exit::Fault, message)
            .help("ltsc wrote something else than the scene says: please report it with the scene"));
    }
    // The ledger is for people.
    let content = sink.content(|path| path != ledger::FILE);
    let effective = audited.targets.into_iter().next().map(|audit| audit.effective);
    let features = used(scene, effective.as_ref());
    sink.features(&features);
    sink.finish().map_err(failed)?;
    Ok(Written { work, content, effective, features })
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
    /// What the files mean, where the target has a reader and they were written here.
    effective: Option<Effective>,
    /// Names of the features that the scene uses.
    features: Vec<String>,
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
        let Written { work, content, effective, features } = write(scene, target_of(runner.driver), writing)?;
        let size = (scene.film.width as usize, scene.film.height as usize);
        Ok(Self {
            runner,
            folder: work.path().to_owned(),
            work,
            scene: scene.name.clone(),
            size,
            content,
            effective,
            features,
        })
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
        Ok(Self {
            runner,
            folder: folder.to_owned(),
            work,
            scene: manifest.scene,
            size,
            content,
            effective: None,
            features: manifest.features,
        })
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

    /// What the files mean; none where the target has no reader, or somebody else has written them.
    #[must_use]
    pub fn effective(&self) -> Option<&Effective> {
        self.effective.as_ref()
    }

    /// What the renderer is known to render otherwise of this scene.
    pub fn defects(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.runner.driver.defects_of(&self.features)
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
        let Runner { driver, found, options, command, mark, .. } = self.runner;
        hasher.update(format!("{} {:?}", driver.name, found.version).as_bytes());
        if let Some(mark) = mark {
            hasher.update(format!(" {mark}").as_bytes());
        }
        if !options.is_empty() || command.is_some() {
            let words = command.as_ref().map(Command::texts);
            hasher.update(format!(" {options:?} {words:?}").as_bytes());
        }
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
        render(&self.request(samples, seed, log), &mut |news| progress(news))
    }

    /// Whether the renderer can render an image of so many samples with this seed, as far as that is known before it starts.
    ///
    /// # Errors
    /// What it lacks.
    pub fn refuse(&self, samples: u32, seed: u32) -> Result<(), RenderError> {
        refuse(&self.request(samples, seed, &self.work.path().join("log")))
    }

    fn request(&self, samples: u32, seed: u32, log: &Path) -> RenderRequest {
        let Runner { driver, found, threads, timeout, env, cache, options, command, mark: _ } = self.runner;
        RenderRequest {
            executable: Some(found.path.clone()),
            env: env.clone(),
            cache: cache.clone(),
            main_file: driver.main_file.replace("SCENE", &self.scene),
            samples,
            seed,
            threads: *threads,
            timeout: *timeout,
            features: self.features.clone(),
            options: options.clone(),
            call: command.as_ref().map(|command| command.call(options)),
            ..RenderRequest::new(driver, self.folder.clone(), self.size, log.to_path_buf())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_renderers_do_wrong_is_told_by_features_that_there_are() {
        let known: Vec<&str> = capability::Feature::ALL.iter().map(|feature| feature.name()).collect();
        for driver in DRIVERS {
            for feature in driver.defects.iter().flat_map(|defect| defect.features) {
                assert!(known.contains(feature), "{}: `{feature}`", driver.name);
            }
        }
        assert_eq!(
            driver_called("pbrt-r3").expect("a driver").defects_of(&["a principled material".to_owned()]).count(),
            1
        );
        assert_eq!(driver_called("pbrt-r3").expect("a driver").defects_of(&["a mirror".to_owned()]).count(), 0);
    }
}
