//! Files that ltsc writes among those of a person: pages in `docs`, records, pictures.
//!
//! A record beside them, [`RECORD`], says which are ours and what was written. What it does not name is not touched without `--force`,
//! and neither is what was changed since; a page that is no longer made goes only as it was written.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ltsc_core::files::VPath;
use ltsc_render::regular;
use serde::{Deserialize, Serialize};

use super::notice::say;
use super::sink::refuse_links;
use super::staging::{STAGING, Staging, left_over, remove_empty};
use super::unwritable;
use crate::failure::{Exit, Failure};

/// The name of the record in a folder.
pub const RECORD: &str = ".ltsc-pages.json";

/// The most bytes of a page or picture.
const LARGEST: u64 = 1 << 30;

/// How many files a message names.
const NAMED: usize = 8;

/// Which files of a folder are ours.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Record {
    /// Always "ltsc".
    generator: String,
    /// By path below the folder.
    files: BTreeMap<String, Ours>,
}

/// A file of ours.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Ours {
    /// The command that wrote it.
    by: String,
    /// BLAKE3 of what was written; line ends count as one character.
    hash: String,
    /// While it is being written, that of what it becomes: a run that is killed leaves the one or the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    becomes: Option<String>,
}

impl Record {
    fn read(folder: &Path) -> Self {
        let text = regular::read(&folder.join(RECORD), regular::TEXT).ok();
        let record: Option<Self> = text.and_then(|text| serde_json::from_slice(&text).ok());
        record.filter(|record| record.generator == "ltsc").unwrap_or_default()
    }

    fn names(&self, path: &str, hash: &str) -> bool {
        self.files.get(path).is_some_and(|ours| ours.hash == hash || ours.becomes.as_deref() == Some(hash))
    }

    fn write(&self, staging: &Staging, folder: &Path) -> io::Result<()> {
        let mut text = serde_json::to_vec_pretty(self)?;
        text.push(b'\n');
        staging.put(&folder.join(RECORD), |new| std::fs::write(new, &text))
    }
}

/// What a file holds now.
enum There {
    Nothing,
    Regular(String),
    /// A link, a folder, a pipe, or what cannot be read.
    Other,
}

fn hash(bytes: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    for (at, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        if at > 0 {
            hasher.update(b"\n");
        }
        // Repositories may hold texts with either end of lines.
        hasher.update(line.strip_suffix(b"\r").unwrap_or(line));
    }
    hasher.finalize().to_hex().to_string()
}

/// Whether a file is not there, and cannot be.
pub(super) fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename)
}

fn there(path: &Path) -> There {
    match std::fs::symlink_metadata(path) {
        // What cannot be there is refused when it is to be written.
        Err(error) if is_absent(&error) => There::Nothing,
        Ok(meta) if meta.is_file() => {
            regular::read(path, LARGEST).map_or(There::Other, |bytes| There::Regular(hash(&bytes)))
        }
        _ => There::Other,
    }
}

/// A file as it is to be.
struct Page {
    bytes: Vec<u8>,
    /// What stood in it is part of it.
    merged: bool,
}

/// The files that one command writes into a folder.
pub struct Pages {
    folder: PathBuf,
    by: &'static str,
    pages: BTreeMap<String, Page>,
    record: Record,
    kept: Vec<String>,
}

/// What became of them; with `check`, what would.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Done {
    /// New, or with other content.
    pub written: Vec<PathBuf>,
    /// No longer made.
    pub removed: Vec<PathBuf>,
}

impl Done {
    /// How many files there were to do.
    pub fn count(&self) -> usize {
        self.written.len() + self.removed.len()
    }

    /// A line for each file, of what was done with it or, with `check`, would be.
    pub fn lines(&self, check: bool) -> String {
        let line = |path: &PathBuf, [would, was]: [&str; 2]| match check {
            true => format!("{would}: {}\n", path.display()),
            false => format!("{} {was}\n", path.display()),
        };
        let written = self.written.iter().map(|path| line(path, ["stale", "written"]));
        written.chain(self.removed.iter().map(|path| line(path, ["left over", "removed"]))).collect()
    }
}

impl Pages {
    /// The files of the command `by` in `folder`.
    pub fn new(folder: &Path, by: &'static str) -> Self {
        let record = Record::read(folder);
        let (pages, kept) = (BTreeMap::new(), Vec::new());
        Self { folder: folder.to_path_buf(), by, pages, record, kept }
    }

    /// What the file at `path`, which has `/` between its parts, is to hold.
    pub fn put(&mut self, path: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.pages.insert(path.into(), Page { bytes: bytes.into(), merged: false });
    }

    /// The same for a file whose old content was read and is part of the new one, whoever wrote it.
    pub fn put_merged(&mut self, path: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.pages.insert(path.into(), Page { bytes: bytes.into(), merged: true });
    }

    /// The files of this command that are there and not made now.
    pub fn rest(&self) -> impl Iterator<Item = &str> {
        let rest = self.record.files.iter().filter(|(path, ours)| ours.by == self.by && !self.is_made(path));
        rest.map(|(path, _)| path.as_str())
    }

    fn is_made(&self, path: &str) -> bool {
        self.pages.contains_key(path) || self.kept.iter().any(|kept| kept == path)
    }

