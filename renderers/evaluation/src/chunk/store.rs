//! Where chunks are kept: `chunks/<first two digits>/<identity>/<samples>-<seed>.exr` in the user's cache, or in any folder that several
//! machines share.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use ltsc_render::cache::CachePaths;
use ltsc_render::image::{Provenance, plain_bytes};

use super::facts::{Facts, load};
use crate::disk::{unwritable, write_whole};
use crate::failure::{Exit, Failure};
use crate::job::Job;
use crate::watch::Watch;
use ltsc_render::run::Progress;

/// Locks that chunks are divided among, so that one is rendered by one process at a time.
const LOCKS: usize = 4;

/// How often a chunk that another process renders is looked for.
const POLL: Duration = Duration::from_millis(200);

/// A folder of chunks.
#[derive(Clone, Debug)]
pub struct Store {
    root: PathBuf,
    /// Renderers that run at once; none where that is not this process's doing.
    at_once: Option<u32>,
    /// Whether a chunk that was not rendered alone is rendered again: for times.
    alone: bool,
}

/// All chunks of one description in a store.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The folder.
    pub folder: PathBuf,
    /// The scene's name.
    pub scene: String,
    /// The renderer and its version.
    pub renderer: String,
    /// Chunks.
    pub chunks: usize,
    /// Samples per pixel of all of them.
    pub samples: u64,
    /// Bytes on the disk.
    pub bytes: u64,
    /// When the newest one was written.
    pub newest: SystemTime,
}

/// What a store holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Chunks.
    pub chunks: usize,
    /// Bytes on the disk.
    pub bytes: u64,
}

impl Store {
    /// That of the user's cache.
    #[must_use]
    pub fn of(cache: &CachePaths) -> Self {
        Self::at(cache.root.join("chunks"))
    }

    /// One in a folder, which need not exist.
    #[must_use]
    pub fn at(root: PathBuf) -> Self {
        Self { root, at_once: None, alone: false }
    }

    /// The same store; what is rendered into it now has so many renderers at once.
    #[must_use]
    pub fn at_once(self, count: usize) -> Self {
        Self { at_once: u32::try_from(count).ok(), ..self }
    }

    /// The same store, in which a chunk counts only if its renderer ran alone: others are rendered again, one at a time.
    #[must_use]
    pub fn alone(self) -> Self {
        Self { alone: true, ..self.at_once(1) }
    }

    /// Where it is.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The file of a chunk.
    #[must_use]
    pub fn path(&self, identity: &str, samples: u32, seed: u32) -> PathBuf {
        let head = identity.get(..2).unwrap_or("xx");
        self.root.join(head).join(identity).join(format!("{samples}-{seed}.exr"))
    }

    /// Whether a chunk is there, by its header.
    #[must_use]
    pub fn has(&self, identity: &str, samples: u32, seed: u32) -> bool {
        self.is_chunk(&self.path(identity, samples, seed), identity)
    }

    /// Whether a file is a chunk, by its header: one that a failing disk has left empty or foreign is rendered again.
    fn is_chunk(&self, path: &Path, identity: &str) -> bool {
        let Ok(header) = ltsc_render::image::attributes(path) else { return false };
        let provenance = Provenance::from_attributes(&header);
        provenance.scene_hash == identity && (!self.alone || Facts::read(&provenance).at_once == Some(1))
    }

