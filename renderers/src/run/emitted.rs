//! Emitted folders: what their files declare, and copies in which a file says something else.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{Job, RenderError};

/// Folders beside an emitted one that its files refer to, where several targets share their meshes.
const SHARED: [&str; 2] = ["meshes", "textures"];

/// Whether the main file of a Mitsuba scene or one beside it declares a parameter.
pub(super) fn declares(job: &Job<'_>, name: &str) -> bool {
    let wanted = format!("<default name=\"{name}\"");
    texts(job.folder, "xml").any(|(_, text)| text.contains(&wanted))
}

/// Refuses a scene whose number of samples cannot be set.
pub(super) fn no_parameter(job: &Job<'_>, name: &str, hint: String) -> RenderError {
    RenderError::Request { message: format!("`{}` has no parameter `{name}` to set", job.main.display()), hint }
}

/// The text files of a folder with this ending, in the order of their names.
pub(super) fn texts(folder: &Path, ending: &'static str) -> impl Iterator<Item = (PathBuf, String)> + use<> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == ending))
        .collect();
    paths.sort();
    paths.into_iter().filter_map(|path| crate::regular::read_text(&path, u64::MAX - 1).ok().map(|text| (path, text)))
}

/// Makes `<scratch>/copy/scene` look like the emitted folder, but for the changed files. Other files but the main one are links
/// where the system has them. Gives the new main file. Called again, it changes the files again.
pub(super) fn copy(job: &Job<'_>, changed: &[(PathBuf, String)]) -> Result<PathBuf, RenderError> {
    let place = job.scratch.join("copy");
    let scene = place.join("scene");
    let failed = |source| RenderError::Io { path: scene.clone(), source };
    if !scene.exists() {
        fs::create_dir_all(&scene).map_err(failed)?;
        for entry in fs::read_dir(job.folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let name = path.file_name().unwrap_or_default();
            if path == job.main {
                // pbrt-r4 and pbrt-r3 follow a link first, and look for what the file includes beside its target.
                fs::copy(&path, scene.join(name)).map_err(failed)?;
            } else if !changed.iter().any(|(file, _)| file.file_name() == Some(name)) {
                link(&path, &scene.join(name)).map_err(failed)?;
            }
        }
        for name in SHARED {
            let beside = job.folder.parent().unwrap_or(job.folder).join(name);
            if beside.is_dir() {
                link(&beside, &place.join(name)).map_err(failed)?;
            }
        }
    }
    for (file, text) in changed {
        fs::write(scene.join(file.file_name().unwrap_or_default()), text).map_err(failed)?;
    }
    Ok(scene.join(job.main.strip_prefix(job.folder).unwrap_or(job.main)))
}

#[cfg(unix)]
fn link(from: &Path, to: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(from, to)
}

#[cfg(not(unix))]
fn link(from: &Path, to: &Path) -> io::Result<()> {
    if !from.is_dir() {
        return fs::copy(from, to).map(|_| ());
    }
    fs::create_dir(to)?;
    for entry in fs::read_dir(from)? {
        let path = entry?.path();
        link(&path, &to.join(path.file_name().unwrap_or_default()))?;
    }
    Ok(())
}
