//! Looks for a renderer: what the user names, then a private installation, then the path.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::installed::{Status, status_in_cache};
use super::script::is_python;
use super::{Asked, Driver, Installation, RenderError};
use crate::cache::CachePaths;
use crate::env::{Env, executable};

/// Where to look.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// The environment, of which the path is used.
    pub env: &'a Env,
    /// The user's cache, which holds private installations.
    pub cache: Option<&'a CachePaths>,
    /// What the user has named just now.
    pub given: Option<&'a Path>,
    /// What the user has configured.
    pub configured: Option<&'a Path>,
    /// Until when programs may take to answer; a minute for each if nothing is said.
    pub until: Option<Instant>,
}

/// How an executable was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It was named.
    Given,
    /// It was configured.
    Configured,
    /// It is a private installation.
    Installed,
    /// It lies on the path.
    Path,
}

/// A renderer that answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// A Python that has the module, or a program of the renderer.
    pub path: PathBuf,
    /// Its version, as it says. Compare it with [`Driver::version`].
    pub version: String,
    /// How it was found.
    pub source: Source,
}

/// Finds the renderer that a request without an executable would use. What the user names or
/// configures must work: nothing else is tried then.
///
/// # Errors
/// Gives an error that lists where it was looked for and what was wrong there.
pub fn find(driver: &'static Driver, search: &Search<'_>) -> Result<Found, RenderError> {
    let not_found = |looked| RenderError::NotFound { driver: driver.name, looked };
    let named = [(search.given, Source::Given), (search.configured, Source::Configured)];
    for (path, source) in named {
        let Some(path) = path else { continue };
        let path = locate(path, search.env)
            .ok_or_else(|| not_found(vec![format!("`{}`: no such program", path.display())]))?;
        return match (driver.probe)(Asked { program: &path, until: search.until }) {
            Ok(version) => Ok(Found { path, version, source }),
            Err(reason) => Err(not_found(vec![format!("`{}`: {reason}", path.display())])),
        };
    }
    let mut looked = Vec::new();
    let private = !matches!(driver.installation, Installation::User { .. });
    match search.cache.map(|cache| (cache, status_in_cache(driver, cache))) {
        _ if !private => {}
        Some((_, Status::Installed { path, version })) => {
            return Ok(Found { path, version, source: Source::Installed });
        }
        Some((cache, Status::Partial { .. })) => looked.push(format!(
            "`{}`: an installation was begun and not finished",
            cache.renderer(driver.name, driver.version).display()
        )),
        Some((cache, _)) => {
            looked.push(format!("`{}`: nothing installed", cache.renderers().display()));
        }
        None => looked.push("no cache folder is known".to_owned()),
    }
    match on_path(driver, search.env, search.until, &mut looked) {
        Some((path, version)) => Ok(Found { path, version, source: Source::Path }),
        None => Err(not_found(looked)),
    }
}

/// Looks on the path only, for a program and its version; adds to `looked` what did not work.
pub(crate) fn on_path(
    driver: &Driver,
    env: &Env,
    until: Option<Instant>,
    looked: &mut Vec<String>,
) -> Option<(PathBuf, String)> {
    let python = driver.packages().map(|_| "python3");
    for program in python.iter().chain(driver.programs) {
        let all = env.on_path(program);
        if all.is_empty() {
            looked.push(format!("`{program}`: not on the path"));
        }
        for path in all {
            match (driver.probe)(Asked { program: &path, until }) {
                Ok(version) => return Some((path, version)),
                Err(reason) => looked.push(format!("`{}`: {reason}", path.display())),
            }
        }
    }
    None
}

/// The program that a name means: a path, or else the first of that name on the path.
fn locate(name: &Path, env: &Env) -> Option<PathBuf> {
    if executable(name) {
        return std::path::absolute(name).ok();
    }
    let bare = name.components().count() == 1;
    name.to_str().filter(|_| bare).and_then(|name| env.on_path(name).into_iter().next())
}

/// The reason to give for a program that a driver has no use for.
pub(crate) fn wrong_program(path: &Path, driver: &Driver) -> String {
    debug_assert!(!is_python(path));
    let programs = if driver.programs.is_empty() { "-".to_owned() } else { driver.programs.join(", ") };
    format!("it is neither a Python nor one of: {programs}")
}
