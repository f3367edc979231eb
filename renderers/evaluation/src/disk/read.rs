//! [`DiskFiles`] reads below a root, and never outside of it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use ltsc_core::files::{Bytes, Files, ReadError, VPath};
use ltsc_render::regular;
use memmap2::Mmap;

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

    /// Opens the file at `path` and gives its size, for what is passed on rather than kept.
    ///
    /// # Errors
    /// If it is not there, leads out of the root, or is no regular file.
    pub fn open(&self, path: &VPath) -> Result<(File, u64), ReadError> {
        regular::open(&self.inside(path)?).map_err(|error| ReadError::Other(error.to_string()))
    }

    /// Where the file at `path` lies, without links, if that is below the root.
    fn inside(&self, path: &VPath) -> Result<PathBuf, ReadError> {
        let full = self.root.join(path.as_str());
        let real = fs::canonicalize(&full).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => ReadError::Missing { beside: beside(&full) },
            _ => ReadError::Other(error.to_string()),
        })?;
        if real.starts_with(&self.root) { Ok(real) } else { Err(ReadError::Outside) }
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
        bytes_of(&self.inside(path)?, limit)
    }
}

/// The bytes of a file that is there: mapped where that is worth it.
pub(super) fn bytes_of(path: &Path, limit: u64) -> Result<Bytes, ReadError> {
    let other = |error: io::Error| ReadError::Other(error.to_string());
    let (file, size) = regular::open(path).map_err(other)?;
    if size > limit {
        return Err(ReadError::TooLarge { size, limit });
    }
    if size < MAP_FROM {
        let mut bytes = Vec::with_capacity(size as usize);
        file.take(limit).read_to_end(&mut bytes).map_err(other)?;
        return Ok(Bytes::new(bytes));
    }
    #[expect(unsafe_code, reason = "memory maps are unsafe: another process could cut the file while it is read")]
    // SAFETY: the map is read-only and private to this process. A file that shrinks under it ends the process with a
    // bus error, as it does in the renderers that map their meshes; ltsc never writes a file that it reads.
    let map = unsafe { Mmap::map(&file) }.map_err(other)?;
    Ok(Bytes::new(map))
}

/// The disk with some files as they would be after a change.
pub struct Changed<'d> {
    /// What is on the disk.
    pub disk: &'d DiskFiles,
    /// What stands in the place of it.
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
pub(super) fn beside(path: &Path) -> Vec<String> {
    let Some(entries) = path.parent().and_then(|folder| fs::read_dir(folder).ok()) else { return Vec::new() };
    let names = entries.take(1000).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let sorted: BTreeSet<String> = names.collect();
    sorted.into_iter().collect()
}
