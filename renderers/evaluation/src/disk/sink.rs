//! [`DiskSink`] writes folders that hold exactly what a scene became.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ltsc_core::files::{Bytes, Files, ReadError, Sink, VPath};

use ltsc_render::{guard, regular};

use super::manifest::{MANIFEST, Manifest};
use super::read::{beside, bytes_of};
use super::staging::{Staging, files_below};

/// What happened, or with `check` would happen, to the files of a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Written, new or with other content.
    pub written: Vec<String>,
    /// Already as they should be.
    pub same: usize,
    /// Ours, and no longer part of the scene.
    pub removed: Vec<String>,
    /// No longer part of the scene, but someone has changed them since they were written, so that they stay.
    pub kept: Vec<String>,
    /// Written anew, though someone had changed them since they were written; a folder that people may work in refuses that.
    pub restored: Vec<String>,
}

impl Changes {
    /// Whether there was nothing to do.
    pub fn is_empty(&self) -> bool {
        self.written.is_empty() && self.removed.is_empty()
    }
}

/// Where new files lie until the folder is whole.
enum Place {
    /// Nothing is written.
    Nowhere,
    /// In the folder itself, which no one else knows.
    Own,
    /// Beside the folder, which the new one replaces.
    Beside(Arc<Staging>),
    /// Within the folder, which cannot be replaced.
    Within(Staging),
}

/// Writes one folder. Each file is compared with what is there; where something differs, the whole folder is made anew beside the old
/// one (files that stay are linked, not copied) and takes its place in [`DiskSink::finish`]. A sink that is dropped leaves the folder
/// as it was.
pub struct DiskSink {
    folder: PathBuf,
    place: Place,
    /// Where new files lie; none as long as there are none.
    stage: Option<PathBuf>,
    force: bool,
    /// Whether people may work in the folder: what they have changed there is not written over.
    shared: bool,
    /// What the folder held when it was written last.
    before: Manifest,
    /// Files to write in the place of which there is something that ltsc did not write.
    foreign: Vec<String>,
    manifest: Manifest,
    changes: Changes,
    /// New files, by path below the folder.
    staged: BTreeSet<String>,
}

impl DiskSink {
    /// Writes below `folder`, in which people may work; with `check` nothing is written. What ltsc did not write, or not as it is
    /// now, is not written over unless `force`.
    pub fn new(folder: &Path, scene: &str, check: bool, force: bool) -> io::Result<Self> {
        refuse(folder, check, force)?;
        let place = if check { Place::Nowhere } else { place_of(folder)? };
        let mut sink = Self::at(folder, scene, place, force);
        sink.shared = true;
        Ok(sink)
    }

    /// Writes one of several folders with one place for what is not ready; nothing is written without it. These folders are all ours:
    /// files that were changed are written anew, and told.
    pub fn among(staging: Option<&Arc<Staging>>, folder: &Path, scene: &str, force: bool) -> io::Result<Self> {
        refuse(folder, staging.is_none(), force)?;
        let place = staging.map_or(Place::Nowhere, |staging| Place::Beside(Arc::clone(staging)));
        Ok(Self::at(folder, scene, place, force))
    }

    /// Writes into an empty folder that no one else knows, such as a temporary one.
    pub fn own(folder: &Path, scene: &str) -> Self {
        Self::at(folder, scene, Place::Own, false)
    }

    fn at(folder: &Path, scene: &str, place: Place, force: bool) -> Self {
        let manifest = Manifest { generator: "ltsc".to_owned(), scene: scene.to_owned(), ..Manifest::default() };
        let folder = folder.to_path_buf();
        let (changes, staged) = (Changes::default(), BTreeSet::new());
        let before = match &place {
            Place::Own => Manifest::default(),
            _ => Manifest::read(&folder).unwrap_or_default(),
        };
        let (stage, shared, foreign) = (None, false, Vec::new());
        Self { folder, place, stage, force, shared, before, foreign, manifest, changes, staged }
    }

