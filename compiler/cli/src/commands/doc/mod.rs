//! `ltsc doc`: the catalogue of scenes.

mod html;
mod pictures;

use std::collections::BTreeMap;
use std::path::PathBuf;

use ltsc_core::catalogue::{self, Entry, Pictures};
use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;

use crate::args::{Doc, DocFormat, Format};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal;
use ltsc_evaluation::disk::{Pages, probe};

use super::said::plural;
use super::shared::{CheckedFile, Shown, all_files_of, check, report_as};

pub fn run(command: &Doc) -> Result<Exit, Failure> {
    let groups = all_files_of(&command.paths, &command.findings())?;
    let Some((first, _)) = groups.first() else { return Ok(Exit::Done) };
    let output = command.output.clone().unwrap_or_else(|| first.root.join("docs/scenes"));
    let mut all: Vec<CheckedFile> = Vec::new();
    let mut found: Vec<(&Project, &PathBuf)> = Vec::new();
    for (project, files) in &groups {
        all.extend(check(project, files, &command.findings(), Overrides::default(), &[])?);
        found.extend(files.iter().map(|file| (project, file)));
    }
    let (exit, counts) = report_as(&all, Vec::new(), None, Format::Human, false, Shown::Refusals);
    if counts.warnings > 0 {
        let paths: String = command.paths.iter().map(|path| format!(" {}", path.display())).collect();
        terminal::say(&format!("{}: `ltsc lint{paths}` shows them", plural(counts.warnings, "warning")));
    }
    if exit != Exit::Done {
        terminal::error("nothing was written");
        return Ok(exit);
    }
    let mut scenes: BTreeMap<&str, (&Scene, &Project, &PathBuf)> = BTreeMap::new();
    for (file, (project, path)) in all.iter().zip(found) {
        let Some(scene) = &file.checked.scene else { continue };
        if scenes.insert(&scene.name, (scene, project, path)).is_some() {
            return Err(
                Failure::new(Exit::Input, format!("two scenes are named `{}`", scene.name)).help("rename one of them")
            );
        }
    }
    if scenes.is_empty() {
        return Err(Failure::new(Exit::Usage, "there is no scene among these files").help("libraries have no pages"));
    }
    if command.render {
        probe(&output)?;
        pictures::render_all(command, &scenes, &output)?;
    }
    let pictures: BTreeMap<&str, Pictures> =
        scenes.keys().filter_map(|name| Some((*name, pictures::load(&output, name)?))).collect();
    let entries: Vec<Entry<'_>> =
        scenes.iter().map(|(name, (scene, _, _))| Entry { scene, pictures: pictures.get(name) }).collect();
    let mut made = pages(&entries, command.format);
    let mut pages = Pages::new(&output, command.format.by());
    // Single scenes get their pages anew; the table of all, and the pages of others, are not theirs to change.
    let single = command.paths.iter().any(|path| path.is_file());
    let partial = single && pages.rest().any(|path| !made.contains_key(path));
    if partial {
        made.retain(|name, _| name != "README.md" && name != "index.html");
    }
    for (name, text) in made {
        pages.put(name, text);
    }
    if partial {
        pages.keep(|_| true);
    }
    let mut done = pages.finish(command.check, command.force)?;
    if !partial {
        let gone = pictures::remove_others(&output, &scenes.keys().copied().collect(), command)?;
        done.removed.extend(gone.removed);
    }
    if command.check {
        terminal::print(&done.lines(true));
    }
    let place = output.display();
    terminal::say(&match (done.count(), command.check) {
        (0, _) => format!("{place}: nothing to do, all pages are up to date"),
        (_, true) => format!("{place} is stale; `ltsc doc` brings it up to date"),
        (count, false) => format!("{count} file{} changed in {place}", if count == 1 { "" } else { "s" }),
    });
    Ok(if command.check && done.count() > 0 { Exit::No } else { Exit::Done })
}

/// All files by their path below the folder.
fn pages(entries: &[Entry<'_>], format: DocFormat) -> BTreeMap<String, String> {
    let names: Vec<&str> = entries.iter().map(|entry| entry.scene.name.as_str()).collect();
    let mut files = BTreeMap::new();
    let mut put = |name: &str, title: &str, text: String| match format {
        DocFormat::Markdown => files.insert(format!("{name}.md"), text),
        DocFormat::Html => {
            let name = if name == "README" { "index" } else { name };
            files.insert(format!("{name}.html"), html::page(title, &text))
        }
    };
    put("README", "Scenes", catalogue::index(entries));
    for entry in entries {
        put(&entry.scene.name, &entry.scene.name, catalogue::page(entry, &names));
    }
    for entry in entries {
        if let Some(svg) = catalogue::diagram(entry.scene) {
            files.insert(format!("pictures/{}.svg", entry.scene.name), svg);
        }
    }
    files
}

impl DocFormat {
    /// What the record of pages says of who wrote them: the two forms may stand in one folder.
    fn by(self) -> &'static str {
        match self {
            Self::Markdown => "doc",
            Self::Html => "doc --format html",
        }
    }
}
