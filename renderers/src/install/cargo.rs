//! Installations by cargo: a crate, built where everything of it lies in one folder.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{InstallError, InstallProgress, Made, Site, Step};
use crate::env::Env;
use crate::run::installed::{program, root};
use crate::run::process::{End, Lines};
use crate::run::script::ask;
use crate::run::{Crate, Driver};

/// Builds the crate with the dependencies that its author has locked.
pub(super) fn make(
    site: &Site<'_>,
    source: &Crate,
    progress: &mut dyn FnMut(InstallProgress),
) -> Result<Made, InstallError> {
    let driver = site.request.driver;
    progress(InstallProgress::Step(Step::Cargo));
    let (cargo, version) = choose(driver, source, &site.request.env)?;
    progress(InstallProgress::Line(format!("{} ({version})", cargo.display())));

    progress(InstallProgress::Step(Step::Build));
    let build = site.folder.join("build");
    let mut command = Command::new(&cargo);
    command.args(["install", source.name, "--bin", source.program, "--locked", "--force", "--version"]);
    command.arg(format!("={}", driver.version)).args(source.flags).arg("--root").arg(root(site.folder));
    command.envs(source.environment.iter().copied());
    // Kept when it is interrupted, so that the next attempt goes on from there.
    command.env("CARGO_TARGET_DIR", &build);
    command.env("CARGO_TERM_COLOR", "never").env("CARGO_TERM_PROGRESS_WHEN", "never");
    // A program for another machine could not be run.
    command.env_remove("CARGO_BUILD_TARGET").env_remove("CARGO_INSTALL_ROOT");
    site.run(Step::Build, command, progress)?;
    Ok(Made { executable: program(source, site.folder), tool: version, leftovers: vec![build] })
}

/// The first cargo on the path that is new enough, and its version.
fn choose(driver: &'static Driver, source: &Crate, env: &Env) -> Result<(PathBuf, String), InstallError> {
    let mut looked = Vec::new();
    for path in env.on_path("cargo") {
        match examine(&path, source.oldest) {
            Ok(version) => return Ok((path, version)),
            Err(reason) => looked.push(format!("`{}`: {reason}", path.display())),
        }
    }
    if looked.is_empty() {
        looked.push("no `cargo` on the path".to_owned());
    }
    Err(InstallError::Cargo { driver, oldest: source.oldest, looked })
}

fn examine(path: &Path, oldest: u32) -> Result<String, String> {
    let mut command = Command::new(path);
    command.arg("--version");
    let mut version = None;
    let (end, tail) = ask(command, None, Lines::All, &mut |line| {
        // "cargo 1.95.0 (f2d3ce0bd 2026-03-21)"
        if let Some(rest) = line.strip_prefix("cargo ") {
            version = version.take().or_else(|| rest.split_whitespace().next().map(str::to_owned));
        }
    })?;
    let version = match (end, version) {
        (End::Exited(status), Some(version)) if status.success() => version,
        _ => return Err(format!("it does not work: {}", tail.last().map_or("it does not answer", String::as_str))),
    };
    let mut numbers = version.split('.').map(|part| part.parse::<u32>().unwrap_or_default());
    let found = (numbers.next().unwrap_or_default(), numbers.next().unwrap_or_default());
    if found >= (1, oldest) { Ok(version) } else { Err(format!("it is version {version}, and 1.{oldest} is needed")) }
}
