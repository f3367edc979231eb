//! The log of a renderer, beside an image or where the user wants it. Its last line says what is above it, so that a log as ltsc left it
//! tells itself from every other file.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ltsc_render::guard::{self, Held};
use ltsc_render::regular;

use super::pages::{is_absent, not_ours};
use super::place::{probe_file, unwritable};
use crate::failure::Failure;

/// What the last line begins with; the hash of all that is above follows.
const END: &str = "ltsc: the log ends here, BLAKE3 ";

/// The largest log that is looked at.
const LARGEST: u64 = 1 << 30;

/// A log that is being written; it gets its last line when this is dropped, or when a signal ends the process.
pub struct Log {
    path: PathBuf,
    _held: Held,
}

impl Log {
    /// Takes the place of a log at `path`. Another file than a log as ltsc left it is refused, unless `force`.
    pub fn begin(path: &Path, force: bool) -> Result<Self, Failure> {
        refuse(path, force)?;
        let made = path.to_path_buf();
        fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).map_err(|error| unwritable(path, &error))?;
        let make = || {
            match fs::remove_file(path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
            fs::File::create_new(path).map(|_| ())
        };
        let ((), held) = guard::hold(make, |()| move || end(&made)).map_err(|error| unwritable(path, &error))?;
        Ok(Self { path: path.to_path_buf(), _held: held })
    }
}

/// Refuses a place or a file that [`Log::begin`] refuses, before long work is done for it.
pub fn check(path: &Path, force: bool) -> Result<(), Failure> {
    probe_file(path)?;
    refuse(path, force)
}

fn refuse(path: &Path, force: bool) -> Result<(), Failure> {
    match fs::symlink_metadata(path) {
        Ok(meta) if force || meta.is_file() && is_whole(path) => Ok(()),
        Err(error) if is_absent(&error) => Ok(()),
        _ => Err(not_ours(&[path.to_path_buf()])),
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        end(&self.path);
    }
}

/// Adds to a log that is being written.
///
/// # Errors
/// If it cannot be written.
pub fn append(path: &Path, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = io::BufWriter::new(fs::File::options().append(true).open(path)?);
    write(&mut out)?;
    out.flush()
}

/// Adds the last line.
fn end(path: &Path) {
    if is_whole(path) {
        return;
    }
    let Ok(bytes) = regular::read(path, LARGEST) else { return };
    let Ok(mut file) = fs::File::options().append(true).open(path) else { return };
    let start = if bytes.last().is_none_or(|last| *last == b'\n') { "" } else { "\n" };
    let above = [&bytes, start.as_bytes()].concat();
    let _ended = writeln!(file, "{start}{END}{}", blake3::hash(&above).to_hex());
}

/// Whether a file is a log as it was left.
fn is_whole(path: &Path) -> bool {
    let Ok(bytes) = regular::read(path, LARGEST) else { return false };
    let Some(text) = bytes.strip_suffix(b"\n") else { return false };
    let start = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let wanted = format!("{END}{}", blake3::hash(&text[..start]).to_hex());
    &text[start..] == wanted.as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_log_as_it_was_left_is_begun_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.log");
        for text in ["", "one\n", "one\ntwo"] {
            let log = Log::begin(&path, false).expect("a log");
            fs::write(&path, text).expect("written");
            drop(log);
            assert!(fs::read_to_string(&path).expect("a log").starts_with(text) && is_whole(&path));
        }
        let quoted = fs::read_to_string(&path).expect("a log");
        for other in ["lts 1\n", "", &format!("I saw this:\n{quoted}"), &quoted.replace("two", "2")] {
            fs::write(&path, other).expect("written");
            assert!(Log::begin(&path, false).is_err(), "{other}");
            assert_eq!(fs::read_to_string(&path).expect("a file"), other);
        }
        drop(Log::begin(&path, true).expect("it is asked for"));
        assert!(is_whole(&path));
    }
}
