//! Rewriting a person's file, by the formatter and by fixes: its rights, its other names and its place stay as they are.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Puts `text` in the place of a file's content. A file that is not to be written stays, one with other names keeps them, and one that
/// a link leads to out of `root` is refused. A file without other names is replaced in one step.
pub fn rewrite(path: &Path, root: &Path, text: &[u8]) -> io::Result<()> {
    let real = fs::canonicalize(path)?;
    if !real.starts_with(fs::canonicalize(root)?) {
        let message = format!("it is a link out of {}", root.display());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let meta = fs::metadata(&real)?;
    if !meta.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no regular file"));
    }
    // Whoever may not write it here is told so: replacing it would need no right to it, only to its folder.
    let file = File::options().write(true).open(&real)?;
    if meta.permissions().readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is not to be written"));
    }
    let folder = real.parent().unwrap_or(Path::new("."));
    let mut new = tempfile::Builder::new().prefix(".ltsc-").tempfile_in(folder)?;
    new.write_all(text)?;
    if has_other_names(&meta) {
        // The disk has room for it, as the copy shows.
        drop(new);
        let mut file = file;
        file.write_all(text)?;
        return file.set_len(text.len() as u64);
    }
    new.as_file().set_permissions(meta.permissions())?;
    keep_owner(new.path(), &meta);
    new.persist(&real).map(|_| ()).map_err(|error| error.error)
}

#[cfg(unix)]
fn has_other_names(meta: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    meta.nlink() > 1
}

#[cfg(not(unix))]
fn has_other_names(_meta: &fs::Metadata) -> bool {
    false
}

/// Root formats the files of others, and they stay theirs.
#[cfg(unix)]
fn keep_owner(path: &Path, meta: &fs::Metadata) {
    use std::os::unix::fs::MetadataExt;
    let _as_it_is = std::os::unix::fs::chown(path, Some(meta.uid()), Some(meta.gid()));
}

#[cfg(not(unix))]
fn keep_owner(_path: &Path, _meta: &fs::Metadata) {}
