//! The formatter: expected forms side by side, one form of everything, the same scene before and after.

use std::fs;
use std::io::Write;
use std::process::Stdio;

use ltsc_core::diag::Sources;
use ltsc_core::eval::{Overrides, evaluate};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::format::{FormatError, format};
use ltsc_core::ir::{Group, Scene};

use super::{bless, files_below, ltsc, root, run};

/// The canonical form; none for a text that does not parse.
fn formatted(path: &str, text: &str) -> Option<String> {
    match format(&mut Sources::default(), path, text) {
        Ok(text) => Some(text),
        Err(FormatError::Malformed(_)) => None,
        Err(FormatError::Fault(fault)) => panic!("{path}: {fault}"),
    }
}

#[test]
fn cases_get_the_form_that_is_expected() {
    let folder = root().join("tests/cases/format");
    let mut count = 0;
    for path in files_below(&folder).iter().filter(|path| path.ends_with(".lts")) {
        let text = fs::read_to_string(folder.join(path)).expect("a case");
        let made = formatted(path, &text).unwrap_or_else(|| panic!("{path} does not parse"));
        let expected = folder.join(path.replace(".lts", ".formatted"));
        if bless() {
            fs::write(&expected, &made).expect("a writable folder");
        }
        let wanted = fs::read_to_string(&expected).unwrap_or_default();
        assert!(made == wanted, "{path} is formatted otherwise:\n{made}");
        count += 1;
    }
    assert!(count >= 2, "only {count} cases were found");
}

#[test]
fn everything_has_one_form_and_means_the_same_in_it() {
    let (mut parsed, mut mangled) = (0, 0);
    let mut scenes = 0;
    for folder in [root().join("scenes-src"), root().join("tests/cases")] {
        let all: Vec<String> = files_below(&folder);
        let read = |path: &str| fs::read(folder.join(path)).expect("a file");
        let (mut before, mut after) = (MemoryFiles::default(), MemoryFiles::default());
        // What may mean something else: texts that get another form, and those that use others.
        let (mut texts, mut changed) = (Vec::new(), 0);
        for path in &all {
            let bytes = read(path);
            let text = path.ends_with(".lts").then(|| String::from_utf8(bytes.clone()).expect("text"));
            let made = text.as_ref().and_then(|text| formatted(path, text));
            if let Some(made) = &made {
                parsed += 1;
                if text.as_ref() != Some(made) {
                    changed += 1;
                    assert_eq!(formatted(path, made).as_ref(), Some(made), "{path} has two forms");
                    texts.push(path);
                } else {
                    // Without its indentation it gets the same form, and so means the same.
                    let bare: String = made.lines().map(|line| line.trim_start().to_owned() + "\n").collect();
                    if bare != *made {
                        assert_eq!(formatted(path, &bare).as_ref(), Some(made), "{path} without indentation");
                        mangled += 1;
                    }
                    if made.contains("\nuse ") {
                        texts.push(path);
                    }
                }
            }
            after.insert(path, made.map_or_else(|| bytes.clone(), String::into_bytes));
            before.insert(path, bytes);
        }
        let evaluated = if changed > 0 { texts } else { Vec::new() };
        for path in evaluated {
            let path = VPath::resolve("", path).expect("a path");
            let scene =
                |files: &MemoryFiles| evaluate(files, &mut Sources::default(), &path, &Overrides::default()).scene;
            let (one, other) = (scene(&before), scene(&after));
            scenes += usize::from(one.is_some());
            let same = match (&one, &other) {
                (Some(one), Some(other)) => same(one, other),
                (one, other) => one.is_none() && other.is_none(),
            };
            assert!(same, "{path} is another scene when it is formatted");
        }
    }
    assert!(parsed >= 30 && mangled >= 30 && scenes >= 3, "{parsed} texts, {mangled} mangled, {scenes} scenes");
}

/// Whether two scenes are equal but for the places that their items come from.
fn same(one: &Scene, other: &Scene) -> bool {
    let groups = |scene: &Scene| {
        let of = |group: &Group| {
            let shapes: Vec<_> = group.shapes.values().cloned().collect();
            (group.name.clone(), shapes, group.instances.values().cloned().collect::<Vec<_>>())
        };
        scene.groups.values().map(of).collect::<Vec<_>>()
    };
    one.name == other.name
        && one.documentation == other.documentation
        && one.meshes.values().eq(other.meshes.values())
        && one.materials.values().eq(other.materials.values())
        && one.shapes.values().eq(other.shapes.values())
        && groups(one) == groups(other)
        && one.instances.values().eq(other.instances.values())
        && one.cameras.values().eq(other.cameras.values())
        && (&one.film, &one.integrator, &one.sampler) == (&other.film, &other.integrator, &other.sampler)
}

