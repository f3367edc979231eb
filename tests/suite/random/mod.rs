//! Random scenes that are valid: written for every target, twice, and read back. `LTSC_RANDOM=N` asks the long run for so many of them,
//! and `LTSC_RANDOM_SEED=N` for others; `LTSC_THOROUGH=1` for ten thousand.

mod author;
pub mod dice;
mod scene;
mod shapes;

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::{Family, table};
use ltsc_core::files::{MemoryFiles, MemorySink, VPath};
use ltsc_core::formats::{self, Choices, TARGETS};
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline::{self, Options};

use self::author::{Author, Written};
use super::root;

/// Scenes of a plain run.
const FEW: u64 = 80;
/// Scenes of a long run, the first of which those of a plain run are.
const MORE: u64 = 400;
/// Scenes of a thorough one.
const MANY: u64 = 10_000;

/// Rows of the table that the author never writes, with the reason: none. A new constructor is added to the author, or here.
const NEVER: &[(Family, &str, &str)] = &[];

/// Files that scenes name, by the folder they lie in.
const FILES: &[(&str, &[&str])] = &[
    (
        "compiler/cli/conventions/images",
        &[
            "colors.png",
            "edge.png",
            "edge_16.png",
            "edge.jpg",
            "edge.exr",
            "edge.pfm",
            "edge.hdr",
            "sky.exr",
            "ridge.ply",
        ],
    ),
    ("tests/cases/images", &["odd name (1).png", "palette.png"]),
    (
        "tests/cases/meshes",
        &[
            "colored.ply",
            "no_normals.ply",
            "strips.ply",
            "tetrahedron.obj",
            "room.obj",
            "room.mtl",
            "cube.stl",
            "table.glb",
        ],
    ),
    ("tests/cases/arrays", &["positions.npy", "forest.npy", "heights.npy"]),
];

/// What became of a scene.
enum Outcome {
    /// Written and read back.
    Good,
    /// Refused with these codes.
    Refused(Vec<String>),
    /// A fault of ltsc.
    Fault(String),
}

fn shared_files() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    for (folder, names) in FILES {
        for name in *names {
            files.insert(*name, fs::read(root().join(folder).join(name)).expect("a file of the tests"));
        }
    }
    files.insert("lib.lts", scene::LIBRARY);
    files
}

/// The text of the scene with this seed, and what it has of the table.
pub fn scene_text(seed: u64) -> (String, Written) {
    let mut author = Author::new(seed);
    let text = scene::text(&mut author, "x");
    (text, author.written)
}

/// The files of the scene with this seed, and its path.
pub fn files_of(seed: u64) -> (MemoryFiles, String) {
    let mut files = shared_files();
    files.insert("x.lts", scene_text(seed).0);
    (files, "x.lts".to_owned())
}

/// Writes a scene for all targets into memory, as `ltsc build` does.
pub fn written(scene: &ltsc_core::valid::Valid, choices: &Choices) -> BTreeMap<String, Vec<u8>> {
    let (camera, _) = scene.cameras.iter().next().expect("a camera");
    let mut sink = MemorySink::default();
    formats::write_meshes(scene, "meshes/", &mut sink).expect("memory takes all");
    let all: Vec<_> = TARGETS.iter().collect();
    formats::write_textures(scene, &all, "textures/", &mut sink).expect("memory takes all");
    let mut files = sink.files;
    for target in TARGETS {
        let mut sink = MemorySink::default();
        let ledger = Ledger::of(scene, target, &[]);
        pipeline::emit_shared(scene, camera, target, &ledger, choices, &mut sink).expect("memory takes all");
        files.extend(sink.files.into_iter().map(|(name, bytes)| (format!("{}/{name}", target.name), bytes)));
    }
    files
}

