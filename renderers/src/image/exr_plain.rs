//! OpenEXR files whose rows lie in them as they are: `B`, `G` and `R` in single precision, not packed, row by row, as chunks are kept. Read
//! at the speed of memory; whatever looks otherwise is left to the decoder of all files, which also says what is wrong.

use exr::meta::MetaData;
use exr::meta::attribute::{LineOrder, SampleType};
use exr::meta::header::Header;
use exr::prelude::Compression;

use super::Image;
use super::attributes::scan;

/// Below so many pixels threads cost more than they save.
const LARGE: usize = 1 << 20;

/// In front of a row: its number and its length.
const HEAD: usize = 8;

/// The picture of a file of that kind.
pub(super) fn decode(bytes: &[u8], meta: &MetaData) -> Option<Image> {
    let [header] = meta.headers.as_slice() else { return None };
    if meta.requirements.has_multiple_layers || header.deep || !is_plain(header) {
        return None;
    }
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
            let (blue, rest) = row(first + at)?.split_at(4 * width);
            let (green, red) = rest.split_at(4 * width);
            let values = red.as_chunks::<4>().0.iter().zip(green.as_chunks::<4>().0).zip(blue.as_chunks::<4>().0);
            for (pixel, ((red, green), blue)) in pixels.iter_mut().zip(values) {
                *pixel = [red, green, blue].map(|value| f32::from_le_bytes(*value));
            }
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
