//! The disk: [`DiskFiles`] reads below a root, [`DiskSink`] writes folders that hold exactly what a scene became.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use ltsc_core::files::{Bytes, Files, ReadError, Sink, VPath};
use memmap2::Mmap;
use serde::{Deserialize, Serialize};
use tempfile::TempPath;

use crate::output::{Exit, Failure};

/// Files of this size and more are mapped, smaller ones read: a map costs more than a short copy.
const MAP_FROM: u64 = 1 << 16;

/// Reads files below a root folder; links that leave it are refused.
pub struct DiskFiles {
    /// Without links.
    root: PathBuf,
}

impl DiskFiles {
    /// Reads below `root`.
    pub fn new(root: &Path) -> io::Result<Self> {
        Ok(Self { root: fs::canonicalize(root)? })
    }

    /// Where the file at `path` lies, without links.
    pub fn real(&self, path: &VPath) -> io::Result<PathBuf> {
        fs::canonicalize(self.root.join(path.as_str()))
    }

    /// The path of `file` below the root, if it is there.
    pub fn path_of(&self, file: &Path) -> Option<VPath> {
        // The file itself may be missing: its folder tells where it would be.
        let whole = fs::canonicalize(file).or_else(|_| {
            let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            fs::canonicalize(folder).map(|folder| folder.join(file.file_name().unwrap_or_default()))
        });
        let below = whole.ok()?.strip_prefix(&self.root).ok()?.to_path_buf();
        let parts: Option<Vec<&str>> = below.components().map(|part| part.as_os_str().to_str()).collect();
        VPath::resolve("", &parts?.join("/")).ok()
    }
}

impl Files for DiskFiles {
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let full = self.root.join(path.as_str());
        let other = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => ReadError::Missing { beside: beside(&full) },
            _ => ReadError::Other(error.to_string()),
        };
        let real = fs::canonicalize(&full).map_err(other)?;
        if !real.starts_with(&self.root) {
            return Err(ReadError::Outside);
        }
        let meta = fs::metadata(&real).map_err(other)?;
        if !meta.is_file() {
            return Err(ReadError::Other(
                if meta.is_dir() { "it is a folder" } else { "it is no regular file" }.to_owned(),
            ));
        }
        let size = meta.len();
        if size > limit {
            return Err(ReadError::TooLarge { size, limit });
        }
        bytes_of(&real, size, limit).map_err(other)
    }
}

/// The bytes of a file of `size` bytes: mapped where that is worth it.
fn bytes_of(path: &Path, size: u64, limit: u64) -> io::Result<Bytes> {
    let file = File::open(path)?;
    if size < MAP_FROM {
        let mut bytes = Vec::with_capacity(size as usize);
        file.take(limit).read_to_end(&mut bytes)?;
        return Ok(Bytes::new(bytes));
    }
    #[expect(unsafe_code, reason = "memory maps are unsafe: another process could cut the file while it is read")]
    // SAFETY: the map is read-only and private to this process. A file that shrinks under it ends the process with a
    // bus error, as it does in the renderers that map their meshes; ltsc never writes a file that it reads.
    let map = unsafe { Mmap::map(&file) }?;
    Ok(Bytes::new(map))
}

/// The disk with some files as they would be after a change.
pub struct Changed<'d> {
    pub disk: &'d DiskFiles,
    pub texts: &'d BTreeMap<VPath, String>,
}

impl Files for Changed<'_> {
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        match self.texts.get(path) {
            Some(text) if text.len() as u64 > limit => Err(ReadError::TooLarge { size: text.len() as u64, limit }),
            Some(text) => Ok(Bytes::new(text.clone().into_bytes())),
            None => self.disk.read(path, limit),
        }
    }
}

/// Names in the same folder, for "did you mean".
fn beside(path: &Path) -> Vec<String> {
    let Some(entries) = path.parent().and_then(|folder| fs::read_dir(folder).ok()) else { return Vec::new() };
    let names = entries.take(1000).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let sorted: BTreeSet<String> = names.collect();
    sorted.into_iter().collect()
}

/// The name of the file that says which files of a folder are ours.
pub const MANIFEST: &str = "manifest.json";

/// Which files a folder holds, by path below it, and their content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always "ltsc".
    pub generator: String,
    /// The scene.
    pub scene: String,
    /// BLAKE3 of each file.
    pub files: BTreeMap<String, String>,
}

impl Manifest {
    /// The manifest of a folder; none where there is none of ours.
    pub fn read(folder: &Path) -> Option<Self> {
        let bytes = fs::read(folder.join(MANIFEST)).ok()?;
        let manifest: Self = serde_json::from_slice(&bytes).ok()?;
        (manifest.generator == "ltsc").then_some(manifest)
    }

    fn bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }
}