    /// Leaves files that `keep` says yes to as the last writing left them.
    pub fn keep(&mut self, keep: impl Fn(&str) -> bool) {
        let kept = self.before.files.iter().filter(|(path, _)| keep(path));
        self.manifest.files.extend(kept.map(|(path, hash)| (path.clone(), hash.clone())));
    }

    /// Writes down which features the scene uses.
    pub fn features(&mut self, features: &[String]) {
        self.manifest.features = features.to_vec();
    }

    /// A sink for a folder inside this one.
    pub fn below(&mut self, name: &str) -> Below<'_> {
        Below { sink: self, prefix: format!("{name}/") }
    }

    /// What has changed so far.
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// A hash of the paths and contents of the files that `counts` says yes to.
    pub fn content(&self, counts: impl Fn(&str) -> bool) -> blake3::Hash {
        self.manifest.content(counts)
    }

    /// Ends the folder: what is new takes its place, those files that were ours and are no longer part of it go, and the manifest says
    /// what is ours now.
    pub fn finish(mut self) -> io::Result<Changes> {
        self.refuse_foreign()?;
        let before = std::mem::take(&mut self.before);
        for (path, hash) in before.files.iter().filter(|(path, _)| !self.manifest.files.contains_key(*path)) {
            // A manifest is a file like any other: it must not lead out of the folder.
            let Ok(inside) = VPath::resolve("", path) else { continue };
            let full = self.folder.join(inside.as_str());
            refuse_links(&self.folder, &full)?;
            if is_removable(&self.folder, path, hash) {
                self.changes.removed.push(path.clone());
            } else if fs::symlink_metadata(&full).is_ok_and(|meta| meta.is_file()) {
                let list = if self.force { &mut self.changes.removed } else { &mut self.changes.kept };
                list.push(path.clone());
            }
        }
        let bytes = self.manifest.bytes();
        if !regular::read(&self.folder.join(MANIFEST), bytes.len() as u64).is_ok_and(|old| old == bytes) {
            self.changes.written.push(MANIFEST.to_owned());
        }
        if !self.changes.is_empty() && !matches!(self.place, Place::Nowhere) {
            let stage = self.stage()?;
            fs::write(stage.join(MANIFEST), &bytes)?;
            self.settle(&stage)?;
        }
        Ok(std::mem::take(&mut self.changes))
    }

    /// Notices what is in the place of a file that is to be written.
    fn notice(&mut self, path: &str, full: &Path) {
        if matches!(self.place, Place::Own) || fs::symlink_metadata(full).is_err() {
            return;
        }
        match self.before.files.get(path) {
            None => self.foreign.push(path.to_owned()),
            Some(hash) if hash_of(full).as_ref() != Some(hash) => self.changes.restored.push(path.to_owned()),
            Some(_) => {}
        }
    }

    /// Refuses to write over what ltsc did not write, and in a folder in which people work also what was changed there.
    fn refuse_foreign(&self) -> io::Result<()> {
        let changed = if self.shared { &self.changes.restored[..] } else { &[] };
        if self.force || matches!(self.place, Place::Nowhere) {
            return Ok(());
        }
        let message = match (self.foreign.first(), changed.first()) {
            (Some(path), _) => format!("`{path}` is there, and ltsc did not write it"),
            (None, Some(path)) => format!("`{path}` was changed since ltsc wrote it"),
            (None, None) => return Ok(()),
        };
        Err(io::Error::new(io::ErrorKind::AlreadyExists, message))
    }

    /// Brings the new folder to its place.
    fn settle(&mut self, stage: &Path) -> io::Result<()> {
        match &self.place {
            Place::Nowhere | Place::Own => {}
            Place::Within(staging) => {
                staging.pour(stage)?;
                // What a person has changed is not known to be ours, and goes only where that is asked for.
                for path in self.changes.removed.iter() {
                    let _gone = fs::remove_file(self.folder.join(path));
                }
            }
            Place::Beside(staging) => {
                if let Ok(meta) = fs::metadata(&self.folder) {
                    self.carry(stage)?;
                    fs::set_permissions(stage, meta.permissions())?;
                }
                staging.replace(stage, &self.folder)?;
            }
        }
        self.stage = None;
        Ok(())
    }

    /// Gives the new folder all that stays: our files that are the same, and everything of someone else's.
    fn carry(&self, stage: &Path) -> io::Result<()> {
        guard::stop_if_ending();
        // As paths, since the disk may have another separator.
        let removed: BTreeSet<&Path> = self.changes.removed.iter().map(Path::new).collect();
        let staged: BTreeSet<&Path> = self.staged.iter().map(Path::new).chain([Path::new(MANIFEST)]).collect();
        for path in files_below(&self.folder)? {
            if staged.contains(path.as_path()) || removed.contains(path.as_path()) {
                continue;
            }
            let (from, to) = (self.folder.join(&path), stage.join(&path));
            fs::create_dir_all(to.parent().unwrap_or(stage))?;
            link(&from, &to)?;
        }
        Ok(())
    }

    fn stage(&mut self) -> io::Result<PathBuf> {
        if let Some(stage) = &self.stage {
            return Ok(stage.clone());
        }
        let stage = match &self.place {
            Place::Nowhere | Place::Own => self.folder.clone(),
            Place::Beside(staging) => staging.stage()?,
            Place::Within(staging) => staging.stage()?,
        };
        self.stage = Some(stage.clone());
        Ok(stage)
    }
}

