//! Images of one renderer, in memory or on the disk.

use std::borrow::Cow;
use std::path::PathBuf;

use ltsc_render::image::{Image, Rows, read};
use rayon::prelude::*;

use super::CompareError;
use super::moments::{self, Moments};

/// Images that are added at once, and so many files are open in each thread.
const AT_ONCE: usize = 64;

/// The same of files that must be read whole, and as many are read meanwhile.
const WHOLE: usize = 2;

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
        match self {
            Self::Held(images) => {
                let mut moments = Moments::new(images[0].width, images[0].height);
                moments.add_all(&images.iter().collect::<Vec<_>>())?;
                Ok(moments)
            }
            Self::Files(files) => match plain(files)? {
                Some((width, height)) => {
                    let mut moments = Moments::new(width, height);
                    for files in files.chunks(AT_ONCE) {
                        moments.gather(files.len(), || Opened::new(files))?;
                    }
                    Ok(moments)
                }
                None => self.unpacked(),
            },
        }
    }

    /// The moments of files that must be read whole.
    fn unpacked(&self) -> Result<Moments, CompareError> {
        let count = self.count();
        let batch = |from: usize| -> Result<Vec<Cow<'_, Image>>, CompareError> {
            (from..(from + WHOLE).min(count)).into_par_iter().map(|at| self.get(at)).collect()
        };
        let mut images = batch(0)?;
        let mut moments = Moments::new(images[0].width, images[0].height);
        for from in (0..count).step_by(WHOLE) {
            // The next ones are read while these are added.
            let (added, next) = rayon::join(
                || moments.add_all(&images.iter().map(Cow::as_ref).collect::<Vec<_>>()),
                || batch(from + WHOLE),
            );
            added?;
            images = next?;
        }
        Ok(moments)
    }
}

/// The size of files all of whose rows can be read by themselves; none where some cannot.
fn plain(files: &[PathBuf]) -> Result<Option<(usize, usize)>, CompareError> {
    let size = |file: &PathBuf| match Rows::open(file) {
        Ok(rows) => Ok(rows.map(|rows| (rows.width, rows.height))),
        Err(error) => Err(CompareError::Unreadable { message: error.to_string() }),
    };
    let sizes = files.par_iter().map(size).collect::<Result<Option<Vec<_>>, _>>()?;
    let Some(a) = sizes.as_ref().and_then(|sizes| sizes.first().copied()) else { return Ok(None) };
    match sizes.into_iter().flatten().find(|b| *b != a) {
        Some(b) => Err(CompareError::Size { a, b }),
        None => Ok(Some(a)),
    }
}

/// Files whose rows are read.
struct Opened<'i> {
    files: &'i [PathBuf],
    rows: Vec<Rows>,
}

impl<'i> Opened<'i> {
    fn new(files: &'i [PathBuf]) -> Result<Self, CompareError> {
        let open = |file: &PathBuf| {
            let rows = Rows::open(file).map_err(|error| error.to_string());
            let changed = || format!("{} has changed while it was read", file.display());
            rows.and_then(|rows| rows.ok_or_else(changed)).map_err(|message| CompareError::Unreadable { message })
        };
        Ok(Self { files, rows: files.iter().map(open).collect::<Result<_, _>>()? })
    }
}

impl moments::Rows for Opened<'_> {
    fn rows<'p>(
        &'p mut self,
        at: usize,
        from: usize,
        pixels: &'p mut [[f32; 3]],
    ) -> Result<&'p [[f32; 3]], CompareError> {
        let rows = &mut self.rows[at];
        match rows.seek(from).and_then(|()| rows.read(pixels)) {
            Ok(()) => Ok(pixels),
            // The reader of whole files says what is wrong.
            Err(error) => {
                Images::Files(self.files).get(at)?;
                Err(CompareError::Unreadable { message: format!("{}: {error}", self.files[at].display()) })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use ltsc_render::image::{Provenance, exr_bytes, plain_bytes};

    use super::*;

    /// Images wide enough for pieces of few rows, of which the last is not whole; some pixels are not finite in one of them.
    fn images() -> Vec<Image> {
        let (width, height) = (1500, 133);
        let value = |at: usize| (at as f32).sin() + 1.5;
        let image = |seed: usize| {
            let pixel = |at: usize| [0, 7, 11].map(|c: usize| value(at * (seed + 3) + c));
            Image { width, height, pixels: (0..width * height).map(pixel).collect() }
        };
        let mut images: Vec<Image> = (0..5).map(image).collect();
        images[1].pixels[3000] = [f32::NAN, 1.0, 1.0];
        images[4].pixels[199_499] = [1.0, f32::INFINITY, 1.0];
        images
    }

    fn same(a: &Moments, b: &Moments) -> bool {
        let all = |moments: &Moments| {
            let bits =
                |image: &Image| -> Vec<[u32; 3]> { image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect() };
            (bits(&moments.mean_image()), bits(&moments.variance_image()), moments.tiles().to_vec())
        };
        all(a) == all(b)
    }

    #[test]
    fn files_have_the_moments_of_their_images() {
        let (folder, images) = (tempfile::tempdir().expect("a folder"), images());
        let held = Images::Held(&images).moments().expect("moments");
        assert_eq!(held.mean_image().non_finite(), 2);
        let mut one_by_one = Moments::new(1500, 133);
        images.iter().for_each(|image| one_by_one.add(image).expect("one size"));
        assert!(same(&held, &one_by_one));
        let path = |at: usize| folder.path().join(format!("{at}.exr"));
        let files: Vec<PathBuf> = (0..images.len()).map(path).collect();
        for (file, image) in files.iter().zip(&images) {
            fs::write(file, plain_bytes(file, image, &Provenance::default()).expect("bytes")).expect("written");
        }
        assert!(plain(&files).is_ok_and(|size| size == Some((1500, 133))));
        assert!(same(&held, &Images::Files(&files).moments().expect("moments")));
        // One that must be read whole among them.
        let packed = exr_bytes(&files[2], &images[2], &Provenance::default()).expect("bytes");
        fs::write(&files[2], packed).expect("written");
        assert!(plain(&files).is_ok_and(|size| size.is_none()));
        assert!(same(&held, &Images::Files(&files).moments().expect("moments")));
    }

    #[test]
    fn a_damaged_file_and_another_size_are_told() {
        let (folder, images) = (tempfile::tempdir().expect("a folder"), images());
        let files = [folder.path().join("a.exr"), folder.path().join("b.exr")];
        let other = Image::filled(20, 10, [1.0; 3]);
        let write = |at: usize, bytes: &[u8]| fs::write(&files[at], bytes).expect("written");
        let bytes = |image: &Image| plain_bytes(&files[0], image, &Provenance::default()).expect("bytes");
        write(0, &bytes(&images[0]));
        write(1, &bytes(&other));
        let told = || Images::Files(&files).moments().err().map(|error| error.to_string()).unwrap_or_default();
        assert!(told().contains("20") && told().contains("1500"), "{}", told());
        let mut damaged = bytes(&images[0]);
        // The number of a row, in the second band.
        let at = damaged.len() - 2 * (8 + 12 * 1500);
        damaged[at] ^= 0x40;
        write(1, &damaged);
        assert!(told().contains("b.exr"), "{}", told());
        damaged.truncate(at);
        write(1, &damaged);
        assert!(told().contains("b.exr"), "{}", told());
    }
}
