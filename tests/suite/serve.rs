//! `ltsc serve`: what it gives to whom, and what it refuses.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Stdio};

use super::browser::Browser;
use super::page::{HOSTILE, Stage};
use super::{ltsc, run};

/// A server of a folder, which ends with the value.
struct Server {
    child: Child,
    port: u16,
}

impl Server {
    fn of(folder: &Path) -> Self {
        let mut command = ltsc();
        command.arg("serve").arg(folder).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("it starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("it says its address");
        let address = line.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.strip_suffix("/\n"));
        Self { child, port: address.and_then(|port| port.parse().ok()).unwrap_or_else(|| panic!("{line}")) }
    }

    /// What it answers to these bytes: the lines above, and the body.
    fn says(&self, request: &[u8]) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.write_all(request).expect("it hears");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("an end of the lines") + 4;
        (String::from_utf8(answer[..end].to_vec()).expect("text"), answer[end..].to_vec())
    }

    fn asks(&self, method: &str, path: &str, more: &str) -> (String, Vec<u8>) {
        self.says(format!("{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n{more}\r\n", self.port).as_bytes())
    }

    /// The code of the answer.
    fn code(&self, method: &str, path: &str) -> String {
        self.asks(method, path, "").0.split(' ').nth(1).expect("a code").to_owned()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _ended = self.child.wait();
    }
}

/// A folder of results whose page is only hinted at, with secrets beside it.
fn results() -> Stage {
    let stage = Stage::new();
    fs::create_dir_all(stage.path("r/page")).expect("folders");
    fs::create_dir_all(stage.path("r/ünï ☃")).expect("folders");
    fs::write(stage.path("r/page/index.html"), "the page").expect("written");
    fs::write(stage.path("r/ünï ☃/漢字 a%b.exr"), "0123456789").expect("written");
    fs::write(stage.path("r/empty.txt"), "").expect("written");
    fs::write(stage.path("secret"), "secret").expect("written");
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(stage.path(from), stage.path(to)).expect("a link");
    link("secret", "r/out");
    link("", "r/above");
    link("r/page/index.html", "r/within.html");
    let pipe = stage.path("r/pipe");
    rustix::fs::mknodat(rustix::fs::CWD, pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0).expect("a pipe");
    stage
}

#[test]
fn files_of_the_folder_are_served_and_nothing_else() {
    let stage = results();
    let server = Server::of(&stage.path("r"));
    let (head, _) = server.asks("GET", "/", "");
    assert!(head.starts_with("HTTP/1.1 302 ") && head.contains("\r\nLocation: /page/index.html\r\n"), "{head}");
    let (head, body) = server.asks("GET", "/page/index.html?a=b", "");
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n") && head.contains("Content-Type: text/html"), "{head}");
    assert!(head.contains("nosniff") && head.contains("Resource-Policy: same-origin"), "{head}");
    assert_eq!(body, b"the page");
    let name = "/%C3%BCn%C3%AF%20%E2%98%83/%e6%bc%a2%E5%AD%97%20a%25b.exr";
    let (head, body) = server.asks("GET", name, "");
    assert!(head.contains("Content-Length: 10\r\n") && head.contains("Content-Type: image/x-exr\r\n"), "{head}");
    assert_eq!(body, b"0123456789");
    assert_eq!(server.asks("GET", "/ünï%20☃/漢字%20a%25b.exr", "").1, b"0123456789");
    assert_eq!(server.asks("GET", "/within.html", "").1, b"the page");
    assert!(server.asks("GET", "/empty.txt", "").0.contains("Content-Length: 0\r\n"));
    for path in ["/../secret", "/%2e%2e/secret", "/%2E%2E%2Fsecret", "/page/../../secret", "/page/..%2f..%2fsecret"] {
        assert_eq!(server.code("GET", path), "404", "{path}");
    }
    for path in ["/out", "/above/secret", "//etc/passwd", "/%2fetc/passwd", "/..%5csecret", "/%00", "/nothing"] {
        assert_eq!(server.code("GET", path), "404", "{path}");
    }
    // Neither folders nor what is no file.
    for path in ["/page", "/page/", "/above/", "/pipe", "/.", "/page/.."] {
        assert_eq!(server.code("GET", path), "404", "{path}");
    }
    let secret = |path: &str| server.asks("GET", path, "").1.windows(6).any(|six| six == b"secret");
    assert!(!["/out", "/above/secret", "/../secret"].into_iter().any(secret));
    for path in ["page/index.html", "/%", "/%4", "/%zz", "/%ff", "http://127.0.0.1/page/index.html"] {
        assert_eq!(server.code("GET", path), "400", "{path}");
    }
}

