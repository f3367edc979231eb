//! A headless Chromium, driven by its protocol: a small client that opens a page, runs scripts in it, presses keys, and notes what the
//! page complains about and asks the network for.

use std::io::ErrorKind;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket};

use super::skip;

/// How long anything may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// A browser with one open page. It ends with the value.
pub struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: String,
    next: u64,
    events: Vec<Value>,
    _profile: tempfile::TempDir,
    /// One at a time: each draws with all processors.
    _alone: MutexGuard<'static, ()>,
}

static ALONE: Mutex<()> = Mutex::new(());

/// The program, where the system has one.
fn program() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("LTSC_CHROMIUM") {
        return Some(PathBuf::from(named));
    }
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name))).find(|file| file.is_file())
}

impl Browser {
    /// Starts one with a window of this size; nothing, and a word about it, where there is none.
    pub fn start(test: &str, (width, height): (u32, u32)) -> Option<Self> {
        let Some(program) = program() else {
            skip(test, "Chromium");
            return None;
        };
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
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
        let start = Instant::now();
        let (port, path) = loop {
            let text = std::fs::read_to_string(&place).unwrap_or_default();
            if let Some((port, path)) = text.split_once('\n')
                && path.starts_with("/devtools/")
            {
                break (port.to_owned(), path.trim().to_owned());
            }
            assert!(start.elapsed() < PATIENCE, "the browser does not say where it listens");
            std::thread::sleep(Duration::from_millis(20));
        };
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("the browser listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        // Answers hold whole images.
        let config = WebSocketConfig::default().max_message_size(None).max_frame_size(None);
        let address = format!("ws://127.0.0.1:{port}{path}");
        let (socket, _) = tungstenite::client::client_with_config(address, stream, Some(config)).expect("a connection");
        let (session, events) = (String::new(), Vec::new());
        let mut browser = Self { child, socket, session, next: 0, events, _profile: profile, _alone: alone };
        let target = browser.send("Target.createTarget", json!({ "url": "about:blank" }));
        let attached =
            browser.send("Target.attachToTarget", json!({ "targetId": target["targetId"], "flatten": true }));
        browser.session = attached["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.send(&format!("{domain}.enable"), json!({}));
        }
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        browser.send("Emulation.setDeviceMetricsOverride", size);
        Some(browser)
    }

    /// Sends a command and waits for its answer; events that come in between are kept.
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
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
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

    /// Opens a page of ours, and waits until its data is there.
    pub fn open(&mut self, file: &Path, hash: &str) {
        let file = file.canonicalize().expect("a page");
        let plain = file.to_str().expect("a name in UTF-8").replace('%', "%25").replace('#', "%23").replace('?', "%3f");
        // Another part behind `#` alone would not load the page anew.
        self.send("Page.navigate", json!({ "url": "about:blank" }));
        self.send("Page.navigate", json!({ "url": format!("file://{plain}{hash}") }));
        self.until("typeof ltsc !== 'undefined' && ltsc.ready === true");
        self.settle();
    }

    /// The value of an expression, or of what it promises.
    pub fn eval(&mut self, expression: &str) -> Value {
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
        for kind in ["keyDown", "keyUp"] {
            let params = json!({ "type": kind, "key": key, "code": code, "modifiers": modifiers });
            self.send("Input.dispatchKeyEvent", params);
        }
        self.settle();
    }

    /// A pointer that is pressed, moved along these places, and let go; the wheel where there is one place and `wheel` is not 0.
    pub fn pointer(&mut self, places: &[(f64, f64)], modifiers: u32, wheel: f64) {
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
                _ => None,
            }
        };
        // That reading pixels is slow is told of what the tests do.
        let own = |text: &String| text.contains("GPU stall due to ReadPixels") || text.contains("willReadFrequently");
        self.events.iter().filter_map(words).filter(|text| !own(text)).collect()
    }

    /// Addresses that were asked for and are no files of the disk and nothing of the page itself.
    pub fn requests(&self) -> Vec<String> {
        let sent = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        let urls = sent.filter_map(|event| event["params"]["request"]["url"].as_str().map(str::to_owned));
        let own = ["file://", "data:", "blob:", "about:blank"];
        urls.filter(|url| !own.iter().any(|start| url.starts_with(start))).collect()
    }

    /// Files that were asked for whose names hold a word.
    pub fn files(&self, word: &str) -> usize {
        let sent = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        sent.filter(|event| event["params"]["request"]["url"].as_str().is_some_and(|url| url.contains(word))).count()
    }

    /// Forgets what was noted.
    pub fn forget(&mut self) {
        self.events.clear();
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _ended = self.child.wait();
    }
}
