//! References: rendered until they are good enough, by runs that are killed or out of time and go on; stale where their scene has changed;
//! taken in from elsewhere. The renderer is a stand-in that counts its calls, and draws other noise at each.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use ltsc_core::formats::Choices;
use ltsc_evaluation::compare::Images;
use ltsc_evaluation::compare::verdict::{Outcome, Rendered, Tolerance, judge_kept};
use ltsc_evaluation::reference::{self, Stale};
use ltsc_render::image::{Image, Provenance, attributes, layered_bytes, write_exr};
use serde_json::Value;

use super::cli::MINIMAL;
use super::{Disk, Ran, ltsc, prepared, run};

/// Images that the stand-in has.
const IMAGES: usize = 60;

/// Pixels of an image.
const SIZE: (usize, usize) = (16, 8);

struct Stage {
    folder: tempfile::TempDir,
}

/// Uniform noise of this width around a level, other at each number.
fn noisy(number: usize, width: f32) -> Image {
    let mut state = (number as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1_u64 << 24) as f32 - 0.5
    };
    let pixel = |grain: f32| [0.5, 0.25, 1.0].map(|level| level * (1.0 + grain));
    let pixels = (0..SIZE.0 * SIZE.1).map(|_| pixel(width * draw())).collect();
    Image { width: SIZE.0, height: SIZE.1, pixels }
}

impl Stage {
    fn new() -> Self {
        let stage = Self { folder: tempfile::tempdir().expect("a folder") };
        fs::write(stage.path("ltsc.toml"), "scenes = \"scenes\"\n").expect("a project");
        fs::create_dir(stage.path("scenes")).expect("a folder");
        stage.scene(&MINIMAL.replace("NAME", "one"));
        stage.images(0.2);
        let here = stage.folder.path().display().to_string();
        fs::write(stage.path("version"), "pbrt-r4 4.5.2\n").expect("a version");
        let body = format!(
            "#!/bin/sh\ncat {here}/version\nif [ \"$1\" = --version ]; then exit 0; fi\n\
             echo call >> {here}/calls\nsleep 0.05\nwhile [ \"$1\" != --outfile ]; do shift; done\n\
             number=$(wc -l < {here}/calls)\n\
             if [ -f {here}/fails ] && [ $number -gt $(cat {here}/fails) ]; then echo 'it fails'; exit 1; fi\n\
             cp {here}/image-$((number)).exr \"$2\"\n"
        );
        fs::write(stage.path("pbrt-r4"), body).expect("a program");
        fs::set_permissions(stage.path("pbrt-r4"), fs::Permissions::from_mode(0o755)).expect("rights");
        stage
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn scene(&self, text: &str) {
        fs::write(self.path("scenes/one.lts"), text).expect("a scene");
    }

    fn images(&self, width: f32) {
        for number in 1..=IMAGES {
            let path = self.path(&format!("image-{number}.exr"));
            write_exr(&path, &noisy(number, width), &Provenance::default()).expect("an image");
        }
    }

    fn ltsc(&self, words: &[&str]) -> Command {
        let mut command = ltsc();
        command.current_dir(self.folder.path()).env("LTSC_CACHE", self.path("cache")).args(words);
        command
    }

    fn render(&self, words: &[&str]) -> Command {
        let mut command = self.ltsc(&["reference", "scenes/one.lts", "--renderer", "pbrt-r4", "--size", "16"]);
        command.args(words).arg("--executable").arg(self.path("pbrt-r4"));
        command
    }

    fn ran(&self, words: &[&str]) -> Ran {
        run(&mut self.ltsc(words))
    }

    /// How often the renderer was called.
    fn calls(&self) -> usize {
        fs::read_to_string(self.path("calls")).unwrap_or_default().lines().count()
    }

    fn file(&self) -> PathBuf {
        self.path("references/one/pbrt-r4.exr")
    }

    /// The only reference of the list.
    fn listed(&self) -> Value {
        let ran = self.ran(&["reference", "list", "--format", "json"]);
        let document: Value = serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}: {}", ran.err));
        document["references"][0].clone()
    }

    fn found(&self) -> reference::Found {
        let scene = prepared(&Disk(self.folder.path().to_path_buf()), "scenes/one.lts");
        let folder = reference::folder(self.folder.path());
        reference::find(&folder, &scene, &Choices::default(), "pbrt-v4").expect("readable").expect("a reference")
    }
}

