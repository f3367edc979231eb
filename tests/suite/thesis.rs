//! Our scenes against the thesis's own files of the same scenes, in one renderer at the same settings.
//!
//! The pools are left out: their water is ours, and path tracing cannot resolve their lights.

use std::path::Path;
use std::process::Command;

use ltsc_render::image::{Image, read};

use super::{corpus, python, root, skip};

/// Scene, samples of each image, and whether it takes part in every long run. With `LTSC_THOROUGH=1` all do, with 256 samples:
/// then the means tell differences of 0.5 % (a quarter of an hour on two cores).
const SCENES: &[(&str, u32, bool)] = &[
    ("cbox_classic", 64, false),
    ("cbox_empty", 64, false),
    ("cbox_indirect", 64, true),
    ("cboxm_diffuse_lsame", 32, false),
    ("cboxm_diffuse_lvar", 32, true),
    ("cboxm_glossy_lsame", 32, true),
    ("cboxm_glossy_lvar", 32, false),
    ("ring", 64, true),
    ("veach_mis", 64, false),
];

/// The one of a plain run, with few samples: its bounds follow from the noise that is found.
const QUICK: &[(&str, u32)] = &[("cbox_indirect", 8)];

/// Images of each side.
const SEEDS: usize = 4;

/// Renders a folder's `scene.xml` at 128 x 128 with `SEEDS` seeds. The thesis's files name properties that Mitsuba 3 does not
/// have; `unused_properties` keeps it from refusing them.
const SCRIPT: &str = "
import os, sys
import mitsuba as mi
mi.set_variant('scalar_rgb')
folder, samples, seeds, first, out = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
config = mi.parser.ParserConfig('scalar_rgb')
config.unused_properties = mi.LogLevel.Debug
state = mi.parser.parse_file(config, os.path.join(folder, 'scene.xml'))
mi.parser.transform_all(config, state)
mi.file_resolver().prepend(folder)
scene = mi.parser.instantiate(config, state)
scene = scene[0] if isinstance(scene, (list, tuple)) else scene
params = mi.traverse(scene)
for ending in ('film.size', 'film.crop_size'):
    key = [key for key in params.keys() if key.endswith(ending)][0]
    params[key] = [128, 128]
    params.update()
for seed in range(seeds):
    image = mi.render(scene, spp=samples, seed=(first + seed) * 128 * 128 * 7)
    bitmap = mi.Bitmap(image).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    bitmap.write(f'{out}{seed}.exr')
";

fn rendered(python: &Path, folder: &Path, samples: u32, first: usize, out: &Path) -> Vec<Image> {
    let output = Command::new(python)
        .args(["-c", SCRIPT])
        .arg(folder)
        .args([samples.to_string(), SEEDS.to_string(), first.to_string()])
        .arg(out)
        .output()
        .expect("Python starts");
    assert!(output.status.success(), "{}: {}", folder.display(), String::from_utf8_lossy(&output.stderr));
    let file = |seed: usize| format!("{}{seed}.exr", out.display());
    (0..SEEDS).map(|seed| read(Path::new(&file(seed))).expect("an image").0).collect()
}

/// The means over all channels of an 8 x 8 grid of tiles.
fn tiles(image: &Image) -> Vec<f64> {
    let mut sums = vec![0.0; 64];
    for y in 0..128 {
        for x in 0..128 {
            let pixel = image.at(x, y);
            sums[y / 16 * 8 + x / 16] += pixel.iter().map(|c| f64::from(*c)).sum::<f64>() / (3.0 * 256.0);
        }
    }
    sums
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance of one of the values.
fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (values.len() - 1) as f64
}