impl Sink for DiskSink {
    fn file(&mut self, path: &str, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        let full = self.folder.join(path);
        refuse_links(&self.folder, &full)?;
        let mut out = BufWriter::with_capacity(1 << 18, Compare::new(&full));
        write(&mut out)?;
        let (same, hash) = out.into_inner().map_err(io::IntoInnerError::into_error)?.finish();
        self.manifest.files.insert(path.to_owned(), hash);
        if same {
            self.changes.same += 1;
            return Ok(());
        }
        self.changes.written.push(path.to_owned());
        self.notice(path, &full);
        if matches!(self.place, Place::Nowhere) {
            return Ok(());
        }
        guard::stop_if_ending();
        let new = self.stage()?.join(path);
        fs::create_dir_all(new.parent().unwrap_or(&self.folder))?;
        let mut out = BufWriter::with_capacity(1 << 18, File::create(&new)?);
        write(&mut out)?;
        out.into_inner().map_err(io::IntoInnerError::into_error)?;
        self.staged.insert(path.to_owned());
        Ok(())
    }
}

impl Files for DiskSink {
    /// What the folder will hold: what was written, and what was there and is the same.
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let full = self.folder.join(path.as_str());
        let staged = self.stage.as_ref().filter(|_| self.staged.contains(path.as_str()));
        if staged.is_none() && !self.manifest.files.contains_key(path.as_str()) {
            return Err(ReadError::Missing { beside: beside(&full) });
        }
        let place = staged.map_or(full, |stage| stage.join(path.as_str()));
        bytes_of(&place, limit)
    }
}

impl Drop for DiskSink {
    fn drop(&mut self) {
        if let (Some(stage), Place::Beside(_) | Place::Within(_)) = (&self.stage, &self.place) {
            let _gone = fs::remove_dir_all(stage);
        }
    }
}

/// Refuses what is no folder, a link to one, and, where something is to be written and unless `force`, one that ltsc did not write.
fn refuse(folder: &Path, check: bool, force: bool) -> io::Result<()> {
    let Ok(meta) = fs::symlink_metadata(folder) else { return Ok(()) };
    if meta.file_type().is_symlink() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is a link, and ltsc writes inside its own folders only",
        ));
    }
    if !meta.is_dir() {
        return Err(io::Error::new(io::ErrorKind::NotADirectory, "it is a file, not a folder"));
    }
    let occupied = fs::read_dir(folder)?.flatten().any(|entry| entry.file_name() != super::STAGING);
    if occupied && !check && !force && Manifest::read(folder).is_none() {
        let message = "the folder is not empty, and ltsc did not write it";
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, message));
    }
    Ok(())
}

