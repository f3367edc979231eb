//! Finds a Python that an environment can be made with.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::InstallError;
use crate::env::{Env, executable};
use crate::run::process::{End, Lines};
use crate::run::script::ask;
use crate::run::{Driver, Packages};

/// Runs the module named by the first argument as `python -m` would. Standard input is held open
/// by ltsc; when it ends, ltsc has ended, and nobody would notice if this went on beside another
/// installation.
pub(super) const SUPERVISED: &str = "\
import os, runpy, sys, threading

def die_with_parent():
    try:
        while os.read(0, 4096):
            pass
    finally:
        if hasattr(os, 'killpg') and os.getpgrp() == os.getpid():
            os.killpg(0, 9)
        os._exit(143)

threading.Thread(target=die_with_parent, daemon=True).start()
sys.argv = sys.argv[1:]
runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)
";

/// Asks for version, environment and pip. The tests of both are those that the modules make.
const QUESTION: &str = "\
import sys
print('\\n@ltsc version %d.%d.%d' % sys.version_info[:3], flush=True)
try:
    import ensurepip, venv
    print('@ltsc venv', flush=True)
except ImportError:
    pass
";

/// A Python that can be used.
pub(super) struct Base {
    pub path: PathBuf,
    pub version: String,
}

/// The Python that was named, else the first on the path that fits.
pub(super) fn choose(
    driver: &'static Driver,
    packages: &Packages,
    named: Option<&Path>,
    env: &Env,
) -> Result<Base, InstallError> {
    let (oldest, newest) = packages.pythons;
    let candidates: Vec<PathBuf> = match named {
        Some(path) if executable(path) => std::path::absolute(path).into_iter().collect(),
        Some(path) => path.to_str().map(|name| env.on_path(name)).unwrap_or_default(),
        // What is called python3 is what the user means by it; others only stand in.
        None => std::iter::once("python3".to_owned())
            .chain((oldest..=newest).rev().map(|minor| format!("python3.{minor}")))
            .chain(std::iter::once("python".to_owned()))
            .flat_map(|name| env.on_path(&name))
            .collect(),
    };
    let mut looked = Vec::new();
    for path in candidates {
        match examine(driver, packages.pythons, &path) {
            Ok(version) => return Ok(Base { path, version }),
            Err(reason) => looked.push(format!("`{}`: {reason}", path.display())),
        }
    }
    if looked.is_empty() {
        looked.push(match named {
            Some(path) => format!("`{}`: no such program", path.display()),
            None => "no `python3` on the path".to_owned(),
        });
    }
    Err(InstallError::Python { driver, pythons: packages.pythons, looked })
}

/// A Python that sees neither the user's packages nor the working directory, and does not keep
/// lines back.
pub(super) fn isolated(python: &Path) -> Command {
    let mut command = Command::new(python);
    command.args(["-I", "-u", "-X", "utf8"]);
    command
}

fn examine(driver: &Driver, (oldest, newest): (u32, u32), path: &Path) -> Result<String, String> {
    let mut command = isolated(path);
    command.arg("-c").arg(QUESTION);
    let (mut version, mut venv) = (None, false);
    let (end, tail) = ask(command, None, Lines::Events, &mut |line| {
        if let Some(rest) = line.strip_prefix("version ") {
            version = Some(rest.to_owned());
        }
        venv |= line == "venv";
    })?;
    let version = match (end, version) {
        (End::Exited(status), Some(version)) if status.success() => version,
        _ => {
            let last = tail.last().map_or("it does not answer", String::as_str);
            return Err(format!("it does not work: {last}"));
        }
    };
    let mut numbers = version.split('.').map(|part| part.parse::<u32>().unwrap_or_default());
    match (numbers.next(), numbers.next()) {
        (Some(3), Some(minor)) if (oldest..=newest).contains(&minor) => {}
        _ => {
            return Err(format!(
                "it is Python {version}, and `{}` {} has packages for 3.{oldest} to 3.{newest}",
                driver.name, driver.version
            ));
        }
    }
    if venv { Ok(version) } else { Err("it lacks the modules `venv` and `ensurepip`".to_owned()) }
}
