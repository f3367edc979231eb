//! Writes OpenEXR: linear 32-bit float RGB, ZIP blocks of 16 rows, provenance in the header.

use std::io::{Cursor, Write};
use std::path::Path;

use exr::image::Encoding;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, FlatSamples, Image as ExrImage, Layer, LayerAttributes, LineOrder,
    WritableImage, f16,
};

use super::attributes::{PROLOGUE, scan};
use super::{Image, ImageError, MAX_SIDE, Provenance};
use crate::cache::replace_file;

/// Rows in a block of ZIP compression (OpenEXR file layout).
const ZIP_ROWS: usize = 16;

/// Writes the image with its provenance. The file appears under its name only when it is whole,
/// and equal arguments give equal bytes.
///
/// # Errors
/// Gives an error if the image is empty or too large, or the folder cannot be written to.
pub fn write_exr(path: &Path, image: &Image, provenance: &Provenance) -> Result<(), ImageError> {
    let bytes = exr_bytes(path, image, provenance)?;
    replace_file(path, |file| file.write_all(&bytes)).map_err(|source| ImageError::Io { path: path.to_owned(), source })
}

/// The bytes of the file that [`write_exr`] writes; `path` is for the error.
///
/// # Errors
/// If the image cannot be stored.
pub fn exr_bytes(path: &Path, image: &Image, provenance: &Provenance) -> Result<Vec<u8>, ImageError> {
    encode(&[("", image)], provenance, Numbers::Single)
        .map_err(|message| ImageError::Unwritable { path: path.to_owned(), message })
}

/// The bytes of a file of several images of one size: each has a prefix to its channels `R`, `G` and `B`, such as `variance.`, and the
/// picture itself none. `path` is for the error.
///
/// # Errors
/// If the images cannot be stored.
pub fn layered_bytes(path: &Path, layers: &[(&str, &Image)], provenance: &Provenance) -> Result<Vec<u8>, ImageError> {
    encode(layers, provenance, Numbers::Single)
        .map_err(|message| ImageError::Unwritable { path: path.to_owned(), message })
}

/// The same in half floats: 11 significant bits, from 6e-8 to 65504. What is larger becomes infinite.
///
/// # Errors
/// If the images cannot be stored.
pub fn half_bytes(path: &Path, layers: &[(&str, &Image)], provenance: &Provenance) -> Result<Vec<u8>, ImageError> {
    encode(layers, provenance, Numbers::Half)
        .map_err(|message| ImageError::Unwritable { path: path.to_owned(), message })
}

/// The nearest half float, as [`half_bytes`] stores it.
#[must_use]
pub fn as_half(value: f32) -> f32 {
    f16::from_f32(value).to_f32()
}

/// The bytes of a file that is read at the speed of memory: not packed. Noise packs by 2 % only.
///
/// # Errors
/// If the image cannot be stored.
pub fn plain_bytes(path: &Path, image: &Image, provenance: &Provenance) -> Result<Vec<u8>, ImageError> {
    encode(&[("", image)], provenance, Numbers::Plain)
        .map_err(|message| ImageError::Unwritable { path: path.to_owned(), message })
}

/// How numbers are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Numbers {
    /// 32 bits, not packed.
    Plain,
    /// 32 bits.
    Single,
    /// 16 bits.
    Half,
}

fn encode(layers: &[(&str, &Image)], provenance: &Provenance, numbers: Numbers) -> Result<Vec<u8>, String> {
    let (width, height) = layers.first().map_or((0, 0), |(_, image)| (image.width, image.height));
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("{width}x{height} pixels cannot be stored"));
    }
    let fits = |image: &Image| (image.width, image.height) == (width, height) && image.pixels.len() == width * height;
    if !layers.iter().all(|(_, image)| fits(image)) {
        return Err("the number of pixels does not fit the size".to_owned());
    }
    let channel = |prefix: &str, image: &Image, at: usize| {
        let samples = image.pixels.iter().map(|pixel| pixel[at]);
        let samples = match numbers {
            Numbers::Single | Numbers::Plain => FlatSamples::F32(samples.collect()),
            Numbers::Half => FlatSamples::F16(samples.map(f16::from_f32).collect()),
        };
        AnyChannel::new(format!("{prefix}{}", ["R", "G", "B"][at]).as_str(), samples)
    };
    let all = layers.iter().flat_map(|(prefix, image)| [0, 1, 2].map(|at: usize| channel(prefix, image, at)));
    let channels = AnyChannels::sort(all.collect());
    let encoding = Encoding {
        compression: if numbers == Numbers::Plain { Compression::Uncompressed } else { Compression::ZIP16 },
        blocks: exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, height), LayerAttributes::default(), encoding, channels);
    let mut plain = Cursor::new(Vec::new());
    ExrImage::from_layer(layer)
        .write()
        // Blocks end up in the order of their rows, whatever the machine.
        .non_parallel()
        .to_buffered(&mut plain)
        .map_err(|error| error.to_string())?;
    let rows = if numbers == Numbers::Plain { 1 } else { ZIP_ROWS };
    insert(&plain.into_inner(), &provenance.attributes(), height.div_ceil(rows))
}

