//! Any scene gives findings or files for every target.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::{Limits, Overrides};
use ltsc_core::files::{MemoryFiles, MemorySink, VPath};
use ltsc_core::formats::{Choices, TARGETS};
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline::{Options, camera, check, emit_alone, prepare};

fuzz_target!(|text: &str| {
    let mut files = MemoryFiles::default();
    files.insert("fuzz.lts", text);
    let path = VPath::resolve("", "fuzz.lts").expect("a path");
    // Small limits keep each run short; the same code refuses what is larger.
    let limits = Limits { list: 10_000, steps: 100_000, triangles: 100_000, instances: 10_000, ..Limits::default() };
    let options = Options { overrides: Overrides { limits, ..Overrides::default() }, ..Options::default() };
    let checked = check(&files, &mut Sources::default(), &path, &options);
    let worst = checked.worst();
    let Some(scene) = checked.scene else {
        assert!(worst == Severity::Error || checked.library, "no scene and no reason");
        return;
    };
    let triangles: usize = scene.meshes.values().map(|mesh| mesh.triangles.len()).sum();
    if triangles > 10_000 {
        return;
    }
    let Ok((scene, _)) = prepare(scene) else { return };
    let places: usize = scene.instances.values().map(|instance| instance.places.maps().len()).sum();
    if scene.shapes.len() + places > 10_000 {
        return;
    }
    let camera = camera(&scene, None).expect("a valid scene has a camera");
    for target in TARGETS {
        emit_alone(&scene, camera, target, &Ledger::of(&scene, target, &[]), &Choices::default(), &mut MemorySink::default()).expect("memory takes everything");
    }
});
