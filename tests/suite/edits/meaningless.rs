//! What of generated files says nothing of the scene, so that the audit need not see when it is another.

use super::change::Change;

/// Why an edit of `file` of `target` means nothing; none where it means something.
pub fn reason(target: &str, file: &str, change: &Change) -> Option<&'static str> {
    TABLE.iter().find(|row| (row.of)(target, file) && (row.applies)(change)).map(|row| row.why)
}

/// A kind of edits that mean nothing.
struct Row {
    /// In which files of which target.
    of: fn(&str, &str) -> bool,
    /// Which edits.
    applies: fn(&Change) -> bool,
    /// Why.
    why: &'static str,
}

fn mitsuba(target: &str, _: &str) -> bool {
    target.starts_with("mitsuba")
}

fn pbrt(target: &str, _: &str) -> bool {
    target.starts_with("pbrt")
}

fn luxcore(target: &str, _: &str) -> bool {
    target == "luxcore"
}

fn cycles(target: &str, _: &str) -> bool {
    target == "cycles"
}

fn gltf(target: &str, _: &str) -> bool {
    target == "gltf" || target == "glb"
}

/// Whether the edit stands in a comment that begins with `sign`.
fn comment(change: &Change, sign: char) -> bool {
    change.before.trim_start().starts_with(sign)
}

/// Whether the edit stands in the text of this key of JSON.
fn value_of(change: &Change, key: &str) -> bool {
    let before = &change.before;
    let Some((_, rest)) = before.rsplit_once(&format!("\"{key}\":")) else { return false };
    let text = rest.trim_start();
    // Within the quotes, or the number itself.
    (text.starts_with('"') && !text[1..].replace("\\\"", "").contains('"')) || text.is_empty()
}

const TABLE: &[Row] = &[
    Row {
        of: |_, file| file == "ledger.json",
        applies: |_| true,
        why: "the account of losses, which no renderer reads",
    },
    Row {
        of: mitsuba,
        applies: |change| change.before.rfind("<!--").is_some_and(|at| !change.before[at..].contains("-->")),
        why: "a comment",
    },
    Row {
        of: |target, _| ["pbrt-v3", "pbrt-v4", "luxcore", "cycles"].contains(&target),
        applies: |change| comment(change, '#'),
        why: "a comment",
    },
    Row {
        of: mitsuba,
        applies: |change| {
            let named = |tag: &str| change.before.contains(tag) && change.before.contains(" id=\"");
            named("<shape type=") || named("<emitter type=")
        },
        why: "the name of a shape or light, which nothing refers to",
    },
    Row {
        of: mitsuba,
        applies: |change| change.line.contains("rrDepth") || change.line.contains("rr_depth"),
        why: "where paths begin to end by chance: the same image with other noise",
    },
    Row {
        of: pbrt,
        applies: |change| change.before.trim_end().ends_with("\"float rrthreshold\" ["),
        why: "where paths begin to end by chance: the same image with other noise",
    },
    Row {
        of: pbrt,
        applies: |change| change.before.contains("lightsample"),
        why: "how lights are chosen: the same image with other noise",
    },
    Row {
        of: |target, file| pbrt(target, file) && file.contains("settings"),
        applies: |change| change.before.contains("\"string filename\" [\""),
        why: "the file of the image",
    },
    Row {
        of: luxcore,
        applies: |change| change.before.contains("film.outputs.0.") && change.before.contains('='),
        why: "the file of the image",
    },
    Row {
        of: luxcore,
        applies: |change| change.before.contains("path.russianroulette.depth ="),
        why: "where paths begin to end by chance: the same image with other noise",
    },
    Row {
        of: cycles,
        applies: |change| {
            let call = |name: &str| change.before.trim_start().starts_with(name);
            let first = !change.before.contains("\",");
            first
                && (call("instance(\"")
                    || call("shape(\"")
                    || call("emitter(\"")
                    || call("scene(")
                    || call("light")
                    || call("point(")
                    || call("spot(")
                    || call("sun("))
        },
        why: "a name, which nothing refers to",
    },
    Row {
        of: gltf,
        applies: |change| ["generator", "copyright", "comment"].iter().any(|key| value_of(change, key)),
        why: "who wrote the file, and its license",
    },
    Row {
        of: |_, file| file.contains("settings") || file == "scene.scn",
        applies: |change| {
            let words: Vec<&str> = change.before.split_whitespace().collect();
            let look = words.first() == Some(&"LookAt") && (7..=9).contains(&words.len());
            look || change.before.contains("up=\"") || change.before.starts_with("scene.camera.up =")
        },
        why: "an upward direction that the camera's own makes the same",
    },
    Row {
        of: gltf,
        applies: |change| value_of(change, "thicknessFactor") && change.to != b"0" && !change.to.starts_with(b"-"),
        why: "how thick a body is, for programs that trace no rays into it: only 0 means something",
    },
    Row {
        of: gltf,
        applies: |change| value_of(change, "name") || (change.from == "name" && change.to == b"extras"),
        why: "a name, which nothing refers to",
    },
    Row {
        of: gltf,
        applies: |change| {
            value_of(change, "byteLength") && change.from < String::from_utf8_lossy(&change.to).into_owned()
        },
        why: "a part of a buffer that ends later: what lies in it says the accessor",
    },
];
