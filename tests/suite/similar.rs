//! `ltsc similar`: the bounds that the help states, held against the eleven scenes that they were chosen by and against others, and
//! what drafts are told.

mod drafts;

use std::collections::BTreeMap;
use std::fs;
use std::sync::OnceLock;

use ltsc_core::diag::Sources;
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::lint::Level;
use ltsc_core::pipeline::{self, Options};
use ltsc_core::similar::{Near, Nearness, Profile, rank};
use serde_json::Value;

use super::outputs::{CLEAN, project};
use super::{files_below, ltsc, root, run, scenes};

fn answer(folder: &std::path::Path, scene: &str) -> Value {
    let ran = run(ltsc().current_dir(folder).args(["similar", scene, "--format", "json"]));
    assert_eq!(ran.code, Some(0), "{scene}: {}", ran.err);
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{scene}: {error}\n{}", ran.out))
}

/// The scenes that the bounds were chosen by: those of the lteval suite.
const ELEVEN: [&str; 11] = [
    "cbox_classic",
    "cbox_empty",
    "cbox_indirect",
    "cboxm_diffuse_lsame",
    "cboxm_diffuse_lvar",
    "cboxm_glossy_lsame",
    "cboxm_glossy_lvar",
    "pool_classic",
    "pool_simple",
    "ring",
    "veach_mis",
];

/// What the project's scenes are compared by.
fn profiles() -> &'static [Profile] {
    static PROFILES: OnceLock<Vec<Profile>> = OnceLock::new();
    PROFILES.get_or_init(read_profiles)
}

fn read_profiles() -> Vec<Profile> {
    let mut files = MemoryFiles::default();
    for path in files_below(&root().join("scenes-src")) {
        files.insert(path.clone(), fs::read(root().join("scenes-src").join(&path)).expect("a file"));
    }
    let mut options = Options::default();
    options.levels.set("all", Level::Allow).expect("a group");
    let of = |name: &str| {
        let path = VPath::resolve("", &format!("{name}.lts")).expect("a path");
        let checked = pipeline::check(&files, &mut Sources::default(), &path, &options);
        Profile::of(&checked.scene.unwrap_or_else(|| panic!("{name}: {:#?}", checked.findings)))
    };
    scenes().iter().map(|name| of(name)).collect()
}

/// Whether one of two scenes names the other in `similar`.
fn named(a: &str, b: &str) -> bool {
    let text = |name: &str| fs::read_to_string(root().join(format!("scenes-src/{name}.lts"))).expect("a scene");
    text(a).contains(&format!("(\"{b}\",")) || text(b).contains(&format!("(\"{a}\","))
}

#[test]
fn the_bounds_tell_the_eleven_scenes_apart() {
    let profiles: Vec<Profile> =
        profiles().iter().filter(|profile| ELEVEN.contains(&profile.name.as_str())).cloned().collect();
    let mut pairs: BTreeMap<(String, String), Near> = BTreeMap::new();
    for own in &profiles {
        let others: Vec<Profile> = profiles.iter().filter(|other| other.name != own.name).cloned().collect();
        for near in rank(own, &others) {
            let mut pair = [own.name.clone(), near.name.clone()];
            pair.sort();
            let [a, b] = pair;
            if let Some(back) = pairs.insert((a, b), near.clone()) {
                assert!((back.score - near.score).abs() < 1e-12, "{back:?} {near:?}");
            }
        }
    }
    assert_eq!(pairs.len(), profiles.len() * (profiles.len() - 1) / 2);
    let of = |accept: &dyn Fn(Nearness, bool) -> bool| -> Vec<String> {
        let kept = pairs.iter().filter(|((a, b), near)| accept(near.nearness, named(a, b)));
        kept.map(|((a, b), _)| format!("{a} {b}")).collect()
    };
    assert_eq!(
        of(&|nearness, _| nearness == Nearness::VeryNear),
        ["cboxm_diffuse_lsame cboxm_diffuse_lvar", "cboxm_glossy_lsame cboxm_glossy_lvar"]
    );
    assert_eq!(of(&|nearness, named| nearness == Nearness::Far && named), ["cbox_classic cbox_indirect"]);
    assert!(of(&|nearness, named| nearness > Nearness::Far && !named).is_empty(), "{pairs:#?}");
    assert_eq!(of(&|_, named| named).len(), 11);
    // The gaps that the bounds lie in.
    let score = |a: &str, b: &str| pairs[&(a.to_owned(), b.to_owned())].score;
    assert!(score("pool_classic", "pool_simple") > 0.52 && score("ring", "veach_mis") < 0.48);
    assert!(score("cboxm_glossy_lsame", "cboxm_glossy_lvar") > 0.94 && score("cbox_classic", "cbox_empty") < 0.81);
}

#[test]
fn drafts_are_told_what_to_write() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(
        folder,
        &[("one", ""), ("four", "shape a = box(size: 1) with dielectric(ior: 1.5)\n"), ("broken", "shape a = x\n")],
    );
    let draft = |name: &str, text: &str| {
        fs::write(folder.join(format!("{name}.lts")), text.replace("NAME", name)).expect("a write");
        let ran = run(ltsc().current_dir(folder).arg("similar").arg(format!("{name}.lts")));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        ran
    };
    let twin = draft("twin", &CLEAN.replace("LDE", "LDDDDE"));
    assert!(twin.out.contains("1.00   1.00   1.00       1.00   one  very near"), "{}", twin.out);
    assert!(twin.out.contains("`one`: consider replacing it by `twin`"), "{}", twin.out);
    assert!(twin.out.contains("in `twin`: similar: [(\"one\", \"...\")"), "{}", twin.out);
    assert!(twin.err.contains("not compared, since they cannot be read: scenes/broken.lts"), "{}", twin.err);

    let argued = CLEAN.replace("LDE", "LDDDDE").replace("]\n}", "]\n    similar: [(\"one\", \"a draft\")]\n}");
    let argued = draft("argued", &argued);
    assert!(argued.out.contains("very near, argued") && argued.out.contains("argued by \"a draft\""), "{}", argued.out);

    let new = CLEAN.replace("LDE", "LSE").replace("A.", "Mirrors.").replace("diffuse(0.5)", "mirror(0.9)");
    let new = draft("new", &new);
    assert!(new.out.contains("no scene is near: `new` is new"), "{}", new.out);
    assert_eq!(answer(folder, "new.lts")["verdict"], "new");

    let silent = draft("silent", &CLEAN.replace("    paths: [\"LDE\"]\n", ""));
    assert!(silent.out.contains("names no light paths"), "{}", silent.out);

    // A draft of a scene that is there already is not held against it.
    fs::create_dir(folder.join("drafts")).expect("a folder");
    fs::write(folder.join("drafts/one.lts"), CLEAN.replace("NAME", "one")).expect("a write");
    let names: Vec<Value> = answer(folder, "drafts/one.lts")["scenes"].as_array().expect("scenes").clone();
    assert!(names.iter().all(|other| other["name"] != "one") && names.len() == 1, "{names:?}");

    let bad = run(ltsc().current_dir(folder).args(["similar", "scenes/broken.lts"]));
    assert!(bad.code == Some(3) && bad.err.contains("unknown-name"), "{}", bad.err);
    fs::write(folder.join("library.lts"), "lts 1\n\nlet x = 1\n").expect("a write");
    let library = run(ltsc().current_dir(folder).args(["similar", "library.lts"]));
    assert!(library.code == Some(3) && library.err.contains("is a library"), "{}", library.err);
}
