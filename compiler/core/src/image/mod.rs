//! Image files: read whole and checked, and made plain where renderers would read them differently. What comes out of
//! [`load`] means the same in every renderer: the numbers, made linear by [`crate::ir::Encoding`] and by nothing else.
//!
//! | file | what it means |
//! |---|---|
//! | OpenEXR | the display window, black where there are no data; primaries of its own are converted to linear sRGB |
//! | PNG, JPEG | the numbers as they are stored; gamma, primaries, color profile and orientation of the file say nothing |
//! | PFM, Radiance HDR | the numbers as they are stored |
//! | all | no alpha; no negative number; one that is not finite is an error |

mod color;
mod exr;
mod float;
mod jpeg;
mod pixels;
mod png;
pub mod sphere;
pub mod write;

pub use pixels::{Pixels, decoded};

use crate::ir::{ImageFile, ImageFormat, ImageInfo, Texture};
use write::Depth;

/// The longest side of an image in pixels; JPEG ends there.
pub const LONGEST_SIDE: u32 = 65_535;

/// Why a file is no image that renderers read alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageError {
    /// `invalid-image-file`, or `image-limit`.
    pub id: &'static str,
    /// What is wrong, to stand behind the path.
    pub message: String,
    /// Where in the file; empty for the whole.
    pub place: String,
    /// What to do.
    pub help: Option<&'static str>,
}

impl ImageError {
    fn new(message: impl Into<String>, place: impl Into<String>) -> Self {
        Self { id: "invalid-image-file", message: message.into(), place: place.into(), help: None }
    }

    fn cut(place: impl Into<String>) -> Self {
        Self::new("is cut off", place)
    }

    fn help(mut self, text: &'static str) -> Self {
        self.help = Some(text);
        self
    }
}

impl From<ImageError> for std::io::Error {
    fn from(error: ImageError) -> Self {
        let ImageError { id: _, message, place, help: _ } = error;
        Self::new(std::io::ErrorKind::InvalidData, format!("an image {message} ({place})"))
    }
}

/// What became of a part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// It is computed into the pixels.
    Baked,
    /// It is nearly kept.
    Approximated,
    /// It is left out.
    Dropped,
}

/// What is not read of a file and has nothing to do with colors: how its picture is turned, and that it has several.
const ORIENTATION: &str = "an orientation";
const FRAMES: &str = "several frames";

/// Something of a file that is not in its pixels as it stands there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// What became of it.
    pub loss: Loss,
    /// What it is, to stand behind the path.
    pub message: String,
    /// Whether it is what the file says of its colors (gamma, primaries, profile), which is not applied to them.
    pub of_color: bool,
}

impl Remark {
    fn new(loss: Loss, message: String) -> Self {
        Self { loss, message, of_color: false }
    }

    fn alpha() -> Self {
        let message = "has an alpha, which is left out: its colors are taken as they are stored";
        Self::new(Loss::Dropped, message.to_owned())
    }

    fn unread(what: &str) -> Self {
        let message = format!("has {what}, which is not applied: its numbers are taken as they are stored");
        let of_color = ![ORIENTATION, FRAMES].contains(&what);
        Self { of_color, ..Self::new(Loss::Dropped, message) }
    }
}

/// An image that means the same in every renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// Size and kind.
    pub info: ImageInfo,
    /// The bytes: those that were given where nothing had to be changed.
    pub file: ImageFile,
    /// The largest of its numbers.
    pub peak: f64,
    /// What was changed.
    pub remarks: Vec<Remark>,
}

/// Reads a file whose name ends in `ending` (without dot, in lower case) and that may have `most` pixels.
///
/// # Errors
/// What is malformed, is too large, or is a kind of image that has no meaning common to all renderers.
pub fn load(ending: &str, bytes: &[u8], most: u64) -> Result<Loaded, ImageError> {
    let Some(format) = sniff(bytes) else {
        return Err(ImageError::new("is no image that can be read", "at its start")
            .help("PNG, JPEG, OpenEXR, PFM and Radiance HDR files are read; convert it to one of them"));
    };
    let fits_name = ending == format.ending() || (format == ImageFormat::Jpeg && ending == "jpeg");
    if !fits_name {
        return Err(ImageError::new(format!("is {} by another name", format.words()), "its name and its start")
            .help("rename it: many renderers choose the reader by the ending"));
    }
    let same = || ImageFile::new(bytes);
    let (pixels, file, bits, mut remarks) = match format {
        ImageFormat::Png => {
            let [width, height] = png::size(bytes)?;
            fits(u64::from(width), u64::from(height), most)?;
            let png::Png { pixels, bits, plain, remarks } = png::load(bytes)?;
            let file = plain.map_or_else(|| write::png(&pixels, bits), Ok)?;
            (pixels, Some(ImageFile::new(&file)), bits, remarks)
        }
        ImageFormat::Jpeg => {
            let jpeg::Header { width, height, .. } = jpeg::header(bytes)?;
            fits(u64::from(width), u64::from(height), most)?;
            let (pixels, plain, remarks) = jpeg::load(bytes)?;
            (pixels, Some(ImageFile::new(&plain)), 8, remarks)
        }
        ImageFormat::Exr => {
            let exr::Exr { pixels, plain, full, remarks } = exr::load(bytes, most)?;
            (pixels, plain.then(same), if full { 32 } else { 16 }, remarks)
        }
        ImageFormat::Pfm => {
            let float::Pfm { width, height, .. } = float::pfm(bytes)?;
            fits(u64::from(width), u64::from(height), most)?;
            (float::pfm_pixels(bytes)?, Some(same()), 32, Vec::new())
        }
        ImageFormat::Hdr => {
            let float::Hdr { width, height, .. } = float::hdr(bytes)?;
            fits(u64::from(width), u64::from(height), most)?;
            let (pixels, plain, remarks) = float::hdr_load(bytes)?;
            (pixels, Some(ImageFile::new(&plain)), 32, remarks)
        }
    };
    let (pixels, changed) = sound(pixels, &mut remarks)?;
    let (file, bits) = match file.filter(|_| !changed) {
        Some(file) => (file, bits),
        None if format == ImageFormat::Pfm => (ImageFile::new(&write::pfm(&pixels)), 32),
        None => {
            let half = write::fits_half(&pixels);
            let depth = if half { Depth::Half } else { Depth::Full };
            (ImageFile::new(&write::exr(&pixels, depth)?), if half { 16 } else { 32 })
        }
    };
    let info = ImageInfo {
        format,
        width: pixels.width as u32,
        height: pixels.height as u32,
        channels: pixels.channels as u8,
        bits,
    };
    Ok(Loaded { info, file, peak: f64::from(pixels.peak()), remarks })
}

