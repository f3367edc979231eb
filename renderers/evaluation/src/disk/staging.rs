//! Where folders are made before they take their place: `.ltsc` beside them, held by one process at a time.
//!
//! A folder is written there as a whole and then changes places with the one that is there, in one step where the system has it
//! (Linux, macOS). Elsewhere the old one is moved aside first, and the next run puts it back if nothing took its place. What a run that
//! was killed has left here is ours, and the next one removes it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use ltsc_render::guard::{self, Held};
use ltsc_render::regular;

use super::manifest::{MANIFEST, Manifest};
use super::notice::say;
use super::sink::is_removable;

/// The name of the folder.
pub const STAGING: &str = ".ltsc";

const LOCK: &str = "lock";

/// Keeps what a killed run has left out of commits.
const IGNORE: &str = ".gitignore";

/// What an old folder is called while the new one takes its place.
const OLD: &str = "old-";

/// Files that are ready to be moved into a folder that cannot be replaced.
const READY: &str = "ready";

/// How long another process is waited for before a word is said.
const SILENT: Duration = Duration::from_secs(1);

/// How often a lock that others remove at the same time is taken anew.
const TRIES: usize = 10_000;

/// The place beside folders that are being written, held by this process until it is dropped.
pub struct Staging {
    /// The folder in which the folders lie.
    around: PathBuf,
    /// The lock goes with its file.
    _lock: Option<File>,
    next: AtomicU64,
    /// Folders that were not there before, the outermost first.
    made: Vec<PathBuf>,
    _held: Held,
}

impl Staging {
    /// Takes the place for the folders in `around`, which is made if need be, and puts in order what a killed run has left there. Another
    /// process that has it is waited for.
    pub fn of(around: &Path) -> io::Result<Self> {
        let mut made: Vec<PathBuf> = around
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists())
            .map(PathBuf::from)
            .collect();
        made.reverse();
        let mine = Arc::new(AtomicBool::new(false));
        let undo = {
            let (place, made, mine) = (around.to_path_buf(), made.clone(), Arc::clone(&mine));
            move || put_back(&place, &made, &mine)
        };
        let ((), held) = guard::hold(|| Ok(()), |()| undo)?;
        fs::create_dir_all(around)?;
        let lock = locked(around)?;
        mine.store(true, Ordering::SeqCst);
        let staging = Self { around: around.to_path_buf(), _lock: lock, next: AtomicU64::new(0), made, _held: held };
        staging.recover()?;
        Ok(staging)
    }

    fn folder(&self) -> PathBuf {
        self.around.join(STAGING)
    }

    /// A new empty folder here.
    pub(super) fn stage(&self) -> io::Result<PathBuf> {
        guard::stop_if_ending();
        let stage = self.folder().join(self.next.fetch_add(1, Ordering::Relaxed).to_string());
        fs::create_dir(&stage)?;
        Ok(stage)
    }

    /// Lets a folder made by [`Staging::stage`] take the place of `folder`, and removes the one that was there.
    pub(super) fn replace(&self, stage: &Path, folder: &Path) -> io::Result<()> {
        let moving = moving();
        if fs::symlink_metadata(folder).is_err() {
            return fs::rename(stage, folder);
        }
        if exchange(stage, folder)? {
            drop(moving);
            return fs::remove_dir_all(stage);
        }
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let old = self.folder().join(format!("{OLD}{name}"));
        fs::rename(folder, &old)?;
        if let Err(error) = fs::rename(stage, folder) {
            fs::rename(&old, folder)?;
            return Err(error);
        }
        fs::remove_dir_all(&old)
    }

    /// Moves the files of a folder made by [`Staging::stage`] into `around` itself, which cannot be replaced: the folder in which a
    /// shell stands. A run that is killed here is continued by the next one.
    pub(super) fn pour(&self, stage: &Path) -> io::Result<()> {
        let _moving = moving();
        fs::rename(stage, self.folder().join(READY))?;
        self.pour_ready()
    }

    /// Makes one file at `to`, which lies below `around`, by a function that is told where to write it: it appears as a whole.
    pub fn put<E: From<io::Error>>(&self, to: &Path, make: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
        let stage = self.stage()?;
        let new = stage.join("file");
        make(&new)?;
        let _moving = moving();
        fs::rename(&new, to)?;
        Ok(fs::remove_dir(&stage)?)
    }

    fn pour_ready(&self) -> io::Result<()> {
        let ready = self.folder().join(READY);
        // The manifest is moved last: without it all is in its place, and nothing may be taken for left over.
        let Some(new) = Manifest::read(&ready) else { return fs::remove_dir_all(&ready) };
        if let Some(old) = Manifest::read(&self.around) {
            for (path, hash) in old.files.iter().filter(|(path, _)| !new.files.contains_key(*path)) {
                if is_removable(&self.around, path, hash) {
                    fs::remove_file(self.around.join(path))?;
                    remove_empty(&self.around, &self.around.join(path));
                }
            }
        }
        for path in files_below(&ready)?.into_iter().filter(|path| path != Path::new(MANIFEST)) {
            let to = self.around.join(&path);
            fs::create_dir_all(to.parent().unwrap_or(&self.around))?;
            fs::rename(ready.join(&path), to)?;
        }
        // Until here the old manifest tells what is left to do.
        fs::rename(ready.join(MANIFEST), self.around.join(MANIFEST))?;
        fs::remove_dir_all(&ready)
    }

    /// Finishes or removes what a killed run has left.
    fn recover(&self) -> io::Result<()> {
        for entry in fs::read_dir(self.folder())? {
            let (path, name) = entry.map(|entry| (entry.path(), entry.file_name().to_string_lossy().into_owned()))?;
            if name == LOCK || name == IGNORE {
                continue;
            }
            let place = name.strip_prefix(OLD).map(|name| self.around.join(name));
            match place {
                Some(place) if fs::symlink_metadata(&place).is_err() => fs::rename(&path, &place)?,
                _ if name == READY => self.pour_ready()?,
                _ if path.is_dir() => fs::remove_dir_all(&path)?,
                _ => fs::remove_file(&path)?,
            }
        }
        Ok(())
    }
}

