//! `ltsc report` and `ltsc view`: what is in a page, and what becomes of folders that hold strange things.

use std::fs;
use std::path::{Path, PathBuf};

use ltsc_render::image::{Image, Provenance, layered_bytes, write_exr};
use serde_json::Value;

use super::{Ran, files_below, ltsc, root, run};

/// Results with pages, in a folder of their own.
pub struct Stage(tempfile::TempDir);

impl Stage {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A copy of the results that are kept for tests.
    pub fn real() -> Self {
        let stage = Self::new();
        let from = root().join("tests/real");
        for path in files_below(&from) {
            let to = stage.path("real").join(&path);
            fs::create_dir_all(to.parent().expect("a folder")).expect("folders");
            fs::copy(from.join(path), to).expect("a copy");
        }
        stage
    }

    /// Makes the page of a folder, and gives its index.
    pub fn report(&self, folder: &str) -> PathBuf {
        let ran = run(ltsc().arg("report").arg(self.path(folder)));
        assert_eq!(ran.code, Some(0), "{} {}", ran.out, ran.err);
        self.path(folder).join("page/index.html")
    }

    pub fn view(&self, words: &[&str]) -> Ran {
        run(ltsc().current_dir(self.0.path()).arg("view").args(words))
    }

    pub fn image(&self, name: &str, image: &Image) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("folders");
        write_exr(&path, image, &Provenance::default()).expect("an image");
    }
}

/// The data of a page.
pub fn model(index: &Path) -> Value {
    let text = fs::read_to_string(index.with_file_name("data").join("index.js")).expect("the data");
    let json = text.strip_prefix("ltsc.model(").and_then(|rest| rest.strip_suffix(");\n")).expect("a call");
    serde_json::from_str(json).expect("JSON")
}

/// A small image whose pixels all differ.
pub fn ramp(width: usize, height: usize, scale: f32) -> Image {
    let pixel = |at: usize| [scale * (1.0 + at as f32), scale * (2.0 + (at % 7) as f32), scale * 0.5];
    Image { width, height, pixels: (0..width * height).map(pixel).collect() }
}

#[test]
fn the_page_of_results_has_all_that_they_say() {
    let stage = Stage::real();
    fs::remove_file(stage.path("real/scenes/cbox_classic/shallow.exr")).expect("a file");
    stage.image("real/scenes/cbox_classic/by hand.exr", &ramp(48, 36, 0.01));
    let index = stage.report("real");
    let model = model(&index);
    assert_eq!((model["title"].as_str(), model["form"].as_u64()), (Some("two renderers"), Some(1)));
    assert_eq!(model["cases"][1]["description"], "Fewer bounces, which is not the same image.");
    let scenes = model["scenes"].as_array().expect("scenes");
    assert_eq!(scenes.len(), 3);
    assert_eq!(scenes[1]["parameters"][0][1], "20");
    assert!(scenes[0]["documentation"].as_str().is_some_and(|text| text.len() > 20), "{}", scenes[0]);
    let image = |label: &str| {
        let images = model["images"].as_array().expect("images");
        images.iter().find(|one| one["label"] == label).unwrap_or_else(|| panic!("no image {label}")).clone()
    };
    assert_eq!((image("shallow")["status"].as_str(), image("shallow")["data"].is_null()), (Some("missing"), true));
    assert_eq!(image("by hand")["status"], "done");
    let path = image("path/mitsuba-3");
    assert_eq!(path["file"], "../scenes/cbox_classic/path-mitsuba-3.exr");
    assert_eq!(path["log"], "../scenes/cbox_classic/path-mitsuba-3.log");
    assert!(
        path["facts"].as_array().is_some_and(|facts| facts.iter().any(|fact| fact[0] == "hash of scene and settings"))
    );
    let pair = &scenes[0]["pairs"][0];
    assert!(pair["verdict"].is_string() && pair["proof"].is_string() && pair["worst"]["words"].is_string());
    let tiles = &pair["tiles"];
    let list = |name: &str| tiles[name].as_array().expect("a list").clone();
    assert_eq!([list("ratios").len(), list("half").len(), list("words").len()], [64; 3]);
    assert!(list("half").iter().all(Value::is_number), "the variance is known: {tiles}");
    // Plots with the numbers beside them, and one over the swept parameter.
    for plot in scenes[0]["plots"].as_array().expect("plots").iter().chain(model["plots"].as_array().expect("plots")) {
        let file = |name: &str| {
            fs::read_to_string(index.with_file_name(plot[name].as_str().expect("a path"))).expect("a file")
        };
        assert!(file("svg").starts_with("<svg") && file("csv").starts_with("series,"), "{plot}");
    }
    let swept = model["plots"][0]["title"].as_str().expect("a plot over the parameter");
    assert!(swept.contains("lamp_side"), "{swept}");
    // What is there already is written again only where it changes, and the folder is ours as a whole.
    let before = fs::metadata(&index).expect("the page").modified().expect("a time");
    stage.report("real");
    assert_eq!(fs::metadata(&index).expect("the page").modified().expect("a time"), before);
    fs::write(index.with_file_name("mine.txt"), "mine").expect("a file");
    stage.report("real");
    assert!(index.with_file_name("mine.txt").is_file(), "what is not ours stays");
    fs::write(&index, "changed").expect("a file");
    let ran = run(ltsc().arg("report").arg(stage.path("real")));
    assert!(ran.code == Some(4) || ran.code == Some(2), "{:?} {}", ran.code, ran.err);
    assert_eq!(fs::read_to_string(&index).expect("the page"), "changed");
    assert_eq!(run(ltsc().arg("report").arg(stage.path("real")).arg("--force")).code, Some(0));
}

