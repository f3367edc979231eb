//! A headless browser, driven by its protocol: a small client that opens a page, runs scripts in it, presses keys, and notes what the
//! page complains about and asks the network for. Here is what Chromium is told; `firefox` has what differs in Firefox.

use std::io::ErrorKind;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket};

use super::{firefox, skip};

/// How long anything may take.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// A browser with one open page. It ends with the value.
pub struct Browser {
    children: Vec<Child>,
    pub wire: Wire,
    /// The page in Firefox; nothing in Chromium.
    firefox: Option<String>,
    _profile: tempfile::TempDir,
    /// Few at a time: each draws with all processors.
    _seat: MutexGuard<'static, ()>,
}

static SEATS: [Mutex<()>; 2] = [const { Mutex::new(()) }; 2];

/// A free one, else one of them in turn, once it is given up.
fn seat() -> MutexGuard<'static, ()> {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let free = SEATS.iter().find_map(|seat| match seat.try_lock() {
        Ok(seat) => Some(seat),
        Err(TryLockError::Poisoned(seat)) => Some(seat.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    });
    let next = NEXT.fetch_add(1, Ordering::Relaxed) % SEATS.len();
    free.unwrap_or_else(|| SEATS[next].lock().unwrap_or_else(PoisonError::into_inner))
}

/// A program, where the system has it by one of these names, or the variable names it.
pub fn program(variable: &str, names: &[&str]) -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(variable) {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let files = std::env::split_paths(&path).flat_map(|folder| names.iter().map(move |name| folder.join(name)));
    files.into_iter().find(|file| file.is_file())
}

/// Commands to a browser, their answers, and the events that come in between.
pub struct Wire {
    socket: WebSocket<TcpStream>,
    session: String,
    next: u64,
    events: Vec<Value>,
}

impl Wire {
    pub fn connect(port: u64, path: &str) -> Self {
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("the browser listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        // Answers hold whole images.
        let config = WebSocketConfig::default().max_message_size(None).max_frame_size(None);
        let address = format!("ws://127.0.0.1:{port}{path}");
        let (socket, _) = tungstenite::client::client_with_config(address, stream, Some(config)).expect("a connection");
        Self { socket, session: String::new(), next: 0, events: Vec::new() }
    }

    /// Sends a command and waits for its answer.
    pub fn send(&mut self, method: &str, params: Value) -> Value {
        self.next += 1;
        let mut message = json!({ "id": self.next, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(message.to_string())).expect("the browser hears");
        loop {
            let answer = self.receive();
            if answer["id"] == json!(self.next) {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    fn receive(&mut self) -> Value {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => return serde_json::from_str(text.as_str()).expect("JSON"),
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => panic!("the browser is gone: {error}"),
            }
        }
    }
}

/// Waits for what a browser writes into its profile.
pub fn wait<T>(look: impl Fn() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "the browser does not say where it listens");
        std::thread::sleep(Duration::from_millis(20));
    }
}

impl Browser {
    /// Firefox with a window of this size; nothing, and a word about it, where there is none.
    pub fn firefox(test: &str, size: (u32, u32)) -> Option<Self> {
        let Some(programs) = firefox::programs() else {
            skip(test, "Firefox and Xvfb");
            return None;
        };
        let seat = seat();
        let profile = tempfile::tempdir().expect("a folder");
        let (children, wire, page) = firefox::start(&programs, profile.path(), size);
        Some(Self { children, wire, firefox: Some(page), _profile: profile, _seat: seat })
    }

