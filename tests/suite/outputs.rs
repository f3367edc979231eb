//! What comes out of `ltsc lint`: forms for programs, levels, exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::{ltsc, root, run, skip};

/// The text of a scene that has no findings.
pub const CLEAN: &str = "lts 1\n\n/// A.\n///\n/// B.\nscene NAME {\n    paths: [\"LDE\"]\n}\n\n\
    camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(16, 8)\n\
    integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
    emitter lamp = rectangle(x: -1..1, y: -1..1, z: 5, normal: -Z) with radiance(10)\n\
    shape floor = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with diffuse(0.5)\n";

/// A project in `folder` with scenes of these names and additions.
pub fn project(folder: &Path, scenes: &[(&str, &str)]) {
    fs::write(folder.join("ltsc.toml"), "scenes = \"scenes\"\n").expect("a project file");
    for (path, more) in scenes {
        let file = folder.join(format!("scenes/{path}.lts"));
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        let name = path.rsplit('/').next().expect("a name");
        let paths = format!("\"LD{}E\"", "D".repeat(name.len()));
        let text = CLEAN.replace("NAME", name).replace("\"LDE\"", &paths);
        fs::write(file, format!("{text}{more}")).expect("a scene");
    }
}

const BULB: &str = "emitter bulb = sphere(center: (0, 0, 3)) with radiance(1)\n";

/// A Python that has these modules: the one that `.ci/run` installs, or the system's.
pub fn python(modules: &[&str]) -> Option<PathBuf> {
    let own = root().join("target/validators/python/bin/python");
    let imports: String = modules.iter().map(|module| format!("import {module};")).collect();
    let has = |python: &PathBuf| {
        let ran = Command::new(python).args(["-c", &imports]).output();
        ran.is_ok_and(|ran| ran.status.success())
    };
    [own, PathBuf::from("python3")].into_iter().find(has)
}

/// Everything that a finding can be: errors in two files, a suppression, places without text, special letters in a path.
fn everything(folder: &Path) {
    project(
        folder,
        &[
            ("a b é/lamp", BULB),
            ("broken", "shape a = spere() with diffuse(0.5)\nshape `é` = box(size: nothing) with diffuse(0.5)\n"),
            ("allowed", &format!("allow smooth-emitter \"it is the point\"\n{BULB}")),
            ("twice", "let x = 1\nlet x = 2\nallow unused-name \"50 %, wanted: so\"\nlet y = 3\n"),
            ("bad_mesh", "shape a = file(\"../broken.ply\") with diffuse(0.5)\n"),
        ],
    );
    fs::write(folder.join("broken.ply"), "ply\nformat ascii 1.0\nend_header\n").expect("a mesh");
    fs::write(folder.join("scenes/foreign.scn"), "").expect("a file");
}

fn sarif(folder: &Path, args: &[&str]) -> Value {
    let ran = run(ltsc().current_dir(folder).args(args).args(["--format", "sarif"]));
    let log: Value = serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{args:?}: {error}\n{}", ran.out));
    let told = log["runs"][0]["invocations"][0]["exitCode"].as_i64();
    assert_eq!(told, ran.code.map(i64::from), "{args:?}: the log tells the exit code");
    log
}

#[test]
fn sarif_is_valid_against_the_schema_of_the_standard() {
    let folder = tempfile::tempdir().expect("a folder");
    everything(folder.path());
    let logs = [
        sarif(folder.path(), &["lint", "scenes", "scenes/foreign.scn"]),
        sarif(folder.path(), &["lint", "scenes", "--target", "gltf,luxcore"]),
        sarif(folder.path(), &["lint", "nowhere.lts"]),
        sarif(folder.path(), &["build", "scenes"]),
        sarif(folder.path(), &["emit", "scenes/twice.lts", "--target", "gltf"]),
        // The scene with the most losses.
        sarif(root(), &["build", "scenes-src/surfaces.lts", "--check"]),
    ];
    assert!(logs[0]["runs"][0]["results"].as_array().is_some_and(|results| results.len() > 5), "{:#}", logs[0]);
    assert_eq!(logs[2]["runs"][0]["invocations"][0]["executionSuccessful"], false);
    let Some(python) = python(&["jsonschema"]) else {
        return skip("sarif_is_valid_against_the_schema_of_the_standard", "Python's jsonschema");
    };
    let code = "import json, sys, jsonschema\n\
        schema = json.load(open(sys.argv[1], encoding='utf-8'))\n\
        checker = jsonschema.Draft4Validator(schema, format_checker=jsonschema.FormatChecker())\n\
        for path in sys.argv[2:]:\n\
        \x20   for error in checker.iter_errors(json.load(open(path, encoding='utf-8'))):\n\
        \x20       print(path, list(error.absolute_path), error.message[:300])\n";
    let mut check = Command::new(python);
    check.args(["-c", code]).arg(root().join("tests/oracles/sarif-schema-2.1.0.json"));
    // The last one is wrong, so that a check that sees nothing is seen.
    let mut wrong = logs[0].clone();
    wrong["runs"][0]["results"][0]["level"] = "grave".into();
    for (at, log) in logs.iter().chain([&wrong]).enumerate() {
        let path = folder.path().join(format!("{at}.sarif"));
        fs::write(&path, log.to_string()).expect("a write");
        check.arg(path);
    }
    let ran = run(&mut check);
    assert_eq!((ran.code, ran.out.lines().count()), (Some(0), 1), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("grave"), "{}", ran.out);
}

