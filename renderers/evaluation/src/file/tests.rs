//! What a file means, and every finding at its place.

use std::collections::BTreeMap;
use std::time::Duration;

use ltsc_core::diag::{Finding, Severity, Sources};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::formats::Target;
use ltsc_core::ir::Filter;
use ltsc_core::pipeline;

use super::model::{Evaluation, Reference, Run, Side, Source, Statement, Value};
use super::{Surroundings, Unknown, load};

/// A project of two scenes, one of which has no files for PBRT.
struct Project;

impl Surroundings for Project {
    fn scenes(&self) -> Vec<String> {
        ["ring", "pool"].map(str::to_owned).to_vec()
    }

    fn missing(&self, scene: &Source) -> Option<String> {
        let (Source::Name(name) | Source::File(name)) = scene;
        (!["ring", "pool", "a/pool.lts"].contains(&name.as_str())).then(|| format!("there is no scene `{name}`"))
    }

    fn lacks(&self, scene: &Source, target: &'static Target) -> Option<String> {
        let none = *scene == Source::Name("pool".to_owned()) && target.name == "pbrt-v4";
        none.then(|| "it has no files for it".to_owned())
    }

    fn parameters(&self, _scene: &Source) -> Option<Vec<String>> {
        Some(["lamp", "depth"].map(str::to_owned).to_vec())
    }

    fn has_file(&self, path: &str) -> bool {
        path.ends_with(".exr")
    }

    fn reference(&self, scene: &Source, target: &'static Target) -> Option<String> {
        let Source::Name(name) = scene else { return None };
        (target.name == "mitsuba-3").then(|| format!("references/{name}.exr"))
    }
}

/// Reads a text as `stem.toml` in the project; findings come with the text that their place covers.
pub(super) fn told(text: &str) -> (Option<Evaluation>, Vec<(Finding, String)>) {
    let file = Sources::default().add("stem.toml", text);
    let (evaluation, findings) = load(file, text, "stem", &Project);
    let place = |finding: Finding| {
        let span = finding.origin.span().expect("a place");
        let there = text[span.start as usize..span.end as usize].to_owned();
        (finding, there)
    };
    (evaluation, findings.into_iter().map(place).collect())
}

fn good(text: &str) -> Evaluation {
    let (evaluation, findings) = told(text);
    let errors: Vec<_> = findings.iter().filter(|(finding, _)| finding.severity >= Severity::Warn).collect();
    assert!(errors.is_empty(), "{errors:#?}");
    evaluation.expect("an evaluation")
}

/// The only finding of a text: code, place, message and help.
fn only(text: &str) -> (String, String, String, String) {
    let (evaluation, mut findings) = told(text);
    assert_eq!(findings.len(), 1, "{findings:#?}");
    let (finding, place) = findings.remove(0);
    assert_eq!(evaluation.is_some(), finding.severity < Severity::Error);
    (finding.id.to_owned(), place, finding.message, finding.help.unwrap_or_default())
}

const CASE: &str = "[[case]]\nname = \"a\"\nrenderer = \"mitsuba-3\"\n";

/// A file with `scenes` and one case, with other lines before and behind.
pub(super) fn file(before: &str, behind: &str) -> String {
    format!("scenes = [\"ring\"]\n{before}\n{CASE}{behind}\n")
}

