//! Images of linear radiance: the type, reading by content, and reduction.

mod attributes;
mod error;
mod exr_plain;
mod exr_read;
mod exr_write;
mod pfm;
mod provenance;

use std::path::Path;

use crate::regular;

pub use error::ImageError;
pub use exr_plain::Rows;
pub use exr_write::{as_half, exr_bytes, half_bytes, layered_bytes, plain_bytes, write_exr};
pub use pfm::write_pfm;
pub use provenance::Provenance;

/// The largest file that is read: four channels of 32 bits in as many pixels as two images are filled up to.
const MOST_BYTES: u64 = 16 << 28;

/// The largest width and height that is read. Larger claims are taken for damage.
pub const MAX_SIDE: usize = 65_536;

/// String attributes of an image file, in the order of the file.
pub type Attributes = Vec<(String, String)>;

/// A picture of linear radiance in RGB (sRGB primaries), row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels, row by row, in W/(m^2 sr) where the scene uses such units. Values
    /// that are not finite or negative are kept as they were rendered.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// An image of one color.
    #[must_use]
    pub fn filled(width: usize, height: usize, color: [f32; 3]) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// The pixel in column `x` and row `y`, both of which must lie inside.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// How many pixels have a component that is infinite or not a number.
    #[must_use]
    pub fn non_finite(&self) -> usize {
        self.pixels.iter().filter(|pixel| !finite(pixel)).count()
    }
}

/// Whether all three components are finite.
#[must_use]
pub fn finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

/// Reads an OpenEXR or PFM file, told apart by their first bytes, with its string attributes (none
/// in PFM).
///
/// # Errors
/// Gives an error if the file cannot be read, is neither format, is damaged, or has no color.
pub fn read(path: &Path) -> Result<(Image, Attributes), ImageError> {
    read_placed(path).map(|(image, _, attributes)| (image, attributes))
}

/// The same as [`read`], with the picture in the channels of a prefix beside it, such as `error.`; none where the file has no such channels.
///
/// # Errors
/// As of [`read`], and where the two differ in size.
pub fn read_layered(path: &Path, prefix: &str) -> Result<(Image, Option<Image>, Attributes), ImageError> {
    let bytes = bytes_of(path)?;
    let whole = || -> Result<_, Fault> {
        let (image, _, attributes) = decode(&bytes)?;
        let layer = if bytes.starts_with(&attributes::MAGIC) { exr_read::layer(&bytes, prefix)? } else { None };
        if layer.as_ref().is_some_and(|layer| (layer.width, layer.height) != (image.width, image.height)) {
            let message = format!("its layer `{}` has another size than its picture", prefix.trim_end_matches('.'));
            return Err(Fault::new(message, "write both with one data window"));
        }
        Ok((image, layer, attributes))
    };
    whole().map_err(|fault| fault.at(path))
}

/// The names of the layers of an OpenEXR file that has several and no picture that is meant, which [`read`] refuses; nothing of other files.
///
/// # Errors
/// If the file cannot be read or is damaged.
pub fn layers(path: &Path) -> Result<Vec<String>, ImageError> {
    let bytes = bytes_of(path)?;
    if !bytes.starts_with(&attributes::MAGIC) {
        return Ok(Vec::new());
    }
    exr_read::layers(&bytes).map_err(|fault| fault.at(path))
}

/// A layer of an OpenEXR file by its name, as [`layers`] gives it.
///
/// # Errors
/// As of [`read`], and where there is no such layer.
pub fn read_layer(path: &Path, name: &str) -> Result<(Image, Attributes), ImageError> {
    let bytes = bytes_of(path)?;
    let whole = || -> Result<_, Fault> {
        let layer = exr_read::layer(&bytes, &format!("{name}."))?;
        let layer = layer.ok_or_else(|| Fault::new(format!("it has no layer `{name}`"), "name one that it has"))?;
        Ok((layer, exr_read::texts(&bytes)?))
    };
    whole().map_err(|fault| fault.at(path))
}

/// The string attributes of an OpenEXR file, without its pixels; none of a PFM file.
///
/// # Errors
/// If its beginning cannot be read or is damaged.
pub fn attributes(path: &Path) -> Result<Attributes, ImageError> {
    use std::io::Read;
    let fault = |source| ImageError::Io { path: path.to_owned(), source };
    let (mut file, _) = regular::open(path).map_err(fault)?;
    let mut bytes = Vec::new();
    // Nearly every header ends within the first part.
    for part in HEADERS {
        let before = bytes.len() as u64;
        (&mut file).take(part - before).read_to_end(&mut bytes).map_err(fault)?;
        if !bytes.starts_with(&attributes::MAGIC) {
            return Ok(Vec::new());
        }
        match exr_read::texts(&bytes) {
            Err(_) if bytes.len() as u64 == part && part < HEADERS[1] => {}
            done => return done.map_err(|fault| fault.at(path)),
        }
    }
    Ok(Vec::new())
}

