//! Native statements of test cases: what they make of a target's files, read back, and the thesis's own configurations.
//!
//! A case in `tests/cases/statements` is a scene, a target and statements; beside it stands what the settings then say, a line for each
//! statement, and the effective settings. `thesis` in a case are lines that the thesis's scripts make of the same statements.

use std::collections::BTreeMap;
use std::fs;

use ltsc_core::files::{MemoryFiles, MemorySink};
use ltsc_core::formats::statements::{Parameter, Statement, Statements, Value};
use ltsc_core::formats::{self, Choices, Target};
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;

use super::mitsuba::{Element, parse};
use super::{Disk, bless, files_below, prepared, root};

fn value(value: &toml::Value) -> Value {
    match value {
        toml::Value::Boolean(value) => Value::Bool(*value),
        toml::Value::Integer(value) => Value::Integer(*value),
        toml::Value::Float(value) => Value::Float(*value),
        toml::Value::String(value) => Value::String(value.clone()),
        toml::Value::Array(items) => Value::List(items.iter().map(self::value).collect()),
        other => panic!("{other} is no value"),
    }
}

/// Statements as a table: each a list of triples, or a table of values.
fn statements(table: &toml::Table) -> Statements {
    let one = |(name, body): (&String, &toml::Value)| {
        let parameters = match body {
            toml::Value::Array(triples) => triples
                .iter()
                .map(|triple| {
                    let [name, kind, what] = &triple.as_array().expect("a triple")[..] else { panic!("{triple}") };
                    let text = |value: &toml::Value| value.as_str().expect("a text").to_owned();
                    Parameter::typed(text(name), text(kind), value(what))
                })
                .collect(),
            toml::Value::Table(values) => values.iter().map(|(name, what)| Parameter::new(name, value(what))).collect(),
            other => panic!("{other} is no statement"),
        };
        Statement::new(name, parameters)
    };
    table.iter().map(one).collect()
}

/// A scene with statements in a target's files.
fn written(scene: &Valid, target: &'static Target, given: &Statements) -> BTreeMap<String, Vec<u8>> {
    let camera = pipeline::camera(scene, None).expect("a camera");
    let mut sink = MemorySink::default();
    let ledger = Ledger::of(scene, target, &[]);
    pipeline::emit_given(scene, camera, target, &ledger, &Choices::default(), given, &mut sink)
        .expect("memory takes all");
    sink.files
}

/// The statements of an element and of those in it, a line each: attributes, and parameters by their names.
fn elements(element: &Element, defaults: &BTreeMap<&str, &str>, lines: &mut Vec<String>) {
    for inner in &element.inner {
        let get = |name: &str| inner.get(name).unwrap_or_default();
        if ["default", "include", "transform"].contains(&inner.tag.as_str()) || inner.get("value").is_some() {
            continue;
        }
        let mut parameters: Vec<String> = inner
            .inner
            .iter()
            .filter(|one| one.get("value").is_some())
            .map(|one| {
                let said = one.get("value").unwrap_or_default();
                let said = said.strip_prefix('$').map_or(said, |name| defaults[name]);
                format!("{} {}={said}", one.tag, one.get("name").unwrap_or_default())
            })
            .collect();
        parameters.sort();
        lines.push(format!("{} type={}; {}", inner.tag, get("type"), parameters.join("; ")).trim_end().to_owned());
        elements(inner, defaults, lines);
    }
}

/// The statements of a file of settings, a line each, so that spelling and order do not matter.
fn lines(target: &Target, files: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let text = |name: &str| String::from_utf8(files[name].clone()).expect("text");
    let mut lines = Vec::new();
    if target.name.starts_with("mitsuba") {
        let text = text("settings.xml");
        let root = parse(&text);
        let defaults = root.inner.iter().filter(|one| one.tag == "default");
        let defaults = defaults.map(|one| (one.get("name").unwrap_or_default(), one.get("value").unwrap_or_default()));
        elements(&root, &defaults.collect(), &mut lines);
    } else if target.name.starts_with("pbrt") {
        lines.extend(text("settings.pbrt").lines().filter(|line| !line.starts_with('#')).map(directive));
    } else {
        let file = if target.name == "cycles" { "scene.py" } else { "scene.cfg" };
        let text = text(file);
        let settings = text.lines().take_while(|line| !line.starts_with("camera("));
        lines.extend(settings.filter(|line| line.contains(['=', '('])).map(str::to_owned));
        // What is written for every scene is seen elsewhere.
        lines.retain(|line| !line.starts_with("sys.path") && !line.starts_with('#'));
    }
    lines
}

