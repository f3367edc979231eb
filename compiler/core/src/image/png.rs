//! PNG (ISO/IEC 15948): the chunks from IHDR to IEND.

use super::{Cursor, ImageError};
use crate::ir::{ImageFormat, ImageInfo};

pub(super) fn read(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let mut cursor = Cursor::new(bytes, 8);
    let mut info = None;
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
            (b"IEND", Some(info)) if pixels => return Ok(info),
            (b"IEND", Some(_)) => return Err(ImageError::new("has no pixels", place())),
            (_, Some(_)) => {}
        }
    }
}

fn header(data: &[u8], place: String) -> Result<ImageInfo, ImageError> {
    let [w0, w1, w2, w3, h0, h1, h2, h3, depth, color, compression, filter, interlace] = *data else {
        return Err(ImageError::new("has a header of another length than 13 bytes", place));
    };
    // Grey, colour, palette, grey with alpha, colour with alpha, with the depths that the standard allows them.
    let (channels, depths): (u8, &[u8]) = match color {
        0 => (1, &[1, 2, 4, 8, 16]),
        2 => (3, &[8, 16]),
        3 => (3, &[1, 2, 4, 8]),
        4 => (2, &[8, 16]),
        6 => (4, &[8, 16]),
        _ => return Err(ImageError::new(format!("has the unknown colour type {color}"), place)),
    };
    if !depths.contains(&depth) {
        return Err(ImageError::new(format!("has {depth} bits of colour type {color}"), place));
    }
    if compression != 0 || filter != 0 || interlace > 1 {
        return Err(ImageError::new("is packed in an unknown way", place));
    }
    Ok(ImageInfo {
        format: ImageFormat::Png,
        width: u32::from_be_bytes([w0, w1, w2, w3]),
        height: u32::from_be_bytes([h0, h1, h2, h3]),
        channels,
        bits: depth.max(8),
    })
}
