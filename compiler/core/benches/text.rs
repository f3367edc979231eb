//! Large machine-written scene texts: what the grammar alone takes, the tree, and the finished Scene.
//!
//! Run on demand: `cargo bench -p ltsc-core --bench text`. Times are those of the machine; compare them as ratios.

use std::fmt::Write as _;
use std::hint::black_box;

use divan::Bencher;
use divan::counter::BytesCount;
use ltsc_core::diag::Sources;
use ltsc_core::eval::{Overrides, evaluate};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::syntax::parse;
use pest::Parser as _;

/// The grammar without anything of ours around it.
mod grammar {
    #[derive(pest_derive::Parser)]
    #[grammar = "../../grammar/lts.pest"]
    pub(super) struct Grammar;
}
use grammar::{Grammar, Rule};

fn main() {
    divan::main();
}

const STATEMENTS: u32 = 100_000;

const HEAD: &str = "lts 1
scene bulk {}
camera = perspective(eye: (0, -900, 300), target: (0, 0, 2), fov_x: 45deg)
film = image(64, 64)
integrator = path(max_depth: 3)
sampler = independent(samples: 4)
material stone = diffuse(0.5)
mesh ball = box(size: 1)
group oak {
    shape trunk = ball with stone
}
";

/// Shapes and instances in turn, each with a matrix: 13.6 MB.
fn text() -> String {
    let mut text = HEAD.to_owned();
    for at in 0..STATEMENTS {
        let turn = f64::from(at) * 0.618_034;
        let (a, b) = (libm::cos(turn), libm::sin(turn));
        let (x, y) = (a * f64::from(at) / 100.0, b * f64::from(at) / 100.0);
        let rows = format!("({a:.6}, {:.6}, 0, {x:.6}), ({b:.6}, {a:.6}, 0, {y:.6}), (0, 0, 1.25, 0.5)", -b);
        if at % 2 == 0 {
            writeln!(text, "shape ball_{at} = ball |> matrix({rows}) with stone").expect("text");
        } else {
            writeln!(text, "instance oak_{at} = oak |> matrix({rows})").expect("text");
        }
    }
    text
}

/// pest, called for each statement, and every pair looked at; one thread.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn grammar_alone(bencher: Bencher<'_, '_>) {
    let text = text();
    bencher.counter(BytesCount::of_str(&text)).bench(|| {
        let pairs = text.lines().map(|line| Grammar::parse(Rule::file, line).expect("good text").flatten().count());
        black_box(pairs.sum::<usize>())
    });
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn tree(bencher: Bencher<'_, '_>) {
    let text = text();
    let file = Sources::default().add("bulk.lts", "");
    bencher.counter(BytesCount::of_str(&text)).bench(|| black_box(parse(file, &text)));
}

/// Text to Scene.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn scene(bencher: Bencher<'_, '_>) {
    let text = text();
    let size = BytesCount::of_str(&text);
    let mut files = MemoryFiles::default();
    files.insert("bulk.lts", text);
    let path = VPath::resolve("", "bulk.lts").expect("a path");
    bencher.counter(size).bench(|| {
        let evaluated = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
        assert!(evaluated.scene.is_some(), "{:?}", evaluated.findings.first());
        black_box(evaluated)
    });
}