#[test]
fn sarif_says_where_and_why() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join(".git")).expect("a folder");
    let inner = folder.path().join("suite");
    fs::create_dir(&inner).expect("a folder");
    everything(&inner);
    let log = sarif(&inner, &["lint"]);
    let run = &log["runs"][0];
    let results = run["results"].as_array().expect("results");
    let of = |file: &str, id: &str| {
        let uri = format!("suite/scenes/{file}.lts");
        let here = |result: &&Value| {
            let place = &result["locations"][0]["physicalLocation"]["artifactLocation"];
            result["ruleId"] == id && place["uri"] == uri.as_str() && place["uriBaseId"] == "%SRCROOT%"
        };
        results.iter().find(here).unwrap_or_else(|| panic!("no {id} in {file}: {log:#}"))
    };
    // Paths are seen from the repository, and written as a URI wants them.
    let smooth = of("a%20b%20%C3%A9/lamp", "smooth-emitter");
    assert_eq!((&smooth["level"], smooth.get("suppressions")), (&"error".into(), None));
    let rule = &run["tool"]["driver"]["rules"][smooth["ruleIndex"].as_u64().expect("an index") as usize];
    assert_eq!(rule["id"], "smooth-emitter");
    assert!(rule["help"]["markdown"].as_str().is_some_and(|page| page.contains("**Good**")), "{rule:#}");
    // Columns count code points: `é` is one, and the name stands in column 23 of its line.
    assert_eq!(run["columnKind"], "unicodeCodePoints");
    let region = &of("broken", "unknown-name")["locations"][0]["physicalLocation"]["region"];
    let line = CLEAN.lines().count() + 2;
    assert_eq!(
        (region["startLine"].as_u64(), region["startColumn"].as_u64(), region["endColumn"].as_u64()),
        (Some(line as u64), Some(23), Some(30))
    );
    let twice = of("twice", "duplicate-name");
    assert!(twice["relatedLocations"][0]["message"]["text"].is_string(), "{twice:#}");
    let allowed = of("allowed", "smooth-emitter");
    assert_eq!(allowed["suppressions"][0]["kind"], "inSource");
    assert_eq!(allowed["suppressions"][0]["justification"], "it is the point");
}

#[test]
fn github_gets_annotations() {
    let folder = tempfile::tempdir().expect("a folder");
    everything(folder.path());
    let ran = run(ltsc().current_dir(folder.path()).args(["lint", "--format", "github"]));
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(lines.iter().all(|line| line.starts_with("::error ") || line.starts_with("::warning ")), "{}", ran.out);
    let at = CLEAN.lines().count() + 1;
    let smooth = format!(
        "::error file=scenes/a b é/lamp.lts,line={at},endLine={at},col=1,endColumn={},title=smooth-emitter::the emitter `bulb`",
        BULB.len()
    );
    assert!(lines.iter().any(|line| line.starts_with(&smooth)), "{smooth}\n{}", ran.out);
    assert!(!ran.out.contains("50 %") && ran.err.contains("allowed"), "what is allowed is only counted");
    let missing = run(ltsc().args(["lint", "no,where.lts", "--format", "github"]));
    assert!(missing.code == Some(3) && missing.out.starts_with("::error title=ltsc::no,where.lts"), "{}", missing.out);
}

