//! `ltsc cache`: what the user's cache holds, and removing what is old.

use std::time::{Duration, SystemTime};

use ltsc_evaluation::chunk::{Entry, Store};
use ltsc_evaluation::disk::unwritable;
use ltsc_evaluation::executor::slurm;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use serde_json::json;

use crate::args::{Cache, CacheAction, Format};
use crate::output::{Exit, Failure};
use crate::terminal::{self, Watcher};

pub fn run(command: &Cache) -> Result<Exit, Failure> {
    let root = match &command.shared {
        Some(shared) if !shared.is_dir() => {
            return Err(Failure::new(Exit::Usage, format!("{} is no folder", shared.display()))
                .help("`--shared` names the folder that the machines of a cluster share"));
        }
        Some(shared) => shared.clone(),
        None => CachePaths::find(&Env::of_process()).map(|cache| cache.root).ok_or_else(|| {
            Failure::new(Exit::Environment, "the system names no cache folder").help("set LTSC_CACHE to a folder")
        })?,
    };
    let store = Store::of(&CachePaths { root: root.clone() });
    let failed = |error: std::io::Error| unwritable(store.root(), &error);
    if let Some(CacheAction::Prune { days }) = command.action {
        let ended = command.shared.as_deref().map(|shared| slurm::clean(shared, &Env::of_process())).transpose()?;
        let age = Duration::from_secs(days.saturating_mul(24 * 60 * 60));
        let removed = store.prune(age, &mut Watcher::default()).map_err(failed)?;
        if command.format == Format::Json {
            terminal::print(&format!(
                "{:#}\n",
                json!({ "removed": removed.chunks, "bytes": removed.bytes, "runs": ended })
            ));
        } else {
            if let Some(ended) = ended.filter(|ended| *ended > 0) {
                terminal::say(&format!("killed runs that are removed with what they had submitted: {ended}"));
            }
            terminal::say(&format!("{} chunks removed, {}", removed.chunks, size(removed.bytes)));
        }
        return Ok(Exit::Done);
    }
    let entries = store.entries().map_err(failed)?;
    if command.format == Format::Json {
        let row = |entry: &Entry| {
            json!({
                "scene": entry.scene, "renderer": entry.renderer, "chunks": entry.chunks, "samples": entry.samples,
                "bytes": entry.bytes, "folder": entry.folder, "days": days(entry.newest),
            })
        };
        let rows: Vec<_> = entries.iter().map(row).collect();
        terminal::print(&format!("{:#}\n", json!({ "folder": root, "chunks": rows })));
        return Ok(Exit::Done);
    }
    for entry in &entries {
        let Entry { scene, renderer, chunks, samples, bytes, newest, folder: _ } = entry;
        let (of, plural) = (days(*newest), if *chunks == 1 { "" } else { "s" });
        if *chunks == 0 {
            let kept = format!("logs of renderings that failed, {}, {of} days old", size(*bytes));
            terminal::print(&format!("{}: {kept}\n", entry.folder.display()));
            continue;
        }
        terminal::print(&format!(
            "{scene:<24} {renderer:<20} {chunks:>4} chunk{plural}, {samples} samples, {}, {of} days old\n",
            size(*bytes)
        ));
    }
    let (chunks, bytes) =
        (entries.iter().map(|entry| entry.chunks).sum::<usize>(), entries.iter().map(|entry| entry.bytes).sum());
    terminal::print(&format!("{}: {chunks} chunks, {}\n", root.display(), size(bytes)));
    Ok(Exit::Done)
}

/// Whole days since then.
fn days(then: SystemTime) -> u64 {
    SystemTime::now().duration_since(then).map_or(0, |since| since.as_secs() / (24 * 60 * 60))
}

/// Bytes in the unit that suits them.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}
