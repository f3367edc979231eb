//! Images that no table names: what people have put beside results, or folders without any; and what headers say of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ltsc_render::image::{Attributes, Provenance};

use super::gather::Book;
use super::model::{Fact, Picture, Scene};
use super::write::{FOLDER, is_page};
use crate::failure::{Exit, Failure, why};

/// How deep images are looked for in a folder, and how many of them are shown.
const DEPTH: usize = 6;
const MOST: usize = 10_000;

/// Images that no table names, by the folder they lie in.
pub(super) fn by_hand(book: &mut Book, folder: &Path, folders: &mut BTreeMap<String, usize>) -> Result<(), Failure> {
    let known: BTreeSet<PathBuf> = book.paths.iter().flatten().cloned().collect();
    // What was written for renderers has images too, which are no results.
    let files = folder.join("results.json").is_file().then(|| folder.join("files"));
    let apart: Vec<PathBuf> = files.into_iter().chain([folder.join(FOLDER)]).collect();
    let mut found = Vec::new();
    look(folder, &apart, DEPTH, &mut found)
        .map_err(|error| Failure::new(Exit::Input, format!("{}: {}", folder.display(), why(&error))))?;
    found.sort();
    if found.len() > MOST {
        book.model.remarks.push(format!("{} images were found, of which the first {MOST} are here", found.len()));
        found.truncate(MOST);
    }
    for path in found.into_iter().filter(|path| !known.contains(path)) {
        let below = path.strip_prefix(folder).unwrap_or(&path);
        let text = below.to_str().map(|text| text.replace(std::path::MAIN_SEPARATOR, "/"));
        let shown = below.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/");
        let (around, name) = shown.rsplit_once('/').unwrap_or(("", &shown));
        let reference = around == "references" || around.starts_with("references/");
        let plain = around.strip_prefix("scenes/").or_else(|| around.strip_prefix("references/")).unwrap_or(around);
        let title = if plain.is_empty() { "images" } else { plain };
        let at = folders.get(around).or_else(|| folders.get(plain)).copied().unwrap_or_else(|| {
            let scene = Scene { name: title.to_owned(), scene: title.to_owned(), ..Scene::default() };
            book.model.scenes.push(scene);
            book.model.scenes.len() - 1
        });
        folders.insert(around.to_owned(), at);
        folders.insert(plain.to_owned(), at);
        let label = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        let label = if reference { format!("reference: {label}") } else { label.to_owned() };
        let log = path.with_extension("log");
        let picture = Picture {
            label,
            kind: if reference { "reference" } else { "image" },
            status: "done",
            file: text.as_ref().map(|text| format!("../{text}")),
            log: text.filter(|_| log.is_file()).and_then(|text| {
                let (stem, _) = text.rsplit_once('.')?;
                Some(format!("../{stem}.log"))
            }),
            ..Picture::default()
        };
        book.add_all(at, &picture, &path);
    }
    Ok(())
}

/// Images below a folder; hidden folders, links, pages, and files for renderers are passed over.
fn look(folder: &Path, apart: &[PathBuf], depth: usize, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let (kind, path) = (entry.file_type()?, entry.path());
        let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
        if kind.is_dir() && !hidden && depth > 0 && !is_page(&path) {
            if !apart.contains(&path) {
                look(&path, apart, depth - 1, found)?;
            }
        } else if kind.is_file() && !hidden {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
            if matches!(ending.as_deref(), Some("exr" | "pfm")) {
                found.push(path);
            }
        }
    }
    Ok(())
}

/// What the header of an image says of how it came to be.
pub(super) fn header(attributes: &Attributes) -> Vec<Fact> {
    let Provenance { scene, scene_hash, version, renderer, renderer_version, samples, seed, seconds, extra } =
        Provenance::from_attributes(attributes);
    let mut facts = Vec::new();
    let mut add = |name: &str, value: String| {
        if !value.is_empty() {
            facts.push(Fact(name.to_owned(), value));
        }
    };
    let some = |number: u64| if number > 0 { number.to_string() } else { String::new() };
    add("scene", scene);
    add("renderer", format!("{renderer} {renderer_version}").trim().to_owned());
    add("samples per pixel", some(samples));
    add("seed", some(seed));
    add("seconds", if seconds > 0.0 { format!("{seconds:.1}") } else { String::new() });
    add("hash of scene and settings", scene_hash);
    add("rendered through", if version.is_empty() { version } else { format!("ltsc {version}") });
    for (name, value) in extra {
        add(&name, value);
    }
    let others = attributes.iter().filter(|(name, _)| !name.starts_with("ltsc:"));
    facts.extend(others.map(|(name, value)| Fact(name.clone(), value.clone())));
    facts
}
