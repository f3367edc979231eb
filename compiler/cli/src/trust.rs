//! Which programs a project file may have run: those that the user has said yes to, once, for this project. A checkout may be
//! anybody's, and looking around in it must not run what it names.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::regular;
use serde::{Deserialize, Serialize};

use ltsc_evaluation::disk::write_whole;

/// Folders of projects whose programs are all trusted, parted as those of `PATH` are.
const VARIABLE: &str = "LTSC_TRUST";

/// One program of one project.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Trusted {
    project: PathBuf,
    program: PathBuf,
}

fn file() -> Option<PathBuf> {
    CachePaths::find(&Env::of_process()).map(|cache| cache.root.join("trusted.json"))
}

fn all() -> Vec<Trusted> {
    let text = file().and_then(|file| regular::read_text(&file, regular::TEXT).ok());
    text.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// Whether a program that the project in `root` names may be run.
pub fn is_trusted(root: &Path, program: &Path) -> bool {
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let root = real(root);
    let named = std::env::var_os(VARIABLE).unwrap_or_default();
    std::env::split_paths(&named).any(|folder| !folder.as_os_str().is_empty() && real(&folder) == root)
        || all().iter().any(|one| one.project == root && one.program == program)
}

/// Remembers that programs of the project in `root` may be run.
pub fn trust(root: &Path, programs: impl Iterator<Item = PathBuf>) -> io::Result<()> {
    let file = file().ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the system names no home"))?;
    let root = std::fs::canonicalize(root)?;
    let mut known = all();
    for program in programs {
        let one = Trusted { project: root.clone(), program };
        if !known.contains(&one) {
            known.push(one);
        }
    }
    let text = serde_json::to_vec_pretty(&known)?;
    write_whole(&file, &mut |out: &mut dyn Write| out.write_all(&text))
}
