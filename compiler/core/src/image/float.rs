//! Portable float maps, and Radiance's pictures.

use super::ImageError;
use crate::ir::{ImageFormat, ImageInfo};

/// The longest header that is looked at, in bytes.
const HEADER: usize = 4096;

/// A portable float map (Debevec): `PF` or `Pf`, width and height, a scale whose sign says the order of bytes.
pub(super) fn pfm(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut at = 2;
    let mut word = || {
        let head = &bytes[..bytes.len().min(HEADER)];
        let start = head.get(at..).unwrap_or_default().iter().position(|byte| !byte.is_ascii_whitespace())? + at;
        let end = head[start..].iter().position(u8::is_ascii_whitespace)? + start;
        at = end + 1;
        std::str::from_utf8(&head[start..end]).ok()
    };
    let (width, height, scale) = (word(), word(), word());
    let side = |word: Option<&str>| word.and_then(|word| word.parse::<u32>().ok());
    let scale = scale.and_then(|word| word.parse::<f64>().ok());
    let (Some(width), Some(height), Some(scale)) = (side(width), side(height), scale) else {
        return Err(ImageError::new("has no width, height and scale", "in its header"));
    };
    if scale.abs() != 1.0 {
        return Err(ImageError::new(format!("has the scale {scale}"), "in its header")
            .help("save it with scale 1 or -1: some renderers apply another one, some do not"));
    }
    let size = u64::from(width) * u64::from(height) * u64::from(channels) * 4;
    let there = (bytes.len() - at.min(bytes.len())) as u64;
    if there < size {
        return Err(ImageError::cut(format!("{there} bytes of pixels instead of {size}")));
    }
    Ok(ImageInfo { format: ImageFormat::Pfm, width, height, channels, bits: 32 })
}

/// A picture of Radiance (Ward, "Real Pixels", and `picture.5` of Radiance).
pub(super) fn hdr(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let mut lines = bytes[..bytes.len().min(HEADER)].split(|byte| *byte == b'\n');
    let place = || "in its header".to_owned();
    let mut format = false;
    for line in lines.by_ref() {
        if line.is_empty() {
            break;
        }
        if let Some(name) = line.strip_prefix(b"FORMAT=") {
            if name != b"32-bit_rle_rgbe" {
                return Err(ImageError::new("holds other colours than RGB", place()).help("save it as RGBE"));
            }
            format = true;
        }
    }
    let size = lines.next().and_then(|line| std::str::from_utf8(line).ok()).unwrap_or_default();
    let words: Vec<&str> = size.split_ascii_whitespace().collect();
    let ["-Y", height, "+X", width] = words[..] else {
        return Err(ImageError::new("has no size, or its rows do not run from top to bottom", place())
            .help("save it with the usual order of pixels, `-Y height +X width`"));
    };
    let (Ok(width), Ok(height)) = (width.parse(), height.parse()) else {
        return Err(ImageError::new("has no size", place()));
    };
    if !format {
        return Err(ImageError::new("does not say its format", place()));
    }
    if lines.next().is_none_or(<[u8]>::is_empty) {
        return Err(ImageError::cut("behind its header"));
    }
    Ok(ImageInfo { format: ImageFormat::Hdr, width, height, channels: 3, bits: 32 })
}