/// What happened, or with `check` would happen, to the files of a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Written, new or with other content.
    pub written: Vec<String>,
    /// Already as they should be.
    pub same: usize,
    /// Ours, and no longer part of the scene.
    pub removed: Vec<String>,
}

impl Changes {
    /// Whether there was nothing to do.
    pub fn is_empty(&self) -> bool {
        self.written.is_empty() && self.removed.is_empty()
    }
}

/// Writes one folder. Each file is compared with what is there and written, under another name, only where it differs; all
/// are renamed together by [`DiskSink::finish`]. A sink that is dropped leaves the folder as it was.
pub struct DiskSink {
    folder: PathBuf,
    check: bool,
    manifest: Manifest,
    changes: Changes,
    /// Files under their other names, by path below the folder.
    staged: BTreeMap<String, TempPath>,
}

impl DiskSink {
    /// Writes below `folder`; with `check` nothing is written. A folder with files of someone else's is refused unless
    /// `force`.
    pub fn new(folder: &Path, scene: &str, check: bool, force: bool) -> io::Result<Self> {
        if fs::metadata(folder).is_ok_and(|meta| !meta.is_dir()) {
            return Err(io::Error::new(io::ErrorKind::NotADirectory, "it is a file, not a folder"));
        }
        let occupied = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !check && !force && Manifest::read(folder).is_none() {
            let message = "the folder is not empty, and ltsc did not write it";
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, message));
        }
        let manifest = Manifest { generator: "ltsc".to_owned(), scene: scene.to_owned(), files: BTreeMap::new() };
        let folder = folder.to_path_buf();
        Ok(Self { folder, check, manifest, changes: Changes::default(), staged: BTreeMap::new() })
    }

    /// Leaves files that `keep` says yes to as the last writing left them.
    pub fn keep(&mut self, keep: impl Fn(&str) -> bool) {
        let before = Manifest::read(&self.folder).unwrap_or_default();
        let kept = before.files.into_iter().filter(|(path, _)| keep(path));
        self.manifest.files.extend(kept);
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
        let mut hasher = blake3::Hasher::new();
        for (path, hash) in self.manifest.files.iter().filter(|(path, _)| counts(path)) {
            // Lengths keep two different lists of files from looking alike.
            hasher.update(&(path.len() as u64).to_le_bytes());
            hasher.update(path.as_bytes());
            hasher.update(hash.as_bytes());
        }
        hasher.finalize()
    }

    /// Ends the folder: files get their names, those that were ours and are no longer part of it go, and the manifest is written.
    pub fn finish(mut self) -> io::Result<Changes> {
        for (path, staged) in std::mem::take(&mut self.staged) {
            staged.persist(self.folder.join(path)).map_err(|error| error.error)?;
        }
        let before = Manifest::read(&self.folder).unwrap_or_default();
        for path in before.files.keys().filter(|path| !self.manifest.files.contains_key(*path)) {
            // A manifest is a file like any other: it must not lead out of the folder.
            let Ok(inside) = VPath::resolve("", path) else { continue };
            let full = self.folder.join(inside.as_str());
            refuse_links(&self.folder, &full)?;
            if fs::symlink_metadata(&full).is_ok_and(|meta| meta.is_file()) {
                self.changes.removed.push(path.clone());
                if !self.check {
                    fs::remove_file(&full)?;
                    remove_empty_folders(&self.folder, &full);
                }
            }
        }
        let bytes = self.manifest.bytes();
        let same = fs::read(self.folder.join(MANIFEST)).is_ok_and(|old| old == bytes);
        if !same {
            self.changes.written.push(MANIFEST.to_owned());
            if !self.check {
                write_atomically(&self.folder.join(MANIFEST), &mut |out| out.write_all(&bytes))?;
            }
        }
        Ok(std::mem::take(&mut self.changes))
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
        if !self.check {
            self.staged.insert(path.to_owned(), written_beside(&full, write)?);
        }
        Ok(())
    }
}

impl Files for DiskSink {
    /// What the folder will hold: what was written, and what was there and is the same.
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let full = self.folder.join(path.as_str());
        let staged = self.staged.get(path.as_str());
        if staged.is_none() && !self.manifest.files.contains_key(path.as_str()) {
            return Err(ReadError::Missing { beside: beside(&full) });
        }
        let place = staged.map_or(full.as_path(), |staged| staged);
        let other = |error: io::Error| ReadError::Other(error.to_string());
        let size = fs::metadata(place).map_err(other)?.len();
        if size > limit {
            return Err(ReadError::TooLarge { size, limit });
        }
        bytes_of(place, size, limit).map_err(other)
    }
}

