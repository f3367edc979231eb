//! glTF as Khronos's own validator judges it.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::{root, scenes, skip};

/// The folder `node_modules` with the package `gltf-validator`.
fn modules() -> Option<PathBuf> {
    let named = std::env::var_os("LTSC_NODE_MODULES").map(PathBuf::from);
    let folder = named.unwrap_or_else(|| root().join("target/validators/node_modules"));
    folder.join("gltf-validator").is_dir().then_some(folder)
}

/// Prints a line of JSON for each file: its report.
const SCRIPT: &str = "
const fs = require('fs'), path = require('path');
const validator = require(path.join(process.argv[1], 'gltf-validator'));
(async () => {
    for (const file of process.argv.slice(2)) {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
            uri: path.basename(file),
            maxIssues: 0,
            externalResourceFunction: async (uri) => new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
        });
        console.log(JSON.stringify(report));
    }
})().catch((error) => { console.error(error); process.exit(1); });
";

/// What the validator says of each file; none where it is missing.
fn reports(test: &str, files: &[PathBuf]) -> Option<Vec<Value>> {
    let Some(modules) = modules() else {
        skip(test, "the npm package gltf-validator in target/validators");
        return None;
    };
    let output = Command::new("node").args(["-e", SCRIPT]).arg(&modules).args(files).output().expect("node starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    let reports: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("a report")).collect();
    assert_eq!(reports.len(), files.len());
    Some(reports)
}

fn has_no_issue(file: &Path, report: &Value) {
    let issues = &report["issues"];
    let counts = (&issues["numErrors"], &issues["numWarnings"]);
    assert_eq!(counts, (&0.into(), &0.into()), "{}: {issues:#}", file.display());
}

#[test]
fn generated_gltf_and_glb_have_no_error_and_no_warning() {
    let name = |scene: &str, form: &str| root().join(format!("generated/{scene}/{form}/{scene}.{form}"));
    let files: Vec<PathBuf> = scenes().iter().flat_map(|scene| ["gltf", "glb"].map(|form| name(scene, form))).collect();
    let Some(reports) = reports("gltf", &files) else { return };
    for (pair, files) in reports.chunks(2).zip(files.chunks(2)) {
        for (report, file) in pair.iter().zip(files) {
            has_no_issue(file, report);
        }
        // Both forms hold the same things.
        let what = |report: &Value| {
            let mut info = report["info"].clone();
            info["resources"] = Value::Null;
            info
        };
        assert_eq!(what(&pair[0]), what(&pair[1]), "{}", files[0].display());
        assert!(pair[0]["info"]["totalTriangleCount"].as_u64().expect("a count") > 0);
    }
}
