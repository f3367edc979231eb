//! `ltsc clean`: results of earlier evaluations go, as far as ltsc wrote them and nobody has changed them since.

use std::path::{Path, PathBuf};

use ltsc_evaluation::study::{Removed, clean};
use serde_json::json;

use crate::args::{Clean, Format};
use crate::output::{Exit, Failure};
use crate::terminal;

use super::said::{from_here, plural};

pub fn run(command: &Clean) -> Result<Exit, Failure> {
    let default = [PathBuf::from("results")];
    let folders: &[PathBuf] = if command.folders.is_empty() { &default } else { &command.folders };
    if let Some(missing) = folders.iter().find(|folder| !folder.is_dir()) {
        return Err(Failure::new(Exit::Usage, format!("{}: there is no such folder", missing.display()))
            .help("name a folder of results: `results` beside an evaluation file"));
    }
    let folders: Vec<&Path> = folders.iter().map(PathBuf::as_path).collect();
    let done = clean(&folders, command.keep, command.files, command.dry_run)?;
    if command.answer.format == Format::Json {
        terminal::print(&format!("{:#}\n", json!({ "removed": done, "dry_run": command.dry_run })));
        return Ok(Exit::Done);
    }
    let word = if command.dry_run { "would go" } else { "removed" };
    for Removed { folder, files, bytes: _, kept } in &done {
        let stay = if kept.is_empty() {
            String::new()
        } else {
            format!(", {} stay: changed, or not ours", plural(kept.len(), "file"))
        };
        terminal::print(&format!("{}: {} {word}{stay}\n", from_here(folder), plural(*files, "file")));
    }
    let (files, bytes) = done.iter().fold((0, 0), |(files, bytes), one| (files + one.files, bytes + one.bytes));
    terminal::say(&format!("{} {word}, {:.1} MB", plural(files, "file"), bytes as f64 / 1e6));
    Ok(Exit::Done)
}
