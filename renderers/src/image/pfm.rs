//! Portable float maps: the plain format in which scripts hand images over.
//!
//! A header of three lines (`PF` or `Pf`, size, scale), then 32-bit floats from the bottom row
//! upwards. A negative scale means little endian; its size multiplies the values, as it does in
//! Mitsuba and in PBRT.

use std::io::Write;
use std::path::Path;

use super::attributes::DAMAGED;
use super::{Fault, Image, ImageError, MAX_SIDE};
use crate::cache::replace_file;

/// Writes the image as little-endian color; the file appears only when it is whole.
///
/// # Errors
/// Gives an error if the folder cannot be written to.
pub fn write_pfm(path: &Path, image: &Image) -> Result<(), ImageError> {
    let mut bytes = format!("PF\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in image.pixels.chunks(image.width.max(1)).rev() {
        bytes.extend(row.iter().flatten().flat_map(|value| value.to_le_bytes()));
    }
    replace_file(path, |file| file.write_all(&bytes)).map_err(|source| ImageError::Io { path: path.to_owned(), source })
}

/// Decodes a whole file.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, Fault> {
    let mut at = 0;
    let channels = match word(bytes, &mut at)? {
        "PF" => 3,
        "Pf" => 1,
        other => return Err(Fault::new(format!("`{other}` is no kind of PFM file"), DAMAGED)),
    };
    let width = side(word(bytes, &mut at)?)?;
    let height = side(word(bytes, &mut at)?)?;
    let scale: f32 = number(word(bytes, &mut at)?)?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(Fault::new(format!("its scale is {scale}"), DAMAGED));
    }
    let data = &bytes[at..];
    let expected = width * height * channels * 4;
    if data.len() != expected {
        return Err(Fault::new(format!("it should have {expected} bytes of pixels, but has {}", data.len()), DAMAGED));
    }
    let value = |field: &[u8]| {
        let field = [field[0], field[1], field[2], field[3]];
        let value = if scale < 0.0 { f32::from_le_bytes(field) } else { f32::from_be_bytes(field) };
        value * scale.abs()
    };
    let pixel = |field: &[u8]| match channels {
        1 => [value(field); 3],
        _ => [value(&field[..4]), value(&field[4..8]), value(&field[8..])],
    };
    let pixels = data
        .chunks_exact(width * channels * 4)
        .rev()
        .flat_map(|row| row.chunks_exact(channels * 4))
        .map(pixel)
        .collect();
    Ok(Image { width, height, pixels })
}

/// The next word of the header; the one white space behind it is taken too.
fn word<'a>(bytes: &'a [u8], at: &mut usize) -> Result<&'a str, Fault> {
    let rest = bytes.get(*at..).unwrap_or_default();
    let rest = &rest[rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count()..];
    let start = bytes.len() - rest.len();
    // No number in the header needs more; pixels may have no white space for long.
    let length = rest.iter().take(64).position(u8::is_ascii_whitespace);
    let length = length.ok_or_else(|| Fault::new("its header is not complete", DAMAGED))?;
    *at = start + length + 1;
    std::str::from_utf8(&rest[..length]).map_err(|_| Fault::new("its header is not text", DAMAGED))
}

fn number<T: std::str::FromStr>(word: &str) -> Result<T, Fault> {
    word.parse().map_err(|_| Fault::new(format!("`{word}` is no number"), DAMAGED))
}

fn side(word: &str) -> Result<usize, Fault> {
    match number(word)? {
        side @ 1..=MAX_SIDE => Ok(side),
        side => Err(Fault::new(format!("its header claims {side} pixels in a row"), DAMAGED)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::*;

    fn picture() -> Image {
        let pixels = (0..6).map(|i| [i as f32, 0.5, -1.0]).collect();
        Image { width: 2, height: 3, pixels }
    }

    fn message(bytes: &[u8]) -> String {
        decode(bytes).err().map(|fault| fault.message).expect("refused")
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image.pfm");
        write_pfm(&path, &picture()).expect("write");
        assert_eq!(read(&path).expect("read").0, picture());
        let bytes = std::fs::read(&path).expect("read");
        // The last row comes first.
        assert_eq!(bytes[..19], *b"PF\n2 3\n-1.0\n\0\0\x80\x40\0\0\0");
    }

    #[test]
    fn grey_big_endian_and_scale_are_understood() {
        let mut bytes = b"Pf 1\t2\n2.0\n".to_vec();
        bytes.extend([1.5_f32.to_be_bytes(), 4.0_f32.to_be_bytes()].concat());
        let image = decode(&bytes).map_err(|fault| fault.message).expect("an image");
        assert_eq!(image.pixels, [[8.0; 3], [3.0; 3]]);
    }

    #[test]
    fn every_cut_is_an_error() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("image.pfm");
        write_pfm(&path, &picture()).expect("write");
        let whole = std::fs::read(&path).expect("read");
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_err(), "{length} bytes");
        }
        assert!(message(&[&whole[..], b"\n"].concat()).contains("should have 72 bytes"));
    }

    #[test]
    fn strange_headers_are_refused() {
        assert!(message(b"PF\n99999999 1\n-1\n").contains("claims"));
        assert!(message(b"PF\n0 1\n-1\n").contains("claims"));
        assert!(message(b"PF\n65536 65536\n-1\n").contains("should have"));
        assert!(message(b"PF\n1 -1\n-1\n").contains("no number"));
        assert!(message(b"PF\n1 1\nnan\n0000").contains("scale"));
        assert!(message(b"PF\n1 1\n0\n0000").contains("scale"));
        assert!(message(b"PFX\n1 1\n-1\n").contains("no kind"));
    }
}
