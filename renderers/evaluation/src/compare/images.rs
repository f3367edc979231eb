//! Images of one renderer, in memory or on the disk.

use std::borrow::Cow;
use std::path::PathBuf;

use ltsc_render::image::{Image, read};

use super::CompareError;
use super::moments::Moments;

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
        let first = self.get(0)?;
        let mut moments = Moments::new(first.width, first.height);
        moments.add(&first)?;
        drop(first);
        for at in 1..self.count() {
            moments.add(&*self.get(at)?)?;
        }
        Ok(moments)
    }
}
