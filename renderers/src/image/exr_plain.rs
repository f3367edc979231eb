//! OpenEXR files whose rows lie in them as they are: `B`, `G` and `R` in single precision, not packed, row by row, as chunks are kept. Read
//! at the speed of memory; whatever looks otherwise is left to the decoder of all files, which also says what is wrong.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{LineOrder, SampleType};
use exr::meta::header::Header;
use exr::prelude::Compression;

use super::attributes::{MAGIC, scan};
use super::{HEADERS, Image, ImageError};
use crate::regular;

/// Below so many pixels threads cost more than they save.
const LARGE: usize = 1 << 20;

/// In front of a row: its number and its length.
const HEAD: usize = 8;

/// The picture of a file of that kind.
pub(super) fn decode(bytes: &[u8], meta: &MetaData) -> Option<Image> {
    let header = plain_header(meta)?;
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    let top = i64::from(header.own_attributes.layer_position.y());
    let (_, table) = scan(bytes).ok()?;
    let offsets = bytes.get(table..table.checked_add(height.checked_mul(8)?)?)?;
    let row = |at: usize| -> Option<&[u8]> {
        let offset = u64::from_le_bytes(offsets.get(8 * at..8 * at + 8)?.try_into().ok()?);
        let start = usize::try_from(offset).ok()?;
        let block = bytes.get(start..start.checked_add(HEAD + 12 * width)?)?;
        let number = |at: usize| block[at..at + 4].try_into().map(i32::from_le_bytes).ok();
        let fits = i64::from(number(0)?) - top == at as i64 && usize::try_from(number(4)?).ok()? == 12 * width;
        fits.then_some(&block[HEAD..])
    };
    // A header may claim more than any memory holds.
    let count =
        width.checked_mul(height).filter(|count| count.checked_mul(12).is_some_and(|size| size <= bytes.len()))?;
    let mut pixels = vec![[0.0_f32; 3]; count];
    let fill = |first: usize, part: &mut [[f32; 3]]| -> Option<()> {
        for (at, pixels) in part.chunks_exact_mut(width).enumerate() {
            unpack(row(first + at)?, pixels);
        }
        Some(())
    };
    let threads = if pixels.len() < LARGE { 1 } else { std::thread::available_parallelism().map_or(1, usize::from) };
    let rows = height.div_ceil(threads).max(1);
    let whole = std::thread::scope(|scope| {
        let parts = pixels.chunks_mut((rows * width).max(1)).enumerate();
        let fill = &fill;
        let running: Vec<_> = parts.map(|(at, part)| scope.spawn(move || fill(at * rows, part))).collect();
        running.into_iter().all(|thread| matches!(thread.join(), Ok(Some(()))))
    });
    whole.then_some(Image { width, height, pixels })
}

/// The rows of such a file, read one after the other without the rest of it.
pub struct Rows {
    file: File,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Where the first row begins, and its number.
    start: u64,
    top: i64,
    next: usize,
    bytes: Vec<u8>,
}