    /// Chromium with a window of this size; nothing, and a word about it, where there is none.
    pub fn start(test: &str, (width, height): (u32, u32)) -> Option<Self> {
        let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
        let Some(program) = program("LTSC_CHROMIUM", &names) else {
            skip(test, "Chromium");
            return None;
        };
        let seat = seat();
        let profile = tempfile::tempdir().expect("a folder");
        let child = Command::new(program)
            .args(["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .args([
                "--remote-debugging-port=0",
                "--no-first-run",
                "--disable-extensions",
                "--disable-background-networking",
            ])
            .args(["--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the browser starts");
        let place = profile.path().join("DevToolsActivePort");
        let (port, path) = wait(|| {
            let text = std::fs::read_to_string(&place).unwrap_or_default();
            let (port, path) = text.split_once('\n').filter(|(_, path)| path.starts_with("/devtools/"))?;
            Some((port.parse().ok()?, path.trim().to_owned()))
        });
        let wire = Wire::connect(port, &path);
        let mut browser = Self { children: vec![child], wire, firefox: None, _profile: profile, _seat: seat };
        let target = browser.send("Target.createTarget", json!({ "url": "about:blank" }));
        let attached =
            browser.send("Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        browser.wire.session = attached["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.send(&format!("{domain}.enable"), json!({}));
        }
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        browser.send("Emulation.setDeviceMetricsOverride", size);
        Some(browser)
    }

    /// Sends a command of Chromium's protocol and waits for its answer.
    pub fn send(&mut self, method: &str, params: Value) -> Value {
        self.wire.send(method, params)
    }

    fn navigate(&mut self, url: &str) {
        match &self.firefox {
            Some(page) => firefox::navigate(&mut self.wire, page, url),
            None => drop(self.send("Page.navigate", json!({ "url": url }))),
        }
    }

    /// Opens a page of ours, and waits until its data is there.
    pub fn open(&mut self, file: &Path, hash: &str) {
        let file = file.canonicalize().expect("a page");
        let plain = file.to_str().expect("a name in UTF-8").replace('%', "%25").replace('#', "%23").replace('?', "%3f");
        self.visit(&format!("file://{plain}{hash}"));
    }

    /// Opens one by its address.
    pub fn visit(&mut self, url: &str) {
        // Another part behind `#` alone would not load the page anew.
        self.navigate("about:blank");
        self.navigate(url);
        self.until("typeof ltsc !== 'undefined' && ltsc.ready === true");
        self.settle();
    }

    /// The value of an expression, or of what it promises.
    pub fn eval(&mut self, expression: &str) -> Value {
        if let Some(page) = &self.firefox {
            return firefox::eval(&mut self.wire, page, expression);
        }
        let params =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true });
        let result = self.send("Runtime.evaluate", params);
        let wrong = &result["exceptionDetails"];
        assert!(wrong.is_null(), "{expression}: {}", wrong["exception"]["description"]);
        result["result"]["value"].clone()
    }

    /// A text that an expression gives.
    pub fn text(&mut self, expression: &str) -> String {
        let value = self.eval(expression);
        value.as_str().unwrap_or_else(|| panic!("{expression} is {value}")).to_owned()
    }