impl Drop for Staging {
    /// Leaves nothing behind. What cannot be removed is removed by the next run.
    fn drop(&mut self) {
        clean(&self.around, &self.made);
    }
}

fn clean(around: &Path, made: &[PathBuf]) {
    let folder = around.join(STAGING);
    for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if name != LOCK && name != IGNORE {
            let _gone = fs::remove_dir_all(entry.path());
        }
    }
    // Who waits for the lock sees that its file is another one, and begins anew.
    for name in [IGNORE, LOCK] {
        let _gone = fs::remove_file(folder.join(name));
    }
    let _gone = fs::remove_dir(&folder);
    // Fails where something was written.
    for folder in made.iter().rev() {
        let _kept = fs::remove_dir(folder);
    }
}

/// What [`Staging`] does when it is dropped, where a signal ends the process first.
fn put_back(around: &Path, made: &[PathBuf], mine: &AtomicBool) {
    // Nothing is moved from here on, so that nothing is half moved.
    std::mem::forget(moving());
    if !mine.load(Ordering::SeqCst) && !left_over(around) {
        return;
    }
    // Other threads may be about to write a last file.
    for _ in 0..20 {
        clean(around, made);
        thread::sleep(Duration::from_millis(10));
        if !around.join(STAGING).exists() {
            return;
        }
    }
}

/// Held while names change, so that a signal does not come in between.
fn moving() -> MutexGuard<'static, ()> {
    static MOVING: Mutex<()> = Mutex::new(());
    MOVING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes one file by a function that is told where to write it: it appears as a whole, in the place of whatever is there.