fn shown(statements: &[Statement]) -> Vec<String> {
    let value = |value: &Value| match value {
        Value::Bool(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => format!("{value:?}"),
        Value::String(text) => format!("'{text}'"),
        Value::List(values) => format!("{} values", values.len()),
    };
    let one = |statement: &Statement| {
        let own = statement.parameters.iter();
        let own = own.map(|own| format!("{}:{}={}", own.name, own.kind.as_deref().unwrap_or("?"), value(&own.value)));
        format!("{} {}", statement.name.value, own.collect::<Vec<_>>().join(" "))
    };
    statements.iter().map(one).collect()
}

#[test]
fn defaults_are_those_of_the_thesis() {
    let evaluation = good(&file("", ""));
    assert_eq!(evaluation.name, "stem");
    let output = &evaluation.output;
    assert!(output.folder == "results" && output.dated && !output.page && !output.display);
    assert_eq!((evaluation.tolerance.tiles, evaluation.tolerance.whole, evaluation.tiles), (0.05, 0.01, 8));
    assert_eq!(evaluation.runs, [Run { condition: 0, case: 0, variant: 0 }]);
    let variant = evaluation.variant(evaluation.runs[0]);
    assert!(variant.statements.is_empty() && variant.settings.is_empty() && variant.chunks.is_none());
    let renderer = evaluation.renderer(evaluation.runs[0]);
    assert_eq!((renderer.target.name, renderer.driver.map(|driver| driver.name)), ("mitsuba-3", Some("mitsuba-3")));
    assert!(evaluation.pairs.is_empty() && evaluation.label(evaluation.runs[0]) == "a");
}

#[test]
fn bases_are_merged_in_their_order_and_the_last_one_counts() {
    let text = file(
        "",
        r#"parameters = { base = ["high", "boxed"], sampler = { seed = 3 } }
        [parameters.high]
        base = "low"
        sampler = { sample_count = 256 }
        film = [["pixel_format", "string", "rgb"], { banner = false }, ["crop", "float", [0, 1]], ["crop", "integer", [0, 1]]]
        [parameters.low]
        integrator = { type = "path", max_depth = 10, "odd name" = 1.5 }
        sampler = [["type", "", "independent"], ["sample_count", "integer", 16]]
        [parameters.boxed]
        film = { pixel_format = "rgba" }
        integrator = [["max_depth", "int", 5]]"#,
    );
    let evaluation = good(&text);
    assert_eq!(
        shown(&evaluation.variant(evaluation.runs[0]).statements),
        [
            "integrator type:='path' max_depth:int=5 odd name:?=1.5",
            "sampler type:='independent' sample_count:integer=256 seed:?=3",
            "film pixel_format:string='rgba' banner:?=false crop:float=2 values crop:integer=2 values",
        ]
    );
    let low = evaluation.parameters.iter().find(|set| set.name == "low").expect("a set");
    assert_eq!(shown(&low.statements)[0], "integrator type:='path' max_depth:?=10 odd name:?=1.5");
}

#[test]
fn settings_are_those_of_the_renderer_the_case_and_the_file_in_this_order() {
    let evaluation = good(
        r#"scenes = ["ring"]
        settings = { size = 64, samples = 16, filter = "gaussian", seed = 7 }
        budget = { time = "1.5min" }
        [[case]]
        name = "both"
        renderers = ["mitsuba-3", "luxcore"]
        settings = { integrator = "path", max_depth = 4, samples = 32, sampler = "independent" }
        chunks = 4
        for.luxcore = { settings = { samples = 64, filter = { type = "box" }, size = [64, 32] }, budget = { samples = 512 }, chunks = 16, parameters = { film = { a = 1 } } }
        "#,
    );
    let [mitsuba, luxcore] = evaluation.cases[0].variants.as_slice() else { panic!("two variants") };
    let one = &mitsuba.settings;
    assert_eq!(one.integrator.map(|own| own.value), Some("path"));
    assert_eq!(one.sampler.map(|own| own.value), Some("independent"));
    assert_eq!(one.filter.as_ref().map(|own| own.value.clone()), Some(Filter::Gaussian { stddev: 0.5, radius: 2.0 }));
    let numbers =
        |own: &super::model::Settings| [own.max_depth, own.samples, own.seed].map(|own| own.expect("set").value);
    assert_eq!((numbers(one), one.size.map(|own| own.value), mitsuba.chunks), ([4, 32, 7], Some((64, 64)), Some(4)));
    let two = &luxcore.settings;
    assert_eq!((numbers(two), two.size.map(|own| own.value), luxcore.chunks), ([4, 64, 7], Some((64, 32)), Some(16)));
    assert_eq!(two.filter.as_ref().map(|own| own.value.clone()), Some(Filter::Box { radius: 0.5 }));
    let time = |own: &super::model::Budget| own.time.map(|time| time.value);
    assert_eq!((time(&mitsuba.budget), mitsuba.budget.samples), (Some(Duration::from_secs(90)), None));
    assert_eq!(luxcore.budget.samples.map(|own| own.value), Some(512));
    assert!(mitsuba.statements.is_empty());
    assert_eq!(shown(&luxcore.statements), ["film a:?=1"]);
    assert_eq!(
        evaluation.runs.iter().map(|run| evaluation.label(*run)).collect::<Vec<_>>(),
        ["both/mitsuba-3", "both/luxcore"]
    );
    // Against the first image where there is no reference.
    assert_eq!(evaluation.pairs.len(), 1);
    assert!(evaluation.pairs[0].a == Side::Run(0) && evaluation.pairs[0].b == 1);
}

#[test]
fn settings_take_the_place_of_those_of_a_scene() {
    let evaluation = good(&file("settings = { integrator = \"metropolis\", max_depth = 3, samples = 64, sampler = \"sobol\", size = [5, 6], seed = 9 }", "").replace("mitsuba-3", "pbrt-v4"));
    let text = "lts 1\nscene s {}\nfilm = image(8, 8)\nintegrator = path(max_depth: 2)\nsampler = independent(samples: 1)\ncamera = perspective(eye: (0, -5, 0), target: (0, 0, 0), fov_x: 45deg)\nmaterial grey = diffuse(0.5)\n\
                shape ball = box(size: 1) with grey\nemitter lamp = rectangle(x: -1..1, y: -1..1, z: 3, normal: -Z) with radiance(1)\n";
    let mut files = MemoryFiles::default();
    files.insert("s.lts", text);
    let path = VPath::resolve("", "s.lts").expect("a path");
    let checked = pipeline::check(&files, &mut Sources::default(), &path, &pipeline::Options::default());
    let mut scene = checked.scene.unwrap_or_else(|| panic!("{:?}", checked.findings));
    evaluation.cases[0].variants[0].settings.overrides().apply(&mut scene);
    assert_eq!(scene.integrator, ltsc_core::ir::Integrator::Metropolis { max_depth: 3 });
    assert_eq!(scene.sampler, ltsc_core::ir::Sampler::Sobol { samples: 64, seed: 9 });
    assert_eq!((scene.film.width, scene.film.height), (5, 6));
}

#[test]
fn the_matrix_is_multiplied_out_without_what_is_excluded() {
    let evaluation = good(
        r#"scenes = ["ring", { scene = "a/pool.lts", name = "small", set = { lamp = 2, depth = "45deg" }, camera = "side" }]
        [[sweep]]
        parameter = "lamp"
        scenes = ["small"]
        from = 1
        to = 4
        count = 3
        scale = "log"
        [[case]]
        name = "a"
        renderers = ["mitsuba-3", "luxcore"]
        [[case]]
        name = "b"
        renderer = "cycles"
        scenes = ["ring"]
        [[exclude]]
        renderers = ["luxcore"]
        scenes = ["small, lamp=2", "ring"]
        "#,
    );
    let names: Vec<&str> = evaluation.conditions.iter().map(|condition| condition.name.as_str()).collect();
    assert_eq!(names, ["ring", "small, lamp=1", "small, lamp=2", "small, lamp=4"]);
    let set = |at: usize| -> BTreeMap<&str, &str> {
        evaluation.conditions[at].set.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect()
    };
    assert_eq!(set(2), BTreeMap::from([("lamp", "2"), ("depth", "45deg")]));
    assert_eq!(
        (evaluation.scenes[1].camera.as_deref(), &evaluation.scenes[1].source),
        (Some("side"), &Source::File("a/pool.lts".to_owned()))
    );
    let runs: Vec<String> =
        evaluation.runs.iter().map(|run| format!("{} {}", names[run.condition], evaluation.label(*run))).collect();
    assert_eq!(
        runs,
        [
            "ring a/mitsuba-3",
            "ring b",
            "small, lamp=1 a/mitsuba-3",
            "small, lamp=1 a/luxcore",
            "small, lamp=2 a/mitsuba-3",
            "small, lamp=4 a/mitsuba-3",
            "small, lamp=4 a/luxcore"
        ]
    );
}

#[test]
fn ranges_have_steps_and_counts() {
    let values = |range: &str| -> Vec<String> {
        let evaluation = good(&file("", &format!("[[sweep]]\nparameter = \"lamp\"\n{range}")));
        evaluation.conditions.into_iter().map(|condition| condition.swept[0].1.clone()).collect()
    };
    assert_eq!(values("from = 0\nto = 0.3\nstep = 0.1"), ["0", "0.1", "0.2", "0.3"]);
    assert_eq!(values("from = 3\nto = 1\nstep = 1.5"), ["3", "1.5"]);
    assert_eq!(values("from = 0\nto = 1\ncount = 3"), ["0", "0.5", "1"]);
    assert_eq!(values("from = 0.001\nto = 1\ncount = 4\nscale = \"log\""), ["0.001", "0.01", "0.1", "1"]);
    assert_eq!(values("values = [1, 2.5, true, \"45deg\"]"), ["1", "2.5", "true", "45deg"]);
}

#[test]
fn comparisons_are_with_the_reference_the_first_or_all() {
    let base = |reference: &str, compare: &str| {
        good(&format!(
            "scenes = [\"ring\"]\n{reference}\n[[case]]\nname = \"a\"\nrenderers = [\"mitsuba-3\", \"luxcore\"]\n[[case]]\nname = \"b\"\n\
             renderers = [\"mitsuba-3\", \"luxcore\"]\n[compare]\n{compare}\n"
        ))
    };
    let shown = |evaluation: &Evaluation| -> Vec<String> {
        let label = |run: usize| evaluation.label(evaluation.runs[run]);
        let a = |side: &Side| match side {
            Side::Run(run) => label(*run),
            Side::File(file) => file.clone(),
        };
        evaluation.pairs.iter().map(|pair| format!("{} : {}", a(&pair.a), label(pair.b))).collect()
    };
    let first = ["a/mitsuba-3 : a/luxcore", "a/mitsuba-3 : b/mitsuba-3", "a/mitsuba-3 : b/luxcore"];
    assert_eq!(shown(&base("", "")), first);
    assert_eq!(shown(&base("", "against = \"first\"")), first);
    assert_eq!(shown(&base("", "against = \"all\"")).len(), 6);
    assert!(shown(&base("", "against = \"nothing\"")).is_empty());
    // The convention has a reference for Mitsuba alone; the others are held against the first image.
    assert_eq!(
        shown(&base("reference = \"convention\"", "")),
        [
            "references/ring.exr : a/mitsuba-3",
            "a/mitsuba-3 : a/luxcore",
            "references/ring.exr : b/mitsuba-3",
            "a/mitsuba-3 : b/luxcore"
        ]
    );
    assert_eq!(shown(&base("reference = \"convention\"", "against = \"reference\"")).len(), 2);
    assert_eq!(
        shown(&base("reference = \"{scene}-{target}-{case}-{renderer}.exr\"", ""))[1],
        "ring-luxcore-a-luxcore.exr : a/luxcore"
    );
    assert_eq!(
        shown(&base("reference = { case = \"b\" }", "against = \"reference\"")),
        ["b/mitsuba-3 : a/mitsuba-3", "b/luxcore : a/luxcore"]
    );
    assert_eq!(
        shown(&base("reference = { case = \"b\", renderer = \"luxcore\" }", "against = \"reference\"")),
        ["b/luxcore : a/mitsuba-3", "b/luxcore : a/luxcore", "b/luxcore : b/mitsuba-3"]
    );
    assert_eq!(
        shown(&base(
            "reference = \"r.exr\"",
            "pairs = [[\"a\", \"b\"], [\"b/luxcore\", \"a/mitsuba-3\"], [\"reference\", \"b/luxcore\"]]"
        )),
        ["a/mitsuba-3 : b/mitsuba-3", "a/luxcore : b/luxcore", "b/luxcore : a/mitsuba-3", "r.exr : b/luxcore"]
    );
    let own = good(&file("reference = \"r.exr\"", "reference = \"nothing\""));
    assert!(own.pairs.is_empty() && own.cases[0].reference.as_ref().is_some_and(|own| own.value == Reference::Nothing));
}

#[test]
fn a_renderer_has_a_target_or_a_command() {
    let evaluation = good(&file(
        "[renderers.fork]\ntarget = \"mitsuba-0.6\"\npath = \"bin/mitsuba\"\noptions = \"-p 4 -q\"\ncommand = \"{exe} {options} -o {out} {scene}\"\nthreads = 4\ntimeout = 90\n\
         [renderers.web]\ntarget = \"gltf\"\ncommand = [\"viewer\", \"{scene}\", \"{out}\"]",
        "[[case]]\nname = \"b\"\nrenderers = [\"fork\", \"web\", \"pbrt-r4\"]",
    ));
    let [fork, web, r4] = ["fork", "web", "pbrt-r4"]
        .map(|name| evaluation.renderers.iter().find(|renderer| renderer.name == name).expect("a renderer"));
    assert_eq!(
        (fork.target.name, fork.options.len(), fork.threads, fork.timeout),
        ("mitsuba-0.6", 3, Some(4), Some(Duration::from_secs(90)))
    );
    assert!(fork.command.is_some() && web.driver.is_none() && web.command.is_some());
    assert_eq!((r4.target.name, r4.driver.map(|driver| driver.name)), ("pbrt-v4", Some("pbrt-r4")));
    // A target stands for the renderer of its name, not for the first one that reads its files.
    let of_target = good(&file("", "").replace("mitsuba-3", "pbrt-v4"));
    assert_eq!(of_target.renderers[0].driver.map(|driver| driver.name), Some("pbrt-v4"));
}

#[test]
fn scenes_are_there_once_and_for_every_target() {
    let found = only("scenes = [\"ring\", \"ring\"]\n[[case]]\nname = \"a\"\nrenderer = \"luxcore\"");
    assert_eq!((found.0.as_str(), found.1.as_str()), ("evaluation-duplicate", "\"ring\""));
    let found = only(&format!("scenes = [\"ring\", \"rong\"]\n{CASE}"));
    assert_eq!(
        (found.0.as_str(), found.1.as_str(), found.3.as_str()),
        ("evaluation-scene", "\"rong\"", "did you mean `ring`?")
    );
    let text =
        "scenes = [\"ring\", \"pool\"]\n[[case]]\nname = \"a\"\nrenderers = [\"pbrt-v4\", \"pbrt-r4\", \"luxcore\"]\n";
    let found = only(text);
    assert_eq!((found.0.as_str(), found.1.as_str()), ("evaluation-scene", "\"pool\""));
    assert!(found.2.contains("for `pbrt-v4`: it has no files for it"), "{found:?}");
    good(&format!("{text}[[exclude]]\nscenes = [\"pool\"]\nrenderers = [\"pbrt-v4\", \"pbrt-r4\"]"));
    assert_eq!(only(&format!("scenes = []\n{CASE}")).1, "[]");
    assert_eq!(only(&format!("scenes = [{{ name = \"x\" }}]\n{CASE}")).0, "evaluation-missing");
    assert_eq!(only(&format!("scenes = [{{ scene = \"ring\", set = {{ lmap = 1 }} }}]\n{CASE}")).0, "evaluation-name");
    assert!(only(CASE).2.contains("no `scenes`") && only("scenes = [\"ring\"]").2.contains("no `[[case]]`"));
}

#[test]
fn all_findings_come_at_once_in_the_order_of_the_text() {
    let (evaluation, findings) = told(
        "nmae = 1\nscenes = [\"rign\", \"pool\"]\nchunks = 8\nsettings = { samples = 3 }\n[parameters.a]\nbase = [\"b\"]\nfilm = [[1, 2]]\n\
         [[case]]\nname = \"x\"\nrenderers = [\"luxcore\", \"nothing\"]\nparameters = \"c\"\n[[case]]\nname = \"y\"\n",
    );
    assert!(evaluation.is_none());
    let codes: Vec<&str> = findings.iter().map(|(finding, _)| finding.id).collect();
    assert_eq!(
        codes,
        [
            "evaluation-key",
            "evaluation-scene",
            "evaluation-value",
            "evaluation-unused",
            "evaluation-name",
            "evaluation-parameter",
            "evaluation-name",
            "evaluation-name",
            "evaluation-missing"
        ]
    );
    // Errors of the syntax are all told, and alone.
    let (_, findings) = told("scenes = [\"ring\"\nname = = 3\nx = 'a\n");
    assert!(
        findings.len() > 1 && findings.iter().all(|(finding, _)| finding.id == "evaluation-syntax"),
        "{findings:?}"
    );
    let (_, findings) = told("name = \"a\"\nname = \"b\"\n");
    assert_eq!((findings.len(), findings[0].0.id, findings[0].1.as_str()), (1, "evaluation-syntax", "name"));
}

#[test]
fn what_would_be_too_much_is_refused() {
    let sweep = |name: &str| format!("[[sweep]]\nparameter = \"{name}\"\nfrom = 1\nto = 2\ncount = 1000\n");
    let (evaluation, findings) = told(&file("", &(sweep("lamp") + &sweep("depth"))));
    assert!(evaluation.is_none() && findings.iter().any(|(finding, _)| finding.message.contains("conditions")));
    let cases: String = (0..200).map(|at| format!("[[case]]\nname = \"c{at}\"\nrenderer = \"luxcore\"\n")).collect();
    let (evaluation, findings) = told(&file("", &(sweep("lamp") + &cases)));
    assert!(evaluation.is_none() && findings.iter().any(|(finding, _)| finding.message.contains("images")));
    let (evaluation, findings) = told(&file(
        "compare = { against = \"all\" }",
        &cases.replace("renderer = \"luxcore\"", "renderers = [\"luxcore\", \"cycles\", \"mitsuba-3\", \"pbrt-v4\"]"),
    ));
    assert!(
        evaluation.is_none() && findings.iter().any(|(finding, _)| finding.message.contains("comparisons")),
        "{findings:?}"
    );
}

#[test]
fn no_text_is_too_strange() {
    use proptest::prelude::*;
    let words = prop::sample::select(vec![
        "scenes",
        "case",
        "name",
        "renderer",
        "renderers",
        "parameters",
        "settings",
        "base",
        "for",
        "sweep",
        "values",
        "exclude",
        "compare",
        "pairs",
        "reference",
        "[[",
        "]]",
        "[",
        "]",
        "{",
        "}",
        "=",
        ",",
        ".",
        "\"",
        "'",
        "\"\"\"",
        "\n",
        "#",
        "1",
        "-1.5e9",
        "true",
        "nan",
        "inf",
        "2020-01-01",
        "\"ring\"",
        "\"a\"",
        "\"mitsuba-3\"",
        "\"type\"",
        "é",
        "\u{1F600}",
        "\u{0}",
        "\\",
        " ",
    ]);
    let texts = prop::collection::vec(words, 0..60).prop_map(|words| words.concat());
    let lines = prop::collection::vec(
        prop::sample::select(vec![
            "scenes = [\"ring\"]",
            "[[case]]",
            "name = \"a\"",
            "renderer = \"mitsuba-3\"",
            "renderers = [\"x\", \"luxcore\"]",
            "[parameters.x]",
            "base = [\"x\"]",
            "film = [[\"a\", \"\", 1]]",
            "[renderers.x]",
            "target = \"gltf\"",
            "command = \"{out} {scene}\"",
            "[[sweep]]",
            "parameter = \"lamp\"",
            "from = 1e-300",
            "to = 1e300",
            "count = 5",
            "scale = \"log\"",
            "[compare]",
            "pairs = [[\"a\", \"b\"]]",
            "against = \"all\"",
            "[[exclude]]",
            "cases = [\"a\"]",
            "settings = { samples = 1 }",
            "reference = { case = \"a\" }",
            "é = 1",
            "[case.for.x]",
        ]),
        0..30,
    )
    .prop_map(|lines| lines.join("\n"));
    let all = prop_oneof![texts, lines, any::<String>()];
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        cases: 1000,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    runner
        .run(&all, |text| {
            let file = Sources::default().add("a.toml", text.as_str());
            let (evaluation, findings) = load(file, &text, "a", &Unknown);
            for finding in &findings {
                let span = finding.origin.span().expect("a place");
                prop_assert!(text.get(span.start as usize..span.end as usize).is_some(), "{finding:?}");
                prop_assert!(ltsc_core::diag::CODES.iter().any(|code| code.id == finding.id));
            }
            let errors = findings.iter().any(|finding| finding.severity == Severity::Error);
            prop_assert_eq!(evaluation.is_none(), errors);
            Ok(())
        })
        .expect("no text panics");
}
