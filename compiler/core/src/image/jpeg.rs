//! JPEG (ITU-T T.81): the markers up to the first scan.

use super::{Cursor, ImageError};
use crate::ir::{ImageFormat, ImageInfo};

pub(super) fn read(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let mut cursor = Cursor::new(bytes, 2);
    let mut info = None;
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
        match kind {
            // Baseline, extended and progressive, all by Huffman's code.
            0xc0..=0xc2 => info = Some(frame(data, place())?),
            // Tables and restarts are no frames.
            0xc4 | 0xc8 | 0xcc => {}
            0xc3..=0xcf => {
                return Err(ImageError::new("is a lossless, hierarchical or arithmetic JPEG", place())
                    .help("renderers read baseline and progressive JPEG; save it as one of these, or as PNG"));
            }
            0xda => {
                let info = info.ok_or_else(|| ImageError::new("has pixels before its header", place()))?;
                if cursor.at >= bytes.len() {
                    return Err(ImageError::cut(format!("byte {}", cursor.at)));
                }
                return Ok(info);
            }
            _ => {}
        }
    }
}

fn frame(data: &[u8], place: String) -> Result<ImageInfo, ImageError> {
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
    Ok(ImageInfo {
        format: ImageFormat::Jpeg,
        width: side(w0, w1),
        height: side(h0, h1),
        channels: components,
        bits: 8,
    })
}
