//! What drivers with a Python script have in common.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::installed::LOCK;

use super::process::{End, Lines, Patience, begin, run, tail};
use super::{Asked, Delivery, Job, Plan, RenderError};

/// Stands in front of every script.
const PRELUDE: &str = include_str!("prelude.py");
/// Importing a renderer takes about a second; a loaded machine and a network drive take longer.
const PROBE_TIME: Duration = Duration::from_secs(60);

/// Whether the executable is to be used with a script.
#[must_use]
pub fn is_python(executable: &Path) -> bool {
    executable.file_name().and_then(OsStr::to_str).is_some_and(|name| name.starts_with("python"))
}

/// A Python with an environment that does not interfere.
pub(crate) fn python(executable: &Path) -> Command {
    let mut command = Command::new(executable);
    let root = executable.ancestors().nth(3);
    if root.is_some_and(|root| root.join(LOCK).exists()) {
        // A private installation must not see other packages of the user. Elsewhere the user's
        // variables may be what makes the renderer visible.
        command.arg("-I");
    }
    command.args(["-u", "-X", "utf8"]);
    command
}

/// Plans a run of the driver's script with the job as its one argument, to which the driver may add.
pub(crate) fn plan(
    job: &Job<'_>,
    script: &str,
    more: serde_json::Value,
    working_directory: &Path,
) -> Result<Plan, RenderError> {
    // A file in a folder of its own, since Python looks for modules beside the script first, and
    // the emitted folder may hold anything.
    let folder = job.scratch.join("script");
    let file = folder.join("render.py");
    fs::create_dir(&folder)
        .and_then(|()| fs::write(&file, format!("{PRELUDE}\n{script}")))
        .map_err(|source| RenderError::Io { path: file.clone(), source })?;
    let text = |path: &Path| {
        path.to_str().map(str::to_owned).ok_or_else(|| RenderError::Request {
            message: format!("the name `{}` is not Unicode", path.display()),
            hint: "rename the folder".to_owned(),
        })
    };
    let mut argument = serde_json::json!({
        "main": text(job.main)?,
        "samples": job.request.samples,
        "seed": job.request.seed,
        "threads": job.request.threads,
        "scratch": text(job.scratch)?,
    });
    if let (Some(all), serde_json::Value::Object(more)) = (argument.as_object_mut(), more) {
        all.extend(more);
    }
    let mut command = python(job.executable);
    command.arg(&file).arg(argument.to_string()).current_dir(working_directory);
    Ok(Plan { command, delivery: Delivery::Events, above: 0, facts: Vec::new() })
}

/// Asks a Python for the version of a module, given by an expression.
pub(crate) fn probe(asked: Asked<'_>, module: &str, expression: &str) -> Result<String, String> {
    // Renderers print on import; the version stands on a line of its own.
    let program = format!(
        "import importlib.util, sys\n\
         if importlib.util.find_spec('{module}') is None: sys.exit(77)\n\
         import {module}\n\
         print('\\n@ltsc ' + str({expression}), flush=True)\n"
    );
    let mut command = python(asked.program);
    command.arg("-c").arg(program);
    let mut version = None;
    let (end, tail) = ask(command, asked.until, Lines::Events, &mut |line| version = Some(line.to_owned()))?;
    match (end, version) {
        (End::Exited(status), Some(version)) if status.success() => Ok(version),
        (End::Exited(status), _) if status.code() == Some(77) => Err(format!("it has no module `{module}`")),
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
        (End::Exited(_), _) => {
            Err(format!("importing `{module}` fails: {}", tail.last().map_or("no reason is given", String::as_str)))
        }
    }
}

/// Runs a short command in an empty folder, not longer than `until`; gives its end and the end of its output.
pub(crate) fn ask(
    mut command: Command,
    until: Option<Instant>,
    lines: Lines,
    on_line: &mut dyn FnMut(&str),
) -> Result<(End, Vec<String>), String> {
    let folder = crate::guard::Folder::new().map_err(|error| error.to_string())?;
    let log = folder.path().join("log");
    command.current_dir(folder.path());
    begin(&log).map_err(|error| error.to_string())?;
    let most = Instant::now() + PROBE_TIME;
    let patience = Patience { until: Some(until.map_or(most, |until| until.min(most))), cancel: None };
    let (end, _) =
        run(command, &log, lines, patience, on_line).map_err(|error| format!("it does not start: {error}"))?;
    Ok((end, tail(&log, super::error::CAUSES)))
}
