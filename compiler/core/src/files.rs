//! The only two doors of the core: [`Files`] (bytes by path) and [`Sink`] (streams out), and their in-memory forms.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::ops::Deref;
use std::sync::Arc;

/// A path below the project root: parts joined by `/`, without `.`, `..` and empty parts.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VPath(String);

/// Why a path in a file is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathError {
    /// Empty, or it names a folder.
    Empty,
    /// `/x`, `C:\x` or a URL.
    Absolute,
    /// Contains `\`.
    Backslash,
    /// Leads out of the project root.
    Outside,
    /// Contains a control character.
    Control,
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "the path names no file",
            Self::Absolute => "the path is absolute",
            Self::Backslash => "the path contains a backslash",
            Self::Outside => "the path leads out of the project",
            Self::Control => "the path contains a control character",
        })
    }
}

impl VPath {
    /// The path `relative` as written in a file of folder `folder` (parts joined by `/`, empty for the root).
    pub fn resolve(folder: &str, relative: &str) -> Result<Self, PathError> {
        if relative.chars().any(char::is_control) {
            return Err(PathError::Control);
        }
        if relative.contains('\\') {
            return Err(PathError::Backslash);
        }
        let drive = relative.as_bytes().get(1) == Some(&b':');
        if relative.starts_with('/') || drive || relative.contains("://") {
            return Err(PathError::Absolute);
        }
        if relative.is_empty() || relative.ends_with('/') {
            return Err(PathError::Empty);
        }
        let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
        for part in relative.split('/') {
            match part {
                "" | "." => {}
                ".." => {
                    parts.pop().ok_or(PathError::Outside)?;
                }
                name => parts.push(name),
            }
        }
        if parts.is_empty() || relative.ends_with("..") {
            return Err(PathError::Empty);
        }
        Ok(Self(parts.join("/")))
    }

    /// The whole path.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The folder of the file, empty for the root.
    pub fn folder(&self) -> &str {
        self.0.rsplit_once('/').map_or("", |(folder, _)| folder)
    }

    /// The last part.
    pub fn name(&self) -> &str {
        self.0.rsplit_once('/').map_or(&self.0, |(_, name)| name)
    }

    /// The last part without its ending.
    pub fn stem(&self) -> &str {
        let name = self.name();
        name.rsplit_once('.').map_or(name, |(stem, _)| stem)
    }

    /// The ending of the last part in lower case, empty for none.
    pub fn extension(&self) -> String {
        self.name().rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_ascii_lowercase())
    }
}

impl fmt::Display for VPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The bytes of a file: a vector, a memory map, or anything that can be seen as bytes.
#[derive(Clone)]
pub struct Bytes(Arc<dyn AsRef<[u8]> + Send + Sync>);

impl Bytes {
    /// Shares `bytes`.
    pub fn new(bytes: impl AsRef<[u8]> + Send + Sync + 'static) -> Self {
        Self(Arc::new(bytes))
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        self
    }
}

impl fmt::Debug for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Bytes({})", self.len())
    }
}

/// Why a file could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// There is no such file; the names of files beside it, for suggestions.
    Missing {
        /// Files in the same folder, sorted; may be cut.
        beside: Vec<String>,
    },
    /// A link leads out of the project root.
    Outside,
    /// Larger than the limit in bytes.
    TooLarge {
        /// The file's size.
        size: u64,
        /// The limit.
        limit: u64,
    },
    /// What the system said.
    Other(String),
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { .. } => f.write_str("there is no such file"),
            Self::Outside => f.write_str("a link leads out of the project"),
            Self::TooLarge { size, limit } => write!(f, "the file has {size} bytes, more than the limit of {limit}"),
            Self::Other(text) => f.write_str(text),
        }
    }
}

/// Bytes by path.
pub trait Files: Sync {
    /// The bytes of the file at `path`, at most `limit` of them.
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError>;
}

/// Streams out. A file appears whole or not at all.
pub trait Sink {
    /// Writes the file at `path` (relative to the output folder, `/`) with what `write` writes. If `write` fails, the
    /// file is as it was before.
    fn file(&mut self, path: &str, write: &mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>) -> io::Result<()>;
}

/// [`Files`] in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    files: BTreeMap<String, Vec<u8>>,
}

impl MemoryFiles {
    /// Adds or replaces a file; `path` as in [`VPath::as_str`].
    pub fn insert(&mut self, path: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.files.insert(path.into(), bytes.into());
    }
}

impl Files for MemoryFiles {
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let Some(bytes) = self.files.get(path.as_str()) else {
            let folder = path.folder();
            let beside = self.files.keys().filter_map(|name| VPath::resolve("", name).ok());
            let beside = beside.filter(|other| other.folder() == folder).map(|other| other.name().to_owned());
            return Err(ReadError::Missing { beside: beside.collect() });
        };
        let size = bytes.len() as u64;
        if size > limit {
            return Err(ReadError::TooLarge { size, limit });
        }
        Ok(Bytes::new(bytes.clone()))
    }
}

/// [`Sink`] in memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemorySink {
    /// The files written, by path.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl Sink for MemorySink {
    fn file(&mut self, path: &str, write: &mut dyn FnMut(&mut dyn io::Write) -> io::Result<()>) -> io::Result<()> {
        let mut bytes = Vec::new();
        write(&mut bytes)?;
        self.files.insert(path.to_owned(), bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside() {
        let at = |folder, relative| VPath::resolve(folder, relative).map(|path| path.as_str().to_owned());
        assert_eq!(at("scenes/lib", "../meshes/./a.ply"), Ok("scenes/meshes/a.ply".to_owned()));
        assert_eq!(at("scenes", "../../etc/passwd"), Err(PathError::Outside));
        assert_eq!(at("", "/etc/passwd"), Err(PathError::Absolute));
        assert_eq!(at("", "C:/a.ply"), Err(PathError::Absolute));
        assert_eq!(at("", "a\\b.ply"), Err(PathError::Backslash));
        assert_eq!(at("", "a\0b.ply"), Err(PathError::Control));
        assert_eq!(at("a", ".."), Err(PathError::Empty));
        assert_eq!(at("a", ""), Err(PathError::Empty));
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let mut sink = MemorySink::default();
        let failed = sink.file("a", &mut |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("no"))
        });
        assert!(failed.is_err() && sink.files.is_empty());
    }
}
