//! PNG (ISO/IEC 15948): the header, the chunks that speak about colors, and the pixels.

use std::io::Cursor as Reader;

use super::{Cursor, ImageError, Pixels, Remark};

/// Chunks by which programs may change what the numbers mean, or that some draw and others do not. Without them the numbers mean
/// what `encoding` says.
const MEANING: &[&[u8; 4]] =
    &[b"gAMA", b"cHRM", b"sRGB", b"iCCP", b"cICP", b"eXIf", b"tRNS", b"acTL", b"fcTL", b"fdAT", b"mDCV", b"cLLI"];

/// How far a gamma may be from that of screens, in the 1/100000 of the file: `sRGB` is said as 1/2.2, rounded up or down.
const SAME_GAMMA: u32 = 1000;

/// The primaries and the white of Rec. 709 in the 1/100000 of the file, and how far files round them.
const REC_709: [u32; 8] = [31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000];
const SAME_PLACE: u32 = 200;

/// A file that has been read.
pub(super) struct Png {
    pub pixels: Pixels,
    /// 8 or 16.
    pub bits: u8,
    /// The file without what speaks about colors; none if the pixels have to be written anew.
    pub plain: Option<Vec<u8>>,
    pub remarks: Vec<Remark>,
}

/// Width and height, after the structure of the file was looked at.
pub(super) fn size(bytes: &[u8]) -> Result<[u32; 2], ImageError> {
    scan(bytes).map(|(size, _, _)| size)
}

/// Size, whether all pixels lie there in the order of rows as grey or RGB of 8 or 16 bits, and the chunks.
#[allow(clippy::type_complexity, reason = "used twice, here")]
fn scan(bytes: &[u8]) -> Result<([u32; 2], bool, Vec<([u8; 4], &[u8])>), ImageError> {
    let mut cursor = Cursor::new(bytes, 8);
    let mut info = None;
    let mut chunks = Vec::new();
    let mut pixels = false;
    loop {
        let start = cursor.at;
        let length = u32::from_be_bytes(cursor.array()?) as usize;
        let kind: [u8; 4] = cursor.array()?;
        let data = cursor.take(length)?;
        let _checksum: [u8; 4] = cursor.array()?;
        let place = || format!("the chunk at byte {start}");
        match (&kind, info) {
            (b"IHDR", None) => info = Some(header(data, place())?),
            (b"IHDR", Some(_)) => return Err(ImageError::new("has two headers", place())),
            (_, None) => return Err(ImageError::new("does not begin with its header", place())),
            (b"IDAT", Some(_)) => pixels = true,
            (b"IEND", Some((size, simple))) if pixels => return Ok((size, simple, chunks)),
            (b"IEND", Some(_)) => return Err(ImageError::new("has no pixels", place())),
            (_, Some(_)) => {}
        }
        if MEANING.contains(&&kind) {
            chunks.push((kind, data));
        }
    }
}

fn header(data: &[u8], place: String) -> Result<([u32; 2], bool), ImageError> {
    let [w0, w1, w2, w3, h0, h1, h2, h3, depth, color, compression, filter, interlace] = *data else {
        return Err(ImageError::new("has a header of another length than 13 bytes", place));
    };
    // Grey, color, palette, grey with alpha, color with alpha, with the depths that the standard allows them.
    let depths: &[u8] = match color {
        0 => &[1, 2, 4, 8, 16],
        2 | 4 | 6 => &[8, 16],
        3 => &[1, 2, 4, 8],
        _ => return Err(ImageError::new(format!("has the unknown color type {color}"), place)),
    };
    if !depths.contains(&depth) {
        return Err(ImageError::new(format!("has {depth} bits of color type {color}"), place));
    }
    if compression != 0 || filter != 0 || interlace > 1 {
        return Err(ImageError::new("is packed in an unknown way", place));
    }
    let simple = matches!(color, 0 | 2) && depth >= 8 && interlace == 0;
    Ok(([u32::from_be_bytes([w0, w1, w2, w3]), u32::from_be_bytes([h0, h1, h2, h3])], simple))
}