/// Puts string attributes in front of those of the encoder, which keeps them in a hash map and so
/// would write them in another order each time, and moves the offsets of the blocks along.
fn insert(plain: &[u8], attributes: &[(String, String)], blocks: usize) -> Result<Vec<u8>, String> {
    let mut added = Vec::new();
    for (name, value) in attributes {
        // 31 bytes are the limit of files without the flag for long names.
        if name.is_empty() || name.len() > 31 || name.contains('\0') {
            return Err(format!("`{name}` cannot be the name of an attribute"));
        }
        let length = i32::try_from(value.len()).map_err(|_| format!("`{name}` is too long"))?;
        added.extend_from_slice(name.as_bytes());
        added.extend_from_slice(b"\0string\0");
        added.extend_from_slice(&length.to_le_bytes());
        added.extend_from_slice(value.as_bytes());
    }
    let wrong = || "the encoder wrote another layout than was asked for".to_owned();
    let (_, table) = scan(plain).map_err(|_| wrong())?;
    let end = table + 8 * blocks;
    let offsets = plain.get(table..end).ok_or_else(wrong)?;
    let mut whole = Vec::with_capacity(plain.len() + added.len());
    whole.extend_from_slice(&plain[..PROLOGUE]);
    whole.extend_from_slice(&added);
    whole.extend_from_slice(&plain[PROLOGUE..table]);
    for (index, offset) in offsets.chunks_exact(8).enumerate() {
        let offset = u64::from_le_bytes(offset.try_into().map_err(|_| wrong())?);
        if index == 0 && offset != end as u64 {
            return Err(wrong());
        }
        whole.extend_from_slice(&(offset + added.len() as u64).to_le_bytes());
    }
    whole.extend_from_slice(&plain[end..]);
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::super::{decode, read};
    use super::*;

    fn encode(layers: &[(&str, &Image)], provenance: &Provenance) -> Result<Vec<u8>, String> {
        super::encode(layers, provenance, Numbers::Single)
    }

    fn provenance() -> Provenance {
        Provenance {
            scene: "cbox".to_owned(),
            scene_hash: "00ff".to_owned(),
            version: "0.1.0".to_owned(),
            renderer: "mitsuba-3".to_owned(),
            renderer_version: "3.9.1".to_owned(),
            samples: 64,
            seed: 7,
            seconds: 1.5,
            extra: vec![("note".to_owned(), "größer als 8 Bit".to_owned())],
        }
    }

    /// An image of several blocks, with values that a half float could not hold.
    fn picture() -> Image {
        let pixels = (0..5 * 37).map(|i| [i as f32 * 1.000_1, -1e-30, 3.0e38]).collect();
        Image { width: 5, height: 37, pixels }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image.exr");
        write_exr(&path, &picture(), &provenance()).expect("write");
        let (image, attributes) = read(&path).expect("read");
        assert_eq!(image, picture());
        assert_eq!(Provenance::from_attributes(&attributes), provenance());
        assert_eq!(attributes[0].0, "ltsc:note");
        // The decoder checks every attribute and offset in its strict mode.
        exr::meta::MetaData::read_from_file(&path, true).expect("a valid header");
    }

    #[test]
    fn half_floats_have_eleven_bits_and_an_end() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image.exr");
        let image = Image { width: 2, height: 1, pixels: vec![[1.0, 1.000_3, 65_504.0], [6e-8, 1e-8, 7e4]] };
        let error = Image::filled(2, 1, [0.25, 1e-6, -0.0]);
        let bytes = half_bytes(&path, &[("", &image), ("error.", &error)], &provenance()).expect("encode");
        std::fs::write(&path, bytes).expect("write");
        let (read, layer, attributes) = super::super::read_layered(&path, "error.").expect("read");
        assert_eq!(read.pixels, image.pixels.iter().map(|pixel| pixel.map(as_half)).collect::<Vec<_>>());
        assert_eq!(read.pixels[0], [1.0, 1.0, 65_504.0]);
        assert_eq!(read.pixels[1], [5.960_464_5e-8, 0.0, f32::INFINITY]);
        let layer = layer.expect("the layer");
        // Below 6.1e-5 steps of 6e-8 are left: 3 % here.
        assert!(layer.pixels[0][0] == 0.25 && (layer.pixels[0][1] / 1e-6 - 1.0).abs() < 0.03, "{layer:?}");
        assert_eq!(Provenance::from_attributes(&attributes), provenance());
        assert_eq!(super::super::read_layered(&path, "variance.").expect("read").1, None);
    }

    #[test]
    fn the_picture_of_several_layers_is_the_one_without_a_prefix() {
        let other = Image { pixels: vec![[7.0; 3]; 5 * 37], ..picture() };
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image.exr");
        let bytes = layered_bytes(&path, &[("", &picture()), ("variance.", &other)], &provenance()).expect("encode");
        std::fs::write(&path, &bytes).expect("write");
        let (image, attributes) = read(&path).expect("read");
        assert!(image == picture() && Provenance::from_attributes(&attributes) == provenance());
        assert_eq!(super::super::attributes(&path).expect("a header"), attributes);
        let meta = exr::meta::MetaData::read_from_file(&path, true).expect("a valid header");
        let names: Vec<String> = meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R", "variance.B", "variance.G", "variance.R"]);
        let small = Image::filled(1, 1, [0.0; 3]);
        assert!(layered_bytes(&path, &[("", &picture()), ("variance.", &small)], &provenance()).is_err());
    }

    #[test]
    fn equal_images_are_equal_files() {
        let encode = || encode(&[("", &picture())], &provenance()).expect("encode");
        let first = encode();
        assert!((0..8).all(|_| encode() == first));
    }

    #[test]
    fn values_that_are_not_finite_survive() {
        let mut image = picture();
        image.pixels[3] = [f32::NAN, f32::INFINITY, 0.0];
        let bytes = encode(&[("", &image)], &Provenance::default()).expect("encode");
        let (back, _, _) = decode(&bytes).map_err(|fault| fault.message).expect("decode");
        assert_eq!(back.non_finite(), 1);
        assert!(back.pixels[3][0].is_nan());
    }

    #[test]
    fn impossible_images_and_names_are_refused() {
        let empty = Image { width: 0, height: 3, pixels: Vec::new() };
        assert!(encode(&[("", &empty)], &Provenance::default()).is_err());
        let short = Image { width: 2, height: 3, pixels: vec![[0.0; 3]] };
        assert!(encode(&[("", &short)], &Provenance::default()).is_err());
        let extra = vec![("x".repeat(40), "1".to_owned())];
        let long = Provenance { extra, ..Provenance::default() };
        assert!(encode(&[("", &picture())], &long).is_err());
    }

    #[test]
    fn no_cut_and_no_flipped_byte_makes_the_reader_panic() {
        let whole = encode(&[("", &picture())], &provenance()).expect("encode");
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
        for at in 0..whole.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                // Some changes only change a value.
                let _ = decode(&bytes);
            }
        }
    }

    #[test]
    fn a_huge_claim_is_refused_before_memory_is_taken() {
        let whole = encode(&[("", &picture())], &Provenance::default()).expect("encode");
        let name = b"dataWindow\0box2i\0";
        let at = whole.windows(name.len()).position(|window| window == name).expect("the window");
        let corner = at + name.len() + 4 + 8;
        for (width, height) in [(60_000, 37), (i32::MAX - 1, 37), (5, 60_000), (60_000, 60_000)] {
            let mut bytes = whole.clone();
            bytes[corner..corner + 4].copy_from_slice(&i32::to_le_bytes(width - 1));
            bytes[corner + 4..corner + 8].copy_from_slice(&i32::to_le_bytes(height - 1));
            let fault = decode(&bytes).err().map(|fault| fault.message);
            let message = fault.expect("refused");
            assert!(message.contains("claims") || message.contains("window"), "{message}");
        }
    }
}
