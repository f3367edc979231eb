//! What differs where the browser is Firefox: it speaks WebDriver BiDi. Without a display it has no WebGL, so that it draws beside an
//! invisible one, where Mesa is its graphics processor.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use super::browser::{Wire, program, wait};

/// What a new profile says: drawing by WebGL whatever the driver, colors as they are, and nothing asked of the network.
const PREFERENCES: [(&str, &str); 9] = [
    ("webgl.force-enabled", "true"),
    ("gfx.color_management.mode", "0"),
    ("app.normandy.enabled", "false"),
    ("app.update.disabledForTesting", "true"),
    ("browser.startup.page", "0"),
    ("datareporting.policy.dataSubmissionEnabled", "false"),
    ("network.captive-portal-service.enabled", "false"),
    ("network.connectivity-service.enabled", "false"),
    ("services.settings.server", "\"data:,\""),
];

/// Firefox, and the display that shows nothing.
pub fn programs() -> Option<(PathBuf, PathBuf)> {
    Some((program("LTSC_FIREFOX", &["firefox-esr", "firefox"])?, program("LTSC_XVFB", &["Xvfb"])?))
}

/// Starts both: the programs, the connection, and the name of the page.
pub fn start(programs: &(PathBuf, PathBuf), profile: &Path, (width, height): (u32, u32)) -> (Vec<Child>, Wire, String) {
    let mut display = Command::new(&programs.1)
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the display starts");
    let mut number = String::new();
    BufReader::new(display.stdout.take().expect("a pipe")).read_line(&mut number).expect("the display says its number");
    let preferences = PREFERENCES.map(|(name, value)| format!("user_pref(\"{name}\", {value});\n")).concat();
    std::fs::write(profile.join("user.js"), preferences).expect("a profile");
    let browser = Command::new(&programs.0)
        .args(["--headless", "--no-remote", "--remote-debugging-port=0", "--profile"])
        .arg(profile)
        .arg("about:blank")
        .env("DISPLAY", format!(":{}", number.trim()))
        .env("LIBGL_ALWAYS_SOFTWARE", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    let place = profile.join("WebDriverBiDiServer.json");
    let port = wait(|| {
        let text = std::fs::read_to_string(&place).ok()?;
        serde_json::from_str::<Value>(&text).ok()?["ws_port"].as_u64()
    });
    let mut wire = Wire::connect(port, "/session");
    wire.send("session.new", json!({ "capabilities": {} }));
    wire.send("session.subscribe", json!({ "events": ["log.entryAdded", "network.beforeRequestSent"] }));
    let pages = wire.send("browsingContext.getTree", json!({}));
    let page = pages["contexts"][0]["context"].as_str().expect("a page").to_owned();
    let size = json!({ "context": page, "viewport": { "width": width, "height": height }, "devicePixelRatio": 1 });
    wire.send("browsingContext.setViewport", size);
    (vec![browser, display], wire, page)
}

pub fn navigate(wire: &mut Wire, page: &str, url: &str) {
    wire.send("browsingContext.navigate", json!({ "context": page, "url": url, "wait": "complete" }));
}

pub fn eval(wire: &mut Wire, page: &str, expression: &str) -> Value {
    let target = json!({ "context": page });
    let params = json!({ "expression": expression, "target": target, "awaitPromise": true, "userActivation": true });
    let answer = wire.send("script.evaluate", params);
    let wrong = &answer["exceptionDetails"];
    assert!(wrong.is_null(), "{expression}: {}", wrong["text"]);
    plain(&answer["result"])
}

/// A value as JSON, without the names of its types. What JSON has not is nothing.
fn plain(value: &Value) -> Value {
    let inside = &value["value"];
    match value["type"].as_str() {
        Some("number") if inside == "-0" => json!(0),
        Some("number") if inside.is_string() => Value::Null,
        Some("string" | "boolean" | "number") => inside.clone(),
        Some("array") => inside.as_array().into_iter().flatten().map(plain).collect(),
        Some("object") => {
            let pairs = inside.as_array().into_iter().flatten();
            pairs.filter_map(|pair| Some((pair[0].as_str()?.to_owned(), plain(&pair[1])))).collect()
        }
        _ => Value::Null,
    }
}

/// Keys that hold, by the bits of the modifiers.
const HELD: [(u32, &str); 2] = [(1, "\u{e00a}"), (8, "\u{e008}")];

fn hold(modifiers: u32, kind: &str) -> Vec<Value> {
    let held = HELD.iter().filter(|(bit, _)| modifiers & bit != 0);
    held.map(|(_, key)| json!({ "type": kind, "value": key })).collect()
}

fn act(wire: &mut Wire, page: &str, kind: &str, actions: &[Value]) {
    if !actions.is_empty() {
        let source = json!({ "type": kind, "id": kind, "actions": actions });
        wire.send("input.performActions", json!({ "context": page, "actions": [source] }));
    }
}

pub fn key(wire: &mut Wire, page: &str, key: &str, modifiers: u32) {
    let value = match key {
        "ArrowLeft" => "\u{e012}",
        "ArrowUp" => "\u{e013}",
        "ArrowRight" => "\u{e014}",
        "ArrowDown" => "\u{e015}",
        other => other,
    };
    let mut actions = hold(modifiers, "keyDown");
    actions.extend(["keyDown", "keyUp"].map(|kind| json!({ "type": kind, "value": value })));
    actions.extend(hold(modifiers, "keyUp"));
    act(wire, page, "key", &actions);
}

pub fn pointer(wire: &mut Wire, page: &str, places: &[(f64, f64)], modifiers: u32, wheel: f64) {
    let go = |&(x, y): &(f64, f64)| json!({ "type": "pointerMove", "x": x, "y": y });
    act(wire, page, "key", &hold(modifiers, "keyDown"));
    if wheel != 0.0 {
        let (x, y) = (places[0].0 as i64, places[0].1 as i64);
        act(wire, page, "wheel", &[json!({ "type": "scroll", "x": x, "y": y, "deltaX": 0, "deltaY": wheel as i64 })]);
    } else {
        let mut actions = vec![go(&places[0])];
        if places.len() > 1 {
            actions.push(json!({ "type": "pointerDown", "button": 0 }));
            actions.extend(places[1..].iter().map(go));
            actions.push(json!({ "type": "pointerUp", "button": 0 }));
        }
        act(wire, page, "pointer", &actions);
    }
    act(wire, page, "key", &hold(modifiers, "keyUp"));
}