impl Drop for DiskSink {
    /// Folders that were made for files that are not to be are not to be either.
    fn drop(&mut self) {
        for (path, staged) in std::mem::take(&mut self.staged) {
            let _gone = staged.close();
            remove_empty_folders(&self.folder, &self.folder.join(path));
            // Fails where there is something in it.
            let _kept = fs::remove_dir(&self.folder);
        }
    }
}

/// Links to folders inside an output folder would lead out of it.
fn refuse_links(top: &Path, file: &Path) -> io::Result<()> {
    let inner = file.ancestors().skip(1).take_while(|folder| *folder != top && folder.starts_with(top));
    for folder in inner {
        if fs::symlink_metadata(folder).is_ok_and(|meta| meta.file_type().is_symlink()) {
            let message = format!("{} is a link, and ltsc writes inside its folder only", folder.display());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
    }
    Ok(())
}

/// Why an output folder cannot be written, and the exit code that it leads to.
pub fn unwritable(folder: &Path, error: &io::Error) -> Failure {
    let failure = Failure::new(Exit::Environment, format!("{}: {error}", folder.display()));
    match error.kind() {
        io::ErrorKind::AlreadyExists => Failure { exit: Exit::Usage, ..failure }
            .help("choose another folder with `-o`, or add `--force` to write into it"),
        io::ErrorKind::NotADirectory | io::ErrorKind::InvalidInput => {
            Failure { exit: Exit::Usage, ..failure }.help("choose another folder with `-o`")
        }
        _ => failure,
    }
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

/// Writes a file under another name in its folder and renames it.
pub fn write_atomically(path: &Path, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    written_beside(path, write)?.persist(path).map_err(|error| error.error)
}

/// Writes a file under another name in its folder, which goes away unless it is renamed.
fn written_beside(path: &Path, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<TempPath> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let temporary = tempfile::Builder::new().prefix(".ltsc-").permissions_of_files().tempfile_in(folder)?;
    let mut out = BufWriter::with_capacity(1 << 18, temporary);
    write(&mut out)?;
    Ok(out.into_inner().map_err(io::IntoInnerError::into_error)?.into_temp_path())
}

/// Temporary files are private; the files that they become are as any other new file.
trait PermissionsOfFiles {
    fn permissions_of_files(&mut self) -> &mut Self;
}

impl PermissionsOfFiles for tempfile::Builder<'_, '_> {
    #[cfg(unix)]
    fn permissions_of_files(&mut self) -> &mut Self {
        use std::os::unix::fs::PermissionsExt;
        // The process's mask takes away from these what it takes away from every new file.
        self.permissions(fs::Permissions::from_mode(0o666))
    }

    #[cfg(not(unix))]
    fn permissions_of_files(&mut self) -> &mut Self {
        self
    }
}

fn remove_empty_folders(top: &Path, file: &Path) {
    let mut folder = file.parent();
    while let Some(path) = folder.filter(|path| *path != top && path.starts_with(top)) {
        if fs::remove_dir(path).is_err() {
            break;
        }
        folder = path.parent();
    }
}

/// Compares what is written with a file, and hashes it.
struct Compare {
    old: Option<BufReader<File>>,
    buffer: Vec<u8>,
    hasher: blake3::Hasher,
}

impl Compare {
    fn new(path: &Path) -> Self {
        let old = File::open(path).ok().map(|file| BufReader::with_capacity(1 << 18, file));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_sink_that_is_dropped_leaves_what_was_there() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("scene");
        let path = VPath::resolve("", "target/a.txt").expect("a path");
        let write = |sink: &mut DiskSink, text: &'static [u8]| {
            sink.file("target/a.txt", &mut |out| out.write_all(text)).expect("a file");
            sink.read(&path, 100).map(|bytes| bytes.to_vec())
        };
        let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
        assert_eq!(
            write(&mut sink, b"first"),
            Ok(b"first".to_vec()),
            "what was written is read before it has its name"
        );
        drop(sink);
        assert_eq!(names(root.path()), Vec::<String>::new());
        let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
        assert_eq!(write(&mut sink, b"first"), Ok(b"first".to_vec()));
        sink.finish().expect("a folder");
        let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
        assert_eq!(write(&mut sink, b"second"), Ok(b"second".to_vec()));
        drop(sink);
        assert_eq!(fs::read(folder.join("target/a.txt")).expect("the first"), b"first");
        assert_eq!(
            (names(&folder), names(&folder.join("target"))),
            (vec![MANIFEST.to_owned(), "target".to_owned()], vec!["a.txt".to_owned()])
        );
        let mut sink = DiskSink::new(&folder, "scene", false, false).expect("a sink");
        assert_eq!(write(&mut sink, b"first"), Ok(b"first".to_vec()), "what is the same is read where it is");
        assert!(sink.finish().expect("a folder").is_empty());
    }
}
