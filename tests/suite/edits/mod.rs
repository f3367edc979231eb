//! Edits of one number or word in generated files: each is seen by the audit, or stands in the table of what means nothing.
//! `LTSC_EDITS=N` asks for so many, `LTSC_EDITS_SEED=N` for others; `LTSC_THOROUGH=1` for 3,000 in more scenes.

mod change;
mod meaningless;
mod removed;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ltsc_core::files::{Bytes, Files, MemoryFiles, ReadError, VPath};
use ltsc_core::formats::{self, Choices, TARGETS, Target};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;

use self::change::Change;
use super::random::dice::Dice;
use super::{Disk, prepared, random, root, scenes};

/// Edits of a plain run.
const FEW: u64 = 250;
/// Edits of a thorough one.
const MANY: u64 = 3_000;

/// Seeds of random scenes that are edited, in a plain run the first of them.
const SEEDS: u64 = 30;

/// A scene with all its files.
struct Written {
    name: String,
    scene: Valid,
    files: BTreeMap<String, Vec<u8>>,
    memory: MemoryFiles,
}

impl Written {
    fn new(name: String, scene: Valid) -> Self {
        let files = random::written(&scene, &Choices::default());
        let mut memory = MemoryFiles::default();
        files.iter().for_each(|(name, bytes)| memory.insert(name.clone(), bytes.clone()));
        Self { name, scene, files, memory }
    }
}

/// Files of which one is another.
struct Edited<'f> {
    files: &'f MemoryFiles,
    path: &'f str,
    bytes: Vec<u8>,
}

impl Files for Edited<'_> {
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        if path.as_str() == self.path { Ok(Bytes::new(self.bytes.clone())) } else { self.files.read(path, limit) }
    }
}

/// The scenes that are edited: ours, the small ones in a plain run, and random ones.
fn pool(thorough: bool) -> Vec<Written> {
    let ours = scenes().into_iter().filter(|name| thorough || ["cbox_classic", "surfaces"].contains(&name.as_str()));
    let files = Disk(root().to_path_buf());
    let mut all: Vec<Written> = ours
        .map(|name| {
            let scene = prepared(&files, &format!("scenes-src/{name}.lts"));
            Written::new(name, scene)
        })
        .collect();
    for seed in 1..=if thorough { SEEDS } else { SEEDS / 3 } {
        let (files, path) = random::files_of(seed);
        all.push(Written::new(format!("random scene {seed}"), prepared(&files, &path)));
    }
    all
}

/// What became of an edit.
enum Outcome {
    Seen,
    Meaningless(&'static str),
    Unseen(String),
}

fn outcome(pool: &[Written], seed: u64) -> Outcome {
    let mut dice = Dice::new(seed);
    loop {
        let written = &pool[dice.at(pool.len())];
        let target = &TARGETS[dice.at(TARGETS.len())];
        let own = format!("{}/", target.name);
        // Files of all targets are asked for as often as the target's own.
        let names: Vec<&String> = written
            .files
            .keys()
            // The account of losses is no part of the scene.
            .filter(|name| !name.ends_with("ledger.json") || dice.chance(0.1))
            .filter(|name| name.starts_with(&own) || (target.shares_meshes && shared(written, target, name)))
            .collect();
        let path = names[dice.at(names.len())];
        let bytes = &written.files[path];
        let Some(change) = change::change(path, bytes, &mut dice) else { continue };
        if change.to == bytes[change.at..change.end] {
            continue;
        }
        let file = path.strip_prefix(&own).unwrap_or(path);
        let files = Edited { files: &written.memory, path, bytes: change.applied(bytes) };
        let (camera, _) = written.scene.cameras.iter().next().expect("a camera");
        let audit = || {
            let audited = pipeline::audit(&written.scene, camera, &[target], &files, |target| target.name.to_owned());
            audited.findings().next().is_some()
        };
        let Change { from, to, line, .. } = &change;
        let what = format!(
            "seed {seed}, {}, {} {path}: `{from}` to `{}` in `{line}` behind `{}`",
            written.name,
            target.name,
            String::from_utf8_lossy(to),
            change.around(bytes)
        );
        return match catch_unwind(AssertUnwindSafe(audit)) {
            Ok(true) => Outcome::Seen,
            Ok(false) => match meaningless::reason(target.name, file, &change) {
                Some(why) => Outcome::Meaningless(why),
                None => Outcome::Unseen(what),
            },
            Err(_) => Outcome::Unseen(format!("{what}: it panicked")),
        };
    }
}

/// Whether a file lies in the folders that targets share, and this one reads it.
fn shared(written: &Written, target: &Target, name: &str) -> bool {
    if name.starts_with("meshes/") {
        return true;
    }
    let images = formats::shared::images::shared(&written.scene, target.images);
    let files = formats::texture_files(&written.scene).into_iter().zip(images);
    name.strip_prefix("textures/").is_some_and(|name| files.clone().any(|(file, shared)| shared && file == name))
}

#[test]
fn an_edit_is_seen_or_means_nothing() {
    let thorough = std::env::var_os("LTSC_THOROUGH").is_some_and(|value| value == "1");
    let count = random::number("LTSC_EDITS").unwrap_or(if thorough { MANY } else { FEW });
    let first = random::number("LTSC_EDITS_SEED").unwrap_or(1);
    let pool = pool(thorough);
    let all = random::in_parallel(first, count, |seed| outcome(&pool, seed));
    let (mut seen, mut nothing, mut unseen) = (0, BTreeMap::<&str, usize>::new(), Vec::new());
    for (_, outcome) in all {
        match outcome {
            Outcome::Seen => seen += 1,
            Outcome::Meaningless(why) => *nothing.entry(why).or_default() += 1,
            Outcome::Unseen(what) => unseen.push(what),
        }
    }
    println!("{count} edits from seed {first}: {seen} seen, {} not, the rest mean nothing:", unseen.len());
    for (why, count) in &nothing {
        println!("{count:6}  {why}");
    }
    assert!(unseen.is_empty(), "{} edits are not seen:\n{}", unseen.len(), unseen.join("\n"));
    assert!(2 * seen > count, "most edits mean nothing");
}
