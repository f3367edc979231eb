//! What can be wrong with an image.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why an image could not be read, written or changed.
#[derive(Debug)]
pub enum ImageError {
    /// The file system refused.
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: io::Error,
    },
    /// A folder, device or pipe stands where a file was expected.
    NotAFile {
        /// What stands there.
        path: PathBuf,
    },
    /// The bytes are no image that can be read.
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
        /// What may help.
        hint: &'static str,
    },
    /// The pixels cannot be stored in the format.
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why not.
        message: String,
    },
    /// The wanted size is not the old one divided by a whole number.
    Reduction {
        /// Width and height of the image.
        from: (usize, usize),
        /// Width and height that were asked for.
        to: (usize, usize),
    },
    /// Two images do not show the same window: its upper left pixel, and its width and height.
    Windows {
        /// Of the first.
        a: ((i64, i64), (usize, usize)),
        /// Of the second.
        b: ((i64, i64), (usize, usize)),
    },
    /// Two images are so far apart that what holds both is too large.
    Apart {
        /// Its width.
        width: u64,
        /// Its height.
        height: u64,
    },
}

impl ImageError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Io { source, .. } if source.kind() == io::ErrorKind::NotFound => {
                "check the name, or render the image first".to_owned()
            }
            Self::Io { .. } => "check the permissions and the free space of the folder".to_owned(),
            Self::NotAFile { .. } => "name the image file itself".to_owned(),
            Self::Damaged { hint, .. } => (*hint).to_owned(),
            Self::Unwritable { .. } => "give another name or a smaller image".to_owned(),
            Self::Reduction { from: (width, height), .. } => format!(
                "divide both sides by the same whole number, such as {}x{}",
                (width / 2).max(1),
                (height / 2).max(1)
            ),
            Self::Windows { .. } => "write both with one display window".to_owned(),
            Self::Apart { .. } => {
                "look at their data windows: one of them lies far outside of the display window".to_owned()
            }
        }
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, source } => write!(f, "cannot use `{}`: {source}", path.display()),
            Self::NotAFile { path } => write!(f, "`{}` is not a file", path.display()),
            Self::Damaged { path, message, .. } => {
                write!(f, "cannot read the image `{}`: {message}", path.display())
            }
            Self::Unwritable { path, message } => {
                write!(f, "cannot write the image `{}`: {message}", path.display())
            }
            Self::Reduction { from, to } => {
                write!(f, "an image of {}x{} pixels cannot be reduced to {}x{}", from.0, from.1, to.0, to.1)
            }
            Self::Windows { a: (at, a), b: (bt, b) } => write!(
                f,
                "the images show different windows: {}x{} pixels at ({}, {}), and {}x{} at ({}, {})",
                a.0, a.1, at.0, at.1, b.0, b.1, bt.0, bt.1
            ),
            Self::Apart { width, height } => write!(f, "the images lie apart: {width}x{height} pixels hold both"),
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { source, .. } => Some(source),
            Self::NotAFile { .. }
            | Self::Damaged { .. }
            | Self::Unwritable { .. }
            | Self::Reduction { .. }
            | Self::Windows { .. }
            | Self::Apart { .. } => None,
        }
    }
}
