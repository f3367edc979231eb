//! Carries a request out: finds the program, runs it, and gathers the image.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Deserialize;

use super::process::{End, Lines, Patience, begin, run, tail};
use super::{
    Asked, Delivery, Driver, Job, Plan, Progress, RenderError, RenderRequest, Rendered, Said, Search, call, find,
};
use crate::guard;
use crate::image::{Image, read};

/// Renders one image. The renderer's processes have ended when this returns, however it does.
///
/// # Errors
/// Gives an error if the renderer is missing, fails, takes too long, is cancelled, or leaves no
/// image of the right size.
pub fn render(request: &RenderRequest, progress: &mut dyn FnMut(Progress)) -> Result<Rendered, RenderError> {
    let Ready { request, executable, version, scratch, plan, until } = prepare(request)?;
    let request = &request;
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| RenderError::Io { path, source }
    };
    let log = std::path::absolute(&request.log).map_err(io(&request.log))?;
    let driver = request.driver;
    let Plan { command, delivery, above, mut facts } = plan;
    let defects: Vec<&str> = driver.defects_of(&request.features).collect();
    if !defects.is_empty() {
        facts.push(("defects".to_owned(), defects.join("; ")));
    }
    begin(&log).map_err(io(&log))?;
    let mut gathered = Gathered { version, ..Gathered::default() };
    let mut watch = Watch::new(u64::from(request.samples));
    if !gathered.version.is_empty() && !matches!(delivery, Delivery::Events) {
        progress(Progress::Started { version: gathered.version.clone() });
    }
    let patience = Patience { until, cancel: request.cancel.as_deref() };
    let lines = if matches!(delivery, Delivery::Events) { Lines::Events } else { Lines::All };
    let ended = run(command, &log, lines, patience, &mut |line| match &delivery {
        Delivery::Events => gathered.take(line, scratch.path(), progress),
        Delivery::File(_, listener) => {
            if let Some(said) = listener(line) {
                watch.take(said, progress);
            }
        }
    });
    let (end, usage) = ended.map_err(io(&executable))?;
    judge(request, end, &gathered, &log)?;
    let wall_seconds = watch.start.elapsed().as_secs_f64();
    let (image, samples_done, seconds) = match delivery {
        Delivery::Events => {
            let (samples, seconds) = (gathered.samples, gathered.seconds.unwrap_or(wall_seconds));
            (gathered.take_image(driver, &log)?, samples, seconds)
        }
        Delivery::File(path, _) => {
            if !path.exists() {
                return Err(no_image(driver, "left no image".to_owned(), &log));
            }
            if gathered.version.is_empty() && request.call.is_none() {
                gathered.version = (driver.probe)(Asked { program: &executable, until }).unwrap_or_default();
            }
            (without_rows(read(&path)?.0, above), u64::from(request.samples), watch.took())
        }
    };
    if (image.width, image.height) != (request.width, request.height) {
        let message = wrong_size((image.width, image.height), (request.width, request.height));
        return Err(no_image(driver, message, &log));
    }
    Ok(Rendered {
        image,
        seconds,
        wall_seconds,
        renderer_version: gathered.version,
        samples_done,
        executable,
        log_path: log,
        usage,
        facts,
    })
}

/// A request whose program is known, with what is to be run.
struct Ready {
    /// As the driver understands it.
    request: RenderRequest,
    executable: PathBuf,
    version: String,
    /// What the plan has written lies there.
    scratch: guard::Folder,
    plan: Plan,
    until: Option<Instant>,
}

/// Whether a request is one that its renderer can carry out, as far as that is known before it starts: seeds that it does not have,
/// parameters that the files lack, options that it does not take. Nothing is run but what finds the program.
///
/// # Errors
/// What [`render`] would say.
pub fn refuse(request: &RenderRequest) -> Result<(), RenderError> {
    prepare(request).map(|_| ())
}

