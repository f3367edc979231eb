//! Any bytes give an image or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // The reader wants a file: images are read from disk.
    let folder = std::env::temp_dir().join(format!("ltsc-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    for ending in ["exr", "pfm"] {
        let path = folder.join(format!("image.{ending}"));
        std::fs::write(&path, bytes).expect("a file");
        if let Ok((image, _)) = ltsc_render::image::read(&path) {
            assert_eq!(image.pixels.len(), image.width * image.height);
        }
    }
});
