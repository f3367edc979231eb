//! Where the user's cache lies, and files that appear only when they are whole.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::env::Env;

/// The folder that holds everything ltsc can make again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CachePaths {
    /// The folder itself; it need not exist.
    pub root: PathBuf,
}

impl CachePaths {
    /// `$LTSC_CACHE`, else the place that the system has for caches; nothing if the system names
    /// no home.
    #[must_use]
    pub fn find(env: &Env) -> Option<Self> {
        let folder = |name: &str| env.get(name).map(PathBuf::from);
        // The specification says that a relative value is to be ignored.
        let xdg = || folder("XDG_CACHE_HOME").filter(|path| path.is_absolute());
        let root = folder("LTSC_CACHE").or_else(|| {
            if cfg!(windows) {
                folder("LOCALAPPDATA").map(|path| path.join("ltsc").join("cache"))
            } else if cfg!(target_os = "macos") {
                xdg()
                    .map(|path| path.join("ltsc"))
                    .or_else(|| folder("HOME").map(|home| home.join("Library").join("Caches").join("ltsc")))
            } else {
                xdg().or_else(|| folder("HOME").map(|home| home.join(".cache"))).map(|path| path.join("ltsc"))
            }
        })?;
        Some(Self { root })
    }

    /// Private installations of renderers.
    #[must_use]
    pub fn renderers(&self) -> PathBuf {
        self.root.join("renderers")
    }

    /// The private installation of one version of a renderer.
    #[must_use]
    pub fn renderer(&self, name: &str, version: &str) -> PathBuf {
        self.renderers().join(format!("{name}-{version}"))
    }
}

/// Writes a file under a temporary name in the same folder and renames it, so that nobody ever
/// sees half of it. The folder must exist.
pub(crate) fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ltsc-");
    // Temporary files are private by default; a result should be as readable as any other file,
    // and the system still takes away what the user's mask says.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    write(file.as_file_mut())?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cache_follows_the_variables_in_order() {
        let root = |vars: &[(&str, &str)]| CachePaths::find(&Env::of(vars)).map(|paths| paths.root);
        let all = [("LTSC_CACHE", "/a"), ("XDG_CACHE_HOME", "/b"), ("HOME", "/c")];
        assert_eq!(root(&all), Some(PathBuf::from("/a")));
        assert_eq!(root(&[]), None);
        if cfg!(all(unix, not(target_os = "macos"))) {
            assert_eq!(root(&all[1..]), Some(PathBuf::from("/b/ltsc")));
            assert_eq!(root(&all[2..]), Some(PathBuf::from("/c/.cache/ltsc")));
            let relative = [("XDG_CACHE_HOME", "b"), ("HOME", "/c")];
            assert_eq!(root(&relative), Some(PathBuf::from("/c/.cache/ltsc")));
            let empty = [("LTSC_CACHE", ""), ("HOME", "/c")];
            assert_eq!(root(&empty), Some(PathBuf::from("/c/.cache/ltsc")));
        }
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("file");
        std::fs::write(&path, "old").expect("write");
        let result = replace_file(&path, |_| Err(io::Error::other("no")));
        assert!(result.is_err());
        assert_eq!(std::fs::read(&path).expect("read"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("list").count(), 1);
    }
}
