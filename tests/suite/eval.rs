//! `ltsc eval` with stand-ins for renderers: what it renders and how often, what it writes, and what becomes of it where it is killed and
//! where renderers fail. The stand-in's images have noise, another one for each seed.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use ltsc_render::image::{Image, Provenance, read, write_exr};
use serde_json::Value;

use super::cli::MINIMAL;
use super::{Ran, files_below, ltsc, run};

/// Seeds for which the stand-in has images.
const SEEDS: u32 = 24;

pub struct Stage {
    folder: tempfile::TempDir,
}

/// An image with noise of its own for each seed, `bright` times as bright.
fn image(seed: u32, bright: f32) -> Image {
    let mut state = u64::from(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut pixel = || [0.5, 0.25, 1.0].map(|value: f32| bright * value * (0.9 + 0.2 * random()));
    Image { width: 16, height: 8, pixels: (0..128).map(|_| pixel()).collect() }
}

impl Stage {
    pub fn new() -> Self {
        let stage = Self { folder: tempfile::tempdir().expect("a folder") };
        fs::create_dir_all(stage.path("scenes/eval")).expect("folders");
        fs::write(stage.path("ltsc.toml"), "scenes = \"scenes\"\n").expect("a project");
        let parameters = "param bright: number = 10 in 1..100\nparam depth: number = 3 in 1..10\ncamera = ";
        let scene = MINIMAL.replace("NAME", "one").replacen("camera = ", parameters, 1);
        let scene = scene.replace("radiance(10)", "radiance(bright)").replace("max_depth: 3", "max_depth: depth");
        fs::write(stage.path("scenes/one.lts"), scene).expect("a scene");
        for (name, bright) in [("even", 1.0), ("bright", 1.3)] {
            fs::create_dir(stage.path(name)).expect("a folder");
            for seed in 0..SEEDS {
                let file = stage.path(&format!("{name}/{seed}.exr"));
                write_exr(&file, &image(seed, bright), &Provenance::default()).expect("an image");
            }
            stage.renderer(name, &format!("cp $here/{name}/$seed.exr \"$out\""));
        }
        stage
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A renderer beside the evaluation that does `what`, knowing `$seed`, `$out`, `$here`.
    fn renderer(&self, name: &str, what: &str) {
        let here = self.folder.path().display();
        let body = format!(
            "#!/bin/sh\necho pbrt-r4 4.5.2\nif [ \"$1\" = --version ]; then exit 0; fi\nhere={here}\n\
             for main; do :; done\nwhile [ \"$1\" != --outfile ]; do shift; done\nout=$2\n\
             seed=$(cat $(dirname $main)/*.pbrt | sed -n 's/.*\"integer seed\" \\[\\([0-9]*\\)\\].*/\\1/p' | head -1)\n\
             seed=${{seed:-0}}\necho {name} $seed >> $here/calls\nsleep 0.03\n{what}\n"
        );
        let path = self.path(&format!("scenes/eval/{name}"));
        fs::write(&path, body).expect("a program");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("rights");
    }

    /// An evaluation file of the scene with these renderers beside it, and more.
    pub fn evaluation(&self, renderers: &[&str], more: &str) {
        let mut text = "scenes = [\"one\"]\noutput = { dated = false }\nsettings = { samples = 16 }\n".to_owned();
        text.push_str(&format!("{more}\n"));
        for name in renderers {
            text.push_str(&format!("[renderers.{name}]\ntarget = \"pbrt-r4\"\npath = \"{name}\"\n"));
        }
        if !more.contains("[[case]]") {
            for name in renderers {
                text.push_str(&format!("[[case]]\nname = \"{name}\"\nrenderer = \"{name}\"\n"));
            }
        }
        fs::write(self.path("scenes/eval/a.toml"), text).expect("an evaluation");
    }

    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = ltsc();
        command.current_dir(self.folder.path()).env("LTSC_CACHE", self.path("cache"));
        command.env("LTSC_TRUST", self.folder.path()).args(words);
        command
    }

    fn eval(&self, words: &[&str]) -> Ran {
        run(self.command(&["eval", "scenes/eval/a.toml"]).args(words))
    }

    /// The evaluation in `undisturbed`, with chunks of its own.
    fn undisturbed(&self) {
        let mut command = self.command(&["eval", "scenes/eval/a.toml", "-o", "undisturbed"]);
        let ran = run(command.env("LTSC_CACHE", self.path("another cache")));
        assert_eq!((ran.code, self.calls()), (Some(1), 16), "{}", ran.err);
    }

    fn calls(&self) -> usize {
        let calls = fs::read_to_string(self.path("calls")).unwrap_or_default();
        // One that is to be ended in no time may not come so far.
        calls.lines().filter(|line| !line.starts_with("hangs")).count()
    }

    fn results(&self) -> Value {
        json(&self.path("scenes/eval/results/a/results.json"))
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("a file")).expect("JSON")
}

#[test]
fn cases_are_rendered_compared_and_written() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "description = \"two | renderers\"\nname = \"a\"");
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(1), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("even and bright: differ"), "{}", ran.out);
    assert!(ran.err.contains("1 comparison: 0 agree, 1 differ, 0 undecided"), "{}", ran.err);
    assert_eq!(stage.calls(), 16, "eight chunks each");
    let folder = stage.path("scenes/eval/results/a");
    let wanted = [
        "comparisons.csv",
        "evaluation.toml",
        "images.csv",
        "manifest.json",
        "results.json",
        "scenes/one/bright.exr",
        "scenes/one/bright.log",
        "scenes/one/even.exr",
        "scenes/one/even.log",
        "scenes/one/seen 16 x 8.png",
        "summary.md",
        "timing.json",
    ];
    assert_eq!(files_below(&folder), wanted);
    let results = stage.results();
    let pair = &results["conditions"][0]["pairs"][0];
    assert_eq!((pair["a"].as_str(), pair["b"].as_str()), (Some("even"), Some("bright")));
    let ratio = pair["verdict"]["channels"][1]["ratio"].as_f64().expect("a ratio");
    assert!((ratio - 1.3).abs() < 0.02, "{ratio}");
    // The image is the mean of the chunks, with the variance of that mean.
    let (found, _) = read(&folder.join("scenes/one/even.exr")).expect("an image");
    let mean: f32 = (0..8).map(|seed| image(seed, 1.0).pixels[5][2]).sum::<f32>() / 8.0;
    assert!((found.pixels[5][2] - mean).abs() < 1e-6);
    let noise = results["conditions"][0]["runs"][0]["noise"].as_f64().expect("noise");
    // Uniform noise of 20 % over eight images, weighted by the squares of the channels.
    let channels = [0.5_f64, 0.25, 1.0];
    let squares = channels.iter().map(|value| value * value).sum::<f64>() / 3.0;
    let wanted = (squares / 12.0 / 8.0).sqrt() * 0.2 / (1.75 / 3.0);
    assert!((noise / wanted - 1.0).abs() < 0.15, "{noise}, not {wanted}");
    let summary = fs::read_to_string(folder.join("summary.md")).expect("a summary");
    assert!(summary.contains("| even | bright | **differ** |") && summary.contains("two | renderers"), "{summary}");
    let csv = fs::read_to_string(folder.join("comparisons.csv")).expect("a table");
    assert!(csv.lines().nth(1).is_some_and(|line| line.starts_with("one,one,even,bright,differ,")), "{csv}");
    let timing = json(&folder.join("timing.json"));
    let steps = timing["runs"][1]["steps"].as_array().expect("steps");
    let chunks: Vec<u64> = steps.iter().map(|step| step["chunks"].as_u64().expect("a number")).collect();
    assert_eq!(chunks, [1, 2, 4, 8]);
    // The same again renders nothing.
    assert_eq!(stage.eval(&[]).code, Some(1));
    assert_eq!(stage.calls(), 16);
}

