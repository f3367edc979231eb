//! The thesis's scenes, which it has for Mitsuba and for PBRT.

use std::path::PathBuf;

use super::*;
use crate::files::{Bytes, Files, ReadError};

/// Files below a folder.
struct Folder(PathBuf);

impl Files for Folder {
    fn read(&self, path: &VPath, _limit: u64) -> Result<Bytes, ReadError> {
        std::fs::read(self.0.join(path.as_str())).map(Bytes::new).map_err(|error| ReadError::Other(error.to_string()))
    }
}

/// Where they are: beside the checkout, or beside the folder around it.
fn corpus() -> Option<PathBuf> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().map(|folder| folder.join("shared/corpus/lteval")).find(|folder| folder.is_dir())
}

fn imported(folder: &std::path::Path, name: &str) -> Read {
    let path = VPath::resolve("", name).expect("a path");
    let mut sources = Sources::default();
    let files = Folder(folder.to_path_buf());
    let found = import(find(&path).expect("an importer"), &files, &mut sources, &path, &Options::default());
    Read { scene: found.scene, findings: found.findings, sources }
}

/// Number, radiance and place of all that emits, sorted.
fn emitters(scene: &Scene) -> Vec<String> {
    let shown = |shape: &Shape| {
        let emission = shape.emission.as_ref()?;
        let place = shape.transform.point([0.0; 3]).map(|x| (x * 1e3).round());
        Some(format!("{:?} {place:?}", emission.radiance.rgb().map(|x| (x * 1e6).round() / 1e6)))
    };
    let mut all: Vec<String> = scene.shapes.values().filter_map(shown).collect();
    all.sort();
    all
}

/// The materials that are used, by what they do.
fn materials(scene: &Scene) -> Vec<String> {
    let mut all: Vec<String> = scene.materials.values().map(|material| material.bsdf.word().to_owned()).collect();
    all.sort();
    all
}

#[test]
fn both_versions_of_a_scene_are_one() {
    let Some(corpus) = corpus() else {
        println!("skipped: the thesis's scenes (needs ../shared/corpus/lteval)");
        return;
    };
    let mut scenes: Vec<PathBuf> =
        std::fs::read_dir(corpus).expect("a folder").filter_map(|entry| Some(entry.ok()?.path())).collect();
    scenes.retain(|scene| scene.is_dir());
    scenes.sort();
    assert_eq!(scenes.len(), 11);
    for folder in scenes {
        let (ours, theirs) = (imported(&folder, "pbrt_3/scene.pbrt"), imported(&folder, "mitsuba_0_5/scene.xml"));
        let bad = |finding: &&Finding| finding.id == "loss-dropped" || finding.severity > Severity::Warn;
        assert_eq!(ours.findings.iter().find(bad).map(|finding| &finding.message), None, "{folder:?}");
        let (a, b) = (ours.camera(), theirs.camera());
        let (forward, other) = (a.axes().expect("axes"), b.axes().expect("axes"));
        assert!(close(&a.eye, &b.eye) && (a.fov_x - b.fov_x).abs() < 1e-6, "{folder:?} {a:?} {b:?}");
        assert!(close(&forward.forward, &other.forward) && close(&forward.up, &other.up), "{folder:?} {a:?} {b:?}");
        assert!(close(&forward.right, &other.right), "{folder:?} {a:?} {b:?}");
        assert!(crate::pipeline::prepare(ours.scene().clone()).is_ok());
        let (ours, theirs) = (ours.scene(), theirs.scene());
        assert_eq!((ours.film.width, ours.film.height), (theirs.film.width, theirs.film.height), "{folder:?}");
        assert_eq!(ours.film.filter, theirs.film.filter, "{folder:?}");
        assert_eq!(ours.integrator, theirs.integrator, "{folder:?}");
        assert_eq!(ours.shapes.len(), theirs.shapes.len(), "{folder:?}");
        assert_eq!(ours.instances.len(), theirs.instances.len(), "{folder:?}");
        let inner = |scene: &Scene| scene.groups.values().map(|group| group.shapes.len()).collect::<Vec<_>>();
        assert_eq!(inner(ours), inner(theirs), "{folder:?}");
        assert_eq!(materials(ours), materials(theirs), "{folder:?}");
        assert_eq!(emitters(ours), emitters(theirs), "{folder:?}");
    }
}
