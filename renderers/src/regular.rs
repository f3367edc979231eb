//! The one way to read a file: regular files only, up to a bound. A pipe would wait for ever, a device has no end.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// The most bytes of a text that ltsc itself or a person has written: a project file, a page, a record.
pub const TEXT: u64 = 64 << 20;

/// The most bytes for which memory is asked before there is anything to put there.
const MOST_AT_ONCE: u64 = 1 << 30;

/// Opens a regular file, and gives its size. Links are followed.
///
/// # Errors
/// If it is not there, cannot be read, or is something else.
pub fn open(path: &Path) -> io::Result<(File, u64)> {
    let refused = |meta: &fs::Metadata| {
        let what = if meta.is_dir() { "it is a folder" } else { "it is no regular file" };
        io::Error::new(io::ErrorKind::InvalidInput, what)
    };
    // Some devices do something when they are opened.
    let meta = fs::metadata(path)?;
    if !meta.is_file() {
        return Err(refused(&meta));
    }
    let mut options = File::options();
    options.read(true);
    // Should a pipe have taken its place, this does not wait for a writer.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, rustix::fs::OFlags::NONBLOCK.bits() as i32);
    let file = options.open(path)?;
    let meta = file.metadata()?;
    if meta.is_file() { Ok((file, meta.len())) } else { Err(refused(&meta)) }
}

/// The content of a regular file of at most `limit` bytes.
///
/// # Errors
/// As of [`open`], and if it is larger.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (file, size) = open(path)?;
    // A size is a claim: a file may be one hole.
    let mut bytes = Vec::with_capacity(size.min(limit).min(MOST_AT_ONCE) as usize);
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {limit} bytes")));
    }
    Ok(bytes)
}

/// The same as text.
///
/// # Errors
/// As of [`read`], and if it is no UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    let wrong = |_| io::Error::new(io::ErrorKind::InvalidData, "it is not a text in UTF-8");
    String::from_utf8(read(path, limit)?).map_err(wrong)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_a_size_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = |name: &str| folder.path().join(name);
        fs::write(place("text"), "1234").expect("written");
        std::os::unix::fs::symlink(place("text"), place("link")).expect("a link");
        std::os::unix::fs::symlink("/dev/zero", place("zero")).expect("a link");
        rustix::fs::mknodat(rustix::fs::CWD, place("pipe"), rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
            .expect("a pipe");
        let _socket = std::os::unix::net::UnixListener::bind(place("socket")).expect("a socket");
        assert_eq!(read(&place("link"), 4).expect("read"), b"1234");
        assert_eq!(read(&place("text"), 3).expect_err("too large").kind(), io::ErrorKind::FileTooLarge);
        for name in ["zero", "pipe", "socket", ""] {
            assert_eq!(read(&place(name), 9).expect_err(name).kind(), io::ErrorKind::InvalidInput, "{name}");
        }
    }
}