#[test]
fn equal_renderers_agree_and_more_samples_need_only_the_rest() {
    let stage = Stage::new();
    stage.evaluation(&["even"], "name = \"a\"\n[compare]\nagainst = \"first\"\ntiles = 2");
    let other = stage.path("scenes/eval/even");
    // A second one that is not the same program: its images are those of other seeds.
    stage.renderer("odd", "cp $here/even/$((seed + 8)).exr \"$out\"");
    stage.evaluation(&["even", "odd"], "name = \"a\"\n[compare]\ntiles = 1\ntolerance = 0.05\nmean_tolerance = 0.05");
    let ran = stage.eval(&["--require-agree"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("even and odd: agree: within 5.0 %"), "{}", ran.out);
    let calls = stage.calls();
    // Half as many again, of the same size.
    let text = fs::read_to_string(stage.path("scenes/eval/a.toml")).expect("a file");
    fs::write(stage.path("scenes/eval/a.toml"), text.replace("{ samples = 16 }", "{ samples = 24 }")).expect("written");
    assert_eq!(stage.eval(&[]).code, Some(0));
    assert_eq!(stage.calls(), calls + 8, "chunks of two samples: eight are there, four are new");
    // A program that changes is another renderer, though it says the same version.
    let body = fs::read_to_string(&other).expect("a program");
    fs::write(&other, format!("{body}# changed\n")).expect("written");
    assert_eq!(stage.eval(&[]).code, Some(0));
    assert_eq!(stage.calls(), calls + 8 + 12);
}

#[test]
fn an_evaluation_that_is_killed_goes_on_and_its_results_are_the_same() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "name = \"a\"");
    stage.undisturbed();
    let mut kills = 0;
    for wanted in [3, 9, 14] {
        let mut child = stage
            .command(&["eval", "scenes/eval/a.toml"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("ltsc");
        let start = Instant::now();
        while stage.calls() < 16 + wanted + kills && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        child.kill().expect("killed");
        child.wait().expect("ended");
        kills += 1;
    }
    assert!(!stage.path("scenes/eval/results/a").exists(), "results appear as a whole");
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    assert!(ran.err.contains("are there from before"), "{}", ran.err);
    // Each kill may cost the chunk that was being rendered, and no other.
    assert!(stage.calls() <= 32 + kills, "{} calls", stage.calls());
    let results = stage.path("scenes/eval/results/a");
    assert_eq!(files_below(&results), files_below(&stage.path("undisturbed")));
    assert!(bytes(&results) == bytes(&stage.path("undisturbed")), "results depend on how they came to be");
    // And anew from what is there.
    fs::remove_dir_all(&results).expect("removed");
    assert_eq!(stage.eval(&[]).code, Some(1));
    assert!(bytes(&results) == bytes(&stage.path("undisturbed")), "results depend on when they were made");
}

/// The results but for times and logs.
fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    let timed = |file: &String| {
        ["timing.json", "summary.md", "images.csv", "manifest.json"].contains(&file.as_str()) || file.ends_with(".log")
    };
    files_below(folder)
        .iter()
        .filter(|file| !timed(file))
        .map(|file| fs::read(folder.join(file)).expect("a file"))
        .collect()
}

