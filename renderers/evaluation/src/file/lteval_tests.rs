//! Configurations of the shapes that the thesis's tool has, and what becomes of them.

use ltsc_core::diag::{Severity, Sources};
use proptest::prelude::*;

use super::{Unknown, load, lteval, print};

/// The file that a configuration becomes, and what was found: place and message.
fn converted(text: &str) -> (String, Vec<(String, Severity, String)>) {
    let file = Sources::default().add("cfg.py", text);
    let (written, findings) = lteval::read(file, text);
    let told = findings.into_iter().map(|finding| {
        let span = finding.origin.span().expect("a place");
        (text[span.start as usize..span.end as usize].to_owned(), finding.severity, finding.message)
    });
    (print(&written), told.collect())
}

/// What is wrong with the file that a configuration became.
fn wrong(toml: &str) -> Vec<String> {
    let (evaluation, findings) = load(Sources::default().add("cfg.toml", toml), toml, "cfg", &Unknown);
    let errors: Vec<String> = findings.iter().map(|finding| finding.message.clone()).collect();
    assert!(evaluation.is_some() == findings.iter().all(|finding| finding.severity < Severity::Error), "{toml}");
    errors
}

const MINIMAL: &str = r#"# As little as possible.
configuration = {"webpage_generate": True}
scenes = ["ring"]
renderers = {
    "m": {"type": "mitsuba_0_5", "path": "/opt/mitsuba"},
}
test_cases = [
    {"name": "plain", "renderer": "m"},
]
"#;

#[test]
fn the_least_configuration() {
    let (toml, found) = converted(MINIMAL);
    assert!(found.is_empty(), "{found:?}");
    let expected = r#"output = { page = true }
scenes = ["ring"]

[renderers.m]
target = "mitsuba-0.5"
path = "/opt/mitsuba"

[[case]]
name = "plain"
renderer = "m"
"#;
    assert_eq!(toml, expected);
    assert!(wrong(&toml).is_empty());
}

const WHOLE: &str = r#""""Everything.

Over several lines."""
configuration = {
    "name": "the " "name",  # joined
    'description': """two