/// The most bytes of a header that is read by itself, and of its first part.
const HEADERS: [u64; 2] = [1 << 14, 1 << 20];

/// The same as [`read`], and where its pixels lie.
///
/// # Errors
/// As of [`read`].
pub fn read_placed(path: &Path) -> Result<(Image, Window, Attributes), ImageError> {
    decode(&bytes_of(path)?).map_err(|fault| fault.at(path))
}

/// The whole file.
fn bytes_of(path: &Path) -> Result<Vec<u8>, ImageError> {
    regular::read(path, MOST_BYTES).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidInput => ImageError::NotAFile { path: path.to_owned() },
        _ => ImageError::Io { path: path.to_owned(), source: error },
    })
}

/// Where the pixels of a file lie: an OpenEXR file may have fewer or more of them than it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The upper left pixel.
    pub at: (i64, i64),
    /// The upper left pixel of what is shown, the display window.
    pub shown_at: (i64, i64),
    /// Width and height of what is shown.
    pub shown: (usize, usize),
}

impl Window {
    /// That of an image that is shown whole.
    fn whole(image: &Image) -> Self {
        Self { at: (0, 0), shown_at: (0, 0), shown: (image.width, image.height) }
    }

    fn is_whole(&self, image: &Image) -> bool {
        self.at == self.shown_at && self.shown == (image.width, image.height)
    }
}

/// The most pixels that two images are filled up to.
const MOST_PIXELS: u64 = 1 << 28;

/// Two images laid over each other: both over all pixels that one of them has, black where it has none. Images that are shown
/// whole are as they are.
///
/// # Errors
/// If they do not show the same window, or the pixels would be too many.
pub fn laid(a: (Image, Window), b: (Image, Window)) -> Result<(Image, Image), ImageError> {
    let ((a, at), (b, bt)) = (a, b);
    if at.is_whole(&a) && bt.is_whole(&b) {
        return Ok((a, b));
    }
    if (at.shown_at, at.shown) != (bt.shown_at, bt.shown) {
        return Err(ImageError::Windows { a: (at.shown_at, at.shown), b: (bt.shown_at, bt.shown) });
    }
    let end = |image: &Image, at: (i64, i64)| (at.0 + image.width as i64, at.1 + image.height as i64);
    let low = (at.at.0.min(bt.at.0), at.at.1.min(bt.at.1));
    let (ea, eb) = (end(&a, at.at), end(&b, bt.at));
    let high = (ea.0.max(eb.0), ea.1.max(eb.1));
    // Corners lie within 32 bits.
    let (width, height) = (high.0.abs_diff(low.0), high.1.abs_diff(low.1));
    if width.saturating_mul(height) > MOST_PIXELS {
        return Err(ImageError::Apart { width, height });
    }
    let over = |image: &Image, at: (i64, i64)| {
        let mut whole = Image::filled(width as usize, height as usize, [0.0; 3]);
        let start = (at.0.abs_diff(low.0) as usize, at.1.abs_diff(low.1) as usize);
        for (row, line) in image.pixels.chunks_exact(image.width).enumerate() {
            let first = (start.1 + row) * whole.width + start.0;
            whole.pixels[first..first + line.len()].copy_from_slice(line);
        }
        whole
    };
    Ok((over(&a, at.at), over(&b, bt.at)))
}

/// Averages blocks of pixels until the image is `width` by `height`; both sides must be divided by
/// one and the same whole number. Values that are not finite spread to their whole block.
///
/// # Errors
/// Gives an error if the sizes are not related so.
pub fn reduce(image: &Image, width: usize, height: usize) -> Result<Image, ImageError> {
    let fault = || ImageError::Reduction { from: (image.width, image.height), to: (width, height) };
    if width == 0 || height == 0 || !image.width.is_multiple_of(width) {
        return Err(fault());
    }
    let factor = image.width / width;
    if factor == 0 || Some(image.height) != height.checked_mul(factor) {
        return Err(fault());
    }
    let share = 1.0 / (factor * factor) as f64;
    let mut pixels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0_f64; 3];
            for row in y * factor..(y + 1) * factor {
                let start = row * image.width + x * factor;
                for pixel in &image.pixels[start..start + factor] {
                    for (total, value) in sum.iter_mut().zip(pixel) {
                        *total += f64::from(*value);
                    }
                }
            }
            pixels.push(sum.map(|total| (total * share) as f32));
        }
    }
    Ok(Image { width, height, pixels })
}