    /// Renders a chunk that is not there, and tells how, or nothing if it is there. Another process that renders the same one is waited for.
    ///
    /// # Errors
    /// What the renderer says, or the disk.
    pub fn make(
        &self,
        job: &Job<'_>,
        (samples, seed): (u32, u32),
        watch: &mut dyn FnMut(Progress),
    ) -> Result<Option<Facts>, Failure> {
        let identity = job.identity();
        let path = self.path(&identity, samples, seed);
        if self.is_chunk(&path, &identity) {
            return Ok(None);
        }
        let _lock = self.lock(&job.key(samples, seed)).map_err(|error| unwritable(&self.root, &error))?;
        if self.is_chunk(&path, &identity) {
            return Ok(None);
        }
        let folder = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder).map_err(|error| unwritable(&self.root, &error))?;
        let load = load();
        // Where it fails, its log stays, and is begun anew next time.
        let rendered = job
            .render_logged(samples, seed, &path.with_extension("log"), watch)
            .map_err(|error| Failure::of_renderer(&error))?;
        let facts = Facts::of(&rendered, job.runner().threads, load, self.at_once);
        let mut provenance = Provenance {
            scene: job.scene().to_owned(),
            scene_hash: identity,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            renderer: job.runner().driver.name.to_owned(),
            renderer_version: rendered.renderer_version.clone(),
            samples: rendered.samples_done,
            seed: u64::from(seed),
            seconds: rendered.seconds,
            extra: rendered.facts.clone(),
        };
        facts.write(&mut provenance);
        let bytes = plain_bytes(&path, &rendered.image, &provenance)
            .map_err(|error| Failure::new(Exit::Environment, error.to_string()).help(error.hint()))?;
        write_whole(&path, &mut |out| out.write_all(&bytes)).map_err(|error| unwritable(&self.root, &error))?;
        Ok(Some(facts))
    }

    /// Holds the lock of a chunk, which the system lets go when the process ends, however it does. The files of locks stay: another
    /// process may hold one that is removed.
    fn lock(&self, key: &str) -> io::Result<File> {
        let folder = self.root.join("locks");
        fs::create_dir_all(&folder)?;
        // Windows locks no file that is open only to be added to.
        let file = File::options().read(true).create(true).append(true).open(folder.join(&key[..LOCKS]))?;
        loop {
            ltsc_render::guard::stop_if_ending();
            match file.try_lock() {
                Ok(()) => return Ok(file),
                Err(fs::TryLockError::WouldBlock) => std::thread::sleep(POLL),
                // A system of files without locks: the worst is that a chunk is rendered twice.
                Err(fs::TryLockError::Error(_)) => return Ok(file),
            }
        }
    }

    /// What it holds, by scene and renderer.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub fn entries(&self) -> io::Result<Vec<Entry>> {
        let mut all = Vec::new();
        for head in folders(&self.root)? {
            if head.file_name().is_none_or(|name| name.len() != 2) {
                continue;
            }
            for folder in folders(&head)? {
                all.extend(entry(folder)?);
            }
        }
        all.sort_by(|a: &Entry, b: &Entry| (&a.scene, &a.renderer, &a.folder).cmp(&(&b.scene, &b.renderer, &b.folder)));
        Ok(all)
    }

    /// Removes all chunks of descriptions whose newest one is older than `age`, and what killed runs have left.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn prune(&self, age: Duration, watch: &mut dyn Watch) -> io::Result<Summary> {
        let mut removed = Summary::default();
        let now = SystemTime::now();
        for entry in self.entries()? {
            let old = now.duration_since(entry.newest).is_ok_and(|since| since >= age);
            if !old {
                continue;
            }
            for file in files(&entry.folder)? {
                fs::remove_file(&file)?;
            }
            // Something else may lie there; then it stays.
            let _emptied = fs::remove_dir(&entry.folder);
            removed.chunks += entry.chunks;
            removed.bytes += entry.bytes;
            watch.doing(&entry.scene);
        }
        Ok(removed)
    }
}

/// The folders in one, sorted; none if it is not there.
fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let mut all = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            all.push(entry.path());
        }
    }
    all.sort();
    Ok(all)
}

/// The chunks and logs in a folder, sorted.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let ours = name.split_once('-').is_some_and(|(samples, seed)| {
            [samples, seed].iter().all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()))
        });
        if ours && path.extension().is_some_and(|ending| ending == "exr" || ending == "log") {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
}

fn entry(folder: PathBuf) -> io::Result<Option<Entry>> {
    let files = files(&folder)?;
    let Some(last) = files.last() else { return Ok(None) };
    let chunks: Vec<&PathBuf> =
        files.iter().filter(|file| file.extension().is_some_and(|ending| ending == "exr")).collect();
    let about = ltsc_render::image::attributes(chunks.first().copied().unwrap_or(last))
        .map(|found| Provenance::from_attributes(&found))
        .unwrap_or_default();
    let mut entry = Entry {
        scene: about.scene,
        renderer: format!("{} {}", about.renderer, about.renderer_version).trim().to_owned(),
        chunks: chunks.len(),
        samples: 0,
        bytes: 0,
        newest: SystemTime::UNIX_EPOCH,
        folder,
    };
    for file in &files {
        let meta = fs::metadata(file)?;
        entry.bytes += meta.len();
        entry.newest = entry.newest.max(meta.modified()?);
        if file.extension().is_none_or(|ending| ending != "exr") {
            continue;
        }
        let name = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        entry.samples += name.split_once('-').and_then(|(samples, _)| samples.parse::<u64>().ok()).unwrap_or(0);
    }
    Ok(Some(entry))
}