#[test]
fn levels_come_from_the_project_the_variables_and_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path(), &[("one", BULB)]);
    let lint = |variables: &[(&str, &str)], args: &[&str]| {
        let mut command = ltsc();
        command.current_dir(folder.path()).args(["lint", "--format", "short"]).args(args);
        run(command.envs(variables.iter().copied()))
    };
    let toml = |text: &str| {
        fs::write(folder.path().join("ltsc.toml"), format!("scenes = \"scenes\"\n{text}")).expect("a write")
    };
    assert_eq!(lint(&[], &[]).code, Some(1));
    toml("[rules]\nsmooth-emitter = \"warn\"\n");
    let warned = lint(&[], &[]);
    assert!(warned.code == Some(0) && warned.out.contains("warning[smooth-emitter]"), "{}", warned.out);
    assert_eq!(lint(&[], &["--deny", "warnings"]).code, Some(1));
    assert_eq!(lint(&[("LTSC_DENY", "unused-name, smooth-emitter")], &[]).code, Some(1));
    assert_eq!(lint(&[("LTSC_DENY", "smooth-emitter")], &["--warn", "smooth-emitter,unused-name"]).code, Some(0));
    assert_eq!(lint(&[("LTSC_DENY", "smooth-emitter")], &["--allow", "all"]).out, "");
    let but = lint(&[], &["--deny", "all", "--allow", "smooth-emitter"]);
    assert_eq!((but.code, but.out.as_str()), (Some(0), ""), "a code is stronger than a group");
    toml("[rules]\nall = \"deny\"\nsmooth-emitter = \"allow\"\n");
    assert_eq!(lint(&[], &[]).out, "");

    // What is no rule and no error has a level too.
    let without = format!("{}{BULB}", CLEAN.replace("NAME", "one").replace("lts 1\n\n", ""));
    fs::write(folder.path().join("scenes/one.lts"), without).expect("a write");
    assert!(lint(&[], &[]).out.contains("warning[missing-version]"));
    assert_eq!(lint(&[], &["--deny", "missing-version"]).code, Some(1));
    assert_eq!(lint(&[], &["--allow", "missing-version"]).out, "");

    for (variables, args, words) in [
        (&[][..], &["--deny", "smoth-emitter"][..], "did you mean `smooth-emitter`?"),
        (&[("LTSC_WARN", "smooth-emitter,lose-dropped")], &[], "LTSC_WARN: there is no rule `lose-dropped`"),
        (&[], &["--allow", "syntax-error"], "`syntax-error` is always an error"),
        (&[], &["--deny", "qqqqqqqq"], "`all` and `warnings` are groups"),
    ] {
        let ran = lint(variables, args);
        assert!(ran.code == Some(2) && ran.err.contains(words), "{args:?}: {}", ran.err);
    }
    toml("[rules]\nall = \"warn\"\nsmoth-emitter = \"allow\"\n");
    let ran = lint(&[], &[]);
    assert!(ran.code == Some(3) && ran.err.contains("ltsc.toml:4:1: there is no rule"), "{}", ran.err);
    assert!(ran.err.contains("did you mean `smooth-emitter`?"), "{}", ran.err);
}

#[test]
fn a_rule_that_is_not_asked_leaves_its_suppressions_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let needless = "allow black-surface \"nothing is black\"\nshape a = box(size: 1) with diffuse(0.5)\n";
    project(folder.path(), &[("one", needless)]);
    let lint =
        |args: &[&str]| run(ltsc().current_dir(folder.path()).args(["lint", "--format", "short"]).args(args)).out;
    assert!(lint(&[]).contains("unused-allow"));
    assert_eq!(lint(&["--allow", "black-surface"]), "");
}

#[test]
fn losses_gate_a_build() {
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path(), &[("one", "emitter sky = environment(radiance: 1)\n")]);
    let build = |args: &[&str]| run(ltsc().current_dir(folder.path()).args(["build", "--target", "gltf"]).args(args));
    let denied = build(&["--deny", "loss-dropped"]);
    assert!(denied.code == Some(1) && denied.err.contains("loss-dropped"), "{}", denied.err);
    assert!(!folder.path().join("generated/one").exists());
    assert_eq!(build(&[]).code, Some(0));
    let emit = run(ltsc().current_dir(folder.path()).args([
        "emit",
        "scenes/one.lts",
        "--target",
        "gltf",
        "--deny",
        "loss-dropped",
        "-o",
        "out",
    ]));
    assert!(emit.code == Some(1) && !folder.path().join("out").exists(), "{}", emit.err);
}

#[test]
fn one_bad_file_does_not_hide_another() {
    let folder = tempfile::tempdir().expect("a folder");
    everything(folder.path());
    let args =
        ["lint", "scenes/nowhere.lts", "scenes/foreign.scn", "scenes/twice.lts", "broken.ply", "scenes/a b é/lamp.lts"];
    let ran = run(ltsc().current_dir(folder.path()).args(args).args(["scenes", "--format", "short"]));
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    for words in
        ["nowhere.lts cannot be read", "foreign.scn: error[foreign-file]", "twice.lts", "smooth-emitter", "broken.lts"]
    {
        assert!(ran.out.contains(words), "{words} is missing in\n{}", ran.out);
    }
    assert_eq!(ran.out.matches("duplicate-name").count(), 1, "a file that is named twice is checked once\n{}", ran.out);
    assert!(ran.out.contains("a mesh") && ran.out.contains("a scene of LuxCore"), "{}", ran.out);
    // The order is that of the paths, whatever thread was first.
    let order: Vec<usize> = ["foreign.scn", "twice.lts", "broken.ply", "a b é/lamp.lts", "bad_mesh.lts"]
        .iter()
        .map(|name| ran.out.find(name).unwrap_or_else(|| panic!("{name}\n{}", ran.out)))
        .collect();
    assert!(order.is_sorted(), "{}", ran.out);
}