fn prepare(request: &RenderRequest) -> Result<Ready, RenderError> {
    if request.samples == 0 || request.threads == Some(0) {
        return Err(RenderError::Request {
            message: "there must be at least one sample and one thread".to_owned(),
            hint: "ask for 1 or more".to_owned(),
        });
    }
    let request = call::understood(request);
    let until = request.timeout.map(|timeout| Instant::now() + timeout);
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| RenderError::Io { path, source }
    };
    let folder = std::path::absolute(&request.folder).map_err(io(&request.folder))?;
    let main = folder.join(&request.main_file);
    if !main.is_file() {
        return Err(RenderError::Request {
            message: format!("`{}` is not there", main.display()),
            hint: format!("emit the scene for the target `{}` first", request.driver.target),
        });
    }
    let search = |given| Search { env: &request.env, cache: request.cache.as_ref(), given, configured: None, until };
    let driver = request.driver;
    let (executable, version) = match &request.executable {
        Some(path) if !driver.asks_named || request.call.is_some() => {
            (std::path::absolute(path).map_err(io(path))?, String::new())
        }
        given => {
            let found = find(driver, &search(given.as_deref())).map_err(|error| in_time(&request, until, error))?;
            (found.path, found.version)
        }
    };
    let scratch = guard::Folder::new().map_err(io(&std::env::temp_dir()))?;
    let plan = {
        let job =
            Job { request: &request, executable: &executable, folder: &folder, main: &main, scratch: scratch.path() };
        call::plan(&job)?
    };
    Ok(Ready { request, executable, version, scratch, plan, until })
}

/// The image without its first rows, all of which it has.
fn without_rows(mut image: Image, rows: usize) -> Image {
    let rows = rows.min(image.height);
    image.pixels.drain(..rows * image.width);
    image.height -= rows;
    image
}

/// Why no renderer was found: where the time was over, that it did not answer in time.
fn in_time(request: &RenderRequest, until: Option<Instant>, error: RenderError) -> RenderError {
    if until.is_none_or(|until| Instant::now() < until) {
        return error;
    }
    let after = request.timeout.unwrap_or_default();
    RenderError::TimedOut { driver: request.driver.name, after, tail: error.tail().to_vec(), log: request.log.clone() }
}

/// What is wrong with an image that is not as large as the scene says.
pub(super) fn wrong_size(found: (usize, usize), wanted: (usize, usize)) -> String {
    format!("gave an image of {}x{} pixels instead of {}x{}", found.0, found.1, wanted.0, wanted.1)
}

/// The time of a run, and what its output says of it.
struct Watch {
    samples: u64,
    start: Instant,
    /// The rendering time as the program tells it.
    said: Option<f64>,
    /// When it had loaded the scene.
    loaded: Option<Instant>,
    /// The samples and the time that were told last.
    told: Option<(u64, Instant)>,
}

/// The shortest time between two pieces of news: some programs write hundreds of lines in it.
const NEWS: Duration = Duration::from_millis(100);

impl Watch {
    fn new(samples: u64) -> Self {
        Self { samples, start: Instant::now(), said: None, loaded: None, told: None }
    }

    /// The rendering time; a program that does not tell its time took all of it, or all since it had loaded the scene.
    fn took(&self) -> f64 {
        self.said.unwrap_or_else(|| self.loaded.unwrap_or(self.start).elapsed().as_secs_f64())
    }

    fn take(&mut self, said: Said, progress: &mut dyn FnMut(Progress)) {
        let part = match said {
            Said::Took(seconds) => {
                self.said = Some(seconds);
                1.0
            }
            Said::Part(part) => part.clamp(0.0, 1.0),
        };
        let now = Instant::now();
        if self.loaded.is_none() {
            self.loaded = Some(now);
            progress(Progress::Loaded { seconds: (now - self.start).as_secs_f64() });
        }
        let done = (part * self.samples as f64) as u64;
        let news = match self.told {
            Some((before, when)) => done > before && (now - when >= NEWS || done == self.samples),
            None => true,
        };
        if news {
            self.told = Some((done, now));
            let seconds = (now - self.start).as_secs_f64();
            progress(Progress::Samples { done, total: self.samples, seconds });
        }
    }
}

/// Turns every end but a good one into an error.
fn judge(request: &RenderRequest, end: End, gathered: &Gathered, log: &Path) -> Result<(), RenderError> {
    let driver = request.driver;
    match end {
        End::Exited(status) => {
            let confessed = confession(driver, log);
            if status.success() && confessed.is_none() {
                return Ok(());
            }
            let missing =
                [("No module named", "this Python lacks the renderer; `ltsc renderers install` makes a private copy")];
            let hints: Vec<_> = missing.iter().chain(driver.hints).copied().collect();
            let message = gathered.message.clone().or(confessed);
            Err(RenderError::failed(driver.name, &hints, status, message, log))
        }
        End::TimedOut => Err(RenderError::TimedOut {
            driver: driver.name,
            after: request.timeout.unwrap_or_default(),
            tail: tail(log, super::error::TAIL),
            log: log.to_owned(),
        }),
        End::Cancelled => Err(RenderError::Cancelled),
    }
}

