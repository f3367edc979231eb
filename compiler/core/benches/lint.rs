//! What `ltsc lint` does to a scene, without the process: read, evaluate, lint. And the parser alone on bulk text.
//!
//! Run on demand: `cargo bench -p ltsc-core --bench lint`. Times are those of the machine; compare them as ratios.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use ltsc_core::diag::Sources;
use ltsc_core::eval::{Overrides, evaluate};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::lint::{self, Around, Level, Levels};
use ltsc_core::pipeline::{Options, check, prepare};
use ltsc_core::syntax::parse;

fn main() {
    divan::main();
}

fn files() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    files.insert("lib/cornell.lts", include_str!("../../../scenes-src/lib/cornell.lts"));
    files.insert("lib/metals.lts", include_str!("../../../scenes-src/lib/metals.lts"));
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

/// The rules that look at triangles, all others switched off.
const GEOMETRIC: &[&str] = &[
    "degenerate-triangles",
    "dielectric-contact",
    "duplicate-triangles",
    "emitter-in-wall",
    "far-from-origin",
    "flipped-normals",
    "inside-out-dielectric",
    "inside-out-mesh",
    "leaning-normals",
    "non-unit-normals",
    "open-dielectric",
    "overlapping-faces",
    "smooth-emitter",
];

/// The time that the geometric rules take for a scene with these items.
fn geometry(bencher: Bencher<'_, '_>, triangles: u32, items: &str) {
    let mut files = MemoryFiles::default();
    let settings = "camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(64, 64)\n\
                    integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n";
    files.insert("page.lts", format!("lts 1\nscene page {{}}\n{settings}{items}"));
    let path = VPath::resolve("", "page.lts").expect("a path");
    let evaluated = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
    let scene = evaluated.scene.unwrap_or_else(|| panic!("{:?}", evaluated.findings));
    let mut levels = Levels::default();
    levels.set("all", Level::Allow).expect("a group of rules");
    for rule in GEOMETRIC {
        levels.set(rule, Level::Warn).expect("a rule");
    }
    let around = Around::default();
    bencher.counter(ItemsCount::new(triangles)).bench(|| black_box(lint::lint(&scene, &around, &levels, &[])));
}

/// A ball in a shell of glass, half of the triangles each: two closed meshes whose boxes overlap everywhere.
#[divan::bench(args = [10_000, 100_000, 1_000_000, 10_000_000], sample_count = 3, sample_size = 1)]
fn geometry_of_two_meshes(bencher: Bencher<'_, '_>, triangles: u32) {
    let rings = (f64::from(triangles) / 8.0).sqrt().round() as u32 + 1;
    let sphere = format!("segments: {}, rings: {rings}", 2 * (rings - 1));
    let text = format!(
        "shape core = sphere(radius: 1, {sphere}) with diffuse(0.5)\n\
         shape shell = sphere(radius: 1.01, {sphere}) with dielectric(ior: 1.5)\n"
    );
    geometry(bencher, triangles, &text);
}

/// Blocks of two materials side by side on a floor, in tiles of 100: every block touches five others and the floor.
#[divan::bench(args = [10_000, 100_000, 1_000_000, 10_000_000], sample_count = 3, sample_size = 1)]
fn geometry_of_many_boxes(bencher: Bencher<'_, '_>, triangles: u32) {
    let side = (f64::from(triangles) / 1200.0).sqrt().round() as u32;
    let text = format!(
        "material dark = diffuse(0.2)\nmaterial light = diffuse(0.8)\nmesh block = box(x: 0..1, y: 0..2, z: 0..1)\n\
         group tile {{ for i in 0..4, j in 0..9 {{\n\
         shape dark = block |> translate(2 * i, 2 * j, 0) with dark\n\
         shape light = block |> translate(2 * i + 1, 2 * j, 0) with light\n}} }}\n\
         for i in 0..{last}, j in 0..{last} {{ instance tile = tile |> translate(10 * i, 20 * j, 0) }}\n\
         shape floor = rectangle(x: 0..{}, y: 0..{}, z: 0, normal: Z) with diffuse(0.5)\n",
        10 * side,
        20 * side,
        last = side - 1
    );
    geometry(bencher, triangles, &text);
}

/// The same, each tile turned by an angle of its own: no two pairs of blocks are alike.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 3, sample_size = 1)]
fn geometry_of_many_turned_boxes(bencher: Bencher<'_, '_>, triangles: u32) {
    let side = (f64::from(triangles) / 1200.0).sqrt().round() as u32;
    let text = format!(
        "material dark = diffuse(0.2)\nmaterial light = diffuse(0.8)\nmesh block = box(x: 0..1, y: 0..2, z: 0..1)\n\
         group tile {{ for i in 0..4, j in 0..9 {{\n\
         shape dark = block |> translate(2 * i, 2 * j, 0) with dark\n\
         shape light = block |> translate(2 * i + 1, 2 * j, 0) with light\n}} }}\n\
         for i in 0..{last}, j in 0..{last} {{\n\
         instance tile = tile |> rotate(z: (i * {side} + j) * 360deg / {count}) |> translate(20 * i, 20 * j, 0) }}\n\
         shape floor = rectangle(x: -20..{wide}, y: -20..{wide}, z: 0, normal: Z) with diffuse(0.5)\n",
        last = side - 1,
        count = side * side,
        wide = 20 * side,
    );
    geometry(bencher, triangles, &text);
}