fn outcome(files: &MemoryFiles, seed: u64) -> Outcome {
    let (text, _) = scene_text(seed);
    let mut files = files.clone();
    files.insert("x.lts", text);
    let path = VPath::resolve("", "x.lts").expect("a path");
    let checked = pipeline::check(&files, &mut Sources::default(), &path, &Options::default());
    let errors = |findings: &[ltsc_core::diag::Finding]| -> Vec<String> {
        let errors = findings.iter().filter(|finding| finding.severity == Severity::Error);
        errors.map(|finding| format!("{}: {}", finding.id, finding.message)).collect()
    };
    let refused = errors(&checked.findings);
    let Some(scene) = checked.scene.filter(|_| refused.is_empty()) else { return Outcome::Refused(refused) };
    let valid = match pipeline::prepare(scene) {
        Ok((valid, _)) => valid,
        Err(findings) => return Outcome::Refused(errors(&findings)),
    };
    let mut choices = Choices::default();
    if seed.is_multiple_of(3) {
        for (target, choice) in formats::choices() {
            choices.add(&format!("{}.{}", target.name, choice.name)).expect("a choice");
        }
    }
    let all = written(&valid, &choices);
    if seed.is_multiple_of(16) && all != written(&valid, &choices) {
        return Outcome::Fault("the files differ from those of the run before".to_owned());
    }
    let mut out = MemoryFiles::default();
    all.into_iter().for_each(|(name, bytes)| out.insert(name, bytes));
    let (camera, _) = valid.cameras.iter().next().expect("a camera");
    let targets: Vec<_> = TARGETS.iter().collect();
    let audited = pipeline::audit(&valid, camera, &targets, &out, |target| target.name.to_owned());
    let found: Vec<String> =
        audited.findings().map(|finding| format!("{:?} {}: {}", finding.origin, finding.id, finding.message)).collect();
    if found.is_empty() { Outcome::Good } else { Outcome::Fault(found.join("\n    ")) }
}

/// A number that the environment may set.
pub fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// What `work` gives for each of `count` seeds, two at a time.
pub fn in_parallel<T: Send>(first: u64, count: u64, work: impl Fn(u64) -> T + Sync) -> Vec<(u64, T)> {
    let next = AtomicU64::new(first);
    let one = || {
        let mut found = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= first + count {
                return found;
            }
            found.push((seed, work(seed)));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(2);
    let mut all: Vec<(u64, T)> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        running.into_iter().flat_map(|thread| thread.join().expect("a thread that ends")).collect()
    });
    all.sort_by_key(|(seed, _)| *seed);
    all
}

#[test]
fn valid_scenes_are_written_and_read_back() {
    judge(1, FEW);
}

/// As many as `LTSC_RANDOM` says, from the seed `LTSC_RANDOM_SEED` on.
#[test]
#[ignore = "long: hundreds of scenes"]
fn more_valid_scenes_are_written_and_read_back() {
    let thorough = std::env::var_os("LTSC_THOROUGH").is_some_and(|value| value == "1");
    let first = number("LTSC_RANDOM_SEED").unwrap_or(if thorough { 1 } else { FEW + 1 });
    judge(first, number("LTSC_RANDOM").unwrap_or(if thorough { MANY } else { MORE - FEW }));
}

/// Writes so many scenes from a seed on.
fn judge(first: u64, count: u64) {
    let files = shared_files();
    let all = in_parallel(first, count, |seed| {
        let outcome = catch_unwind(AssertUnwindSafe(|| outcome(&files, seed)));
        outcome.unwrap_or_else(|_| Outcome::Fault("it panicked".to_owned()))
    });
    let (mut faults, mut refused) = (Vec::new(), BTreeMap::<String, Vec<u64>>::new());
    for (seed, outcome) in &all {
        match outcome {
            Outcome::Good => {}
            Outcome::Refused(why) => {
                refused.entry(why.first().cloned().unwrap_or_default()).or_default().push(*seed);
            }
            Outcome::Fault(what) => faults.push(format!("seed {seed}: {what}")),
        }
    }
    let no: usize = refused.values().map(Vec::len).sum();
    println!("{count} scenes from seed {first}, {no} of them refused, {} faults", faults.len());
    for (why, seeds) in &refused {
        println!("refused {:?}: {why}", &seeds[..seeds.len().min(3)]);
    }
    assert!(faults.is_empty(), "{} scenes:\n{}", faults.len(), faults.join("\n"));
    assert!(no as u64 * 20 <= count, "{no} of {count} scenes are not valid");
}

/// A new constructor or parameter is a part of random scenes from its first day on.
#[test]
fn random_scenes_have_every_constructor_with_every_parameter() {
    let mut written = Written::new();
    for seed in 1..=MORE {
        for (row, params) in scene_text(seed).1 {
            written.entry(row).or_default().extend(params);
        }
    }
    let mut missing = Vec::new();
    for row in table() {
        let never = NEVER.iter().any(|(family, name, _)| *family == row.family && *name == row.name);
        let used = written.get(&(row.family, row.name));
        assert!(!(never && used.is_some()), "`{}` is written after all", row.name);
        if never {
            continue;
        }
        let Some(used) = used else {
            missing.push(format!("`{}`, {}", row.name, row.family.words()));
            continue;
        };
        // What stands before `|>` has no label.
        let params = row.params.iter().skip(usize::from(row.family == Family::Stage));
        let absent = params.filter(|param| !used.contains(param.name));
        missing.extend(absent.map(|param| format!("`{}` of `{}`", param.name, row.name)));
    }
    assert!(missing.is_empty(), "no random scene has {}", missing.join(", "));
}
