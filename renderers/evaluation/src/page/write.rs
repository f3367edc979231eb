//! The folder of a page: its scripts, data and pictures. It appears as a whole, and holds nothing but what ltsc wrote.

use std::collections::BTreeMap;
use std::path::Path;

use ltsc_core::files::Sink;
use ltsc_render::image::{Image, ImageError};
use ltsc_render::regular;

use super::gather::Book;
use super::loose::header;
use super::measured::{Side, measure};
use super::model::{Groups, Model, Picture};
use super::{pixels, plots};
use crate::compare::{png, read_grey_png};
use crate::disk::{DiskSink, Manifest, unwritable};
use crate::failure::{Exit, Failure, why};
use crate::watch::Watch;

/// The folder of a page within results.
pub const FOLDER: &str = "page";

/// What the manifest of a page names as its scene begins with this.
const MARK: &str = "page of ";

/// Bytes of all pixels up to which they are exact: beyond, numbers have 3 bytes instead of 4.
const EXACT: usize = 40_000_000;

/// Bytes of images that are held at once; others are read again where they are needed.
const HELD: usize = 1 << 30;

/// The largest picture of groups that is read.
const LARGEST_PNG: u64 = 1 << 28;

/// What runs in the browser, in the order in which it is loaded.
const SCRIPTS: &[(&str, &str)] = &[
    ("base.js", include_str!("assets/base.js")),
    ("maths.js", include_str!("assets/maths.js")),
    ("flip.js", include_str!("assets/flip.js")),
    ("store.js", include_str!("assets/store.js")),
    ("shader.js", include_str!("assets/shader.js")),
    ("gpu.js", include_str!("assets/gpu.js")),
    ("cpu.js", include_str!("assets/cpu.js")),
    ("state.js", include_str!("assets/state.js")),
    ("draw.js", include_str!("assets/draw.js")),
    ("over.js", include_str!("assets/over.js")),
    ("side.js", include_str!("assets/side.js")),
    ("viewer.js", include_str!("assets/viewer.js")),
    ("keys.js", include_str!("assets/keys.js")),
    ("index.js", include_str!("assets/index.js")),
    ("main.js", include_str!("assets/main.js")),
];
const STYLE: &str = include_str!("assets/page.css");
const HTML: &str = include_str!("assets/index.html");

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Images with pixels.
    pub images: usize,
    /// Images that are named and have none.
    pub missing: usize,
    /// Bytes of the page.
    pub bytes: u64,
    /// Bytes of each number of an image.
    pub precision: usize,
}

/// Whether a folder is a page that ltsc wrote.
#[must_use]
pub fn is_page(folder: &Path) -> bool {
    Manifest::read(folder).is_some_and(|manifest| manifest.scene.starts_with(MARK))
}

/// Images that were read, with their variances.
#[derive(Default)]
struct Held {
    images: BTreeMap<usize, (Image, Option<Image>)>,
    bytes: usize,
}

impl Held {
    /// Takes an image back where there is room.
    fn keep(&mut self, number: usize, image: Image, variance: Option<Image>) {
        let size = 12 * image.pixels.len() * (1 + usize::from(variance.is_some()));
        if self.bytes + size <= HELD {
            self.bytes += size;
            self.images.insert(number, (image, variance));
        }
    }

    /// An image again; it was read once, and is gone only where someone has changed it since.
    fn with<T>(&self, book: &Book, number: usize, of: impl FnOnce(&Image, Option<&Image>) -> T) -> Option<T> {
        if let Some((image, variance)) = self.images.get(&number) {
            return Some(of(image, variance.as_ref()));
        }
        let (image, variance, _) = book.read(number)?.ok()?;
        Some(of(&image, variance.as_ref()))
    }
}

/// Counts what goes into a sink.
struct Out<'s> {
    sink: &'s mut DiskSink,
    folder: &'s Path,
    bytes: u64,
}

impl Out<'_> {
    fn put(&mut self, path: &str, bytes: &[u8]) -> Result<(), Failure> {
        self.bytes += bytes.len() as u64;
        self.sink.file(path, &mut |out| out.write_all(bytes)).map_err(|error| unwritable(self.folder, &error))
    }
}