impl Rows {
    /// Opens a file; none where it is not of that kind, or its rows do not lie one after the other.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open(path: &Path) -> Result<Option<Self>, ImageError> {
        let fault = |source| ImageError::Io { path: path.to_owned(), source };
        let (mut file, size) = regular::open(path).map_err(fault)?;
        let mut bytes = Vec::new();
        (&mut file).take(HEADERS[0]).read_to_end(&mut bytes).map_err(fault)?;
        let known = || -> Option<(usize, usize, i64, usize)> {
            let (_, table) = bytes.starts_with(&MAGIC).then(|| scan(&bytes).ok())??;
            let meta = MetaData::read_from_buffered(std::io::Cursor::new(&bytes[..table]), false).ok()?;
            let header = plain_header(&meta)?;
            let top = i64::from(header.own_attributes.layer_position.y());
            Some((header.layer_size.width(), header.layer_size.height(), top, table))
        };
        let Some((width, height, top, table)) = known() else { return Ok(None) };
        // A header may claim more than there is.
        let step = width.checked_mul(12).map(|row| row as u64 + HEAD as u64);
        let start = table as u64 + 8 * height as u64;
        if step
            .and_then(|step| step.checked_mul(height as u64))
            .is_none_or(|pixels| pixels > size.saturating_sub(start))
        {
            return Ok(None);
        }
        let mut offsets = vec![0; 8 * height];
        file.seek(SeekFrom::Start(table as u64)).and_then(|_| file.read_exact(&mut offsets)).map_err(fault)?;
        let step = step.unwrap_or_default();
        let places = offsets.as_chunks::<8>().0.iter().map(|place| u64::from_le_bytes(*place));
        let expected = (0..height as u64).map(|row| start + row * step);
        Ok(places.eq(expected).then_some(Self { file, width, height, start, top, next: 0, bytes: Vec::new() }))
    }

    /// Goes to a row.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn seek(&mut self, row: usize) -> std::io::Result<()> {
        self.next = row;
        self.file.seek(SeekFrom::Start(self.start + (row * self.step()) as u64)).map(|_| ())
    }

    /// Reads the next rows, as many as `pixels` has.
    ///
    /// # Errors
    /// If the file ends, cannot be read, or has other rows there.
    pub fn read(&mut self, pixels: &mut [[f32; 3]]) -> std::io::Result<()> {
        let step = self.step();
        let rows = pixels.len() / self.width.max(1);
        self.bytes.resize(rows * step, 0);
        self.file.read_exact(&mut self.bytes)?;
        for (block, pixels) in self.bytes.chunks_exact(step).zip(pixels.chunks_exact_mut(self.width.max(1))) {
            let number = |at: usize| block[at..at + 4].try_into().map_or(-1, i32::from_le_bytes);
            if i64::from(number(0)) - self.top != self.next as i64 || number(4) as usize != step - HEAD {
                let message = format!("row {} is another one, or has another length", self.next);
                return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, message));
            }
            unpack(&block[HEAD..], pixels);
            self.next += 1;
        }
        Ok(())
    }

    fn step(&self) -> usize {
        HEAD + 12 * self.width
    }
}

/// A row of blue, green and red values, as pixels.
fn unpack(row: &[u8], pixels: &mut [[f32; 3]]) {
    let values = row.as_chunks::<4>().0;
    let (blue, rest) = values.split_at(pixels.len());
    let (green, red) = rest.split_at(pixels.len());
    for (pixel, ((red, green), blue)) in pixels.iter_mut().zip(red.iter().zip(green).zip(blue)) {
        *pixel = [red, green, blue].map(|value| f32::from_le_bytes(*value));
    }
}

fn plain_header(meta: &MetaData) -> Option<&Header> {
    let [header] = meta.headers.as_slice() else { return None };
    (!meta.requirements.has_multiple_layers && !header.deep && is_plain(header)).then_some(header)
}