fn put<E: From<io::Error>>(path: &Path, make: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Staging::of(folder)?.put(path, make)
}

/// The same from a stream.
pub fn write_whole(path: &Path, write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    put(path, |new| {
        let mut out = io::BufWriter::with_capacity(1 << 18, File::create(new)?);
        write(&mut out)?;
        out.into_inner().map(|_| ()).map_err(io::IntoInnerError::into_error)
    })
}

/// Whether a killed run has left something in `around`. Where another process is writing there, nothing is left over yet.
pub fn left_over(around: &Path) -> bool {
    let Ok((lock, _)) = regular::open(&around.join(STAGING).join(LOCK)) else { return around.join(STAGING).is_dir() };
    lock.try_lock().is_ok()
}

/// The lock of the place in `around`; none on a system of files without locks.
fn locked(around: &Path) -> io::Result<Option<File>> {
    let folder = around.join(STAGING);
    let (start, mut said) = (Instant::now(), false);
    for _ in 0..TRIES {
        guard::stop_if_ending();
        match fs::create_dir(&folder) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
            _ => {}
        }
        if fs::symlink_metadata(&folder).is_ok_and(|meta| !meta.is_dir()) {
            let message = format!("{} is no folder", folder.display());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        // Another process may just have removed the folder. Windows locks no file that is open only to be added to.
        let gone = |error: &io::Error| error.kind() == io::ErrorKind::NotFound;
        let lock = match File::options().read(true).create(true).append(true).open(folder.join(LOCK)) {
            Err(error) if gone(&error) => continue,
            other => other?,
        };
        loop {
            match lock.try_lock() {
                Ok(()) => break,
                Err(fs::TryLockError::Error(_)) => return Ok(None),
                Err(fs::TryLockError::WouldBlock) => {
                    if !said && start.elapsed() > SILENT {
                        say(&format!("waiting for another ltsc that writes in {}", around.display()));
                        said = true;
                    }
                    thread::sleep(Duration::from_millis(10));
                }
            }
        }
        if !is_there(&lock, &folder.join(LOCK)) {
            continue;
        }
        match File::create(folder.join(IGNORE)).and_then(|mut file| file.write_all(b"*\n")) {
            Err(error) if gone(&error) => continue,
            other => other?,
        }
        return Ok(Some(lock));
    }
    Err(io::Error::new(io::ErrorKind::WouldBlock, "other processes take and give back this folder all the time"))
}

/// Whether an open file is still the one at `path`.
#[cfg(unix)]
fn is_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(one), Ok(other)) = (file.metadata(), fs::metadata(path)) else { return false };
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// Elsewhere files that are open cannot be removed.
#[cfg(not(unix))]
fn is_there(_file: &File, path: &Path) -> bool {
    path.is_file()
}

/// Lets two folders change places in one step; false where the system cannot do that.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
fn exchange(one: &Path, other: &Path) -> io::Result<bool> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(true),
        Err(Errno::NOSYS | Errno::INVAL | Errno::NOTSUP) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
fn exchange(_one: &Path, _other: &Path) -> io::Result<bool> {
    Ok(false)
}

/// All that is no folder, by its path below `top`, in order; links are not followed.
pub(super) fn files_below(top: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(inner) = open.pop() {
        for entry in fs::read_dir(top.join(&inner))? {
            let entry = entry?;
            let path = inner.join(entry.file_name());
            if entry.file_type()?.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    Ok(found)
}

/// Removes the folders of a file that is gone, as far as they are empty, up to `top`.
pub(super) fn remove_empty(top: &Path, file: &Path) {
    let inner = file.ancestors().skip(1).take_while(|folder| *folder != top && folder.starts_with(top));
    for folder in inner {
        if fs::remove_dir(folder).is_err() {
            break;
        }
    }
}

#[cfg(test)]
#[path = "staging_tests.rs"]
mod tests;
