//! Textures: image files that color surfaces.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use super::{Color, Handle};

/// An image laid over a surface by its texture coordinates.
///
/// `u` grows to the right in the image and `v` upwards: (0, 0) is its lower left corner, (1, 1) the upper right one. Beyond
/// them the image repeats. Between the middles of its pixels it is interpolated linearly.
///
/// Spelling: Mitsuba `bitmap`; PBRT `imagemap`; LuxCore `imagemap`; glTF `baseColorTexture`.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// As the author wrote it, else the name of the file without its ending; need not be a word, need not be unique.
    pub name: String,
    /// A file that means the same in every renderer: the reader of images made it so.
    pub file: ImageFile,
    /// What its header says.
    pub image: ImageInfo,
    /// How its numbers become linear.
    pub encoding: Encoding,
    /// The largest of its numbers once they are linear.
    pub peak: f64,
    /// By what its linear red, green and blue are multiplied, each from 0 to 1; 1 for an image of the environment, whose light has
    /// a tint. No more than 1, since glTF has no more.
    pub factor: [f64; 3],
}

impl Texture {
    /// Whether its numbers are multiplied by anything.
    pub fn is_scaled(&self) -> bool {
        self.factor != [1.0; 3]
    }

    /// No channel of it is larger.
    pub fn most(&self) -> f64 {
        self.peak * self.factor.into_iter().fold(0.0, f64::max)
    }
}

/// How the numbers of an image become linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Encoding {
    /// By the sRGB curve (IEC 61966-2-1); not for floats.
    Srgb,
    /// They are linear.
    Linear,
}

/// A format of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImageFormat {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// OpenEXR.
    Exr,
    /// Portable float map.
    Pfm,
    /// Radiance's picture with a shared exponent.
    Hdr,
}

impl ImageFormat {
    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
            Self::Exr => "exr",
            Self::Pfm => "pfm",
            Self::Hdr => "hdr",
        }
    }

    /// Whether it holds floats, which are linear.
    pub fn is_float(self) -> bool {
        match self {
            Self::Png | Self::Jpeg => false,
            Self::Exr | Self::Pfm | Self::Hdr => true,
        }
    }

    /// The name with its article.
    pub fn words(self) -> &'static str {
        match self {
            Self::Png => "a PNG file",
            Self::Jpeg => "a JPEG file",
            Self::Exr => "an OpenEXR file",
            Self::Pfm => "a PFM file",
            Self::Hdr => "a Radiance HDR file",
        }
    }
}

/// What the header of an image file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageInfo {
    /// The format.
    pub format: ImageFormat,
    /// Pixels, at least 1.
    pub width: u32,
    /// Pixels, at least 1.
    pub height: u32,
    /// 1 (grey), 2 (grey and alpha), 3 (color) or 4 (color and alpha). Alpha means nothing to a texture.
    pub channels: u8,
    /// Bits of each channel: 8, 16 or 32; fewer count as 8.
    pub bits: u8,
}

/// The bytes of an image file. Cheap to clone.
#[derive(Clone, PartialEq)]
pub struct ImageFile(Arc<[u8]>);

impl ImageFile {
    /// Holds a copy of `bytes`.
    pub fn new(bytes: &[u8]) -> Self {
        Self(bytes.into())
    }
}

impl Deref for ImageFile {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl fmt::Debug for ImageFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ImageFile({} bytes)", self.len())
    }
}

/// One color for a whole surface, or an image.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorOrTexture {
    /// The same everywhere.
    Color(Color),
    /// By the surface's texture coordinates.
    Texture(Handle<Texture>),
}

impl ColorOrTexture {
    /// The color that is the same everywhere; none for a texture.
    pub fn color(&self) -> Option<&Color> {
        match self {
            Self::Color(color) => Some(color),
            Self::Texture(_) => None,
        }
    }

    /// The texture; none for a color.
    pub fn texture(&self) -> Option<Handle<Texture>> {
        match self {
            Self::Color(_) => None,
            Self::Texture(texture) => Some(*texture),
        }
    }
}

impl From<Color> for ColorOrTexture {
    fn from(color: Color) -> Self {
        Self::Color(color)
    }
}
