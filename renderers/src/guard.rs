//! What is half done, and how it is put back: temporary folders, running programs, places that are being written.
//!
//! Whoever makes such a thing holds it here. Usually it ends by itself, and [`Held`] is dropped. Where a signal ends the process
//! first, [`put_back`] undoes all of it, the newest first, and no other thread goes on from there.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempDir;

type Undo = Box<dyn FnOnce() + Send>;

/// What is half done, in the order in which it was begun.
struct List {
    next: u64,
    undo: BTreeMap<u64, Undo>,
    /// Temporary folders among it; whoever outlives this process removes them.
    folders: BTreeMap<u64, PathBuf>,
}

static LIST: Mutex<List> = Mutex::new(List { next: 0, undo: BTreeMap::new(), folders: BTreeMap::new() });

static ENDING: AtomicBool = AtomicBool::new(false);

fn list() -> MutexGuard<'static, List> {
    LIST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Something half done; once this is dropped, it is done, or its owner has undone it.
#[derive(Debug)]
#[must_use]
pub struct Held(u64);

impl Drop for Held {
    fn drop(&mut self) {
        let mut list = list();
        let _done = list.undo.remove(&self.0);
        list.folders.remove(&self.0);
    }
}

/// Makes something together with how it is undone. No signal comes in between.
///
/// # Errors
/// That of `make`.
pub fn hold<T, U: FnOnce() + Send + 'static>(
    make: impl FnOnce() -> io::Result<T>,
    undo: impl FnOnce(&T) -> U,
) -> io::Result<(T, Held)> {
    let mut list = list();
    if ENDING.load(Ordering::SeqCst) {
        drop(list);
        stop_if_ending();
        return Err(io::ErrorKind::Interrupted.into());
    }
    let made = make()?;
    let number = list.next;
    list.next += 1;
    list.undo.insert(number, Box::new(undo(&made)));
    Ok((made, Held(number)))
}

/// A temporary folder that is gone when this is dropped, or when a signal ends the process.
pub struct Folder {
    // Removed first, while it is still held.
    folder: TempDir,
    _held: Held,
}

impl Folder {
    /// Makes one.
    ///
    /// # Errors
    /// If none can be made.
    pub fn new() -> io::Result<Self> {
        let make = || tempfile::Builder::new().prefix("ltsc-").tempdir();
        let (folder, held) = hold(make, |folder| {
            let path = folder.path().to_owned();
            move || remove(&path)
        })?;
        list().folders.insert(held.0, folder.path().to_owned());
        Ok(Self { folder, _held: held })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// The temporary folders that are there now.
pub(crate) fn folders() -> Vec<PathBuf> {
    list().folders.values().cloned().collect()
}

/// Removes a folder in which something may still be written.
pub(crate) fn remove(folder: &Path) {
    for _ in 0..50 {
        match std::fs::remove_dir_all(folder) {
            Ok(()) => return,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return,
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(10)),
        }
    }
}

/// Undoes all that is half done. The process must end now: whoever asks [`stop_if_ending`] waits for that.
pub fn put_back() {
    let undo = {
        let mut list = list();
        ENDING.store(true, Ordering::SeqCst);
        std::mem::take(&mut list.undo)
    };
    for (_, undo) in undo.into_iter().rev() {
        undo();
    }
}

/// Does not come back where a signal is ending the process: what happens from then on is no result, and nobody must hear of it.
pub fn stop_if_ending() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`put_back`] itself ends a process, so the tests of the binary try it.
    #[test]
    fn a_folder_is_known_as_long_as_it_is_there() {
        let folder = Folder::new().expect("a folder");
        let path = folder.path().to_owned();
        assert!(path.is_dir() && folders().contains(&path));
        drop(folder);
        assert!(!path.exists() && !folders().contains(&path));
    }
}