/// Writes a page into `folder`, which must be empty, not there, or an earlier page; with `force` it may hold anything.
///
/// # Errors
/// If the folder is not ours, or cannot be written.
pub fn write(mut book: Book, folder: &Path, force: bool, watch: &mut dyn Watch) -> Result<Written, Failure> {
    let failed = |error: std::io::Error| unwritable(folder, &error);
    let mut sink = DiskSink::new(folder, &format!("{MARK}{}", book.model.title), false, force).map_err(failed)?;
    let mut out = Out { sink: &mut sink, folder, bytes: 0 };
    let pairs: usize = book.model.scenes.iter().map(|scene| scene.pairs.len()).sum();
    watch.begin((2 * book.count() + pairs) as u64, "writing the page");
    let mut done = 0;
    let mut held = Held::default();
    for number in 0..book.count() {
        look(&mut book, number, &mut held);
        done += 1;
        watch.set(done);
    }
    find_references(&mut book);
    let pixels: usize = data(&book.model).map(|data| data.width * data.height).sum();
    let precision = if 12 * pixels > EXACT { 3 } else { 4 };
    for number in 0..book.count() {
        if let Some(data) = &mut book.model.images[number].data {
            data.bytes = precision;
        }
        image(&mut book, number, &held, &mut out)?;
        done += 1;
        watch.set(done);
    }
    for scene in 0..book.model.scenes.len() {
        for pair in 0..book.model.scenes[scene].pairs.len() {
            compared(&mut book, scene, pair, &held);
            done += 1;
            watch.set(done);
        }
    }
    drop(held);
    groups(&mut book, &mut out)?;
    for (path, bytes) in plots::all(&mut book.model, book.timing.as_ref()) {
        out.put(&path, bytes.as_bytes())?;
    }
    for (name, text) in SCRIPTS {
        out.put(&format!("assets/{name}"), text.as_bytes())?;
    }
    out.put("assets/page.css", STYLE.as_bytes())?;
    out.put("data/index.js", model_script(&book.model)?.as_bytes())?;
    out.put("index.html", html(&book.model.title).as_bytes())?;
    let bytes = out.bytes;
    sink.finish().map_err(failed)?;
    watch.end();
    let images = data(&book.model).count();
    Ok(Written { images, missing: book.count() - images, bytes, precision })
}

fn data(model: &Model) -> impl Iterator<Item = &super::model::Data> {
    model.images.iter().filter_map(|picture| picture.data.as_ref())
}

/// Reads an image: what it is, and how it came to be.
fn look(book: &mut Book, number: usize, held: &mut Held) {
    if book.model.images[number].status != "done" {
        return;
    }
    let Some(found) = book.read(number) else { return };
    let picture = &mut book.model.images[number];
    match found {
        Ok((image, variance, attributes)) if !image.pixels.is_empty() => {
            picture.data = Some(pixels::data(&image, 4));
            // What an evaluation knows of an image is more than its header says.
            if picture.case.is_empty() {
                picture.facts.extend(header(&attributes));
            }
            held.keep(number, image, variance);
        }
        Ok(_) => unreadable(picture, "it has no pixels".to_owned()),
        Err(error) => unreadable(picture, told(&error)),
    }
}

/// Why an image cannot be read, without the path of this machine.
fn told(error: &ImageError) -> String {
    match error {
        ImageError::Damaged { message, hint, .. } => format!("{message}; {hint}"),
        ImageError::Io { source, .. } => why(source),
        other => other.hint().to_owned(),
    }
}

fn unreadable(picture: &mut Picture, why: String) {
    picture.status = "unreadable";
    picture.why = Some(why);
}

/// References are known by the file they were made from, which their header names.
fn find_references(book: &mut Book) {
    for wanted in &book.wanted {
        let images = &book.model.images;
        let from = |image: &&usize| images[**image].facts.iter().any(|fact| fact.0 == "from" && fact.1 == wanted.from);
        let scene = &mut book.model.scenes[wanted.scene];
        let found = scene.images.iter().filter(|image| images[**image].kind == "reference").find(from).copied();
        let pair = &mut scene.pairs[wanted.pair];
        pair.a = found;
        if let Some(found) = found {
            pair.a_label.clone_from(&images[found].label);
        }
    }
}