/// What is wrong with the bytes of a file: message and hint.
pub(crate) struct Fault {
    message: String,
    hint: &'static str,
}

impl Fault {
    fn new(message: impl Into<String>, hint: &'static str) -> Self {
        Self { message: message.into(), hint }
    }

    fn at(self, path: &Path) -> ImageError {
        ImageError::Damaged { path: path.to_owned(), message: self.message, hint: self.hint }
    }
}

fn decode(bytes: &[u8]) -> Result<exr_read::Decoded, Fault> {
    if bytes.starts_with(&attributes::MAGIC) {
        exr_read::decode(bytes)
    } else if bytes.starts_with(b"PF") || bytes.starts_with(b"Pf") {
        pfm::decode(bytes).map(|image| {
            let window = Window::whole(&image);
            (image, window, Attributes::new())
        })
    } else if bytes.is_empty() {
        Err(Fault::new("the file is empty", "was the program that wrote it interrupted?"))
    } else {
        Err(Fault::new(
            "this is neither an OpenEXR nor a PFM file",
            "only linear images can be read; PNG, JPEG and the like have lost the radiance",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduction_averages_square_blocks() {
        let mut image = Image::filled(4, 2, [1.0, 0.0, 2.0]);
        image.pixels[0] = [5.0, 4.0, 2.0];
        let small = reduce(&image, 2, 1).expect("4x2 to 2x1");
        assert_eq!(small.pixels, [[2.0, 1.0, 2.0], [1.0, 0.0, 2.0]]);
        assert_eq!(reduce(&image, 4, 2).expect("the same size"), image);
    }

    #[test]
    fn reduction_refuses_what_is_not_a_whole_factor() {
        let image = Image::filled(4, 4, [1.0; 3]);
        for (width, height) in [(3, 3), (2, 4), (4, 2), (8, 8), (0, 0), (2, 0)] {
            let error = reduce(&image, width, height).expect_err("no whole factor");
            assert!(error.hint().contains("whole number"), "{error}");
        }
    }

    #[test]
    fn images_are_laid_over_each_other_by_their_windows() {
        let shown = ((0, 0), (4, 3));
        let placed = |at| {
            let image = Image::filled(2, 1, [1.0; 3]);
            (image, Window { at, shown_at: shown.0, shown: shown.1 })
        };
        let red = |image: &Image| image.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<_>>();
        let (a, b) = laid(placed((0, 1)), placed((1, 1))).expect("the same window");
        assert_eq!((a.width, a.height, red(&a), red(&b)), (3, 1, vec![1.0, 1.0, 0.0], vec![0.0, 1.0, 1.0]));
        let (a, b) = laid(placed((-1, 0)), placed((-1, 0))).expect("the same window");
        assert_eq!((a.width, &a), (2, &b));
        // A picture that is shown whole is the same with black round it.
        let mut whole = Image::filled(4, 3, [0.0; 3]);
        whole.pixels[5] = [1.0; 3];
        whole.pixels[6] = [1.0; 3];
        let window = Window::whole(&whole);
        let (a, b) = laid((whole, window), placed((1, 1))).expect("the same window");
        assert_eq!(a, b);
        let other = Window { shown: (5, 3), ..window };
        let error = laid((Image::filled(2, 1, [1.0; 3]), other), placed((0, 0))).expect_err("another window");
        assert!(error.to_string().contains("5x3") && !error.hint().is_empty(), "{error}");
        let far = (i64::from(i32::MAX), i64::from(i32::MIN));
        assert!(matches!(laid(placed((0, 0)), placed(far)), Err(ImageError::Apart { .. })));
    }

    #[test]
    fn strange_files_are_refused_with_a_hint() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image");
        for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n", b"P", b"\x76\x2f\x31"] {
            std::fs::write(&path, bytes).expect("write");
            let error = read(&path).expect_err("not an image");
            assert!(!error.hint().is_empty());
        }
        assert!(matches!(read(folder.path()), Err(ImageError::NotAFile { .. })));
        let missing = read(&folder.path().join("missing")).expect_err("missing");
        assert!(missing.to_string().contains("missing"), "{missing}");
    }
}
