//! `ltsc serve`: a page from an address instead of the disk, for browsers of this machine.
//!
//! The server is the standard library's sockets and what stands here: files are all that is asked for, one for each connection, so that a
//! library of its own (the small ones have had no release for years) would bring more than it takes away.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use ltsc_core::files::VPath;
use ltsc_evaluation::disk::DiskFiles;
use ltsc_evaluation::page;
use serde_json::json;

use crate::args::{Format, Serve};
use crate::output::{Exit, Failure, why};
use crate::terminal;

/// The most bytes of the lines of a request.
const LONGEST: u64 = 16 << 10;
/// How long a browser may keep still.
const PATIENCE: Duration = Duration::from_secs(30);
/// Connections at once. A browser opens six.
const MOST: usize = 64;

/// What endings of names stand for.
const TYPES: [(&str, &str); 12] = [
    ("html", "text/html; charset=utf-8"),
    ("js", "text/javascript; charset=utf-8"),
    ("css", "text/css; charset=utf-8"),
    ("json", "application/json"),
    ("svg", "image/svg+xml"),
    ("png", "image/png"),
    ("exr", "image/x-exr"),
    ("csv", "text/csv; charset=utf-8"),
    ("md", "text/markdown; charset=utf-8"),
    ("log", "text/plain; charset=utf-8"),
    ("txt", "text/plain; charset=utf-8"),
    ("toml", "text/plain; charset=utf-8"),
];

pub fn run(command: &Serve) -> Result<Exit, Failure> {
    let folder = &command.folder;
    let wrong = |message: String| Failure::new(Exit::Usage, message);
    if !folder.is_dir() {
        return Err(wrong(format!("{}: there is no such folder", folder.display())));
    }
    let files = DiskFiles::new(folder)
        .map_err(|error| Failure::new(Exit::Input, format!("{}: {}", folder.display(), why(&error))))?;
    let places = [format!("{}/index.html", page::FOLDER), "index.html".to_owned()];
    let Some(start) = places.into_iter().find(|place| folder.join(place).is_file()) else {
        return Err(wrong(format!("there is no page in {}", folder.display()))
            .help(format!("make it with `ltsc report {}`", folder.display())));
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, command.port)).map_err(|error| {
        Failure::new(Exit::Environment, format!("port {} is not to be had: {}", command.port, why(&error)))
            .help("without `--port` one is chosen that is free")
    })?;
    let port = listener.local_addr().map_or(command.port, |address| address.port());
    let address = format!("http://127.0.0.1:{port}/");
    if command.answer.format == Format::Json {
        terminal::print(&format!("{:#}\n", json!({ "address": address, "port": port })));
    } else {
        terminal::print(&format!("{address}\n"));
        terminal::say("Ctrl-C ends it");
    }
    if command.open {
        super::page::browse(address.as_ref(), &address);
    }
    let served = Arc::new(Served { files, start });
    let open = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        // What a browser gives up before it is accepted is none of ours.
        let Ok(stream) = stream else { continue };
        if open.load(Ordering::Relaxed) >= MOST {
            continue;
        }
        let (served, open) = (Arc::clone(&served), Arc::clone(&open));
        open.fetch_add(1, Ordering::Relaxed);
        thread::spawn(move || {
            // A browser that goes away in between is no error.
            let _told = served.answer(&stream);
            let _closed = stream.shutdown(Shutdown::Both);
            open.fetch_sub(1, Ordering::Relaxed);
        });
    }
    Ok(Exit::Done)
}

/// What is asked for.
struct Request {
    method: String,
    target: String,
    host: Option<String>,
    range: Option<String>,
}

/// A file that is given.
struct Found {
    file: File,
    kind: &'static str,
    size: u64,
    /// The part that is asked for, which is not empty; nothing where all is meant.
    part: Option<Range<u64>>,
}

/// What is answered where no file is.
struct Refusal {
    status: &'static str,
    more: String,
}

impl Refusal {
    fn of(status: &'static str) -> Self {
        Self { status, more: String::new() }
    }
}

struct Served {
    files: DiskFiles,
    /// The page that `/` leads to.
    start: String,
}

/// What no answer may lack: it is what it says, nothing is kept (a page may be made anew), and pages from elsewhere do not get it.
const ALWAYS: &str = "X-Content-Type-Options: nosniff\r\nCache-Control: no-cache\r\nCross-Origin-Resource-Policy: same-origin\r\n\
                      Referrer-Policy: no-referrer\r\nConnection: close\r\n";

