//! glTF as Khronos's own validator judges it.

use std::path::PathBuf;
use std::process::Command;

use super::{root, scenes, skip};

/// The folder `node_modules` with the package `gltf-validator`.
fn modules() -> Option<PathBuf> {
    let named = std::env::var_os("LTSC_NODE_MODULES").map(PathBuf::from);
    let folder = named.unwrap_or_else(|| root().join("target/validators/node_modules"));
    folder.join("gltf-validator").is_dir().then_some(folder)
}

const SCRIPT: &str = "
const fs = require('fs'), path = require('path');
const validator = require(path.join(process.argv[1], 'gltf-validator'));
const file = process.argv[2];
validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    externalResourceFunction: (uri) => Promise.resolve(new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))))),
}).then((report) => {
    console.log(JSON.stringify(report.issues));
}, (error) => { console.error(error); process.exit(1); });
";

#[test]
fn generated_gltf_has_no_error_and_no_warning() {
    let Some(modules) = modules() else { return skip("gltf", "the npm package gltf-validator in target/validators") };
    for scene in scenes() {
        let file = root().join(format!("generated/{scene}/gltf/{scene}.gltf"));
        let output = Command::new("node").args(["-e", SCRIPT]).arg(&modules).arg(&file).output().expect("node starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let issues: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
        assert_eq!((&issues["numErrors"], &issues["numWarnings"]), (&0.into(), &0.into()), "{scene}: {issues:#}");
    }
}