/// A directive with its parameters by their names, commas and brackets aside.
fn directive(line: &str) -> String {
    let clean: String = line.chars().map(|letter| if "[],".contains(letter) { ' ' } else { letter }).collect();
    let mut parts: Vec<(bool, String)> = Vec::new();
    for (at, piece) in clean.split('"').enumerate() {
        if at % 2 == 1 {
            parts.push((true, piece.to_owned()));
        } else {
            parts.extend(piece.split_whitespace().map(|word| (false, word.to_owned())));
        }
    }
    let mut words = parts.into_iter();
    let mut head = words.next().map(|(_, word)| word).unwrap_or_default();
    let mut parameters: Vec<String> = Vec::new();
    for (quoted, word) in words {
        match parameters.last_mut() {
            _ if quoted && word.contains(' ') => parameters.push(format!("{word}=")),
            Some(last) => {
                let gap = if last.ends_with('=') { "" } else { " " };
                last.push_str(&format!("{gap}{word}"));
            }
            None if quoted => head.push_str(&format!(" type={word};")),
            None => head.push_str(&format!(" {word}")),
        }
    }
    parameters.sort();
    format!("{head} {}", parameters.join("; ")).trim_end().to_owned()
}

/// What a case gives: lines of the settings, and what they mean.
fn outcome(case: &toml::Table) -> (Vec<String>, String) {
    let text = |name: &str| case[name].as_str().expect("a text");
    let target = formats::find(text("target")).expect("a target");
    let given = statements(case.get("statements").and_then(toml::Value::as_table).unwrap_or(&toml::Table::new()));
    let scene = prepared(&Disk(root().to_path_buf()), text("scene"));
    let say =
        |finding: &ltsc_core::diag::Finding| format!("{:?} {}: {}\n", finding.severity, finding.id, finding.message);
    let (scene, found) = match pipeline::take_statements(scene, target, &given) {
        Ok(taken) => taken,
        Err(findings) => return (Vec::new(), findings.iter().map(say).collect()),
    };
    let written = written(&scene, target, &given);
    let lines = lines(target, &written);
    let mut files = MemoryFiles::default();
    written.into_iter().for_each(|(path, bytes)| files.insert(path, bytes));
    let camera = pipeline::camera(&scene, None).expect("a camera");
    let audited = pipeline::audit_given(&scene, camera, &[target], &given, &files, |_| String::new());
    let wrong: Vec<&str> = audited.findings().map(|finding| finding.message.as_str()).collect();
    assert!(wrong.is_empty(), "{wrong:?} in {lines:#?}");
    let effective = &audited.targets[0].effective;
    let mut shown: String = found.iter().map(say).collect();
    shown += &lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let algorithm =
        effective.algorithm.map(|one| format!("{} ({}, {})", one.native, one.family, one.convergence.word()));
    shown += &format!(
        "\nalgorithm {algorithm:?}\nmax_depth {:?}\nfilter {:?}\nsamples {:?}\nsize {:?}\narea {:?}\nimage {:?}\nclamped {:?}\n",
        effective.max_depth,
        effective.filter,
        effective.samples,
        effective.size,
        effective.area,
        effective.image,
        effective.clamped
    );
    shown += &effective.passed.iter().map(|one| format!("passed: {one}\n")).collect::<String>();
    (lines, shown)
}