#[test]
fn renderers_that_fail_are_told_and_the_others_go_on() {
    let stage = Stage::new();
    stage.renderer("crashes", "echo 'there is no light'; exit 3");
    stage.renderer("hangs", "sleep 600");
    stage.renderer("cuts", "head -c 300 $here/even/$seed.exr > \"$out\"");
    stage.renderer("nothing", "true");
    write_exr(&stage.path("large.exr"), &Image::filled(32, 8, [1.0; 3]), &Provenance::default()).expect("an image");
    stage.renderer("large", "cp $here/large.exr \"$out\"");
    let mut bad = image(0, 1.0);
    bad.pixels[3][1] = f32::NAN;
    write_exr(&stage.path("bad.exr"), &bad, &Provenance::default()).expect("an image");
    stage
        .renderer("bad", "if [ $seed = 2 ]; then cp $here/bad.exr \"$out\"; else cp $here/even/$seed.exr \"$out\"; fi");
    let names = ["even", "crashes", "hangs", "cuts", "nothing", "large", "bad"];
    stage.evaluation(&names, "name = \"a\"");
    let text = fs::read_to_string(stage.path("scenes/eval/a.toml")).expect("a file");
    let text = text.replace("path = \"hangs\"\n", "path = \"hangs\"\ntimeout = \"0.3s\"\n");
    let text = text.replace("settings =", "chunks = 4\nsettings =");
    fs::write(stage.path("scenes/eval/a.toml"), text).expect("written");
    let ran = stage.eval(&["--keep-going"]);
    assert_eq!(ran.code, Some(4), "{}{}", ran.out, ran.err);
    let results = stage.results();
    let runs = results["conditions"][0]["runs"].as_array().expect("runs");
    let said = [
        ("even", "done", ""),
        ("crashes", "failed", "there is no light"),
        ("hangs", "failed", "0.3 s"),
        ("cuts", "failed", "image"),
        ("nothing", "failed", "left no image"),
        ("large", "failed", "32x8"),
        ("bad", "done", ""),
    ];
    for ((name, status, why), run) in said.into_iter().zip(runs) {
        assert_eq!((run["label"].as_str(), run["status"].as_str()), (Some(name), Some(status)), "{run}");
        assert!(run["failure"].as_str().unwrap_or_default().contains(why), "{name}: {}", run["failure"]);
        assert_eq!(run["files"].is_string(), status == "failed", "{run}");
    }
    assert_eq!(runs[6]["non_finite"], 1);
    assert!(stage.path("scenes/eval/results/a/files/one/crashes/scene.pbrt").is_file());
    assert!(ran.err.contains("files/one/crashes"), "{}", ran.err);
    // What failed is tried again, each once; the rest is there.
    let calls = stage.calls();
    assert_eq!(stage.eval(&["--keep-going", "--clean", "always"]).code, Some(4));
    assert_eq!(stage.calls(), calls + 4 * 4);
    assert!(!stage.path("scenes/eval/results/a/files").exists());
    // Without going on, what comes after the first failure is left.
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(4));
    assert!(ran.err.contains("images were not rendered; `--keep-going`"), "{}", ran.err);
}