#[test]
fn one_that_is_killed_goes_on_and_is_as_good_as_asked_for() {
    let stage = Stage::new();
    // A deviation of 0.2 / sqrt(12) in tiles of 2 pixels: 0.5 % takes about 67 images, 1 % about 17.
    let mut child = stage.render(&["--error", "1%"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("ltsc");
    let start = Instant::now();
    while stage.calls() < 4 {
        assert!(start.elapsed() < Duration::from_secs(60), "it does not start");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    let called = stage.calls();
    assert!(!stage.file().exists());
    let ran = run(&mut stage.render(&["--error", "1%"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains("chunks of 256 samples are there from before"), "{}", ran.err);
    let entry = stage.listed();
    let (error, images) = (&entry["about"]["error"], entry["about"]["images"].as_u64().expect("a number"));
    let tiles = error["tiles"].as_f64().expect("a number");
    assert!(tiles > 0.007 && tiles <= 0.01 && (12..24).contains(&images), "{tiles} by {images}");
    // The one that was killed on its way is rendered again.
    assert!(stage.calls() as u64 <= images + 1 && called <= stage.calls(), "{} for {images}", stage.calls());
    assert_eq!((entry["state"].as_str(), &entry["about"]["samples"]), (Some("fresh"), &(images * 256).into()));
    // The same again renders nothing and leaves it as it is; a better one goes on.
    let (calls, before) = (stage.calls(), fs::read(stage.file()).expect("a file"));
    let ran = run(&mut stage.render(&["--error", "1%"]));
    assert!(ran.code == Some(0) && ran.err.contains("stays"), "{}", ran.err);
    assert_eq!((stage.calls(), fs::read(stage.file()).expect("a file")), (calls, before));
    let ran = run(&mut stage.render(&["--error", "0.8%", "--format", "json"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let document: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert!(document["reached"] == true && document["written"] == true && document["left"].is_null(), "{}", ran.out);
    assert!(stage.calls() > calls && stage.calls() < 2 * calls, "{} of {calls}", stage.calls());
}

#[test]
fn a_time_that_is_over_writes_what_there_is_and_says_what_remains() {
    let stage = Stage::new();
    let ran = run(&mut stage.render(&["--budget", "0.001ms"]));
    assert_eq!((ran.code, stage.calls()), (Some(1), 0), "{}", ran.err);
    assert!(ran.err.contains("nothing is written yet") && !stage.path("references").exists(), "{}", ran.err);
    let ran = run(&mut stage.render(&["--budget", "1.5s"]));
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    let calls = stage.calls();
    assert!((4..=30).contains(&calls), "{calls} calls in 1.5 s");
    assert!(ran.err.contains("not yet 0.50 %") && ran.err.contains("samples more, "), "{}", ran.err);
    assert_eq!(stage.listed()["about"]["images"], calls);
    // One that is worse than what is there takes its place only where it has more samples.
    let wrong = run(&mut stage.render(&["--budget", "soon"]));
    assert!(wrong.code == Some(2) && wrong.err.contains("10m"), "{}", wrong.err);
    let ran = run(&mut stage.render(&["--budget", "2m", "--error", "0.02"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
}

#[test]
fn a_renderer_that_fails_on_its_way_leaves_what_was_good() {
    let stage = Stage::new();
    fs::write(stage.path("fails"), "10").expect("written");
    let ran = run(&mut stage.render(&[]));
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    assert!(ran.err.contains("it fails") && ran.err.contains("written"), "{}", ran.err);
    assert_eq!((stage.calls(), stage.listed()["about"]["images"].as_u64()), (11, Some(10)));
    let ran = run(&mut stage.render(&["--format", "json"]));
    let document: Value = serde_json::from_str(&ran.out).expect("one document");
    let message = document["error"]["message"].as_str().expect("a message");
    assert!(ran.code == Some(4) && message.contains("it fails") && document["chunks"] == 10, "{}", ran.out);
}

#[test]
fn a_renderer_without_noise_or_light_gives_no_reference() {
    let stage = Stage::new();
    stage.images(0.0);
    let ran = run(&mut stage.render(&[]));
    assert!(ran.code == Some(4) && ran.err.contains("all the same image"), "{}", ran.err);
    for number in 1..=IMAGES {
        let path = stage.path(&format!("image-{number}.exr"));
        write_exr(&path, &Image::filled(16, 8, [0.0; 3]), &Provenance::default()).expect("an image");
    }
    fs::remove_dir_all(stage.path("cache")).expect("removed");
    fs::remove_file(stage.path("calls")).expect("removed");
    let ran = run(&mut stage.render(&[]));
    assert!(ran.code == Some(4) && ran.err.contains("is black"), "{}", ran.err);
    assert!(!stage.path("references").exists());
}

#[test]
fn one_of_a_scene_that_has_changed_is_stale() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(&["--error", "2%"])).code, Some(0));
    let found = stage.found();
    assert!(found.stale.is_none() && found.variance.is_some(), "{:?}", found.about);
    assert_eq!(stage.ran(&["reference", "list", "--check"]).code, Some(0));
    // What is written for the renderer is the same.
    stage.scene(&format!("// A comment.\n{}", MINIMAL.replace("NAME", "one")).replace("samples: 4", "samples: 8"));
    assert_eq!(stage.ran(&["reference", "list", "--check"]).code, Some(0));
    stage.scene(&MINIMAL.replace("NAME", "one").replace("radiance(10)", "radiance(11)"));
    assert_eq!(stage.found().stale, Some(Stale::Changed));
    let ran = stage.ran(&["reference", "list", "--check"]);
    assert!(ran.code == Some(1) && ran.out.contains("stale") && ran.out.contains("has changed since"), "{}", ran.out);
    // Another depth is another image.
    stage.scene(&MINIMAL.replace("NAME", "one").replace("max_depth: 3", "max_depth: 4"));
    assert_eq!(stage.found().stale, Some(Stale::Depth { kept: 3, scene: 4 }));
    stage.scene(&MINIMAL.replace("NAME", "one").replace("radiance(10)", "radiance(11)"));
    let calls = stage.calls();
    let ran = run(&mut stage.render(&["--error", "2%"]));
    assert!(ran.code == Some(0) && ran.err.contains("takes the place of"), "{}", ran.err);
    assert!(stage.calls() >= calls + 8 && stage.found().stale.is_none());
    // So does one by another version; a scene that is gone leaves an orphan.
    fs::write(stage.path("version"), "pbrt-r4 4.5.3\n").expect("written");
    assert_eq!(run(&mut stage.render(&["--error", "2%"])).code, Some(0));
    assert_eq!(stage.listed()["about"]["origin"]["version"], "4.5.3");
    fs::write(stage.path("scenes/two.lts"), MINIMAL.replace("NAME", "two")).expect("a scene");
    fs::remove_file(stage.path("scenes/one.lts")).expect("removed");
    let ran = stage.ran(&["reference", "list", "--check"]);
    assert!(ran.code == Some(1) && ran.out.contains("orphan") && ran.out.contains("missing"), "{}", ran.out);
}

#[test]
fn another_one_is_not_written_over() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(&["--error", "2%"])).code, Some(0));
    let (calls, before) = (stage.calls(), fs::read(stage.file()).expect("a file"));
    for (words, said) in [
        (&["--size", "32"][..], "16x8"),
        (&["--max-depth", "2"], "3 segments"),
        (&["--integrator", "light_tracing"], "by path"),
    ] {
        let mut command = stage.ltsc(&["reference", "scenes/one.lts", "--renderer", "pbrt-r4", "--error", "2%"]);
        if words[0] != "--size" {
            command.args(["--size", "16"]);
        }
        let ran = run(command.args(words).arg("--executable").arg(stage.path("pbrt-r4")));
        assert!(ran.code == Some(2) && ran.err.contains(said) && ran.err.contains("--force"), "{words:?}: {}", ran.err);
    }
    assert_eq!((stage.calls(), fs::read(stage.file()).expect("a file")), (calls, before));
    let ran = run(&mut stage.render(&["--error", "2%", "--max-depth", "2", "--force"]));
    assert!(ran.code == Some(0) && stage.listed()["about"]["settings"]["max_depth"] == 2, "{}", ran.err);
    // What is none of ours stays, and is told from ours.
    fs::write(stage.file(), "mine \" '").expect("written");
    let ran = run(&mut stage.render(&["--error", "2%"]));
    assert!(ran.code != Some(0) && fs::read(stage.file()).expect("a file") == b"mine \" '", "{}", ran.err);
    assert_eq!(stage.listed()["state"], "damaged");
}

#[test]
fn wrong_renderers_and_algorithms_are_refused_before_anything_is_rendered() {
    let stage = Stage::new();
    for (words, said) in [
        (&["--renderer", "luxcore", "--integrator", "metropolis"][..], "pbrt-r4"),
        (&["--renderer", "pbrt-r3"], "seeds that cost nothing"),
        (&["--renderer", "mitsba-3"], "did you mean `mitsuba-3`"),
        (&["--renderer", "pbrt-r4", "--integrator", "pathh"], "did you mean `path`"),
        (&["--renderer", "pbrt-r4", "--error", "2"], "a share"),
        (&[], "--renderer"),
    ] {
        let ran = run(stage.ltsc(&["reference", "scenes/one.lts"]).args(words));
        assert!(ran.code == Some(2) && ran.err.contains(said), "{words:?}: {}", ran.err);
    }
    // Light tracing sees no mirror.
    stage.scene(
        &(MINIMAL.replace("NAME", "one") + "shape ball = sphere(center: (0, 0, 2)) with dielectric(ior: 1.5)\n"),
    );
    let ran = run(&mut stage.render(&["--integrator", "light_tracing"]));
    assert!(ran.code == Some(2) && ran.err.contains("black there"), "{}", ran.err);
    assert_eq!(stage.calls(), 0);
    let ran = run(&mut stage.render(&["--integrator", "light_tracing", "--error", "2%", "--force"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(stage.ran(&["reference", "list"]).out.contains("black there"));
    let ran = run(&mut stage.render(&["--integrator", "photon_map", "--error", "2%", "--force"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let listed = stage.ran(&["reference", "list"]).out;
    assert!(listed.contains("consistent: off by") && !listed.contains("black there"), "{listed}");
}

#[test]
fn a_declared_one_is_shown_as_declared_and_stays() {
    let stage = Stage::new();
    let (image, path) = (noisy(1, 0.1), stage.path("given.exr"));
    let variance = Image {
        pixels: image.pixels.iter().map(|pixel| pixel.map(|value| value * value * 1e-4)).collect(),
        ..image.clone()
    };
    let as_if = Provenance { renderer: "mitsuba-3".to_owned(), samples: 9, ..Provenance::default() };
    let bytes = layered_bytes(&path, &[("", &image), ("variance.", &variance)], &as_if).expect("bytes");
    fs::write(&path, bytes).expect("written");
    let add = |words: &[&str]| {
        let mut all = vec!["reference", "add", "given.exr", "--scene", "scenes/one.lts", "--renderer", "pbrt-r4"];
        all.extend(words);
        stage.ran(&all)
    };
    assert_eq!(add(&[]).code, Some(2));
    let ran = add(&["--by", " "]);
    assert!(ran.code == Some(2) && ran.err.contains("--by"), "{}", ran.err);
    let ran = add(&["--by", "a thesis \" '", "--algorithm", "bdpt"]);
    assert!(ran.code == Some(0) && ran.err.contains("declared: a thesis \" ', bdpt"), "{}", ran.err);
    let header = attributes(&stage.file()).expect("a header");
    let has = |name: &str| header.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
    assert_eq!((has("ltsc:renderer"), has("ltsc:declared-by")), (None, Some("a thesis \" '")));
    let found = stage.found();
    assert!(!found.about.is_rendered() && found.stale.is_none());
    // One percent in each pixel, two pixels in a tile.
    let error = found.about.error.expect("an error");
    assert!((error.pixels - 0.01).abs() < 1e-3 && (error.tiles - 0.01 / 2_f64.sqrt()).abs() < 1e-3, "{error:?}");
    let ran = stage.ran(&["reference", "list"]);
    assert!(ran.out.contains("declared: a thesis") && ran.out.contains("fresh"), "{}", ran.out);
    // ltsc's own does not take its place, and another one does only by force.
    let ran = run(&mut stage.render(&["--error", "2%"]));
    assert!(ran.code == Some(2) && ran.err.contains("of other origin") && stage.calls() == 0, "{}", ran.err);
    let ran = add(&["--by", "nobody"]);
    assert!(ran.code == Some(2) && ran.err.contains("is there"), "{}", ran.err);
    assert_eq!(add(&["--by", "nobody", "--force"]).code, Some(0));
    stage.scene(&MINIMAL.replace("NAME", "one").replace("radiance(10)", "radiance(11)"));
    assert_eq!(stage.found().stale, Some(Stale::Changed));
}

#[test]
fn what_is_no_image_of_the_scene_is_not_taken_in() {
    let stage = Stage::new();
    write_exr(&stage.path("square.exr"), &Image::filled(8, 8, [1.0; 3]), &Provenance::default()).expect("an image");
    write_exr(&stage.path("nan.exr"), &Image::filled(16, 8, [f32::NAN; 3]), &Provenance::default()).expect("an image");
    write_exr(&stage.path("minus.exr"), &Image::filled(16, 8, [-1.0; 3]), &Provenance::default()).expect("an image");
    write_exr(&stage.path("good.exr"), &noisy(1, 0.1), &Provenance::default()).expect("an image");
    fs::write(stage.path("text.exr"), "no image").expect("written");
    for (file, more, code, said) in [
        ("square.exr", &[][..], 3, "proportions"),
        ("nan.exr", &[], 3, "no finite pixel"),
        ("text.exr", &[], 3, "neither"),
        ("absent.exr", &[], 3, "absent.exr"),
        ("good.exr", &["--variance", "minus.exr"], 3, "negative"),
        ("good.exr", &["--variance", "square.exr"], 3, "another size"),
        ("good.exr", &["--renderer", "../up"], 2, "cannot be the name"),
    ] {
        let mut words = vec!["reference", "add", file, "--scene", "scenes/one.lts", "--by", "nobody"];
        if !more.contains(&"--renderer") {
            words.extend(["--renderer", "thesis"]);
        }
        words.extend(more);
        let ran = stage.ran(&words);
        assert!(ran.code == Some(code) && ran.err.contains(said), "{file}: {:?} {}", ran.code, ran.err);
    }
    assert!(!stage.path("references").exists());
}

/// Those that a checkout has: images of its own scenes, which a change of one makes stale, and no more than fits.
#[test]
fn shipped_ones_are_whole_and_small() {
    let ran = run(ltsc().args(["reference", "list", "--format", "json"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let document: Value = serde_json::from_str(&ran.out).expect("JSON");
    let entries = document["references"].as_array().expect("a list");
    let mut bytes = 0;
    for entry in entries.iter().filter(|entry| entry["state"] != "missing") {
        assert!(entry["state"] == "fresh" || entry["state"] == "stale", "{entry:#}");
        let (stored, error) = (&entry["about"]["stored"], &entry["about"]["error"]["tiles"]);
        let (change, error) = (stored["change"].as_f64().expect("a number"), error.as_f64().expect("a number"));
        assert!(change <= 0.1 * error && error < 0.05, "{entry:#}");
        let file = entry["file"].as_str().expect("a path");
        bytes += fs::metadata(file).expect("a file").len();
    }
    assert!(bytes <= 20_000_000, "{bytes} bytes");
}

#[test]
fn pictures_of_the_catalogue_are_those_of_references() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(&["--error", "1%"])).code, Some(0));
    let calls = stage.calls();
    for (size, factor) in [("16", 1), ("8", 4)] {
        let ran = stage.ran(&["doc", "--render", "--size", size]);
        assert!(ran.code == Some(0) && ran.err.contains("pictures of what is kept"), "{}", ran.err);
        let page = fs::read_to_string(stage.path("docs/scenes/one.md")).expect("a page");
        let samples = stage.found().about.samples.expect("samples") * factor;
        // 0.2 / sqrt(12) at one image, less by the root of how many there are and of the pixels of a block.
        let images = (samples / 256) as f64;
        let noise = format!("median noise of a pixel {:.1} %", 100.0 * 0.2 / 12_f64.sqrt() / images.sqrt());
        for said in
            ["pbrt-r4 4.5.2", &format!("path, {samples} samples per pixel"), &noise, "references of the project"]
        {
            assert!(page.contains(said), "{said}: {page}");
        }
    }
    // One that is too small, or stale, is no picture.
    for scene in [None, Some(MINIMAL.replace("NAME", "one").replace("radiance(10)", "radiance(11)"))] {
        scene.iter().for_each(|text| stage.scene(text));
        let size = if scene.is_some() { "16" } else { "32" };
        let ran = run(stage.ltsc(&["doc", "--render", "--size", size]).env("PATH", "/bin:/usr/bin"));
        assert!(ran.code == Some(0) && !ran.err.contains("pictures of what is kept"), "{}", ran.err);
        assert_eq!(ran.err.contains("is stale and not shown"), scene.is_some(), "{}", ran.err);
    }
    assert_eq!(stage.calls(), calls);
}

#[test]
fn a_reference_is_a_side_of_a_verdict() {
    let stage = Stage::new();
    assert_eq!(run(&mut stage.render(&["--error", "1%"])).code, Some(0));
    let found = stage.found();
    let judged = |level: f32| {
        let image = |at: usize| {
            let image = noisy(100 + at, 0.2);
            Image { pixels: image.pixels.iter().map(|pixel| pixel.map(|value| value * level)).collect(), ..image }
        };
        let images: Vec<Image> = (0..32).map(image).collect();
        let b = Rendered { images: Images::Held(&images), samples: 256.0 };
        judge_kept(found.side(), b, Tolerance { tiles: 0.1, whole: 0.02 }, 8).expect("a verdict").outcome
    };
    assert_eq!((judged(1.0), judged(1.3)), (Outcome::Agree, Outcome::Differ));
}