#[test]
fn methods_parts_and_hosts_are_those_of_a_page() {
    let stage = results();
    let server = Server::of(&stage.path("r"));
    let (head, body) = server.asks("HEAD", "/page/index.html", "");
    assert!(head.starts_with("HTTP/1.1 200 ") && head.contains("Content-Length: 8\r\n") && body.is_empty(), "{head}");
    let (head, body) = server.asks("HEAD", "/nothing", "");
    assert!(head.starts_with("HTTP/1.1 404 ") && body.is_empty(), "{head}");
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "get"] {
        let (head, _) = server.asks(method, "/page/index.html", "Content-Length: 0\r\n");
        assert!(head.starts_with("HTTP/1.1 405 ") && head.contains("\r\nAllow: GET, HEAD\r\n"), "{head}");
    }
    let part = |text: &str| server.asks("GET", "/page/index.html", &format!("Range: bytes={text}\r\n"));
    for (text, from, body) in
        [("0-2", "0-2", "the"), ("4-", "4-7", "page"), ("-4", "4-7", "page"), ("4-99", "4-7", "page")]
    {
        let (head, found) = part(text);
        assert!(head.starts_with("HTTP/1.1 206 ") && head.contains(&format!("bytes {from}/8\r\n")), "{text}: {head}");
        assert_eq!(String::from_utf8_lossy(&found), body, "{text}");
    }
    assert!(part("8-").0.starts_with("HTTP/1.1 416 "));
    for whole in ["0-1,3-4", "5-2", "x-", "-"] {
        assert_eq!(part(whole).1, b"the page", "{whole}");
    }
    // A name that elsewhere was made to mean this machine.
    for host in ["Host: evil.example\r\n", "Host: 127.0.0.1.evil.example:80\r\n", ""] {
        let (head, _) = server.says(format!("GET /page/index.html HTTP/1.1\r\n{host}\r\n").as_bytes());
        assert!(head.starts_with("HTTP/1.1 403 "), "{host}: {head}");
    }
    assert!(server.says(b"GET / HTTP/1.1\r\nHost: localhost:8000\r\n\r\n").0.starts_with("HTTP/1.1 302 "));
    for wrong in [&b"\r\n\r\n"[..], b"GET /\r\n\r\n", b"GET / HTTP/2\r\n\r\n", b"\xff / HTTP/1.1\r\n\r\n"] {
        assert!(server.says(wrong).0.starts_with("HTTP/1.1 400 "), "{wrong:?}");
    }
    let long = [&b"GET /"[..], &b"a".repeat((16 << 10) - 5)].concat();
    assert!(server.says(&long).0.starts_with("HTTP/1.1 400 "));
    // One that says nothing keeps nobody waiting.
    let _silent: Vec<TcpStream> =
        (0..8).map(|_| TcpStream::connect(("127.0.0.1", server.port)).expect("it listens")).collect();
    assert_eq!(server.code("GET", "/page/index.html"), "200");
}

#[test]
fn it_says_what_it_lacks_and_ends_by_a_signal() {
    let stage = results();
    let mut server = Server::of(&stage.path("r"));
    let port = server.port.to_string();
    let ran = run(ltsc().arg("serve").arg(stage.path("r")).args(["--port", &port]));
    assert!(ran.code == Some(4) && ran.err.contains(&port) && ran.err.contains("--port"), "{}", ran.err);
    let pid = rustix::process::Pid::from_child(&server.child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("a signal");
    assert_eq!(server.child.wait().expect("an end").signal(), Some(2));
    let ran = run(ltsc().arg("serve").arg(stage.path("nowhere")));
    assert!(ran.code == Some(2) && ran.err.contains("no such folder"), "{}", ran.err);
    let ran = run(ltsc().arg("serve").arg(stage.path("r/ünï ☃")));
    assert!(ran.code == Some(2) && ran.err.contains("ltsc report"), "{}", ran.err);
}

#[test]
fn a_page_works_from_an_address_too() {
    let stage = Stage::real();
    stage.image(&format!("real/scenes/cbox_classic/{}.exr", HOSTILE.replace('/', "")), &super::page::ramp(48, 36, 0.1));
    stage.report("real");
    let server = Server::of(&stage.path("real"));
    let Some(mut browser) = Browser::start("a_page_works_from_an_address_too", (1100, 620)) else { return };
    browser.visit(&format!("http://127.0.0.1:{}/#view?scene=cbox_classic&show=map&map=flip", server.port));
    assert_eq!(browser.eval("ltsc.store.loaded().length"), 2);
    assert_eq!(browser.problems(), Vec::<String>::new());
    let file = browser.eval(
        "Promise.all(ltsc.book.images.filter((one) => one.file).map((one) => new Promise((resolve) => { const a = document.createElement('a'); \
         a.href = ltsc.path(one.file); resolve(a.pathname); })))",
    );
    let paths: Vec<&str> = file.as_array().expect("a list").iter().filter_map(|path| path.as_str()).collect();
    assert!(paths.len() >= 4 && paths.iter().all(|path| server.code("HEAD", path) == "200"), "{paths:?}");
}
