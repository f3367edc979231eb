//! Carries a request out: finds the program, runs it, and gathers the image.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Deserialize;

use super::process::{End, Lines, Patience, run, tail};
use super::{Delivery, Driver, Job, Plan, Progress, RenderError, RenderRequest, Rendered, Search, find};
use crate::image::{Image, read};

/// Renders one image. The renderer's processes have ended when this returns, however it does.
///
/// # Errors
/// Gives an error if the renderer is missing, fails, takes too long, is cancelled, or leaves no
/// image of the right size.
pub fn render(request: &RenderRequest, progress: &mut dyn FnMut(Progress)) -> Result<Rendered, RenderError> {
    if request.samples == 0 || request.threads == Some(0) {
        return Err(RenderError::Request {
            message: "there must be at least one sample and one thread".to_owned(),
            hint: "ask for 1 or more".to_owned(),
        });
    }
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| RenderError::Io { path, source }
    };
    let absolute = |path: &Path| std::path::absolute(path).map_err(io(path));
    let (folder, log) = (absolute(&request.folder)?, absolute(&request.log)?);
    let main = folder.join(&request.main_file);
    if !main.is_file() {
        return Err(RenderError::Request {
            message: format!("`{}` is not there", main.display()),
            hint: format!("emit the scene for the target `{}` first", request.driver.target),
        });
    }
    // A named executable is used without a question, since asking costs a start each time.
    let (executable, version) = match &request.executable {
        Some(path) => (absolute(path)?, String::new()),
        None => {
            let search = Search { env: &request.env, cache: request.cache.as_ref(), given: None, configured: None };
            let found = find(request.driver, &search)?;
            (found.path, found.version)
        }
    };
    let scratch = tempfile::Builder::new().prefix("ltsc-render-").tempdir().map_err(io(&std::env::temp_dir()))?;
    let job = Job { request, executable: &executable, folder: &folder, main: &main, scratch: scratch.path() };
    let Plan { command, delivery } = (request.driver.plan)(&job)?;
    let lines = match delivery {
        Delivery::Events => Lines::Events,
        Delivery::File(_) => Lines::All,
    };
    let mut gathered = Gathered { version, ..Gathered::default() };
    let patience = Patience { timeout: request.timeout, cancel: request.cancel.as_deref() };
    let start = Instant::now();
    let end = run(command, &log, lines, patience, &mut |line| {
        if lines == Lines::Events {
            gathered.take(line, scratch.path(), progress);
        }
    })
    .map_err(io(&executable))?;
    let wall_seconds = start.elapsed().as_secs_f64();
    judge(request, end, &gathered, &log)?;
    let driver = request.driver;
    let (image, samples_done, seconds) = match delivery {
        Delivery::Events => {
            let seconds = gathered.seconds.unwrap_or(wall_seconds);
            let samples = gathered.samples;
            (gathered.take_image(driver, &log)?, samples, seconds)
        }
        Delivery::File(path) => {
            if !path.exists() {
                return Err(no_image(driver, "left no image".to_owned(), &log));
            }
            if gathered.version.is_empty() {
                gathered.version = (driver.probe)(&executable).unwrap_or_default();
            }
            (read(&path)?.0, u64::from(request.samples), wall_seconds)
        }
    };
    if (image.width, image.height) != (request.width, request.height) {
        let message = format!(
            "gave an image of {}x{} pixels instead of {}x{}",
            image.width, image.height, request.width, request.height
        );
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
    })
}

/// Turns every end but a good one into an error.
fn judge(request: &RenderRequest, end: End, gathered: &Gathered, log: &Path) -> Result<(), RenderError> {
    let driver = request.driver;
    match end {
        End::Exited(status) if status.success() => Ok(()),
        End::Exited(status) => {
            let missing =
                [("No module named", "this Python lacks the renderer; `ltsc renderers install` makes a private copy")];
            let hints: Vec<_> = missing.iter().chain(driver.hints).copied().collect();
            let message = gathered.message.clone();
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
