//! Places that cannot be written: one cause has one exit code and one hint, whatever command meets it.

use std::fs;
use std::io;
use std::path::Path;

use super::staging::Staging;
use crate::failure::{Exit, Failure, why};

const ANOTHER: &str = "choose another place";

/// Why `path` cannot be written, and the exit code that it leads to: 2 for a place that cannot be meant, 4 where the system refuses.
pub fn unwritable(path: &Path, error: &io::Error) -> Failure {
    let failure = |exit, why: String| Failure::new(exit, format!("{} cannot be written: {why}", path.display()));
    let (usage, environment) = (|why| failure(Exit::Usage, why), |why| failure(Exit::Environment, why));
    // The system's word for a file in the way depends on the call that met it. Its number tells it from a word of ours.
    let met = error.kind() == io::ErrorKind::AlreadyExists && error.raw_os_error().is_some() && !path.is_dir();
    if let Some(file) = file_in_the_way(path).or(met.then_some(path)) {
        return usage(format!("{} is a file, not a folder", file.display())).help(ANOTHER);
    }
    let around = nearest_there(path).display().to_string();
    match error.kind() {
        io::ErrorKind::AlreadyExists => {
            usage(error.to_string()).help(format!("{ANOTHER}, or add `--force` to write over what is there"))
        }
        io::ErrorKind::NotADirectory | io::ErrorKind::IsADirectory | io::ErrorKind::InvalidInput => {
            usage(why(error)).help(ANOTHER)
        }
        io::ErrorKind::InvalidFilename => usage("its name is too long, or not allowed".to_owned()).help(ANOTHER),
        io::ErrorKind::PermissionDenied => environment(format!("you have no right to write in {around}"))
            .help(format!("{ANOTHER}, or change the permissions")),
        io::ErrorKind::ReadOnlyFilesystem => {
            environment(format!("{around} is on a disk that is read-only")).help(ANOTHER)
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            environment(format!("no space is left ({})", why(error))).help(format!("free some space, or {ANOTHER}"))
        }
        // Folders that are missing are made, so that this is no folder in which files can be made.
        io::ErrorKind::NotFound => environment(format!("the system makes no files in {around}")).help(ANOTHER),
        _ => environment(why(error)).help(ANOTHER),
    }
}

/// Refuses a folder in which nothing can be written, before long work is done for it. What is missing of it is made and removed again.
pub fn probe(folder: &Path) -> Result<(), Failure> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    Staging::of(folder).map(drop).map_err(|error| unwritable(folder, &error))
}

/// [`probe`] of the folder in which a file is to lie.
pub fn probe_file(file: &Path) -> Result<(), Failure> {
    if file.is_dir() {
        return Err(Failure::new(Exit::Usage, format!("{} cannot be written: it is a folder", file.display()))
            .help("name a file in it"));
    }
    probe(file.parent().unwrap_or(Path::new(".")))
}

/// Why there is no temporary folder.
pub fn no_temporary(error: &io::Error) -> Failure {
    Failure::new(Exit::Environment, format!("no temporary folder can be made: {}", why(error)))
        .help("set TMPDIR to a folder that can be written")
}

/// What stands above `path` and is no folder.
fn file_in_the_way(path: &Path) -> Option<&Path> {
    let there = |path: &&Path| fs::metadata(path).is_ok();
    path.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty()).find(there).filter(|path| !path.is_dir())
}

/// The nearest folder upward that is there, the path itself included.
fn nearest_there(path: &Path) -> &Path {
    path.ancestors().find(|folder| folder.is_dir()).unwrap_or(Path::new("."))
}
