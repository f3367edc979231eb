//! Headers of image files: format, size, channels and depth, and whether the file is whole as far as its structure tells.
//! Pixels are for renderers to read.

mod exr;
mod float;
mod jpeg;
mod png;

use crate::ir::{ImageFormat, ImageInfo};

/// The longest side of an image in pixels; JPEG ends there.
pub const LONGEST_SIDE: u32 = 65_535;

/// Why a file is no image that renderers read alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageError {
    /// What is wrong, to stand behind the path.
    pub message: String,
    /// Where in the file; empty for the whole.
    pub place: String,
    /// What to do.
    pub help: Option<&'static str>,
}

impl ImageError {
    fn new(message: impl Into<String>, place: impl Into<String>) -> Self {
        Self { message: message.into(), place: place.into(), help: None }
    }

    fn cut(place: impl Into<String>) -> Self {
        Self::new("is cut off", place)
    }

    fn help(mut self, text: &'static str) -> Self {
        self.help = Some(text);
        self
    }
}

/// Reads the header of a file whose name ends in `ending` (without dot, in lower case).
///
/// # Errors
/// What is malformed, or is a kind of image that not every renderer reads alike.
pub fn read(ending: &str, bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let Some(format) = sniff(bytes) else {
        return Err(ImageError::new("is no image that can be read", "at its start")
            .help("PNG, JPEG, OpenEXR, PFM and Radiance HDR files are read; convert it to one of them"));
    };
    let fits = ending == format.ending() || (format == ImageFormat::Jpeg && ending == "jpeg");
    if !fits {
        return Err(ImageError::new(format!("is {} by another name", format.words()), "its name and its start")
            .help("rename it: many renderers choose the reader by the ending"));
    }
    let info = match format {
        ImageFormat::Png => png::read(bytes),
        ImageFormat::Jpeg => jpeg::read(bytes),
        ImageFormat::Exr => exr::read(bytes),
        ImageFormat::Pfm => float::pfm(bytes),
        ImageFormat::Hdr => float::hdr(bytes),
    }?;
    if info.width == 0 || info.height == 0 {
        return Err(ImageError::new("has no pixels", "in its header"));
    }
    if info.width.max(info.height) > LONGEST_SIDE {
        return Err(ImageError::new(
            format!("has {} x {} pixels, more than {LONGEST_SIDE} along a side", info.width, info.height),
            "in its header",
        ));
    }
    Ok(info)
}

fn sniff(bytes: &[u8]) -> Option<ImageFormat> {
    let starts: [(&[u8], ImageFormat); 7] = [
        (b"\x89PNG\r\n\x1a\n", ImageFormat::Png),
        (b"\xff\xd8\xff", ImageFormat::Jpeg),
        (b"\x76\x2f\x31\x01", ImageFormat::Exr),
        (b"PF", ImageFormat::Pfm),
        (b"Pf", ImageFormat::Pfm),
        (b"#?RADIANCE", ImageFormat::Hdr),
        (b"#?RGBE", ImageFormat::Hdr),
    ];
    starts.into_iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, format)| format)
}

/// Reads numbers out of bytes; every read says where it failed.
struct Cursor<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Cursor<'b> {
    fn new(bytes: &'b [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    fn take(&mut self, count: usize) -> Result<&'b [u8], ImageError> {
        let part = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end));
        let part = part.ok_or_else(|| ImageError::cut(format!("byte {}", self.at)))?;
        self.at += count;
        Ok(part)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], ImageError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn byte(&mut self) -> Result<u8, ImageError> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// The text up to a zero byte, at most `longest` bytes.
    fn text(&mut self, longest: usize) -> Result<&'b [u8], ImageError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().take(longest + 1).position(|byte| *byte == 0);
        let end = end.ok_or_else(|| ImageError::new("has a name without an end", format!("byte {}", self.at)))?;
        let text = self.take(end)?;
        self.at += 1;
        Ok(text)
    }
}

#[cfg(test)]
mod tests;