#[test]
fn scenes_are_formatted() {
    let ran = run(ltsc().args(["fmt", "--check", "scenes-src"]));
    assert_eq!(ran.code, Some(0), "run `ltsc fmt`: {}", ran.err);
}

#[test]
fn files_are_replaced_only_where_they_change() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fs::write(path("good.lts"), "lts 1\n\nlet a = 1\n").expect("write");
    fs::write(path("bad.lts"), "lts 1\nlet a=1 // one\n").expect("write");
    fs::write(path("broken.lts"), "lts 1\nlet a = (\n").expect("write");
    fs::write(path("binary.lts"), [0xff, 0xfe, 0]).expect("write");
    let before = fs::metadata(path("good.lts")).and_then(|meta| meta.modified()).expect("a time");

    let ran = run(ltsc().args(["fmt", "--check"]).args([path("good.lts"), path("bad.lts")]));
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert!(ran.err.contains("bad.lts would be formatted") && !ran.err.contains("good.lts"), "{}", ran.err);
    let ran = run(ltsc().args(["fmt", "--diff"]).arg(path("bad.lts")));
    assert_eq!((ran.code, ran.out.contains("-let a=1 // one\n+let a = 1 // one\n")), (Some(1), true), "{}", ran.out);
    assert_eq!(fs::read_to_string(path("bad.lts")).expect("text"), "lts 1\nlet a=1 // one\n");

    // A broken file does not keep the others from being formatted.
    let ran = run(ltsc().arg("fmt").arg(folder.path()));
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("broken.lts") && ran.err.contains("not a text in UTF-8"), "{}", ran.err);
    assert_eq!(fs::read_to_string(path("bad.lts")).expect("text"), "lts 1\nlet a = 1 // one\n");
    assert_eq!(fs::read_to_string(path("broken.lts")).expect("text"), "lts 1\nlet a = (\n");
    assert_eq!(fs::metadata(path("good.lts")).and_then(|meta| meta.modified()).expect("a time"), before);
    assert_eq!(run(ltsc().arg("fmt").arg(path("missing.lts"))).code, Some(3));
}

#[test]
fn standard_input_becomes_standard_output() {
    let mut child = ltsc()
        .args(["fmt", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    child.stdin.take().expect("a pipe").write_all(b"lts   1\nlet  a=[1,2] // two\n").expect("write");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "lts 1\nlet a = [1, 2] // two\n");
    assert_eq!(run(ltsc().args(["fmt", "-", "a.lts"])).code, Some(2));
}

#[test]
fn programs_are_told_what_has_another_form() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join(".git")).expect("a folder");
    let project = folder.path().join("suite");
    fs::create_dir_all(project.join("scenes-src")).expect("a folder");
    fs::write(project.join("ltsc.toml"), "").expect("a write");
    fs::write(project.join("scenes-src/a.lts"), "lts 1\n\nlet a  =  1\n").expect("a write");
    fs::write(project.join("scenes-src/b.lts"), "lts 1\n\nlet b = (1\n").expect("a write");
    fs::write(project.join("scenes-src/c.lts"), "lts 1\n\nlet c = 1\n").expect("a write");
    let fmt = |args: &[&str]| run(ltsc().current_dir(&project).arg("fmt").args(args));
    let github = fmt(&["--check", "--format", "github"]);
    assert_eq!(github.code, Some(3), "{}", github.err);
    let words = [
        "::error file=suite/scenes-src/a.lts,line=3,endLine=3,col=1,endColumn=12,title=unformatted::",
        "file=suite/scenes-src/b.lts,line=3",
    ];
    assert!(words.iter().all(|word| github.out.contains(word)) && github.out.lines().count() == 2, "{}", github.out);
    let json: serde_json::Value =
        serde_json::from_str(&fmt(&["--check", "--format", "json", "nowhere.lts", "scenes-src"]).out).expect("JSON");
    let ids: Vec<&str> =
        json["findings"].as_array().expect("findings").iter().filter_map(|finding| finding["id"].as_str()).collect();
    assert_eq!(ids, ["unreadable-file", "unformatted", "syntax-error"]);
    let sarif: serde_json::Value = serde_json::from_str(&fmt(&["--format", "sarif"]).out).expect("JSON");
    assert_eq!(sarif["runs"][0]["results"][0]["ruleId"], "syntax-error");
    assert_eq!(fs::read_to_string(project.join("scenes-src/a.lts")).expect("a file"), "lts 1\n\nlet a = 1\n");
}