/// The first line near the end of the log by which the driver's program tells that it has failed.
fn confession(driver: &Driver, log: &Path) -> Option<String> {
    if driver.failures.is_empty() {
        return None;
    }
    let told = |line: &String| driver.failures.iter().any(|text| line.contains(text));
    tail(log, super::error::CAUSES).into_iter().find(told)
}

fn no_image(driver: &'static Driver, message: String, log: &Path) -> RenderError {
    RenderError::NoImage { driver: driver.name, message, tail: tail(log, super::error::TAIL), log: log.to_owned() }
}

/// What scripts say; see `prelude.py`.
#[derive(Deserialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event {
    Version { version: String },
    Loaded { seconds: f64 },
    Progress { done: u64, total: u64, seconds: f64 },
    Pass { samples: u64, done: u64, total: u64, file: String, seconds: f64 },
    Done { seconds: f64 },
    Error { message: String },
}

/// What has come of a run so far.
#[derive(Default)]
struct Gathered {
    version: String,
    message: Option<String>,
    seconds: Option<f64>,
    samples: u64,
    /// Width, height and the sum of all passes, each times its samples.
    sum: Option<(usize, usize, Vec<[f64; 3]>)>,
    /// The first thing that went wrong with a pass.
    fault: Option<RenderError>,
    /// An event that makes no sense.
    strange: Option<String>,
}

impl Gathered {
    fn take(&mut self, line: &str, scratch: &Path, progress: &mut dyn FnMut(Progress)) {
        match serde_json::from_str(line) {
            Ok(Event::Version { version }) => {
                self.version.clone_from(&version);
                progress(Progress::Started { version });
            }
            Ok(Event::Loaded { seconds }) => progress(Progress::Loaded { seconds }),
            Ok(Event::Progress { done, total, seconds }) => {
                progress(Progress::Samples { done, total, seconds });
            }
            Ok(Event::Pass { samples, done, total, file, seconds }) => {
                self.add(&scratch.join(file), samples);
                progress(Progress::Samples { done, total, seconds });
            }
            Ok(Event::Done { seconds }) => self.seconds = Some(seconds),
            Ok(Event::Error { message }) => self.message = Some(message),
            Err(_) => self.strange = Some(line.chars().take(200).collect()),
        }
    }

    /// Adds a pass in double precision and deletes its file.
    fn add(&mut self, path: &PathBuf, samples: u64) {
        if self.fault.is_some() {
            return;
        }
        let image = match read(path) {
            Ok((image, _)) => image,
            Err(error) => {
                self.fault = Some(error.into());
                return;
            }
        };
        // The whole folder goes in the end, so a file that stays costs only space.
        let _ = std::fs::remove_file(path);
        let size = (image.width, image.height);
        let (width, height, sum) = self.sum.get_or_insert_with(|| (size.0, size.1, vec![[0.0; 3]; image.pixels.len()]));
        if (*width, *height) != size {
            self.strange = Some("passes of different sizes".to_owned());
            return;
        }
        let weight = samples as f64;
        for (total, pixel) in sum.iter_mut().zip(&image.pixels) {
            for (total, value) in total.iter_mut().zip(pixel) {
                *total += weight * f64::from(*value);
            }
        }
        self.samples += samples;
    }

    /// The mean over all passes.
    fn take_image(&mut self, driver: &'static Driver, log: &Path) -> Result<Image, RenderError> {
        if let Some(fault) = self.fault.take() {
            return Err(fault);
        }
        if let Some(strange) = self.strange.take() {
            return Err(no_image(driver, format!("said something strange: {strange}"), log));
        }
        // Without the last event the script has not come to its end, whatever its exit code.
        let (Some((width, height, sum)), Some(_)) = (self.sum.take(), self.seconds) else {
            return Err(no_image(driver, "left no image".to_owned(), log));
        };
        if self.samples == 0 {
            return Err(no_image(driver, "took no samples".to_owned(), log));
        }
        let share = 1.0 / self.samples as f64;
        let pixels = sum.into_iter().map(|total| total.map(|value| (value * share) as f32)).collect();
        Ok(Image { width, height, pixels })
    }
}

#[cfg(all(test, unix))]
#[path = "render_tests.rs"]
mod tests;

#[cfg(all(test, unix))]
#[path = "program_tests.rs"]
mod programs;