#[test]
fn loose_images_have_a_page_too() {
    let stage = Stage::new();
    stage.image("a.exr", &ramp(9, 5, 1.0));
    stage.image("b.exr", &ramp(9, 5, 1.1));
    stage.image("other/b.exr", &ramp(9, 5, 2.0));
    let ran = stage.view(&["a.exr", "b.exr", "other/b.exr", "-o", "page"]);
    assert_eq!((ran.code, ran.out.as_str()), (Some(0), "page/index.html\n"), "{}", ran.err);
    let model = model(&stage.path("page/index.html"));
    let labels: Vec<&str> =
        model["images"].as_array().expect("images").iter().filter_map(|one| one["label"].as_str()).collect();
    assert_eq!(labels, ["a", "b", "b 2"]);
    let pairs = model["scenes"][0]["pairs"].as_array().expect("pairs");
    let ratio = |at: usize| {
        pairs[at]["metrics"].as_array().expect("metrics").iter().find(|one| one[0] == "ratio").expect("a ratio")[1]
            .clone()
    };
    assert!(
        (ratio(0).as_f64().expect("a number") - 1.1).abs() < 1e-5
            && (ratio(1).as_f64().expect("a number") - 2.0).abs() < 1e-5
    );
    let all = files_below(&stage.path("page"));
    for path in &all {
        let text = String::from_utf8_lossy(&fs::read(stage.path("page").join(path)).expect("a file")).into_owned();
        assert!(!text.contains(stage.0.path().to_str().expect("UTF-8")), "{path} names a folder of this machine");
    }
    let missing = stage.view(&["a.exr", "c.exr"]);
    assert_eq!(missing.code, Some(3), "{}", missing.err);
    assert!(missing.err.contains("c.exr") && !stage.path("view").exists(), "{}", missing.err);
    // A folder of someone else is not written into.
    let refused = stage.view(&["a.exr", "-o", "other"]);
    assert!(refused.code != Some(0) && files_below(&stage.path("other")).len() == 1, "{}", refused.err);
}

/// Names with all that HTML, scripts, addresses and shells care about.
pub const HOSTILE: &str = "\"><img src=x onerror=alert(1)> '&amp; %41 #x ?y ünï ☃ 漢字 \u{202e}";