impl Served {
    fn answer(&self, mut stream: &TcpStream) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = read(BufReader::new(stream.take(LONGEST)))?;
        let found = match &request {
            Some(request) => self.find(request),
            None => Err(Refusal::of("400 Bad Request")),
        };
        let head_only = request.as_ref().is_some_and(|request| request.method == "HEAD");
        let Found { mut file, kind, size, part } = match found {
            Ok(found) => found,
            Err(Refusal { status, more }) => {
                let body = if head_only { String::new() } else { format!("{status}\n") };
                let length = status.len() + 1;
                let head = format!(
                    "HTTP/1.1 {status}\r\n{more}{ALWAYS}Content-Type: text/plain\r\nContent-Length: {length}\r\n\r\n"
                );
                return stream.write_all((head + &body).as_bytes());
            }
        };
        let (status, place) = match &part {
            Some(range) => {
                ("206 Partial Content", format!("Content-Range: bytes {}-{}/{size}\r\n", range.start, range.end - 1))
            }
            None => ("200 OK", String::new()),
        };
        let range = part.unwrap_or(0..size);
        let length = range.end - range.start;
        let head = format!(
            "HTTP/1.1 {status}\r\n{place}{ALWAYS}Accept-Ranges: bytes\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\r\n"
        );
        stream.write_all(head.as_bytes())?;
        if head_only {
            return Ok(());
        }
        file.seek(SeekFrom::Start(range.start))?;
        io::copy(&mut file.take(length), &mut stream).map(drop)
    }

    fn find(&self, request: &Request) -> Result<Found, Refusal> {
        if !matches!(request.method.as_str(), "GET" | "HEAD") {
            let more = "Allow: GET, HEAD\r\n".to_owned();
            return Err(Refusal { status: "405 Method Not Allowed", more });
        }
        // A page from elsewhere whose name was made to mean this machine would say its own.
        let here = ["127.0.0.1", "localhost"];
        let ours = |host: &String| {
            let (name, port) = host.rsplit_once(':').unwrap_or((host, "80"));
            // Through a tunnel the port is another one.
            here.iter().any(|one| one.eq_ignore_ascii_case(name)) && port.parse::<u16>().is_ok()
        };
        if !request.host.as_ref().is_some_and(ours) {
            return Err(Refusal::of("403 Forbidden"));
        }
        let path = request.target.split(['?', '#']).next().unwrap_or_default();
        if path == "/" {
            let more = format!("Location: /{}\r\n", self.start);
            return Err(Refusal { status: "302 Found", more });
        }
        let path = path.strip_prefix('/').and_then(decoded).ok_or(Refusal::of("400 Bad Request"))?;
        let missing = || Refusal::of("404 Not Found");
        let path = VPath::resolve("", &path).map_err(|_| missing())?;
        let (file, size) = self.files.open(&path).map_err(|_| missing())?;
        let ending = path.extension();
        let kind = TYPES.iter().find(|(one, _)| *one == ending).map_or("application/octet-stream", |(_, kind)| *kind);
        let part = request.range.as_deref().and_then(|text| part(text, size));
        if part.as_ref().is_some_and(Range::is_empty) {
            let more = format!("Content-Range: bytes */{size}\r\n");
            return Err(Refusal { status: "416 Range Not Satisfiable", more });
        }
        Ok(Found { file, kind, size, part })
    }
}

/// The lines of a request; nothing where they are no such thing, or too long.
fn read(mut from: impl BufRead) -> io::Result<Option<Request>> {
    let mut line = || -> io::Result<Option<String>> {
        let mut bytes = Vec::new();
        from.read_until(b'\n', &mut bytes)?;
        let text = String::from_utf8(bytes).ok();
        Ok(text.and_then(|text| Some(text.strip_suffix('\n')?.trim_end_matches('\r').to_owned())))
    };
    let Some(first) = line()? else { return Ok(None) };
    let words: Vec<&str> = first.split(' ').collect();
    let [method, target, version] = words[..] else { return Ok(None) };
    if !version.starts_with("HTTP/1.") {
        return Ok(None);
    }
    let mut request = Request { method: method.to_owned(), target: target.to_owned(), host: None, range: None };
    loop {
        let Some(next) = line()? else { return Ok(None) };
        if next.is_empty() {
            return Ok(Some(request));
        }
        let Some((name, value)) = next.split_once(':') else { return Ok(None) };
        let value = Some(value.trim().to_owned());
        match name.to_ascii_lowercase().as_str() {
            "host" => request.host = value,
            "range" => request.range = value,
            _ => {}
        }
    }
}

/// A path with its `%41` replaced; nothing where it is no text.
fn decoded(path: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let [first, more @ ..] = rest {
        if *first == b'%' {
            let digit = |at: usize| char::from(*more.get(at)?).to_digit(16);
            bytes.push((digit(0)? * 16 + digit(1)?) as u8);
            rest = &more[2..];
        } else {
            bytes.push(*first);
            rest = more;
        }
    }
    String::from_utf8(bytes).ok()
}

/// A part of a file such as `bytes=0-99`, empty where it lies behind the end; nothing where all is meant, or several parts.
fn part(text: &str, size: u64) -> Option<Range<u64>> {
    let (from, to) = text.strip_prefix("bytes=")?.split_once('-')?;
    if from.is_empty() {
        let last: u64 = to.parse().ok()?;
        return Some(size.saturating_sub(last)..size);
    }
    let from: u64 = from.parse().ok()?;
    let end = if to.is_empty() { u64::MAX } else { to.parse::<u64>().ok()?.saturating_add(1) };
    (end > from).then_some(from..end.min(size).max(from))
}
