//! What `ltsc lint` does to a scene, without the process: read, evaluate, lint. And the parser alone on bulk text.
//!
//! Run on demand: `cargo bench -p ltsc-core --bench lint`. Times are those of the machine; compare them as ratios.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::BytesCount;
use ltsc_core::diag::Sources;
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::pipeline::{Options, check, prepare};
use ltsc_core::syntax::parse;

fn main() {
    divan::main();
}

fn files() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    files.insert("lib/cornell.lts", include_str!("../../../scenes-src/lib/cornell.lts"));
    files.insert("cbox_classic.lts", include_str!("../../../scenes-src/cbox_classic.lts"));
    files.insert("veach_mis.lts", include_str!("../../../scenes-src/veach_mis.lts"));
    files
}

#[divan::bench(args = ["cbox_classic", "veach_mis"])]
fn lint(bencher: Bencher<'_, '_>, scene: &str) {
    let files = files();
    let path = VPath::resolve("", &format!("{scene}.lts")).expect("a path");
    bencher.bench(|| black_box(check(&files, &mut Sources::default(), &path, &Options::default())));
}

#[divan::bench(args = ["cbox_classic", "veach_mis"])]
fn lower_and_validate(bencher: Bencher<'_, '_>, scene: &str) {
    let path = VPath::resolve("", &format!("{scene}.lts")).expect("a path");
    let checked = check(&files(), &mut Sources::default(), &path, &Options::default());
    let scene = checked.scene.expect("a scene");
    bencher.with_inputs(|| scene.clone()).bench_values(|scene| black_box(prepare(scene).is_ok()));
}

/// 20 000 shapes, each with a matrix: machine-written text.
#[divan::bench]
fn parse_bulk(bencher: Bencher<'_, '_>) {
    let one = |at: u32| {
        format!(
            "shape s{at} = ball |> matrix((0.86, -0.5, 0, {at}), (0.5, 0.86, 0, -1.5), (0, 0, 1, 0.75)) with stone\n"
        )
    };
    let text: String = (0..20_000).map(one).collect();
    let file = Sources::default().add("bulk.lts", "");
    bencher.counter(BytesCount::of_str(&text)).bench(|| black_box(parse(file, &text)));
}