fn is_plain(header: &Header) -> bool {
    let channels = &header.channels.list;
    let named = channels.len() == 3 && channels.iter().zip(["B", "G", "R"]).all(|(one, name)| one.name.eq(name));
    let single = |one: &exr::meta::attribute::ChannelDescription| {
        one.sample_type == SampleType::F32 && one.sampling.x() == 1 && one.sampling.y() == 1
    };
    named
        && channels.iter().all(single)
        && header.compression == Compression::Uncompressed
        && header.line_order == LineOrder::Increasing
        && matches!(header.blocks, exr::meta::BlockDescription::ScanLines)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use super::super::{Provenance, exr_bytes, exr_read, plain_bytes};
    use super::*;

    fn image(width: usize, height: usize) -> Image {
        let value = |at: usize| (at as f32).sin() * 10_f32.powi((at % 7) as i32 - 3);
        let pixel = |at: usize| [value(3 * at), value(3 * at + 1), value(3 * at + 2)];
        let mut image = Image { width, height, pixels: (0..width * height).map(pixel).collect() };
        image.pixels[0] = [f32::INFINITY, -0.0, f32::MIN_POSITIVE / 2.0];
        image
    }

    fn meta(bytes: &[u8]) -> MetaData {
        MetaData::read_from_buffered(Cursor::new(bytes), false).expect("a header")
    }

    #[test]
    fn what_is_not_packed_is_read_as_the_other_decoder_reads_it() {
        for (width, height) in [(1, 1), (7, 5), (64, 1), (1, 64), (33, 40), (1500, 900)] {
            let image = image(width, height);
            let provenance = Provenance { scene: "a scene".to_owned(), ..Provenance::default() };
            let bytes = plain_bytes(Path::new("a.exr"), &image, &provenance).expect("bytes");
            let found = decode(&bytes, &meta(&bytes)).expect("a plain file");
            assert!(found == image, "{width} x {height}");
            let names = ["R", "G", "B"].map(str::to_owned);
            assert!(exr_read::pixels(&bytes, &names).is_ok_and(|found| found == image));
            assert_eq!(
                exr_read::decode(&bytes).map(|(image, _, texts)| (image.width, texts.len() > 1)).ok(),
                Some((width, true))
            );
        }
    }

    #[test]
    fn rows_are_read_by_themselves() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let image = image(33, 40);
        let bytes = plain_bytes(&path, &image, &Provenance::default()).expect("bytes");
        std::fs::write(&path, &bytes).expect("written");
        let mut rows = Rows::open(&path).expect("read").expect("a plain file");
        assert_eq!((rows.width, rows.height), (33, 40));
        let mut pixels = vec![[0.0; 3]; 33 * 5];
        for from in [0, 5, 35] {
            rows.seek(from).expect("a row");
            rows.read(&mut pixels).expect("rows");
            assert!(pixels == image.pixels[33 * from..33 * (from + 5)], "from {from}");
        }
        assert!(rows.read(&mut pixels).is_err(), "behind the last");
        // A row that is another one, one that is missing, and rows in another place.
        let Ok((_, table)) = scan(&bytes) else { panic!("no header") };
        let opened = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            Rows::open(&path).expect("read")
        };
        let mut other = bytes.clone();
        other[table + 8 * 40] ^= 1;
        let mut rows = opened(&other).expect("a plain file");
        assert!(rows.seek(0).is_ok() && rows.read(&mut pixels).is_err());
        assert!(opened(&bytes[..bytes.len() - 1]).is_none());
        other[table] ^= 1;
        assert!(opened(&other).is_none());
        assert!(opened(b"").is_none() && Rows::open(&folder.path().join("none.exr")).is_err());
    }

    #[test]
    fn what_looks_otherwise_is_left_to_the_other_decoder() {
        let packed = exr_bytes(Path::new("a.exr"), &image(8, 8), &Provenance::default()).expect("bytes");
        assert!(decode(&packed, &meta(&packed)).is_none());
        let bytes = plain_bytes(Path::new("a.exr"), &image(8, 8), &Provenance::default()).expect("bytes");
        let header = meta(&bytes);
        assert!(decode(&bytes[..bytes.len() - 1], &header).is_none(), "cut off");
        let mut huge = header.clone();
        huge.headers[0].layer_size = exr::math::Vec2(1 << 58, 8);
        assert!(decode(&bytes, &huge).is_none(), "more than there is");
        // The number of a row, its length, and its place.
        let Ok((_, table)) = scan(&bytes) else { panic!("no header") };
        for at in [table, table + 64, table + 68] {
            let mut other = bytes.clone();
            other[at] ^= 0x5a;
            assert!(decode(&other, &header).is_none(), "byte {at}");
            assert!(exr_read::decode(&other).is_err() || at == table + 64, "byte {at}");
        }
    }
}
