//! Chunks of large images put together and compared: how fast, and with how much memory. Run on demand:
//!
//!     cargo bench -p ltsc-evaluation --bench chunks            (8 chunks a side of 3840 x 2160)
//!     LTSC_CHUNKS=50 cargo bench -p ltsc-evaluation --bench chunks
//!
//! Beside each time stands that of reading the same files and of copying as many bytes in memory, the physical limits.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use ltsc_evaluation::compare::Images;
use ltsc_evaluation::compare::verdict::{Rendered, Tolerance, judge};
use ltsc_render::image::{Image, Provenance, plain_bytes};

fn image(width: usize, height: usize, seed: u64) -> Image {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    Image { width, height, pixels: (0..width * height).map(|_| [random(), random(), random()]).collect() }
}

/// The most memory that this process has held, in bytes.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap_or(0) * 1024
}

fn main() {
    let number =
        |name: &str, default: usize| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let (width, height, count) = (number("LTSC_WIDTH", 3840), number("LTSC_HEIGHT", 2160), number("LTSC_CHUNKS", 8));
    let folder = tempfile::tempdir().expect("a folder");
    let make = |side: u64| -> Vec<PathBuf> {
        (0..count)
            .map(|at| {
                let path = folder.path().join(format!("{side}-{at}.exr"));
                let image = image(width, height, side * 1000 + at as u64);
                fs::write(&path, plain_bytes(&path, &image, &Provenance::default()).expect("bytes")).expect("written");
                path
            })
            .collect()
    };
    let (a, b) = (make(1), make(2));
    let one_image = (width * height * 12) as f64;
    let bytes = one_image * count as f64;
    println!(
        "{count} chunks a side of {width} x {height}, {:.2} GB a side; an image is {:.0} MB",
        bytes / 1e9,
        one_image / 1e6
    );
    let told = |what: &str, bytes: f64, run: &mut dyn FnMut()| {
        let start = Instant::now();
        run();
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{what:<44} {seconds:>8.2} s {:>8.2} GB/s   peak memory {:>6.1} images",
            bytes / seconds / 1e9,
            peak() as f64 / one_image
        );
    };
    let read = |files: &[PathBuf]| {
        files.iter().map(|file: &PathBuf| fs::read(file as &Path).map_or(0, |bytes| bytes.len())).sum::<usize>()
    };
    told("reading the files of a side", bytes, &mut || assert!(read(&a) > 0));
    let source = vec![1_u8; one_image as usize];
    let mut target = vec![0_u8; one_image as usize];
    told("copying as many bytes in memory", bytes, &mut || {
        for _ in 0..count {
            target.copy_from_slice(&source);
            std::hint::black_box(&target);
        }
    });
    drop((source, target));
    told("mean and variance of a side", bytes, &mut || {
        std::hint::black_box(Images::Files(&a).moments().expect("moments"));
    });
    let side = |files| Rendered { images: Images::Files(files), samples: 16.0 };
    told("verdict on both sides", 2.0 * bytes, &mut || {
        std::hint::black_box(judge(side(&a), side(&b), Tolerance::default()).expect("a verdict"));
    });
}