#[test]
fn statements_replace_those_of_the_target() {
    let folder = root().join("tests/cases/statements");
    let cases: Vec<String> = files_below(&folder).into_iter().filter(|file| file.ends_with(".toml")).collect();
    assert!(cases.len() >= 10, "{cases:?}");
    let mut wrong = Vec::new();
    for file in cases {
        let case: toml::Table = fs::read_to_string(folder.join(&file)).expect("a case").parse().expect("TOML");
        let (lines, shown) = outcome(&case);
        for line in case.get("thesis").and_then(toml::Value::as_array).into_iter().flatten() {
            let line = line.as_str().expect("a line");
            if !lines.iter().any(|known| known == line) {
                wrong.push(format!("{file}: no line `{line}` in {lines:#?}"));
            }
        }
        let expected = folder.join(file.replace(".toml", ".txt"));
        if bless() {
            fs::write(&expected, &shown).expect("a writable expectation");
        } else if fs::read_to_string(&expected).unwrap_or_default() != shown {
            wrong.push(format!("{file} gives:\n{shown}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A scene with statements for a target, as files; the statements are those of a case.
fn of_case(name: &str) -> (Valid, &'static Target, Statements, BTreeMap<String, Vec<u8>>) {
    let text = fs::read_to_string(root().join(format!("tests/cases/statements/{name}.toml"))).expect("a case");
    let case: toml::Table = text.parse().expect("TOML");
    let target = formats::find(case["target"].as_str().expect("a text")).expect("a target");
    let given = statements(case["statements"].as_table().expect("a table"));
    let scene = prepared(&Disk(root().to_path_buf()), case["scene"].as_str().expect("a text"));
    let (scene, _) = pipeline::take_statements(scene, target, &given).unwrap_or_else(|found| panic!("{found:?}"));
    let files = written(&scene, target, &given);
    (scene, target, given, files)
}

/// The elements that an element of this name stands in, outermost first.
fn around(element: &Element, tag: &str, above: &mut Vec<String>) -> bool {
    if element.tag == tag {
        return true;
    }
    above.push(element.tag.clone());
    if element.inner.iter().any(|inner| around(inner, tag, above)) {
        return true;
    }
    above.pop();
    false
}

#[test]
fn statements_stand_where_the_renderer_looks_for_them() {
    let (_, _, _, files) = of_case("mitsuba3_film");
    let settings = parse(std::str::from_utf8(&files["settings.xml"]).expect("text"));
    let places =
        [("integrator", "scene"), ("emitter", "scene"), ("film", "sensor"), ("sampler", "sensor"), ("rfilter", "film")];
    for (tag, parent) in places {
        let mut above = Vec::new();
        assert!(around(&settings, tag, &mut above), "{tag} is not written");
        assert_eq!(above.last().map(String::as_str), Some(parent), "{tag}");
    }
    let (_, _, _, files) = of_case("pbrt4");
    let settings = std::str::from_utf8(&files["settings.pbrt"]).expect("text");
    for line in [
        "LookAt 0 -100 50 0 0 50 0 0 1",
        "\"integer pixelbounds\" [0 32 0 16]",
        "PixelFilter \"gaussian\"",
        "\"bool regularize\" [false]",
    ] {
        assert!(settings.contains(line), "no `{line}` in {settings}");
    }
    assert_eq!(settings.matches("Film").count(), 1, "the scene's own film stays: {settings}");
}

/// What a statement replaces is not compared with the scene; all the rest still is.
#[test]
fn the_audit_sees_edits_beside_statements() {
    let (scene, target, given, files) = of_case("mitsuba3_film");
    let camera = pipeline::camera(&scene, None).expect("a camera");
    let found = |edit: &dyn Fn(&str) -> String| {
        let mut memory = MemoryFiles::default();
        for (path, bytes) in &files {
            let bytes = match std::str::from_utf8(bytes) {
                Ok(text) if path.ends_with(".xml") => edit(text).into_bytes(),
                _ => bytes.clone(),
            };
            memory.insert(path, bytes);
        }
        let audited = pipeline::audit_given(&scene, camera, &[target], &given, &memory, |_| String::new());
        audited.findings().map(|finding| finding.message.clone()).collect::<Vec<_>>()
    };
    assert!(found(&str::to_owned).is_empty());
    let fov = found(&|text| text.replace("value=\"45\"", "value=\"46\""));
    assert!(!fov.is_empty(), "another field of view");
    let light = found(&|text| text.replace("30", "31"));
    assert!(!light.is_empty(), "another radiance");
    // The depth is the statement's.
    let depth = found(&|text| text.replace("name=\"max_depth\" value=\"6\"", "name=\"max_depth\" value=\"7\""));
    assert!(depth.is_empty(), "{depth:?}");
}