/// The pixels of a texture, made linear.
///
/// # Errors
/// If its file is not one that [`load`] made plain.
pub fn linear(texture: &Texture) -> Result<Pixels, ImageError> {
    Ok(stored(texture)?.linear(texture.encoding))
}

/// The pixels of a texture as its file has them.
///
/// # Errors
/// As of [`linear`].
pub fn stored(texture: &Texture) -> Result<Pixels, ImageError> {
    let Texture { name: _, file, image, encoding: _, peak: _, factor: _ } = texture;
    match image.format {
        ImageFormat::Png => Ok(png::load(file)?.pixels),
        ImageFormat::Jpeg => Ok(jpeg::load(file)?.0),
        ImageFormat::Exr => Ok(exr::load(file, u64::MAX)?.pixels),
        ImageFormat::Pfm => float::pfm_pixels(file),
        ImageFormat::Hdr => Ok(float::hdr_load(file)?.0),
    }
}

/// Refuses numbers that are not finite, and makes negative ones 0; says whether there were any.
fn sound(mut pixels: Pixels, remarks: &mut Vec<Remark>) -> Result<(Pixels, bool), ImageError> {
    if let Some(at) = pixels.values.iter().position(|value| !value.is_finite()) {
        let pixel = at / pixels.channels;
        let (x, y) = (pixel % pixels.width, pixel / pixels.width);
        let value = pixels.values[at];
        return Err(ImageError::new(
            format!("has the number {value} in column {x} of row {y}, counted from 0 at its upper left corner"),
            "within its pixels",
        )
        .help("mend the pixel: some renderers spread such a number over the image, some refuse the file"));
    }
    let mut count: u64 = 0;
    let mut least: f32 = 0.0;
    for value in pixels.values.iter_mut().filter(|value| **value < 0.0) {
        count += 1;
        least = least.min(*value);
        *value = 0.0;
    }
    if count > 0 {
        let words = match count {
            1 => format!("the negative number {least}, which becomes"),
            _ => format!("{count} negative numbers, down to {least}, which become"),
        };
        let message = format!("has {words} 0: light cannot be negative");
        remarks.push(Remark::new(Loss::Approximated, message));
    }
    Ok((pixels, count > 0))
}

/// Refuses sizes that are none, or more than may be.
fn fits(width: u64, height: u64, most: u64) -> Result<(), ImageError> {
    let longest = u64::from(LONGEST_SIDE);
    if width == 0 || height == 0 {
        return Err(ImageError::new("has no pixels", "in its header"));
    }
    if width.max(height) > longest {
        let message = format!("has {width} x {height} pixels, more than {longest} along a side");
        return Err(ImageError::new(message, "in its header"));
    }
    if width * height > most {
        let message = format!("has {width} x {height} pixels, {} of the {most} that an image may have", width * height);
        return Err(ImageError { id: "image-limit", ..ImageError::new(message, "in its header") });
    }
    Ok(())
}

/// Whether the data of Exif, from the mark of their byte order on, say that the picture is turned or mirrored.
fn turned(data: &[u8]) -> bool {
    const ORIENTATION: u16 = 0x0112;
    let little = data.starts_with(b"II");
    let two = |at: usize| -> Option<u16> {
        let pair = [*data.get(at)?, *data.get(at + 1)?];
        Some(if little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) })
    };
    let four = |at: usize| -> Option<usize> {
        let (a, b) = (usize::from(two(at)?), usize::from(two(at + 2)?));
        Some(if little { b << 16 | a } else { a << 16 | b })
    };
    let found = || {
        let start = four(4)?;
        let count = usize::from(two(start)?);
        let entry = (0..count).map(|index| start + 2 + 12 * index).find(|at| two(*at) == Some(ORIENTATION))?;
        two(entry + 8)
    };
    found().is_some_and(|orientation| orientation != 1)
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
}

#[cfg(test)]
mod tests;