/// Renders the scenes of both sides, with so many samples, and compares them.
fn judge(scenes: &[(&str, u32)]) {
    let Some(python) = python("mitsuba-3") else {
        return skip("the thesis's scenes", "`ltsc renderers install mitsuba-3`");
    };
    let Some(corpus) = corpus() else { return skip("the thesis's scenes", "../shared/corpus/lteval") };
    let folder = tempfile::tempdir().expect("a folder");
    for (scene, samples) in scenes {
        let theirs = corpus.join(scene).join("mitsuba_0_5");
        let ours = root().join(format!("generated/{scene}/mitsuba-3"));
        // Other seeds, so that noise that both sides share hides nothing.
        let theirs = rendered(&python, &theirs, *samples, 1, &folder.path().join("theirs"));
        let ours = rendered(&python, &ours, *samples, 101, &folder.path().join("ours"));
        compare(scene, &theirs, &ours);
    }
}

#[test]
fn a_scene_of_ours_is_that_of_the_thesis() {
    judge(QUICK);
}

#[test]
#[ignore = "long: 32 images of 128 x 128 pixels"]
fn our_scenes_are_those_of_the_thesis() {
    let thorough = std::env::var_os("LTSC_THOROUGH").is_some_and(|value| value == "1");
    let asked = SCENES.iter().filter(|(_, _, always)| thorough || *always);
    judge(&asked.map(|(scene, samples, _)| (*scene, if thorough { 256 } else { *samples })).collect::<Vec<_>>());
}

fn compare(scene: &str, theirs: &[Image], ours: &[Image]) {
    let count = SEEDS as f64;
    let theirs: Vec<Vec<f64>> = theirs.iter().map(tiles).collect();
    let ours: Vec<Vec<f64>> = ours.iter().map(tiles).collect();
    let means = |images: &[Vec<f64>]| images.iter().map(|tiles| mean(tiles)).collect::<Vec<f64>>();
    let (all_theirs, all_ours) = (means(&theirs), means(&ours));
    let whole = mean(&all_theirs);
    let ratio = mean(&all_ours) / whole;
    let error = ((variance(&all_theirs) + variance(&all_ours)) / count).sqrt() / whole;
    assert!((ratio - 1.0).abs() <= f64::max(0.005, 4.0 * error), "{scene}: means {ratio:.4} +- {error:.4}");

    let of = |images: &[Vec<f64>], tile: usize| images.iter().map(|tiles| tiles[tile]).collect::<Vec<f64>>();
    let pairs: Vec<(Vec<f64>, Vec<f64>)> = (0..64).map(|tile| (of(&theirs, tile), of(&ours, tile))).collect();
    let noise = |(a, b): &(Vec<f64>, Vec<f64>)| (variance(a) + variance(b)) / count;
    // Eight images tell the noise of a tile badly: half of what counts is the median of all tiles, relative to their means.
    let mut shares: Vec<f64> = pairs.iter().map(|pair| noise(pair) / (mean(&pair.0) * mean(&pair.0))).collect();
    shares.sort_by(f64::total_cmp);
    let usual = shares[32];
    let scores: Vec<f64> = pairs
        .iter()
        .map(|pair| {
            let (a, b) = (mean(&pair.0), mean(&pair.1));
            let variance = 0.5 * noise(pair) + 0.5 * usual * a * a;
            // What two right renderings may differ by: 0.2 % of a tile, and a little of the image in dark ones.
            (b - a) / (variance + (0.002 * a).powi(2) + (0.0025 * whole).powi(2)).sqrt()
        })
        .collect();
    let rms = mean(&scores.iter().map(|z| z * z).collect::<Vec<f64>>()).sqrt();
    let worst = scores.iter().fold(0.0_f64, |worst, z| worst.max(z.abs()));
    assert!(rms < 1.6 && worst < 6.0, "{scene}: tiles differ, rms z {rms:.2}, worst {worst:.2}");
    let _written = std::io::Write::write_fmt(
        &mut std::io::stderr(),
        format_args!("{scene}: means {ratio:.4} +- {error:.4}, tiles rms z {rms:.2}, worst {worst:.2}\n"),
    );
}
