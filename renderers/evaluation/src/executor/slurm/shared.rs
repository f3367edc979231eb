//! The folder that all machines share: `jobs/<identity>/`, what was written for renderers, and `runs/<name>/`, what an ltsc that waits
//! has submitted. A run is held by a lock, which the system lets go when the process ends, however it does.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use ltsc_core::files::Sink;
use ltsc_render::regular;

use super::task::List;
use crate::disk::{DiskSink, Manifest, Staging, unwritable, write_whole};
use crate::failure::{Exit, Failure};
use crate::job::Job;

const LOCK: &str = "held";
const SCRIPT: &str = "task.sh";

/// The folder.
#[derive(Clone, Debug)]
pub struct Shared {
    root: PathBuf,
}

/// What one ltsc has submitted.
#[derive(Debug)]
pub struct Run {
    /// Its folder.
    pub folder: PathBuf,
    /// What the names of its arrays begin with.
    pub name: String,
    _lock: File,
}

impl Shared {
    /// A folder that is there.
    pub fn at(root: &Path) -> Result<Self, Failure> {
        let root = std::path::absolute(root).map_err(|error| unwritable(root, &error))?;
        if !root.is_dir() {
            // A misspelt one would be made on this machine alone.
            return Err(Failure::new(Exit::Usage, format!("{}: there is no such folder", root.display()))
                .help("make it where all machines of the cluster see it"));
        }
        Ok(Self { root })
    }

    /// Where it is.
    pub fn root(&self) -> &Path {
        &self.root
    }

    fn jobs(&self) -> PathBuf {
        self.root.join("jobs")
    }

    fn runs(&self) -> PathBuf {
        self.root.join("runs")
    }

    /// Where the files of a job are.
    pub fn job(&self, identity: &str) -> PathBuf {
        self.jobs().join(identity)
    }

    /// Held by one ltsc at a time, while it adds or removes jobs and runs.
    fn staging(&self) -> io::Result<Arc<Staging>> {
        Staging::of(&self.jobs()).map(Arc::new)
    }

    /// Begins a run whose tasks call `program`.
    pub fn begin(&self, program: &Path) -> io::Result<Run> {
        let _staging = self.staging()?;
        fs::create_dir_all(self.runs())?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO);
        let start = now.as_nanos() as u64 ^ u64::from(std::process::id()) << 40;
        let (folder, name) = (start..)
            .map(|number| {
                let name = format!("ltsc-{:012x}", number & 0xffff_ffff_ffff);
                (self.runs().join(&name), name)
            })
            .find_map(|(folder, name)| match fs::create_dir(&folder) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => None,
                made => Some(made.map(|()| (folder, name))),
            })
            .unwrap_or_else(|| Err(io::ErrorKind::AlreadyExists.into()))?;
        // Windows locks no file that is open only to be added to.
        let lock = File::options().read(true).create(true).append(true).open(folder.join(LOCK))?;
        // On a system of files without locks other runs leave this one alone.
        let _held = lock.try_lock();
        write_whole(&folder.join(SCRIPT), &mut |out| out.write_all(script(program).as_bytes()))?;
        Ok(Run { folder, name, _lock: lock })
    }

    /// Writes a list of a run, and puts the files of its jobs into their place where they are not there as they should be.
    pub fn put(&self, list: &List, path: &Path, jobs: &[&Job<'_>]) -> Result<(), Failure> {
        let failed = |error: io::Error| unwritable(&self.root, &error);
        let staging = self.staging().map_err(failed)?;
        // A list names its jobs before they are there, so that nobody removes them.
        list.write(path).map_err(failed)?;
        for job in jobs {
            copy(job.folder(), &self.job(&job.identity()), &staging).map_err(failed)?;
        }
        Ok(())
    }

    /// Runs whose ltsc is gone.
    pub fn left_over(&self) -> io::Result<Vec<Run>> {
        if !self.runs().is_dir() {
            return Ok(Vec::new());
        }
        let _staging = self.staging()?;
        let mut found = Vec::new();
        for entry in fs::read_dir(self.runs())? {
            let (folder, name) = entry.map(|entry| (entry.path(), entry.file_name().to_string_lossy().into_owned()))?;
            let lock = match File::options().read(true).append(true).open(folder.join(LOCK)) {
                Ok(lock) => lock,
                // It was killed before it had one.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    File::options().read(true).create(true).append(true).open(folder.join(LOCK))?
                }
                Err(error) => return Err(error),
            };
            if lock.try_lock().is_ok() {
                found.push(Run { folder, name, _lock: lock });
            }
        }
        found.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(found)
    }

    /// Removes a run, and the files of jobs that no other run needs.
    pub fn end(&self, run: &Path) -> io::Result<()> {
        let staging = self.staging()?;
        self.remove(run)?;
        drop(staging);
        let _kept = fs::remove_dir(self.jobs());
        Ok(())
    }

    /// The same where a signal ends the process, and locks can no longer be waited for.
    pub fn remove(&self, run: &Path) -> io::Result<()> {
        remove(run)?;
        let mut needed = BTreeSet::new();
        for folder in folders(&self.runs())? {
            for list in lists(&folder)? {
                // One that cannot be read may be one that is being written by a newer ltsc.
                let Ok(list) = List::read(&list) else { return Ok(()) };
                needed.extend(list.jobs.into_iter().map(|job| job.folder));
            }
        }
        for folder in folders(&self.jobs())? {
            let ours = folder.file_name().is_some_and(|name| name.len() == 64);
            if ours && !needed.contains(&folder) {
                remove(&folder)?;
            }
        }
        // They go where nothing is left in them.
        for folder in [self.runs(), self.jobs()] {
            let _kept = fs::remove_dir(folder);
        }
        Ok(())
    }
}