pub(super) fn load(bytes: &[u8]) -> Result<Png, ImageError> {
    let fault = |error: png::DecodingError| ImageError::new("is damaged", error.to_string());
    let (_, simple, chunks) = scan(bytes)?;
    let mut decoder = png::Decoder::new(Reader::new(bytes));
    // Palettes become colors, transparent ones an alpha, and depths below 8 bits 8 bits.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(fault)?;
    let profile = reader.info().icc_profile.as_deref().map(is_srgb);
    let size = reader.output_buffer_size().ok_or_else(|| ImageError::new("has too many pixels", "in its header"))?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(fault)?;
    data.truncate(frame.buffer_size());
    let all = match frame.color_type {
        png::ColorType::Grayscale | png::ColorType::Indexed => 1,
        png::ColorType::GrayscaleAlpha => 2,
        png::ColorType::Rgb => 3,
        png::ColorType::Rgba => 4,
    };
    let deep = frame.bit_depth == png::BitDepth::Sixteen;
    let number = |at: usize| match deep {
        true => f32::from(u16::from_be_bytes([data[2 * at], data[2 * at + 1]])) / 65_535.0,
        false => f32::from(data[at]) / 255.0,
    };
    let (width, height) = (frame.width as usize, frame.height as usize);
    let channels = if all < 3 { 1 } else { 3 };
    let count = width * height * all;
    let mut values = Vec::with_capacity(width * height * channels);
    let mut opaque = true;
    for start in (0..count).step_by(all) {
        values.extend((start..start + channels).map(number));
        opaque &= channels == all || number(start + channels) == 1.0;
    }
    let mut remarks = Vec::new();
    if !opaque {
        remarks.push(Remark::alpha());
    }
    let srgb = chunks.iter().any(|(kind, _)| kind == b"sRGB");
    for (kind, data) in &chunks {
        let what = match (kind, *data) {
            (b"gAMA", [a, b, c, d]) if !srgb => {
                let gamma = u32::from_be_bytes([*a, *b, *c, *d]);
                (gamma.abs_diff(45_455) > SAME_GAMMA).then(|| format!("a gamma of {}", f64::from(gamma) / 100_000.0))
            }
            (b"cHRM", places) if !srgb => {
                let places =
                    places.chunks_exact(4).map(|part| part.iter().fold(0, |sum, byte| sum << 8 | u32::from(*byte)));
                let off = places.zip(REC_709).any(|(place, wanted)| place.abs_diff(wanted) > SAME_PLACE);
                off.then(|| "primaries of its own".to_owned())
            }
            (b"iCCP", _) if profile != Some(true) => Some("a color profile".to_owned()),
            // Primaries and curve of sRGB, as numbers that are not reordered.
            (b"cICP", places) => (*places != [1, 13, 0, 1]).then(|| "a color space".to_owned()),
            (b"eXIf", data) => super::turned(data).then(|| super::ORIENTATION.to_owned()),
            (b"acTL", _) => Some(super::FRAMES.to_owned()),
            _ => None,
        };
        remarks.extend(what.map(|what| Remark::unread(&what)));
    }
    let plain = simple && chunks.iter().all(|(kind, _)| kind != b"tRNS");
    let plain = plain.then(|| if chunks.is_empty() { bytes.to_vec() } else { without(bytes) });
    Ok(Png { pixels: Pixels { width, height, channels, values }, bits: if deep { 16 } else { 8 }, plain, remarks })
}

/// The file without the chunks of [`MEANING`]; its structure has been looked at.
fn without(bytes: &[u8]) -> Vec<u8> {
    let mut kept = bytes[..8].to_vec();
    let mut at = 8;
    while let Some([a, b, c, d]) = bytes.get(at..at + 4) {
        let end = (at + 12).saturating_add(u32::from_be_bytes([*a, *b, *c, *d]) as usize);
        let Some(chunk) = bytes.get(at..end) else { break };
        if !MEANING.iter().any(|kind| chunk[4..8] == **kind) {
            kept.extend(chunk);
        }
        at = end;
    }
    kept
}

/// Whether a color profile calls itself one of sRGB.
pub(super) fn is_srgb(profile: &[u8]) -> bool {
    let wide: Vec<u8> = "sRGB".bytes().flat_map(|byte| [0, byte]).collect();
    profile.windows(4).any(|part| part == b"sRGB") || profile.windows(8).any(|part| part == wide)
}