/// Writes the pixels of an image, and its small picture.
fn image(book: &mut Book, number: usize, held: &Held, out: &mut Out) -> Result<(), Failure> {
    let Some(data) = book.model.images[number].data.clone() else { return Ok(()) };
    let thumb = held.with(book, number, |image, _| {
        if let Some(preview) = data.preview {
            let small = pixels::smaller(image, preview.factor);
            let whole = [0, 0, small.width, small.height];
            out.put(&format!("data/{number}-p.js"), &pixels::script(&small, &data, number, "p", whole))?;
        }
        for (at, tile) in data.tiles.iter().enumerate() {
            let script = pixels::script(image, &data, number, &at.to_string(), *tile);
            out.put(&format!("data/{number}-{at}.js"), &script)?;
        }
        let path = format!("thumbs/{number}.png");
        let (width, height, shown) = pixels::thumb(image, data.exposure);
        let bytes = png(Path::new(&path), width, height, &shown)
            .map_err(|error| Failure::new(Exit::Environment, error.to_string()))?;
        out.put(&path, &bytes)?;
        Ok(path)
    });
    let picture = &mut book.model.images[number];
    match thumb {
        Some(path) => picture.thumb = Some(path?),
        None => {
            picture.data = None;
            unreadable(picture, "it was changed while the page was made".to_owned());
        }
    }
    Ok(())
}

/// Writes which pixels see what, as far as the files are there and of the size they are said to have.
fn groups(book: &mut Book, out: &mut Out) -> Result<(), Failure> {
    for (number, (scene, file, size, names)) in std::mem::take(&mut book.groups).into_iter().enumerate() {
        let bytes = regular::read(&file, LARGEST_PNG).ok();
        let Some((width, height, pixels)) = bytes.and_then(|bytes| read_grey_png(&bytes)) else { continue };
        if (width, height) != size {
            continue;
        }
        let data = format!("data/g{number}.js");
        out.put(&data, &pixels::group_script(&data, &pixels))?;
        book.model.scenes[scene].groups.push(Groups { width, height, data, names });
    }
    Ok(())
}

/// Fills in a comparison.
fn compared(book: &mut Book, scene: usize, at: usize, held: &Held) {
    let mut pair = book.model.scenes[scene].pairs[at].clone();
    let there = |number: Option<usize>| number.filter(|number| book.model.images[*number].data.is_some());
    if let (Some(a), Some(b)) = (there(pair.a), there(pair.b)) {
        let open = book.open.contains(&(scene, at));
        held.with(book, a, |image, variance| {
            let a = Side { image, variance };
            held.with(book, b, |image, variance| measure(&mut pair, &a, &Side { image, variance }, open));
        });
    } else if pair.verdict.is_none() {
        pair.refused.get_or_insert("one of the images is not there".to_owned());
    }
    book.model.scenes[scene].pairs[at] = pair;
}

/// All but the pixels, as a script. No text in it can end the script, or be taken for HTML.
fn model_script(model: &Model) -> Result<String, Failure> {
    let text = serde_json::to_string(model).map_err(|error| Failure::new(Exit::Fault, error.to_string()))?;
    let text = text.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029");
    Ok(format!("ltsc.model({text});\n"))
}

/// The page itself.
fn html(title: &str) -> String {
    let mut plain = String::new();
    for letter in title.chars() {
        match letter {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            _ => plain.push(letter),
        }
    }
    let scripts: String = SCRIPTS
        .iter()
        .map(|(name, _)| format!("<script defer src=\"assets/{name}\"></script>\n"))
        .chain(std::iter::once("<script defer src=\"data/index.js\"></script>\n".to_owned()))
        .collect();
    HTML.replace("<!-- scripts -->\n", &scripts).replace("<!-- title -->", &plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_end_a_script_or_become_html() {
        let title = "</script><script>alert(1)</script> & \"x\" \u{2028}";
        let model = Model { title: title.to_owned(), ..Model::default() };
        let script = model_script(&model).expect("a script");
        assert!(!script.contains('<') && !script.contains('\u{2028}'), "{script}");
        let json = script.strip_prefix("ltsc.model(").and_then(|rest| rest.strip_suffix(");\n")).expect("a call");
        let back: serde_json::Value = serde_json::from_str(json).expect("JSON");
        assert_eq!(back["title"], title);
        let page = html(title);
        assert!(page.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)") && !page.contains("<script>"), "{page}");
        assert_eq!(page.matches("<script").count(), SCRIPTS.len() + 1);
    }

    #[test]
    fn scripts_make_no_html_of_text_and_load_nothing_from_elsewhere() {
        let forbidden =
            ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "http:", "fetch(", "XMLHttp"];
        for (name, text) in SCRIPTS {
            for word in forbidden {
                // The name space of SVG is a name, and no address.
                let text = text.replace("http://www.w3.org/2000/svg", "");
                assert!(!text.contains(word), "{name} has `{word}`");
            }
            assert!(text.lines().count() <= 450 && text.starts_with("// "), "{name}");
        }
    }
}