impl Run {
    /// The list of an array of this run.
    pub fn list(&self, array: &str) -> PathBuf {
        self.folder.join(format!("{array}.json"))
    }

    /// Its script.
    pub fn script(&self) -> PathBuf {
        self.folder.join(SCRIPT)
    }

    /// The names of its arrays.
    pub fn arrays(&self) -> io::Result<Vec<String>> {
        let stem = |path: PathBuf| path.file_stem().map(|name| name.to_string_lossy().into_owned());
        Ok(lists(&self.folder)?.into_iter().filter_map(stem).collect())
    }
}

/// The output of an element of an array.
pub fn log_of(list: &Path, index: usize) -> PathBuf {
    let array = list.file_stem().unwrap_or_default().to_string_lossy();
    list.with_file_name(format!("{array}-{index}.log"))
}

/// What each element of an array runs. Slurm adds the number of the element to its environment.
fn script(program: &Path) -> String {
    let program = format!("'{}'", program.display().to_string().replace('\'', r"'\''"));
    format!(
        "#!/bin/sh\nif [ ! -x {program} ]; then\n    echo \"there is no \"{program}\" on $(uname -n): the ltsc that submits must lie in \
         the same place on all machines\" >&2\n    exit 127\nfi\n\
         exec {program} task \"$SLURM_JOB_NAME.json\" \"$SLURM_ARRAY_TASK_ID\"\n"
    )
}

/// Makes `to` what the manifest of `from` says.
fn copy(from: &Path, to: &Path, staging: &Arc<Staging>) -> io::Result<()> {
    let manifest = Manifest::verified(from)?;
    // Whatever lies there is ours, by the folder's name.
    let mut sink = DiskSink::among(Some(staging), to, &manifest.scene, true)?;
    for path in manifest.files.keys() {
        sink.file(path, &mut |out| {
            let (mut file, _) = regular::open(&from.join(path))?;
            io::copy(&mut file, out).map(|_| ())
        })?;
    }
    sink.finish().map(|_| ())
}

/// Removes a folder in which something may still be written.
fn remove(folder: &Path) -> io::Result<()> {
    let mut tries = 0;
    loop {
        match fs::remove_dir_all(folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(_) if tries < 50 => std::thread::sleep(Duration::from_millis(10)),
            other => return other,
        }
        tries += 1;
    }
}

fn lists(run: &Path) -> io::Result<Vec<PathBuf>> {
    let mut all = paths(run)?;
    all.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    Ok(all)
}

fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut all = paths(folder)?;
    all.retain(|path| path.is_dir());
    Ok(all)
}

/// What is in a folder, sorted; nothing if it is not there.
fn paths(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let mut all = entries.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<Vec<_>>>()?;
    all.sort();
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_run_whose_process_is_gone_is_left_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let shared = Shared::at(folder.path()).expect("a folder");
        let run = shared.begin(Path::new("/bin/true")).expect("a run");
        let other = shared.begin(Path::new("/bin/true")).expect("a run");
        assert_ne!(run.name, other.name);
        assert!(shared.left_over().expect("runs").is_empty());
        let (place, name) = (run.folder.clone(), run.name.clone());
        drop(run);
        let found = shared.left_over().expect("runs");
        assert_eq!(found.iter().map(|run| run.name.clone()).collect::<Vec<_>>(), [name]);
        fs::create_dir_all(shared.job(&"a".repeat(64))).expect("a job");
        shared.end(&place).expect("ended");
        assert!(!place.exists() && !shared.job(&"a".repeat(64)).exists() && other.folder.is_dir());
        shared.end(&other.folder).expect("ended");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn a_program_of_any_name_is_called_and_one_that_is_missing_is_told() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("it's $HOME");
        let run = || {
            let text = script(&program);
            let mut shell = std::process::Command::new("/bin/sh");
            shell.args(["-c", &text]).env("SLURM_JOB_NAME", "ltsc-1-0").env("SLURM_ARRAY_TASK_ID", "7");
            let out = shell.output().expect("a shell");
            (out.status.code(), String::from_utf8_lossy(&[out.stdout, out.stderr].concat()).into_owned())
        };
        let (code, said) = run();
        assert!(code == Some(127) && said.contains("it's $HOME on "), "{said}");
        fs::write(&program, "#!/bin/sh\necho \"$@\"\n").expect("written");
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("rights");
        assert_eq!(run(), (Some(0), "task ltsc-1-0.json 7\n".to_owned()));
    }
}