    /// Leaves those files that `keep` says yes to, though they are not made now.
    pub fn keep(&mut self, keep: impl Fn(&str) -> bool) {
        let kept: Vec<String> = self.rest().filter(|path| keep(path)).map(str::to_owned).collect();
        self.kept.extend(kept);
    }

    /// Refuses what [`Pages::finish`] would refuse, before long work is done for it.
    pub fn refuse(&self, path: &str, force: bool) -> Result<(), Failure> {
        let ours = match there(&self.folder.join(path)) {
            There::Nothing => true,
            There::Regular(old) => self.record.names(path, &old),
            There::Other => false,
        };
        if ours || force { Ok(()) } else { Err(not_ours(&[self.folder.join(path)])) }
    }

    /// Writes what is not yet as it should be, or with `check` only says what would be written. Nothing is written where one of the
    /// files is not ours, unless `force`.
    pub fn finish(mut self, check: bool, force: bool) -> Result<Done, Failure> {
        let failed = |error: io::Error| unwritable(&self.folder, &error);
        let mut next = self.record.clone();
        next.generator = "ltsc".to_owned();
        let (mut changed, mut foreign) = (Vec::new(), Vec::new());
        for (path, page) in &self.pages {
            refuse_links(&self.folder, &self.folder.join(path)).map_err(failed)?;
            let new = hash(&page.bytes);
            let before = there(&self.folder.join(path));
            match before {
                There::Regular(old) if old == new => {}
                There::Nothing => changed.push(path.clone()),
                There::Regular(old) if page.merged || self.record.names(path, &old) => changed.push(path.clone()),
                _ => {
                    changed.push(path.clone());
                    foreign.push(self.folder.join(path));
                }
            }
            next.files.insert(path.clone(), Ours { by: self.by.to_owned(), hash: new, becomes: None });
        }
        let mut gone = Vec::new();
        for path in self.rest().map(str::to_owned).collect::<Vec<_>>() {
            next.files.remove(&path);
            // A record is a file like any other: it must not lead out of the folder.
            let full = self.folder.join(&path);
            if VPath::resolve("", &path).is_err() || refuse_links(&self.folder, &full).is_err() {
                continue;
            }
            match there(&full) {
                There::Nothing => {}
                There::Regular(old) if self.record.names(&path, &old) => gone.push(path),
                There::Regular(_) | There::Other => {
                    say(&format!("{} is no longer made, and was changed since: it stays", full.display()));
                }
            }
        }
        let full = |paths: &[String]| paths.iter().map(|path| self.folder.join(path)).collect::<Vec<_>>();
        let mut done = Done { written: full(&changed), removed: full(&gone) };
        // What a killed run has left goes also where there is nothing else to do.
        if left_over(&self.folder) {
            done.removed.push(self.folder.join(STAGING));
        }
        if check || done.count() == 0 && next.files == self.record.files {
            return Ok(done);
        }
        if !foreign.is_empty() && !force {
            return Err(not_ours(&foreign));
        }
        self.write(next, &changed, &gone).map_err(|error| unwritable(&self.folder, &error))?;
        Ok(done)
    }

    fn write(&mut self, mut next: Record, changed: &[String], gone: &[String]) -> io::Result<()> {
        let staging = Staging::of(&self.folder)?;
        // Another command may have written here in the meantime.
        let now = Record::read(&self.folder);
        let others = now.files.iter().filter(|(path, ours)| ours.by != self.by && !self.pages.contains_key(*path));
        next.files.retain(|_, ours| ours.by == self.by);
        next.files.extend(others.map(|(path, ours)| (path.clone(), ours.clone())));
        let mut during = now;
        during.generator = "ltsc".to_owned();
        for path in changed {
            let new = next.files[path].hash.clone();
            let ours =
                during.files.entry(path.clone()).or_insert_with(|| Ours { hash: new.clone(), ..Ours::default() });
            self.by.clone_into(&mut ours.by);
            ours.becomes = Some(new);
        }
        if !changed.is_empty() {
            during.write(&staging, &self.folder)?;
        }
        for path in changed {
            let to = self.folder.join(path);
            std::fs::create_dir_all(to.parent().unwrap_or(&self.folder))?;
            let bytes = &self.pages[path].bytes;
            staging.put(&to, |new| std::fs::File::create(new)?.write_all(bytes))?;
        }
        for path in gone {
            let place = self.folder.join(path);
            std::fs::remove_file(&place)?;
            remove_empty(&self.folder, &place);
        }
        next.write(&staging, &self.folder)
    }
}

/// Why nothing was written over files.
pub fn not_ours(files: &[PathBuf]) -> Failure {
    let named: Vec<String> = files.iter().take(NAMED).map(|file| file.display().to_string()).collect();
    let more = files.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let what = if files.len() == 1 {
        "is there, and ltsc did not write it as it is"
    } else {
        "are there, and ltsc did not write them as they are"
    };
    let message = format!("{}{more} {what}; nothing was written", named.join(", "));
    Failure::new(Exit::Usage, message).help("choose another place, or add `--force` to write over what is there")
}

#[cfg(test)]
#[path = "pages_tests.rs"]
mod tests;
