//! Which references are there, and which are not.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ltsc_core::formats::Choices;
use ltsc_core::valid::Valid;

use super::about::About;
use super::{Stale, names, path, staleness, store};
use crate::failure::{Exit, Failure, why};

/// A reference that is there, or is not.
pub struct Entry {
    /// The scene.
    pub scene: String,
    /// Its name: that of a renderer, a target, or another; empty where a scene has none at all.
    pub name: String,
    /// The file.
    pub file: PathBuf,
    /// How it stands.
    pub state: State,
}

/// How a reference stands.
pub enum State {
    /// It shows the scene as it is now.
    Fresh(About),
    /// It does not.
    Stale(About, Stale),
    /// There is no scene of its name.
    Orphan,
    /// The file cannot be read, or is none of ours.
    Damaged(String),
    /// It is not there.
    Missing,
}

impl State {
    /// The word for it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Fresh(_) => "fresh",
            Self::Stale(..) => "stale",
            Self::Orphan => "orphan",
            Self::Damaged(_) => "damaged",
            Self::Missing => "missing",
        }
    }
}

/// The references of scenes, which have their own settings: all that are there, those of `wanted` names that are not, and where nothing is
/// wanted, scenes without any. With `all`, the scenes are all that there are, and references of others are orphans.
///
/// # Errors
/// If the folder cannot be read.
pub fn list(
    references: &Path,
    scenes: &[(&Valid, &Choices)],
    wanted: &[String],
    all: bool,
) -> Result<Vec<Entry>, Failure> {
    let mut entries = Vec::new();
    for (scene, choices) in scenes {
        let there = files(&references.join(&scene.name))?;
        let has = |name: &String| names(name).iter().any(|name| there.contains(name));
        let shown = |name: &&String| wanted.is_empty() || wanted.iter().any(|wanted| names(wanted).contains(name));
        for name in there.iter().filter(shown) {
            let file = path(references, &scene.name, name);
            let state = match store::describe(&file) {
                Err(failure) => State::Damaged(failure.message),
                Ok(None) => State::Damaged(format!("{} is no reference that ltsc wrote", file.display())),
                Ok(Some(about)) => match staleness(&about, scene, choices)? {
                    None => State::Fresh(about),
                    Some(stale) => State::Stale(about, stale),
                },
            };
            entries.push(Entry { scene: scene.name.clone(), name: name.clone(), file, state });
        }
        let nothing = (wanted.is_empty() && there.is_empty()).then(String::new);
        for name in wanted.iter().filter(|name| !has(name)).cloned().chain(nothing) {
            let file = path(references, &scene.name, &name);
            entries.push(Entry { scene: scene.name.clone(), name, file, state: State::Missing });
        }
    }
    if all {
        let known: BTreeSet<&str> = scenes.iter().map(|(scene, _)| scene.name.as_str()).collect();
        for folder in entries_of(references)? {
            let scene = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if known.contains(scene.as_str()) || scene.starts_with('.') || !folder.is_dir() {
                continue;
            }
            for name in files(&folder)? {
                let file = path(references, &scene, &name);
                entries.push(Entry { scene: scene.clone(), name, file, state: State::Orphan });
            }
        }
    }
    Ok(entries)
}

/// The names of the EXR files in a folder, sorted; none if it is not there.
fn files(folder: &Path) -> Result<BTreeSet<String>, Failure> {
    let exr = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "exr");
    let name = |path: PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(entries_of(folder)?.into_iter().filter(exr).filter_map(name).collect())
}

fn entries_of(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed =
        |error: std::io::Error| Failure::new(Exit::Environment, format!("{}: {}", folder.display(), why(&error)));
    match std::fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(failed(error)),
        Ok(entries) => {
            let mut all =
                entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>().map_err(failed)?;
            all.sort();
            Ok(all)
        }
    }
}