#[test]
fn programs_that_a_file_names_run_only_where_they_are_trusted() {
    let stage = Stage::new();
    stage.evaluation(&["even"], "");
    let untrusted = || {
        let mut command = stage.command(&["eval", "scenes/eval/a.toml"]);
        command.env_remove("LTSC_TRUST");
        command
    };
    let ran = run(&mut untrusted());
    assert_eq!((ran.code, stage.calls()), (Some(4), 0), "{}", ran.err);
    assert!(ran.err.contains("was not run") && ran.err.contains("`--trust`"), "{}", ran.err);
    assert_eq!(run(untrusted().arg("--trust")).code, Some(0));
    assert_eq!((run(&mut untrusted()).code, stage.calls()), (Some(0), 8));
}

#[test]
fn a_dry_run_says_what_would_be_done_and_does_nothing() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "");
    let ran = stage.eval(&["--dry-run"]);
    assert_eq!((ran.code, stage.calls()), (Some(0), 0), "{}", ran.err);
    assert!(
        ran.out.contains("8 chunks of 2 samples") && ran.err.contains("16 of 16 chunks to render"),
        "{}{}",
        ran.out,
        ran.err
    );
    assert!(!stage.path("scenes/eval/results").exists());
    assert_eq!(stage.eval(&[]).code, Some(1));
    let ran = stage.eval(&["--dry-run", "--format", "json"]);
    let document: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!((document["chunks"].as_u64(), document["kept"].as_u64()), (Some(16), Some(16)));
}

#[test]
fn what_cannot_be_rendered_is_said_before_anything_is() {
    let stage = Stage::new();
    stage.evaluation(&["even", "gone"], "");
    let ran = stage.eval(&[]);
    assert_eq!((ran.code, stage.calls()), (Some(4), 0), "{}", ran.err);
    assert!(ran.err.contains("evaluation-renderer") && ran.err.contains("`gone` cannot be used"), "{}", ran.err);
    // A misspelt scene and a missing renderer are told together, and a broken file refused as one.
    fs::write(stage.path("scenes/eval/a.toml"), "scenes = [\"oen\"]\n[[case]]\nname = \"a\"\nrenderer = \"nothing\"\n")
        .expect("written");
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("no scene `oen`") && ran.err.contains("no renderer `nothing`"), "{}", ran.err);
    for (words, wanted) in [
        (vec!["eval", "scenes/one.lts"], "is no evaluation file"),
        (vec!["eval", "nothing.toml"], "nothing.toml"),
        (vec!["eval"], "<FILE.toml>"),
    ] {
        let ran = run(&mut stage.command(&words));
        assert!(
            ran.code.is_some_and(|code| code == 2 || code == 3) && ran.err.contains(wanted),
            "{words:?}: {}",
            ran.err
        );
    }
}

#[test]
fn settings_that_differ_are_said_beside_the_verdict() {
    let stage = Stage::new();
    // Ten of PBRT are eleven segments.
    stage.evaluation(
        &["even"],
        "name = \"a\"\n[[case]]\nname = \"neutral\"\nrenderer = \"even\"\nsettings = { max_depth = 10 }\n[[case]]\nname = \
         \"native\"\nrenderer = \"even\"\nparameters = { Integrator = { type = \"path\", maxdepth = 10 } }\n[[case]]\nname = \
         \"equal\"\nrenderer = \"even\"\nparameters = { Integrator = { type = \"path\", maxdepth = 9 }, Sampler = { type = \
         \"independent\", pixelsamples = 32 } }\n",
    );
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    assert!(ran.err.contains("not-comparable") && ran.err.contains("10 and 11 segments"), "{}", ran.err);
    let results = stage.results();
    let condition = &results["conditions"][0];
    let apart: Vec<usize> = condition["pairs"]
        .as_array()
        .expect("pairs")
        .iter()
        .map(|pair| pair["not_comparable"].as_array().map_or(0, Vec::len))
        .collect();
    assert_eq!(apart, [1, 0]);
    let depth = |at: usize| condition["runs"][at]["settings"]["max_depth"].as_u64();
    assert_eq!([depth(0), depth(1), depth(2)], [Some(10), Some(11), Some(10)]);
    // The statement's samples are those of the whole image.
    assert_eq!(condition["runs"][2]["samples"], 32);
    assert_eq!(condition["runs"][2]["chunks"], 8);
    assert_eq!(condition["runs"][0]["settings"]["convergence"], "unbiased");
}

