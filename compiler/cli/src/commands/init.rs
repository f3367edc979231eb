//! `ltsc init`: a project to start from.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::args::Init;
use crate::output::{Exit, Failure};
use crate::project::FILE;
use crate::terminal;
use ltsc_evaluation::disk::unwritable;

/// The project file, with what can be said in it.
const PROJECT: &str = "\
# A repository of scenes for ltsc. Every key is optional; `ltsc explain` lists rules and targets.
scenes = \"scenes-src\"
generated = \"generated\"
# targets = [\"mitsuba-3\", \"pbrt-v4\"]    # all, if left out

# [rules]
# undocumented-scene = \"deny\"           # allow, warn, deny
";

/// A scene that lint has nothing to say about.
const SCENE: &str = include_str!("init/first.lts");

/// The name of its file.
const FIRST: &str = "first";

pub fn run(command: &Init) -> Result<Exit, Failure> {
    let folder = command.folder.clone().unwrap_or_else(|| PathBuf::from("."));
    let scene = folder.join("scenes-src").join(format!("{FIRST}.lts"));
    let project = folder.join(FILE);
    for path in [&project, &scene] {
        if fs::symlink_metadata(path).is_ok() {
            return Err(Failure::new(Exit::Usage, format!("{} is there already", path.display()))
                .help("choose another folder: `ltsc init FOLDER`"));
        }
    }
    let failed = |path: &Path, error: io::Error| unwritable(path, &error);
    let parent = scene.parent().unwrap_or(&folder);
    fs::create_dir_all(parent).map_err(|error| failed(parent, error))?;
    for (path, text) in [(&scene, SCENE), (&project, PROJECT)] {
        // Whatever has appeared there since is not written over.
        let made = fs::File::options().write(true).create_new(true).open(path);
        made.and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| failed(path, error))?;
        terminal::print(&format!("{} written\n", path.display()));
    }
    let here = if folder == Path::new(".") { String::new() } else { format!("    cd {}\n", folder.display()) };
    terminal::print(&format!(
        "next:\n{here}    ltsc lint\n    ltsc build\n    ltsc renderers install mitsuba-3\n    ltsc render scenes-src/{FIRST}.lts \
         --renderer mitsuba-3 -o {FIRST}.exr\n"
    ));
    Ok(Exit::Done)
}
