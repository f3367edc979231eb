//! Images of one renderer, in memory or on the disk.

use std::borrow::Cow;
use std::path::PathBuf;

use ltsc_render::image::{Image, read};

use super::CompareError;
use super::moments::Moments;

/// Images that are held at once while moments are gathered.
const AT_ONCE: usize = 4;

/// Images of one renderer, rendered independently of each other.
#[derive(Clone, Copy)]
pub enum Images<'i> {
    /// In memory.
    Held(&'i [Image]),
    /// In files, read one after the other whenever they are needed.
    Files(&'i [PathBuf]),
}

impl Images<'_> {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        match self {
            Self::Held(images) => images.len(),
            Self::Files(files) => files.len(),
        }
    }

    /// One of them.
    ///
    /// # Errors
    /// If its file cannot be read.
    pub fn get(&self, at: usize) -> Result<Cow<'_, Image>, CompareError> {
        match self {
            Self::Held(images) => Ok(Cow::Borrowed(&images[at])),
            Self::Files(files) => match read(&files[at]) {
                Ok((image, _)) => Ok(Cow::Owned(image)),
                Err(error) => Err(CompareError::Unreadable { message: error.to_string() }),
            },
        }
    }

    /// The moments of all of them.
    ///
    /// # Errors
    /// If there is none, one cannot be read, or their sizes differ.
    pub fn moments(&self) -> Result<Moments, CompareError> {
        if self.count() == 0 {
            return Err(CompareError::Empty);
        }
        let mut moments: Option<Moments> = None;
        let count = self.count();
        for from in (0..count).step_by(AT_ONCE) {
            let images: Vec<Cow<'_, Image>> =
                (from..(from + AT_ONCE).min(count)).map(|at| self.get(at)).collect::<Result<_, _>>()?;
            let moments = moments.get_or_insert_with(|| Moments::new(images[0].width, images[0].height));
            moments.add_all(&images.iter().map(Cow::as_ref).collect::<Vec<_>>())?;
        }
        moments.ok_or(CompareError::Empty)
    }
}