#[test]
fn sweeps_of_the_file_and_of_the_command_line_are_conditions() {
    let stage = Stage::new();
    stage.evaluation(&["even"], "name = \"a\"\n[[sweep]]\nparameter = \"bright\"\nvalues = [1, 2, 4]");
    assert_eq!(stage.eval(&[]).code, Some(0));
    let names = |results: &Value| -> Vec<String> {
        let all = results["conditions"].as_array().expect("conditions");
        all.iter().map(|one| one["name"].as_str().expect("a name").to_owned()).collect()
    };
    assert_eq!(names(&stage.results()), ["one, bright=1", "one, bright=2", "one, bright=4"]);
    assert_eq!(stage.calls(), 24);
    // The command line takes the place of the file's sweep over the same parameter.
    assert_eq!(stage.eval(&["--set", "bright=2,8", "--set", "depth=3"]).code, Some(0));
    assert_eq!(names(&stage.results()), ["one, bright=2, depth=3", "one, bright=8, depth=3"]);
    assert_eq!(stage.calls(), 32, "bright=2 was there");
    let ran = stage.eval(&["--set", "brigt=2"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("brigt"), "{}", ran.err);
}

#[test]
fn budgets_render_further_chunks() {
    let stage = Stage::new();
    stage.evaluation(&["even"], "name = \"a\"\nbudget = { samples = 40 }");
    assert_eq!(stage.eval(&[]).code, Some(0));
    assert_eq!((stage.calls(), stage.results()["conditions"][0]["runs"][0]["samples"].as_u64()), (20, Some(40)));
    let stage = Stage::new();
    stage.evaluation(&["even"], "name = \"a\"\nbudget = { samples = 40, time = 0.001 }");
    assert_eq!(stage.eval(&[]).code, Some(0));
    assert_eq!(stage.calls(), 8, "the time is used up by what is needed at least");
}

#[test]
fn times_are_taken_alone_where_they_are_to_be_compared() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "name = \"a\"");
    let timing = || json(&stage.path("scenes/eval/results/a/timing.json"))["runs"][0].clone();
    assert_eq!(stage.eval(&["--jobs", "2"]).code, Some(1));
    assert_eq!((stage.calls(), timing()["cost"]["at_once"].as_u64()), (16, Some(2)));
    assert_eq!(
        timing()["cost"]["threads"].as_u64(),
        Some(1.max(std::thread::available_parallelism().map_or(1, usize::from) as u64 / 2))
    );
    // What was rendered beside others is rendered again, once.
    assert_eq!(stage.eval(&["--timing"]).code, Some(1));
    assert_eq!((stage.calls(), timing()["cost"]["at_once"].as_u64()), (32, Some(1)));
    assert_eq!(stage.eval(&["--timing"]).code, Some(1));
    assert_eq!(stage.calls(), 32);
    let group = timing()["group"].as_str().expect("a group").to_owned();
    assert!(group.contains("1 at once") && group.contains("cores"), "{group}");
    assert_eq!(timing()["efficiency"].as_f64().map(|one| one > 0.0), Some(true));
    assert_eq!(stage.eval(&["--timing", "--jobs", "2"]).code, Some(2));
}

#[test]
fn earlier_results_are_cleaned_and_nothing_else() {
    let stage = Stage::new();
    stage.evaluation(&["even"], "name = \"a\"");
    let text =
        fs::read_to_string(stage.path("scenes/eval/a.toml")).expect("a file").replace("dated = false", "dated = true");
    fs::write(stage.path("scenes/eval/a.toml"), text).expect("written");
    let results = stage.path("scenes/eval/results");
    let folders = || {
        let mut all: Vec<PathBuf> =
            fs::read_dir(&results).expect("a folder").map(|entry| entry.expect("one").path()).collect();
        all.sort();
        all
    };
    for _ in 0..3 {
        assert_eq!(stage.eval(&[]).code, Some(0));
        // A second is the least between two dates.
        std::thread::sleep(Duration::from_millis(1100));
    }
    let before = folders();
    assert_eq!((before.len(), stage.calls()), (3, 8), "a date does not render anew");
    fs::write(before[0].join("notes.txt"), "mine").expect("written");
    fs::write(before[1].join("summary.md"), "changed").expect("written");
    let clean = |more: &[&str]| run(stage.command(&["clean", "scenes/eval/results"]).args(more));
    let ran = clean(&["--dry-run"]);
    assert_eq!((ran.code, folders().len()), (Some(0), 3), "{}", ran.err);
    assert_eq!(clean(&[]).code, Some(0));
    let after = folders();
    assert_eq!(after, before, "what is not ours keeps its folder");
    assert_eq!(files_below(&before[0]), ["notes.txt"]);
    assert_eq!(files_below(&before[1]), ["manifest.json", "summary.md"]);
    assert!(files_below(&before[2]).len() > 5);
    assert_eq!(run(&mut stage.command(&["clean", "nowhere"])).code, Some(2));
}

