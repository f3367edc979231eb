//! Results of earlier runs, removed: only folders with a manifest of an evaluation, and in them only files that it names and nobody has
//! changed since.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;

use crate::disk::{MANIFEST, Manifest, is_removable, unwritable};
use crate::failure::Failure;
use crate::page;

use super::folder::is_results;

/// How deep folders of results are looked for.
const DEPTH: usize = 3;

/// What became of a folder of results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Removed {
    /// The folder.
    pub folder: PathBuf,
    /// Files that are gone, or would go.
    pub files: usize,
    /// Their size.
    pub bytes: u64,
    /// Files that stay: changed since they were written, or not ours.
    pub kept: Vec<String>,
}

/// Removes results below `folders` but for the newest `keep` of each evaluation; with `files_only` only the files of cases that were
/// kept, of all results; with `dry` nothing.
///
/// # Errors
/// Where something cannot be read or removed.
pub fn clean(folders: &[&Path], keep: usize, files_only: bool, dry: bool) -> Result<Vec<Removed>, Failure> {
    let mut found = Vec::new();
    for folder in folders {
        look(folder, DEPTH, &mut found).map_err(|error| unwritable(folder, &error))?;
    }
    found.sort();
    found.dedup();
    let mut by_name: BTreeMap<(PathBuf, String), Vec<(SystemTime, PathBuf)>> = BTreeMap::new();
    for folder in found {
        let Some(manifest) = Manifest::read(&folder) else { continue };
        let written = fs::metadata(folder.join(MANIFEST)).and_then(|meta| meta.modified());
        let around = folder.parent().unwrap_or(Path::new(".")).to_path_buf();
        by_name.entry((around, manifest.scene)).or_default().push((written.unwrap_or(SystemTime::UNIX_EPOCH), folder));
    }
    let mut done = Vec::new();
    for (_, mut all) in by_name {
        all.sort_by(|one, other| other.cmp(one));
        for (_, folder) in all.into_iter().skip(if files_only { 0 } else { keep }) {
            let one = remove(&folder, files_only, dry).map_err(|error| unwritable(&folder, &error))?;
            done.extend((one.files > 0 || !one.kept.is_empty()).then_some(one));
        }
    }
    done.sort_by(|one, other| one.folder.cmp(&other.folder));
    Ok(done)
}

/// Folders of results at a place or below it; hidden folders and links are passed over.
fn look(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if is_results(folder) {
        found.push(folder.to_path_buf());
        return Ok(());
    }
    if depth == 0 {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() && !entry.file_name().as_encoded_bytes().starts_with(b".") {
            look(&entry.path(), depth - 1, found)?;
        }
    }
    Ok(())
}

fn remove(folder: &Path, files_only: bool, dry: bool) -> std::io::Result<Removed> {
    let mut done = Removed { folder: folder.to_path_buf(), files: 0, bytes: 0, kept: Vec::new() };
    let Some(mut manifest) = Manifest::read(folder) else { return Ok(done) };
    // The page of results goes with them.
    let page = folder.join(page::FOLDER);
    if !files_only && page::is_page(&page) {
        let of_page = remove(&page, false, dry)?;
        done.files += of_page.files;
        done.bytes += of_page.bytes;
        done.kept.extend(of_page.kept.iter().map(|path| format!("{}/{path}", page::FOLDER)));
    }
    let asked: Vec<(String, String)> = manifest
        .files
        .iter()
        .filter(|(path, _)| !files_only || path.starts_with("files/"))
        .map(|(path, hash)| (path.clone(), hash.clone()))
        .collect();
    let mut around: BTreeSet<PathBuf> = BTreeSet::new();
    for (path, hash) in asked {
        let full = folder.join(&path);
        if !is_removable(folder, &path, &hash) {
            if fs::symlink_metadata(&full).is_ok() {
                done.kept.push(path);
            }
            continue;
        }
        done.bytes += fs::metadata(&full).map_or(0, |meta| meta.len());
        done.files += 1;
        around.extend(full.ancestors().skip(1).take_while(|above| *above != folder).map(Path::to_path_buf));
        if !dry {
            fs::remove_file(&full)?;
            manifest.files.remove(&path);
        }
    }
    if dry {
        return Ok(done);
    }
    // Folders that are empty now, the deepest first.
    for above in around.iter().rev() {
        let _stays_if_not_empty = fs::remove_dir(above);
    }
    if files_only || !done.kept.is_empty() {
        if done.files > 0 {
            let bytes = manifest.bytes();
            crate::disk::write_whole(&folder.join(MANIFEST), &mut |out| out.write_all(&bytes))?;
        }
        return Ok(done);
    }
    fs::remove_file(folder.join(MANIFEST))?;
    done.files += 1;
    // What is not ours stays, and its folder with it.
    if fs::remove_dir(folder).is_err() {
        done.kept.extend(fs::read_dir(folder)?.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()));
    }
    Ok(done)
}
