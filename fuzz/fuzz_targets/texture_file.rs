//! Any bytes give an image whose pixels are there, finite and at least 0, or an error. The first byte chooses the format.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::image::{linear, load, stored};
use ltsc_core::ir::{Encoding, Texture};

const ENDINGS: [&str; 6] = ["png", "jpg", "jpeg", "exr", "pfm", "hdr"];

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let ending = ENDINGS[usize::from(*first) % ENDINGS.len()];
    let Ok(loaded) = load(ending, bytes, 1 << 22) else { return };
    let float = loaded.info.format.is_float();
    let encoding = if float { Encoding::Linear } else { Encoding::Srgb };
    let texture = Texture {
        name: String::new(),
        file: loaded.file,
        image: loaded.info,
        encoding,
        peak: loaded.peak,
        factor: [1.0; 3],
    };
    let pixels = stored(&texture).expect("what is loaded is read again");
    let size = texture.image.width as usize * texture.image.height as usize;
    assert_eq!(pixels.values.len(), size * pixels.channels);
    let pixels = linear(&texture).expect("what is loaded is made linear");
    assert!(pixels.values.iter().all(|value| value.is_finite() && *value >= 0.0));
});
