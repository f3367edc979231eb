//! `ltsc report` and `ltsc view`: pages for a browser, of folders of results and of loose images.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Duration;

use ltsc_evaluation::page::{self, Book, Written};
use ltsc_render::client;
use serde_json::json;

use crate::args::{Format, Report, View};
use crate::output::{Exit, Failure};
use crate::terminal::{self, Watcher};

use super::said::{from_here, plural};

/// How long the program that opens a page may take to hand it on.
const PATIENCE: Duration = Duration::from_secs(20);

pub fn report(command: &Report) -> Result<Exit, Failure> {
    let folder = command.folder.join(page::FOLDER);
    let book = page::of_folder(&command.folder)?;
    if book.count() == 0 {
        terminal::say(&format!("{} holds no images: the page says so", from_here(&command.folder)));
    }
    make(book, &folder, command.force, command.open, command.answer.format)
}

pub fn view(command: &View) -> Result<Exit, Failure> {
    let book = page::of_files(&command.files)?;
    make(book, &command.output, command.force, command.open, command.answer.format)
}

fn make(book: Book, folder: &Path, force: bool, open: bool, format: Format) -> Result<Exit, Failure> {
    let written = page::write(book, folder, force, &mut Watcher::default())?;
    let index = folder.join("index.html");
    let Written { images, missing, bytes, precision } = written;
    if format == Format::Json {
        let document = json!({
            "page": index.to_string_lossy(), "images": images, "missing": missing, "bytes": bytes, "bytes_per_number": precision,
        });
        terminal::print(&format!("{document:#}\n"));
    } else {
        let lacks = if missing > 0 { format!(", {missing} missing") } else { String::new() };
        terminal::say(&format!("{}{lacks}, {:.1} MB", plural(images, "image"), bytes as f64 / 1e6));
        if precision < 4 {
            terminal::say(
                "numbers have 15 bits behind the point instead of 23, since there are many: off by 2^-16 of them at most",
            );
        }
        terminal::print(&format!("{}\n", from_here(&index)));
    }
    if open {
        show(&index);
    }
    Ok(Exit::Done)
}

/// The page of results that were just written; what goes wrong is told, and spoils nothing else.
pub fn beside(results: &Path, force: bool, open: bool) -> Option<std::path::PathBuf> {
    let folder = results.join(page::FOLDER);
    let written = page::of_folder(results).and_then(|book| page::write(book, &folder, force, &mut Watcher::default()));
    let index = folder.join("index.html");
    match written {
        Ok(_) => {
            if open {
                show(&index);
            }
            Some(index)
        }
        Err(failure) => {
            terminal::error(&format!("the page was not written: {}", failure.message));
            failure.help.iter().for_each(|help| terminal::help(help));
            None
        }
    }
}

/// Hands a page to the browser of the system.
fn show(index: &Path) {
    // Without links, but where that makes a path that shells of Windows do not know.
    let real = if cfg!(windows) { std::path::absolute(index) } else { std::fs::canonicalize(index) };
    let real = real.unwrap_or_else(|_| index.to_path_buf());
    browse(real.as_os_str(), &from_here(index).to_string());
}

/// Hands a file or an address to the browser of the system; `name` is what people are told of it.
pub fn browse(what: &OsStr, name: &str) {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let words: Vec<&OsStr> = before.iter().map(OsStr::new).chain([what]).collect();
    let why = match client::ask(Path::new(program), &words, PATIENCE) {
        Ok(answer) if answer.ok => return,
        Ok(answer) => answer.words(),
        Err(error) => crate::output::why(&error),
    };
    terminal::say(&format!("no browser was started ({program}: {why}): open {name} in one"));
}
