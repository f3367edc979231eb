//! OpenEXR (openexr.com, "OpenEXR File Layout"): the attributes of the header.

use super::{Cursor, ImageError};
use crate::ir::{ImageFormat, ImageInfo};

pub(super) fn read(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let mut cursor = Cursor::new(bytes, 4);
    let version = u32::from_le_bytes(cursor.array()?);
    if version & 0xff != 2 {
        return Err(ImageError::new(format!("has version {} of OpenEXR", version & 0xff), "byte 4"));
    }
    // Bits 11 and 12: deep pixels, several parts.
    if version & 0x1800 != 0 {
        return Err(ImageError::new("is a deep image or one of several parts", "byte 4")
            .help("save one flat image: many renderers read nothing else"));
    }
    let mut channels = None;
    let mut window = None;
    loop {
        let start = cursor.at;
        let name = cursor.text(255)?;
        if name.is_empty() {
            break;
        }
        let kind = cursor.text(255)?;
        let size = u32::from_le_bytes(cursor.array()?) as usize;
        let data = cursor.take(size)?;
        let place = format!("the attribute at byte {start}");
        match (name, kind) {
            (b"channels", b"chlist") => channels = Some(channel_list(data, place)?),
            (b"dataWindow", b"box2i") => window = Some(extent(data, place)?),
            _ => {}
        }
    }
    let (Some((channels, bits)), Some((width, height))) = (channels, window) else {
        return Err(ImageError::new("has no channels or no size", "in its header"));
    };
    if cursor.at >= bytes.len() {
        return Err(ImageError::cut(format!("byte {}", cursor.at)));
    }
    Ok(ImageInfo { format: ImageFormat::Exr, width, height, channels, bits })
}

/// Count of the channels that a texture has, and their bits.
fn channel_list(data: &[u8], place: String) -> Result<(u8, u8), ImageError> {
    let mut cursor = Cursor::new(data, 0);
    let mut names: Vec<&[u8]> = Vec::new();
    let mut bits = 16;
    loop {
        let name = cursor.text(255)?;
        if name.is_empty() {
            break;
        }
        // Type (0 whole numbers, 1 half, 2 float), linear, reserved, sampling along x and y.
        let kind = u32::from_le_bytes(cursor.array()?);
        let _linear: [u8; 4] = cursor.array()?;
        let sampling: [u8; 8] = cursor.array()?;
        if [&b"R"[..], b"G", b"B", b"A", b"Y"].contains(&name) {
            if kind != 1 && kind != 2 {
                return Err(ImageError::new("has channels of whole numbers", place).help("save it as half or float"));
            }
            if sampling != [1, 0, 0, 0, 1, 0, 0, 0] {
                return Err(ImageError::new("has channels of fewer pixels", place).help("save it as RGB"));
            }
            bits = bits.max(if kind == 2 { 32 } else { 16 });
            names.push(name);
        }
    }
    let has = |name: &[u8]| names.contains(&name);
    let alpha = u8::from(has(b"A"));
    let color = has(b"R") && has(b"G") && has(b"B");
    if color || has(b"Y") {
        Ok((if color { 3 } else { 1 } + alpha, bits))
    } else {
        Err(ImageError::new("has no channels R, G and B, and no Y", place)
            .help("save the image without layers: channels are looked up by these names"))
    }
}

/// Width and height of a box of pixels.
fn extent(data: &[u8], place: String) -> Result<(u32, u32), ImageError> {
    let mut cursor = Cursor::new(data, 0);
    let mut corner = || cursor.array().map(i32::from_le_bytes).map(i64::from);
    let (x0, y0, x1, y1) = (corner()?, corner()?, corner()?, corner()?);
    let side = |low: i64, high: i64| u32::try_from(high - low + 1).ok().filter(|side| *side > 0);
    match (side(x0, x1), side(y0, y1)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(ImageError::new("has no pixels", place)),
    }
}
