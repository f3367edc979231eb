//! Programs that are called otherwise than by their drivers: with further arguments, or by words that their user gives.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use super::{Delivery, Driver, Installation, Job, Plan, RenderError, RenderRequest, Seeds};

/// The words of a command, made from what takes the place of `exe`, `out`, `scene`, `samples`, `seed` and `threads`.
type Words = dyn Fn(&dyn Fn(&str) -> String) -> Vec<String> + Send + Sync;

/// How a program is called.
#[derive(Clone)]
pub struct Call {
    /// Gives the words, the program's first; see [`Words`].
    pub words: Arc<Words>,
    /// Whether they say the seed; without it there is one image only.
    pub seeded: bool,
}

impl fmt::Debug for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Call").field("seeded", &self.seeded).finish_non_exhaustive()
    }
}

/// Targets whose files no renderer of ours reads, with their main files: programs that read them need a command.
const WITHOUT: [Driver; 2] = [row("gltf", "SCENE.gltf"), row("glb", "SCENE.glb")];

const fn row(target: &'static str, main_file: &'static str) -> Driver {
    Driver {
        name: target,
        aliases: &[],
        summary: "a program that is called by a command",
        target,
        main_file,
        version: "",
        installation: Installation::User { source: "wherever it comes from" },
        programs: &[],
        asks_named: false,
        test_scene: &[],
        wavelengths: None,
        seeds: Seeds::Free,
        least_samples: 1,
        defects: &[],
        failures: &[],
        hints: &[],
        probe: |_| Ok(String::new()),
        plan: |job| {
            Err(RenderError::Request {
                message: format!("no renderer of ltsc reads `{}`", job.request.driver.target),
                hint: "say how a program is called".to_owned(),
            })
        },
    }
}

/// What stands in for the driver of a target that none of ours reads.
#[must_use]
pub fn without_driver(target: &str) -> Option<&'static Driver> {
    WITHOUT.iter().find(|driver| driver.target == target)
}

/// The request as its driver is to see it: what the driver has a word of its own for is no option any more.
pub(super) fn understood(request: &RenderRequest) -> RenderRequest {
    let mut request = request.clone();
    if request.driver.name != "mitsuba-3" || request.call.is_some() {
        return request;
    }
    if let Some(at) = request.options.iter().position(|option| option == "-m" || option == "--mode")
        && at + 1 < request.options.len()
    {
        request.variant = Some(request.options.remove(at + 1));
        request.options.remove(at);
    }
    request
}

/// What to run: the driver's plan with the options of the request, or what the request says itself.
pub(super) fn plan(job: &Job<'_>) -> Result<Plan, RenderError> {
    if let Some(call) = &job.request.call {
        return called(job, call);
    }
    let mut plan = (job.request.driver.plan)(job)?;
    let options = &job.request.options;
    if options.is_empty() {
        return Ok(plan);
    }
    if matches!(plan.delivery, Delivery::Events) {
        let name = job.request.driver.name;
        let own = if name == "mitsuba-3" { "it takes `-m VARIANT` only" } else { "it takes none" };
        return Err(RenderError::Request {
            message: format!("{name} runs as a script of Python, which has no options `{}`", options.join(" ")),
            hint: format!("{own}; say the rest by parameters of the case, or name a program and its command"),
        });
    }
    plan.command = with_options(&plan.command, options);
    Ok(plan)
}

/// The same command with options before its other arguments.
fn with_options(command: &Command, options: &[String]) -> Command {
    let mut new = Command::new(command.get_program());
    new.args(options).args(command.get_args());
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => new.env(name, value),
            None => new.env_remove(name),
        };
    }
    if let Some(folder) = command.get_current_dir() {
        new.current_dir(folder);
    }
    new
}

fn called(job: &Job<'_>, call: &Call) -> Result<Plan, RenderError> {
    let request = job.request;
    if request.seed != 0 && !call.seeded {
        return Err(RenderError::Request {
            message: format!("the command has no `{{seed}}`, so that it cannot be {}", request.seed),
            hint: "add it, or leave the seed at 0 and ask for one chunk".to_owned(),
        });
    }
    let text = |path: &Path| {
        path.to_str().map(str::to_owned).ok_or_else(|| RenderError::Request {
            message: format!("the name `{}` is not Unicode", path.display()),
            hint: "rename the folder".to_owned(),
        })
    };
    let image: PathBuf = job.scratch.join("image.exr");
    let (exe, out, scene) = (text(job.executable)?, text(&image)?, text(job.main)?);
    let threads = request.threads.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    let words = (call.words)(&|name| match name {
        "exe" => exe.clone(),
        "out" => out.clone(),
        "scene" => scene.clone(),
        "samples" => request.samples.to_string(),
        "seed" => request.seed.to_string(),
        "threads" => threads.to_string(),
        _ => String::new(),
    });
    let mut words = words.into_iter();
    let Some(program) = words.next() else {
        let hint = "write for example `{exe} -o {out} {scene}`".to_owned();
        return Err(RenderError::Request { message: "the command is empty".to_owned(), hint });
    };
    let mut command = Command::new(program);
    command.args(words).current_dir(job.scratch);
    Ok(Plan { command, delivery: Delivery::File(image, |_| None), above: 0, facts: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::driver;

    #[test]
    fn the_variant_of_mitsuba_is_no_option() {
        let known = driver("mitsuba-3").expect("a driver");
        let mut request = RenderRequest::new(known, PathBuf::new(), (1, 1), PathBuf::new());
        request.options = ["-m", "llvm_ad_rgb", "-v"].map(str::to_owned).to_vec();
        let seen = understood(&request);
        assert_eq!((seen.variant.as_deref(), seen.options), (Some("llvm_ad_rgb"), vec!["-v".to_owned()]));
        request.options = vec!["-m".to_owned()];
        assert_eq!(understood(&request).variant, None);
    }

    #[test]
    fn options_stand_before_the_arguments_of_a_driver() {
        let mut command = Command::new("pbrt");
        command.arg("--outfile").arg("a.exr").env("A", "b").env_remove("C").current_dir("/");
        let new = with_options(&command, &["--quiet".to_owned()]);
        assert_eq!(format!("{new:?}"), format!("{command:?}").replace("\"pbrt\"", "\"pbrt\" \"--quiet\""));
    }

    #[test]
    fn targets_that_nothing_reads_have_a_stand_in() {
        for driver in &WITHOUT {
            assert!(crate::run::DRIVERS.iter().all(|known| known.target != driver.target), "{}", driver.target);
        }
        assert!(without_driver("gltf").is_some() && without_driver("mitsuba-3").is_none());
    }
}
