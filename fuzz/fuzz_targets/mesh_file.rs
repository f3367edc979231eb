//! Any bytes give a mesh that passes its own check, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::mesh::file::{EXTENSIONS, read};

fuzz_target!(|bytes: &[u8]| {
    for extension in EXTENSIONS {
        if let Ok((geometry, _)) = read(extension, bytes, None) {
            geometry.check().expect("what is read is consistent");
        }
    }
});
