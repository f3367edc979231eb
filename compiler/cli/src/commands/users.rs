//! Which scenes of a project use a library, directly or through others: what is wrong with a library shows in them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use ltsc_core::eval;
use ltsc_core::files::VPath;

use crate::args;
use crate::output::Failure;
use crate::project::{self, Project};

use super::shared::disk_of;

/// The scenes of a project that use a library among `files`, in the project's order and without those in `files`. Of a folder
/// without `ltsc.toml` none: nothing says where its scenes are.
pub fn users(project: &Project, files: &[PathBuf], findings: &args::Findings) -> Result<Vec<PathBuf>, Failure> {
    let disk = disk_of(project, findings)?;
    let limits = project::limits_with(project.limits, &findings.limits)?;
    let named: BTreeSet<VPath> = files.iter().filter_map(|file| disk.path_of(file)).collect();
    let is_scene = |path: &VPath| eval::header(&disk, path, limits).is_some();
    let libraries: BTreeSet<&VPath> = named.iter().filter(|path| !is_scene(path)).collect();
    if libraries.is_empty() || !project.declared {
        return Ok(Vec::new());
    }
    let mut known: BTreeMap<VPath, Vec<VPath>> = BTreeMap::new();
    let mut reaches = |start: &VPath| {
        let mut seen: BTreeSet<VPath> = BTreeSet::from([start.clone()]);
        let mut open = vec![start.clone()];
        while let Some(path) = open.pop() {
            let used = known.entry(path).or_insert_with_key(|path| eval::uses(&disk, path, limits));
            for path in used.iter() {
                if libraries.contains(path) {
                    return true;
                }
                if seen.insert(path.clone()) {
                    open.push(path.clone());
                }
            }
        }
        false
    };
    let mut found = Vec::new();
    for file in project::scene_files(&project.scenes).unwrap_or_default().files {
        let Some(path) = disk.path_of(&file) else { continue };
        if !named.contains(&path) && reaches(&path) && is_scene(&path) {
            found.push(file);
        }
    }
    Ok(found)
}