/// A folder of images with strange names, sizes and numbers.
pub fn strange() -> Stage {
    let stage = Stage::new();
    let long = "long ".repeat(40);
    let mut broken = ramp(16, 12, 1.0);
    broken.pixels[0] = [f32::NAN; 3];
    broken.pixels[1] = [f32::INFINITY, 1.0, 1.0];
    broken.pixels[2] = [1.0, f32::NEG_INFINITY, 1.0];
    broken.pixels[3] = [-1.0, -2.0, -3.0];
    for (name, image) in [
        (HOSTILE, ramp(16, 12, 1.0)),
        (long.trim(), ramp(16, 12, 1.1)),
        ("broken numbers", broken),
        ("other size", ramp(5, 31, 1.0)),
        ("all black", Image::filled(16, 12, [0.0; 3])),
        ("nothing finite", Image::filled(16, 12, [f32::NAN; 3])),
        ("grey", Image::filled(16, 12, [0.25; 3])),
    ] {
        stage.image(
            &format!("all/scenes/{HOSTILE}/{name}.exr")
                .replace("alert(1)> '&amp; %41 #x ?y ünï ☃ 漢字 \u{202e}/", "alert(1)> '&amp;/"),
            &image,
        );
    }
    stage
}

#[test]
fn strange_folders_have_a_page_that_says_what_is_strange() {
    let stage = strange();
    let folder = fs::read_dir(stage.path("all/scenes")).expect("a folder").next().expect("one").expect("one").path();
    fs::write(folder.join("no image.exr"), "no image").expect("a file");
    fs::write(folder.join("empty.exr"), "").expect("a file");
    for name in ["layers", "y_only", "grey", "luminance"] {
        let from = root().join(format!("tests/cases/images/{name}.exr"));
        if from.is_file() {
            fs::copy(&from, folder.join(format!("case {name}.exr"))).expect("a copy");
        }
    }
    let one = Image::filled(16, 12, [0.5; 3]);
    let many: Vec<(String, Image)> = (0..30).map(|at| (format!("layer{at}."), one.clone())).collect();
    let layers: Vec<(&str, &Image)> =
        std::iter::once(("", &one)).chain(many.iter().map(|(name, image)| (name.as_str(), image))).collect();
    let bytes = layered_bytes(Path::new("many"), &layers, &Provenance::default()).expect("bytes");
    fs::write(folder.join("many layers.exr"), bytes).expect("a file");
    // A file of two layers and no picture of its own shows both.
    let two = [("near.", &Image::filled(16, 12, [0.5; 3])), ("far.", &Image::filled(16, 12, [1.0; 3]))];
    let bytes = layered_bytes(Path::new("two"), &two, &Provenance::default()).expect("bytes");
    fs::write(folder.join("two.exr"), bytes).expect("a file");
    let index = stage.report("all");
    let model = model(&index);
    let images = model["images"].as_array().expect("images");
    let find =
        |label: &str| images.iter().find(|one| one["label"] == label).unwrap_or_else(|| panic!("no image {label}"));
    assert!(find(HOSTILE)["data"].is_object() && find("many layers")["data"].is_object());
    let brightness = |label: &str| find(label)["data"]["mean"][0].as_f64();
    assert_eq!([brightness("two: near"), brightness("two: far")], [Some(0.5), Some(1.0)]);
    for (label, word) in [("no image", "neither"), ("empty", "empty")] {
        let why = find(label)["why"].as_str().expect("a reason");
        assert!(
            find(label)["status"] == "unreadable"
                && why.contains(word)
                && !why.contains(stage.path("").to_str().expect("UTF-8")),
            "{why}"
        );
    }
    assert_eq!(find("broken numbers")["data"]["non_finite"], 3);
    assert_eq!(find("grey")["data"]["grey"], true);
    assert!(find("nothing finite")["data"]["mean"][0].is_null());
    let pairs = model["scenes"][0]["pairs"].as_array().expect("pairs");
    let size = pairs
        .iter()
        .find(|pair| pair["b_label"] == "other size")
        .or_else(|| pairs.iter().find(|pair| pair["a_label"] == "other size"));
    assert!(size.expect("a pair")["refused"].as_str().is_some_and(|why| why.contains("differ in size")));
    let script = fs::read_to_string(index.with_file_name("data").join("index.js")).expect("the data");
    assert!(!script.contains('<'), "no text can end a script");
}