#[test]
fn a_configuration_of_lteval_becomes_an_evaluation_that_loads() {
    let stage = Stage::new();
    let text = "configuration = {'name': 'old'}\nscenes = ['one']\nrenderers = {'m': {'type': 'mitsuba_0_5', 'path': \
                '/opt/mitsuba'}}\ntest_cases = [{'name': 'a', 'renderer': 'm', 'params': {'sampler': [('type', '', \
                'independent'), ('sampleCount', 'integer', 4)]}}]\n";
    fs::write(stage.path("cfg.py"), text).expect("written");
    let ran = run(&mut stage.command(&["eval", "--from-lteval", "cfg.py"]));
    assert!(ran.out.contains("scenes") && ran.out.contains("[renderers."), "{}{}", ran.out, ran.err);
    let ran = run(&mut stage.command(&["eval", "--from-lteval", "nothing.py"]));
    assert_eq!(ran.code, Some(3), "{}", ran.err);
}

#[test]
fn images_made_by_hand_are_awaited_and_taken_when_they_are_there() {
    let stage = Stage::new();
    stage.evaluation(
        &["even"],
        "name = \"a\"\n[renderers.own]\ntarget = \"gltf\"\nmanual = true\n[[case]]\nname = \"even\"\nrenderer = \"even\"\n[[case]]\nname = \
         \"own\"\nrenderer = \"own\"\n[compare]\ntiles = 1\ntolerance = 0.1\nmean_tolerance = 0.1",
    );
    let ran = stage.eval(&[]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    assert!(ran.err.contains("results/manual/a/one/own.exr"), "{}", ran.err);
    let manual = stage.path("scenes/eval/results/manual/a/one");
    assert!(manual.join("own/one.gltf").is_file(), "{:?}", files_below(&manual));
    let status = || stage.results()["conditions"][0]["runs"][1]["status"].clone();
    assert_eq!(status(), "awaited");
    // One image has metrics, several have a verdict.
    fs::copy(stage.path("even/9.exr"), manual.join("own.exr")).expect("copied");
    assert_eq!(stage.eval(&[]).code, Some(0));
    let pair = || stage.results()["conditions"][0]["pairs"][0].clone();
    assert_eq!(status(), "done");
    assert!(pair()["verdict"].is_null() && !pair()["metrics"].as_array().expect("metrics").is_empty());
    for at in 1..5 {
        fs::copy(stage.path(&format!("even/{}.exr", 9 + at)), manual.join(format!("own-{at}.exr"))).expect("copied");
    }
    assert_eq!(stage.eval(&[]).code, Some(0));
    assert_eq!(pair()["verdict"]["outcome"], "agree", "{}", pair());
    assert_eq!(stage.calls(), 8);
}

#[test]
fn a_program_without_a_driver_is_called_by_its_command() {
    let stage = Stage::new();
    let body =
        format!("#!/bin/sh\necho \"$@\" >> {0}/calls\ncp {0}/even/$3.exr \"$1\"\n", stage.folder.path().display());
    fs::write(stage.path("scenes/eval/fork"), body).expect("a program");
    fs::set_permissions(stage.path("scenes/eval/fork"), fs::Permissions::from_mode(0o755)).expect("rights");
    let evaluation = |command: &str, seed: u32| {
        stage.evaluation(
            &[],
            &format!(
                "name = \"a\"\nchunks = 4\n[renderers.fork]\ntarget = \"gltf\"\npath = \"fork\"\noptions = [\"-q\"]\ncommand = \
                 \"{command}\"\n[[case]]\nname = \"x\"\nrenderer = \"fork\"\n[[case]]\nname = \"y\"\nrenderer = \"fork\"\nsettings = {{ seed = {seed} }}"
            ),
        );
        stage.eval(&[])
    };
    let ran = evaluation("{exe} {out} {scene} {seed} {samples} {options}", 8);
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    let calls = fs::read_to_string(stage.path("calls")).expect("calls");
    assert_eq!(calls.lines().count(), 8);
    assert!(calls.lines().all(|line| line.ends_with(" 4 -q") && line.contains("one.gltf")), "{calls}");
    // Seeds end: no image is taken twice.
    let ran = evaluation("{exe} {out} {scene} {seed} {samples} {options}", u32::MAX - 2);
    assert!(ran.code == Some(3) && ran.err.contains("more seeds than there are"), "{:?} {}", ran.code, ran.err);
    // Without a seed there is one image, and no verdict.
    let ran = evaluation("{exe} {out} {scene} 3 {samples} {options}", 0);
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    assert!(ran.err.contains("evaluation-seeds"), "{}", ran.err);
    let pair = &stage.results()["conditions"][0]["pairs"][0];
    assert!(pair["verdict"].is_null() && pair["refused"].as_str().is_some_and(|why| why.contains("noise")), "{pair}");
}

#[test]
fn a_scene_is_reduced_to_what_the_difference_needs() {
    use ltsc_core::ir::Scene;
    use ltsc_evaluation::chunk::Store;
    use ltsc_evaluation::compare::verdict::{Outcome, Tolerance};
    use ltsc_evaluation::job::Runner;
    use ltsc_evaluation::reduce::{Question, write};
    use ltsc_evaluation::watch::Unwatched;

    let stage = Stage::new();
    // It renders what it is given as the other one does, but for one shape.
    stage.renderer("picky", "set=even; if cat $(dirname $main)/*.pbrt | grep -q culprit; then set=bright; fi\ncp $here/$set/$seed.exr \"$out\"");
    let more: String =
        (0..2).map(|at| format!("shape s{at} = box(size: 0.1) |> translate({at}, 0, 0) with diffuse(0.2)\n")).collect();
    let text = fs::read_to_string(stage.path("scenes/one.lts")).expect("a scene");
    let text = format!("{text}{more}shape culprit = box(size: 0.2) |> translate(0, 3, 0) with mirror(0.9)\n");
    fs::write(stage.path("scenes/two.lts"), text.replace("scene one", "scene two")).expect("a scene");
    let scene: Scene = super::prepared(&super::Disk(stage.folder.path().to_path_buf()), "scenes/two.lts").into_inner();
    let driver = ltsc_render::run::driver("pbrt-r4").expect("a driver");
    let find = |name: &str| {
        Runner::find(driver, Some(&stage.path(&format!("scenes/eval/{name}"))), None, None).expect("a program")
    };
    let (even, picky, bright) = (find("even"), find("picky"), find("bright"));
    let store = Store::at(stage.path("cache/chunks"));
    let question = |a, b| Question {
        a,
        b,
        samples: 16,
        tolerance: Tolerance { tiles: 0.05, whole: 0.05 },
        tiles: 1,
        store: &store,
    };
    let reduced = question(&even, &picky).reduce(scene.clone(), &mut Unwatched).expect("a difference");
    let names: Vec<&str> = reduced.shown.scene.shapes.values().map(|shape| shape.name.as_str()).collect();
    assert_eq!((names, reduced.things), (vec!["culprit"], (4, 1)), "{:?}", reduced.steps);
    assert_eq!(reduced.shown.verdict.outcome, Outcome::Differ);
    assert!(reduced.steps.iter().any(|step| step.contains("grey diffuse")), "{:?}", reduced.steps);
    assert_eq!(reduced.shown.scene.integrator.max_depth(), 1);
    let folder = stage.path("report");
    write(&reduced, &folder, false).expect("written");
    let files = files_below(&folder);
    for name in ["report.md", "verdict.json", "difference.png", "pbrt-r4-a.exr", "pbrt-r4-b/scene.pbrt"] {
        assert!(files.iter().any(|file| file == name), "{name}: {files:?}");
    }
    let report = fs::read_to_string(folder.join("report.md")).expect("a report");
    assert!(report.contains("`culprit`: diffuse") && report.contains("**differ**"), "{report}");
    // What differs everywhere needs nothing; what does not differ is refused.
    let all = question(&even, &bright).reduce(scene.clone(), &mut Unwatched).expect("a difference");
    assert_eq!(all.things.1, 1, "{:?}", all.steps);
    let same = question(&even, &even).reduce(scene, &mut Unwatched).err().expect("no difference");
    assert!(same.message.contains("do not differ"), "{}", same.message);
}

#[test]
fn chunks_that_a_disk_has_spoilt_are_rendered_again_or_fail_alone() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "name = \"a\"");
    assert_eq!(stage.eval(&[]).code, Some(1));
    let results = fs::read(stage.path("scenes/eval/results/a/results.json")).expect("results");
    let chunks: Vec<PathBuf> = files_below(&stage.path("cache/chunks"))
        .iter()
        .filter(|name| name.ends_with("-3.exr"))
        .map(|name| stage.path("cache/chunks").join(name))
        .collect();
    assert_eq!(chunks.len(), 2);
    // No chunk, and that of another scene.
    let whole = fs::read(&chunks[0]).expect("a chunk");
    fs::write(&chunks[0], "").expect("written");
    fs::copy(stage.path("even/3.exr"), &chunks[1]).expect("written");
    assert_eq!(stage.eval(&["--force"]).code, Some(1));
    assert_eq!(stage.calls(), 16 + 2);
    assert_eq!(fs::read(stage.path("scenes/eval/results/a/results.json")).expect("results"), results);
    // A header without all of its pixels.
    fs::write(&chunks[0], &whole[..whole.len() - 40]).expect("written");
    let ran = stage.eval(&["--force"]);
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    let runs = stage.results()["conditions"][0]["runs"].clone();
    let of = |at: usize| (runs[at]["status"].as_str(), runs[at]["failure"].as_str().unwrap_or_default().to_owned());
    let (bad, good) = if of(0).0 == Some("failed") { (of(0), of(1)) } else { (of(1), of(0)) };
    assert_eq!((bad.0, good.0), (Some("failed"), Some("done")), "{runs}");
    assert!(bad.1.contains("-3.exr") && bad.1.contains("rendered again"), "{}", bad.1);
}

