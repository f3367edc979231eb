//! JPEG (ITU-T T.81): the markers up to the first scan, and the pixels.

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{Cursor, ImageError, LONGEST_SIDE, Pixels, Remark};

/// What stands before the pixels.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub width: u32,
    pub height: u32,
    /// 1 or 3.
    pub channels: u8,
    /// Segments that speak about colors or about how the picture is turned, with what they say.
    spoken: Vec<(std::ops::Range<usize>, Option<&'static str>)>,
}

pub(super) fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    let mut cursor = Cursor::new(bytes, 2);
    let mut found: Option<Header> = None;
    let mut spoken = Vec::new();
    let mut profile = Vec::new();
    let mut plain = None;
    loop {
        let start = cursor.at;
        let place = || format!("the marker at byte {start}");
        if cursor.byte()? != 0xff {
            return Err(ImageError::new("has no marker where one is due", place()));
        }
        let mut kind = cursor.byte()?;
        // Any number of fill bytes may stand before a marker.
        while kind == 0xff {
            kind = cursor.byte()?;
        }
        if kind == 0xd9 {
            return Err(ImageError::new("ends before its pixels", place()));
        }
        let length = usize::from(u16::from_be_bytes(cursor.array()?));
        let data =
            cursor.take(length.checked_sub(2).ok_or_else(|| ImageError::new("has an empty marker", place()))?)?;
        let segment = start..cursor.at;
        match kind {
            // Baseline, extended and progressive, all by Huffman's code.
            0xc0..=0xc2 => found = Some(frame(data, place())?),
            // Tables and restarts are no frames.
            0xc4 | 0xc8 | 0xcc => {}
            0xc3..=0xcf => {
                return Err(ImageError::new("is a lossless, hierarchical or arithmetic JPEG", place())
                    .help("renderers read baseline and progressive JPEG; save it as one of these, or as PNG"));
            }
            0xe1 if data.starts_with(b"Exif\0\0") => {
                spoken.push((segment, super::turned(&data[6..]).then_some(super::ORIENTATION)));
            }
            0xe2 if data.starts_with(b"ICC_PROFILE\0") => {
                profile.extend_from_slice(data);
                spoken.push((segment, None));
            }
            // Adobe's marker, its last byte the transform: 0 for no luma and chroma.
            0xee if data.starts_with(b"Adobe") && data.get(11) == Some(&0) => plain = Some(place()),
            0xda => {
                let mut found = found.ok_or_else(|| ImageError::new("has pixels before its header", place()))?;
                if cursor.at >= bytes.len() {
                    return Err(ImageError::cut(format!("byte {}", cursor.at)));
                }
                if let Some(place) = plain.filter(|_| found.channels == 3) {
                    return Err(ImageError::new("holds red, green and blue instead of luma and chroma", place)
                        .help("save it as PNG: many renderers take every JPEG for luma and chroma"));
                }
                if let Some((_, what)) =
                    spoken.iter_mut().find(|_| !profile.is_empty() && !super::png::is_srgb(&profile))
                {
                    *what = what.or(Some("a color profile"));
                }
                found.spoken = spoken;
                return Ok(found);
            }
            _ => {}
        }
    }
}

fn frame(data: &[u8], place: String) -> Result<Header, ImageError> {
    let [precision, h0, h1, w0, w1, components, ..] = *data else {
        return Err(ImageError::new("has a header that is too short", place));
    };
    if precision != 8 {
        return Err(ImageError::new(format!("has {precision} bits per channel"), place).help("save it with 8 bits"));
    }
    if components != 1 && components != 3 {
        return Err(ImageError::new(format!("has {components} channels"), place)
            .help("save it as grey or as RGB: inks have no common meaning in renderers"));
    }
    let side = |high, low| u32::from(u16::from_be_bytes([high, low]));
    Ok(Header { width: side(w0, w1), height: side(h0, h1), channels: components, spoken: Vec::new() })
}

/// The pixels, and the file without segments that say something else than the numbers.
pub(super) fn load(bytes: &[u8]) -> Result<(Pixels, Vec<u8>, Vec<Remark>), ImageError> {
    let Header { width: _, height: _, channels, spoken } = header(bytes)?;
    let said: Vec<_> = spoken.iter().filter_map(|(_, what)| *what).collect();
    let plain = if said.is_empty() {
        bytes.to_vec()
    } else {
        let mut kept = Vec::with_capacity(bytes.len());
        let mut at = 0;
        for (segment, _) in &spoken {
            kept.extend_from_slice(&bytes[at..segment.start]);
            at = segment.end;
        }
        kept.extend_from_slice(&bytes[at..]);
        kept
    };
    let remarks = said.iter().map(|what| Remark::unread(what)).collect();
    Ok((pixels(bytes, channels)?, plain, remarks))
}

fn pixels(bytes: &[u8], channels: u8) -> Result<Pixels, ImageError> {
    let space = if channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    // Without fast paths: their rounding depends on the machine.
    let options = DecoderOptions::new_safe()
        .set_max_width(LONGEST_SIDE as usize)
        .set_max_height(LONGEST_SIDE as usize)
        .jpeg_set_out_colorspace(space);
    let fault = |error: zune_jpeg::errors::DecodeErrors| ImageError::new("is damaged", error.to_string());
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(fault)?;
    let data = decoder.decode().map_err(fault)?;
    let (width, height) = decoder.dimensions().ok_or_else(|| ImageError::new("has no pixels", "in its header"))?;
    let channels = usize::from(channels);
    if data.len() != width * height * channels {
        return Err(ImageError::new("has another number of pixels than its header says", "behind its header"));
    }
    let values = data.iter().map(|byte| f32::from(*byte) / 255.0).collect();
    Ok(Pixels { width, height, channels, values })
}