#[test]
fn results_of_others_show_nothing_that_lies_elsewhere() {
    let stage = Stage::real();
    stage.image("secret.exr", &ramp(48, 36, 1.0));
    let file = stage.path("real/results.json");
    let text = fs::read_to_string(&file).expect("a file");
    let other = text.replace("scenes/cbox_classic/shallow.exr", "../secret.exr");
    assert_ne!(text, other);
    fs::write(&file, other).expect("written");
    let model = model(&stage.report("real"));
    let images = model["images"].as_array().expect("images");
    let named: Vec<&Value> = images.iter().filter(|one| one["label"] == "shallow").collect();
    assert!(named[0]["data"].is_null() && named[0]["file"].is_null() && named[0]["status"] == "missing", "{named:?}");
    assert!(!model.to_string().contains("secret"));
}

#[test]
fn empty_folders_and_broken_tables_are_told() {
    let stage = Stage::new();
    fs::create_dir(stage.path("empty")).expect("a folder");
    let index = stage.report("empty");
    assert_eq!(model(&index)["scenes"], serde_json::json!([]));
    let ran = run(ltsc().arg("report").arg(stage.path("nowhere")));
    assert!(ran.code == Some(2) && ran.err.contains("no such folder"), "{}", ran.err);
    fs::create_dir(stage.path("broken")).expect("a folder");
    fs::write(stage.path("broken/results.json"), "{\"form\": 1}").expect("a file");
    let ran = run(ltsc().arg("report").arg(stage.path("broken")));
    assert!(
        ran.code == Some(3) && ran.err.contains("results.json") && ran.err.contains("move this file away"),
        "{}",
        ran.err
    );
    assert!(!stage.path("broken/page").exists());
}

#[cfg(unix)]
#[test]
fn evaluations_make_their_page_and_clean_takes_it_away() {
    let stage = super::eval::Stage::new();
    stage.evaluation(&["even", "bright"], "name = \"a\"");
    let eval = |more: &[&str]| run(stage.command(&["eval", "scenes/eval/a.toml"]).args(more));
    let page = stage.path("scenes/eval/results/a/page");
    assert_eq!(eval(&[]).code, Some(1));
    assert!(!page.exists(), "nobody asked for it");
    let ran = eval(&["--page"]);
    assert!(ran.code == Some(1) && ran.err.contains("page/index.html in a browser"), "{}", ran.err);
    let first = model(&page.join("index.html"));
    assert_eq!(first["images"].as_array().expect("images").len(), 2);
    assert_eq!(first["scenes"][0]["pairs"][0]["verdict"], "differ");
    // A page that is there would show what is no longer so: it is made anew.
    let text = fs::read_to_string(stage.path("scenes/eval/a.toml")).expect("a file");
    fs::write(stage.path("scenes/eval/a.toml"), text.replace("{ samples = 16 }", "{ samples = 24 }")).expect("written");
    assert_eq!(eval(&[]).code, Some(1));
    assert_eq!(model(&page.join("index.html"))["images"][0]["samples"], 24);
    // What a person puts into the page's folder stays, and so does the folder.
    let clean = || run(&mut stage.command(&["clean", "scenes/eval/results", "--keep", "0"]));
    fs::write(page.join("mine.txt"), "mine").expect("a file");
    assert_eq!(clean().code, Some(0));
    assert!(page.join("mine.txt").is_file() && !page.join("index.html").exists());
    fs::remove_dir_all(stage.path("scenes/eval/results")).expect("removed");
    assert_eq!(eval(&["--page"]).code, Some(1));
    assert_eq!(clean().code, Some(0));
    assert!(!stage.path("scenes/eval/results/a").exists(), "the page goes with its results");
}