/// On small file systems in memory, which only root may make.
#[test]
fn a_full_disk_ends_an_evaluation_and_the_next_one_goes_on() {
    let stage = Stage::new();
    stage.evaluation(&["even", "bright"], "name = \"a\"");
    stage.undisturbed();
    let mount = |options: &str, place: &Path| {
        let mut command = Command::new("mount");
        command.args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(place);
        command.stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    let results = stage.path("scenes/eval/results");
    for (place, size) in [(stage.path("cache"), "size=48k"), (results.clone(), "size=24k")] {
        fs::create_dir_all(&place).expect("a folder");
        if !cfg!(target_os = "linux") || !mount(size, &place) {
            return super::skip("full disks", "the right to mount");
        }
        let before = stage.calls();
        let ran = stage.eval(&[]);
        // What is there is whole; more room, and it goes on.
        let whole = !results.join("a").exists() || results.join("a/results.json").exists();
        let grown = mount("remount,size=4m", &place);
        let again = stage.eval(&[]);
        let same = bytes(&results.join("a")) == bytes(&stage.path("undisturbed"));
        let left = files_below(&results);
        fs::remove_dir_all(results.join("a")).expect("removed");
        let unmounted = Command::new("umount").arg(&place).status().is_ok_and(|status| status.success());
        assert!(grown && unmounted);
        assert_eq!(ran.code, Some(4), "{}{}", ran.out, ran.err);
        assert!(ran.err.contains("space"), "{}", ran.err);
        assert!(whole, "half a folder of results");
        assert_eq!(again.code, Some(1), "{}", again.err);
        // Nothing was rendered twice but what did not find room.
        assert!(stage.calls() - before <= 16 + 2, "{} calls", stage.calls() - before);
        assert!(same && left.iter().all(|file| file.starts_with("a/")), "{left:?}");
    }
}

/// Those that take the least time; the others have the same renderers.
#[test]
#[ignore = "long: renders examples with real renderers"]
fn examples_are_carried_out_by_real_renderers() {
    let listed = run(ltsc().args(["renderers", "list", "--format", "json"]));
    let list: Value = serde_json::from_str(&listed.out).expect("JSON");
    for name in ["mitsuba-3", "luxcore", "cycles", "pbrt-r4"] {
        let all = list["renderers"].as_array().expect("a list");
        if !all.iter().any(|one| one["name"] == name && one["status"] == "installed") {
            return super::skip("examples of evaluations", &format!("`ltsc renderers install {name}`"));
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["parameter_types", "together"] {
        let file = super::root().join(format!("scenes-src/eval/{name}.toml"));
        let out = folder.path().join(name);
        let ran = run(ltsc().arg("eval").arg(file).arg("-o").arg(&out).arg("--keep-going"));
        assert!(matches!(ran.code, Some(0 | 1)), "{name}: {}{}", ran.out, ran.err);
        let results = json(&out.join("results.json"));
        let runs = results["conditions"]
            .as_array()
            .expect("conditions")
            .iter()
            .flat_map(|one| one["runs"].as_array().expect("runs"));
        assert!(runs.into_iter().all(|run| run["status"] == "done"), "{name}: {results}");
    }
}
