//! Any bytes give a mesh, and parts, that pass their own check, or an error. The first byte chooses the format.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::mesh::file::{EXTENSIONS, alone, parts, read, read_parts};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let extension = EXTENSIONS[usize::from(*first) % EXTENSIONS.len()];
    if let Ok((geometry, _)) = read(extension, bytes, None, &mut alone) {
        geometry.check().expect("what is read is consistent");
        let names = parts(extension, bytes).expect("a file that is read has parts that are read");
        for name in names.iter().take(3) {
            let _may_be_empty = read(extension, bytes, Some(name), &mut alone);
        }
    }
    // The text that follows a mesh stands for its material library.
    let mut beside = |_: &str| Ok(Box::new(bytes.to_vec()) as Box<dyn AsRef<[u8]>>);
    if let Ok((model, _)) = read_parts(extension, bytes, &mut beside) {
        assert!(!model.parts.is_empty());
        for (_, geometry) in &model.meshes {
            geometry.check().expect("what is read is consistent");
        }
        for part in &model.parts {
            assert!(part.mesh < model.meshes.len() && part.surface.is_none_or(|at| at < model.surfaces.len()));
        }
    }
});
