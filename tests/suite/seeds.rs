//! Seeds of real renderers: each gives other noise and the same image, however large it is and however near to another.

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::image::{Image, read};
use ltsc_render::install::{Status, status};
use ltsc_render::run::{DRIVERS, Driver, Installation};

use super::{ltsc, root, run, skip};

/// Neighbors, and numbers beyond what 7 or 8 bits hold.
const SEEDS: [u32; 5] = [0, 1, 2, 101, 300];

/// Those of pbrt-r3, which renders an image more for each.
const FEW: [u32; 5] = [0, 1, 2, 3, 5];

/// Cycles and LuxCore take a second or two to start, and pbrt-r3 renders ten images.
const SLOW: [&str; 3] = ["cycles", "luxcore", "pbrt-r3"];

#[test]
fn seeds_change_the_noise_and_not_the_image() {
    seeds(|name| !SLOW.contains(&name));
}

#[test]
#[ignore = "long: ten slow starts"]
fn seeds_change_the_noise_and_not_the_image_in_slow_renderers() {
    seeds(|name| SLOW.contains(&name));
}

fn seeds(asked: impl Fn(&str) -> bool) {
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let ours = |driver: &&Driver| !matches!(driver.installation, Installation::User { .. });
    for &driver in DRIVERS.iter().filter(|driver| ours(driver) && asked(driver.name)) {
        let there = matches!(status(driver, cache.as_ref(), &env), Status::Installed { .. } | Status::External { .. });
        if !there {
            skip("seeds", &format!("`ltsc renderers install {}`", driver.name));
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let render = |seed: u32| {
            let out = folder.path().join(format!("{seed}.exr"));
            let ran = run(ltsc()
                .arg("render")
                .arg(root().join("scenes-src/cbox_classic.lts"))
                .args(["--renderer", driver.name, "--width", "32", "--height", "32", "--samples", "64"])
                // LuxCore gives out its samples to threads as they come: with several, equal seeds give images of other noise.
                .args(["--threads", "1", "--seed", &seed.to_string(), "-o"])
                .arg(&out));
            (ran.code, out)
        };
        let seeds = if driver.name == "pbrt-r3" { FEW } else { SEEDS };
        let images = seeds.map(|seed| {
            let (code, out) = render(seed);
            assert_eq!(code, Some(0), "{} {seed}", driver.name);
            read(&out).expect("an image").0
        });
        judge(driver.name, &seeds, &images);
    }
}

/// The images have the same mean, and what each differs by from that mean has nothing to do with what another does, nor with that of
/// the pixel beside it in another.
fn judge(name: &str, seeds: &[u32], images: &[Image]) {
    let count = images.len() as f64;
    let value = |image: &Image, at: usize| image.pixels[at].iter().map(|x| f64::from(*x)).sum::<f64>();
    let mean = |at: usize| images.iter().map(|image| value(image, at)).sum::<f64>() / count;
    let means: Vec<f64> = (0..1024).map(mean).collect();
    // In units of the pixel's own scatter: the edge of the lamp would outweigh all others.
    let scatter = |at: usize| images.iter().map(|image| (value(image, at) - means[at]).powi(2)).sum::<f64>().sqrt();
    let scatters: Vec<f64> = (0..1024).map(|at| scatter(at).max(f64::MIN_POSITIVE)).collect();
    let off = |image: &Image| (0..1024).map(|at| (value(image, at) - means[at]) / scatters[at]).collect();
    let off: Vec<Vec<f64>> = images.iter().map(off).collect();
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    for (a, one) in off.iter().enumerate() {
        for (b, other) in off.iter().enumerate().filter(|(b, _)| *b != a) {
            let norm = (dot(one, one) * dot(other, other)).sqrt();
            let pair = format!("{name}: seeds {} and {}", seeds[a], seeds[b]);
            // Of the deviations of five independent images from their mean, two correlate by -1 / 4; 0.03 is the standard error.
            let same = dot(one, other) / norm;
            assert!((same + 0.25).abs() < 0.2, "{pair} correlate by {same}");
            let beside = dot(&one[1..], &other[..1023]) / norm;
            assert!(beside.abs() < 0.2, "{pair} correlate by {beside}, one pixel over");
        }
    }
    let sums: Vec<f64> = images.iter().map(|image| (0..1024).map(|at| value(image, at)).sum::<f64>()).collect();
    let middle = sums.iter().sum::<f64>() / count;
    // Of LuxCore's, the noisiest, one mean scatters by 1.2 %.
    assert!(sums.iter().all(|sum| (sum / middle - 1.0).abs() < 0.05), "{name}: {sums:?}");
}