lines""",
    "output_dir": r"out\put",
    "output_dir_date": False,
    "webpage_generate": True, "webpage_display": False,
}

all_scenes = ["ring", 'pool_simple']
scenes = all_scenes + ("veach_mis",)

renderers = {
    "m": {"type": "mitsuba_0_5", "path": "m.exe", "options": "-p 4 '-a b'"},
    "p": {"type": "pbrt_3", "path": "p.exe", "options": None},
}

depth = 10
sampler = [["type", "", "independent"], ["sampleCount", "integer", 2]]
parameter_sets = {
    "low": {"integrator": [["type", "", "bdpt"], ["maxDepth", "integer", depth], ["twoStage", "boolean", "true"]], "sampler": sampler},
    "high": {"base": ["low"], "sampler": [["sampleCount", "integer", 0x100]]},
    "pbrt": {
        "Integrator": [["type", "", "bdpt"], ["pixelbounds", "integer", [128, 384, 128, 384]], ["x", "float", -1.5e-3]],
        "Film": [["", "", [1, 2]], ["y", "float", 1], ["y", "integer", 1]],
    },
}
test_cases = [
    {"name": "a", "description": "d", "renderer": "m", "params": {"base": ["high"]}},
    {"name": "b", "renderer": "p", "params": {"base": ["pbrt"], "Integrator": [["maxdepth", "integer", 4]]}},
]
"#;

#[test]
fn a_configuration_with_everything() {
    let (toml, found) = converted(WHOLE);
    let expected = r#"name = "the name"
description = "two\nlines"
output = { folder = "out\\put", dated = false, page = true, display = false }
scenes = ["ring", "pool_simple", "veach_mis"]

[renderers.m]
target = "mitsuba-0.5"
path = "m.exe"
options = ["-p", "4", "-a b"]

[renderers.p]
target = "pbrt-v3"
path = "p.exe"

[parameters.low]
integrator = [["type", "", "bdpt"], { maxDepth = 10 }, ["twoStage", "boolean", "true"]]
sampler = { type = "independent", sampleCount = 2 }

[parameters.high]
base = ["low"]
sampler = { sampleCount = 256 }

[parameters.pbrt]
Integrator = [["type", "", "bdpt"], ["pixelbounds", "integer", [128, 384, 128, 384]], { x = -0.0015 }]
Film = [["", "", [1, 2]], ["y", "float", 1], ["y", "integer", 1]]

[[case]]
name = "a"
description = "d"
renderer = "m"
parameters = "high"

[[case]]
name = "b"
renderer = "p"

[case.parameters]
base = ["pbrt"]
Integrator = { maxdepth = 4 }
"#;
    assert_eq!(toml, expected);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == "r\"out\\put\"" && found[0].2.contains("relative paths"), "{found:?}");
    assert!(wrong(&toml).is_empty(), "{:?}", wrong(&toml));
}

#[test]
fn code_is_listed_and_not_run() {
    let text = format!(
        "import os\n{MINIMAL}\ntest_cases_ = [\n    {{'name': 'other'}}\n]\n\ndef more():\n    return [1]\n\nnames = [x for x in scenes]\n\
         others = more()\nos.name = 'x'\nlabel = f'{{names}}'\nlast = scenes[0]\nif True:\n    sceens = 3\n"
    );
    let (toml, found) = converted(&text);
    assert_eq!(toml, converted(MINIMAL).0);
    let told: Vec<(&str, &str)> = found.iter().map(|(place, _, message)| (place.as_str(), message.as_str())).collect();
    let unread = |why: &str| format!("this could not be read: {why}");
    let expected = [
        ("import", unread("nothing is imported")),
        ("def", unread("a block of code is not run")),
        ("x", unread("`x` is not known")),
        ("more", unread("`more` is not known")),
        ("os", unread("it is no assignment of a value to a name")),
        ("f'{names}'", unread("a formatted string is not evaluated")),
        ("scenes[", unread("elements are not looked up")),
        ("if", unread("a block of code is not run")),
    ];
    let told: Vec<(&str, String)> = told.into_iter().map(|(place, message)| (place, message.to_owned())).collect();
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for (told, expected) in told.iter().zip(&expected) {
        assert_eq!(told.1, expected.1);
        assert!(told.0.starts_with(expected.0) || expected.0.starts_with(told.0), "{told:?} {expected:?}");
    }
}

#[test]
fn what_code_may_have_changed_is_not_known() {
    for code in [
        "test_cases = make()",
        "for s in scenes:\n    test_cases.append(s)",
        "test_cases += [f(1)]",
        "test_cases.append(3)",
    ] {
        let (_, found) = converted(&format!("{MINIMAL}{code}\n"));
        let lost = found
            .iter()
            .any(|(_, severity, message)| *severity == Severity::Error && message.contains("no `test_cases`"));
        assert!(lost, "{code}: {found:?}");
    }
    let (toml, found) = converted(&format!("{MINIMAL}scenes += ['pool']\n"));
    assert!(found.is_empty() && toml.contains("[\"ring\", \"pool\"]"), "{found:?}");
}

#[test]
fn what_is_wrong_is_found_at_its_place() {
    let rows = [
        (
            "\"plain\", \"renderer\"",
            "\"plain\", \"params\": {\"film\": [[\"type\", \"x\"]]}, \"renderer\"",
            "[\"type\", \"x\"]",
            "2 of three",
        ),
        (
            "\"plain\", \"renderer\"",
            "\"plain\", \"params\": {\"film\": [\"type\", \"\", \"x\"]}, \"renderer\"",
            "\"type\"",
            "is a list, not a string",
        ),
        ("\"name\": \"plain\", ", "", "{\"renderer\": \"m\"}", "no `name`"),
        ("\"plain\"", "3", "3", "`name` takes a string, not an integer"),
        ("webpage_generate", "webpage", "\"webpage\"", "no key `webpage`"),
        ("[\"ring\"]", "\"ring\"", "\"ring\"", "`scenes` takes a list, not a string"),
        ("mitsuba_0_5", "mitsuba_7", "\"mitsuba_7\"", "no renderer of the type `mitsuba_7`"),
        ("\"m\": {\"type\": \"mitsuba_0_5\", ", "\"m\": {", "\"m\"", "the renderer `m` has no `type`"),
        ("scenes =", "scenen =", "", "no `scenes` that could be read"),
        ("[\"ring\"]", "[\"ring\"", "", "no `scenes` that could be read"),
    ];
    for (from, to, place, message) in rows {
        let (_, found) = converted(&MINIMAL.replacen(from, to, 1));
        assert!(found.iter().any(|(at, _, text)| at == place && text.contains(message)), "{to}: {found:?}");
    }
}

#[test]
fn no_text_is_too_strange() {
    let words = prop::sample::select(vec![
        "configuration",
        "scenes",
        "renderers",
        "test_cases",
        "parameter_sets",
        "=",
        "+=",
        "+",
        "-",
        "[",
        "]",
        "{",
        "}",
        "(",
        ")",
        ",",
        ":",
        ";",
        ".",
        "\n",
        "\r\n",
        "    ",
        "\t",
        "\\\n",
        "\\",
        "'",
        "\"",
        "\"\"\"",
        "'''",
        "#",
        "r'",
        "f'",
        "b\"",
        "0x",
        "1e",
        "1.5e-3",
        "10_000",
        "__",
        "9999999999999999999",
        "True",
        "None",
        "def f():",
        "é",
        "\u{feff}",
        "\u{1F600}",
        "\"\\x4\"",
        "\"\\u00e9\"",
        "\"\\U00110000\"",
        "'a'",
        "\"base\"",
        "\"type\"",
        "\u{0}",
    ]);
    let texts = prop_oneof![prop::collection::vec(words, 0..80).prop_map(|words| words.concat()), any::<String>()];
    let config = ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() };
    proptest::test_runner::TestRunner::new(config)
        .run(&texts, |text| {
            let (toml, _) = converted(&text);
            // What comes out is always TOML.
            let (_, findings) = load(Sources::default().add("a.toml", toml.as_str()), &toml, "a", &Unknown);
            prop_assert!(findings.iter().all(|finding| finding.id != "evaluation-syntax"), "{toml}");
            Ok(())
        })
        .expect("no text panics");
}

#[test]
fn values_do_not_multiply_without_end() {
    let mut text = "a0 = [1, 2]\n".to_owned();
    for at in 0..64 {
        text += &format!("a{} = a{at} + a{at}\n", at + 1);
    }
    text += "b = [a9, a9, a9]\n";
    let (_, found) = converted(&text);
    assert!(found.iter().any(|(_, _, message)| message.contains("more than a million values")), "{found:?}");
    let (_, found) = converted(&format!("a = {}1{}\n", "[".repeat(200), "]".repeat(200)));
    assert!(found.iter().any(|(_, _, message)| message.contains("nested too deeply")), "{found:?}");
}