    /// Floats that an expression gives as a `Float32Array`.
    pub fn floats(&mut self, expression: &str) -> Vec<f32> {
        let bytes = self.bytes(expression);
        bytes.chunks_exact(4).map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]])).collect()
    }

    /// The bytes of an array that an expression gives.
    pub fn bytes(&mut self, expression: &str) -> Vec<u8> {
        let read = format!(
            "(async () => {{ const a = await ({expression}); const b = new Uint8Array(a.buffer, a.byteOffset, a.byteLength); let s = ''; \
             for (let i = 0; i < b.length; i += 8192) s += String.fromCharCode(...b.subarray(i, i + 8192)); return btoa(s); }})()"
        );
        STANDARD.decode(self.text(&read)).expect("base64")
    }

    /// Waits until an expression is true.
    pub fn until(&mut self, expression: &str) {
        let start = Instant::now();
        while self.eval(expression) != json!(true) {
            assert!(start.elapsed() < PATIENCE, "it does not come: {expression}; {:?}", self.problems());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until the viewer has drawn what it is to show.
    pub fn settle(&mut self) {
        self.until("!document.querySelector('.viewer') || !ltsc.draw.busy()");
    }

    /// Presses a key, such as `e`, `E`, `Shift+ArrowRight` or `Shift+Digit2`.
    pub fn key(&mut self, name: &str) {
        let (mut modifiers, mut plain) = (0, name);
        for (prefix, bit) in [("Alt+", 1), ("Shift+", 8)] {
            if let Some(rest) = plain.strip_prefix(prefix) {
                (modifiers, plain) = (modifiers | bit, rest);
            }
        }
        let digit = plain.strip_prefix("Digit");
        let (key, code) = match digit {
            Some(digit) if modifiers & 8 != 0 => {
                ("!@#$%^&*(".get(digit.parse::<usize>().map_or(0..1, |at| at - 1..at)).unwrap_or(digit), plain)
            }
            Some(digit) => (digit, plain),
            None => (plain, ""),
        };
        if key.len() == 1 && key.chars().all(char::is_uppercase) {
            modifiers |= 8;
        }
        match &self.firefox {
            Some(page) => firefox::key(&mut self.wire, page, key, modifiers),
            None => {
                for kind in ["keyDown", "keyUp"] {
                    let params = json!({ "type": kind, "key": key, "code": code, "modifiers": modifiers });
                    self.send("Input.dispatchKeyEvent", params);
                }
            }
        }
        self.settle();
    }

    /// A pointer that is pressed, moved along these places, and let go; the wheel where there is one place and `wheel` is not 0.
    pub fn pointer(&mut self, places: &[(f64, f64)], modifiers: u32, wheel: f64) {
        if let Some(page) = &self.firefox {
            firefox::pointer(&mut self.wire, page, places, modifiers, wheel);
            return self.settle();
        }
        let mut mouse = |kind: &str, (x, y): (f64, f64), buttons: u32| {
            let params = json!({
                "type": kind, "x": x, "y": y, "button": if buttons > 0 || kind == "mouseReleased" { "left" } else { "none" },
                "buttons": buttons, "clickCount": 1, "modifiers": modifiers, "deltaX": 0, "deltaY": wheel,
            });
            self.send("Input.dispatchMouseEvent", params);
        };
        let (first, last) = (places[0], places[places.len() - 1]);
        mouse("mouseMoved", first, 0);
        if wheel != 0.0 {
            mouse("mouseWheel", first, 0);
        } else if places.len() > 1 {
            mouse("mousePressed", first, 1);
            places[1..].iter().for_each(|place| mouse("mouseMoved", *place, 1));
            mouse("mouseReleased", last, 0);
        }
        self.settle();
    }

    /// What the page complains about.
    pub fn problems(&self) -> Vec<String> {
        let words = |event: &Value| {
            let params = &event["params"];
            match event["method"].as_str()? {
                "Runtime.exceptionThrown" => Some(params["exceptionDetails"].to_string()),
                "Runtime.consoleAPICalled"
                    if matches!(params["type"].as_str(), Some("error" | "warning" | "assert")) =>
                {
                    Some(params["args"].to_string())
                }
                "Log.entryAdded" if matches!(params["entry"]["level"].as_str(), Some("error" | "warning")) => {
                    Some(params["entry"].to_string())
                }
                "log.entryAdded" if matches!(params["level"].as_str(), Some("error" | "warn")) => {
                    Some(params["text"].to_string())
                }
                _ => None,
            }
        };
        // That reading pixels is slow is told of what the tests do.
        let own = |text: &String| text.contains("GPU stall due to ReadPixels") || text.contains("willReadFrequently");
        self.wire.events.iter().filter_map(words).filter(|text| !own(text)).collect()
    }

    /// Addresses that were asked for. Firefox does not tell of those of the disk.
    fn asked(&self) -> impl Iterator<Item = &str> {
        let sent = ["Network.requestWillBeSent", "network.beforeRequestSent"];
        let events = self.wire.events.iter().filter(move |event| sent.iter().any(|name| event["method"] == *name));
        events.filter_map(|event| event["params"]["request"]["url"].as_str())
    }

    /// Addresses that were asked for and are no files of the disk and nothing of the page itself.
    pub fn requests(&self) -> Vec<String> {
        let own = ["file://", "data:", "blob:", "about:blank"];
        self.asked().filter(|url| !own.iter().any(|start| url.starts_with(start))).map(str::to_owned).collect()
    }

    /// Files that were asked for whose names hold a word.
    pub fn files(&self, word: &str) -> usize {
        self.asked().filter(|url| url.contains(word)).count()
    }

    /// Forgets what was noted.
    pub fn forget(&mut self) {
        self.wire.events.clear();
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        for child in &mut self.children {
            let _gone = child.kill();
            let _ended = child.wait();
        }
    }
}
