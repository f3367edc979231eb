//! Real renderers: two of them must give one image, and the thesis's; lights without a surface must give what the formula says.
//!
//! Bounds: means within 0.5 % in every channel, tiles of an 8 x 8 grid within 2 % over all channels, the best shift (0, 0).
//! A single channel's tile is noisier where that channel is nearly black (red on the green wall): it may differ by the same
//! 2 % of the tile's mean over all channels.

use std::path::{Path, PathBuf};
use std::process::Command;

use ltsc_evaluation::compare::{CompareOptions, Comparison, compare};
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::image::{Image, read, reduce};
use ltsc_render::install::{Status, status};
use ltsc_render::run::driver;

use super::micro::THINGS;
use super::{corpus, ltsc, root, run, skip};

/// Whether a renderer is there without installing it.
fn there(name: &str) -> bool {
    let env = Env::of_process();
    let driver = driver(name).expect("a driver");
    matches!(status(driver, CachePaths::find(&env).as_ref(), &env), Status::Installed { .. } | Status::External { .. })
}

/// Renders a scene of the repository at `side` x `side`.
fn render_at(
    folder: &Path,
    scene: &str,
    renderer: &str,
    side: u32,
    samples: u32,
    seed: u32,
) -> (Image, Vec<(String, String)>) {
    let out: PathBuf = folder.join(format!("{scene}-{renderer}-{seed}.exr"));
    let side = side.to_string();
    let ran = run(ltsc()
        .arg("render")
        .arg(root().join(format!("scenes-src/{scene}.lts")))
        .args(["--renderer", renderer, "--width", &side, "--height", &side, "--timeout", "1200", "--force"])
        .args(["--samples", &samples.to_string(), "--seed", &seed.to_string(), "-o"])
        .arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(!ran.err.contains('\r') && !ran.err.contains('\u{1b}'), "a progress bar outside a terminal: {:?}", ran.err);
    read(&out).expect("an image")
}

fn compared(a: &Image, b: &Image) -> Comparison {
    compare(a, b, &CompareOptions { only: &["ratio"], ..CompareOptions::default() }).expect("comparable images")
}

/// Ratio of means over all channels, B/A.
fn ratio(a: &Image, b: &Image) -> f64 {
    compared(a, b).metric("ratio").and_then(|value| value.overall).expect("a ratio")
}

pub(super) fn judge(what: &str, a: &Image, b: &Image, mean: f64, tile: f64) {
    let comparison = compared(a, b);
    let ratios = comparison.metric("ratio").expect("ratios").channels;
    for ratio in ratios.into_iter().flatten() {
        assert!((ratio - 1.0).abs() <= mean, "{what}: means {ratios:?}");
    }
    for tile_of in comparison.tiles.rows.iter().flatten() {
        let overall = tile_of.overall.expect("no tile is black");
        assert!((overall - 1.0).abs() <= tile, "{what}: a tile differs by {:.4}", overall - 1.0);
    }
    let shift = comparison.shift.expect("a shift");
    assert_eq!((shift.dx, shift.dy), (0, 0), "{what}: the image is shifted");
}

/// A sixteenth of the samples of a tile at 512 in the long run, where the noisiest has a standard deviation of 0.9 %: here it has
/// 3.6 %, and the mean of 64 tiles at most 0.45 %. The bounds are four of them.
#[test]
fn two_renderers_give_one_small_image_of_cbox_classic() {
    if !there("mitsuba-3") || !there("luxcore") {
        return skip("two renderers", "`ltsc renderers install mitsuba-3 luxcore`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (mitsuba, facts) = render_at(folder.path(), "cbox_classic", "mitsuba-3", 64, 128, 0);
    let (luxcore, _) = render_at(folder.path(), "cbox_classic", "luxcore", 64, 128, 0);
    judge("LuxCore against Mitsuba 3", &mitsuba, &luxcore, 0.02, 0.15);

    let fact = |name: &str| facts.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
    assert_eq!(fact("ltsc:scene"), Some("cbox_classic"));
    assert_eq!(fact("ltsc:renderer"), Some("mitsuba-3"));
    assert_eq!((fact("ltsc:samples"), fact("ltsc:seed")), (Some("128"), Some("0")));
    for name in ["ltsc:scene-hash", "ltsc:version", "ltsc:renderer-version", "ltsc:seconds"] {
        assert!(fact(name).is_some_and(|value| !value.is_empty()), "{name} is missing");
    }
}

#[test]
#[ignore = "long: 34 million paths"]
fn two_renderers_give_one_image_of_cbox_classic() {
    if !there("mitsuba-3") || !there("luxcore") {
        return skip("two renderers", "`ltsc renderers install mitsuba-3 luxcore`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    // At 512 samples the noisiest tile's ratio has a standard deviation of 0.9 %: a bound of 2 % would fail one run in
    // twenty by chance alone. At 1024 it is one in some hundred.
    let (mitsuba, _) = render_at(folder.path(), "cbox_classic", "mitsuba-3", 128, 1024, 0);
    let (luxcore, _) = render_at(folder.path(), "cbox_classic", "luxcore", 128, 1024, 0);
    judge("LuxCore against Mitsuba 3", &mitsuba, &luxcore, 0.005, 0.02);

    let Some(corpus) = corpus() else { return skip("the thesis's cbox_classic", "../shared/corpus/lteval") };
    let (reference, _) = read(&corpus.join("cbox_classic/mitsuba_0_5/reference.exr")).expect("the reference");
    let reference = reduce(&reference, 128, 128).expect("a smaller reference");
    judge("Mitsuba 3 against the thesis", &reference, &mitsuba, 0.005, 0.02);
    judge("LuxCore against the thesis", &reference, &luxcore, 0.005, 0.02);
}

/// The standard deviation of the mean of one image of veach_mis, 128 x 128 pixels, of one sample per pixel: 1.9 % at 64
/// samples over 8 seeds (measured with Mitsuba 3.9.1), falling with the root of the samples. Rare bright paths make it up:
/// a few images that all missed them look alike, so that their own scatter tells too little.
const VEACH_NOISE: f64 = 0.019 * 8.0;

/// The mean over seeds of the ratio to the reference, within 1 % or four standard errors of 1.
#[test]
#[ignore = "long: 34 million paths"]
fn veach_mis_has_the_mean_of_the_thesis() {
    if !there("mitsuba-3") || !there("luxcore") {
        return skip("veach_mis", "`ltsc renderers install mitsuba-3 luxcore`");
    }
    let Some(corpus) = corpus() else { return skip("the thesis's veach_mis", "../shared/corpus/lteval") };
    let (reference, _) = read(&corpus.join("veach_mis/mitsuba_0_5/reference.exr")).expect("the reference");
    let reference = reduce(&reference, 128, 128).expect("a smaller reference");
    let folder = tempfile::tempdir().expect("a folder");
    for (renderer, samples) in [("mitsuba-3", 256), ("luxcore", 256)] {
        let seeds = [1, 2, 3, 4];
        let ratios =
            seeds.map(|seed| ratio(&reference, &render_at(folder.path(), "veach_mis", renderer, 128, samples, seed).0));
        let mean = ratios.iter().sum::<f64>() / 4.0;
        let variance = ratios.iter().map(|ratio| (ratio - mean) * (ratio - mean)).sum::<f64>() / 3.0;
        let known = VEACH_NOISE / f64::from(samples).sqrt() / 2.0;
        let error = (variance / 4.0).sqrt().max(known);
        assert!((mean - 1.0).abs() <= f64::max(0.01, 4.0 * error), "{renderer}: {mean:.4} +- {error:.4} {ratios:?}");
        assert!(error < 0.015, "{renderer}: too noisy to tell anything, {ratios:?}");
        assert!(ratios.windows(2).all(|pair| pair[0] != pair[1]), "{renderer}: seeds do nothing, {ratios:?}");
    }
}

#[test]
fn a_renderer_that_fails_shows_the_end_of_its_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let fake = folder.path().join(if cfg!(windows) { "mitsuba.exe" } else { "mitsuba" });
    if cfg!(windows) {
        return skip("a failing renderer", "a system with shell scripts");
    }
    std::fs::write(&fake, "#!/bin/sh\necho loading the scene\necho the kernel is out of coffee >&2\nexit 7\n")
        .expect("a script");
    let made = Command::new("chmod").arg("+x").arg(&fake).status().expect("chmod starts");
    assert!(made.success());
    let out = folder.path().join("a.exr");
    let ran = run(ltsc()
        .args(["render", "scenes-src/cbox_empty.lts", "--renderer", "mitsuba-3", "--executable"])
        .arg(&fake)
        .arg("-o")
        .arg(&out));
    assert_eq!(ran.code, Some(4), "{}", ran.err);
    assert!(ran.err.contains("out of coffee") && ran.err.contains('7'), "{}", ran.err);
    assert!(!out.exists(), "half an image was written");
    assert!(folder.path().join("a.exr.log").is_file(), "the log is kept");
}

/// A diffuse square of reflectance (0.8, 0.4, 0.2) at the origin, seen from above by 8 x 8 pixels, in `light`.
fn square(folder: &Path, name: &str, integrator: &str, light: &str) -> PathBuf {
    let path = folder.join(format!("{name}.lts"));
    let text = format!(
        "lts 1\n\nscene {name} {{}}\n\n\
         camera = perspective(eye: (0, 0, 10), target: (0, 0, 0), up: Y, fov_x: 4deg)\nfilm = image(8, 8)\n\
         integrator = {integrator}(max_depth: 2)\nsampler = independent(samples: 16)\n\
         shape floor = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with diffuse(rgb(0.8, 0.4, 0.2))\n{light}\n"
    );
    std::fs::write(&path, text).expect("a scene");
    path
}

fn mean(image: &Image) -> [f64; 3] {
    let sum = image
        .pixels
        .iter()
        .fold([0.0; 3], |sum: [f64; 3], pixel| [0, 1, 2].map(|channel| sum[channel] + f64::from(pixel[channel])));
    sum.map(|sum| sum / image.pixels.len() as f64)
}

/// The radiance of a diffuse surface is reflectance E / pi: under a point E = I cos / r^2, under directional light
/// E = irradiance cos, under the environment E = pi L. Two of them never add up to a third by chance: each has its own
/// color, and the cosine is 0.8.
fn lights(renderers: &[&str]) {
    use std::f64::consts::PI;
    let lights: [(&str, &str, u32, [f64; 3], f64); 9] = [
        // 3 across and 4 up: r = 5. Over the pixels, 0.35 each way, the mean is 0.04 % below that in the middle.
        (
            "point",
            "emitter l = point(position: (0, 3, 4), intensity: rgb(100, 50, 10))",
            64,
            [100.0, 50.0, 10.0].map(|intensity| intensity * 0.8 / 25.0),
            2e-3,
        ),
        (
            "directional",
            "emitter l = directional(direction: (0, 3, -4), irradiance: rgb(3, 2, 1))",
            16,
            [3.0, 2.0, 1.0].map(|irradiance| irradiance * 0.8),
            1e-4,
        ),
        ("behind", "emitter l = directional(direction: (0, 3, 4), irradiance: rgb(3, 2, 1))", 16, [0.0; 3], 0.0),
        (
            "environment",
            "emitter l = environment(radiance: rgb(1, 2, 0.5))",
            1024,
            [1.0, 2.0, 0.5].map(|l| PI * l),
            5e-3,
        ),
        // On the axis all renderers agree; 5 up and 0 across, the mean over 0.35 each way is 0.5 % below the middle's.
        (
            "spot",
            "emitter l = spot(position: (0, 0, 5), target: (0, 0, 0), intensity: 100, angle: 30deg, inner: 10deg)",
            16,
            [100.0 / 25.0; 3],
            1e-2,
        ),
        // 20 degrees off the axis: within the cone and outside of it, whose edge passes 0.4 from the origin.
        (
            "inside",
            "emitter l = spot(position: (0, 0, 5), target: (0, 1.8199, 0), intensity: 100, angle: 26deg)",
            16,
            [100.0 / 25.0; 3],
            // LuxCore's spot is 1 / cos too bright; see its answer.
            0.075,
        ),
        (
            "outside",
            "emitter l = spot(position: (0, 0, 5), target: (0, 1.8199, 0), intensity: 100, angle: 14deg)",
            16,
            [0.0; 3],
            0.0,
        ),
        // Radiance under a light that a surface hides.
        (
            "hidden",
            "emitter l = point(position: (0, 0, 20), intensity: 100)\n\
             shape lid = rectangle(x: -1..1, y: -1..1, z: 15, normal: Z) with diffuse(0)",
            16,
            [0.0; 3],
            0.0,
        ),
        // Far away along the surface: no bounding sphere may cut the light off.
        (
            "wide",
            "emitter l = directional(direction: (10, 0, -1), irradiance: 10)\n\
             shape far = rectangle(x: -901..-900, y: -1..1, z: -90, normal: Z) with diffuse(0.5)",
            16,
            [10.0 / 101.0_f64.sqrt(); 3],
            1e-4,
        ),
    ];
    for &renderer in renderers {
        if !there(renderer) {
            return skip("lights without a surface", &format!("`ltsc renderers install {renderer}`"));
        }
        let folder = tempfile::tempdir().expect("a folder");
        for (name, light, samples, irradiance, tolerance) in &lights {
            let scene = square(folder.path(), name, "path", light);
            let out = folder.path().join(format!("{name}.exr"));
            let ran = run(ltsc().arg("render").arg(&scene).arg("-o").arg(&out).args([
                "--renderer",
                renderer,
                "--threads",
                // LuxCore's threads share the film without locks.
                "1",
                "--samples",
                &samples.to_string(),
            ]));
            assert_eq!(ran.code, Some(0), "{renderer} {name}: {}", ran.err);
            let found = mean(&read(&out).expect("an image").0);
            let reflectance = [0.8, 0.4, 0.2];
            for channel in 0..3 {
                let expected = reflectance[channel] * irradiance[channel] / PI;
                let off = (found[channel] - expected).abs();
                assert!(off <= tolerance * expected, "{renderer} {name}: {found:?} instead of {expected}");
            }
        }
    }
}

#[test]
fn lights_give_the_radiance_of_the_formula() {
    lights(&["mitsuba-3", "luxcore", "pbrt-r3"]);
}

/// Cycles takes two seconds to start, for each image.
#[test]
#[ignore = "long: Cycles starts nine times"]
fn lights_give_the_radiance_of_the_formula_in_cycles() {
    lights(&["cycles"]);
}

/// A room of reflectance 0.8 with a lamp and `thing` in it, 48 x 48 pixels.
pub fn room_text(name: &str, max_depth: u32, thing: &str) -> String {
    let wall = |name: &str, extent: &str, normal: &str| {
        format!("shape {name} = rectangle({extent}, normal: {normal}) with diffuse(0.8)\n")
    };
    let walls = [
        wall("floor", "x: -5..5, y: -5..5, z: 0", "Z"),
        wall("ceiling", "x: -5..5, y: -5..5, z: 10", "-Z"),
        wall("back", "x: -5..5, y: 5, z: 0..10", "-Y"),
        wall("left", "x: -5, y: -5..5, z: 0..10", "X"),
        wall("right", "x: 5, y: -5..5, z: 0..10", "-X"),
    ];
    format!(
        "lts 1\n\nscene {name} {{}}\n\n\
         camera = perspective(eye: (0, -16, 5), target: (0, 0, 5), fov_x: 45deg)\nfilm = image(48, 48)\n\
         integrator = path(max_depth: {max_depth})\nsampler = independent(samples: 16)\n{}\
         emitter lamp = rectangle(x: -2..2, y: -2..2, z: 9.9, normal: -Z) with radiance(10)\n{thing}\n",
        walls.concat()
    )
}

fn room(folder: &Path, name: &str, max_depth: u32, thing: &str) -> PathBuf {
    let path = folder.join(format!("{name}.lts"));
    std::fs::write(&path, room_text(name, max_depth, thing)).expect("a scene");
    path
}

/// A group at places that are turned, stretched and mirrored.
const INSTANCES: &str = "group thing(r: number) {
    shape ball = sphere(radius: r, segments: 32, rings: 16) with diffuse(rgb(0.8, 0.6, 0.2))
    shape box = box(size: 1) |> translate(z: 1.2) with mirror(reflectance: rgb(0.9, 0.7, 0.5))
}
for i in -1..1 { instance t = thing(0.8) |> rotate(z: 30deg * i) |> scale(x: 1, y: 2, z: 1) |> translate(2.5 * i, 0, 2) }
instance m = thing(0.8) |> scale(x: -1) |> rotate(y: 40deg) |> translate(1, 0, 6)";

#[test]
#[ignore = "long: Cycles starts"]
fn three_renderers_agree_on_instances() {
    agree_on(&[("instances", 6, INSTANCES)]);
}

/// Materials, instances with turns, shears and mirrors, and depths at which one segment more or less is a tenth of the light.
#[test]
#[ignore = "long: some fifty images"]
fn three_renderers_agree_on_small_scenes() {
    let scenes = [
        (
            "mirror",
            6,
            "shape m = box(size: 3) |> rotate(z: 20deg) |> translate(z: 2.5) with mirror(reflectance: rgb(0.9, 0.5, 0.2))",
        ),
        ("direct", 2, "shape m = box(size: 3) |> rotate(z: 20deg) |> translate(z: 2.5) with diffuse(0.5)"),
        ("once", 3, "shape m = box(size: 3) |> rotate(z: 20deg) |> translate(z: 2.5) with diffuse(0.5)"),
        (
            "lit",
            6,
            "emitter m = box(size: 3) |> rotate(z: 20deg) |> translate(z: 2.5) with radiance(1, over: diffuse(0.5))",
        ),
    ];
    let micro = THINGS.iter().map(|(name, thing)| (*name, 6, *thing));
    agree_on(&scenes.into_iter().chain(micro).collect::<Vec<_>>());
}

/// Squares of each material that is black from behind, in a white room: the upper ones from the front, the lower ones from behind.
const SIDES: &str = "lts 1\n\n/// Sides.\n///\n/// From the front and from behind.\nscene sides { paths: [\"LE\", \"L D+ E\"] }\n
camera = perspective(eye: (0, -10, 0), target: (0, 0, 0), fov_x: 40deg)
film = image(64, 24)
integrator = path(max_depth: 2)
sampler = independent(samples: 64)
emitter room = box(size: 40) |> flip() with radiance(1)
let metal = conductor(eta: rgb(0.2, 0.92, 1.1), k: rgb(3.9, 2.45, 2.1), alpha: 0.1)
let all = [diffuse(0.8), metal, mirror(0.7), plastic(0.8, alpha: 0.1), principled(0.8, metallic: 0.5)]
for i in 0..4 {
    shape front = rectangle(x: (1.2 * i - 3.5)..(1.2 * i - 2.5), y: 0, z: 0.1..1, normal: -Y) with one_sided(all[i])
    shape back = rectangle(x: (1.2 * i - 3.5)..(1.2 * i - 2.5), y: 0, z: -1..-0.1, normal: Y) with one_sided(all[i])
}
emitter front_lamp = rectangle(x: 2.5..3.5, y: 0, z: 0.1..1, normal: -Y) with radiance(0.5, over: one_sided(diffuse(0.5)))
emitter back_lamp = rectangle(x: 2.5..3.5, y: 0, z: -1..-0.1, normal: Y) with radiance(0.5, over: one_sided(diffuse(0.5)))
";

fn black_from_behind(renderer: &str) {
    if !there(renderer) {
        return skip("one-sided surfaces", &format!("`ltsc renderers install {renderer}`"));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, out) = (folder.path().join("sides.lts"), folder.path().join("sides.exr"));
    std::fs::write(&scene, SIDES).expect("a scene");
    let ran = run(ltsc().arg("render").arg(&scene).args(["--renderer", renderer, "-o"]).arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let image = read(&out).expect("an image").0;
    let scale = f64::from(64) / 2.0 / (10.0 * 20.0_f64.to_radians().tan());
    // Pixels around a middle.
    let at = |x: f64, z: f64| {
        let (left, top) = ((31.0 + x * scale) as usize, (11.0 - z * scale) as usize);
        (0..9).map(|nth| image.at(left + nth % 3, top + nth / 3)[1]).sum::<f32>() / 9.0
    };
    // Green of each in even light, where all renderers have the same: what a rough coat or a blend reflects is their own.
    for (square, known) in [Some(0.8), Some(0.614), Some(0.7), None, None, Some(1.0)].into_iter().enumerate() {
        let x = 1.2 * square as f64 - 3.0;
        let (front, back) = (at(x, 0.55), at(x, -0.55));
        assert!(back == 0.0 && front > 0.5, "{renderer}, {square}: {front} and {back}");
        assert!(known.is_none_or(|known| (front - known).abs() < 0.03), "{renderer}, {square}: {front}");
    }
}

#[test]
fn one_sided_surfaces_are_black_from_behind() {
    black_from_behind("mitsuba-3");
    black_from_behind("luxcore");
}

#[test]
#[ignore = "long: Cycles starts"]
fn one_sided_surfaces_are_black_from_behind_in_cycles() {
    black_from_behind("cycles");
}

/// What one renderer says otherwise than the others shows in the mean of a tile. Scenes are a name, a depth and what is in the room.
fn agree_on(scenes: &[(&str, u32, &str)]) {
    for renderer in ["mitsuba-3", "luxcore", "cycles"] {
        if !there(renderer) {
            return skip("small scenes in three renderers", &format!("`ltsc renderers install {renderer}`"));
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    for &(name, max_depth, thing) in scenes {
        let scene = room(folder.path(), name, max_depth, thing);
        let image = |renderer: &str| {
            let out = folder.path().join(format!("{name}-{renderer}.exr"));
            let ran = run(ltsc()
                .arg("render")
                .arg(&scene)
                .args(["--renderer", renderer, "--samples", "512", "-o"])
                .arg(&out));
            assert_eq!(ran.code, Some(0), "{renderer} {name}: {}", ran.err);
            read(&out).expect("an image").0
        };
        let first = image("mitsuba-3");
        for renderer in ["luxcore", "cycles"] {
            let (what, other) = (format!("{name} in {renderer} against Mitsuba 3"), image(renderer));
            if max_depth > 2 {
                judge(&what, &first, &other, 0.01, 0.1);
            } else {
                // Direct light leaves the ceiling black.
                let ratio = ratio(&first, &other);
                assert!((ratio - 1.0).abs() < 0.01, "{what}: {ratio}");
            }
        }
    }
}

/// Light tracing finds the same image as path tracing, from lights of every kind; a depth that is off by one would be a
/// black image here.
#[test]
fn light_tracing_gives_the_image_of_path_tracing() {
    if !there("mitsuba-3") {
        return skip("light tracing", "`ltsc renderers install mitsuba-3`");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let lights = [
        ("sun", "emitter l = directional(direction: (0, 3, -4), irradiance: 3)", 2.4),
        ("sky", "emitter l = environment(radiance: 1)", std::f64::consts::PI),
    ];
    for (name, light, irradiance) in lights {
        let scene = square(folder.path(), name, "light_tracing", light);
        let out = folder.path().join(format!("{name}.exr"));
        // Measured with 65536 samples: 1.0019 and 1.0008 of path tracing, with standard errors of about 0.2 %.
        let ran = run(ltsc()
            .arg("render")
            .arg(&scene)
            .args(["--renderer", "mitsuba-3", "--samples", "32768", "-o"])
            .arg(&out));
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.err);
        let found = mean(&read(&out).expect("an image").0);
        for (channel, reflectance) in [0.8, 0.4, 0.2].into_iter().enumerate() {
            let expected = reflectance * irradiance / std::f64::consts::PI;
            assert!((found[channel] / expected - 1.0).abs() < 0.02, "{name}: {found:?} instead of {expected}");
        }
    }
}

/// A square from (-1, -1) to (1, 1) of `surface` that fills 8 x 8 pixels, under light that makes its radiance its reflectance.
fn lit_square(folder: &Path, name: &str, before: &str, surface: &str) -> PathBuf {
    let path = folder.join(format!("{name}.lts"));
    // tan(fov / 2) = 1 / 10.
    let text = format!(
        "lts 1\n\nscene {name} {{}}\n\n\
         camera = perspective(eye: (0, 0, 10), target: (0, 0, 0), up: Y, fov_x: 2 * atan(0.1))\nfilm = image(8, 8)\n\
         integrator = path(max_depth: 2)\nsampler = independent(samples: 16)\n{before}\n\
         shape floor = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with {surface}\n\
         emitter sun = directional(direction: -Z, irradiance: PI)\n"
    );
    std::fs::write(&path, text).expect("a scene");
    path
}

/// Renders a small scene that is its author's own.
fn rendered(scene: &Path, renderer: &str, threads: &str) -> Image {
    let out = scene.with_extension(format!("{renderer}.exr"));
    let ran = run(ltsc().arg("render").arg(scene).arg("-o").arg(&out).args([
        "--renderer",
        renderer,
        "--threads",
        threads,
        "--timeout",
        "120",
        "--force",
    ]));
    assert_eq!(ran.code, Some(0), "{renderer} {}: {}", scene.display(), ran.err);
    read(&out).expect("an image").0
}

/// A quarter of an image of four colors that lie the right way up, read as sRGB and as they are, from a PNG and from floats.
fn textures(renderers: &[&str]) {
    // The codes of `quads.png`, by rows from the top; `quads.pfm` holds the same divided by 255.
    let quads = [[200, 60, 30], [128, 128, 128], [30, 90, 220], [255, 255, 255]];
    // IEC 61966-2-1.
    let decode = |x: f64| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    // A pixel in the middle of each quarter: four pixels of the image away from its neighbors.
    let places = [(1, 1), (6, 1), (1, 6), (6, 6)];
    for &renderer in renderers {
        if !there(renderer) {
            return skip("textures", &format!("`ltsc renderers install {renderer}`"));
        }
        let folder = tempfile::tempdir().expect("a folder");
        for file in ["quads.png", "quads.pfm"] {
            std::fs::copy(root().join("tests/cases/textures").join(file), folder.path().join(file)).expect("an image");
        }
        let kinds = [
            ("srgb", "bitmap(\"quads.png\")", true),
            ("linear", "bitmap(\"quads.png\", encoding: \"linear\")", false),
            ("floats", "bitmap(\"quads.pfm\")", false),
            ("scaled", "bitmap(\"quads.png\", scale: rgb(0.5, 0.25, 1))", true),
        ];
        for (name, texture, curved) in kinds {
            let factors = if name == "scaled" { [0.5, 0.25, 1.0] } else { [1.0; 3] };
            let scene = lit_square(folder.path(), name, &format!("texture quads = {texture}"), "diffuse(quads)");
            let image = rendered(&scene, renderer, "1");
            for ((x, y), codes) in places.into_iter().zip(quads) {
                let pixel = image.pixels[y * image.width + x];
                for ((found, code), factor) in pixel.into_iter().zip(codes).zip(factors) {
                    let share = f64::from(code) / 255.0;
                    let expected = factor * if curved { decode(share) } else { share };
                    let off = (f64::from(found) - expected).abs();
                    assert!(off <= 2e-4, "{renderer} {name} at ({x}, {y}): {pixel:?} instead of {expected}");
                }
            }
        }
    }
}

#[test]
fn textures_lie_the_right_way_up_and_are_decoded() {
    textures(&["mitsuba-3", "luxcore", "pbrt-r3"]);
}

#[test]
#[ignore = "long: Cycles starts four times"]
fn textures_lie_the_right_way_up_and_are_decoded_in_cycles() {
    textures(&["cycles"]);
}

/// A spectrum as a reflectance and as light has the colors that a table of 1 nm gives (color-science 0.4.7, CIE 1931, D65).
#[test]
fn spectra_have_the_colors_of_the_standard_observer() {
    let moss = "spectrum([(400, 0.08), (480, 0.12), (550, 0.38), (620, 0.22), (700, 0.3)])";
    let warm =
        "spectrum([(400, 0.175), (450, 0.368), (500, 0.631), (560, 1), (600, 1.254), (650, 1.554), (700, 1.818)])";
    let cases = [
        ("moss", format!("diffuse({moss})"), [0.26468, 0.31952, 0.08601]),
        ("grey", "diffuse(spectrum([(500, 0.25), (600, 0.25)]))".to_owned(), [0.25; 3]),
        ("warm", format!("radiance({warm})"), [1.77206, 0.84931, 0.27903]),
    ];
    for renderer in ["mitsuba-3", "luxcore"] {
        if !there(renderer) {
            return skip("spectra", "`ltsc renderers install mitsuba-3 luxcore`");
        }
        let folder = tempfile::tempdir().expect("a folder");
        for (name, surface, expected) in &cases {
            let scene = lit_square(folder.path(), name, "", surface);
            if surface.starts_with("radiance") {
                let text = std::fs::read_to_string(&scene).expect("the scene").replace("shape floor", "emitter floor");
                std::fs::write(&scene, text).expect("a scene");
            }
            let found = mean(&rendered(&scene, renderer, "1"));
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 2e-3, "{renderer} {name}: {found} instead of {expected}");
            }
        }
    }
}

/// Smooth plastic seen head-on in light from above, whose mirror image is no part of it: what passes the coat twice, at the base
/// and within the coat, is rho (1 - F)^2 / n^2 / (1 - rho Fi), with F = 0.04 and Fi = 0.5963 for n = 1.5 (Mitsuba's `plastic`).
#[test]
fn plastic_is_a_base_under_a_coat() {
    let expected = 0.5 * 0.96 * 0.96 / 2.25 / (1.0 - 0.5 * 0.5963);
    for (renderer, bound) in [("mitsuba-3", 2e-3), ("luxcore", 0.12)] {
        if !there(renderer) {
            return skip("plastic", "`ltsc renderers install mitsuba-3 luxcore`");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let scene = lit_square(folder.path(), "coat", "", "plastic(0.5)");
        // Light from the side of the camera's mirror image would be seen in the coat.
        let text = std::fs::read_to_string(&scene).expect("the scene").replace("eye: (0, 0, 10)", "eye: (0.8, 0, 10)");
        std::fs::write(&scene, text).expect("a scene");
        let image = rendered(&scene, renderer, "1");
        let found = f64::from(image.pixels[4 * image.width + 4][1]);
        assert!((found / expected - 1.0).abs() < bound, "{renderer}: {found} instead of {expected}");
    }
}

/// The albedo of a base of 0.5 under a coat of index 1.5, seen at 60 degrees in even light; `docs/conventions.md` has the table.
#[test]
fn plastic_and_principled_have_the_albedo_that_was_measured() {
    let known = [("mitsuba-3", 0.341, 0.582), ("luxcore", 0.341, 0.482), ("cycles", 0.348, 0.542)];
    for (renderer, plastic, principled) in known {
        if !there(renderer) {
            return skip("albedos", &format!("`ltsc renderers install {renderer}`"));
        }
        let folder = tempfile::tempdir().expect("a folder");
        let surfaces = [
            ("plastic", "plastic(0.5, alpha: 0.1)", plastic),
            ("principled", "principled(0.5, roughness: 0.316)", principled),
        ];
        for (name, surface, expected) in surfaces {
            let text = format!(
                "lts 1\n\nscene {name} {{}}\n\n\
                 camera = perspective(eye: (8.660254, 0, 5), target: (0, 0, 0), up: Y, fov_x: 1deg)\nfilm = image(8, 8)\n\
                 integrator = path(max_depth: 2)\nsampler = independent(samples: 1024)\n\
                 shape floor = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with {surface}\n\
                 emitter sky = environment(radiance: 1)\n"
            );
            let scene = folder.path().join(format!("{name}.lts"));
            std::fs::write(&scene, text).expect("a scene");
            let found = mean(&rendered(&scene, renderer, "1"))[1];
            assert!((found / expected - 1.0).abs() < 0.01, "{renderer} {name}: {found} instead of {expected}");
        }
    }
}

/// An image of the environment with a color of its own to each side: +y is its middle, +x lies to the right of that.
fn image_of_the_environment(renderers: &[&str]) {
    const SIZE: (usize, usize) = (256, 128);
    let sides = [[0.1, 0.1, 0.9], [0.1, 0.9, 0.1], [0.9, 0.1, 0.1], [0.9, 0.1, 0.9]];
    let (top, bottom) = ([0.9, 0.9, 0.1_f32], [0.1, 0.9, 0.9]);
    let mut pfm = format!("PF\n{} {}\n-1.0\n", SIZE.0, SIZE.1).into_bytes();
    // The rows of a PFM begin at the bottom.
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            // Sides are centered on 0, 1/4, 1/2 and 3/4 of the width: -y, -x, +y, +x.
            let side = sides[(x + SIZE.0 / 8) * 4 / SIZE.0 % 4];
            let color = if y < 24 {
                bottom
            } else if y >= SIZE.1 - 24 {
                top
            } else {
                side
            };
            pfm.extend(color.iter().flat_map(|channel: &f32| channel.to_le_bytes()));
        }
    }
    // Not straight up and down: the last rows are mixed with each other in LuxCore.
    let views = [
        ("front", "(0, 1, 0)", sides[2]),
        ("right", "(1, 0, 0)", sides[3]),
        ("left", "(-1, 0, 0)", sides[1]),
        ("back", "(0, -1, 0)", sides[0]),
        ("above", "(0, 0.1, 1)", top),
        ("below", "(0, 0.1, -1)", bottom),
    ];
    // What the image lights a diffuse surface that faces +y with: the sum over its pixels of L cos / pi.
    let mut lit = [0.0_f64; 3];
    let slope = |row: f64| (row / SIZE.1 as f64 - 0.5) * std::f64::consts::PI;
    for y in 0..SIZE.1 {
        let height = slope(y as f64 + 0.5);
        let area = (slope(y as f64 + 1.0).sin() - slope(y as f64).sin()) * 2.0 * std::f64::consts::PI / SIZE.0 as f64;
        for x in 0..SIZE.0 {
            // The middle of the width is +y.
            let turn = ((x as f64 + 0.5) / SIZE.0 as f64 - 0.5) * 2.0 * std::f64::consts::PI;
            let cosine = (height.cos() * turn.cos()).max(0.0);
            let at = (y * SIZE.0 + x) * 12 + pfm.len() - SIZE.0 * SIZE.1 * 12;
            for (channel, sum) in lit.iter_mut().enumerate() {
                let bytes = &pfm[at + 4 * channel..at + 4 * channel + 4];
                let radiance = f32::from_le_bytes(bytes.try_into().expect("four bytes"));
                *sum += f64::from(radiance) * cosine * area / std::f64::consts::PI;
            }
        }
    }
    for &renderer in renderers {
        if !there(renderer) {
            return skip("the environment", &format!("`ltsc renderers install {renderer}`"));
        }
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("sky.pfm"), &pfm).expect("an image");
        for (name, target, expected) in views {
            let text = format!(
                "lts 1\n\nscene {name} {{}}\n\nallow nothing-in-view \"the environment is looked at\"\n\
                 camera = perspective(eye: (0, 0, 0), target: {target}, fov_x: 2deg)\nfilm = image(4, 4)\n\
                 integrator = path(max_depth: 2)\nsampler = independent(samples: 16)\n\
                 shape far = rectangle(x: 50..51, y: 50..51, z: -50, normal: Z) with diffuse(0.5)\n\
                 emitter sky = environment(radiance: bitmap(\"sky.pfm\"))\n"
            );
            let scene = folder.path().join(format!("{name}.lts"));
            std::fs::write(&scene, text).expect("a scene");
            let found = mean(&rendered(&scene, renderer, "1"));
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - f64::from(expected)).abs() < 1e-3, "{renderer} {name}: {found} instead of {expected}");
            }
        }
        let text = "lts 1\n\nscene lit {}\n\n\
                    camera = perspective(eye: (0, 9, 0), target: (0, 0, 0), fov_x: 5deg)\nfilm = image(8, 8)\n\
                    integrator = path(max_depth: 2)\nsampler = independent(samples: 1024)\n\
                    shape wall = rectangle(x: -1..1, y: 0, z: -1..1, normal: Y) with diffuse(0.5)\n\
                    emitter sky = environment(radiance: bitmap(\"sky.pfm\"))\n";
        let scene = folder.path().join("lit.lts");
        std::fs::write(&scene, text).expect("a scene");
        let found = mean(&rendered(&scene, renderer, "1"));
        // Renderers interpolate where the sum above has an edge: 1 % in Mitsuba at this size of the image, 2.7 % at a quarter of it.
        for (found, lit) in found.into_iter().zip(lit) {
            assert!((found / (0.5 * lit) - 1.0).abs() < 0.02, "{renderer}: {found} instead of {}", 0.5 * lit);
        }
    }
}

#[test]
fn an_image_of_the_environment_is_the_right_way_round() {
    image_of_the_environment(&["mitsuba-3", "luxcore"]);
}

#[test]
#[ignore = "long: Cycles starts seven times"]
fn an_image_of_the_environment_is_the_right_way_round_in_cycles() {
    image_of_the_environment(&["cycles"]);
}
