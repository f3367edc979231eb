//! `ltsc doc`: the catalogue of scenes.

mod html;
mod pictures;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use ltsc_core::catalogue::{self, Entry, Pictures};
use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;

use crate::args::{Doc, DocFormat, Format};
use crate::disk::{unwritable, write_atomically};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal;

use super::shared::{CheckedFile, all_files_of, check, report};

/// What every page says of itself; files without it are not ours.
const MARK: &str = "Written by <code>ltsc doc</code>";
const MARK_MARKDOWN: &str = "*Written by `ltsc doc`; do not edit.*";

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
    let (exit, _) = report(&all, Vec::new(), Format::Human, false, true);
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
        pictures::render_all(command, &scenes, &output)?;
    }
    let pictures: BTreeMap<&str, Pictures> =
        scenes.keys().filter_map(|name| Some((*name, pictures::load(&output, name)?))).collect();
    let entries: Vec<Entry<'_>> =
        scenes.iter().map(|(name, (scene, _, _))| Entry { scene, pictures: pictures.get(name) }).collect();
    let mut pages = pages(&entries, command.format);
    // Single scenes get their pages anew; the table of all, and the pages of others, are not theirs to change.
    let single = command.paths.iter().any(|path| path.is_file());
    let partial = single && !left_over(&output, &pages, command.format).is_empty();
    if partial {
        pages.retain(|name, _| name != "README.md" && name != "index.html");
    }
    write(command, &output, &pages, partial)
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

/// Pages of scenes that are gone: files of ours that are no longer made.
fn left_over(folder: &Path, files: &BTreeMap<String, String>, format: DocFormat) -> Vec<PathBuf> {
    let ending = match format {
        DocFormat::Markdown => "md",
        DocFormat::Html => "html",
    };
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let ours = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        path.extension().is_some_and(|own| own == ending)
            && !files.contains_key(&name)
            && fs::read_to_string(path).is_ok_and(|text| text.contains(MARK) || text.contains(MARK_MARKDOWN))
    };
    let sorted: BTreeSet<PathBuf> = paths.filter(ours).collect();
    sorted.into_iter().collect()
}

/// Writes what is not yet as it should be, or only names it.
fn write(command: &Doc, folder: &Path, files: &BTreeMap<String, String>, partial: bool) -> Result<Exit, Failure> {
    let failed = |error: std::io::Error| unwritable(folder, &error);
    let mut changed = 0;
    for (name, text) in files {
        let path = folder.join(name);
        if fs::read(&path).is_ok_and(|there| there == text.as_bytes()) {
            continue;
        }
        changed += 1;
        if command.check {
            terminal::print(&format!("stale: {}\n", path.display()));
        } else {
            write_atomically(&path, &mut |out| out.write_all(text.as_bytes())).map_err(failed)?;
        }
    }
    let gone = if partial { Vec::new() } else { left_over(folder, files, command.format) };
    for path in gone {
        changed += 1;
        if command.check {
            terminal::print(&format!("left over: {}\n", path.display()));
        } else {
            fs::remove_file(&path).map_err(failed)?;
        }
    }
    let place = folder.display();
    terminal::say(&match (changed, command.check) {
        (0, _) => format!("{place}: nothing to do, all pages are up to date"),
        (_, true) => format!("{place} is stale; `ltsc doc` brings it up to date"),
        (count, false) => format!("{count} file{} changed in {place}", if count == 1 { "" } else { "s" }),
    });
    Ok(if command.check && changed > 0 { Exit::No } else { Exit::Done })
}