/// Beside the folder, or within it where it cannot be replaced: where this process or its shell stands in it, and where nothing can be
/// made beside it.
fn place_of(folder: &Path) -> io::Result<Place> {
    let real = fs::canonicalize(folder).ok();
    let here = std::env::current_dir().and_then(fs::canonicalize).ok();
    let stands_in = matches!((&real, &here), (Some(real), Some(here)) if here.starts_with(real));
    let around = match (&real, folder.parent()) {
        (Some(real), _) => real.parent().map(Path::to_path_buf),
        (None, Some(parent)) if parent.as_os_str().is_empty() => Some(PathBuf::from(".")),
        (None, parent) => parent.map(Path::to_path_buf),
    };
    match around.filter(|_| !stands_in) {
        Some(around) => match Staging::of(&around) {
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied && real.is_some() => {
                Staging::of(folder).map(Place::Within)
            }
            other => other.map(|staging| Place::Beside(Arc::new(staging))),
        },
        None => Staging::of(folder).map(Place::Within),
    }
}

/// Whether a file below `top` is as its manifest says, by its hash, so that it may be removed.
pub(crate) fn is_removable(top: &Path, path: &str, hash: &str) -> bool {
    let Ok(inside) = VPath::resolve("", path) else { return false };
    let full = top.join(inside.as_str());
    if refuse_links(top, &full).is_err() || !fs::symlink_metadata(&full).is_ok_and(|meta| meta.is_file()) {
        return false;
    }
    hash_of(&full).is_some_and(|found| found == hash)
}

/// BLAKE3 of a regular file.
pub(super) fn hash_of(path: &Path) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    let (mut file, _) = regular::open(path).ok()?;
    io::copy(&mut file, &mut hasher).ok()?;
    Some(hasher.finalize().to_hex().to_string())
}

/// Links to folders inside an output folder would lead out of it.
pub(super) fn refuse_links(top: &Path, file: &Path) -> io::Result<()> {
    let inner = file.ancestors().skip(1).take_while(|folder| *folder != top && folder.starts_with(top));
    for folder in inner {
        if fs::symlink_metadata(folder).is_ok_and(|meta| meta.file_type().is_symlink()) {
            let message = format!("{} is a link, and ltsc writes inside its folder only", folder.display());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
    }
    Ok(())
}

/// One file in two places; where the system has no links, a copy.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    if fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    let meta = fs::symlink_metadata(from)?;
    if meta.is_file() {
        return fs::copy(from, to).map(|_| ());
    }
    #[cfg(unix)]
    if meta.file_type().is_symlink() {
        return std::os::unix::fs::symlink(fs::read_link(from)?, to);
    }
    let message = format!("{} cannot be kept in a folder that is written anew", from.display());
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

/// A folder inside the folder of a [`DiskSink`].
pub struct Below<'s> {
    sink: &'s mut DiskSink,
    prefix: String,
}

impl Sink for Below<'_> {
    fn file(&mut self, path: &str, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        self.sink.file(&format!("{}{path}", self.prefix), write)
    }
}

/// Compares what is written with a file, and hashes it.
struct Compare {
    old: Option<BufReader<File>>,
    buffer: Vec<u8>,
    hasher: blake3::Hasher,
}

impl Compare {
    /// What is no regular file differs from everything, and is not opened: a pipe would wait for ever.
    fn new(path: &Path) -> Self {
        let is_file = fs::symlink_metadata(path).is_ok_and(|meta| meta.is_file());
        let old = is_file.then(|| regular::open(path).ok()).flatten();
        let old = old.map(|(file, _)| BufReader::with_capacity(1 << 18, file));
        Self { old, buffer: Vec::new(), hasher: blake3::Hasher::new() }
    }

    fn finish(mut self) -> (bool, String) {
        let ended = self.old.as_mut().is_some_and(|old| old.read(&mut [0]).is_ok_and(|more| more == 0));
        (ended, self.hasher.finalize().to_hex().to_string())
    }
}

impl Write for Compare {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.hasher.update(bytes);
        if let Some(old) = &mut self.old {
            self.buffer.resize(bytes.len(), 0);
            if old.read_exact(&mut self.buffer).is_err() || self.buffer != bytes {
                self.old = None;
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
